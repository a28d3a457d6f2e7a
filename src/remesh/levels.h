#pragma once

#include <vector>

#include "relief/multires/mesh_hierarchy.h"
#include "relief/remesh/simplify.h"
#include "remesh/moving_mesh.h"

namespace relief::remesh {

/// A base mesh on a surface, how it is subdivided, and where vertices on its curves lie.
class Levels {
  public:
    /// Errors: those of MeshHierarchy::create.
    [[nodiscard]] static Result<Levels> create(const Surface& surface, Simplification base,
                                               int steps);

    [[nodiscard]] const multires::MeshHierarchy& hierarchy() const { return hierarchy_; }
    [[nodiscard]] const Simplification& base() const { return base_; }

    /// The mesh of a depth, its vertices where they are on the base, but those on curves at equal
    /// distances between those of the base.
    [[nodiscard]] MovingMesh mapped(int depth) const;
    /// The mesh of the next depth: new vertices near the middles of edges.
    [[nodiscard]] MovingMesh refined(const MovingMesh& coarse, int depth) const;

  private:
    /// The half-edges of the surface between two vertices of the base, along a side of it.
    struct Chain {
        mesh::Index side = 0;
        std::vector<mesh::Index> half_edges;
        std::vector<double> until;  ///< the length up to the end of each
    };

    Levels(const Surface& surface, Simplification base, multires::MeshHierarchy hierarchy);
    void find_chains();
    [[nodiscard]] Place on_chain(const Chain& chain, double share) const;
    void put_curves(MovingMesh& mesh, int depth) const;

    const Surface* surface_;
    Simplification base_;
    multires::MeshHierarchy hierarchy_;
    std::vector<Chain> chains_;
};

}  // namespace relief::remesh
