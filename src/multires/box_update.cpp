#include "multires/box_update.h"

#include <algorithm>
#include <array>

#include "relief/core/simd.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "multires/box_update.cpp"
#include <hwy/cache_control.h>
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#ifndef RELIEF_MULTIRES_BOX_UPDATE_PLAN
#define RELIEF_MULTIRES_BOX_UPDATE_PLAN
namespace relief::multires::box {

/// Column shifts -reach .. reach that an order uses.
constexpr int shift_reach(int order) {
    return order == 1 ? 1 : kUpdateReach;
}
inline constexpr int kShifts = 2 * kUpdateReach + 1;

/// The rows that one weight takes at one column shift.
struct TapGroup {
    int count = 0;
    std::array<int, 8> slot{};
};

/// groups[shift][weight]; shift s stands for column y + s - kUpdateReach.
using UpdatePlan = std::array<std::array<TapGroup, kUpdateWeights>, kShifts>;

/// Vertex y gathers from edge y - offset what that edge scatters to its offset.
constexpr UpdatePlan update_plan(int order) {
    UpdatePlan plan{};
    for (int kind = 0; kind < kEdgeKinds; ++kind) {
        for (int t = 0; t < rules(order).update_taps; ++t) {
            const UpdateTap& tap = kUpdate[std::size_t(t)];
            const Offset o = for_kind(kind, tap.offset);
            TapGroup& group = plan[std::size_t(kUpdateReach - o.col)][std::size_t(tap.weight)];
            group.slot[std::size_t(group.count++)] = update_row_slot(kind, -o.row);
        }
    }
    return plan;
}

template <int kOrder>
inline constexpr UpdatePlan kPlan = update_plan(kOrder);

template <class T>
using EdgeRows = std::array<const T*, kUpdateRows>;

constexpr bool is_first_weight(int order, int shift, int weight) {
    const UpdatePlan& groups = order == 1 ? kPlan<1> : kPlan<2>;
    for (int w = 0; w < weight; ++w)
        if (groups[std::size_t(shift)][std::size_t(w)].count > 0) return false;
    return true;
}

template <int kOrder>
inline constexpr int kFirstShift = kUpdateReach - shift_reach(kOrder);

/// Columns whose sums are kept at once: five rows of them stay in the first-level cache.
template <class T>
inline constexpr std::int64_t kBlock = 4096 / static_cast<std::int64_t>(sizeof(T));

/// The sums start a cache line before the block, so that aligned rows are loaded aligned.
template <class T>
inline constexpr std::int64_t kLead = 64 / sizeof(T);

/// The five shifts' sums of a block with its reach on both sides and the rest of a last vector.
template <class T>
using ShiftSums = T[kShifts][kBlock<T> + 3 * kLead<T>];

}  // namespace relief::multires::box
#endif

HWY_BEFORE_NAMESPACE();
namespace relief::multires::box {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

template <class T>
using Tag = hn::CappedTag<T, 64 / sizeof(T)>;
template <class T>
using Vector = hn::Vec<Tag<T>>;

/// Rows 0 .. kTap of a group, added in order.
template <int kOrder, int kShift, int kWeight, int kTap, class T>
HWY_INLINE Vector<T> sum_rows(const EdgeRows<T>& edges, std::int64_t c) {
    constexpr int slot = kPlan<kOrder>[kShift][kWeight].slot[kTap];
    const auto row = hn::LoadU(Tag<T>(), edges[std::size_t(slot)] + c);
    if constexpr (kTap == 0) {
        return row;
    } else {
        return hn::Add(sum_rows<kOrder, kShift, kWeight, kTap - 1>(edges, c), row);
    }
}

/// Weights 0 .. kWeight of a shift, added in order.
template <int kOrder, int kShift, int kWeight, class T>
HWY_INLINE Vector<T> sum_weights(const EdgeRows<T>& edges, std::int64_t c, const T* weights) {
    constexpr int count = kPlan<kOrder>[kShift][kWeight].count;
    if constexpr (count == 0) {
        return sum_weights<kOrder, kShift, kWeight - 1>(edges, c, weights);
    } else {
        const auto rows = sum_rows<kOrder, kShift, kWeight, count - 1>(edges, c);
        const auto term = hn::Mul(hn::Set(Tag<T>(), weights[kWeight]), rows);
        if constexpr (is_first_weight(kOrder, kShift, kWeight)) {
            return term;
        } else {
            return hn::Add(sum_weights<kOrder, kShift, kWeight - 1>(edges, c, weights), term);
        }
    }
}

/// The sums of all shifts at columns first .. last - 1 and some behind. All are formed before one
/// is stored, so that each row is loaded once.
template <int kOrder, class T>
HWY_INLINE void sum_shifts(const EdgeRows<T>& edges, std::int64_t first, std::int64_t last,
                           const T* weights, const SoonRows<T>& soon, ShiftSums<T>& sums) {
    constexpr int top = kUpdateWeights - 1;
    const Tag<T> d;
    const auto lanes = static_cast<std::int64_t>(hn::Lanes(d));
    for (std::int64_t c = first; c < last; c += lanes) {
        for (const T* row : soon) hwy::Prefetch(row + c);
        const auto left = sum_weights<kOrder, 1, top>(edges, c, weights);
        const auto middle = sum_weights<kOrder, 2, top>(edges, c, weights);
        const auto right = sum_weights<kOrder, 3, top>(edges, c, weights);
        if constexpr (shift_reach(kOrder) == 2) {
            const auto far_left = sum_weights<kOrder, 0, top>(edges, c, weights);
            const auto far_right = sum_weights<kOrder, 4, top>(edges, c, weights);
            hn::StoreU(far_left, d, sums[0] + (c - first));
            hn::StoreU(far_right, d, sums[4] + (c - first));
        }
        hn::StoreU(left, d, sums[1] + (c - first));
        hn::StoreU(middle, d, sums[2] + (c - first));
        hn::StoreU(right, d, sums[3] + (c - first));
    }
}

/// out = vertices + the shifted sums; sums start kLead columns before the block.
template <int kOrder, class T>
HWY_INLINE void add_shifted(const ShiftSums<T>& sums, const T* vertices, std::int64_t n, T* out) {
    const Tag<T> d;
    const auto lanes = static_cast<std::int64_t>(hn::Lanes(d));
    std::int64_t j = 0;
    for (; j + lanes <= n; j += lanes) {
        auto sum = hn::LoadU(
            d, sums[kFirstShift<kOrder>] + kLead<T> + j + kFirstShift<kOrder> - kUpdateReach);
        for (int s = kFirstShift<kOrder> + 1; s < kShifts - kFirstShift<kOrder>; ++s)
            sum = hn::Add(sum, hn::LoadU(d, sums[s] + kLead<T> + j + s - kUpdateReach));
        hn::StoreU(hn::Add(hn::LoadU(d, vertices + j), sum), d, out + j);
    }
    for (; j < n; ++j) {
        T sum = sums[kFirstShift<kOrder>][kLead<T> + j + kFirstShift<kOrder> - kUpdateReach];
        for (int s = kFirstShift<kOrder> + 1; s < kShifts - kFirstShift<kOrder>; ++s)
            sum = sum + sums[s][kLead<T> + j + s - kUpdateReach];
        out[j] = vertices[j] + sum;
    }
}

template <int kOrder, class T>
void update(const EdgeRows<T>& edges, const T* weights, const T* vertices, std::int64_t n,
            const SoonRows<T>& soon, T* out) {
    HWY_ALIGN ShiftSums<T> sums;
    for (std::int64_t j = 0; j < n; j += kBlock<T>) {
        const std::int64_t count = std::min(kBlock<T>, n - j);
        sum_shifts<kOrder>(edges, j - kLead<T>, j + count + kUpdateReach, weights, soon, sums);
        add_shifted<kOrder>(sums, vertices + j, count, out + j);
    }
}

#define RELIEF_UPDATE(T, S)                                                        \
    void linear_##S(const EdgeRows<T>& e, const T* w, const T* v, std::int64_t n,  \
                    const SoonRows<T>& s, T* o) {                                  \
        update<1, T>(e, w, v, n, s, o);                                            \
    }                                                                              \
    void quartic_##S(const EdgeRows<T>& e, const T* w, const T* v, std::int64_t n, \
                     const SoonRows<T>& s, T* o) {                                 \
        update<2, T>(e, w, v, n, s, o);                                            \
    }
