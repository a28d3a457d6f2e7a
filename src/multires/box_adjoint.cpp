#include "multires/box_adjoint.h"

#include <algorithm>

#include "multires/row_copy.h"
#include "multires/strips.h"
#include "relief/core/parallel.h"
#include "relief/core/rows.h"

namespace relief::multires::box {

namespace {

/// Columns from either side in which weights may differ from those in the middle of a row.
constexpr std::int64_t kRim = 3;

/// self * an element + a weighted sum of others; those outside of their plane are left out.
template <class T>
struct Stencil {
    T self = 1;
    std::array<RowTap<T>, 16> taps;
    int count = 0;

    void add(const RowWindow<const T>& plane, std::int64_t i, std::int64_t j, double weight) {
        if (weight == 0 || i < 0 || i >= plane.rows || j < 0 || j >= plane.cols) return;
        taps[std::size_t(count++)] = {plane.row(i) + j, T(weight)};
    }
};

/// Applies stencil_at(j) to each element j of a row; the stencils of the middle columns are shifts
/// of one.
template <class T, class StencilAt>
void apply_row(T* out, std::int64_t n, StencilAt stencil_at) {
    const auto point = [&](std::int64_t j) {
        const Stencil<T> stencil = stencil_at(j);
        T sum = stencil.self * out[j];
        for (std::size_t t = 0; t < std::size_t(stencil.count); ++t)
            sum = sum + stencil.taps[t].weight * *stencil.taps[t].row;
        out[j] = sum;
    };
    const std::int64_t left = std::min(kRim, n);
    const std::int64_t right = std::max(left, n - kRim);
    for (std::int64_t j = 0; j < left; ++j) point(j);
    for (std::int64_t j = right; j < n; ++j) point(j);
    if (left == right) return;
    const Stencil<T> stencil = stencil_at(left);
    const RowTap<T> self = {out + left, stencil.self};
    if (stencil.self != 1) row_fir(out + left, right - left, &self, 1);
    if (stencil.count > 0)
        row_fir_add(out + left, right - left, stencil.taps.data(), stencil.count);
}

bool on_border(Lattice lattice, std::int64_t i, std::int64_t j) {
    return lattice.on_row_border(i) || lattice.on_col_border(j);
}

double centre_weight(const Rules& rules, Lattice lattice, std::int64_t i, std::int64_t j) {
    if (lattice.on_row_border(i) && lattice.on_col_border(j)) return 1;
    return on_border(lattice, i, j) ? rules.border_vertex.centre : rules.vertex.centre;
}

/// How much edges of `kind` that end at (i, j) move this vertex.
double ring_weight(const Rules& rules, Lattice lattice, int kind, std::int64_t i, std::int64_t j) {
    if (!on_border(lattice, i, j)) return rules.vertex.ring;
    const bool corner = lattice.on_row_border(i) && lattice.on_col_border(j);
    const bool along =
        (kind == 0 && lattice.on_col_border(j)) || (kind == 1 && lattice.on_row_border(i));
    return along && !corner ? rules.border_vertex.ring : 0;
}

double ends_weight(const Rules& rules, Lattice lattice, int kind, std::int64_t i, std::int64_t j) {
    return lattice.is_border_edge(kind, i, j) ? rules.border_ends : rules.ends;
}

double opposite_weight(const Rules& rules, Lattice lattice, int kind, std::int64_t i,
                       std::int64_t j) {
    return lattice.is_border_edge(kind, i, j) ? 0 : rules.opposite;
}

/// Transposed padding and splitting of a row: zeros where a line was padded.
template <class T>
void split_row(const T* row, std::int64_t cols, T* even, T* odd) {
    const std::int64_t pairs = cols / 2;
    row_split(row, pairs, even, odd);
    even[pairs] = cols % 2 == 1 ? row[cols - 1] : T(0);
}

/// The last rows of a plane of rows x cols, with a cache line of zeros in front of and behind each.
template <class T>
class KeptRows {
  public:
    KeptRows(std::int64_t depth, std::int64_t rows, std::int64_t cols)
        : rows_(rows), cols_(cols), kept_(depth, cols + 2 * kMargin, T(0)) {}
    [[nodiscard]] RowWindow<const T> window() const {
        return {kept_.row(0) + kMargin, rows_, cols_, kept_.stride(), kept_.rows()};
    }
    [[nodiscard]] T* row(std::int64_t i) { return kept_.row(i % kept_.rows()) + kMargin; }

