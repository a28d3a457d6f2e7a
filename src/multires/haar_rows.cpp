#include "multires/haar_rows.h"

#include <algorithm>

#include "relief/core/simd.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "multires/haar_rows.cpp"
#include <hwy/cache_control.h>
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#ifndef RELIEF_MULTIRES_HAAR_ROWS_ONCE
#define RELIEF_MULTIRES_HAAR_ROWS_ONCE
namespace relief::multires::barycentric {

/// kChannel[4 X + 2 Y + Z] of letters X, Y, Z (1: high): the inverse of channel_letters.
inline constexpr std::array<std::size_t, 8> kChannel = {0, 1, 2, 4, 3, 5, 6, 7};

/// Sums and differences along the index bits 4, 2, 1 in this order: the passes along e1, e2, e3.
template <class T>
void butterfly(std::array<T, 8>& v) {
    for (std::size_t bit = 4; bit > 0; bit /= 2)
        for (std::size_t k = 0; k < 8; ++k) {
            if (k & bit) continue;
            const T difference = v[k] - v[k + bit];
            v[k] = v[k] + v[k + bit];
            v[k + bit] = difference;
        }
}

template <class T>
void analyse_point(T scale, const std::array<const T*, 3>& fine, std::int64_t k,
                   const std::array<T*, 8>& channels) {
    const T* above = fine[0] + 2 * k;
    const T* row = fine[1] + 2 * k;
    const T* below = fine[2] + 2 * k;
    std::array<T, 8> v = {row[1], above[0], row[2], above[1], below[1], row[0], below[2], row[1]};
    butterfly(v);
    for (std::size_t xyz = 0; xyz < 8; ++xyz) channels[kChannel[xyz]][k] = scale * v[xyz];
}

template <class T>
void point_values(T scale, const std::array<const T*, 8>& channels, std::int64_t k,
                  const std::array<T*, 8>& points) {
    std::array<T, 8> v;
    for (std::size_t xyz = 0; xyz < 8; ++xyz) v[xyz] = channels[kChannel[xyz]][k];
    butterfly(v);
    for (std::size_t lmn = 0; lmn < 8; ++lmn) points[lmn][k] = scale * v[lmn];
}

}  // namespace relief::multires::barycentric
#endif

