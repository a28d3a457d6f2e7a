#include "multires/fvs_functionals.h"

#include <cmath>

namespace relief::multires::fvs_mesh {

using mesh::Index;
using mesh::Quadrangulation;

namespace {

constexpr double kLargestData = 1e150;

}  // namespace

Status check(const Quadrangulation& mesh, const NodalData& data) {
    if (!fits(mesh, data))
        return bad_data("size_mismatch: a spline on this mesh has " +
                        std::to_string(mesh.vertex_count()) + " values and gradients and " +
                        std::to_string(mesh.edge_count()) + " normal derivatives; pass that many");
    const char* const names[] = {"value of vertex ", "gradient of vertex ", "gradient of vertex ",
                                 "normal derivative of edge "};
    std::string bad;
    int array = 0;
    for_each_nodal(
        [&](const std::vector<double>& numbers) {
            for (std::size_t k = 0; bad.empty() && k < numbers.size(); ++k)
                if (!(std::abs(numbers[k]) <= kLargestData)) bad = names[array] + std::to_string(k);
            ++array;
        },
        data);
    if (bad.empty()) return {};
    return bad_data("non_finite_data: it is not finite or beyond 1e150; fill or remove holes first",
                    bad);
}

spline::FvsData quad_data(const Quadrangulation& mesh, const NodalData& data, Index q) {
    spline::FvsData local;
    for (int i = 0; i < 4; ++i) {
        const Index v = mesh.quads[q][i];
        local.value[i] = data.value[v];
        local.gradient[i] = {data.dx[v], data.dy[v]};
        local.normal[i] = mesh.quad_signs[q][i] * data.normal[mesh.quad_edges[q][i]];
    }
    return local;
}

QuadFunctionals quad_functionals(const Quadrangulation& mesh, Index q) {
    QuadFunctionals f;
    f.sign.fill(1);
    const std::size_t normals = 3 * std::size_t{mesh.vertex_count()};
    for (int i = 0; i < 4; ++i) {
        for (int k = 0; k < 3; ++k) f.id[3 * i + k] = 3 * std::size_t{mesh.quads[q][i]} + k;
        f.id[12 + i] = normals + mesh.quad_edges[q][i];
        f.sign[12 + i] = mesh.quad_signs[q][i];
    }
    return f;
}

std::vector<double> flat(const NodalData& data) {
    std::vector<double> list;
    list.reserve(3 * data.value.size() + data.normal.size());
    for (std::size_t v = 0; v < data.value.size(); ++v)
        list.insert(list.end(), {data.value[v], data.dx[v], data.dy[v]});
    list.insert(list.end(), data.normal.begin(), data.normal.end());
    return list;
}

NodalData nodal(const Quadrangulation& mesh, const std::vector<double>& flat) {
    NodalData data = make_nodal<double>(mesh);
    for (std::size_t v = 0; v < data.value.size(); ++v) {
        data.value[v] = flat[3 * v];
        data.dx[v] = flat[3 * v + 1];
        data.dy[v] = flat[3 * v + 2];
    }
    std::copy(flat.begin() + static_cast<std::ptrdiff_t>(3 * data.value.size()), flat.end(),
              data.normal.begin());
    return data;
}

Details<double> detail_units(const Quadrangulation& parent, const Quadrangulation& child,
                             double factor) {
    Details<double> units = make_details<double>(parent);
    units.edge_value.assign(units.edge_value.size(), 1.0);
    units.centre_value.assign(units.centre_value.size(), 1.0);
    for (Index e = 0; e < parent.edge_count(); ++e)
        units.edge_tangential[e] = factor / (0.5 * length(parent.edge_vector(e)));
    for (Index q = 0; q < parent.quad_count(); ++q) {
        const double h = 0.5 * std::sqrt(0.5 * doubled_area(parent.corners(q)));
        units.centre_dx[q] = units.centre_dy[q] = factor / h;
    }
    for (Index e = 0; e < child.edge_count(); ++e)
        units.normal[e] = factor / length(child.edge_vector(e));
    return units;
}

Nodal<double> nodal_units(const Quadrangulation& mesh, double factor) {
    Nodal<double> units = make_nodal<double>(mesh);
    std::vector<double> total(mesh.vertex_count());
    std::vector<double> edges(mesh.vertex_count());
    for (Index e = 0; e < mesh.edge_count(); ++e) {
        const double h = length(mesh.edge_vector(e));
        units.normal[e] = factor / h;
        for (const Index v : mesh.edges[e]) {
            total[v] += h;
            edges[v] += 1;
        }
    }
    for (Index v = 0; v < mesh.vertex_count(); ++v) {
        units.value[v] = 1;
        units.dx[v] = units.dy[v] = factor / (total[v] / edges[v]);
    }
    return units;
}

}  // namespace relief::multires::fvs_mesh
