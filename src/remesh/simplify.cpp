#include "relief/remesh/simplify.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <queue>

#include "remesh/angles.h"
#include "remesh/fan.h"
#include "remesh/quadric.h"

namespace relief::remesh {

namespace {

using mesh::Index;
using mesh::kNone;
using Point = Vec3<double>;

/// A triangle of the base may turn so far away from those that it stands for, in one collapse: the
/// cosine.
constexpr double kLeastTurn = 0.3;
/// Quality of triangles: 1 if equilateral, 0 if flat.
/// First none is worse than the first limit; if no vertex is left to collapse so, as on slabs with
/// holes, than the next one.
constexpr std::array<double, 3> kLeastQualities = {0.05, 0.01, 0.002};
constexpr double kPoorQuality = 0.2;
constexpr double kPoorFactor = 3;
constexpr double kGoodQuality = 0.5;
constexpr std::size_t kMostValence = 14;
constexpr double kRoot3Half = 0.86602540378443865;
/// Angles around a vertex count as at least this, so that each face has a place in the plane.
constexpr double kLeastAngle = 1e-4;
/// Exponents of radii in the plane, in eighths.
constexpr std::array<int, 2> kExponents = {4, 16};
constexpr int kFlatterExponent = 2;
/// Doubled area over the square of the longest side of a triangle in the plane, at least; on a
/// circle only the orientation counts.
constexpr double kLeastPlanar = 0.02;
constexpr double kLeastOnCircle = 1e-6;

double square(const Point& a) {
    return dot(a, a);
}

Point unit(const Point& a) {
    const double size = length(a);
    return size > 0 ? 1 / size * a : Point{};
}

/// l^(eighths / 8).
double power(double l, int eighths) {
    const double root = std::sqrt(std::sqrt(std::sqrt(l)));
    double result = 1;
    for (int k = 0; k < eighths; ++k) result *= root;
    return result;
}

double corner_angle(const Point& a, const Point& b) {
    const double x = dot(a, b);
    const double y = length(cross(a, b));
    return x == 0 && y == 0 ? kLeastAngle : std::max(kLeastAngle, angle_of(x, y));
}

struct Candidate {
    double cost = 0;
    Index vertex = 0;
    Index target = 0;
    std::uint32_t stamp = 0;

    /// The cheapest comes first.
    friend bool operator<(const Candidate& a, const Candidate& b) {
        return a.cost != b.cost ? a.cost > b.cost : a.vertex > b.vertex;
    }
};

}  // namespace

/// The mesh between two collapses.
class Simplification::Collapser {
  public:
    Collapser(const Surface& surface, const SimplifyOptions& options, Simplification& result)
        : points_(surface.points),
          mesh_(surface),
          kinds_(surface.kinds),
          quadrics_(surface.points.size()),
          stamps_(surface.points.size(), 0),
          marks_(surface.points.size(), 0),
          left_(surface.mesh.face_count),
          options_(options),
          result_(result) {
        for (const Index v : options.locked) kinds_[v] = VertexKind::Corner;
        add_quadrics(surface);
    }

    void run() {
        for (const double limit : kLeastQualities) {
            if (left_ <= options_.faces) break;
            least_quality_ = limit;
            collapse_cheapest();
        }
        finish();
    }

  private:
    void collapse_cheapest() {
        for (Index v = 0; v < points_.size(); ++v)
            if (mesh_.out[v] != kNone) offer(v);
        while (left_ > options_.faces && !queue_.empty()) {
            const Candidate next = queue_.top();
            queue_.pop();
            if (next.stamp != stamps_[next.vertex]) continue;
            const Candidate now = best_of(next.vertex);
            if (now.target == kNone) continue;
            if (now.target != next.target || now.cost > next.cost)
                queue_.push(now);
            else
                take(now);
        }
    }

    void add_quadrics(const Surface& surface) {
        for (Index f = 0; f < surface.mesh.face_count; ++f) {
            const Point& normal = surface.face_normals[f];
            const auto corners = surface.mesh.corners(f);
            const Point& a = points_[corners[0]];
            const double area = length(cross(points_[corners[1]] - a, points_[corners[2]] - a)) / 2;
            for (std::size_t k = 0; k < 3; ++k) {
                quadrics_[corners[k]].add_plane(normal, a, area / 3);
                if (!surface.sharp[3 * f + k]) continue;
                const Point side = points_[corners[(k + 1) % 3]] - points_[corners[k]];
                const Point across = unit(cross(side, normal));
                for (const Index v : {corners[k], corners[(k + 1) % 3]})
                    quadrics_[v].add_plane(across, points_[corners[k]], square(side));
            }
        }
    }

