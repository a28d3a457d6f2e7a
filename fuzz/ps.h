#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "codec/ps_header.h"
#include "containers.h"
#include "relief/codec/container.h"
#include "relief/codec/ps_codec.h"
#include "relief/mesh/delaunay.h"

/// What the fuzzers of files of Powell-Sabin splines run, and the tests on a small corpus.
namespace relief::codec::fuzz {

/// Some scattered places, of decimals or not, in the order of their triangulation.
inline mesh::Triangulation scattered(int count, bool decimals) {
    std::vector<Vec2> places;
    for (int k = 0; k < count; ++k) {
        const double x = std::fmod(k * 0.6180339887, 1.0);
        const double y = std::fmod(k * 0.7548776662, 1.0);
        places.push_back(decimals ? Vec2{std::rint(1000 * x) / 10, std::rint(1000 * y) / 10}
                                  : Vec2{x, y});
    }
    return (*mesh::delaunay(places)).mesh;
}

/// Two triangles that meet in a vertex, beside a strip: not what Delaunay makes of the places.
inline mesh::Triangulation bow_tie_and_strip() {
    const std::vector<Vec2> places = {{0, 0}, {-1, 1},  {-1, -1}, {1, -1}, {1, 1},
                                      {3, 0}, {6, 0.1}, {3, 1},   {6, 1}};
    const std::vector<std::array<mesh::Index, 3>> triangles = {
        {0, 1, 2}, {0, 3, 4}, {6, 8, 7}, {5, 6, 7}};
    return *mesh::build(places, triangles);
}

inline double ps_height(Vec2 p) {
    return 3 * std::sqrt(1 + p.x * p.x + 0.5 * p.y * p.y) + 0.2 * p.x * p.y;
}

inline PsValues values_on(const mesh::Triangulation& mesh, int components, double unit) {
    PsValues values;
    for (int c = 0; c < components; ++c) {
        auto& component = values.components.emplace_back();
        for (mesh::Index v = 0; v < mesh.vertex_count(); ++v) {
            const double z = ps_height(mesh.origin + mesh.vertex(v)) + c;
            component.push_back(unit > 0 ? unit * std::rint(z / unit) : z);
        }
    }
    return values;
}

inline PsSplines splines_on(const mesh::Triangulation& mesh, int levels, int components) {
    namespace ps = multires::ps;
    const auto hierarchy = *ps::Hierarchy::create(*ps::make_space(mesh), levels);
    const ps::Space& space = hierarchy.space(levels);
    PsSplines splines{levels, {}};
    for (int c = 0; c < components; ++c) {
        auto& spline = splines.components.emplace_back();
        for (mesh::Index v = 0; v < space.mesh.vertex_count(); ++v) {
            const Vec2 p = space.mesh.origin + space.mesh.vertex(v);
            const double root = std::sqrt(1 + p.x * p.x + 0.5 * p.y * p.y);
            const Vec2 slope = {3 * p.x / root + 0.2 * p.y, 1.5 * p.y / root + 0.2 * p.x};
            spline.push_back(ps::heights(space.control[v], {ps_height(p) - c, slope}));
        }
    }
    return splines;
}

/// Small files of every kind: values and coefficients, with triangles that follow from the vertices
/// or not, decimals, steps and doubles, places
/// along lines, one and two components, levels, corrections, moves.
inline const std::vector<Bytes>& valid_ps_files() {
    static const auto files = [] {
        using Kind = Goal::Kind;
        std::vector<Bytes> coded;
        const auto add = [&](mesh::Triangulation mesh, auto surface, Goal goal, bool order = true) {
            const PsModel model{std::move(mesh), std::move(surface), {}};
            coded.push_back(encode_ps(model, {.goal = goal, .keep_order = order})->bytes);
        };
        const auto few = scattered(12, true);
        const auto doubles = scattered(20, false);
        const auto odd = bow_tie_and_strip();
        add(few, values_on(few, 1, 0.5), {Kind::Lossless, 0});
        add(doubles, values_on(doubles, 2, 0), {Kind::MaxError, 0.01});
        add(odd, values_on(odd, 1, 0), {Kind::Lossless, 0});
        add(odd, splines_on(odd, 1, 1), {Kind::RmsError, 0.01}, false);
        add(few, splines_on(few, 2, 1), {Kind::MaxError, 0.01});
        add(few, splines_on(few, 1, 2), {Kind::Lossless, 0});
        add(doubles, splines_on(doubles, 1, 1), {Kind::Keep, 50});
        std::vector<Vec2> lines;
        for (int k = 0; k < 60; ++k)
            lines.push_back({1.0 * (k % 20), 30.0 * (k / 20) + 0.5 * (k % 3)});
        const auto tracks = (*mesh::delaunay(lines)).mesh;
        add(tracks, values_on(tracks, 1, 0.1), {Kind::MaxError, 1});
        coded.push_back(*add_ps_moves(coded[4], {{0, 3, 0, 0.5, {}}, {2, 1, 0, -1, {1, 2}}}));
        return coded;
    }();
    return files;
}

/// All that can be asked of an opened file; what decodes is a surface, and finite.
inline void explore(const PsFile& file) {
    (void)file.chunks();
    (void)file.checksums_ok();
    (void)file.extent();
    (void)file.values();
    for (int level = 0; level <= file.levels(); ++level) {
        (void)file.bound(level);
        (void)file.surface_bound(level);
        require(file.bytes_for(level) <= file.size());
        const auto surface = file.surface(level);
        require(surface.ok() || surface.error().code == ErrorCode::BadFile);
        if (!surface.ok()) continue;
        require(surface->space.mesh.vertex_count() == file.counts(level).vertices);
        require(surface->space.mesh.triangle_count() == file.counts(level).triangles);
        require(static_cast<int>(surface->components.size()) == file.components());
        for (const auto& spline : surface->components)
            for (const auto& heights : spline)
                for (const double height : heights) require(std::isfinite(height));
    }
}

/// Sizes that are decoded quickly; larger ones are not the point.
inline bool is_small_ps_file(const ContainerReader& container) {
    const auto header = read_ps_header(container.header());
    if (!header.ok()) return true;
    double vertices = static_cast<double>(header->base.vertices + header->base.triangles);
    for (int m = 0; m < header->levels; ++m) vertices *= 9;
    return vertices < (1 << 14);
}

/// The bytes as a file, as its beginning, and with a move added.
inline void ps_files(std::span<const std::uint8_t> bytes) {
    const auto source = std::make_shared<MemorySource>(Bytes(bytes.begin(), bytes.end()));
    const auto container = ContainerReader::open(source);
    if (container.ok() && !is_small_ps_file(*container)) return;
    if (const auto file = PsFile::open(source); file.ok()) {
        explore(*file);
        const auto moved =
            add_ps_moves(Bytes(bytes.begin(), bytes.end()), {{0, 0, 0, 1, {0.5, 0}}});
        if (moved.ok()) {
            const auto again = PsFile::open(*moved);
            require(again.ok() && again->moves().size() == file->moves().size() + 1);
        }
    } else if (const auto prefix = PsFile::open(source, bytes.size() - 1); prefix.ok()) {
        explore(*prefix);
    }
}

/// The first byte chooses a valid file; the others are edits of its chunks.
inline void ps_chunks(std::span<const std::uint8_t> bytes) {
    if (bytes.empty()) return;
    const auto& files = valid_ps_files();
    const auto reader = *ContainerReader::open(files[bytes[0] % files.size()]);
    auto chunks = chunks_of(reader);
    edit_chunks(bytes.subspan(1), chunks);
    ps_files(rebuilt(reader, reader.header(), chunks));
}

/// The bytes as the header of each of the valid files; what is read is written the same again.
inline void ps_header(std::span<const std::uint8_t> bytes) {
    const std::string text(bytes.begin(), bytes.end());
    if (const auto header = read_ps_header(text); header.ok()) {
        const std::string once = write_ps_header(*header);
        const auto again = read_ps_header(once);
        require(again.ok() && write_ps_header(*again) == once);
    }
    for (const auto& file : valid_ps_files()) {
        const auto reader = *ContainerReader::open(file);
        ps_files(rebuilt(reader, text, chunks_of(reader)));
    }
}

}  // namespace relief::codec::fuzz
