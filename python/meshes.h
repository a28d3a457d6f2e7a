#pragma once

#include "convert.h"
#include "relief/core/polygon_mesh.h"
#include "relief/mesh/index.h"
#include "relief/remesh/remesh.h"

/// Meshes as arrays.
namespace relief::python {

/// Corners of faces from an array (m, k) of integers, or from (indices, offsets). int32 and uint32
/// are read where they are.
struct FaceArrays {
    explicit FaceArrays(const py::object& faces);

    std::vector<std::int64_t> offsets = {0};
    std::span<const mesh::Index> corners;

  private:
    void take_corners(const py::array& array);

    py::array kept_;
    std::vector<mesh::Index> converted_;
};

/// An array (n, 3) of places in T, where it lies if that is its type.
template <class T>
[[nodiscard]] std::span<const Vec3<T>> points_of(const Contiguous<T>& vertices) {
    if (vertices.ndim() != 2 || vertices.shape(1) != 3)
        raise_argument("vertices are an array of shape (n, 3)");
    return {reinterpret_cast<const Vec3<T>*>(vertices.data()),
            static_cast<std::size_t>(vertices.shape(0))};
}

/// (a, b, sharpness) and (vertex, sharpness); inf is sharp for ever.
using Creases = std::vector<std::tuple<std::int32_t, std::int32_t, double>>;
using Corners = std::vector<std::pair<std::int32_t, double>>;

/// A copy as a mesh that passes relief::check.
[[nodiscard]] PolygonMesh polygons_from(const py::object& vertices, const py::object& faces,
                                        const Creases& creases, const Corners& corners);

/// What a remesh reached.
[[nodiscard]] py::dict remesh_report(const remesh::RemeshReport& reached);

}  // namespace relief::python
