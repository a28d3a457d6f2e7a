#include <algorithm>
#include <optional>

#include "point_peer.h"
#include "relief/multires/ps_interpolant.h"

namespace relief::peers {

namespace {

namespace ps = multires::ps;

class ReliefPoints final : public PointPeer {
  public:
    explicit ReliefPoints(Slivers slivers) : slivers_(slivers) {}

    [[nodiscard]] std::string name() const override {
        return slivers_ == Slivers::Peeled ? "relief" : "relief, slivers kept";
    }

    [[nodiscard]] Status build(const Samples& sites) override {
        interpolant_.reset();
        ps::InterpolationOptions options;
        if (slivers_ == Slivers::Kept) options.delaunay.peel = 0;
        RELIEF_TRY(ps::Interpolant interpolant,
                   ps::Interpolant::create(sites.places, sites.values, options));
        interpolant_.emplace(std::move(interpolant));
        return {};
    }

    /// Gradients and Hessians, too.
    [[nodiscard]] Status evaluate(std::span<const Vec2> places, std::span<double> values) override {
        jets_.resize(places.size());
        RELIEF_CHECK(interpolant_->evaluate(places, jets_, ps::Outside::Nearest));
        std::transform(jets_.begin(), jets_.end(), values.begin(),
                       [](const spline::PlaneJet& jet) { return jet.value; });
        return {};
    }

    [[nodiscard]] Status raster(std::int64_t side, std::span<double> values) override {
        const double step = 1 / static_cast<double>(side);
        return interpolant_->evaluate_raster({{step / 2, step / 2}, {step, step}},
                                             {values.data(), side, side, side});
    }

  private:
    Slivers slivers_;
    std::optional<ps::Interpolant> interpolant_;
    std::vector<spline::PlaneJet> jets_;
};

}  // namespace

std::unique_ptr<PointPeer> relief_points(Slivers slivers) {
    return std::make_unique<ReliefPoints>(slivers);
}

}  // namespace relief::peers
