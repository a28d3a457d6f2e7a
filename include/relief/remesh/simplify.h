#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "relief/remesh/surface.h"

/// A base mesh for a surface, and a one-to-one map between both. Source: mesh-codec-and-remesh.md
/// sections 3.2 and 3.3.
namespace relief::remesh {

struct SimplifyOptions {
    mesh::Index faces = 300;  ///< where to stop
    /// How much the shape of triangles counts beside the distance from the surface.
    double shape = 1e-3;
    std::span<const mesh::Index> locked = {};  ///< vertices that stay
};

/// What half-edge collapses leave of a surface. Each collapse v -> w flattened the faces around v;
/// this is recorded, so that points of the base mesh find their places on the surface and no two
/// the same one. Source of the idea: A. W. F. Lee and others, MAPS, SIGGRAPH 1998.
class Simplification {
  public:
    /// Collapses in the order of how far the surface around moves, with corners and locked vertices
    /// staying and curves collapsing along themselves. It stops above `faces` where no collapse is
    /// allowed: each component keeps its topology. The surface must outlive this. Complexity:
    /// O(n log n).
    Simplification(const Surface& surface, const SimplifyOptions& options);

    /// Of the base; its vertices are those of the surface that stayed.
    [[nodiscard]] const mesh::FaceList& faces() const { return base_; }
    [[nodiscard]] const std::vector<mesh::Index>& vertices() const { return base_vertices_; }
    /// [corner of faces()]: 1 for sides on boundaries and features.
    [[nodiscard]] const std::vector<std::uint8_t>& sharp() const { return base_sharp_; }

    /// From places on the base to those on the surface. Complexity: O(places log(reduction)).
    void to_surface(std::span<Place> places) const;

  private:
    class Collapser;
    struct Planar {
        double x = 0;
        double y = 0;
    };
    /// The faces around v before v went to the ring's vertex `target`; v is at the origin.
    struct Record {
        mesh::Index first_spoke = 0;  ///< of spokes_: half-edges that began at v, counter-clockwise
        mesh::Index first_ring = 0;   ///< of ring_: where their ends are in the plane
        mesh::Index spokes = 0;
        mesh::Index ring = 0;  ///< as many as spokes, or one more on the boundary
        mesh::Index target = 0;

        /// Whether the face at a spoke went with the collapse.
        [[nodiscard]] bool gone(mesh::Index spoke) const {
            return spoke == target || (spoke + 1) % ring == target;
        }
    };
    static Place placed(const Record& record, std::span<const mesh::Index> spokes,
                        std::span<const Planar> ring, const Planar& p);

    std::vector<Record> records_;
    std::vector<mesh::Index> spokes_;
    std::vector<Planar> ring_;
    std::size_t face_count_ = 0;         ///< of the surface
    std::vector<mesh::Index> face_ids_;  ///< of the base's faces, among those of the surface
    mesh::FaceList base_;
    std::vector<mesh::Index> base_vertices_;
    std::vector<std::uint8_t> base_sharp_;
};

}  // namespace relief::remesh
