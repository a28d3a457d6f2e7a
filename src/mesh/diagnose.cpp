#include "mesh/loops.h"
#include "relief/mesh/repair.h"

namespace relief::mesh {

namespace {

using Kind = MeshProblemKind;

std::string ends(const Side& side) {
    return "the edge from vertex " + std::to_string(side.low()) + " to " +
           std::to_string(side.high());
}

/// Collects problems of one kind after the other.
class Report {
  public:
    explicit Report(std::size_t listed) : listed_(listed) {}

    /// message(): what to say of it, asked only if it is listed.
    template <class Message>
    void add(Kind kind, Index element, std::array<Index, 2> edge, Message message) {
        auto& count = result_.counts[static_cast<std::size_t>(kind)];
        if (count++ < listed_) result_.problems.push_back({kind, element, edge, message()});
    }
    template <class Message>
    void add(Kind kind, Index element, Message message) {
        add(kind, element, {kNone, kNone}, message);
    }
    [[nodiscard]] MeshDiagnosis take() {
        std::stable_sort(
            result_.problems.begin(), result_.problems.end(),
            [](const MeshProblem& a, const MeshProblem& b) { return a.kind < b.kind; });
        return std::move(result_);
    }

  private:
    std::size_t listed_;
    MeshDiagnosis result_;
};

void report_faces(const FaceList& faces, Index vertex_count, std::span<const Flaws> flaws,
                  Report& report) {
    for (Index f = 0; f < flaws.size(); ++f) {
        const Flaws& flaw = flaws[f];
        if (flaw.missing != kNone)
            report.add(Kind::MissingVertex, f, [&] {
                return "index_out_of_range: it names vertex " + std::to_string(flaw.missing) +
                       " of " + std::to_string(vertex_count) + "; vertices count from 0";
            });
        if (flaw.repeated != kNone)
            report.add(Kind::RepeatedCorner, f, [&] {
                return "repeated_corner: it names vertex " + std::to_string(flaw.repeated) +
                       " twice";
            });
        if (flaw.degenerate)
            report.add(Kind::TooFewCorners, f, [&] {
                return "too_few_corners: no three different ones are left of its " +
                       std::to_string(faces[f].size());
            });
    }
}

void report_duplicates(const Loops& loops, std::span<const Index> equals, Report& report) {
    for (Index l = 0; l < loops.size(); ++l)
        if (equals[l] != l)
            report.add(Kind::DuplicateFace, loops.source[l], [&] {
                return "duplicate_face: it has the corners of face " +
                       std::to_string(loops.source[equals[l]]);
            });
}

/// Problems of edges, in the order of their first faces.
void report_edges(const Loops& loops, std::span<const Side> sides, Report& report) {
    struct Found {
        Index face;
        std::span<const Side> at;
    };
    std::vector<Found> found;
    group_by_edge(sides, [&](std::span<const Side> at) {
        const bool turned = at.size() == 2 && same_direction(loops, at[0], at[1]);
        if (turned || at.size() > 2)
            found.push_back({loops.source[loops.loop[at[turned ? 1 : 0].corner]], at});
    });
    std::stable_sort(found.begin(), found.end(),
                     [](const Found& a, const Found& b) { return a.face < b.face; });
    for (const Found& crowd : found) {
        const Index face = crowd.face;
        const std::span<const Side> at = crowd.at;
        const Side& side = at[0];
        const std::array<Index, 2> edge = {side.low(), side.high()};
        if (at.size() > 2)
            report.add(Kind::CrowdedEdge, face, edge, [&] {
                return "non_manifold_edge: " + ends(side) + " has " + std::to_string(at.size()) +
                       " faces";
            });
        else
            report.add(Kind::TurnedFace, face, edge, [&] {
                return "non_manifold_edge: it runs along " + ends(side) +
                       " in the same direction as face " +
                       std::to_string(loops.source[loops.loop[side.corner]]) +
                       ": they are oriented differently";
            });
    }
}

void report_vertices(const Loops& loops, std::span<const Side> sides, Index vertex_count,
                     Report& report) {
    TurnedSets corners(loops.corner.size());
    group_by_edge(sides, [&](std::span<const Side> at) {
        for (std::size_t k = 1; k < at.size(); ++k) join_corners(loops, at[0], at[k], corners);
    });
    std::vector<Index> fans(vertex_count, 0);
    for (Index c = 0; c < loops.corner.size(); ++c)
        if (corners.find(c).root == c) ++fans[loops.vertex(c)];
    for (Index v = 0; v < vertex_count; ++v) {
        if (fans[v] > 1)
            report.add(Kind::SeveralFans, v, [&] {
                return "non_manifold_vertex: its faces form " + std::to_string(fans[v]) + " fans";
            });
        if (fans[v] == 0)
            report.add(Kind::UnusedVertex, v, [] { return "unused_vertex: no face names it"; });
    }
}

}  // namespace

MeshDiagnosis diagnose(const FaceList& faces, Index vertex_count, std::size_t listed) {
    Report report(listed);
    const auto [all, flaws] = sort_faces(faces, vertex_count);
    report_faces(faces, vertex_count, flaws, report);
    const std::vector<Index> equals = first_equals(all);
    report_duplicates(all, equals, report);
    const Loops loops = distinct(all, equals);
    const std::vector<Side> sides = sides_of(loops);
    report_edges(loops, sides, report);
    report_vertices(loops, sides, vertex_count, report);
    return report.take();
}

}  // namespace relief::mesh
