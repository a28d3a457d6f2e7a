#include "remesh/align.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace relief::remesh {

namespace {

using mesh::Index;
using multires::DetailFrames;
using multires::MeshHierarchy;
using multires::MeshMaps;
using Point = Vec3<double>;
using Points = std::vector<Point>;

/// The new vertices of a step that lie on curves: their details stay whole.
std::vector<std::uint8_t> on_curves(const MeshHierarchy& hierarchy, int step) {
    const mesh::Topology& coarse = hierarchy.topology(step);
    std::vector<std::uint8_t> curve(coarse.edge_count, 0);
    for (Index h = 0; h < coarse.half_edge_count(); ++h)
        if (hierarchy.tags(step).is_sharp(coarse, h)) curve[coarse.edge[h]] = 1;
    return curve;
}

/// visit(detail, its part along the normal) for all details that may lose the rest, coarse to fine;
/// `points` are coefficients and become the mesh that they give then.
template <class Visit>
void synthesise(const MeshMaps& maps, const MeshHierarchy& hierarchy, Points& points,
                const Visit& visit) {
    for (int step = 0; step < hierarchy.steps(); ++step) {
        const DetailFrames frames(hierarchy, step, points.data());
        const std::vector<std::uint8_t> curve = on_curves(hierarchy, step);
        Point* details = points.data() + hierarchy.vertices(step);
        for (std::size_t k = 0; k < curve.size(); ++k) {
            const multires::MeshFrame& frame = frames.fresh()[k];
            if (curve[k] || frame.size == 0) continue;
            visit(details[k], dot(frame.normal, details[k]) * frame.normal);
        }
        maps.synthesise_step(step, points.data(), {});
    }
}

}  // namespace

Status align(MovingMesh& mesh, const MeshHierarchy& hierarchy, int rounds) {
    RELIEF_TRY(const MeshMaps maps, MeshMaps::create(hierarchy, {}));
    for (int round = 0; round < rounds; ++round) {
        Points wanted = mesh.points;
        multires::StiffResiduals none;
        maps.analyse(wanted.data(), none);
        synthesise(maps, hierarchy, wanted,
                   [](Point& detail, const Point& normal) { detail = normal; });
        const std::vector<double> limits = mesh.edge_lengths();
        for (std::size_t v = 0; v < wanted.size(); ++v) {
            wanted[v] -= mesh.points[v];
            const double size = length(wanted[v]);
            if (size > limits[v]) wanted[v] = limits[v] / size * wanted[v];
        }
        mesh.move(wanted);
    }
    return {};
}

Result<double> tangential_rms(const MovingMesh& mesh, const MeshHierarchy& hierarchy) {
    RELIEF_TRY(const MeshMaps maps, MeshMaps::create(hierarchy, {}));
    Points coefficients = mesh.points;
    multires::StiffResiduals none;
    maps.analyse(coefficients.data(), none);
    double sum = 0;
    std::size_t count = 0;
    synthesise(maps, hierarchy, coefficients, [&](Point& detail, const Point& normal) {
        sum += dot(detail - normal, detail - normal);
        ++count;
    });
    return std::sqrt(sum / static_cast<double>(std::max<std::size_t>(count, 1)));
}

}  // namespace relief::remesh
