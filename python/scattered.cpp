#include <algorithm>
#include <cmath>

#include "files.h"
#include "meshes.h"
#include "relief/codec/point_codec.h"
#include "relief/codec/polygons.h"
#include "relief/io/crs.h"
#include "relief/io/points.h"
#include "relief/multires/ps_surface.h"

/// Scattered points: reading them, and surfaces through and near them.
namespace relief::python {

namespace {

namespace ps = multires::ps;
using codec::Goal;
using codec::PsFile;
using py::literals::operator""_a;

/// The numbers of an array (n,), or of the rows of one (k, n).
std::vector<std::vector<double>> components_of(const Contiguous<double>& values, std::size_t n) {
    const py::ssize_t rows = values.ndim() == 2 ? values.shape(0) : 1;
    if (values.ndim() < 1 || values.ndim() > 2 ||
        values.shape(values.ndim() - 1) != static_cast<py::ssize_t>(n))
        raise_argument("values are an array (n,) or (components, n), n the number of places");
    std::vector<std::vector<double>> components;
    for (py::ssize_t k = 0; k < rows; ++k) {
        const double* first = values.data() + k * static_cast<py::ssize_t>(n);
        components.emplace_back(first, first + n);
    }
    return components;
}

codec::PsData data_of(const Contiguous<double>& x, const Contiguous<double>& y,
                      const Contiguous<double>& z, const py::object& weights) {
    if (x.ndim() != 1 || y.ndim() != 1 || x.size() != y.size())
        raise_argument("x and y are arrays of one size");
    codec::PsData data;
    const auto n = static_cast<std::size_t>(x.size());
    data.points.reserve(n);
    for (std::size_t k = 0; k < n; ++k) data.points.push_back({x.data()[k], y.data()[k]});
    data.values = components_of(z, n);
    if (!weights.is_none()) {
        const auto given = numbers_of<double>(weights, "weights");
        if (given.ndim() != 1 || given.size() != x.size())
            raise_argument("weights are an array of the size of x");
        data.weights.assign(given.data(), given.data() + n);
    }
    return data;
}

struct FitOptions {
    std::optional<std::size_t> vertices;
    std::shared_ptr<PolygonMesh> mesh;
    std::optional<double> smoothing;
    std::string energy;     ///< empty: the library's choice
    std::string gradients;  ///< likewise
    int levels = 0;
};

Result<codec::PointMethod> method_of(const FitOptions& options, const std::optional<Goal>& goal) {
    codec::FitWishes wishes{
        .vertices = options.vertices, .levels = options.levels, .smoothing = options.smoothing};
    if (!options.energy.empty() && options.energy != "plate" && options.energy != "jumps")
        return Error{ErrorCode::InvalidArgument, "energy is plate or jumps", ""};
    if (!options.energy.empty())
        wishes.energy = options.energy == "jumps" ? ps::Energy::Jump : ps::Energy::ThinPlate;
    if (!options.gradients.empty()) {
        RELIEF_TRY(wishes.gradients, ps::gradient_rule_from_name(options.gradients));
    }
    if (options.mesh) {
        RELIEF_TRY(wishes.triangles, codec::triangulation_of(*options.mesh));
    }
    return codec::point_method(std::move(wishes), goal);
}

py::object fit(const Contiguous<double>& x, const Contiguous<double>& y,
               const Contiguous<double>& z, const py::object& weights,
               const std::optional<Goal>& goal, const FitOptions& options, const std::string& crs,
               const std::string& unit, const py::object& path, const py::object& progress) {
    const codec::PsData data = data_of(x, y, z, weights);
    const codec::PsReference reference{crs.empty() ? crs : take(io::crs_from_user(crs)), unit};
    LongCall call(progress);
    const Progress hook = call.hook();
    auto encoded = call.run([&]() -> Result<codec::EncodedPoints> {
        RELIEF_TRY(const codec::PointMethod method, method_of(options, goal));
        return codec::encode_points(data, method, goal, hook, reference);
    });
    py::dict report = rate_report(encoded.report);
    report["vertices"] = encoded.report.vertices;
    report["triangles"] = encoded.report.triangles;
    report["levels"] = encoded.report.levels;
    report["surface_bound"] = encoded.report.surface_bound;
    report["smoothing"] = encoded.smoothing;
    report["merged"] = encoded.merged;
    report["outside"] = encoded.outside;
    report["beyond"] = encoded.beyond;
    report["reason"] = encoded.reason;
    return py::cast(encoded_file<PsFile>(std::move(encoded.bytes), std::move(report), path));
}

py::tuple read_points(const py::object& path, const std::vector<std::string>& columns) {
    io::PointColumns wanted;
    if (!columns.empty()) {
        if (columns.size() < 3 || columns.size() > 6)
            raise_argument("columns are x, y, value and perhaps weight, or u, v, x, y, z likewise");
        const std::ptrdiff_t components = columns.size() < 5 ? 1 : 3;
        wanted.x = columns[0];
        wanted.y = columns[1];
        wanted.values.assign(columns.begin() + 2, columns.begin() + 2 + components);
        if (std::ssize(columns) > 2 + components) wanted.weight = columns.back();
    }
    const std::string name = path_of(path);
    io::PointSet set = take(unlocked([&] { return io::read_points(name, wanted); }));
    py::tuple values(set.values.size());
    for (std::size_t k = 0; k < set.values.size(); ++k) values[k] = owned(std::move(set.values[k]));
    return py::make_tuple(
        owned_rows<double>(std::move(set.places)),
        values.size() == 1 ? py::object(values[0]) : py::object(values),
        set.weights.empty() ? py::object(py::none()) : py::object(owned(std::move(set.weights))));
}

void write_columns(const py::object& path, const py::dict& columns) {
    std::vector<Contiguous<double>> kept;
    std::vector<io::CsvColumn> table;
    for (const auto& [name, values] : columns) {
        kept.push_back(numbers_of<double>(values, "columns"));
        if (kept.back().ndim() != 1) raise_argument("a column is an array of numbers (n,)");
        table.push_back({name.cast<std::string>(),
                         {kept.back().data(), static_cast<std::size_t>(kept.back().size())}});
    }
    const std::string name = path_of(path);
    check(unlocked([&] { return io::write_csv(name, table); }));
}

/// Values at the samples of a raster over the plane.
py::object grid(const OpenFile<PsFile>& self, const std::array<double, 2>& first,
                const std::array<double, 2>& step, const std::array<std::int64_t, 2>& shape,
                int level) {
    check_level(self, level, self.file.levels());
    if (shape[0] < 1 || shape[1] < 1) raise_argument("a grid has at least one row and column");
    auto planes = take(unlocked([&]() -> Result<std::vector<Grid<double>>> {
        RELIEF_TRY(const codec::PsSurface data, self.file.surface(level));
        RELIEF_TRY(const ps::Surface surface, ps::Surface::create(data.space, data.components));
        std::vector<Grid<double>> components;
        for (int c = 0; c < surface.components(); ++c) {
            Grid<double>& plane = components.emplace_back(shape[0], shape[1]);
            RELIEF_CHECK(ps::evaluate_raster(surface, {{first[0], first[1]}, {step[0], step[1]}},
                                             plane.view(), c));
        }
        return components;
    }));
    py::tuple arrays(planes.size());
    for (std::size_t c = 0; c < planes.size(); ++c) arrays[c] = owned(std::move(planes[c]));
    return arrays.size() == 1 ? py::object(arrays[0]) : py::object(arrays);
}

}  // namespace

void define_scattered(py::module_& module) {
    py::class_<FitOptions>(module, "FitOptions")
        .def(py::init([](std::optional<std::size_t> vertices, std::shared_ptr<PolygonMesh> mesh,
                         std::optional<double> smoothing, std::string energy, std::string gradients,
                         int levels) {
                 return FitOptions{vertices,          std::move(mesh),      smoothing,
                                   std::move(energy), std::move(gradients), levels};
             }),
             py::arg("vertices"), py::arg("mesh"), py::arg("smoothing"), py::arg("energy"),
             py::arg("gradients"), py::arg("levels"));
    module.def("fit", &fit, py::arg("x"), py::arg("y"), py::arg("z"), py::arg("weights"),
               py::arg("goal"), py::arg("options"), py::arg("crs"), py::arg("unit"),
               py::arg("path"), py::arg("progress"));
    module.def("read_points", &read_points, py::arg("path"), py::arg("columns"));
    module.def("write_columns", &write_columns, py::arg("path"), py::arg("columns"));

    auto type =
        py::reinterpret_borrow<py::class_<OpenFile<PsFile>, std::shared_ptr<OpenFile<PsFile>>>>(
            module.attr("SplineFile"));
    type.def_property_readonly(
            "components", [](const OpenFile<PsFile>& self) { return self.file.components(); },
            "1: heights over the plane; 3: a surface in space over its parameters.")
        .def_property_readonly(
            "extent", [](const OpenFile<PsFile>& self) { return self.file.extent(); },
            "[x least, y least, x most, y most].")
        .def_property_readonly(
            "crs", [](const OpenFile<PsFile>& self) { return self.file.reference().crs; },
            "Of x and y; '': unknown.")
        .def_property_readonly(
            "unit", [](const OpenFile<PsFile>& self) { return self.file.reference().unit; },
            "Of the values; '': unknown.")
        .def("grid", &grid, py::arg("first"), py::arg("step"), py::arg("shape"),
             py::arg("level") = 0,
             "Values at (first[0] + c step[0], first[1] + r step[1]) for the rows r and columns c "
             "of "
             "`shape`; NaN outside. Of several components a tuple of arrays.");
}

}  // namespace relief::python
