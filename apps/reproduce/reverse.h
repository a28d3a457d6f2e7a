#pragma once

#include <vector>

#include "relief/core/polygon_mesh.h"
#include "relief/multires/mesh_hierarchy.h"
#include "reproduce.h"

/// What the experiments on reverse subdivision share.
namespace relief::reproduce::reverse {

using Points = std::vector<Vec3<double>>;

void add_fractions(Rows& rows);

/// A polyhedron of triangles.
struct Polyhedron {
    mesh::FaceList faces;
    Points points;
};
/// Of 2 size^2 quads, cut: all its vertices are regular.
[[nodiscard]] Polyhedron torus(int size);
/// The same with edges flipped here and there, so that valences go from 3 to 9.
[[nodiscard]] Polyhedron irregular_torus(int size);
/// A torus on which two edges are flipped towards a vertex, and which vertex that is.
[[nodiscard]] std::pair<Polyhedron, mesh::Index> torus_with_valence_eight(int size);

/// A mesh with its coarser ones.
struct Model {
    multires::MeshHierarchy hierarchy;
    Points points;  ///< of the finest

    [[nodiscard]] int steps() const { return hierarchy.steps(); }
};
/// The polyhedron, subdivided. alpha: of sqrt(3).
[[nodiscard]] Model subdivided(const Polyhedron& base, multires::MeshScheme scheme, int steps,
                               std::optional<double> alpha = {});
/// Vertices on the torus with radii 3 and 1.
void put_on_torus(Points& points);
/// Every vertex along the normal, by bumps of several lengths and a ridge.
void add_bumps(Model& model);
/// Every coordinate by numbers of mean square `size`^2.
void add_noise(Points& points, double size, unsigned seed);

/// Takes `points` down by `levels` of the model's steps; the first ones are the coarse vertices.
[[nodiscard]] Points reversed(const Model& model, const multires::MeshTransform& transform,
                              int levels, Points points);
[[nodiscard]] Points reversed(const Model& model, multires::LiftKind lift, int levels);

/// |g - P c| of the finest step, if c is the reversal of g.
[[nodiscard]] double residual(const Model& model, const multires::MeshTransform& transform);
[[nodiscard]] double root_mean_square(const Points& points);

[[nodiscard]] PolygonMesh mesh_at(const Model& model, int levels, const Points& points);

}  // namespace relief::reproduce::reverse
