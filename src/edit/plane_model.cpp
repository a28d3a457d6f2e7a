#include "edit/plane_model.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "edit/plane_graph.h"
#include "relief/core/parallel.h"

namespace relief::edit {

using mesh::Index;
using spline::PlaneJet;

namespace {

/// Nets of more points are not sent.
constexpr std::size_t kWholeNet = 65536;
/// Far below what files refuse, so that what splines make of it is kept, too.
constexpr double kLargest = 1e100;
constexpr std::int64_t kGrain = 256;
}  // namespace

PlaneLevel::PlaneLevel(CellMesh mesh, std::vector<Index> number)
    : mesh_(std::move(mesh)), grid_(mesh_), number_(std::move(number)), vertex_(number_.size()) {
    for (std::size_t v = 0; v < number_.size(); ++v) vertex_[number_[v]] = static_cast<Index>(v);
}

void PlaneModel::set_up(Levels levels, std::unique_ptr<PlaneMoves> moves, Description description) {
    levels_ = std::move(levels);
    moves_ = std::move(moves);
    description_ = std::move(description);
    frame_.parametric = description_.parametric;
    const CellMesh& mesh = level(0).mesh();
    const auto original = spline(View::Show::Original, 0);
    std::vector<PlaneJet> jets(original->components());
    bounds_ = kNothing;
    for (Index v = 0; v < mesh.vertices.size(); ++v) {
        original->at_vertex(v, jets.data());
        include(bounds_, frame_.place(mesh.vertices[v], jets.data()));
    }
    const Vec3<double> middle = 0.5 * (bounds_.min + bounds_.max);
    description_.origin =
        frame_.parametric ? middle : Vec3<double>{mesh.origin.x, mesh.origin.y, middle.z};
    frame_.origin = description_.origin;
    const Vec3<double> moved = frame_.parametric ? middle : Vec3<double>{0, 0, middle.z};
    bounds_ = {bounds_.min - moved, bounds_.max - moved};
}

std::unique_ptr<NetGraph> PlaneModel::graph(int level) const {
    if (!description_.parametric) return std::make_unique<PlaneGraph>(this->level(level));
    settle();
    return std::make_unique<SurfaceGraph>(this->level(level), spline(View::Show::Edited, level));
}

Status PlaneModel::check_sum(const PointMove& move) const {
    const VertexMove before = moves_->at(move.level, level(move.level).vertex_of(move.point));
    const Vec3<double> delta = before.delta + move.delta;
    const Vec2 slope = before.slope + move.slope;
    for (const double number : {delta.x, delta.y, delta.z, slope.x, slope.y})
        if (!(std::abs(number) <= kLargest))
            return wrong("all moves of control point " + std::to_string(move.point) +
                         " together are not numbers of at most 1e100");
    return {};
}

Status PlaneModel::push(std::vector<PointMove> group) {
    std::vector<PointMove> of_vertices = group;
    for (PointMove& move : of_vertices) move.point = level(move.level).vertex_of(move.point);
    PlaneMoves::Undo undo = moves_->add(of_vertices);
    groups_.push_back({std::move(group), std::move(undo)});
    return {};
}

void PlaneModel::pop() {
    moves_->restore(groups_.back().undo);
    groups_.pop_back();
}

std::vector<PointMove> PlaneModel::all_moves() const {
    std::vector<PointMove> moves;
    for (const Group& group : groups_)
        moves.insert(moves.end(), group.moves.begin(), group.moves.end());
    return moves;
}

PlaneSamples PlaneModel::sampled(const View& view, const GridPart& part) const {
    settle();
    return sample(*spline(view.show, view.level), level(view.level).grid(), part,
                  view.extras.curvature ? Derivatives::Second : Derivatives::First);
}

/// The original at places of a level's mesh: cells of other levels are other ones.
PlaneSamples PlaneModel::original_at(int level, const GridPart& part,
                                     const std::vector<Vec2>& places) const {
    const auto original = spline(View::Show::Original, 0);
    if (level == 0) return sample(*original, this->level(0).grid(), part, Derivatives::First);
    PlaneSamples samples(original->components(), places.size());
    parallel_for(0, static_cast<std::int64_t>(places.size()), kGrain,
                 [&](std::int64_t first, std::int64_t last) {
                     for (auto k = static_cast<std::size_t>(first);
                          k < static_cast<std::size_t>(last); ++k) {
                         const CellPlace at = *locate(0, places[k], Outside::Nearest);
                         original->in_cell(at.cell, {&at.point, 1}, samples.at(k));
                     }
                 });
    return samples;
}

PlaneModel::Drawn PlaneModel::draw(const View& view, const GridPart& part) const {
    const PlaneSamples samples = sampled(view, part);
    Drawn drawn;
    drawn.position.reserve(samples.count());
    drawn.normal.reserve(samples.count());
    for (std::size_t k = 0; k < samples.count(); ++k) {
        const Vec3<double> p = frame_.place(samples.places[k], samples.at(k));
        include(bounds_, p);
        drawn.position.push_back(page_point(p));
        drawn.normal.push_back(packed_normal(frame_.normal(samples.at(k))));
        if (view.extras.curvature)
            drawn.curvature.push_back(static_cast<float>(frame_.curvature(samples.at(k))));
    }
    if (!view.extras.error) return drawn;
    const PlaneSamples original = original_at(view.level, part, samples.places);
    for (std::size_t k = 0; k < samples.count(); ++k)
        drawn.error.push_back(static_cast<float>(frame_.error(samples.at(k), original.at(k))));
    return drawn;
}

Result<SurfaceGeometry> PlaneModel::surface(const View& view) const {
    const PlaneLevel& level = this->level(view.level);
    Drawn drawn = draw(view, GridPart::whole(level.mesh()));
    SurfaceGeometry out;
    out.level = view.level;
    out.position = std::move(drawn.position);
    out.normal = std::move(drawn.normal);
    out.error = std::move(drawn.error);
    out.curvature = std::move(drawn.curvature);
    out.index = level.grid().triangles();
    out.line = level.grid().lines();
    return out;
}

Result<TileGeometry> PlaneModel::tile(const View&, const TileName&) const {
    return wrong("only rasters are drawn in tiles; ask for the surface");
}

/// What is drawn otherwise when the spline changed at some vertices: they, their edges and cells.
/// Second derivatives on the border of a cell are the cell's.
GridPart PlaneModel::part_at(const View& view, const std::vector<Index>& changed) const {
    const CellMesh& mesh = level(view.level).mesh();
    GridPart part{changed, mesh.edges_at(changed), mesh.cells_at(changed)};
    if (!view.extras.curvature) return part;
    for (const Index c : part.cells)
        for (std::size_t i = 0; i < mesh.sides; ++i) {
            const Index v = mesh.cells[c][i];
            const Index e = mesh.cell_edges[c][i];
            if (mesh.vertex_cells.of(v)[0] == c) part.vertices.push_back(v);
            if (mesh.edge_cell[e] == c) part.edges.push_back(e);
        }
    sort_unique(part.vertices, mesh.vertices.size());
    sort_unique(part.edges, mesh.edges.size());
    return part;
}

Result<Change> PlaneModel::changes(const View& view, const std::vector<TileName>&) {
    settle();
    const std::vector<std::vector<Index>> all = moves_->take_changed();
    const std::vector<Index>& changed = all[static_cast<std::size_t>(view.level)];
    Change change;
    change.touched = all[0].size();
    change.surface.level = view.level;
    if (view.show != View::Show::Edited || changed.empty()) return change;
    const GridPart part = part_at(view, changed);
    Drawn drawn = draw(view, part);
    change.surface.at = part.points(level(view.level).grid());
    change.surface.position = std::move(drawn.position);
    change.surface.normal = std::move(drawn.normal);
    change.surface.error = std::move(drawn.error);
    change.surface.curvature = std::move(drawn.curvature);
    return change;
}

void PlaneModel::add_to_net(const LevelSpline& spline, int level, Index vertex,
                            NetGeometry& net) const {
    std::vector<PlaneJet> jets(spline.components());
    spline.at_vertex(vertex, jets.data());
    const Vec2 plan = this->level(level).mesh().vertices[vertex];
    net.position.push_back(page_point(frame_.place(plan, jets.data())));
    net.point.push_back(this->level(level).number_of(vertex));
    const auto control = corners(level, vertex);
    if (!control) return;
    std::array<Point, 3>& corner = net.corner.emplace_back();
    for (std::size_t j = 0; j < 3; ++j) corner[j] = page_point((*control)[j] - frame_.origin);
}

Result<NetGeometry> PlaneModel::net(int number, const std::optional<LatticeBox>& window) const {
    const PlaneLevel& level = this->level(number);
    if (window) return wrong("only nets of rasters have windows; ask for the whole net of a level");
    if (level.vertex_count() > kWholeNet)
        return wrong("the control net of level " + std::to_string(number) + " has " +
                     std::to_string(level.vertex_count()) + " points, more than " +
                     std::to_string(kWholeNet) + "; ask for that of a coarser level");
    settle();
    const auto edited = spline(View::Show::Edited, number);
    NetGeometry net;
    net.level = number;
    for (std::size_t k = 0; k < level.vertex_count(); ++k)
        add_to_net(*edited, number, level.vertex_of(k), net);
    for (const auto& [from, to] : level.mesh().edges)
        net.line.insert(net.line.end(), {level.number_of(from), level.number_of(to)});
    return net;
}

Result<std::optional<Probe>> PlaneModel::at(const View& view, Vec2 page) const {
    if (description_.parametric) return std::optional<Probe>();
    const auto place = locate(view.level, page, Outside::None);
    if (!place) return std::optional<Probe>();
    settle();
    PlaneJet jet;
    spline(view.show, view.level)->in_cell(place->cell, {&place->point, 1}, &jet);
    Probe probe;
    probe.value = jet.value;
    probe.gradient = jet.gradient;
    probe.slope = std::atan(length(jet.gradient)) * 180 / 3.14159265358979323846;
    probe.place = level(0).mesh().origin + page;
    return std::optional<Probe>(probe);
}

Result<Measurement> PlaneModel::measure(const View& view) const {
    const GridPart part = GridPart::whole(level(view.level).mesh());
    const PlaneSamples now = sampled({.level = view.level, .show = view.show}, part);
    const PlaneSamples before = original_at(view.level, part, now.places);
    Measurement worst;
    double squares = 0;
    for (std::size_t k = 0; k < now.count(); ++k) {
        const double error = std::abs(frame_.error(now.at(k), before.at(k)));
        squares += error * error;
        if (!(error > worst.max_error)) continue;
        worst.max_error = error;
        worst.place = frame_.place(now.places[k], now.at(k));
    }
    worst.rms_error = std::sqrt(squares / static_cast<double>(now.count()));
    return worst;
}

}  // namespace relief::edit
