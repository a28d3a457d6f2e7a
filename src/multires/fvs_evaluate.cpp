#include <algorithm>
#include <cmath>

#include "multires/fvs_functionals.h"
#include "relief/core/parallel.h"

namespace relief::multires::fvs_mesh {

using mesh::Index;
using mesh::Quadrangulation;

namespace {

constexpr std::int64_t kGrain = 256;

/// Evaluates at consecutive points; keeps the ordinates of the last quad.
class Evaluator {
  public:
    Evaluator(const Quadrangulation& mesh, const NodalData& data) : mesh_(mesh), data_(data) {}

    spline::PlaneJet operator()(const mesh::Place& place) {
        if (!element_ || place.quad != quad_) {
            quad_ = place.quad;
            element_.emplace(mesh_.corners(quad_));
            ordinates_ = element_->ordinates(quad_data(mesh_, data_, quad_));
        }
        return element_->jet(ordinates_, place.point);
    }

  private:
    const Quadrangulation& mesh_;
    const NodalData& data_;
    Index quad_ = 0;
    std::optional<spline::FvsElement> element_;
    spline::FvsOrdinates ordinates_;
};

}  // namespace

std::optional<mesh::Place> locate(const Hierarchy& hierarchy, int level, Vec2 point,
                                  Outside outside) {
    std::optional<mesh::Place> place = hierarchy.locator().locate(point);
    const bool finite = std::isfinite(point.x) && std::isfinite(point.y);
    if (!place && outside == Outside::Clamp && finite) place = hierarchy.locator().nearest(point);
    for (int m = 0; place && m < level; ++m)
        place->quad = mesh::child_of(hierarchy.mesh(m), hierarchy.mesh(m + 1), *place);
    return place;
}

Status evaluate(const Hierarchy& hierarchy, int level, const NodalData& data,
                std::span<const Vec2> points, std::span<spline::PlaneJet> out, Outside outside) {
    if (level < 0 || level > hierarchy.levels()) return bad_level(level, hierarchy.levels());
    const Quadrangulation& mesh = hierarchy.mesh(level);
    if (!fits(mesh, data) || points.size() != out.size())
        return bad_data(
            "size_mismatch: the data must be those of the level, and every point "
            "needs a place for its result");
    std::vector<std::uint8_t> missed(points.size());
    parallel_for(0, static_cast<std::int64_t>(points.size()), kGrain,
                 [&](std::int64_t first, std::int64_t last) {
                     Evaluator evaluator(mesh, data);
                     for (std::int64_t k = first; k < last; ++k) {
                         const auto place = locate(hierarchy, level, points[k], outside);
                         if (place)
                             out[k] = evaluator(*place);
                         else
                             missed[k] = 1;
                     }
                 });
    const auto first = std::find(missed.begin(), missed.end(), 1);
    if (first == missed.end()) return {};
    return bad_data("outside_domain: no quad contains the point; leave it out or clamp it",
                    "point " + std::to_string(first - missed.begin()));
}

double l2_norm(const Quadrangulation& mesh, const NodalData& data) {
    double sum = 0;
    for (Index q = 0; q < mesh.quad_count(); ++q) {
        const auto numbers = spline::fvs_flat(quad_data(mesh, data, q));
        const auto mass = spline::FvsElement(mesh.corners(q)).mass_matrix();
        for (std::size_t i = 0; i < 16; ++i)
            for (std::size_t j = 0; j < 16; ++j) sum += mass[16 * i + j] * numbers[i] * numbers[j];
    }
    return std::sqrt(std::max(sum, 0.0));
}

}  // namespace relief::multires::fvs_mesh
