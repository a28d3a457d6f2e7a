#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "relief/mesh/triangulation.h"

namespace relief::codec {

/// The vertices of a triangulation from coarse to fine: 0, then the odd multiples of 2^k, k
/// descending. Numbers along a curve thus give rounds each of which lies between what the rounds
/// before have left open. Knows what lies around a vertex of those before it. docs/format.md,
/// "Rounds".
class PsSurroundings {
  public:
    /// The mesh must outlive this.
    explicit PsSurroundings(const mesh::Triangulation& mesh);

    /// The order: visit(vertex, known vertices around it), until it returns false.
    template <class Visit>
    bool each(Visit visit) {
        const mesh::Index count = mesh_.vertex_count();
        if (!visit_one(0, 0, visit)) return false;
        mesh::Index stride = 1;
        while (stride < count / 2 + count % 2) stride *= 2;
        for (; stride > 0; stride /= 2)
            for (mesh::Index v = stride; v < count; v += 2 * stride)
                if (!visit_one(v, stride, visit)) return false;
        return true;
    }

  private:
    /// Of further strides, neighbours in the order are known to be near, and others hard to find.
    static constexpr mesh::Index kLargestSearched = 64;
    static constexpr std::size_t kEnough = 6;
    static constexpr std::size_t kMost = 24;
    static constexpr std::size_t kMostSeen = 1024;
    static constexpr std::size_t kMostSpokes = 64;

    template <class Visit>
    bool visit_one(mesh::Index v, mesh::Index stride, Visit& visit) {
        find(v, stride);
        known_[v] = 1;
        return visit(v, std::span<const mesh::Index>(around_));
    }
    void find(mesh::Index v, mesh::Index stride);
    void find_along_order(mesh::Index v, mesh::Index stride);
    void see_neighbours(mesh::Index v);

    const mesh::Triangulation& mesh_;
    mesh::VertexStars neighbours_;
    std::vector<std::uint8_t> known_;
    std::vector<mesh::Index> seen_from_;  ///< [vertex]: the last vertex whose search met it
    std::vector<mesh::Index> ring_;
    std::vector<mesh::Index> around_;
    mesh::Index searching_ = 0;
};

}  // namespace relief::codec
