#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "convert.h"
#include "relief/codec/raster_codec.h"
#include "relief/io/file.h"
#include "relief/io/file_kind.h"
#include "relief/io/raster.h"

/// Python objects as rasters that the library reads in windows.
namespace relief::python {

namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

SampleType type_of(const py::dtype& dtype) {
    const auto type = sample_type_from_name(py::str(dtype.attr("name")).cast<std::string>());
    if (!type.ok()) raise(type.error());
    return *type;
}

/// out[k] = the k-th of n samples `step` bytes apart.
template <class T>
void widen(const std::byte* samples, std::ptrdiff_t step, std::int64_t n, double* out) {
    for (std::int64_t k = 0; k < n; ++k) {
        T sample;
        std::memcpy(&sample, samples + k * step, sizeof(T));
        out[k] = static_cast<double>(sample);
    }
}

void widen(SampleType type, const std::byte* samples, std::ptrdiff_t step, std::int64_t n,
           double* out) {
    switch (type) {
        case SampleType::UInt8:
            return widen<std::uint8_t>(samples, step, n, out);
        case SampleType::UInt16:
            return widen<std::uint16_t>(samples, step, n, out);
        case SampleType::Int16:
            return widen<std::int16_t>(samples, step, n, out);
        case SampleType::UInt32:
            return widen<std::uint32_t>(samples, step, n, out);
        case SampleType::Int32:
            return widen<std::int32_t>(samples, step, n, out);
        case SampleType::Float32:
            return widen<float>(samples, step, n, out);
        case SampleType::Float64:
            return widen<double>(samples, step, n, out);
    }
}

/// Samples in the memory of an array, one plane behind the other.
struct Samples {
    const std::byte* first = nullptr;
    std::ptrdiff_t plane = 0, row = 0, col = 0;  ///< steps in bytes
    SampleType type = SampleType::Float64;

    explicit Samples(const py::array& array) : type(type_of(array.dtype())) {
        if (!array.dtype().attr("isnative").cast<bool>())
            raise_argument("the samples are not in the byte order of this machine: use astype");
        first = static_cast<const std::byte*>(array.data());
        const py::ssize_t axes = array.ndim();
        plane = axes == 3 ? array.strides(0) : 0;
        row = array.strides(axes - 2);
        col = array.strides(axes - 1);
    }
    [[nodiscard]] const std::byte* at(std::int64_t p, std::int64_t r, std::int64_t c) const {
        return first + p * plane + r * row + c * col;
    }
    /// Doubles that the library can read where they are.
    [[nodiscard]] bool in_place() const {
        constexpr std::ptrdiff_t size = sizeof(double);
        return type == SampleType::Float64 && col == size && row % size == 0 &&
               reinterpret_cast<std::uintptr_t>(first) % alignof(double) == 0 && plane % size == 0;
    }
};

/// What marks holes in a window: a mask, the NODATA value, numbers that are not finite.
class Holes {
  public:
    Holes(const py::object& valid, std::int64_t rows, std::int64_t cols,
          std::optional<double> nodata)
        : nodata_(nodata) {
        if (valid.is_none()) return;
        valid_ = py::array_t<bool>::ensure(valid);
        if (!valid_ || valid_.ndim() != 2 || valid_.shape(0) != rows || valid_.shape(1) != cols)
            raise_argument("valid must be an array of bool of the shape (rows, cols)");
        mask_ = reinterpret_cast<const std::byte*>(valid_.data());
        row_ = valid_.strides(0);
        col_ = valid_.strides(1);
    }

    /// Whether a sample is one, which lies at (row, col) of the raster.
    [[nodiscard]] bool operator()(double sample, std::int64_t row, std::int64_t col) const {
        return !std::isfinite(sample) || sample == nodata_ ||
               (mask_ != nullptr && mask_[row * row_ + col * col_] == std::byte{0});
    }

    /// Marks the holes of a window in its mask and planes; without any there is no mask.
    void mark(const LatticeBox& window, Raster& part) const {
        Grid<std::uint8_t> mask(window.rows, window.cols, 1);
        bool any = false;
        for (const Grid<double>& plane : part.planes)
            for (std::int64_t r = 0; r < window.rows; ++r)
                for (std::int64_t c = 0; c < window.cols; ++c)
                    if ((*this)(plane(r, c), window.row0 + r, window.col0 + c)) {
                        mask(r, c) = 0;
                        any = true;
                    }
        if (!any) return;
        for (Grid<double>& plane : part.planes)
            for (std::int64_t r = 0; r < window.rows; ++r)
                for (std::int64_t c = 0; c < window.cols; ++c)
                    if (mask(r, c) == 0) plane(r, c) = kNan;
        part.mask = std::move(mask);
    }

