#pragma once

#include <cmath>
#include <limits>
#include <mutex>

#include "convert.h"
#include "relief/codec/plane_surface.h"

/// What open .relief files of all kinds have in common.
namespace relief::python {

/// An open file with the bytes that it reads. A codec::RasterFile must not move once a surface of
/// it is there.
template <class File>
struct OpenFile {
    std::shared_ptr<const ByteSource> source;
    File file;
    py::object report = py::none();  ///< of the encoder, if it was encoded by this process

    std::mutex mutex = {};
    std::unique_ptr<const codec::PlaneSurface> surface = {};  ///< made when it is first asked

    OpenFile(std::shared_ptr<const ByteSource> bytes, File opened)
        : source(std::move(bytes)), file(std::move(opened)) {}
};

inline constexpr std::uint64_t kAll = std::numeric_limits<std::uint64_t>::max();

template <class File>
[[nodiscard]] std::shared_ptr<OpenFile<File>> open_source(std::shared_ptr<const ByteSource> source,
                                                          std::optional<std::uint64_t> bytes,
                                                          const std::string& path) {
    File file =
        take(unlocked([&] { return located(File::open(source, bytes.value_or(kAll)), path); }));
    return std::make_shared<OpenFile<File>>(std::move(source), std::move(file));
}
template <class File>
[[nodiscard]] std::shared_ptr<OpenFile<File>> open_object(const py::object& object,
                                                          std::optional<std::uint64_t> bytes) {
    return open_source<File>(byte_source(object), bytes, is_path(object) ? path_of(object) : "");
}
/// What an encoder made, with its report; written to `path` unless that is None.
template <class File>
[[nodiscard]] std::shared_ptr<OpenFile<File>> encoded_file(Bytes bytes, py::object report,
                                                           const py::object& path) {
    const std::shared_ptr<const ByteSource> source =
        std::make_shared<MemorySource>(std::move(bytes));
    if (!path.is_none()) copy_to_file(*source, path_of(path));
    auto file = open_source<File>(source, {}, "");
    file->report = std::move(report);
    return file;
}

/// What every encoder reports of sizes and errors.
template <class Report>
[[nodiscard]] py::dict rate_report(const Report& report) {
    using py::literals::operator""_a;
    return py::dict("samples"_a = report.samples, "coefficients"_a = report.coefficients,
                    "kept"_a = report.kept, "bytes"_a = report.bytes,
                    "bits_per_sample"_a = report.bits_per_sample, "max_error"_a = report.max_error,
                    "rms_error"_a = report.rms_error, "energy_percent"_a = report.energy_percent,
                    "bound"_a = report.bound);
}

/// The surface of a file over the plane.
template <class File>
[[nodiscard]] Result<const codec::PlaneSurface*> surface_of(OpenFile<File>& file) {
    const std::lock_guard lock(file.mutex);
    if (!file.surface) {
        RELIEF_TRY(file.surface, codec::plane_surface(file.file));
    }
    return file.surface.get();
}

/// The jets at places, [place][component].
[[nodiscard]] py::object jets_as_arrays(std::vector<spline::PlaneJet> jets, const py::array& places,
                                        int components, int derivatives);
[[nodiscard]] py::object derivative_of(const std::vector<spline::PlaneJet>& jets,
                                       const py::array& places, int components, int dx, int dy);
/// x and y, broadcast against each other, as places (.., 2).
[[nodiscard]] Contiguous<double> paired(const py::object& x, const py::object& y);

template <class File>
[[nodiscard]] std::pair<std::vector<spline::PlaneJet>, int> jets_at(
    OpenFile<File>& file, const Contiguous<double>& places, int derivatives) {
    const std::span<const Vec2> at = places_of(places);
    std::vector<spline::PlaneJet> jets;
    const int components = take(unlocked([&]() -> Result<int> {
        RELIEF_TRY(const codec::PlaneSurface* surface, surface_of(file));
        jets.resize(at.size() * static_cast<std::size_t>(surface->components()));
        RELIEF_CHECK(surface->evaluate(at, derivatives, jets));
        return surface->components();
    }));
    return {std::move(jets), components};
}

inline constexpr const char* kEvaluateDoc =
    "The surface at places (.., 2): x, y in the units of the data (column and row of a raster "
    "without a transform).\n\n"
    "Returns values (..), with derivatives=1 also gradients (.., 2), with 2 also Hessians "
    "(.., 2, 2), per data unit; with several components (.., components) and so on. NaN outside "
    "the "
    "surface and in holes. Errors: relief.Error for damaged files. Source: docs/evaluation.md.";
inline constexpr const char* kCallDoc =
    "The surface, or a derivative of it (dx + dy <= 2), at x, y, which are broadcast against each "
    "other.\n\nNaN outside the surface and in holes.";

/// Members `evaluate` and `__call__`.
template <class File, class... Options>
void define_evaluation(py::class_<OpenFile<File>, Options...>& type) {
    type.def(
        "evaluate",
        [](OpenFile<File>& self, const Contiguous<double>& places, int derivatives) {
            auto [jets, components] = jets_at(self, places, derivatives);
            return jets_as_arrays(std::move(jets), places, components, derivatives);
        },
        py::arg("places"), py::arg("derivatives") = 0, kEvaluateDoc);
    type.def(
        "__call__",
        [](OpenFile<File>& self, const py::object& x, const py::object& y, int dx, int dy) {
            if (dx < 0 || dy < 0 || dx + dy > 2)
                raise_argument("dx and dy are derivatives of order 0 to 2 together");
            const Contiguous<double> places = paired(x, y);
            const auto [jets, components] = jets_at(self, places, dx + dy);
            return derivative_of(jets, places, components, dx, dy);
        },
        py::arg("x"), py::arg("y"), py::arg("dx") = 0, py::arg("dy") = 0, kCallDoc);
}

template <class File>
void check_level(const OpenFile<File>& file, int level, int levels) {
    static_cast<void>(file);
    if (level < 0 || level > levels)
        raise_argument("there is no level " + std::to_string(level) +
                       "; levels are 0 (finest) to " + std::to_string(levels));
}

/// The bytes of an open file, of a path, or of an object with a buffer.
[[nodiscard]] std::shared_ptr<const ByteSource> any_byte_source(const py::object& object);
/// A file of any kind. path: for messages.
[[nodiscard]] py::object open_any(const std::shared_ptr<const ByteSource>& source,
                                  std::optional<std::uint64_t> bytes = {},
                                  const std::string& path = "");

[[nodiscard]] py::object chunks_as_list(const std::vector<codec::ChunkSummary>& chunks);
/// ('max-error', 0.5) and the like.
[[nodiscard]] py::tuple goal_as_tuple(const codec::Goal& goal);

/// Members that all files have. levels_of(file): how many levels there are above the finest.
template <class File, class LevelsOf, class... Options>
void define_file(py::class_<OpenFile<File>, Options...>& type, LevelsOf levels_of) {
    using Self = OpenFile<File>;
    type.def_property_readonly(
            "levels", [levels_of](const Self& self) { return levels_of(self.file); },
            "The coarsest level; 0 is the finest.")
        .def_property_readonly(
            "size", [](const Self& self) { return self.file.size(); }, "Bytes of the whole file.")
        .def_property_readonly(
            "goal", [](const Self& self) { return goal_as_tuple(self.file.goal()); },
            "What it was encoded for: ('max-error', 0.5), ('lossless', 0.0), ..")
        .def_property_readonly(
            "max_error", [](const Self& self) { return self.file.max_error(); },
            "Largest error of the whole file, in data units, as its encoder verified.")
        .def_property_readonly(
            "rms_error", [](const Self& self) { return self.file.rms_error(); },
            "Root mean square error of the same.")
        .def_property_readonly(
            "finest_level", [](const Self& self) { return self.file.finest_level(); },
            "The finest level that is complete: above 0 for the first bytes of a file.")
        .def_property_readonly(
            "edited", [](const Self& self) { return self.file.edited(); },
            "Whether the file has moves (relief.EditSession).")
        .def_property_readonly(
            "chunks", [](const Self& self) { return chunks_as_list(self.file.chunks()); },
            "What the file consists of: a list of dicts of kind, level, count, bytes, max_error.")
        .def_readonly(
            "report", &Self::report,
            "What encoding achieved: a dict, measured on the decoded file; None for files "
            "that were opened.")
        .def(
            "bytes_for",
            [levels_of](const Self& self, int level) {
                check_level(self, level, levels_of(self.file));
                return self.file.bytes_for(level);
            },
            py::arg("level"), "How many first bytes of the file `level` needs.")
        .def(
            "bound",
            [levels_of](const Self& self, int level) {
                check_level(self, level, levels_of(self.file));
                return self.file.bound(level);
            },
            py::arg("level") = 0,
            "Verified largest error of `level`, in data units; None if edited or not known.")
        .def(
            "checksums_ok",
            [](const Self& self) { return unlocked([&] { return self.file.checksums_ok(); }); },
            "Whether no byte of the file is damaged. Reads all of it.")
        .def(
            "tobytes", [](const Self& self) { return bytes_of(*self.source); },
            "The bytes of the file.")
        .def(
            "write",
            [](const Self& self, const py::object& path) {
                copy_to_file(*self.source, path_of(path));
            },
            py::arg("path"), "Writes the file, which appears when it is complete.")
        .def("__reduce__", [](const Self& self) {
            return py::make_tuple(py::module_::import("relief").attr("open"),
                                  py::make_tuple(bytes_of(*self.source)));
        });
}

}  // namespace relief::python
