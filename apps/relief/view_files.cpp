#include "view_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>

#include "command.h"
#include "mesh_verbs.h"
#include "ps_verbs.h"
#include "quad_verbs.h"
#include "relief/codec/container.h"
#include "relief/codec/point_codec.h"
#include "relief/io/file.h"
#include "relief/io/file_kind.h"
#include "relief/io/mesh.h"
#include "relief/io/points.h"
#include "relief/io/raster.h"
#include "relief/remesh/remesh.h"

namespace relief::cli {

namespace {

using editor::Document;

constexpr codec::Goal kLossless{codec::Goal::Kind::Lossless, 0};
/// Edges of machine parts that turn by more degrees are sharp.
constexpr double kFeatures = 40;
/// A mesh of more vertices is nothing that other programs can show.
constexpr std::int64_t kLargestMesh = std::int64_t{1} << 24;

Result<Bytes> raster_bytes(const std::string& path, const Progress& progress) {
    RELIEF_TRY(const io::RasterReader reader, io::RasterReader::open(path));
    MemorySink sink;
    MemorySpool spool;
    const auto report = codec::encode_raster(
        reader, {.goal = kLossless, .profile = codec::Profile::Fast, .progress = progress}, sink,
        spool);
    if (!report.ok()) return located(report.error(), path);
    return sink.take();
}

bool has_no_levels(const Error& error) {
    return error.message.starts_with("no_subdivision_connectivity");
}

/// Meshes are edited at levels of subdivision: one without any is shown by a mesh of its shape that
/// has them.
Result<PolygonMesh> remeshed(const PolygonMesh& mesh, const std::string& path,
                             const Progress& progress, std::vector<std::string>& notices) {
    auto result = remesh::remesh(mesh, {.progress = progress});
    // What is no scan may be a machine part.
    if (!result.ok() && result.error().message.starts_with("tolerance_not_met"))
        result = remesh::remesh(mesh, {.feature_degrees = kFeatures, .progress = progress});
    if (!result.ok()) {
        Error error = result.error();
        error.message =
            "it is no subdivision of a coarser mesh. 'relief subdivide' makes one of a control "
            "mesh, 'relief remesh' one of nearly the same shape, but without options it failed: " +
            error.message;
        return located(std::move(error), path);
    }
    const remesh::RemeshReport& report = result->report;
    notices.push_back(fmt::format(
        "{} is no subdivision of a coarser mesh. Shown is one of the same shape: {} faces in {} "
        "levels over {}; the surfaces are {} of the diagonal apart (RMS), at most {}",
        std::filesystem::path(path).filename().string(), grouped(result->mesh.polygon_count()),
        report.levels, grouped(report.base_faces), shown(report.rms_error / report.diagonal),
        shown(report.max_error / report.diagonal)));
    return std::move(result->mesh);
}

Result<Bytes> mesh_bytes(const std::string& path, const Progress& progress,
                         std::vector<std::string>& notices) {
    RELIEF_TRY(const bool subdivision, is_subdivision(path, {}));
    if (!subdivision) {
        RELIEF_TRY(const codec::QuadMesh mesh, read_quads(path));
        auto encoded = codec::encode_quads(mesh, {});
        if (!encoded.ok()) return located(encoded.error(), path);
        return std::move(encoded->bytes);
    }
    RELIEF_TRY(PolygonMesh mesh, read_polygons(path));
    const codec::MeshEncodeOptions options{.goal = kLossless, .progress = progress};
    auto encoded = codec::encode_mesh(mesh, options);
    if (!encoded.ok() && has_no_levels(encoded.error())) {
        RELIEF_TRY(mesh, remeshed(mesh, path, progress, notices));
        encoded = codec::encode_mesh(mesh, options);
    }
    if (!encoded.ok()) return located(encoded.error(), path);
    if (encoded->report.lost_creases > 0)
        notices.push_back(
            fmt::format("{} sharp edges are no part of sharp edges of the coarser "
                        "meshes; they stay sharp at the finest level only",
                        encoded->report.lost_creases));
    return std::move(encoded->bytes);
}

Result<Bytes> point_bytes(const std::string& path, const Progress& progress,
                          std::vector<std::string>& notices) {
    RELIEF_TRY(io::PointSet points, io::read_points(path));
    const codec::PsData data{std::move(points.places), std::move(points.values),
                             std::move(points.weights)};
    auto encoded = codec::encode_points(data, codec::Interpolation{}, {}, progress);
    if (!encoded.ok()) return located(encoded.error(), path);
    if (encoded->merged > 0)
        notices.push_back(fmt::format(
            "{} points lie where others do: the surface passes through the mean", encoded->merged));
    return std::move(encoded->bytes);
}

Result<std::shared_ptr<const ByteSource>> relief_of(const std::string& path,
                                                    const Progress& progress,
                                                    std::vector<std::string>& notices) {
    const io::FileKind kind = io::recognise(path);
    if (kind == io::FileKind::Relief) return io::open_source(path);
    auto bytes = kind == io::FileKind::Mesh     ? mesh_bytes(path, progress, notices)
                 : kind == io::FileKind::Points ? point_bytes(path, progress, notices)
                                                : raster_bytes(path, progress);
    if (!bytes.ok()) return bytes.error();
    return std::shared_ptr<const ByteSource>(std::make_shared<MemorySource>(*std::move(bytes)));
}

bool holds_raster(const std::shared_ptr<const ByteSource>& relief) {
    const auto content = codec::content_of(relief);
    return content.ok() && *content == "raster";
}

/// Sizes of samples in the unit of the heights; none without a CRS.
std::optional<std::array<double, 2>> spacing_of(const Raster& about) {
    const auto cell = io::cell_size_in_unit(about);
    if (!cell) return {};
    return std::array{cell->x, cell->y};
}

/// Where sample (row, col) of a raster lies, in one unit with its heights.
class Ground {
  public:
    explicit Ground(const Raster& about) {
        if (about.geo.transform) transform_ = *about.geo.transform;
        const auto spacing = spacing_of(about);
        if (!spacing) return;
        const double x = std::hypot(transform_[1], transform_[4]);
        const double y = std::hypot(transform_[2], transform_[5]);
        constexpr double tolerance = 1e-9;  // a cell's size is computed from the transform
        if (std::abs((*spacing)[0] - x) > tolerance * x ||
            std::abs((*spacing)[1] - y) > tolerance * y)
            transform_ = {0, (*spacing)[0], 0, 0, 0, -(*spacing)[1]};
    }
    [[nodiscard]] std::array<double, 2> at(std::int64_t row, std::int64_t col) const {
        const double r = static_cast<double>(row) + 0.5;
        const double c = static_cast<double>(col) + 0.5;
        const auto& t = transform_;
        return {t[0] + t[1] * c + t[2] * r, t[3] + t[4] * c + t[5] * r};
    }

