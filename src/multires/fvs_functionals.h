#pragma once

#include <array>
#include <string>
#include <vector>

#include "relief/multires/fvs_mesh.h"

/// The numbers of a level as one list, and what the files of scheme `fvs` on meshes share.
namespace relief::multires::fvs_mesh {

/// "name: what to do" at an element.
[[nodiscard]] inline Error bad_data(std::string message, std::string where = "") {
    return {ErrorCode::BadInput, std::move(message), std::move(where)};
}
[[nodiscard]] inline Error bad_level(int level, int levels) {
    return {ErrorCode::InvalidArgument,
            "level_out_of_range: this hierarchy has levels 0 to " + std::to_string(levels),
            "level " + std::to_string(level)};
}

/// fn(array of each set) for each of the arrays.
template <class Fn, class... Sets>
void for_each_nodal(Fn&& fn, Sets&... sets) {
    fn(sets.value...);
    fn(sets.dx...);
    fn(sets.dy...);
    fn(sets.normal...);
}
template <class Fn, class... Sets>
void for_each_detail(Fn&& fn, Sets&... sets) {
    fn(sets.edge_value...);
    fn(sets.edge_tangential...);
    fn(sets.centre_value...);
    fn(sets.centre_dx...);
    fn(sets.centre_dy...);
    fn(sets.normal...);
}

template <class T>
[[nodiscard]] Nodal<T> make_nodal(const mesh::Quadrangulation& mesh) {
    const std::vector<T> vertices(mesh.vertex_count());
    return {vertices, vertices, vertices, std::vector<T>(mesh.edge_count())};
}
template <class T>
[[nodiscard]] Details<T> make_details(const mesh::Quadrangulation& parent) {
    const std::vector<T> edges(parent.edge_count());
    const std::vector<T> quads(parent.quad_count());
    return {edges, edges, quads, quads, quads, std::vector<T>(2 * edges.size() + 4 * quads.size())};
}

/// Whether the arrays have the sizes of the mesh.
template <class T>
[[nodiscard]] bool fits(const mesh::Quadrangulation& mesh, const Nodal<T>& data) {
    const std::size_t vertices = mesh.vertex_count();
    return data.value.size() == vertices && data.dx.size() == vertices &&
           data.dy.size() == vertices && data.normal.size() == mesh.edge_count();
}
template <class T>
[[nodiscard]] bool fits(const mesh::Quadrangulation& parent, const Details<T>& details) {
    const std::size_t edges = parent.edge_count();
    const std::size_t quads = parent.quad_count();
    return details.edge_value.size() == edges && details.edge_tangential.size() == edges &&
           details.centre_value.size() == quads && details.centre_dx.size() == quads &&
           details.centre_dy.size() == quads && details.normal.size() == 2 * edges + 4 * quads;
}

/// `level_out_of_range` or `size_mismatch` for base and details[0 .. level - 1].
template <class T>
[[nodiscard]] Status check_sizes(const Hierarchy& hierarchy, const Nodal<T>& base,
                                 const std::vector<Details<T>>& details, int level) {
    if (level < 0 || level > hierarchy.levels()) return bad_level(level, hierarchy.levels());
    bool good = fits(hierarchy.mesh(0), base) && details.size() >= static_cast<std::size_t>(level);
    for (int m = 0; good && m < level; ++m) good = fits(hierarchy.mesh(m), details[m]);
    if (good) return {};
    return bad_data(
        "size_mismatch: the coefficients are not those of this hierarchy; decompose "
        "and reconstruct with the same mesh and levels");
}

/// The 16 numbers of a quad, the normals turned inward.
[[nodiscard]] spline::FvsData quad_data(const mesh::Quadrangulation& mesh, const NodalData& data,
                                        mesh::Index q);

/// The numbers of a level in one list: value, dx, dy of vertex v at 3v .. 3v + 2, then the normal
/// of edge e at 3V + e. Signs are those with which a quad sees the numbers.
struct QuadFunctionals {
    std::array<std::size_t, 16> id;
    std::array<double, 16> sign;
};
[[nodiscard]] QuadFunctionals quad_functionals(const mesh::Quadrangulation& mesh, mesh::Index q);
[[nodiscard]] std::vector<double> flat(const NodalData& data);
[[nodiscard]] NodalData nodal(const mesh::Quadrangulation& mesh, const std::vector<double>& flat);

/// 1 for values and factor / h for derivatives, h as in `Convention`.
[[nodiscard]] Details<double> detail_units(const mesh::Quadrangulation& parent,
                                           const mesh::Quadrangulation& child, double factor);
/// The same for a whole level: h is the length of the edge, or the mean length of a vertex's edges.
[[nodiscard]] Nodal<double> nodal_units(const mesh::Quadrangulation& mesh, double factor);

/// The functionals of a refined level that its parent has not, of `fine` minus `predicted`.
[[nodiscard]] Details<double> extract(const mesh::Quadrangulation& parent, const NodalData& fine,
                                      const NodalData& predicted);
/// Adds details to a predicted level.
void insert(const mesh::Quadrangulation& parent, const Details<double>& details, NodalData& fine);

}  // namespace relief::multires::fvs_mesh
