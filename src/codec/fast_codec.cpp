#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "codec/fast_bits.h"
#include "codec/fast_rows.h"
#include "codec/fast_samples.h"
#include "codec/fast_tokens.h"
#include "codec/lattice_fill.h"
#include "codec/lattice_level.h"
#include "codec/rans.h"

/// The chunk of a level, empty if all its quotients are 0:
///
///     bits    what changes in the token model: TokenModel::adapt
///     2 bits  s: tokens are coded with 2^s states
///     5 bits  w, then w bits: how many words follow; then zeros up to a whole byte
///     words   of 16 bits, little-endian: the states, low word first, then what they shift in
///     bits    sign and offset of each token that is not 0; zeros up to a whole byte
///
/// Rows are coded in the order of SampleRows, each padded with samples of the silent class to a
/// multiple of 8; sample k of a row belongs to state k modulo 2^s.
namespace relief::codec::fast {

namespace {

constexpr std::int64_t kBatch = 8;
constexpr std::size_t kMostStates = 8;

std::int64_t padded(std::int64_t n) {
    return (n + kBatch - 1) / kBatch * kBatch;
}

/// The least magnitude of a token; how many raw bits tell the sign, which is the lowest, and what
/// is added to that magnitude.
struct TokenRange {
    std::int32_t first;
    int bits;
};

constexpr std::array<TokenRange, kTokens> kRanges = [] {
    std::array<TokenRange, kTokens> ranges{};
    std::int32_t first = 0;
    for (int t = 0; t < kTokens; ++t) {
        const int bits = t < kOwnTokens ? 0 : 1 + (t - kOwnTokens) / 2;
        ranges[static_cast<std::size_t>(t)] = {first, t == 0 ? 0 : bits + 1};
        first += 1 << bits;
    }
    ranges.back().bits = 31;
    return ranges;
}();

/// Of one row, padded.
struct RowBuffers {
    Buffer<std::int32_t> predictions;
    Buffer<std::int32_t> quotients;
    Buffer<std::int32_t> places;  ///< of the samples whose quotient is not 0
    Buffer<std::uint8_t> classes;
    Buffer<std::uint8_t> tokens;

    explicit RowBuffers(std::int64_t cols)
        : predictions(size(cols)),
          quotients(size(cols)),
          places(size(cols)),
          classes(size(cols)),
          tokens(size(cols)) {}

  private:
    static std::size_t size(std::int64_t cols) { return static_cast<std::size_t>(padded(cols)); }
};

void silence(const LatticeLevel& level, const SampleRow& row, std::uint8_t* classes) {
    std::fill(classes + row.n, classes + padded(row.n), kSilent);
    if (level.all_valid) return;
    const std::uint8_t* valid = level.valid.row(row.r) + row.col0;
    for (std::int64_t k = 0; k < row.n; ++k)
        if (!valid[2 * k]) classes[k] = kSilent;
}

/// What encoder and decoder share: code(row, buffers) makes the quotients of a row from its
/// predictions and classes.
template <class Code>
void code_level(LatticeLevel& level, const RowRule& rule, Code code) {
    RowBuffers buffers((level.cols() + 1) / 2);
    SampleRows(level, rule).for_each([&](const SampleRow& row) {
        std::int32_t* predictions = buffers.predictions.data();
        predict_row(row.neighbours, row.n, rule, predictions, buffers.classes.data());
        silence(level, row, buffers.classes.data());
        code(row, buffers);
        reconstruct_row(predictions, buffers.quotients.data(), row.n, rule, row.values,
                        row.quotients);
    });
}

/// Writes the places of the tokens that are not 0, and returns how many they are.
std::int64_t find_tokens(const std::uint8_t* tokens, std::int64_t n, std::int32_t* places) {
    std::int64_t count = 0;
    for (std::int64_t k = 0; k < n; k += kBatch) {
        std::uint64_t batch = 0;
        std::memcpy(&batch, tokens + k, sizeof batch);
        if (batch == 0) continue;
        for (std::int64_t s = k; s < k + kBatch; ++s) {
            places[count] = static_cast<std::int32_t>(s);
            count += tokens[s] != 0;
        }
    }
    return count;
}

class TokenDecoder {
  public:
    TokenDecoder(const TokenModel& model, std::size_t states, std::span<const std::uint8_t> words,
                 std::span<const std::uint8_t> rest)
        : tables_(kClasses + 1), states_(states), words_(words), rest_(rest) {
        for (std::size_t c = 0; c < kClasses; ++c) tables_[c].set(model.frequencies(c));
        tables_[kSilent].set({kRansTotal});
        for (std::size_t s = 0; s < states; ++s) {
            const std::uint32_t low = words_.next();
            state_[s] = low | std::uint32_t{words_.next()} << 16;
        }
    }

