#include "edit/raster_jets.h"

#include <algorithm>
#include <cmath>

#include "relief/multires/surface.h"

namespace relief::edit {

namespace {

using multires::PyramidLayout;
using multires::SchemeId;
using LevelCoefficients = multires::LevelCoefficients<double>;
using Surface = multires::Surface<double>;

/// First and last place.
struct Range {
    std::int64_t first = 0;
    std::int64_t last = 0;
};

/// The lattice points of a level around places, `reach` further on each side, inside `all`.
Range around(const std::vector<double>& places, int level, std::int64_t reach, std::int64_t first,
             std::int64_t count) {
    const double step = std::ldexp(1.0, -level);
    const auto low = static_cast<std::int64_t>(std::floor(step * places.front())) - reach;
    const auto high = static_cast<std::int64_t>(std::ceil(step * places.back())) + reach;
    const std::int64_t last = first + count - 1;
    return {std::clamp(low, first, last), std::clamp(high, first, last)};
}

LatticeBox box_around(const Places& places, int level, std::int64_t reach, const LatticeBox& all) {
    const Range rows = around(places.rows, level, reach, all.row0, all.rows);
    const Range cols = around(places.cols, level, reach, all.col0, all.cols);
    return {rows.first, cols.first, rows.last - rows.first + 1, cols.last - cols.first + 1};
}

/// Where the places are in the coordinates of a level, relative to (row0, col0).
struct Points {
    std::vector<double> i, j;

