#include "relief/mesh/quadrangulation.h"

#include <algorithm>
#include <tuple>
#include <utility>

#include "mesh/plane_checks.h"
#include "mesh/quadrangulation_checks.h"

namespace relief::mesh {

namespace {

constexpr std::uint64_t kMaxElements = (std::uint64_t{1} << 31) - 1;

Status check_corners(std::span<const std::array<Index, 4>> quads, std::size_t vertex_count) {
    for (std::size_t q = 0; q < quads.size(); ++q)
        for (const Index v : quads[q])
            if (v >= vertex_count)
                return bad_mesh("index_out_of_range: it names vertex " + std::to_string(v) +
                                    " of " + std::to_string(vertex_count) +
                                    "; vertices count from 0",
                                "quad", q);
    for (std::size_t q = 0; q < quads.size(); ++q)
        for (int i = 0; i < 4; ++i)
            for (int j = 0; j < i; ++j)
                if (quads[q][i] == quads[q][j])
                    return bad_mesh("repeated_vertex: it names vertex " +
                                        std::to_string(quads[q][i]) +
                                        " twice; triangles must be split into quads first",
                                    "quad", q);
    return {};
}

Status orient(Quadrangulation& mesh, bool reorient) {
    for (Index q = 0; q < mesh.quad_count(); ++q) {
        if (!(doubled_area(mesh.corners(q)) < 0)) continue;
        if (!reorient)
            return bad_mesh("clockwise: reverse its corners, or build with reorient", "quad", q);
        std::swap(mesh.quads[q][1], mesh.quads[q][3]);
    }
    return {};
}

/// One side of a quad under the key of its edge.
struct Side {
    Index from = 0;    ///< the smaller vertex
    Index to = 0;      ///< the larger vertex
    Index number = 0;  ///< 4 quad + side
    std::int8_t sign = 0;
};

std::vector<Side> sorted_sides(const Quadrangulation& mesh) {
    std::vector<Side> sides;
    sides.reserve(4 * mesh.quads.size());
    for (Index q = 0; q < mesh.quad_count(); ++q)
        for (Index i = 0; i < 4; ++i) {
            const Index a = mesh.quads[q][i];
            const Index b = mesh.quads[q][(i + 1) % 4];
            sides.push_back({std::min(a, b), std::max(a, b), 4 * q + i,
                             static_cast<std::int8_t>(a < b ? 1 : -1)});
        }
    std::sort(sides.begin(), sides.end(), [](const Side& a, const Side& b) {
        return std::tie(a.from, a.to, a.number) < std::tie(b.from, b.to, b.number);
    });
    return sides;
}

bool same_edge(const Side& a, const Side& b) {
    return a.from == b.from && a.to == b.to;
}

/// Two sides of one edge must run in opposite directions, and there can be no third.
Status check_manifold(const std::vector<Side>& sides) {
    Index found = kNoQuad;
    Side reported;
    for (std::size_t k = 1; k < sides.size(); ++k) {
        if (!same_edge(sides[k], sides[k - 1])) continue;
        const bool third = k >= 2 && same_edge(sides[k], sides[k - 2]);
        const bool twice = third || sides[k].sign == sides[k - 1].sign;
        if (!twice || sides[k].number >= found) continue;
        found = sides[k].number;
        reported = sides[k];
    }
    if (found == kNoQuad) return {};
    return bad_mesh(
        "edge_used_twice_in_same_direction: another quad has its edge between vertices " +
            std::to_string(reported.from) + " and " + std::to_string(reported.to) +
            " on the same side; remove duplicates and folds",
        "quad", found / 4);
}

Status connect(Quadrangulation& mesh) {
    const std::vector<Side> sides = sorted_sides(mesh);
    RELIEF_CHECK(check_manifold(sides));
    std::vector<Index> first_side(sides.size());  // of the edge of a side
    for (std::size_t k = 0; k < sides.size(); ++k) {
        const bool again = k > 0 && same_edge(sides[k], sides[k - 1]);
        first_side[sides[k].number] = again ? first_side[sides[k - 1].number] : sides[k].number;
    }
    mesh.quad_edges.resize(mesh.quads.size());
    mesh.quad_signs.resize(mesh.quads.size());
    for (Index side = 0; side < sides.size(); ++side) {
        const Index a = mesh.quads[side / 4][side % 4];
        const Index b = mesh.quads[side / 4][(side + 1) % 4];
        const Index first = first_side[side];
        if (first == side) {
            mesh.quad_edges[side / 4][side % 4] = mesh.edge_count();
            mesh.edges.push_back({std::min(a, b), std::max(a, b)});
        } else {
            mesh.quad_edges[side / 4][side % 4] = mesh.quad_edges[first / 4][first % 4];
        }
        mesh.quad_signs[side / 4][side % 4] = a < b ? 1 : -1;
    }
    return {};
}

Error level_out_of_range(int level) {
    return {ErrorCode::InvalidArgument,
            "level_out_of_range: levels count from 0 and may have up to 2^31 - 1 edges; ask for "
            "fewer",
            "level " + std::to_string(level)};
}

}  // namespace

Result<Quadrangulation> build(std::span<const Vec2> vertices,
                              std::span<const std::array<Index, 4>> quads,
                              const BuildOptions& options) {
    if (vertices.size() > kMaxElements || quads.size() > kMaxElements / 4)
        return Error{ErrorCode::BadInput,
                     "too_many_elements: at most 2^31 - 1 vertices and 2^29 - 1 quads; split the "
                     "mesh",
                     ""};
    RELIEF_CHECK(check_coordinates(vertices, "non_finite_vertex", "vertex"));
    RELIEF_CHECK(check_corners(quads, vertices.size()));
    Quadrangulation mesh;
    if (!vertices.empty()) {
        const Box box = box_of(vertices);
        mesh.origin = midpoint(box.low, box.high);
    }
    for (const Vec2 v : vertices) {
        mesh.x.push_back(v.x - mesh.origin.x);
        mesh.y.push_back(v.y - mesh.origin.y);
    }
    mesh.quads.assign(quads.begin(), quads.end());
    RELIEF_CHECK(orient(mesh, options.reorient));
    RELIEF_CHECK(check_convex(mesh));
    RELIEF_CHECK(connect(mesh));
    RELIEF_CHECK(check_vertices_used(mesh));
    RELIEF_CHECK(check_t_junctions(mesh));
    if (options.check_overlap) RELIEF_CHECK(check_overlap(mesh));
    if (mesh.quads.empty())
        return Error{ErrorCode::BadInput, "empty_mesh: there is no quad; add one", ""};
    return mesh;
}

Result<Quadrangulation> build_from_polygons(std::span<const Vec2> vertices,
                                            std::span<const Index> sizes,
                                            std::span<const Index> corners,
                                            const BuildOptions& options) {
    const auto other = std::find_if(sizes.begin(), sizes.end(), [](Index n) { return n != 4; });
    if (other != sizes.end())
        return bad_mesh("not_a_quad: it has " + std::to_string(*other) +
                            " corners; split every n-gon into n quads at its centre first",
                        "polygon", static_cast<std::size_t>(other - sizes.begin()));
    if (corners.size() / 4 != sizes.size() || corners.size() % 4 != 0)
        return Error{ErrorCode::BadInput,
                     "size_mismatch: " + std::to_string(sizes.size()) + " quads and " +
                         std::to_string(corners.size()) + " corners; pass four a quad",
                     ""};
    std::vector<std::array<Index, 4>> quads(sizes.size());
    for (std::size_t k = 0; k < corners.size(); ++k) quads[k / 4][k % 4] = corners[k];
    return build(vertices, quads, options);
}

Result<LevelCounts> level_counts(const Quadrangulation& base, int level) {
    if (level < 0) return level_out_of_range(level);
    LevelCounts n{base.vertex_count(), base.edge_count(), base.quad_count()};
    for (int m = 0; m < level; ++m) {
        n = {n.vertices + n.edges + n.quads, 2 * n.edges + 4 * n.quads, 4 * n.quads};
        if (n.vertices > kMaxElements || n.edges > kMaxElements) return level_out_of_range(level);
    }
    return n;
}

Result<Quadrangulation> refine(const Quadrangulation& parent) {
    if (!level_counts(parent, 1).ok()) return level_out_of_range(1);
    const Index vertices = parent.vertex_count();
    const Index edges = parent.edge_count();
    const Index centres = vertices + edges;
    Quadrangulation child;
    child.origin = parent.origin;
    child.x = parent.x;
    child.y = parent.y;
    const auto add_vertex = [&child](Vec2 p) {
        child.x.push_back(p.x);
        child.y.push_back(p.y);
    };
    for (Index e = 0; e < edges; ++e) {
        const auto [a, b] = parent.edges[e];
        add_vertex(midpoint(parent.vertex(a), parent.vertex(b)));
        child.edges.push_back({a, vertices + e});
        child.edges.push_back({vertices + e, b});
    }
    for (Index q = 0; q < parent.quad_count(); ++q) {
        add_vertex(diagonals(parent.corners(q)).centre);
        const auto& edge = parent.quad_edges[q];
        const auto& sign = parent.quad_signs[q];
        for (Index i = 0; i < 4; ++i) {
            const Index before = (i + 3) % 4;
            const Index inner = 2 * edges + 4 * q;
            child.edges.push_back({vertices + edge[i], centres + q});
            child.quads.push_back(
                {parent.quads[q][i], vertices + edge[i], centres + q, vertices + edge[before]});
            child.quad_edges.push_back({2 * edge[i] + (sign[i] < 0), inner + i, inner + before,
                                        2 * edge[before] + (sign[before] > 0)});
            child.quad_signs.push_back({sign[i], 1, -1, sign[before]});
        }
    }
    return child;
}

VertexQuads vertex_quads(const Quadrangulation& mesh) {
    VertexQuads at{std::vector<Index>(mesh.vertex_count() + 1), {}};
    for (const auto& quad : mesh.quads)
        for (const Index v : quad) ++at.first[v + 1];
    for (Index v = 0; v < mesh.vertex_count(); ++v) at.first[v + 1] += at.first[v];
    at.quads.resize(4 * mesh.quads.size());
    std::vector<Index> next = at.first;
    for (Index q = 0; q < mesh.quad_count(); ++q)
        for (const Index v : mesh.quads[q]) at.quads[next[v]++] = q;
    return at;
}

std::vector<std::array<Index, 2>> edge_quads(const Quadrangulation& mesh) {
    std::vector<std::array<Index, 2>> sides(mesh.edges.size(), {kNoQuad, kNoQuad});
    for (Index q = 0; q < mesh.quad_count(); ++q)
        for (const Index e : mesh.quad_edges[q]) sides[e][sides[e][0] == kNoQuad ? 0 : 1] = q;
    return sides;
}

}  // namespace relief::mesh
