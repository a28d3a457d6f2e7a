#include "meshes.h"
#include "relief/remesh/remesh.h"

/// Remeshing.
namespace relief::python {

py::dict remesh_report(const remesh::RemeshReport& reached) {
    py::dict report;
    report["base_faces"] = reached.base_faces;
    report["levels"] = reached.levels;
    report["rms_error"] = reached.rms_error;
    report["max_error"] = reached.max_error;
    report["worst"] = reached.worst;
    report["flips"] = reached.flips;
    report["quality"] = reached.quality;
    report["diagonal"] = reached.diagonal;
    report["attempts"] = reached.attempts;
    return report;
}

namespace {

py::tuple remesh_mesh(const PolygonMesh& mesh, std::optional<std::int64_t> base_faces,
                      std::optional<int> levels, std::optional<double> features, double tolerance,
                      const py::object& progress) {
    LongCall call(progress);
    const remesh::RemeshOptions options{.base_faces = base_faces,
                                        .levels = levels,
                                        .feature_degrees = features,
                                        .tolerance = tolerance,
                                        .progress = call.hook()};
    auto remeshed = call.run([&] { return remesh::remesh(mesh, options); });
    const py::dict report = remesh_report(remeshed.report);
    return py::make_tuple(std::make_shared<PolygonMesh>(std::move(remeshed.mesh)), report);
}

}  // namespace

void define_remeshing(py::module_& module) {
    module.def("remesh", &remesh_mesh, py::arg("mesh"), py::arg("base_faces"), py::arg("levels"),
               py::arg("features"), py::arg("tolerance"), py::arg("progress"));
}

}  // namespace relief::python
