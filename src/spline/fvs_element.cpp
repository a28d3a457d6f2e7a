#include "relief/spline/fvs_element.h"

namespace relief::spline {

namespace {

constexpr int next(int i) {
    return (i + 1) % 4;
}

/// Exponents of the ordinates of a cubic net.
constexpr std::array<std::array<int, 3>, 10> kExponents = {{{3, 0, 0},
                                                            {2, 1, 0},
                                                            {2, 0, 1},
                                                            {1, 2, 0},
                                                            {1, 1, 1},
                                                            {1, 0, 2},
                                                            {0, 3, 0},
                                                            {0, 2, 1},
                                                            {0, 1, 2},
                                                            {0, 0, 3}}};

constexpr int ordinate_index(int second, int third) {
    const int p = second + third;
    return p * (p + 1) / 2 + third;
}

/// [k][l][m]: the ordinate of exponents e_k + e_l + e_m, which is what a step of de Casteljau's
/// algorithm along each of three corners multiplies.
constexpr auto kStep = [] {
    std::array<std::array<std::array<int, 3>, 3>, 3> table{};
    for (int k = 0; k < 3; ++k)
        for (int l = 0; l < 3; ++l)
            for (int m = 0; m < 3; ++m)
                table[k][l][m] =
                    ordinate_index((k == 1) + (l == 1) + (m == 1), (k == 2) + (l == 2) + (m == 2));
    return table;
}();

constexpr int factorial(int n) {
    return n < 2 ? 1 : n * factorial(n - 1);
}

constexpr int multinomial(int ordinate) {
    int product = 1;
    for (const int exponent : kExponents[ordinate]) product *= factorial(exponent);
    return 6 / product;
}

/// Integrals of products of cubic Bernstein polynomials over a triangle of area 1.
constexpr auto kGram = [] {
    std::array<std::array<double, 10>, 10> gram{};
    for (int a = 0; a < 10; ++a)
        for (int b = 0; b < 10; ++b) {
            int numerator = 2 * multinomial(a) * multinomial(b);
            for (int k = 0; k < 3; ++k) numerator *= factorial(kExponents[a][k] + kExponents[b][k]);
            gram[a][b] = static_cast<double>(numerator) / factorial(8);
        }
    return gram;
}();

/// g with g . a = ga and g . b = gb.
Vec2 solve(Vec2 a, double ga, Vec2 b, double gb) {
    const double determinant = cross(a, b);
    return {(ga * b.y - gb * a.y) / determinant, (gb * a.x - ga * b.x) / determinant};
}

/// The three values of the linear polynomial that two steps of de Casteljau's algorithm leave, for
/// each pair of steps: [k][l] = sum over m of lambda_m c(e_k + e_l + e_m).
using SecondSteps = std::array<std::array<double, 3>, 3>;
SecondSteps second_steps(const CubicNet& net, const std::array<double, 3>& lambda) {
    SecondSteps steps;
    for (int k = 0; k < 3; ++k)
        for (int l = 0; l <= k; ++l) {
            const auto& index = kStep[k][l];
            steps[k][l] = steps[l][k] =
                lambda[0] * net[index[0]] + lambda[1] * net[index[1]] + lambda[2] * net[index[2]];
        }
    return steps;
}

std::array<double, 3> first_steps(const SecondSteps& second, const std::array<double, 3>& lambda) {
    std::array<double, 3> steps;
    for (int k = 0; k < 3; ++k)
        steps[k] = lambda[0] * second[k][0] + lambda[1] * second[k][1] + lambda[2] * second[k][2];
    return steps;
}

Vec2 gradient_of(const std::array<double, 3>& steps, const std::array<Vec2, 3>& gradients) {
    return 3 * (steps[0] * gradients[0] + steps[1] * gradients[1] + steps[2] * gradients[2]);
}

}  // namespace

CubicNet FvsOrdinates::net(int i) const {
    const int j = next(i);
    return {corner[i], side[i][0], spoke[i], side[i][1], inner[i],
            ring[i],   corner[j],  spoke[j], ring[j],    centre};
}

FvsElement::FvsElement(const QuadCorners& v) : v_(v), diagonals_(diagonals(v)) {
    for (int i = 0; i < 4; ++i) {
        const Vec2 side = v[next(i)] - v[i];
        const double side_length = length(side);
        const Vec2 along{side.x / side_length, side.y / side_length};
        const Vec2 to_centre = diagonals_.centre - v[i];
        normal_[i] = turned(along);
        along_[i] = dot(to_centre, along) / side_length;
        height_[i] = dot(to_centre, normal_[i]);
    }
}

FvsOrdinates FvsElement::ordinates(const FvsData& data) const {
    FvsOrdinates b;
    b.corner = data.value;
    for (int i = 0; i < 4; ++i) {
        const int j = next(i);
        const Vec2 side = v_[j] - v_[i];
        b.side[i] = {data.value[i] + dot(data.gradient[i], side) / 3,
                     data.value[j] - dot(data.gradient[j], side) / 3};
        b.spoke[i] = data.value[i] + dot(data.gradient[i], diagonals_.centre - v_[i]) / 3;
        b.inner[i] = (1 - along_[i]) * b.side[i][0] + along_[i] * b.side[i][1] +
                     height_[i] / 6 *
                         (4 * data.normal[i] - dot(data.gradient[i], normal_[i]) -
                          dot(data.gradient[j], normal_[i]));
    }
    const double s = diagonals_.s;
    const double t = diagonals_.t;
    b.ring = {(1 - t) * b.inner[0] + t * b.inner[3], (1 - s) * b.inner[0] + s * b.inner[1],
              (1 - t) * b.inner[1] + t * b.inner[2], (1 - s) * b.inner[3] + s * b.inner[2]};
    b.centre = (1 - s) * b.ring[0] + s * b.ring[2];
    return b;
}

FvsData FvsElement::data(const FvsOrdinates& b) const {
    FvsData data;
    data.value = b.corner;
    for (int i = 0; i < 4; ++i)
        data.gradient[i] = solve(v_[next(i)] - v_[i], 3 * (b.side[i][0] - b.corner[i]),
                                 diagonals_.centre - v_[i], 3 * (b.spoke[i] - b.corner[i]));
    for (int i = 0; i < 4; ++i) {
        const double across =
            b.inner[i] - (1 - along_[i]) * b.side[i][0] - along_[i] * b.side[i][1];
        data.normal[i] = (6 / height_[i] * across + dot(data.gradient[i], normal_[i]) +
                          dot(data.gradient[next(i)], normal_[i])) /
                         4;
    }
    return data;
}

int FvsElement::triangle_of(Vec2 point) const {
    const double a = cross(v_[2] - v_[0], point - v_[0]);
    const double b = cross(v_[3] - v_[1], point - v_[1]);
    if (a <= 0) return b >= 0 ? 0 : 1;
    return b <= 0 ? 2 : 3;
}

std::array<Vec2, 3> FvsElement::barycentric_gradients(int triangle) const {
    const Vec2 a = v_[triangle];
    const Vec2 b = v_[next(triangle)];
    const Vec2 c = diagonals_.centre;
    const double inverse = 1 / cross(b - a, c - a);
    return {inverse * turned(c - b), inverse * turned(a - c), inverse * turned(b - a)};
}

FvsElement::Barycentric FvsElement::barycentric(int triangle, Vec2 point) const {
    const Vec2 a = v_[triangle];
    const Vec2 b = v_[next(triangle)];
    const Vec2 c = diagonals_.centre;
    const double area = cross(b - a, c - a);
    return {cross(c - b, point - b) / area, cross(a - c, point - c) / area,
            cross(b - a, point - a) / area};
}

PlaneJet FvsElement::jet(const FvsOrdinates& ordinates, int triangle, Vec2 point) const {
    const Barycentric lambda = barycentric(triangle, point);
    const std::array<Vec2, 3> gradients = barycentric_gradients(triangle);
    const SecondSteps second = second_steps(ordinates.net(triangle), lambda);
    const std::array<double, 3> first = first_steps(second, lambda);
    PlaneJet jet;
    jet.value = lambda[0] * first[0] + lambda[1] * first[1] + lambda[2] * first[2];
    jet.gradient = gradient_of(first, gradients);
    for (int k = 0; k < 3; ++k)
        for (int l = 0; l < 3; ++l) {
            jet.xx += 6 * second[k][l] * gradients[k].x * gradients[l].x;
            jet.xy += 6 * second[k][l] * gradients[k].x * gradients[l].y;
            jet.yy += 6 * second[k][l] * gradients[k].y * gradients[l].y;
        }
    return jet;
}

FvsEdgeMiddle fvs_edge_middle(double length, const std::array<double, 2>& value,
                              const std::array<double, 2>& tangential,
                              const std::array<double, 2>& normal, double middle_normal) {
    return {0.5 * (value[0] + value[1]) + length / 8 * (tangential[0] - tangential[1]),
            1.5 * (value[1] - value[0]) / length - 0.25 * (tangential[0] + tangential[1]),
            {0.375 * normal[0] + 0.75 * middle_normal - 0.125 * normal[1],
             -0.125 * normal[0] + 0.75 * middle_normal + 0.375 * normal[1]}};
}

FvsQuadMiddle FvsElement::middle(const FvsOrdinates& b) const {
    constexpr Barycentric kInnerEdge = {0.25, 0.25, 0.5};
    FvsQuadMiddle middle;
    const Vec2 c = diagonals_.centre;
    middle.value = b.centre;
    middle.gradient =
        solve(v_[0] - c, 3 * (b.ring[0] - b.centre), v_[1] - c, 3 * (b.ring[1] - b.centre));
    for (int i = 0; i < 4; ++i) {
        const Vec2 across = turned(unit(c - midpoint(v_[i], v_[next(i)])));
        const auto first = first_steps(second_steps(b.net(i), kInnerEdge), kInnerEdge);
        middle.inner_normals[i] = dot(across, gradient_of(first, barycentric_gradients(i)));
    }
    return middle;
}

std::array<double, 16> fvs_flat(const FvsData& data) {
    std::array<double, 16> flat;
    for (int i = 0; i < 4; ++i) {
        flat[3 * i] = data.value[i];
        flat[3 * i + 1] = data.gradient[i].x;
        flat[3 * i + 2] = data.gradient[i].y;
        flat[12 + i] = data.normal[i];
    }
    return flat;
}

FvsData fvs_data(const std::array<double, 16>& flat) {
    FvsData data;
    for (int i = 0; i < 4; ++i) {
        data.value[i] = flat[3 * i];
        data.gradient[i] = {flat[3 * i + 1], flat[3 * i + 2]};
        data.normal[i] = flat[12 + i];
    }
    return data;
}

std::array<CubicNet, 16> FvsElement::basis_nets(int triangle) const {
    std::array<CubicNet, 16> nets;
    for (int k = 0; k < 16; ++k) {
        std::array<double, 16> flat{};
        flat[k] = 1;
        nets[k] = ordinates(fvs_data(flat)).net(triangle);
    }
    return nets;
}

std::array<double, 16> FvsElement::weights(int triangle, Vec2 point) const {
    const Barycentric lambda = barycentric(triangle, point);
    const std::array<CubicNet, 16> nets = basis_nets(triangle);
    std::array<double, 16> weights;
    for (int k = 0; k < 16; ++k) {
        const auto first = first_steps(second_steps(nets[k], lambda), lambda);
        weights[k] = lambda[0] * first[0] + lambda[1] * first[1] + lambda[2] * first[2];
    }
    return weights;
}

std::array<double, 256> FvsElement::mass_matrix() const {
    std::array<double, 256> mass{};
    for (int triangle = 0; triangle < 4; ++triangle) {
        const double area =
            0.5 * cross(v_[next(triangle)] - v_[triangle], diagonals_.centre - v_[triangle]);
        const std::array<CubicNet, 16> nets = basis_nets(triangle);
        for (int i = 0; i < 16; ++i) {
            CubicNet image{};  // area * Gram * net i
            for (int a = 0; a < 10; ++a)
                for (int b = 0; b < 10; ++b) image[a] += area * kGram[a][b] * nets[i][b];
            for (int j = 0; j <= i; ++j)
                for (int a = 0; a < 10; ++a) mass[16 * i + j] += image[a] * nets[j][a];
        }
    }
    for (int i = 0; i < 16; ++i)
        for (int j = 0; j < i; ++j) mass[16 * j + i] = mass[16 * i + j];
    return mass;
}

}  // namespace relief::spline
