#include "relief/io/mesh_picture.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "io/camera.h"
#include "io/legend.h"
#include "relief/core/parallel.h"

namespace relief::io {

namespace {

using detail::Box;
using detail::Camera;
using detail::Canvas;
using detail::CornerWeights;
using detail::Fit;
using detail::Light;
using detail::Pen;
using detail::ScreenPoint;
using detail::Srgb;
using detail::Vec;

constexpr int kBandRows = 16;
constexpr std::int64_t kGrain = 4096;
/// Lines lie on a surface: this part of their nearness above it.
constexpr double kLift = 4e-4;
/// Faces of a vertex are smooth together up to an angle between them of 50 degrees: its cosine.
constexpr double kSmooth = 0.643;
/// Vertices of more faces are smooth as a whole, so that time is linear.
constexpr std::size_t kMostCompared = 64;
constexpr Srgb kFront = {222, 219, 212};
constexpr Srgb kBack = {176, 132, 104};
constexpr double kBackLight = 0.6;  ///< of backs that have colours

/// Of length 1, or zero.
Vec unit(const Vec& a) {
    const double norm = length(a);
    return norm > 0 ? (1 / norm) * a : Vec{};
}

std::array<double, 3> scaled(double s, const std::array<double, 3>& a) {
    return {s * a[0], s * a[1], s * a[2]};
}

/// z up, x right and -y towards a viewer in the south.
Vec upright(const std::array<double, 3>& p, UpAxis up) {
    return up == UpAxis::Y ? Vec{p[0], -p[2], p[1]} : Vec{p[0], p[1], p[2]};
}

void add_polygons(const PolygonMesh& mesh, UpAxis up, Box& box) {
    for (const std::int32_t v : mesh.corners)
        box.add(upright(mesh.vertices[static_cast<std::size_t>(v)], up));
}

/// The vertices of a mesh relative to the camera.
struct Placed {
    std::vector<Vec> places;  ///< as Camera::place
    std::vector<ScreenPoint> points;
};

Placed placed(const PolygonMesh& mesh, UpAxis up, const Camera& camera) {
    Placed out;
    out.places.resize(mesh.vertices.size());
    out.points.resize(mesh.vertices.size());
    parallel_for(0, static_cast<std::int64_t>(mesh.vertices.size()), kGrain,
                 [&](std::int64_t first, std::int64_t end) {
                     for (auto v = static_cast<std::size_t>(first);
                          v < static_cast<std::size_t>(end); ++v) {
                         const Vec p = upright(mesh.vertices[v], up);
                         out.places[v] = camera.place(p);
                         out.points[v] = camera.project(p);
                     }
                 });
    return out;
}

/// Which items touch which bands of kBandRows rows of a picture.
class Bands {
  public:
    /// rows(k): the first and last pixel row that item k < count may touch.
    template <class Rows>
    Bands(int height, std::size_t count, Rows rows)
        : begin_(static_cast<std::size_t>((height + kBandRows - 1) / kBandRows) + 2, 0) {
        const auto last_band = static_cast<double>(size()) - 1;
        const auto band = [&](double row) {
            return static_cast<std::size_t>(std::clamp(row / kBandRows, 0.0, last_band));
        };
        const auto each = [&](auto visit) {
            for (std::size_t k = 0; k < count; ++k) {
                const std::array<double, 2> touched = rows(k);
                for (std::size_t b = band(touched[0]); b <= band(touched[1]); ++b) visit(b, k);
            }
        };
        each([&](std::size_t b, std::size_t) { ++begin_[b + 2]; });
        for (std::size_t b = 2; b < begin_.size(); ++b) begin_[b] += begin_[b - 1];
        items_.resize(begin_.back());
        each([&](std::size_t b, std::size_t k) {
            items_[begin_[b + 1]++] = static_cast<std::uint32_t>(k);
        });
    }