RELIEF_UPDATE(float, f)
RELIEF_UPDATE(double, d)
#undef RELIEF_UPDATE

}  // namespace HWY_NAMESPACE
}  // namespace relief::multires::box
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace relief::multires::box {
namespace {

template <class T>
T shift_sum_scalar(const std::array<TapGroup, kUpdateWeights>& groups, const EdgeRows<T>& edges,
                   std::int64_t c, const T* weights) {
    T sum = 0;
    bool first = true;
    for (std::size_t w = 0; w < groups.size(); ++w) {
        const TapGroup& group = groups[w];
        if (group.count == 0) continue;
        T rows = edges[std::size_t(group.slot[0])][c];
        for (std::size_t t = 1; t < std::size_t(group.count); ++t)
            rows = rows + edges[std::size_t(group.slot[t])][c];
        const T term = weights[w] * rows;
        sum = first ? term : sum + term;
        first = false;
    }
    return sum;
}

template <class T>
void update_scalar(int order, const EdgeRows<T>& edges, const T* weights, const T* vertices,
                   std::int64_t n, T* out) {
    const UpdatePlan& plan = order == 1 ? kPlan<1> : kPlan<2>;
    const int reach = shift_reach(order);
    const auto shift_sum = [&](int shift, std::int64_t c) {
        return shift_sum_scalar(plan[std::size_t(shift + kUpdateReach)], edges, c, weights);
    };
    for (std::int64_t j = 0; j < n; ++j) {
        T sum = shift_sum(-reach, j - reach);
        for (int shift = 1 - reach; shift <= reach; ++shift)
            sum = sum + shift_sum(shift, j + shift);
        out[j] = vertices[j] + sum;
    }
}

template <class T>
std::array<T, kUpdateWeights> signed_weights(int order, T sign) {
    std::array<T, kUpdateWeights> weights;
    for (std::size_t w = 0; w < weights.size(); ++w) weights[w] = sign * T(rules(order).update[w]);
    return weights;
}

}  // namespace

#define RELIEF_EXPORT(T, S)                                                                        \
    HWY_EXPORT(linear_##S);                                                                        \
    HWY_EXPORT(quartic_##S);                                                                       \
    template <>                                                                                    \
    void update_vertices(int order, T sign, const EdgeRows<T>& edges, const T* vertices,           \
                         std::int64_t n, const SoonRows<T>& soon, T* out) {                        \
        const auto weights = signed_weights(order, sign);                                          \
        if (!simd_enabled()) return update_scalar(order, edges, weights.data(), vertices, n, out); \
        if (order == 1)                                                                            \
            return HWY_DYNAMIC_DISPATCH(linear_##S)(edges, weights.data(), vertices, n, soon,      \
                                                    out);                                          \
        HWY_DYNAMIC_DISPATCH(quartic_##S)(edges, weights.data(), vertices, n, soon, out);          \
    }
RELIEF_EXPORT(float, f)
RELIEF_EXPORT(double, d)
#undef RELIEF_EXPORT

}  // namespace relief::multires::box
#endif  // HWY_ONCE
