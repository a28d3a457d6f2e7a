#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "relief/mesh/triangulation.h"

namespace relief::multires::ps {

/// The points around a vertex that local fits look at. One object a thread.
class StencilSearch {
  public:
    /// Both must outlive this.
    StencilSearch(const mesh::Triangulation& mesh, const mesh::VertexStars& neighbours)
        : mesh_(mesh), neighbours_(neighbours), slots_(kSlots, mesh::kNone) {}

    /// Whole rings of edge neighbours of v until there are `enough` points, but at most four rings.
    /// Rings do not grow through other vertices of more than kMostSpokes edges, so that a vertex
    /// that many others share costs no more than others. Complexity: O(points), at most
    /// enough x kMostSpokes but for the first ring.
    [[nodiscard]] std::span<const mesh::Index> rings(mesh::Index v, std::size_t enough);

    /// The same; of more than `most` points the nearest, in the order of (squared distance,
    /// number).
    [[nodiscard]] std::span<const mesh::Index> nearest(mesh::Index v, std::size_t enough,
                                                       std::size_t most);

  private:
    static constexpr int kMostRings = 4;
    static constexpr std::size_t kMostSpokes = 64;
    static constexpr std::size_t kSlots = 4096;

    struct Distance {
        double squared;
        mesh::Index vertex;
        bool operator<(const Distance& other) const {
            return squared != other.squared ? squared < other.squared : vertex < other.vertex;
        }
    };

    bool mark(mesh::Index v);

    const mesh::Triangulation& mesh_;
    const mesh::VertexStars& neighbours_;
    std::vector<mesh::Index> slots_;  ///< a hash table of what is found; kNone: free
    std::vector<std::size_t> used_;   ///< its slots
    std::vector<mesh::Index> found_;
    std::vector<Distance> sorted_;
};

}  // namespace relief::multires::ps