    [[nodiscard]] std::size_t size() const { return begin_.size() - 2; }
    /// In ascending order.
    [[nodiscard]] std::span<const std::uint32_t> operator[](std::size_t band) const {
        return std::span(items_).subspan(begin_[band], begin_[band + 1] - begin_[band]);
    }

  private:
    std::vector<std::size_t> begin_;  ///< while it is filled, of the band before
    std::vector<std::uint32_t> items_;
};

/// A triangle of a polygon, by its corners among those of the mesh.
using Triangle = std::array<std::uint32_t, 3>;

/// Of the faces around a vertex: a corner there, and a normal as long as the doubled area.
struct FaceAtVertex {
    std::uint32_t corner;
    Vec normal;
};

/// The normal at each corner of one vertex: the sum of those of all faces that are smooth with its
/// own.
template <class Visit>
void smooth_normals(std::span<const FaceAtVertex> faces, Visit visit) {
    Vec all{};
    for (const FaceAtVertex& face : faces) all += face.normal;
    for (const FaceAtVertex& face : faces) {
        Vec normal{};
        for (std::size_t k = 0; faces.size() <= kMostCompared && k < faces.size(); ++k) {
            const Vec& other = faces[k].normal;
            if (dot(face.normal, other) >= kSmooth * length(face.normal) * length(other))
                normal += other;
        }
        visit(face.corner, unit(faces.size() <= kMostCompared ? normal : all));
    }
}

/// What is drawn of a mesh: where its corners are, and what is there.
class Scene {
  public:
    Scene(const PolygonMesh& mesh, const MeshPictureOptions& options, const Camera& camera,
          Placed placed)
        : mesh_(mesh),
          options_(options),
          placed_(std::move(placed)),
          colours_(mesh.attribute("colour")),
          perspective_(camera.distance().has_value()),
          key_(unit(-0.5 * camera.right() + 0.65 * camera.up() + 0.6 * camera.towards_viewer())),
          fill_(unit(0.8 * camera.right() + 0.1 * camera.up() + 0.5 * camera.towards_viewer())) {
        set_normals();
        set_triangles();
        set_scale();
    }

    [[nodiscard]] const std::vector<Triangle>& triangles() const { return triangles_; }
    [[nodiscard]] const detail::Legend& legend() const { return legend_; }
    [[nodiscard]] std::array<ScreenPoint, 3> points(const Triangle& t) const {
        return {point(t[0]), point(t[1]), point(t[2])};
    }

    void draw(const Triangle& t, Canvas& canvas) const {
        const std::array<ScreenPoint, 3> at = points(t);
        // On the screen y is down: fronts run clockwise there.
        const bool back =
            (at[1].x - at[0].x) * (at[2].y - at[0].y) - (at[2].x - at[0].x) * (at[1].y - at[0].y) >
            0;
        std::array<Corner, 3> corners;
        for (std::size_t k = 0; k < 3; ++k) corners[k] = corner(t[k], back);
        canvas.triangle(at, [&](const CornerWeights& screen) {
            return colour(corners, in_space(screen, at), back);
        });
    }

  private:
    /// What is blended over a triangle.
    struct Corner {
        Vec normal;
        Light base;
        double value;
    };

    [[nodiscard]] std::uint32_t begin_of(std::size_t face) const {
        return static_cast<std::uint32_t>(mesh_.offsets[face]);
    }
    [[nodiscard]] std::size_t vertex(std::uint32_t corner) const {
        return static_cast<std::size_t>(mesh_.corners[corner]);
    }
    [[nodiscard]] const ScreenPoint& point(std::uint32_t corner) const {
        return placed_.points[vertex(corner)];
    }
    [[nodiscard]] const Vec& place(std::uint32_t corner) const {
        return placed_.places[vertex(corner)];
    }

    /// The normal of a triangle, as long as its doubled area.
    [[nodiscard]] Vec area(const Triangle& c) const {
        return cross(place(c[1]) - place(c[0]), place(c[2]) - place(c[0]));
    }

