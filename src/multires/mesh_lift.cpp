#include "relief/multires/mesh_lift.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "multires/conjugate_gradient.h"
#include "multires/mesh_curves.h"
#include "multires/mesh_normal.h"
#include "multires/mesh_points.h"

namespace relief::multires {

namespace {

using mesh::Index;
using Points = std::vector<Vec3<double>>;

constexpr int kMostSweeps = 64;
constexpr double kLeastSquares = 1e-13;

/// The weight of an end of its edge, or of a corner of its face, in each new vertex.
std::vector<double> star_weights(const MeshStep<double>& step) {
    const mesh::Topology& mesh = step.coarse();
    const StepRules& rules = step.rules();
    std::vector<double> weights(step.new_count(), rules::kFacePoint3);
    if (rules.split != mesh::Split::Loop && rules.split != mesh::Split::CatmullClark)
        return weights;
    const auto share = [&](Index h) { return 1.0 / mesh.size_of(mesh.face_of(h)); };
    mesh::each_edge(mesh, [&](Index h, Index, Index) {
        const bool sharp = is_sharp(rules, mesh, h);
        double& weight = weights[mesh.edge[h]];
        if (sharp)
            weight = rules::kSharpEdgeEnd;
        else if (rules.split == mesh::Split::Loop)
            weight = rules::kLoopEdgeEnd;
        else
            weight = rules::kQuadEdgeEnd + rules::kQuadEdgeFace * (share(h) + share(mesh.twin[h]));
    });
    if (rules.split == mesh::Split::CatmullClark)
        for (Index f = 0; f < mesh.face_count; ++f)
            weights[mesh.edge_count + f] = 1.0 / mesh.size_of(f);
    return weights;
}

}  // namespace

struct MeshLift::State {
    State(const MeshStep<double>& its_step, const LiftOptions& its_options)
        : step(its_step), options(its_options), curves(its_step) {}

    void prepare() {
        if (options.kind == LiftKind::Ring) prepare_ring();
        if (options.kind == LiftKind::Chebyshev) prepare_sweeps();
        if (options.kind == LiftKind::LeastSquares) normal.emplace(step);
    }

    [[nodiscard]] bool is_inner(Index v) const { return step.rules().kinds[v] <= VertexKind::Dart; }

    void prepare_sweeps() {
        normal.emplace(step);
        const MeshNormal::Points sums = normal->column_sums();
        scale.resize(sums.size());
        for (std::size_t k = 0; k < sums.size(); ++k) scale[k] = 1 / sums[k].x;
    }

    /// Squares of the columns of P, cut to the vertex itself and its star; K P of the same.
    void prepare_ring() {
        const StepRules& rules = step.rules();
        star = star_weights(step);
        self.assign(rules.self.data(), rules.self.data() + rules.self.size());
        std::vector<double> squares(step.coarse_count(), 0);
        each_point_around<double>(step.coarse(), rules, [&](Index v, Index point, double sign) {
            self[v] += sign * rules.point[v] * star[point];
            squares[v] += star[point] * star[point];
        });
        for (const PointWeight& w : rules.points) self[w.vertex] += w.weight * star[w.point];
        for (std::size_t v = 0; v < squares.size(); ++v)
            scale.push_back(1 / (self[v] * self[v] + squares[v]));
    }

    void ring(const Vec3<double>* old, const Vec3<double>* fresh, Vec3<double>* out) const {
        Points sums(step.coarse_count());
        for (std::size_t v = 0; v < sums.size(); ++v) sums[v] = self[v] * old[v];
        each_point_around<double>(step.coarse(), step.rules(), [&](Index v, Index point, double) {
            sums[v] += star[point] * fresh[point];
        });
        for (Index v = 0; v < step.coarse_count(); ++v)
            if (is_inner(v)) out[v] = scale[v] * sums[v];
    }

    /// The inner vertices, from what is left beside the curves.
    void fit_surface(const Vec3<double>* old, const Vec3<double>* fresh, Vec3<double>* out) const {
        MeshNormal::Passes passes(*normal);
        const MeshNormal::Points target = normal->adjoint(old, fresh, passes);
        const auto put = [&](const auto& x) {
            for (std::size_t k = 0; k < target.size(); ++k) out[normal->vertices()[k]] = x[k];
        };
        if (options.kind == LiftKind::Chebyshev)
            return put(normal->sweep(options, scale, target, passes));
        put(conjugate_gradient<double>(
            Points(target.data(), target.data() + target.size()),
            [&](const Points& p, Points& y) { normal->apply(p.data(), y.data(), passes); },
            kLeastSquares));
    }

