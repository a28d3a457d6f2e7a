#include "relief/mesh/recognise.h"

#include <algorithm>
#include <array>
#include <utility>

#include "mesh/coarse_faces.h"
#include "mesh/seed_spread.h"
#include "mesh/twins.h"
#include "relief/mesh/walk.h"

namespace relief::mesh {

namespace {

constexpr const char* kBadVertex =
    "a vertex has another number of edges than new ones have, or is old to one face and new to "
    "another";
constexpr const char* kBadCoarse = "the coarser faces would repeat a corner or share an edge twice";

/// What there is at a vertex: its edges, and its roles in all ways.
struct Around {
    std::uint32_t edges = 0;
    PackedRoles roles = 0;
    std::uint8_t open = 0;      ///< on the boundary
    std::uint8_t opposite = 0;  ///< boundary edges across its faces, at most 255

    [[nodiscard]] Role role(std::size_t way) const { return role_in(roles, way); }
};

/// Labels of an open component in odd sqrt(3) steps: faces on the boundary have pairs of old
/// corners and tell all others.
class PairSpread {
  public:
    PairSpread(const Topology& fine, std::vector<PackedLabels>& labels)
        : fine_(fine), labels_(labels) {}

    /// boundary: faces of the component; all others are kUnlabelled.
    Conflict run(std::span<const Index> boundary) {
        for (const Index f : boundary)
            set(f, static_cast<Label>(kPair + boundary_side(fine_, f) - 3 * f));
        for (std::size_t k = 0; k < queue_.size(); ++k) {
            const Conflict conflict = spread_from(queue_[k]);
            if (conflict.reason) return conflict;
        }
        return {};
    }

  private:
    void set(Index face, Label label) {
        labels_[face] = label;
        queue_.push_back(face);
    }

    Conflict spread_from(Index f) {
        const Label label = labels_[f];
        for (Index k = 0; k < 3; ++k) {
            const Index twin = fine_.twin[3 * f + k];
            if (twin == kNone) {
                if (!may_end(Split::Sqrt3Odd, label, k)) return {kBoundaryPattern, f};
                continue;
            }
            const Index g = twin / 3;
            const Index m = twin % 3;
            const int wanted = label_across(Split::Sqrt3Odd, label, k, m);
            if (wanted == kConflict) return {kLabelConflict, f};
            if (labels_[g] == kUnlabelled)
                set(g, static_cast<Label>(wanted));
            else if (!agrees(labels_[g], wanted, m))
                return {kLabelConflict, g};
        }
        return {};
    }

