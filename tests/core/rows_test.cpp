#include "relief/core/rows.h"

#include <cstring>
#include <random>

#include "relief/core/simd.h"

namespace relief {
namespace {

template <class T>
class Rows : public testing::Test {};
using Scalars = testing::Types<float, double>;
TYPED_TEST_SUITE(Rows, Scalars);

template <class T>
std::vector<T> noise(std::int64_t n, unsigned seed) {
    std::mt19937 engine(seed);
    std::uniform_real_distribution<T> draw(-1000, 1000);
    std::vector<T> row(static_cast<std::size_t>(n));
    for (T& x : row) x = draw(engine);
    return row;
}

/// Runs `kernel` with the vector version and with the scalar twin and expects the same bytes.
template <class T, class Kernel>
void expect_twins_agree(std::int64_t outputs, Kernel kernel) {
    std::vector<T> vector(static_cast<std::size_t>(outputs), T(7));
    std::vector<T> scalar(static_cast<std::size_t>(outputs), T(7));
    kernel(vector.data());
    set_simd_enabled(false);
    kernel(scalar.data());
    set_simd_enabled(true);
    EXPECT_EQ(0, std::memcmp(vector.data(), scalar.data(), vector.size() * sizeof(T)));
}

TYPED_TEST(Rows, VectorAndScalarGiveTheSameBytes) {
    using T = TypeParam;
    for (const std::int64_t n : {1, 2, 3, 15, 16, 17, 63, 64, 65, 200}) {
        const auto a = noise<T>(2 * n, 1);
        const auto b = noise<T>(2 * n, 2);
        const auto c = noise<T>(2 * n, 3);
        const RowTap<T> taps[] = {
            {a.data(), T(0.3)}, {b.data() + 1, T(-1.7)}, {c.data(), T(1) / 3}};
        expect_twins_agree<T>(n, [&](T* out) { row_fir(out, n, taps, 3); });
        expect_twins_agree<T>(n, [&](T* out) { row_fir_add(out, n, taps, 3); });
        expect_twins_agree<T>(2 * n, [&](T* out) { row_split(a.data(), n, out, out + n); });
        expect_twins_agree<T>(2 * n, [&](T* out) { row_merge(a.data(), b.data(), n, out); });
        expect_twins_agree<T>(2 * n,
                              [&](T* out) { row_butterfly(a.data(), b.data(), n, out, out + n); });
    }
}

TYPED_TEST(Rows, FirIsTheWeightedSum) {
    using T = TypeParam;
    const auto a = noise<T>(70, 4);
    const auto b = noise<T>(70, 5);
    const RowTap<T> taps[] = {{a.data(), T(2)}, {b.data(), T(-0.5)}};
    std::vector<T> out(70);
    row_fir(out.data(), 70, taps, 2);
    for (std::size_t k = 0; k < 70; ++k) EXPECT_EQ(out[k], T(2) * a[k] + T(-0.5) * b[k]);
}

TYPED_TEST(Rows, MergeUndoesSplit) {
    using T = TypeParam;
    const auto a = noise<T>(130, 6);
    std::vector<T> even(65), odd(65), back(130);
    row_split(a.data(), 65, even.data(), odd.data());
    EXPECT_EQ(even[3], a[6]);
    EXPECT_EQ(odd[3], a[7]);
    row_merge(even.data(), odd.data(), 65, back.data());
    EXPECT_EQ(a, back);
}

}  // namespace
}  // namespace relief
