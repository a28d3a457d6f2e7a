#include <algorithm>

#include "meshes.h"
#include "relief/multires/mesh_pyramid.h"
#include "relief/multires/polygon_subdivision.h"
#include "relief/multires/subdivider.h"

/// Subdivision of meshes, and its reversal.
namespace relief::python {

namespace {

using mesh::Index;
using multires::MeshPyramid;
using multires::MeshSpec;

MeshSpec spec_of(const std::string& scheme, std::optional<double> alpha) {
    return {.scheme = take(multires::mesh_scheme_from_name(scheme)), .alpha = alpha};
}

/// Corners of faces with so many sides, as (m, sides) int32.
py::array_t<std::int32_t> face_array(std::uint64_t faces, int sides) {
    return py::array_t<std::int32_t>(
        {static_cast<py::ssize_t>(faces), static_cast<py::ssize_t>(sides)});
}

/// Faces and points go into the arrays that are returned.
template <class T>
py::tuple subdivide_as(const Contiguous<T>& vertices, const FaceArrays& faces, const MeshSpec& spec,
                       int steps) {
    const auto points = points_of<T>(vertices);
    multires::Subdivider subdivider;
    const mesh::Topology base = take(unlocked([&]() -> Result<mesh::Topology> {
        RELIEF_TRY(mesh::Topology built,
                   mesh::build(faces.offsets, faces.corners, static_cast<Index>(points.size())));
        return built;
    }));
    check(unlocked([&] { return subdivider.prepare(base, {}, spec, steps); }));
    const mesh::MeshCounts counts = subdivider.counts();
    auto corners = face_array(counts.faces, subdivider.sides());
    py::array_t<T> fine({static_cast<py::ssize_t>(counts.vertices), py::ssize_t{3}});
    const std::span<Index> into{reinterpret_cast<Index*>(corners.mutable_data()),
                                static_cast<std::size_t>(corners.size())};
    const std::span<Vec3<T>> places{reinterpret_cast<Vec3<T>*>(fine.mutable_data()),
                                    static_cast<std::size_t>(counts.vertices)};
    unlocked([&] {
        subdivider.faces(into);
        subdivider.points<T>(points, places);
    });
    return py::make_tuple(fine, corners);
}

py::tuple subdivide_arrays(const py::object& vertices, const py::object& faces,
                           const std::string& scheme, int steps, std::optional<double> alpha) {
    const FaceArrays arrays(faces);
    const MeshSpec spec = spec_of(scheme, alpha);
    if (py::isinstance<py::array_t<float>>(vertices))
        return subdivide_as<float>(Contiguous<float>::ensure(vertices), arrays, spec, steps);
    const auto places = numbers_of<double>(vertices, "vertices");
    return subdivide_as<double>(places, arrays, spec, steps);
}

std::shared_ptr<PolygonMesh> subdivide_mesh(const PolygonMesh& mesh, const std::string& scheme,
                                            int steps, std::optional<double> alpha, bool limit,
                                            bool boundary_corners) {
    if (steps < 0) raise_argument("levels must not be negative");
    const MeshSpec spec = spec_of(scheme, alpha);
    return std::make_shared<PolygonMesh>(take(unlocked([&] {
        return multires::subdivide(mesh, spec, {steps, limit, boundary_corners});
    })));
}

std::shared_ptr<MeshPyramid> reverse(const py::object& vertices, const py::object& faces,
                                     const std::string& scheme, int levels, const std::string& lift,
                                     bool boundary_corners, double omega) {
    const auto places = numbers_of<double>(vertices, "vertices");
    const auto points = points_of<double>(places);
    const FaceArrays arrays(faces);
    const multires::MeshScheme kind = take(multires::mesh_scheme_from_name(scheme));
    const multires::MeshTransform transform{.lift = take(multires::lift_from_name(lift)),
                                            .omega = omega};
    constexpr int most = 30;
    return std::make_shared<MeshPyramid>(take(unlocked([&]() -> Result<MeshPyramid> {
        RELIEF_TRY(const mesh::Topology mesh,
                   mesh::build(arrays.offsets, arrays.corners, static_cast<Index>(points.size())));
        multires::MeshTags tags;
        if (boundary_corners) multires::tag_boundary_corners(mesh, tags);
        return MeshPyramid::analyse(mesh, points, tags, kind, levels < 0 ? most : levels,
                                    transform);
    })));
}

void check_level(const MeshPyramid& pyramid, int level) {
    if (level < 0 || level > pyramid.levels())
        raise_argument("there is no level " + std::to_string(level) +
                       "; levels are 0 (finest) to " + std::to_string(pyramid.levels()));
}

py::list bands(const py::object& self) {
    auto& pyramid = self.cast<MeshPyramid&>();
    constexpr py::ssize_t size = sizeof(double);
    py::list list;
    for (int level = pyramid.levels(); level >= 0; --level) {
        const auto band = pyramid.band(level);
        list.append(view_of(&band.data()->x, {static_cast<py::ssize_t>(band.size()), 3},
                            {3 * size, size}, self));
    }
    return list;
}

py::object faces_of(const py::object& self, int level) {
    const auto& pyramid = self.cast<const MeshPyramid&>();
    check_level(pyramid, level);
    const mesh::Topology& mesh = pyramid.topology(level);
    constexpr py::ssize_t size = sizeof(Index);
    const auto view = [&](const Buffer<Index>& buffer) {
        return view_of(buffer.data(), {static_cast<py::ssize_t>(buffer.size())}, {size}, self)
            .attr("view")("int32");
    };
    if (mesh.sides == 0) return py::make_tuple(view(mesh.origin), view(mesh.first));
    return view(mesh.origin).attr("reshape")(-1, mesh.sides);
}

}  // namespace

void define_subdivision(py::module_& module) {
    py::class_<MeshPyramid, std::shared_ptr<MeshPyramid>>(
        module, "MeshPyramid",
        "A mesh as its coarsest mesh and details: what relief.reverse makes "
        "(docs/reverse-subdivision.md).")
        .def("__repr__",
             [](const MeshPyramid& self) {
                 return std::string("<relief.MeshPyramid ") +
                        multires::mesh_scheme_name(self.hierarchy().spec().scheme) + ", " +
                        std::to_string(self.levels()) + " levels over " +
                        std::to_string(self.topology(self.levels()).vertex_count) + " vertices>";
             })
        .def_property_readonly("levels", &MeshPyramid::levels, "The coarsest level; 0 is the mesh.")
        .def_property_readonly(
            "scheme",
            [](const MeshPyramid& self) {
                return multires::mesh_scheme_name(self.hierarchy().spec().scheme);
            },
            "'loop', 'sqrt3' or 'catmull-clark'.")
        .def_property_readonly(
            "bands", &bands,
            "(n, 3) each, where they lie: places of the coarsest vertices, then the details of "
            "level "
            "levels - 1, .., 0: one for each vertex that the level adds. Writing changes the mesh.")
        .def_property_readonly(
            "numbers",
            [](const py::object& self) {
                const auto& numbers = self.cast<const MeshPyramid&>().numbers();
                return view_of(numbers.data(), {static_cast<py::ssize_t>(numbers.size())},
                               {sizeof(Index)}, self)
                    .attr("view")("int32");
            },
            "For each vertex of level 0 its number in the mesh that was reversed.")
        .def("faces", &faces_of, py::arg("level") = 0,
             "(m, k) int32, or (indices, offsets) of polygons, of a level.")
        .def(
            "synthesise",
            [](const MeshPyramid& self, int level) {
                check_level(self, level);
                return owned_rows<double>(unlocked([&] { return self.synthesise(level); }));
            },
            py::arg("level") = 0,
            "(n, 3): the vertices of a level; those of a coarser level are the first ones.");

    module.def("subdivide_arrays", &subdivide_arrays, py::arg("vertices"), py::arg("faces"),
               py::arg("scheme"), py::arg("levels"), py::arg("alpha"));
    module.def("subdivide_mesh", &subdivide_mesh, py::arg("mesh"), py::arg("scheme"),
               py::arg("levels"), py::arg("alpha"), py::arg("limit"), py::arg("boundary_corners"));
    module.def("reverse", &reverse, py::arg("vertices"), py::arg("faces"), py::arg("scheme"),
               py::arg("levels"), py::arg("lift"), py::arg("boundary_corners"), py::arg("omega"));
}

}  // namespace relief::python
