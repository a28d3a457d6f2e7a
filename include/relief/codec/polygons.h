#pragma once

#include <array>
#include <span>
#include <vector>

#include "relief/codec/ps_codec.h"
#include "relief/codec/quad_codec.h"
#include "relief/core/polygon_mesh.h"

/// Polygon meshes as what the codecs take and give.
namespace relief::codec {

/// Three quarters of the polygons or more are quads that are seen counter-clockwise from above:
/// heights over the plane, even if some have a flaw, which is then told by its name.
[[nodiscard]] bool is_over_plane(const PolygonMesh& mesh);

/// Errors: BadInput `not_a_quad` naming the polygon.
[[nodiscard]] Result<QuadMesh> quads_of(const PolygonMesh& mesh);
[[nodiscard]] PolygonMesh polygons_of(const QuadMesh& mesh);

/// The triangulation of a mesh of triangles over the plane, as seen from above. Errors: BadInput
/// `not_a_triangle` naming the polygon, and those of mesh::build with overlaps refused.
[[nodiscard]] Result<mesh::Triangulation> triangulation_of(const PolygonMesh& mesh);

/// The heights of a mesh of triangles over the plane. Errors: those of triangulation_of.
[[nodiscard]] Result<PsModel> model_of(const PolygonMesh& mesh);
/// Its vertices over the plane of its texture coordinates; vertices with several of them, at seams,
/// become several. Errors: and BadInput for faces without texture coordinates.
[[nodiscard]] Result<PsModel> model_over_uv(const PolygonMesh& mesh);

/// One component are heights over the plane, three a surface in space. Errors: Unsupported for two.
[[nodiscard]] Status check_in_space(int components);
/// Requires: one or three values.
[[nodiscard]] std::array<double, 3> in_space(Vec2 place, std::span<const double> values);

/// The tangent planes of all components at the vertices of a level, [component][vertex]. Values
/// that the file holds are exact. Errors: BadFile.
[[nodiscard]] Result<std::vector<multires::ps::TangentPlanes>> tangent_planes_of(
    const PsFile& file, const PsSurface& level);

/// The triangulation of a level with the heights of the spline; for three components the surface in
/// space with its parameters as "uv". Errors: those of check_in_space; BadFile.
[[nodiscard]] Result<PolygonMesh> polygons_of(const PsFile& file, const PsSurface& level);

}  // namespace relief::codec
