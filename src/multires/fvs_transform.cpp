#include <algorithm>
#include <cmath>

#include "multires/fvs_functionals.h"
#include "relief/core/parallel.h"

namespace relief::multires::fvs_mesh {

using mesh::Index;
using mesh::Quadrangulation;

namespace {

constexpr std::int64_t kGrain = 1024;

void predict_edge(const Quadrangulation& parent, const NodalData& low, Index e, NodalData& fine) {
    const auto [a, b] = parent.edges[e];
    const Vec2 edge = parent.edge_vector(e);
    const double h = length(edge);
    const Vec2 along = unit(edge);
    const Vec2 across = turned(along);
    const Vec2 ga{low.dx[a], low.dy[a]};
    const Vec2 gb{low.dx[b], low.dy[b]};
    const spline::FvsEdgeMiddle middle =
        spline::fvs_edge_middle(h, {low.value[a], low.value[b]}, {dot(ga, along), dot(gb, along)},
                                {dot(ga, across), dot(gb, across)}, low.normal[e]);
    const Vec2 gradient = middle.tangential * along + low.normal[e] * across;
    const Index v = parent.vertex_count() + e;
    fine.value[v] = middle.value;
    fine.dx[v] = gradient.x;
    fine.dy[v] = gradient.y;
    fine.normal[2 * e] = middle.half_normals[0];
    fine.normal[2 * e + 1] = middle.half_normals[1];
}

void predict_quad(const Quadrangulation& parent, const NodalData& low, Index q, NodalData& fine) {
    const spline::FvsElement element(parent.corners(q));
    const spline::FvsQuadMiddle middle =
        element.middle(element.ordinates(quad_data(parent, low, q)));
    const Index v = parent.vertex_count() + parent.edge_count() + q;
    fine.value[v] = middle.value;
    fine.dx[v] = middle.gradient.x;
    fine.dy[v] = middle.gradient.y;
    std::copy(
        middle.inner_normals.begin(), middle.inner_normals.end(),
        fine.normal.begin() + 2 * std::ptrdiff_t{parent.edge_count()} + 4 * std::ptrdiff_t{q});
}

}  // namespace

Result<Hierarchy> Hierarchy::create(Quadrangulation base, int levels) {
    RELIEF_CHECK(mesh::level_counts(base, levels));
    std::vector<Quadrangulation> meshes;
    meshes.reserve(static_cast<std::size_t>(levels) + 1);
    meshes.push_back(std::move(base));
    for (int m = 0; m < levels; ++m) {
        RELIEF_TRY(Quadrangulation child, mesh::refine(meshes.back()));
        meshes.push_back(std::move(child));
    }
    return Hierarchy(std::move(meshes));
}

NodalData interpolate(const Quadrangulation& mesh, const std::function<spline::PlaneJet(Vec2)>& f) {
    NodalData data = make_nodal<double>(mesh);
    for (Index v = 0; v < mesh.vertex_count(); ++v) {
        const spline::PlaneJet jet = f(mesh.origin + mesh.vertex(v));
        data.value[v] = jet.value;
        data.dx[v] = jet.gradient.x;
        data.dy[v] = jet.gradient.y;
    }
    for (Index e = 0; e < mesh.edge_count(); ++e) {
        const auto [a, b] = mesh.edges[e];
        const Vec2 middle = midpoint(mesh.vertex(a), mesh.vertex(b));
        data.normal[e] = dot(f(mesh.origin + middle).gradient, turned(unit(mesh.edge_vector(e))));
    }
    return data;
}

NodalData predict(const Quadrangulation& parent, const NodalData& low) {
    const std::size_t edges = parent.edge_count();
    const std::size_t quads = parent.quad_count();
    NodalData fine;
    for_each_nodal([](std::vector<double>& to, const std::vector<double>& from) { to = from; },
                   fine, low);
    const std::size_t vertices = low.value.size() + edges + quads;
    fine.value.resize(vertices);
    fine.dx.resize(vertices);
    fine.dy.resize(vertices);
    fine.normal.resize(2 * edges + 4 * quads);
    parallel_for(0, static_cast<std::int64_t>(edges), kGrain,
                 [&](std::int64_t first, std::int64_t last) {
                     for (std::int64_t e = first; e < last; ++e)
                         predict_edge(parent, low, static_cast<Index>(e), fine);
                 });
    parallel_for(0, static_cast<std::int64_t>(quads), kGrain,
                 [&](std::int64_t first, std::int64_t last) {
                     for (std::int64_t q = first; q < last; ++q)
                         predict_quad(parent, low, static_cast<Index>(q), fine);
                 });
    return fine;
}

NodalData restrict_to(const Quadrangulation& parent, const NodalData& fine) {
    const Index vertices = parent.vertex_count();
    NodalData low = make_nodal<double>(parent);
    std::copy_n(fine.value.begin(), vertices, low.value.begin());
    std::copy_n(fine.dx.begin(), vertices, low.dx.begin());
    std::copy_n(fine.dy.begin(), vertices, low.dy.begin());
    for (Index e = 0; e < parent.edge_count(); ++e)
        low.normal[e] = dot(Vec2{fine.dx[vertices + e], fine.dy[vertices + e]},
                            turned(unit(parent.edge_vector(e))));
    return low;
}

Details<double> extract(const Quadrangulation& parent, const NodalData& fine,
                        const NodalData& predicted) {
    Details<double> details = make_details<double>(parent);
    const Index edges = parent.edge_count();
    for (Index e = 0; e < edges; ++e) {
        const Index v = parent.vertex_count() + e;
        const Vec2 gradient{fine.dx[v] - predicted.dx[v], fine.dy[v] - predicted.dy[v]};
        details.edge_value[e] = fine.value[v] - predicted.value[v];
        details.edge_tangential[e] = dot(gradient, unit(parent.edge_vector(e)));
    }
    for (Index q = 0; q < parent.quad_count(); ++q) {
        const Index v = parent.vertex_count() + edges + q;
        details.centre_value[q] = fine.value[v] - predicted.value[v];
        details.centre_dx[q] = fine.dx[v] - predicted.dx[v];
        details.centre_dy[q] = fine.dy[v] - predicted.dy[v];
    }
    for (std::size_t e = 0; e < details.normal.size(); ++e)
        details.normal[e] = fine.normal[e] - predicted.normal[e];
    return details;
}

void insert(const Quadrangulation& parent, const Details<double>& details, NodalData& fine) {
    const Index edges = parent.edge_count();
    for (Index e = 0; e < edges; ++e) {
        const Index v = parent.vertex_count() + e;
        const Vec2 gradient = details.edge_tangential[e] * unit(parent.edge_vector(e));
        fine.value[v] += details.edge_value[e];
        fine.dx[v] += gradient.x;
        fine.dy[v] += gradient.y;
    }
    for (Index q = 0; q < parent.quad_count(); ++q) {
        const Index v = parent.vertex_count() + edges + q;
        fine.value[v] += details.centre_value[q];
        fine.dx[v] += details.centre_dx[q];
        fine.dy[v] += details.centre_dy[q];
    }
    for (std::size_t e = 0; e < details.normal.size(); ++e) fine.normal[e] += details.normal[e];
}

Result<Decomposition> decompose(const Hierarchy& hierarchy, NodalData finest) {
    RELIEF_CHECK(check(hierarchy.mesh(hierarchy.levels()), finest));
    Decomposition out;
    out.details.resize(static_cast<std::size_t>(hierarchy.levels()));
    NodalData fine = std::move(finest);
    for (int m = hierarchy.levels(); m > 0; --m) {
        const Quadrangulation& parent = hierarchy.mesh(m - 1);
        NodalData low = restrict_to(parent, fine);
        out.details[m - 1] = extract(parent, fine, predict(parent, low));
        fine = std::move(low);
    }
    out.base = std::move(fine);
    return out;
}

Result<NodalData> reconstruct(const Hierarchy& hierarchy, const Decomposition& coefficients,
                              int level) {
    RELIEF_CHECK(check_sizes(hierarchy, coefficients.base, coefficients.details, level));
    NodalData data = coefficients.base;
    for (int m = 1; m <= level; ++m) {
        const Quadrangulation& parent = hierarchy.mesh(m - 1);
        data = predict(parent, data);
        insert(parent, coefficients.details[m - 1], data);
    }
    RELIEF_CHECK(check(hierarchy.mesh(level), data));
    return data;
}

std::vector<Details<double>> threshold_limits(const Hierarchy& hierarchy, double epsilon,
                                              Convention convention) {
    std::vector<Details<double>> limits;
    const int finest = hierarchy.levels();
    for (int m = 1; m <= finest; ++m) {
        const double factor = convention == Convention::Const ? std::ldexp(1.0, finest - m) : 1.0;
        limits.push_back(detail_units(hierarchy.mesh(m - 1), hierarchy.mesh(m), factor));
        for_each_detail(
            [&](std::vector<double>& units) {
                for (double& unit : units) unit *= epsilon;
            },
            limits.back());
    }
    return limits;
}

std::vector<std::uint64_t> threshold(Decomposition& coefficients,
                                     const std::vector<Details<double>>& limits) {
    std::vector<std::uint64_t> kept = {3 * coefficients.base.value.size() +
                                       coefficients.base.normal.size()};
    for (std::size_t m = 0; m < coefficients.details.size(); ++m) {
        kept.push_back(0);
        for_each_detail(
            [&](std::vector<double>& numbers, const std::vector<double>& limit) {
                for (std::size_t k = 0; k < numbers.size(); ++k) {
                    if (std::abs(numbers[k]) < limit[k])
                        numbers[k] = 0;
                    else
                        ++kept.back();
                }
            },
            coefficients.details[m], limits[m]);
    }
    return kept;
}

}  // namespace relief::multires::fvs_mesh
