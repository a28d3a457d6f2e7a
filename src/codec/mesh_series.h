#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "codec/number_coder.h"
#include "relief/core/result.h"
#include "relief/core/stream.h"
#include "relief/mesh/index.h"

/// Series of numbers about the elements of a mesh. docs/format.md, "Series".
namespace relief::codec {

[[nodiscard]] inline Error damaged_chunk(const char* what) {
    return Error{ErrorCode::BadFile, "its numbers do not fit its bytes; the file is damaged",
                 std::string(what) + " chunk"};
}

/// Numbers that are expected to be as large as the last ones of their kind.
template <class Coder>
class Series {
  public:
    explicit Series(Coder& coder) : numbers_(coder, model_) {}

    std::int64_t code(std::int64_t q, std::uint32_t kind) {
        Surrounding& recent = recent_[kind];
        q = numbers_.code(q, kind, recent, last_);
        if (recent.count >= kSome) {
            recent.magnitude /= 2;
            recent.balance = 0;
            recent.count /= 2;
        }
        recent.add(q);
        last_ = {};
        last_.add(q);
        return q;
    }

    /// A number of which another is expected; differences wrap.
    std::int64_t code_near(std::int64_t value, std::int64_t expected, std::uint32_t kind) {
        const auto wrap = [](std::int64_t v) { return static_cast<std::uint64_t>(v); };
        const std::int64_t q = code(static_cast<std::int64_t>(wrap(value) - wrap(expected)), kind);
        return static_cast<std::int64_t>(wrap(expected) + wrap(q));
    }

  private:
    static constexpr std::uint32_t kSome = 8;

    NumberModel model_;
    NumberCoder<Coder> numbers_;
    std::array<Surrounding, NumberModel::kKinds> recent_;
    Surrounding last_;
};

/// Bytes of what code(series) codes.
template <class Code>
[[nodiscard]] Bytes encoded(Code code) {
    RangeEncoder encoder;
    Series<RangeEncoder> series(encoder);
    code(series);
    return encoder.finish();
}

/// The reverse. Errors: BadFile.
template <class Code>
[[nodiscard]] Status decoded(std::span<const std::uint8_t> bytes, const char* what, Code code) {
    RangeDecoder decoder(bytes);
    Series<RangeDecoder> series(decoder);
    code(series);
    if (decoder.at_end()) return {};
    return damaged_chunk(what);
}

/// Whether the numbers 0 .. n - 1 occur once each.
[[nodiscard]] inline bool is_permutation(const std::vector<mesh::Index>& order) {
    std::vector<std::uint8_t> seen(order.size(), 0);
    for (const mesh::Index number : order) {
        if (number >= seen.size() || seen[number]) return false;
        seen[number] = 1;
    }
    return true;
}

}  // namespace relief::codec
