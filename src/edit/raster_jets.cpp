#include "edit/raster_jets.h"

#include <algorithm>
#include <cmath>

#include "relief/multires/surface.h"

namespace relief::edit {

namespace {

using multires::PyramidLayout;
using multires::SchemeId;
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

Result<const codec::RasterSurface*> OriginalSurfaces::surface(int level,
                                                              const LatticeBox& window) const {
    const auto found = surfaces_.find(level);
    const bool whole = !file_->closed_loop();
    if (found != surfaces_.end() && (whole || found->second.window() == window))
        return &found->second;
    RELIEF_TRY(auto made,
               codec::RasterSurface::create(*file_, level, whole ? file_->box(level) : window));
    return &surfaces_.insert_or_assign(level, std::move(made)).first->second;
}

Result<OriginalSurfaces::Part> OriginalSurfaces::part(int level, const Places& places,
                                                      int derivatives) const {
    const int here = std::min(std::max(level, places.lod), file_->layout().levels());
    const codec::LatticeMargin margin = here == 0 ? file_->margin() : codec::LatticeMargin();
    Places moved = places;
    for (double& row : moved.rows) row = std::max(row - static_cast<double>(margin.rows), 0.0);
    for (double& col : moved.cols) col = std::max(col - static_cast<double>(margin.cols), 0.0);
    const LatticeBox window = box_around(moved, here, 0, file_->box(here));
    RELIEF_TRY(const codec::RasterSurface* surface, this->surface(here, window));

    const Points points(moved, here, 0, 0);
    Part part;
    for (int c = 0; c < surface->components(); ++c) {
        Jets jets(places.count(), derivatives);
        RELIEF_CHECK(surface->evaluate(c, points.i, points.j, with_gradient(derivatives),
                                       spans_of(jets)));
        to_finest_steps(jets, here);
        part.components.push_back(std::move(jets));
    }
    if (!file_->has_holes()) return part;
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

Status MoveFields::add_to(std::vector<Jets>& components, int level, const Places& places,
                          int derivatives) const {
    for (int l = layout_->levels(); l >= level; --l)
        RELIEF_CHECK(add_field(components, l, places, derivatives));
    return {};
}

namespace {

/// How far from a cell the coefficients lie that its values depend on; of bicubic splines, to a
/// part in 10^9.
std::int64_t reach_of(const multires::SchemeSpec& spec) {
    return spec.id == SchemeId::Cubic ? 16 : spec.order + 1;
}

}  // namespace

Status MoveFields::add_field(std::vector<Jets>& components, int level, const Places& places,
                             int derivatives) const {
    const Field& field = fields_[static_cast<std::size_t>(level)];
    if (field.empty()) return {};
    const LatticeBox all = multires::scaling_box(*layout_, level);
    const bool fvs = layout_->spec.id == SchemeId::Fvs && all.rows > 1 && all.cols > 1;
    const LatticeBox window = box_around(places, level, 0, all);
    const LatticeBox crop =
        fvs ? spline::FvsSurface<double>::samples_for(window, all.rows, all.cols)
            : box_around(places, level, reach_of(layout_->spec), all);
    multires::Planes<double> planes;
    for (std::size_t c = 0; c < components.size(); ++c)
        planes.emplace_back(crop.rows, crop.cols, 0.0);
    bool any = false;
    for (std::int64_t row = crop.row0; row < crop.row0 + crop.rows; ++row) {
        auto entry = field.lower_bound({row, crop.col0});
        for (; entry != field.end() && entry->first < Key{row, crop.col0 + crop.cols}; ++entry)
            for (std::size_t c = 0; c < planes.size(); ++c) {
                planes[c](row - crop.row0, entry->first.second - crop.col0) = entry->second[c];
                any = any || entry->second[c] != 0;
            }
    }
    if (!any) return {};
    const Points points(places, level, fvs ? 0 : static_cast<double>(crop.row0),
                        fvs ? 0 : static_cast<double>(crop.col0));
    for (std::size_t c = 0; c < planes.size(); ++c) {
        RELIEF_TRY(const auto surface,
                   fvs ? Surface::create_fvs({planes[c].view(), crop.row0, crop.col0, all.rows,
                                              all.cols},
                                             window)
                       : Surface::create(layout_->spec, planes[c].view()));
        Jets jets(places.count(), derivatives);
        RELIEF_CHECK(surface.evaluate(points.i, points.j, with_gradient(derivatives),
                                      spans_of(jets)));
        to_finest_steps(jets, level);
        add(components[c], jets);
    }
    return {};
}

}  // namespace relief::edit
