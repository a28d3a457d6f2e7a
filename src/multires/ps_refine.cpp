#include "relief/multires/ps_refine.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "multires/ps_control.h"
#include "multires/ps_crossing.h"
#include "multires/ps_errors.h"
#include "multires/ps_step.h"

namespace relief::multires::ps {

using mesh::Index;
using mesh::kNone;
using mesh::Triangulation;
using spline::PsElement;

namespace {

constexpr double kFullCut = 2.0 / 3;
constexpr double kDyadicMargin = 1e-6;
constexpr double kThinnest = 1e-12;  ///< twice the area by the squared longest side
constexpr double kOnSide = 1e-12;    ///< a vertex this close to a side of its control triangle

constexpr Index next(Index k) {
    return k == 2 ? 0 : k + 1;
}
constexpr Index before(Index k) {
    return k == 0 ? 2 : k - 1;
}

using Ratios = std::vector<std::array<double, 3>>;  ///< 1 / rho of each triangle's corners

Ratios inverse_ratios(const Space& space) {
    Ratios ratios(space.mesh.triangle_count());
    for_each_index(ratios.size(), [&](Index t) { ratios[t] = space.element(t).inverse_ratios(); });
    return ratios;
}

/// kappa from what is possible at each vertex.
void choose_cuts(const RefineOptions& options, std::vector<double>& possible) {
    for (double& kappa : possible) {
        const double limit = options.eta * kappa;
        kappa = std::min(kFullCut, limit);
        if (options.cut == CutRule::Closed) continue;
        kappa = kFullCut;
        while (kappa >= limit) kappa /= 2;
    }
}

/// The smallest 1 / rho at each vertex.
std::vector<double> first_cuts(const Space& space, const Ratios& ratios,
                               const RefineOptions& options) {
    std::vector<double> cuts(space.mesh.vertex_count(), 1 / options.eta);
    for (Index t = 0; t < ratios.size(); ++t)
        for (Index k = 0; k < 3; ++k) {
            double& smallest = cuts[space.mesh.triangles[t][k]];
            smallest = std::min(smallest, ratios[t][k]);
        }
    choose_cuts(options, cuts);
    return cuts;
}

/// The smallest 1 / rho at the old vertices of the mesh that the first half of a triadic step
/// makes: its triangle (V_i, Z', Z) has nu / rho + (1 - nu) / rho', where R = nu Z + (1 - nu) Z'.
std::vector<double> second_cuts(const Space& space, const Ratios& ratios,
                                const RefineOptions& options) {
    const Triangulation& mesh = space.mesh;
    std::vector<double> cuts(mesh.vertex_count(), 1 / options.eta);
    for (Index e = 0; e < mesh.edge_count(); ++e) {
        if (mesh.on_boundary(e)) continue;
        const auto [left, right] = mesh.edge_triangles[e];
        const Vec2 from = mesh.vertex(mesh.edges[e][0]);
        const double height = cross(mesh.edge_vector(e), space.split.centre[left] - from);
        const double depth = cross(mesh.edge_vector(e), space.split.centre[right] - from);
        const double nu = depth / (depth - height);
        for (const Index v : mesh.edges[e]) {
            const auto ratio = [&](Index t) {
                const auto& corners = mesh.triangles[t];
                return ratios[t][std::find(corners.begin(), corners.end(), v) - corners.begin()];
            };
            cuts[v] = std::min(cuts[v], nu * ratio(left) + (1 - nu) * ratio(right));
        }
    }
    choose_cuts(options, cuts);
    return cuts;
}

/// A refined mesh under construction.
struct Draft {
    explicit Draft(const Triangulation& coarse, std::size_t vertices, std::size_t triangle_count)
        : x(vertices), y(vertices), triangles(triangle_count), centre(triangle_count) {
        std::copy(coarse.x.begin(), coarse.x.end(), x.begin());
        std::copy(coarse.y.begin(), coarse.y.end(), y.begin());
    }
    void set_vertex(std::size_t v, Vec2 position) {
        x[v] = position.x;
        y[v] = position.y;
    }
    void set_triangle(std::size_t t, const std::array<Index, 3>& corners, Vec2 inner) {
        triangles[t] = corners;
        centre[t] = inner;
    }
    std::vector<double> x;
    std::vector<double> y;
    std::vector<std::array<Index, 3>> triangles;
    std::vector<Vec2> centre;
};

/// Joins the triangles; boundary_weight(lower, higher) is the weight of the lower vertex in R of a
/// boundary edge.
template <class BoundaryWeight>
Status finish(const Triangulation& coarse, Draft draft, Space& fine, BoundaryWeight weight) {
    fine.mesh = mesh::connect(coarse.origin, std::move(draft.x), std::move(draft.y),
                              std::move(draft.triangles));
    const std::size_t thin = first_failure(fine.mesh.triangles.size(), [&](Index t) {
        const TriangleCorners v = fine.mesh.corners(t);
        double longest = 0;
        for (Index k = 0; k < 3; ++k) {
            const Vec2 side = v[next(k)] - v[k];
            longest = std::max(longest, dot(side, side));
        }
        return orient(v[0], v[1], v[2]) > kThinnest * longest;
    });
    if (thin < fine.mesh.triangles.size())
        return bad_input(
            "degenerate_triangle: a triangle of the refined mesh has no area; remove thin "
            "triangles "
            "from the mesh before it is refined",
            "refined triangle " + std::to_string(thin));
    fine.split.centre = std::move(draft.centre);
    fine.split.edge_weight.resize(fine.mesh.edge_count());
    for (Index e = 0; e < fine.mesh.edge_count(); ++e)
        if (fine.mesh.on_boundary(e))
            fine.split.edge_weight[e] = weight(fine.mesh.edges[e][0], fine.mesh.edges[e][1]);
    return cross_edges(fine.mesh, fine.split);
}

class TriadicDraft {
  public:
    TriadicDraft(const Space& coarse, const Ratios& ratios, const Refinement& step)
        : coarse_(coarse),
          ratios_(ratios),
          step_(step),
          n_(coarse.mesh.vertex_count()),
          t_(coarse.mesh.triangle_count()) {}