    void decode_row(const SampleRow& row, RowBuffers& buffers) {
        std::uint8_t* tokens = buffers.tokens.data();
        const std::int64_t n = padded(row.n);
        decode_tokens(buffers.classes.data(), n, tokens);
        const std::int64_t count = find_tokens(tokens, n, buffers.places.data());
        std::fill_n(buffers.quotients.data(), n, 0);
        decode_quotients(tokens, buffers.places.data(), count, buffers.quotients.data());
    }

    /// Requires: n is a multiple of kBatch.
    void decode_tokens(const std::uint8_t* classes, std::int64_t n, std::uint8_t* tokens) {
        switch (states_) {
            case 1:
                return decode_tokens_of<1>(classes, n, tokens);
            case 2:
                return decode_tokens_of<2>(classes, n, tokens);
            case 4:
                return decode_tokens_of<4>(classes, n, tokens);
            default:
                return decode_tokens_of<8>(classes, n, tokens);
        }
    }

    /// quotients[places[k]]: what the token there and its rest stand for.
    void decode_quotients(const std::uint8_t* tokens, const std::int32_t* places,
                          std::int64_t count, std::int32_t* quotients) {
        BitReader rest = rest_;
        for (std::int64_t k = 0; k < count; ++k) {
            const TokenRange range = kRanges[tokens[places[k]]];
            const std::uint32_t bits = rest.get(range.bits);
            const std::int32_t magnitude = range.first + static_cast<std::int32_t>(bits >> 1);
            quotients[places[k]] = bits & 1 ? -magnitude : magnitude;
        }
        rest_ = rest;
    }

    [[nodiscard]] bool at_end() const {
        return words_.at_end() && rest_.at_end() &&
               std::all_of(state_.data(), state_.data() + states_,
                           [](std::uint32_t state) { return state == kRansLow; });
    }

  private:
    template <std::size_t kStates>
    void decode_tokens_of(const std::uint8_t* classes, std::int64_t n, std::uint8_t* tokens) {
        std::array<std::uint32_t, kStates> state;
        std::copy_n(state_.begin(), kStates, state.begin());
        RansWords words = words_;
        for (std::int64_t k = 0; k < n; k += kBatch) {
            if (words.has(kBatch)) {
                decode_batch<kStates, false>(classes + k, state, words, tokens + k);
            } else {
                decode_batch<kStates, true>(classes + k, state, words, tokens + k);
            }
        }
        words_ = words;
        std::copy_n(state.begin(), kStates, state_.begin());
    }

    template <std::size_t kStates, bool kChecked>
    void decode_batch(const std::uint8_t* classes, std::array<std::uint32_t, kStates>& state,
                      RansWords& words, std::uint8_t* tokens) {
        for (std::size_t s = 0; s < kBatch; ++s) {
            tokens[s] = tables_[classes[s]].decode(state[s % kStates]);
            words.refill<kChecked>(state[s % kStates]);
        }
    }

    std::vector<RansTable<kTokens>> tables_;
    std::size_t states_;
    std::array<std::uint32_t, kMostStates> state_{};
    RansWords words_;
    BitReader rest_;
};

/// The symbols of a level, collected row by row, because rANS codes backwards.
class TokenCollector {
  public:
    explicit TokenCollector(const LatticeLevel& level) {
        const std::int64_t rows = level.rows() + level.rows() / 2;
        const auto most = static_cast<std::size_t>(rows * padded((level.cols() + 1) / 2));
        classes_ = Buffer<std::uint8_t>(most);
        tokens_ = Buffer<std::uint8_t>(most);
        quotients_ = Buffer<std::int32_t>(most);
    }

    void add_row(const SampleRow& row, RowBuffers& buffers) {
        const std::int64_t n = padded(row.n);
        std::uint8_t* tokens = buffers.tokens.data();
        std::fill(tokens + row.n, tokens + n, std::uint8_t{0});
        std::copy_n(buffers.classes.data(), n, classes_.data() + size_);
        std::copy_n(tokens, n, tokens_.data() + size_);
        size_ += static_cast<std::size_t>(n);
        const std::int64_t count = find_tokens(tokens, n, buffers.places.data());
        rest_.reserve(static_cast<std::size_t>(32 * count));
        for (std::int64_t k = 0; k < count; ++k) {
            const std::int32_t place = buffers.places[static_cast<std::size_t>(k)];
            const std::int32_t quotient = buffers.quotients[static_cast<std::size_t>(place)];
            put_rest(tokens[place], quotient);
            quotients_[nonzero_++] = quotient;
        }
    }

