#pragma once

#include <charconv>
#include <cmath>
#include <cstdint>
#include <deque>
#include <span>
#include <string>
#include <string_view>

#include "relief/core/result.h"

/// Line by line through text formats, with errors that name the line.
namespace relief::io::detail {

/// Words of one line, separated by blanks.
class Words {
  public:
    explicit Words(std::string_view line) : rest_(line) { skip_blanks(); }

    [[nodiscard]] bool empty() const { return rest_.empty(); }
    /// The next word; empty at the end.
    std::string_view next() {
        const std::string_view word = rest_.substr(0, rest_.find_first_of(kBlanks));
        rest_.remove_prefix(word.size());
        skip_blanks();
        return word;
    }
    /// All that is left, without blanks at its ends.
    [[nodiscard]] std::string_view rest() const {
        return rest_.substr(0, rest_.find_last_not_of(kBlanks) + 1);
    }

    static constexpr std::string_view kBlanks = " \t\r\v\f";

  private:
    void skip_blanks() {
        const std::size_t first = rest_.find_first_not_of(kBlanks);
        rest_.remove_prefix(first == std::string_view::npos ? rest_.size() : first);
    }
    std::string_view rest_;
};

/// Whether the whole word is a number, which is then in `value`; a leading + is allowed.
template <class Number>
bool parse_number(std::string_view word, Number& value) {
    if (word.size() > 1 && word[0] == '+' && word[1] != '-') word.remove_prefix(1);
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    return error == std::errc() && end == word.data() + word.size();
}

/// Where # begins a comment, which lasts to the end of the line: nowhere, anywhere, or (Obj) at the
/// beginning of a word. A backslash at the end of a line of Obj continues it on the next.
enum class Syntax { Plain, Off, Obj };

/// The lines that say something: without comments, not blank.
class Lines {
  public:
    Lines(std::string_view text, const std::string& name, Syntax syntax)
        : rest_(text), name_(name), syntax_(syntax) {}

    /// The next line; false at the end of the text.
    bool next(Words& words) {
        while (!rest_.empty()) {
            std::string_view line = take();
            if (syntax_ == Syntax::Obj && is_continued(line)) line = join(line);
            words = Words(line.substr(0, comment_at(line)));
            if (!words.empty()) return true;
        }
        return false;
    }

    [[nodiscard]] std::int64_t number() const { return number_; }
    [[nodiscard]] const std::string& name() const { return name_; }
    [[nodiscard]] std::size_t bytes_left() const { return rest_.size(); }
    /// An error of the line that was read last.
    [[nodiscard]] Error error(std::string message) const {
        return error_at(number_, std::move(message));
    }
    [[nodiscard]] Error error_at(std::int64_t line, std::string message) const {
        return {ErrorCode::BadInput, std::move(message), name_ + ", line " + std::to_string(line)};
    }

  private:
    /// The next line as it stands there.
    std::string_view take() {
        const std::string_view line = rest_.substr(0, rest_.find('\n'));
        rest_.remove_prefix(line.size() < rest_.size() ? line.size() + 1 : line.size());
        ++number_;
        return line;
    }

    static bool is_continued(std::string_view line) {
        return line.ends_with('\\') || line.ends_with("\\\r");
    }

    /// The line and those that continue it. Valid as long as this object.
    std::string_view join(std::string_view line) {
        std::string& whole = joined_.emplace_back();
        for (; is_continued(line); line = take())
            whole.append(line.substr(0, line.rfind('\\'))) += ' ';
        return whole.append(line);
    }

    [[nodiscard]] std::size_t comment_at(std::string_view line) const {
        if (syntax_ == Syntax::Plain) return line.size();
        std::size_t at = line.find('#');
        while (syntax_ == Syntax::Obj && at != std::string_view::npos && at > 0 &&
               Words::kBlanks.find(line[at - 1]) == std::string_view::npos)
            at = line.find('#', at + 1);
        return at;
    }

    std::string_view rest_;
    const std::string& name_;
    Syntax syntax_;
    std::deque<std::string> joined_;  ///< lines that were continued
    std::int64_t number_ = 0;
};

/// A word for messages: short, and printable.
inline std::string quoted(std::string_view word) {
    std::string text = "'" + std::string(word.substr(0, 40)) + "'";
    for (char& c : text)
        if (static_cast<unsigned char>(c) < 0x20) c = '?';
    return text;
}

/// Fills `numbers` with the next words. `element` is what they belong to, for messages. Errors: a
/// word is not a finite number.
inline Status read_numbers(Words& words, const Lines& lines, std::string_view element,
                           std::span<double> numbers) {
    for (double& number : numbers) {
        const std::string_view word = words.next();
        if (!parse_number(word, number))
            return lines.error("a " + std::string(element) + " needs " +
                               std::to_string(numbers.size()) + " numbers, not " + quoted(word));
        if (!std::isfinite(number))
            return lines.error(
                (element == "vertex" ? "non_finite_vertex: " : "non_finite_value: ") +
                quoted(word) + " is not a finite number; remove or repair it");
    }
    return {};
}

}  // namespace relief::io::detail