HWY_BEFORE_NAMESPACE();
namespace relief::multires::barycentric {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// At most a cache line, so that streamed vectors fill lines.
template <class T>
using Tag = hn::CappedTag<T, 64 / sizeof(T)>;
template <class T>
using Vector = hn::Vec<Tag<T>>;

template <class V>
HWY_INLINE void butterfly_of(V& a, V& b) {
    const V difference = hn::Sub(a, b);
    a = hn::Add(a, b);
    b = difference;
}

/// The vector version of butterfly().
template <class V>
HWY_INLINE void butterflies(V& v0, V& v1, V& v2, V& v3, V& v4, V& v5, V& v6, V& v7) {
    butterfly_of(v0, v4);
    butterfly_of(v1, v5);
    butterfly_of(v2, v6);
    butterfly_of(v3, v7);
    butterfly_of(v0, v2);
    butterfly_of(v1, v3);
    butterfly_of(v4, v6);
    butterfly_of(v5, v7);
    butterfly_of(v0, v1);
    butterfly_of(v2, v3);
    butterfly_of(v4, v5);
    butterfly_of(v6, v7);
}

template <bool kStream, class T>
HWY_INLINE void put(Vector<T> v, T* out) {
    if constexpr (kStream) {
        hn::Stream(v, Tag<T>(), out);
    } else {
        hn::StoreU(v, Tag<T>(), out);
    }
}

template <bool kStream, class T>
void analyse(T scale, const std::array<const T*, 3>& fine, std::int64_t n,
             const std::array<T*, 8>& channels) {
    const Tag<T> d;
    const auto lanes = static_cast<std::int64_t>(hn::Lanes(d));
    const auto [above, row, below] = fine;
    const auto [aaa, aab, aba, baa, abb, bab, bba, bbb] = channels;
    const auto s = hn::Set(d, scale);
    std::int64_t k = 0;
    for (; k + lanes <= n; k += lanes) {
        Vector<T> f000, f001, f010, f011, f100, f101, f110, f111, unused;
        hn::LoadInterleaved2(d, above + 2 * k, f001, f011);
        hn::LoadInterleaved2(d, row + 2 * k, f101, f111);
        hn::LoadInterleaved2(d, row + 2 * k + 1, unused, f010);
        hn::LoadInterleaved2(d, below + 2 * k + 1, f100, f110);
        f000 = f111;
        butterflies(f000, f001, f010, f011, f100, f101, f110, f111);
        hn::StoreU(hn::Mul(s, f000), d, aaa + k);
        put<kStream>(hn::Mul(s, f001), aab + k);
        put<kStream>(hn::Mul(s, f010), aba + k);
        put<kStream>(hn::Mul(s, f011), abb + k);
        put<kStream>(hn::Mul(s, f100), baa + k);
        put<kStream>(hn::Mul(s, f101), bab + k);
        put<kStream>(hn::Mul(s, f110), bba + k);
        put<kStream>(hn::Mul(s, f111), bbb + k);
    }
    for (; k < n; ++k) analyse_point(scale, fine, k, channels);
}

/// Stores past the caches need aligned vectors.
template <class T>
void analyse_streaming(T scale, const std::array<const T*, 3>& fine, std::int64_t n,
                       const std::array<T*, 8>& channels) {
    const auto aligned = [](const T* row) {
        return reinterpret_cast<std::uintptr_t>(row) % 64 == 0;
    };
    if (std::all_of(channels.begin() + 1, channels.end(), aligned))
        analyse<true>(scale, fine, n, channels);
    else
        analyse<false>(scale, fine, n, channels);
}

template <class T>
void points(T scale, const std::array<const T*, 8>& channels, std::int64_t n,
            const std::array<T*, 8>& out) {
    const Tag<T> d;
    const auto lanes = static_cast<std::int64_t>(hn::Lanes(d));
    const auto [aaa, aab, aba, baa, abb, bab, bba, bbb] = channels;
    const auto s = hn::Set(d, scale);
    std::int64_t k = 0;
    for (; k + lanes <= n; k += lanes) {
        auto v0 = hn::LoadU(d, aaa + k);
        auto v1 = hn::LoadU(d, aab + k);
        auto v2 = hn::LoadU(d, aba + k);
        auto v3 = hn::LoadU(d, abb + k);
        auto v4 = hn::LoadU(d, baa + k);
        auto v5 = hn::LoadU(d, bab + k);
        auto v6 = hn::LoadU(d, bba + k);
        auto v7 = hn::LoadU(d, bbb + k);
        butterflies(v0, v1, v2, v3, v4, v5, v6, v7);
        hn::StoreU(hn::Mul(s, v0), d, out[0] + k);
        hn::StoreU(hn::Mul(s, v1), d, out[1] + k);
        hn::StoreU(hn::Mul(s, v2), d, out[2] + k);
        hn::StoreU(hn::Mul(s, v3), d, out[3] + k);
        hn::StoreU(hn::Mul(s, v4), d, out[4] + k);
        hn::StoreU(hn::Mul(s, v5), d, out[5] + k);
        hn::StoreU(hn::Mul(s, v6), d, out[6] + k);
        hn::StoreU(hn::Mul(s, v7), d, out[7] + k);
    }
    for (; k < n; ++k) point_values(scale, channels, k, out);
}

template <class T>
void merge_sums(const std::array<const T*, 2>& even, const std::array<const T*, 2>& odd,
                std::int64_t pairs, T* out) {
    const Tag<T> d;
    const auto lanes = static_cast<std::int64_t>(hn::Lanes(d));
    std::int64_t k = 0;
    for (; k + lanes <= pairs; k += lanes)
        hn::StoreInterleaved2(hn::Add(hn::LoadU(d, even[0] + k), hn::LoadU(d, even[1] + k)),
                              hn::Add(hn::LoadU(d, odd[0] + k), hn::LoadU(d, odd[1] + k)), d,
                              out + 2 * k);
    for (; k < pairs; ++k) {
        out[2 * k] = even[0][k] + even[1][k];
        out[2 * k + 1] = odd[0][k] + odd[1][k];
    }
}

#define RELIEF_KERNELS(T, S)                                                                \
    void analyse_##S(T s, const std::array<const T*, 3>& f, std::int64_t n,                 \
                     const std::array<T*, 8>& c) {                                          \
        analyse<false>(s, f, n, c);                                                         \
    }                                                                                       \
    void analyse_streaming_##S(T s, const std::array<const T*, 3>& f, std::int64_t n,       \
                               const std::array<T*, 8>& c) {                                \
        analyse_streaming(s, f, n, c);                                                      \
    }                                                                                       \
    void points_##S(T s, const std::array<const T*, 8>& c, std::int64_t n,                  \
                    const std::array<T*, 8>& p) {                                           \
        points(s, c, n, p);                                                                 \
    }                                                                                       \
    void merge_sums_##S(const std::array<const T*, 2>& e, const std::array<const T*, 2>& o, \
                        std::int64_t n, T* out) {                                           \
        merge_sums(e, o, n, out);                                                           \
    }