    /// What is left of a residual beside the curves; out: what they move.
    void fit_curves(Vec3<double>* old, Points& fresh, Vec3<double>* out) const {
        curves.fit(old, fresh.data(), out);
        Points old_part(step.coarse_count());
        Points fresh_part(step.new_count());
        step.apply(out, old_part.data(), fresh_part.data());
        for (std::size_t k = 0; k < old_part.size(); ++k) old[k] -= old_part[k];
        for (std::size_t k = 0; k < fresh.size(); ++k) fresh[k] -= fresh_part[k];
    }

    const MeshStep<double>& step;
    LiftOptions options;
    MeshCurves curves;
    std::optional<MeshNormal> normal;  ///< Chebyshev, least squares
    std::vector<double> scale;         ///< [vertex]
    std::vector<double> self;          ///< ring: of a vertex in its own fine position
    std::vector<double> star;          ///< ring: [new vertex]
};

Result<LiftKind> lift_from_name(std::string_view name) {
    for (const LiftKind kind : kLiftKinds)
        if (name == lift_name(kind)) return kind;
    return Error{
        ErrorCode::InvalidArgument,
        "lifts are none, ring, chebyshev and least-squares, not '" + std::string(name) + "'", ""};
}

const char* lift_name(LiftKind kind) {
    constexpr std::array<const char*, kLiftKinds.size()> names{"none", "ring", "chebyshev",
                                                               "least-squares"};
    return names[static_cast<std::size_t>(kind)];
}

LiftOptions default_lift(MeshScheme scheme, int level) {
    const int sweeps = scheme == MeshScheme::Sqrt3 ? 4 : scheme == MeshScheme::Loop ? 6 : 12;
    const double lowest = scheme == MeshScheme::CatmullClark ? 1.0 / 16 : 1.0 / 8;
    const int doubled = level < 4 ? sweeps << level : kMostSweeps;
    return {LiftKind::Chebyshev, std::min(doubled, kMostSweeps), lowest};
}

Result<MeshLift> MeshLift::create(const MeshStep<double>& step, const LiftOptions& options) {
    if (options.kind == LiftKind::Chebyshev &&
        (options.sweeps < 1 || !(options.lowest > 0 && options.lowest < 1)))
        return Error{ErrorCode::InvalidArgument,
                     "invalid_parameter: Chebyshev lifting needs sweeps from 1 on and a lowest "
                     "eigenvalue between 0 and 1",
                     "lift"};
    auto state = std::make_unique<State>(step, options);
    state->prepare();
    return MeshLift(std::move(state));
}

MeshLift::MeshLift(std::unique_ptr<State> state) : state_(std::move(state)) {}
MeshLift::MeshLift(MeshLift&&) noexcept = default;
MeshLift& MeshLift::operator=(MeshLift&&) noexcept = default;
MeshLift::~MeshLift() = default;

void MeshLift::apply(const Vec3<double>* details, const Vec3<double>* residuals,
                     Vec3<double>* out) const {
    const MeshStep<double>& step = state_->step;
    if (state_->options.kind == LiftKind::None) {
        std::fill_n(out, step.coarse_count(), Vec3<double>());
        return;
    }
    // What the plain reversal leaves everywhere: e = Q d. Where no curves are fitted first, `out`
    // has room for it.
    const bool has_curves = !state_->curves.empty();
    MeshNormal::Points apart(has_curves ? step.coarse_count() : 0);
    Vec3<double>* old = has_curves ? apart.data() : out;
    step.gather(details, old);
    const auto& stiff = step.rules().stiff.vertices;
    for (std::size_t k = 0; k < stiff.size(); ++k) old[stiff[k]] += residuals[k];
    Points beside;
    if (has_curves) {
        std::fill_n(out, step.coarse_count(), Vec3<double>());
        beside.assign(details, details + step.new_count());
        state_->fit_curves(old, beside, out);
    }
    const Vec3<double>* fresh = has_curves ? beside.data() : details;
    if (state_->options.kind == LiftKind::Ring)
        state_->ring(old, fresh, out);
    else
        state_->fit_surface(old, fresh, out);
    for (Index v = 0; !has_curves && v < step.coarse_count(); ++v)
        if (!state_->is_inner(v)) out[v] = {};
}

}  // namespace relief::multires
