#include "codec/lattice_level.h"

#include <algorithm>

namespace relief::codec {

namespace {

/// How far margins are needed: predictors reach three cells.
constexpr std::int64_t kReach = 3;

using Values = MarginGrid<std::int32_t>;

/// Odd reflection 2 f(0) - f(k), kept within one span of the samples so that sums of neighbours
/// cannot overflow.
struct Reflection {
    std::int64_t lowest;
    std::int64_t highest;

    explicit Reflection(const LatticeLevel& level)
        : lowest(2 * std::int64_t{level.lowest} - level.highest),
          highest(2 * std::int64_t{level.highest} - level.lowest) {}

    [[nodiscard]] std::int32_t operator()(std::int32_t border, std::int32_t inside) const {
        return static_cast<std::int32_t>(
            std::clamp(2 * std::int64_t{border} - inside, lowest, highest));
    }
};

void reflect_columns(LatticeLevel& level, const Reflection& reflected) {
    const std::int64_t last = level.cols() - 1;
    for (std::int64_t r = -kReach; r < level.rows() + kReach; ++r) {
        std::int32_t* row = level.values.row(r);
        for (std::int64_t k = 1; k <= kReach; ++k) {
            const std::int64_t inside = std::min(k, last);
            if (level.borders.west) row[-k] = reflected(row[0], row[inside]);
            if (level.borders.east) row[last + k] = reflected(row[last], row[last - inside]);
        }
    }
}

void reflect_rows(LatticeLevel& level, const Reflection& reflected) {
    Values& values = level.values;
    const std::int64_t last = level.rows() - 1;
    for (std::int64_t k = 1; k <= kReach; ++k) {
        const std::int64_t inside = std::min(k, last);
        for (std::int64_t c = -kReach; c < level.cols() + kReach; ++c) {
            if (level.borders.north) values(-k, c) = reflected(values(0, c), values(inside, c));
            if (level.borders.south)
                values(last + k, c) = reflected(values(last, c), values(last - inside, c));
        }
    }
}

/// Calls visit(row, column) for the margin points up to `reach` cells out.
template <class Visit>
void visit_margins(const LatticeLevel& level, std::int64_t reach, Visit visit) {
    for (std::int64_t r = -reach; r < level.rows() + reach; ++r) {
        const bool inside = r >= 0 && r < level.rows();
        for (std::int64_t c = -reach; c < level.cols() + reach; ++c) {
            if (inside && c == 0) c = level.cols();
            visit(r, c);
        }
    }
}

}  // namespace

void reflect_borders(LatticeLevel& level) {
    const Reflection reflected(level);
    reflect_columns(level, reflected);
    reflect_rows(level, reflected);
}

LatticeLevel refine(LatticeLevel& coarse, std::int64_t rows, std::int64_t cols) {
    reflect_borders(coarse);
    LatticeLevel fine;
    fine.level = coarse.level - 1;
    fine.borders = coarse.borders;
    fine.lowest = coarse.lowest;
    fine.highest = coarse.highest;
    fine.values = Values::uninitialised(rows, cols);
    fine.quotients = MarginGrid<std::int16_t>::uninitialised(rows, cols);
    fine.valid = MarginGrid<std::uint8_t>::uninitialised(rows, cols);
    constexpr std::int64_t margin = Values::kMargin;
    for (std::int64_t r = -margin; r < rows + margin; r += 2) {
        std::int32_t* to = fine.values.row(r);
        const std::int32_t* from = coarse.values.row(r / 2);
        for (std::int64_t c = -margin; c < cols + margin; c += 2) to[c] = from[c / 2];
    }
    for (std::int64_t r = 0; r < rows; r += 2) {
        std::int16_t* to = fine.quotients.row(r);
        const std::int16_t* from = coarse.quotients.row(r / 2);
        for (std::int64_t c = 0; c < cols; c += 2) to[c] = from[c / 2];
    }
    return fine;
}

void fill_diagonal_margins(LatticeLevel& level) {
    Values& v = level.values;
    visit_margins(level, kReach, [&](std::int64_t r, std::int64_t c) {
        if ((r & 1) && (c & 1))
            v(r, c) =
                margin_mean(v(r - 1, c - 1), v(r - 1, c + 1), v(r + 1, c - 1), v(r + 1, c + 1));
    });
}

void fill_edge_margins(LatticeLevel& level) {
    Values& v = level.values;
    visit_margins(level, kReach - 1, [&](std::int64_t r, std::int64_t c) {
        if ((r + c) & 1) v(r, c) = margin_mean(v(r - 1, c), v(r + 1, c), v(r, c - 1), v(r, c + 1));
    });
}

}  // namespace relief::codec
