#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "relief/core/polygon_mesh.h"
#include "relief/core/result.h"
#include "relief/core/vec3.h"
#include "relief/mesh/topology.h"

/// A triangle mesh as a surface on which points lie and move. Source: mesh-codec-and-remesh.md
/// sections 3.1, 3.2 and 3.4.
namespace relief::remesh {

/// A point of a surface.
struct Place {
    mesh::Index face = 0;
    std::array<double, 3> weights{1, 0, 0};  ///< of its corners; none negative, their sum is 1

    friend bool operator==(const Place&, const Place&) = default;
};

/// What may happen to a vertex when the surface is simplified.
enum class VertexKind : std::uint8_t {
    Smooth,
    Curve,   ///< between two edges of a boundary or feature: it stays on that curve
    Corner,  ///< where such curves end, meet or turn: it stays
};

struct SurfaceOptions {
    /// Edges between faces whose normals differ by more are features; none: there are none.
    std::optional<double> feature_degrees = {};
    /// Curves that turn by more have a corner there.
    double corner_degrees = 60;
};

/// An oriented manifold of triangles in units of the diagonal of its box, from the lowest corner.
struct Surface {
    mesh::Topology mesh;
    std::vector<Vec3<double>> points;
    std::vector<Vec3<double>> face_normals;  ///< of length 1, or 0 for faces without area
    std::vector<Vec3<double>> normals;       ///< of vertices: means by area, of length 1 or 0
    std::vector<std::uint8_t> sharp;         ///< [half-edge]: 1 on boundaries and features
    std::vector<VertexKind> kinds;           ///< [vertex]

    /// Where the elements come from.
    std::vector<mesh::Index> vertex_sources;                  ///< [vertex]: a vertex
    std::vector<mesh::Index> face_sources;                    ///< [face]: a polygon
    std::vector<std::array<std::int64_t, 3>> corner_sources;  ///< [face]: places in `corners`
    Vec3<double> lowest;
    double diagonal = 1;

    [[nodiscard]] Vec3<double> point(const Place& place) const;
    /// The mean of the normals of the corners; not of length 1.
    [[nodiscard]] Vec3<double> normal(const Place& place) const;
    /// In the units of the mesh that this was made of.
    [[nodiscard]] Vec3<double> original(const Vec3<double>& p) const {
        return lowest + diagonal * p;
    }
};

/// The surface of a mesh; polygons become fans around their first corners, vertices that no polygon
/// uses are left out. Errors: those of relief::check; BadInput, naming the element, for what
/// mesh::diagnose finds and for `empty_mesh`, `no_area` and `too_large` (coordinates above 1e75).
/// Complexity: O(n log n).
[[nodiscard]] Result<Surface> surface_of(const PolygonMesh& mesh, const SurfaceOptions& options);

/// Sets which edges are features, and the kinds of vertices. Complexity: O(n).
void find_features(Surface& surface, const SurfaceOptions& options);

/// Where a point comes that moves straight ahead by a vector, of which the part along the face
/// counts: on the unfolded surface, along a boundary where it meets one. It stops after 400 faces,
/// and where faces have no area. Complexity: O(faces on the way).
[[nodiscard]] Place walk(const Surface& surface, const Place& from, const Vec3<double>& step);

}  // namespace relief::remesh
