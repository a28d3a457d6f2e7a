#include "edit/triangle_model.h"

#include <string>

namespace relief::edit {

using mesh::Index;
namespace ps = multires::ps;

namespace {

using Components = TriangleSpline::Components;

/// The splines of all levels of a file, from the finest, and the space of the coarsest.
struct AllSplines {
    std::vector<Components> levels;
    ps::Space base;
};
Result<AllSplines> all_splines(const codec::PsFile& file) {
    AllSplines all;
    for (int level = 0; level <= file.levels(); ++level) {
        RELIEF_TRY(codec::PsSurface surface, file.surface(level));
        all.levels.push_back(std::move(surface.components));
        if (level == file.levels()) all.base = std::move(surface.space);
    }
    return all;
}

/// What a move of a control point is to a file.
std::vector<codec::PsMove> file_moves(const PointMove& move, bool parametric) {
    if (!parametric) return {{move.level, move.point, 0, move.delta.z, move.slope}};
    return {{move.level, move.point, 0, move.delta.x, {}},
            {move.level, move.point, 1, move.delta.y, {}},
            {move.level, move.point, 2, move.delta.z, {}}};
}

}  // namespace

TriangleModel::TriangleModel(std::shared_ptr<const ByteSource> source, codec::PsFile file,
                             std::unique_ptr<ps::Hierarchy> hierarchy,
                             std::vector<Components> original)
    : source_(std::move(source)),
      file_(std::move(file)),
      hierarchy_(std::move(hierarchy)),
      original_(std::move(original)) {
    Levels levels;
    std::vector<const CellMesh*> meshes;
    for (int k = 0; k <= hierarchy_->levels(); ++k) {
        const mesh::Triangulation& mesh = space(k).mesh;
        levels.push_back(std::make_unique<PlaneLevel>(CellMesh(mesh), std::vector<Index>()));
        meshes.push_back(&levels.back()->mesh());
        locators_.emplace_back(mesh);
    }
    auto moves =
        std::make_unique<TriangleMoves>(*hierarchy_, std::move(meshes), shown_components());
    moves_ = moves.get();
    set_up(std::move(levels), std::move(moves), described());
}

Result<std::unique_ptr<Model>> TriangleModel::open(std::shared_ptr<const ByteSource> source) {
    RELIEF_TRY(codec::PsFile file, codec::PsFile::open(source));
    RELIEF_TRY(AllSplines original, all_splines(file));
    RELIEF_TRY(ps::Hierarchy hierarchy,
               ps::Hierarchy::create(std::move(original.base), file.levels()));
    auto kept = std::make_unique<ps::Hierarchy>(std::move(hierarchy));
    return std::unique_ptr<Model>(new TriangleModel(std::move(source), std::move(file),
                                                    std::move(kept), std::move(original.levels)));
}

Result<std::unique_ptr<Model>> open_triangles(std::shared_ptr<const ByteSource> file) {
    return TriangleModel::open(std::move(file));
}

Description TriangleModel::described() const {
    Description d;
    d.kind = Kind::Triangles;
    d.scheme = "powell-sabin";
    for (int level = 0; level <= file_.levels(); ++level) {
        const codec::PsCounts counts = file_.counts(level);
        d.levels.push_back({counts.vertices, counts.triangles, file_.bytes_for(level)});
    }
    d.components = file_.components();
    d.parametric = file_.components() == 3;
    d.bound = file_.bound(0);
    d.bytes = file_.size();
    return d;
}

TriangleSpline TriangleModel::shown(View::Show show, int level) const {
    const auto at = static_cast<std::size_t>(level);
    if (show == View::Show::Compressed && !compressed_.empty())
        return {space(level), shown_components(), compressed_[at], nullptr};
    const bool moved = show != View::Show::Original;
    return {space(level), shown_components(), original_[at],
            moved ? &moves_->added(level) : nullptr};
}

std::unique_ptr<LevelSpline> TriangleModel::spline(View::Show show, int level) const {
    return std::unique_ptr<LevelSpline>(new TriangleSpline(shown(show, level)));
}

std::optional<CellPlace> TriangleModel::locate(int level, Vec2 point, Outside outside) const {
    const mesh::TriangleLocator& locator = locators_[static_cast<std::size_t>(level)];
    const Vec2 place = space(level).mesh.origin + point;
    const Index triangle = locator.locate(place);
    if (triangle != mesh::kNone) return CellPlace{triangle, point};
    if (outside == Outside::None) return std::nullopt;
    const mesh::TrianglePlace nearest = locator.nearest(place);
    return CellPlace{nearest.triangle, nearest.point};
}

std::optional<std::array<Vec3<double>, 3>> TriangleModel::corners(int level, Index vertex) const {
    const TriangleSpline spline = shown(View::Show::Edited, level);
    const mesh::Triangulation& mesh = space(level).mesh;
    std::array<ps::Heights, 3> number{};
    for (std::size_t c = 0; c < spline.components(); ++c) number[c] = spline.heights(c, vertex);
    std::array<Vec3<double>, 3> corner;
    for (std::size_t j = 0; j < 3; ++j) {
        const Vec2 place = mesh.origin + (mesh.vertex(vertex) + space(level).control[vertex][j]);
        corner[j] = spline.components() == 3
                        ? Vec3<double>{number[0][j], number[1][j], number[2][j]}
                        : Vec3<double>{place.x, place.y, number[0][j]};
    }
    return corner;
}

Status TriangleModel::check(const PointMove& move) const {
    const bool parametric = shown_components() == 3;
    if (parametric && !(move.slope == Vec2{}))
        return wrong("control points of a surface in space have no slope; move them");
    if (!parametric && (move.delta.x != 0 || move.delta.y != 0))
        return wrong("control triangles of a function move up and down only; tilt them");
    RELIEF_CHECK(check_sum(move));
    return file_.check(file_moves(move, parametric));
}

Result<Bytes> TriangleModel::file() const {
    std::vector<codec::PsMove> moves;
    for (const PointMove& move : all_moves())
        for (const codec::PsMove& part : file_moves(move, shown_components() == 3))
            moves.push_back(part);
    RELIEF_TRY(Bytes bytes, read_all(*source_));
    return codec::add_ps_moves(std::move(bytes), moves);
}

Result<Compression> TriangleModel::compress(double max_error, const Progress& progress) {
    RELIEF_TRY(Bytes edited, file());
    RELIEF_TRY(const codec::PsFile opened, codec::PsFile::open(std::move(edited)));
    codec::PsModel model{opened.base(), {}, {}};
    if (opened.holds_values() && !opened.edited()) {
        RELIEF_TRY(model.surface, opened.values());
    } else {
        RELIEF_TRY(codec::PsSurface surface, opened.surface(0));
        model.surface = codec::PsSplines{opened.levels(), std::move(surface.components)};
    }
    RELIEF_TRY(const codec::EncodedPs encoded,
               codec::encode_ps(model, {.goal = {codec::Goal::Kind::MaxError, max_error},
                                        .progress = progress}));
    RELIEF_TRY(const codec::PsFile file, codec::PsFile::open(encoded.bytes));
    RELIEF_TRY(AllSplines splines, all_splines(file));
    compressed_ = std::move(splines.levels);
    const codec::PsReport& report = encoded.report;
    return Compression{report.bytes, report.kept, report.coefficients, report.max_error,
                       report.rms_error};
}

}  // namespace relief::edit
