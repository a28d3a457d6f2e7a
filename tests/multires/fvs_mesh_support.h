#pragma once

#include <cmath>

#include "mesh/meshes.h"
#include "multires/fvs_functionals.h"
#include "relief/multires/fvs_mesh.h"

namespace relief::test {

using multires::fvs_mesh::Decomposition;
using multires::fvs_mesh::Details;
using multires::fvs_mesh::Hierarchy;
using multires::fvs_mesh::NodalData;

inline const nlohmann::json& fvs_golden() {
    static const nlohmann::json file = reference("fvs_mesh.json");
    return file;
}

inline Hierarchy hierarchy_of(mesh::Quadrangulation base, int levels) {
    auto result = Hierarchy::create(std::move(base), levels);
    EXPECT_TRUE(result.ok());
    return *std::move(result);
}
inline Hierarchy unit_square(int levels) {
    return hierarchy_of(built(grid_mesh(1, 1)), levels);
}

inline NodalData noise_data(const mesh::Quadrangulation& mesh, std::uint64_t seed) {
    NodalData data = multires::fvs_mesh::make_nodal<double>(mesh);
    Noise noise(seed);
    multires::fvs_mesh::for_each_nodal(
        [&](std::vector<double>& numbers) {
            for (double& number : numbers) number = noise();
        },
        data);
    return data;
}

inline double largest_difference(const NodalData& a, const NodalData& b) {
    double most = 0;
    multires::fvs_mesh::for_each_nodal(
        [&](const std::vector<double>& x, const std::vector<double>& y) {
            if (x.size() != y.size()) most = INFINITY;
            for (std::size_t k = 0; k < x.size() && k < y.size(); ++k)
                most = std::max(most, std::abs(x[k] - y[k]));
        },
        a, b);
    return most;
}

inline double largest_detail(const Decomposition& coefficients) {
    double most = 0;
    for (const Details<double>& level : coefficients.details)
        multires::fvs_mesh::for_each_detail(
            [&](const std::vector<double>& numbers) {
                for (const double number : numbers) most = std::max(most, std::abs(number));
            },
            level);
    return most;
}

/// amplitude * exp(-a (x - x0)^2 - b (y - y0)^2), and the first derivatives.
inline spline::PlaneJet bump(Vec2 p, double amplitude, double a, double x0, double b, double y0) {
    const double value =
        amplitude * std::exp(-a * (p.x - x0) * (p.x - x0) - b * (p.y - y0) * (p.y - y0));
    return {value, {-2 * a * (p.x - x0) * value, -2 * b * (p.y - y0) * value}};
}

/// Franke's function; `squared` has (9y + 1)^2 in the second term.
inline spline::PlaneJet franke(Vec2 p, bool squared = false) {
    spline::PlaneJet sum;
    const double wide = std::exp(-(9 * p.y + 1) / 10);
    spline::PlaneJet second = bump(p, 0.75, 81.0 / 49, -1.0 / 9, squared ? 8.1 : 0, -1.0 / 9);
    if (!squared) {
        second.gradient = {wide * second.gradient.x, -0.9 * wide * second.value};
        second.value *= wide;
    }
    for (const spline::PlaneJet& term : {bump(p, 0.75, 81.0 / 4, 2.0 / 9, 81.0 / 4, 2.0 / 9),
                                         second, bump(p, 0.5, 81.0 / 4, 7.0 / 9, 81.0 / 4, 1.0 / 3),
                                         bump(p, -0.2, 81, 4.0 / 9, 81, 7.0 / 9)}) {
        sum.value += term.value;
        sum.gradient = sum.gradient + term.gradient;
    }
    return sum;
}

/// The paper's second function: a smooth hill on a disc.
inline spline::PlaneJet hill(Vec2 p) {
    constexpr double R = 1.0 / 128;
    const Vec2 d = p - Vec2{0.5, 0.5};
    const double rest = R - dot(d, d);
    if (rest <= 0) return {};
    const double value = std::exp(-R / rest);
    return {value, (-2 * R * value / (rest * rest)) * d};
}

/// n x n points over the unit square, border included.
inline std::vector<Vec2> square_points(int n) {
    std::vector<Vec2> points;
    for (int r = 0; r < n; ++r)
        for (int c = 0; c < n; ++c)
            points.push_back({static_cast<double>(c) / (n - 1), static_cast<double>(r) / (n - 1)});
    return points;
}

inline std::vector<spline::PlaneJet> jets(const Hierarchy& hierarchy, int level,
                                          const NodalData& data, const std::vector<Vec2>& points) {
    std::vector<spline::PlaneJet> out(points.size());
    const Status status = multires::fvs_mesh::evaluate(hierarchy, level, data, points, out);
    EXPECT_TRUE(status.ok()) << (status.ok() ? "" : status.error().text());
    return out;
}

/// Points of a mesh, away from its edges: three in every triangle of every quad.
inline std::vector<Vec2> inner_points(const mesh::Quadrangulation& mesh) {
    std::vector<Vec2> points;
    for (mesh::Index q = 0; q < mesh.quad_count(); ++q) {
        const QuadCorners v = mesh.corners(q);
        const Vec2 c = diagonals(v).centre;
        for (int i = 0; i < 4; ++i)
            for (const auto& [s, t] : {std::pair{0.21, 0.33}, {0.55, 0.24}, {0.13, 0.71}})
                points.push_back(mesh.origin + v[i] + s * (v[(i + 1) % 4] - v[i]) + t * (c - v[i]));
    }
    return points;
}

}  // namespace relief::test