  private:
    std::array<double, 6> transform_ = {0, 1, 0, 0, 0, -1};
};

/// A vertex for each valid sample, a quad for four of them around a cell; three planes are x, y, z.
Result<PolygonMesh> mesh_of(const Raster& raster) {
    if (raster.rows * raster.cols > kLargestMesh)
        return Error{ErrorCode::InvalidArgument,
                     fmt::format("{} x {} samples are too many for a mesh; show a coarser level",
                                 raster.cols, raster.rows),
                     ""};
    const Ground ground(raster);
    const bool parametric = raster.planes.size() == 3;
    PolygonMesh mesh;
    Grid<std::int32_t> vertex(raster.rows, raster.cols, -1);
    for (std::int64_t r = 0; r < raster.rows; ++r)
        for (std::int64_t c = 0; c < raster.cols; ++c) {
            if (!raster.valid(r, c)) continue;
            vertex(r, c) = static_cast<std::int32_t>(mesh.vertices.size());
            const auto [x, y] = ground.at(r, c);
            const auto& planes = raster.planes;
            mesh.vertices.push_back(
                parametric ? std::array{planes[0](r, c), planes[1](r, c), planes[2](r, c)}
                           : std::array{x, y, planes[0](r, c)});
        }
    for (std::int64_t r = 0; r + 1 < raster.rows; ++r)
        for (std::int64_t c = 0; c + 1 < raster.cols; ++c) {
            const std::array quad = {vertex(r + 1, c), vertex(r + 1, c + 1), vertex(r, c + 1),
                                     vertex(r, c)};
            if (*std::min_element(quad.begin(), quad.end()) >= 0) mesh.add_polygon(quad);
        }
    return mesh;
}

Status export_raster(const std::string& relief, int level, const std::string& out) {
    RELIEF_TRY(const codec::RasterFile file, open_relief(relief));
    RELIEF_TRY(const Raster raster, file.decode(level));
    if (!io::names_mesh(out)) return io::write_raster(out, raster);
    RELIEF_TRY(const PolygonMesh mesh, mesh_of(raster));
    const auto written =
        io::write_mesh(out, mesh, {.up = raster.planes.size() == 3 ? io::Up::Y : io::Up::Z});
    return written.ok() ? Status() : written.error();
}

}  // namespace

Result<Document> open_document(const std::string& path, const Progress& progress) {
    Document document;
    document.name = std::filesystem::path(path).filename().string();
    RELIEF_TRY(document.file, relief_of(path, progress, document.notices));
    if (!holds_raster(document.file)) return document;
    const auto file = codec::RasterFile::open(document.file);
    if (!file.ok()) return located(file.error(), path);
    document.terrain = description_of(file->description());
    document.options.spacing = spacing_of(*document.terrain);
    return document;
}

Result<Document> open_dropped(const std::string& path, const Progress& progress) {
    if (io::recognise(path) == io::FileKind::Raster && !io::is_self_contained(path))
        return Error{ErrorCode::BadInput,
                     "is of a format whose files can refer to others; open it with 'relief view'",
                     std::filesystem::path(path).filename().string()};
    return open_document(path, progress);
}

Status export_level(const std::string& relief, int level, const std::string& out) {
    const auto status = [](const Result<Outcome>& outcome) {
        return outcome.ok() ? Status() : outcome.error();
    };
    if (holds_mesh(relief)) return status(decode_mesh(relief, out, level, {}));
    if (holds_quads(relief)) return status(decode_quads(relief, out, level, {}));
    if (holds_ps(relief))
        return status(decode_ps({relief, out, level, {}, {}, 1, {}}, {.quiet = true}));
    return export_raster(relief, level, out);
}

}  // namespace relief::cli
