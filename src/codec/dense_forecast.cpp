#include "codec/dense_forecast.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace relief::codec::dense {

void RowForecast::resize(std::int64_t samples) {
    count = samples;
    const std::size_t size = static_cast<std::size_t>(samples) + kSlack;
    line.resize(size);
    second.resize(size);
    calm.resize(size);
    around.resize(size);
    texture.resize(size);
    inherited.resize(size);
    base_.resize(size);
    roughness_.resize(size);
}

void RowForecast::make(const LatticeLevel& level, Kind kind, std::int64_t row,
                       const Weights& weights) {
    const Stencil& stencil = kStencils[static_cast<std::size_t>(kind)];
    first = kind == Kind::Vertical ? 0 : 1;
    resize((level.cols() - first + 1) / 2);
    predict(level, stencil, row, weights);
    measure(level, stencil, row);
}

/// base + sum of weight (sample - base) as one sum of samples.
void RowForecast::predict(const LatticeLevel& level, const Stencil& stencil, std::int64_t row,
                          const Weights& weights) {
    const auto n = static_cast<std::size_t>(count);
    const auto at = [&](Offset offset) {
        return level.values.row(row + offset.row) + first + offset.col;
    };
    std::array<Tap, 4 + 2 * kFeatures> taps;
    const auto set_nearest = [&](double share) {
        for (std::size_t k = 0; k < 4; ++k) taps[k] = {at(stencil.nearest[k]), share / 4};
    };
    set_nearest(1);
    weighted_sum({taps.data(), 4}, n, base_.data());

    double share = 1 - stencil.second_weight * static_cast<double>(stencil.ring_size);
    set_nearest(share);
    for (std::size_t j = 0; j < stencil.ring_size; ++j)
        taps[4 + j] = {at(stencil.ring[j]), stencil.second_weight};
    weighted_sum({taps.data(), 4 + stencil.ring_size}, n, second.data());

    share = 1 - weights[0];
    std::size_t used = 4;
    for (std::size_t j = 1; j < kFeatures; ++j) {
        const Feature& feature = stencil.features[j];
        taps[used++] = {at(feature.first), weights[j]};
        share -= weights[j];
        if (j < stencil.singles) continue;
        taps[used++] = {at(feature.second), weights[j]};
        share -= weights[j];
    }
    set_nearest(share);
    weighted_sum({taps.data(), used}, n, line.data());
}

void RowForecast::measure(const LatticeLevel& level, const Stencil& stencil, std::int64_t row) {
    const auto value = [&](std::size_t n) {
        return level.values.row(row + stencil.nearest[n].row) + first + stencil.nearest[n].col;
    };
    const auto quotient = [&](Offset offset) {
        return level.quotients.row(row + offset.row) + first + offset.col;
    };
    const std::int32_t* const a = value(0);
    const std::int32_t* const b = value(1);
    const std::int32_t* const c = value(2);
    const std::int32_t* const d = value(3);
    const std::int16_t* const late0 = quotient(stencil.nearest[stencil.late[0]]);
    const std::int16_t* const late1 = quotient(stencil.nearest[stencil.late[1]]);
    const std::int16_t* const early0 = quotient(stencil.nearest[stencil.early[0]]);
    const std::int16_t* const early1 = quotient(stencil.nearest[stencil.early[1]]);
    const std::int16_t* const q0 = quotient(stencil.causal[0]);
    const std::int16_t* const q1 = quotient(stencil.causal[1]);
    const std::int16_t* const q2 = quotient(stencil.causal[2]);
    const double ring = stencil.ring_texture / std::abs(stencil.second_weight);
    const auto per_step = static_cast<float>(1.0 / modelled_step(level));
    for (std::int64_t k = 0; k < count; ++k) {
        const auto i = static_cast<std::size_t>(k);
        const double nw = a[2 * k];
        const double ne = b[2 * k];
        const double sw = c[2 * k];
        const double se = d[2 * k];
        roughness_[i] = static_cast<float>(.25 * std::abs(nw - ne - sw + se) +
                                           .05 * (std::abs(nw - se) + std::abs(ne - sw)) +
                                           ring * std::abs(second[i] - base_[i])) *
                        per_step;
    }
    for (std::int64_t k = 0; k < count; ++k) {
        const auto i = static_cast<std::size_t>(k);
        const std::int32_t late = std::abs(late0[2 * k]) + std::abs(late1[2 * k]);
        const std::int32_t early = std::abs(early0[2 * k]) + std::abs(early1[2 * k]);
        texture[i] = static_cast<std::uint8_t>(octave_class(roughness_[i]));
        inherited[i] = static_cast<std::uint8_t>(sum_class(late + early));
        around[i] = stencil.causal_shares[0] * std::abs(q0[2 * k]) +
                    stencil.causal_shares[1] * std::abs(q1[2 * k]) +
                    stencil.causal_shares[2] * std::abs(q2[2 * k]);
        calm[i] = kScale.late * static_cast<float>(late) +
                  kScale.early * static_cast<float>(early) + kScale.texture * roughness_[i] +
                  kScale.least;
    }
}

}  // namespace relief::codec::dense