    Points(const Places& places, int level, double row0, double col0) {
        i.reserve(places.count());
        j.reserve(places.count());
        const double step = std::ldexp(1.0, -level);
        for (const double row : places.rows)
            for (const double col : places.cols) {
                i.push_back(step * row - row0);
                j.push_back(step * col - col0);
            }
    }
};

spline::JetSpans<double> spans_of(Jets& jets) {
    return {jets.value, jets.di, jets.dj, jets.dii, jets.dij, jets.djj};
}

void scale(std::vector<double>& numbers, double by) {
    for (double& number : numbers) number *= by;
}

/// Derivatives per step of a level to those per step of the finest lattice.
void to_finest_steps(Jets& jets, int level) {
    const double once = std::ldexp(1.0, -level);
    scale(jets.di, once);
    scale(jets.dj, once);
    for (auto* second : {&jets.dii, &jets.dij, &jets.djj}) scale(*second, once * once);
}

/// Evaluation needs value and gradient at least.
int with_gradient(int derivatives) {
    return std::max(derivatives, 1);
}

}  // namespace

Jets::Jets(std::size_t size, int derivatives) : value(size), di(size), dj(size) {
    if (derivatives < 2) return;
    for (auto* second : {&dii, &dij, &djj}) second->resize(size);
}

void add(Jets& to, const Jets& from) {
    const auto sum = [](std::vector<double>& a, const std::vector<double>& b) {
        for (std::size_t k = 0; k < a.size(); ++k) a[k] += b[k];
    };
    sum(to.value, from.value);
    sum(to.di, from.di);
    sum(to.dj, from.dj);
    sum(to.dii, from.dii);
    sum(to.dij, from.dij);
    sum(to.djj, from.djj);
}

Result<OriginalSurfaces::Part> OriginalSurfaces::part(int level, const Places& places,
                                                      int derivatives) const {
    const int here = std::min(std::max(level, places.lod), file_.layout().levels());
    const codec::LatticeMargin margin = here == 0 ? file_.margin() : codec::LatticeMargin();
    Places moved = places;
    for (double& row : moved.rows) row = std::max(row - static_cast<double>(margin.rows), 0.0);
    for (double& col : moved.cols) col = std::max(col - static_cast<double>(margin.cols), 0.0);
    const LatticeBox window = box_around(moved, here, 0, file_.box(here));
    RELIEF_TRY(const codec::RasterSurface* surface, surfaces_.around(here, window));

    const Points points(moved, here, 0, 0);
    Part part;
    for (int c = 0; c < surface->components(); ++c) {
        Jets jets(places.count(), derivatives);
        RELIEF_CHECK(
            surface->evaluate(c, points.i, points.j, with_gradient(derivatives), spans_of(jets)));
        to_finest_steps(jets, here);
        part.components.push_back(std::move(jets));
    }
    if (!file_.has_holes()) return part;
    part.valid.resize(places.count());
    for (std::size_t k = 0; k < places.count(); ++k)
        part.valid[k] = surface->valid(points.i[k], points.j[k]) ? 1 : 0;
    return part;
}

MoveFields::MoveFields(const PyramidLayout& layout)
    : layout_(&layout), fields_(static_cast<std::size_t>(layout.levels()) + 1) {}

bool MoveFields::empty() const {
    return std::all_of(fields_.begin(), fields_.end(), [](const Field& f) { return f.empty(); });
}

MoveFields::Undo MoveFields::add(const std::vector<multires::Move>& moves) {
    Undo undo;
    for (const multires::Move& move : moves) {
        Field& field = fields_[static_cast<std::size_t>(move.level)];
        const Key key{move.row, move.col};
        const auto found = field.find(key);
        undo.entries.push_back(
            {move.level, key, found == field.end() ? std::nullopt : std::optional(found->second)});
        Delta& sum = field[key];
        for (std::size_t c = 0; c < sum.size(); ++c) sum[c] += move.delta[c];
    }
    return undo;
}

void MoveFields::restore(const Undo& undo) {
    for (auto entry = undo.entries.rbegin(); entry != undo.entries.rend(); ++entry) {
        Field& field = fields_[static_cast<std::size_t>(entry->level)];
        if (entry->before)
            field[entry->key] = *entry->before;
        else
            field.erase(entry->key);
    }
}

MoveFields::Delta MoveFields::at(int level, std::int64_t row, std::int64_t col) const {
    const Field& field = fields_[static_cast<std::size_t>(level)];
    const auto found = field.find({row, col});
    return found == field.end() ? Delta{} : found->second;
}

namespace {

/// How far from a cell the coefficients lie that its values depend on; of bicubic splines, to a
/// part in 10^9.
std::int64_t reach_of(const multires::SchemeSpec& spec) {
    return spec.id == SchemeId::Cubic ? 16 : spec.order + 1;
}

/// How far from a coefficient those of the coarser level lie that it is subdivided from; with
/// SchemeSpec::exact all are, of which 16 are a part in 10^9 from it.
std::int64_t subdivision_reach(const multires::SchemeSpec& spec) {
    if (spec.id == SchemeId::Cubic) return spec.exact ? 16 : 7;
    return spec.order + 2;
}

LatticeBox hull(const LatticeBox& a, const LatticeBox& b) {
    if (a.count() == 0) return b;
    if (b.count() == 0) return a;
    const std::int64_t row0 = std::min(a.row0, b.row0);
    const std::int64_t col0 = std::min(a.col0, b.col0);
    return {row0, col0, std::max(a.row0 + a.rows, b.row0 + b.rows) - row0,
            std::max(a.col0 + a.cols, b.col0 + b.cols) - col0};
}

LatticeBox grown(const LatticeBox& box, std::int64_t by, const LatticeBox& all) {
    return intersection({box.row0 - by, box.col0 - by, box.rows + 2 * by, box.cols + 2 * by}, all);
}

/// A part of a side of a lattice of `count` points on which subdivision gives points first .. last:
/// it begins with an even one, and ends with one or at the lattice's end, where rules for borders
/// apply if the scheme has some.
Range subdivided_part(std::int64_t first, std::int64_t last, std::int64_t count,
                      const multires::SchemeSpec& spec) {
    const std::int64_t reach = subdivision_reach(spec);
    const std::int64_t low = (first - 2 * reach) & ~std::int64_t{1};
    const std::int64_t high = (last + 2 * reach + 1) & ~std::int64_t{1};
    if (spec.id == SchemeId::Barycentric) return {low, high};
    return {std::max<std::int64_t>(low, 0), std::min(high, count - 1)};
}

void add_where_both(LevelCoefficients& to, const LevelCoefficients& from) {
    const LatticeBox both = intersection(to.box, from.box);
    for (std::size_t c = 0; c < to.planes.size(); ++c)
        for (std::int64_t row = both.row0; row < both.row0 + both.rows; ++row)
            for (std::int64_t col = both.col0; col < both.col0 + both.cols; ++col)
                to.planes[c](row - to.box.row0, col - to.box.col0) +=
                    from.planes[c](row - from.box.row0, col - from.box.col0);
}

LevelCoefficients zeros(const LatticeBox& box, int components) {
    LevelCoefficients net{box, {}};
    for (int c = 0; c < components; ++c) net.planes.emplace_back(box.rows, box.cols, 0.0);
    return net;
}

/// The part of places in a box of the finest lattice: first and end of rows, of columns.
struct PlacesPart {
    std::size_t row0 = 0, row1 = 0, col0 = 0, col1 = 0;

