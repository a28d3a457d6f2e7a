#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <limits>
#include <span>

#include "multires/mesh_support.h"
#include "relief/multires/mesh_hierarchy.h"

/// What holds for meshes of all kinds: closed, open and creased, of genus 0 to 3, of several
/// components, with valences from 3 to 12.
namespace relief::multires {
namespace {

using mesh::Index;
using test::noisy;
using test::Points;
using test::points_of;
using test::Shape;

/// Two pyramids of n sides over each other.
Shape bipyramid(Index n) {
    Shape shape{{}, {{0, 0, 1.5}, {0, 0, -1.5}}};
    for (Index k = 0; k < n; ++k) {
        shape.points.push_back({std::cos(2 * M_PI * k / n), std::sin(2 * M_PI * k / n), 0.1 * k});
        shape.add({0, 2 + k, 2 + (k + 1) % n});
        shape.add({1, 2 + (k + 1) % n, 2 + k});
    }
    return shape;
}

/// A slab of quads with so many holes.
Shape slab(int genus) {
    std::set<test::Cell> cells;
    for (int x = 0; x < 2 * genus + 1; ++x)
        for (int y = 0; y < 3; ++y)
            if (y != 1 || x % 2 == 0) cells.insert({x, y, 0});
    return test::voxels(cells);
}

/// The whole range from the first sample on.
template <class T>
T any_of(T begin, T end) {
    return *rc::gen::resize(rc::kNominalSize, rc::gen::inRange(begin, end));
}

struct Sample {
    std::string text;
    Shape base;
    MeshHierarchy hierarchy;
    MeshTransform transform;
};

Shape any_base(bool triangles) {
    const int kind = any_of(0, 5);
    const auto flips = any_of(0, 40);
    const auto seed = any_of(0U, 1000U);
    const auto mixed = [&](const Shape& shape) {
        return triangles ? test::flipped(shape, flips, seed) : shape;
    };
    if (kind == 0) return mixed(test::icosahedron());
    if (kind == 1) return mixed(test::grid(4, 3, triangles));
    if (kind == 2) return bipyramid(any_of(3U, 13U));
    const Shape holes = slab(any_of(0, 4));
    if (kind == 3) return triangles ? mixed(test::triangulated(holes)) : holes;
    return test::both(test::tetrahedron(), mixed(test::grid(4, 5, triangles, true)));
}

Sample any_sample(int most_steps) {
    const auto scheme =
        *rc::gen::element(MeshScheme::Sqrt3, MeshScheme::Loop, MeshScheme::CatmullClark);
    const int steps = any_of(1, most_steps + 1);
    Shape base = any_base(scheme != MeshScheme::CatmullClark);
    mesh::Topology mesh = base.topology();
    const bool creased = scheme != MeshScheme::Sqrt3 && *rc::gen::arbitrary<bool>();
    const MeshTags tags = creased ? test::some_tags(mesh, any_of(0U, 1000U)) : MeshTags();
    const MeshTransform transform{.local_frames = *rc::gen::arbitrary<bool>()};
    std::string text = std::string(mesh_scheme_name(scheme)) + ", " + std::to_string(steps) +
                       " steps, " + std::to_string(base.size()) + " vertices" +
                       (creased ? ", creased" : "");
    auto hierarchy = MeshHierarchy::create(std::move(mesh), tags, {.scheme = scheme}, steps);
    return {std::move(text), std::move(base), *std::move(hierarchy), transform};
}

double extent(const Points& points) {
    Vec3<double> low = points[0];
    Vec3<double> high = points[0];
    for (const auto& p : points) {
        low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
        high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
    }
    return std::max({high.x - low.x, high.y - low.y, high.z - low.z});
}

/// A subdivision surface with noise.
Points surface(const Sample& sample, double noise) {
    Points points = points_of(sample.base);
    points.resize(sample.hierarchy.vertices(sample.hierarchy.steps()));
    StiffResiduals residuals;
    for (int step = 0; step < sample.hierarchy.steps(); ++step)
        residuals.emplace_back(sample.hierarchy.rules(step).stiff.size());
    MeshMaps::create(sample.hierarchy, {})
        ->synthesise(0, sample.hierarchy.steps(), points.data(), residuals);
    return noisy(points, 8, noise);
}

double largest_coordinate(const Points& a, const Points& b) {
    double largest = 0;
    for (std::size_t k = 0; k < a.size(); ++k)
        largest = std::max({largest, std::abs(a[k].x - b[k].x), std::abs(a[k].y - b[k].y),
                            std::abs(a[k].z - b[k].z)});
    return largest;
}

/// What rounding is amplified by: a coarse vertex that is nearly lost (D of Loop vertices with
/// three edges is 1/10, and 1/16 if one of them is sharp) passes it on to the next coarser step by
/// 1 / D.
double amplification(const MeshHierarchy& hierarchy) {
    double factor = 1;
    for (int step = 0; step + 1 < hierarchy.steps(); ++step) {
        double weakest = 1;
        for (const double self :
             std::span(hierarchy.rules(step).self.data(), hierarchy.vertices(step)))
            if (self != 0) weakest = std::min(weakest, std::abs(self));
        if (weakest < 0.15) factor /= weakest;
    }
    return factor;
}

/// Largest difference of coordinates, in amplified units in the last place of the extent.
double error_of(const Sample& sample, const Points& a, const Points& b) {
    return largest_coordinate(a, b) /
           (extent(b) * std::numeric_limits<double>::epsilon() * amplification(sample.hierarchy));
}

/// To 4 units in the last place of the extent.
RC_GTEST_PROP(MeshProperties, RoundTrip, ()) {
    const Sample sample = any_sample(3);
    RC_LOG() << sample.text;
    const Points points = surface(sample, 0.02);
    const MeshMaps maps = *MeshMaps::create(sample.hierarchy, sample.transform);
    Points coefficients = points;
    StiffResiduals residuals;
    maps.analyse(coefficients.data(), residuals);
    maps.synthesise(0, sample.hierarchy.steps(), coefficients.data(), residuals);
    RC_ASSERT(error_of(sample, coefficients, points) <= 4);
}

/// Control points to 1e-12, details to 1e-13, of the extent.
RC_GTEST_PROP(MeshProperties, PureSurfaces, ()) {
    const Sample sample = any_sample(3);
    RC_LOG() << sample.text;
    Points points = surface(sample, 0);
    const double size = extent(points);
    StiffResiduals residuals;
    MeshMaps::create(sample.hierarchy, sample.transform)->analyse(points.data(), residuals);
    const Points base = points_of(sample.base);
    for (std::size_t v = 0; v < base.size(); ++v)
        RC_ASSERT(length(points[v] - base[v]) <= 1e-12 * size);
    for (std::size_t v = base.size(); v < points.size(); ++v)
        RC_ASSERT(length(points[v]) <= 1e-13 * size);
}

/// A hundred walks from the finest level to some coarser one and back.
RC_GTEST_PROP(MeshProperties, HundredLevelChanges, ()) {
    const Sample sample = any_sample(2);
    RC_LOG() << sample.text;
    const Points points = surface(sample, 0.02);
    const MeshMaps maps = *MeshMaps::create(sample.hierarchy, sample.transform);
    Points walked = points;
    StiffResiduals residuals(static_cast<std::size_t>(sample.hierarchy.steps()));
    for (int change = 0; change < 100; ++change) {
        const int down = change % sample.hierarchy.steps();
        for (int step = sample.hierarchy.steps() - 1; step >= down; --step)
            maps.analyse_step(step, walked.data(), residuals[static_cast<std::size_t>(step)]);
        maps.synthesise(down, sample.hierarchy.steps(), walked.data(), residuals);
    }
    RC_ASSERT(error_of(sample, walked, points) <= 100 * 4);
}

}  // namespace
}  // namespace relief::multires
