#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "relief/core/polygon_mesh.h"
#include "relief/core/raster.h"
#include "relief/core/result.h"

/// Any triangle mesh as a mesh with subdivision connectivity, which the codec and the editor of
/// meshes take. Source: mesh-codec-and-remesh.md sections 3 to 8; docs/remeshing.md.
namespace relief::remesh {

/// A mesh of fewer vertices gains little: its facets are details.
inline constexpr std::int64_t kFewVertices = 5000;

struct RemeshOptions {
    /// Of the base mesh, about: more where corners and features ask for them, or if the tolerance
    /// is not met otherwise. None: such that the result has as many faces as the mesh.
    std::optional<std::int64_t> base_faces = {};
    /// Of subdivision. None: such that the base has 250 to 1000 faces, if the mesh has so many.
    std::optional<int> levels = {};
    /// Edges whose faces turn by more are kept as creases; boundaries and creases of the mesh that
    /// are sharp for ever are kept anyway.
    std::optional<double> feature_degrees = {};
    /// The largest distance of the surfaces, both ways, as a fraction of the diagonal.
    double tolerance = 2e-3;
    Progress progress = {};
};

/// What was reached. Lengths are in the units of the mesh.
struct RemeshReport {
    std::int64_t vertices = 0;  ///< of the mesh that was given
    std::int64_t base_faces = 0;
    int levels = 0;
    double diagonal = 0;   ///< of the box of the mesh
    double rms_error = 0;  ///< of the distance between the surfaces, over their areas: the larger
                           ///< of both ways
    double max_error = 0;  ///< the largest distance, both ways, at vertices and samples
    std::array<double, 3> worst{};  ///< where it is
    std::int64_t flips = 0;  ///< faces whose normal opposes that of the mesh where they lie: none
    double quality = 0;      ///< mean over faces: 1 equilateral, 0 flat
    std::int64_t attempts = 0;  ///< bases that were tried
};

struct Remeshed {
    /// With the numbers of Loop subdivision: the vertices of level k come before those that level
    /// k - 1 adds. Sharp edges and corners are creases that are sharp for ever. Attributes are
    /// those of the mesh where the vertices lie.
    PolygonMesh mesh;
    PolygonMesh base;  ///< its coarsest mesh, whose vertices are the first ones of `mesh`
    int levels = 0;
    RemeshReport report;
};

/// Simplifies the mesh to a base with a one-to-one map, spreads the vertices of its subdivisions
/// over the surface as distance, curvature and the codec's transform want them, and takes finer
/// bases where the tolerance is not met. The same for any number of threads.
///
/// Errors: those of surface_of; InvalidArgument for options out of range: base faces from 1 and
/// levels from 0 on, degrees and a tolerance above 0; BadInput `too_many_elements` for more than
/// 2^31 half-edges, `tolerance_not_met` with the place and the distance, `flipped_faces` with a
/// place; Cancelled. Complexity: O(n log n) time for each of at most 4 bases; about 600 bytes a
/// face of the mesh and 700 of the result.
[[nodiscard]] Result<Remeshed> remesh(const PolygonMesh& mesh, const RemeshOptions& options);

}  // namespace relief::remesh
