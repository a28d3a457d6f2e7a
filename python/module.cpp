#include "convert.h"
#include "relief/core/parallel.h"

/// The compiled part of the Python package: what `import relief` brings.
PYBIND11_MODULE(_relief, module) {
    using namespace relief::python;
    module.doc() = "Multiresolution spline surfaces: the compiled part of the package relief.";
    module.attr("__version__") = RELIEF_VERSION;
    define_error(module);
    define_rasters(module);
    define_files(module);
    define_pyramids(module);
    define_meshes(module);
    define_subdivision(module);
    define_scattered(module);
    define_edit(module);
    define_shards(module);
    define_remeshing(module);
    module.def("set_thread_count", &relief::set_thread_count, py::arg("threads"),
               "How many threads the library uses from now on; 0: as many as there are cores.\n\n"
               "Results do not depend on it.");
    module.def("thread_count", &relief::thread_count, "How many threads the library uses.");
}
