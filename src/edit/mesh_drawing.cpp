#include "edit/mesh_drawing.h"

namespace relief::edit {

using mesh::Index;

Point MeshDrawing::position(Index v) const {
    const Vec3<double> p = points[v] - origin;
    return {static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z)};
}

Vec3<double> MeshDrawing::normal(Index v) const {
    const Vec3<double> sum = normal_at(mesh, corners, points.data(), v);
    const double size = length(sum);
    return size > 0 ? 1 / size * sum : Vec3<double>{0, 0, 1};
}

float MeshDrawing::error(Index v, const Vec3<double>& normal) const {
    const Vec3<double> off = points[v] - (*original)[v];
    const double size = length(off);
    return static_cast<float>(dot(off, normal) < 0 ? -size : size);
}

SurfaceGeometry MeshDrawing::surface(const Extras& extras) const {
    SurfaceGeometry out;
    out.position.resize(points.size());
    out.normal.resize(points.size());
    if (extras.error && original) out.error.resize(points.size());
    if (extras.curvature) out.curvature.resize(points.size());
    for (Index v = 0; v < points.size(); ++v) {
        const Index at = number(v);
        const Vec3<double> up = normal(v);
        out.position[at] = position(v);
        out.normal[at] = packed_normal(up);
        if (!out.error.empty()) out.error[at] = error(v, up);
        if (extras.curvature)
            out.curvature[at] =
                static_cast<float>(mean_curvature(mesh, corners, points.data(), v, up));
    }
    for (Index f = 0; f < mesh.face_count; ++f) {
        const auto face = mesh.corners(f);
        for (std::size_t k = 1; k + 1 < face.size(); ++k)
            for (const Index v : {face[0], face[k], face[k + 1]}) out.index.push_back(number(v));
    }
    for (const auto& [a, b] : edges_of(mesh, corners)) {
        out.line.push_back(number(a));
        out.line.push_back(number(b));
    }
    return out;
}

SurfacePatch MeshDrawing::patch(const std::vector<Index>& moved, const Extras& extras) const {
    std::vector<bool> drawn(points.size(), false);
    std::vector<Index> vertices;
    for (const Index v : moved)
        for (const Index h : corners.of(v))
            for (const Index w : mesh.corners(mesh.face_of(h))) {
                if (drawn[w]) continue;
                drawn[w] = true;
                vertices.push_back(w);
            }
    SurfacePatch out;
    out.at.reserve(vertices.size());
    out.position.reserve(vertices.size());
    out.normal.reserve(vertices.size());
    for (const Index v : vertices) {
        const Vec3<double> up = normal(v);
        out.at.push_back(number(v));
        out.position.push_back(position(v));
        out.normal.push_back(packed_normal(up));
        if (extras.error && original) out.error.push_back(error(v, up));
        if (extras.curvature)
            out.curvature.push_back(
                static_cast<float>(mean_curvature(mesh, corners, points.data(), v, up)));
    }
    return out;
}

NetGeometry MeshDrawing::net() const {
    NetGeometry out;
    out.position.resize(points.size());
    out.point.resize(points.size());
    for (Index v = 0; v < points.size(); ++v) {
        out.position[number(v)] = position(v);
        out.point[v] = v;
    }
    for (const auto& [a, b] : edges_of(mesh, corners)) {
        out.line.push_back(number(a));
        out.line.push_back(number(b));
    }
    return out;
}

NetGeometry MeshDrawing::net_of(const std::vector<Index>& moved) const {
    NetGeometry out;
    for (const Index v : moved) {
        out.position.push_back(position(v));
        out.point.push_back(number(v));
    }
    return out;
}

}  // namespace relief::edit
