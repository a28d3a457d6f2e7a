#include "relief/multires/edit.h"

#include <algorithm>
#include <limits>
#include <string>

#include "multires/cubic_rules.h"

namespace relief::multires {

namespace {

template <class T>
void add(Grid<T>& to, const Grid<T>& from) {
    for (std::int64_t r = 0; r < to.rows(); ++r)
        for (std::int64_t c = 0; c < to.cols(); ++c) to(r, c) += from(r, c);
}

/// The moves of one level as a field of scaling coefficients.
template <class T>
LevelCoefficients<T> field_of(const PyramidLayout& layout, const std::vector<Move>& moves,
                              int level) {
    LevelCoefficients<T> field;
    field.box = scaling_box(layout, level);
    for (int c = 0; c < layout.components; ++c) {
        Grid<T> plane(field.box.rows, field.box.cols, T(0));
        for (const Move& move : moves)
            if (move.level == level)
                plane(move.row - field.box.row0, move.col - field.box.col0) +=
                    static_cast<T>(move.delta[static_cast<std::size_t>(c)]);
        field.planes.push_back(std::move(plane));
    }
    return field;
}

}  // namespace

Status check_move(const PyramidLayout& layout, const Move& move) {
    if (move.level < 0 || move.level > layout.levels())
        return Error{ErrorCode::InvalidArgument,
                     "there is no level " + std::to_string(move.level) +
                         "; levels are 0 (finest) to " + std::to_string(layout.levels()),
                     ""};
    const LatticeBox box = scaling_box(layout, move.level);
    if (box.contains(move.row, move.col)) return {};
    return Error{ErrorCode::InvalidArgument,
                 "there is no control coefficient (" + std::to_string(move.row) + ", " +
                     std::to_string(move.col) + ") at level " + std::to_string(move.level) +
                     "; rows are " + std::to_string(box.row0) + " to " +
                     std::to_string(box.row0 + box.rows - 1) + ", columns " +
                     std::to_string(box.col0) + " to " + std::to_string(box.col0 + box.cols - 1),
                 ""};
}

template <class T>
Status apply_moves(Pyramid<T>& pyramid, const std::vector<Move>& moves) {
    for (const Move& move : moves) RELIEF_CHECK(check_move(pyramid.layout, move));
    const PyramidLayout& layout = pyramid.layout;
    for (int level = layout.levels(); level >= 0; --level) {
        if (std::none_of(moves.begin(), moves.end(),
                         [&](const Move& m) { return m.level == level; }))
            continue;
        // Analysis is linear: the bands above a move change by the analysis of the change alone.
        const LevelCoefficients<T> change = field_of<T>(layout, moves, level);
        auto difference = Pyramid<T>::allocate(layout);
        for (std::size_t c = 0; c < change.planes.size(); ++c)
            analyse_coefficients<T>(change.planes[c].view(), static_cast<int>(c), difference,
                                    level);
        for (std::size_t k = 0; k < pyramid.bands.size(); ++k) {
            if (layout.bands[k].level <= level && layout.bands[k].channel != 0) continue;
            for (std::size_t c = 0; c < change.planes.size(); ++c)
                add(pyramid.bands[k][c], difference.bands[k][c]);
        }
    }
    return {};
}

template <class T>
LevelCoefficients<T> displacement(const PyramidLayout& layout, const std::vector<Move>& moves,
                                  int level) {
    LevelCoefficients<T> sum = field_of<T>(layout, moves, level);
    int coarsest = level;
    for (const Move& move : moves) coarsest = std::max(coarsest, move.level);
    if (coarsest == level) return sum;
    LevelCoefficients<T> running = field_of<T>(layout, moves, coarsest);
    for (int l = coarsest; l > level; --l) {
        running = subdivide(layout, std::move(running), l, l - 1);
        const LevelCoefficients<T> here = field_of<T>(layout, moves, l - 1);
        for (std::size_t c = 0; c < here.planes.size(); ++c) add(running.planes[c], here.planes[c]);
    }
    return running;
}

namespace {

/// How far a scaling coefficient `levels` above reaches, in samples.
std::int64_t reach_of(const SchemeSpec& spec, int levels) {
    const std::int64_t scale = std::int64_t{1} << levels;
    if (spec.id != SchemeId::Cubic) return spec.order * scale - 1;  // M_ddd: |i|, |j| < d
    if (spec.exact) return levels == 0 ? 0 : std::numeric_limits<std::int32_t>::max();
    return (2 * cubic::kTaps - 1) * (scale - 1);  // each level: twice as far, and a step
}

}  // namespace

LatticeBox touched_box(const PyramidLayout& layout, const std::vector<Move>& moves, int level) {
    std::int64_t top = INT64_MAX, left = INT64_MAX, bottom = INT64_MIN, right = INT64_MIN;
    for (const Move& move : moves) {
        if (move.level < level) continue;
        const std::int64_t scale = std::int64_t{1} << (move.level - level);
        const std::int64_t reach = reach_of(layout.spec, move.level - level);
        top = std::min(top, move.row * scale - reach);
        bottom = std::max(bottom, move.row * scale + reach);
        left = std::min(left, move.col * scale - reach);
        right = std::max(right, move.col * scale + reach);
    }
    const std::int64_t step = std::int64_t{1} << level;
    top = std::max<std::int64_t>(top, 0);
    left = std::max<std::int64_t>(left, 0);
    bottom = std::min(bottom, (layout.rows + step - 1) / step - 1);
    right = std::min(right, (layout.cols + step - 1) / step - 1);
    if (top > bottom || left > right) return {0, 0, 0, 0};
    return {top, left, bottom - top + 1, right - left + 1};
}

#define RELIEF_INSTANTIATE(T)                                           \
    template Status apply_moves(Pyramid<T>&, const std::vector<Move>&); \
    template LevelCoefficients<T> displacement(const PyramidLayout&, const std::vector<Move>&, int);
RELIEF_INSTANTIATE(float)
RELIEF_INSTANTIATE(double)
#undef RELIEF_INSTANTIATE

}  // namespace relief::multires
