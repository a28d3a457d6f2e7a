#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "codec/mesh_header.h"
#include "containers.h"
#include "relief/codec/mesh_codec.h"
#include "relief/multires/subdivide.h"

/// What the fuzzers of files of meshes run, and the tests on a small corpus.
namespace relief::codec::fuzz {

/// A tetrahedron, or two quads, subdivided.
inline PolygonMesh small_mesh(multires::MeshScheme scheme, int steps, bool open) {
    multires::SubdividedMesh<double> mesh;
    mesh::FaceList faces;
    std::vector<Vec3<double>> points{{0, 0, 0}, {1, 0, 0.2}, {0, 1, 0.1}, {0.3, 0.3, 1}};
    const bool quads = scheme == multires::MeshScheme::CatmullClark;
    if (quads) {
        points.push_back({2, 0.1, 0});
        points.push_back({2, 1, 0.5});
        faces.add(std::vector<mesh::Index>{0, 1, 3, 2});
        faces.add(std::vector<mesh::Index>{1, 4, 5, 3});
    } else {
        for (const auto& face : {std::vector<mesh::Index>{0, 2, 1}, {0, 1, 3}, {1, 2, 3}})
            faces.add(face);
        if (!open) faces.add(std::vector<mesh::Index>{2, 0, 3});
    }
    mesh.mesh = *mesh::build(faces, static_cast<mesh::Index>(points.size()));
    mesh.arrays.push_back(points);
    mesh = *multires::subdivide(std::move(mesh), {.scheme = scheme}, steps);
    PolygonMesh result;
    double bump = 0;
    for (const auto& p : mesh.arrays[0]) {
        bump = bump > 0.01 ? -0.01 : bump + 0.003;
        result.vertices.push_back({p.x, p.y, p.z + bump});
    }
    const mesh::FaceList fine = mesh::faces_of(mesh.mesh);
    result.offsets = fine.offsets;
    result.corners.assign(fine.corners.begin(), fine.corners.end());
    return result;
}

/// Small files of every kind: schemes, boundaries, lossless, attributes, labels, creases, moves,
/// and a numbering of its own.
inline const std::vector<Bytes>& valid_mesh_files() {
    static const auto files = [] {
        using Kind = Goal::Kind;
        using multires::MeshScheme;
        std::vector<Bytes> coded;
        const auto add = [&](const PolygonMesh& mesh, Goal goal) {
            coded.push_back(encode_mesh(mesh, {.goal = goal})->bytes);
        };
        add(small_mesh(MeshScheme::Loop, 2, false), {Kind::MaxError, 0.002});
        add(small_mesh(MeshScheme::Loop, 1, true), {Kind::Lossless, 0});
        add(small_mesh(MeshScheme::Sqrt3, 3, true), {Kind::RmsError, 0.002});
        add(small_mesh(MeshScheme::Sqrt3, 2, false), {Kind::Keep, 60});
        PolygonMesh rich = small_mesh(MeshScheme::CatmullClark, 2, true);
        MeshAttribute colour{"colour", 3, SampleType::UInt8, {}, {}};
        for (std::size_t k = 0; k < 3 * rich.vertices.size(); ++k)
            colour.values.push_back(static_cast<double>(k % 256));
        MeshAttribute uv{"uv", 2, SampleType::Float64, {0, 0, 1, 0.5}, {}};
        for (std::size_t c = 0; c < rich.corners.size(); ++c)
            uv.corners.push_back(static_cast<std::int32_t>(c % 2));
        rich.attributes = {colour, uv};
        rich.labels = {{"g", {"a", "b"}, {}}};
        for (std::int64_t f = 0; f < rich.polygon_count(); ++f)
            rich.labels[0].of_face.push_back(static_cast<std::int32_t>(f % 2));
        rich.creases = {{rich.corners[0], rich.corners[1], HUGE_VAL}};
        rich.sharp_vertices = {{2, 1.5}};
        add(rich, {Kind::MaxError, 0.01});
        PolygonMesh turned = small_mesh(MeshScheme::Loop, 1, false);
        std::reverse(turned.vertices.begin(), turned.vertices.end());
        for (auto& v : turned.corners)
            v = static_cast<std::int32_t>(turned.vertices.size()) - 1 - v;
        add(turned, {Kind::MaxError, 0.01});
        coded.push_back(*add_mesh_moves(coded[0], {{0, 3, {0.5, 0, 0}}, {2, 1, {0, -1, 0.2}}}));
        return coded;
    }();
    return files;
}

/// All that can be asked of an opened file; what decodes is a mesh, and finite.
inline void explore(const MeshFile& file) {
    (void)file.chunks();
    (void)file.checksums_ok();
    for (int level = 0; level <= file.levels(); ++level) {
        (void)file.bound(level);
        require(file.bytes_for(level) <= file.size());
        const auto mesh = file.decode(level);
        if (!mesh.ok()) continue;
        require(mesh->vertices.size() == file.counts(level).vertices);
        require(static_cast<std::uint64_t>(mesh->polygon_count()) == file.counts(level).faces);
        require(check(*mesh).ok());
    }
}

/// Sizes that are decoded quickly; larger ones are not the point.
inline bool is_small_mesh_file(const ContainerReader& container) {
    const auto header = read_mesh_header(container.header());
    return !header.ok() ||
           ((header->base_faces + header->base_vertices) << 2 * header->levels) < (1 << 14);
}

/// The bytes as a file, as its beginning, and with a move added.
inline void meshes(std::span<const std::uint8_t> bytes) {
    const auto source = std::make_shared<MemorySource>(Bytes(bytes.begin(), bytes.end()));
    const auto container = ContainerReader::open(source);
    if (container.ok() && !is_small_mesh_file(*container)) return;
    if (const auto file = MeshFile::open(source); file.ok()) {
        explore(*file);
        const auto moved = add_mesh_moves(Bytes(bytes.begin(), bytes.end()), {{0, 0, {1, 2, 3}}});
        if (moved.ok()) {
            const auto again = MeshFile::open(*moved);
            require(again.ok() && again->moves().size() == file->moves().size() + 1);
        }
    } else if (const auto prefix = MeshFile::open(source, bytes.size() - 1); prefix.ok()) {
        explore(*prefix);
    }
}

/// The first byte chooses a valid file; the others are edits of its chunks.
inline void mesh_chunks(std::span<const std::uint8_t> bytes) {
    if (bytes.empty()) return;
    const auto& files = valid_mesh_files();
    const auto reader = *ContainerReader::open(files[bytes[0] % files.size()]);
    auto chunks = chunks_of(reader);
    edit_chunks(bytes.subspan(1), chunks);
    meshes(rebuilt(reader, reader.header(), chunks));
}

/// The bytes as the header of each of the valid files; what is read is written the same again.
inline void mesh_header(std::span<const std::uint8_t> bytes) {
    const std::string text(bytes.begin(), bytes.end());
    if (const auto header = read_mesh_header(text); header.ok()) {
        const std::string once = write_mesh_header(*header);
        const auto again = read_mesh_header(once);
        require(again.ok() && write_mesh_header(*again) == once);
    }
    for (const auto& file : valid_mesh_files()) {
        const auto reader = *ContainerReader::open(file);
        meshes(rebuilt(reader, text, chunks_of(reader)));
    }
}

}  // namespace relief::codec::fuzz
