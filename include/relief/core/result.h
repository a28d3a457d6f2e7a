#pragma once

#include <optional>
#include <string>
#include <utility>
#include <variant>

/// Errors as values. Bad data never throws across the interface; only std::bad_alloc passes
/// through.
namespace relief {

enum class ErrorCode {
    InvalidArgument,  ///< an option or parameter is wrong: the caller can correct the call
    BadInput,         ///< the data can not be used: empty, not finite, unsupported type
    BadFile,          ///< a file is not what it should be: truncated, altered, wrong format
    NotFound,         ///< a file does not exist or can not be read
    CannotWrite,      ///< an output can not be created or completed
    Unsupported,      ///< understood, but this build or version can not do it
    Cancelled,        ///< the caller asked to stop
};

/// What went wrong (`message`, which also says what to do) and where (`where`: a file, byte, row or
/// element).
struct Error {
    ErrorCode code = ErrorCode::BadInput;
    std::string message;
    std::string where;

    /// One line: "where: message".
    [[nodiscard]] std::string text() const {
        return where.empty() ? message : where + ": " + message;
    }
};

/// A value or the error that prevented it.
template <class T>
class [[nodiscard]] Result {
  public:
    Result(T value) : state_(std::in_place_index<0>, std::move(value)) {}      // NOLINT: implicit
    Result(Error error) : state_(std::in_place_index<1>, std::move(error)) {}  // NOLINT: implicit

    [[nodiscard]] bool ok() const { return state_.index() == 0; }
    explicit operator bool() const { return ok(); }

    T& value() & { return *std::get_if<0>(&state_); }
    const T& value() const& { return *std::get_if<0>(&state_); }
    T&& value() && { return std::move(*std::get_if<0>(&state_)); }
    T& operator*() & { return value(); }
    const T& operator*() const& { return value(); }
    T&& operator*() && { return std::move(*this).value(); }
    T* operator->() { return &value(); }
    const T* operator->() const { return &value(); }

    [[nodiscard]] const Error& error() const { return *std::get_if<1>(&state_); }

  private:
    std::variant<T, Error> state_;
};

/// Success or an error.
template <>
class [[nodiscard]] Result<void> {
  public:
    Result() = default;
    Result(Error error) : error_(std::move(error)) {}  // NOLINT: implicit

    [[nodiscard]] bool ok() const { return !error_; }
    explicit operator bool() const { return ok(); }
    [[nodiscard]] const Error& error() const { return *error_; }

  private:
    std::optional<Error> error_;
};

using Status = Result<void>;

}  // namespace relief

#define RELIEF_CONCAT_INNER(a, b) a##b
#define RELIEF_CONCAT(a, b) RELIEF_CONCAT_INNER(a, b)

/// Returns the error of `expression` from the enclosing function, if it has one.
#define RELIEF_CHECK(expression)                                                              \
    if (auto relief_status = (expression); !relief_status.ok()) return relief_status.error(); \
    static_assert(true)

// NOLINTBEGIN(bugprone-macro-parentheses): what is declared can not stand in parentheses.
/// `RELIEF_TRY(auto x, f());` declares x from the value of f(), or returns its error.
#define RELIEF_TRY(declaration, expression) \
    RELIEF_TRY_INNER(RELIEF_CONCAT(relief_result_, __LINE__), declaration, expression)
#define RELIEF_TRY_INNER(name, declaration, expression) \
    auto name = (expression);                           \
    if (!name.ok()) return name.error();                \
    declaration = *std::move(name)
// NOLINTEND(bugprone-macro-parentheses)
