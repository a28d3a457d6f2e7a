#include "meshes.h"

#include <algorithm>

#include "files.h"
#include "relief/codec/mesh_codec.h"
#include "relief/codec/polygons.h"
#include "relief/codec/scan_codec.h"
#include "relief/io/mesh.h"
#include "relief/mesh/repair.h"

/// relief.Mesh, meshes from and to files, and .relief files of meshes.
namespace relief::python {

namespace {

using codec::Goal;
using codec::MeshFile;
using codec::QuadFile;
using py::literals::operator""_a;

/// How many corners all polygons have; 0: not the same.
std::int64_t sides_of(const PolygonMesh& mesh) {
    const std::int64_t count = mesh.polygon_count();
    if (count == 0) return 0;
    const std::int64_t sides = mesh.offsets[1];
    for (std::int64_t k = 0; k < count; ++k)
        if (static_cast<std::int64_t>(mesh.polygon(k).size()) != sides) return 0;
    return sides;
}

py::array vertices_of(const py::object& self) {
    auto& mesh = self.cast<PolygonMesh&>();
    constexpr py::ssize_t size = sizeof(double);
    return view_of(mesh.vertices.empty() ? nullptr : mesh.vertices[0].data(),
                   {static_cast<py::ssize_t>(mesh.vertices.size()), 3}, {3 * size, size}, self);
}

template <class T>
py::array read_only(const std::vector<T>& values, py::handle owner) {
    return view_of(values.data(), {static_cast<py::ssize_t>(values.size())}, {sizeof(T)}, owner);
}

py::object faces_of(const py::object& self) {
    const auto& mesh = self.cast<const PolygonMesh&>();
    const py::ssize_t sides = sides_of(mesh);
    constexpr py::ssize_t size = sizeof(std::int32_t);
    if (sides > 0)
        return view_of(mesh.corners.data(), {mesh.polygon_count(), sides}, {sides * size, size},
                       self);
    return py::make_tuple(read_only(mesh.corners, self), read_only(mesh.offsets, self));
}

py::dict attributes_of(const py::object& self) {
    const auto& mesh = self.cast<const PolygonMesh&>();
    py::dict attributes;
    for (const MeshAttribute& a : mesh.attributes) {
        constexpr py::ssize_t size = sizeof(double);
        const py::ssize_t components = a.components;
        const py::array values = view_of(a.values.data(), {a.element_count(), components},
                                         {components * size, size}, self);
        attributes[py::str(a.name)] = py::make_tuple(
            values, a.face_varying() ? py::object(read_only(a.corners, self)) : py::none());
    }
    return attributes;
}

std::string text_of(const PolygonMesh& mesh) {
    return "<relief.Mesh " + std::to_string(mesh.vertices.size()) + " vertices, " +
           std::to_string(mesh.polygon_count()) + " faces>";
}

std::shared_ptr<PolygonMesh> read_mesh(const py::object& path) {
    const std::string name = path_of(path);
    return std::make_shared<PolygonMesh>(take(unlocked([&] { return io::read_mesh(name); })).mesh);
}

std::vector<std::string> write_mesh(const py::object& path, const PolygonMesh& mesh, bool ascii) {
    const std::string name = path_of(path);
    const auto encoding = ascii ? io::PlyEncoding::Ascii : io::PlyEncoding::Binary;
    return take(unlocked([&] { return io::write_mesh(name, mesh, {encoding}); }));
}

py::dict mesh_report(const codec::MeshReport& reached) {
    py::dict report = rate_report(reached);
    report["scheme"] = multires::mesh_scheme_name(reached.scheme);
    report["levels"] = reached.levels;
    report["base_vertices"] = reached.base_vertices;
    report["base_faces"] = reached.base_faces;
    report["faces"] = reached.faces;
    report["lost_creases"] = reached.lost_creases;
    return report;
}

py::object encode_subdivision(const PolygonMesh& mesh, const py::object& path, const Goal& goal,
                              const std::string& scheme, int levels, const py::dict& options,
                              const py::object& progress) {
    LongCall call(progress);
    codec::MeshEncodeOptions encode;
    encode.goal = goal;
    encode.levels = levels;
    if (!scheme.empty()) encode.scheme = take(multires::mesh_scheme_from_name(scheme));
    encode.lift = take(multires::lift_from_name(options["lift"].cast<std::string>()));
    encode.alpha = options["alpha"].cast<std::optional<double>>();
    encode.keep_order = options["keep_order"].cast<bool>();
    if (options["surface"].cast<bool>()) encode.distance = codec::MeshDistance::Surface;
    const auto original = options["original"].cast<std::shared_ptr<PolygonMesh>>();
    if (original && encode.distance != codec::MeshDistance::Surface)
        raise_argument("distances from an original are those of surfaces: give surface=True");
    encode.original = original.get();
    encode.progress = call.hook();
    auto encoded = call.run([&] { return codec::encode_mesh(mesh, encode); });
    return py::cast(
        encoded_file<MeshFile>(std::move(encoded.bytes), mesh_report(encoded.report), path));
}

/// A remesh of what is no subdivision of anything.
py::object encode_scan(const PolygonMesh& mesh, const py::object& path, const Goal& goal,
                       const std::string& scheme, int levels, const py::dict& options,
                       const py::object& progress) {
    if (!scheme.empty() && scheme != "loop") raise_argument("remeshes have the scheme 'loop'");
    const int effort = options["effort"].cast<int>();
    if (effort < 0 || effort > 2) raise_argument("effort is 0, 1 or 2");
    LongCall call(progress);
    codec::ScanEncodeOptions encode{
        .goal = goal,
        .base_faces = options["base_faces"].cast<std::optional<std::int64_t>>(),
        .feature_degrees = options["features"].cast<std::optional<double>>(),
        .tolerance = options["tolerance"].cast<std::optional<double>>(),
        .effort = static_cast<codec::ScanEffort>(effort),
        .lift = take(multires::lift_from_name(options["lift"].cast<std::string>())),
        .remeshing = call.hook(),
        .encoding = call.hook()};
    if (levels >= 0) encode.levels = levels;
    auto made = call.run([&] { return codec::encode_scan(mesh, encode); });
    py::dict report = mesh_report(made.encoded.report);
    report["remesh"] = remesh_report(made.remeshed.report);
    return py::cast(encoded_file<MeshFile>(std::move(made.encoded.bytes), std::move(report), path));
}

py::object encode_quads(const PolygonMesh& mesh, const py::object& path, const Goal& goal,
                        int levels) {
    auto encoded = take(unlocked([&]() -> Result<codec::EncodedQuads> {
        RELIEF_TRY(const codec::QuadMesh quads, codec::quads_of(mesh));
        return codec::encode_quads(quads, {.goal = goal, .levels = levels});
    }));
    py::dict report = rate_report(encoded.report);
    report["scheme"] = "fvs";
    report["levels"] = encoded.report.levels;
    report["surface_bound"] = encoded.report.surface_bound;
    return py::cast(encoded_file<QuadFile>(std::move(encoded.bytes), std::move(report), path));
}

py::object encode_triangles(const PolygonMesh& mesh, const py::object& path, const Goal& goal,
                            bool over_uv, const py::object& progress) {
    LongCall call(progress);
    const Progress hook = call.hook();
    auto encoded = call.run([&]() -> Result<codec::EncodedPs> {
        RELIEF_TRY(const codec::PsModel model,
                   over_uv ? codec::model_over_uv(mesh) : codec::model_of(mesh));
        return codec::encode_ps(model, {.goal = goal, .progress = hook});
    });
    py::dict report = rate_report(encoded.report);
    report["scheme"] = "powell-sabin";
    report["levels"] = encoded.report.levels;
    report["surface_bound"] = encoded.report.surface_bound;
    return py::cast(encoded_file<codec::PsFile>(std::move(encoded.bytes), std::move(report), path));
}

/// As `relief encode` does with meshes.
py::object encode_mesh(const PolygonMesh& mesh, const py::object& path, const Goal& goal,
                       const std::string& scheme, int levels, const py::dict& options,
                       const py::object& progress) {
    if (options["remesh"].cast<bool>())
        return encode_scan(mesh, path, goal, scheme, levels, options, progress);
    if (scheme == "powell-sabin")
        return encode_triangles(mesh, path, goal, options["over_uv"].cast<bool>(), progress);
    const bool quads =
        scheme == "fvs" || (scheme.empty() && unlocked([&] { return codec::is_over_plane(mesh); }));
    if (quads) return encode_quads(mesh, path, goal, levels);
    return encode_subdivision(mesh, path, goal, scheme, levels, options, progress);
}

void define_mesh(py::module_& module) {
    py::class_<PolygonMesh, std::shared_ptr<PolygonMesh>>(
        module, "Mesh",
        "A polygon mesh in memory, with all that its file says: attributes, labels, creases.\n\n"
        "vertices: (n, 3). faces: (m, k) corners, or (indices, offsets) where polygon i has the "
        "corners indices[offsets[i]:offsets[i + 1]]. creases: (a, b, sharpness) of edges; corners: "
        "(vertex, sharpness); inf: sharp for ever. Errors: relief.Error naming the element.\n\n"
        ">>> import relief\n"
        ">>> relief.Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])\n"
        "<relief.Mesh 3 vertices, 1 faces>\n"
        ">>> relief.Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 3]])\n"
        "Traceback (most recent call last):\n"
        "relief.Error: polygon 0: index_out_of_range: a corner names a vertex that does not "
        "exist\n")
        .def(py::init([](const py::object& vertices, const py::object& faces,
                         const Creases& creases, const Corners& corners) {
                 return std::make_shared<PolygonMesh>(
                     polygons_from(vertices, faces, creases, corners));
             }),
             py::arg("vertices"), py::arg("faces"), py::arg("creases") = Creases(),
             py::arg("corners") = Corners())
        .def("__repr__", &text_of)
        .def_property_readonly("vertices", &vertices_of,
                               "(n, 3) float64 where they lie: writing moves them.")
        .def_property_readonly(
            "faces", &faces_of,
            "(m, k) int32 if all have k corners, else (indices, offsets); not copied, read-only.")
        .def_property_readonly("attributes", &attributes_of,
                               "By name (values (elements, components), corners): 'uv', 'colour', "
                               "'normal' and others; "
                               "corners: None if element v belongs to vertex v, else an element "
                               "for each corner of the "
                               "faces, or -1.")
        .def_property_readonly(
            "labels",
            [](const PolygonMesh& mesh) {
                py::dict labels;
                for (const FaceLabels& l : mesh.labels)
                    labels[py::str(l.keyword)] = py::make_tuple(
                        l.names, py::array_t<std::int32_t>(
                                     static_cast<py::ssize_t>(l.of_face.size()), l.of_face.data()));
                return labels;
            },
            "By keyword ('g', 'usemtl', ..) the names, and for each face the number of one or -1.")
        .def_property_readonly(
            "creases",
            [](const PolygonMesh& mesh) {
                Creases creases;
                for (const CreaseEdge& c : mesh.creases)
                    creases.emplace_back(c.a, c.b, c.sharpness);
                return creases;
            },
            "Sharp edges: (a, b, sharpness).")
        .def_property_readonly(
            "corners",
            [](const PolygonMesh& mesh) {
                Corners corners;
                for (const SharpVertex& s : mesh.sharp_vertices)
                    corners.emplace_back(s.vertex, s.sharpness);
                return corners;
            },
            "Sharp vertices: (vertex, sharpness).")
        .def(
            "repair",
            [](const PolygonMesh& mesh) {
                return std::make_shared<PolygonMesh>(
                    unlocked([&] { return mesh::repair(mesh); }).mesh);
            },
            "The mesh as an oriented manifold: docs/cli.md, 'relief info'.");
}

template <class File, class Decoded>
void define_mesh_file(py::module_& module, const char* name, const char* doc,
                      Decoded decode_level) {
    using Self = OpenFile<File>;
    py::class_<Self, std::shared_ptr<Self>> type(module, name, doc);
    define_file(type, [](const File& file) { return file.levels(); });
    if constexpr (requires(const File& file) { codec::plane_surface(file); })
        define_evaluation(type);
    type.def(
            "decode",
            [decode_level](const std::shared_ptr<Self>& self, int level,
                           std::optional<std::uint64_t> bytes) {
                check_level(*self, level, self->file.levels());
                const auto from = bytes ? open_source<File>(self->source, bytes, "") : self;
                return std::make_shared<PolygonMesh>(
                    take(unlocked([&] { return decode_level(from->file, level); })));
            },
            py::arg("level") = 0, py::arg("bytes") = py::none(),
            "The mesh of a level, with `bytes` from the first bytes of the file only.\n\n"
            "Errors: relief.Error for a level that does not exist, or damage.")
        .def("__repr__", [name](const Self& self) {
            return std::string("<relief.") + name + " " +
                   std::to_string(self.file.counts(0).vertices) + " vertices, " +
                   std::to_string(self.file.levels()) + " levels, " +
                   std::to_string(self.file.size()) + " bytes>";
        });
    if constexpr (requires(const File& file) { file.surface_bound(0); })
        type.def(
            "surface_bound",
            [](const Self& self, int level) {
                check_level(self, level, self.file.levels());
                return self.file.surface_bound(level);
            },
            py::arg("level") = 0,
            "Certified largest distance along z of the surface of `level` from the encoded one; "
            "None "
            "if edited.");
}

}  // namespace

FaceArrays::FaceArrays(const py::object& faces) {
    if (py::isinstance<py::tuple>(faces) && py::len(faces) == 2) {
        const py::tuple pair = faces;
        const auto ends = numbers_of<std::int64_t>(pair[1], "offsets");
        if (ends.ndim() != 1 || ends.size() < 1)
            raise_argument("offsets are a list of integers, one more than there are faces");
        offsets.assign(ends.data(), ends.data() + ends.size());
        take_corners(py::array::ensure(pair[0]));
        const bool ascending = std::is_sorted(offsets.begin(), offsets.end());
        if (!ascending || offsets.front() != 0 ||
            offsets.back() != static_cast<std::int64_t>(corners.size()))
            raise_argument("offsets must ascend from 0 to the number of indices");
        return;
    }
    const py::array array = py::array::ensure(faces);
    if (!array || array.ndim() != 2)
        raise_argument("faces are an array of shape (m, k), or (indices, offsets)");
    take_corners(array);
    for (py::ssize_t f = 1; f <= array.shape(0); ++f) offsets.push_back(f * array.shape(1));
}

void FaceArrays::take_corners(const py::array& array) {
    const char kind = array ? array.dtype().kind() : ' ';
    if (kind != 'i' && kind != 'u') raise_argument("corners of faces are integers");
    const bool here = array.itemsize() == 4 && (array.flags() & py::array::c_style) != 0 &&
                      array.dtype().attr("isnative").cast<bool>();
    if (here) {
        kept_ = array;
        corners = {static_cast<const mesh::Index*>(array.data()),
                   static_cast<std::size_t>(array.size())};
        return;
    }
    const auto wide = numbers_of<std::int64_t>(array, "corners of faces");
    converted_.reserve(static_cast<std::size_t>(wide.size()));
    for (py::ssize_t k = 0; k < wide.size(); ++k) {
        const std::int64_t corner = wide.data()[k];
        const bool fits = corner >= 0 && corner <= INT32_MAX;
        converted_.push_back(fits ? static_cast<mesh::Index>(corner) : mesh::kNone);
    }
    corners = converted_;
}

PolygonMesh polygons_from(const py::object& vertices, const py::object& faces,
                          const Creases& creases, const Corners& corners) {
    const auto places = numbers_of<double>(vertices, "vertices");
    const auto points = points_of<double>(places);
    FaceArrays arrays(faces);
    PolygonMesh mesh;
    for (const Vec3<double>& p : points) mesh.vertices.push_back({p.x, p.y, p.z});
    mesh.offsets = std::move(arrays.offsets);
    for (const mesh::Index corner : arrays.corners)
        mesh.corners.push_back(static_cast<std::int32_t>(corner));
    for (const auto& [a, b, sharpness] : creases) mesh.creases.push_back({a, b, sharpness});
    for (const auto& [vertex, sharpness] : corners)
        mesh.sharp_vertices.push_back({vertex, sharpness});
    check(unlocked([&] { return relief::check(mesh); }));
    return mesh;
}

void define_meshes(py::module_& module) {
    define_mesh(module);
    define_mesh_file<MeshFile>(module, "MeshFile",
                               "An open .relief file of a mesh with subdivision connectivity "
                               "(docs/reverse-subdivision.md).",
                               [](const MeshFile& file, int level) { return file.decode(level); });
    define_mesh_file<QuadFile>(
        module, "QuadFile",
        "An open .relief file of quads over the plane, whose surface is C1 (docs/fvs.md).",
        [](const QuadFile& file, int level) -> Result<PolygonMesh> {
            RELIEF_TRY(const codec::QuadMesh mesh, file.decode(level));
            return codec::polygons_of(mesh);
        });
    define_mesh_file<codec::PsFile>(
        module, "SplineFile",
        "An open .relief file of a Powell-Sabin spline: what relief.fit makes "
        "(docs/powell-sabin.md).",
        [](const codec::PsFile& file, int level) -> Result<PolygonMesh> {
            RELIEF_TRY(const codec::PsSurface surface, file.surface(level));
            return codec::polygons_of(file, surface);
        });
    module.def("read_mesh", &read_mesh, py::arg("path"));
    module.def("write_mesh", &write_mesh, py::arg("path"), py::arg("mesh"),
               py::arg("ascii") = false);
    module.def("encode_mesh", &encode_mesh, py::arg("mesh"), py::arg("path"), py::arg("goal"),
               py::arg("scheme"), py::arg("levels"), py::arg("options"), py::arg("progress"));
}

}  // namespace relief::python
