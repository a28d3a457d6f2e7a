#include "relief/codec/raster_surface.h"

#include <algorithm>
#include <cmath>
#include <string>

namespace relief::codec {

namespace {

Grid<std::uint8_t> cut_out(const Grid<std::uint8_t>& mask, const LatticeBox& box) {
    if (mask.empty()) return {};
    Grid<std::uint8_t> part(box.rows, box.cols);
    for (std::int64_t r = 0; r < box.rows; ++r)
        std::copy_n(mask.row(box.row0 + r) + box.col0, box.cols, part.row(r));
    return part;
}

}  // namespace

/// The samples that a part of a closed-loop file depends on, and no others, are decoded.
Status RasterSurface::create_part(const RasterFile& file, int level, const LatticeBox& part,
                                  const LatticeBox& all) {
    const LatticeBox wanted = spline::FvsSurface<double>::samples_for(part, all.rows, all.cols);
    RELIEF_TRY(const ControlPart control, file.control_part(level, wanted));
    RELIEF_CHECK(check_damage(control.damaged));
    mask_ = cut_out(control.mask, relative(part, wanted.row0, wanted.col0));
    for (const Grid<double>& plane : control.net.planes) {
        RELIEF_TRY(auto made,
                   multires::Surface<double>::create_fvs(
                       {plane.view(), wanted.row0, wanted.col0, all.rows, all.cols}, part));
        surfaces_.push_back(std::move(made));
    }
    return {};
}

Status RasterSurface::create_whole(const RasterFile& file, int level) {
    RELIEF_TRY(DecodedRaster decoded, file.decode_window(level, window_));
    RELIEF_CHECK(check_damage(decoded.damaged));
    mask_ = std::move(decoded.raster.mask);
    multires::LevelCoefficients<double> net;
    if (level == 0) {
        RELIEF_TRY(net.planes, file.control_net());
        const LatticeBox all = multires::scaling_box(file.layout(), 0);
        net.box = {all.row0, all.col0, 0, 0};
    } else {
        RELIEF_TRY(net, file.coefficients(level));
    }
    row0_ = static_cast<double>(net.box.row0);
    col0_ = static_cast<double>(net.box.col0);
    for (const Grid<double>& plane : net.planes) {
        RELIEF_TRY(auto made, multires::Surface<double>::create(file.spec(), plane.view()));
        surfaces_.push_back(std::move(made));
    }
    return {};
}

Result<RasterSurface> RasterSurface::create(const RasterFile& file, int level,
                                            const LatticeBox& window) {
    RELIEF_CHECK(file.check_window(level, window));
    RasterSurface surface;
    surface.window_ = window;
    const LatticeBox all = multires::scaling_box(file.layout(), level);
    if (!file.closed_loop() || all.rows < 2 || all.cols < 2) {
        RELIEF_CHECK(surface.create_whole(file, level));
        return surface;
    }
    const LatticeMargin margin = level == 0 ? file.margin() : LatticeMargin();
    const LatticeBox part{window.row0 + margin.rows, window.col0 + margin.cols, window.rows,
                          window.cols};
    RELIEF_CHECK(surface.create_part(file, level, part, all));
    surface.row0_ = -static_cast<double>(margin.rows);
    surface.col0_ = -static_cast<double>(margin.cols);
    return surface;
}

Result<const RasterSurface*> RasterSurfaces::around(int level, const LatticeBox& window) {
    const bool whole = !file_.closed_loop();
    const auto found = surfaces_.find(level);
    if (found != surfaces_.end() && (whole || found->second.window() == window))
        return &found->second;
    RELIEF_TRY(auto made, RasterSurface::create(file_, level, whole ? file_.box(level) : window));
    return &surfaces_.insert_or_assign(level, std::move(made)).first->second;
}

bool RasterSurface::valid(double i, double j) const {
    if (mask_.empty()) return true;
    const auto nearest = [](double x, std::int64_t first, std::int64_t count) {
        return std::clamp<std::int64_t>(std::llround(x) - first, 0, count - 1);
    };
    return mask_(nearest(i, window_.row0, window_.rows), nearest(j, window_.col0, window_.cols)) !=
           0;
}

Status RasterSurface::evaluate(int component, std::span<const double> i, std::span<const double> j,
                               int derivatives, const spline::JetSpans<double>& out) const {
    const auto& surface = surfaces_[static_cast<std::size_t>(component)];
    if (row0_ == 0 && col0_ == 0) return surface.evaluate(i, j, derivatives, out);
    std::vector<double> rows(i.begin(), i.end());
    std::vector<double> cols(j.begin(), j.end());
    for (double& row : rows) row -= row0_;
    for (double& col : cols) col -= col0_;
    return surface.evaluate(rows, cols, derivatives, out);
}

void RasterSurface::evaluate_grid(int component, double i0, double di, double j0, double dj,
                                  GridView<double> out) const {
    surfaces_[static_cast<std::size_t>(component)].evaluate_grid(i0 - row0_, di, j0 - col0_, dj,
                                                                 out);
}

}  // namespace relief::codec
