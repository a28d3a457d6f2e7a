#include "remesh/moving_mesh.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "relief/core/parallel.h"
#include "remesh/local_search.h"

namespace relief::remesh {

namespace {

using mesh::Index;
using Point = Vec3<double>;

constexpr std::int64_t kGrain = 512;
constexpr double kRoot3Half = 0.86602540378443865;
constexpr int kUntangleRounds = 24;
/// Faces that are as good as this are let alone.
constexpr double kGoodFit = 0.15;
double square(const Point& a) {
    return dot(a, a);
}

/// A vertex and those of the faces around it.
void add_ring(const MovingMesh& mesh, Index v, std::vector<std::uint8_t>& seen,
              std::vector<Index>& ring) {
    for (const Index c : mesh.corners_at(v))
        for (Index k = 0; k < 3; ++k) {
            const Index u = mesh.corners[c / 3 * 3 + k];
            if (!std::exchange(seen[u], 1)) ring.push_back(u);
        }
}

}  // namespace

MovingMesh::MovingMesh(const Surface& on, std::span<const Index> faces, std::vector<Place> at)
    : surface(&on),
      corners(faces.begin(), faces.end()),
      places(std::move(at)),
      points(places.size()),
      normals(places.size()),
      fixed(places.size(), 0),
      first(places.size() + 1, 0),
      of_vertex(faces.size()) {
    for (const Index v : corners) ++first[v + 1];
    for (std::size_t v = 0; v < places.size(); ++v) first[v + 1] += first[v];
    std::vector<Index> next(first.begin(), first.end() - 1);
    for (Index c = 0; c < corners.size(); ++c) of_vertex[next[corners[c]]++] = c;
    for (Index v = 0; v < places.size(); ++v) put(v, places[v]);
}

void MovingMesh::put(Index v, const Place& place) {
    places[v] = place;
    points[v] = surface->point(place);
    normals[v] = surface->normal(place);
}

double MovingMesh::fit(Index face) const {
    const Index* v = corners.data() + 3 * face;
    const Point& a = points[v[0]];
    const Point& b = points[v[1]];
    const Point& c = points[v[2]];
    const Point normal = normals[v[0]] + normals[v[1]] + normals[v[2]];
    const double longest = std::max({square(b - a), square(c - b), square(a - c)});
    const double scale = longest * kRoot3Half * length(normal);
    return scale > 0 ? dot(cross(b - a, c - a), normal) / scale : 0;
}

double MovingMesh::worst_fit(Index v) const {
    double worst = 1;
    for (const Index c : corners_at(v)) worst = std::min(worst, fit(c / 3));
    return worst;
}

std::vector<Index> MovingMesh::around(std::span<const Index> faces) const {
    std::vector<std::uint8_t> seen(points.size(), 0);
    std::vector<Index> near;
    for (const Index f : faces)
        for (Index k = 0; k < 3; ++k)
            if (!std::exchange(seen[corners[3 * f + k]], 1)) near.push_back(corners[3 * f + k]);
    const std::size_t inner = near.size();
    for (std::size_t i = 0; i < inner; ++i) add_ring(*this, near[i], seen, near);
    return near;
}

std::vector<Index> MovingMesh::flips() const {
    std::vector<Index> found;
    for (Index f = 0; f < face_count(); ++f)
        if (flipped(f)) found.push_back(f);
    return found;
}

void MovingMesh::move(const std::vector<Point>& steps) {
    const std::vector<Place> places_before = places;
    std::vector<std::uint8_t> was_flipped(face_count());
    const auto faces = static_cast<std::int64_t>(face_count());
    parallel_for(0, faces, kGrain, [&](std::int64_t begin, std::int64_t end) {
        for (auto f = static_cast<Index>(begin); f < end; ++f) was_flipped[f] = flipped(f);
    });
    parallel_for(0, static_cast<std::int64_t>(places.size()), kGrain,
                 [&](std::int64_t begin, std::int64_t end) {
                     for (auto v = static_cast<Index>(begin); v < end; ++v)
                         if (!fixed[v]) put(v, walk(*surface, places[v], steps[v]));
                 });
    std::vector<std::uint8_t> is_new(face_count());
    parallel_for(0, faces, kGrain, [&](std::int64_t begin, std::int64_t end) {
        for (auto f = static_cast<Index>(begin); f < end; ++f)
            is_new[f] = !was_flipped[f] && flipped(f);
    });
    std::vector<Index> wrong;
    for (Index f = 0; f < face_count(); ++f)
        if (is_new[f]) wrong.push_back(f);
    // To put vertices back may flip faces beside; each vertex goes back once.
    std::vector<std::uint8_t> back(places.size(), 0);
    while (!wrong.empty()) {
        const Index f = wrong.back();
        wrong.pop_back();
        if (was_flipped[f] || !flipped(f)) continue;
        for (Index k = 0; k < 3; ++k) {
            const Index v = corners[3 * f + k];
            if (back[v]) continue;
            back[v] = 1;
            put(v, places_before[v]);
            for (const Index c : corners_at(v)) wrong.push_back(c / 3);
        }
    }
}

void MovingMesh::untangle() {
    for (int round = 0; round < kUntangleRounds; ++round) {
        const std::vector<Index> wrong = flips();
        bool moved = false;
        for (const Index v : around(wrong))
            if (!fixed[v] && worst_fit(v) <= kGoodFit)
                moved = try_places(*this, v, [&] { return worst_fit(v); }) || moved;
        if (!moved) return;
    }
}

std::vector<double> MovingMesh::edge_lengths() const {
    std::vector<double> sizes(points.size());
    for (Index v = 0; v < points.size(); ++v) {
        double sum = 0;
        for (const Index c : corners_at(v)) {
            const Index f = c / 3 * 3;
            sum += length(points[corners[f + (c - f + 1) % 3]] - points[v]) +
                   length(points[corners[f + (c - f + 2) % 3]] - points[v]);
        }
        sizes[v] = sum / (2 * static_cast<double>(corners_at(v).size()));
    }
    return sizes;
}

std::vector<mesh::FanTriangle> MovingMesh::triangles() const {
    std::vector<mesh::FanTriangle> result(face_count());
    for (Index f = 0; f < face_count(); ++f)
        result[f] = {
            {points[corners[3 * f]], points[corners[3 * f + 1]], points[corners[3 * f + 2]]}, f};
    return result;
}

}  // namespace relief::remesh