    /// Puts the best collapse of a vertex into the queue, in place of the one there.
    void offer(Index v) {
        ++stamps_[v];
        const Candidate best = best_of(v);
        if (best.target != kNone) queue_.push(best);
    }

    Candidate best_of(Index v) {
        Candidate best{std::numeric_limits<double>::infinity(), v, kNone, stamps_[v]};
        if (kinds_[v] == VertexKind::Corner) return best;
        fan_.read(mesh_, v);
        if (fan_.ring.size() < 3) return best;
        for (std::size_t i = 0; i < fan_.ring.size(); ++i) {
            const Index w = fan_.ring[i];
            const double distance = (quadrics_[v](points_[w]) + quadrics_[w](points_[w])) /
                                    std::max(quadrics_[v].weight() + quadrics_[w].weight(), 1e-300);
            if (distance >= best.cost || !allowed(i)) continue;
            const double quality = quality_after(i);
            if (quality < least_quality_) continue;
            const double flatness = 0.02 + 0.5 * std::max(0.0, kGoodQuality - quality);
            double cost = distance + options_.shape * square(points_[w] - points_[v]) * flatness;
            if (quality < kPoorQuality) cost *= kPoorFactor;
            if (cost >= best.cost) continue;
            best.cost = cost;
            best.target = w;
        }
        return best;
    }

    /// Whether fan_ may collapse to ring[i] and the mesh stays what it is.
    bool allowed(std::size_t i) {
        const Index v = fan_.vertex;
        const Index w = fan_.ring[i];
        const bool end = !fan_.closed && (i == 0 || i + 1 == fan_.ring.size());
        if (!fan_.closed && !end) return false;
        const bool curve = kinds_[v] == VertexKind::Curve;
        if (curve && !fan_.sharp(mesh_, i)) return false;
        other_.read(mesh_, w);
        ++mark_;
        for (const Index u : other_.ring) marks_[u] = mark_;
        std::size_t common = 0;
        for (const Index u : fan_.ring) common += marks_[u] == mark_;
        if (common != (end ? 1 : 2)) return false;
        if (other_.ring.size() + fan_.ring.size() - 2 - common > kMostValence) return false;
        if (curve && meets_itself(i)) return false;
        return !(fan_.closed && fan_.ring.size() == 3 && is_tetrahedron(i));
    }

    /// The curve through the vertex would run twice between the same two.
    bool meets_itself(std::size_t i) const {
        for (std::size_t k = 0; k < fan_.ring.size(); ++k) {
            if (k == i || !fan_.sharp(mesh_, k)) continue;
            for (std::size_t j = 0; j < other_.ring.size(); ++j)
                if (other_.ring[j] == fan_.ring[k] && other_.sharp(mesh_, j)) return true;
        }
        return false;
    }

    bool is_tetrahedron(std::size_t i) const {
        const Index across = mesh_.twin[CollapsingMesh::next(fan_.spokes[fan_.after(i)])];
        return across != kNone && mesh_.origin[CollapsingMesh::prev(across)] == fan_.ring[i];
    }

    /// Of the worst triangle that a collapse would leave; negative if one turns too far.
    double quality_after(std::size_t target) const {
        const Point& v = points_[fan_.vertex];
        const Point& w = points_[fan_.ring[target]];
        double worst = 1;
        for (std::size_t i = 0; i < fan_.spokes.size(); ++i) {
            if (i == target || fan_.after(i) == target) continue;
            const Point& a = points_[fan_.ring[i]];
            const Point& b = points_[fan_.ring[fan_.after(i)]];
            const Point now = cross(a - v, b - v);
            const Point then = cross(a - w, b - w);
            const double longest = std::max({square(a - w), square(b - w), square(a - b)});
            const double doubled = length(then);
            if (!(doubled > 0)) return -1;
            worst = std::min(worst, doubled / (longest * kRoot3Half));
            const double before = length(now);
            if (before > 0 && dot(now, then) < kLeastTurn * before * doubled) return -1;
        }
        return worst;
    }

