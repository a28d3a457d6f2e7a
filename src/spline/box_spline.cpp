#include "relief/spline/box_spline.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "spline/bezier_triangle-inl.h"

namespace relief::spline {

namespace {

/// Numerators over degree!, up to 22! for the Gram mask of order 4.
__extension__ using Wide = __int128;

/// The Bezier net of a continuous spline of compact support: ordinate (a, b) belongs to the point
/// (a, b) / degree, for |a|, |b| <= radius * degree; zero elsewhere.
class Net {
  public:
    Net(int net_degree, int radius)
        : degree(net_degree),
          extent(radius * net_degree),
          side_(2 * extent + 1),
          ordinates_(static_cast<std::size_t>(side_) * side_) {}

    [[nodiscard]] bool contains(int a, int b) const {
        return std::abs(a) <= extent && std::abs(b) <= extent;
    }
    Wide& at(int a, int b) { return ordinates_[index(a, b)]; }
    [[nodiscard]] Wide operator()(int a, int b) const {
        return contains(a, b) ? ordinates_[index(a, b)] : 0;
    }

    int degree;
    int extent;

  private:
    [[nodiscard]] std::size_t index(int a, int b) const {
        return static_cast<std::size_t>(a + extent) * side_ + (b + extent);
    }
    int side_;
    std::vector<Wide> ordinates_;
};

struct Direction {
    int i;
    int j;
};
constexpr Direction kDirections[] = {{1, 0}, {0, 1}, {-1, -1}};

struct CellPoint {
    int cell;
    int fraction;
};
CellPoint split(int a, int degree) {
    const int cell = a >= 0 ? a / degree : -((-a + degree - 1) / degree);
    return {cell, a - cell * degree};
}

/// The spline S with D_e S = M(x) - M(x - e), from M of one degree less. Each small edge of S
/// parallel to e lies in one small triangle of M's net, whose ordinate is degree times the
/// difference along the edge; numerators over degree! absorb the factor. Edges are walked along e
/// from outside the support, where S is zero.
Net integrate(const Net& m, Direction e, int radius) {
    Net s(m.degree + 1, radius);
    const int n = s.degree;
    const int along = e.i + e.j > 0 ? 1 : -1;
    for (int row = -s.extent; row <= s.extent; ++row) {
        for (int col = -s.extent; col <= s.extent; ++col) {
            const int a = along * row;
            const int b = along * col;
            if (!s.contains(a - e.i, b - e.j)) continue;
            const auto [cell_i, fi] = split(std::min(a, a - e.i), n);
            const auto [cell_j, fj] = split(std::min(b, b - e.j), n);
            const int qa = cell_i * (n - 1) + fi - (e.i == 0 && fi > fj);
            const int qb = cell_j * (n - 1) + fj - (e.j == 0 && fj > fi);
            s.at(a, b) =
                s(a - e.i, b - e.j) + m(qa, qb) - m(qa - e.i * (n - 1), qb - e.j * (n - 1));
        }
    }
    return s;
}

/// The net of the centred M_ddd. Partial sums such as M_{d+1,d,d} reach one cell farther than the
/// spline before.
Net box_net(int order) {
    Net net(1, order);
    net.at(0, 0) = 1;
    for (int d = 1; d < order; ++d)
        for (const Direction e : kDirections) net = integrate(net, e, order);
    return net;
}

std::int64_t factorial(int n) {
    return n < 2 ? 1 : n * factorial(n - 1);
}

/// The values of a spline at the lattice points. A product of doubles gives 22! exactly: it has 53
/// significant bits.
std::vector<MaskTap> lattice_values(const Net& net) {
    double denominator = 1;
    for (int k = 2; k <= net.degree; ++k) denominator *= k;
    const int radius = net.extent / net.degree;
    std::vector<MaskTap> mask;
    for (int i = -radius; i <= radius; ++i) {
        for (int j = -radius; j <= radius; ++j) {
            const Wide numerator = net(i * net.degree, j * net.degree);
            if (numerator != 0)
                mask.push_back({i, j, static_cast<double>(numerator) / denominator});
        }
    }
    return mask;
}

/// The ordinates, on the lower triangle of cell (0, 0), of the basis function centred at (i, j).
std::vector<std::int64_t> lower_ordinates(const Net& net, int i, int j) {
    std::vector<std::int64_t> ordinates;
    for (int p = 0; p <= net.degree; ++p)
        for (int t = 0; t <= p; ++t)
            ordinates.push_back(
                static_cast<std::int64_t>(net(p - i * net.degree, t - j * net.degree)));
    return ordinates;
}

BoxSpline derive(int order) {
    const Net net = box_net(order);
    BoxSpline spline{order, net.degree,          factorial(net.degree),
                     {},    lattice_values(net), lattice_values(box_net(2 * order))};
    for (int i = 1 - order; i <= order; ++i) {
        for (int j = 1 - order; j <= order; ++j) {
            std::vector<std::int64_t> numerators = lower_ordinates(net, i, j);
            const bool reaches = std::any_of(numerators.begin(), numerators.end(),
                                             [](std::int64_t n) { return n != 0; });
            if (reaches) spline.reach.push_back({i, j, std::move(numerators)});
        }
    }
    return spline;
}

template <int kOrder>
const BoxSpline& table() {
    static const BoxSpline spline = derive(kOrder);
    return spline;
}

template <int kOrder>
SurfaceJet<double> jet_of_order(double i, double j) {
    const double cell_i = std::floor(i);
    const double cell_j = std::floor(j);
    const double fi = i - cell_i;
    const double fj = j - cell_j;
    const bool upper = fj > fi;
    const double x = std::max(fi, fj);
    const double y = std::min(fi, fj);
    const BoxSpline& spline = table<kOrder>();
    for (const ReachingControl& control : spline.reach) {
        const int ci = upper ? control.j : control.i;
        const int cj = upper ? control.i : control.j;
        if (cell_i != -ci || cell_j != -cj) continue;
        double b[ordinate_count(degree_of(kOrder))];
        std::copy(control.numerators.begin(), control.numerators.end(), b);
        SurfaceJet<double> jet = HWY_NAMESPACE::triangle_jet<degree_of(kOrder)>(
            b, HWY_NAMESPACE::Barycentric<double>{1 - x, x - y, y},
            1 / static_cast<double>(spline.denominator), [](double c) { return c; });
        if (upper) {
            std::swap(jet.di, jet.dj);
            std::swap(jet.dii, jet.djj);
        }
        return jet;
    }
    return {};
}

}  // namespace

const BoxSpline& box_spline(int order) {
    switch (order) {
        case 1:
            return table<1>();
        case 2:
            return table<2>();
        case 3:
            return table<3>();
        default:
            return table<4>();
    }
}

SurfaceJet<double> box_spline_jet(int order, double i, double j) {
    switch (order) {
        case 1:
            return jet_of_order<1>(i, j);
        case 2:
            return jet_of_order<2>(i, j);
        case 3:
            return jet_of_order<3>(i, j);
        default:
            return jet_of_order<4>(i, j);
    }
}

}  // namespace relief::spline