  private:
    static constexpr std::int64_t kMargin = 64 / std::int64_t(sizeof(T));

    std::int64_t rows_;
    std::int64_t cols_;
    Grid<T> kept_;
};

/// Transpose of synthesis on the strip of coarse rows first .. last - 1: row t is split, the
/// vertices spread over the edges of row t - 1, collected in row t - 2, and the edges of row t - 4
/// finished.
template <class T>
class TransposeStrip {
  public:
    TransposeStrip(int order, const UpdateFactors& factors, GridView<const T> fine,
                   GridView<T> vertices, const EdgePlanes<T>& edges)
        : order_(order),
          factors_(factors),
          fine_(fine),
          vertices_out_(vertices),
          edges_out_(edges),
          lattice_{vertices.rows, vertices.cols},
          traffic_(streamed_if_large<T>(fine.count())),
          vertices_(7, lattice_.rows, lattice_.cols),
          edges_{edge_rows(0), edge_rows(1), edge_rows(2)},
          zeros_(1, 1, lattice_.cols),
          targets_(1, lattice_.cols) {}

    void run(std::int64_t first, std::int64_t last) {
        const auto within = [&](std::int64_t i, std::int64_t reach, std::int64_t rows) {
            return i >= std::max<std::int64_t>(0, first - reach) &&
                   i < std::min(rows, last + reach);
        };
        const std::int64_t begin = std::max<std::int64_t>(0, first - kUpdateReach - 1);
        for (std::int64_t t = begin; t < last + kUpdateReach + 2; ++t) {
            if (within(t, kUpdateReach + 2, lattice_.rows)) split(t);
            if (within(t - 1, kUpdateReach + 1, lattice_.rows)) spread(t - 1);
            if (within(t - 2, kUpdateReach, lattice_.rows)) collect(t - 2);
            if (within(t - 4, 0, lattice_.rows)) finish(t - 4);
        }
        finish_streaming();
    }

  private:
    /// Row i is split when row i - 4 is finished.
    KeptRows<T> edge_rows(int kind) const {
        return {5, lattice_.edge_rows(kind), lattice_.edge_cols(kind)};
    }

    void split(std::int64_t i) {
        T* v = vertices_.row(i);
        T* e2 = edges_[1].row(i);
        if (2 * i < fine_.rows) {
            split_row(fine_.row(2 * i), fine_.cols, v, e2);
        } else {
            std::fill_n(v, lattice_.cols, T(0));
            std::fill_n(e2, lattice_.edge_cols(1), T(0));
        }
        if (i < lattice_.edge_rows(0))
            split_row(fine_.row(2 * i + 1), fine_.cols, edges_[0].row(i), edges_[2].row(i));
    }

    void spread(std::int64_t i) {
        if (!rules(order_).has_vertex_step) return;
        for (int kind = 0; kind < kEdgeKinds; ++kind)
            if (i < lattice_.edge_rows(kind))
                spread_vertices<T>(order_, lattice_, vertices_.window(), kind, i,
                                   edges_[std::size_t(kind)].row(i));
    }

    void collect(std::int64_t i) {
        const auto& [e1, e2, e3] = edges_;
        collect_edges<T>(order_, lattice_, {e1.window(), e2.window(), e3.window()}, i,
                         vertices_.row(i));
    }