    /// Records and makes a collapse, unless the faces around can not be flattened.
    void take(const Candidate& candidate) {
        fan_.read(mesh_, candidate.vertex);
        if (kinds_[candidate.vertex] == VertexKind::Curve && fan_.closed) {
            std::size_t first = 0;
            while (!fan_.sharp(mesh_, first)) ++first;
            fan_.rotate(first);
        }
        const auto target = static_cast<std::size_t>(
            std::find(fan_.ring.begin(), fan_.ring.end(), candidate.target) - fan_.ring.begin());
        if (!flatten(target)) return;
        Record record{static_cast<Index>(result_.spokes_.size()),
                      static_cast<Index>(result_.ring_.size()),
                      static_cast<Index>(fan_.spokes.size()), static_cast<Index>(fan_.ring.size()),
                      static_cast<Index>(target)};
        for (Index i = 0; i < record.spokes; ++i) left_ -= record.gone(i);
        result_.records_.push_back(record);
        result_.spokes_.insert(result_.spokes_.end(), fan_.spokes.begin(), fan_.spokes.end());
        result_.ring_.insert(result_.ring_.end(), planar_.begin(), planar_.end());
        for (Index i = 0; i < record.spokes; ++i)
            if (record.gone(i)) gone_.push_back(fan_.spokes[i] / 3);
        collapse(mesh_, fan_, target);
        quadrics_[candidate.target].add(quadrics_[candidate.vertex]);
        ++stamps_[candidate.vertex];
        around_ = fan_.ring;
        for (const Index u : around_) offer(u);
    }

    /// The angles at the vertex, scaled to a whole turn, or to half of one on each side of a curve.
    /// The factor, as far as there is one, is the exponent of lengths that keeps angles elsewhere.
    double find_directions() {
        const Point& v = points_[fan_.vertex];
        const std::size_t count = fan_.spokes.size();
        angles_.resize(count);
        double all = 0;
        for (std::size_t i = 0; i < count; ++i) {
            angles_[i] =
                corner_angle(points_[fan_.ring[i]] - v, points_[fan_.ring[fan_.after(i)]] - v);
            all += angles_[i];
        }
        const bool crease = fan_.closed && kinds_[fan_.vertex] == VertexKind::Curve;
        std::size_t middle = count;
        double left = all;
        if (crease) {
            middle = 1;
            while (!fan_.sharp(mesh_, middle)) ++middle;
            left = 0;
            for (std::size_t i = 0; i < middle; ++i) left += angles_[i];
        }
        const double turn = fan_.closed && !crease ? 2 * kPi : kPi;
        directions_.resize(fan_.ring.size());
        double angle = 0;
        for (std::size_t i = 0; i < fan_.ring.size(); ++i) {
            directions_[i] = direction_of(angle);
            if (i < count) angle += angles_[i] * turn / (i < middle ? left : all - left);
        }
        return crease ? 1 : turn / all;
    }

    /// Fills planar_: the ring around the origin, so that the triangles that a collapse leaves have
    /// the right orientation too.
    bool flatten(std::size_t target) {
        const double exponent = find_directions();
        const int eighths =
            std::clamp(static_cast<int>(std::lround(8 * exponent)), kExponents[0], kExponents[1]);
        const Point& v = points_[fan_.vertex];
        double largest = 0;
        for (const Index u : fan_.ring) largest = std::max(largest, length(points_[u] - v));
        if (!(largest > 0)) return false;
        for (const int power_of : {eighths, kFlatterExponent, 0}) {
            planar_.resize(fan_.ring.size());
            for (std::size_t i = 0; i < planar_.size(); ++i) {
                const double radius = power(length(points_[fan_.ring[i]] - v) / largest, power_of);
                planar_[i] = {radius * directions_[i].x, radius * directions_[i].y};
            }
            if (is_oriented(target, power_of == 0 ? kLeastOnCircle : kLeastPlanar)) return true;
        }
        return false;
    }

    /// Whether the faces have the same orientation in the plane before and after the collapse.
    bool is_oriented(std::size_t target, double least) const {
        const Planar& w = planar_[target];
        for (std::size_t i = 0; i < fan_.spokes.size(); ++i) {
            const Planar& a = planar_[i];
            const Planar& b = planar_[fan_.after(i)];
            if (!is_left({}, a, b, kLeastOnCircle)) return false;
            if (i == target || fan_.after(i) == target) continue;
            if (!is_left(w, a, b, least)) return false;
        }
        return true;
    }

    static bool is_left(const Planar& at, const Planar& a, const Planar& b, double least) {
        const Planar u{a.x - at.x, a.y - at.y};
        const Planar v{b.x - at.x, b.y - at.y};
        const Planar w{b.x - a.x, b.y - a.y};
        const double longest =
            std::max({u.x * u.x + u.y * u.y, v.x * v.x + v.y * v.y, w.x * w.x + w.y * w.y});
        return longest > 0 && u.x * v.y - u.y * v.x >= least * longest;
    }

