#pragma once

#include <array>
#include <cstdint>

/// Every number of scheme `box` (barycentric-mra.md sections 7 and 7.1), once.
namespace relief::multires::box {

struct Offset {
    int row;
    int col;
};

inline constexpr int kEdgeKinds = 3;

/// Edge k of coarse vertex x runs from x to x + kStep[k]; its midpoint is the fine point 2x +
/// kStep[k].
inline constexpr std::array<Offset, kEdgeKinds> kStep = {{{1, 0}, {0, 1}, {1, 1}}};

/// The two vertices opposite of edge k of x, relative to x.
inline constexpr std::array<std::array<Offset, 2>, kEdgeKinds> kOpposite = {
    {{{{1, 1}, {0, -1}}}, {{{1, 1}, {-1, 0}}}, {{{1, 0}, {0, 1}}}}};

/// fine vertex = centre * coarse vertex + ring * (sum of neighbouring fine edge points).
struct VertexRule {
    double centre;
    double ring;
};

/// The same relation solved for the coarse vertex.
constexpr VertexRule inverse(VertexRule rule) {
    return {1 / rule.centre, -rule.ring / rule.centre};
}

/// Where the update moves an edge coefficient: offset from x for edge kind 0, and which weight it
/// takes.
struct UpdateTap {
    Offset offset;
    int weight;
};

inline constexpr int kUpdateWeights = 5;
inline constexpr int kUpdateReach = 2;  ///< largest |row| and |col| of an offset
inline constexpr std::array<UpdateTap, 14> kUpdate = {{{{0, 0}, 0},
                                                       {{1, 0}, 0},
                                                       {{1, 1}, 1},
                                                       {{0, -1}, 1},
                                                       {{0, 1}, 2},
                                                       {{2, 1}, 2},
                                                       {{1, -1}, 2},
                                                       {{-1, -1}, 2},
                                                       {{-1, 0}, 3},
                                                       {{2, 0}, 3},
                                                       {{1, 2}, 4},
                                                       {{2, 2}, 4},
                                                       {{0, -2}, 4},
                                                       {{-1, -2}, 4}}};

/// The lattice symmetry that takes edge kind 0 to `kind`.
constexpr Offset for_kind(int kind, Offset o) {
    if (kind == 1) return {o.col, o.row};
    if (kind == 2) return {o.row, o.row - o.col};
    return o;
}

inline constexpr int kCurveReach = 3;

struct Rules {
    bool has_vertex_step;      ///< order 1 interpolates at vertices: no step 1
    VertexRule vertex;         ///< interior vertices, six edge points
    VertexRule border_vertex;  ///< vertices on one side of the rectangle, its two edge points;
                               ///< corners do not move
    double ends;               ///< prediction of an edge point from its two ends
    double opposite;           ///< and from the two opposite vertices
    double border_ends;        ///< edges of the rectangle's border: ends only
    int update_taps;           ///< how many entries of kUpdate have a weight
    std::array<double, kUpdateWeights> update;
    /// Curves: weights of the ends at distance 1, 2, 3 half-steps .. from the midpoint, both sides.
    std::array<double, kCurveReach> curve_update;
};

inline constexpr std::array<Rules, 2> kRules = {{
    {false,
     {1, 0},
     {1, 0},
     1.0 / 2,
     0,
     1.0 / 2,
     4,
     {3.0 / 16, -1.0 / 16, 0, 0, 0},
     {1.0 / 4, 0, 0}},
    {true,
     {2.0 / 5, 1.0 / 10},
     {1.0 / 2, 1.0 / 4},
     3.0 / 8,
     1.0 / 8,
     1.0 / 2,
     14,
     {0.335, -0.12, -0.045, -0.04, 0.0325},
     {0.51, -0.165, 0.03}},
}};

constexpr const Rules& rules(int order) {
    return kRules[static_cast<std::size_t>(order - 1)];
}

/// Size of the next coarser level along one side; a side of 1 or 2 stays.
constexpr std::int64_t coarser(std::int64_t n) {
    return n / 2 + 1;
}

/// A level's coarse lattice.
struct Lattice {
    std::int64_t rows;
    std::int64_t cols;

    [[nodiscard]] std::int64_t edge_rows(int kind) const {
        return rows - kStep[std::size_t(kind)].row;
    }
    [[nodiscard]] std::int64_t edge_cols(int kind) const {
        return cols - kStep[std::size_t(kind)].col;
    }
    [[nodiscard]] bool has_vertex(std::int64_t i, std::int64_t j) const {
        return i >= 0 && i < rows && j >= 0 && j < cols;
    }
    [[nodiscard]] bool has_edge(int kind, std::int64_t i, std::int64_t j) const {
        return i >= 0 && i < edge_rows(kind) && j >= 0 && j < edge_cols(kind);
    }
    [[nodiscard]] bool on_row_border(std::int64_t i) const { return i == 0 || i == rows - 1; }
    [[nodiscard]] bool on_col_border(std::int64_t j) const { return j == 0 || j == cols - 1; }
    /// Edges along a side of the rectangle lack an opposite vertex.
    [[nodiscard]] bool is_border_edge(int kind, std::int64_t i, std::int64_t j) const {
        return (kind == 0 && on_col_border(j)) || (kind == 1 && on_row_border(i));
    }
};

}  // namespace relief::multires::box
