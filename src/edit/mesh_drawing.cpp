#include "edit/mesh_drawing.h"

#include "relief/core/parallel.h"

namespace relief::edit {

using mesh::Index;

namespace {

constexpr std::int64_t kGrain = 4096;

}  // namespace

Point MeshDrawing::position(Index v) const {
    return page_point(points[v] - origin);
}

Vec3<double> MeshDrawing::normal(Index v) const {
    const Vec3<double> sum = normal_at(mesh, around, points.data(), v);
    const double size = length(sum);
    return size > 0 ? 1 / size * sum : Vec3<double>{0, 0, 1};
}

float MeshDrawing::error(Index v, const Vec3<double>& normal) const {
    const Vec3<double> off = points[v] - (*original)[v];
    const double size = length(off);
    return static_cast<float>(dot(off, normal) < 0 ? -size : size);
}

template <class Geometry>
void MeshDrawing::draw(Index v, std::size_t at, Geometry& out) const {
    const Vec3<double> up = normal(v);
    out.position[at] = position(v);
    out.normal[at] = packed_normal(up);
    if (!out.error.empty()) out.error[at] = error(v, up);
    if (!out.curvature.empty())
        out.curvature[at] = static_cast<float>(mean_curvature(mesh, around, points.data(), v, up));
}

SurfaceGeometry MeshDrawing::surface(const Extras& extras) const {
    SurfaceGeometry out;
    out.position.resize(points.size());
    out.normal.resize(points.size());
    if (extras.error && original) out.error.resize(points.size());
    if (extras.curvature) out.curvature.resize(points.size());
    parallel_for(0, static_cast<std::int64_t>(points.size()), kGrain, [&](auto k, auto end) {
        for (auto v = static_cast<Index>(k); v < end; ++v) draw(v, number(v), out);
    });
    for (Index f = 0; f < mesh.face_count; ++f) {
        const auto face = mesh.corners(f);
        for (std::size_t k = 1; k + 1 < face.size(); ++k)
            for (const Index v : {face[0], face[k], face[k + 1]}) out.index.push_back(number(v));
    }
    for (const auto& [a, b] : edges_of(mesh, around)) {
        out.line.push_back(number(a));
        out.line.push_back(number(b));
    }
    return out;
}

SurfacePatch MeshDrawing::patch(const std::vector<Index>& moved, const Extras& extras) const {
    std::vector<bool> drawn(points.size(), false);
    std::vector<Index> vertices;
    for (const Index v : moved)
        for (const Index f : around.of(v))
            for (const Index w : mesh.corners(f)) {
                if (drawn[w]) continue;
                drawn[w] = true;
                vertices.push_back(w);
            }
    SurfacePatch out;
    out.at.resize(vertices.size());
    out.position.resize(vertices.size());
    out.normal.resize(vertices.size());
    if (extras.error && original) out.error.resize(vertices.size());
    if (extras.curvature) out.curvature.resize(vertices.size());
    parallel_for(0, static_cast<std::int64_t>(vertices.size()), kGrain, [&](auto k, auto end) {
        for (; k < end; ++k)
            draw(vertices[static_cast<std::size_t>(k)], static_cast<std::size_t>(k), out);
    });
    for (std::size_t k = 0; k < vertices.size(); ++k) out.at[k] = number(vertices[k]);
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
    for (const auto& [a, b] : edges_of(mesh, around)) {
        out.line.push_back(number(a));
        out.line.push_back(number(b));
    }
    return out;
}

}  // namespace relief::edit
