#include "files.h"

#include <algorithm>

#include "relief/codec/container.h"
#include "relief/codec/measure.h"
#include "relief/codec/mesh_codec.h"
#include "relief/io/file.h"

/// .relief files: of any kind, and of rasters.
namespace relief::python {

namespace {

using codec::Goal;
using codec::RasterFile;
using OpenRaster = OpenFile<RasterFile>;
using py::literals::operator""_a;

std::vector<py::ssize_t> leading_shape(const py::array& places, int components) {
    std::vector<py::ssize_t> shape(places.shape(), places.shape() + places.ndim() - 1);
    if (components > 1) shape.push_back(components);
    return shape;
}

/// Strides of elements of `size` bytes one after another, in shape `shape`.
std::vector<py::ssize_t> dense_strides(const std::vector<py::ssize_t>& shape, py::ssize_t size) {
    std::vector<py::ssize_t> strides(shape.size());
    for (std::size_t k = shape.size(); k-- > 0; size *= shape[k]) strides[k] = size;
    return strides;
}

struct RasterEncoding {
    codec::EncodeOptions options;
    std::string path;  ///< empty: to memory
};

Result<std::pair<std::shared_ptr<const ByteSource>, codec::EncodeReport>> encode(
    const RasterSource& source, const RasterEncoding& encoding) {
    if (encoding.path.empty()) {
        MemorySink sink;
        MemorySpool spool;
        RELIEF_TRY(auto report, codec::encode_raster(source, encoding.options, sink, spool));
        return std::pair(
            std::shared_ptr<const ByteSource>(std::make_shared<MemorySource>(sink.take())),
            std::move(report));
    }
    RELIEF_TRY(io::OutputFile sink, io::OutputFile::create(encoding.path));
    io::FileSpool spool(encoding.path);
    RELIEF_TRY(auto report, codec::encode_raster(source, encoding.options, sink, spool));
    RELIEF_CHECK(sink.commit());
    RELIEF_TRY(auto bytes, io::open_source(encoding.path));
    return std::pair(std::move(bytes), std::move(report));
}

py::dict report_of(const codec::EncodeReport& report) {
    py::dict dict = rate_report(report);
    dict["scheme"] = std::string(multires::scheme_name(report.spec.id));
    dict["order"] = report.spec.order;
    dict["levels"] = report.spec.levels;
    dict["corrected"] = report.corrected;
    dict["closed_loop"] = report.closed_loop;
    dict["lattice"] = report.lattice > 0 ? py::object(py::float_(report.lattice)) : py::none();
    return dict;
}

std::shared_ptr<OpenRaster> encode_raster(const py::object& values, const py::object& path,
                                          const ArrayAbout& about, const Goal& goal,
                                          const std::optional<multires::SchemeSpec>& spec,
                                          const std::string& profile, int effort,
                                          const py::object& progress) {
    if (profile != "dense" && profile != "fast")
        raise_argument("profiles are dense and fast, not '" + profile + "'");
    if (effort < 0 || effort > 2) raise_argument("effort is 0, 1 or 2");
    const Source source(values, about);
    LongCall call(progress);
    RasterEncoding encoding;
    encoding.options.spec = spec;
    encoding.options.goal = goal;
    encoding.options.effort = static_cast<codec::Effort>(effort);
    encoding.options.profile = profile == "fast" ? codec::Profile::Fast : codec::Profile::Dense;
    encoding.options.progress = call.hook();
    if (!path.is_none()) encoding.path = path_of(path);
    auto [bytes, report] =
        call.run([&] { return located(encode(*source, encoding), source.path()); });
    auto file = open_source<RasterFile>(std::move(bytes), {}, encoding.path);
    file->report = report_of(report);
    return file;
}

/// The same file or its first bytes.
std::shared_ptr<OpenRaster> prefix(const std::shared_ptr<OpenRaster>& self,
                                   std::optional<std::uint64_t> bytes) {
    return bytes ? open_source<RasterFile>(self->source, bytes, "") : self;
}

py::tuple decode_part(const std::shared_ptr<OpenRaster>& self, int level,
                      const std::optional<Window>& window, std::optional<std::uint64_t> bytes,
                      bool allow_damage) {
    const auto from = prefix(self, bytes);
    check_level(*from, level, from->file.layout().levels());
    const LatticeBox box = window ? box_of(*window) : from->file.box(level);
    codec::DecodedRaster part = take(unlocked([&]() -> Result<codec::DecodedRaster> {
        if (window || allow_damage) return from->file.decode_window(level, box);
        RELIEF_TRY(Raster raster, from->file.decode(level));
        return codec::DecodedRaster{std::move(raster), from->file.bound(level), {}};
    }));
    if (!part.damaged.empty() && !allow_damage)
        raise({ErrorCode::BadFile,
               "chunks of that part are damaged; allow_damage=True fills them in from coarser ones",
               "row " + std::to_string(part.damaged[0].row0) + ", column " +
                   std::to_string(part.damaged[0].col0)});
    py::list damaged;
    for (const LatticeBox& d : part.damaged)
        damaged.append(py::make_tuple(d.row0, d.col0, d.rows, d.cols));
    return py::make_tuple(std::make_shared<Raster>(std::move(part.raster)), part.bound, damaged);
}

std::shared_ptr<Raster> decode(const std::shared_ptr<OpenRaster>& self, int level,
                               const std::optional<Window>& window,
                               std::optional<std::uint64_t> bytes, bool allow_damage) {
    return decode_part(self, level, window, bytes, allow_damage)[0].cast<std::shared_ptr<Raster>>();
}

py::tuple coefficients(const OpenRaster& self, int level) {
    check_level(self, level, self.file.layout().levels());
    auto net = take(unlocked([&] { return self.file.coefficients(level); }));
    py::tuple planes(net.planes.size());
    for (std::size_t p = 0; p < net.planes.size(); ++p) planes[p] = owned(std::move(net.planes[p]));
    return py::make_tuple(planes.size() == 1 ? py::object(planes[0]) : py::object(planes),
                          py::make_tuple(net.box.row0, net.box.col0));
}

py::dict measure(const Raster& reference, const Raster& other) {
    const codec::Measure m = take(unlocked([&] { return codec::measure(reference, other); }));
    return py::dict("samples"_a = m.samples, "mask_differs"_a = m.mask_differs,
                    "max_error"_a = m.max_error, "mean_square"_a = m.mean_square,
                    "rms_error"_a = m.rms_error, "psnr_db"_a = m.psnr_db, "range"_a = m.range,
                    "worst"_a = py::make_tuple(m.worst_row, m.worst_col));
}

py::object open(const py::object& object, std::optional<std::uint64_t> bytes) {
    return open_any(byte_source(object), bytes, is_path(object) ? path_of(object) : "");
}

multires::SchemeSpec scheme(const std::string& name, int order, int levels,
                            const std::string& family, int dual, const std::string& map,
                            bool exact) {
    multires::SchemeSpec spec;
    spec.id = take(multires::scheme_from_name(name));
    spec.family = take(multires::family_from_name(family));
    spec.data_map = take(multires::data_map_from_name(map));
    if (levels < -1) raise_argument("levels must not be negative");
    spec.order = order;
    spec.levels = levels;
    spec.dual_order = dual;
    spec.exact = exact;
    return spec;
}

void define_raster_file(py::module_& module) {
    py::class_<OpenRaster, std::shared_ptr<OpenRaster>> type(
        module, "RasterFile",
        "An open .relief file of a raster, or the first bytes of one.\n\n"
        "Several threads may read at once.");
    define_file(type, [](const RasterFile& file) { return file.layout().levels(); });
    define_evaluation(type);
    const auto about = [](const OpenRaster& self) -> const Raster& {
        return self.file.description();
    };
    type.def("__repr__",
             [about](const OpenRaster& self) {
                 const Raster& raster = about(self);
                 return "<relief.RasterFile " + std::to_string(raster.rows) + " x " +
                        std::to_string(raster.cols) + ", " +
                        std::string(multires::scheme_name(self.file.spec().id)) + ", " +
                        std::to_string(self.file.size()) + " bytes>";
             })
        .def_property_readonly(
            "shape",
            [about](const OpenRaster& self) {
                const Raster& raster = about(self);
                const int components = self.file.layout().components;
                return components == 1 ? py::make_tuple(raster.rows, raster.cols)
                                       : py::make_tuple(components, raster.rows, raster.cols);
            },
            "(rows, cols), or (bands, rows, cols), of level 0.")
        .def(
            "level_shape",
            [](const OpenRaster& self, int level) {
                check_level(self, level, self.file.layout().levels());
                const LatticeBox box = self.file.box(level);
                return py::make_tuple(box.rows, box.cols);
            },
            py::arg("level"), "(rows, cols) of a level.")
        .def_property_readonly(
            "dtype",
            [about](const OpenRaster& self) {
                return py::dtype(std::string(sample_type_name(about(self).type)));
            },
            "What the raster's own file stores a sample as.")
        .def_property_readonly(
            "crs", [about](const OpenRaster& self) { return about(self).geo.crs; },
            "As Raster.crs.")
        .def_property_readonly(
            "transform", [about](const OpenRaster& self) { return about(self).geo.transform; },
            "As Raster.transform, of level 0.")
        .def_property_readonly(
            "unit", [about](const OpenRaster& self) { return about(self).unit; }, "Of the samples.")
        .def_property_readonly(
            "nodata", [about](const OpenRaster& self) { return about(self).nodata; },
            "The value of holes in the raster's own file, or None.")
        .def_property_readonly(
            "scheme",
            [](const OpenRaster& self) {
                return std::string(multires::scheme_name(self.file.spec().id));
            },
            "'fvs', 'cubic', 'box' or 'barycentric'.")
        .def_property_readonly(
            "order", [](const OpenRaster& self) { return self.file.spec().order; },
            "Of the scheme.")
        .def_property_readonly(
            "profile", [](const OpenRaster& self) { return self.file.profile(); },
            "'dense' or 'fast' of a closed-loop file (docs/codec.md); else ''.")
        .def(
            "surface_bound",
            [](const OpenRaster& self, int level) {
                check_level(self, level, self.file.layout().levels());
                return self.file.surface_bound(level);
            },
            py::arg("level") = 0,
            "Verified largest error, at all samples of the raster, of the surface when nothing "
            "finer "
            "than `level` is read; None if edited or not known.")
        .def(
            "decode", &decode, py::arg("level") = 0, py::arg("window") = py::none(),
            py::arg("bytes") = py::none(), py::arg("allow_damage") = false,
            "The raster of a level, or its window (row, col, rows, cols); with `bytes` from the "
            "first bytes of the file only.\n\n"
            "Errors: relief.Error for a level or window that does not exist, and for damage, which "
            "allow_damage=True fills in from coarser levels. A window of a closed-loop file reads "
            "its tiles only. Source: docs/codec.md.")
        .def("decode_part", &decode_part, py::arg("level") = 0, py::arg("window") = py::none(),
             py::arg("bytes") = py::none(), py::arg("allow_damage") = false,
             "(raster, bound, damaged): as decode, with the verified largest error of the part or "
             "None, and the list of damaged boxes (row, col, rows, cols) of level 0.")
        .def("coefficients", &coefficients, py::arg("level") = 0,
             "(array, (row, col)): the control coefficients of a level, moves included, and the "
             "place "
             "of the first one on the lattice; of several components a tuple of arrays.");
}

}  // namespace

py::object open_any(const std::shared_ptr<const ByteSource>& source,
                    std::optional<std::uint64_t> bytes, const std::string& path) {
    const std::string content =
        take(unlocked([&] { return located(codec::content_of(source), path); }));
    if (content == "quadrangulation")
        return py::cast(open_source<codec::QuadFile>(source, bytes, path));
    if (content == "mesh") return py::cast(open_source<codec::MeshFile>(source, bytes, path));
    if (content == "powell-sabin") return py::cast(open_source<codec::PsFile>(source, bytes, path));
    return py::cast(open_source<RasterFile>(source, bytes, path));
}

std::shared_ptr<const ByteSource> any_byte_source(const py::object& object) {
    if (py::isinstance<OpenRaster>(object)) return object.cast<OpenRaster&>().source;
    if (py::isinstance<OpenFile<codec::MeshFile>>(object))
        return object.cast<OpenFile<codec::MeshFile>&>().source;
    if (py::isinstance<OpenFile<codec::QuadFile>>(object))
        return object.cast<OpenFile<codec::QuadFile>&>().source;
    if (py::isinstance<OpenFile<codec::PsFile>>(object))
        return object.cast<OpenFile<codec::PsFile>&>().source;
    return byte_source(object);
}

py::object jets_as_arrays(std::vector<spline::PlaneJet> jets, const py::array& places,
                          int components, int derivatives) {
    constexpr py::ssize_t step = sizeof(spline::PlaneJet);
    constexpr py::ssize_t number = sizeof(double);
    static_assert(step == 6 * number);  // value, x, y, xx, xy, yy
    std::vector<py::ssize_t> shape = leading_shape(places, components);
    if (derivatives == 0) return derivative_of(jets, places, components, 0, 0);
    std::vector<spline::PlaneJet>* place = nullptr;
    const py::capsule owner = capsule_of(std::move(jets), place);
    const auto* first = reinterpret_cast<const double*>(place->data());
    std::vector<py::ssize_t> strides = dense_strides(shape, step);
    const py::array values = view_of(first, shape, strides, owner);
    shape.push_back(2);
    strides.push_back(number);
    const py::array gradients = view_of(first + 1, shape, strides, owner);
    if (derivatives == 1) return py::make_tuple(values, gradients);
    shape.push_back(2);
    strides.push_back(number);  // xx xy / xy yy: the same step both ways
    return py::make_tuple(values, gradients, view_of(first + 3, shape, strides, owner));
}

py::object derivative_of(const std::vector<spline::PlaneJet>& jets, const py::array& places,
                         int components, int dx, int dy) {
    const int order = dx + dy;
    const int number = order == 0 ? 0 : order == 1 ? 1 + dy : 3 + dy;
    py::array_t<double> values(leading_shape(places, components));
    double* out = values.mutable_data();
    for (std::size_t k = 0; k < jets.size(); ++k)
        out[k] = reinterpret_cast<const double*>(&jets[k])[number];
    return values.attr("__getitem__")(py::tuple());  // without axes: a number
}

Contiguous<double> paired(const py::object& x, const py::object& y) {
    const py::module_ numpy = py::module_::import("numpy");
    const py::object both = numpy.attr("broadcast_arrays")(x, y);
    return numpy.attr("stack")(both, "axis"_a = -1).cast<Contiguous<double>>();
}

py::object chunks_as_list(const std::vector<codec::ChunkSummary>& chunks) {
    py::list list;
    for (const codec::ChunkSummary& chunk : chunks)
        list.append(py::dict("kind"_a = chunk.kind, "level"_a = chunk.level,
                             "count"_a = chunk.count, "bytes"_a = chunk.bytes,
                             "max_error"_a = std::isfinite(chunk.max_error)
                                                 ? py::object(py::float_(chunk.max_error))
                                                 : py::none()));
    return list;
}

py::tuple goal_as_tuple(const Goal& goal) {
    constexpr std::array names{"keep", "rms-error", "max-error", "bytes", "lossless"};
    return py::make_tuple(names[static_cast<std::size_t>(goal.kind)], goal.value);
}

void define_files(py::module_& module) {
    py::class_<Goal>(module, "Goal")
        .def(py::init([](const std::string& kind, double value) {
                 using enum Goal::Kind;
                 if (kind == "keep") return Goal{Keep, value};
                 if (kind == "rms_error") return Goal{RmsError, value};
                 if (kind == "max_error") return Goal{MaxError, value};
                 if (kind == "bytes") return Goal{Bytes, value};
                 if (kind == "lossless") return Goal{Lossless, 0};
                 raise_argument("goals are max_error, rms_error, bytes, keep and lossless, not '" +
                                kind + "'");
             }),
             py::arg("kind"), py::arg("value") = 0.0);
    py::class_<multires::SchemeSpec>(module, "SchemeSpec")
        .def(py::init(&scheme), py::arg("name"), py::arg("order") = 2, py::arg("levels") = -1,
             py::arg("family") = "compact", py::arg("dual") = 0, py::arg("map") = "interpolate",
             py::arg("exact") = false);
    define_raster_file(module);
    module.def("encode_raster", &encode_raster, py::arg("values"), py::arg("path"),
               py::arg("about"), py::arg("goal"), py::arg("spec"), py::arg("profile"),
               py::arg("effort"), py::arg("progress"));
    module.def("open", &open, py::arg("file"), py::arg("bytes") = py::none());
    module.def("compare", &measure, py::arg("reference"), py::arg("other"));
}

}  // namespace relief::python
