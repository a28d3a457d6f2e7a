#include "relief/mesh/coarsen.h"

#include <algorithm>
#include <utility>

namespace relief::mesh {

namespace {

constexpr Index kNone = ~Index{0};
constexpr double kTolerance = 1e-9;

/// Children 0 .. 3 of a coarse quad.
using Family = std::array<Index, 4>;

/// Tells for every quad of a refined mesh which corner was one of its parent: its turn t. Then its
/// corners t .. t + 3 are (v_i, M_i, c, M_(i-1)). One quad decides for all that are connected with
/// it through edges.
class Turns {
  public:
    explicit Turns(const Quadrangulation& fine)
        : fine_(fine), neighbours_(edge_quads(fine)), turns_(fine.quads.size(), kNone) {}

    /// False: the mesh is no refinement.
    bool find() {
        for (Index q = 0; q < fine_.quad_count(); ++q) {
            Index turn = 0;
            while (turns_[q] == kNone && turn < 4 && !spread(q, turn)) ++turn;
            if (turn == 4) return false;
        }
        return true;
    }

    [[nodiscard]] Index of(Index q) const { return turns_[q]; }
    /// Corner k of quad q, counted from its turn.
    [[nodiscard]] Index corner(Index q, Index k) const {
        return fine_.quads[q][(turns_[q] + k) % 4];
    }

    /// The children of the parent of q, beginning with q, if there are four around one centre.
    [[nodiscard]] std::optional<Family> family(Index q) const {
        Family children{};
        Index child = q;
        for (Index& place : children) {
            if (child == kNone || turns_[child] == kNone) return std::nullopt;
            place = child;
            child = across(child, (turns_[child] + 1) % 4);
        }
        const bool closed = child == q && children[1] != q && children[2] != q;
        return closed ? std::optional(children) : std::nullopt;
    }

  private:
    /// The quad behind side i of q.
    [[nodiscard]] Index across(Index q, Index i) const {
        const auto& pair = neighbours_[fine_.quad_edges[q][i]];
        return pair[0] == q ? pair[1] : pair[0];
    }

    /// Whether all quads connected with `first` are children if `turn` is that of the first. If
    /// not, they stay without turns.
    bool spread(Index first, Index turn) {
        std::vector<Index> reached = {first};
        turns_[first] = turn;
        bool good = true;
        for (std::size_t k = 0; good && k < reached.size(); ++k) good = visit(reached[k], reached);
        for (std::size_t k = 0; good && k < reached.size(); ++k) good = is_child(reached[k]);
        if (!good)
            for (const Index q : reached) turns_[q] = kNone;
        return good;
    }

    /// Gives the neighbours of q their turns, or finds that they have others.
    bool visit(Index q, std::vector<Index>& reached) {
        for (Index i = 0; i < 4; ++i) {
            const Index next = across(q, i);
            if (next == kNone) continue;
            const auto& edges = fine_.quad_edges[next];
            const auto j = static_cast<Index>(
                std::find(edges.begin(), edges.end(), fine_.quad_edges[q][i]) - edges.begin());
            // Corner i of q, which has role i - turn, is corner j + 1 of its neighbour. Between v
            // and M all sides are alike, and between M and c, so that roles are mirrored.
            const Index turn = (j + 1 + (i + 4 - turns_[q])) % 4;
            if (turns_[next] == turn) continue;
            if (turns_[next] != kNone) return false;
            turns_[next] = turn;
            reached.push_back(next);
        }
        return true;
    }

    /// Whether q has three siblings, and their corners lie where refinement puts them.
    [[nodiscard]] bool is_child(Index q) const {
        const auto children = family(q);
        if (!children) return false;
        QuadCorners v;
        for (Index i = 0; i < 4; ++i) v[i] = fine_.vertex(corner((*children)[i], 0));
        if (!(doubled_area(v) > 0)) return false;
        const double size = std::max(length(v[2] - v[0]), length(v[3] - v[1]));
        if (!is_near(fine_.vertex(corner(q, 2)), diagonals(v).centre, size)) return false;
        return is_near(fine_.vertex(corner(q, 1)), midpoint(v[0], v[1]), length(v[1] - v[0]));
    }

    static bool is_near(Vec2 p, Vec2 expected, double size) {
        return length(p - expected) <= kTolerance * size;
    }