    /// The base mesh, with its vertices in the order of those of the surface.
    void finish() {
        std::vector<Index> number(points_.size(), kNone);
        for (Index v = 0; v < points_.size(); ++v) {
            if (mesh_.out[v] == kNone) continue;
            number[v] = static_cast<Index>(result_.base_vertices_.size());
            result_.base_vertices_.push_back(v);
        }
        const auto faces = static_cast<Index>(mesh_.origin.size() / 3);
        std::vector<std::uint8_t> gone(faces, 0);
        for (const Index f : gone_) gone[f] = 1;
        result_.face_count_ = faces;
        for (Index f = 0; f < faces; ++f) {
            if (gone[f]) continue;
            result_.face_ids_.push_back(f);
            std::array<Index, 3> corners{};
            for (Index k = 0; k < 3; ++k) {
                corners[k] = number[mesh_.origin[3 * f + k]];
                result_.base_sharp_.push_back(mesh_.sharp[3 * f + k]);
            }
            result_.base_.add(corners);
        }
    }

    const std::vector<Point>& points_;
    CollapsingMesh mesh_;
    std::vector<VertexKind> kinds_;
    std::vector<Quadric> quadrics_;
    std::vector<std::uint32_t> stamps_;
    std::vector<std::uint32_t> marks_;
    std::uint32_t mark_ = 0;
    Index left_;  ///< faces
    double least_quality_ = kLeastQualities.front();
    std::vector<Index> gone_;
    std::priority_queue<Candidate> queue_;
    const SimplifyOptions& options_;
    Simplification& result_;
    // Memory that is used again and again.
    Fan fan_;
    Fan other_;
    std::vector<Index> around_;
    std::vector<double> angles_;
    std::vector<Direction> directions_;
    std::vector<Planar> planar_;
};

Simplification::Simplification(const Surface& surface, const SimplifyOptions& options) {
    Collapser(surface, options, *this).run();
}

Place Simplification::placed(const Record& record, std::span<const Index> spokes,
                             std::span<const Planar> ring, const Planar& p) {
    Place best;
    double largest = -std::numeric_limits<double>::infinity();
    std::array<double, 3> weights{};
    for (Index i = 0; i < record.spokes; ++i) {
        const Planar& a = ring[i];
        const Planar& b = ring[(i + 1) % record.ring];
        const double doubled = a.x * b.y - a.y * b.x;
        const double along_a = (p.x * b.y - p.y * b.x) / doubled;
        const double along_b = (a.x * p.y - a.y * p.x) / doubled;
        const double least = std::min({along_a, along_b, 1 - along_a - along_b});
        if (!(least > largest)) continue;
        largest = least;
        best.face = spokes[i] / 3;
        const Index slot = spokes[i] % 3;
        weights[slot] = 1 - along_a - along_b;
        weights[(slot + 1) % 3] = along_a;
        weights[(slot + 2) % 3] = along_b;
    }
    double sum = 0;
    for (double& w : weights) sum += w = std::max(w, 0.0);
    for (std::size_t k = 0; k < 3; ++k) best.weights[k] = weights[k] / sum;
    return best;
}

void Simplification::to_surface(std::span<Place> places) const {
    // The places of each face are a list.
    std::vector<Index> first(face_count_, kNone);
    std::vector<Index> following(places.size(), kNone);
    const auto put = [&](Index s) {
        following[s] = first[places[s].face];
        first[places[s].face] = s;
    };
    for (Index s = 0; s < places.size(); ++s) {
        places[s].face = face_ids_[places[s].face];
        put(s);
    }
    std::vector<Index> moving;
    std::vector<Planar> where;
    for (auto record = records_.rbegin(); record != records_.rend(); ++record) {
        const auto spokes = std::span(spokes_).subspan(record->first_spoke, record->spokes);
        const auto ring = std::span(ring_).subspan(record->first_ring, record->ring);
        moving.clear();
        where.clear();
        for (Index i = 0; i < record->spokes; ++i) {
            if (record->gone(i)) continue;
            const Planar& centre = ring[record->target];
            const Planar& a = ring[i];
            const Planar& b = ring[(i + 1) % record->ring];
            const Index slot = spokes[i] % 3;
            for (Index s = std::exchange(first[spokes[i] / 3], kNone); s != kNone;
                 s = following[s]) {
                const auto& w = places[s].weights;
                const double at_a = w[(slot + 1) % 3];
                const double at_b = w[(slot + 2) % 3];
                moving.push_back(s);
                where.push_back({w[slot] * centre.x + at_a * a.x + at_b * b.x,
                                 w[slot] * centre.y + at_a * a.y + at_b * b.y});
            }
        }
        for (std::size_t k = 0; k < moving.size(); ++k) {
            places[moving[k]] = placed(*record, spokes, ring, where[k]);
            put(moving[k]);
        }
    }
}

}  // namespace relief::remesh