    Draft build() {
        const std::size_t edges = coarse_.mesh.edges.size();
        Draft draft(coarse_.mesh, std::size_t{n_} + t_ + 2 * edges, 9 * std::size_t{t_});
        for_each_index(edges, [&](Index e) {
            const auto [lower, higher] = coarse_.mesh.edges[e];
            const double weight = coarse_.split.edge_weight[e];
            const Vec2 along = coarse_.mesh.edge_vector(e);
            draft.set_vertex(near_lower(e), coarse_.mesh.vertex(lower) +
                                                (step_.kappa[lower] * (1 - weight)) * along);
            draft.set_vertex(near_lower(e) + 1,
                             coarse_.mesh.vertex(higher) - (step_.kappa[higher] * weight) * along);
        });
        for_each_index(t_, [&](Index t) { cut_triangle(t, draft); });
        return draft;
    }

    /// Outer thirds end beyond the point; the middle third keeps the old point.
    [[nodiscard]] double boundary_weight(Index lower, Index higher) const {
        if (lower < n_) return 1 - 0.75 * step_.second_kappa[lower];
        const Index e = (higher - n_ - t_) / 2;
        const double weight = coarse_.split.edge_weight[e];
        const auto [from, to] = coarse_.mesh.edges[e];
        const double before_point = (1 - weight) * (1 - step_.kappa[from]);
        const double after_point = weight * (1 - step_.kappa[to]);
        return after_point / (before_point + after_point);
    }

  private:
    /// The vertex of an edge near its lower end; the next one is near the higher end.
    [[nodiscard]] Index near_lower(Index e) const { return n_ + t_ + 2 * e; }
    /// The vertex on edge k of a triangle near corner k, and near corner k + 1.
    [[nodiscard]] std::array<Index, 2> on_edge(Index t, Index k) const {
        const Index first = near_lower(coarse_.mesh.triangle_edges[t][k]);
        if (coarse_.mesh.runs_forward(t, k)) return {first, first + 1};
        return {first + 1, first};
    }

    void cut_triangle(Index t, Draft& draft) const {
        const PsElement element = coarse_.element(t);
        const Vec2 z = element.centre();
        const Index centre = n_ + t;
        draft.set_vertex(centre, z);
        for (Index k = 0; k < 3; ++k) {
            const Index v = coarse_.mesh.triangles[t][k];
            const double tau = step_.kappa[v] / ratios_[t][k];
            const auto [after, next_before] = on_edge(t, k);
            const Index previous = on_edge(t, before(k))[1];
            const Vec2 inwards = -1 * element.corner(k);  // from V_k to Z
            draft.set_triangle(9 * std::size_t{t} + k, {v, after, previous},
                               coarse_.mesh.vertex(v) + (step_.second_kappa[v] * tau) * inwards);
            draft.set_triangle(9 * std::size_t{t} + 3 + k, {centre, previous, after},
                               z - (kFullCut * (1 - tau)) * inwards);
            draft.set_triangle(9 * std::size_t{t} + 6 + k, {centre, after, next_before},
                               z + kFullCut * element.edge_point(static_cast<int>(k)));
        }
    }