    void set_normals() {
        std::vector<Vec> faces(static_cast<std::size_t>(mesh_.polygon_count()));
        for (std::size_t f = 0; f < faces.size(); ++f)
            for (std::uint32_t c = begin_of(f) + 1; c + 1 < begin_of(f + 1); ++c)
                faces[f] += area({begin_of(f), c, c + 1});
        normals_.resize(mesh_.corners.size());
        if (options_.shading == MeshShading::Smooth) return smooth(faces);
        for (std::size_t f = 0; f < faces.size(); ++f)
            for (std::uint32_t c = begin_of(f); c < begin_of(f + 1); ++c)
                normals_[c] = unit(faces[f]);
    }

    void smooth(const std::vector<Vec>& faces) {
        std::vector<std::size_t> end(mesh_.vertices.size() + 1, 0);
        for (const std::int32_t v : mesh_.corners) ++end[static_cast<std::size_t>(v) + 1];
        std::partial_sum(end.begin(), end.end(), end.begin());
        std::vector<FaceAtVertex> around(mesh_.corners.size());
        for (std::size_t f = 0; f < faces.size(); ++f)
            for (std::uint32_t c = begin_of(f); c < begin_of(f + 1); ++c)
                around[end[vertex(c)]++] = {c, faces[f]};
        parallel_for(0, static_cast<std::int64_t>(mesh_.vertices.size()), kGrain,
                     [&](std::int64_t first, std::int64_t last) {
                         for (auto v = static_cast<std::size_t>(first);
                              v < static_cast<std::size_t>(last); ++v) {
                             const std::size_t begin = v > 0 ? end[v - 1] : 0;
                             smooth_normals(
                                 std::span(around).subspan(begin, end[v] - begin),
                                 [&](std::uint32_t c, const Vec& n) { normals_[c] = n; });
                         }
                     });
    }

    void set_triangles() {
        for (std::size_t f = 0; f + 1 < mesh_.offsets.size(); ++f) {
            const std::uint32_t begin = begin_of(f);
            const std::uint32_t end = begin_of(f + 1);
            if (end - begin == 4) {
                add_quad(begin);
                continue;
            }
            for (std::uint32_t c = begin + 1; c + 1 < end; ++c)
                triangles_.push_back({begin, c, c + 1});
        }
    }

    /// Cuts a quad such that the smaller triangle, or the one that is turned over, is the largest.
    void add_quad(std::uint32_t begin) {
        std::array<std::array<Triangle, 2>, 2> cuts;
        std::array<double, 2> smaller;
        for (std::uint32_t k = 0; k < 2; ++k) {
            const auto c = [&](std::uint32_t i) { return begin + (i + k) % 4; };
            cuts[k] = {Triangle{c(0), c(1), c(2)}, Triangle{c(0), c(2), c(3)}};
            const Vec a = area(cuts[k][0]);
            const Vec b = area(cuts[k][1]);
            smaller[k] = std::min(dot(a, a + b), dot(b, a + b));
        }
        const auto& best = cuts[smaller[1] > smaller[0] ? 1 : 0];
        triangles_.insert(triangles_.end(), best.begin(), best.end());
    }

    void set_scale() {
        double largest = 0;
        legend_ = {options_.scale, options_.unit, true};
        for (const double value : options_.values) {
            if (!std::isfinite(value)) continue;
            largest = std::max(largest, std::abs(value));
            if (value < 0) legend_.from_zero = false;
        }
        if (!(legend_.scale > 0)) legend_.scale = detail::round_scale(largest);
    }

