#include "edit/raster_tiles.h"

#include <algorithm>
#include <cmath>

#include "edit/curvature.h"

namespace relief::edit {

namespace {

/// Samples of a side of the lattice at a level of detail: every 2^lod-th, and the last.
std::int64_t samples_of(std::int64_t count, int lod) {
    const std::int64_t step = std::int64_t{1} << lod;
    return (count - 1 + step - 1) / step + 1;
}

struct Span {
    std::int64_t first = 0;
    std::int64_t count = 0;
};

/// Samples of a tile along one side.
Span tile_span(std::int64_t count, int lod, std::int64_t number) {
    const std::int64_t all = samples_of(count, lod);
    const std::int64_t first = number * TileGrid::kTile;
    const std::int64_t last = std::min(first + TileGrid::kTile, all - 1);
    return {first, last - first + 1};
}

bool has_tile(std::int64_t count, int lod, std::int64_t number) {
    const std::int64_t cells = std::max<std::int64_t>(samples_of(count, lod) - 1, 1);
    return number >= 0 && number <= (cells - 1) / TileGrid::kTile;
}

std::vector<double> places_along(std::int64_t count, int lod, std::int64_t first,
                                 std::int64_t samples) {
    std::vector<double> places;
    for (std::int64_t q = first; q < first + samples; ++q)
        places.push_back(static_cast<double>(std::min(q << lod, count - 1)));
    return places;
}

/// The samples first .. of a tile whose places lie in lattice points low .. high.
Span span_in(std::int64_t count, int lod, const Span& tile, std::int64_t low, std::int64_t high) {
    const std::int64_t step = std::int64_t{1} << lod;
    const std::int64_t all = samples_of(count, lod);
    const std::int64_t first = std::max(tile.first, (low + step - 1) / step);
    const std::int64_t end = high >= count - 1 ? all - 1 : high / step;
    const std::int64_t last = std::min(tile.first + tile.count - 1, end);
    return {first - tile.first, std::max<std::int64_t>(last - first + 1, 0)};
}

}  // namespace

int TileGrid::coarsest() const {
    int lod = 0;
    while (samples_of(std::max(rows, cols), lod) - 1 > kTile) ++lod;
    return lod;
}

Result<LatticeBox> TileGrid::rect_of(const TileName& name) const {
    const bool known = name.lod >= 0 && name.lod <= coarsest() &&
                       has_tile(rows, name.lod, name.row) && has_tile(cols, name.lod, name.col);
    if (!known)
        return Error{ErrorCode::InvalidArgument,
                     "there is no tile " + std::to_string(name.row) + ", " +
                         std::to_string(name.col) + " of detail " + std::to_string(name.lod),
                     ""};
    return LatticeBox{0, 0, tile_span(rows, name.lod, name.row).count,
                      tile_span(cols, name.lod, name.col).count};
}

Places TileGrid::places_of(const TileName& name, const LatticeBox& rect) const {
    return {name.lod, places_along(rows, name.lod, name.row * kTile + rect.row0, rect.rows),
            places_along(cols, name.lod, name.col * kTile + rect.col0, rect.cols)};
}

LatticeBox TileGrid::part_in(const TileName& name, const LatticeBox& box) const {
    const Span r = span_in(rows, name.lod, tile_span(rows, name.lod, name.row), box.row0,
                           box.row0 + box.rows - 1);
    const Span c = span_in(cols, name.lod, tile_span(cols, name.lod, name.col), box.col0,
                           box.col0 + box.cols - 1);
    return {r.first, c.first, r.count, c.count};
}

Vec2 TileGrid::page_place(double row, double col) const {
    return {spacing[0] * (col - static_cast<double>(margin.cols)),
            -spacing[1] * (row - static_cast<double>(margin.rows))};
}

Vec2 TileGrid::lattice_place(Vec2 page) const {
    return {static_cast<double>(margin.rows) - page.y / spacing[1],
            static_cast<double>(margin.cols) + page.x / spacing[0]};
}

namespace {

/// Sample k of a parametric surface, in data coordinates.
Vec3<double> point(const std::vector<Jets>& c, std::size_t k) {
    return {c[0].value[k], c[1].value[k], c[2].value[k]};
}

}  // namespace

Vec3<double> TileFrame::place(const std::vector<Jets>& components, const Places& places,
                              std::size_t k) const {
    if (parametric) return point(components, k) - origin;
    const Vec2 plan =
        grid->page_place(places.rows[k / places.cols.size()], places.cols[k % places.cols.size()]);
    return {plan.x, plan.y, components[0].value[k] - origin.z};
}

namespace {

Vec3<double> along_columns(const TileFrame& frame, const std::vector<Jets>& c, std::size_t k) {
    if (frame.parametric) return {c[0].dj[k], c[1].dj[k], c[2].dj[k]};
    return {frame.grid->spacing[0], 0, c[0].dj[k]};
}

Vec3<double> up_the_rows(const TileFrame& frame, const std::vector<Jets>& c, std::size_t k) {
    if (frame.parametric) return {-c[0].di[k], -c[1].di[k], -c[2].di[k]};
    return {0, frame.grid->spacing[1], -c[0].di[k]};
}

}  // namespace

Vec3<double> TileFrame::normal(const std::vector<Jets>& components, std::size_t k) const {
    return unit(cross(along_columns(*this, components, k), up_the_rows(*this, components, k)));
}

double TileFrame::curvature(const std::vector<Jets>& c, std::size_t k) const {
    SurfaceDerivatives d;
    d.u = along_columns(*this, c, k);
    d.v = up_the_rows(*this, c, k);
    if (parametric) {
        d.uu = {c[0].djj[k], c[1].djj[k], c[2].djj[k]};
        d.uv = {-c[0].dij[k], -c[1].dij[k], -c[2].dij[k]};
        d.vv = {c[0].dii[k], c[1].dii[k], c[2].dii[k]};
    } else {
        d.uu.z = c[0].djj[k];
        d.uv.z = -c[0].dij[k];
        d.vv.z = c[0].dii[k];
    }
    return mean_curvature(d, unit(cross(d.u, d.v)));
}

void TileFrame::draw(const Places& places, const OriginalSurfaces::Part& part,
                     TileGeometry& out) const {
    const std::vector<Jets>& components = part.components;
    const std::size_t count = places.count();
    out.normal.resize(count);
    for (std::size_t k = 0; k < count; ++k) out.normal[k] = packed_normal(normal(components, k));
    if (parametric) {
        out.position.resize(count);
        for (std::size_t k = 0; k < count; ++k)
            out.position[k] = page_point(point(components, k) - origin);
    } else {
        out.height.resize(count);
        for (std::size_t k = 0; k < count; ++k)
            out.height[k] = static_cast<float>(components[0].value[k] - origin.z);
    }
    if (!components[0].dii.empty()) {
        out.curvature.resize(count);
        for (std::size_t k = 0; k < count; ++k)
            out.curvature[k] = static_cast<float>(curvature(components, k));
    }
    out.valid = part.valid;
    const auto step = [](const std::vector<double>& along) {
        return along.size() > 1 ? along[1] - along[0] : 1.0;
    };
    const Vec2 first = grid->page_place(places.rows.front(), places.cols.front());
    const Vec2 last = grid->page_place(places.rows.back(), places.cols.back());
    out.x0 = first.x;
    out.y0 = first.y;
    out.x1 = last.x;
    out.y1 = last.y;
    out.dx = grid->spacing[0] * step(places.cols);
    out.dy = -grid->spacing[1] * step(places.rows);
}

void TileFrame::draw_errors(const Places& places, const OriginalSurfaces::Part& part,
                            const OriginalSurfaces::Part& original, TileGeometry& out) const {
    out.error.resize(places.count());
    const auto& now = part.components;
    const auto& before = original.components;
    for (std::size_t k = 0; k < out.error.size(); ++k) {
        if (parametric) {
            const Vec3<double> off = point(now, k) - point(before, k);
            out.error[k] =
                static_cast<float>(std::copysign(length(off), dot(off, normal(before, k))));
        } else {
            out.error[k] = static_cast<float>(now[0].value[k] - before[0].value[k]);
        }
    }
}

}  // namespace relief::edit