    const Space& coarse_;
    const Ratios& ratios_;
    const Refinement& step_;
    Index n_;
    Index t_;
};

Status refine_triadic(const Space& coarse, const RefineOptions& options, Refinement& step) {
    const Ratios ratios = inverse_ratios(coarse);
    step.kappa = first_cuts(coarse, ratios, options);
    step.second_kappa = second_cuts(coarse, ratios, options);
    TriadicDraft triadic(coarse, ratios, step);
    return finish(coarse.mesh, triadic.build(), step.fine,
                  [&](Index a, Index b) { return triadic.boundary_weight(a, b); });
}

Status refine_root3(const Space& coarse, const RefineOptions& options, Refinement& step) {
    step.kappa = first_cuts(coarse, inverse_ratios(coarse), options);
    const Triangulation& mesh = coarse.mesh;
    const Index n = mesh.vertex_count();
    Draft draft(mesh, std::size_t{n} + mesh.triangle_count(), 3 * mesh.triangles.size());
    for (Index t = 0; t < mesh.triangle_count(); ++t)
        draft.set_vertex(n + t, coarse.split.centre[t]);
    std::vector<double> boundary;  // weights of boundary edges in the order of edges
    std::size_t made = 0;
    for (Index e = 0; e < mesh.edge_count(); ++e) {
        const auto [lower, higher] = mesh.edges[e];
        const auto [left, right] = mesh.edge_triangles[e];
        const Vec2 r = edge_point(mesh, coarse.split, e);
        if (mesh.on_boundary(e)) {
            const Index t = left == kNone ? right : left;
            const Index from = left == kNone ? higher : lower;
            draft.set_triangle(made++, {from, lower + higher - from, n + t},
                               r + (1.0 / 3) * (coarse.split.centre[t] - r));
            boundary.push_back(coarse.split.edge_weight[e]);
            continue;
        }
        const auto near = [&](Index v) {
            return mesh.vertex(v) + step.kappa[v] * (r - mesh.vertex(v));
        };
        draft.set_triangle(made++, {lower, n + right, n + left}, near(lower));
        draft.set_triangle(made++, {higher, n + left, n + right}, near(higher));
    }
    // Boundary edges stay, and with them their order.
    auto weight = boundary.begin();
    return finish(mesh, std::move(draft), step.fine, [&](Index, Index) { return *weight++; });
}

Status refine_dyadic(const Space& coarse, Refinement& step) {
    const Triangulation& mesh = coarse.mesh;
    const Ratios ratios = inverse_ratios(coarse);
    const auto bad = std::find_if(ratios.begin(), ratios.end(), [](const auto& r) {
        return !(std::min({r[0], r[1], r[2]}) > 1 + kDyadicMargin);
    });
    if (bad != ratios.end())
        return bad_input(
            "dyadic_not_applicable: the inner point is not inside the triangle of its edge points; "
            "refine triadically",
            "triangle " + std::to_string(bad - ratios.begin()));
    const Index n = mesh.vertex_count();
    Draft draft(mesh, std::size_t{n} + mesh.edge_count(), 4 * mesh.triangles.size());
    for (Index e = 0; e < mesh.edge_count(); ++e)
        draft.set_vertex(n + e, edge_point(mesh, coarse.split, e));
    for (Index t = 0; t < mesh.triangle_count(); ++t) {
        const Vec2 z = coarse.split.centre[t];
        const auto& edge = mesh.triangle_edges[t];
        for (Index k = 0; k < 3; ++k) {
            const Index v = mesh.triangles[t][k];
            draft.set_triangle(4 * std::size_t{t} + k, {v, n + edge[k], n + edge[before(k)]},
                               mesh.vertex(v) + (kFullCut / ratios[t][k]) * (z - mesh.vertex(v)));
        }
        draft.set_triangle(4 * std::size_t{t} + 3, {n + edge[0], n + edge[1], n + edge[2]}, z);
    }
    return finish(mesh, std::move(draft), step.fine, [](Index, Index) { return 0.5; });
}

/// By how much a control triangle, scaled about its vertex, must at least be as large as it is to
/// contain a point.
double needed_scale(const std::array<spline::TangentPlane, 3>& basis, Vec2 point) {
    double scale = 0;
    for (const spline::TangentPlane& function : basis)
        if (function.value > kOnSide)
            scale = std::max(scale, -dot(function.gradient, point) / function.value);
    return std::min(scale, 1.0);
}

/// Shrinks the control triangles of the first `count` vertices as far as their points allow.
void tighten(Space& space, std::size_t count) {
    const Triangulation& mesh = space.mesh;
    std::vector<std::array<double, 3>> needed(mesh.triangles.size());
    for_each_index(needed.size(), [&](Index t) {
        for (Index k = 0; k < 3; ++k) {
            const Index v = mesh.triangles[t][k];
            if (v >= count) continue;
            const auto basis = basis_planes(space.control[v]);
            for (const Vec2 point : halfway_points(mesh, space.split, t, k))
                needed[t][k] = std::max(needed[t][k], needed_scale(basis, point));
        }
    });
    std::vector<double> scale(count);
    for (Index t = 0; t < needed.size(); ++t)
        for (Index k = 0; k < 3; ++k) {
            const Index v = mesh.triangles[t][k];
            if (v < count) scale[v] = std::max(scale[v], needed[t][k]);
        }
    for (std::size_t v = 0; v < count; ++v)
        for (Vec2& corner : space.control[v]) corner = scale[v] * corner;
}

/// Control triangles of triadic and root-3 steps.
void place_controls(const Space& coarse, const RefineOptions& options, Refinement& step) {
    const Index n = coarse.mesh.vertex_count();
    const Index t = coarse.mesh.triangle_count();
    const bool triadic = step.scheme == Scheme::Triadic;
    Space& fine = step.fine;
    fine.control = coarse.control;
    fine.control.resize(fine.mesh.vertex_count());
    for_each_index(fine.control.size() - n, [&](Index k) {
        const Index v = n + k;
        fine.control[v] =
            anchors(coarse, step.scheme, step.kappa, v, fine.mesh.vertex(v), {}).point;
        if (triadic && k < t)
            for (Vec2& corner : fine.control[v]) corner = kFullCut * corner;
    });
    if (options.rescale == Rescale::Tight) tighten(fine, triadic ? n + t : n);
    if (options.rescale != Rescale::Paper) return;
    std::vector<double> scale = step.kappa;
    if (triadic)
        for (Index v = 0; v < n; ++v) scale[v] *= step.second_kappa[v];
    else
        for (Index e = 0; e < coarse.mesh.edge_count(); ++e)
            if (coarse.mesh.on_boundary(e))
                for (const Index v : coarse.mesh.edges[e]) scale[v] = 1;
    for (Index v = 0; v < n; ++v)
        for (Vec2& corner : fine.control[v]) corner = scale[v] * corner;
}

Status check_size(const Triangulation& mesh, const RefineOptions& options) {
    if (!(options.eta > 0 && options.eta < 1))
        return Error{ErrorCode::InvalidArgument,
                     "invalid_eta: choose it between 0 and 1, such as 0.75", ""};
    const std::uint64_t edges =
        3 * std::uint64_t{mesh.edge_count()} + 9 * std::uint64_t{mesh.triangle_count()};
    if (edges < (std::uint64_t{1} << 31)) return {};
    return bad_input("too_many_elements: the refined mesh would have " + std::to_string(edges) +
                     " edges, 2^31 or more; refine less often");
}

}  // namespace

Result<Refinement> refine(const Space& coarse, const RefineOptions& options) {
    RELIEF_CHECK(check_size(coarse.mesh, options));
    Refinement step{options.scheme, {}, {}, {}};
    switch (options.scheme) {
        case Scheme::Triadic:
            RELIEF_CHECK(refine_triadic(coarse, options, step));
            break;
        case Scheme::Root3:
            RELIEF_CHECK(refine_root3(coarse, options, step));
            break;
        case Scheme::Dyadic:
            RELIEF_CHECK(refine_dyadic(coarse, step));
            break;
    }
    if (options.rescale == Rescale::Smallest || options.scheme == Scheme::Dyadic) {
        RELIEF_TRY(step.fine.control, smallest_controls(step.fine.mesh, step.fine.split));
    } else {
        place_controls(coarse, options, step);
    }
    return step;
}

}  // namespace relief::multires::ps
