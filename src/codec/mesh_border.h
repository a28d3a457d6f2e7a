#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "relief/mesh/index.h"

namespace relief::codec {

/// The border of the part of a mesh that is known while its faces come one by one. docs/format.md,
/// "Connectivity".
///
/// A border edge is named by the half-edge of the known face beside it, and runs against it: for
/// the faces that are to come. Border edges form loops.
class MeshBorder {
  public:
    using Index = mesh::Index;

    [[nodiscard]] bool is_open(Index edge) const { return open_[edge] != 0; }
    [[nodiscard]] Index next(Index edge) const { return next_[edge]; }
    [[nodiscard]] Index prev(Index edge) const { return prev_[edge]; }
    [[nodiscard]] Index origin(Index edge) const { return to_[edge]; }
    [[nodiscard]] Index target(Index edge) const { return from_[edge]; }
    /// Known faces at a vertex.
    [[nodiscard]] Index degree(Index vertex) const { return degree_[vertex]; }
    [[nodiscard]] std::size_t half_edges() const { return from_.size(); }

    /// Which known vertex a corner is, or that it is new.
    struct Corner {
        Index vertex = 0;
        Index out =
            mesh::kNone;     ///< the border edge that leaves it where the face comes; none: new
        bool glued = false;  ///< the side towards the next corner lies on `out`
    };

    /// A face of corners 0, 1, ..; no edge of it is known.
    void add_seed(std::span<const Corner> corners);
    /// A face whose side 0 lies on `gate`: corners 0 and 1 are its ends. Its new border edges are
    /// named by the sides that are not glued.
    void add_face(Index gate, std::span<const Corner> corners);

  private:
    void add_half_edges(std::span<const Corner> corners);
    void link(Index before, Index after) {
        next_[before] = after;
        prev_[after] = before;
    }

    std::vector<Index> from_;  ///< [half-edge]
    std::vector<Index> to_;
    std::vector<Index> next_;  ///< [border edge]
    std::vector<Index> prev_;
    std::vector<std::uint8_t> open_;
    std::vector<Index> degree_;  ///< [vertex]
};

}  // namespace relief::codec
