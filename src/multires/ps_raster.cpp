#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "multires/ps_block.h"
#include "multires/ps_errors.h"
#include "relief/multires/ps_surface.h"

namespace relief::multires::ps {

using mesh::Index;

namespace {

constexpr double kTolerance = 1e-12;  ///< of a triangle's extent: samples on the boundary are in it
constexpr std::int64_t kBandRows = 64;
constexpr std::int64_t kFewSamples = 24;  ///< of a row, that are faster one by one

/// first .. last; none if last < first.
struct Range {
    std::int64_t first = 0;
    std::int64_t last = -1;
};

/// Ascending coordinates first + k step, step > 0.
class Axis {
  public:
    Axis(double first, double step, std::int64_t count)
        : inverse_(1 / step), count_(count), at_(count + 3, kInfinity) {
        for (std::int64_t k = 0; k < count; ++k) at_[k] = first + static_cast<double>(k) * step;
    }
    double operator[](std::int64_t k) const { return at_[k]; }
    [[nodiscard]] const double* data() const { return at_.data(); }

    /// The first coordinate that is not below a number.
    [[nodiscard]] std::int64_t first_not_below(double number) const {
        const std::int64_t k = estimate(number);
        return k + (at_[k] < number ? 1 : 0) + (at_[k + 1] < number ? 1 : 0) +
               (at_[k + 2] < number ? 1 : 0);
    }
    /// Which coordinates lie in [low, high].
    [[nodiscard]] Range inside(double low, double high) const {
        const std::int64_t k = estimate(high);
        const std::int64_t end = k + (at_[k] <= high ? 1 : 0) + (at_[k + 1] <= high ? 1 : 0) +
                                 (at_[k + 2] <= high ? 1 : 0);
        return {first_not_below(low), end - 1};
    }

  private:
    static constexpr double kInfinity = std::numeric_limits<double>::infinity();

    /// One or two less than the answer, or the answer: rounding moves it by less than one.
    [[nodiscard]] std::int64_t estimate(double number) const {
        const double place = (number - at_[0]) * inverse_ - 1;
        return static_cast<std::int64_t>(std::clamp(place, 0.0, static_cast<double>(count_)));
    }

    double inverse_;
    std::int64_t count_;
    std::vector<double> at_;
};

/// A triangle cut along horizontal lines. The ends of an edge are always taken in the same order,
/// so that neighbours see the same cut.
class Cutter {
  public:
    explicit Cutter(TriangleCorners v) : v_(v) {
        order(v_[0], v_[1]);
        order(v_[1], v_[2]);
        order(v_[0], v_[1]);
        const auto slope = [](Vec2 a, Vec2 b) { return (b.x - a.x) / (b.y - a.y); };
        slope_ = {slope(v_[0], v_[1]), slope(v_[1], v_[2]), slope(v_[0], v_[2])};
        tolerance_ = tolerance(v_);
    }

    [[nodiscard]] static double tolerance(const TriangleCorners& v) {
        const auto [left, right] = std::minmax({v[0].x, v[1].x, v[2].x});
        const auto [low, high] = std::minmax({v[0].y, v[1].y, v[2].y});
        return kTolerance * std::max(right - left, high - low);
    }
    /// Smallest and largest abscissa at height y.
    [[nodiscard]] std::array<double, 2> cut(double y) const {
        y = std::clamp(y, v_[0].y, v_[2].y);
        const double a = crossing(v_[0], v_[2], slope_[2], y);
        const int upper = y > v_[1].y ? 1 : 0;
        const double b = crossing(v_[upper], v_[upper + 1], slope_[upper], y);
        return {std::min(a, b) - tolerance_, std::max(a, b) + tolerance_};
    }

  private:
    static void order(Vec2& a, Vec2& b) {
        if (b.y < a.y || (b.y == a.y && b.x < a.x)) std::swap(a, b);
    }
    static double crossing(Vec2 from, Vec2 to, double slope, double y) {
        return y == to.y ? to.x : from.x + (y - from.y) * slope;
    }
    TriangleCorners v_;
    std::array<double, 3> slope_;
    double tolerance_;
};

/// The pieces of a triangle along horizontal lines.
class PieceCutter {
  public:
    /// On one side of Z, from left to right: the pieces, and between them the spokes, which at a
    /// height dy above Z lie slope dy to the right of it.
    struct Side {
        int cuts = 0;
        std::array<double, 6> slope{};
        std::array<int, 7> piece{};
    };

    explicit PieceCutter(const double* numbers) {
        const std::array<Vec2, 6> spokes = block::spokes(numbers);
        above_ = side_of(spokes, 1);
        below_ = side_of(spokes, -1);
    }

    [[nodiscard]] const Side& side(double dy) const { return dy >= 0 ? above_ : below_; }

  private:
    /// Piece k lies between spokes k and k + 1. From left to right they follow each other clockwise
    /// above Z, counter-clockwise below it.
    static Side side_of(const std::array<Vec2, 6>& spokes, int sign) {
        const auto beyond = [&](int k) { return sign * spokes[k % 6].y > 0; };
        const int turn = sign > 0 ? 5 : 1;
        const int after = sign > 0 ? 5 : 0;  // from a spoke to the piece on its right
        int k = 0;
        while (k < 5 && (!beyond(k) || beyond(k + 6 - turn))) ++k;
        Side side;
        side.piece[0] = (k + 5 - after) % 6;
        for (; side.cuts < 6 && beyond(k); k += turn) {
            side.slope[side.cuts] = spokes[k % 6].x / spokes[k % 6].y;
            side.piece[++side.cuts] = (k + after) % 6;
        }
        return side;
    }

