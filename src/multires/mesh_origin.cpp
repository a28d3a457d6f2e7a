#include <algorithm>
#include <utility>

#include "multires/mesh_descent.h"
#include "relief/mesh/near_order.h"
#include "relief/mesh/walk.h"

namespace relief::multires {

namespace {

using mesh::Index;
using mesh::kNone;
using mesh::Split;
using mesh::Topology;
using mesh::Unsplit;
using Levels = std::vector<std::unique_ptr<FoundLevel>>;

/// A mesh in numbers in which neighbours are near each other: what is found in it is looked for in
/// the order of memory.
struct NearMesh {
    mesh::Renumbered numbers;
    std::vector<Vec3<double>> points;
    MeshTags tags;

    NearMesh(const Topology& mesh, std::span<const Vec3<double>> its_points,
             const MeshTags& its_tags)
        : numbers(mesh::near_order(mesh)) {
        for (std::size_t v = 0; v < numbers.vertices.size() && !its_points.empty(); ++v)
            points.push_back(its_points[numbers.vertices[v]]);
        for (std::size_t v = 0; v < numbers.vertices.size() && !its_tags.corner.empty(); ++v)
            tags.corner.push_back(its_tags.corner[numbers.vertices[v]]);
        if (its_tags.sharp.empty()) return;
        mesh::number_edges(numbers.mesh);
        tags.sharp.resize(mesh.edge_count);
        for (Index h = 0; h < mesh.half_edge_count(); ++h)
            tags.sharp[numbers.mesh.edge[h]] = its_tags.sharp[mesh.edge[numbers.half_edge(h)]];
    }
};

/// A mesh whose levels were found, and how another mesh numbers the same.
struct Searched {
    const Topology& mesh;
    Levels levels;
    const mesh::Renumbered* numbers = nullptr;  ///< none: its own

