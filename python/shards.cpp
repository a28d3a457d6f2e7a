#include "files.h"
#include "relief/codec/raster_shards.h"
#include "relief/io/file.h"

/// Rasters encoded in parts: what relief.dask and relief.merge call.
namespace relief::python {

namespace {

using codec::RasterPlan;

py::bytes as_bytes(const Bytes& bytes) {
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

py::bytes plan_raster(const py::object& values, const ArrayAbout& about, const codec::Goal& goal,
                      const std::string& profile, const py::object& progress) {
    if (profile != "dense" && profile != "fast")
        raise_argument("profiles are dense and fast, not '" + profile + "'");
    const Source source(values, about);
    LongCall call(progress);
    codec::EncodeOptions options;
    options.goal = goal;
    options.profile = profile == "fast" ? codec::Profile::Fast : codec::Profile::Dense;
    options.progress = call.hook();
    MemorySink sink;
    call.run([&] { return located(codec::plan_raster(*source, options, sink), source.path()); });
    return as_bytes(sink.take());
}

std::shared_ptr<RasterPlan> open_plan(const py::object& file) {
    const auto source = byte_source(file);
    return std::make_shared<RasterPlan>(take(unlocked([&] { return RasterPlan::open(source); })));
}

py::tuple samples(const RasterPlan& plan, std::int64_t tile) {
    if (tile < 0 || tile >= plan.tile_rows() * plan.tile_cols())
        raise_argument("there is no tile " + std::to_string(tile));
    const LatticeBox box = plan.samples(tile);
    return py::make_tuple(box.row0, box.col0, box.rows, box.cols);
}

py::bytes encode_shard(const RasterPlan& plan, const py::object& values, const ArrayAbout& about,
                       const std::vector<std::int64_t>& tiles) {
    const Source source(values, about);
    MemorySink sink;
    LongCall call{py::none()};
    const Progress hook = call.hook();
    call.run([&] {
        return located(codec::encode_shard(plan, *source, tiles, hook, sink), source.path());
    });
    return as_bytes(sink.take());
}

py::object merge(const std::vector<py::object>& shards, const py::object& path) {
    std::vector<std::shared_ptr<const ByteSource>> sources;
    for (const py::object& shard : shards) sources.push_back(byte_source(shard));
    if (path.is_none()) {
        MemorySink sink;
        const auto report = unlocked([&] { return codec::merge_shards(sources, sink); });
        if (!report.ok()) raise(report.error());
        return open_any(std::make_shared<MemorySource>(sink.take()));
    }
    const std::string name = path_of(path);
    check(unlocked([&]() -> Status {
        RELIEF_TRY(io::OutputFile sink, io::OutputFile::create(name));
        if (const auto report = codec::merge_shards(sources, sink); !report.ok())
            return report.error();
        return sink.commit();
    }));
    return open_any(byte_source(path), {}, name);
}

}  // namespace

void define_shards(py::module_& module) {
    py::class_<RasterPlan, std::shared_ptr<RasterPlan>>(module, "RasterPlan")
        .def(py::init(&open_plan), py::arg("file"))
        .def_property_readonly("tile_rows", &RasterPlan::tile_rows)
        .def_property_readonly("tile_cols", &RasterPlan::tile_cols)
        .def_property_readonly("missing_tiles", &RasterPlan::missing_tiles)
        .def("samples", &samples, py::arg("tile"));
    module.def("plan_raster", &plan_raster, py::arg("values"), py::arg("about"), py::arg("goal"),
               py::arg("profile"), py::arg("progress"));
    module.def("encode_shard", &encode_shard, py::arg("plan"), py::arg("values"), py::arg("about"),
               py::arg("tiles"));
    module.def("merge", &merge, py::arg("shards"), py::arg("path"));
}

}  // namespace relief::python