    /// Colours of files are sRGB: floats to 1, integers to the largest of their type.
    [[nodiscard]] Light own_colour(std::uint32_t corner) const {
        const std::int64_t element = colours_->face_varying()
                                         ? colours_->corners[corner]
                                         : static_cast<std::int64_t>(vertex(corner));
        if (element < 0) return detail::light_of(kFront);
        const double top = colours_->type == SampleType::UInt8    ? 255
                           : colours_->type == SampleType::UInt16 ? 65535
                           : colours_->type == SampleType::Int16  ? 32767
                           : colours_->type == SampleType::UInt32 ? 4294967295
                           : colours_->type == SampleType::Int32  ? 2147483647
                                                                  : 1;
        Light light;
        for (std::size_t k = 0; k < 3; ++k) {
            const double code = colours_->element(element)[k] / top;
            light[k] = detail::linear_of(
                static_cast<std::uint8_t>(std::lround(255 * std::clamp(code, 0.0, 1.0))));
        }
        return light;
    }

    [[nodiscard]] Corner corner(std::uint32_t c, bool back) const {
        Light base = detail::light_of(back ? kBack : kFront);
        if (colours_) base = scaled(back ? kBackLight : 1, own_colour(c));
        const double value =
            options_.values.empty() ? std::nan("") : options_.values[vertex(c)] / legend_.scale;
        return {(back ? -1.0 : 1.0) * normals_[c], base, value};
    }

    /// The weights of the corners at a point of the triangle itself: nearness is proportional to
    /// the reciprocal of the distance from the viewer.
    [[nodiscard]] CornerWeights in_space(const CornerWeights& screen,
                                         const std::array<ScreenPoint, 3>& at) const {
        if (!perspective_) return screen;
        const CornerWeights w = {screen[0] * at[0].nearness, screen[1] * at[1].nearness,
                                 screen[2] * at[2].nearness};
        return scaled(1 / (w[0] + w[1] + w[2]), w);
    }

    [[nodiscard]] Srgb colour(const std::array<Corner, 3>& corners, const CornerWeights& w,
                              bool back) const {
        const auto& [a, b, c] = corners;
        const Vec normal = unit(w[0] * a.normal + w[1] * b.normal + w[2] * c.normal);
        const double value = w[0] * a.value + w[1] * b.value + w[2] * c.value;
        // The key light reaches around the mesh, weaker and weaker.
        const double key = 0.5 + 0.5 * dot(normal, key_);
        const double fill = std::max(0.0, dot(normal, fill_));
        const double light = 0.10 + 0.92 * key * key + 0.15 * fill;
        if (std::isfinite(value)) {
            const double faint = 0.5 + 0.5 * light;  // the colours are to be read
            return detail::srgb_of(
                scaled(back ? kBackLight * faint : faint, detail::difference_light(value)));
        }
        Light base;
        for (std::size_t k = 0; k < 3; ++k)
            base[k] = w[0] * a.base[k] + w[1] * b.base[k] + w[2] * c.base[k];
        return detail::srgb_of(scaled(light, base));
    }

