#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>

#include "codec/tile_codec.h"
#include "decoders.h"

/// What the fuzzers run of the closed loop, below its files.
namespace relief::codec::fuzz {

/// Bytes in parts, the length of each in front of it in two bytes. Missing bytes are zeros.
class Parts {
  public:
    explicit Parts(std::span<const std::uint8_t> bytes) : bytes_(bytes) {}

    std::uint8_t byte() {
        if (bytes_.empty()) return 0;
        const std::uint8_t first = bytes_[0];
        bytes_ = bytes_.subspan(1);
        return first;
    }
    std::span<const std::uint8_t> part() {
        const std::size_t low = byte();
        const std::size_t claimed = low | static_cast<std::size_t>(byte()) << 8;
        const std::size_t length = std::min(claimed, bytes_.size());
        const auto taken = bytes_.first(length);
        bytes_ = bytes_.subspan(length);
        return taken;
    }
    std::span<const std::uint8_t> rest() const { return bytes_; }

  private:
    std::span<const std::uint8_t> bytes_;
};

/// The shape of a tile's levels, in eight bytes: profile and borders, rows, columns, number of
/// levels, step, bits of the largest sample, holes, seed.
struct LevelShape {
    Profile profile;
    Borders borders;
    std::int64_t rows, cols;
    int levels;
    std::int32_t step, highest;
    std::uint32_t holes;  ///< of 256 samples
    std::uint32_t seed;

    explicit LevelShape(Parts& in) {
        const std::uint8_t flags = in.byte();
        profile = flags & 1 ? Profile::Dense : Profile::Fast;
        borders = {(flags & 2) != 0, (flags & 4) != 0, (flags & 8) != 0, (flags & 16) != 0};
        rows = 1 + in.byte() % 40;
        cols = 1 + in.byte() % 40;
        levels = 1 + in.byte() % 3;
        const std::uint8_t steps = in.byte();
        step = steps < 128 ? 2 * (steps / 4) + 1 : (1 << (steps % 30)) | 1;
        highest = (1 << (in.byte() % 30)) - 1;
        holes = in.byte();
        seed = in.byte();
    }

    /// The same for the same place in all runs.
    [[nodiscard]] std::uint32_t noise(std::int64_t r, std::int64_t c) const {
        const auto place = static_cast<std::uint32_t>(r * 977 + c);
        const std::uint32_t mixed = (place + seed) * 2654435761U;
        return (mixed ^ mixed >> 15) * 2246822519U;
    }

    /// The level that decoding begins with, margins included.
    [[nodiscard]] LatticeLevel coarse() const {
        LatticeLevel level;
        level.level = levels;
        level.borders = borders;
        level.highest = highest;
        const std::int64_t r1 = level_size(rows, levels);
        const std::int64_t c1 = level_size(cols, levels);
        level.values = MarginGrid<std::int32_t>(r1, c1);
        level.quotients = MarginGrid<std::int16_t>(r1, c1);
        for (std::int64_t r = -3; r < r1 + 3; ++r)
            for (std::int64_t c = -3; c < c1 + 3; ++c)
                level.values(r, c) = static_cast<std::int32_t>(
                    noise(r, c) % (static_cast<std::uint32_t>(highest) + 1));
        return level;
    }