    void finish(std::int64_t i) {
        copy_row(vertices_.row(i), lattice_.cols, vertices_out_.row(i), Traffic::Cached);
        TargetRows<T> around;
        for (int o = 0; o < kTargetRows; ++o) {
            const std::int64_t y = i + o - kUpdateReach;
            around[std::size_t(o)] = y >= 0 && y < lattice_.rows ? vertices_.row(y) : zeros_.row(0);
        }
        for (int kind = 0; kind < kEdgeKinds; ++kind) {
            if (i >= lattice_.edge_rows(kind)) continue;
            const std::int64_t n = lattice_.edge_cols(kind);
            T* targets = targets_.row(0);
            collect_targets<T>(order_, around, kind, n, targets);
            factors_.scale_row(kind, i, targets);
            T* row = edges_[std::size_t(kind)].row(i);
            const RowTap<T> tap = {targets, T(-1)};
            row_fir_add(row, n, &tap, 1);
            copy_row(row, n, edges_out_[std::size_t(kind)].row(i), traffic_);
        }
    }

    int order_;
    const UpdateFactors& factors_;
    GridView<const T> fine_;
    GridView<T> vertices_out_;
    EdgePlanes<T> edges_out_;
    Lattice lattice_;
    Traffic traffic_;
    KeptRows<T> vertices_;
    std::array<KeptRows<T>, kEdgeKinds> edges_;
    KeptRows<T> zeros_;
    Grid<T> targets_;
};

}  // namespace

template <class T>
void spread_vertices(int order, Lattice lattice, const RowWindow<const T>& vertices, int kind,
                     std::int64_t i, T* edges) {
    const Rules& r = rules(order);
    const Offset step = kStep[std::size_t(kind)];
    apply_row(edges, lattice.edge_cols(kind), [&](std::int64_t j) {
        Stencil<T> s;
        for (const Offset o : {Offset{0, 0}, step})
            s.add(vertices, i + o.row, j + o.col,
                  ring_weight(r, lattice, kind, i + o.row, j + o.col));
        return s;
    });
}

template <class T>
void collect_edges(int order, Lattice lattice, const EdgeWindows<const T>& edges, std::int64_t i,
                   T* vertices) {
    const Rules& r = rules(order);
    apply_row(vertices, lattice.cols, [&](std::int64_t j) {
        Stencil<T> s;
        s.self = T(centre_weight(r, lattice, i, j));
        for (int kind = 0; kind < kEdgeKinds; ++kind) {
            const auto add = [&](Offset o, auto weight) {
                s.add(edges[std::size_t(kind)], i - o.row, j - o.col,
                      weight(r, lattice, kind, i - o.row, j - o.col));
            };
            add({0, 0}, ends_weight);
            add(kStep[std::size_t(kind)], ends_weight);
            for (const Offset o : kOpposite[std::size_t(kind)]) add(o, opposite_weight);
        }
        return s;
    });
}

template <class T>
void collect_targets(int order, const TargetRows<T>& vertices, int kind, std::int64_t n, T* sums) {
    const Rules& r = rules(order);
    std::array<RowTap<T>, kUpdate.size()> taps;
    for (std::size_t t = 0; t < std::size_t(r.update_taps); ++t) {
        const Offset o = for_kind(kind, kUpdate[t].offset);
        taps[t] = {vertices[std::size_t(o.row + kUpdateReach)] + o.col,
                   T(r.update[std::size_t(kUpdate[t].weight)])};
    }
    row_fir(sums, n, taps.data(), r.update_taps);
}

template <class T>
void transpose_level(int order, const UpdateFactors& factors, GridView<const T> fine,
                     GridView<T> vertices, const EdgePlanes<T>& edges) {
    parallel_for(0, vertices.rows, strip_rows(vertices.rows),
                 [&](std::int64_t first, std::int64_t last) {
                     TransposeStrip<T>(order, factors, fine, vertices, edges).run(first, last);
                 });
}

#define RELIEF_INSTANTIATE(T)                                                                      \
    template void spread_vertices(int, Lattice, const RowWindow<const T>&, int, std::int64_t, T*); \
    template void collect_edges(int, Lattice, const EdgeWindows<const T>&, std::int64_t, T*);      \
    template void collect_targets(int, const TargetRows<T>&, int, std::int64_t, T*);               \
    template void transpose_level(int, const UpdateFactors&, GridView<const T>, GridView<T>,       \
                                  const EdgePlanes<T>&);
RELIEF_INSTANTIATE(float)
RELIEF_INSTANTIATE(double)
#undef RELIEF_INSTANTIATE

}  // namespace relief::multires::box
