#include "edit/raster_net.h"

#include <algorithm>
#include <cmath>

namespace relief::edit {

Result<RasterNet> RasterNet::create(const codec::RasterFile& file,
                                    const std::vector<multires::Move>& moves, int level,
                                    const LatticeBox& window) {
    RasterNet net;
    net.level_ = level;
    net.window_ = window;
    RELIEF_TRY(net.coefficients_, file.coefficients(level, window));
    std::vector<multires::Move> coarser;
    for (const multires::Move& move : moves)
        if (move.level > level) coarser.push_back(move);
    if (coarser.empty()) return net;
    const auto moved = multires::displacement<double>(file.layout(), coarser, level);
    const LatticeBox& box = net.coefficients_.box;
    for (std::size_t c = 0; c < moved.planes.size(); ++c)
        for (std::int64_t r = 0; r < box.rows; ++r)
            for (std::int64_t k = 0; k < box.cols; ++k)
                net.coefficients_.planes[c](r, k) +=
                    moved.planes[c](box.row0 + r - moved.box.row0, box.col0 + k - moved.box.col0);
    return net;
}

bool RasterNet::depends_on(const std::vector<multires::Move>& moves) const {
    return std::any_of(moves.begin(), moves.end(),
                       [&](const multires::Move& move) { return move.level > level_; });
}

std::array<double, 4> RasterNet::coefficient(const MoveFields& fields, std::int64_t row,
                                             std::int64_t col) const {
    std::array<double, 4> sum = fields.at(level_, row, col);
    const LatticeBox& box = coefficients_.box;
    for (std::size_t c = 0; c < coefficients_.planes.size(); ++c)
        sum[c] += coefficients_.planes[c](row - box.row0, col - box.col0);
    return sum;
}

Vec3<double> RasterNet::place(const TileFrame& frame, const MoveFields& fields, std::int64_t row,
                              std::int64_t col) const {
    const std::array<double, 4> c = coefficient(fields, row, col);
    if (frame.parametric) return Vec3<double>{c[0], c[1], c[2]} - frame.origin;
    const double step = std::ldexp(1.0, level_);
    const Vec2 plan =
        frame.grid->page_place(step * static_cast<double>(row), step * static_cast<double>(col));
    return {plan.x, plan.y, c[0] - frame.origin.z};
}

void LatticeGraph::neighbours(std::uint64_t point, std::vector<std::uint64_t>& out) const {
    const LatticePoint here = point_of(all_, point);
    for (std::int64_t row = here.row - 1; row <= here.row + 1; ++row)
        for (std::int64_t col = here.col - 1; col <= here.col + 1; ++col) {
            const bool same = row == here.row && col == here.col;
            if (!same && all_.contains(row, col)) out.push_back(number_of(all_, row, col));
        }
}

double LatticeGraph::distance(std::uint64_t source, std::uint64_t, double, std::uint64_t to) const {
    const LatticePoint a = point_of(all_, source);
    const LatticePoint b = point_of(all_, to);
    const double step = std::ldexp(1.0, level_);
    return std::hypot(step * spacing_[0] * static_cast<double>(b.col - a.col),
                      step * spacing_[1] * static_cast<double>(b.row - a.row));
}

NetGeometry draw_net(const RasterNet& net, const LatticeBox& all, const TileFrame& frame,
                     const MoveFields& fields) {
    NetGeometry out;
    out.level = net.level();
    const LatticeBox& window = net.window();
    for (std::int64_t r = 0; r < window.rows; ++r)
        for (std::int64_t c = 0; c < window.cols; ++c) {
            const std::int64_t row = window.row0 + r;
            const std::int64_t col = window.col0 + c;
            const auto here = static_cast<std::uint32_t>(r * window.cols + c);
            out.position.push_back(page_point(net.place(frame, fields, row, col)));
            out.point.push_back(static_cast<std::uint32_t>(number_of(all, row, col)));
            if (c > 0) out.line.insert(out.line.end(), {here - 1, here});
            if (r > 0)
                out.line.insert(out.line.end(),
                                {here - static_cast<std::uint32_t>(window.cols), here});
        }
    return out;
}

}  // namespace relief::edit
