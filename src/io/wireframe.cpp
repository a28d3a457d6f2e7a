#include "relief/io/wireframe.h"

#include <algorithm>
#include <cmath>

#include "io/camera.h"

namespace relief::io {

namespace {

using detail::Box;
using detail::Camera;
using detail::Canvas;
using detail::direction;
using detail::Fit;
using detail::Light;
using detail::ScreenPoint;
using detail::Vec;

Vec point(const Sheet& sheet, std::int64_t r, std::int64_t c) {
    return {sheet.xyz[0](r, c), sheet.xyz[1](r, c), sheet.xyz[2](r, c)};
}

bool is_valid(const Sheet& sheet, std::int64_t r, std::int64_t c) {
    if (!sheet.mask.empty() && sheet.mask(r, c) == 0) return false;
    const Vec p = point(sheet, r, c);
    return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z);
}

template <class Visit>
void for_each_valid(const Sheet& sheet, Visit visit) {
    for (std::int64_t r = 0; r < sheet.xyz[0].rows(); ++r)
        for (std::int64_t c = 0; c < sheet.xyz[0].cols(); ++c)
            if (is_valid(sheet, r, c)) visit(point(sheet, r, c));
}

Fit fit(std::span<const Layer> layers, const Camera& camera, int width) {
    Box seen;
    for (const Layer& layer : layers)
        for_each_valid(*layer.sheet, [&](const Vec& p) { seen.add(camera.project(p)); });
    return fitted(seen, width);
}

/// Draws one sheet; all that depends on sheet and view is at hand.
class SheetPainter {
  public:
    SheetPainter(const Layer& layer, const Box& coloured, const Camera& camera, const Fit& fit,
                 const ViewOptions& view)
        : sheet_(*layer.sheet),
          style_(layer.style),
          coloured_(coloured),
          camera_(camera),
          fit_(fit),
          sun_(direction(view.light.azimuth, view.light.altitude)),
          viewer_(direction(view.azimuth, view.altitude)) {}

    void fill(Canvas& canvas) const {
        if (style_.fill == SheetFill::None || rows() < 2 || cols() < 2) return;
        for (std::int64_t r = 0; r + 1 < rows(); ++r) {
            for (std::int64_t c = 0; c + 1 < cols(); ++c) {
                corner(canvas, {r, c}, {r + 1, c}, {r, c + 1});
                corner(canvas, {r + 1, c + 1}, {r, c + 1}, {r + 1, c});
            }
        }
    }

    void lines(Canvas& canvas) const {
        if (style_.line_every < 1) return;
        for (std::int64_t r = 0; r < rows(); ++r) {
            for (std::int64_t c = 0; c < cols(); ++c) {
                const bool row_line = on_line(r, rows());
                const bool col_line = on_line(c, cols());
                if (row_line && c + 1 < cols())
                    segment(canvas, {r, c}, {r, c + 1}, style_.line_width);
                if (col_line && r + 1 < rows())
                    segment(canvas, {r, c}, {r + 1, c}, style_.line_width);
                if (row_line && col_line && style_.dot_radius > 0)
                    segment(canvas, {r, c}, {r, c}, 2 * style_.dot_radius);
            }
        }
    }

  private:
    using Index = std::array<std::int64_t, 2>;

    [[nodiscard]] std::int64_t rows() const { return sheet_.xyz[0].rows(); }
    [[nodiscard]] std::int64_t cols() const { return sheet_.xyz[0].cols(); }
    [[nodiscard]] bool on_line(std::int64_t k, std::int64_t count) const {
        return k % style_.line_every == 0 || k == count - 1;
    }
    [[nodiscard]] bool valid(const Index& k) const { return is_valid(sheet_, k[0], k[1]); }
    [[nodiscard]] Vec at(const Index& k) const { return point(sheet_, k[0], k[1]); }
    [[nodiscard]] ScreenPoint on_screen(const Index& k) const {
        return fit_(camera_.project(at(k)));
    }

    void corner(Canvas& canvas, const Index& a, const Index& b, const Index& c) const {
        if (!valid(a) || !valid(b) || !valid(c)) return;
        canvas.triangle({on_screen(a), on_screen(b), on_screen(c)},
                        {colour(a), colour(b), colour(c)});
    }

    void segment(Canvas& canvas, const Index& a, const Index& b, double width) const {
        if (!valid(a) || !valid(b)) return;
        const double hidden = style_.fill == SheetFill::None ? 0.4 * style_.line_opacity : 0;
        canvas.line(on_screen(a), on_screen(b), width,
                    {style_.line_colour, style_.line_opacity, hidden, 4e-3});
    }

