#pragma once

#include "multires/box_rules.h"
#include "multires/box_support.h"

/// The scheme written point by point from the specification: no rows, no strips, no collapsed
/// tables. Only the order of additions is that of the product, so that both must give the same
/// bits.
namespace relief::multires::box {

template <class T>
class ReferenceLevel {
  public:
    /// integrals: of the fine basis functions, double whatever T is; replaced by those of the
    /// coarse ones.
    ReferenceLevel(int order, std::int64_t fine_rows, std::int64_t fine_cols,
                   Grid<double>& integrals)
        : rules_(rules(order)),
          fine_rows_(fine_rows),
          fine_cols_(fine_cols),
          lattice_{coarser(fine_rows), coarser(fine_cols)},
          vertices(lattice_.rows, lattice_.cols) {
        for (int k = 0; k < kEdgeKinds; ++k) {
            edges[std::size_t(k)] = Grid<T>(lattice_.edge_rows(k), lattice_.edge_cols(k));
            factors_[std::size_t(k)] = Grid<double>(lattice_.edge_rows(k), lattice_.edge_cols(k));
        }
        coarsen(integrals);
    }

    void analyse(const Grid<T>& fine) {
        const auto sample = [&](std::int64_t i, std::int64_t j) { return padded(fine, i, j); };
        for_vertices(
            [&](std::int64_t i, std::int64_t j) { vertices(i, j) = sample(2 * i, 2 * j); });
        for_edges([&](int k, std::int64_t i, std::int64_t j) {
            edge(k, i, j) =
                sample(2 * i + kStep[std::size_t(k)].row, 2 * j + kStep[std::size_t(k)].col);
        });
        move_vertices(inverse(rules_.vertex), inverse(rules_.border_vertex));
        predict(T(-1));
        update(T(1));
    }

    Grid<T> synthesise() {
        update(T(-1));
        predict(T(1));
        move_vertices(rules_.vertex, rules_.border_vertex);
        Grid<T> fine(fine_rows_, fine_cols_);
        for (std::int64_t i = 0; i < fine_rows_; ++i)
            for (std::int64_t j = 0; j < fine_cols_; ++j)
                fine(i, j) = i % 2 == 0 && j % 2 == 0 ? vertices(i / 2, j / 2)
                                                      : edge(j % 2 == 0   ? 0
                                                             : i % 2 == 0 ? 1
                                                                          : 2,
                                                             i / 2, j / 2);
        return fine;
    }

  private:
    T& edge(int k, std::int64_t i, std::int64_t j) { return edges[std::size_t(k)](i, j); }
    bool is_corner(std::int64_t i, std::int64_t j) const {
        return lattice_.on_row_border(i) && lattice_.on_col_border(j);
    }

    static T padded(const Grid<T>& fine, std::int64_t i, std::int64_t j) {
        const std::int64_t m = fine.rows();
        const std::int64_t n = fine.cols();
        if (i < m && j < n) return fine(i, j);
        if (i < m) return 2 * fine(i, n - 1) - fine(i, n - 2);
        if (j < n) return 2 * fine(m - 1, j) - fine(m - 2, j);
        // Rows first, then columns.
        const T last = 2 * fine(m - 1, n - 1) - fine(m - 2, n - 1);
        const T before = 2 * fine(m - 1, n - 2) - fine(m - 2, n - 2);
        return 2 * last - before;
    }

    template <class Visit>
    void for_vertices(Visit visit) {
        for (std::int64_t i = 0; i < lattice_.rows; ++i)
            for (std::int64_t j = 0; j < lattice_.cols; ++j) visit(i, j);
    }
    template <class Visit>
    void for_edges(Visit visit) {
        for (int k = 0; k < kEdgeKinds; ++k)
            for (std::int64_t i = 0; i < lattice_.edge_rows(k); ++i)
                for (std::int64_t j = 0; j < lattice_.edge_cols(k); ++j) visit(k, i, j);
    }

    void move_vertices(VertexRule inner, VertexRule border) {
        if (!rules_.has_vertex_step) return;
        Grid<T> moved(lattice_.rows, lattice_.cols);
        for_vertices([&](std::int64_t i, std::int64_t j) {
            const T v = vertices(i, j);
            if (is_corner(i, j))
                moved(i, j) = v;
            else if (lattice_.on_row_border(i))
                moved(i, j) =
                    T(border.centre) * v + T(border.ring) * (edge(1, i, j - 1) + edge(1, i, j));
            else if (lattice_.on_col_border(j))
                moved(i, j) =
                    T(border.centre) * v + T(border.ring) * (edge(0, i - 1, j) + edge(0, i, j));
            else
                moved(i, j) =
                    T(inner.centre) * v + T(inner.ring) * (((edge(0, i - 1, j) + edge(0, i, j)) +
                                                            (edge(1, i, j - 1) + edge(1, i, j))) +
                                                           (edge(2, i - 1, j - 1) + edge(2, i, j)));
        });
        vertices = std::move(moved);
    }

    void predict(T sign) {
        for_edges([&](int k, std::int64_t i, std::int64_t j) {
            const Offset step = kStep[std::size_t(k)];
            const auto [a, b] = kOpposite[std::size_t(k)];
            const T ends = vertices(i, j) + vertices(i + step.row, j + step.col);
            const bool border = !lattice_.has_vertex(i + a.row, j + a.col) ||
                                !lattice_.has_vertex(i + b.row, j + b.col);
            if (border || rules_.opposite == 0)
                edge(k, i, j) = edge(k, i, j) + sign * T(0.5) * ends;
            else
                edge(k, i, j) =
                    edge(k, i, j) +
                    (sign * T(rules_.ends) * ends +
                     sign * T(rules_.opposite) *
                         (vertices(i + a.row, j + a.col) + vertices(i + b.row, j + b.col)));
        });
    }

