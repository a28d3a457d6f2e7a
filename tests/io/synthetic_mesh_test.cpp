#include "relief/io/synthetic_mesh.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>

namespace relief::io {
namespace {

/// Closed, turned outwards, of the right genus.
TEST(SyntheticMesh, ClosedSurfaces) {
    const std::map<std::string_view, int> characteristic{
        {"cube", 2}, {"octahedron", 2}, {"icosahedron", 2}, {"torus", 0}};
    for (const std::string_view name : synthetic_mesh_names()) {
        const PolygonMesh mesh = *synthetic_mesh(name, 16);
        EXPECT_TRUE(check(mesh).ok());
        std::map<std::pair<int, int>, int> sides;
        double volume = 0;
        for (std::int64_t f = 0; f < mesh.polygon_count(); ++f) {
            const auto face = mesh.polygon(f);
            for (std::size_t k = 0; k < face.size(); ++k)
                ++sides[{face[k], face[(k + 1) % face.size()]}];
            for (std::size_t k = 1; k + 1 < face.size(); ++k) {
                const auto& a = mesh.vertices[static_cast<std::size_t>(face[0])];
                const auto& b = mesh.vertices[static_cast<std::size_t>(face[k])];
                const auto& c = mesh.vertices[static_cast<std::size_t>(face[k + 1])];
                volume += (a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) +
                           a[2] * (b[0] * c[1] - b[1] * c[0])) /
                          6;
            }
        }
        for (const auto& [side, count] : sides) {
            EXPECT_EQ(count, 1);
            EXPECT_EQ(sides.count({side.second, side.first}), 1U);
        }
        EXPECT_GT(volume, 1) << name;
        const auto edges = static_cast<std::int64_t>(sides.size()) / 2;
        EXPECT_EQ(static_cast<std::int64_t>(mesh.vertices.size()) - edges + mesh.polygon_count(),
                  characteristic.at(name));
    }
    EXPECT_FALSE(synthetic_mesh("moon", 16).ok());
    EXPECT_FALSE(synthetic_mesh("torus", 2).ok());
}

}  // namespace
}  // namespace relief::io