    [[nodiscard]] bool all_zero() const { return nonzero_ == 0; }

    /// Four tables in turn: adding twice in a row to one count would wait for the first sum.
    [[nodiscard]] ClassCounts counts() const {
        std::array<std::array<TokenCounts, kClasses + 1>, 4> parts{};
        for (std::size_t k = 0; k < size_; k += parts.size())
            for (std::size_t i = 0; i < parts.size(); ++i)
                ++parts[i][classes_[k + i]][tokens_[k + i]];
        ClassCounts sums{};
        for (const auto& part : parts)
            for (std::size_t c = 0; c < kClasses; ++c)
                for (std::size_t t = 0; t < kTokens; ++t) sums[c][t] += part[c][t];
        return sums;
    }

    /// The words, at the end of `room`.
    std::span<const std::uint16_t> encode(const TokenModel& model, std::size_t states,
                                          Buffer<std::uint16_t>& room) const {
        const auto symbols = symbols_of(model);
        room = Buffer<std::uint16_t>(size_ + 2 * states);
        std::uint16_t* const stop = room.data() + room.size();
        std::uint16_t* end = stop;
        switch (states) {
            case 1:
                end = encode_tokens<1>(symbols, stop);
                break;
            case 2:
                end = encode_tokens<2>(symbols, stop);
                break;
            case 4:
                end = encode_tokens<4>(symbols, stop);
                break;
            default:
                end = encode_tokens<8>(symbols, stop);
        }
        return {end, stop};
    }

    [[nodiscard]] std::span<const std::uint8_t> rest() const { return rest_.bytes(); }

    /// Whether a decoder that is told the same classes finds the same symbols.
    [[nodiscard]] bool decodes_from(TokenDecoder& decoder) const {
        constexpr std::size_t kPiece = 4096;
        Buffer<std::uint8_t> tokens(kPiece);
        Buffer<std::int32_t> places(kPiece);
        Buffer<std::int32_t> quotients(kPiece);
        const std::int32_t* expected = quotients_.data();
        for (std::size_t first = 0; first < size_; first += kPiece) {
            const auto n = static_cast<std::int64_t>(std::min(kPiece, size_ - first));
            decoder.decode_tokens(classes_.data() + first, n, tokens.data());
            if (!std::equal(tokens.data(), tokens.data() + n, tokens_.data() + first)) return false;
            const std::int64_t count = find_tokens(tokens.data(), n, places.data());
            decoder.decode_quotients(tokens.data(), places.data(), count, quotients.data());
            for (std::size_t k = 0; k < static_cast<std::size_t>(count); ++k)
                if (quotients[static_cast<std::size_t>(places[k])] != *expected++) return false;
        }
        return decoder.at_end();
    }

  private:
    using Symbols = std::array<std::array<RansSymbol, kTokens>, kClasses + 1>;

    static Symbols symbols_of(const TokenModel& model) {
        Symbols symbols;
        for (std::size_t c = 0; c < kClasses; ++c) {
            const TokenFrequencies frequencies = model.frequencies(c);
            std::uint32_t start = 0;
            for (std::size_t t = 0; t < kTokens; ++t) {
                if (frequencies[t] > 0) symbols[c][t] = RansSymbol(start, frequencies[t]);
                start += frequencies[t];
            }
        }
        symbols[kSilent][0] = RansSymbol(0, kRansTotal);
        return symbols;
    }

    /// Writes words downwards from `end`; returns where they begin.
    template <std::size_t kStates>
    std::uint16_t* encode_tokens(const Symbols& symbols, std::uint16_t* end) const {
        std::array<std::uint32_t, kStates> state;
        state.fill(kRansLow);
        for (std::size_t k = size_; k > 0; k -= kBatch) {
            const std::uint8_t* classes = classes_.data() + k - kBatch;
            const std::uint8_t* tokens = tokens_.data() + k - kBatch;
            for (std::size_t s = kBatch; s-- > 0;)
                end = symbols[classes[s]][tokens[s]].encode(state[s % kStates], end);
        }
        for (std::size_t s = kStates; s-- > 0;) {
            *--end = static_cast<std::uint16_t>(state[s] >> 16);
            *--end = static_cast<std::uint16_t>(state[s]);
        }
        return end;
    }

    void put_rest(std::uint8_t token, std::int32_t quotient) {
        const TokenRange range = kRanges[token];
        const auto offset = static_cast<std::uint32_t>(std::abs(quotient) - range.first);
        rest_.put(offset << 1 | (quotient < 0 ? 1U : 0U), range.bits);
    }