RELIEF_KERNELS(float, f)
RELIEF_KERNELS(double, d)
#undef RELIEF_KERNELS

}  // namespace HWY_NAMESPACE
}  // namespace relief::multires::barycentric
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace relief::multires::barycentric {

#define RELIEF_EXPORT(T, S)                                                                      \
    HWY_EXPORT(analyse_##S);                                                                     \
    HWY_EXPORT(analyse_streaming_##S);                                                           \
    HWY_EXPORT(points_##S);                                                                      \
    HWY_EXPORT(merge_sums_##S);                                                                  \
    template <>                                                                                  \
    void haar_analysis_row(T scale, const std::array<const T*, 3>& fine, std::int64_t n,         \
                           const std::array<T*, 8>& channels, Traffic details) {                 \
        if (!simd_enabled()) {                                                                   \
            for (std::int64_t k = 0; k < n; ++k) analyse_point(scale, fine, k, channels);        \
        } else if (details == Traffic::Streamed) {                                               \
            HWY_DYNAMIC_DISPATCH(analyse_streaming_##S)(scale, fine, n, channels);               \
        } else {                                                                                 \
            HWY_DYNAMIC_DISPATCH(analyse_##S)(scale, fine, n, channels);                         \
        }                                                                                        \
    }                                                                                            \
    template <>                                                                                  \
    void haar_points_row(T scale, const std::array<const T*, 8>& channels, std::int64_t n,       \
                         const std::array<T*, 8>& points) {                                      \
        if (simd_enabled()) return HWY_DYNAMIC_DISPATCH(points_##S)(scale, channels, n, points); \
        for (std::int64_t k = 0; k < n; ++k) point_values(scale, channels, k, points);           \
    }                                                                                            \
    template <>                                                                                  \
    void merge_sums_row(const std::array<const T*, 2>& even, const std::array<const T*, 2>& odd, \
                        std::int64_t pairs, T* out) {                                            \
        if (simd_enabled()) return HWY_DYNAMIC_DISPATCH(merge_sums_##S)(even, odd, pairs, out);  \
        for (std::int64_t k = 0; k < pairs; ++k) {                                               \
            out[2 * k] = even[0][k] + even[1][k];                                                \
            out[2 * k + 1] = odd[0][k] + odd[1][k];                                              \
        }                                                                                        \
    }
RELIEF_EXPORT(float, f)
RELIEF_EXPORT(double, d)
#undef RELIEF_EXPORT

}  // namespace relief::multires::barycentric
#endif  // HWY_ONCE
