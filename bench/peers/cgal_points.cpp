#include <CGAL/Delaunay_triangulation_2.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Interpolation_gradient_fitting_traits_2.h>
#include <CGAL/Interpolation_traits_2.h>
#include <CGAL/Spatial_sort_traits_adapter_2.h>
#include <CGAL/Triangulation_vertex_base_with_info_2.h>
#include <CGAL/interpolation_functions.h>
#include <CGAL/natural_neighbor_coordinates_2.h>
#include <CGAL/property_map.h>
#include <CGAL/sibson_gradient_fitting.h>
#include <CGAL/spatial_sort.h>

#include <boost/iterator/function_output_iterator.hpp>
#include <numeric>

#include "point_peer.h"

namespace relief::peers {

namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Point = Kernel::Point_2;

struct Site {
    double value = 0;
    std::pair<Kernel::Vector_2, bool> gradient{CGAL::NULL_VECTOR, false};
};
using Vertex = CGAL::Triangulation_vertex_base_with_info_2<Site, Kernel>;
using Triangulation =
    CGAL::Delaunay_triangulation_2<Kernel, CGAL::Triangulation_data_structure_2<Vertex>>;
using VertexHandle = Triangulation::Vertex_handle;
using Weight = std::pair<VertexHandle, double>;

std::pair<double, bool> value_of(VertexHandle v) {
    return {v->info().value, true};
}
std::pair<Kernel::Vector_2, bool> gradient_of(VertexHandle v) {
    return v->info().gradient;
}

/// Sibson's C1 interpolant of natural neighbours, in the variant without square roots.
class CgalPoints final : public PointPeer {
  public:
    [[nodiscard]] std::string name() const override { return "CGAL, Sibson C1"; }

    [[nodiscard]] Status build(const Samples& sites) override {
        std::vector<std::pair<Point, Site>> points;
        for (std::size_t k = 0; k < sites.places.size(); ++k)
            points.emplace_back(Point(sites.places[k].x, sites.places[k].y), Site{sites.values[k]});
        mesh_ = Triangulation(points.begin(), points.end());
        using Fitted = std::pair<VertexHandle, Kernel::Vector_2>;
        CGAL::sibson_gradient_fitting_nn_2(
            mesh_, boost::make_function_output_iterator([](const Fitted& fitted) {
                fitted.first->info().gradient = {fitted.second, true};
            }),
            CGAL::Identity<Fitted>(), value_of,
            CGAL::Interpolation_gradient_fitting_traits_2<Kernel>());
        return {};
    }

    [[nodiscard]] Status evaluate(std::span<const Vec2> places, std::span<double> values) override {
        std::vector<Point> points;
        for (const Vec2 place : places) points.emplace_back(place.x, place.y);
        std::vector<std::size_t> order(points.size());
        std::iota(order.begin(), order.end(), std::size_t{0});
        const auto place_of = CGAL::make_property_map(points);
        CGAL::spatial_sort(
            order.begin(), order.end(),
            CGAL::Spatial_sort_traits_adapter_2<Kernel, decltype(place_of)>(place_of));
        Triangulation::Face_handle face;
        for (const std::size_t k : order) values[k] = value_at(points[k], face);
        return {};
    }

    [[nodiscard]] Status raster(std::int64_t side, std::span<double> values) override {
        const double step = 1 / static_cast<double>(side);
        Triangulation::Face_handle face;
        for (std::size_t k = 0; k < values.size(); ++k) {
            const auto row = static_cast<std::int64_t>(k) / side;
            const auto col = static_cast<std::int64_t>(k) % side;
            values[k] = value_at(
                {step * (static_cast<double>(col) + 0.5), step * (static_cast<double>(row) + 0.5)},
                face);
        }
        return {};
    }

  private:
    /// `face`: where the search begins and where it ended. Vertices of the hull have no gradients:
    /// linear beside them.
    double value_at(const Point& point, Triangulation::Face_handle& face) {
        face = mesh_.locate(point, face);
        weights_.clear();
        const auto found = CGAL::natural_neighbor_coordinates_2(
            mesh_, point, std::back_inserter(weights_), CGAL::Identity<Weight>(), face);
        const auto smooth = CGAL::sibson_c1_interpolation_square(
            weights_.begin(), weights_.end(), found.second, point, value_of, gradient_of,
            CGAL::Interpolation_traits_2<Kernel>());
        return smooth.second ? smooth.first
                             : CGAL::linear_interpolation(weights_.begin(), weights_.end(),
                                                          found.second, value_of);
    }

    Triangulation mesh_;
    std::vector<Weight> weights_;
};

}  // namespace

std::unique_ptr<PointPeer> cgal_points() {
    return std::make_unique<CgalPoints>();
}

}  // namespace relief::peers
