#include <algorithm>
#include <array>
#include <cmath>

#include "ps_verbs.h"
#include "relief/io/mesh_picture.h"
#include "relief/io/picture.h"

namespace relief::cli {

namespace ps = multires::ps;
using mesh::Index;

namespace {

/// Triangles that a surface is drawn with at most; beyond that each triangle is drawn as it is.
constexpr std::size_t kDrawn = 400000;
constexpr int kMostParts = 12;

/// Points in space as they are drawn.
struct View {
    Vec2 metres{1, 1};  ///< of a unit of x and of y: degrees are not as long as they are wide
    double exaggeration = 1;
    double low = 0;
    double high = 1;

    [[nodiscard]] std::array<double, 3> point(const std::array<double, 3>& p) const {
        return {p[0] * metres.x, p[1] * metres.y, p[2] * exaggeration};
    }
    /// sRGB from 0 to 1.
    [[nodiscard]] std::array<double, 3> colour(double height) const {
        const double land = low < 0 && high > 0 ? height / (height < 0 ? -low : high)
                            : high > low        ? (height - low) / (high - low)
                                                : 0;
        const auto rgb = io::height_colour(std::clamp(land, -1.0, 1.0));
        return {rgb[0] / 255.0, rgb[1] / 255.0, rgb[2] / 255.0};
    }
};

/// Points of a triangle with its sides cut into n parts: (i, j) is corner 0 + i / n of side 0 +
/// j / n of side 2, turned round.
class Patch {
  public:
    Patch(const PsLevel& level, Index t, int parts)
        : level_(level), t_(t), corners_(level.space().mesh.corners(t)), parts_(parts) {}

    [[nodiscard]] std::array<double, 3> at(int i, int j) const {
        const double u = static_cast<double>(i) / parts_;
        const double v = static_cast<double>(j) / parts_;
        const Vec2 place =
            corners_[0] + u * (corners_[1] - corners_[0]) + v * (corners_[2] - corners_[0]);
        std::array<double, 3> values{};
        const auto components = static_cast<std::size_t>(level_.surface.components());
        for (std::size_t m = 0; m < components; ++m)
            values[m] = level_.surface.jet(t_, place, static_cast<int>(m)).value;
        return codec::in_space(level_.space().mesh.origin + place,
                               std::span(values).first(components));
    }

  private:
    const PsLevel& level_;
    Index t_;
    TriangleCorners corners_;
    int parts_;
};

/// The surface as small triangles with colours by height.
PolygonMesh tessellated(const PsLevel& level, int parts, const View& view) {
    PolygonMesh mesh;
    MeshAttribute colours{"colour", 3};
    for (Index t = 0; t < level.space().mesh.triangle_count(); ++t) {
        const Patch patch(level, t, parts);
        const auto first = static_cast<std::int32_t>(mesh.vertices.size());
        for (int j = 0; j <= parts; ++j)
            for (int i = 0; i + j <= parts; ++i) {
                const std::array<double, 3> point = patch.at(i, j);
                mesh.vertices.push_back(view.point(point));
                const auto colour = view.colour(point[2]);
                colours.values.insert(colours.values.end(), colour.begin(), colour.end());
            }
        std::int32_t row = first;
        for (int j = 0; j < parts; ++j) {
            const std::int32_t above = row + parts - j + 1;
            for (int i = 0; i + j < parts; ++i) {
                mesh.add_polygon(std::array{row + i, row + i + 1, above + i});
                if (i + j + 1 < parts)
                    mesh.add_polygon(std::array{row + i + 1, above + i + 1, above + i});
            }
            row = above;
        }
    }
    mesh.attributes.push_back(std::move(colours));
    return mesh;
}

/// The sides of the triangles, as they lie on the surface.
PolygonMesh sides(const PsLevel& level, int parts, const View& view) {
    PolygonMesh net;
    for (Index t = 0; t < level.space().mesh.triangle_count(); ++t) {
        const Patch patch(level, t, parts);
        std::vector<std::int32_t> polygon;
        const auto add = [&](int i, int j) {
            polygon.push_back(static_cast<std::int32_t>(net.vertices.size()));
            net.vertices.push_back(view.point(patch.at(i, j)));
        };
        for (int k = 0; k < parts; ++k) add(k, 0);
        for (int k = 0; k < parts; ++k) add(parts - k, k);
        for (int k = 0; k < parts; ++k) add(0, parts - k);
        net.add_polygon(polygon);
    }
    return net;
}

/// The control triangles: planes that touch the surface at the vertices.
PolygonMesh control_triangles(const PsLevel& level, const View& view) {
    const ps::Space& space = level.space();
    PolygonMesh net;
    for (Index v = 0; v < space.mesh.vertex_count(); ++v) {
        const auto first = static_cast<std::int32_t>(net.vertices.size());
        for (std::size_t k = 0; k < 3; ++k) {
            std::vector<double> values;
            for (const ps::Coefficients& component : level.data->components)
                values.push_back(component[v][k]);
            const Vec2 place = space.mesh.origin + space.mesh.vertex(v) + space.control[v][k];
            net.vertices.push_back(view.point(codec::in_space(place, values)));
        }
        net.add_polygon(std::array{first, first + 1, first + 2});
    }
    return net;
}

/// Heights at samples all over the surface say how it is drawn. Surfaces in space are not
/// exaggerated unless that is asked for.
Result<View> view_of(const std::string& path, double exaggeration) {
    RELIEF_TRY(const Raster raster, picture_raster(path, 0, 256));
    const io::CellSize cell = io::cell_size_metres(raster.geo, raster.rows);
    const std::array<double, 6>& transform = *raster.geo.transform;
    View view{{cell.x / transform[1], cell.y / -transform[5]}, exaggeration, INFINITY, -INFINITY};
    for (std::int64_t r = 0; r < raster.rows; ++r)
        for (std::int64_t c = 0; c < raster.cols; ++c)
            if (raster.valid(r, c)) {
                view.low = std::min(view.low, raster.planes.back()(r, c));
                view.high = std::max(view.high, raster.planes.back()(r, c));
            }
    if (!(exaggeration > 0))
        view.exaggeration =
            raster.planes.size() == 3
                ? 1
                : io::auto_exaggeration(raster.planes[0].view(), raster.mask.view(), cell);
    return view;
}

}  // namespace

Result<io::Image> draw_ps(const std::string& path, const PsWireVerb& verb) {
    RELIEF_TRY(const codec::PsFile file, open_ps(path));
    RELIEF_CHECK(codec::check_in_space(file.components()));
    RELIEF_TRY(const PsLevel level, open_level(file, 0));
    RELIEF_TRY(const View view, view_of(path, verb.exaggeration));
    const double each =
        static_cast<double>(kDrawn) / static_cast<double>(level.space().mesh.triangles.size());
    const int parts = std::clamp(static_cast<int>(std::sqrt(each)), 1, kMostParts);
    const PolygonMesh surface = tessellated(level, parts, view);
    io::MeshPictureOptions picture;
    picture.width = verb.width;
    if (verb.viewer) picture.azimuth = *verb.viewer;
    PolygonMesh net;
    if (verb.control_level) {
        const auto control = open_level(file, *verb.control_level);
        if (!control.ok()) return located(control.error(), path);
        net = control_triangles(*control, view);
        picture.net_lines.dot_radius = 0;
    } else {
        net = sides(level, parts, view);
        picture.net_lines = {.width = 1, .opacity = 0.7};
    }
    picture.net = &net;
    return io::draw_mesh(surface, picture);
}

}  // namespace relief::cli
