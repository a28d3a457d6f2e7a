#include "relief/mesh/recognise.h"

#include <algorithm>
#include <array>
#include <utility>

#include "mesh/split_labels.h"
#include "mesh/twins.h"

namespace relief::mesh {

namespace {

constexpr const char* kLabelConflict = "faces around it ask different things of one";
constexpr const char* kBoundaryPattern = "its boundary does not have the pattern";
constexpr const char* kBadVertex =
    "a vertex has another number of edges than new ones have, or is old to one face and new to "
    "another";
constexpr const char* kBadCoarse = "the coarser faces would repeat a corner or share an edge twice";

/// Which roles faces give to a vertex; each has one.
using Role = std::uint8_t;
constexpr Role kOld = 1;
constexpr Role kEdgePoint = 2;
constexpr Role kFacePoint = 4;

Role role_of(Split split, Label label, Index corner) {
    if (split == Split::CatmullClark) {
        const Index place = (corner + 4 - label) % 4;
        return place == 0 ? kOld : place == 2 ? kFacePoint : kEdgePoint;
    }
    const Role fresh = split == Split::Loop ? kEdgePoint : kFacePoint;
    if (label >= kPair) {
        const Index j = label - kPair;
        return corner == (j + 2) % 3 ? fresh : kOld;
    }
    return corner == label ? kOld : fresh;
}

/// Coarse faces whose corners are fine vertices, and the fine half-edges at them.
struct CoarseFaces {
    FaceList faces;
    std::vector<Index> fine;

    void add(Index corner, Index half_edge) {
        faces.corners.push_back(corner);
        fine.push_back(half_edge);
    }
    void end_face() { faces.offsets.push_back(static_cast<std::int64_t>(faces.corners.size())); }
};

/// Collects the coarse faces of all fine faces with a label.
template <class LabelOf>
class Emitter {
  public:
    Emitter(const Topology& fine, Split split, LabelOf label_of)
        : fine_(fine), split_(split), label_of_(label_of) {}

    CoarseFaces run() {
        if (split_ == Split::Loop)
            add_centres();
        else
            add_fans();
        if (split_ == Split::Sqrt3Even) add_trisected();
        return std::move(coarse_);
    }

  private:
    /// Across the sides of a middle face are its corners.
    void add_centres() {
        for (Index f = 0; f < fine_.face_count; ++f) {
            if (label_of_(f) != kCentre) continue;
            for (Index h = 3 * f; h < 3 * f + 3; ++h) {
                const Index out = fine_.prev(fine_.twin[h]);
                coarse_.add(fine_.origin[out], out);
            }
            coarse_.end_face();
        }
    }

    /// Around face points.
    void add_fans() {
        const auto out = outgoing(fine_);
        for (Index v = 0; v < fine_.vertex_count; ++v) {
            const Label label = label_of_(fine_.face_of(out[v]));
            if (label == kUnlabelled || fine_.on_boundary(out[v]) ||
                role_of(split_, label, out[v] - fine_.first_of(fine_.face_of(out[v]))) !=
                    kFacePoint)
                continue;
            Index h = out[v];
            do {
                const Index corner = fine_.face_of(h);
                if (split_ == Split::CatmullClark) {
                    const Index old = fine_.next(fine_.next(h));
                    coarse_.add(fine_.origin[old], old);
                } else if (role_of(split_, label_of_(corner), fine_.next(h) - 3 * corner) == kOld) {
                    coarse_.add(fine_.target(h), fine_.next(h));
                }
                h = rotated(fine_, h);
            } while (h != out[v]);
            coarse_.end_face();
        }
    }

