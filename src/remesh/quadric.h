#pragma once

#include <algorithm>

#include "relief/core/vec3.h"

namespace relief::remesh {

/// The weighted sum of squared distances from planes: p^T A p + 2 b^T p + c.
class Quadric {
  public:
    /// Requires: a normal of length 1.
    void add_plane(const Vec3<double>& normal, const Vec3<double>& through, double weight) {
        const double offset = -dot(normal, through);
        const Vec3<double> scaled = weight * normal;
        row_x_ += scaled.x * normal;
        row_y_ += scaled.y * normal;
        row_z_ += scaled.z * normal;
        linear_ += offset * scaled;
        constant_ += weight * offset * offset;
        weight_ += weight;
    }
    void add(const Quadric& other) {
        row_x_ += other.row_x_;
        row_y_ += other.row_y_;
        row_z_ += other.row_z_;
        linear_ += other.linear_;
        constant_ += other.constant_;
        weight_ += other.weight_;
    }
    [[nodiscard]] double weight() const { return weight_; }
    [[nodiscard]] double operator()(const Vec3<double>& p) const {
        const Vec3<double> image{dot(row_x_, p), dot(row_y_, p), dot(row_z_, p)};
        return std::max(0.0, dot(image, p) + 2 * dot(linear_, p) + constant_);
    }

  private:
    Vec3<double> row_x_;
    Vec3<double> row_y_;
    Vec3<double> row_z_;
    Vec3<double> linear_;
    double constant_ = 0;
    double weight_ = 0;
};

}  // namespace relief::remesh
