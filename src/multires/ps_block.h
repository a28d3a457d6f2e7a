#pragma once

#include <algorithm>

#include "relief/spline/ps_element.h"

/// The numbers of a triangle of a surface: V_k - Z, Z, the weights of V_k in R_k, then for each
/// component value and gradient at Z and the Hessians of the pieces.
namespace relief::multires::ps::block {

inline constexpr int kCentre = 6;
inline constexpr int kWeights = 8;
inline constexpr int kGeometry = 11;
inline constexpr int kPerComponent = 21;
inline constexpr int kHessians = 3;  ///< from the beginning of a component

inline Vec2 centre(const double* block) {
    return {block[kCentre], block[kCentre + 1]};
}

/// As spline::PsElement::piece_of, without branches: nothing can predict where points lie.
class PieceFinder {
  public:
    explicit PieceFinder(const double* block) {
        std::copy_n(block, 6, corner_);
        std::copy_n(block + kWeights, 3, weight_);
    }

    [[nodiscard]] int piece_of(Vec2 d) const {
        double height[3];  // of the point over the line from Z to V_k
        for (int k = 0; k < 3; ++k) height[k] = corner_[2 * k] * d.y - corner_[2 * k + 1] * d.x;
        double over[3];  // over the line from Z to R_k
        for (int k = 0; k < 3; ++k)
            over[k] = weight_[k] * height[k] + (1 - weight_[k]) * height[k == 2 ? 0 : k + 1];
        const auto bit = [](double number, int shift) { return (number >= 0 ? 1 : 0) << shift; };
        const int left = bit(height[0], 0) + bit(height[1], 1) + bit(height[2], 2);
        const int k = spline::kPsSector[left];
        return 2 * k + ((bit(over[0], 0) + bit(over[1], 1) + bit(over[2], 2)) >> k & 1);
    }

  private:
    double corner_[6];
    double weight_[3];
};

/// The lines from Z, to V_0, R_0, V_1, R_1, V_2, R_2; spoke k begins piece k.
inline std::array<Vec2, 6> spokes(const double* block) {
    std::array<Vec2, 6> spokes;
    for (int k = 0; k < 3; ++k) spokes[2 * k] = {block[2 * k], block[2 * k + 1]};
    for (int k = 0; k < 3; ++k) {
        const double weight = block[kWeights + k];
        spokes[2 * k + 1] = weight * spokes[2 * k] + (1 - weight) * spokes[k == 2 ? 0 : 2 * k + 2];
    }
    return spokes;
}

/// The jet of a piece at Z.
inline spline::PlaneJet centre_jet(const double* block, int piece, int component) {
    const double* numbers = block + kGeometry + kPerComponent * component;
    const double* h = numbers + kHessians + 3 * piece;
    return {numbers[0], {numbers[1], numbers[2]}, h[0], h[1], h[2]};
}

}  // namespace relief::multires::ps::block
