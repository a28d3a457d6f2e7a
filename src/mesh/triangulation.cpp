#include "relief/mesh/triangulation.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include "mesh/plane_checks.h"
#include "mesh/triangulation_checks.h"
#include "relief/core/buffer.h"

namespace relief::mesh {

namespace {

using Triangles = std::span<const std::array<Index, 3>>;

constexpr std::size_t kMaxElements = (std::size_t{1} << 31) - 1;

Status check_range(Triangles triangles, std::size_t vertex_count) {
    for (std::size_t t = 0; t < triangles.size(); ++t)
        for (const Index v : triangles[t])
            if (v >= vertex_count)
                return bad_mesh("index_out_of_range: it names vertex " + std::to_string(v) +
                                    " of " + std::to_string(vertex_count) +
                                    "; vertices count from 0",
                                "triangle", t);
    return {};
}

Status check_corners_differ(Triangles triangles) {
    for (std::size_t t = 0; t < triangles.size(); ++t) {
        const auto [a, b, c] = triangles[t];
        if (a == b || b == c || c == a)
            return bad_mesh("repeated_index: it names vertex " + std::to_string(b == c ? b : a) +
                                " twice; remove it",
                            "triangle", t);
    }
    return {};
}

std::vector<std::uint8_t> used_vertices(Triangles triangles, std::size_t vertex_count) {
    std::vector<std::uint8_t> used(vertex_count);
    for (const auto& corners : triangles)
        for (const Index v : corners) used[v] = 1;
    return used;
}

Status check_vertices_used(Triangles triangles, std::size_t vertex_count) {
    const auto used = used_vertices(triangles, vertex_count);
    const auto unused = std::find(used.begin(), used.end(), 0);
    if (unused == used.end()) return {};
    return bad_mesh("isolated_vertex: it belongs to no triangle; remove it, or compact the mesh",
                    "vertex", static_cast<std::size_t>(unused - used.begin()));
}

Status turn_counter_clockwise(Triangulation& mesh, bool strict) {
    for (Index t = 0; t < mesh.triangle_count(); ++t) {
        const auto [a, b, c] = mesh.corners(t);
        if (orient(a, b, c) > 0) continue;
        if (strict)
            return bad_mesh(
                "clockwise: exchange two of its corners, or build without strict orientation",
                "triangle", t);
        std::swap(mesh.triangles[t][1], mesh.triangles[t][2]);
    }
    return {};
}

/// A side of a triangle: 3 triangle + k, and one end of it.
struct Side {
    Index end = 0;
    Index number = 0;
};

/// The sides of all triangles in the order of (lower end, higher end, number); those with lower end
/// v, of which `end` is the higher one, are sides[first[v]] .. sides[first[v + 1] - 1].
struct SortedSides {
    std::vector<Index> first;
    Buffer<Side> sides;

