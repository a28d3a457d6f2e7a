#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "reverse.h"

namespace relief::reproduce {

namespace {

using namespace reverse;
using mesh::Index;
using multires::kLiftKinds;
using multires::lift_name;
using multires::LiftKind;
using multires::MeshScheme;
using multires::MeshTransform;

constexpr const char* kSource = "reverse subdivision by diagrams (sqrt(3), Loop, Catmull-Clark)";

// --- the paper's formulas

/// The rows of A at vertices of valence n, from D and K of our rules.
void formulas(Rows& rows) {
    namespace rules = multires::rules;
    for (const Index n : {3U, 4U, 5U, 6U, 7U, 8U, 12U}) {
        const double alpha = rules::sqrt3_alpha(n);
        const auto sqrt3 = rules::sqrt3_smooth(n, alpha);
        const std::string valence = fmt::format("valence {}", n);
        rows.add("(5.2), sqrt(3)", "a_0, " + valence, 2 / (2 - 3 * alpha), 1 / sqrt3.self);
        rows.add("(5.3), sqrt(3)", "h, " + valence, -3 * alpha / (n * (2 - 3 * alpha)),
                 -sqrt3.face / sqrt3.self, "signs: erratum");
        rows.add("(10.1), figure 29", "beta, " + valence, 3 * alpha / (2 - 3 * alpha),
                 1 / sqrt3.self - 1);
        const double weight = rules::loop_alpha(n);
        const double denominator = 3 * n * weight - 5 * (1 - n * weight);
        const auto loop = rules::loop_smooth(n);
        rows.add("section 8, Loop", "a_0, " + valence, -5 / denominator, 1 / loop.self);
        rows.add("section 8, Loop", "a_i, " + valence, 8 * weight / denominator,
                 -loop.edge / loop.self);
        if (n == 3) continue;  // the paper does not mention that its formula has no value there
        const auto quads = rules::catmull_clark_smooth(n);
        const double m = n * (static_cast<double>(n) - 3);
        rows.add("section 8, Catmull-Clark", "a_0, " + valence, n / (n - 3.0), 1 / quads.self);
        rows.add("section 8, Catmull-Clark", "a of edges, " + valence, -4 / m,
                 -quads.edge / quads.self);
        rows.add("section 8, Catmull-Clark", "a of faces, " + valence, 1 / m,
                 -quads.face / quads.self);
    }
}

// --- the paper's experiments

double largest(const Points& points) {
    double most = 0;
    for (const auto& p : points) most = std::max(most, length(p));
    return most;
}

Points difference(Points a, const Points& b) {
    for (std::size_t v = 0; v < a.size(); ++v) a[v] -= b[v];
    return a;
}

/// Figure 25: a torus of samples, four steps down. How far the vertices are from the torus.
void sampled_torus(Rows& rows) {
    Model model = subdivided(torus(8), MeshScheme::Sqrt3, 4);
    put_on_torus(model.points);
    for (const LiftKind lift : kLiftKinds)
        for (int levels = 1; levels <= 4; ++levels) {
            const Points c = reversed(model, lift, levels);
            Points on = c;
            put_on_torus(on);
            rows.add(
                "figure 25",
                fmt::format("{}, level {}: distance from the torus, max", lift_name(lift), levels),
                {}, largest(difference(c, on)),
                "tube of radius 1; control points lie outside; paper: \"quite stable\"");
        }
}

/// Figures 26 to 28: a polyhedron subdivided, perturbed, and taken down again.
void perturbed(Rows& rows, const std::string& item, const Polyhedron& base, int steps) {
    constexpr double kNoise = 0.02;
    Model model = subdivided(base, MeshScheme::Sqrt3, steps);
    rows.add(item, fmt::format("{} steps down: off the polyhedron, max", steps), 0,
             largest(difference(reversed(model, LiftKind::None, steps), base.points)),
             "unperturbed, plain reversal");
    add_noise(model.points, kNoise, 3);
    for (const LiftKind lift : kLiftKinds)
        rows.add(item, fmt::format("{} steps down, {}: off, rms / noise", steps, lift_name(lift)),
                 {},
                 root_mean_square(difference(reversed(model, lift, steps), base.points)) / kNoise,
                 "paper: \"quite satisfactory and stable\"");
}

/// Figure 31: what a coarse vertex of valence eight makes of a move of the fine one by 1.
void perturbed_vertex(Rows& rows) {
    const auto [base, vertex] = torus_with_valence_eight(8);
    const Model model = subdivided(base, MeshScheme::Sqrt3, 4);
    Points move(model.points.size());
    move[vertex] = {0, 0, 1};
    for (const LiftKind lift : kLiftKinds)
        for (const int levels : {1, 2, 4}) {
            const bool formula = lift == LiftKind::None;
            const double a = 2 / (2 - 3 * multires::rules::sqrt3_alpha(8));
            rows.add("figure 31",
                     fmt::format("{}, level {}: move of the vertex", lift_name(lift), levels),
                     formula ? std::optional(std::pow(a, levels)) : std::nullopt,
                     reversed(model, {.lift = lift}, levels, move)[vertex].z,
                     formula ? "a_0 to that power" : "paper: delta \"significantly\" reduces it");
        }
}

/// Figure 30: noise through four steps, with the scheme's alpha and 1/8.
void other_alpha(Rows& rows) {
    for (const double alpha : {0.0, 0.125})
        for (const LiftKind lift : {LiftKind::None, LiftKind::Chebyshev}) {
            const auto chosen = alpha > 0 ? std::optional(alpha) : std::nullopt;
            const Model model = subdivided(irregular_torus(8), MeshScheme::Sqrt3, 4, chosen);
            Points noise(model.points.size());
            add_noise(noise, 1, 5);
            rows.add("figure 30",
                     fmt::format("alpha {}, {}: noise after 4 steps",
                                 alpha > 0 ? "1/8" : "by valence", lift_name(lift)),
                     {}, root_mean_square(reversed(model, {.lift = lift}, 4, noise)),
                     "paper: with 1/8 the deviation is \"far less\"");
        }
}

// --- our measurements

void measure(Rows& rows, MeshScheme scheme, int steps) {
    Model model = subdivided(irregular_torus(8), scheme, steps);
    add_bumps(model);
    const double smooth_best = residual(model, {.lift = LiftKind::LeastSquares});
    Model rough = subdivided(irregular_torus(8), scheme, steps);
    rough.points = model.points;
    add_noise(rough.points, 0.01, 11);
    const double best = residual(rough, {.lift = LiftKind::LeastSquares});
    Points noise(model.points.size());
    add_noise(noise, 1, 5);
    const std::string item = fmt::format("{}, {} steps", multires::mesh_scheme_name(scheme), steps);
    for (const LiftKind lift : kLiftKinds) {
        const MeshTransform transform{.lift = lift};
        const std::string name = lift_name(lift);
        rows.add(item, name + ": residual / least, smooth shape", {},
                 residual(model, transform) / smooth_best);
        rows.add(item, name + ": residual / least, noisy shape", {},
                 residual(rough, transform) / best);
        rows.add(item, name + ": noise at the base", {},
                 root_mean_square(reversed(model, transform, steps, noise)));
    }
}

/// Off the means of neighbours, as minimised by smooth reversal.
double roughness(const Model& model, const Points& c) {
    const mesh::Topology& mesh = model.hierarchy.topology(model.steps() - 1);
    Points off(c.size());
    const auto valences = mesh::valences(mesh);
    for (Index h = 0; h < mesh.half_edge_count(); ++h) {
        const Index v = mesh.origin[h];
        off[v] += 1.0 / valences[v] * (c[v] - c[mesh.target(h)]);
    }
    return root_mean_square(off);
}

void smooth_reversal(Rows& rows) {
    Model model = subdivided(irregular_torus(8), MeshScheme::Sqrt3, 1);
    add_bumps(model);
    add_noise(model.points, 0.01, 11);
    double best = 0;
    for (const double omega : {1.0, 0.9, 0.7, 0.5, 0.3}) {
        const MeshTransform transform{.lift = LiftKind::LeastSquares, .omega = omega};
        const double found = residual(model, transform);
        if (omega == 1) best = found;
        const std::string item = fmt::format("smooth reversal, omega {}", omega);
        rows.add(item, "residual / least", {}, found / best, "sqrt(3), one step, noisy shape");
        rows.add(item, "rms |U c|", {},
                 roughness(model, reversed(model, transform, 1, model.points)));
    }
}

}  // namespace

std::vector<Row> reverse_rows() {
    Rows rows(kSource);
    add_fractions(rows);
    formulas(rows);
    sampled_torus(rows);
    perturbed(rows, "figure 26, torus", torus(8), 1);
    perturbed(rows, "figure 28, irregular", irregular_torus(8), 2);
    perturbed_vertex(rows);
    other_alpha(rows);
    measure(rows, MeshScheme::Sqrt3, 4);
    measure(rows, MeshScheme::Loop, 3);
    measure(rows, MeshScheme::CatmullClark, 3);
    smooth_reversal(rows);
    return std::move(rows).take();
}

}  // namespace relief::reproduce
