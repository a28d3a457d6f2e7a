#include <cmath>

#include "convert.h"
#include "relief/io/crs.h"
#include "relief/io/file_kind.h"
#include "relief/io/raster.h"

/// relief.Raster, and rasters from and to files.
namespace relief::python {

namespace {

py::tuple shape_of(const Raster& raster) {
    if (raster.planes.size() == 1) return py::make_tuple(raster.rows, raster.cols);
    return py::make_tuple(raster.planes.size(), raster.rows, raster.cols);
}

/// The planes where they lie.
py::tuple planes_of(const py::object& self) {
    auto& raster = self.cast<Raster&>();
    py::tuple planes(raster.planes.size());
    for (std::size_t p = 0; p < raster.planes.size(); ++p)
        planes[p] = view_of(raster.planes[p].view(), self);
    return planes;
}

py::object as_array(const py::object& self, const py::object& dtype, const py::object& copy) {
    const py::tuple planes = planes_of(self);
    py::object array = planes[0];
    if (planes.size() > 1) array = py::module_::import("numpy").attr("stack")(planes);
    if (!dtype.is_none()) array = array.attr("astype")(dtype, py::arg("copy") = false);
    const bool copied = !copy.is_none() && copy.cast<bool>();
    return copied ? py::object(array.attr("copy")()) : array;
}

py::object valid_of(const py::object& self) {
    auto& raster = self.cast<Raster&>();
    if (raster.mask.empty()) return py::none();
    return view_of(raster.mask.view(), self).attr("view")("bool");
}

ArrayAbout about_of(py::object valid, std::optional<double> nodata,
                    std::optional<std::array<double, 6>> transform, const std::string& crs,
                    std::string unit) {
    return {std::move(valid), nodata, transform, crs.empty() ? crs : take(io::crs_from_user(crs)),
            std::move(unit)};
}

std::shared_ptr<Raster> raster_from(const py::object& values, const py::object& valid,
                                    std::optional<double> nodata,
                                    std::optional<std::array<double, 6>> transform,
                                    const std::string& crs, const std::string& unit,
                                    const std::optional<std::string>& dtype) {
    const ArrayAbout about = about_of(valid, nodata, transform, crs, unit);
    const Source source(values, about);
    Raster raster = description_of(source->description());
    Raster part = take(unlocked([&] { return source->read({0, 0, raster.rows, raster.cols}); }));
    raster.planes = std::move(part.planes);
    raster.mask = std::move(part.mask);
    if (dtype) raster.type = take(sample_type_from_name(*dtype));
    return std::make_shared<Raster>(std::move(raster));
}

std::string text_of(const Raster& raster) {
    const std::string bands =
        raster.planes.size() == 1 ? "" : std::to_string(raster.planes.size()) + " bands of ";
    return "<relief.Raster " + bands + std::to_string(raster.rows) + " x " +
           std::to_string(raster.cols) + ", " + std::string(sample_type_name(raster.type)) +
           (raster.geo.crs.empty() ? "" : ", " + raster.geo.crs.substr(0, 40)) + ">";
}

std::shared_ptr<Raster> read_raster(const py::object& path, const std::optional<Window>& window,
                                    const py::object& progress) {
    LongCall call(progress);
    io::ReadOptions options{.progress = call.hook()};
    if (window) options.window = box_of(*window);
    const std::string name = path_of(path);
    return std::make_shared<Raster>(call.run([&] { return io::read_raster(name, options); }));
}

/// Strip by strip, unless the raster is in the library's memory already.
void write_raster(const py::object& path, const py::object& values, const ArrayAbout& about,
                  const std::string& driver, const std::vector<std::string>& creation_options,
                  const py::object& progress) {
    const std::string name = path_of(path);
    const Source source(values, about);
    LongCall call(progress);
    const io::WriteOptions options{call.hook(), driver, creation_options};
    const Raster* whole = py::isinstance<Raster>(values) ? &values.cast<const Raster&>() : nullptr;
    call.run([&]() -> Status {
        if (whole != nullptr) return io::write_raster(name, *whole, options);
        constexpr std::int64_t height = 256;
        const Raster& all = source->description();
        const auto possible = io::Holes::Possible;
        RELIEF_TRY(auto writer,
                   io::RasterWriter::create(name, all, source->components(), possible, options));
        for (std::int64_t row = 0; row < all.rows; row += height) {
            RELIEF_TRY(Raster strip,
                       source->read({row, 0, std::min(height, all.rows - row), all.cols}));
            RELIEF_CHECK(writer.write(row, strip));
        }
        return writer.commit();
    });
}

const char* kind_of(const py::object& path) {
    const std::string name = path_of(path);
    switch (unlocked([&] { return io::recognise(name); })) {
        case io::FileKind::Relief:
            return "relief";
        case io::FileKind::Raster:
            return "raster";
        case io::FileKind::Mesh:
            return "mesh";
        case io::FileKind::Points:
            return "points";
        case io::FileKind::Unknown:
            return "unknown";
    }
    return "unknown";
}

}  // namespace

void define_rasters(py::module_& module) {
    py::class_<ArrayAbout>(module, "ArrayAbout")
        .def(py::init(&about_of), py::arg("valid") = py::none(), py::arg("nodata") = py::none(),
             py::arg("transform") = py::none(), py::arg("crs") = "", py::arg("unit") = "");

    py::class_<Raster, std::shared_ptr<Raster>>(
        module, "Raster",
        "A raster in memory: one to four planes of float64 samples, NaN in holes, and what its "
        "file says of them.\n\n"
        "np.asarray(raster) is the only plane where it lies, or a new array (bands, rows, "
        "cols).\n\n"
        ">>> import numpy as np, relief\n"
        ">>> raster = relief.Raster(np.arange(6, dtype=np.int16).reshape(2, 3), unit='m')\n"
        ">>> raster\n"
        "<relief.Raster 2 x 3, int16>\n"
        ">>> float(np.asarray(raster)[1, 2])\n"
        "5.0\n")
        .def(py::init(&raster_from), py::arg("values"), py::arg("valid") = py::none(),
             py::arg("nodata") = py::none(), py::arg("transform") = py::none(), py::arg("crs") = "",
             py::arg("unit") = "", py::arg("dtype") = py::none())
        .def("__repr__", &text_of)
        .def("__array__", &as_array, py::arg("dtype") = py::none(), py::arg("copy") = py::none())
        .def_property_readonly("shape", &shape_of, "(rows, cols), or (bands, rows, cols).")
        .def_property_readonly(
            "dtype",
            [](const Raster& raster) {
                return py::dtype(std::string(sample_type_name(raster.type)));
            },
            "What a file stores a sample as; the planes are float64, which holds all exactly.")
        .def_property_readonly("planes", &planes_of, "The bands, each (rows, cols), not copied.")
        .def_property_readonly("valid", &valid_of,
                               "(rows, cols): False in holes, not copied; None without holes.")
        .def_readwrite("nodata", &Raster::nodata, "The value of holes in a file, or None.")
        .def_property(
            "transform", [](const Raster& raster) { return raster.geo.transform; },
            [](Raster& raster, const std::optional<std::array<double, 6>>& transform) {
                raster.geo.transform = transform;
            },
            "t: x = t[0] + t[1] col + t[2] row, y = t[3] + t[4] col + t[5] row, from the outer "
            "corner of the first cell; None: unknown.")
        .def_property(
            "crs", [](const Raster& raster) { return raster.geo.crs; },
            [](Raster& raster, const std::string& crs) {
                raster.geo.crs = crs.empty() ? crs : take(io::crs_from_user(crs));
            },
            "'EPSG:26911' where that says everything, else WKT; '': unknown.")
        .def_readwrite("unit", &Raster::unit, "Of the samples: 'm', 'ft', ..; '': unknown.")
        .def_readwrite("scale", &Raster::scale, "Physical value = sample x scale + offset.")
        .def_readwrite("offset", &Raster::offset, "See scale.")
        .def_readwrite("band_names", &Raster::band_names, "A name for each band, or none.")
        .def_readwrite("metadata", &Raster::metadata, "Pairs of texts.");

    module.def("read_raster", &read_raster, py::arg("path"), py::arg("window") = py::none(),
               py::arg("progress") = py::none());
    module.def("write_raster", &write_raster, py::arg("path"), py::arg("values"),
               py::arg("about") = ArrayAbout(), py::arg("driver") = "",
               py::arg("creation_options") = std::vector<std::string>(),
               py::arg("progress") = py::none());
    module.def("kind_of", &kind_of, py::arg("path"),
               "What a file is: 'relief', 'raster', 'mesh', 'points' or 'unknown'.");
}

}  // namespace relief::python