    [[nodiscard]] std::span<const Side> from(Index v) const {
        return {sides.data() + first[v], first[v + 1] - first[v]};
    }
};

/// Where each bucket begins, from how many are in it.
void accumulate(std::vector<Index>& counts) {
    std::exclusive_scan(counts.begin(), counts.end(), counts.begin(), Index{0});
}

/// Two stable counting sorts: by the higher ends, then by the lower ones.
SortedSides sort_sides(Triangles triangles, Index vertex_count) {
    const std::size_t side_count = 3 * triangles.size();
    std::vector<Index> next(std::size_t{vertex_count} + 1);
    SortedSides sorted{std::vector<Index>(next.size()), Buffer<Side>(side_count)};
    const auto each_side = [&](auto visit) {
        Index number = 0;
        for (const auto& v : triangles)
            for (int k = 0; k < 3; ++k, ++number)
                visit(number, std::minmax(v[k], v[k == 2 ? 0 : k + 1]));
    };
    each_side([&](Index, std::pair<Index, Index> ends) {
        ++sorted.first[ends.first];
        ++next[ends.second];
    });
    accumulate(sorted.first);
    accumulate(next);
    Buffer<Side> by_higher(side_count);
    each_side([&](Index number, std::pair<Index, Index> ends) {
        by_higher[next[ends.second]++] = {ends.first, number};
    });
    // next[v] now is where the sides of higher end v stop.
    std::vector<Index> place(sorted.first);
    for (Index v = 0, k = 0; v < vertex_count; ++v)
        for (; k < next[v]; ++k) {
            const Side side = by_higher[k];
            sorted.sides[place[side.end]++] = {v, side.number};
        }
    return sorted;
}

/// visit(lower end, higher end, sides) for each edge, in lexicographic order.
template <class Visit>
void each_edge(const SortedSides& sorted, Visit&& visit) {
    for (Index v = 0; v + 1 < sorted.first.size(); ++v) {
        const auto sides = sorted.from(v);
        for (std::size_t begin = 0, end = 0; begin < sides.size(); begin = end) {
            while (end < sides.size() && sides[end].end == sides[begin].end) ++end;
            visit(v, sides[begin].end, sides.subspan(begin, end - begin));
        }
    }
}

bool forward(const Triangulation& mesh, Side side) {
    return mesh.runs_forward(side.number / 3, side.number % 3);
}

Status check_manifold(const Triangulation& mesh, const SortedSides& sorted) {
    Status third;
    Status same_side;
    const auto ends = [](Index low, Index high) {
        return "the edge between vertices " + std::to_string(low) + " and " + std::to_string(high) +
               "; remove duplicates and folds";
    };
    each_edge(sorted, [&](Index low, Index high, std::span<const Side> sides) {
        if (third.ok() && sides.size() > 2)
            third = bad_mesh("non_manifold_edge: it is the third triangle at " + ends(low, high),
                             "triangle", sides[2].number / 3);
        if (same_side.ok() && sides.size() == 2 &&
            forward(mesh, sides[0]) == forward(mesh, sides[1]))
            same_side = bad_mesh("inconsistent_orientation: it lies on the same side as triangle " +
                                     std::to_string(sides[0].number / 3) + " of " + ends(low, high),
                                 "triangle", sides[1].number / 3);
    });
    return third.ok() ? same_side : third;
}

void number_edges(Triangulation& mesh, const SortedSides& sorted) {
    std::size_t count = 0;
    each_edge(sorted, [&](Index, Index, std::span<const Side>) { ++count; });
    mesh.edges.reserve(count);
    mesh.edge_triangles.reserve(count);
    mesh.triangle_edges.resize(mesh.triangles.size());
    each_edge(sorted, [&](Index low, Index high, std::span<const Side> sides) {
        std::array<Index, 2> triangles{kNone, kNone};
        for (const Side side : sides) {
            triangles[forward(mesh, side) ? 0 : 1] = side.number / 3;
            mesh.triangle_edges[side.number / 3][side.number % 3] = mesh.edge_count();
        }
        mesh.edges.push_back({low, high});
        mesh.edge_triangles.push_back(triangles);
    });
}

}  // namespace

Result<Triangulation> build(std::span<const Vec2> vertices, Triangles triangles,
                            const TriangulationOptions& options) {
    if (vertices.size() > kMaxElements || triangles.size() > kMaxElements / 3)
        return Error{ErrorCode::BadInput,
                     "too_many_elements: at most 2^31 - 1 vertices and a third as many triangles; "
                     "split the mesh",
                     ""};
    RELIEF_CHECK(check_coordinates(vertices, "non_finite_input", "vertex"));
    if (triangles.empty())
        return Error{ErrorCode::BadInput, "empty_mesh: there is no triangle; add one", ""};
    RELIEF_CHECK(check_range(triangles, vertices.size()));
    RELIEF_CHECK(check_corners_differ(triangles));
    RELIEF_CHECK(check_vertices_used(triangles, vertices.size()));
    Triangulation mesh;
    const Box box = box_of(vertices);
    mesh.origin = midpoint(box.low, box.high);
    for (const Vec2 v : vertices) {
        mesh.x.push_back(v.x - mesh.origin.x);
        mesh.y.push_back(v.y - mesh.origin.y);
    }
    mesh.triangles.assign(triangles.begin(), triangles.end());
    RELIEF_CHECK(check_thickness(mesh));
    RELIEF_CHECK(turn_counter_clockwise(mesh, options.strict_orientation));
    const SortedSides sorted = sort_sides(mesh.triangles, mesh.vertex_count());
    RELIEF_CHECK(check_manifold(mesh, sorted));
    number_edges(mesh, sorted);
    RELIEF_CHECK(check_folds(mesh));
    RELIEF_CHECK(check_hanging_vertices(mesh));
    if (options.check_overlap) RELIEF_CHECK(check_overlap(mesh));
    return mesh;
}

Triangulation connect(Vec2 origin, std::vector<double> x, std::vector<double> y,
                      std::vector<std::array<Index, 3>> triangles) {
    Triangulation mesh{{origin, std::move(x), std::move(y), std::move(triangles)}, {}, {}, {}};
    number_edges(mesh, sort_sides(mesh.triangles, mesh.vertex_count()));
    return mesh;
}

std::vector<TriangleSide> boundary_sides(const Triangulation& mesh) {
    std::vector<TriangleSide> sides;
    for (Index e = 0; e < mesh.edge_count(); ++e) {
        if (!mesh.on_boundary(e)) continue;
        const auto [left, right] = mesh.edge_triangles[e];
        const Index t = left == kNone ? right : left;
        const auto& around = mesh.triangle_edges[t];
        const auto side = std::find(around.begin(), around.end(), e) - around.begin();
        sides.push_back({t, static_cast<Index>(side)});
    }
    return sides;
}

Result<CompactTriangles> compact(std::span<const Vec2> vertices, Triangles triangles) {
    RELIEF_CHECK(check_range(triangles, vertices.size()));
    const auto used = used_vertices(triangles, vertices.size());
    CompactTriangles result;
    std::vector<Index> number(vertices.size());
    for (Index v = 0; v < vertices.size(); ++v) {
        if (!used[v]) continue;
        number[v] = static_cast<Index>(result.source.size());
        result.source.push_back(v);
        result.vertices.push_back(vertices[v]);
    }
    for (const auto& [a, b, c] : triangles)
        result.triangles.push_back({number[a], number[b], number[c]});
    return result;
}

VertexStars vertex_triangles(const Triangulation& mesh) {
    VertexStars stars{std::vector<Index>(std::size_t{mesh.vertex_count()} + 1),
                      std::vector<Index>(3 * mesh.triangles.size())};
    for (const auto& triangle : mesh.triangles)
        for (const Index v : triangle) ++stars.first[v];
    accumulate(stars.first);
    std::vector<Index> next(stars.first);
    for (Index t = 0; t < mesh.triangle_count(); ++t)
        for (const Index v : mesh.triangles[t]) stars.items[next[v]++] = t;
    return stars;
}

VertexStars vertex_neighbours(const Triangulation& mesh) {
    VertexStars stars{std::vector<Index>(std::size_t{mesh.vertex_count()} + 1),
                      std::vector<Index>(2 * mesh.edges.size())};
    for (const auto& edge : mesh.edges)
        for (const Index v : edge) ++stars.first[v];
    accumulate(stars.first);
    std::vector<Index> next(stars.first);
    // The order of edges makes both halves of each list ascending.
    for (const auto& [low, high] : mesh.edges) stars.items[next[high]++] = low;
    for (const auto& [low, high] : mesh.edges) stars.items[next[low]++] = high;
    return stars;
}

}  // namespace relief::mesh
