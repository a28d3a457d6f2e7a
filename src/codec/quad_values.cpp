#include "codec/quad_values.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

namespace relief::codec {

using mesh::Index;
using mesh::Quadrangulation;
namespace fvs_mesh = multires::fvs_mesh;

namespace {

/// What a mesh may have: beyond it derivatives overflow.
constexpr double kLargestValue = 1e150;

/// How much of what the prediction has missed at the middles of its sides is added at the centre of
/// a quad; 1/2 each would be the blend of four curves, of which noise makes the most.
constexpr double kCentreShare = 0.25;

/// Vertices in the order in which walks along edges reach them, component after component.
std::vector<Index> breadth_first(const Quadrangulation& mesh, const mesh::VertexQuads& quads) {
    std::vector<Index> order;
    std::vector<std::uint8_t> reached(mesh.vertex_count());
    const auto reach = [&](Index v) {
        if (!reached[v]) order.push_back(v);
        reached[v] = 1;
    };
    for (Index start = 0; start < mesh.vertex_count(); ++start) {
        std::size_t next = order.size();
        for (reach(start); next < order.size(); ++next)
            for (const Index q : quads.of(order[next])) {
                const auto& corners = mesh.quads[q];
                const auto i = static_cast<std::size_t>(
                    std::find(corners.begin(), corners.end(), order[next]) - corners.begin());
                reach(corners[(i + 1) % 4]);
                reach(corners[(i + 3) % 4]);
            }
    }
    return order;
}

/// Predicts the value at a vertex from those that are known around it.
class PlanePrediction {
  public:
    PlanePrediction(const Quadrangulation& mesh, const std::vector<double>& values,
                    const std::vector<std::uint8_t>& known)
        : mesh_(mesh), values_(values), known_(known) {}

    /// The least squares solution of the conditions that the quads whose other corners are known be
    /// plane: (1-s) z0 + s z2 = (1-t) z1 + t z3. Without such quads the mean of the known corners
    /// of its quads; without those `last`.
    [[nodiscard]] double at(Index v, std::span<const Index> quads, double last) const {
        double weights = 0;
        double planes = 0;
        double sum = 0;
        int count = 0;
        for (const Index q : quads) {
            const std::array<Index, 4> corner = beginning_with(v, q);
            int here = 0;
            for (std::size_t i = 1; i < 4; ++i) {
                if (!known_[corner[i]]) continue;
                sum += values_[corner[i]];
                ++here;
            }
            count += here;
            if (here < 3) continue;
            const Diagonals d = diagonals({mesh_.vertex(corner[0]), mesh_.vertex(corner[1]),
                                           mesh_.vertex(corner[2]), mesh_.vertex(corner[3])});
            const double right = (1 - d.t) * values_[corner[1]] + d.t * values_[corner[3]] -
                                 d.s * values_[corner[2]];
            weights += (1 - d.s) * (1 - d.s);
            planes += (1 - d.s) * right;
        }
        if (weights > 0) return planes / weights;
        return count > 0 ? sum / count : last;
    }

  private:
    [[nodiscard]] std::array<Index, 4> beginning_with(Index v, Index q) const {
        std::array<Index, 4> corners = mesh_.quads[q];
        std::rotate(corners.begin(), std::find(corners.begin(), corners.end(), v), corners.end());
        return corners;
    }

