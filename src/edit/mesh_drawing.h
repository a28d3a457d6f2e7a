#pragma once

#include <span>

#include "edit/mesh_levels.h"
#include "relief/edit/geometry.h"

namespace relief::edit {

/// A mesh as the editor draws it. Page coordinates are relative to `origin`.
struct MeshDrawing {
    const mesh::Topology& mesh;
    const VertexFaces& around;
    const MeshPoints& points;
    const MeshPoints* original = nullptr;    ///< null: errors are not known
    std::span<const mesh::Index> numbers{};  ///< what vertices are called; empty: as they are
    Vec3<double> origin{};

    [[nodiscard]] mesh::Index number(mesh::Index v) const {
        return numbers.empty() ? v : numbers[v];
    }
    [[nodiscard]] Point position(mesh::Index v) const;
    /// Of all vertices. uv: [number], may be empty. Complexity: O(n).
    [[nodiscard]] SurfaceGeometry surface(const Extras& extras) const;
    /// Of some vertices, and those in the faces around them. Complexity: O(n / 8 bytes), and what
    /// is drawn.
    [[nodiscard]] SurfacePatch patch(const std::vector<mesh::Index>& moved,
                                     const Extras& extras) const;
    /// All vertices and edges.
    [[nodiscard]] NetGeometry net() const;

  private:
    [[nodiscard]] Vec3<double> normal(mesh::Index v) const;
    [[nodiscard]] float error(mesh::Index v, const Vec3<double>& normal) const;
    /// Into place `at` of the arrays that are there.
    template <class Geometry>
    void draw(mesh::Index v, std::size_t at, Geometry& out) const;
};

}  // namespace relief::edit
