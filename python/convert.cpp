#include "convert.h"

#include <algorithm>
#include <limits>

#include "relief/io/file.h"

namespace relief::python {

namespace {

PyObject* g_error = nullptr;  ///< relief.Error, which the module keeps

const char* name_of(ErrorCode code) {
    switch (code) {
        case ErrorCode::InvalidArgument:
            return "invalid_argument";
        case ErrorCode::BadInput:
            return "bad_input";
        case ErrorCode::BadFile:
            return "bad_file";
        case ErrorCode::NotFound:
            return "not_found";
        case ErrorCode::CannotWrite:
            return "cannot_write";
        case ErrorCode::Unsupported:
            return "unsupported";
        case ErrorCode::Cancelled:
            return "cancelled";
    }
    return "";
}

/// A Python object with a buffer of bytes. The object may only be touched with the lock.
class BufferSource final : public ByteSource {
  public:
    explicit BufferSource(const py::buffer& buffer) : info_(buffer.request()) {
        if (info_.itemsize * info_.size != 0 && !PyBuffer_IsContiguous(info_.view(), 'C'))
            raise_argument("the bytes of a file must lie one after another");
    }
    ~BufferSource() override {
        const py::gil_scoped_acquire lock;
        info_ = py::buffer_info();
    }
    [[nodiscard]] std::uint64_t size() const override {
        return static_cast<std::uint64_t>(info_.itemsize * info_.size);
    }
    Status read(std::uint64_t offset, std::span<std::uint8_t> into) const override {
        std::copy_n(static_cast<const std::uint8_t*>(info_.ptr) + offset, into.size(), into.data());
        return {};
    }

  private:
    py::buffer_info info_;
};

}  // namespace

void define_error(py::module_& module) {
    g_error = PyErr_NewExceptionWithDoc(
        "relief.Error",
        "What was wrong, where, and what to do.\n\n"
        "code: 'invalid_argument', 'bad_input', 'bad_file', 'not_found', 'cannot_write',\n"
        "'unsupported' or 'cancelled'; where: the file, row, vertex or byte, or ''; message: the "
        "rest.",
        PyExc_ValueError, nullptr);
    if (g_error == nullptr) throw py::error_already_set();
    module.attr("Error") = py::reinterpret_borrow<py::object>(g_error);
}

void raise(const Error& error) {
    const py::object exception = py::reinterpret_borrow<py::object>(g_error)(error.text());
    exception.attr("code") = name_of(error.code);
    exception.attr("where") = error.where;
    exception.attr("message") = error.message;
    PyErr_SetObject(g_error, exception.ptr());
    throw py::error_already_set();
}

void raise_argument(const std::string& message) {
    raise({ErrorCode::InvalidArgument, message, ""});
}

bool LongCall::report(double done) {
    const py::gil_scoped_acquire lock;
    if (pending_) return false;
    try {
        if (PyErr_CheckSignals() != 0) throw py::error_already_set();
        if (callback_.is_none()) return true;
        const py::object answer = callback_(done);
        return answer.is_none() || answer.cast<bool>();
    } catch (py::error_already_set& error) {
        pending_.emplace(std::move(error));
        return false;
    }
}

bool is_path(const py::handle& object) {
    return py::isinstance<py::str>(object) || py::hasattr(object, "__fspath__");
}

std::string path_of(const py::handle& path) {
    return py::module_::import("os").attr("fsdecode")(path).cast<std::string>();
}

std::span<const Vec2> places_of(const Contiguous<double>& places) {
    if (places.ndim() < 1 || places.shape(places.ndim() - 1) != 2)
        raise_argument("places are an array of shape (.., 2): x and y");
    return {reinterpret_cast<const Vec2*>(places.data()),
            static_cast<std::size_t>(places.size() / 2)};
}

py::object from_json(const std::string& text) {
    return py::module_::import("json").attr("loads")(text);
}

std::string to_json(const py::handle& object) {
    return py::module_::import("json").attr("dumps")(object).cast<std::string>();
}

std::shared_ptr<const ByteSource> byte_source(const py::object& object) {
    if (is_path(object)) {
        const std::string path = path_of(object);
        return take(unlocked([&] { return io::open_source(path); }));
    }
    if (!py::isinstance<py::buffer>(object))
        throw py::type_error("a file is a path, or bytes or another object with a buffer");
    return std::make_shared<BufferSource>(py::reinterpret_borrow<py::buffer>(object));
}

py::bytes bytes_of(const ByteSource& source) {
    const auto size = static_cast<std::size_t>(source.size());
    const py::bytes bytes(nullptr, size);
    std::span<std::uint8_t> into{reinterpret_cast<std::uint8_t*>(PyBytes_AS_STRING(bytes.ptr())),
                                 size};
    check(unlocked([&] { return source.read(0, into); }));
    return bytes;
}

void copy_to_file(const ByteSource& source, const std::string& path) {
    constexpr std::uint64_t block = std::uint64_t{1} << 20;
    check(unlocked([&]() -> Status {
        RELIEF_TRY(io::OutputFile out, io::OutputFile::create(path));
        Bytes bytes;
        for (std::uint64_t at = 0; at < source.size(); at += bytes.size()) {
            bytes.resize(static_cast<std::size_t>(std::min(block, source.size() - at)));
            RELIEF_CHECK(source.read(at, bytes));
            RELIEF_CHECK(out.write(bytes));
        }
        return out.commit();
    }));
}

}  // namespace relief::python
