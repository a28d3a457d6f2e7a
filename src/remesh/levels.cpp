#include "remesh/levels.h"

#include <algorithm>
#include <utility>

#include "relief/core/parallel.h"
#include "relief/mesh/split.h"

namespace relief::remesh {

namespace {

using mesh::Index;
using mesh::kNone;
using mesh::Topology;
using Point = Vec3<double>;

constexpr std::int64_t kGrain = 512;
/// How often new vertices are moved nearer to the middles of their edges.
constexpr int kCorrections = 2;

multires::MeshTags tags_of(const Topology& base, const Surface& surface,
                           const Simplification& simple) {
    multires::MeshTags tags;
    for (Index h = 0; h < base.half_edge_count(); ++h) {
        if (!simple.sharp()[h] || base.on_boundary(h)) continue;
        tags.sharp.resize(base.edge_count, 0);
        tags.sharp[base.edge[h]] = 1;
    }
    for (Index v = 0; v < base.vertex_count; ++v) {
        if (surface.kinds[simple.vertices()[v]] != VertexKind::Corner) continue;
        tags.corner.resize(base.vertex_count, 0);
        tags.corner[v] = 1;
    }
    return tags;
}

/// Where the corners of the faces of a depth are in the faces of the base.
std::vector<std::array<Place, 3>> places_on_base(std::size_t base_faces, int depth) {
    std::vector<std::array<Place, 3>> faces;
    for (Index f = 0; f < base_faces; ++f)
        faces.push_back({Place{f, {1, 0, 0}}, Place{f, {0, 1, 0}}, Place{f, {0, 0, 1}}});
    const auto middle = [](const Place& a, const Place& b) {
        Place m = a;
        for (std::size_t k = 0; k < 3; ++k) m.weights[k] = (a.weights[k] + b.weights[k]) / 2;
        return m;
    };
    for (int step = 0; step < depth; ++step) {
        std::vector<std::array<Place, 3>> finer;
        finer.reserve(4 * faces.size());
        for (const auto& [a, b, c] : faces) {  // as mesh::refine does
            const Place ab = middle(a, b);
            const Place bc = middle(b, c);
            const Place ca = middle(c, a);
            finer.insert(finer.end(), {{a, ab, ca}, {b, bc, ab}, {c, ca, bc}, {ab, bc, ca}});
        }
        faces = std::move(finer);
    }
    return faces;
}

std::span<const Index> corners_of(const Topology& mesh) {
    return {mesh.origin.data(), mesh.origin.size()};
}

}  // namespace

Levels::Levels(const Surface& surface, Simplification base, multires::MeshHierarchy hierarchy)
    : surface_(&surface), base_(std::move(base)), hierarchy_(std::move(hierarchy)) {
    find_chains();
}

Result<Levels> Levels::create(const Surface& surface, Simplification base, int steps) {
    RELIEF_TRY(Topology topology,
               mesh::build(base.faces(), static_cast<Index>(base.vertices().size())));
    multires::MeshTags tags = tags_of(topology, surface, base);
    RELIEF_TRY(auto hierarchy,
               multires::MeshHierarchy::create(std::move(topology), std::move(tags),
                                               {.scheme = multires::MeshScheme::Loop}, steps));
    return Levels(surface, std::move(base), std::move(hierarchy));
}

void Levels::find_chains() {
    const Topology& base = hierarchy_.topology(0);
    const Topology& fine = surface_->mesh;
    const Buffer<Index> out = mesh::outgoing(fine);
    std::vector<Index> number(fine.vertex_count, kNone);
    for (Index v = 0; v < base.vertex_count; ++v) number[base_.vertices()[v]] = v;
    // The sharp half-edge that goes on from the end of one; at most one where no curves meet.
    const auto next = [&](Index h) {
        const Index first = out[fine.target(h)];
        for (Index g = first; g != kNone; g = mesh::rotated(fine, g)) {
            if (surface_->sharp[g] && g != fine.twin[h]) return g;
            if (mesh::rotated(fine, g) == first) break;
        }
        return kNone;
    };
    const auto follow = [&](Index h) {
        Chain chain;
        double size = 0;
        while (h != kNone) {
            size += length(surface_->points[fine.target(h)] - surface_->points[fine.origin[h]]);
            chain.half_edges.push_back(h);
            chain.until.push_back(size);
            if (number[fine.target(h)] != kNone) break;
            h = next(h);
        }
        return chain;
    };
    for (Index side = 0; side < base.half_edge_count(); ++side) {
        if (!base_.sharp()[side] || !(base.on_boundary(side) || base.is_first(side))) continue;
        const Index first = out[base_.vertices()[base.origin[side]]];
        for (Index h = first; h != kNone; h = mesh::rotated(fine, h)) {
            if (surface_->sharp[h]) {
                Chain chain = follow(h);
                if (number[fine.target(chain.half_edges.back())] == base.target(side)) {
                    chain.side = side;
                    chains_.push_back(std::move(chain));
                    break;
                }
            }
            if (mesh::rotated(fine, h) == first) break;
        }
    }
}

Place Levels::on_chain(const Chain& chain, double share) const {
    const double at = share * chain.until.back();
    const auto found = std::lower_bound(chain.until.begin(), chain.until.end() - 1, at);
    const double before = found == chain.until.begin() ? 0 : *(found - 1);
    const double t = *found > before ? std::clamp((at - before) / (*found - before), 0.0, 1.0) : 0;
    const Index h = chain.half_edges[static_cast<std::size_t>(found - chain.until.begin())];
    Place place{h / 3, {0, 0, 0}};
    place.weights[h % 3] = 1 - t;
    place.weights[(h + 1) % 3] = t;
    return place;
}

void Levels::put_curves(MovingMesh& mesh, int depth) const {
    for (const Chain& chain : chains_) {
        std::vector<Index> pieces = {chain.side};
        for (int step = 0; step < depth; ++step) {
            std::vector<Index> finer;
            for (const Index h : pieces)
                for (const Index half :
                     mesh::halves(hierarchy_.topology(step), mesh::Split::Loop, h))
                    finer.push_back(half);
            pieces = std::move(finer);
        }
        const Topology& fine = hierarchy_.topology(depth);
        for (std::size_t k = 0; k < pieces.size(); ++k) {
            const Index v = fine.origin[pieces[k]];
            mesh.put(v,
                     on_chain(chain, static_cast<double>(k) / static_cast<double>(pieces.size())));
            mesh.fixed[v] = 1;
            mesh.fixed[fine.target(pieces[k])] = 1;
        }
    }
}

MovingMesh Levels::mapped(int depth) const {
    const Topology& fine = hierarchy_.topology(depth);
    const auto corners = places_on_base(base_.faces().size(), depth);
    std::vector<Place> places(fine.vertex_count);
    for (Index h = 0; h < fine.half_edge_count(); ++h)
        places[fine.origin[h]] = corners[h / 3][h % 3];
    base_.to_surface(places);
    MovingMesh mesh(*surface_, corners_of(fine), std::move(places));
    put_curves(mesh, depth);
    return mesh;
}

MovingMesh Levels::refined(const MovingMesh& coarse, int depth) const {
    const Topology& topology = hierarchy_.topology(depth);
    std::vector<Place> places = coarse.places;
    places.resize(hierarchy_.vertices(depth + 1));
    parallel_for(0, topology.half_edge_count(), kGrain, [&](std::int64_t begin, std::int64_t end) {
        for (auto h = static_cast<Index>(begin); h < end; ++h) {
            if (!topology.is_first(h)) continue;
            const std::array<Index, 2> ends = {topology.origin[h], topology.target(h)};
            const Point middle = 0.5 * (coarse.points[ends[0]] + coarse.points[ends[1]]);
            Place best;
            double least = HUGE_VAL;
            for (const Index v : ends) {
                const Place place = walk(*surface_, coarse.places[v], middle - coarse.points[v]);
                const double distance = length(surface_->point(place) - middle);
                if (!(distance < least)) continue;
                least = distance;
                best = place;
            }
            for (int k = 0; k < kCorrections; ++k)
                best = walk(*surface_, best, middle - surface_->point(best));
            places[topology.vertex_count + topology.edge[h]] = best;
        }
    });
    MovingMesh fine(*surface_, corners_of(hierarchy_.topology(depth + 1)), std::move(places));
    std::copy(coarse.fixed.begin(), coarse.fixed.end(), fine.fixed.begin());
    put_curves(fine, depth + 1);
    return fine;
}

}  // namespace relief::remesh
