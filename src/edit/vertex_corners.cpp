#include "edit/vertex_corners.h"

#include <algorithm>

namespace relief::edit {

using mesh::Index;
using mesh::Topology;

VertexCorners::VertexCorners(const Topology& mesh)
    : first_(mesh.vertex_count + std::size_t{1}), corners_(mesh.half_edge_count()) {
    std::fill_n(first_.data(), first_.size(), Index{0});
    for (Index h = 0; h < mesh.half_edge_count(); ++h) ++first_[mesh.origin[h]];
    Index end = 0;
    for (Index v = 0; v < first_.size(); ++v) first_[v] = end += first_[v];
    for (Index h = mesh.half_edge_count(); h-- > 0;) corners_[--first_[mesh.origin[h]]] = h;
}

void VertexCorners::neighbours(const Topology& mesh, Index v, std::vector<Index>& out) const {
    const auto old = static_cast<std::ptrdiff_t>(out.size());
    for (const Index h : of(v)) {
        out.push_back(mesh.target(h));
        out.push_back(mesh.origin[mesh.prev(h)]);
    }
    std::sort(out.begin() + old, out.end());
    out.erase(std::unique(out.begin() + old, out.end()), out.end());
}

std::vector<std::array<Index, 2>> edges_of(const Topology& mesh, const VertexCorners& corners) {
    std::vector<std::array<Index, 2>> edges;
    edges.reserve(mesh.edge_count);
    std::vector<Index> around;
    for (Index v = 0; v < mesh.vertex_count; ++v) {
        around.clear();
        corners.neighbours(mesh, v, around);
        for (const Index w : around)
            if (v < w) edges.push_back({v, w});
    }
    return edges;
}

Vec3<double> normal_at(const Topology& mesh, const VertexCorners& corners,
                       const Vec3<double>* points, Index v) {
    Vec3<double> normal;
    for (const Index corner : corners.of(v)) {
        const Index f = mesh.face_of(corner);
        const Index first = mesh.first_of(f);
        const Vec3<double>& a = points[mesh.origin[first]];
        for (Index h = first + 1; h + 1 < mesh.first_of(f + 1); ++h)
            normal += cross(points[mesh.origin[h]] - a, points[mesh.origin[h + 1]] - a);
    }
    return normal;
}

double mean_curvature(const Topology& mesh, const VertexCorners& corners,
                      const Vec3<double>* points, Index v, const Vec3<double>& normal) {
    std::vector<Index> around;
    corners.neighbours(mesh, v, around);
    if (around.size() != corners.of(v).size()) return 0;
    Vec3<double> sum;  // of (cot + cot)(v - neighbour)
    double area = 0;   // twice
    for (const Index corner : corners.of(v)) {
        const Index f = mesh.face_of(corner);
        const Index first = mesh.first_of(f);
        for (Index h = first + 1; h + 1 < mesh.first_of(f + 1); ++h) {
            std::array<Index, 3> t{mesh.origin[first], mesh.origin[h], mesh.origin[h + 1]};
            const auto here = std::find(t.begin(), t.end(), v);
            if (here == t.end()) continue;
            std::rotate(t.begin(), here, t.end());
            const Vec3<double> a = points[t[0]] - points[t[1]];
            const Vec3<double> b = points[t[0]] - points[t[2]];
            const Vec3<double> across = points[t[1]] - points[t[2]];
            const double doubled = length(cross(a, b));
            if (!(doubled > 0)) continue;
            sum += dot(b, across) / doubled * a;
            sum -= dot(a, across) / doubled * b;
            area += doubled;
        }
    }
    return area > 0 ? -1.5 * dot(sum, normal) / area : 0;
}

}  // namespace relief::edit
