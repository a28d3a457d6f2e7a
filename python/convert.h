#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <array>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "relief/core/grid.h"
#include "relief/core/raster.h"
#include "relief/core/result.h"
#include "relief/core/stream.h"
#include "relief/core/vec2.h"
#include "relief/core/vec3.h"

/// Between Python and the library: errors, arrays, long calls. All functions need the interpreter's
/// lock unless they say otherwise.
namespace relief::python {

namespace py = pybind11;

/// relief.Error, a ValueError with the members code, where and message.
void define_error(py::module_& module);
[[noreturn]] void raise(const Error& error);
[[noreturn]] void raise_argument(const std::string& message);

inline void check(const Status& status) {
    if (!status.ok()) raise(status.error());
}
template <class T>
[[nodiscard]] T take(Result<T> result) {
    if (!result.ok()) raise(result.error());
    if constexpr (!std::is_void_v<T>) return *std::move(result);
}

/// The same error, saying which file it is about.
template <class T>
[[nodiscard]] Result<T> located(Result<T> result, const std::string& path) {
    if (result.ok() || path.empty()) return result;
    Error error = result.error();
    error.where = error.where.empty() ? path : path + ", " + error.where;
    return error;
}

/// Runs without the interpreter's lock.
template <class Function>
auto unlocked(Function&& function) {
    const py::gil_scoped_release release;
    return function();
}

/// A long call that Ctrl-C ends, and that tells a Python function how far it is.
class LongCall {
  public:
    /// progress: None, or called with the fraction done; the call ends when it returns False.
    explicit LongCall(py::object progress) : callback_(std::move(progress)) {}

    /// For the library, which calls it from the thread that runs the call.
    [[nodiscard]] Progress hook() {
        return [this](double done) { return report(done); };
    }

    /// Runs without the lock; raises what Python raised meanwhile, or the error.
    template <class Function>
    auto run(Function&& function) {
        auto result = unlocked(std::forward<Function>(function));
        if (pending_) throw py::error_already_set(std::move(*pending_));
        return take(std::move(result));
    }

  private:
    bool report(double done);

    py::object callback_;
    std::optional<py::error_already_set> pending_;
};

/// The path of a str or os.PathLike.
[[nodiscard]] std::string path_of(const py::handle& path);
/// Whether it is one; arrays and files are not.
[[nodiscard]] bool is_path(const py::handle& object);

template <class T>
using Contiguous = py::array_t<T, py::array::c_style | py::array::forcecast>;

/// Numbers of T, converted if they are others. Errors: ValueError saying `what` they should be.
template <class T>
[[nodiscard]] Contiguous<T> numbers_of(const py::handle& object, const char* what) {
    auto numbers = Contiguous<T>::ensure(object);
    if (!numbers) raise_argument(std::string(what) + " must be numbers");
    return numbers;
}

/// An array that is part of `owner`, which lives at least as long.
template <class T>
[[nodiscard]] py::array view_of(T* data, std::vector<py::ssize_t> shape,
                                std::vector<py::ssize_t> strides, py::handle owner) {
    using Plain = std::remove_const_t<T>;
    py::array array(py::dtype::of<Plain>(), std::move(shape), std::move(strides), data, owner);
    if constexpr (std::is_const_v<T>) array.attr("setflags")(py::arg("write") = false);
    return array;
}
template <class T>
[[nodiscard]] py::array view_of(const GridView<T>& grid, py::handle owner) {
    constexpr auto size = static_cast<py::ssize_t>(sizeof(T));
    return view_of(grid.data, {grid.rows, grid.cols}, {grid.stride * size, size}, owner);
}

/// Gives what it holds to an array, without a copy: `shape` of `width` bytes apart.
template <class T>
[[nodiscard]] py::capsule capsule_of(T object, T*& place) {
    place = new T(std::move(object));
    return py::capsule(place, [](void* held) { delete static_cast<T*>(held); });
}
template <class T>
[[nodiscard]] py::array owned(Grid<T> grid) {
    Grid<T>* place = nullptr;
    const py::capsule owner = capsule_of(std::move(grid), place);
    return view_of(place->view(), owner);
}
template <class T>
[[nodiscard]] py::array owned(std::vector<T> values) {
    std::vector<T>* place = nullptr;
    const py::capsule owner = capsule_of(std::move(values), place);
    const auto count = static_cast<py::ssize_t>(place->size());
    return view_of(place->data(), {count}, {static_cast<py::ssize_t>(sizeof(T))}, owner);
}
/// As (n, width) numbers of type T.
template <class T, class Element>
[[nodiscard]] py::array owned_rows(std::vector<Element> values) {
    static_assert(sizeof(Element) % sizeof(T) == 0);
    std::vector<Element>* place = nullptr;
    const py::capsule owner = capsule_of(std::move(values), place);
    return view_of(reinterpret_cast<T*>(place->data()),
                   {static_cast<py::ssize_t>(place->size()), sizeof(Element) / sizeof(T)},
                   {sizeof(Element), sizeof(T)}, owner);
}

static_assert(sizeof(Vec2) == 2 * sizeof(double) && sizeof(Vec3<float>) == 3 * sizeof(float));

/// The places of an array (.., 2), where they lie. Errors: ValueError for another shape.
[[nodiscard]] std::span<const Vec2> places_of(const Contiguous<double>& places);

/// JSON text to Python objects and back.
[[nodiscard]] py::object from_json(const std::string& text);
[[nodiscard]] std::string to_json(const py::handle& object);

/// (row, col, rows, cols).
using Window = std::array<std::int64_t, 4>;
[[nodiscard]] inline LatticeBox box_of(const Window& w) {
    return {w[0], w[1], w[2], w[3]};
}

/// The raster that a Python object is, to be read in windows: a path, a Raster, or an array (rows,
/// cols) or (bands, rows, cols) of one of the seven sample types, or anything with a shape, a dtype
/// and slices. What is said of it is in `about`.
struct ArrayAbout {
    py::object valid = py::none();  ///< (rows, cols): False where there is a hole
    std::optional<double> nodata = {};
    std::optional<std::array<double, 6>> transform = {};
    std::string crs = {};
    std::string unit = {};
};
class Source {
  public:
    Source(const py::object& object, const ArrayAbout& about);
    [[nodiscard]] const RasterSource& operator*() const { return *source_; }
    [[nodiscard]] const RasterSource* operator->() const { return source_.get(); }
    /// Of the file, for messages; else empty.
    [[nodiscard]] const std::string& path() const { return path_; }

  private:
    py::object kept_;
    std::string path_;
    std::unique_ptr<RasterSource> source_;
};

/// Bytes of a path or of an object with a buffer, which is kept and not copied.
[[nodiscard]] std::shared_ptr<const ByteSource> byte_source(const py::object& object);
/// Of the whole source.
[[nodiscard]] py::bytes bytes_of(const ByteSource& source);
/// Writes a source to a file that appears when it is complete.
void copy_to_file(const ByteSource& source, const std::string& path);

// One for each topic.
void define_rasters(py::module_& module);
void define_files(py::module_& module);
void define_pyramids(py::module_& module);
void define_meshes(py::module_& module);
void define_subdivision(py::module_& module);
void define_scattered(py::module_& module);
void define_edit(py::module_& module);
void define_shards(py::module_& module);
void define_remeshing(py::module_& module);

}  // namespace relief::python
