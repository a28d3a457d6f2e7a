#include "multires/box_adjoint.h"

#include <algorithm>

#include "relief/core/parallel.h"
#include "relief/core/rows.h"

namespace relief::multires::box {

namespace {

/// Columns from either side in which weights may differ from those in the middle of a row.
constexpr std::int64_t kRim = 3;
constexpr std::int64_t kRowsPerBlock = 64;

/// self * an element + a weighted sum of others; those outside of their plane are left out.
template <class T>
struct Stencil {
    T self = 1;
    std::array<RowTap<T>, 16> taps;
    int count = 0;

    void add(GridView<const T> plane, std::int64_t i, std::int64_t j, double weight) {
        if (weight == 0 || i < 0 || i >= plane.rows || j < 0 || j >= plane.cols) return;
        taps[std::size_t(count++)] = {&plane(i, j), T(weight)};
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

template <class Row>
void for_rows(std::int64_t rows, Row row) {
    parallel_for(0, rows, kRowsPerBlock, [&](std::int64_t first, std::int64_t last) {
        for (std::int64_t i = first; i < last; ++i) row(i);
    });
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

/// Transposed padding and splitting: fine points to vertices and edges, zeros on a padded line.
template <class T>
void split_planes(GridView<const T> fine, GridView<T> vertices, const EdgePlanes<T>& edges) {
    const auto coset = [&](GridView<T> plane, Offset o, std::int64_t i) {
        const std::int64_t row = 2 * i + o.row;
        for (std::int64_t j = 0; j < plane.cols; ++j) {
            const std::int64_t col = 2 * j + o.col;
            plane(i, j) = row < fine.rows && col < fine.cols ? fine(row, col) : T(0);
        }
    };
    for_rows(vertices.rows, [&](std::int64_t i) {
        coset(vertices, {0, 0}, i);
        for (std::size_t kind = 0; kind < edges.size(); ++kind)
            if (i < edges[kind].rows) coset(edges[kind], kStep[kind], i);
    });
}

}  // namespace

template <class T>
void spread_vertices(int order, Lattice lattice, GridView<const T> vertices,
                     const EdgePlanes<T>& edges) {
    const Rules& r = rules(order);
    for (int kind = 0; kind < kEdgeKinds; ++kind) {
        const Offset step = kStep[std::size_t(kind)];
        const GridView<T>& plane = edges[std::size_t(kind)];
        const auto stencil = [&](std::int64_t i, std::int64_t j) {
            Stencil<T> s;
            for (const Offset o : {Offset{0, 0}, step})
                s.add(vertices, i + o.row, j + o.col,
                      ring_weight(r, lattice, kind, i + o.row, j + o.col));
            return s;
        };
        for_rows(plane.rows, [&](std::int64_t i) {
            apply_row(plane.row(i), plane.cols, [&](std::int64_t j) { return stencil(i, j); });
        });
    }
}

template <class T>
void collect_edges(int order, Lattice lattice, const EdgePlanes<const T>& edges,
                   GridView<T> vertices) {
    const Rules& r = rules(order);
    const auto stencil = [&](std::int64_t i, std::int64_t j) {
        Stencil<T> s;
        s.self = T(centre_weight(r, lattice, i, j));
        for (int kind = 0; kind < kEdgeKinds; ++kind) {
            const GridView<const T>& plane = edges[std::size_t(kind)];
            const auto add = [&](Offset o, auto weight) {
                s.add(plane, i - o.row, j - o.col, weight(r, lattice, kind, i - o.row, j - o.col));
            };
            add({0, 0}, ends_weight);
            add(kStep[std::size_t(kind)], ends_weight);
            for (const Offset o : kOpposite[std::size_t(kind)]) add(o, opposite_weight);
        }
        return s;
    };
    for_rows(vertices.rows, [&](std::int64_t i) {
        apply_row(vertices.row(i), vertices.cols, [&](std::int64_t j) { return stencil(i, j); });
    });
}

template <class T>
void collect_targets(int order, GridView<const T> vertices, int kind, std::int64_t row,
                     std::int64_t n, T* sums) {
    const Rules& r = rules(order);
    std::fill_n(sums, n, T(0));
    apply_row(sums, n, [&](std::int64_t j) {
        Stencil<T> s;
        for (std::size_t t = 0; t < std::size_t(r.update_taps); ++t) {
            const Offset o = for_kind(kind, kUpdate[t].offset);
            s.add(vertices, row + o.row, j + o.col, r.update[std::size_t(kUpdate[t].weight)]);
        }
        return s;
    });
}

template <class T>
void transpose_level(int order, const UpdateFactors& factors, GridView<const T> fine,
                     GridView<T> vertices, const EdgePlanes<T>& edges) {
    const Lattice lattice = {vertices.rows, vertices.cols};
    split_planes(fine, vertices, edges);
    if (rules(order).has_vertex_step) spread_vertices<T>(order, lattice, vertices, edges);
    collect_edges<T>(order, lattice, {edges[0], edges[1], edges[2]}, vertices);
    for (int kind = 0; kind < kEdgeKinds; ++kind) {
        const GridView<T>& plane = edges[std::size_t(kind)];
        parallel_for(0, plane.rows, kRowsPerBlock, [&](std::int64_t first, std::int64_t last) {
            Buffer<T> targets(static_cast<std::size_t>(plane.cols));
            for (std::int64_t i = first; i < last; ++i) {
                collect_targets<T>(order, vertices, kind, i, plane.cols, targets.data());
                factors.scale_row(kind, i, targets.data());
                for (std::int64_t j = 0; j < plane.cols; ++j)
                    plane(i, j) -= targets[std::size_t(j)];
            }
        });
    }
}

#define RELIEF_INSTANTIATE(T)                                                                   \
    template void spread_vertices(int, Lattice, GridView<const T>, const EdgePlanes<T>&);       \
    template void collect_edges(int, Lattice, const EdgePlanes<const T>&, GridView<T>);         \
    template void collect_targets(int, GridView<const T>, int, std::int64_t, std::int64_t, T*); \
    template void transpose_level(int, const UpdateFactors&, GridView<const T>, GridView<T>,    \
                                  const EdgePlanes<T>&);
RELIEF_INSTANTIATE(float)
RELIEF_INSTANTIATE(double)
#undef RELIEF_INSTANTIATE

}  // namespace relief::multires::box
