#include "relief/multires/ps_gradients.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>

#include "multires/ps_gradient_rules.h"
#include "multires/ps_local_fits.h"
#include "relief/core/buffer.h"
#include "relief/core/parallel.h"

namespace relief::multires::ps {

namespace {

using mesh::Index;
using mesh::Triangulation;
using mesh::VertexStars;

constexpr double kLargest = 1e150;
constexpr std::size_t kEnough = 15;
constexpr std::int64_t kGrain = 1024;
static_assert(kGrain % kFitLanes == 0);

/// What pass 1 leaves of a vertex.
struct VertexFits {
    std::array<Vec2, kDegrees> gradient;
    std::array<double, kDegrees> error;
    double zero_error;
    double plain;
    double curved;
};

/// Pass 1 for some vertices: stencils are gathered for kFitLanes of them and fitted together.
class FirstPass {
  public:
    FirstPass(const Triangulation& mesh, const VertexStars& neighbours,
              std::span<const double> values)
        : mesh_(mesh), values_(values), search_(mesh, neighbours) {}

    void run(Index begin, Index end, VertexFits* out) {
        for (Index v = begin; v < end; v += kFitLanes) {
            const auto lanes = std::min<std::size_t>(kFitLanes, end - v);
            stencils_ = {};
            for (std::size_t lane = 0; lane < lanes; ++lane)
                gather(v + static_cast<Index>(lane), lane);
            fit_stencils(stencils_, fits_);
            for (std::size_t lane = 0; lane < lanes; ++lane) out[v + lane] = result(lane);
        }
    }

  private:
    void gather(Index v, std::size_t lane) {
        const auto points = search_.nearest(v, kEnough, kStencilSize);
        const Vec2 centre = mesh_.vertex(v);
        double squares = 0;
        for (const Index w : points) {
            const Vec2 d = mesh_.vertex(w) - centre;
            squares += dot(d, d);
        }
        const auto count = static_cast<double>(points.size());
        size_[lane] = std::sqrt(squares / count);
        for (std::size_t q = 0; q < points.size(); ++q) {
            const Vec2 d = mesh_.vertex(points[q]) - centre;
            stencils_.dx[q][lane] = d.x / size_[lane];
            stencils_.dy[q][lane] = d.y / size_[lane];
            stencils_.dz[q][lane] = values_[points[q]] - values_[v];
            stencils_.present[q][lane] = 1;
        }
        stencils_.count[lane] = count;
        stencils_.rows = std::max(stencils_.rows, points.size());
    }

    [[nodiscard]] VertexFits result(std::size_t lane) const {
        VertexFits fits{};
        for (std::size_t d = 0; d < kDegrees; ++d) {
            fits.gradient[d] = {fits_.gradient[d][0][lane] / size_[lane],
                                fits_.gradient[d][1][lane] / size_[lane]};
            fits.error[d] = fits_.error[d][lane];
        }
        fits.zero_error = fits_.zero_error[lane];
        fits.plain = fits_.plain[lane];
        fits.curved = fits_.curved[lane];
        return fits;
    }

    const Triangulation& mesh_;
    std::span<const double> values_;
    StencilSearch search_;
    FitStencils stencils_{};
    LocalFits fits_{};
    std::array<double, kFitLanes> size_{};
};

/// Pass 2: the fits of a vertex and its neighbours become its gradient.
class SecondPass {
  public:
    SecondPass(const Triangulation& mesh, const VertexStars& neighbours,
               const VertexStars& triangles, std::span<const double> values, const VertexFits* fits,
               const GradientOptions& options)
        : mesh_(mesh),
          neighbours_(neighbours),
          triangles_(triangles),
          values_(values),
          fits_(fits),
          options_(options) {}

    [[nodiscard]] Vec2 gradient(Index v) const {
        const Blend blend = blended(v);
        Vec2 g = blend.gradient;
        if (options_.tilt > 0) g = g + tilt(v, blend.linear_share);
        return limited(v, g);
    }

  private:
    /// Errors are compared after the third power; curved fits count a tenth of the plane.
    static constexpr double kCurvedFavour = 0.1;
    static constexpr double kSteeper = 0.3;
    static constexpr double kMostError = 1e30;
    static constexpr double kLeastError = 1e-300;
    static constexpr double kMostRatio = 1e6;

