#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <span>
#include <string>
#include <vector>

#include "codec/embedded_coder.h"
#include "codec/raster_header.h"
#include "containers.h"
#include "relief/codec/container.h"
#include "relief/codec/mask_coder.h"
#include "relief/codec/raster_codec.h"
#include "relief/codec/raster_surface.h"

/// What the fuzzers run, and the tests on a small corpus. Each takes any bytes and must return;
/// what decodes must encode to something that decodes to the same.
namespace relief::codec::fuzz {

/// The bytes as a file, and as a prefix of one.
inline void container(std::span<const std::uint8_t> bytes) {
    const auto source = std::make_shared<MemorySource>(Bytes(bytes.begin(), bytes.end()));
    for (const std::uint64_t visible : {bytes.size(), bytes.size() / 2}) {
        const Result<ContainerReader> reader = ContainerReader::open(source, visible);
        if (!reader.ok()) continue;
        const std::size_t complete = reader.value().complete_chunks();
        for (std::size_t k = 0; k < reader.value().chunks().size(); ++k)
            require(!reader.value().chunk(k).ok() || k < complete);
        require(reader.value().complete_size() <= visible ||
                complete < reader.value().chunks().size());
    }
}

/// Bands of one level whose boxes come from the first bytes: a count, then five bytes for each box
/// and its channel.
struct Level {
    std::vector<Grid<std::int32_t>> grids;
    std::vector<StreamBand> bands;

