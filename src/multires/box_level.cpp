#include "multires/box_level.h"

#include <algorithm>

#include "multires/box_rows.h"
#include "multires/box_update.h"
#include "multires/strips.h"
#include "relief/core/parallel.h"
#include "relief/core/rows.h"

namespace relief::multires::box {

namespace {

/// The last `depth` rows of a plane. Rows start on cache lines, an odd number of them apart, and
/// have kRowMargin elements on both sides that are zero until somebody writes there.
template <class T>
class RowRing {
  public:
    RowRing(std::int64_t depth, std::int64_t cols)
        : depth_(depth), stride_(padded(cols)), rows_(std::size_t(depth * stride_)) {
        std::fill_n(rows_.data(), rows_.size(), T(0));
    }
    T* row(std::int64_t i) { return rows_.data() + i % depth_ * stride_ + kRowMargin; }

  private:
    static std::int64_t padded(std::int64_t cols) {
        constexpr std::int64_t line = 64 / std::int64_t(sizeof(T));
        return ((cols + 2 * kRowMargin + line - 1) / line | 1) * line;
    }
    std::int64_t depth_;
    std::int64_t stride_;
    Buffer<T> rows_;
};

/// Rings of the three edge planes and a row of zeros for what lies outside of them.
template <class T>
class EdgeRings {
  public:
    EdgeRings(std::int64_t depth, Lattice lattice)
        : lattice_(lattice),
          rings_{RowRing<T>(depth, lattice.cols), RowRing<T>(depth, lattice.cols),
                 RowRing<T>(depth, lattice.cols)},
          zeros_(1, lattice.cols) {}

    T* row(int kind, std::int64_t i) { return rings_[std::size_t(kind)].row(i); }

    /// The rows that the update of vertex row y reads.
    std::array<const T*, kUpdateRows> around(std::int64_t y) {
        std::array<const T*, kUpdateRows> rows;
        for (int kind = 0; kind < kEdgeKinds; ++kind) {
            for (int o = -kUpdateReach; o <= kUpdateReach; ++o) {
                const bool inside = y + o >= 0 && y + o < lattice_.edge_rows(kind);
                rows[std::size_t(update_row_slot(kind, o))] =
                    inside ? row(kind, y + o) : zeros_.row(0);
            }
        }
        return rows;
    }

