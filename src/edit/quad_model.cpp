#include "edit/quad_model.h"

#include <string>

#include "edit/quad_spline.h"

namespace relief::edit {

using mesh::Index;
namespace fvs_mesh = multires::fvs_mesh;

namespace {

codec::QuadMove file_move(const PointMove& move) {
    return {move.level, move.point, move.delta.z};
}

}  // namespace

QuadModel::QuadModel(std::shared_ptr<const ByteSource> source, codec::QuadFile file,
                     std::unique_ptr<Hierarchy> hierarchy, std::vector<Data> original,
                     std::vector<Index> numbers)
    : source_(std::move(source)),
      file_(std::move(file)),
      hierarchy_(std::move(hierarchy)),
      original_(std::move(original)) {
    Levels levels;
    std::vector<const CellMesh*> meshes;
    for (int level = 0; level <= hierarchy_->levels(); ++level) {
        levels.push_back(
            std::make_unique<PlaneLevel>(CellMesh(hierarchy_->mesh(refined(level))),
                                         level == 0 ? std::move(numbers) : std::vector<Index>()));
        meshes.push_back(&levels.back()->mesh());
    }
    auto moves = std::make_unique<QuadMoves>(*hierarchy_, std::move(meshes));
    moves_ = moves.get();
    set_up(std::move(levels), std::move(moves), described());
}

Result<std::unique_ptr<Model>> QuadModel::open(std::shared_ptr<const ByteSource> source) {
    RELIEF_TRY(codec::QuadFile file, codec::QuadFile::open(source));
    RELIEF_TRY(codec::QuadSurface finest, file.surface(0));
    RELIEF_TRY(std::vector<Index> numbers, file.vertex_numbers(0));
    std::vector<Data> original;
    original.push_back(std::move(finest.data));
    for (int level = 1; level <= file.levels(); ++level) {
        RELIEF_TRY(codec::QuadSurface surface, file.surface(level));
        original.push_back(std::move(surface.data));
    }
    auto hierarchy = std::make_unique<Hierarchy>(std::move(finest.hierarchy));
    return std::unique_ptr<Model>(new QuadModel(std::move(source), std::move(file),
                                                std::move(hierarchy), std::move(original),
                                                std::move(numbers)));
}

Result<std::unique_ptr<Model>> open_quads(std::shared_ptr<const ByteSource> file) {
    return QuadModel::open(std::move(file));
}

Description QuadModel::described() const {
    Description d;
    d.kind = Kind::Quads;
    d.scheme = "fvs";
    for (int level = 0; level <= file_.levels(); ++level) {
        const mesh::LevelCounts counts = file_.counts(level);
        d.levels.push_back({counts.vertices, counts.quads, file_.bytes_for(level)});
    }
    d.bound = file_.bound(0);
    d.bytes = file_.size();
    return d;
}

std::unique_ptr<LevelSpline> QuadModel::spline(View::Show show, int level) const {
    const mesh::Quadrangulation& mesh = hierarchy_->mesh(refined(level));
    const auto at = static_cast<std::size_t>(level);
    if (show == View::Show::Compressed && !compressed_.empty())
        return std::make_unique<QuadSpline>(mesh, compressed_[at], nullptr);
    const Data* added = show == View::Show::Original ? nullptr : &moves_->added(level);
    return std::make_unique<QuadSpline>(mesh, original_[at], added);
}

std::optional<CellPlace> QuadModel::locate(int level, Vec2 point, Outside outside) const {
    const auto place = fvs_mesh::locate(
        *hierarchy_, refined(level), hierarchy_->mesh(0).origin + point,
        outside == Outside::Nearest ? fvs_mesh::Outside::Clamp : fvs_mesh::Outside::Reject);
    if (!place) return std::nullopt;
    return CellPlace{place->quad, place->point};
}

Status QuadModel::check(const PointMove& move) const {
    if (!(move.slope == Vec2{})) return wrong("control points of quads have no slope; move them");
    if (move.delta.x != 0 || move.delta.y != 0)
        return wrong("control points of quads move up and down only");
    RELIEF_CHECK(check_sum(move));
    return file_.check({file_move(move)});
}

Result<Bytes> QuadModel::file() const {
    std::vector<codec::QuadMove> moves;
    for (const PointMove& move : all_moves()) moves.push_back(file_move(move));
    RELIEF_TRY(Bytes bytes, read_all(*source_));
    return codec::add_quad_moves(std::move(bytes), moves);
}

Result<Compression> QuadModel::compress(double max_error, const Progress& /*progress*/) {
    RELIEF_TRY(Bytes edited, file());
    RELIEF_TRY(const codec::QuadFile opened, codec::QuadFile::open(std::move(edited)));
    RELIEF_TRY(const codec::QuadMesh mesh, opened.decode(0));
    RELIEF_TRY(const codec::EncodedQuads encoded,
               codec::encode_quads(mesh, {.goal = {codec::Goal::Kind::MaxError, max_error},
                                          .levels = file_.levels()}));
    RELIEF_TRY(const codec::QuadFile file, codec::QuadFile::open(encoded.bytes));
    std::vector<Data> levels;
    for (int level = 0; level <= file.levels(); ++level) {
        RELIEF_TRY(codec::QuadSurface surface, file.surface(level));
        levels.push_back(std::move(surface.data));
    }
    compressed_ = std::move(levels);
    const codec::QuadReport& report = encoded.report;
    return Compression{report.bytes, report.kept, report.coefficients, report.max_error,
                       report.rms_error};
}

}  // namespace relief::edit
