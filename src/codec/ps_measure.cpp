#include "codec/ps_measure.h"

#include <algorithm>
#include <cmath>

#include "relief/multires/ps_surface.h"

namespace relief::codec {

namespace ps = multires::ps;
using mesh::Index;

namespace {

ps::Heights difference(const ps::Heights& a, const ps::Heights& b) {
    return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}

}  // namespace

double PsErrors::rms() const {
    return weight > 0 ? std::sqrt(square / weight) : 0;
}

PsDataErrors::PsDataErrors(const ps::Space& space, const PsData& data)
    : space_(space), data_(data), places_(data.points.size()) {
    const mesh::TriangleLocator locator(space.mesh);
    std::vector<Index> triangles(data.points.size());
    locator.locate(data.points, triangles);
    for (std::size_t k = 0; k < triangles.size(); ++k)
        places_[k] = triangles[k] == mesh::kNone
                         ? locator.nearest(data.points[k])
                         : mesh::TrianglePlace{triangles[k], data.points[k] - space.mesh.origin};
}

Result<PsErrors> PsDataErrors::of(const LevelHeights& splines) const {
    RELIEF_TRY(const ps::Surface surface, ps::Surface::create(space_, splines));
    PsErrors errors{0, 0, 0};
    for (std::size_t k = 0; k < places_.size(); ++k) {
        const double weight = data_.weights.empty() ? 1 : data_.weights[k];
        for (std::size_t c = 0; c < splines.size(); ++c) {
            const auto jet =
                surface.jet(places_[k].triangle, places_[k].point, static_cast<int>(c));
            const double error = std::abs(jet.value - data_.values[c][k]);
            errors.max = std::max(errors.max, error);
            errors.square += weight * (error * error);
            errors.weight += weight;
        }
    }
    return errors;
}

PsErrors surface_errors(const ps::Space& space, const LevelHeights& a, const LevelHeights& b) {
    PsErrors errors{largest_difference(a, b), 0, 0};
    for (Index t = 0; t < space.mesh.triangle_count(); ++t) {
        const TriangleCorners corners = space.mesh.corners(t);
        errors.weight +=
            0.5 * orient(corners[0], corners[1], corners[2]) * static_cast<double>(a.size());
        const spline::PsMatrix mass = space.element(t).mass_matrix(space.basis(t));
        for (std::size_t c = 0; c < a.size(); ++c) {
            std::array<double, 9> off{};
            for (std::size_t k = 0; k < 3; ++k) {
                const Index v = space.mesh.triangles[t][k];
                const ps::Heights d = difference(a[c][v], b[c][v]);
                std::copy(d.begin(), d.end(), off.begin() + static_cast<std::ptrdiff_t>(3 * k));
            }
            for (std::size_t i = 0; i < 9; ++i)
                for (std::size_t j = 0; j < 9; ++j)
                    errors.square += off[i] * mass[9 * i + j] * off[j];
        }
    }
    errors.square = std::max(errors.square, 0.0);
    return errors;
}

double largest_difference(const LevelHeights& a, const LevelHeights& b) {
    double most = 0;
    for (std::size_t c = 0; c < a.size(); ++c)
        for (std::size_t v = 0; v < a[c].size(); ++v)
            for (const double d : difference(a[c][v], b[c][v])) most = std::max(most, std::abs(d));
    return most;
}

}  // namespace relief::codec
