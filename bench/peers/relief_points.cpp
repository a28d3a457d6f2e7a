#include <algorithm>
#include <optional>

#include "point_peer.h"
#include "relief/mesh/delaunay.h"
#include "relief/multires/ps_gradients.h"
#include "relief/multires/ps_surface.h"

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
        locator_.reset();
        surface_.reset();
        mesh::DelaunayOptions options;
        if (slivers_ == Slivers::Kept) options.peel = 0;
        RELIEF_TRY(mesh::Delaunay delaunay, mesh::delaunay(sites.places, options));
        std::vector<double> values(delaunay.mesh.vertex_count());
        for (std::size_t k = 0; k < sites.values.size(); ++k)
            values[delaunay.vertex_of_point[k]] = sites.values[k];
        RELIEF_TRY(const std::vector<Vec2> gradients,
                   ps::estimate_gradients(delaunay.mesh, values));
        RELIEF_TRY(space_, ps::make_space(std::move(delaunay.mesh)));
        ps::TangentPlanes planes(values.size());
        std::transform(values.begin(), values.end(), gradients.begin(), planes.begin(),
                       [](double value, Vec2 gradient) {
                           return spline::TangentPlane{value, gradient};
                       });
        const ps::Coefficients spline = ps::coefficients(space_, planes);
        RELIEF_TRY(surface_, ps::Surface::create(space_, std::span(&spline, 1)));
        locator_.emplace(space_.mesh);
        return {};
    }

    /// Gradients and Hessians, too.
    [[nodiscard]] Status evaluate(std::span<const Vec2> places, std::span<double> values) override {
        jets_.resize(places.size());
        RELIEF_CHECK(ps::evaluate(*surface_, *locator_, places, jets_, ps::Outside::Nearest));
        std::transform(jets_.begin(), jets_.end(), values.begin(),
                       [](const spline::PlaneJet& jet) { return jet.value; });
        return {};
    }

    [[nodiscard]] Status raster(std::int64_t side, std::span<double> values) override {
        const double step = 1 / static_cast<double>(side);
        return ps::evaluate_raster(*surface_, {{step / 2, step / 2}, {step, step}},
                                   {values.data(), side, side, side});
    }

  private:
    Slivers slivers_;
    ps::Space space_;
    std::optional<ps::Surface> surface_;
    std::optional<mesh::TriangleLocator> locator_;
    std::vector<spline::PlaneJet> jets_;
};

}  // namespace

std::unique_ptr<PointPeer> relief_points(Slivers slivers) {
    return std::make_unique<ReliefPoints>(slivers);
}

}  // namespace relief::peers