    /// The difference across k along one index, between the valid neighbours there are.
    [[nodiscard]] Vec tangent(const Index& k, std::size_t along) const {
        Index before = k;
        Index after = k;
        const std::int64_t count = along == 0 ? rows() : cols();
        if (k[along] > 0) --before[along];
        if (k[along] + 1 < count) ++after[along];
        return at(valid(after) ? after : k) - at(valid(before) ? before : k);
    }

    [[nodiscard]] Light colour(const Index& k) const {
        Vec normal = cross(tangent(k, 0), tangent(k, 1));
        const double norm = length(normal);
        // Both sides of a sheet are lit: the one that faces the viewer counts.
        const double side = dot(normal, viewer_) < 0 ? -1 : 1;
        const double cosine = norm > 0 ? side * dot(normal, sun_) / norm : sun_.z;
        const double span = coloured_.high.z - coloured_.low.z;
        const double z = at(k).z;
        double height = span > 0 ? (z - coloured_.low.z) / span : 0.5;
        if (coloured_.low.z < 0 && coloured_.high.z > 0)
            height = z < 0 ? -z / coloured_.low.z : z / coloured_.high.z;
        const Light paper = {0.92, 0.92, 0.92};
        const Light& base =
            style_.fill == SheetFill::ByHeight ? detail::height_light(height) : paper;
        return detail::lit(base, std::max(0.0, cosine), std::max(sun_.z, 0.2));
    }

    const Sheet& sheet_;
    const SheetStyle& style_;
    const Box& coloured_;  ///< its heights span the height ramp
    const Camera& camera_;
    const Fit& fit_;
    Vec sun_;
    Vec viewer_;
};

}  // namespace

Sheet height_sheet(Heights z, Mask mask, CellSize cell, double exaggeration,
                   std::array<double, 2> origin, std::int64_t every) {
    const auto thinned = [&](std::int64_t n) { return (n + every - 1) / every; };
    Sheet sheet;
    for (Grid<double>& plane : sheet.xyz) plane = Grid<double>(thinned(z.rows), thinned(z.cols));
    if (mask.count() > 0) sheet.mask = Grid<std::uint8_t>(thinned(z.rows), thinned(z.cols));
    for (std::int64_t r = 0; r < z.rows; r += every) {
        for (std::int64_t c = 0; c < z.cols; c += every) {
            sheet.xyz[0](r / every, c / every) = origin[0] + static_cast<double>(c) * cell.x;
            sheet.xyz[1](r / every, c / every) = -origin[1] - static_cast<double>(r) * cell.y;
            sheet.xyz[2](r / every, c / every) = z(r, c) * exaggeration;
            if (mask.count() > 0) sheet.mask(r / every, c / every) = mask(r, c);
        }
    }
    return sheet;
}

Sheet point_sheet(Heights x, Heights y, Heights z, Mask mask) {
    Sheet sheet = height_sheet(z, mask, {}, 1);
    for (std::int64_t r = 0; r < z.rows; ++r) {
        std::copy_n(x.row(r), z.cols, sheet.xyz[0].row(r));
        std::copy_n(y.row(r), z.cols, sheet.xyz[1].row(r));
    }
    return sheet;
}

Image draw_sheets(std::span<const Layer> layers, const ViewOptions& view) {
    Box box;
    Box coloured;  // a net that overshoots must not squeeze the colours of the ground
    for (const Layer& layer : layers)
        for_each_valid(*layer.sheet, [&](const Vec& p) {
            box.add(p);
            if (layer.style.fill != SheetFill::None) coloured.add(p);
        });
    if (box.empty()) return {};
    const Camera camera(box, {view.azimuth, view.altitude, view.field_of_view});
    const Fit to_pixels = fit(layers, camera, std::max(view.width, 16));
    Canvas canvas(to_pixels.width, to_pixels.height);
    for (const Layer& layer : layers)
        SheetPainter(layer, coloured, camera, to_pixels, view).fill(canvas);
    for (const Layer& layer : layers)
        SheetPainter(layer, coloured, camera, to_pixels, view).lines(canvas);
    return canvas.image(view.background == HoleStyle::Transparent ? 4 : 3);
}

Image wireframe(Heights z, Mask mask, CellSize cell, const ViewOptions& view, int lines) {
    const std::int64_t longer = std::max(z.rows, z.cols);
    const std::int64_t step = std::max<std::int64_t>(1, longer / std::max(view.width, 16));
    const double exaggeration = view.light.vertical_exaggeration > 0
                                    ? view.light.vertical_exaggeration
                                    : auto_exaggeration(z, mask, cell);
    const Sheet sheet = height_sheet(z, mask, cell, exaggeration, {0, 0}, step);
    SheetStyle style;
    if (lines > 0)
        style.line_every = static_cast<int>(std::max<std::int64_t>(1, longer / step / lines));
    style.line_opacity = 0.5;
    const Layer layer = {&sheet, style};
    return draw_sheets({&layer, 1}, view);
}

}  // namespace relief::io