    Buffer<std::uint8_t> classes_;
    Buffer<std::uint8_t> tokens_;
    std::size_t size_ = 0;
    BitWriter rest_;
    Buffer<std::int32_t> quotients_;  ///< that are not 0
    std::size_t nonzero_ = 0;
};

/// Each state more costs about three bytes, which is to be one percent of the chunk.
int log_states_for(std::uint64_t bytes) {
    return std::min(static_cast<int>(std::bit_width(bytes / 400)), 3);
}

Error damaged(const LatticeLevel& level) {
    return {ErrorCode::BadFile, "the data of a level are damaged or cut off; fetch the file again",
            "level " + std::to_string(level.level)};
}

class FastCodec final : public LevelCodec {
  public:
    bool encode(LatticeLevel& level, GridView<const std::int32_t> source,
                std::vector<std::uint8_t>& out) override;
    Status decode(LatticeLevel& level, std::span<const std::uint8_t> bytes) override;
    std::unique_ptr<LevelCodec> descendant() const override {
        return std::make_unique<FastCodec>(*this);
    }

  private:
    /// A decoder of a chunk that is not empty; none: no encoder writes such a chunk.
    static std::optional<TokenDecoder> open(std::span<const std::uint8_t> bytes, TokenModel& model);

    TokenModel model_;
};

std::optional<TokenDecoder> FastCodec::open(std::span<const std::uint8_t> bytes,
                                            TokenModel& model) {
    BitReader head(bytes);
    if (!model.read(head)) return {};
    const std::size_t states = std::size_t{1} << head.get(2);
    const std::uint64_t count = head.get(static_cast<int>(head.get(5)));
    const auto body = head.rest();
    if (body.size() / 2 < count) return {};
    return TokenDecoder(model, states, body.first(2 * count), body.subspan(2 * count));
}

bool FastCodec::encode(LatticeLevel& level, GridView<const std::int32_t> source,
                       std::vector<std::uint8_t>& out) {
    const RowRule rule(level.lowest, level.highest, level.step);
    TokenCollector collector(level);
    Buffer<std::int32_t> sources(static_cast<std::size_t>(level.cols() + 1) / 2);
    code_level(level, rule, [&](const SampleRow& row, RowBuffers& buffers) {
        split_values(source.row(row.r) + row.col0, row.n, rule, sources.data());
        quantise_row(sources.data(), buffers.predictions.data(), buffers.classes.data(), row.n,
                     rule, buffers.quotients.data(), buffers.tokens.data());
        collector.add_row(row, buffers);
    });
    if (collector.all_zero()) return true;
    const ClassCounts counts = collector.counts();
    const std::size_t begin = out.size();
    TokenModel known = model_;
    BitWriter head;
    model_.adapt(counts, head);
    const auto rest = collector.rest();
    const int log_states = log_states_for(cost_of(counts, model_) / (8 * 256) + rest.size());
    Buffer<std::uint16_t> room;
    const auto words = collector.encode(model_, std::size_t{1} << log_states, room);
    const auto count = static_cast<std::uint32_t>(words.size());
    const int width = std::bit_width(count);
    head.put(static_cast<std::uint32_t>(log_states), 2);
    head.put(static_cast<std::uint32_t>(width), 5);
    head.put(count, width);
    out.insert(out.end(), head.bytes().begin(), head.bytes().end());
    std::size_t at = out.size();
    out.resize(at + 2 * words.size());
    for (const std::uint16_t word : words) {
        store(word, out.data() + at);
        at += 2;
    }
    out.insert(out.end(), rest.begin(), rest.end());
    auto decoder = open(std::span(out).subspan(begin), known);
    return decoder && known == model_ && collector.decodes_from(*decoder);
}

Status FastCodec::decode(LatticeLevel& level, std::span<const std::uint8_t> bytes) {
    if (bytes.empty()) {
        fill_level(level);
        return {};
    }
    const RowRule rule(level.lowest, level.highest, level.step);
    TokenModel model = model_;
    auto decoder = open(bytes, model);
    if (!decoder) return damaged(level);
    code_level(level, rule, [&](const SampleRow& row, RowBuffers& buffers) {
        decoder->decode_row(row, buffers);
    });
    if (!decoder->at_end()) return damaged(level);
    model_ = model;
    return {};
}

}  // namespace

}  // namespace relief::codec::fast

namespace relief::codec {

std::unique_ptr<LevelCodec> make_fast_codec() {
    return std::make_unique<fast::FastCodec>();
}

}  // namespace relief::codec
