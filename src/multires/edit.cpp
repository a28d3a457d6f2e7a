#include "relief/multires/edit.h"

#include <algorithm>
#include <limits>
#include <string>

#include "multires/cubic_rules.h"
#include "relief/multires/fvs.h"

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

/// Whether analysis of the scaling coefficients of `level` gives a band.
bool changes_with(const PyramidLayout& layout, const BandLayout& band, int level) {
    if (layout.spec.id == SchemeId::Fvs) return fvs::follows_values_of(layout, band, level);
    return band.level > level || band.channel == 0;
}

/// Each level's moves by themselves: estimated derivatives belong to the level that was moved.
template <class T>
LevelCoefficients<T> fvs_displacement(const PyramidLayout& layout, const std::vector<Move>& moves,
                                      int level) {
    LevelCoefficients<T> sum = field_of<T>(layout, moves, level);
    for (int l = level + 1; l <= layout.levels(); ++l) {
        if (std::none_of(moves.begin(), moves.end(), [&](const Move& m) { return m.level == l; }))
            continue;
        const auto part = subdivide(layout, field_of<T>(layout, moves, l), l, level);
        for (std::size_t c = 0; c < part.planes.size(); ++c) add(sum.planes[c], part.planes[c]);
    }
    return sum;
}

/// The first and last point of `level` that a move of the point k of n at a level `scale` times as
/// coarse can change.
fvs::LatticeRange reach_of(const PyramidLayout& layout, std::int64_t k, std::int64_t n,
                           std::int64_t scale) {
    const SchemeSpec& spec = layout.spec;
    if (spec.id == SchemeId::Fvs) {
        const fvs::LatticeRange range = fvs::cardinal_support(k, n);
        return {range.first * scale, range.last * scale};
    }
    std::int64_t reach = spec.order * scale - 1;  // M_ddd lives on |i|, |j| < d
    if (spec.id == SchemeId::Cubic && spec.exact)
        reach = scale == 1 ? 0 : std::numeric_limits<std::int32_t>::max();
    else if (spec.id == SchemeId::Cubic)
        reach = (2 * cubic::kTaps - 1) * (scale - 1);  // each level: twice as far, and a step
    return {k * scale - reach, k * scale + reach};
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
            if (!changes_with(layout, layout.bands[k], level)) continue;
            for (std::size_t c = 0; c < change.planes.size(); ++c)
                add(pyramid.bands[k][c], difference.bands[k][c]);
        }
    }
    return {};
}

template <class T>
LevelCoefficients<T> displacement(const PyramidLayout& layout, const std::vector<Move>& moves,
                                  int level) {
    if (layout.spec.id == SchemeId::Fvs) return fvs_displacement<T>(layout, moves, level);
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

LatticeBox touched_box(const PyramidLayout& layout, const std::vector<Move>& moves, int level) {
    std::int64_t top = INT64_MAX, left = INT64_MAX, bottom = INT64_MIN, right = INT64_MIN;
    for (const Move& move : moves) {
        if (move.level < level) continue;
        const std::int64_t scale = std::int64_t{1} << (move.level - level);
        const LatticeBox box = scaling_box(layout, move.level);
        const fvs::LatticeRange rows = reach_of(layout, move.row, box.rows, scale);
        const fvs::LatticeRange cols = reach_of(layout, move.col, box.cols, scale);
        top = std::min(top, rows.first);
        bottom = std::max(bottom, rows.last);
        left = std::min(left, cols.first);
        right = std::max(right, cols.last);
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
