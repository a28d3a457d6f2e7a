#include <nlohmann/json.hpp>

#include "files.h"
#include "relief/codec/container.h"
#include "relief/codec/mesh_codec.h"
#include "relief/core/json.h"
#include "relief/edit/session.h"
#include "relief/io/raster.h"

/// relief.EditSession.
namespace relief::python {

namespace {

using edit::Session;
using py::literals::operator""_a;

/// A raster's cells have the size that its reference system gives them.
Result<Session> open_session(const std::shared_ptr<const ByteSource>& source) {
    edit::OpenOptions options;
    RELIEF_TRY(const std::string content, codec::content_of(source));
    if (content == "raster") {
        RELIEF_TRY(const codec::RasterFile file, codec::RasterFile::open(source));
        if (const auto cell = io::cell_size_in_unit(file.description()))
            options.spacing = std::array{cell->x, cell->y};
    }
    return Session::open(source, options);
}

std::shared_ptr<Session> create(const py::object& file) {
    const auto source = any_byte_source(file);
    return std::make_shared<Session>(take(unlocked([&] { return open_session(source); })));
}

py::tuple tuple_of(const Vec3<double>& v) {
    return py::make_tuple(v.x, v.y, v.z);
}

nlohmann::json json_of(const py::handle& object) {
    // What Python writes is JSON, but for NaN and infinities, which no command has.
    nlohmann::json json = parse_json<nlohmann::json>(to_json(object));
    if (json.is_discarded())
        raise_argument("commands have no NaN, no infinities and nothing deep inside");
    return json;
}

py::dict run(Session& session, const py::dict& command) {
    const nlohmann::json json = json_of(command);
    const edit::Change change = take(unlocked([&] { return session.run(json); }));
    return py::dict("touched"_a = change.touched, "revision"_a = session.revision());
}

void replay(Session& session, const py::object& script) {
    const nlohmann::json json = json_of(script);
    check(unlocked([&] { return session.replay(json); }));
}

py::object at(const Session& session, double x, double y) {
    const auto probe = take(unlocked([&] { return session.at({x, y}); }));
    if (!probe) return py::none();
    return py::dict("value"_a = probe->value,
                    "gradient"_a = py::make_tuple(probe->gradient.x, probe->gradient.y),
                    "slope"_a = probe->slope, "x"_a = probe->place.x, "y"_a = probe->place.y);
}

py::dict describe(const Session& session) {
    const edit::Description& d = session.description();
    py::list levels;
    for (const edit::LevelInfo& level : d.levels)
        levels.append(py::dict("control_points"_a = level.control_points, "faces"_a = level.faces,
                               "bytes"_a = level.bytes, "rows"_a = level.rows,
                               "cols"_a = level.cols));
    const edit::Bounds bounds = session.bounds();
    return py::dict("kind"_a = edit::kind_name(d.kind), "scheme"_a = d.scheme, "order"_a = d.order,
                    "levels"_a = levels, "components"_a = d.components,
                    "parametric"_a = d.parametric, "origin"_a = tuple_of(d.origin),
                    "min"_a = tuple_of(bounds.min), "max"_a = tuple_of(bounds.max),
                    "unit"_a = d.unit, "crs"_a = d.crs, "bound"_a = d.bound, "bytes"_a = d.bytes);
}

/// Points of the control net and their numbers.
py::tuple net(const Session& session, int level, const std::optional<Window>& window) {
    std::optional<LatticeBox> box;
    if (window) box = box_of(*window);
    edit::NetGeometry net = take(unlocked([&] { return session.net(level, box); }));
    return py::make_tuple(owned_rows<float>(std::move(net.position)), owned(std::move(net.point)));
}

py::tuple surface(Session& session, int level) {
    edit::SurfaceGeometry geometry = take(unlocked([&]() -> Result<edit::SurfaceGeometry> {
        RELIEF_CHECK(session.set_view({.level = level}));
        return session.surface();
    }));
    return py::make_tuple(owned_rows<float>(std::move(geometry.position)),
                          owned(std::move(geometry.index)).attr("reshape")(-1, 3));
}

py::object compress(Session& session, double max_error, const py::object& progress) {
    LongCall call(progress);
    const Progress hook = call.hook();
    const edit::Compression c = call.run([&] { return session.compress(max_error, hook); });
    return open_any(c.file);
}

py::object file_of(const Session& session) {
    return open_any(std::make_shared<MemorySource>(take(unlocked([&] { return session.file(); }))));
}

py::dict history(const Session& session) {
    py::list entries;
    for (const edit::HistoryEntry& entry : session.history().entries) entries.append(entry.text);
    return py::dict("done"_a = session.history().done, "entries"_a = entries);
}

}  // namespace

void define_edit(py::module_& module) {
    py::class_<Session, std::shared_ptr<Session>>(
        module, "EditSession",
        "Editing a file of any kind at any level, by the commands of docs/protocol.md; what the "
        "browser's editor does. Places are in page coordinates: data units from `origin`. Not for "
        "several threads at once.\n\n"
        ">>> import numpy as np, relief\n"
        ">>> flat = relief.encode(np.zeros((33, 33)), max_error=0.01)\n"
        ">>> session = relief.EditSession(flat)\n"
        ">>> change = session.run({'do': 'move', 'level': 3, 'points': [12], 'delta': 5})\n"
        ">>> float(np.asarray(session.file().decode()).max())\n"
        "5.0\n"
        ">>> change = session.run({'do': 'undo'})\n"
        ">>> float(np.asarray(session.file().decode()).max())\n"
        "0.0\n")
        .def(py::init(&create), py::arg("file"))
        .def("run", &run, py::arg("command"),
             "Runs a command: {'do': 'move', 'level': 3, 'points': [12], 'delta': 5}, 'tilt', "
             "'undo', 'redo', 'goto', 'drag' or 'release'.\n\n"
             "Returns how many samples or vertices may differ (`touched`) and the `revision`. "
             "Errors: relief.Error naming the member that is wrong.")
        .def("replay", &replay, py::arg("script"),
             "Runs a list of commands, or {'commands': list}. Errors name the command's number.")
        .def(
            "script", [](const Session& session) { return from_json(session.script().dump()); },
            "The commands in effect: their replay gives the same file.")
        .def_property_readonly(
            "description", &describe,
            "A dict: kind, scheme, levels, origin, min, max, unit, crs, bound, ..")
        .def_property_readonly("history", &history,
                               "A dict: `entries`, of which the first `done` are in effect.")
        .def("at", &at, py::arg("x"), py::arg("y"),
             "Value, gradient and slope (degrees) at page coordinates; None outside.")
        .def("net", &net, py::arg("level"), py::arg("window") = py::none(),
             "(positions (n, 3) float32, points (n,)): control points of a level, or of a window "
             "(row, col, rows, cols) of a raster, and what commands call them.")
        .def("surface", &surface, py::arg("level") = 0,
             "(positions (n, 3) float32, triangles (m, 3)): the edited surface of kinds but "
             "rasters.")
        .def(
            "measure",
            [](const Session& session) {
                const auto m = take(unlocked([&] { return session.measure(); }));
                return py::dict("max_error"_a = m.max_error, "rms_error"_a = m.rms_error,
                                "place"_a = tuple_of(m.place));
            },
            "How far the edited surface is from the original: max_error, rms_error, place.")
        .def("compress", &compress, py::arg("max_error"), py::arg("progress") = py::none(),
             "The edited surface encoded anew within this bound, as an open file.")
        .def("file", &file_of, "The edited file, opened: the original with the moves as a layer.");
}

}  // namespace relief::python
