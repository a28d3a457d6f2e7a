#include "edit/vertex_faces.h"

#include <algorithm>

namespace relief::edit {

using mesh::Index;
using mesh::Topology;

VertexFaces::VertexFaces(const Topology& mesh)
    : first_(mesh.vertex_count + std::size_t{1}), faces_(mesh.half_edge_count()) {
    std::fill_n(first_.data(), first_.size(), Index{0});
    for (Index h = 0; h < mesh.half_edge_count(); ++h) ++first_[mesh.origin[h]];
    Index end = 0;
    for (std::size_t v = 0; v < first_.size(); ++v) first_[v] = end += first_[v];
    for (Index f = mesh.face_count; f-- > 0;)
        for (const Index v : mesh.corners(f)) faces_[--first_[v]] = f;
}

void VertexFaces::neighbours(const Topology& mesh, Index v, std::vector<Index>& out) const {
    const auto old = static_cast<std::ptrdiff_t>(out.size());
    for (const Index f : of(v)) {
        const auto corners = mesh.corners(f);
        const auto here = std::find(corners.begin(), corners.end(), v);
        out.push_back(here == corners.begin() ? corners.back() : here[-1]);
        out.push_back(here + 1 == corners.end() ? corners.front() : here[1]);
    }
    std::sort(out.begin() + old, out.end());
    out.erase(std::unique(out.begin() + old, out.end()), out.end());
}

std::vector<std::array<Index, 2>> edges_of(const Topology& mesh, const VertexFaces& around) {
    std::vector<std::array<Index, 2>> edges;
    edges.reserve(mesh.edge_count);
    std::vector<Index> neighbours;
    for (Index v = 0; v < mesh.vertex_count; ++v) {
        neighbours.clear();
        around.neighbours(mesh, v, neighbours);
        for (const Index w : neighbours)
            if (v < w) edges.push_back({v, w});
    }
    return edges;
}

Vec3<double> normal_at(const Topology& mesh, const VertexFaces& around, const Vec3<double>* points,
                       Index v) {
    Vec3<double> normal;
    for (const Index f : around.of(v)) {
        const auto corners = mesh.corners(f);
        const Vec3<double>& a = points[corners[0]];
        for (std::size_t k = 1; k + 1 < corners.size(); ++k)
            normal += cross(points[corners[k]] - a, points[corners[k + 1]] - a);
    }
    return normal;
}

double mean_curvature(const Topology& mesh, const VertexFaces& around, const Vec3<double>* points,
                      Index v, const Vec3<double>& normal) {
    std::vector<Index> neighbours;
    around.neighbours(mesh, v, neighbours);
    if (neighbours.size() != around.of(v).size()) return 0;
    Vec3<double> sum;  // of (cot + cot)(v - neighbour)
    double area = 0;   // twice
    for (const Index f : around.of(v)) {
        const auto corners = mesh.corners(f);
        for (std::size_t k = 1; k + 1 < corners.size(); ++k) {
            std::array<Index, 3> t{corners[0], corners[k], corners[k + 1]};
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
