#include <fmt/format.h>

#include <Eigen/Dense>
#include <array>
#include <cmath>

#include "relief/codec/fill.h"
#include "relief/codec/oracle.h"
#include "relief/multires/barycentric.h"
#include "relief/multires/edit.h"
#include "relief/multires/filters.h"
#include "relief/spline/box_spline.h"
#include "relief/spline/lattice_filters.h"
#include "reproduce.h"

namespace relief::reproduce {

namespace {

using multires::DataMap;
using multires::Family;
using multires::FilterBank;
using multires::SchemeId;
using multires::SchemeSpec;

constexpr const char* kSource = "barycentric (Dreger, Gross, Schlegel 1999)";

SchemeSpec spec_of(SchemeId id, int order, Family family, int levels) {
    return {id, order, family, 0, levels, DataMap::Coefficients};
}

// --- storage
// ----------------------------------------------------------------------------------------------------

void storage(Rows& rows) {
    rows.add("section 5, figure 15", "storage of 3 levels, % of the samples", 231,
             100 * (7.0 / 3 - 4.0 / 3 * std::pow(0.25, 3)));
    const auto layout =
        multires::layout(spec_of(SchemeId::Barycentric, 1, Family::Compact, 3), 4096, 4096, 1);
    rows.add("section 5, figure 15", "the same, 4096 x 4096 with borders", 231,
             100.0 * static_cast<double>(layout->coefficients()) / (4096.0 * 4096.0));
    rows.add("section 3.4", "limit of the storage, samples", 7.0 / 3,
             7.0 / 3 - 4.0 / 3 * std::pow(0.25, 26), "printed as 2/3; erratum E19: 2 1/3 is meant");
}

// --- linear dependence
// ------------------------------------------------------------------------------------------

/// Columns: the 8 synthesis kernels; rows: the lattice points where any of them has a tap.
Eigen::MatrixXd basis_matrix(const FilterBank& bank) {
    constexpr int reach = 12;
    std::vector<std::array<double, 8>> taps;
    for (int i = -reach; i <= reach; ++i)
        for (int j = -reach; j <= reach; ++j) {
            std::array<double, 8> row{};
            bool any = false;
            for (int c = 0; c < 8; ++c) {
                row[static_cast<std::size_t>(c)] = multires::synthesis_kernel(bank, c)(i, j);
                any = any || row[static_cast<std::size_t>(c)] != 0;
            }
            if (any) taps.push_back(row);
        }
    Eigen::MatrixXd matrix(static_cast<Eigen::Index>(taps.size()), 8);
    for (Eigen::Index r = 0; r < matrix.rows(); ++r)
        for (Eigen::Index c = 0; c < 8; ++c)
            matrix(r, c) = taps[static_cast<std::size_t>(r)][static_cast<std::size_t>(c)];
    return matrix;
}

void matrix_21(Rows& rows) {
    constexpr int points[7][2] = {{0, 0}, {-1, -1}, {-1, 0}, {0, 1}, {1, 1}, {1, 0}, {0, -1}};
    constexpr int printed[7][8] = {{2, 0, 0, 0, 2, 2, 2, 0},     {1, -1, 1, 1, -1, -1, 1, -1},
                                   {1, -1, -1, 1, 1, -1, -1, 1}, {1, 1, -1, 1, -1, 1, -1, -1},
                                   {1, 1, -1, -1, -1, -1, 1, 1}, {1, 1, 1, -1, 1, -1, -1, -1},
                                   {1, -1, 1, -1, -1, 1, -1, 1}};
    const FilterBank haar = *multires::filter_bank(1, Family::Compact, 1);
    int equal = 0;
    for (int r = 0; r < 7; ++r)
        for (int c = 0; c < 8; ++c)
            equal += multires::synthesis_kernel(haar, c)(points[r][0], points[r][1]) ==
                     0.5 * printed[r][c];
    rows.add("equation (21)", "entries of B_L that agree, of 56", 56, equal);
}

void nullspaces(Rows& rows) {
    const Eigen::MatrixXd linear = basis_matrix(*multires::filter_bank(1, Family::Compact, 1));
    Eigen::FullPivLU<Eigen::MatrixXd> linear_lu(linear);
    rows.add("equation (22)", "dimension of the nullspace of B_L", 1,
             static_cast<double>(linear_lu.dimensionOfKernel()));
    Eigen::VectorXd kernel = linear_lu.kernel().col(0);
    kernel /= kernel(1);
    constexpr int printed[8] = {0, 1, 1, 1, 0, 0, 0, 1};
    for (int c = 0; c < 8; ++c)
        rows.add("equation (22)", fmt::format("null vector, entry {}", c), printed[c],
                 std::abs(kernel(c)) < 1e-14 ? 0 : kernel(c));
    for (const auto& [family, name] :
         {std::pair{Family::SemiOrthogonal, "Chui-Wang"}, {Family::Compact, "compact (2,2)"}}) {
        Eigen::FullPivLU<Eigen::MatrixXd> lu(basis_matrix(*multires::filter_bank(2, family, 0)));
        rows.add("equation (23)", fmt::format("dimension of the nullspace of B_Q, {}", name), 0,
                 static_cast<double>(lu.dimensionOfKernel()));
    }
}

// --- smoothness and support
// -------------------------------------------------------------------------------------

/// The highest k such that all derivatives up to k agree on both sides of the lattice edges.
int continuity(int order) {
    constexpr double h = 1e-6;
    int smooth = -1;
    for (int k = 0; k <= 2; ++k) {
        double jump = 0;
        for (const double t : {0.13, 0.37, 0.71})
            for (const auto& [i, j, ni, nj] : {std::array{0.0, t, 1.0, 0.0},
                                               {t, 0.0, 0.0, 1.0},
                                               {t, t, 1.0, -1.0},
                                               {1.0, t, 1.0, 0.0}}) {
                const auto a = spline::box_spline_jet(order, i + h * ni, j + h * nj);
                const auto b = spline::box_spline_jet(order, i - h * ni, j - h * nj);
                const double jumps[3] = {std::abs(a.value - b.value),
                                         std::max(std::abs(a.di - b.di), std::abs(a.dj - b.dj)),
                                         std::max({std::abs(a.dii - b.dii), std::abs(a.dij - b.dij),
                                                   std::abs(a.djj - b.djj)})};
                jump = std::max(jump, jumps[k]);
            }
        if (jump > 100 * h) break;
        smooth = k;
    }
    return smooth;
}

void smoothness(Rows& rows) {
    rows.add("sections 2.2, 2.6", "continuity of linear bases", 0, continuity(1));
    rows.add("sections 2.2, 2.6", "continuity of quartic bases", 2, continuity(2));
    rows.add("section 2.6", "polynomial degree of Haar's projection", 1,
             spline::box_spline(1).degree);
    rows.add("section 2.6", "polynomial degree of linear B-splines' projection", 4,
             spline::box_spline(2).degree);
}

void supports(Rows& rows) {
    constexpr int expected[2][3] = {{7, 37, 169}, {37, 169, 721}};
    for (int order = 1; order <= 2; ++order)
        for (int level = 1; level <= 3; ++level) {
            SchemeSpec spec = spec_of(SchemeId::Barycentric, order, Family::Compact, 3);
            spec.data_map = DataMap::Interpolate;
            const auto layout = multires::layout(spec, 97, 97, 1);
            const multires::Move move{level, 48 >> level, 48 >> level, {1}};
            const auto change = multires::samples_of(
                *layout, multires::displacement<double>(*layout, {move}, 0), 0);
            int count = 0;
            for (std::int64_t r = 0; r < 97; ++r)
                for (std::int64_t c = 0; c < 97; ++c) count += change[0](r, c) != 0;
            rows.add("figure 16",
                     fmt::format("samples moved by one {} coefficient, level {}",
                                 order == 1 ? "linear" : "quartic", level),
                     {}, count, fmt::format("3R(R-1)+1 = {}", expected[order - 1][level - 1]));
        }
}

// --- appendix B
// -------------------------------------------------------------------------------------------------

/// The exact analysis filter: numerator / D(z^2) as a series.
double exact_tap(const FilterBank& bank, const multires::Sequence& numerator, int n) {
    const double pole = bank.poles[0];
    double sum = 0;
    for (int k = -60; k <= 60; ++k)
        sum += numerator(n - 2 * k) * std::pow(pole, std::abs(k)) / (1 - pole * pole) / bank.gain;
    return sum;
}

void appendix_taps(Rows& rows) {
    constexpr double a[10] = {0.6830127, 0.3169873,  -0.1160254, -0.0849365, 0.0310889,
                              0.0227587, -0.0083302, -0.0060982, 0.0022321,  0.0016340};
    constexpr double b[9] = {0.8660254,  -0.3169873, -0.2320508, 0.0849365, 0.0621778,
                             -0.0227587, -0.0166605, 0.0044642,  -0.0016340};
    const FilterBank bank = *multires::filter_bank(2, Family::SemiOrthogonal, 0);
    for (int k = 0; k < 10; ++k)
        rows.add("appendix B (29)", fmt::format("a_{}", k + 1), a[k], exact_tap(bank, bank.a, k));
    for (int k = 0; k < 9; ++k)
        rows.add("appendix B (30)", fmt::format("b_{}", k + 1), b[k],
                 exact_tap(bank, bank.b, 1 + k),
                 k >= 7 ? "erratum E14: one entry was skipped" : "");
}

// --- figures 17 and 18
// ------------------------------------------------------------------------------------------

/// c^T G c: squared L2 norm of the surface with these coefficients.
double surface_energy(int order, const Grid<double>& c) {
    Grid<double> image(c.rows(), c.cols());
    (void)spline::gram_apply<double>(order, c.view(), image.view());
    double sum = 0;
    for (std::int64_t r = 0; r < c.rows(); ++r)
        for (std::int64_t k = 0; k < c.cols(); ++k) sum += c(r, k) * image(r, k);
    return sum;
}

Grid<double> difference(const Grid<double>& a, const Grid<double>& b) {
    Grid<double> d(a.rows(), a.cols());
    for (std::int64_t r = 0; r < a.rows(); ++r)
        for (std::int64_t c = 0; c < a.cols(); ++c) d(r, c) = a(r, c) - b(r, c);
    return d;
}

multires::Pyramid<double> thresholded(const Grid<double>& data, const SchemeSpec& spec,
                                      std::int64_t keep) {
    auto pyramid = *multires::analyse<double>({data.view()}, spec);
    codec::apply(codec::select_largest(pyramid, keep, codec::Metric::Surface), pyramid);
    return pyramid;
}

/// Squared L2 error in per cent of the squared L2 norm of (surface minus its coarsest
/// reconstruction).
double error_percent(const Grid<double>& data, const SchemeSpec& spec, double kept_percent) {
    const auto keep = static_cast<std::int64_t>(
        std::llround(kept_percent / 100 * static_cast<double>(data.count())));
    const auto surface = multires::coefficients(thresholded(data, spec, keep)).planes[0].clone();
    const auto coarse = multires::coefficients(thresholded(data, spec, 0)).planes[0].clone();
    return 100 * surface_energy(spec.order, difference(data, surface)) /
           surface_energy(spec.order, difference(data, coarse));
}

struct FigureRow {
    const char* figure;
    const char* name;
    SchemeSpec spec;
    std::array<std::optional<double>, 5> paper;
};

/// Heights above their mean: the printed taps do not sum to one, and what they do to the mean would
/// hide all else.
Grid<double> without_mean(Grid<double> data) {
    double sum = 0;
    for (std::int64_t r = 0; r < data.rows(); ++r)
        for (std::int64_t c = 0; c < data.cols(); ++c) sum += data(r, c);
    const double mean = sum / static_cast<double>(data.count());
    for (std::int64_t r = 0; r < data.rows(); ++r)
        for (std::int64_t c = 0; c < data.cols(); ++c) data(r, c) -= mean;
    return data;
}

/// What the 19 and 17 taps of the printed table leave behind when nothing is rejected.
void truncated_filters(Rows& rows, const Terrain& terrain) {
    const Grid<double> data =
        without_mean(codec::filled(terrain.raster.planes[0].view(), terrain.raster.mask));
    for (const auto& [family, name] : {std::pair{Family::TruncatedLiteral, "as printed"},
                                       {Family::TruncatedCorrect, "b corrected"}})
        rows.add("figure 18, " + terrain.name,
                 fmt::format("quartic, 19 and 17 taps {}: error %, 231 % kept", name),
                 family == Family::TruncatedLiteral ? std::optional(0.0) : std::nullopt,
                 error_percent(data, spec_of(SchemeId::Barycentric, 2, family, 3), 1e6),
                 "truncated filters do not reconstruct; heights above their mean");
}

void figures(Rows& rows, const Terrain& terrain) {
    const bool holes = terrain.raster.valid_count() != terrain.raster.rows * terrain.raster.cols;
    const Grid<double> data = codec::filled(terrain.raster.planes[0].view(), terrain.raster.mask);
    const std::array<double, 5> rates = {1e6, 36, 24.5, 13, 6.2};
    const std::array<std::optional<double>, 5> none;
    const FigureRow table[] = {
        {"17",
         "linear frame (Haar)",
         spec_of(SchemeId::Barycentric, 1, Family::Compact, 3),
         {0.0, 4.1, 7.2, 14.7, 30.1}},
        {"17", "linear, box lifting", spec_of(SchemeId::Box, 1, Family::Compact, 3), none},
        {"18",
         "quartic frame (Chui-Wang)",
         spec_of(SchemeId::Barycentric, 2, Family::SemiOrthogonal, 3),
         {0.0, 2.2, 4.0, 9.4, 22.6}},
        {"18", "quartic frame (2,2)", spec_of(SchemeId::Barycentric, 2, Family::Compact, 3), none},
        {"18", "quartic, box lifting", spec_of(SchemeId::Box, 2, Family::Compact, 3), none},
    };
    const char* note = holes ? "another terrain than the paper's, its holes filled smoothly"
                             : "another terrain than the paper's";
    for (const FigureRow& figure : table)
        for (std::size_t k = 0; k < rates.size(); ++k)
            rows.add("figure " + std::string(figure.figure) + ", " + terrain.name,
                     fmt::format("{}: error %, {} % kept", figure.name,
                                 k == 0 ? "231" : fmt::format("{}", rates[k])),
                     figure.paper[k], error_percent(data, figure.spec, rates[k]),
                     k == 0            ? "all coefficients"
                     : figure.paper[k] ? note
                     : holes           ? "holes filled smoothly"
                                       : "");
}

}  // namespace

std::vector<Row> barycentric_rows(const std::vector<Terrain>& terrains) {
    Rows rows(kSource);
    storage(rows);
    matrix_21(rows);
    nullspaces(rows);
    smoothness(rows);
    supports(rows);
    appendix_taps(rows);
    for (const Terrain& terrain : terrains) figures(rows, terrain);
    if (!terrains.empty()) truncated_filters(rows, terrains.front());
    return std::move(rows).take();
}

}  // namespace relief::reproduce