    [[nodiscard]] LatticeLevel below(LatticeLevel& above) const {
        const int number = above.level - 1;
        LatticeLevel level = refine(above, level_size(rows, number), level_size(cols, number));
        level.step = step;
        level.all_valid = holes == 0;
        for (std::int64_t r = 0; r < level.rows(); ++r)
            for (std::int64_t c = 0; c < level.cols(); ++c)
                level.valid(r, c) = noise(r << number, c << number) >> 24 >= holes;
        return level;
    }
};

inline bool same_samples(const LatticeLevel& a, const LatticeLevel& b) {
    for (std::int64_t r = 0; r < a.rows(); ++r)
        if (!std::equal(a.values.row(r), a.values.row(r) + a.cols(), b.values.row(r)) ||
            !std::equal(a.quotients.row(r), a.quotients.row(r) + a.cols(), b.quotients.row(r)))
            return false;
    return true;
}

/// What was decoded from a level, encoded by a codec in the state before, decodes to the same as
/// the encoder left.
inline void check_round_trip(const LatticeLevel& decoded, const LevelShape& shape,
                             LatticeLevel& above, const LevelCodec& before) {
    Grid<std::int32_t> source(decoded.rows(), decoded.cols());
    for (std::int64_t r = 0; r < source.rows(); ++r)
        for (std::int64_t c = 0; c < source.cols(); ++c)
            source(r, c) = std::clamp(decoded.values(r, c), decoded.lowest, decoded.highest);
    LatticeLevel meant = shape.below(above);
    Bytes coded;
    require(before.descendant()->encode(meant, source.view(), coded));
    LatticeLevel again = shape.below(above);
    require(before.descendant()->decode(again, coded).ok());
    require(same_samples(meant, again));
    for (std::int64_t r = 0; r < source.rows(); ++r)
        for (std::int64_t c = 0; c < source.cols(); ++c)
            require(!meant.valid(r, c) || (r % 2 == 0 && c % 2 == 0) ||
                    std::abs(meant.values(r, c) - source(r, c)) <= decoded.step / 2);
}

/// A shape, then the parts of its levels.
inline void lattice_level(std::span<const std::uint8_t> bytes) {
    Parts in(bytes);
    const LevelShape shape(in);
    auto codec = shape.profile == Profile::Dense ? make_dense_codec() : make_fast_codec();
    LatticeLevel level = shape.coarse();
    while (level.level > 0) {
        LatticeLevel next = shape.below(level);
        const auto before = codec->descendant();
        if (!codec->decode(next, in.part()).ok()) return;
        fill_edge_margins(next);
        for (std::int64_t r = 0; r < next.rows(); ++r)
            for (std::int64_t c = 0; c < next.cols(); ++c)
                require(next.values(r, c) >= -shape.highest - shape.step / 2 &&
                        next.values(r, c) <= 2 * std::int64_t{shape.highest} + shape.step / 2);
        check_round_trip(next, shape, level, *before);
        level = std::move(next);
    }
}

/// A tile of a raster of one tile: six bytes of what its header says, its mask in front of its
/// first chunk, all chunks as parts.
inline void tile(std::span<const std::uint8_t> bytes) {
    Parts in(bytes);
    const TileTree tree(1 + in.byte() % 64, 1 + in.byte() % 64);
    LatticeCoding coding;
    const std::uint8_t flags = in.byte();
    coding.profile = flags & 1 ? Profile::Dense : Profile::Fast;
    coding.tightening = flags & 2 ? 1.1 : 1;
    coding.type = static_cast<SampleType>(in.byte() % 7);
    IntegerDomain domain;
    domain.step = 2 * (in.byte() / 2) + 1;
    domain.highest = (1 << (in.byte() % 30)) - 1;
    coding.domains.assign(1 + (flags >> 2 & 1), domain);

    auto rest = in.part();
    const auto valid = read_tile_mask(tree.box(0, 0), rest);
    if (!valid.ok()) return;
    const TileCodec codec(coding, tree, 0, 0, *valid);
    TileState state = top_state(coding);
    for (const LevelRange& range : chunk_ranges(tree, 0)) {
        const bool good = codec.decode_chunk(range, rest, state).ok();
        rest = in.part();
        if (!good) break;
    }
    for (const LatticeRepair& repair : state.repairs) {
        require(repair.component < coding.domains.size() && std::isfinite(repair.value));
        require(repair.row >= 0 && repair.row < level_size(codec.box().rows, repair.level));
        require(repair.col >= 0 && repair.col < level_size(codec.box().cols, repair.level));
    }
    for (std::size_t c = 0; c < state.levels.size(); ++c)
        while (state.levels[c].level > 0)
            state.levels[c] = codec.interpolate(state.levels[c].level - 1, c, state.levels[c]);
}

}  // namespace relief::codec::fuzz
