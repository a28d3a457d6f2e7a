#include "multires/box_factors.h"

#include <algorithm>
#include <cmath>

#include "multires/box_adjoint.h"
#include "relief/core/rows.h"

namespace relief::multires::box {

namespace {

/// One level's integrals, fine (edges) and then coarse (vertices).
struct Integrals {
    Grid<double> vertices;
    std::array<Grid<double>, kEdgeKinds> edges;

    [[nodiscard]] EdgeWindows<const double> edge_windows() const {
        return {edges[0].view(), edges[1].view(), edges[2].view()};
    }
};

/// fine(2i + row, 2j + col), where a padded line repeats the last one.
Grid<double> coset(const Grid<double>& fine, std::int64_t rows, std::int64_t cols, Offset o) {
    Grid<double> out(rows, cols);
    for (std::int64_t i = 0; i < rows; ++i)
        for (std::int64_t j = 0; j < cols; ++j)
            out(i, j) = fine(std::min(2 * i + o.row, fine.rows() - 1),
                             std::min(2 * j + o.col, fine.cols() - 1));
    return out;
}

Integrals coarse_integrals(int order, Lattice lattice, const Grid<double>& fine) {
    Integrals out;
    out.vertices = coset(fine, lattice.rows, lattice.cols, {0, 0});
    for (int kind = 0; kind < kEdgeKinds; ++kind)
        out.edges[std::size_t(kind)] =
            coset(fine, lattice.edge_rows(kind), lattice.edge_cols(kind), kStep[std::size_t(kind)]);
    const Integrals& done = out;
    if (rules(order).has_vertex_step)
        for (int kind = 0; kind < kEdgeKinds; ++kind)
            for (std::int64_t i = 0; i < lattice.edge_rows(kind); ++i)
                spread_vertices<double>(order, lattice, done.vertices.view(), kind, i,
                                        out.edges[std::size_t(kind)].row(i));
    for (std::int64_t i = 0; i < lattice.rows; ++i)
        collect_edges<double>(order, lattice, done.edge_windows(), i, out.vertices.row(i));
    return out;
}

std::array<Grid<double>, kEdgeKinds> factor_tables(int order, const Integrals& integrals) {
    std::array<Grid<double>, kEdgeKinds> tables;
    const Grid<double>& vertices = integrals.vertices;
    Grid<double> padded(vertices.rows() + 2 * kUpdateReach, vertices.cols() + 2 * kUpdateReach,
                        0.0);
    for (std::int64_t i = 0; i < vertices.rows(); ++i)
        std::copy_n(vertices.row(i), vertices.cols(), padded.row(i + kUpdateReach) + kUpdateReach);
    for (int kind = 0; kind < kEdgeKinds; ++kind) {
        const Grid<double>& edges = integrals.edges[std::size_t(kind)];
        Grid<double> factors(edges.rows(), edges.cols());
        for (std::int64_t i = 0; i < edges.rows(); ++i) {
            double* row = factors.row(i);
            TargetRows<double> targets;
            for (int o = 0; o < kTargetRows; ++o)
                targets[std::size_t(o)] = padded.row(i + o) + kUpdateReach;
            collect_targets<double>(order, targets, kind, edges.cols(), row);
            for (std::int64_t j = 0; j < edges.cols(); ++j) {
                row[j] = edges(i, j) / row[j];
                // Away from the border the quotient is 1 but for rounding.
                if (std::abs(row[j] - 1) < 1e-12) row[j] = 1;
            }
        }
        tables[std::size_t(kind)] = std::move(factors);
    }
    return tables;
}

Grid<double> resized(const Grid<double>& table, std::int64_t rows, std::int64_t cols) {
    Grid<double> out(rows, cols);
    for (std::int64_t i = 0; i < rows; ++i)
        for (std::int64_t j = 0; j < cols; ++j)
            out(i, j) =
                table(table_index(i, rows, table.rows()), table_index(j, cols, table.cols()));
    return out;
}

}  // namespace

double UpdateFactors::at(int kind, std::int64_t i, std::int64_t j) const {
    const Grid<double>& table = tables_[std::size_t(kind)];
    return table(table_index(i, lattice_.edge_rows(kind), table.rows()),
                 table_index(j, lattice_.edge_cols(kind), table.cols()));
}

template <class T>
void UpdateFactors::scale_row(int kind, std::int64_t i, T* coefficients) const {
    const Grid<double>& table = tables_[std::size_t(kind)];
    const std::int64_t n = lattice_.edge_cols(kind);
    const std::int64_t size = table.cols();
    const std::int64_t middle = (size - 1) / 2;
    const double* factors = table.row(table_index(i, lattice_.edge_rows(kind), table.rows()));
    for (std::int64_t j = 0; j < middle; ++j) coefficients[j] *= T(factors[j]);
    const std::int64_t constant = n - size + 1;
    const RowTap<T> scale = {coefficients + middle, T(factors[middle])};
    if (factors[middle] != 1) row_fir(coefficients + middle, constant, &scale, 1);
    for (std::int64_t j = middle + 1; j < size; ++j) coefficients[n - size + j] *= T(factors[j]);
}

std::vector<UpdateFactors> update_factors(int order, std::int64_t rows, std::int64_t cols,
                                          int levels) {
    std::vector<UpdateFactors> factors;
    Grid<double> fine(table_size(rows), table_size(cols), 1.0);
    for (int level = 1; level <= levels; ++level) {
        const Lattice table_lattice = {coarser(fine.rows()), coarser(fine.cols())};
        const Integrals integrals = coarse_integrals(order, table_lattice, fine);
        rows = coarser(rows);
        cols = coarser(cols);
        factors.emplace_back(Lattice{rows, cols}, factor_tables(order, integrals));
        fine = resized(integrals.vertices, table_size(rows), table_size(cols));
    }
    return factors;
}

template void UpdateFactors::scale_row(int, std::int64_t, float*) const;
template void UpdateFactors::scale_row(int, std::int64_t, double*) const;

}  // namespace relief::multires::box
