#include "relief/spline/fvs_element.h"

#include <algorithm>

#include "support.h"

namespace relief::spline {
namespace {

Vec2 point_of(const nlohmann::json& p) {
    return {p[0], p[1]};
}

QuadCorners random_corners(test::Noise& noise) {
    const auto corner = [&](double x, double y) {
        return Vec2{x + 0.24 * noise(), y + 0.24 * noise()};
    };
    return {corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)};
}

/// Includes a parallelogram so skewed that alpha leaves [0, 1].
std::vector<QuadCorners> shapes() {
    test::Noise noise(7);
    std::vector<QuadCorners> list = {{Vec2{0, 0}, {1, 0}, {1, 1}, {0, 1}},
                                     {Vec2{0, 0}, {1, 0}, {6, 1}, {5, 1}},
                                     {Vec2{0, 0}, {3, 0}, {2, 0.5}, {0.2, 0.4}}};
    for (int k = 0; k < 30; ++k) list.push_back(random_corners(noise));
    return list;
}

FvsData random_data(test::Noise& noise) {
    std::array<double, 16> flat;
    for (double& value : flat) value = noise();
    return fvs_data(flat);
}

PlaneJet cubic(Vec2 p) {
    const auto [x, y] = p;
    return {1 - 2 * x + 0.5 * y + x * x - 0.7 * x * y + 2 * y * y + 0.3 * x * x * x -
                0.8 * x * x * y + 0.4 * x * y * y - 0.6 * y * y * y,
            {-2 + 2 * x - 0.7 * y + 0.9 * x * x - 1.6 * x * y + 0.4 * y * y,
             0.5 - 0.7 * x + 4 * y - 0.8 * x * x + 0.8 * x * y - 1.8 * y * y},
            2 + 1.8 * x - 1.6 * y,
            -0.7 - 1.6 * x + 0.8 * y,
            4 + 0.8 * x - 3.6 * y};
}

FvsData data_of_cubic(const QuadCorners& v) {
    FvsData data;
    for (int i = 0; i < 4; ++i) {
        const Vec2 side = v[(i + 1) % 4] - v[i];
        data.value[i] = cubic(v[i]).value;
        data.gradient[i] = cubic(v[i]).gradient;
        data.normal[i] = dot(cubic(midpoint(v[i], v[(i + 1) % 4])).gradient, turned(unit(side)));
    }
    return data;
}

TEST(FvsElement, Golden) {
    const nlohmann::json file = test::reference("fvs_mesh.json");
    ASSERT_EQ(file["fvs_element"].size(), 2u);
    for (const auto& golden : file["fvs_element"]) {
        QuadCorners v;
        FvsData data;
        for (int i = 0; i < 4; ++i) {
            v[i] = point_of(golden["quad"][i]);
            data.value[i] = golden["value"][i];
            data.gradient[i] = point_of(golden["grad"][i]);
            const auto edge = golden["side_edge"][i].get<std::size_t>();
            data.normal[i] =
                golden["side_sign"][i].get<double>() * golden["gamma"][edge].get<double>();
        }
        const FvsElement element(v);
        const Vec2 c = point_of(golden["c"]);
        EXPECT_NEAR(length(element.centre() - c), 0, 1e-13);
        EXPECT_NEAR(element.s(), golden["s"].get<double>(), 1e-13);
        EXPECT_NEAR(element.t(), golden["t"].get<double>(), 1e-13);
        const FvsOrdinates b = element.ordinates(data);
        for (int triangle = 0; triangle < 4; ++triangle)
            for (std::size_t k = 0; k < 10; ++k)
                EXPECT_NEAR(b.net(triangle)[k],
                            golden["nets"][static_cast<std::size_t>(triangle)][k].get<double>(),
                            1e-13);
        for (const auto& expected : golden["points"]) {
            const Vec2 p = point_of(expected["x"]);
            EXPECT_EQ(element.triangle_of(p), expected["triangle"].get<int>());
            const PlaneJet jet = element.jet(b, p);
            EXPECT_NEAR(jet.value, expected["value"].get<double>(), 1e-13);
            EXPECT_NEAR(jet.gradient.x, expected["grad"][0].get<double>(), 1e-12);
            EXPECT_NEAR(jet.gradient.y, expected["grad"][1].get<double>(), 1e-12);
            EXPECT_NEAR(jet.xx, expected["hessian"][0][0].get<double>(), 2e-11);
            EXPECT_NEAR(jet.xy, expected["hessian"][0][1].get<double>(), 2e-11);
            EXPECT_NEAR(jet.yy, expected["hessian"][1][1].get<double>(), 2e-11);
        }
    }
}

TEST(FvsElement, CentreIsTheSameAlongBothDiagonals) {
    test::Noise noise(1);
    for (const QuadCorners& v : shapes()) {
        const FvsElement element(v);
        const FvsOrdinates b = element.ordinates(random_data(noise));
        EXPECT_NEAR(b.centre, (1 - element.t()) * b.ring[1] + element.t() * b.ring[3], 1e-14);
    }
}

TEST(FvsElement, DataComeBackFromOrdinates) {
    test::Noise noise(2);
    for (const QuadCorners& v : shapes()) {
        const FvsElement element(v);
        const FvsData data = random_data(noise);
        const auto expected = fvs_flat(data);
        const auto back = fvs_flat(element.data(element.ordinates(data)));
        // The skewed shapes divide by heights near 0.1.
        for (int k = 0; k < 16; ++k) EXPECT_NEAR(back[k], expected[k], 1e-12);
    }
}

TEST(FvsElement, ReproducesCubics) {
    test::Noise noise(3);
    for (const QuadCorners& v : shapes()) {
        const FvsElement element(v);
        const FvsOrdinates b = element.ordinates(data_of_cubic(v));
        for (int triangle = 0; triangle < 4; ++triangle)
            for (int k = 0; k < 5; ++k) {
                const double s = 0.5 + 0.5 * noise();
                const double t = (1 - s) * (0.5 + 0.5 * noise());
                const Vec2 p = v[triangle] + s * (v[(triangle + 1) % 4] - v[triangle]) +
                               t * (element.centre() - v[triangle]);
                const PlaneJet expected = cubic(p);
                const PlaneJet jet = element.jet(b, triangle, p);
                // Values reach 50, Hessians divide by squared heights near 0.01.
                EXPECT_NEAR(jet.value, expected.value, 1e-12);
                EXPECT_NEAR(length(jet.gradient - expected.gradient), 0, 1e-11);
                EXPECT_NEAR(jet.xx, expected.xx, 1e-9);
                EXPECT_NEAR(jet.xy, expected.xy, 1e-9);
                EXPECT_NEAR(jet.yy, expected.yy, 1e-9);
            }
    }
}

TEST(FvsElement, IsSmoothAcrossItsDiagonals) {
    test::Noise noise(4);
    for (const QuadCorners& v : shapes()) {
        const FvsElement element(v);
        const FvsOrdinates b = element.ordinates(random_data(noise));
        for (int i = 0; i < 4; ++i)
            for (const double t : {0.0, 0.2, 0.5, 0.9, 1.0}) {
                const Vec2 p = v[i] + t * (element.centre() - v[i]);
                const PlaneJet left = element.jet(b, i, p);
                const PlaneJet right = element.jet(b, (i + 3) % 4, p);
                EXPECT_NEAR(left.value, right.value, 1e-13);
                EXPECT_NEAR(length(left.gradient - right.gradient), 0, 1e-12);
            }
    }
}

/// On a side the value is the Hermite cubic and the normal derivative the quadratic through three
/// numbers of that side: what the other side's quad sees too.
TEST(FvsElement, SidesDependOnTheirOwnDataOnly) {
    test::Noise noise(5);
    for (const QuadCorners& v : shapes()) {
        const FvsElement element(v);
        const FvsData data = random_data(noise);
        const FvsOrdinates b = element.ordinates(data);
        for (int i = 0; i < 4; ++i) {
            const int j = (i + 1) % 4;
            const Vec2 side = v[j] - v[i];
            const Vec2 normal = turned(unit(side));
            for (const double t : {0.0, 0.3, 0.5, 0.8, 1.0}) {
                const double u = 1 - t;
                const PlaneJet jet = element.jet(b, i, v[i] + t * side);
                const double value = u * u * (1 + 2 * t) * data.value[i] +
                                     t * t * (1 + 2 * u) * data.value[j] +
                                     u * u * t * dot(data.gradient[i], side) -
                                     u * t * t * dot(data.gradient[j], side);
                const double across = u * (u - t) * dot(data.gradient[i], normal) +
                                      4 * u * t * data.normal[i] +
                                      t * (t - u) * dot(data.gradient[j], normal);
                EXPECT_NEAR(jet.value, value, 1e-13);
                EXPECT_NEAR(dot(jet.gradient, normal), across, 1e-11);
            }
        }
    }
}

TEST(FvsElement, MiddleOfEdgesIsTheSurfaceThere) {
    test::Noise noise(6);
    for (const QuadCorners& v : shapes()) {
        const FvsElement element(v);
        const FvsData data = random_data(noise);
        const FvsOrdinates b = element.ordinates(data);
        for (int i = 0; i < 4; ++i) {
            const int j = (i + 1) % 4;
            const Vec2 side = v[j] - v[i];
            const Vec2 along = unit(side);
            const Vec2 across = turned(along);
            const FvsEdgeMiddle middle = fvs_edge_middle(
                length(side), {data.value[i], data.value[j]},
                {dot(data.gradient[i], along), dot(data.gradient[j], along)},
                {dot(data.gradient[i], across), dot(data.gradient[j], across)}, data.normal[i]);
            const PlaneJet jet = element.jet(b, i, midpoint(v[i], v[j]));
            EXPECT_NEAR(middle.value, jet.value, 1e-13);
            EXPECT_NEAR(middle.tangential, dot(jet.gradient, along), 1e-12);
            for (int half = 0; half < 2; ++half) {
                const Vec2 p = v[i] + (0.25 + 0.5 * half) * side;
                EXPECT_NEAR(middle.half_normals[static_cast<std::size_t>(half)],
                            dot(element.jet(b, i, p).gradient, across), 1e-11);
            }
        }
    }
}

TEST(FvsElement, MiddleOfTheQuadIsTheSurfaceThere) {
    test::Noise noise(8);
    for (const QuadCorners& v : shapes()) {
        const FvsElement element(v);
        const FvsOrdinates b = element.ordinates(random_data(noise));
        const FvsQuadMiddle middle = element.middle(b);
        const Vec2 c = element.centre();
        for (int i = 0; i < 4; ++i) {
            EXPECT_NEAR(middle.value, element.jet(b, i, c).value, 1e-13);
            EXPECT_NEAR(length(middle.gradient - element.jet(b, i, c).gradient), 0, 1e-11);
            const Vec2 m = midpoint(v[i], v[(i + 1) % 4]);
            const Vec2 slope = element.jet(b, i, midpoint(m, c)).gradient;
            EXPECT_NEAR(middle.inner_normals[static_cast<std::size_t>(i)],
                        dot(slope, turned(unit(c - m))), 1e-11);
        }
    }
}

TEST(FvsElement, WeightsAreTheValue) {
    test::Noise noise(9);
    for (const QuadCorners& v : shapes()) {
        const FvsElement element(v);
        const FvsData data = random_data(noise);
        const auto flat = fvs_flat(data);
        const Vec2 p = element.centre() + 0.3 * (v[2] - element.centre());
        const int triangle = element.triangle_of(p);
        const auto weights = element.weights(triangle, p);
        double sum = 0;
        for (std::size_t k = 0; k < 16; ++k) sum += weights[k] * flat[k];
        EXPECT_NEAR(sum, element.jet(element.ordinates(data), p).value, 1e-13);
    }
}

/// The integral over a triangle of a polynomial of degree 6 by the tensor Gauss rule of 4 x 4
/// points under Duffy's map, which is exact up to degree 7 in one and 6 in the other direction.
double energy(const FvsElement& element, const FvsOrdinates& b) {
    constexpr double node[] = {0.33998104358485626, 0.86113631159405258};
    constexpr double weight[] = {0.65214515486254614, 0.34785484513745386};
    double sum = 0;
    for (int i = 0; i < 4; ++i) {
        const Vec2 c = element.centre();
        const Vec2 v = element.corners()[i];
        const Vec2 side = element.corners()[(i + 1) % 4] - v;
        for (int k = 0; k < 16; ++k) {
            const double r = 0.5 + (k & 1 ? -0.5 : 0.5) * node[k >> 1 & 1];
            const double s = 0.5 + (k & 4 ? -0.5 : 0.5) * node[k >> 3 & 1];
            const double w = 0.25 * weight[k >> 1 & 1] * weight[k >> 3 & 1];
            const double value = element.jet(b, i, c + r * (v + s * side - c)).value;
            sum += w * r * cross(side, c - v) * value * value;
        }
    }
    return sum;
}

TEST(FvsElement, MassMatrixIntegratesSquares) {
    test::Noise noise(10);
    for (const QuadCorners& v : shapes()) {
        const FvsElement element(v);
        const FvsData data = random_data(noise);
        const auto flat = fvs_flat(data);
        const auto mass = element.mass_matrix();
        double sum = 0;
        for (std::size_t i = 0; i < 16; ++i)
            for (std::size_t j = 0; j < 16; ++j) sum += mass[16 * i + j] * flat[i] * flat[j];
        const double expected = energy(element, element.ordinates(data));
        EXPECT_NEAR(sum, expected, 1e-13 * std::max(1.0, expected));
    }
    const nlohmann::json diagonal =
        test::reference("fvs_mesh.json")["l2_update"]["mass_coarse_diag"];
    const auto unit = FvsElement(shapes()[0]).mass_matrix();
    for (std::size_t k = 0; k < 16; ++k)
        EXPECT_NEAR(unit[17 * k], diagonal[k].get<double>(), 1e-15);
}

}  // namespace
}  // namespace relief::spline
