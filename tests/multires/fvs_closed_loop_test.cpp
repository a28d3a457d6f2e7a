#include <limits>
#include <map>

#include "multires/fvs_mesh_support.h"
#include "relief/core/parallel.h"
#include "relief/multires/fvs_mesh_coding.h"

namespace relief::multires::fvs_mesh {
namespace {

using mesh::Index;
using mesh::Quadrangulation;
using test::built;
using test::hierarchy_of;
using test::unit_square;

NodalData franke_data(const Quadrangulation& mesh) {
    return interpolate(mesh, [](Vec2 p) { return test::franke(p); });
}

/// Row and column of a point in units of `cell`.
std::pair<std::size_t, std::size_t> cell_of(Vec2 p, double cell) {
    return {static_cast<std::size_t>(std::lround(std::floor(p.y / cell))),
            static_cast<std::size_t>(std::lround(std::floor(p.x / cell)))};
}

int entry(const nlohmann::json& rows, std::pair<std::size_t, std::size_t> at) {
    return rows[at.first][at.second];
}

/// The reference vectors are those of a grid, where normals are +y and +x and edges run along the
/// axes.
void expect_level(const Hierarchy& hierarchy, int m, const Details<std::int32_t>& q,
                  const nlohmann::json& golden) {
    const Quadrangulation& parent = hierarchy.mesh(m - 1);
    const Quadrangulation& child = hierarchy.mesh(m);
    const double cell = std::ldexp(1.0, 1 - m);
    const auto at = [](const Quadrangulation& mesh, Vec2 p) { return mesh.origin + p; };
    for (Index e = 0; e < parent.edge_count(); ++e) {
        const Vec2 d = parent.edge_vector(e);
        const bool horizontal = d.y == 0;
        const int sign = d.x + d.y > 0 ? 1 : -1;
        const auto place = cell_of(at(parent, parent.vertex(parent.edges[e][0]) + 0.5 * d), cell);
        EXPECT_EQ(q.edge_value[e], entry(golden[horizontal ? "ehv" : "evv"], place));
        EXPECT_EQ(q.edge_tangential[e], sign * entry(golden[horizontal ? "eht" : "evt"], place));
    }
    for (Index k = 0; k < parent.quad_count(); ++k) {
        const auto place = cell_of(at(parent, diagonals(parent.corners(k)).centre), cell);
        EXPECT_EQ(q.centre_value[k], entry(golden["cv"], place));
        EXPECT_EQ(q.centre_dx[k], entry(golden["cx"], place));
        EXPECT_EQ(q.centre_dy[k], entry(golden["cy"], place));
    }
    for (Index e = 0; e < child.edge_count(); ++e) {
        const Vec2 d = child.edge_vector(e);
        const bool horizontal = d.y == 0;
        const Vec2 normal = turned(d);
        const int sign = normal.x + normal.y > 0 ? 1 : -1;
        const bool inner = e >= 2 * parent.edge_count();
        const Vec2 p = at(child, child.vertex(child.edges[e][0]) + 0.5 * d);
        // Rows of gh0, columns of gv0 count lines of the parent grid; those of gh1, gv1 its cells.
        const auto place = horizontal
                               ? std::pair{cell_of(p, cell).first, cell_of(p, cell / 2).second}
                               : std::pair{cell_of(p, cell / 2).first, cell_of(p, cell).second};
        const std::string name = std::string(horizontal ? "gh" : "gv") + (inner ? "1" : "0");
        EXPECT_EQ(q.normal[e], sign * entry(golden[name], place)) << name << " edge " << e;
    }
}

TEST(FvsClosedLoop, GoldenIntegers) {
    const nlohmann::json& golden = test::fvs_golden()["closed_loop"];
    const int levels = golden["levels"];
    const Hierarchy hierarchy = unit_square(levels);
    const NodalData data = franke_data(hierarchy.mesh(levels));
    const Quantised code = *quantise(hierarchy, data, golden["step_value"], golden["kappa"]);
    const Quadrangulation& base = hierarchy.mesh(0);
    const nlohmann::json& level0 = golden["q"][0];
    for (Index v = 0; v < 4; ++v) {
        const auto place = cell_of(base.origin + base.vertex(v), 1);
        EXPECT_EQ(code.base.value[v], entry(level0[0], place));
        EXPECT_EQ(code.base.dx[v], entry(level0[1], place));
        EXPECT_EQ(code.base.dy[v], entry(level0[2], place));
    }
    for (Index e = 0; e < 4; ++e) {
        const Vec2 d = base.edge_vector(e);
        const bool horizontal = d.y == 0;
        const int sign = horizontal ? (d.x > 0 ? 1 : -1) : (d.y > 0 ? -1 : 1);
        const auto place = cell_of(base.origin + base.vertex(base.edges[e][0]) + 0.5 * d, 1);
        EXPECT_EQ(code.base.normal[e], sign * entry(level0[horizontal ? 3 : 4], place));
    }
    for (int m = 1; m <= levels; ++m)
        expect_level(hierarchy, m, code.details[m - 1], golden["q"][m]);

    const NodalData decoded = *dequantise(hierarchy, code, levels);
    // The bound contains the rounding term of 1e-13 of the surface.
    EXPECT_NEAR(error_bound(hierarchy.mesh(levels), data, decoded, 0),
                golden["bb_bound"].get<double>(), 1e-12);
    const auto points = test::square_points(65);
    const auto exact = test::jets(hierarchy, levels, data, points);
    const auto approximate = test::jets(hierarchy, levels, decoded, points);
    double most = 0;
    for (std::size_t k = 0; k < points.size(); ++k)
        most = std::max(most, std::abs(exact[k].value - approximate[k].value));
    EXPECT_NEAR(most, golden["sampled_max"].get<double>(), 1e-12);
}

TEST(FvsClosedLoop, ErrorsDoNotAddUp) {
    for (const Quadrangulation& base : test::mesh_family()) {
        const Hierarchy hierarchy = hierarchy_of(base, 3);
        const NodalData data = test::noise_data(hierarchy.mesh(3), 3);
        constexpr double kStep = 0.01;
        const NodalData decoded = *dequantise(hierarchy, *quantise(hierarchy, data, kStep), 3);
        for (std::size_t v = 0; v < data.value.size(); ++v)
            EXPECT_LE(std::abs(data.value[v] - decoded.value[v]), 0.5 * kStep + 1e-12);
        // Normal derivatives: kappa / h steps, h of the level where the edge's midpoint appears,
        // which is at least that of level 3.
        for (Index e = 0; e < hierarchy.mesh(3).edge_count(); ++e) {
            const double h = length(hierarchy.mesh(3).edge_vector(e));
            EXPECT_LE(std::abs(data.normal[e] - decoded.normal[e]), 2 * kStep / h + 1e-12);
        }
    }
}

TEST(FvsClosedLoop, DecoderRepeatsTheEncoder) {
    const Hierarchy hierarchy = hierarchy_of(built(test::grid_mesh(12, 9, 0.1, 0.19)), 3);
    const NodalData data = franke_data(hierarchy.mesh(3));
    Quantised codes[2];
    NodalData decoded[2];
    for (int k = 0; k < 2; ++k) {
        set_thread_count(k == 0 ? 1 : 4);
        codes[k] = *quantise(hierarchy, data, 1e-4);
        decoded[k] = *dequantise(hierarchy, codes[k], 3);
    }
    set_thread_count(0);
    EXPECT_TRUE(codes[0].base == codes[1].base && codes[0].details == codes[1].details);
    EXPECT_TRUE(decoded[0] == decoded[1]);
    // What was decoded is a fixed point: its own code is the same.
    const Quantised again = *quantise(hierarchy, decoded[0], 1e-4);
    EXPECT_TRUE(again.base == codes[0].base && again.details == codes[0].details);
}

TEST(FvsClosedLoop, PrefixesDecode) {
    const Hierarchy hierarchy = unit_square(4);
    const Quantised code = *quantise(hierarchy, franke_data(hierarchy.mesh(4)), 1e-3);
    Quantised prefix = code;
    prefix.details.resize(2);
    EXPECT_TRUE(*dequantise(hierarchy, prefix, 2) == *dequantise(hierarchy, code, 2));
    EXPECT_FALSE(dequantise(hierarchy, prefix, 3).ok());
}

TEST(FvsClosedLoop, CertifiedErrorIsWithinTheTolerance) {
    const auto points = test::square_points(97);
    for (const double tolerance : {1e-2, 1e-3, 1e-4}) {
        const Hierarchy hierarchy = unit_square(5);
        const NodalData data = franke_data(hierarchy.mesh(5));
        const ClosedLoop loop = *quantise_within(hierarchy, data, tolerance);
        EXPECT_LE(loop.bound, tolerance);
        EXPECT_GE(loop.bound, 0.7 * tolerance);  // the search is not far from the tolerance
        // Found steps are 0.9 to 2 times the tolerance (section 8.2); the safe one is 0.59.
        EXPECT_GE(loop.code.step, 0.59 * tolerance);
        const auto exact = test::jets(hierarchy, 5, data, points);
        const auto decoded = test::jets(hierarchy, 5, *dequantise(hierarchy, loop.code, 5), points);
        for (std::size_t k = 0; k < points.size(); ++k)
            EXPECT_LE(std::abs(exact[k].value - decoded[k].value), loop.bound);
    }
}

TEST(FvsClosedLoop, CertifiedErrorOnAnyMesh) {
    for (const Quadrangulation& base : test::mesh_family()) {
        const Hierarchy hierarchy = hierarchy_of(base, 2);
        const NodalData data = test::noise_data(hierarchy.mesh(2), 23);
        const ClosedLoop loop = *quantise_within(hierarchy, data, 0.01);
        EXPECT_LE(loop.bound, 0.01);
        EXPECT_LE(error_bound(hierarchy.mesh(2), data, *dequantise(hierarchy, loop.code, 2), 3),
                  loop.bound);
    }
}

TEST(FvsClosedLoop, NamedErrors) {
    const Hierarchy hierarchy = unit_square(2);
    NodalData data = franke_data(hierarchy.mesh(2));
    const auto name = [](const Error& error) {
        return error.message.substr(0, error.message.find(':'));
    };
    const double nan = std::numeric_limits<double>::quiet_NaN();
    for (const double step : {0.0, -1.0, nan}) {
        EXPECT_EQ(name(quantise(hierarchy, data, step).error()), "step_not_positive");
        EXPECT_EQ(name(quantise_within(hierarchy, data, step).error()), "tolerance_not_positive");
    }
    EXPECT_EQ(name(quantise(hierarchy, data, 1, 0).error()), "step_not_positive");
    EXPECT_EQ(name(quantise(hierarchy, data, 1e-12).error()), "step_too_small");
    EXPECT_FALSE(quantise_within(hierarchy, data, 1e-14).ok());
    Quantised code = *quantise(hierarchy, data, 0.01);
    code.step = nan;
    EXPECT_EQ(name(dequantise(hierarchy, code, 2).error()), "step_not_positive");
    code.step = 1e300;
    EXPECT_EQ(name(dequantise(hierarchy, code, 2).error()), "non_finite_data");
    data.dx[3] = nan;
    EXPECT_EQ(name(quantise(hierarchy, data, 0.01).error()), "non_finite_data");
}

}  // namespace
}  // namespace relief::multires::fvs_mesh