    [[nodiscard]] const Topology& finer(std::size_t k) const {
        return k == 0 ? mesh : levels[k - 1]->unsplit.mesh;
    }
    [[nodiscard]] const Topology& base() const { return levels.back()->unsplit.mesh; }
    [[nodiscard]] Index face(Index f) const { return numbers ? numbers->faces[f] : f; }
    /// Of a vertex of the mesh above `level`.
    [[nodiscard]] Index vertex(std::size_t level, Index v) const {
        while (level-- > 0) v = levels[level]->unsplit.old_vertices[v];
        return numbers ? numbers->vertices[v] : v;
    }
};

/// Where the faces of the finest level of the hierarchy over a base begin in the mesh. here:
/// half-edges of the base, as levels.back() has them.
Result<Buffer<Index>> climb(const Searched& searched, const Topology& base, Buffer<Index> here) {
    const Topology* canonical = &base;
    Topology finer;
    for (std::size_t k = searched.levels.size(); k-- > 0;) {
        const FoundLevel& level = *searched.levels[k];
        Buffer<Index> start(canonical->half_edge_count());
        for (Index h = 0; h < start.size(); ++h) start[h] = level.unsplit.fine[here[h]];
        here = mesh::fine_half_edges(*canonical, level.split, searched.finer(k), start);
        if (k == 0) break;
        RELIEF_TRY(Topology next, mesh::refine(*canonical, level.split));
        finer = std::move(next);
        canonical = &finer;
    }
    const auto sides = static_cast<Index>(searched.mesh.sides);
    Buffer<Index> corners(searched.mesh.face_count);
    for (Index f = 0; f < corners.size(); ++f) {
        const Index h = here[sides * f];
        corners[f] = searched.numbers ? searched.numbers->half_edge(h) : h;
    }
    return corners;
}

/// What tells the order of a base's faces and corners: numbers in the mesh of what they give, which
/// grow where the mesh was made by subdivision.
struct Keys {
    std::vector<Index> of_half_edge;
    std::vector<Index> of_face;  ///< sqrt(3): first; else empty
};

/// Loop, Catmull-Clark: the first face that each corner gives in the end.
Keys keys_of_corners(const Searched& searched) {
    Keys keys;
    const Levels& levels = searched.levels;
    const Buffer<Index>& starts = levels.back()->unsplit.fine;
    for (Index corner = 0; corner < starts.size(); ++corner) {
        Index h = starts[corner];
        for (std::size_t k = levels.size() - 1; k-- > 0;) h = levels[k]->unsplit.fine[h];
        keys.of_half_edge.push_back(searched.face(searched.mesh.face_of(h)));
    }
    return keys;
}

/// sqrt(3): the vertices that the first step puts into faces and the second one into what each
/// half-edge gives, or its face in the end.
Keys keys_of_edges(const Searched& searched) {
    // The vertex that level k puts into a face, the first of two, by its number in the mesh.
    const auto point = [&](std::size_t k, const Topology& coarse, Index f) {
        const FoundLevel& level = *searched.levels[k];
        const Index side = mesh::boundary_side(coarse, f);
        const bool trisected = level.split == Split::Sqrt3Even && side != kNone;
        const Topology& fine = searched.finer(k);
        const Index h = level.unsplit.fine[trisected ? side : 3 * f];
        return searched.vertex(k, fine.origin[trisected ? h : fine.prev(h)]);
    };
    const std::size_t last = searched.levels.size() - 1;
    const Topology& base = searched.base();
    const Topology& finer = searched.finer(last);
    Keys keys;
    for (Index f = 0; f < base.face_count; ++f) keys.of_face.push_back(point(last, base, f));
    const Buffer<Index>& starts = searched.levels[last]->unsplit.fine;
    for (Index h = 0; h < starts.size(); ++h) {
        const Index face = finer.face_of(starts[h]);
        keys.of_half_edge.push_back(last == 0 ? searched.face(face) : point(last - 1, finer, face));
    }
    return keys;
}

/// For each vertex of the base how many of them have smaller numbers in the mesh.
std::vector<Index> ranks(const Searched& searched) {
    const Index count = searched.base().vertex_count;
    std::vector<Index> at(searched.mesh.vertex_count, kNone);
    for (Index v = 0; v < count; ++v) at[searched.vertex(searched.levels.size(), v)] = v;
    std::vector<Index> result(count);
    Index rank = 0;
    for (const Index v : at)
        if (v != kNone) result[v] = rank++;
    return result;
}

/// The base with its faces in the order in which the mesh has what they give, each from the corner
/// that gives the first: a mesh that was made by subdivision gives back what it was made of.
/// sqrt(3) numbers fine faces by old edges, so that the order of faces comes from their points; a
/// face begins with the first edge that none before it has, or with its first vertex. Vertices are
/// in the order of the mesh.
struct Arranged {
    Topology base;
    MeshTags tags;
    Buffer<Index> half_edges;  ///< as the base was before
};

/// The half-edge that a face begins with, and what it is sorted by.
struct FaceStart {
    Index key;
    Index first;
};

std::vector<FaceStart> face_starts(const Topology& base, const Keys& keys,
                                   const std::vector<Index>& rank) {
    std::vector<FaceStart> starts(base.face_count);
    for (Index f = 0; f < base.face_count; ++f) {
        Index least = kNone;
        Index first = base.first_of(f);
        for (Index h = base.first_of(f); h < base.first_of(f + 1); ++h)
            if (rank[base.origin[h]] < rank[base.origin[first]]) first = h;
        for (Index h = base.first_of(f); h < base.first_of(f + 1); ++h) {
            const Index twin = base.twin[h];
            if (!keys.of_face.empty() && twin != kNone &&
                keys.of_face[base.face_of(twin)] < keys.of_face[f])
                continue;
            if (keys.of_half_edge[h] >= least) continue;
            least = keys.of_half_edge[h];
            first = h;
        }
        starts[f] = {keys.of_face.empty() ? least : keys.of_face[f], first};
    }
    std::sort(starts.begin(), starts.end(),
              [](const FaceStart& a, const FaceStart& b) { return a.key < b.key; });
    return starts;
}

Result<Arranged> arranged(const Searched& searched, const Keys& keys) {
    const Topology& base = searched.base();
    const MeshTags& tags = searched.levels.back()->tags;
    const std::vector<Index> rank = ranks(searched);
    mesh::FaceList faces;
    Arranged result;
    result.half_edges = Buffer<Index>(base.half_edge_count());
    Index count = 0;
    for (const FaceStart& face : face_starts(base, keys, rank)) {
        Index h = face.first;
        do {
            faces.corners.push_back(rank[base.origin[h]]);
            result.half_edges[count++] = h;
            h = base.next(h);
        } while (h != face.first);
        faces.offsets.push_back(count);
    }
    RELIEF_TRY(result.base, mesh::build(faces, base.vertex_count));
    result.tags.corner.resize(tags.corner.size());
    for (std::size_t v = 0; v < tags.corner.size(); ++v)
        result.tags.corner[rank[v]] = tags.corner[v];
    if (tags.sharp.empty()) return result;
    result.tags.sharp.resize(base.edge_count);
    for (Index h = 0; h < count; ++h)
        result.tags.sharp[result.base.edge[h]] = tags.sharp[base.edge[result.half_edges[h]]];
    return result;
}

/// Sharp edges that no edge of the first level gives, ascending, as the other mesh numbers them.
std::vector<Index> lost_creases(const Searched& searched, const MeshTags& tags,
                                const Topology& other) {
    std::vector<Index> lost;
    if (tags.sharp.empty()) return lost;
    coarser_tags(tags, searched.mesh, *searched.levels.front(), &lost);
    if (lost.empty() || !searched.numbers) return lost;
    std::vector<Index> edges(other.edge_count);
    mesh::each_edge(searched.mesh, [&](Index h, Index, Index) {
        edges[searched.mesh.edge[h]] = other.edge[searched.numbers->half_edge(h)];
    });
    for (Index& edge : lost) edge = edges[edge];
    std::sort(lost.begin(), lost.end());
    return lost;
}

/// The longer one of the levels that descents found. With as many, those of sqrt(3) whose base
/// begins with an odd step: the first descent ends with one.
Levels longest(std::vector<MeshDescent>& descents) {
    Levels levels = std::move(descents[0].levels());
    if (descents.size() == 1) return levels;
    Levels other = std::move(descents[1].levels());
    const bool even = !other.empty() && other.size() == levels.size() && other.size() % 2 == 0;
    return other.size() > levels.size() || even ? std::move(other) : std::move(levels);
}

}  // namespace

Result<MeshOrigin> origin_of(const Topology& mesh, std::span<const Vec3<double>> points,
                             const MeshTags& tags, MeshScheme scheme, int most) {
    const bool open = mesh::counts_of(mesh).boundary_edges > 0;
    const int parities = scheme == MeshScheme::Sqrt3 && open ? 2 : 1;
    std::vector<MeshDescent> descents;
    bool in_order = false;
    for (int even = 0; even < parities; ++even) {
        descents.emplace_back(mesh, points, tags, scheme, even == 1).read_in_order(most);
        in_order = in_order || !descents.back().levels().empty();
    }
    std::optional<NearMesh> near;
    if (!in_order && mesh.sides != 0) {
        near.emplace(mesh, points, tags);
        descents.clear();
        for (int even = 0; even < parities; ++even)
            descents.emplace_back(near->numbers.mesh, near->points, near->tags, scheme, even == 1);
    }
    for (MeshDescent& descent : descents) descent.search(most);
    const Searched searched{near ? near->numbers.mesh : mesh, longest(descents),
                            near ? &near->numbers : nullptr};
    if (searched.levels.empty()) {
        // Once more in the mesh's own numbers, which the reason names.
        MeshDescent descent(mesh, points, tags, scheme, false);
        descent.search(most);
        return descent.reason().value_or(
            Error{ErrorCode::InvalidArgument, "at least one level is needed", "levels"});
    }
    FoundLevel& last = *searched.levels.back();
    MeshOrigin origin;
    origin.lost_creases = lost_creases(searched, near ? near->tags : tags, mesh);
    origin.spec.scheme = scheme;
    origin.spec.first_even = open && last.split == Split::Sqrt3Even;
    origin.steps = static_cast<int>(searched.levels.size());
    if (last.in_order) {
        origin.base = std::move(last.unsplit.mesh);
        origin.tags = std::move(last.tags);
        return origin;
    }
    RELIEF_TRY(Arranged base,
               arranged(searched, scheme == MeshScheme::Sqrt3 ? keys_of_edges(searched)
                                                              : keys_of_corners(searched)));
    RELIEF_TRY(origin.corners, climb(searched, base.base, std::move(base.half_edges)));
    origin.tags = std::move(base.tags);
    origin.base = std::move(base.base);
    return origin;
}

bool MeshOrigin::in_order() const {
    const auto sides = static_cast<Index>(mesh::sides_after(spec.split(0)));
    for (Index f = 0; f < corners.size(); ++f)
        if (corners[f] != sides * f) return false;
    return true;
}

Result<MeshOrigin> renumbered(const MeshOrigin& origin, std::span<const Index> vertices,
                              std::span<const Index> corners) {
    const Topology& base = origin.base;
    std::vector<Index> numbers(base.vertex_count);
    for (Index v = 0; v < vertices.size(); ++v) numbers[vertices[v]] = v;
    MeshOrigin result;
    result.spec = origin.spec;
    result.steps = origin.steps;
    result.lost_creases = origin.lost_creases;
    mesh::FaceList faces;
    std::vector<Index> here;
    for (const Index first : corners) {
        Index h = first;
        do {
            faces.corners.push_back(numbers[base.origin[h]]);
            here.push_back(h);
            h = base.next(h);
        } while (h != first);
        faces.offsets.push_back(static_cast<std::int64_t>(here.size()));
    }
    RELIEF_TRY(result.base, mesh::build(faces, base.vertex_count));
    if (!origin.tags.corner.empty())
        for (const Index v : vertices) result.tags.corner.push_back(origin.tags.corner[v]);
    if (!origin.tags.sharp.empty()) {
        result.tags.sharp.resize(base.edge_count);
        for (Index h = 0; h < here.size(); ++h)
            result.tags.sharp[result.base.edge[h]] = origin.tags.sharp[base.edge[here[h]]];
    }
    // Both are subdivided side by side.
    Topology mine = *mesh::build(faces, base.vertex_count);
    Topology theirs = *mesh::build(mesh::faces_of(base), base.vertex_count);
    for (int step = 0; step < origin.steps; ++step) {
        const Split split = origin.spec.split(step);
        const Buffer<Index> starts = own_starts(theirs, split);
        Buffer<Index> start(here.size());
        for (std::size_t h = 0; h < here.size(); ++h) start[h] = starts[here[h]];
        RELIEF_TRY(theirs, mesh::refine(theirs, split));
        const Buffer<Index> finer = mesh::fine_half_edges(mine, split, theirs, start);
        here.assign(finer.data(), finer.data() + finer.size());
        RELIEF_TRY(mine, mesh::refine(mine, split));
    }
    const auto sides = static_cast<Index>(mine.sides);
    result.corners = Buffer<Index>(mine.face_count);
    for (Index f = 0; f < mine.face_count; ++f)
        result.corners[f] = origin.half_edge(here[sides * f]);
    return result;
}

}  // namespace relief::multires
