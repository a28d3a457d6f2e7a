#include <algorithm>
#include <limits>
#include <numeric>
#include <utility>

#include "relief/mesh/recognise.h"
#include "relief/mesh/walk.h"
#include "relief/multires/mesh_hierarchy.h"

namespace relief::multires {

namespace {

using mesh::Index;
using mesh::kNone;
using mesh::Recognition;
using mesh::Split;
using mesh::Topology;
using mesh::Unsplit;
using Points = std::vector<Vec3<double>>;

/// A level that was found, and how to get back to the finer one.
struct Found {
    Unsplit unsplit;
    Split split = Split::Loop;
    MeshTags tags;
    bool in_order = false;  ///< the finer one has the numbers of the split
};

/// For each half-edge of a mesh where its split has what Unsplit::fine names.
Buffer<Index> own_starts(const Topology& coarse, Split split) {
    Buffer<Index> starts(coarse.half_edge_count());
    const bool sqrt3 = split == Split::Sqrt3Odd || split == Split::Sqrt3Even;
    const Buffer<Index> faces = sqrt3 ? mesh::sqrt3_faces(coarse, split) : Buffer<Index>();
    for (Index h = 0; h < starts.size(); ++h)
        starts[h] = sqrt3                  ? 3 * faces[h]
                    : split == Split::Loop ? 12 * (h / 3) + 3 * (h % 3)
                                           : 4 * h;
    return starts;
}

/// Tags of the coarser mesh: an edge is sharp if both of its halves are.
MeshTags coarser_tags(const MeshTags& tags, const Topology& fine, const Found& found,
                      std::vector<Index>* lost) {
    const Topology& coarse = found.unsplit.mesh;
    MeshTags result;
    if (!tags.corner.empty()) {
        result.corner.resize(coarse.vertex_count);
        for (Index v = 0; v < coarse.vertex_count; ++v)
            result.corner[v] = tags.corner[found.unsplit.old_vertices[v]];
    }
    if (tags.sharp.empty()) return result;
    std::vector<std::uint8_t> kept(fine.edge_count, 0);
    result.sharp.assign(coarse.edge_count, 0);
    const bool halved = found.split == Split::Loop || found.split == Split::CatmullClark;
    mesh::each_edge(coarse, [&](Index h, Index, Index) {
        if (!halved || coarse.on_boundary(h)) return;
        const Index first = fine.edge[found.unsplit.fine[h]];
        const Index second = fine.edge[found.unsplit.fine[coarse.twin[h]]];
        if (!tags.sharp[first] || !tags.sharp[second]) return;
        result.sharp[coarse.edge[h]] = kept[first] = kept[second] = 1;
    });
    for (Index h = 0; lost && h < fine.half_edge_count(); ++h)
        if (fine.is_first(h) && !fine.on_boundary(h) && tags.sharp[fine.edge[h]] &&
            !kept[fine.edge[h]])
            lost->push_back(fine.edge[h]);
    return result;
}

/// A mesh in the numbers of the subdivision that it is.
struct Ordered {
    Points points;
    std::vector<Index> half_edge;  ///< [vertex]: one of the mesh's that begins there
};

Result<Ordered> ordered(const Topology& fine, std::span<const Vec3<double>> points,
                        const Found& found) {
    RELIEF_TRY(const Topology again, mesh::refine(found.unsplit.mesh, found.split));
    const auto half_edges =
        mesh::fine_half_edges(found.unsplit.mesh, found.split, fine, found.unsplit.fine);
    Ordered result{Points(points.size()), std::vector<Index>(points.size())};
    for (Index h = 0; h < again.half_edge_count(); ++h) {
        result.points[again.origin[h]] = points[fine.origin[half_edges[h]]];
        result.half_edge[again.origin[h]] = half_edges[h];
    }
    return result;
}

/// The coarser mesh whose subdivision is near the points.
Result<Points> lifted(const MeshStep<double>& step, const Points& points, MeshScheme scheme) {
    Points c = points;
    Points scratch(c.size());
    Points stiff(step.rules().stiff.size());
    step.analyse(c.data(), stiff.data(), scratch.data());
    RELIEF_TRY(const MeshLift lift, MeshLift::create(step, default_lift(scheme, 0)));
    lift.apply(c.data() + step.coarse_count(), stiff.data(), scratch.data());
    c.resize(step.coarse_count());
    for (std::size_t v = 0; v < c.size(); ++v) c[v] += scratch[v];
    return c;
}

class Descent {
  public:
    Descent(const Topology& mesh, std::span<const Vec3<double>> points, const MeshTags& tags,
            MeshScheme scheme)
        : mesh_(mesh), tags_(tags), scheme_(scheme), points_(points) {}