    const PolygonMesh& mesh_;
    const MeshPictureOptions& options_;
    Placed placed_;  ///< points in pixels
    const MeshAttribute* colours_;
    bool perspective_;
    Vec key_;  ///< towards the lights
    Vec fill_;
    std::vector<Vec> normals_;  ///< at each corner, of length 1
    std::vector<Triangle> triangles_;
    detail::Legend legend_;
};

/// A line or, between equal ends, a dot.
struct Stroke {
    ScreenPoint from;
    ScreenPoint to;
    double width;
    const Pen* pen;
};

void add_strokes(const PolygonMesh& mesh, const std::vector<ScreenPoint>& points,
                 const LineStyle& style, const Pen& pen, std::vector<Stroke>& strokes) {
    std::vector<std::array<std::int32_t, 2>> edges;  // and vertices, as edges from and to them
    for (std::int64_t f = 0; f < mesh.polygon_count(); ++f) {
        const auto corners = mesh.polygon(f);
        for (std::size_t k = 0; k < corners.size(); ++k) {
            const std::int32_t a = corners[k];
            const std::int32_t b = corners[k + 1 < corners.size() ? k + 1 : 0];
            if (style.width > 0) edges.push_back({std::min(a, b), std::max(a, b)});
            if (style.dot_radius > 0) edges.push_back({a, a});
        }
    }
    std::sort(edges.begin(), edges.end());
    edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
    for (const auto& [a, b] : edges)
        strokes.push_back({points[static_cast<std::size_t>(a)], points[static_cast<std::size_t>(b)],
                           a == b ? 2 * style.dot_radius : style.width, &pen});
}

Pen pen_of(const LineStyle& style) {
    const int reach =
        static_cast<int>(std::clamp(std::ceil(style.width * Canvas::kSamples / 2), 1.0, 4.0));
    return {style.colour, style.opacity, style.hidden_opacity, kLift, reach};
}

void fit_points(const Fit& fit, std::vector<ScreenPoint>& points) {
    for (ScreenPoint& p : points) p = fit(p);
}

Image drawn(const Scene& scene, const std::vector<Stroke>& strokes, const Fit& fit, int channels) {
    const auto triangle_rows = [&](std::size_t k) {
        const auto at = scene.points(scene.triangles()[k]);
        return std::array{std::min({at[0].y, at[1].y, at[2].y}),
                          std::max({at[0].y, at[1].y, at[2].y})};
    };
    const auto stroke_rows = [&](std::size_t k) {
        const Stroke& s = strokes[k];
        return std::array{std::min(s.from.y, s.to.y) - s.width - 1,
                          std::max(s.from.y, s.to.y) + s.width + 1};
    };
    const Bands triangles(fit.height, scene.triangles().size(), triangle_rows);
    const Bands lines(fit.height, strokes.size(), stroke_rows);
    Image image(fit.width, fit.height, channels);
    parallel_for(
        0, static_cast<std::int64_t>(triangles.size()), 1,
        [&](std::int64_t first, std::int64_t end) {
            for (auto b = static_cast<std::size_t>(first); b < static_cast<std::size_t>(end); ++b) {
                const int top = static_cast<int>(b) * kBandRows;
                const int rows = std::min(kBandRows, fit.height - top);
                Canvas canvas(fit.width, rows, top);
                for (const std::uint32_t k : triangles[b]) scene.draw(scene.triangles()[k], canvas);
                for (const std::uint32_t k : lines[b])
                    canvas.line(strokes[k].from, strokes[k].to, strokes[k].width, *strokes[k].pen);
                canvas.write_rows(0, rows, image);
            }
        });
    return image;
}

}  // namespace

Image draw_mesh(const PolygonMesh& mesh, const MeshPictureOptions& options) {
    static const PolygonMesh nothing;
    const PolygonMesh& net = options.net ? *options.net : nothing;
    Box box;
    for (const PolygonMesh* part : {&mesh, &net}) add_polygons(*part, options.up, box);
    if (box.empty()) return {};
    const Camera camera(box, {options.azimuth, options.altitude, options.field_of_view});
    Placed of_mesh = placed(mesh, options.up, camera);
    Placed of_net = placed(net, options.up, camera);
    Box seen;
    for (const std::int32_t v : mesh.corners) seen.add(of_mesh.points[static_cast<std::size_t>(v)]);
    for (const std::int32_t v : net.corners) seen.add(of_net.points[static_cast<std::size_t>(v)]);
    const Fit fit = fitted(seen, std::max(options.width, 16));
    fit_points(fit, of_mesh.points);
    fit_points(fit, of_net.points);

    const Pen edge_pen = pen_of(options.edges);
    const Pen net_pen = pen_of(options.net_lines);
    std::vector<Stroke> strokes;
    add_strokes(mesh, of_mesh.points, options.edges, edge_pen, strokes);
    add_strokes(net, of_net.points, options.net_lines, net_pen, strokes);
    const Scene scene(mesh, options, camera, std::move(of_mesh));
    Image image = drawn(scene, strokes, fit, options.background == HoleStyle::Transparent ? 4 : 3);
    return options.values.empty() ? image : detail::with_legend(image, scene.legend());
}

}  // namespace relief::io
