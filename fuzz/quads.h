#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <span>
#include <string>
#include <vector>

#include "codec/quad_header.h"
#include "containers.h"
#include "relief/codec/container.h"
#include "relief/codec/quad_codec.h"
#include "relief/mesh/quadrangulation.h"

/// What the fuzzers of files of quadrangulations run, and the tests on a small corpus.
namespace relief::codec::fuzz {

/// A grid of cols x rows quads, its inner vertices moved, refined some times; heights with `digits`
/// or none.
inline QuadMesh quad_grid(mesh::Index cols, mesh::Index rows, int levels, bool decimals) {
    std::vector<Vec2> places;
    std::vector<std::array<mesh::Index, 4>> quads;
    for (mesh::Index r = 0; r <= rows; ++r)
        for (mesh::Index c = 0; c <= cols; ++c) {
            const bool inside = r > 0 && r < rows && c > 0 && c < cols;
            const double shift = inside ? 0.1 * ((r * 7 + c * 3) % 4) - 0.15 : 0;
            places.push_back({c + shift, r - shift});
            const mesh::Index v = r * (cols + 1) + c;
            if (r < rows && c < cols) quads.push_back({v, v + 1, v + cols + 2, v + cols + 1});
        }
    auto plane = *mesh::build(places, quads);
    for (int m = 0; m < levels; ++m) plane = *mesh::refine(plane);
    QuadMesh mesh{{}, plane.quads};
    for (mesh::Index v = 0; v < plane.vertex_count(); ++v) {
        const Vec2 p = plane.origin + plane.vertex(v);
        const double z = 3 * std::sqrt(1 + p.x * p.x + 0.5 * p.y) + 0.2 * p.x * p.y;
        mesh.vertices.push_back({p.x, p.y, decimals ? std::rint(100 * z) / 100 : z});
    }
    return mesh;
}

/// Small files of every kind: values as decimals, steps, floats and doubles; coefficients; moves; a
/// numbering of its own.
inline const std::vector<Bytes>& valid_quad_files() {
    static const auto files = [] {
        using Kind = Goal::Kind;
        QuadMesh turned = quad_grid(2, 2, 1, true);
        std::reverse(turned.quads.begin(), turned.quads.end());
        QuadMesh floats = quad_grid(3, 2, 0, false);
        for (auto& vertex : floats.vertices) vertex[2] = static_cast<float>(vertex[2]);
        std::vector<Bytes> coded;
        const auto add = [&](const QuadMesh& mesh, Goal goal) {
            coded.push_back(encode_quads(mesh, {.goal = goal})->bytes);
        };
        add(quad_grid(2, 2, 2, true), {Kind::MaxError, 0.05});
        add(turned, {Kind::Lossless, 0});
        add(floats, {Kind::Lossless, 0});
        add(quad_grid(3, 3, 0, false), {Kind::Lossless, 0});
        add(quad_grid(2, 1, 2, false), {Kind::RmsError, 0.01});
        add(quad_grid(2, 2, 2, false), {Kind::Keep, 80});
        coded.push_back(*add_quad_moves(coded[0], {{0, 3, 0.5}, {1, 2, -1}}));
        return coded;
    }();
    return files;
}

/// All that can be asked of an opened file; what decodes is a mesh, and finite.
inline void explore(const QuadFile& file) {
    (void)file.chunks();
    (void)file.checksums_ok();
    (void)file.extent();
    for (int level = 0; level <= file.levels(); ++level) {
        (void)file.bound(level);
        (void)file.surface_bound(level);
        require(file.bytes_for(level) <= file.size());
        const auto mesh = file.decode(level);
        require(mesh.ok() || level < file.finest_level() ||
                mesh.error().code == ErrorCode::BadFile);
        if (!mesh.ok()) continue;
        require(mesh->vertices.size() == file.counts(level).vertices);
        for (const auto& vertex : mesh->vertices)
            for (const double x : vertex) require(std::isfinite(x));
        for (const auto& quad : mesh->quads)
            for (const mesh::Index v : quad) require(v < mesh->vertices.size());
    }
}

/// Sizes that are decoded quickly; larger ones are not the point.
inline bool is_small_quad_file(const ContainerReader& container) {
    const auto header = read_quad_header(container.header());
    return !header.ok() || ((header->quads + header->vertices) << 2 * header->levels) < (1 << 14);
}

/// The bytes as a file, as its beginning, and with a move added.
inline void quads(std::span<const std::uint8_t> bytes) {
    const auto source = std::make_shared<MemorySource>(Bytes(bytes.begin(), bytes.end()));
    const auto container = ContainerReader::open(source);
    if (container.ok() && !is_small_quad_file(*container)) return;
    if (const auto file = QuadFile::open(source); file.ok()) {
        explore(*file);
        const auto moved = add_quad_moves(Bytes(bytes.begin(), bytes.end()), {{0, 0, 1}});
        if (moved.ok()) {
            const auto again = QuadFile::open(*moved);
            require(again.ok() && again->moves().size() == file->moves().size() + 1);
        }
    } else if (const auto prefix = QuadFile::open(source, bytes.size() - 1); prefix.ok()) {
        explore(*prefix);
    }
}

/// The first byte chooses a valid file; the others are edits of its chunks.
inline void quad_chunks(std::span<const std::uint8_t> bytes) {
    if (bytes.empty()) return;
    const auto& files = valid_quad_files();
    const auto reader = *ContainerReader::open(files[bytes[0] % files.size()]);
    auto chunks = chunks_of(reader);
    edit_chunks(bytes.subspan(1), chunks);
    quads(rebuilt(reader, reader.header(), chunks));
}

/// The bytes as the header of each of the valid files; what is read is written the same again.
inline void quad_header(std::span<const std::uint8_t> bytes) {
    const std::string text(bytes.begin(), bytes.end());
    if (const auto header = read_quad_header(text); header.ok()) {
        const std::string once = write_quad_header(*header);
        const auto again = read_quad_header(once);
        require(again.ok() && write_quad_header(*again) == once);
    }
    for (const auto& file : valid_quad_files()) {
        const auto reader = *ContainerReader::open(file);
        quads(rebuilt(reader, text, chunks_of(reader)));
    }
}

}  // namespace relief::codec::fuzz