    /// Vertex (i, j) gathers from edge (i, j) - offset.
    void update(T sign) {
        for_vertices([&](std::int64_t i, std::int64_t j) {
            T sum = 0;
            bool first_shift = true;
            for (int shift = -kUpdateReach; shift <= kUpdateReach; ++shift) {
                bool any = false;
                const T of_shift = shift_sum(sign, i, j, shift, any);
                if (!any) continue;
                sum = first_shift ? of_shift : sum + of_shift;
                first_shift = false;
            }
            vertices(i, j) = vertices(i, j) + sum;
        });
    }

    T shift_sum(T sign, std::int64_t i, std::int64_t j, int shift, bool& any) {
        T sum = 0;
        for (int w = 0; w < kUpdateWeights; ++w) {
            T edges_sum = 0;
            bool first = true;
            for (int k = 0; k < kEdgeKinds; ++k) {
                for (int t = 0; t < rules_.update_taps; ++t) {
                    const UpdateTap tap = kUpdate[std::size_t(t)];
                    const Offset o = for_kind(k, tap.offset);
                    if (tap.weight != w || -o.col != shift) continue;
                    const T e = scaled_edge(k, i - o.row, j - o.col);
                    edges_sum = first ? e : edges_sum + e;
                    first = false;
                }
            }
            if (first) continue;
            const T term = sign * T(rules_.update[std::size_t(w)]) * edges_sum;
            sum = any ? sum + term : term;
            any = true;
        }
        return sum;
    }

    T scaled_edge(int k, std::int64_t i, std::int64_t j) {
        if (!lattice_.has_edge(k, i, j)) return 0;
        return edge(k, i, j) * T(factors_[std::size_t(k)](i, j));
    }

    /// The factors of section 7.1: integrals of the edge functions over the weighted integrals of
    /// their targets.
    void coarsen(Grid<double>& integrals) {
        const auto fine = [&](std::int64_t i, std::int64_t j) {
            return integrals(std::min(i, integrals.rows() - 1), std::min(j, integrals.cols() - 1));
        };
        Grid<double> coarse(lattice_.rows, lattice_.cols);
        Grid<double> of_edge[kEdgeKinds];
        for_vertices([&](std::int64_t i, std::int64_t j) {
            const bool border = lattice_.on_row_border(i) || lattice_.on_col_border(j);
            const double centre = is_corner(i, j) ? 1
                                  : border        ? rules_.border_vertex.centre
                                                  : rules_.vertex.centre;
            coarse(i, j) = centre * fine(2 * i, 2 * j);
        });
        for (int k = 0; k < kEdgeKinds; ++k) {
            const Offset step = kStep[std::size_t(k)];
            const auto [a, b] = kOpposite[std::size_t(k)];
            of_edge[k] = grid_from<double>(
                lattice_.edge_rows(k), lattice_.edge_cols(k), [&](auto i, auto j) {
                    const auto ring = [&](std::int64_t vi, std::int64_t vj) {
                        const bool border =
                            lattice_.on_row_border(vi) || lattice_.on_col_border(vj);
                        const bool along = lattice_.is_border_edge(k, i, j);
                        const double t = !border                       ? rules_.vertex.ring
                                         : along && !is_corner(vi, vj) ? rules_.border_vertex.ring
                                                                       : 0;
                        return t * fine(2 * vi, 2 * vj);
                    };
                    return fine(2 * i + step.row, 2 * j + step.col) + ring(i, j) +
                           ring(i + step.row, j + step.col);
                });
            for (std::int64_t i = 0; i < of_edge[k].rows(); ++i) {
                for (std::int64_t j = 0; j < of_edge[k].cols(); ++j) {
                    const bool border = lattice_.is_border_edge(k, i, j);
                    const double ends = border ? 0.5 : rules_.ends;
                    coarse(i, j) += ends * of_edge[k](i, j);
                    coarse(i + step.row, j + step.col) += ends * of_edge[k](i, j);
                    if (border) continue;
                    coarse(i + a.row, j + a.col) += rules_.opposite * of_edge[k](i, j);
                    coarse(i + b.row, j + b.col) += rules_.opposite * of_edge[k](i, j);
                }
            }
        }
        for_edges([&](int k, std::int64_t i, std::int64_t j) {
            double targets = 0;
            for (int t = 0; t < rules_.update_taps; ++t) {
                const Offset o = for_kind(k, kUpdate[std::size_t(t)].offset);
                if (lattice_.has_vertex(i + o.row, j + o.col))
                    targets += rules_.update[std::size_t(kUpdate[std::size_t(t)].weight)] *
                               coarse(i + o.row, j + o.col);
            }
            factors_[std::size_t(k)](i, j) = of_edge[k](i, j) / targets;
        });
        integrals = std::move(coarse);
    }

    const Rules& rules_;
    std::int64_t fine_rows_;
    std::int64_t fine_cols_;
    Lattice lattice_;

  public:
    Grid<T> vertices;
    std::array<Grid<T>, kEdgeKinds> edges;
    /// Replaces the factors, whose last bit depends on the order in which integrals are added.
    void set_factors(std::array<Grid<double>, kEdgeKinds> factors) {
        factors_ = std::move(factors);
    }
    [[nodiscard]] const std::array<Grid<double>, kEdgeKinds>& factors() const { return factors_; }

  private:
    std::array<Grid<double>, kEdgeKinds> factors_;
};

}  // namespace relief::multires::box