    /// Even sqrt(3): (p, q, c) on the boundary is the middle of (a, b, c).
    void add_trisected() {
        Buffer<Index> before(fine_.vertex_count);
        for (Index h = 0; h < fine_.half_edge_count(); ++h)
            if (fine_.on_boundary(h)) before[fine_.target(h)] = h;
        const auto out = outgoing(fine_);
        for (Index f = 0; f < fine_.face_count; ++f) {
            const Label label = label_of_(f);
            if (label > 2) continue;
            const Index middle = 3 * f + (label + 1U) % 3;
            if (!fine_.on_boundary(middle)) continue;
            const Index last = fine_.target(out[fine_.target(middle)]);
            const Index to_p = fine_.twin[fine_.prev(middle)];
            if (to_p == kNone) continue;  // its vertices are refused
            coarse_.add(fine_.origin[before[fine_.origin[middle]]], middle);
            coarse_.add(last, fine_.next(out[fine_.target(middle)]));
            coarse_.add(fine_.origin[3 * f + label], fine_.next(to_p));
            coarse_.end_face();
        }
    }

    const Topology& fine_;
    Split split_;
    LabelOf label_of_;
    CoarseFaces coarse_;
};

template <class LabelOf>
CoarseFaces coarse_faces(const Topology& fine, Split split, LabelOf label_of) {
    return Emitter<LabelOf>(fine, split, label_of).run();
}

/// Ranks of the corners among all of them; `old` gets the corners, ascending.
void rank_corners(Index vertex_count, FaceList& faces, std::vector<Index>& old) {
    std::vector<Index> rank(vertex_count, kNone);
    for (const Index v : faces.corners) rank[v] = 0;
    for (Index v = 0; v < vertex_count; ++v) {
        if (rank[v] == kNone) continue;
        rank[v] = static_cast<Index>(old.size());
        old.push_back(v);
    }
    for (Index& v : faces.corners) v = rank[v];
}

/// Faces begin with their smallest vertex and are sorted: by it, and by the second.
CoarseFaces sorted(const CoarseFaces& coarse, std::size_t vertices) {
    struct Face {
        Index second;
        Index number;
        Index turn;
    };
    const std::size_t count = coarse.faces.size();
    std::vector<Index> ends(vertices + 1, 0);
    std::vector<Face> order(count);
    const auto smallest = [&](std::size_t f) {
        const auto corners = coarse.faces[f];
        return static_cast<Index>(std::min_element(corners.begin(), corners.end()) -
                                  corners.begin());
    };
    for (std::size_t f = 0; f < count; ++f) ++ends[coarse.faces[f][smallest(f)]];
    Index sum = 0;
    for (Index& end : ends) sum += std::exchange(end, sum);
    for (std::size_t f = 0; f < count; ++f) {
        const auto corners = coarse.faces[f];
        const Index turn = smallest(f);
        order[ends[corners[turn]]++] = {corners[(turn + 1) % corners.size()], static_cast<Index>(f),
                                        turn};
    }
    Index begin = 0;
    for (std::size_t v = 0; v < vertices; ++v) {
        std::sort(order.begin() + begin, order.begin() + ends[v],
                  [](const Face& a, const Face& b) { return a.second < b.second; });
        begin = ends[v];
    }
    CoarseFaces result;
    result.faces.corners.reserve(coarse.fine.size());
    result.fine.reserve(coarse.fine.size());
    for (const Face& face : order) {
        const auto corners = coarse.faces[face.number];
        const auto first = static_cast<std::size_t>(coarse.faces.offsets[face.number]);
        for (std::size_t k = 0; k < corners.size(); ++k) {
            const std::size_t corner = (face.turn + k) % corners.size();
            result.add(corners[corner], coarse.fine[first + corner]);
        }
        result.end_face();
    }
    return result;
}

}  // namespace

Recognition::Recognition(const Topology& fine, Split split, bool quads_only)
    : fine_(fine), split_(split), quads_only_(quads_only), parts_(mesh::components(fine)) {
    ways_.resize(parts_.count);
    reasons_.resize(parts_.count);
    const int sides = split == Split::CatmullClark ? 4 : 3;
    if (fine.sides != sides) {
        for (std::string& reason : reasons_)
            reason = sides == 4 ? "not_quads: the mesh has other faces than quads"
                                : "not_triangles: the mesh has other faces than triangles";
        return;
    }
    labels_.assign(split == Split::Loop || split == Split::CatmullClark ? 4 : 3,
                   Labels(fine.face_count, kUnlabelled));
    std::vector<Index> seeds(parts_.count);
    for (Index f = fine.face_count; f-- > 0;) seeds[parts_.of_face[f]] = f;
    std::vector<std::vector<Index>> boundaries(parts_.count);
    for (Index f = 0; split == Split::Sqrt3Odd && f < fine.face_count; ++f)
        if (boundary_side(fine, f) != kNone) boundaries[parts_.of_face[f]].push_back(f);
    for (std::size_t c = 0; c < seeds.size(); ++c) find(c, seeds[c], boundaries[c]);
    const auto valence = valences(fine);
    for (std::size_t way = 0; way < labels_.size(); ++way) {
        const auto has_way = [&](const auto& ways) {
            return std::find(ways.begin(), ways.end(), way) != ways.end();
        };
        if (std::none_of(ways_.begin(), ways_.end(), has_way)) continue;
        check_vertices(way, {valence.data(), valence.size()});
        check_coarse_edges(way);
    }
}

namespace {

/// Labels one component from what is queued. Returns nothing, or what is wrong where.
struct Conflict {
    const char* reason = nullptr;
    Index face = 0;
};

class Spread {
  public:
    Spread(const Topology& fine, Split split, std::vector<Label>& labels)
        : fine_(fine), split_(split), sides_(static_cast<Index>(fine.sides)), labels_(labels) {}