    static Level from(std::span<const std::uint8_t>& bytes) {
        Level level;
        const std::size_t count = bytes.empty() ? 0 : bytes[0] % 4;
        if (bytes.empty() || bytes.size() < 1 + 5 * count) return level;
        for (std::size_t k = 0; k < count; ++k) {
            const std::uint8_t* b = &bytes[1 + 5 * k];
            const LatticeBox box{static_cast<std::int8_t>(b[0]), static_cast<std::int8_t>(b[1]),
                                 b[2] % 80, b[3] % 80};
            level.grids.emplace_back(box.rows, box.cols, 0);
            level.bands.push_back({1, b[4] % 5, box, level.grids.back().view()});
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

/// Bands, numbers of planes and of passes, and the bytes of a stream.
inline void stream(std::span<const std::uint8_t> bytes) {
    const std::span<const std::uint8_t> shape = bytes;
    Level level = Level::from(bytes);
    if (bytes.size() < 2) return;
    const int planes = bytes[0] % 33;
    const int passes = bytes[1] % 97;
    bytes = bytes.subspan(2);
    std::vector<ParentBand> parents;
    const Grid<std::int32_t> above(9, 11, 5);
    for (int channel = 0; channel < 3; ++channel)
        parents.push_back({2, channel, {-1, -2, 9, 11}, above.view()});
    if (!decode_stream({bytes, planes, passes}, level.bands, parents).ok()) return;
    const auto coded = encode_stream(level.bands, parents);
    require(coded.ok() && coded->planes <= planes);
    std::span<const std::uint8_t> again = shape;
    Level decoded = Level::from(again);
    const StreamPart whole{coded->bytes, coded->planes, 3 * coded->planes};
    require(decode_stream(whole, decoded.bands, parents).ok());
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

/// Sizes that are decoded quickly; larger ones are not the point.
inline bool is_small(const ContainerReader& container) {
    const auto header = read_header(container.header());
    return !header.ok() || header->description.rows <= (1 << 20) / header->description.cols;
}

/// A window of a level is a part of the whole, unless the whole is damaged, and has a surface.
inline void explore_window(const RasterFile& file, int level, const Result<Raster>& whole) {
    const LatticeBox all = file.box(level);
    const LatticeBox part{all.rows / 3, all.cols / 4, all.rows / 2 + all.rows % 2,
                          all.cols / 2 + all.cols % 2};
    const auto window = file.decode_window(level, part);
    require(window.ok() || !whole.ok());
    if (!window.ok()) return;
    for (std::size_t p = 0; p < window->raster.planes.size(); ++p)
        for (std::int64_t r = 0; r < part.rows; ++r)
            for (std::int64_t c = 0; c < part.cols; ++c) {
                const double value = window->raster.planes[p](r, c);
                require(std::isfinite(value) == window->raster.valid(r, c));
                if (!whole.ok()) continue;
                require(window->raster.valid(r, c) == whole->valid(part.row0 + r, part.col0 + c));
                require(!window->raster.valid(r, c) ||
                        value == whole->planes[p](part.row0 + r, part.col0 + c));
            }
    const auto surface = RasterSurface::create(file, level, part);
    require(surface.ok() == window->damaged.empty());
    if (!surface.ok()) return;
    Grid<double> grid(3, 4);
    for (int p = 0; p < surface->components(); ++p)
        surface->evaluate_grid(p, static_cast<double>(part.row0), 0.3,
                               static_cast<double>(part.col0), 0.4, grid.view());
}

/// All that can be asked of an opened file; what decodes is whole and finite.
inline void explore(const RasterFile& file) {
    (void)file.bands();
    (void)file.chunks();
    (void)file.checksums_ok();
    (void)file.control_net();
    for (int level = 0; level <= file.layout().levels(); ++level) {
        (void)file.bound(level);
        (void)file.surface_bound(level);
        require(file.bytes_for(level) <= file.size());
        const auto raster = file.decode(level);
        // A window of an open-loop file is cut from its whole raster.
        if (file.closed_loop() || level == 0) explore_window(file, level, raster);
        if (!raster.ok()) continue;
        require(raster->rows == file.box(level).rows && raster->cols == file.box(level).cols);
        for (const Grid<double>& plane : raster->planes)
            for (std::int64_t r = 0; r < plane.rows(); ++r)
                for (std::int64_t c = 0; c < plane.cols(); ++c)
                    require(!raster->valid(r, c) || std::isfinite(plane(r, c)));
    }
}

/// The bytes as a raster file, as its beginning, and with a move added.
inline void raster(std::span<const std::uint8_t> bytes) {
    const auto source = std::make_shared<MemorySource>(Bytes(bytes.begin(), bytes.end()));
    const auto container = ContainerReader::open(source);
    if (container.ok() && !is_small(*container)) return;
    if (const auto file = RasterFile::open(source); file.ok()) {
        explore(*file);
        MemorySink moved;
        if (add_moves(source, {{.delta = {1}}}, moved).ok()) {
            const auto again = RasterFile::open(moved.take());
            require(again.ok() && again->moves().size() == file->moves().size() + 1);
        }
    } else if (const auto prefix = RasterFile::open(source, bytes.size() - 1); prefix.ok()) {
        explore(*prefix);
    }
}

/// Small files of every kind: masks, moves, corrections of integers and of floats, schemes, both
/// loops.
inline const std::vector<Bytes>& valid_rasters() {
    static const auto files = [] {
        const auto surface = [](SampleType type, bool holes) {
            Raster raster;
            raster.rows = 13;
            raster.cols = 18;
            raster.type = type;
            Grid<double> plane(13, 18);
            for (std::int64_t r = 0; r < 13; ++r)
                for (std::int64_t c = 0; c < 18; ++c)
                    plane(r, c) = static_cast<double>((r * r + 3 * c) % 47 + (r * c) % 5);
            raster.planes.push_back(std::move(plane));
            if (holes) {
                raster.mask = Grid<std::uint8_t>(13, 18, std::uint8_t{1});
                for (std::int64_t r = 2; r < 6; ++r) raster.mask(r, r + 1) = 0;
            }
            return raster;
        };
        using Kind = Goal::Kind;
        std::vector<Bytes> coded;
        const auto add = [&](const Raster& raster, multires::SchemeId scheme, Goal goal) {
            multires::SchemeSpec spec;
            spec.id = scheme;
            coded.push_back(encode_raster(raster, {.spec = spec, .goal = goal})->bytes);
        };
        add(surface(SampleType::Int16, true), multires::SchemeId::Box, {Kind::MaxError, 2});
        add(surface(SampleType::Float32, false), multires::SchemeId::Box, {Kind::Lossless, 0});
        add(surface(SampleType::Float64, true), multires::SchemeId::Barycentric, {Kind::Keep, 40});
        add(surface(SampleType::Int16, false), multires::SchemeId::Cubic, {Kind::RmsError, 1});
        for (const Profile profile : {Profile::Fast, Profile::Dense}) {
            Raster raster = surface(SampleType::Float32, profile == Profile::Dense);
            raster.planes[0](6, 9) = 7.25;  // repaired, as the others are whole
            for (const Goal goal : {Goal{Kind::MaxError, 0.2}, Goal{Kind::MaxError, 3}})
                coded.push_back(encode_raster(raster, {.goal = goal, .profile = profile})->bytes);
        }
        coded.push_back(*add_moves(coded[0], {{.level = 1, .row = 2, .col = 3, .delta = {5}}}));
        return coded;
    }();
    return files;
}

/// The first byte chooses a valid file; the others are edits of its chunks.
inline void raster_chunks(std::span<const std::uint8_t> bytes) {
    if (bytes.empty()) return;
    const auto& files = valid_rasters();
    const auto& file = files[bytes[0] % files.size()];
    const auto reader = *ContainerReader::open(file);
    auto chunks = chunks_of(reader);
    edit_chunks(bytes.subspan(1), chunks);
    raster(rebuilt(reader, reader.header(), chunks));
}

/// The bytes as a header: what is read is written the same again. And as that of a valid file.
inline void raster_header(std::span<const std::uint8_t> bytes) {
    const std::string text(bytes.begin(), bytes.end());
    if (const auto header = read_header(text); header.ok()) {
        const std::string once = write_header(*header);
        const auto again = read_header(once);
        require(again.ok() && write_header(*again) == once);
    }
    for (const auto& file : valid_rasters()) {
        const auto reader = *ContainerReader::open(file);
        raster(rebuilt(reader, text, chunks_of(reader)));
    }
}

}  // namespace relief::codec::fuzz
