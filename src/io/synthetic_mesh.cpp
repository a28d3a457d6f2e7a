#include "relief/io/synthetic_mesh.h"

#include <array>
#include <cmath>
#include <string>

namespace relief::io {

namespace {

constexpr double kTwoPi = 6.28318530717958647692;

void add_faces(PolygonMesh& mesh, std::initializer_list<std::array<std::int32_t, 3>> faces) {
    for (const auto& face : faces) mesh.add_polygon(face);
}

PolygonMesh cube() {
    PolygonMesh mesh;
    for (const double z : {-1.0, 1.0})
        for (const double y : {-1.0, 1.0})
            for (const double x : {-1.0, 1.0}) mesh.vertices.push_back({x, y, z});
    for (const auto& face : {std::array<std::int32_t, 4>{0, 2, 3, 1},
                             {4, 5, 7, 6},
                             {0, 1, 5, 4},
                             {2, 6, 7, 3},
                             {0, 4, 6, 2},
                             {1, 3, 7, 5}})
        mesh.add_polygon(face);
    return mesh;
}

PolygonMesh octahedron() {
    PolygonMesh mesh;
    for (std::size_t axis = 0; axis < 3; ++axis)
        for (const double side : {1.0, -1.0}) {
            std::array<double, 3> corner{};
            corner[axis] = side;
            mesh.vertices.push_back(corner);
        }
    add_faces(
        mesh,
        {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4}, {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}});
    return mesh;
}

PolygonMesh icosahedron() {
    PolygonMesh mesh;
    const double long_side = std::sqrt((5 + std::sqrt(5.0)) / 10);
    const double short_side = std::sqrt((5 - std::sqrt(5.0)) / 10);
    for (std::size_t axis = 0; axis < 3; ++axis)
        for (const double b : {long_side, -long_side})
            for (const double a : {-short_side, short_side}) {
                std::array<double, 3> corner{};
                corner[axis] = a;
                corner[(axis + 1) % 3] = b;
                mesh.vertices.push_back(corner);
            }
    add_faces(mesh,
              {{0, 5, 1}, {0, 1, 7}, {0, 11, 5}, {0, 7, 10}, {0, 10, 11}, {1, 5, 9},   {1, 8, 7},
               {1, 9, 8}, {2, 3, 4}, {2, 6, 3},  {2, 4, 11}, {2, 10, 6},  {2, 11, 10}, {3, 9, 4},
               {3, 6, 8}, {3, 8, 9}, {4, 9, 5},  {4, 5, 11}, {6, 7, 8},   {6, 10, 7}});
    return mesh;
}

PolygonMesh torus(int size) {
    PolygonMesh mesh;
    const std::int32_t around = 2 * size;
    for (std::int32_t i = 0; i < around; ++i)
        for (std::int32_t j = 0; j < size; ++j) {
            const double u = kTwoPi * i / around;
            const double v = kTwoPi * j / size;
            const double radius = 3 + std::cos(v);
            mesh.vertices.push_back({radius * std::cos(u), radius * std::sin(u), std::sin(v)});
        }
    const auto at = [&](std::int32_t i, std::int32_t j) { return (i % around) * size + j % size; };
    for (std::int32_t i = 0; i < around; ++i)
        for (std::int32_t j = 0; j < size; ++j)
            mesh.add_polygon(std::array<std::int32_t, 4>{at(i, j), at(i + 1, j), at(i + 1, j + 1),
                                                         at(i, j + 1)});
    return mesh;
}

}  // namespace

std::vector<std::string_view> synthetic_mesh_names() {
    return {"cube", "octahedron", "icosahedron", "torus"};
}

Result<PolygonMesh> synthetic_mesh(std::string_view name, int size) {
    if (name == "cube") return cube();
    if (name == "octahedron") return octahedron();
    if (name == "icosahedron") return icosahedron();
    if (name == "torus") {
        if (size < 3 || size > 8192)
            return Error{ErrorCode::InvalidArgument,
                         "a torus has 3 to 8192 quads around its tube, not " + std::to_string(size),
                         ""};
        return torus(size);
    }
    return Error{ErrorCode::InvalidArgument,
                 "there is no mesh '" + std::string(name) +
                     "'; there are cube, octahedron, icosahedron, torus",
                 ""};
}

}  // namespace relief::io