    void set(Index face, Label label) {
        labels_[face] = label;
        queue_.push_back(face);
    }

    Conflict run() {
        for (std::size_t k = 0; k < queue_.size(); ++k) {
            const Conflict conflict = spread_from(queue_[k]);
            if (conflict.reason) return conflict;
        }
        return {};
    }

    void undo() {
        for (const Index f : queue_) labels_[f] = kUnlabelled;
    }

  private:
    Conflict spread_from(Index f) {
        const Label label = labels_[f];
        for (Index k = 0; k < sides_; ++k) {
            const Index twin = fine_.twin[sides_ * f + k];
            if (twin == kNone) {
                if (!may_end(split_, label, k)) return {kBoundaryPattern, f};
                continue;
            }
            const Index g = twin / sides_;
            const Index m = twin % sides_;
            const int wanted = label_across(split_, label, k, m);
            if (wanted == kConflict) return {kLabelConflict, f};
            if (labels_[g] == kUnlabelled)
                set(g, static_cast<Label>(wanted));
            else if (!agrees(labels_[g], wanted, m))
                return {kLabelConflict, g};
        }
        return {};
    }

    const Topology& fine_;
    Split split_;
    Index sides_;
    std::vector<Label>& labels_;
    std::vector<Index> queue_;
};

}  // namespace

/// boundary: faces that tell all others, in odd sqrt(3) steps on open surfaces.
void Recognition::find(std::size_t component, Index seed, std::span<const Index> boundary) {
    const std::size_t seeds = boundary.empty() ? labels_.size() : 1;
    std::size_t most = 0;
    for (std::size_t way = 0; way < seeds; ++way) {
        Spread spread(fine_, split_, labels_[way]);
        for (const Index f : boundary)
            spread.set(f, static_cast<Label>(kPair + boundary_side(fine_, f) - 3 * f));
        if (boundary.empty())
            spread.set(seed, way == 3 && split_ == Split::Loop ? kCentre : static_cast<Label>(way));
        const Conflict conflict = spread.run();
        if (!conflict.reason) {
            ways_[component].push_back(way);
            continue;
        }
        spread.undo();
        if (conflict.face < most && !reasons_[component].empty()) continue;
        most = conflict.face;
        reasons_[component] =
            std::string(conflict.reason) + ": face " + std::to_string(conflict.face);
    }
}

void Recognition::drop(std::size_t way, const std::vector<bool>& bad, const char* reason) {
    bool any = false;
    for (std::size_t c = 0; c < ways_.size(); ++c) {
        if (!bad[c]) continue;
        any = std::erase(ways_[c], way) > 0 || any;
        if (reasons_[c].empty()) reasons_[c] = reason;
    }
    if (!any) return;
    for (Index f = 0; f < fine_.face_count; ++f)
        if (bad[parts_.of_face[f]]) labels_[way][f] = kUnlabelled;
}

/// Roles agree, and new vertices have as many edges as the split gives them.
void Recognition::check_vertices(std::size_t way, std::span<const Index> valences) {
    const Labels& labels = labels_[way];
    std::vector<std::uint8_t> roles(fine_.vertex_count, 0);
    std::vector<std::uint8_t> open(fine_.vertex_count, 0);
    const auto sides = static_cast<Index>(fine_.sides);
    for (Index h = 0; h < fine_.half_edge_count(); ++h) {
        const Index f = h / sides;
        if (labels[f] == kUnlabelled) continue;
        roles[fine_.origin[h]] |= role_of(split_, labels[f], h - sides * f);
        if (!fine_.on_boundary(h)) continue;
        open[fine_.origin[h]] = 1;
        // Odd sqrt(3): faces on the boundary take an edge from their new vertex.
        if (split_ == Split::Sqrt3Odd) ++open[fine_.origin[fine_.prev(h)]];
    }
    const auto is_good = [&](Index v) {
        switch (roles[v]) {
            case kOld:
                return true;
            case kEdgePoint:
                return valences[v] == (split_ == Split::Loop ? 6U : 4U) - (open[v] != 0) -
                                          (open[v] != 0 && split_ == Split::Loop);
            case kFacePoint:
                break;
            default:
                return false;
        }
        if (split_ == Split::CatmullClark)
            return open[v] == 0 && valences[v] >= 3 && (!quads_only_ || valences[v] == 4);
        if (split_ == Split::Sqrt3Odd) return valences[v] + open[v] == 6;
        return valences[v] == (open[v] ? 4U : 6U);
    };
    std::vector<bool> bad(ways_.size(), false);
    for (Index h = 0; h < fine_.half_edge_count(); ++h) {
        const Index f = h / sides;
        if (labels[f] != kUnlabelled && !is_good(fine_.origin[h])) bad[parts_.of_face[f]] = true;
    }
    if (split_ == Split::Sqrt3Even) check_thirds(roles, bad);
    drop(way, bad, kBadVertex);
}

/// Boundaries go old, new, new, old, ..
void Recognition::check_thirds(std::span<const std::uint8_t> roles, std::vector<bool>& bad) const {
    Buffer<Index> before(fine_.vertex_count);
    for (Index h = 0; h < fine_.half_edge_count(); ++h)
        if (fine_.on_boundary(h)) before[fine_.target(h)] = fine_.origin[h];
    for (Index h = 0; h < fine_.half_edge_count(); ++h) {
        if (!fine_.on_boundary(h)) continue;
        const bool first = roles[before[fine_.origin[h]]] == kOld;
        const bool second = roles[fine_.origin[h]] == kOld;
        const bool third = roles[fine_.target(h)] == kOld;
        if (first + second + third != 1) bad[parts_.of_face[fine_.face_of(h)]] = true;
    }
}

void Recognition::check_coarse_edges(std::size_t way) {
    const Labels& labels = labels_[way];
    const CoarseFaces coarse = coarse_faces(fine_, split_, [&](Index f) { return labels[f]; });
    std::vector<bool> bad(ways_.size(), false);
    const auto refuse = [&](std::size_t corner) {
        bad[parts_.of_face[fine_.face_of(coarse.fine[corner])]] = true;
    };
    Topology mesh;
    mesh.vertex_count = fine_.vertex_count;
    mesh.face_count = static_cast<Index>(coarse.faces.size());
    mesh.sides = split_ == Split::CatmullClark ? 0 : 3;
    mesh.origin = Buffer<Index>(coarse.faces.corners.size());
    std::copy(coarse.faces.corners.begin(), coarse.faces.corners.end(), mesh.origin.data());
    if (mesh.sides == 0) {
        mesh.first = Buffer<Index>(coarse.faces.offsets.size());
        mesh.face = Buffer<Index>(mesh.origin.size());
        for (std::size_t f = 0; f < coarse.faces.offsets.size(); ++f)
            mesh.first[f] = static_cast<Index>(coarse.faces.offsets[f]);
        for (Index f = 0; f < mesh.face_count; ++f)
            std::fill(mesh.face.data() + mesh.first[f], mesh.face.data() + mesh.first[f + 1], f);
    }
    std::vector<Index> seen(fine_.vertex_count, kNone);
    for (Index f = 0; f < mesh.face_count; ++f)
        for (Index h = mesh.first_of(f); h < mesh.first_of(f + 1); ++h)
            if (std::exchange(seen[mesh.origin[h]], f) == f || mesh.size_of(f) < 3) refuse(h);
    for (const Index h : find_twins(mesh)) refuse(h);
    drop(way, bad, kBadCoarse);
}

bool Recognition::ok() const {
    return std::none_of(ways_.begin(), ways_.end(), [](const auto& ways) { return ways.empty(); });
}

Error Recognition::error() const {
    std::size_t component = 0;
    while (!ways_[component].empty()) ++component;
    const char* const names[] = {"Loop", "Catmull-Clark", "sqrt(3)", "sqrt(3)"};
    return Error{ErrorCode::BadInput,
                 "no_subdivision_connectivity: its faces are not those of a " +
                     std::string(names[static_cast<std::size_t>(split_)]) +
                     " subdivision of a coarser mesh (" + reasons_[component] + ")",
                 "component " + std::to_string(component)};
}

Result<Unsplit> Recognition::unsplit(const std::vector<std::size_t>& choice) const {
    CoarseFaces coarse = coarse_faces(fine_, split_, [&](Index f) {
        const Index component = parts_.of_face[f];
        return labels_[ways_[component][choice[component]]][f];
    });
    Unsplit result;
    rank_corners(fine_.vertex_count, coarse.faces, result.old_vertices);
    coarse = sorted(coarse, result.old_vertices.size());
    RELIEF_TRY(result.mesh, build(coarse.faces, static_cast<Index>(result.old_vertices.size())));
    result.fine = Buffer<Index>(coarse.fine.size());
    std::copy(coarse.fine.begin(), coarse.fine.end(), result.fine.data());
    return result;
}

Buffer<Index> fine_half_edges(const Topology& coarse, Split split, const Topology& fine,
                              const Buffer<Index>& start) {
    Buffer<Index> result(refined(counts_of(coarse), split).half_edges);
    const auto put_triangle = [&](Index to, Index h) {
        result[to] = h;
        result[to + 1] = fine.next(h);
        result[to + 2] = fine.prev(h);
    };
    if (split == Split::Loop) {
        for (Index h = 0; h < coarse.half_edge_count(); ++h) {
            const Index f = h / 3;
            put_triangle(12 * f + 3 * (h - 3 * f), start[h]);
            const Index corner = coarse.next(h);
            result[12 * f + 9 + (h - 3 * f)] = fine.twin[fine.next(start[corner])];
        }
        return result;
    }
    if (split == Split::CatmullClark) {
        for (Index h = 0; h < coarse.half_edge_count(); ++h)
            for (Index k = 0, child = start[h]; k < 4; ++k, child = fine.next(child))
                result[4 * h + k] = child;
        return result;
    }
    const auto faces = sqrt3_faces(coarse, split);
    for (Index h = 0; h < coarse.half_edge_count(); ++h) put_triangle(3 * faces[h], start[h]);
    return result;
}

}  // namespace relief::mesh