    const Quadrangulation& fine_;
    std::vector<std::array<Index, 2>> neighbours_;
    std::vector<Index> turns_;
};

enum class Role : std::uint8_t { Unknown, Corner, Midpoint, Centre };

/// Puts coarse quads together; vertices must be what all their quads say.
class Parents {
  public:
    Parents(const Quadrangulation& fine, const Turns& turns)
        : fine_(fine),
          turns_(turns),
          roles_(fine.vertex_count(), Role::Unknown),
          ends_(fine.vertex_count(), {kNone, kNone}) {}

    std::optional<Coarsening> build_all() {
        std::vector<std::uint8_t> taken(fine_.quads.size());
        for (Index q = 0; q < fine_.quad_count(); ++q) {
            if (taken[q]) continue;
            const Family family = *turns_.family(q);
            for (const Index child : family) taken[child] = 1;
            if (!add(family)) return std::nullopt;
        }
        return finished();
    }

  private:
    bool add(const Family& family) {
        std::array<Index, 4> corners{};
        std::array<TurnedQuad, 4> children{};
        for (std::size_t i = 0; i < 4; ++i) {
            corners[i] = turns_.corner(family[i], 0);
            children[i] = {family[i], turns_.of(family[i])};
            if (!takes_role(corners[i], Role::Corner)) return false;
        }
        for (std::size_t i = 0; i < 4; ++i) {
            const Index middle = turns_.corner(family[i], 1);
            const auto ends = std::minmax(corners[i], corners[(i + 1) % 4]);
            const std::array<Index, 2> pair = {ends.first, ends.second};
            if (!takes_role(middle, Role::Midpoint)) return false;
            if (ends_[middle][0] == kNone) ends_[middle] = pair;
            if (ends_[middle] != pair) return false;
        }
        const Index centre = turns_.corner(family[0], 2);
        if (roles_[centre] != Role::Unknown) return false;
        roles_[centre] = Role::Centre;
        result_.children.push_back(children);
        quads_.push_back(corners);
        return true;
    }

    bool takes_role(Index v, Role role) {
        if (roles_[v] == Role::Unknown) roles_[v] = role;
        return roles_[v] == role;
    }

    std::optional<Coarsening> finished() {
        std::vector<Index> number(fine_.vertex_count());
        std::vector<Vec2> vertices;
        for (Index v = 0; v < fine_.vertex_count(); ++v) {
            if (roles_[v] != Role::Corner) continue;
            number[v] = static_cast<Index>(vertices.size());
            result_.vertices.push_back(v);
            vertices.push_back(fine_.vertex(v));
        }
        for (auto& quad : quads_)
            for (Index& v : quad) v = number[v];
        auto mesh = build(vertices, quads_);
        if (!mesh.ok()) return std::nullopt;
        result_.mesh = *std::move(mesh);
        return std::move(result_);
    }

    const Quadrangulation& fine_;
    const Turns& turns_;
    std::vector<Role> roles_;
    std::vector<std::array<Index, 2>> ends_;  ///< of the coarse edge of a midpoint
    std::vector<std::array<Index, 4>> quads_;
    Coarsening result_;
};

}  // namespace

std::optional<Coarsening> coarsen(const Quadrangulation& fine) {
    if (fine.quads.empty() || fine.quads.size() % 4 != 0) return std::nullopt;
    Turns turns(fine);
    if (!turns.find()) return std::nullopt;
    return Parents(fine, turns).build_all();
}

Refinement refinement_of(const Quadrangulation& mesh, int most) {
    std::vector<Coarsening> steps;  // from fine to coarse
    for (const Quadrangulation* finer = &mesh; static_cast<int>(steps.size()) < most;) {
        auto step = coarsen(*finer);
        if (!step) break;
        steps.push_back(*std::move(step));
        finer = &steps.back().mesh;
    }
    Refinement result;
    result.levels = static_cast<int>(steps.size());
    const Quadrangulation& base = steps.empty() ? mesh : steps.back().mesh;
    result.quads = base.quads;
    for (Index v = 0; v < base.vertex_count(); ++v) {
        Index number = v;
        for (auto step = steps.rbegin(); step != steps.rend(); ++step)
            number = step->vertices[number];
        result.vertices.push_back(number);
    }
    for (Index q = 0; q < base.quad_count(); ++q) result.finest.push_back({q, 0});
    for (auto step = steps.rbegin(); step != steps.rend(); ++step) {
        std::vector<TurnedQuad> finer;
        for (const TurnedQuad& at : result.finest)
            for (Index i = 0; i < 4; ++i)
                finer.push_back(step->children[at.quad][(i + at.turn) % 4]);
        result.finest = std::move(finer);
    }
    return result;
}

}  // namespace relief::mesh
