#include "codec/ps_source.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "codec/ps_chunks.h"

namespace relief::codec {

namespace ps = multires::ps;
using mesh::Index;

namespace {

constexpr double kLargestValue = 1e150;
constexpr std::size_t kMostComponents = 3;

Error bad_data(std::string message, std::string where) {
    return {ErrorCode::BadInput, std::move(message), std::move(where)};
}

Status check_components(std::size_t count) {
    if (count >= 1 && count <= kMostComponents) return {};
    return bad_data(
        "component_count: there are " + std::to_string(count) + " components; 1 to 3 are possible",
        "");
}

Status check_size(std::size_t size, std::size_t expected, const char* what) {
    if (size == expected) return {};
    return bad_data("size_mismatch: there are " + std::to_string(size) + " " + what + ", not " +
                        std::to_string(expected),
                    "");
}

Status check_numbers(const std::vector<double>& numbers, const char* element) {
    for (std::size_t k = 0; k < numbers.size(); ++k)
        if (!(std::abs(numbers[k]) <= kLargestValue))
            return bad_data(
                "non_finite_data: a number is not finite or beyond 1e150; correct or remove it",
                element + (" " + std::to_string(k)));
    return {};
}

Status check_data(const PsData& data, std::size_t components) {
    if (data.points.empty()) return {};
    RELIEF_CHECK(check_size(data.values.size(), components, "components of data"));
    if (!data.weights.empty())
        RELIEF_CHECK(check_size(data.weights.size(), data.points.size(), "weights"));
    for (const std::vector<double>& values : data.values) {
        RELIEF_CHECK(check_size(values.size(), data.points.size(), "values of points"));
        RELIEF_CHECK(check_numbers(values, "point"));
    }
    RELIEF_CHECK(check_numbers(data.weights, "point"));
    for (std::size_t k = 0; k < data.points.size(); ++k) {
        const auto& [x, y] = data.points[k];
        const bool negative = !data.weights.empty() && data.weights[k] < 0;
        if (!(std::abs(x) <= kLargestValue && std::abs(y) <= kLargestValue) || negative)
            return bad_data("non_finite_data: its place is not finite, or its weight negative",
                            "point " + std::to_string(k));
    }
    return {};
}

Result<ps::Hierarchy> hierarchy_on(const mesh::Triangulation& base, int levels) {
    RELIEF_TRY(ps::Space space, ps::make_space(base));
    return ps::Hierarchy::create(std::move(space), levels);
}

/// The corresponding vertices of two refined meshes whose coarser ones correspond.
std::vector<Index> refined_vertices(const mesh::Triangulation& mesh,
                                    const mesh::Triangulation& other,
                                    const PsNumbering& numbering) {
    std::vector<Index> vertices = numbering.vertices;
    for (const Index t : numbering.triangles) vertices.push_back(other.vertex_count() + t);
    const Index first = other.vertex_count() + other.triangle_count();
    std::vector<Index> edges(mesh.edges.size());
    for (Index t = 0; t < mesh.triangle_count(); ++t)
        for (std::size_t k = 0; k < 3; ++k)
            edges[mesh.triangle_edges[t][k]] =
                other.triangle_edges[numbering.triangles[t]][(k + numbering.turns[t]) % 3];
    for (Index e = 0; e < mesh.edge_count(); ++e) {
        const bool turned = numbering.vertices[mesh.edges[e][0]] != other.edges[edges[e]][0];
        for (const Index end : {0U, 1U})
            vertices.push_back(first + 2 * edges[e] + (turned ? 1 - end : end));
    }
    return vertices;
}

/// Splines of a hierarchy whose base is numbered in another way, by their tangent planes.
Result<LevelHeights> renumbered(const ps::Hierarchy& hierarchy, const ps::Hierarchy& other,
                                PsNumbering numbering, const LevelHeights& splines) {
    for (int m = 0; m < hierarchy.levels(); ++m) {
        auto vertices = refined_vertices(hierarchy.space(m).mesh, other.space(m).mesh, numbering);
        auto next = numbering_of(hierarchy.space(m + 1).mesh.triangles,
                                 other.space(m + 1).mesh.triangles, std::move(vertices));
        if (!next)
            return bad_data("its refinements depend on the numbers of vertices; keep their order",
                            "base");
        numbering = *std::move(next);
    }
    const ps::Space& space = hierarchy.space(hierarchy.levels());
    const ps::Space& from = other.space(other.levels());
    LevelHeights result;
    for (const ps::Coefficients& spline : splines) {
        const ps::TangentPlanes planes = tangent_planes(from, spline);
        ps::TangentPlanes moved;
        for (const Index v : numbering.vertices) moved.push_back(planes[v]);
        result.push_back(coefficients(space, moved));
    }
    return result;
}

Result<PsSource> prepare_values(const PsModel& model, PsValues values, CodedPsBase base) {
    RELIEF_CHECK(check_components(values.components.size()));
    RELIEF_CHECK(check_data(model.data, values.components.size()));
    for (std::vector<double>& component : values.components) {
        RELIEF_CHECK(check_size(component.size(), model.base.x.size(), "values"));
        RELIEF_CHECK(check_numbers(component, "vertex"));
        if (!base.numbering) continue;
        const std::vector<double> before = component;
        for (std::size_t v = 0; v < before.size(); ++v)
            component[v] = before[base.numbering->vertices[v]];
    }
    RELIEF_TRY(ps::Hierarchy hierarchy, hierarchy_on(base.mesh, 0));
    RELIEF_TRY(LevelHeights splines,
               splines_through(hierarchy.space(0), values.components, values.gradients));
    return PsSource{std::move(base),    std::move(hierarchy), std::move(values),
                    std::move(splines), model.data,           model.reference};
}

Result<PsSource> prepare_splines(const PsModel& model, const PsSplines& splines, CodedPsBase base) {
    RELIEF_CHECK(check_components(splines.components.size()));
    RELIEF_CHECK(check_data(model.data, splines.components.size()));
    const std::uint64_t vertices = level_counts(base.mesh, splines.levels).vertices;
    for (const ps::Coefficients& component : splines.components)
        RELIEF_CHECK(check_size(component.size(), vertices, "vertices with coefficients"));
    RELIEF_TRY(ps::Hierarchy hierarchy, hierarchy_on(base.mesh, splines.levels));
    const ps::Space& finest = hierarchy.space(splines.levels);
    for (const ps::Coefficients& component : splines.components)
        RELIEF_CHECK(ps::check(finest.mesh, component));
    LevelHeights heights = splines.components;
    if (base.numbering) {
        RELIEF_TRY(const ps::Hierarchy other, hierarchy_on(model.base, splines.levels));
        RELIEF_TRY(heights, renumbered(hierarchy, other, *base.numbering, heights));
    }
    return PsSource{std::move(base),    std::move(hierarchy), {},
                    std::move(heights), model.data,           model.reference};
}

}  // namespace

Result<PsSource> prepare_ps(const PsModel& model, bool keep_order) {
    RELIEF_TRY(CodedPsBase base, encode_ps_base(model.base, keep_order));
    if (const auto* values = std::get_if<PsValues>(&model.surface))
        return prepare_values(model, *values, std::move(base));
    return prepare_splines(model, std::get<PsSplines>(model.surface), std::move(base));
}

}  // namespace relief::codec
