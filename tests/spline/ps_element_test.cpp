#include "relief/spline/ps_element.h"

#include "support.h"

namespace relief::spline {
namespace {

Vec2 point_of(const nlohmann::json& p) {
    return {p[0], p[1]};
}

double random_between(test::Noise& noise, double low, double high) {
    return low + (high - low) * 0.5 * (noise() + 1);
}

PsElement random_element(test::Noise& noise) {
    const TriangleCorners corners = {Vec2{0.3 * noise(), 0.3 * noise()},
                                     Vec2{1 + 0.3 * noise(), 0.3 * noise()},
                                     Vec2{0.5 + 0.5 * noise(), 1 + 0.3 * noise()}};
    const double a = random_between(noise, 0.2, 0.4);
    const double b = random_between(noise, 0.2, 0.4);
    return {corners,
            a * corners[0] + (b * corners[1] + (1 - a - b) * corners[2]),
            {random_between(noise, 0.2, 0.8), random_between(noise, 0.2, 0.8),
             random_between(noise, 0.2, 0.8)}};
}

std::array<TangentPlane, 3> random_planes(test::Noise& noise) {
    std::array<TangentPlane, 3> planes;
    for (TangentPlane& plane : planes) plane = {noise(), {noise(), noise()}};
    return planes;
}

PlaneJet quadratic(Vec2 p) {
    return {1 - 2 * p.x + 0.5 * p.y + p.x * p.x - 0.7 * p.x * p.y + 2 * p.y * p.y,
            {-2 + 2 * p.x - 0.7 * p.y, 0.5 - 0.7 * p.x + 4 * p.y},
            2,
            -0.7,
            4};
}

std::array<TangentPlane, 3> planes_of_quadratic(const PsElement& element) {
    std::array<TangentPlane, 3> planes;
    for (int k = 0; k < 3; ++k) {
        const PlaneJet jet = quadratic(element.centre() + element.corner(k));
        planes[k] = {jet.value, jet.gradient};
    }
    return planes;
}

/// The value of a quadratic net.
double bezier(const QuadraticNet& net, double a, double b) {
    const double c = 1 - a - b;
    return a * a * net[0] + b * b * net[1] + c * c * net[2] + 2 * a * b * net[3] +
           2 * b * c * net[4] + 2 * a * c * net[5];
}

/// The two outer corners of a piece.
std::array<Vec2, 2> outer(const PsElement& e, int piece) {
    const int k = piece / 2;
    if (piece % 2 == 0) return {e.corner(k), e.edge_point(k)};
    return {e.edge_point(k), e.corner((k + 1) % 3)};
}

TEST(PsElement, GoldenOrdinates) {
    const nlohmann::json file = test::reference("powell_sabin.json");
    for (const auto& item : file["cases"]) {
        const auto& mesh = item["mesh"];
        for (std::size_t t = 0; t < item["ordinates"].size(); ++t) {
            TriangleCorners corners;
            std::array<TangentPlane, 3> planes;
            std::array<double, 3> weights;
            for (int k = 0; k < 3; ++k) {
                const std::size_t v = mesh["T"][t][k];
                const std::size_t other = mesh["T"][t][(k + 1) % 3];
                corners[k] = point_of(mesh["V"][v]);
                planes[k] = {item["f"][v], point_of(item["grad"][v])};
                const nlohmann::json edge = {std::min(v, other), std::max(v, other)};
                std::size_t e = 0;
                while (mesh["E"][e] != edge) ++e;
                const double lambda = mesh["lam"][e];
                weights[k] = v < other ? lambda : 1 - lambda;
            }
            const PsElement element(corners, point_of(mesh["Z"][t]), weights);
            const PsOrdinates ordinates = element.ordinates(planes);
            const std::array<double, 3> inverse = element.inverse_ratios();
            for (int k = 0; k < 3; ++k)
                EXPECT_NEAR(inverse[k], item["inv_rho"][t][k].get<double>(), 1e-11);
            for (int piece = 0; piece < 6; ++piece)
                for (int k = 0; k < 6; ++k)
                    EXPECT_NEAR(ordinates.net(piece)[k],
                                item["ordinates"][t][piece][k].get<double>(), 1e-11);
        }
    }
}

TEST(PsElement, PolynomialsHaveTheNets) {
    test::Noise noise(5);
    for (int trial = 0; trial < 50; ++trial) {
        const PsElement element = random_element(noise);
        const PsOrdinates ordinates = element.ordinates(random_planes(noise));
        const PsPolynomials spline = element.polynomials(ordinates);
        for (int piece = 0; piece < 6; ++piece) {
            const auto [p, q] = outer(element, piece);
            const double a = random_between(noise, 0.05, 0.6);
            const double b = random_between(noise, 0.05, 0.35);
            const Vec2 at = a * p + b * q;
            EXPECT_EQ(element.piece_of(at), piece);
            // Roundings of values of size 1 to 10.
            EXPECT_NEAR(spline.jet(piece, at).value, bezier(ordinates.net(piece), a, b), 1e-13);
        }
    }
}

TEST(PsElement, ContinuouslyDifferentiable) {
    test::Noise noise(6);
    for (int trial = 0; trial < 50; ++trial) {
        const PsElement element = random_element(noise);
        const PsPolynomials spline = element.polynomials(random_planes(noise));
        for (int piece = 0; piece < 6; ++piece) {
            const Vec2 on_line = random_between(noise, 0.1, 1) * outer(element, piece)[1];
            const PlaneJet here = spline.jet(piece, on_line);
            const PlaneJet there = spline.jet((piece + 1) % 6, on_line);
            EXPECT_NEAR(here.value, there.value, 1e-12);
            EXPECT_NEAR(here.gradient.x, there.gradient.x, 1e-11);
            EXPECT_NEAR(here.gradient.y, there.gradient.y, 1e-11);
        }
    }
}

TEST(PsElement, TangentPlanesAtCorners) {
    test::Noise noise(8);
    for (int trial = 0; trial < 50; ++trial) {
        const PsElement element = random_element(noise);
        const auto planes = random_planes(noise);
        const PsPolynomials spline = element.polynomials(planes);
        for (int k = 0; k < 3; ++k)
            for (const int piece : {2 * k, (2 * k + 5) % 6}) {
                const PlaneJet jet = spline.jet(piece, element.corner(k));
                EXPECT_NEAR(jet.value, planes[k].value, 1e-12);
                EXPECT_NEAR(jet.gradient.x, planes[k].gradient.x, 1e-11);
                EXPECT_NEAR(jet.gradient.y, planes[k].gradient.y, 1e-11);
            }
    }
}

TEST(PsElement, ReproducesQuadratics) {
    test::Noise noise(9);
    for (int trial = 0; trial < 50; ++trial) {
        const PsElement element = random_element(noise);
        const PsPolynomials spline = element.polynomials(planes_of_quadratic(element));
        for (int piece = 0; piece < 6; ++piece) {
            const auto [p, q] = outer(element, piece);
            const Vec2 at = 0.3 * p + 0.4 * q;
            const PlaneJet expected = quadratic(element.centre() + at);
            const PlaneJet jet = spline.jet(piece, at);
            EXPECT_NEAR(jet.value, expected.value, 1e-12);
            EXPECT_NEAR(jet.gradient.x, expected.gradient.x, 1e-11);
            EXPECT_NEAR(jet.gradient.y, expected.gradient.y, 1e-11);
            EXPECT_NEAR(jet.xx, expected.xx, 1e-8);
            EXPECT_NEAR(jet.xy, expected.xy, 1e-8);
            EXPECT_NEAR(jet.yy, expected.yy, 1e-8);
        }
        const double area = 0.5 * orient(element.corner(0), element.corner(1), element.corner(2));
        const double energy = area * (4 + 2 * 0.49 + 16);
        EXPECT_NEAR(element.thin_plate_energy(spline), energy, 1e-9 * energy);
        EXPECT_LE(element.inner_jump_energy(spline), 1e-10 * energy);
    }
}

TEST(PsElement, DerivativesAreThoseOfTheValue) {
    test::Noise noise(10);
    const double h = 1e-5;
    for (int trial = 0; trial < 20; ++trial) {
        const PsElement element = random_element(noise);
        const PsPolynomials spline = element.polynomials(random_planes(noise));
        for (int piece = 0; piece < 6; ++piece) {
            const auto [p, q] = outer(element, piece);
            const Vec2 at = 0.3 * p + 0.3 * q;
            const PlaneJet jet = spline.jet(piece, at);
            const auto right = spline.jet(piece, at + Vec2{h, 0});
            const auto left = spline.jet(piece, at - Vec2{h, 0});
            const auto up = spline.jet(piece, at + Vec2{0, h});
            const auto down = spline.jet(piece, at - Vec2{0, h});
            // Central differences of quadratics: roundings divided by h.
            EXPECT_NEAR(jet.gradient.x, (right.value - left.value) / (2 * h), 1e-7);
            EXPECT_NEAR(jet.gradient.y, (up.value - down.value) / (2 * h), 1e-7);
            EXPECT_NEAR(jet.xx, (right.gradient.x - left.gradient.x) / (2 * h), 1e-6);
            EXPECT_NEAR(jet.xy, (right.gradient.y - left.gradient.y) / (2 * h), 1e-6);
            EXPECT_NEAR(jet.yy, (up.gradient.y - down.gradient.y) / (2 * h), 1e-6);
        }
    }
}

TEST(PsElement, WeightsGiveTheValue) {
    test::Noise noise(11);
    for (int trial = 0; trial < 30; ++trial) {
        const PsElement element = random_element(noise);
        PsBasis basis;
        for (TangentPlane& plane : basis) plane = {noise(), {noise(), noise()}};
        std::array<double, 9> c;
        std::array<TangentPlane, 3> planes{};
        for (int q = 0; q < 9; ++q) {
            c[q] = noise();
            planes[q / 3].value += c[q] * basis[q].value;
            planes[q / 3].gradient = planes[q / 3].gradient + c[q] * basis[q].gradient;
        }
        const PsPolynomials spline = element.polynomials(planes);
        for (int piece = 0; piece < 6; ++piece) {
            const auto [p, q] = outer(element, piece);
            const Vec2 at = 0.25 * p + 0.6 * q;
            const auto weights = element.weights_at(basis, piece, at);
            double value = 0;
            for (int k = 0; k < 9; ++k) value += weights[k] * c[k];
            EXPECT_NEAR(value, spline.jet(piece, at).value, 1e-13);
        }
    }
}

/// By the rule of seven points, exact for polynomials of degree 5, on each piece.
TEST(PsElement, MatricesAreIntegrals) {
    const double s = std::sqrt(15.0);
    const double near = (6 - s) / 21;
    const double far = (6 + s) / 21;
    struct Node {
        double a, b, weight;
    };
    const std::vector<Node> rule = {
        {1 / 3.0, 1 / 3.0, 9 / 40.0},           {near, near, (155 - s) / 1200},
        {near, 1 - 2 * near, (155 - s) / 1200}, {1 - 2 * near, near, (155 - s) / 1200},
        {far, far, (155 + s) / 1200},           {far, 1 - 2 * far, (155 + s) / 1200},
        {1 - 2 * far, far, (155 + s) / 1200}};
    test::Noise noise(12);
    const PsElement element = random_element(noise);
    const PsMatrix mass = element.mass_matrix(kPsNodalBasis);
    const PsMatrix bending = element.thin_plate_matrix(kPsNodalBasis);
    PsMatrix expected{};
    for (int piece = 0; piece < 6; ++piece) {
        const auto [p, q] = outer(element, piece);
        for (const Node& node : rule) {
            const auto w = element.weights_at(piece, node.a * p + node.b * q);
            for (int i = 0; i < 9; ++i)
                for (int j = 0; j < 9; ++j)
                    expected[9 * i + j] += 0.5 * cross(p, q) * node.weight * w[i] * w[j];
        }
    }
    for (int k = 0; k < 81; ++k) EXPECT_NEAR(mass[k], expected[k], 1e-15);

    const auto planes = random_planes(noise);
    double energy = 0;
    for (int i = 0; i < 9; ++i)
        for (int j = 0; j < 9; ++j) {
            const auto number = [&](int k) {
                const TangentPlane& plane = planes[k / 3];
                return k % 3 == 0 ? plane.value : k % 3 == 1 ? plane.gradient.x : plane.gradient.y;
            };
            energy += bending[9 * i + j] * number(i) * number(j);
        }
    const double direct = element.thin_plate_energy(element.polynomials(planes));
    EXPECT_NEAR(energy, direct, 1e-12 * direct);
}

/// For an edge point at the tangency point of the incircle on both edges of a corner of angle A,
/// rho = cos^2(A / 2).
TEST(PsElement, RatioOfTangencyPoints) {
    const TriangleCorners v = {Vec2{0, 0}, Vec2{2, 0.3}, Vec2{0.7, 1.5}};
    std::array<double, 3> side;
    for (int k = 0; k < 3; ++k) side[k] = length(v[(k + 1) % 3] - v[k]);
    const double around = side[0] + side[1] + side[2];
    Vec2 centre;
    std::array<double, 3> weights;
    for (int k = 0; k < 3; ++k) {
        centre = centre + (side[(k + 1) % 3] / around) * v[k];
        weights[k] = 1 - (around / 2 - side[(k + 1) % 3]) / side[k];
    }
    const auto inverse = PsElement(v, centre, weights).inverse_ratios();
    for (int k = 0; k < 3; ++k) {
        const Vec2 a = unit(v[(k + 1) % 3] - v[k]);
        const Vec2 b = unit(v[(k + 2) % 3] - v[k]);
        EXPECT_NEAR(1 / inverse[k], 0.5 * (1 + dot(a, b)), 1e-12);  // cos^2(A/2)
    }
}

}  // namespace
}  // namespace relief::spline