  private:
    Lattice lattice_;
    std::array<RowRing<T>, kEdgeKinds> rings_;
    RowRing<T> zeros_;
};

/// out = centre * in + ring * (edge points around vertex row i); corners are copied. Either
/// direction of step 1.
template <class T>
void apply_vertex_rule(VertexRule inner, VertexRule border, Lattice lattice, std::int64_t i,
                       const T* in, EdgeRings<T>& edges, T* out) {
    const std::int64_t last = lattice.cols - 1;
    const T border_centre = T(border.centre);
    const T border_ring = T(border.ring);
    const T* e2 = edges.row(1, i);
    if (lattice.on_row_border(i)) {
        out[0] = in[0];
        for (std::int64_t j = 1; j < last; ++j)
            out[j] = border_centre * in[j] + border_ring * (e2[j - 1] + e2[j]);
        out[last] = in[last];
        return;
    }
    const T* e1 = edges.row(0, i);
    const T* e1_above = edges.row(0, i - 1);
    const T* e3 = edges.row(2, i);
    const T* e3_above = edges.row(2, i - 1);
    step_row<T>(T(inner.centre), T(inner.ring), in + 1,
                {e1_above + 1, e1 + 1, e2, e2 + 1, e3_above, e3 + 1}, last - 1, out + 1);
    for (const std::int64_t j : {std::int64_t{0}, last})
        out[j] = border_centre * in[j] + border_ring * (e1_above[j] + e1[j]);
}

/// out = edges + sign * prediction from the vertices: step 2 (-1) or its inverse (1). `out` may be
/// `edges`.
template <class T>
void add_prediction(const Rules& rules, T sign, Lattice lattice, int kind, std::int64_t i,
                    RowRing<T>& vertices, const T* edges, T* out) {
    const Offset step = kStep[std::size_t(kind)];
    const std::int64_t n = lattice.edge_cols(kind);
    const T* begin = vertices.row(i);
    const T* end = vertices.row(i + step.row) + step.col;
    const T border_ends = sign * T(rules.border_ends);
    if (rules.opposite == 0 || (kind == 1 && lattice.on_row_border(i)))
        return predict_row_from_ends(border_ends, edges, begin, end, n, out);

    const auto [a, b] = kOpposite[std::size_t(kind)];
    const std::int64_t rim = kind == 0 ? 1 : 0;
    predict_row<T>(sign * T(rules.ends), sign * T(rules.opposite), edges + rim,
                   {begin + rim, end + rim, vertices.row(i + a.row) + a.col + rim,
                    vertices.row(i + b.row) + b.col + rim},
                   n - 2 * rim, out + rim);
    if (rim == 0) return;
    for (const std::int64_t j : {std::int64_t{0}, n - 1})
        out[j] = edges[j] + border_ends * (begin[j] + end[j]);
}

/// Splits the columns of a fine row into even and odd ones; a missing last even one is
/// extrapolated.
template <class T>
void split_row(GridView<const T> fine, const T* source, T* even, T* odd) {
    const std::int64_t pairs = coarser(fine.cols) - 1;
    row_split(source, pairs, even, odd);
    even[pairs] = fine.cols % 2 == 1 ? source[fine.cols - 1] : 2 * odd[pairs - 1] - even[pairs - 1];
}

template <class T>
void merge_row(const T* even, const T* odd, std::int64_t cols, T* out) {
    const std::int64_t pairs = cols / 2;
    row_merge(even, odd, pairs, out);
    if (cols % 2 == 1) out[cols - 1] = even[pairs];
}

/// Coarse rows [first, last), cut off at the lattice.
struct RowRange {
    std::int64_t first;
    std::int64_t last;

    [[nodiscard]] bool has(std::int64_t i) const { return i >= first && i < last; }
    [[nodiscard]] RowRange grown(std::int64_t by, std::int64_t rows) const {
        return {std::max<std::int64_t>(0, first - by), std::min(rows, last + by)};
    }
};

/// Analysis of the strip `own`: row t is split and its vertices stepped, row t - 1 predicted, row t
/// - 3 updated.
template <class T>
class AnalysisStrip {
  public:
    AnalysisStrip(int order, const UpdateFactors& factors, GridView<const T> fine,
                  GridView<T> vertices, const EdgePlanes<T>& edges, RowRange own)
        : order_(order),
          rules_(rules(order)),
          factors_(factors),
          fine_(fine),
          vertices_out_(vertices),
          edges_out_(edges),
          lattice_{vertices.rows, vertices.cols},
          traffic_(streamed_if_large<T>(fine.count())),
          own_(own),
          predicted_(own.grown(kUpdateReach, lattice_.rows)),
          stepped_(predicted_.grown(1, lattice_.rows)),
          vertices_(4, lattice_.cols),
          edges_(6, lattice_),
          padding_(fine.rows % 2 == 0 ? 1 : 0, fine.cols) {}

    void run() {
        const RowRange split = {std::max<std::int64_t>(0, stepped_.first - 1), stepped_.last};
        for (std::int64_t t = split.first; t < own_.last + 3; ++t) {
            if (split.has(t)) split_rows(t);
            if (stepped_.has(t) && rules_.has_vertex_step) step_vertices(t);
            if (predicted_.has(t - 1)) predict(t - 1);
            if (own_.has(t - 3)) update(t - 3);
        }
        finish_streaming();
    }

