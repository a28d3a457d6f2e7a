#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string_view>

#include "relief/io/file.h"
#include "relief/io/mesh_picture.h"
#include "relief/io/png.h"
#include "relief/multires/curve.h"
#include "reverse.h"

namespace relief::reproduce {

namespace {

using namespace reverse;
using io::Image;
using multires::LiftKind;
using multires::MeshScheme;

constexpr int kPanel = 340;  ///< pixels
constexpr int kGap = 12;

/// The coarser, the thicker the edges; fine meshes have none.
Image panel(const Model& model, int levels, const Points& points, const std::string& caption,
            double azimuth = 215) {
    io::MeshPictureOptions options;
    options.width = kPanel;
    options.azimuth = azimuth;
    options.altitude = 38;
    const auto vertices = static_cast<double>(model.hierarchy.vertices(model.steps() - levels));
    if (vertices < 4000) {
        options.shading = io::MeshShading::Facets;
        options.edges.width = vertices < 600 ? 1.2 : 0.6;
        options.edges.opacity = vertices < 600 ? 0.8 : 0.5;
    }
    // Captions of one length have letters of one size.
    return io::with_caption(io::draw_mesh(mesh_at(model, levels, points), options),
                            fmt::format("{:^21}", caption));
}

/// Pictures side by side, standing on one line.
Image row_of(const std::vector<Image>& panels) {
    Image all(0, 0, 3);
    for (const Image& image : panels) all.height = std::max(all.height, image.height);
    all.width = static_cast<int>(panels.size()) * (kPanel + kGap) - kGap;
    all = Image(all.width, all.height, 3);
    std::fill(all.pixels.begin(), all.pixels.end(), std::uint8_t{255});
    int left = 0;
    for (const Image& image : panels) {
        for (int row = 0; row < image.height; ++row)
            std::copy_n(image.pixel(row, 0), 3 * image.width,
                        all.pixel(all.height - image.height + row, left));
        left += kPanel + kGap;
    }
    return all;
}

Image sampled_torus() {
    Model model = subdivided(torus(8), MeshScheme::Sqrt3, 4);
    put_on_torus(model.points);
    std::vector<Image> panels = {panel(model, 0, model.points, "samples of a torus")};
    for (const int levels : {1, 2, 3, 4})
        panels.push_back(panel(model, levels, reversed(model, LiftKind::None, levels),
                               fmt::format("level {}, plain", levels)));
    return row_of(panels);
}

/// Perturbed, and what plain and lifted reversal make of it.
Image perturbed(const Polyhedron& base, int steps) {
    Model model = subdivided(base, MeshScheme::Sqrt3, steps);
    std::vector<Image> panels = {panel(model, steps, base.points, "polyhedron")};
    add_noise(model.points, 0.02, 3);
    panels.push_back(panel(model, 0, model.points, "subdivided, perturbed"));
    for (const LiftKind lift : {LiftKind::None, LiftKind::Ring, LiftKind::Chebyshev})
        panels.push_back(panel(model, steps, reversed(model, lift, steps),
                               fmt::format("reversed, {}", multires::lift_name(lift))));
    return row_of(panels);
}

Image perturbed_vertex() {
    const auto [base, vertex] = torus_with_valence_eight(8);
    Model model = subdivided(base, MeshScheme::Sqrt3, 4);
    model.points[vertex] += Vec3<double>{0.12, 0, 0.04};
    constexpr double kFromThere = 110;
    std::vector<Image> panels = {panel(model, 0, model.points, "valence 8, one moved", kFromThere)};
    for (const LiftKind lift : {LiftKind::None, LiftKind::Ring, LiftKind::Chebyshev})
        panels.push_back(panel(model, 4, reversed(model, lift, 4),
                               fmt::format("level 4, {}", multires::lift_name(lift)), kFromThere));
    return row_of(panels);
}

Image other_alpha() {
    std::vector<Image> panels;
    for (const bool eighth : {false, true}) {
        const auto alpha = eighth ? std::optional(0.125) : std::nullopt;
        Model model = subdivided(irregular_torus(8), MeshScheme::Sqrt3, 4, alpha);
        add_noise(model.points, 0.01, 3);
        for (const int levels : {2, 4})
            panels.push_back(
                panel(model, levels, reversed(model, LiftKind::None, levels),
                      fmt::format("level {}, alpha {}", levels, eighth ? "1/8" : "varies")));
    }
    return row_of(panels);
}

Image smooth_reversal() {
    Model model = subdivided(irregular_torus(8), MeshScheme::Sqrt3, 4);
    add_bumps(model);
    add_noise(model.points, 0.02, 3);
    std::vector<Image> panels = {panel(model, 0, model.points, "with noise")};
    for (const double omega : {1.0, 0.3, 0.05})
        panels.push_back(panel(
            model, 2,
            reversed(model, {.lift = LiftKind::LeastSquares, .omega = omega}, 2, model.points),
            fmt::format("level 2, omega {}", omega)));
    return row_of(panels);
}

/// Figure 33: the mesh taken down, bent, and brought up again with its details.
Image edited() {
    Model model = subdivided(irregular_torus(8), MeshScheme::Sqrt3, 4);
    add_bumps(model);
    const multires::MeshMaps maps =
        *multires::MeshMaps::create(model.hierarchy, {.local_frames = true});
    multires::StiffResiduals residuals;
    Points points = model.points;
    maps.analyse(points.data(), residuals);
    const std::size_t base = model.hierarchy.vertices(0);
    const auto coarse = [&] {
        return Points(points.begin(), points.begin() + static_cast<std::ptrdiff_t>(base));
    };
    std::vector<Image> panels = {panel(model, 0, model.points, "a mesh"),
                                 panel(model, 4, coarse(), "level 4")};
    for (std::size_t v = 0; v < base; ++v) points[v].z += 0.12 * points[v].x * points[v].x;
    panels.push_back(panel(model, 4, coarse(), "level 4, bent"));
    maps.synthesise(0, model.steps(), points.data(), residuals);
    panels.push_back(panel(model, 0, points, "with its details"));
    return row_of(panels);
}

// --- curves

struct Pen {
    const char* colour;
    double width;
    double dot;
};

std::string drawn(const std::vector<Vec3<double>>& curve, const Pen& pen) {
    std::string path;
    std::string dots;
    for (const auto& p : curve) {
        path += fmt::format("{}{:.2f} {:.2f}", path.empty() ? "M" : " L", p.x, p.y);
        if (pen.dot > 0)
            dots += fmt::format("<circle cx=\"{:.2f}\" cy=\"{:.2f}\" r=\"{}\" fill=\"{}\"/>\n", p.x,
                                p.y, pen.dot, pen.colour);
    }
    return fmt::format("<path d=\"{} Z\" fill=\"none\" stroke=\"{}\" stroke-width=\"{}\"/>\n{}",
                       path, pen.colour, pen.width, dots);
}

/// Figure 23: a closed curve with noise, one and two ternary steps down.
std::string curves() {
    using multires::CurveReversal;
    constexpr int kSize = 420;
    constexpr std::size_t kPoints = 108;
    Points fine;
    for (std::size_t k = 0; k < kPoints; ++k) {
        const double angle = 2 * M_PI * static_cast<double>(k) / kPoints;
        const double radius = 112 + 36 * std::cos(3 * angle) + 9 * std::sin(5 * angle);
        fine.push_back({210 + radius * std::cos(angle), 205 + radius * std::sin(angle), 0});
    }
    add_noise(fine, 2, 3);
    std::string svg = fmt::format(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0}\" height=\"{1}\" viewBox=\"0 0 {0} "
        "{1}\" font-family=\"sans-serif\" font-size=\"15\">\n<rect width=\"100%\" height=\"100%\" "
        "fill=\"white\"/>\n",
        3 * kSize, kSize + 10);
    int left = 0;
    for (const auto& [reversal, name] : {std::pair{CurveReversal::Local, "1 point on each side"},
                                         {CurveReversal::Paper, "4 on each side, the paper's"},
                                         {CurveReversal::LeastSquares, "least squares"}}) {
        svg += fmt::format("<g transform=\"translate({} 0)\">\n", left);
        svg += drawn(fine, {"#9a9a9a", 1, 1.6});
        Points coarse = fine;
        for (const Pen& pen : {Pen{"#2a6fbb", 1.2, 2.6}, Pen{"#b3202c", 1.6, 3.6}}) {
            const auto step =
                multires::CurveStep::create(coarse.size() / 3, {.reversal = reversal});
            coarse = step->analyse(coarse).coarse;
            svg += drawn(coarse, pen);
        }
        svg += fmt::format("<text x=\"210\" y=\"{}\" text-anchor=\"middle\">{}</text>\n</g>\n",
                           kSize - 4, name);
        left += kSize;
    }
    return svg + "</svg>\n";
}

}  // namespace

Status reverse_figures(const std::string& folder) {
    const std::string svg = curves();
    RELIEF_CHECK(
        io::write_file_atomically(folder + "/figure23.svg", Bytes(svg.begin(), svg.end())));
    RELIEF_CHECK(io::write_png(folder + "/figure25.png", sampled_torus()));
    RELIEF_CHECK(io::write_png(folder + "/figure26.png", perturbed(torus(8), 1)));
    RELIEF_CHECK(io::write_png(folder + "/figure28.png", perturbed(irregular_torus(8), 2)));
    RELIEF_CHECK(io::write_png(folder + "/figure30.png", other_alpha()));
    RELIEF_CHECK(io::write_png(folder + "/figure31.png", perturbed_vertex()));
    RELIEF_CHECK(io::write_png(folder + "/figure33.png", edited()));
    return io::write_png(folder + "/smooth.png", smooth_reversal());
}

}  // namespace relief::reproduce