  private:
    py::array_t<bool> valid_;
    const std::byte* mask_ = nullptr;
    std::ptrdiff_t row_ = 0, col_ = 0;
    std::optional<double> nodata_;
};

Raster describe(const py::tuple& shape, SampleType type, const ArrayAbout& about) {
    if (shape.size() != 2 && shape.size() != 3)
        raise_argument("a raster has the shape (rows, cols) or (bands, rows, cols)");
    Raster raster;
    raster.rows = shape[shape.size() - 2].cast<std::int64_t>();
    raster.cols = shape[shape.size() - 1].cast<std::int64_t>();
    raster.type = type;
    raster.nodata = about.nodata;
    raster.geo.transform = about.transform;
    raster.geo.crs = about.crs;
    raster.unit = about.unit;
    return raster;
}

/// An array in memory. Needs no lock while it is read.
class ArraySource final : public RasterSource {
  public:
    ArraySource(const py::array& array, const ArrayAbout& about)
        : samples_(array),
          components_(array.ndim() == 3 ? static_cast<int>(array.shape(0)) : 1),
          description_(describe(array.attr("shape"), samples_.type, about)),
          holes_(about.valid, description_.rows, description_.cols, about.nodata) {}

    [[nodiscard]] const Raster& description() const override { return description_; }
    [[nodiscard]] int components() const override { return components_; }

    [[nodiscard]] Result<Raster> read(const LatticeBox& window) const override {
        Raster part;
        part.rows = window.rows;
        part.cols = window.cols;
        for (int p = 0; p < components_; ++p) {
            Grid<double> plane(window.rows, window.cols);
            for (std::int64_t r = 0; r < window.rows; ++r)
                widen(samples_.type, samples_.at(p, window.row0 + r, window.col0), samples_.col,
                      window.cols, plane.row(r));
            part.planes.push_back(std::move(plane));
        }
        holes_.mark(window, part);
        return part;
    }

    [[nodiscard]] Result<RasterView> view(const LatticeBox& window, Raster& room) const override {
        if (!samples_.in_place() || has_hole(window)) return RasterSource::view(window, room);
        RasterView view{.rows = window.rows, .cols = window.cols};
        for (int p = 0; p < components_; ++p)
            view.planes.emplace_back(sample(p, window.row0, window.col0), window.rows, window.cols,
                                     samples_.row / std::ptrdiff_t{sizeof(double)});
        return view;
    }

  private:
    [[nodiscard]] const double* sample(int p, std::int64_t row, std::int64_t col) const {
        return reinterpret_cast<const double*>(samples_.at(p, row, col));
    }
    [[nodiscard]] bool has_hole(const LatticeBox& window) const {
        for (int p = 0; p < components_; ++p)
            for (std::int64_t r = window.row0; r < window.row0 + window.rows; ++r) {
                const double* row = sample(p, r, 0);
                for (std::int64_t c = window.col0; c < window.col0 + window.cols; ++c)
                    if (holes_(row[c], r, c)) return true;
            }
        return false;
    }

    Samples samples_;
    int components_;
    Raster description_;
    Holes holes_;
};

/// An object that gives windows as arrays when it is sliced: from files, or computed.
class SlicedSource final : public RasterSource {
  public:
    SlicedSource(py::object object, const ArrayAbout& about)
        : object_(std::move(object)),
          components_(py::len(object_.attr("shape")) == 3
                          ? object_.attr("shape").cast<py::tuple>()[0].cast<int>()
                          : 1),
          description_(describe(object_.attr("shape"),
                                type_of(py::dtype::from_args(object_.attr("dtype"))), about)),
          holes_(about.valid, description_.rows, description_.cols, about.nodata) {}

    [[nodiscard]] const Raster& description() const override { return description_; }
    [[nodiscard]] int components() const override { return components_; }

    [[nodiscard]] Result<Raster> read(const LatticeBox& window) const override {
        const py::gil_scoped_acquire lock;
        try {
            return slice(window);
        } catch (const py::error_already_set& error) {
            return Error{ErrorCode::BadInput, error.what(),
                         "rows from " + std::to_string(window.row0) + ", columns from " +
                             std::to_string(window.col0)};
        }
    }