    struct Blend {
        Vec2 gradient;
        double linear_share = 0;
    };

    template <class Of>
    [[nodiscard]] double star_mean(Index v, Of&& of) const {
        double sum = std::min(of(fits_[v]), kMostError);
        const auto around = neighbours_.of(v);
        for (const Index w : around) sum += std::min(of(fits_[w]), kMostError);
        return std::max(sum / static_cast<double>(around.size() + 1), kLeastError);
    }

    [[nodiscard]] Blend blended(Index v) const {
        std::array<double, kDegrees> mean{};
        for (std::size_t d = 0; d < kDegrees; ++d)
            mean[d] = star_mean(v, [d](const VertexFits& f) { return f.error[d]; });
        const double zero = star_mean(v, [](const VertexFits& f) { return f.zero_error; });
        const double least = *std::min_element(mean.begin(), mean.end());
        std::array<double, kDegrees> weight{};
        double sum = 0;
        for (std::size_t d = 0; d < kDegrees; ++d) {
            const double ratio = least / mean[d];
            weight[d] = (d == kLinear ? 1 : kCurvedFavour) * ratio * ratio * ratio;
            sum += weight[d];
        }
        const VertexFits& own = fits_[v];
        Blend blend;
        for (std::size_t d = 0; d < kDegrees; ++d) {
            if (std::isinf(own.error[d])) continue;
            const double share = weight[d] / sum;
            const double more = d == kLinear ? kSteeper * std::min(1.0, mean[kLinear] / zero) : 0;
            blend.gradient = blend.gradient + share * (1 + more) * own.gradient[d];
            if (d == kLinear) blend.linear_share = share;
        }
        return blend;
    }

    /// Towards the surface that a value without its noise would give: what the neighbours say of
    /// the vertices around, times the tilt that keeps a raised vertex's surface lowest.
    [[nodiscard]] Vec2 tilt(Index v, double linear_share) const {
        double plain = fits_[v].plain * fits_[v].plain;
        double curved = fits_[v].curved * fits_[v].curved;
        for (const Index w : neighbours_.of(v)) {
            plain += fits_[w].plain * fits_[w].plain;
            curved += fits_[w].curved * fits_[w].curved;
        }
        const double q =
            curved > 0 ? std::min(plain / curved, kMostRatio) : (plain > 0 ? kMostRatio : 0);
        const double q2 = q * q;
        const double off = (fits_[v].plain + q2 * fits_[v].curved) / (1 + q2);
        const double amount = -options_.tilt / (1 + q2 * q2) * linear_share * off;
        return amount * lowest_tilt(v);
    }

    /// The gradient at v that minimises the mean square of the surface which is 1 there and 0 at
    /// all other vertices: element integrals of the symmetric split.
    [[nodiscard]] Vec2 lowest_tilt(Index v) const {
        double xx = 0;
        double xy = 0;
        double yy = 0;
        Vec2 m;
        for (const Index t : triangles_.of(v)) {
            const auto& corner = mesh_.triangles[t];
            const std::size_t k = corner[0] == v ? 0 : corner[1] == v ? 1 : 2;
            const Vec2 e1 = mesh_.vertex(corner[(k + 1) % 3]) - mesh_.vertex(v);
            const Vec2 e2 = mesh_.vertex(corner[(k + 2) % 3]) - mesh_.vertex(v);
            const double area = 0.5 * cross(e1, e2);
            xx += area * (3 * (e1.x * e1.x + e2.x * e2.x) + 4 * e1.x * e2.x);
            xy += area * (3 * (e1.x * e1.y + e2.x * e2.y) + 2 * (e1.x * e2.y + e1.y * e2.x));
            yy += area * (3 * (e1.y * e1.y + e2.y * e2.y) + 4 * e1.y * e2.y);
            m = m + area * (e1 + e2);
        }
        const double scale = -20.2 / (xx * yy - xy * xy);
        return {scale * (yy * m.x - xy * m.y), scale * (xx * m.y - xy * m.x)};
    }

