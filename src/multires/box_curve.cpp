#include "multires/box_curve.h"

#include <algorithm>
#include <cmath>

#include "multires/box_factors.h"
#include "multires/box_rules.h"

namespace relief::multires::box {

namespace {

/// Calls visit(vertex, weight) for the targets of the update of edge j (between vertices j and j +
/// 1).
template <class Visit>
void for_targets(const Rules& rules, std::int64_t vertices, std::int64_t j, Visit visit) {
    for (std::int64_t k = 0; k < kCurveReach; ++k) {
        const double weight = rules.curve_update[std::size_t(k)];
        if (weight == 0) continue;
        if (j - k >= 0) visit(j - k, weight);
        if (j + 1 + k < vertices) visit(j + 1 + k, weight);
    }
}

double factor_at(const CurveFactors& factors, std::int64_t j, std::int64_t edges) {
    return factors[std::size_t(table_index(j, edges, std::int64_t(factors.size())))];
}

template <class T>
void add_update(const Rules& rules, T sign, const CurveFactors& factors, Line<const T> edges,
                Line<T> vertices) {
    for (std::int64_t j = 0; j < edges.size; ++j) {
        const T scaled = sign * T(factor_at(factors, j, edges.size)) * edges[j];
        for_targets(rules, vertices.size, j,
                    [&](std::int64_t k, double weight) { vertices[k] += T(weight) * scaled; });
    }
}

template <class T>
void add_prediction(const Rules& rules, T sign, Line<const T> vertices, Line<T> edges) {
    const T half = sign * T(rules.border_ends);
    for (std::int64_t j = 0; j < edges.size; ++j)
        edges[j] += half * (vertices[j] + vertices[j + 1]);
}

/// Either direction of step 1, in place; the two ends do not move.
template <class T>
void apply_vertex_rule(VertexRule rule, Line<const T> edges, Line<T> vertices) {
    for (std::int64_t j = 1; j + 1 < vertices.size; ++j)
        vertices[j] = T(rule.centre) * vertices[j] + T(rule.ring) * (edges[j - 1] + edges[j]);
}

/// The transposes of the vertex step and of the prediction.
template <class T>
void spread_and_collect(const Rules& rules, Line<T> vertices, Line<T> edges) {
    for (std::int64_t j = 1; j + 1 < vertices.size && rules.has_vertex_step; ++j) {
        edges[j - 1] += T(rules.border_vertex.ring) * vertices[j];
        edges[j] += T(rules.border_vertex.ring) * vertices[j];
        vertices[j] *= T(rules.border_vertex.centre);
    }
    for (std::int64_t j = 0; j < edges.size; ++j) {
        vertices[j] += T(rules.border_ends) * edges[j];
        vertices[j + 1] += T(rules.border_ends) * edges[j];
    }
}

/// The integrals of the next coarser level in `integrals`; returns the factors between the two
/// levels.
CurveFactors coarsen_integrals(const Rules& rules, std::vector<double>& integrals) {
    if (integrals.size() % 2 == 0) integrals.push_back(integrals.back());
    const auto count = std::int64_t(integrals.size() / 2);
    std::vector<double> vertices(std::size_t(count + 1));
    std::vector<double> edges(static_cast<std::size_t>(count));
    for (std::size_t k = 0; k < integrals.size(); ++k)
        (k % 2 == 0 ? vertices : edges)[k / 2] = integrals[k];
    spread_and_collect(rules, Line<double>{vertices.data(), count + 1, 1},
                       Line<double>{edges.data(), count, 1});
    for (std::int64_t j = 0; j < count; ++j) {
        double targets = 0;
        for_targets(rules, count + 1, j,
                    [&](std::int64_t k, double w) { targets += w * vertices[std::size_t(k)]; });
        edges[std::size_t(j)] /= targets;
    }
    integrals = std::move(vertices);
    return edges;
}

}  // namespace

std::vector<CurveFactors> curve_factors(int order, std::int64_t n, int levels) {
    std::vector<CurveFactors> factors;
    std::vector<double> integrals(std::size_t(table_size(n)), 1.0);
    for (int level = 1; level <= levels; ++level) {
        factors.push_back(coarsen_integrals(rules(order), integrals));
        n = coarser(n);
        std::vector<double> resized(std::size_t(table_size(n)));
        for (std::size_t k = 0; k < resized.size(); ++k)
            resized[k] = integrals[std::size_t(table_index(
                std::int64_t(k), std::int64_t(resized.size()), std::int64_t(integrals.size())))];
        integrals = std::move(resized);
    }
    return factors;
}

template <class T>
void analyse_curve(int order, const CurveFactors& factors, Line<const T> fine, Line<T> vertices,
                   Line<T> edges) {
    const Rules& r = rules(order);
    const std::int64_t n = fine.size;
    for (std::int64_t j = 0; j < edges.size; ++j) {
        vertices[j] = fine[2 * j];
        edges[j] = fine[2 * j + 1];
    }
    vertices[edges.size] = n % 2 == 1 ? fine[n - 1] : 2 * fine[n - 1] - fine[n - 2];
    const Line<const T> points = {edges.data, edges.size, edges.step};
    const Line<const T> ends = {vertices.data, vertices.size, vertices.step};
    if (r.has_vertex_step) apply_vertex_rule(inverse(r.border_vertex), points, vertices);
    add_prediction(r, T(-1), ends, edges);
    add_update(r, T(1), factors, points, vertices);
}

template <class T>
void synthesise_curve(int order, const CurveFactors& factors, Line<const T> vertices,
                      Line<const T> edges, Line<T> fine) {
    const Rules& r = rules(order);
    std::vector<T> v(std::size_t(vertices.size));
    std::vector<T> e(std::size_t(edges.size));
    const Line<T> ends = {v.data(), vertices.size, 1};
    const Line<T> points = {e.data(), edges.size, 1};
    for (std::int64_t j = 0; j < vertices.size; ++j) v[std::size_t(j)] = vertices[j];
    for (std::int64_t j = 0; j < edges.size; ++j) e[std::size_t(j)] = edges[j];
    add_update(r, T(-1), factors, edges, ends);
    add_prediction(r, T(1), Line<const T>{v.data(), ends.size, 1}, points);
    if (r.has_vertex_step)
        apply_vertex_rule(r.border_vertex, Line<const T>{e.data(), points.size, 1}, ends);
    for (std::int64_t k = 0; k < fine.size; ++k) fine[k] = (k % 2 == 0 ? v : e)[std::size_t(k / 2)];
}

template <class T>
void transpose_curve(int order, const CurveFactors& factors, Line<const T> fine, Line<T> vertices,
                     Line<T> edges) {
    const Rules& r = rules(order);
    for (std::int64_t j = 0; j < edges.size; ++j) {
        vertices[j] = fine[2 * j];
        edges[j] = fine[2 * j + 1];
    }
    vertices[edges.size] = fine.size % 2 == 1 ? fine[fine.size - 1] : T(0);
    spread_and_collect(r, vertices, edges);
    for (std::int64_t j = 0; j < edges.size; ++j) {
        T targets = 0;
        for_targets(r, vertices.size, j,
                    [&](std::int64_t k, double weight) { targets += T(weight) * vertices[k]; });
        edges[j] -= T(factor_at(factors, j, edges.size)) * targets;
    }
}

#define RELIEF_INSTANTIATE(T)                                                               \
    template void analyse_curve(int, const CurveFactors&, Line<const T>, Line<T>, Line<T>); \
    template void synthesise_curve(int, const CurveFactors&, Line<const T>, Line<const T>,  \
                                   Line<T>);                                                \
    template void transpose_curve(int, const CurveFactors&, Line<const T>, Line<T>, Line<T>);
RELIEF_INSTANTIATE(float)
RELIEF_INSTANTIATE(double)
#undef RELIEF_INSTANTIATE

}  // namespace relief::multires::box