    const Topology& fine_;
    std::vector<PackedLabels>& labels_;
    std::vector<Index> queue_;
};

/// New vertices have as many edges as the split gives them.
bool is_good(Split split, bool quads_only, const Around& v, Role role) {
    switch (role) {
        case kOld:
            return true;
        case kEdgePoint:
            return v.edges == (split == Split::Loop ? 6U - 2U * v.open : 4U - v.open);
        case kFacePoint:
            break;
        default:
            return false;
    }
    if (split == Split::CatmullClark)
        return !v.open && v.edges >= 3 && (!quads_only || v.edges == 4);
    if (split == Split::Sqrt3Odd) return v.edges + v.opposite == 6;
    return v.edges == (v.open ? 4U : 6U);
}

}  // namespace

Recognition::Recognition(const Topology& fine, Split split, bool quads_only)
    : fine_(fine), split_(split), quads_only_(quads_only) {
    const int sides = split == Split::CatmullClark ? 4 : 3;
    if (fine.sides != sides) {
        parts_ = mesh::components(fine);
        ways_.resize(parts_.count);
        uneven_.resize(parts_.count);
        reasons_.assign(parts_.count, sides == 4 ? "not_quads: the mesh has other faces than quads"
                                                 : "not_triangles: the mesh has other faces than "
                                                   "triangles");
        return;
    }
    SeedSpread spread = spread_seeds(fine, split);
    parts_ = std::move(spread.parts);
    labels_ = std::move(spread.labels);
    ways_.resize(parts_.count);
    uneven_.resize(parts_.count);
    reasons_.resize(parts_.count);
    paired_.assign(parts_.count, false);
    for (std::size_t c = 0; c < ways_.size(); ++c)
        take_ways(c, {spread.conflicts[c].data(), way_count(split)});
    if (split == Split::Sqrt3Odd) label_open_components();
    const std::vector<std::uint8_t> bad = bad_vertices();
    for (std::size_t way = 0; way < way_count(split); ++way) {
        for (std::size_t c = 0; c < ways_.size(); ++c)
            if (bad[c] >> way & 1) drop(c, way, kBadVertex);
        check_coarse_edges(way);
    }
}

Recognition::~Recognition() = default;

/// Of several conflicts that at the last face is told.
void Recognition::take_ways(std::size_t component, std::span<const Conflict> conflicts) {
    ways_[component].clear();
    reasons_[component].clear();
    const Conflict* last = nullptr;
    for (std::size_t way = 0; way < conflicts.size(); ++way)
        if (!conflicts[way].reason)
            ways_[component].push_back(way);
        else if (!last || conflicts[way].face >= last->face)
            last = &conflicts[way];
    if (last)
        reasons_[component] = std::string(last->reason) + ": face " + std::to_string(last->face);
}

void Recognition::label_open_components() {
    std::vector<std::vector<Index>> boundaries(parts_.count);
    for (Index f = 0; f < fine_.face_count; ++f)
        if (boundary_side(fine_, f) != kNone) boundaries[parts_.of_face[f]].push_back(f);
    for (std::size_t c = 0; c < boundaries.size(); ++c) paired_[c] = !boundaries[c].empty();
    for (Index f = 0; f < fine_.face_count; ++f)
        if (paired_[parts_.of_face[f]]) labels_[f] = kUnlabelled;
    for (std::size_t c = 0; c < boundaries.size(); ++c) {
        if (!paired_[c]) continue;
        const Conflict conflict = PairSpread(fine_, labels_).run(boundaries[c]);
        take_ways(c, {&conflict, 1});
    }
}

Buffer<Label> Recognition::labels_of(std::span<const std::size_t> ways) const {
    Buffer<Label> labels(fine_.face_count);
    for (Index f = 0; f < fine_.face_count; ++f) {
        const Index c = parts_.of_face[f];
        labels[f] = ways[c] == kMostWays ? kUnlabelled
                    : paired_[c]         ? labels_[f]
                                         : label_in(split_, labels_[f], ways[c]);
    }
    return labels;
}

void Recognition::drop(std::size_t component, std::size_t way, const char* reason) {
    if (std::erase(ways_[component], way) > 0 && reasons_[component].empty())
        reasons_[component] = reason;
}

/// For each component a bit for each way in which roles do not agree, or new vertices have other
/// numbers of edges than the split gives them.
std::vector<std::uint8_t> Recognition::bad_vertices() const {
    const std::size_t ways = way_count(split_);
    const RoleTable& roles = role_table(split_);
    const auto sides = static_cast<Index>(fine_.sides);
    Buffer<Around> around(fine_.vertex_count);
    std::fill_n(around.data(), around.size(), Around());
    each_half_edge(fine_, [&](Index f, Index h, Index next, Index prev) {
        Around& v = around[fine_.origin[h]];
        const Index corner = h - sides * f;
        v.roles |= paired_[parts_.of_face[f]] ? role_of(split_, labels_[f], corner)
                                              : roles[corner][labels_[f]];
        ++v.edges;
        if (!fine_.on_boundary(h)) return;
        v.open = 1;
        ++around[fine_.origin[next]].edges;
        auto& opposite = around[fine_.origin[prev]].opposite;
        opposite += opposite < 255;
    });
    Buffer<std::uint8_t> bad(fine_.vertex_count);
    std::uint8_t any = 0;
    for (Index v = 0; v < fine_.vertex_count; ++v) {
        bad[v] = 0;
        for (std::size_t way = 0; way < ways; ++way)
            if (!is_good(split_, quads_only_, around[v], around[v].role(way)))
                bad[v] |= static_cast<std::uint8_t>(1U << way);
        any |= bad[v];
    }
    std::vector<std::uint8_t> result(ways_.size(), 0);
    if (any == 0 && split_ != Split::Sqrt3Even) return result;
    Buffer<Index> before(split_ == Split::Sqrt3Even ? fine_.vertex_count : 0);
    for (Index h = 0; before.size() > 0 && h < fine_.half_edge_count(); ++h)
        if (fine_.on_boundary(h)) before[fine_.target(h)] = fine_.origin[h];
    each_half_edge(fine_, [&](Index f, Index h, Index next, Index) {
        std::uint8_t& mask = result[parts_.of_face[f]];
        mask |= bad[fine_.origin[h]];
        if (before.size() == 0 || !fine_.on_boundary(h)) return;
        // Boundaries go old, new, new, old, ..
        for (std::size_t way = 0; way < ways; ++way) {
            int old = 0;
            for (const Index v : {before[fine_.origin[h]], fine_.origin[h], fine_.origin[next]})
                old += around[v].role(way) == kOld;
            if (old != 1) mask |= static_cast<std::uint8_t>(1U << way);
        }
    });
    return result;
}

/// No face repeats a corner, and no two share an edge twice. Notes which are uneven.
void Recognition::check_coarse_edges(std::size_t way) {
    std::vector<std::size_t> choice(ways_.size(), kMostWays);
    bool any = false;
    for (std::size_t c = 0; c < ways_.size(); ++c) {
        if (std::find(ways_[c].begin(), ways_[c].end(), way) == ways_[c].end()) continue;
        choice[c] = way;
        any = true;
    }
    if (!any) return;
    const Buffer<Label> labels = labels_of(choice);
    last_faces_ = std::make_unique<const CoarseFaces>(coarse_faces(fine_, split_, labels.data()));
    last_ways_ = std::move(choice);
    const CoarseFaces& coarse = *last_faces_;
    const auto refuse = [&](std::size_t corner) {
        drop(parts_.of_face[fine_.face_of(coarse.fine[corner])], way, kBadCoarse);
    };
    Topology mesh;
    mesh.vertex_count = fine_.vertex_count;
    set_faces(coarse.faces.offsets, coarse.faces.corners, mesh);
    std::vector<Index> seen(fine_.vertex_count, kNone);
    const auto sides = static_cast<Index>(sides_after(split_));
    for (Index f = 0; f < mesh.face_count; ++f) {
        if (mesh.size_of(f) != sides)
            uneven_[parts_.of_face[fine_.face_of(coarse.fine[mesh.first_of(f)])]] |=
                static_cast<std::uint8_t>(1U << way);
        for (Index h = mesh.first_of(f); h < mesh.first_of(f + 1); ++h)
            if (std::exchange(seen[mesh.origin[h]], f) == f || mesh.size_of(f) < 3) refuse(h);
    }
    if (link_corners(mesh)) return;
    for (const Index h : find_twins(mesh)) refuse(h);
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
    std::vector<std::size_t> ways(choice.size());
    for (std::size_t c = 0; c < choice.size(); ++c) ways[c] = ways_[c][choice[c]];
    Unsplit result;
    const auto sort_faces = [&](const CoarseFaces& faces) {
        return sorted(faces, fine_.vertex_count, result.old_vertices);
    };
    const CoarseFaces coarse =
        ways == last_ways_ ? sort_faces(*last_faces_)
                           : sort_faces(coarse_faces(fine_, split_, labels_of(ways).data()));
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
