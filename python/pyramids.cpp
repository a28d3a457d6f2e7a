#include <cmath>
#include <variant>

#include "convert.h"
#include "relief/codec/oracle.h"
#include "relief/multires/edit.h"
#include "relief/multires/scheme.h"

/// relief.Pyramid: surfaces as coefficients, in memory.
namespace relief::python {

namespace {

using multires::BandLayout;
using py::literals::operator""_a;

template <class T>
using Planes = std::vector<GridView<const T>>;

/// What `analyse` gives, in the precision of what it got.
struct PyramidObject {
    std::variant<multires::Pyramid<float>, multires::Pyramid<double>> pyramid;
    bool stacked = false;  ///< it had an axis of bands

    template <class T>
    PyramidObject(multires::Pyramid<T> made, bool of_stack)
        : pyramid(std::move(made)), stacked(of_stack) {}
    PyramidObject(const PyramidObject&) = delete;
    PyramidObject& operator=(const PyramidObject&) = delete;

    [[nodiscard]] const multires::PyramidLayout& layout() const {
        return std::visit(
            [](const auto& p) -> const auto& { return p.layout; }, pyramid);
    }
};

/// The planes of an array where they are, or of a copy of it in T, which `kept` then is.
template <class T>
Planes<T> planes_of(const py::array& values, py::array& kept) {
    constexpr auto size = static_cast<py::ssize_t>(sizeof(T));
    const py::ssize_t axes = values.ndim();
    const bool aligned = reinterpret_cast<std::uintptr_t>(values.data()) % alignof(T) == 0;
    const bool here = py::isinstance<py::array_t<T>>(values) && aligned &&
                      values.strides(axes - 1) == size && values.strides(axes - 2) % size == 0;
    kept = here ? values : py::array(numbers_of<T>(values, "samples"));
    const auto* first = static_cast<const std::byte*>(kept.data());
    Planes<T> planes;
    for (py::ssize_t p = 0; p < (axes == 3 ? kept.shape(0) : 1); ++p)
        planes.emplace_back(
            reinterpret_cast<const T*>(first + (axes == 3 ? p * kept.strides(0) : 0)),
            kept.shape(axes - 2), kept.shape(axes - 1), kept.strides(axes - 2) / size);
    return planes;
}

template <class T>
Status check_finite(const Planes<T>& planes) {
    for (const GridView<const T>& plane : planes)
        for (std::int64_t r = 0; r < plane.rows; ++r)
            for (std::int64_t c = 0; c < plane.cols; ++c)
                if (!std::isfinite(plane(r, c)))
                    return Error{ErrorCode::BadInput,
                                 "a sample is not a finite number; fill holes first",
                                 "row " + std::to_string(r) + ", column " + std::to_string(c)};
    return {};
}

template <class T>
std::shared_ptr<PyramidObject> analyse_as(const py::array& values,
                                          const multires::SchemeSpec& spec) {
    py::array kept;
    const Planes<T> planes = planes_of<T>(values, kept);
    auto pyramid = take(unlocked([&]() -> Result<multires::Pyramid<T>> {
        RELIEF_CHECK(check_finite(planes));
        return multires::analyse<T>(planes, spec);
    }));
    return std::make_shared<PyramidObject>(std::move(pyramid), values.ndim() == 3);
}

std::shared_ptr<PyramidObject> analyse(const py::array& values, const multires::SchemeSpec& spec) {
    if (values.ndim() != 2 && values.ndim() != 3)
        raise_argument("samples have the shape (rows, cols) or (components, rows, cols)");
    if (values.ndim() == 3 && (values.shape(0) < 1 || values.shape(0) > 4))
        raise_argument("a pyramid has 1 to 4 components");
    return py::isinstance<py::array_t<float>>(values) ? analyse_as<float>(values, spec)
                                                      : analyse_as<double>(values, spec);
}

/// One array, or a tuple of one a component.
template <class T, class Make>
py::object components_of(const multires::Planes<T>& planes, bool stacked, Make make) {
    if (!stacked) return make(0);
    py::tuple all(planes.size());
    for (std::size_t p = 0; p < planes.size(); ++p) all[p] = make(p);
    return all;
}

py::list bands(const py::object& self) {
    auto& object = self.cast<PyramidObject&>();
    py::list list;
    std::visit(
        [&](auto& pyramid) {
            for (auto& band : pyramid.bands)
                list.append(components_of(band, object.stacked, [&](std::size_t p) {
                    return view_of(band[p].view(), self);
                }));
        },
        object.pyramid);
    return list;
}

py::list layout(const PyramidObject& self) {
    py::list list;
    for (const BandLayout& band : self.layout().bands)
        list.append(py::dict(
            "name"_a = band.name, "level"_a = band.level, "channel"_a = band.channel,
            "box"_a = py::make_tuple(band.box.row0, band.box.col0, band.box.rows, band.box.cols),
            "norm_samples"_a = band.norm_samples, "norm_surface"_a = band.norm_surface,
            "norm_max"_a = band.norm_max));
    return list;
}

py::array norms(const PyramidObject& self) {
    std::vector<double> norms;
    for (const BandLayout& band : self.layout().bands) norms.push_back(band.norm_samples);
    return owned(std::move(norms));
}

void check_level(const PyramidObject& self, int level) {
    if (level < 0 || level > self.layout().levels())
        raise_argument("there is no level " + std::to_string(level) +
                       "; levels are 0 (finest) to " + std::to_string(self.layout().levels()));
}

template <class T>
py::object own_planes(multires::Planes<T> planes, bool stacked) {
    return components_of(planes, stacked,
                         [&](std::size_t p) { return owned(std::move(planes[p])); });
}

py::object synthesise(const PyramidObject& self, int level) {
    check_level(self, level);
    return std::visit(
        [&](const auto& pyramid) {
            return own_planes(unlocked([&] { return multires::synthesise(pyramid, level); }),
                              self.stacked);
        },
        self.pyramid);
}

py::tuple coefficients(const PyramidObject& self, int level) {
    check_level(self, level);
    return std::visit(
        [&](const auto& pyramid) {
            auto net = unlocked([&] { return multires::coefficients(pyramid, level); });
            return py::make_tuple(own_planes(std::move(net.planes), self.stacked),
                                  py::make_tuple(net.box.row0, net.box.col0));
        },
        self.pyramid);
}

std::int64_t threshold(PyramidObject& self, std::optional<std::int64_t> keep,
                       std::optional<double> above, const std::string& metric_name) {
    if (keep.has_value() == above.has_value()) raise_argument("give either keep or above");
    if (keep && *keep < 0) raise_argument("keep must not be negative");
    if (above && !(*above >= 0)) raise_argument("above must be a number from 0 on");
    if (metric_name != "samples" && metric_name != "surface")
        raise_argument("metrics are samples and surface, not '" + metric_name + "'");
    const auto metric = metric_name == "surface" ? codec::Metric::Surface : codec::Metric::Samples;
    return std::visit(
        [&](auto& pyramid) {
            return unlocked([&] {
                const codec::Selection selection =
                    keep ? codec::select_largest(pyramid, *keep, metric)
                         : codec::select_above(pyramid, *above, metric);
                codec::apply(selection, pyramid);
                return selection.kept;
            });
        },
        self.pyramid);
}

void move(PyramidObject& self, int level, std::int64_t row, std::int64_t col,
          const py::object& delta) {
    multires::Move one{level, row, col, {}};
    const std::vector<double> numbers = py::isinstance<py::sequence>(delta)
                                            ? delta.cast<std::vector<double>>()
                                            : std::vector<double>{delta.cast<double>()};
    if (numbers.size() > one.delta.size()) raise_argument("delta has at most 4 components");
    std::copy(numbers.begin(), numbers.end(), one.delta.begin());
    std::visit(
        [&](auto& pyramid) {
            check(unlocked([&] { return multires::apply_moves(pyramid, {one}); }));
        },
        self.pyramid);
}

}  // namespace

void define_pyramids(py::module_& module) {
    py::class_<PyramidObject, std::shared_ptr<PyramidObject>>(
        module, "Pyramid",
        "A surface as a coarse band and bands of detail (docs/architecture.md), float32 or float64 "
        "as the samples that it was made from.\n\n"
        ">>> import numpy as np, relief\n"
        ">>> z = np.add.outer(np.arange(9.0), 2 * np.arange(17.0))\n"
        ">>> pyramid = relief.analyse(z, scheme='box', levels=2)\n"
        ">>> [band.shape for band in pyramid.bands]\n"
        "[(3, 5), (2, 5), (3, 4), (2, 4), (4, 9), (5, 8), (4, 8)]\n"
        ">>> bool(abs(pyramid.bands[1]).max() < 1e-12)  # a plane has no details\n"
        "True\n"
        ">>> bool(np.allclose(pyramid.synthesise(), z))\n"
        "True\n")
        .def("__repr__",
             [](const PyramidObject& self) {
                 const multires::PyramidLayout& layout = self.layout();
                 return "<relief.Pyramid " + std::to_string(layout.rows) + " x " +
                        std::to_string(layout.cols) + ", " +
                        std::string(multires::scheme_name(layout.spec.id)) + ", " +
                        std::to_string(layout.levels()) + " levels>";
             })
        .def_property_readonly(
            "levels", [](const PyramidObject& self) { return self.layout().levels(); },
            "The coarsest level; 0 is the finest.")
        .def_property_readonly(
            "shape",
            [](const PyramidObject& self) {
                const multires::PyramidLayout& layout = self.layout();
                return self.stacked ? py::make_tuple(layout.components, layout.rows, layout.cols)
                                    : py::make_tuple(layout.rows, layout.cols);
            },
            "Of the samples.")
        .def_property_readonly(
            "dtype",
            [](const PyramidObject& self) {
                return py::dtype(self.pyramid.index() == 0 ? "float32" : "float64");
            },
            "Of the coefficients.")
        .def_property_readonly(
            "bands", &bands,
            "The coefficients where they lie: writing to them changes the surface. bands[0] is the "
            "coarsest scaling band, then come details from coarse to fine. Of samples with an axis "
            "of components each band is a tuple of arrays.")
        .def_property_readonly(
            "layout", &layout,
            "For each band a dict: name, level (1: finest details), channel (0: scaling), box "
            "(row, "
            "col, rows, cols) in units of 2**level samples, and the norms of its basis functions.")
        .def_property_readonly(
            "norms", &norms,
            "(bands,): root of the sum of squares over the samples of one unit of a coefficient.")
        .def("synthesise", &synthesise, py::arg("level") = 0,
             "The surface at every 2**level-th sample; level 0 gives the samples back.")
        .def("coefficients", &coefficients, py::arg("level") = 0,
             "(array, (row, col)): the control coefficients of a level and the place of the first "
             "one.")
        .def(
            "threshold", &threshold, py::arg("keep") = py::none(), py::arg("above") = py::none(),
            py::arg("metric") = "samples",
            "Sets coefficients to zero in place, and returns how many stay: the `keep` of largest "
            "|coefficient| x norm, or those from `above` on. metric: 'samples' or 'surface', which "
            "norm weights them. The scaling band always stays.")
        .def("move", &move, py::arg("level"), py::arg("row"), py::arg("col"), py::arg("delta"),
             "Moves a control coefficient of a level, in place; finer details stay. delta: a "
             "number, "
             "or one for each component. Errors: relief.Error naming the range.");
    module.def("analyse", &analyse, py::arg("samples"), py::arg("spec"));
}

}  // namespace relief::python
