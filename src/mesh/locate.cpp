#include "relief/mesh/locate.h"

#include <cmath>

#include "mesh/box_tree.h"
#include "mesh/nearest_edge.h"

namespace relief::mesh {

namespace {

/// Points that rounding has pushed out of the domain, relative to the length of the boundary edge.
constexpr double kOnBoundary = 1e-12;

/// Both quads of an edge look at the same number, so no point falls between them.
bool contains(const Quadrangulation& mesh, Index q, Vec2 p) {
    for (int i = 0; i < 4; ++i) {
        const Index e = mesh.quad_edges[q][i];
        const double side = cross(mesh.edge_vector(e), p - mesh.vertex(mesh.edges[e][0]));
        if (mesh.quad_signs[q][i] * side < 0) return false;
    }
    return true;
}

}  // namespace

struct Locator::Data {
    const Quadrangulation& mesh;
    BoxTree quads;
    std::vector<Index> boundary_quads;  ///< of the edges of one quad
    EdgeTree boundary;

    explicit Data(const Quadrangulation& of) : mesh(of) {
        std::vector<Box> boxes;
        for (Index q = 0; q < mesh.quad_count(); ++q) boxes.push_back(box_of(mesh.corners(q)));
        quads = BoxTree(boxes);
        std::vector<EdgeTree::Segment> segments;
        const auto sides = edge_quads(mesh);
        for (Index e = 0; e < mesh.edge_count(); ++e) {
            if (sides[e][1] != kNoQuad) continue;
            boundary_quads.push_back(sides[e][0]);
            segments.push_back({mesh.vertex(mesh.edges[e][0]), mesh.edge_vector(e)});
        }
        boundary = EdgeTree(std::move(segments));
    }

    /// The quad of the smallest number that contains p, or kNoQuad.
    [[nodiscard]] Index quad_at(Vec2 p) const {
        Index found = kNoQuad;
        quads.search([&](const Box& box) { return box.contains(p); },
                     [&](Index q) {
                         if (q < found && contains(mesh, q, p)) found = q;
                     });
        return found;
    }
};

Locator::Locator(const Quadrangulation& mesh) : data_(std::make_unique<const Data>(mesh)) {}
Locator::Locator(Locator&&) noexcept = default;
Locator& Locator::operator=(Locator&&) noexcept = default;
Locator::~Locator() = default;

std::optional<Place> Locator::locate(Vec2 point) const {
    if (!std::isfinite(point.x) || !std::isfinite(point.y)) return std::nullopt;
    const Vec2 p = point - data_->mesh.origin;
    if (const Index q = data_->quad_at(p); q != kNoQuad) return Place{q, p};
    const NearestEdge border = data_->boundary.nearest(p);
    if (border.distance <= kOnBoundary * length(data_->boundary[border.edge].along))
        return Place{data_->boundary_quads[border.edge], border.point};
    return std::nullopt;
}

Place Locator::nearest(Vec2 point) const {
    const Vec2 p = point - data_->mesh.origin;
    if (const Index q = data_->quad_at(p); q != kNoQuad) return {q, p};
    const NearestEdge border = data_->boundary.nearest(p);
    return {data_->boundary_quads[border.edge], border.point};
}

Index child_of(const Quadrangulation& parent, const Quadrangulation& child, const Place& place) {
    const Index q = place.quad;
    const Vec2 centre = child.vertex(parent.vertex_count() + parent.edge_count() + q);
    std::array<double, 4> side{};  // of the inner edge that ends in the midpoint of side i
    for (int i = 0; i < 4; ++i) {
        const Vec2 middle = child.vertex(parent.vertex_count() + parent.quad_edges[q][i]);
        side[i] = cross(middle - centre, place.point - centre);
    }
    for (Index i = 0; i < 4; ++i)
        if (side[(i + 3) % 4] >= 0 && side[i] <= 0) return 4 * q + i;
    return 4 * q;
}

}  // namespace relief::mesh
