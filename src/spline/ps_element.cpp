#include "relief/spline/ps_element.h"

namespace relief::spline {

namespace {

constexpr int next(int k) {
    return k == 2 ? 0 : k + 1;
}
constexpr int before(int k) {
    return k == 0 ? 2 : k - 1;
}

/// Ordinates 200, 020, 002, 110, 011, 101.
constexpr std::array<std::array<int, 3>, 6> kExponents = {
    {{2, 0, 0}, {0, 2, 0}, {0, 0, 2}, {1, 1, 0}, {0, 1, 1}, {1, 0, 1}}};

/// Integrals of products of quadratic Bernstein polynomials over a triangle of area 1: the product
/// of C(a + b, a) over the three exponents, divided by C(4, 2) C(6, 2).
constexpr auto kGram = [] {
    constexpr std::array<std::array<int, 3>, 3> choose = {{{1, 1, 1}, {1, 2, 3}, {1, 3, 6}}};
    std::array<std::array<double, 6>, 6> gram{};
    for (int a = 0; a < 6; ++a)
        for (int b = 0; b < 6; ++b) {
            int product = 1;
            for (int k = 0; k < 3; ++k) product *= choose[kExponents[a][k]][kExponents[b][k]];
            gram[a][b] = product / 90.0;
        }
    return gram;
}();

/// alpha and beta with d = alpha a + beta b.
std::array<double, 2> coordinates(Vec2 d, Vec2 a, Vec2 b) {
    const double area = cross(a, b);
    return {cross(d, b) / area, cross(a, d) / area};
}

double square_norm(const Hessian& h) {
    return h.xx * h.xx + 2 * h.xy * h.xy + h.yy * h.yy;
}

void mirror(PsMatrix& matrix) {
    for (int i = 0; i < 9; ++i)
        for (int j = 0; j < i; ++j) matrix[9 * j + i] = matrix[9 * i + j];
}

}  // namespace

QuadraticNet PsOrdinates::net(int piece) const {
    const int k = piece / 2;
    if (piece % 2 == 0) return {corner[k], edge[k], centre, next[k], spoke[k], inner[k]};
    const int j = spline::next(k);
    return {edge[k], corner[j], centre, previous[j], inner[j], spoke[k]};
}

PsElement::PsElement(const TriangleCorners& corners, Vec2 centre,
                     const std::array<double, 3>& weights)
    : centre_(centre), weight_(weights) {
    for (int k = 0; k < 3; ++k) corner_[k] = corners[k] - centre;
    for (int k = 0; k < 3; ++k)
        edge_point_[k] = weight_[k] * corner_[k] + (1 - weight_[k]) * corner_[next(k)];
    centre_weight_ = barycentric(corner_, {});
}

std::array<double, 3> PsElement::inverse_ratios() const {
    std::array<double, 3> inverse;
    for (int k = 0; k < 3; ++k)
        inverse[k] = centre_weight_[next(k)] / (1 - weight_[k]) +
                     centre_weight_[before(k)] / weight_[before(k)];
    return inverse;
}

PsOrdinates PsElement::ordinates(const std::array<TangentPlane, 3>& planes) const {
    PsOrdinates b;
    for (int k = 0; k < 3; ++k) {
        const TangentPlane& plane = planes[k];
        b.corner[k] = plane.value;
        b.next[k] = plane.at(0.5 * (edge_point_[k] - corner_[k]));
        b.previous[k] = plane.at(0.5 * (edge_point_[before(k)] - corner_[k]));
        b.inner[k] = plane.at(-0.5 * corner_[k]);
    }
    for (int k = 0; k < 3; ++k) {
        const int j = next(k);
        b.edge[k] = weight_[k] * b.next[k] + (1 - weight_[k]) * b.previous[j];
        b.spoke[k] = weight_[k] * b.inner[k] + (1 - weight_[k]) * b.inner[j];
        b.centre += centre_weight_[k] * b.inner[k];
    }
    return b;
}

PsElement::Pair PsElement::piece_corners(int piece) const {
    const int k = piece / 2;
    return piece % 2 == 0 ? Pair{corner_[k], edge_point_[k]}
                          : Pair{edge_point_[k], corner_[next(k)]};
}

Hessian PsElement::hessian(int piece, const QuadraticNet& net) const {
    const auto [a, b] = piece_corners(piece);
    const double area = cross(a, b);
    const Vec2 along_a{b.y / area, -b.x / area};  // gradients of the barycentric coordinates
    const Vec2 along_b{-a.y / area, a.x / area};
    const double aa = 2 * ((net[0] - net[5]) - (net[5] - net[2]));
    const double ab = 2 * ((net[3] - net[5]) - (net[4] - net[2]));
    const double bb = 2 * ((net[1] - net[4]) - (net[4] - net[2]));
    const Vec2 image_a = aa * along_a + ab * along_b;
    const Vec2 image_b = ab * along_a + bb * along_b;
    return {along_a.x * image_a.x + along_b.x * image_b.x,
            along_a.x * image_a.y + along_b.x * image_b.y,
            along_a.y * image_a.y + along_b.y * image_b.y};
}

PsPolynomials PsElement::polynomials(const PsOrdinates& ordinates) const {
    PsPolynomials spline;
    spline.value = ordinates.centre;
    const Vec2 side1 = corner_[1] - corner_[0];
    const Vec2 side2 = corner_[2] - corner_[0];
    const double rise1 = 2 * (ordinates.inner[1] - ordinates.inner[0]);
    const double rise2 = 2 * (ordinates.inner[2] - ordinates.inner[0]);
    const double area = cross(side1, side2);
    spline.gradient = {(rise1 * side2.y - rise2 * side1.y) / area,
                       (rise2 * side1.x - rise1 * side2.x) / area};
    for (int piece = 0; piece < 6; ++piece)
        spline.hessian[piece] = hessian(piece, ordinates.net(piece));
    return spline;
}

int PsElement::piece_of(Vec2 d) const {
    int left = 0;
    for (int k = 0; k < 3; ++k) left += cross(corner_[k], d) >= 0 ? 1 << k : 0;
    const int k = kPsSector[left];
    return 2 * k + (cross(edge_point_[k], d) >= 0 ? 1 : 0);
}

std::array<double, 9> PsElement::weights_at(int piece, Vec2 d) const {
    const auto [a, b] = piece_corners(piece);
    const auto [alpha, beta] = coordinates(d, a, b);
    const double gamma = 1 - alpha - beta;
    const int k = piece / 2;
    const int j = next(k);
    // The weights of the ordinates of the three corners: at the corner, beside it on the piece's
    // edge, and towards Z. Those at R_k, between R_k and Z, and at Z are means of others.
    const bool first = piece % 2 == 0;
    const double at_corner = first ? alpha * alpha : beta * beta;
    const double beside = 2 * alpha * beta;
    const double at_edge = first ? beta * beta : alpha * alpha;
    const double at_spoke = first ? 2 * beta * gamma : 2 * alpha * gamma;
    const double at_inner = first ? 2 * alpha * gamma : 2 * beta * gamma;
    std::array<double, 3> inner;
    for (int i = 0; i < 3; ++i) inner[i] = gamma * gamma * centre_weight_[i];
    inner[k] += weight_[k] * at_spoke + (first ? at_inner : 0);
    inner[j] += (1 - weight_[k]) * at_spoke + (first ? 0 : at_inner);
    std::array<double, 3> edge{};  // of u_k and v_j
    edge[k] = weight_[k] * at_edge + (first ? beside : 0);
    edge[j] = (1 - weight_[k]) * at_edge + (first ? 0 : beside);
    std::array<double, 9> weights;
    for (int i = 0; i < 3; ++i) {
        const Vec2 slope =
            (0.5 * edge[i]) * (edge_point_[k] - corner_[i]) - (0.5 * inner[i]) * corner_[i];
        weights[3 * i] = edge[i] + inner[i];
        weights[3 * i + 1] = slope.x;
        weights[3 * i + 2] = slope.y;
    }
    weights[first ? 3 * k : 3 * j] += at_corner;
    return weights;
}

std::array<double, 9> PsElement::weights_at(const PsBasis& basis, int piece, Vec2 d) const {
    const std::array<double, 9> nodal = weights_at(piece, d);
    std::array<double, 9> weights;
    for (int q = 0; q < 9; ++q) {
        const double* corner = nodal.data() + q / 3 * 3;
        weights[q] = corner[0] * basis[q].value +
                     (corner[1] * basis[q].gradient.x + corner[2] * basis[q].gradient.y);
    }
    return weights;
}

std::array<PsOrdinates, 9> PsElement::basis_ordinates(const PsBasis& basis) const {
    std::array<PsOrdinates, 9> functions;
    for (int q = 0; q < 9; ++q) {
        std::array<TangentPlane, 3> planes{};
        planes[q / 3] = basis[q];
        functions[q] = ordinates(planes);
    }
    return functions;
}

PsMatrix PsElement::mass_matrix(const PsBasis& basis) const {
    const std::array<PsOrdinates, 9> functions = basis_ordinates(basis);
    PsMatrix mass{};
    for (int piece = 0; piece < 6; ++piece) {
        const auto [a, b] = piece_corners(piece);
        const double area = 0.5 * cross(a, b);
        std::array<QuadraticNet, 9> nets;
        for (int q = 0; q < 9; ++q) nets[q] = functions[q].net(piece);
        for (int i = 0; i < 9; ++i) {
            QuadraticNet image{};  // area * Gram * net i
            for (int p = 0; p < 6; ++p)
                for (int q = 0; q < 6; ++q) image[p] += area * kGram[p][q] * nets[i][q];
            for (int j = 0; j <= i; ++j)
                for (int p = 0; p < 6; ++p) mass[9 * i + j] += image[p] * nets[j][p];
        }
    }
    mirror(mass);
    return mass;
}

PsMatrix PsElement::thin_plate_matrix(const PsBasis& basis) const {
    const std::array<PsOrdinates, 9> functions = basis_ordinates(basis);
    PsMatrix matrix{};
    for (int piece = 0; piece < 6; ++piece) {
        const auto [a, b] = piece_corners(piece);
        const double area = 0.5 * cross(a, b);
        std::array<Hessian, 9> h;
        for (int q = 0; q < 9; ++q) h[q] = hessian(piece, functions[q].net(piece));
        for (int i = 0; i < 9; ++i)
            for (int j = 0; j <= i; ++j)
                matrix[9 * i + j] +=
                    area * (h[i].xx * h[j].xx + 2 * h[i].xy * h[j].xy + h[i].yy * h[j].yy);
    }
    mirror(matrix);
    return matrix;
}

double PsElement::thin_plate_energy(const PsPolynomials& spline) const {
    double energy = 0;
    for (int piece = 0; piece < 6; ++piece) {
        const auto [a, b] = piece_corners(piece);
        energy += 0.5 * cross(a, b) * square_norm(spline.hessian[piece]);
    }
    return energy;
}

double PsElement::inner_jump_energy(const PsPolynomials& spline) const {
    double energy = 0;
    for (int k = 0; k < 3; ++k) {
        energy += jump_energy({}, edge_point_[k], spline.hessian[2 * k], spline.hessian[2 * k + 1]);
        energy +=
            jump_energy({}, corner_[k], spline.hessian[2 * before(k) + 1], spline.hessian[2 * k]);
    }
    return energy;
}

double jump_energy(Vec2 a, Vec2 b, const Hessian& h1, const Hessian& h2) {
    const Vec2 normal = turned(b - a);  // as long as the segment
    const double square = dot(normal, normal);
    const double jump = (h1.xx - h2.xx) * normal.x * normal.x +
                        2 * (h1.xy - h2.xy) * normal.x * normal.y +
                        (h1.yy - h2.yy) * normal.y * normal.y;
    return jump * jump / square;
}

}  // namespace relief::spline
