#include "remesh/moving_mesh.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "relief/core/parallel.h"

namespace relief::remesh {

namespace {

using mesh::Index;
using Point = Vec3<double>;

constexpr std::int64_t kGrain = 512;
constexpr double kRoot3Half = 0.86602540378443865;
constexpr int kUntangleRounds = 24;
/// Faces that are as good as this are let alone.
constexpr double kGoodFit = 0.15;
/// Directions and lengths, in mean edges, of the moves that are tried.
constexpr std::array<std::array<double, 2>, 8> kDirections = {
    {{1, 0}, {0.7, 0.7}, {0, 1}, {-0.7, 0.7}, {-1, 0}, {-0.7, -0.7}, {0, -1}, {0.7, -0.7}}};
constexpr std::array<double, 4> kLengths = {0.6, 0.25, 0.1, 0.03};
constexpr std::array<double, 3> kTowardsMean = {1, 0.5, 0.2};

double square(const Point& a) {
    return dot(a, a);
}

double fit_of(const std::array<Point, 3>& p, const Point& normal) {
    const Point doubled = cross(p[1] - p[0], p[2] - p[0]);
    const double longest =
        std::max({square(p[1] - p[0]), square(p[2] - p[1]), square(p[0] - p[2])});
    const double scale = longest * kRoot3Half * length(normal);
    return scale > 0 ? dot(doubled, normal) / scale : 0;
}

/// Tries places for one vertex of a mesh.
class Improvement {
  public:
    Improvement(const MovingMesh& mesh, Index v)
        : mesh_(mesh), v_(v), best_(mesh.places[v]), from_(best_) {
        score_ = before_ = score(mesh.points[v], mesh.normals[v]);
    }

    void try_all() {
        Point mean;
        double edges = 0;
        for (const Index c : mesh_.corners_at(v_))
            for (const Index k : {1U, 2U}) {
                const Point& p = mesh_.points[mesh_.corners[c / 3 * 3 + (c + k - c / 3 * 3) % 3]];
                mean += p;
                edges += length(p - mesh_.points[v_]);
            }
        const double count = 2 * static_cast<double>(mesh_.corners_at(v_).size());
        mean = 1 / count * mean;
        edges /= count;
        const Point& here = mesh_.points[v_];
        for (const double share : kTowardsMean) attempt(share * (mean - here));
        const Point& normal = mesh_.surface->face_normals[from_.face];
        const Point axis = std::abs(normal.x) < 0.6 ? Point{1, 0, 0} : Point{0, 1, 0};
        const Point u = cross(axis, normal);
        const Point w = cross(normal, u);
        for (const double size : kLengths)
            for (const auto& [x, y] : kDirections) attempt(size * edges * (x * u + y * w));
    }

    [[nodiscard]] bool better() const { return score_ > before_; }
    [[nodiscard]] const Place& best() const { return best_; }
    [[nodiscard]] double before() const { return before_; }

  private:
    /// Of the worst face at the vertex.
    [[nodiscard]] double score(const Point& at, const Point& normal) const {
        double worst = 1;
        for (const Index c : mesh_.corners_at(v_)) {
            const Index f = c / 3 * 3;
            std::array<Point, 3> p;
            Point normals;
            for (Index k = 0; k < 3; ++k) {
                const Index u = mesh_.corners[f + k];
                p[k] = u == v_ ? at : mesh_.points[u];
                normals += u == v_ ? normal : mesh_.normals[u];
            }
            worst = std::min(worst, fit_of(p, normals));
        }
        return worst;
    }

    void attempt(const Point& step) {
        const Place place = walk(*mesh_.surface, from_, step);
        const double reached = score(mesh_.surface->point(place), mesh_.surface->normal(place));
        if (reached <= score_) return;
        score_ = reached;
        best_ = place;
    }

    const MovingMesh& mesh_;
    Index v_;
    Place best_;
    Place from_;
    double before_ = 0;
    double score_ = 0;
};

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
    return fit_of({points[v[0]], points[v[1]], points[v[2]]},
                  normals[v[0]] + normals[v[1]] + normals[v[2]]);
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
        // Two rings around flipped faces, the ones beside them first.
        std::vector<Index> near;
        std::vector<std::uint8_t> seen(places.size(), 0);
        for (const Index f : flips())
            for (Index k = 0; k < 3; ++k)
                if (!std::exchange(seen[corners[3 * f + k]], 1)) near.push_back(corners[3 * f + k]);
        if (near.empty()) return;
        const std::size_t inner = near.size();
        for (std::size_t i = 0; i < inner; ++i)
            for (const Index c : corners_at(near[i]))
                for (const Index k : {0U, 1U, 2U})
                    if (!std::exchange(seen[corners[c / 3 * 3 + k]], 1))
                        near.push_back(corners[c / 3 * 3 + k]);
        bool moved = false;
        for (const Index v : near) {
            if (fixed[v]) continue;
            Improvement improvement(*this, v);
            if (improvement.before() > kGoodFit) continue;
            improvement.try_all();
            if (!improvement.better()) continue;
            put(v, improvement.best());
            moved = true;
        }
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
