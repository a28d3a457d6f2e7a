#pragma once

#include "relief/core/polygon_mesh.h"
#include "relief/core/result.h"
#include "relief/core/stream.h"

/// Draco, as it compresses meshes of triangles: places of vertices only.
namespace relief::peers {

struct DracoOptions {
    int bits = 11;  ///< of each coordinate
    int speed = 0;  ///< 0 .. 10: the smallest files first
};

/// Polygons become the fans around their first corners. Draco gives vertices numbers of its own.
/// Errors: BadInput when it refuses.
[[nodiscard]] Result<Bytes> draco_encode(const PolygonMesh& mesh, const DracoOptions& options);

/// What such a file decodes to, with the vertices of `mesh` in their own order: a second file tells
/// which is which. Errors: BadInput when Draco refuses.
[[nodiscard]] Result<PolygonMesh> draco_decoded(const PolygonMesh& mesh,
                                                const DracoOptions& options);

[[nodiscard]] const char* draco_version();

}  // namespace relief::peers
