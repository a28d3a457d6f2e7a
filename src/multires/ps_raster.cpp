#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "multires/ps_errors.h"
#include "relief/multires/ps_surface.h"

namespace relief::multires::ps {

using mesh::Index;
using spline::Hessian;
using spline::PsPolynomials;

namespace {

constexpr double kTolerance = 1e-12;  ///< of a triangle's extent: samples on the boundary are in it
constexpr std::int64_t kBandRows = 64;

/// first .. last; none if last < first.
struct Range {
    std::int64_t first = 0;
    std::int64_t last = -1;
};

/// Ascending coordinates first + k step, step > 0.
class Axis {
  public:
    Axis(double first, double step, std::int64_t count) : inverse_(1 / step), at_(count) {
        for (std::int64_t k = 0; k < count; ++k) at_[k] = first + static_cast<double>(k) * step;
    }
    double operator[](std::int64_t k) const { return at_[k]; }
    [[nodiscard]] const double* data() const { return at_.data(); }

    /// Which coordinates lie in [low, high].
    [[nodiscard]] Range inside(double low, double high) const {
        return {first_not_below(low), first_not_below(std::nextafter(high, kInfinity)) - 1};
    }

  private:
    static constexpr double kInfinity = std::numeric_limits<double>::infinity();

    /// An estimate, moved until it is right.
    [[nodiscard]] std::int64_t first_not_below(double low) const {
        const auto count = static_cast<std::int64_t>(at_.size());
        const double guess = std::clamp((low - at_[0]) * inverse_, 0.0, double(count));
        auto k = static_cast<std::int64_t>(guess);
        while (k > 0 && at_[k - 1] >= low) --k;
        while (k < count && at_[k] < low) ++k;
        return k;
    }

    double inverse_;
    std::vector<double> at_;
};

/// A triangle cut along horizontal lines. The ends of an edge are always taken in the same order,
/// so that neighbours see the same cut.
class Cutter {
  public:
    explicit Cutter(TriangleCorners v) : v_(v) {
        std::sort(v_.begin(), v_.end(),
                  [](Vec2 a, Vec2 b) { return a.y < b.y || (a.y == b.y && a.x < b.x); });
        const auto slope = [](Vec2 a, Vec2 b) { return (b.x - a.x) / (b.y - a.y); };
        slope_ = {slope(v_[0], v_[1]), slope(v_[1], v_[2]), slope(v_[0], v_[2])};
        const auto [left, right] = std::minmax({v_[0].x, v_[1].x, v_[2].x});
        tolerance_ = kTolerance * std::max(right - left, v_[2].y - v_[0].y);
    }

    [[nodiscard]] double low() const { return v_[0].y - tolerance_; }
    [[nodiscard]] double high() const { return v_[2].y + tolerance_; }
    /// Smallest and largest abscissa at height y.
    [[nodiscard]] std::array<double, 2> cut(double y) const {
        y = std::clamp(y, v_[0].y, v_[2].y);
        const double a = crossing(v_[0], v_[2], slope_[2], y);
        const double b = y <= v_[1].y ? crossing(v_[0], v_[1], slope_[0], y)
                                      : crossing(v_[1], v_[2], slope_[1], y);
        return {std::min(a, b) - tolerance_, std::max(a, b) + tolerance_};
    }

  private:
    static double crossing(Vec2 from, Vec2 to, double slope, double y) {
        return y == to.y ? to.x : from.x + (y - from.y) * slope;
    }
    TriangleCorners v_;
    std::array<double, 3> slope_;
    double tolerance_;
};

/// Writes the values of a surface, one triangle after the other.
class Painter {
  public:
    Painter(const Surface& surface, const RasterFrame& frame, GridView<double> out, int component)
        : surface_(surface),
          out_(out),
          component_(component),
          flip_(frame.step.y < 0),
          x_(frame.first.x - surface.space().mesh.origin.x, frame.step.x, out.cols),
          y_(frame.first.y - surface.space().mesh.origin.y +
                 (flip_ ? static_cast<double>(out.rows - 1) * frame.step.y : 0),
             std::abs(frame.step.y), out.rows) {}

    /// The sample, relative to the mesh's origin.
    [[nodiscard]] Vec2 point(std::int64_t row, std::int64_t col) const {
        return {x_[col], y_[ascending(row)]};
    }

    void paint() {
        list_triangles();
        parallel_for(0, out_.rows, kBandRows, [&](std::int64_t first, std::int64_t last) {
            for (std::int64_t row = first; row < last; ++row) {
                double* samples = out_.row(ascending(row));
                std::fill(samples, samples + out_.cols, std::numeric_limits<double>::quiet_NaN());
            }
            const std::int64_t band = first / kBandRows;
            // Backwards, so that of several triangles the one of the smallest number is last.
            for (std::size_t k = begin_[band + 1]; k-- > begin_[band];)
                paint_triangle(triangles_[k], {first, last - 1});
        });
    }

  private:
    /// Rows are counted upwards, those of the raster downwards if its step is negative.
    [[nodiscard]] std::int64_t ascending(std::int64_t row) const {
        return flip_ ? out_.rows - 1 - row : row;
    }

    [[nodiscard]] Range rows_of(const Cutter& cutter) const {
        return y_.inside(cutter.low(), cutter.high());
    }

