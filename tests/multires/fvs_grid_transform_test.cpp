#include "relief/multires/fvs_grid_transform.h"

#include "multires/fvs_support.h"
#include "relief/core/parallel.h"
#include "relief/core/simd.h"
#include "relief/multires/fvs_certificate.h"
#include "relief/spline/fvs_cell.h"

namespace relief::multires::fvs {
namespace {

using namespace spline;  // NOLINT: the planes' names
using test::grid_of;
using test::noise_grid;

const nlohmann::json& golden() {
    static const nlohmann::json data = test::reference("fvs_grid.json");
    return data;
}

template <class T>
FvsGrid<T> predicted(const FvsGrid<T>& coarse, std::int64_t nx, std::int64_t ny) {
    FvsGrid<T> fine(nx, ny, coarse.a / 2, coarse.b / 2);
    predict(coarse.view(), fine.view());
    return fine;
}

template <class T>
struct Level {
    FvsGrid<T> coarse;
    Details<T> details;
};

template <class T>
Level<T> decomposed(const FvsGrid<T>& fine, Lifting lifting) {
    Level<T> level{{coarser(fine.nx()), coarser(fine.ny()), 2 * fine.a, 2 * fine.b},
                   {fine.nx(), fine.ny()}};
    decompose(fine.view(), lifting, level.coarse.view(), level.details.view());
    return level;
}

template <class T>
FvsGrid<T> reconstructed(Level<T> level, Lifting lifting, std::int64_t nx, std::int64_t ny) {
    FvsGrid<T> fine(nx, ny, level.coarse.a / 2, level.coarse.b / 2);
    reconstruct(level.coarse.view(), level.details.view(), lifting, fine.view());
    return fine;
}

TEST(FvsGridTransform, GoldenPrediction) {
    const nlohmann::json& data = golden()["grid_predict"];
    FvsGrid<double> coarse(2, 1, data["a"], data["b"]);
    FvsGrid<double> expected(4, 2);
    for (std::size_t p = 0; p < kFvsPlanes; ++p) {
        coarse.planes[p] = grid_of(data["coarse"][p]);
        expected.planes[p] = grid_of(data["fine"][p]);
    }
    EXPECT_LE(largest_difference(predicted(coarse, 4, 2), expected), 1e-13 * 4);  // data up to 4
}

/// The finer data are those of the coarse surface, whatever the element's formulas are.
TEST(FvsGridTransform, PredictsTheCoarseSurfaceItself) {
    const FvsGrid<double> coarse = noisy_grid<double>(4, 3, 1);
    const FvsGrid<double> fine = predicted(coarse, 8, 6);
    const auto surface = std::move(FvsSurface<double>::create(clone(coarse))).value();
    for (std::int64_t r = 0; r <= 6; ++r)
        for (std::int64_t c = 0; c <= 8; ++c) {
            const double i = double(r) / 2, j = double(c) / 2;
            const auto jet = surface.jet(i, j);
            EXPECT_NEAR(fine[kFvsF](r, c), jet.value, 1e-14);
            EXPECT_NEAR(fine[kFvsFx](r, c), jet.dj, 1e-13);
            EXPECT_NEAR(fine[kFvsFy](r, c), jet.di, 1e-13);
            if (c < 8) {
                EXPECT_NEAR(fine[kFvsGh](r, c), surface.jet(i, j + 0.25).di, 1e-13);
            }
            if (r < 6) {
                EXPECT_NEAR(fine[kFvsGv](r, c), surface.jet(i + 0.25, j).dj, 1e-13);
            }
        }
    // Spaces are nested: the finer surface is the same, its Hessian too.
    FvsGrid<double> finest = predicted(fine, 16, 12);
    const auto refined = std::move(FvsSurface<double>::create(std::move(finest))).value();
    test::Noise noise(2);
    for (int k = 0; k < 300; ++k) {
        const double i = 1.5 * (noise() + 1), j = 2 * (noise() + 1);
        const auto a = surface.jet(i, j), b = refined.jet(4 * i, 4 * j);
        EXPECT_NEAR(a.value, b.value, 1e-14);
        EXPECT_NEAR(a.di, 4 * b.di, 1e-13);
        EXPECT_NEAR(a.dij, 16 * b.dij, 1e-11);
    }
}

template <class T>
void expect_exact(std::int64_t nx, std::int64_t ny, Lifting lifting, double tolerance) {
    const FvsGrid<T> fine = noisy_grid<T>(nx, ny, 5, 0.5, 0.5);
    const Level<T> level = decomposed(fine, lifting);
    const FvsGrid<T> back = reconstructed(Level<T>{clone(level.coarse),
                                                   [&] {
                                                       Details<T> copy(nx, ny);
                                                       for (int k = 0; k < kDetailKinds; ++k)
                                                           copy[k] = level.details[k].clone();
                                                       return copy;
                                                   }()},
                                          lifting, nx, ny);
    EXPECT_LE(largest_difference(back, fine), tolerance) << nx << " x " << ny;
}

TEST(FvsGridTransform, ReconstructsAllSizes) {
    for (const Lifting lifting : {Lifting::None, Lifting::L2})
        for (std::int64_t nx = 0; nx < 12; ++nx)
            for (std::int64_t ny = 0; ny < 12; ++ny) {
                expect_exact<double>(nx, ny, lifting, 1e-14);  // data up to 1, some operations
                expect_exact<float>(nx, ny, lifting, 1e-5);
            }
    expect_exact<double>(301, 217, Lifting::L2, 1e-14);
}

/// Every number of the needed lattices is coded, and no other: 38 627 for 100 x 77 samples and five
/// levels.
TEST(FvsGridTransform, CodesWhatIsNeeded) {
    std::int64_t nx = 99, ny = 76, count = 0;
    for (int level = 0; level < 5; ++level) {
        for (int kind = 0; kind < kDetailKinds; ++kind) count += detail_box(kind, nx, ny).count();
        nx = coarser(nx);
        ny = coarser(ny);
    }
    const FvsGrid<float> top(nx, ny);
    for (const auto& plane : top.planes) count += plane.count();
    EXPECT_EQ(count, 38627);
}

TEST(FvsGridTransform, CubicsHaveNoDetail) {
    const auto cubic = [](double x, double y) {
        return test::Gradient{x * x * x - 2 * x * x * y + 3 * x * y * y + y * y * y - x + 2,
                              3 * x * x - 4 * x * y + 3 * y * y - 1,
                              -2 * x * x + 6 * x * y + 3 * y * y};
    };
    for (const Lifting lifting : {Lifting::None, Lifting::L2}) {
        const Level<double> level = decomposed(hermite_grid(8, cubic), lifting);
        for (int kind = 0; kind < kDetailKinds; ++kind)
            EXPECT_LE(test::largest_difference(
                          level.details[kind],
                          Grid<double>(level.details[kind].rows(), level.details[kind].cols(), 0.)),
                      1e-12)
                << detail_name(kind);
        EXPECT_LE(largest_difference(level.coarse, hermite_grid(4, cubic)), 1e-12);
    }
}

/// Levels of Franke's function and of a narrow bump with exact derivatives, by the transform from
/// level 6 down, at 129 x 129 points.
template <class Function>
void expect_level_errors(const std::string& key, Function f) {
    FvsGrid<double> grid = hermite_grid(64, f);
    for (int level = 6; level >= 0; --level) {
        const auto surface = std::move(FvsSurface<double>::create(clone(grid))).value();
        double largest = 0, squares = 0;
        for (int r = 0; r <= 128; ++r)
            for (int c = 0; c <= 128; ++c) {
                const double scale = double(1 << level) / 128;
                const double e =
                    surface.jet(r * scale, c * scale).value - f(c / 128.0, r / 128.0).value;
                largest = std::max(largest, std::abs(e));
                squares += e * e;
            }
        const nlohmann::json& expected = golden()[key][std::size_t(level)];
        // The printed reference has a relative precision of 1e-10; its differences are of numbers
        // near 1.
        EXPECT_NEAR(largest, expected["e_inf"].get<double>(), 1e-10 * largest + 1e-15) << level;
        EXPECT_NEAR(squares / (129 * 129), expected["mean_square"].get<double>(),
                    1e-9 * squares / (129 * 129))
            << level;
        if (level > 0) grid = std::move(decomposed(grid, Lifting::None).coarse);
    }
}

TEST(FvsGridTransform, GoldenLevelErrors) {
    expect_level_errors("level_errors_franke", test::franke);
    expect_level_errors("level_errors_f2", test::small_bump);
}

/// Quantises in place.
void quantise(Grid<double>& values, double step, Grid<double>& integers) {
    integers = Grid<double>(values.rows(), values.cols());
    for (std::int64_t r = 0; r < values.rows(); ++r)
        for (std::int64_t c = 0; c < values.cols(); ++c) {
            integers(r, c) = std::nearbyint(values(r, c) / step);
            values(r, c) = integers(r, c) * step;
        }
}

/// The integers of a kind as the reference has them: halves of edges stand side by side.
Grid<double> reference_part(const nlohmann::json& level, int kind) {
    std::string name(detail_name(kind));
    const bool second = name.back() == 'b';
    const bool half = name.size() == 4;
    const Grid<double> all = grid_of(level[half ? name.substr(0, 3) : name]);
    if (!half) return all.clone();
    const bool along_x = detail_plane(kind) == kFvsGh;
    Grid<double> part(along_x ? all.rows() : all.rows() / 2, along_x ? all.cols() / 2 : all.cols());
    for (std::int64_t r = 0; r < part.rows(); ++r)
        for (std::int64_t c = 0; c < part.cols(); ++c)
            part(r, c) = along_x ? all(r, 2 * c + second) : all(2 * r + second, c);
    return part;
}

TEST(FvsGridTransform, GoldenClosedLoop) {
    const nlohmann::json& data = golden()["closed_loop"];
    const double step = data["step_value"], kappa = data["kappa"];
    FvsGrid<double> decoded = hermite_grid(1, test::franke);
    Grid<double> integers;
    for (int p = 0; p < kFvsPlanes; ++p) {
        quantise(decoded[p], p == kFvsF ? step : kappa * step, integers);
        EXPECT_EQ(test::largest_difference(integers, grid_of(data["q"][0][std::size_t(p)])), 0);
    }
    for (int level = 1; level <= 3; ++level) {
        const std::int64_t n = std::int64_t{1} << level;
        Level<double> coded{clone(decoded), {n, n}};
        const FvsGrid<double> original = hermite_grid(n, test::franke);
        details_against(std::as_const(decoded).view(), original.view(), coded.details.view());
        for (int kind = 0; kind < kDetailKinds; ++kind) {
            const bool value = detail_plane(kind) == kFvsF;
            quantise(coded.details[kind], value ? step : kappa * step * double(n), integers);
            EXPECT_EQ(test::largest_difference(integers,
                                               reference_part(data["q"][std::size_t(level)], kind)),
                      0)
                << detail_name(kind) << " of level " << level;
        }
        decoded = reconstructed(std::move(coded), Lifting::None, n, n);
    }
    FvsGrid<double> error = hermite_grid(8, test::franke);
    for (int p = 0; p < kFvsPlanes; ++p)
        for (std::int64_t r = 0; r < error[p].rows(); ++r)
            for (std::int64_t c = 0; c < error[p].cols(); ++c) error[p](r, c) -= decoded[p](r, c);
    const auto bounds = cell_bounds<double>(std::as_const(error).view(), 0);
    double bound = 0, sampled = 0;
    for (std::int64_t r = 0; r < 8; ++r)
        for (std::int64_t c = 0; c < 8; ++c) bound = std::max(bound, (*bounds)(r, c));
    const auto surface = std::move(FvsSurface<double>::create(std::move(error))).value();
    for (int r = 0; r <= 64; ++r)
        for (int c = 0; c <= 64; ++c)
            sampled = std::max(sampled, std::abs(surface.jet(r / 8.0, c / 8.0).value));
    EXPECT_NEAR(bound, data["bb_bound"].get<double>(), 1e-12);
    EXPECT_NEAR(sampled, data["sampled_max"].get<double>(), 1e-12);
}

/// Row (value, dx, dy a vertex; side normals) and column order of the reference: vertices and edges
/// run around the cell, normals are edge directions turned by +90 degrees.
TEST(FvsGridTransform, GoldenUpdate) {
    struct Signed {
        int array;
        int row;
        int col;
        double sign;
    };
    const Signed rows[] = {
        {kFvsF, 0, 0, 1},  {kFvsFx, 0, 0, 1},  {kFvsFy, 0, 0, 1},  {kFvsF, 0, 1, 1},
        {kFvsFx, 0, 1, 1}, {kFvsFy, 0, 1, 1},  {kFvsF, 1, 1, 1},   {kFvsFx, 1, 1, 1},
        {kFvsFy, 1, 1, 1}, {kFvsF, 1, 0, 1},   {kFvsFx, 1, 0, 1},  {kFvsFy, 1, 0, 1},
        {kFvsGh, 0, 0, 1}, {kFvsGv, 0, 1, -1}, {kFvsGh, 1, 0, -1}, {kFvsGv, 0, 0, -1}};
    const Signed columns[] = {
        {kEhv, 0, 0, 1},   {kEht, 0, 0, 1},   {kEvv, 0, 1, 1},   {kEvt, 0, 1, 1},
        {kEhv, 1, 0, 1},   {kEht, 1, 0, -1},  {kEvv, 0, 0, 1},   {kEvt, 0, 0, 1},
        {kCv, 0, 0, 1},    {kCx, 0, 0, 1},    {kCy, 0, 0, 1},    {kGh0a, 0, 0, 1},
        {kGh0b, 0, 0, 1},  {kGv0a, 0, 1, -1}, {kGv0b, 0, 1, -1}, {kGh0b, 1, 0, -1},
        {kGh0a, 1, 0, -1}, {kGv0a, 0, 0, -1}, {kGv0b, 0, 0, -1}, {kGv1a, 0, 0, -1},
        {kGh1b, 0, 0, -1}, {kGv1b, 0, 0, 1},  {kGh1a, 0, 0, 1}};
    const Grid<double> expected = grid_of(golden()["l2_update"]["U"]);
    for (std::size_t j = 0; j < std::size(columns); ++j) {
        FvsGrid<double> zero(1, 1, 1, 1);
        Details<double> unit(2, 2);
        for (auto& plane : zero.planes) plane = Grid<double>(plane.rows(), plane.cols(), 0.0);
        for (auto& plane : unit.planes) plane = Grid<double>(plane.rows(), plane.cols(), 0.0);
        unit[columns[j].array](columns[j].row, columns[j].col) = columns[j].sign;
        const FvsGrid<double> fine =
            reconstructed(Level<double>{std::move(zero), std::move(unit)}, Lifting::None, 2, 2);
        const Level<double> level = decomposed(fine, Lifting::L2);
        for (std::size_t i = 0; i < std::size(rows); ++i)
            EXPECT_NEAR(rows[i].sign * level.coarse[rows[i].array](rows[i].row, rows[i].col),
                        expected(std::int64_t(i), std::int64_t(j)), 1e-9)
                << i << " " << j;
    }
}

/// Integral of the product of two splines on a grid.
double inner_product(const FvsGrid<double>& u, const FvsGrid<double>& v) {
    const auto& mass = fvs_cell_mass();
    const auto number = [](const FvsGrid<double>& grid, std::int64_t r, std::int64_t c,
                           std::size_t k) {
        const FvsCellNumber& at = kFvsCell[k];
        const double scale = at.plane == kFvsF                          ? 1
                             : at.plane == kFvsFx || at.plane == kFvsGv ? grid.a
                                                                        : grid.b;
        return scale * grid[at.plane](r + at.row, c + at.col);
    };
    double sum = 0;
    for (std::int64_t r = 0; r < u.ny(); ++r)
        for (std::int64_t c = 0; c < u.nx(); ++c)
            for (std::size_t m = 0; m < kFvsCellNumbers; ++m)
                for (std::size_t n = 0; n < kFvsCellNumbers; ++n)
                    sum += number(u, r, c, m) * mass[m][n] * number(v, r, c, n);
    return sum * u.a * u.b;
}

/// The update is the solution of the local normal equations: with u = U d for one detail, the
/// wavelet E d - P u is orthogonal to the coarse functions of the detail's cells once u acts within
/// them, for every kind, at borders and inside, and for cells that are not square.
TEST(FvsGridTransform, UpdateProjectsOnTheDetailsCells) {
    const std::int64_t nx = 4, ny = 3;
    const double a = 0.7, b = 1.3;
    const auto zero_level = [&] {
        Level<double> level{{nx, ny, a, b}, {2 * nx, 2 * ny}};
        for (auto& plane : level.coarse.planes)
            plane = Grid<double>(plane.rows(), plane.cols(), 0.0);
        for (auto& plane : level.details.planes)
            plane = Grid<double>(plane.rows(), plane.cols(), 0.0);
        return level;
    };
    for (int kind = 0; kind < kDetailKinds; ++kind) {
        const LatticeBox box = detail_box(kind, 2 * nx, 2 * ny);
        for (std::int64_t at = 0; at < box.count(); ++at) {
            Level<double> level = zero_level();
            level.details[kind](at / box.cols, at % box.cols) = 1;
            const FvsGrid<double> wavelet =
                reconstructed(std::move(level), Lifting::L2, 2 * nx, 2 * ny);
            const Level<double> plain = decomposed(wavelet, Lifting::None);
            for (int p = 0; p < kFvsPlanes; ++p)
                for (std::int64_t r = 0; r < plain.coarse[p].rows(); ++r)
                    for (std::int64_t c = 0; c < plain.coarse[p].cols(); ++c) {
                        if (plain.coarse[p](r, c) == 0) continue;
                        Level<double> basis = zero_level();
                        basis.coarse[p](r, c) = 1;
                        const FvsGrid<double> function =
                            reconstructed(std::move(basis), Lifting::None, 2 * nx, 2 * ny);
                        const double size = std::sqrt(inner_product(function, function) *
                                                      inner_product(wavelet, wavelet));
                        ASSERT_NEAR(inner_product(wavelet, function) / size, 0, 1e-11)
                            << detail_name(kind) << " " << at << ", plane " << p;
                    }
        }
    }
}

double dot(const FvsGrid<double>& a, const FvsGrid<double>& b) {
    double sum = 0;
    for (int p = 0; p < kFvsPlanes; ++p) sum += test::dot<double>(a[p].view(), b[p].view());
    return sum;
}

TEST(FvsGridTransform, TransposeIsTheAdjoint) {
    for (const Lifting lifting : {Lifting::None, Lifting::L2})
        for (const auto& [nx, ny] : {std::pair{8, 6}, {7, 9}, {1, 1}, {2, 3}, {0, 5}, {4, 0}}) {
            const Level<double> level{noisy_grid<double>(coarser(nx), coarser(ny), 1, 2, 0.5),
                                      noisy_details<double>(nx, ny, 20)};
            const FvsGrid<double> residual = noisy_grid<double>(nx, ny, 40, 1, 0.25);
            Level<double> adjoint{{coarser(nx), coarser(ny), 2, 0.5}, {nx, ny}};
            transpose(residual.view(), lifting, adjoint.coarse.view(), adjoint.details.view());
            double sum = dot(level.coarse, adjoint.coarse);
            for (int kind = 0; kind < kDetailKinds; ++kind)
                sum += test::dot<double>(level.details[kind].view(), adjoint.details[kind].view());
            Level<double> copy{clone(level.coarse), {nx, ny}};
            for (int kind = 0; kind < kDetailKinds; ++kind)
                copy.details[kind] = level.details[kind].clone();
            const FvsGrid<double> fine = reconstructed(std::move(copy), lifting, nx, ny);
            EXPECT_NEAR(dot(fine, residual), sum, 1e-11) << nx << " x " << ny;
        }
}

TEST(FvsGridTransform, ThreadsAndInstructionsDoNotShow) {
    const FvsGrid<float> fine = noisy_grid<float>(1201, 733, 9);
    const auto run = [&] { return decomposed(fine, Lifting::L2); };
    const auto reference = run();
    set_simd_enabled(false);
    set_thread_count(3);
    const auto other = run();
    set_simd_enabled(true);
    set_thread_count(0);
    EXPECT_EQ(largest_difference(reference.coarse, other.coarse), 0);
    EXPECT_EQ(largest_difference(reference.details, other.details), 0);
}

TEST(FvsGridTransform, PredictedValuesAreThoseOfTheSurface) {
    for (const auto& [rows, cols] :
         {std::pair<std::int64_t, std::int64_t>{13, 17}, {12, 16}, {2, 3}, {2, 2}, {9, 30}}) {
        const Grid<double> coarse =
            noise_grid<double>(coarser(rows - 1) + 1, coarser(cols - 1) + 1, 3);
        Grid<double> fine(rows, cols);
        predict_values<double>(coarse.view(), fine.view());
        const auto surface = FvsSurface<double>::create(RasterPart<double>::whole(coarse.view()),
                                                        {0, 0, coarse.rows(), coarse.cols()});
        for (std::int64_t r = 0; r < rows; ++r)
            for (std::int64_t c = 0; c < cols; ++c)
                EXPECT_NEAR(fine(r, c), surface->jet(double(r) / 2, double(c) / 2).value, 1e-14);
    }
    Grid<double> line(1, 5);
    predict_values<double>(noise_grid<double>(1, 3, 1).view(), line.view());
    EXPECT_EQ(line(0, 4), noise_grid<double>(1, 3, 1)(0, 2));
    Grid<double> point(1, 1);
    predict_values<double>(Grid<double>(1, 1, 7.0).view(), point.view());
    EXPECT_EQ(point(0, 0), 7);
}

}  // namespace
}  // namespace relief::multires::fvs
