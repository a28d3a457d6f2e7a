#include "codec/ps_values.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "codec/number_coder.h"
#include "codec/ps_plane_sums.h"
#include "codec/ps_surroundings.h"

namespace relief::codec {

namespace {

using mesh::Index;
using mesh::Triangulation;

constexpr double kLargestValue = 1e150;
/// Gradients are held near zero by so much.
constexpr double kTrust = 0.02;

enum Predictor : std::size_t { kMean, kPlane, kPredictors };
using Predictions = std::array<double, kPredictors>;

/// What is known of one component.
struct Component {
    const ValueLattice& lattice;
    std::vector<double> values;
    std::vector<Predictions> misses;        ///< [vertex], squared
    std::vector<std::int64_t> differences;  ///< [vertex]: what was coded
};

/// One text for encoder and decoder.
template <class Coder>
class ValueCoder {
  public:
    ValueCoder(Coder& coder, const Triangulation& mesh, std::span<const ValueLattice> lattices)
        : coder_(coder), mesh_(mesh) {
        const std::size_t count = mesh.x.size();
        for (const ValueLattice& lattice : lattices)
            components_.push_back({lattice, std::vector<double>(count),
                                   std::vector<Predictions>(count),
                                   std::vector<std::int64_t>(count)});
    }

    /// source: null for a decoder. False: a value is out of range.
    bool run(const VertexValues* source) {
        PsSurroundings surroundings(mesh_);
        return surroundings.each([&](Index v, std::span<const Index> around) {
            for (std::size_t c = 0; c < components_.size(); ++c)
                if (!code_value(c, source ? &(*source)[c][v] : nullptr, v, around)) return false;
            last_ = v;
            return true;
        });
    }

    [[nodiscard]] VertexValues take_values() {
        VertexValues values;
        for (Component& component : components_) values.push_back(std::move(component.values));
        return values;
    }

  private:
    bool code_value(std::size_t c, const double* source, Index v, std::span<const Index> around) {
        Component& component = components_[c];
        const ValueLattice& lattice = component.lattice;
        const Predictions predictions = predict(component, v, around);
        const double predicted = blended(component, predictions, around);
        const auto base = static_cast<std::uint64_t>(lattice.nearest(predicted));
        const std::uint64_t target =
            source ? static_cast<std::uint64_t>(lattice.nearest(*source)) : base;
        Surrounding near;
        for (const Index u : around) near.add(component.differences[u]);
        Surrounding far;
        far.add(distance(lattice, predicted, spread(component, predictions[kMean], around)));
        for (std::size_t other = 0; other < c; ++other) far.add(components_[other].differences[v]);
        const std::int64_t difference = NumberCoder<Coder>(coder_, model_)
                                            .code(static_cast<std::int64_t>(target - base),
                                                  static_cast<std::uint32_t>(c), near, far);
        component.differences[v] = difference;
        const double value =
            lattice.value(static_cast<std::int64_t>(base + static_cast<std::uint64_t>(difference)));
        component.values[v] = value;
        for (std::size_t k = 0; k < kPredictors; ++k)
            component.misses[v][k] = (predictions[k] - value) * (predictions[k] - value);
        return std::abs(value) <= kLargestValue;
    }

    [[nodiscard]] Predictions predict(const Component& component, Index v,
                                      std::span<const Index> around) const {
        if (around.empty()) {
            Predictions same;
            same.fill(component.values[last_]);
            return same;
        }
        PlaneSums sums;
        for (const Index u : around)
            sums.add(mesh_.vertex(u) - mesh_.vertex(v), component.values[u]);
        return {sums.mean(), sums.plane({}, kTrust).value};
    }

    /// Predictors count as much as they missed little around.
    [[nodiscard]] static double blended(const Component& component, const Predictions& predictions,
                                        std::span<const Index> around) {
        Predictions misses{};
        for (const Index u : around)
            for (std::size_t k = 0; k < kPredictors; ++k) misses[k] += component.misses[u][k];
        const double all = misses[kMean] + misses[kPlane];
        const double plane = all > 0 && all <= kLargestValue ? misses[kMean] / all : 0.5;
        return predictions[kMean] + plane * (predictions[kPlane] - predictions[kMean]);
    }

    /// How far the values around lie from their mean, on average.
    [[nodiscard]] static double spread(const Component& component, double mean,
                                       std::span<const Index> around) {
        double sum = 0;
        for (const Index u : around) sum += std::abs(component.values[u] - mean);
        return around.empty() ? 0 : sum / static_cast<double>(around.size());
    }

    [[nodiscard]] static std::int64_t distance(const ValueLattice& lattice, double value,
                                               double length) {
        return static_cast<std::int64_t>(
            static_cast<std::uint64_t>(lattice.nearest(value + length)) -
            static_cast<std::uint64_t>(lattice.nearest(value)));
    }

    Coder& coder_;
    const Triangulation& mesh_;
    std::vector<Component> components_;
    NumberModel model_;
    Index last_ = 0;
};

}  // namespace

Bytes encode_ps_values(const Triangulation& mesh, std::span<const ValueLattice> lattices,
                       const VertexValues& values) {
    RangeEncoder encoder;
    ValueCoder(encoder, mesh, lattices).run(&values);
    return encoder.finish();
}

Result<VertexValues> decode_ps_values(const Triangulation& mesh,
                                      std::span<const ValueLattice> lattices,
                                      std::span<const std::uint8_t> bytes) {
    RangeDecoder decoder(bytes);
    ValueCoder coder(decoder, mesh, lattices);
    if (coder.run(nullptr) && decoder.at_end()) return coder.take_values();
    return Error{ErrorCode::BadFile, "the values are damaged", "level 0"};
}

}  // namespace relief::codec
