#include "relief/mesh/topology.h"

#include <algorithm>
#include <string>

#include "mesh/twins.h"
#include "relief/mesh/near_order.h"

namespace relief::mesh {

namespace {

constexpr std::int64_t kMostElements = (std::int64_t{1} << 31) - 1;
/// Faces with more corners are checked for repeated ones by sorting.
constexpr std::size_t kManyCorners = 16;

Error bad_mesh(std::string message, const char* element, std::size_t number) {
    return Error{ErrorCode::BadInput, std::move(message),
                 std::string(element) + " " + std::to_string(number)};
}

bool repeats(std::span<const Index> corners) {
    if (corners.size() > kManyCorners) {
        Buffer<Index> sorted(corners.size());
        Index* const end = std::copy(corners.begin(), corners.end(), sorted.data());
        std::sort(sorted.data(), end);
        return std::adjacent_find(sorted.data(), end) != end;
    }
    for (std::size_t i = 1; i < corners.size(); ++i)
        for (std::size_t j = 0; j < i; ++j)
            if (corners[i] == corners[j]) return true;
    return false;
}

Status check_face(std::span<const Index> corners, std::size_t number, Index vertex_count) {
    if (corners.size() < 3)
        return bad_mesh("too_few_corners: it has " + std::to_string(corners.size()) +
                            " corners; faces have at least 3",
                        "face", number);
    for (const Index v : corners)
        if (v >= vertex_count)
            return bad_mesh("index_out_of_range: it names vertex " + std::to_string(v) + " of " +
                                std::to_string(vertex_count) + "; vertices count from 0",
                            "face", number);
    if (repeats(corners))
        return bad_mesh("repeated_corner: it names a vertex twice; remove it", "face", number);
    return {};
}

Status check_faces(std::span<const std::int64_t> offsets, std::span<const Index> corners,
                   Index vertex_count) {
    if (offsets.size() < 2)
        return Error{ErrorCode::BadInput, "empty_mesh: there is no face", "mesh"};
    const auto half_edges = static_cast<std::int64_t>(corners.size());
    if (half_edges > kMostElements || vertex_count > kMostElements)
        return Error{ErrorCode::BadInput,
                     "too_many_elements: a mesh has at most 2^31 - 1 vertices and corners of "
                     "faces; split it",
                     "mesh"};
    for (std::size_t f = 0; f + 1 < offsets.size(); ++f)
        if (offsets[f] < 0 || offsets[f + 1] < offsets[f] || offsets[f + 1] > half_edges)
            return bad_mesh("index_out_of_range: its corners are not there", "face", f);
    for (std::size_t f = 0; f + 1 < offsets.size(); ++f) {
        const auto begin = static_cast<std::size_t>(offsets[f]);
        const auto size = static_cast<std::size_t>(offsets[f + 1]) - begin;
        RELIEF_CHECK(check_face(corners.subspan(begin, size), f, vertex_count));
    }
    return {};
}

int common_size(std::span<const std::int64_t> offsets) {
    for (const int sides : {3, 4}) {
        bool all = true;
        for (std::size_t f = 0; f + 1 < offsets.size() && all; ++f)
            all = offsets[f + 1] - offsets[f] == sides;
        if (all) return sides;
    }
    return 0;
}

Error bad_edge(const Topology& mesh, Index h) {
    return bad_mesh("non_manifold_edge: the faces of its edge from vertex " +
                        std::to_string(mesh.origin[h]) + " to " + std::to_string(mesh.target(h)) +
                        " are more than two, oriented differently, or equal; 'encode --repair' "
                        "splits or turns them",
                    "face", mesh.face_of(h));
}

/// A half-edge at a vertex, the one without twin if there is one; and how many there are.
struct Fan {
    Index first = kNone;
    Index faces = 0;
};

/// The first vertex whose faces are none, or form more than one fan; kNone: all are good.
Index first_bad_fan(const Topology& mesh, const Buffer<Fan>& fans) {
    for (Index v = 0; v < mesh.vertex_count; ++v) {
        Index found = 0;
        const Index first = fans[v].first;
        if (first == kNone) return v;
        Index h = first;
        do {
            ++found;
            h = rotated(mesh, h);
        } while (h != kNone && h != first);
        if (found != fans[v].faces) return v;
    }
    return kNone;
}

/// What is wrong with a mesh that has edges of more than two faces, or vertices whose faces form
/// no fan.
Status explain(Topology& mesh) {
    const std::vector<Index> bad = find_twins(mesh);
    if (!bad.empty()) return bad_edge(mesh, *std::min_element(bad.begin(), bad.end()));
    Buffer<Fan> fans(mesh.vertex_count);
    std::fill_n(fans.data(), fans.size(), Fan());
    for (Index h = 0; h < mesh.half_edge_count(); ++h) {
        Fan& fan = fans[mesh.origin[h]];
        ++fan.faces;
        if (fan.first == kNone || mesh.on_boundary(h)) fan.first = h;
    }
    const Index v = first_bad_fan(mesh, fans);
    if (v == kNone) return {};
    if (fans[v].faces == 0)
        return bad_mesh("unused_vertex: no face names it; remove it", "vertex", v);
    return bad_mesh(
        "non_manifold_vertex: its faces form more than one fan; 'encode --repair' gives each fan a "
        "vertex of its own",
        "vertex", v);
}

}  // namespace

void set_faces(std::span<const std::int64_t> offsets, std::span<const Index> corners,
               Topology& mesh) {
    mesh.face_count = static_cast<Index>(offsets.size() - 1);
    mesh.sides = common_size(offsets);
    mesh.origin = Buffer<Index>(static_cast<std::size_t>(offsets.back() - offsets.front()));
    std::copy_n(corners.begin() + offsets.front(), mesh.origin.size(), mesh.origin.data());
    if (mesh.sides) return;
    mesh.first = Buffer<Index>(offsets.size());
    mesh.face = Buffer<Index>(mesh.origin.size());
    for (std::size_t f = 0; f < offsets.size(); ++f)
        mesh.first[f] = static_cast<Index>(offsets[f] - offsets.front());
    for (Index f = 0; f < mesh.face_count; ++f)
        std::fill(mesh.face.data() + mesh.first[f], mesh.face.data() + mesh.first[f + 1], f);
}

void number_edges(Topology& mesh) {
    mesh.edge = Buffer<Index>(mesh.twin.size());
    Index count = 0;
    for (Index h = 0; h < mesh.half_edge_count(); ++h)
        mesh.edge[h] = mesh.is_first(h) ? count++ : mesh.edge[mesh.twin[h]];
    mesh.edge_count = count;
}

Result<Topology> build(std::span<const std::int64_t> offsets, std::span<const Index> corners,
                       Index vertex_count) {
    RELIEF_CHECK(check_faces(offsets, corners, vertex_count));
    Topology mesh;
    mesh.vertex_count = vertex_count;
    set_faces(offsets, corners, mesh);
    if (link_corners(mesh) != vertex_count) RELIEF_CHECK(explain(mesh));
    number_edges(mesh);
    return mesh;
}

Result<Topology> build(const FaceList& faces, Index vertex_count) {
    return build(faces.offsets, faces.corners, vertex_count);
}

FaceList faces_of(const Topology& mesh) {
    FaceList faces;
    faces.corners.assign(mesh.origin.data(), mesh.origin.data() + mesh.origin.size());
    faces.offsets.resize(std::size_t{mesh.face_count} + 1);
    for (Index f = 0; f <= mesh.face_count; ++f) faces.offsets[f] = mesh.first_of(f);
    return faces;
}

Buffer<Index> outgoing(const Topology& mesh) {
    Buffer<Index> out(mesh.vertex_count);
    for (Index h = mesh.half_edge_count(); h-- > 0;) out[mesh.origin[h]] = h;
    for (Index h = 0; h < mesh.half_edge_count(); ++h)
        if (mesh.on_boundary(h)) out[mesh.origin[h]] = h;
    return out;
}

Buffer<Index> valences(const Topology& mesh) {
    Buffer<Index> count(mesh.vertex_count);
    std::fill_n(count.data(), count.size(), Index{0});
    for (Index h = 0; h < mesh.half_edge_count(); ++h) {
        ++count[mesh.origin[h]];
        if (mesh.on_boundary(h)) ++count[mesh.target(h)];
    }
    return count;
}

Components components(const Topology& mesh) {
    Components result;
    result.of_face.assign(mesh.face_count, kNone);
    std::vector<Index> open;
    for (Index seed = 0; seed < mesh.face_count; ++seed) {
        if (result.of_face[seed] != kNone) continue;
        result.of_face[seed] = result.count;
        open.push_back(seed);
        while (!open.empty()) {
            const Index f = open.back();
            open.pop_back();
            for (Index h = mesh.first_of(f); h < mesh.first_of(f + 1); ++h) {
                if (mesh.on_boundary(h)) continue;
                const Index g = mesh.face_of(mesh.twin[h]);
                if (result.of_face[g] != kNone) continue;
                result.of_face[g] = result.count;
                open.push_back(g);
            }
        }
        ++result.count;
    }
    return result;
}

std::int64_t euler_characteristic(const Topology& mesh) {
    return std::int64_t{mesh.vertex_count} - mesh.edge_count + mesh.face_count;
}

}  // namespace relief::mesh