  private:
    [[nodiscard]] Raster slice(const LatticeBox& window) const {
        const auto range = [](std::int64_t first, std::int64_t count) {
            return py::slice(first, first + count, 1);
        };
        const py::slice rows = range(window.row0, window.rows);
        const py::slice cols = range(window.col0, window.cols);
        const bool planes = py::len(object_.attr("shape")) == 3;
        const py::object part = planes ? object_[py::make_tuple(py::ellipsis(), rows, cols)]
                                       : object_[py::make_tuple(rows, cols)];
        const py::array array = py::module_::import("numpy").attr("asarray")(part);
        const bool fits = array.ndim() == (planes ? 3 : 2) &&
                          (!planes || array.shape(0) == components_) &&
                          array.shape(array.ndim() - 2) == window.rows &&
                          array.shape(array.ndim() - 1) == window.cols;
        if (!fits || type_of(array.dtype()) != description_.type)
            raise_argument("a slice of the raster has another shape or dtype than it says");
        Raster raster = *ArraySource(array, {}).read({0, 0, window.rows, window.cols});
        raster.mask = {};
        holes_.mark(window, raster);
        return raster;
    }

    py::object object_;
    int components_;
    Raster description_;
    Holes holes_;
};

/// A raster that belongs to its source.
class OwnedRaster final : public RasterSource {
  public:
    explicit OwnedRaster(Raster raster) : raster_(std::move(raster)), memory_(raster_) {}
    [[nodiscard]] const Raster& description() const override { return memory_.description(); }
    [[nodiscard]] int components() const override { return memory_.components(); }
    [[nodiscard]] Result<Raster> read(const LatticeBox& window) const override {
        return memory_.read(window);
    }
    [[nodiscard]] Result<RasterView> view(const LatticeBox& window, Raster& room) const override {
        return memory_.view(window, room);
    }

  private:
    Raster raster_;
    MemoryRaster memory_;
};

using SourcePointer = std::unique_ptr<RasterSource>;

Result<SourcePointer> open_raster(const std::string& path) {
    if (io::recognise(path) != io::FileKind::Relief) {
        RELIEF_TRY(io::RasterReader reader, io::RasterReader::open(path));
        return SourcePointer(std::make_unique<io::RasterReader>(std::move(reader)));
    }
    RELIEF_TRY(auto bytes, io::open_source(path));
    RELIEF_TRY(const auto file, located(codec::RasterFile::open(std::move(bytes)), path));
    RELIEF_TRY(Raster raster, located(file.decode(0), path));
    return SourcePointer(std::make_unique<OwnedRaster>(std::move(raster)));
}

/// The mask of a masked array, which is True in holes, unless another one is given.
ArrayAbout with_mask_of(const py::object& array, ArrayAbout about) {
    const py::object masked = py::module_::import("numpy").attr("ma");
    if (!about.valid.is_none() || !py::isinstance(array, masked.attr("MaskedArray"))) return about;
    py::object holes = masked.attr("getmaskarray")(array);
    if (holes.attr("ndim").cast<int>() == 3) holes = holes.attr("any")(py::arg("axis") = 0);
    about.valid = holes.attr("__invert__")();
    return about;
}

}  // namespace

Source::Source(const py::object& object, const ArrayAbout& about) : kept_(object) {
    if (is_path(object)) {
        path_ = path_of(object);
        source_ = take(unlocked([&] { return open_raster(path_); }));
    } else if (py::isinstance<Raster>(object)) {
        source_ = std::make_unique<MemoryRaster>(object.cast<const Raster&>());
    } else if (py::isinstance<py::array>(object)) {
        const auto array = py::reinterpret_borrow<py::array>(object);
        if (array.ndim() != 2 && array.ndim() != 3)
            raise_argument("a raster has the shape (rows, cols) or (bands, rows, cols)");
        source_ = std::make_unique<ArraySource>(array, with_mask_of(object, about));
    } else if (py::hasattr(object, "shape") && py::hasattr(object, "dtype")) {
        source_ = std::make_unique<SlicedSource>(object, about);
    } else {
        throw py::type_error("a raster is a path, a relief.Raster, or an array");
    }
}

}  // namespace relief::python
