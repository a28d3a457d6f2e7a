#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <span>
#include <vector>

#include "relief/codec/band_coder.h"
#include "relief/codec/container.h"
#include "relief/codec/mask_coder.h"

/// What the fuzzers run, and the tests on a small corpus. Each takes any bytes and must return;
/// what decodes must encode to something that decodes to the same.
namespace relief::codec::fuzz {

inline void require(bool condition) {
    if (!condition) std::abort();
}

/// The bytes as a file, and as a prefix of one.
inline void container(std::span<const std::uint8_t> bytes) {
    for (const std::uint64_t file_size :
         {std::uint64_t{bytes.size()}, std::uint64_t{bytes.size()} * 2}) {
        const Result<ContainerReader> reader = ContainerReader::open(bytes, file_size);
        if (!reader.ok()) continue;
        const std::size_t complete = reader.value().complete_chunks();
        for (std::size_t k = 0; k < reader.value().chunks().size(); ++k)
            require(!reader.value().chunk(k).ok() || k < complete);
        require(reader.value().complete_size() <= file_size ||
                complete < reader.value().chunks().size());
    }
}

/// Bands whose boxes come from the first bytes: a count, then five bytes for each box and its flag.
struct Level {
    std::vector<Grid<std::int32_t>> grids;
    std::vector<BandView> bands;

    static Level from(std::span<const std::uint8_t>& bytes) {
        Level level;
        const std::size_t count = bytes.empty() ? 0 : bytes[0] % 4;
        if (bytes.empty() || bytes.size() < 1 + 5 * count) return level;
        for (std::size_t k = 0; k < count; ++k) {
            const std::uint8_t* b = &bytes[1 + 5 * k];
            const LatticeBox box{static_cast<std::int8_t>(b[0]), static_cast<std::int8_t>(b[1]),
                                 b[2] % 80, b[3] % 80};
            level.grids.emplace_back(box.rows, box.cols, 0);
            level.bands.push_back({box, level.grids.back().view(), b[4] % 2 != 0});
        }
        bytes = bytes.subspan(1 + 5 * count);
        return level;
    }

    friend bool operator==(const Level& a, const Level& b) {
        for (std::size_t k = 0; k < a.grids.size(); ++k)
            for (std::int64_t r = 0; r < a.grids[k].rows(); ++r)
                for (std::int64_t c = 0; c < a.grids[k].cols(); ++c)
                    if (a.grids[k](r, c) != b.grids[k](r, c)) return false;
        return true;
    }
};

inline void bands(std::span<const std::uint8_t> bytes) {
    const std::span<const std::uint8_t> shape = bytes;
    Level level = Level::from(bytes);
    const Level parents = [&] {
        std::span<const std::uint8_t> again = shape;
        Level same = Level::from(again);
        for (Grid<std::int32_t>& grid : same.grids)
            for (std::int64_t r = 0; r < grid.rows(); ++r)
                for (std::int64_t c = 0; c < grid.cols(); ++c)
                    grid(r, c) = static_cast<std::int32_t>((r * c) % 3);
        return same;
    }();
    if (!decode_level(bytes, level.bands, parents.bands).ok()) return;
    const std::vector<std::uint8_t> coded = encode_level(level.bands, parents.bands);
    std::span<const std::uint8_t> again = shape;
    Level decoded = Level::from(again);
    require(decode_level(coded, decoded.bands, parents.bands).ok());
    require(decoded == level);
}

/// The first two bytes are the size.
inline void mask(std::span<const std::uint8_t> bytes) {
    if (bytes.size() < 2) return;
    Grid<std::uint8_t> image(bytes[0], bytes[1], 0);
    if (!decode_mask(bytes.subspan(2), image.view()).ok()) return;
    Grid<std::uint8_t> decoded(image.rows(), image.cols(), 0);
    require(decode_mask(encode_mask(image.view()), decoded.view()).ok());
    for (std::int64_t r = 0; r < image.rows(); ++r)
        for (std::int64_t c = 0; c < image.cols(); ++c) require(image(r, c) == decoded(r, c));
}

}  // namespace relief::codec::fuzz