    PlacesPart(const Places& places, double low_row, double high_row, double low_col,
               double high_col) {
        const auto first = [](const std::vector<double>& all, double x) {
            return static_cast<std::size_t>(std::lower_bound(all.begin(), all.end(), x) -
                                            all.begin());
        };
        const auto end = [](const std::vector<double>& all, double x) {
            return static_cast<std::size_t>(std::upper_bound(all.begin(), all.end(), x) -
                                            all.begin());
        };
        row0 = first(places.rows, low_row);
        row1 = end(places.rows, high_row);
        col0 = first(places.cols, low_col);
        col1 = end(places.cols, high_col);
    }
    [[nodiscard]] bool empty() const { return row0 >= row1 || col0 >= col1; }
    [[nodiscard]] Places of(const Places& all) const {
        const auto part = [](const std::vector<double>& v, std::size_t a, std::size_t b) {
            return std::vector<double>(v.begin() + static_cast<std::ptrdiff_t>(a),
                                       v.begin() + static_cast<std::ptrdiff_t>(b));
        };
        return {all.lod, part(all.rows, row0, row1), part(all.cols, col0, col1)};
    }
    void add(Jets& to, const Jets& from, std::size_t cols) const {
        const auto sum = [&](std::vector<double>& a, const std::vector<double>& b) {
            std::size_t k = 0;
            for (std::size_t r = row0; r < row1 && !b.empty(); ++r)
                for (std::size_t c = col0; c < col1; ++c) a[r * cols + c] += b[k++];
        };
        sum(to.value, from.value);
        sum(to.di, from.di);
        sum(to.dj, from.dj);
        sum(to.dii, from.dii);
        sum(to.dij, from.dij);
        sum(to.djj, from.djj);
    }
};

}  // namespace

LatticeBox MoveFields::moved_in(int level, const LatticeBox& box) const {
    const Field& field = fields_[static_cast<std::size_t>(level)];
    LatticeBox moved;
    auto entry = field.lower_bound({box.row0, box.col0});
    for (; entry != field.end() && entry->first.first < box.row0 + box.rows; ++entry) {
        const auto [row, col] = entry->first;
        if (box.contains(row, col)) moved = hull(moved, {row, col, 1, 1});
    }
    return moved;
}

LevelCoefficients MoveFields::own(int level, const LatticeBox& window) const {
    LevelCoefficients net = zeros(window, layout_->components);
    const Field& field = fields_[static_cast<std::size_t>(level)];
    auto entry = field.lower_bound({window.row0, window.col0});
    for (; entry != field.end() && entry->first.first < window.row0 + window.rows; ++entry) {
        const auto [row, col] = entry->first;
        if (!window.contains(row, col)) continue;
        for (std::size_t c = 0; c < net.planes.size(); ++c)
            net.planes[c](row - window.row0, col - window.col0) = entry->second[c];
    }
    return net;
}

Result<std::optional<LevelCoefficients>> MoveFields::coefficients(int level,
                                                                  LatticeBox window) const {
    std::optional<LevelCoefficients> net;
    if (moved_in(level, window).count() > 0) net = own(level, window);
    const bool coarser = std::any_of(fields_.begin() + level + 1, fields_.end(),
                                     [](const Field& field) { return !field.empty(); });
    if (!coarser) return net;

    const std::int64_t step = std::int64_t{1} << level;
    multires::SchemeSpec spec = layout_->spec;
    spec.levels = 1;
    const Range rows = subdivided_part(window.row0, window.row0 + window.rows - 1,
                                       (layout_->rows + step - 1) / step, spec);
    const Range cols = subdivided_part(window.col0, window.col0 + window.cols - 1,
                                       (layout_->cols + step - 1) / step, spec);
    RELIEF_TRY(const PyramidLayout part,
               multires::layout(spec, rows.last - rows.first + 1, cols.last - cols.first + 1,
                                layout_->components));
    const LatticeBox low = multires::scaling_box(part, 1);
    const LatticeBox low_here = relative(low, -rows.first / 2, -cols.first / 2);
    const LatticeBox low_all = multires::scaling_box(*layout_, level + 1);
    RELIEF_TRY(const auto coarse, coefficients(level + 1, intersection(low_here, low_all)));
    if (!coarse) return net;
    LevelCoefficients local = zeros(low_here, layout_->components);
    add_where_both(local, *coarse);
    local.box = low;
    LevelCoefficients fine = multires::subdivide(part, std::move(local), 1, 0);
    fine.box = relative(fine.box, -rows.first, -cols.first);
    if (!net) net = zeros(window, layout_->components);
    add_where_both(*net, fine);
    return net;
}

Status MoveFields::add_surface(const LevelCoefficients& net, int level,
                               std::vector<Jets>& components, const Places& places,
                               int derivatives) const {
    const LatticeBox all = multires::scaling_box(*layout_, level);
    const bool fvs = layout_->spec.id == SchemeId::Fvs && all.rows > 1 && all.cols > 1;
    const LatticeBox window = box_around(places, level, 0, all);
    const Points points(places, level, fvs ? 0 : static_cast<double>(net.box.row0),
                        fvs ? 0 : static_cast<double>(net.box.col0));
    for (std::size_t c = 0; c < components.size(); ++c) {
        const GridView<const double> plane = net.planes[c].view();
        RELIEF_TRY(const auto surface,
                   fvs ? Surface::create_fvs(
                             {plane, net.box.row0, net.box.col0, all.rows, all.cols}, window)
                       : Surface::create(layout_->spec, plane));
        Jets jets(places.count(), derivatives);
        RELIEF_CHECK(
            surface.evaluate(points.i, points.j, with_gradient(derivatives), spans_of(jets)));
        to_finest_steps(jets, level);
        edit::add(components[c], jets);
    }
    return {};
}

Status MoveFields::add_own(std::vector<Jets>& components, int level, const Places& places,
                           int derivatives) const {
    const LatticeBox all = multires::scaling_box(*layout_, level);
    const std::int64_t reach = layout_->spec.id == SchemeId::Fvs ? 4 : reach_of(layout_->spec);
    const LatticeBox moved = moved_in(level, box_around(places, level, reach, all));
    if (moved.count() == 0) return {};
    const double step = std::ldexp(1.0, level);
    const auto place = [&](std::int64_t k) { return step * static_cast<double>(k); };
    const PlacesPart near(places, place(moved.row0 - reach), place(moved.row0 + moved.rows + reach),
                          place(moved.col0 - reach), place(moved.col0 + moved.cols + reach));
    if (near.empty()) return {};
    const Places part = near.of(places);
    const LatticeBox crop = grown(box_around(part, level, 0, all), reach, all);
    std::vector<Jets> jets(components.size(), Jets(part.count(), derivatives));
    RELIEF_CHECK(add_surface(own(level, crop), level, jets, part, derivatives));
    for (std::size_t c = 0; c < components.size(); ++c)
        near.add(components[c], jets[c], places.cols.size());
    return {};
}

Status MoveFields::add_to(std::vector<Jets>& components, int level, const Places& places,
                          int derivatives) const {
    if (empty()) return {};
    const bool fvs = layout_->spec.id == SchemeId::Fvs;
    // Moves of coarse levels are subdivided to where the surface is drawn; finer ones, and those
    // whose estimated derivatives belong to their level, are surfaces of their own.
    const int drawn =
        fvs ? layout_->levels() + 1 : std::min(std::max(level, places.lod), layout_->levels());
    for (int l = level; l < drawn; ++l) RELIEF_CHECK(add_own(components, l, places, derivatives));
    if (fvs) return {};
    const LatticeBox all = multires::scaling_box(*layout_, drawn);
    RELIEF_TRY(const auto net,
               coefficients(drawn, box_around(places, drawn, reach_of(layout_->spec), all)));
    return net ? add_surface(*net, drawn, components, places, derivatives) : Status();
}

}  // namespace relief::edit
