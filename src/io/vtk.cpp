#include "relief/io/vtk.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>

#include "io/mesh_formats.h"
#include "relief/io/file.h"

namespace relief::io {

namespace {

constexpr std::uint8_t kBezierTriangle = 76;

Status check(const BezierTriangles& triangles) {
    for (std::size_t k = 0; k < triangles.points.size(); ++k)
        for (const double t : triangles.points[k])
            if (!std::isfinite(t))
                return Error{ErrorCode::BadInput,
                             "non_finite_vertex: a coordinate is not finite; correct it",
                             fmt::format("point {}", k)};
    for (std::size_t k = 0; k < triangles.cells.size(); ++k)
        for (const std::uint32_t p : triangles.cells[k])
            if (p >= triangles.points.size())
                return Error{ErrorCode::BadInput,
                             fmt::format("index_out_of_range: it names point {} of {}", p,
                                         triangles.points.size()),
                             fmt::format("cell {}", k)};
    for (const VtkField& field : triangles.fields)
        if (field.components < 1 ||
            field.values.size() !=
                triangles.points.size() * static_cast<std::size_t>(field.components))
            return Error{
                ErrorCode::InvalidArgument,
                fmt::format("it has {} values of {} components for {} points", field.values.size(),
                            field.components, triangles.points.size()),
                fmt::format("field '{}'", field.name)};
    return {};
}

std::string escaped(const std::string& text) {
    std::string result;
    for (const char c : text) {
        if (c == '&' || c == '<' || c == '>' || c == '"') {
            fmt::format_to(std::back_inserter(result), "&#{};", static_cast<int>(c));
        } else {
            result += c;
        }
    }
    return result;
}

/// Names arrays at their places among the appended bytes: each stands after its size in 8 bytes.
class ArrayTags {
  public:
    std::string tag(std::string_view type, const std::string& name, int components,
                    std::size_t bytes) {
        std::string text = fmt::format(
            "<DataArray type=\"{}\" Name=\"{}\" NumberOfComponents=\"{}\" format=\"appended\" "
            "offset=\"{}\"/>\n",
            type, escaped(name), components, offset_);
        offset_ += sizeof(std::uint64_t) + bytes;
        return text;
    }

  private:
    std::uint64_t offset_ = 0;
};

std::string head_of(const BezierTriangles& triangles) {
    const std::size_t points = triangles.points.size();
    const std::size_t cells = triangles.cells.size();
    ArrayTags tags;
    std::string text = fmt::format(
        "<?xml version=\"1.0\"?>\n"
        "<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" "
        "header_type=\"UInt64\">\n<UnstructuredGrid>\n"
        "<Piece NumberOfPoints=\"{}\" NumberOfCells=\"{}\">\n<Points>\n",
        points, cells);
    text += tags.tag("Float64", "Points", 3, points * 3 * sizeof(double));
    text += "</Points>\n<Cells>\n";
    text += tags.tag("Int64", "connectivity", 1, cells * 6 * sizeof(std::int64_t));
    text += tags.tag("Int64", "offsets", 1, cells * sizeof(std::int64_t));
    text += tags.tag("UInt8", "types", 1, cells);
    text += "</Cells>\n<PointData>\n";
    for (const VtkField& field : triangles.fields)
        text +=
            tags.tag("Float64", field.name, field.components, field.values.size() * sizeof(double));
    text += "</PointData>\n</Piece>\n</UnstructuredGrid>\n<AppendedData encoding=\"raw\">\n_";
    return text;
}

/// Collects bytes and passes them on in pieces.
class Output {
  public:
    explicit Output(OutputFile& file) : file_(file) {}

    Status add(std::string_view text) {
        bytes_ += text;
        return flush();
    }

    /// An array after its size. each(add) calls add(number) for all its `count` numbers.
    template <class Number, class Each>
    Status add_array(std::size_t count, Each&& each) {
        detail::append_little_endian(bytes_, std::uint64_t{count * sizeof(Number)});
        Status written;
        each([&](Number number) {
            if (!written.ok()) return;
            detail::append_little_endian(bytes_, number);
            if (bytes_.size() >= kPiece) written = flush();
        });
        return written;
    }

    Status flush() {
        Status written =
            file_.write({reinterpret_cast<const std::uint8_t*>(bytes_.data()), bytes_.size()});
        bytes_.clear();
        return written;
    }

  private:
    static constexpr std::size_t kPiece = std::size_t{1} << 20;

    OutputFile& file_;
    std::string bytes_;
};

Status add_arrays(const BezierTriangles& triangles, Output& output) {
    const auto& [points, cells, fields] = triangles;
    RELIEF_CHECK(output.add_array<double>(3 * points.size(), [&points = points](auto add) {
        for (const auto& point : points) std::for_each(point.begin(), point.end(), add);
    }));
    RELIEF_CHECK(output.add_array<std::int64_t>(6 * cells.size(), [&cells = cells](auto add) {
        for (const auto& cell : cells) std::for_each(cell.begin(), cell.end(), add);
    }));
    RELIEF_CHECK(output.add_array<std::int64_t>(cells.size(), [&cells = cells](auto add) {
        for (std::size_t k = 1; k <= cells.size(); ++k) add(static_cast<std::int64_t>(6 * k));
    }));
    RELIEF_CHECK(output.add_array<std::uint8_t>(cells.size(), [&cells = cells](auto add) {
        for (std::size_t k = 0; k < cells.size(); ++k) add(kBezierTriangle);
    }));
    for (const VtkField& field : fields) {
        RELIEF_CHECK(output.add_array<double>(field.values.size(), [&field](auto add) {
            std::for_each(field.values.begin(), field.values.end(), add);
        }));
    }
    return {};
}

}  // namespace

Status write_vtu(const std::string& path, const BezierTriangles& triangles) {
    if (const Status valid = check(triangles); !valid.ok()) {
        Error error = valid.error();
        error.where = path + ", " + error.where;
        return error;
    }
    RELIEF_TRY(OutputFile file, OutputFile::create(path));
    Output output(file);
    RELIEF_CHECK(output.add(head_of(triangles)));
    RELIEF_CHECK(add_arrays(triangles, output));
    RELIEF_CHECK(output.add("\n</AppendedData>\n</VTKFile>\n"));
    return file.commit();
}

}  // namespace relief::io
