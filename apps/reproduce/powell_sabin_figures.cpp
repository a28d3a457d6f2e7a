#include <fmt/format.h>

#include <algorithm>
#include <string>

#include "powell_sabin.h"
#include "relief/io/file.h"
#include "relief/io/picture.h"
#include "relief/io/png.h"
#include "relief/io/wireframe.h"
#include "relief/multires/ps_lift.h"
#include "relief/multires/ps_surface.h"

namespace relief::reproduce {

namespace {

using namespace ps_text;
using mesh::Index;

constexpr int kPanel = 340;  ///< pixels
constexpr int kMargin = 14;
constexpr int kCaption = 26;

struct Pen {
    const char* colour;
    double width;
    const char* fill = "none";
};
constexpr Pen kEdge{"#222222", 1.8};
constexpr Pen kSplit{"#9a9a9a", 0.9};
constexpr Pen kFineEdge{"#2a6fbb", 1.1};
constexpr Pen kControl{"#b3202c", 1.6, "#b3202c22"};

/// Panels side by side, each with a part of the plane, y upwards.
class Drawing {
  public:
    void begin_panel(Vec2 low, Vec2 high, const std::string& caption) {
        const Vec2 size = high - low;
        scale_ = (kPanel - 2 * kMargin) / std::max(size.x, size.y);
        corner_ = {low.x, high.y};
        left_ = kMargin + kPanel * panels_++;
        svg_ += fmt::format("<text x=\"{}\" y=\"{}\" text-anchor=\"middle\">{}</text>\n",
                            left_ + kPanel / 2 - kMargin, kPanel + kCaption - 10, caption);
    }
    void polygon(std::span<const Vec2> points, const Pen& pen) {
        std::string path;
        for (const Vec2 p : points) path += fmt::format("{:.2f},{:.2f} ", x(p), y(p));
        svg_ += fmt::format(
            "<polygon points=\"{}\" fill=\"{}\" stroke=\"{}\" stroke-width=\"{}\" "
            "stroke-linejoin=\"round\"/>\n",
            path, pen.fill, pen.colour, pen.width);
    }
    void line(Vec2 a, Vec2 b, const Pen& pen) { polygon(std::array{a, b}, pen); }
    void dot(Vec2 p, double radius, const char* colour) {
        svg_ += fmt::format("<circle cx=\"{:.2f}\" cy=\"{:.2f}\" r=\"{}\" fill=\"{}\"/>\n", x(p),
                            y(p), radius, colour);
    }
    [[nodiscard]] std::string svg() const {
        const int width = panels_ * kPanel;
        return fmt::format(
                   "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0}\" height=\"{1}\" "
                   "viewBox=\"0 0 {0} {1}\" font-family=\"sans-serif\" font-size=\"15\">\n"
                   "<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n",
                   width, kPanel + kCaption) +
               svg_ + "</svg>\n";
    }

  private:
    [[nodiscard]] double x(Vec2 p) const { return left_ + scale_ * (p.x - corner_.x); }
    [[nodiscard]] double y(Vec2 p) const { return kMargin + scale_ * (corner_.y - p.y); }