    Side above_;
    Side below_;
};

/// Writes the values of a surface, one triangle after the other.
class Painter {
  public:
    Painter(const Surface& surface, const RasterFrame& frame, GridView<double> out, int component)
        : surface_(surface),
          out_(out),
          component_(component),
          flip_(frame.step.y < 0),
          x_(frame.first.x - surface.triangles().origin.x, frame.step.x, out.cols),
          y_(frame.first.y - surface.triangles().origin.y +
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

    [[nodiscard]] Range rows_of(const TriangleCorners& v) const {
        const auto [low, high] = std::minmax({v[0].y, v[1].y, v[2].y});
        const double tolerance = Cutter::tolerance(v);
        return y_.inside(low - tolerance, high + tolerance);
    }

    /// The triangles that reach into each band of rows, ascending.
    void list_triangles() {
        const mesh::PlaneTriangles& mesh = surface_.triangles();
        rows_.resize(mesh.triangles.size());
        for_each_index(rows_.size(), [&](Index t) { rows_[t] = rows_of(mesh.corners(t)); });
        begin_.assign(static_cast<std::size_t>((out_.rows + kBandRows - 1) / kBandRows + 1), 0);
        for (const Range& rows : rows_)
            for (std::int64_t band = first_band(rows); band < end_band(rows); ++band)
                ++begin_[band + 1];
        for (std::size_t band = 1; band < begin_.size(); ++band) begin_[band] += begin_[band - 1];
        triangles_.resize(begin_.back());
        std::vector<std::size_t> next(begin_.begin(), begin_.end() - 1);
        for (Index t = 0; t < rows_.size(); ++t)
            for (std::int64_t band = first_band(rows_[t]); band < end_band(rows_[t]); ++band)
                triangles_[next[band]++] = t;
    }
    static std::int64_t first_band(const Range& rows) { return rows.first / kBandRows; }
    static std::int64_t end_band(const Range& rows) {
        return rows.last < rows.first ? 0 : rows.last / kBandRows + 1;
    }

    void paint_triangle(Index t, Range band) const {
        const Range rows{std::max(rows_[t].first, band.first), std::min(rows_[t].last, band.last)};
        const Cutter cutter(surface_.triangles().corners(t));
        const double* numbers = surface_.numbers(t);
        const block::PieceFinder finder(numbers);
        std::optional<PieceCutter> pieces;
        for (std::int64_t row = rows.first; row <= rows.last; ++row) {
            const auto [left, right] = cutter.cut(y_[row]);
            const Range cols = x_.inside(left, right);
            if (cols.last - cols.first < kFewSamples) {
                paint_samples(numbers, finder, row, cols);
                continue;
            }
            if (!pieces) pieces.emplace(numbers);
            paint_pieces(numbers, *pieces, row, cols);
        }
    }

    void paint_samples(const double* numbers, const block::PieceFinder& finder, std::int64_t row,
                       Range cols) const {
        const Vec2 centre = block::centre(numbers);
        const double dy = y_[row] - centre.y;
        const double* x = x_.data();
        double* samples = out_.row(ascending(row));
        for (std::int64_t col = cols.first; col <= cols.last; ++col) {
            const Vec2 d{x[col] - centre.x, dy};
            const spline::PlaneJet start =
                block::centre_jet(numbers, finder.piece_of(d), component_);
            samples[col] = quadratic_jet(start, d).value;
        }
    }

    void paint_pieces(const double* numbers, const PieceCutter& pieces, std::int64_t row,
                      Range cols) const {
        const Vec2 centre = block::centre(numbers);
        const double dy = y_[row] - centre.y;
        const PieceCutter::Side& side = pieces.side(dy);
        for (int cut = 0; cut < side.cuts; ++cut) {
            const std::int64_t end = x_.first_not_below(centre.x + side.slope[cut] * dy);
            const std::int64_t last = std::min(cols.last, end - 1);
            paint_run(numbers, side.piece[cut], row, {cols.first, last});
            cols.first = std::max(cols.first, last + 1);
        }
        paint_run(numbers, side.piece[side.cuts], row, cols);
    }

    void paint_run(const double* numbers, int piece, std::int64_t row, Range cols) const {
        const Vec2 centre = block::centre(numbers);
        const spline::PlaneJet start = block::centre_jet(numbers, piece, component_);
        const double* x = x_.data();
        const double dy = y_[row] - centre.y;
        double* samples = out_.row(ascending(row));
        for (std::int64_t col = cols.first; col <= cols.last; ++col)
            samples[col] = quadratic_jet(start, {x[col] - centre.x, dy}).value;
    }

    const Surface& surface_;
    GridView<double> out_;
    int component_;
    bool flip_;
    Axis x_;
    Axis y_;
    std::vector<Range> rows_;         ///< of each triangle, upwards
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
    RELIEF_CHECK(check_frame(frame, surface.triangles().origin, out));
    if (component < 0 || component >= surface.components())
        return Error{ErrorCode::InvalidArgument,
                     "component_count: the surface has no such component",
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
            const Vec2 point = painter.point(row, col) + surface.triangles().origin;
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
