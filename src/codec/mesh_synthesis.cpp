#include "codec/mesh_synthesis.h"

#include <algorithm>
#include <cmath>

namespace relief::codec {

namespace {

using multires::DetailFrames;

/// Details are so much smaller than their integer.
constexpr double kShrink = 0.024;

std::int64_t quotient(double x, double step, double rounding) {
    const double size = std::min(std::floor(std::abs(x) / step + rounding), kLargestQuotient);
    return static_cast<std::int64_t>(x < 0 ? -size : size);
}

double value(std::int64_t q, double step) {
    if (q == 0) return 0;
    const double size = static_cast<double>(q);
    return step * (q > 0 ? size - kShrink : size + kShrink);
}

}  // namespace

Vec3<double> base_point(const MeshQuantisation& q, int steps, const GridPoint& p) {
    const double step = q.base_step(steps);
    return {step * static_cast<double>(p[0]), step * static_cast<double>(p[1]),
            step * static_cast<double>(p[2])};
}

GridPoint base_grid_point(const MeshQuantisation& q, int steps, const Vec3<double>& p) {
    const double step = q.base_step(steps);
    const auto nearest = [&](double x) {
        const double place = std::nearbyint(x / step);
        return static_cast<std::int64_t>(std::clamp(place, -kLargestQuotient, kLargestQuotient));
    };
    return {nearest(p.x), nearest(p.y), nearest(p.z)};
}

QuantisedDetail quantised(const Vec3<double>& local, double step, double tangential,
                          double rounding) {
    return {quotient(local.x, tangential * step, rounding),
            quotient(local.y, tangential * step, rounding), quotient(local.z, step, rounding)};
}

Vec3<double> reconstructed(const QuantisedDetail& q, double step, double tangential) {
    return {value(q[0], tangential * step), value(q[1], tangential * step), value(q[2], step)};
}

Result<MeshSynthesis> MeshSynthesis::create(mesh::Topology base, multires::MeshTags tags,
                                            const MeshHeader& header, int steps) {
    MeshSynthesis synthesis;
    if (header.boundary_corners) multires::tag_boundary_corners(base, tags);
    RELIEF_TRY(auto hierarchy, multires::MeshHierarchy::create(std::move(base), std::move(tags),
                                                               header.spec, steps));
    synthesis.hierarchy_ = std::make_unique<multires::MeshHierarchy>(std::move(hierarchy));
    // Sweeps are counted from the file's finest step, whichever is the last one here.
    synthesis.transform_.lift = header.lift;
    if (header.lift == multires::LiftKind::Chebyshev)
        for (int step = 0; step < steps; ++step)
            synthesis.transform_.lifts.push_back(
                multires::default_lift(header.spec.scheme, header.levels - 1 - step));
    RELIEF_TRY(auto maps, multires::MeshMaps::create(*synthesis.hierarchy_, synthesis.transform_));
    synthesis.maps_ = std::make_unique<multires::MeshMaps>(std::move(maps));
    return synthesis;
}

void MeshSynthesis::refine(const MeshQuantisation& q, int steps, int step,
                           const QuantisedStep& details, const DetailFrames& frames,
                           MeshPoints& points) const {
    const double size = q.step_of(step, steps);
    MeshPoints stiff;
    const std::size_t coarse = points.size();
    for (const QuantisedDetail& detail : details.fresh)
        points.push_back(reconstructed(detail, size, q.tangential));
    for (const QuantisedDetail& detail : details.stiff)
        stiff.push_back(reconstructed(detail, size, q.tangential));
    frames.out(points.data() + coarse, stiff);
    maps_->synthesise_global(step, points.data(), stiff);
}

multires::LocalDetails local_details(const MeshQuantisation& q, int steps, int step,
                                     const QuantisedStep& details, const DetailFrames& frames) {
    const double size = q.step_of(step, steps);
    const auto local = [&](const std::vector<QuantisedDetail>& some,
                           const std::vector<multires::MeshFrame>& of) {
        std::vector<multires::LocalDetail> result(some.size());
        for (std::size_t k = 0; k < some.size(); ++k)
            result[k] = {reconstructed(some[k], size, q.tangential), of[k].size};
        return result;
    };
    return {local(details.fresh, frames.fresh()), local(details.stiff, frames.stiff())};
}

void MeshSynthesis::refine_moved(int step, const multires::LocalDetails& details,
                                 MeshPoints& moved) const {
    const multires::GlobalDetails turned =
        multires::turned(details, DetailFrames(*hierarchy_, step, moved.data()));
    moved.insert(moved.end(), turned.fresh.begin(), turned.fresh.end());
    maps_->synthesise_global(step, moved.data(), turned.stiff);
}

}  // namespace relief::codec
