#include "relief/mesh/locate.h"

#include <cmath>
#include <limits>

#include "mesh/box_tree.h"

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

Vec2 nearest_on_segment(Vec2 a, Vec2 ab, Vec2 p) {
    const double t = dot(p - a, ab) / dot(ab, ab);
    return t <= 0 ? a : t >= 1 ? a + ab : a + t * ab;
}

struct Projection {
    Place place;
    double distance = std::numeric_limits<double>::infinity();
    double edge_length = 0;
};

}  // namespace

struct Locator::Data {
    const Quadrangulation& mesh;
    BoxTree quads;
    std::vector<Index> boundary;  ///< the edges of one quad ..
    std::vector<Index> inside;    ///< .. and that quad
    BoxTree boundary_tree;

    explicit Data(const Quadrangulation& of) : mesh(of) {
        std::vector<Box> boxes;
        for (Index q = 0; q < mesh.quad_count(); ++q) boxes.push_back(box_of(mesh.corners(q)));
        quads = BoxTree(boxes);
        boxes.clear();
        const auto sides = edge_quads(mesh);
        for (Index e = 0; e < mesh.edge_count(); ++e) {
            if (sides[e][1] != kNoQuad) continue;
            const auto [a, b] = mesh.edges[e];
            boundary.push_back(e);
            inside.push_back(sides[e][0]);
            boxes.push_back(box_of(std::array{mesh.vertex(a), mesh.vertex(b)}));
        }
        boundary_tree = BoxTree(boxes);
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

    /// The nearest point of the boundary; among equals that of the smallest edge.
    [[nodiscard]] Projection projection(Vec2 p) const {
        Projection best;
        Index best_edge = kNoQuad;
        boundary_tree.search(
            [&](const Box& box) { return box.distance(p) <= best.distance; },
            [&](Index k) {
                const Index e = boundary[k];
                const Vec2 along = mesh.edge_vector(e);
                const Vec2 foot = nearest_on_segment(mesh.vertex(mesh.edges[e][0]), along, p);
                const double distance = length(p - foot);
                if (distance > best.distance || (distance == best.distance && e > best_edge))
                    return;
                best = {{inside[k], foot}, distance, length(along)};
                best_edge = e;
            });
        return best;
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
    const Projection border = data_->projection(p);
    if (border.distance <= kOnBoundary * border.edge_length) return border.place;
    return std::nullopt;
}

Place Locator::nearest(Vec2 point) const {
    const Vec2 p = point - data_->mesh.origin;
    if (const Index q = data_->quad_at(p); q != kNoQuad) return {q, p};
    return data_->projection(p).place;
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
