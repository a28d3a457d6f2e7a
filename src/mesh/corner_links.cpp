#include <algorithm>
#include <utility>

#include "mesh/twins.h"
#include "relief/mesh/walk.h"

namespace relief::mesh {

namespace {

/// Vertices of a block have numbers that differ in these bits alone.
constexpr unsigned kBlockBits = 12;
constexpr Index kBlock = Index{1} << kBlockBits;
/// Half-edges that are fetched ahead.
constexpr std::size_t kAhead = 24;
/// Vertices with more corners than this are matched by sorting.
constexpr Index kFew = 16;

/// A corner of a face: the vertices behind and before it there.
struct Corner {
    Index next;
    Index prev;
    Index half_edge;
};

/// The half-edges sorted by the blocks of their origins: those of block b are first[b] ..
/// first[b + 1] - 1.
struct Blocks {
    std::vector<Index> first;
    Buffer<Index> half_edges;

    explicit Blocks(const Topology& mesh)
        : first((std::size_t{mesh.vertex_count} >> kBlockBits) + 2),
          half_edges(mesh.origin.size()) {
        for (Index h = 0; h < mesh.half_edge_count(); ++h) ++first[mesh.origin[h] >> kBlockBits];
        Index sum = 0;
        for (Index& begin : first) sum += std::exchange(begin, sum);
        std::vector<Index> end = first;
        for (Index h = 0; h < mesh.half_edge_count(); ++h)
            half_edges[end[mesh.origin[h] >> kBlockBits]++] = h;
    }
};

/// The edge that leaves a corner enters another one: edges with the same ends meet at both. Sides:
/// of all faces; 0: of several kinds.
template <Index Sides>
class Linker {
  public:
    explicit Linker(Topology& mesh) : mesh_(mesh), begin_(kBlock + 1) {
        mesh_.twin = Buffer<Index>(mesh_.origin.size());
    }

    std::optional<Index> run() {
        const Blocks blocks(mesh_);
        for (std::size_t b = 0; b + 1 < blocks.first.size(); ++b) {
            const Index* first = blocks.half_edges.data() + blocks.first[b];
            collect({first, blocks.first[b + 1] - std::size_t{blocks.first[b]}});
            for (Index v = 0; v < kBlock; ++v)
                if (!link({corners_.data() + begin_[v], begin_[v + 1] - begin_[v]}))
                    return std::nullopt;
        }
        return used_;
    }

  private:
    [[nodiscard]] Index next(Index h) const {
        if constexpr (Sides == 0)
            return mesh_.next(h);
        else
            return h % Sides + 1 == Sides ? h + 1 - Sides : h + 1;
    }
    [[nodiscard]] Index prev(Index h) const {
        if constexpr (Sides == 0)
            return mesh_.prev(h);
        else
            return h % Sides == 0 ? h + Sides - 1 : h - 1;
    }

    /// The corners of a block, vertex by vertex.
    void collect(std::span<const Index> half_edges) {
        std::fill(begin_.begin(), begin_.end(), Index{0});
        for (std::size_t k = 0; k < half_edges.size(); ++k) {
            if (k + kAhead < half_edges.size())
                __builtin_prefetch(&mesh_.origin[half_edges[k + kAhead]]);
            ++begin_[mesh_.origin[half_edges[k]] % kBlock];
        }
        Index sum = 0;
        for (Index& begin : begin_) sum += std::exchange(begin, sum);
        corners_.resize(half_edges.size());
        for (const Index h : half_edges)
            corners_[begin_[mesh_.origin[h] % kBlock]++] = {mesh_.origin[next(h)],
                                                            mesh_.origin[prev(h)], h};
        std::move_backward(begin_.begin(), begin_.end() - 1, begin_.end());
        begin_[0] = 0;
    }

    /// The corners at a vertex. false: an edge leaves it twice, or there are several fans.
    bool link(std::span<Corner> corners) {
        if (corners.empty()) return true;
        ++used_;
        after_.assign(corners.size(), kNone);
        const bool good = corners.size() > kFew ? match_many(corners) : match_few(corners);
        return good && is_fan(corners);
    }

    /// Corner `to` is entered by the edge that leaves corner `from`.
    void match(std::span<const Corner> corners, Index from, Index to) {
        mesh_.twin[corners[from].half_edge] = prev(corners[to].half_edge);
        after_[to] = from;
    }

    bool match_few(std::span<const Corner> corners) {
        bool twice = false;
        for (Index i = 0; i < corners.size(); ++i) {
            const Index next = corners[i].next;
            Index entered = kNone;
            Index leaves = 0;
            for (Index j = 0; j < corners.size(); ++j) {  // without branches
                entered = corners[j].prev == next ? j : entered;
                leaves += corners[j].next == next;
            }
            twice = twice || leaves > 1;
            if (entered == kNone)
                mesh_.twin[corners[i].half_edge] = kNone;
            else
                match(corners, i, entered);
        }
        return !twice;
    }

    bool match_many(std::span<Corner> corners) {
        const auto by_next = [](const Corner& a, const Corner& b) { return a.next < b.next; };
        std::sort(corners.begin(), corners.end(), by_next);
        for (std::size_t i = 1; i < corners.size(); ++i)
            if (corners[i].next == corners[i - 1].next) return false;
        for (const Corner& corner : corners) mesh_.twin[corner.half_edge] = kNone;
        for (Index j = 0; j < corners.size(); ++j) {
            const Corner wanted{corners[j].prev, 0, 0};
            const auto at = std::lower_bound(corners.begin(), corners.end(), wanted, by_next);
            if (at != corners.end() && at->next == wanted.next)
                match(corners, static_cast<Index>(at - corners.begin()), j);
        }
        return true;
    }

    /// Counter-clockwise from the corner on whose side the boundary is, or from any.
    [[nodiscard]] bool is_fan(std::span<const Corner> corners) const {
        Index start = 0;
        for (Index i = 0; i < corners.size(); ++i)
            if (mesh_.twin[corners[i].half_edge] == kNone) start = i;
        std::size_t found = 0;
        Index i = start;
        do {
            ++found;
            i = after_[i];
        } while (i != kNone && i != start && found < corners.size());
        return found == corners.size() && (i == kNone || i == start);
    }

    Topology& mesh_;
    Index used_ = 0;
    std::vector<Index> begin_;     ///< [vertex of the block]: of its corners
    std::vector<Corner> corners_;  ///< of the block
    std::vector<Index> after_;     ///< [corner at the vertex]: the next one, counter-clockwise
};

}  // namespace

std::optional<Index> link_corners(Topology& mesh) {
    return mesh.sides == 3   ? Linker<3>(mesh).run()
           : mesh.sides == 4 ? Linker<4>(mesh).run()
                             : Linker<0>(mesh).run();
}

}  // namespace relief::mesh
