#include "relief/codec/raster_surface.h"

#include <algorithm>
#include <cmath>
#include <string>

namespace relief::codec {

Result<RasterSurface> RasterSurface::create(const RasterFile& file, int level,
                                            const LatticeBox& window) {
    RasterSurface surface;
    surface.window_ = window;
    RELIEF_TRY(DecodedRaster decoded, file.decode_window(level, window));
    if (!decoded.damaged.empty())
        return Error{ErrorCode::BadFile,
                     "chunks of the tiles around that place are damaged; 'decode --allow-damage' "
                     "fills them in from coarser ones",
                     "row " + std::to_string(decoded.damaged[0].row0) + ", column " +
                         std::to_string(decoded.damaged[0].col0)};
    surface.mask_ = std::move(decoded.raster.mask);
    const LatticeBox all = multires::scaling_box(file.layout(), level);
    const LatticeMargin margin = level == 0 ? file.margin() : LatticeMargin();
    const LatticeBox part{window.row0 + margin.rows, window.col0 + margin.cols, window.rows,
                          window.cols};
    const bool windowed = file.closed_loop() && all.rows > 1 && all.cols > 1;
    multires::LevelCoefficients<double> net;
    if (windowed) {
        RELIEF_TRY(net, file.coefficients(level, spline::FvsSurface<double>::samples_for(
                                                     part, all.rows, all.cols)));
    } else if (level == 0) {
        RELIEF_TRY(net.planes, file.control_net());
        net.box = {all.row0 + margin.rows, all.col0 + margin.cols, 0, 0};
    } else {
        RELIEF_TRY(net, file.coefficients(level));
    }
    surface.row0_ = static_cast<double>((windowed ? 0 : net.box.row0) - margin.rows);
    surface.col0_ = static_cast<double>((windowed ? 0 : net.box.col0) - margin.cols);
    for (const Grid<double>& plane : net.planes) {
        auto made = windowed
                        ? multires::Surface<double>::create_fvs(
                              {plane.view(), net.box.row0, net.box.col0, all.rows, all.cols}, part)
                        : multires::Surface<double>::create(file.spec(), plane.view());
        if (!made.ok()) return made.error();
        surface.surfaces_.push_back(*std::move(made));
    }
    return surface;
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