    std::string svg_;
    Vec2 corner_;
    double scale_ = 1;
    int left_ = 0;
    int panels_ = 0;
};

void draw_edges(Drawing& drawing, const mesh::Triangulation& mesh, const Pen& pen) {
    for (Index e = 0; e < mesh.edge_count(); ++e)
        drawing.line(mesh.vertex(mesh.edges[e][0]), mesh.vertex(mesh.edges[e][1]), pen);
}

void draw_split(Drawing& drawing, const ps::Space& space, const Pen& pen) {
    for (Index t = 0; t < space.mesh.triangle_count(); ++t) {
        const spline::PsElement element = space.element(t);
        const Vec2 centre = element.centre();
        for (int k = 0; k < 3; ++k) {
            drawing.line(centre, centre + element.corner(k), pen);
            drawing.line(centre, centre + element.edge_point(k), pen);
        }
    }
}

void draw_control(Drawing& drawing, const ps::Space& space, Index v) {
    std::array<Vec2, 3> corners = space.control[v];
    for (Vec2& corner : corners) corner = space.mesh.vertex(v) + corner;
    drawing.polygon(corners, kControl);
    drawing.dot(space.mesh.vertex(v), 3, kControl.colour);
}

/// The points that the control triangle of a vertex must contain.
void draw_control_points(Drawing& drawing, const ps::Space& space, Index v) {
    const mesh::VertexStars stars = mesh::vertex_triangles(space.mesh);
    for (const Index t : stars.of(v)) {
        const spline::PsElement element = space.element(t);
        const Vec2 vertex = space.mesh.vertex(v);
        drawing.dot(midpoint(vertex, element.centre()), 2.6, "#222222");
        for (int k = 0; k < 3; ++k)
            if (space.mesh.triangles[t][static_cast<std::size_t>(k)] == v)
                for (const int edge : {k, k == 0 ? 2 : k - 1})
                    drawing.dot(midpoint(vertex, element.centre() + element.edge_point(edge)), 2.6,
                                "#222222");
    }
}

/// A hub with seven neighbours, which are joined in a circle.
ps::Space wheel() {
    const std::vector<Vec2> vertices{{0.1, 0},     {1, 0.1},      {0.6, 0.9}, {-0.2, 1.05},
                                     {-0.95, 0.5}, {-0.8, -0.45}, {0, -0.95}, {0.75, -0.75}};
    std::vector<std::array<Index, 3>> triangles;
    for (Index k = 1; k < 8; ++k) triangles.push_back({0, k, k == 7 ? 1 : k + 1});
    return *ps::make_space(*mesh::build(vertices, triangles));
}

ps::Space one_triangle() {
    const std::array<Vec2, 3> corners{Vec2{0, 0}, {1, 0.08}, {0.38, 0.85}};
    const std::array<std::array<Index, 3>, 1> triangle{{{0, 1, 2}}};
    return *ps::make_space(*mesh::build(corners, triangle));
}

void begin(Drawing& drawing, const ps::Space& space, const std::string& caption) {
    const auto [left, right] = std::minmax_element(space.mesh.x.begin(), space.mesh.x.end());
    const auto [low, high] = std::minmax_element(space.mesh.y.begin(), space.mesh.y.end());
    drawing.begin_panel({*left, *low}, {*right, *high}, caption);
}

/// Figures 1 (b), 2 and 3 (a): the split, the points around a vertex, the triangle about Z.
std::string split_figure() {
    Drawing drawing;
    const ps::Space space = wheel();
    begin(drawing, space, "the split into six");
    draw_split(drawing, space, kSplit);
    draw_edges(drawing, space.mesh, kEdge);
    begin(drawing, space, "smallest control triangle");
    draw_split(drawing, space, kSplit);
    draw_edges(drawing, space.mesh, kEdge);
    draw_control(drawing, space, 0);
    draw_control_points(drawing, space, 0);
    begin(drawing, space, "all of them");
    draw_edges(drawing, space.mesh, kEdge);
    for (Index v = 0; v < space.mesh.vertex_count(); ++v) draw_control(drawing, space, v);
    return drawing.svg();
}

/// Figure 4: dyadic refinement, where every Z lies in the triangle of its R.
std::string dyadic_figure() {
    Drawing drawing;
    const ps::Space space = squares(2);
    const ps::Refinement step = *refine(space, {.scheme = ps::Scheme::Dyadic});
    begin(drawing, space, "a regular mesh");
    draw_split(drawing, space, kSplit);
    draw_edges(drawing, space.mesh, kEdge);
    begin(drawing, space, "dyadic");
    draw_split(drawing, step.fine, kSplit);
    draw_edges(drawing, step.fine.mesh, kFineEdge);
    draw_edges(drawing, space.mesh, kEdge);
    return drawing.svg();
}

/// Figure 5: a mesh, one and two steps of sqrt(3).
std::string refinement_figure() {
    Drawing drawing;
    const ps::Space space = wheel();
    const ps::Refinement root3 = *refine(space, {.scheme = ps::Scheme::Root3});
    const ps::Refinement triadic = *refine(space);
    begin(drawing, space, "a mesh");
    draw_edges(drawing, space.mesh, kEdge);
    begin(drawing, space, "sqrt(3)");
    draw_edges(drawing, space.mesh, kSplit);
    draw_edges(drawing, root3.fine.mesh, kFineEdge);
    begin(drawing, space, "triadic");
    draw_edges(drawing, triadic.fine.mesh, kFineEdge);
    draw_edges(drawing, space.mesh, kEdge);
    return drawing.svg();
}

/// Figures 6 and 7: new control triangles, in the triangle and on the boundary.
std::string new_control_figure() {
    Drawing drawing;
    const ps::Space space = one_triangle();
    const ps::Refinement root3 =
        *refine(space, {.scheme = ps::Scheme::Root3, .rescale = ps::Rescale::None});
    const ps::Refinement triadic = *refine(space, {.rescale = ps::Rescale::None});
    begin(drawing, space, "of Z, sqrt(3)");
    draw_split(drawing, space, kSplit);
    draw_edges(drawing, root3.fine.mesh, kFineEdge);
    draw_edges(drawing, space.mesh, kEdge);
    draw_control(drawing, root3.fine, 3);
    draw_control_points(drawing, root3.fine, 3);
    begin(drawing, space, "on the boundary, triadic");
    draw_split(drawing, triadic.fine, kSplit);
    draw_edges(drawing, triadic.fine.mesh, kFineEdge);
    draw_edges(drawing, space.mesh, kEdge);
    draw_control(drawing, triadic.fine, 4);
    draw_control_points(drawing, triadic.fine, 4);
    return drawing.svg();
}

/// What one detail in the middle of a square adds to the surface.
Result<io::Image> wavelet_picture(ps::Update update, const std::string& caption) {
    constexpr int kSide = 161;
    const ps::Hierarchy hierarchy = *ps::Hierarchy::create(squares(4), 1);
    const ps::Space& fine = hierarchy.space(1);
    const std::size_t old = hierarchy.space(0).mesh.x.size();
    ps::Lifted lifted{ps::Coefficients(old), ps::Coefficients(fine.mesh.x.size() - old)};
    lifted.details[13] = {1, 1, 1};  // in a triangle near the middle
    RELIEF_TRY(const ps::Coefficients wavelet,
               synthesise(hierarchy.space(0), hierarchy.step(0), lifted, update));
    RELIEF_TRY(const ps::Surface surface, ps::Surface::create(fine, std::span(&wavelet, 1)));
    Grid<double> heights(kSide, kSide);
    constexpr double kStep = 1.0 / (kSide - 1);
    RELIEF_CHECK(ps::evaluate_raster(surface, {{0, 0}, {kStep, kStep}}, heights.view()));
    io::ViewOptions view{.width = kPanel};
    view.light.vertical_exaggeration = 0.5;
    return io::with_caption(io::wireframe(heights.view(), {}, {kStep, kStep}, view, 40),
                            fmt::format("{:^24}", caption));
}

Status write_text(const std::string& path, const std::string& text) {
    return io::write_file_atomically(path, Bytes(text.begin(), text.end()));
}

}  // namespace

Status powell_sabin_figures(const std::string& folder) {
    RELIEF_CHECK(write_text(folder + "/ps-split.svg", split_figure()));
    RELIEF_CHECK(write_text(folder + "/ps-dyadic.svg", dyadic_figure()));
    RELIEF_CHECK(write_text(folder + "/ps-refinement.svg", refinement_figure()));
    RELIEF_CHECK(write_text(folder + "/ps-control.svg", new_control_figure()));
    RELIEF_TRY(const io::Image plain, wavelet_picture(ps::Update::None, "no update"));
    RELIEF_CHECK(io::write_png(folder + "/ps-wavelet-plain.png", plain));
    RELIEF_TRY(const io::Image lifted,
               wavelet_picture(ps::Update::Semi2Moments, "orthogonal, moments 0"));
    return io::write_png(folder + "/ps-wavelet.png", lifted);
}

}  // namespace relief::reproduce