    /// All levels, the finest step first; sqrt(3): `even` is the parity of that one.
    void run(bool even, int most) {
        descend_in_order(even, most);
        even = even != (levels_.size() % 2 != 0);
        while (static_cast<int>(levels_.size()) < most) {
            const Split split = split_of(scheme_, even ? 1 : 0);
            const Recognition recognition(finest_left(), split);
            if (recognition.ok()) link_levels_in_order();
            Result<Found> found =
                recognition.ok() ? choose(recognition, split) : Result<Found>(recognition.error());
            if (!found.ok()) {
                reason_ = found.error();
                return;
            }
            levels_.push_back(*std::move(found));
            even = !even;
        }
    }

    [[nodiscard]] const std::optional<Error>& reason() const { return reason_; }
    [[nodiscard]] std::vector<Found>& levels() { return levels_; }

  private:
    [[nodiscard]] const Topology& finer(std::size_t k) const {
        return k == 0 ? mesh_ : levels_[k - 1].unsplit.mesh;
    }
    [[nodiscard]] const Topology& finest_left() const { return finer(levels_.size()); }
    [[nodiscard]] const MeshTags& tags_left() const {
        return levels_.empty() ? tags_ : levels_.back().tags;
    }

    /// As far as meshes have the numbers of subdivision: no other way could be meant.
    void descend_in_order(bool even, int most) {
        while (static_cast<int>(levels_.size()) < most) {
            Found level;
            level.split = split_of(scheme_, even == (levels_.size() % 2 == 0) ? 1 : 0);
            auto coarse = mesh::unsplit_in_order(finest_left(), level.split);
            if (!coarse) break;
            level.in_order = true;
            level.unsplit.mesh = *std::move(coarse);
            levels_.push_back(std::move(level));
        }
        while (!levels_.empty() && !mesh::is_built(finest_left())) levels_.pop_back();
        if (!tags_.sharp.empty() || !tags_.corner.empty()) link_levels_in_order();
        for (std::size_t k = 0; k < levels_.size(); ++k)
            levels_[k].tags =
                coarser_tags(k == 0 ? tags_ : levels_[k - 1].tags, finer(k), levels_[k], nullptr);
    }

    /// Tells where in the finer mesh those levels are.
    void link_levels_in_order() {
        for (Found& level : levels_) {
            Unsplit& unsplit = level.unsplit;
            if (!level.in_order || unsplit.fine.size() > 0) continue;
            unsplit.fine = own_starts(unsplit.mesh, level.split);
            unsplit.old_vertices.resize(unsplit.mesh.vertex_count);
            std::iota(unsplit.old_vertices.begin(), unsplit.old_vertices.end(), Index{0});
        }
    }

    /// Of the coarsest mesh so far. They are needed where there is a choice only.
    Result<std::span<const Vec3<double>>> points_left() {
        while (coarser_points_.size() < levels_.size()) {
            const std::size_t k = coarser_points_.size();
            const Found& found = levels_[k];
            RELIEF_TRY(const Ordered fine, ordered(finer(k), points_at(k), found));
            RELIEF_TRY(const StepRules rules,
                       step_rules(found.unsplit.mesh, found.tags, found.split));
            RELIEF_TRY(Points coarse, lifted({found.unsplit.mesh, rules}, fine.points, scheme_));
            coarser_points_.push_back(std::move(coarse));
        }
        return points_at(levels_.size());
    }
    [[nodiscard]] std::span<const Vec3<double>> points_at(std::size_t k) const {
        return k == 0 ? points_ : coarser_points_[k - 1];
    }

    Result<Found> found(const Recognition& recognition, Split split,
                        const std::vector<std::size_t>& choice) const {
        Found result;
        result.split = split;
        RELIEF_TRY(result.unsplit, recognition.unsplit(choice));
        result.tags = coarser_tags(tags_left(), finest_left(), result, nullptr);
        return result;
    }

