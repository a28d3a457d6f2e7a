#include "multires/haar_rows.h"

#include <cstring>

#include "relief/core/simd.h"
#include "relief/multires/filters.h"
#include "support.h"

namespace relief::multires::barycentric {
namespace {

template <class T>
class HaarRows : public testing::Test {};
using Scalars = testing::Types<float, double>;
TYPED_TEST_SUITE(HaarRows, Scalars);

template <class T>
std::array<T*, 8> rows_of(Grid<T>& grid) {
    std::array<T*, 8> rows;
    for (std::size_t k = 0; k < 8; ++k) rows[k] = grid.row(std::int64_t(k));
    return rows;
}

template <class T>
std::array<const T*, 8> rows_of(const Grid<T>& grid) {
    std::array<const T*, 8> rows;
    for (std::size_t k = 0; k < 8; ++k) rows[k] = grid.row(std::int64_t(k));
    return rows;
}

/// Runs kernel(out) vectorised and as the scalar twin on 8 rows of n elements and expects equal
/// bytes.
template <class T, class Kernel>
void expect_twins_agree(std::int64_t n, Kernel kernel) {
    Grid<T> vector(8, n, T(7));
    Grid<T> scalar(8, n, T(7));
    kernel(vector);
    set_simd_enabled(false);
    kernel(scalar);
    set_simd_enabled(true);
    for (std::int64_t r = 0; r < 8; ++r)
        EXPECT_EQ(0, std::memcmp(vector.row(r), scalar.row(r), std::size_t(n) * sizeof(T)));
}

TYPED_TEST(HaarRows, VectorAndScalarGiveTheSameBytes) {
    using T = TypeParam;
    for (const std::int64_t n : {1, 7, 16, 33, 200}) {
        const Grid<T> fine = test::noise_grid<T>(3, 2 * n + 1, 1);
        const Grid<T> channels = test::noise_grid<T>(8, n, 2);
        for (const Traffic traffic : {Traffic::Cached, Traffic::Streamed})
            expect_twins_agree<T>(n, [&](Grid<T>& out) {
                haar_analysis_row(T(0.125), {fine.row(0), fine.row(1), fine.row(2)}, n,
                                  rows_of(out), traffic);
                finish_streaming();
            });
        expect_twins_agree<T>(
            n, [&](Grid<T>& out) { haar_points_row(T(0.5), rows_of(channels), n, rows_of(out)); });
        expect_twins_agree<T>(2 * n, [&](Grid<T>& out) {
            merge_sums_row<T>({channels.row(0), channels.row(1)},
                              {channels.row(2), channels.row(3)}, n, out.row(0));
        });
    }
}

/// Every channel against its letters, on values whose sums are exact.
TYPED_TEST(HaarRows, AnalysisHasTheSignsOfTheLetters) {
    using T = TypeParam;
    constexpr std::int64_t n = 19;
    Grid<T> fine(3, 2 * n + 1);
    for (std::int64_t r = 0; r < 3; ++r)
        for (std::int64_t c = 0; c < fine.cols(); ++c) fine(r, c) = T(r * 41 + c * c % 17);
    Grid<T> out(8, n);
    haar_analysis_row(T(1), {fine.row(0), fine.row(1), fine.row(2)}, n, rows_of(out),
                      Traffic::Cached);
    for (int c = 0; c < 8; ++c) {
        const auto letters = channel_letters(c);
        for (std::int64_t k = 0; k < n; ++k) {
            T sum = 0;
            for (int p = 0; p < 8; ++p) {
                const int l = p >> 2, m = p >> 1 & 1, e = p & 1;
                const int minus = int(letters[0]) * l + int(letters[1]) * m + int(letters[2]) * e;
                sum += (minus % 2 ? T(-1) : T(1)) * fine(1 + l - e, 2 * k + 1 + m - e);
            }
            EXPECT_EQ(sum, out(c, k)) << channel_name(c) << ' ' << k;
        }
    }
}

/// The points of a coefficient are the transpose of analysis on the eight points apart.
TYPED_TEST(HaarRows, PointsHaveTheSignsOfTheLetters) {
    using T = TypeParam;
    Grid<T> channels(8, 1);
    for (int c = 0; c < 8; ++c) channels(c, 0) = T(1 << c);
    Grid<T> out(8, 1);
    haar_points_row(T(1), rows_of(std::as_const(channels)), 1, rows_of(out));
    for (int p = 0; p < 8; ++p) {
        T sum = 0;
        for (int c = 0; c < 8; ++c) {
            const auto letters = channel_letters(c);
            const int minus = int(letters[0]) * (p >> 2) + int(letters[1]) * (p >> 1 & 1) +
                              int(letters[2]) * (p & 1);
            sum += (minus % 2 ? T(-1) : T(1)) * channels(c, 0);
        }
        EXPECT_EQ(sum, out(p, 0)) << p;
    }
}

}  // namespace
}  // namespace relief::multires::barycentric