    /// Half-way to the neighbours the plane of v stays near the range of the values around it.
    [[nodiscard]] Vec2 limited(Index v, Vec2 g) const {
        if (std::isinf(options_.limit)) return g;
        double low = values_[v];
        double high = low;
        for (const Index w : neighbours_.of(v)) {
            low = std::min(low, values_[w]);
            high = std::max(high, values_[w]);
        }
        const double spare = options_.limit * (high - low);
        const double up = high - values_[v] + spare;
        const double down = values_[v] - low + spare;
        double factor = 1;
        for (const Index w : neighbours_.of(v)) {
            const double rise = 0.5 * dot(g, mesh_.vertex(w) - mesh_.vertex(v));
            if (rise > up) factor = std::min(factor, up / rise);
            if (-rise > down) factor = std::min(factor, down / -rise);
        }
        return factor * g;
    }

    const Triangulation& mesh_;
    const VertexStars& neighbours_;
    const VertexStars& triangles_;
    std::span<const double> values_;
    const VertexFits* fits_;
    const GradientOptions& options_;
};

Status check(const Triangulation& mesh, std::span<const double> values,
             const GradientOptions& options) {
    if (!(options.tilt >= 0) || std::isinf(options.tilt) || !(options.limit >= 0))
        return Error{ErrorCode::InvalidArgument,
                     "invalid_parameter: tilt and limit are numbers from 0 on", "gradients"};
    if (values.size() != mesh.vertex_count())
        return Error{ErrorCode::BadInput,
                     "size_mismatch: " + std::to_string(values.size()) + " values for " +
                         std::to_string(mesh.vertex_count()) + " vertices",
                     "gradients"};
    const auto bad = std::find_if(values.begin(), values.end(),
                                  [](double z) { return !(std::abs(z) <= kLargest); });
    if (bad == values.end()) return {};
    return Error{ErrorCode::BadInput,
                 "non_finite_data: its value is not a number of at most 1e150; remove the vertex "
                 "or correct it",
                 "vertex " + std::to_string(bad - values.begin())};
}

}  // namespace

Result<GradientRule> gradient_rule_from_name(std::string_view name) {
    using enum GradientRule;
    if (name == "adaptive") return Adaptive;
    if (name == "quadratic") return Quadratic;
    if (name == "plane") return Plane;
    if (name == "zero") return Zero;
    return Error{
        ErrorCode::InvalidArgument,
        "gradients are adaptive, quadratic, plane or zero, not '" + std::string(name) + "'", ""};
}

Result<std::vector<Vec2>> estimate_gradients(const Triangulation& mesh,
                                             std::span<const double> values,
                                             const GradientOptions& options) {
    RELIEF_CHECK(check(mesh, values, options));
    std::vector<Vec2> gradients(mesh.vertex_count());
    if (options.rule == GradientRule::Zero) return gradients;
    const VertexStars neighbours = mesh::vertex_neighbours(mesh);
    if (options.rule == GradientRule::Quadratic) {
        parallel_for(0, mesh.vertex_count(), kGrain, [&](std::int64_t begin, std::int64_t end) {
            StencilSearch search(mesh, neighbours);
            for (auto v = static_cast<Index>(begin); v < static_cast<Index>(end); ++v)
                gradients[v] = quadratic_gradient(mesh, values, v, search);
        });
        return gradients;
    }
    Buffer<VertexFits> fits(mesh.vertex_count());
    parallel_for(0, mesh.vertex_count(), kGrain, [&](std::int64_t begin, std::int64_t end) {
        FirstPass(mesh, neighbours, values)
            .run(static_cast<Index>(begin), static_cast<Index>(end), fits.data());
    });
    if (options.rule == GradientRule::Plane) {
        for (Index v = 0; v < mesh.vertex_count(); ++v) gradients[v] = fits[v].gradient[kLinear];
        return gradients;
    }
    const VertexStars triangles = mesh::vertex_triangles(mesh);
    const SecondPass second(mesh, neighbours, triangles, values, fits.data(), options);
    parallel_for(0, mesh.vertex_count(), kGrain, [&](std::int64_t begin, std::int64_t end) {
        for (auto v = static_cast<Index>(begin); v < static_cast<Index>(end); ++v)
            gradients[v] = second.gradient(v);
    });
    return gradients;
}

}  // namespace relief::multires::ps
