#pragma once

#include <optional>
#include <unordered_map>
#include <vector>

#include "edit/model.h"
#include "relief/mesh/index.h"

namespace relief::edit {

/// What moved at a vertex in all.
struct VertexMove {
    Vec3<double> delta = {};
    Vec2 slope = {};
};

/// The moves of vertices, by level (0 the finest), and what they add to the splines of the levels:
/// each level's own moves on top of what the next coarser level's moves make of its vertices. What
/// they add is a function of the sums alone. It is brought up to date by `settle`, where moves
/// changed and no further.
class PlaneMoves {
  public:
    /// What was there before a group of moves.
    struct Undo {
        struct Entry {
            int level = 0;
            mesh::Index vertex = 0;
            std::optional<VertexMove> before;
        };
        std::vector<Entry> entries;
    };

    explicit PlaneMoves(int levels);
    PlaneMoves(const PlaneMoves&) = delete;
    PlaneMoves& operator=(const PlaneMoves&) = delete;
    virtual ~PlaneMoves() = default;

    /// Moves whose `point` is a vertex.
    [[nodiscard]] Undo add(const std::vector<PointMove>& moves);
    void restore(const Undo& undo);
    [[nodiscard]] VertexMove at(int level, mesh::Index vertex) const;

    /// Complexity: O(vertices that change).
    void settle();
    /// By level, the vertices whose spline changed since this was last asked, ascending. Requires:
    /// settled.
    [[nodiscard]] std::vector<std::vector<mesh::Index>> take_changed();

  protected:
    /// The vertices of `level` that depend on some vertices of level + 1; both ascending.
    [[nodiscard]] virtual std::vector<mesh::Index> children(
        int level, const std::vector<mesh::Index>& parents) const = 0;
    /// Computes anew what moves of `level` and coarser ones add at vertices, and returns those
    /// around them at which the spline of the level changed; both ascending.
    [[nodiscard]] virtual std::vector<mesh::Index> update(
        int level, const std::vector<mesh::Index>& vertices) = 0;

  private:
    std::vector<std::unordered_map<mesh::Index, VertexMove>> sums_;
    std::vector<std::vector<mesh::Index>> moved_;    ///< since the last settlement
    std::vector<std::vector<mesh::Index>> changed_;  ///< ascending
};

}  // namespace relief::edit