  private:
    void split_rows(std::int64_t i) {
        T* v = vertices_.row(i);
        T* e2 = edges_.row(1, i);
        if (2 * i < fine_.rows) {
            split_row(fine_, fine_.row(2 * i), v, e2);
        } else {
            const RowTap<T> taps[] = {{fine_.row(fine_.rows - 1), T(2)},
                                      {fine_.row(fine_.rows - 2), T(-1)}};
            row_fir(padding_.row(0), fine_.cols, taps, 2);
            split_row(fine_, padding_.row(0), v, e2);
        }
        if (i < lattice_.rows - 1)
            split_row(fine_, fine_.row(2 * i + 1), edges_.row(0, i), edges_.row(2, i));
    }

    void step_vertices(std::int64_t i) {
        apply_vertex_rule(inverse(rules_.vertex), inverse(rules_.border_vertex), lattice_, i,
                          vertices_.row(i), edges_, vertices_.row(i));
    }

    void predict(std::int64_t i) {
        for (int kind = 0; kind < kEdgeKinds; ++kind) {
            if (i >= lattice_.edge_rows(kind)) continue;
            T* row = edges_.row(kind, i);
            add_prediction(rules_, T(-1), lattice_, kind, i, vertices_, row, row);
            if (own_.has(i))
                copy_row(row, lattice_.edge_cols(kind), edges_out_[std::size_t(kind)].row(i),
                         traffic_);
            factors_.scale_row(kind, i, row);
        }
    }

    void update(std::int64_t i) {
        update_vertices(order_, T(1), edges_.around(i), vertices_.row(i), lattice_.cols,
                        soon(i + 4), vertices_out_.row(i));
    }

    /// Both halves of the fine rows that coarse row i will be split from.
    SoonRows<T> soon(std::int64_t i) const {
        const T* even = fine_.row(std::min(2 * i, fine_.rows - 1));
        const T* odd = fine_.row(std::min(2 * i + 1, fine_.rows - 1));
        return {even, even + fine_.cols / 2, odd, odd + fine_.cols / 2};
    }

    int order_;
    const Rules& rules_;
    const UpdateFactors& factors_;
    GridView<const T> fine_;
    GridView<T> vertices_out_;
    EdgePlanes<T> edges_out_;
    Lattice lattice_;
    Traffic traffic_;
    RowRange own_;
    RowRange predicted_;
    RowRange stepped_;
    RowRing<T> vertices_;
    EdgeRings<T> edges_;
    Grid<T> padding_;
};

/// Synthesis of the strip `own`: edge row t is read, vertex row t - 2 un-updated, edge row t - 3
/// predicted, then the vertices of row t - 3 are stepped back and the pair of fine rows merged.
template <class T>
class SynthesisStrip {
  public:
    SynthesisStrip(int order, const UpdateFactors& factors, GridView<const T> vertices,
                   const EdgePlanes<const T>& edges, Traffic traffic, GridView<T> fine,
                   RowRange own)
        : order_(order),
          rules_(rules(order)),
          factors_(factors),
          vertices_in_(vertices),
          edges_in_(edges),
          fine_(fine),
          lattice_{vertices.rows, vertices.cols},
          traffic_(traffic),
          own_(own),
          predicted_{std::max<std::int64_t>(0, own.first - 1), own.last},
          updated_(predicted_.grown(1, lattice_.rows)),
          read_(updated_.grown(kUpdateReach, lattice_.rows)),
          scaled_(5, lattice_),
          vertices_(3, lattice_.cols),
          edges_(2, lattice_),
          stepped_(1, lattice_.cols),
          merged_(1, fine.cols) {}

    void run() {
        for (std::int64_t t = read_.first; t < own_.last + 3; ++t) {
            if (read_.has(t)) read_edges(t);
            if (updated_.has(t - 2)) undo_update(t - 2);
            if (predicted_.has(t - 3)) predict(t - 3);
            if (own_.has(t - 3)) merge_rows(t - 3);
        }
        finish_streaming();
    }

  private:
    void read_edges(std::int64_t i) {
        for (int kind = 0; kind < kEdgeKinds; ++kind) {
            if (i >= lattice_.edge_rows(kind)) continue;
            const GridView<const T>& band = edges_in_[std::size_t(kind)];
            copy_row(band.row(i), band.cols, scaled_.row(kind, i), Traffic::Cached);
            factors_.scale_row(kind, i, scaled_.row(kind, i));
        }
    }