    /// The components seen in some ways, and how far subdivision stays from the points.
    struct Attempt {
        std::vector<std::size_t> choice;
        Found found;
        Points coarse;
        std::vector<double> squares;  ///< [component]: of the distances
    };

    /// For each component the way from which subdivision comes nearest.
    Result<Found> choose(const Recognition& recognition, Split split) {
        const std::size_t components = recognition.components();
        std::size_t most = 1;
        for (std::size_t c = 0; c < components; ++c) most = std::max(most, recognition.ways(c));
        std::vector<std::size_t> best(components, 0);
        std::vector<double> least(components, std::numeric_limits<double>::infinity());
        std::optional<Attempt> kept;
        for (std::size_t way = 0; most > 1 && !points_.empty() && way < most; ++way) {
            std::vector<std::size_t> choice(components);
            for (std::size_t c = 0; c < components; ++c)
                choice[c] = std::min(way, recognition.ways(c) - 1);
            RELIEF_TRY(Attempt attempt, attempted(recognition, split, std::move(choice)));
            for (std::size_t c = 0; c < components; ++c)
                if (attempt.squares[c] < least[c]) {
                    least[c] = attempt.squares[c];
                    best[c] = attempt.choice[c];
                }
            if (best == attempt.choice) kept = std::move(attempt);
        }
        if (!kept || kept->choice != best) return found(recognition, split, best);
        coarser_points_.push_back(std::move(kept->coarse));
        return std::move(kept->found);
    }

    Result<Attempt> attempted(const Recognition& recognition, Split split,
                              std::vector<std::size_t> choice) {
        Attempt attempt;
        RELIEF_TRY(attempt.found, found(recognition, split, choice));
        const Topology& coarse = attempt.found.unsplit.mesh;
        RELIEF_TRY(const auto points, points_left());
        RELIEF_TRY(const Ordered fine, ordered(finest_left(), points, attempt.found));
        RELIEF_TRY(const StepRules rules, step_rules(coarse, attempt.found.tags, split));
        const MeshStep<double> step(coarse, rules);
        RELIEF_TRY(attempt.coarse, lifted(step, fine.points, scheme_));
        Points surface(fine.points.size());
        step.apply(attempt.coarse.data(), surface.data(), surface.data() + attempt.coarse.size());
        attempt.squares.assign(recognition.components(), 0);
        for (std::size_t k = 0; k < surface.size(); ++k) {
            const Vec3<double> off = fine.points[k] - surface[k];
            const Index face = finest_left().face_of(fine.half_edge[k]);
            attempt.squares[recognition.parts().of_face[face]] += dot(off, off);
        }
        attempt.choice = std::move(choice);
        return attempt;
    }