    /// The triangles that reach into each band of rows, ascending.
    void list_triangles() {
        const mesh::Triangulation& mesh = surface_.space().mesh;
        std::vector<Range> bands(mesh.triangles.size());
        for_each_index(bands.size(), [&](Index t) {
            const Range rows = rows_of(Cutter(mesh.corners(t)));
            if (rows.first <= rows.last)
                bands[t] = {rows.first / kBandRows, rows.last / kBandRows};
        });
        begin_.assign(static_cast<std::size_t>((out_.rows + kBandRows - 1) / kBandRows + 1), 0);
        for (const Range& range : bands)
            for (std::int64_t band = range.first; band <= range.last; ++band) ++begin_[band + 1];
        for (std::size_t band = 1; band < begin_.size(); ++band) begin_[band] += begin_[band - 1];
        triangles_.resize(begin_.back());
        std::vector<std::size_t> next(begin_.begin(), begin_.end() - 1);
        for (Index t = 0; t < bands.size(); ++t)
            for (std::int64_t band = bands[t].first; band <= bands[t].last; ++band)
                triangles_[next[band]++] = t;
    }

    void paint_triangle(Index t, Range band) const {
        const Cutter cutter(surface_.space().mesh.corners(t));
        const Range all = rows_of(cutter);
        const Range rows{std::max(all.first, band.first), std::min(all.last, band.last)};
        if (rows.last < rows.first) return;
        const PsPolynomials spline = surface_.polynomials(t, component_);
        for (std::int64_t row = rows.first; row <= rows.last; ++row) {
            const auto [left, right] = cutter.cut(y_[row]);
            const Range cols = x_.inside(left, right);
            if (cols.first <= cols.last) paint_row(t, spline, row, cols);
        }
    }

    /// Pieces are convex: what lies between two samples of one piece is in it.
    void paint_row(Index t, const PsPolynomials& spline, std::int64_t row, Range cols) const {
        const auto piece_at = [&](std::int64_t col) {
            return surface_.piece_of(t, {x_[col], y_[row]});
        };
        const int last_piece = piece_at(cols.last);
        while (cols.first <= cols.last) {
            const int piece = piece_at(cols.first);
            std::int64_t end = cols.last + 1;
            if (piece != last_piece) {
                std::int64_t inside = cols.first;
                for (end = cols.last; end - inside > 1;) {
                    const std::int64_t middle = inside + (end - inside) / 2;
                    (piece_at(middle) == piece ? inside : end) = middle;
                }
            }
            paint_run(t, spline, piece, row, {cols.first, end - 1});
            cols.first = end;
        }
    }

    /// In the order of operations of PsPolynomials::jet.
    void paint_run(Index t, const PsPolynomials& spline, int piece, std::int64_t row,
                   Range cols) const {
        const Vec2 centre = surface_.space().split.centre[t];
        const Hessian& h = spline.hessian[piece];
        const double dy = y_[row] - centre.y;
        const double square = 0.5 * h.xx;
        const double slope = spline.gradient.x + h.xy * dy;
        const double value = spline.value + dy * (spline.gradient.y + 0.5 * h.yy * dy);
        const double* x = x_.data();
        double* samples = out_.row(ascending(row));
        for (std::int64_t col = cols.first; col <= cols.last; ++col) {
            const double dx = x[col] - centre.x;
            samples[col] = (square * dx + slope) * dx + value;
        }
    }

    const Surface& surface_;
    GridView<double> out_;
    int component_;
    bool flip_;
    Axis x_;
    Axis y_;
    std::vector<std::size_t> begin_;  ///< of each band, in triangles_
    std::vector<Index> triangles_;
};

/// Steps that coordinates can tell apart, none of which are infinite.
bool fine_steps(double first, double step, std::int64_t count) {
    const double last = first + static_cast<double>(count) * step;
    return std::max(std::abs(first), std::abs(last)) <= std::abs(step) * 0x1p50;
}

Status check_frame(const RasterFrame& frame, Vec2 origin, GridView<double> out) {
    if (frame.step.x > 0 && frame.step.y != 0 &&
        fine_steps(frame.first.x - origin.x, frame.step.x, out.cols) &&
        fine_steps(frame.first.y - origin.y, frame.step.y, out.rows))
        return {};
    return Error{ErrorCode::InvalidArgument,
                 "invalid_frame: first sample and steps must be finite, the step in x positive, "
                 "that in y not zero, and both large enough to tell coordinates apart",
                 ""};
}

}  // namespace

Status evaluate_raster(const Surface& surface, const RasterFrame& frame, GridView<double> out,
                       int component, Outside outside, const mesh::TriangleLocator* locator) {
    RELIEF_CHECK(check_frame(frame, surface.space().mesh.origin, out));
    if (component < 0 || component >= surface.components())
        return Error{ErrorCode::InvalidArgument, "component_count: the surface has no such component",
                     "component " + std::to_string(component)};
    if (outside == Outside::Nearest && locator == nullptr)
        return Error{ErrorCode::InvalidArgument,
                     "missing_locator: samples outside need it to find the boundary", ""};
    if (out.rows == 0 || out.cols == 0) return {};
    Painter painter(surface, frame, out, component);
    painter.paint();
    if (outside == Outside::Nan) return {};
    const std::size_t bad = first_failure(static_cast<std::size_t>(out.rows), [&](Index row) {
        for (std::int64_t col = 0; col < out.cols; ++col) {
            double& sample = out(row, col);
            if (!std::isnan(sample)) continue;
            if (outside == Outside::Reject) return false;
            const Vec2 point = painter.point(row, col) + surface.space().mesh.origin;
            const mesh::TrianglePlace place = locator->nearest(point);
            sample = surface.jet(place.triangle, place.point, component).value;
        }
        return true;
    });
    if (bad == static_cast<std::size_t>(out.rows)) return {};
    return bad_input(
        "outside_domain: a sample of the row lies in no triangle; ask for NaN or the nearest point",
        "row " + std::to_string(bad));
}

}  // namespace relief::multires::ps