    void undo_update(std::int64_t i) {
        update_vertices(order_, T(-1), scaled_.around(i), vertices_in_.row(i), lattice_.cols,
                        soon(i), vertices_.row(i));
    }

    /// What the next edge row to be read and the next vertex row to be un-updated need.
    SoonRows<T> soon(std::int64_t i) const {
        const auto edge_row = [&](std::size_t kind) {
            return edges_in_[kind].row(std::min(i + kUpdateReach + 1, edges_in_[kind].rows - 1));
        };
        return {edge_row(0), edge_row(1), edge_row(2),
                vertices_in_.row(std::min(i + 1, vertices_in_.rows - 1))};
    }

    void predict(std::int64_t i) {
        for (int kind = 0; kind < kEdgeKinds; ++kind) {
            if (i >= lattice_.edge_rows(kind)) continue;
            add_prediction(rules_, T(1), lattice_, kind, i, vertices_,
                           edges_in_[std::size_t(kind)].row(i), edges_.row(kind, i));
        }
    }

    void merge_rows(std::int64_t i) {
        const T* v = vertices_.row(i);
        if (rules_.has_vertex_step) {
            apply_vertex_rule(rules_.vertex, rules_.border_vertex, lattice_, i, v, edges_,
                              stepped_.row(0));
            v = stepped_.row(0);
        }
        write_merged(v, edges_.row(1, i), 2 * i);
        write_merged(edges_.row(0, i), edges_.row(2, i), 2 * i + 1);
    }

    void write_merged(const T* even, const T* odd, std::int64_t row) {
        if (row >= fine_.rows) return;
        if (traffic_ == Traffic::Cached) return merge_row(even, odd, fine_.cols, fine_.row(row));
        merge_row(even, odd, fine_.cols, merged_.row(0));
        copy_row(merged_.row(0), fine_.cols, fine_.row(row), traffic_);
    }

    int order_;
    const Rules& rules_;
    const UpdateFactors& factors_;
    GridView<const T> vertices_in_;
    EdgePlanes<const T> edges_in_;
    GridView<T> fine_;
    Lattice lattice_;
    Traffic traffic_;
    RowRange own_;
    RowRange predicted_;
    RowRange updated_;
    RowRange read_;
    EdgeRings<T> scaled_;
    RowRing<T> vertices_;
    EdgeRings<T> edges_;
    RowRing<T> stepped_;
    Grid<T> merged_;
};

}  // namespace

template <class T>
void analyse_level(int order, const UpdateFactors& factors, GridView<const T> fine,
                   GridView<T> vertices, const EdgePlanes<T>& edges) {
    parallel_for(0, vertices.rows, strip_rows(vertices.rows),
                 [&](std::int64_t first, std::int64_t last) {
                     AnalysisStrip<T>(order, factors, fine, vertices, edges, {first, last}).run();
                 });
}

template <class T>
void synthesise_level(int order, const UpdateFactors& factors, GridView<const T> vertices,
                      const EdgePlanes<const T>& edges, Traffic traffic, GridView<T> fine) {
    parallel_for(
        0, vertices.rows, strip_rows(vertices.rows), [&](std::int64_t first, std::int64_t last) {
            SynthesisStrip<T>(order, factors, vertices, edges, traffic, fine, {first, last}).run();
        });
}

#define RELIEF_INSTANTIATE(T)                                                              \
    template void analyse_level(int, const UpdateFactors&, GridView<const T>, GridView<T>, \
                                const EdgePlanes<T>&);                                     \
    template void synthesise_level(int, const UpdateFactors&, GridView<const T>,           \
                                   const EdgePlanes<const T>&, Traffic, GridView<T>);
RELIEF_INSTANTIATE(float)
RELIEF_INSTANTIATE(double)
#undef RELIEF_INSTANTIATE

}  // namespace relief::multires::box