    const Topology& mesh_;
    const MeshTags& tags_;
    MeshScheme scheme_;
    std::vector<Found> levels_;
    std::span<const Vec3<double>> points_;
    std::vector<Points> coarser_points_;  ///< of levels_, as far as asked for
    std::optional<Error> reason_;
};

/// Half-edges of the finest level of the hierarchy over a base, as the mesh has them. here: of the
/// base, as levels.back() has them.
Result<Buffer<Index>> climb(const Topology& fine, const std::vector<Found>& levels,
                            const Topology& base, Buffer<Index> here) {
    const Topology* canonical = &base;
    Topology finer;
    for (std::size_t k = levels.size(); k-- > 0;) {
        const Unsplit& unsplit = levels[k].unsplit;
        const Topology& target = k == 0 ? fine : levels[k - 1].unsplit.mesh;
        Buffer<Index> start(canonical->half_edge_count());
        for (Index h = 0; h < start.size(); ++h) start[h] = unsplit.fine[here[h]];
        here = mesh::fine_half_edges(*canonical, levels[k].split, target, start);
        if (k == 0) break;
        RELIEF_TRY(Topology next, mesh::refine(*canonical, levels[k].split));
        finer = std::move(next);
        canonical = &finer;
    }
    return here;
}

/// What tells the order of a base's faces and corners: numbers in the mesh of what they give, which
/// grow where the mesh was made by subdivision.
struct Keys {
    std::vector<Index> of_half_edge;
    std::vector<Index> of_face;  ///< sqrt(3): first; else empty
};

/// Loop, Catmull-Clark: the first face that each corner gives in the end.
Keys keys_of_corners(const std::vector<Found>& levels, const Topology& mesh) {
    Keys keys;
    const Buffer<Index>& starts = levels.back().unsplit.fine;
    for (Index corner = 0; corner < starts.size(); ++corner) {
        Index h = starts[corner];
        for (std::size_t k = levels.size() - 1; k-- > 0;) h = levels[k].unsplit.fine[h];
        keys.of_half_edge.push_back(mesh.face_of(h));
    }
    return keys;
}

/// sqrt(3): the vertices that the first step puts into faces and the second one into what each
/// half-edge gives, or its face in the end.
Keys keys_of_edges(const std::vector<Found>& levels, const Topology& mesh) {
    const auto at = [&](std::size_t k) -> const Topology& {
        return k == 0 ? mesh : levels[k - 1].unsplit.mesh;
    };
    // The vertex that level k puts into a face, the first of two, by its number in the mesh.
    const auto point = [&](std::size_t k, const Topology& coarse, Index f) {
        const Index side = mesh::boundary_side(coarse, f);
        const bool trisected = levels[k].split == Split::Sqrt3Even && side != kNone;
        const Topology& fine = at(k);
        const Index h = levels[k].unsplit.fine[trisected ? side : 3 * f];
        Index v = fine.origin[trisected ? h : fine.prev(h)];
        for (std::size_t finer = k; finer-- > 0;) v = levels[finer].unsplit.old_vertices[v];
        return v;
    };
    const std::size_t last = levels.size() - 1;
    const Topology& base = levels[last].unsplit.mesh;
    Keys keys;
    for (Index f = 0; f < base.face_count; ++f) keys.of_face.push_back(point(last, base, f));
    const Buffer<Index>& starts = levels[last].unsplit.fine;
    for (Index h = 0; h < starts.size(); ++h) {
        const Index face = at(last).face_of(starts[h]);
        keys.of_half_edge.push_back(last == 0 ? face : point(last - 1, at(last), face));
    }
    return keys;
}

/// The base with its faces in the order in which the mesh has what they give, each from the corner
/// that gives the first: a mesh that was made by subdivision gives back what it was made of.
/// sqrt(3) numbers fine faces by old edges, so that the order of faces comes from their points; a
/// face begins with the first edge that none before it has.
struct Arranged {
    Topology base;
    MeshTags tags;
    Buffer<Index> half_edges;  ///< as the base was before
};
Result<Arranged> arranged(const Topology& base, const MeshTags& tags, const Keys& keys) {
    struct Face {
        Index key;
        Index first;
    };
    std::vector<Face> order(base.face_count);
    for (Index f = 0; f < base.face_count; ++f) {
        Index least = kNone;
        order[f].first = base.first_of(f);
        for (Index h = base.first_of(f); h < base.first_of(f + 1); ++h) {
            const Index twin = base.twin[h];
            if (!keys.of_face.empty() && twin != kNone &&
                keys.of_face[base.face_of(twin)] < keys.of_face[f])
                continue;
            if (keys.of_half_edge[h] >= least) continue;
            least = keys.of_half_edge[h];
            order[f].first = h;
        }
        order[f].key = keys.of_face.empty() ? least : keys.of_face[f];
    }
    std::sort(order.begin(), order.end(),
              [](const Face& a, const Face& b) { return a.key < b.key; });
    mesh::FaceList faces;
    Arranged result;
    result.half_edges = Buffer<Index>(base.half_edge_count());
    Index count = 0;
    for (const Face& face : order) {
        Index h = face.first;
        do {
            faces.corners.push_back(base.origin[h]);
            result.half_edges[count++] = h;
            h = base.next(h);
        } while (h != face.first);
        faces.offsets.push_back(count);
    }
    RELIEF_TRY(result.base, mesh::build(faces, base.vertex_count));
    result.tags.corner = tags.corner;
    if (tags.sharp.empty()) return result;
    result.tags.sharp.resize(base.edge_count);
    for (Index h = 0; h < count; ++h)
        result.tags.sharp[result.base.edge[h]] = tags.sharp[base.edge[result.half_edges[h]]];
    return result;
}

}  // namespace

Result<MeshOrigin> origin_of(const Topology& mesh, std::span<const Vec3<double>> points,
                             const MeshTags& tags, MeshScheme scheme, int most) {
    Descent descent(mesh, points, tags, scheme);
    descent.run(false, most);
    std::vector<Found> levels = std::move(descent.levels());
    const bool open = mesh::counts_of(mesh).boundary_edges > 0;
    if (scheme == MeshScheme::Sqrt3 && open) {
        Descent other(mesh, points, tags, scheme);
        other.run(true, most);
        // With as many levels, the one whose base begins with an odd step.
        const std::size_t steps = other.levels().size();
        if (steps > levels.size() || (steps > 0 && steps == levels.size() && steps % 2 == 0))
            levels = std::move(other.levels());
    }
    if (levels.empty())
        return descent.reason().value_or(
            Error{ErrorCode::InvalidArgument, "at least one level is needed", "levels"});
    MeshOrigin origin;
    coarser_tags(tags, mesh, levels.front(), &origin.lost_creases);
    origin.spec.scheme = scheme;
    origin.spec.first_even = open && levels.back().split == Split::Sqrt3Even;
    origin.steps = static_cast<int>(levels.size());
    if (levels.back().in_order) {
        origin.base = std::move(levels.back().unsplit.mesh);
        origin.tags = std::move(levels.back().tags);
        origin.half_edges = Buffer<Index>(mesh.half_edge_count());
        std::iota(origin.half_edges.data(), origin.half_edges.data() + mesh.half_edge_count(),
                  Index{0});
        return origin;
    }
    const Keys keys =
        scheme == MeshScheme::Sqrt3 ? keys_of_edges(levels, mesh) : keys_of_corners(levels, mesh);
    RELIEF_TRY(Arranged base, arranged(levels.back().unsplit.mesh, levels.back().tags, keys));
    RELIEF_TRY(origin.half_edges, climb(mesh, levels, base.base, std::move(base.half_edges)));
    origin.tags = std::move(base.tags);
    origin.base = std::move(base.base);
    return origin;
}

Result<MeshOrigin> renumbered(const MeshOrigin& origin, std::span<const Index> vertices,
                              std::span<const Index> corners) {
    const Topology& base = origin.base;
    std::vector<Index> numbers(base.vertex_count);
    for (Index v = 0; v < vertices.size(); ++v) numbers[vertices[v]] = v;
    MeshOrigin result;
    result.spec = origin.spec;
    result.steps = origin.steps;
    result.lost_creases = origin.lost_creases;
    mesh::FaceList faces;
    std::vector<Index> here;
    for (const Index first : corners) {
        Index h = first;
        do {
            faces.corners.push_back(numbers[base.origin[h]]);
            here.push_back(h);
            h = base.next(h);
        } while (h != first);
        faces.offsets.push_back(static_cast<std::int64_t>(here.size()));
    }
    RELIEF_TRY(result.base, mesh::build(faces, base.vertex_count));
    if (!origin.tags.corner.empty())
        for (const Index v : vertices) result.tags.corner.push_back(origin.tags.corner[v]);
    if (!origin.tags.sharp.empty()) {
        result.tags.sharp.resize(base.edge_count);
        for (Index h = 0; h < here.size(); ++h)
            result.tags.sharp[result.base.edge[h]] = origin.tags.sharp[base.edge[here[h]]];
    }
    // Both are subdivided side by side.
    Topology mine = *mesh::build(faces, base.vertex_count);
    Topology theirs = *mesh::build(mesh::faces_of(base), base.vertex_count);
    for (int step = 0; step < origin.steps; ++step) {
        const Split split = origin.spec.split(step);
        const Buffer<Index> starts = own_starts(theirs, split);
        Buffer<Index> start(here.size());
        for (std::size_t h = 0; h < here.size(); ++h) start[h] = starts[here[h]];
        RELIEF_TRY(theirs, mesh::refine(theirs, split));
        const Buffer<Index> finer = mesh::fine_half_edges(mine, split, theirs, start);
        here.assign(finer.data(), finer.data() + finer.size());
        RELIEF_TRY(mine, mesh::refine(mine, split));
    }
    result.half_edges = Buffer<Index>(here.size());
    for (std::size_t h = 0; h < here.size(); ++h) result.half_edges[h] = origin.half_edges[here[h]];
    return result;
}

}  // namespace relief::multires