    const Quadrangulation& mesh_;
    const std::vector<double>& values_;
    const std::vector<std::uint8_t>& known_;
};

}  // namespace

QuadValues::QuadValues(const fvs_mesh::Hierarchy& hierarchy, const ValueLattice& lattice)
    : hierarchy_(hierarchy), lattice_(lattice) {}

template <class Coder>
bool QuadValues::code_value(Coder& coder, const std::int64_t* source, Index vertex,
                            double predicted, QuadNumber kind, std::span<const Index> quads) {
    const auto base = static_cast<std::uint64_t>(lattice_.nearest(predicted));
    const std::uint64_t target = source ? static_cast<std::uint64_t>(source[vertex]) : base;
    const std::int64_t difference =
        NumberCoder<Coder>(coder, model_)
            .code(static_cast<std::int64_t>(target - base), static_cast<std::uint32_t>(kind),
                  sums_.around(quads), below_.below(quads, sums_.size()));
    sums_.add(quads, difference);
    values_[vertex] =
        lattice_.value(static_cast<std::int64_t>(base + static_cast<std::uint64_t>(difference)));
    return std::abs(values_[vertex]) <= kLargestValue;
}

template <class Coder>
bool QuadValues::code_base(Coder& coder, const std::int64_t* source) {
    const Quadrangulation& mesh = hierarchy_.mesh(0);
    const mesh::VertexQuads quads = vertex_quads(mesh);
    std::vector<std::uint8_t> known(mesh.vertex_count());
    const PlanePrediction prediction(mesh, values_, known);
    double last = 0;
    for (const Index v : breadth_first(mesh, quads)) {
        const double predicted = prediction.at(v, quads.of(v), last);
        if (!code_value(coder, source, v, predicted, QuadNumber::Value, quads.of(v))) return false;
        known[v] = 1;
        last = values_[v];
    }
    return true;
}

template <class Coder>
bool QuadValues::code_refined(Coder& coder, const std::int64_t* source,
                              const std::vector<double>& predicted) {
    const Quadrangulation& parent = hierarchy_.mesh(next_ - 1);
    const auto owners = mesh::edge_quads(parent);
    for (Index e = 0; e < parent.edge_count(); ++e) {
        const Index v = parent.vertex_count() + e;
        if (!code_value(coder, source, v, predicted[v], QuadNumber::EdgeValue, owners[e]))
            return false;
    }
    for (Index q = 0; q < parent.quad_count(); ++q) {
        const Index v = parent.vertex_count() + parent.edge_count() + q;
        double missed = 0;
        for (const Index e : parent.quad_edges[q]) {
            const Index middle = parent.vertex_count() + e;
            missed += values_[middle] - predicted[middle];
        }
        const std::array<Index, 1> owner = {q};
        if (!code_value(coder, source, v, predicted[v] + kCentreShare * missed,
                        QuadNumber::CentreValue, owner))
            return false;
    }
    return true;
}

template <class Coder>
Status QuadValues::code_next(Coder& coder, const std::int64_t* source) {
    bool good = true;
    if (next_ == 0) {
        values_.resize(hierarchy_.mesh(0).vertex_count());
        sums_ = QuadSums(hierarchy_.mesh(0).quad_count());
        below_ = sums_;
        good = code_base(coder, source);
    } else {
        const Quadrangulation& parent = hierarchy_.mesh(next_ - 1);
        RELIEF_TRY(const auto data, fvs_mesh::interpolate_values(parent, values_));
        const std::vector<double> predicted = fvs_mesh::predict(parent, data).value;
        values_.resize(predicted.size());
        below_ = std::exchange(sums_, QuadSums(parent.quad_count()));
        good = code_refined(coder, source, predicted);
    }
    if (!good)
        return Error{ErrorCode::BadInput,
                     "non_finite_data: a value is not finite or beyond 1e150; correct it", ""};
    ++next_;
    return {};
}

Result<Bytes> QuadValues::encode_next(std::span<const std::int64_t> integers) {
    RangeEncoder coder;
    RELIEF_CHECK(code_next(coder, integers.data()));
    return coder.finish();
}

Status QuadValues::decode_next(std::span<const std::uint8_t> bytes) {
    RangeDecoder coder(bytes);
    const int level = next_;
    if (code_next(coder, nullptr).ok() && coder.at_end()) return {};
    return Error{ErrorCode::BadFile, "the values of a level are damaged",
                 "level " + std::to_string(level) + " of the refinement"};
}

}  // namespace relief::codec
