#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "relief/mesh/split.h"

/// Recognises meshes that come from a split, whatever their numbering. Source:
/// reverse-subdivision.md section 9.
namespace relief::mesh {

/// A mesh whose split is the given one.
///
/// Vertices are numbered as they are in the finer mesh, faces begin with their smallest vertex and
/// are sorted.
struct Unsplit {
    Topology mesh;
    /// Of coarse half-edge h the fine one that the split puts there: from its origin to the new
    /// point on its edge (Loop, Catmull-Clark) or beyond it (sqrt(3)); sqrt(3) on the boundary:
    /// itself (odd steps), or its middle third (even steps).
    Buffer<Index> fine;
    std::vector<Index> old_vertices;  ///< of the finer mesh: those of the coarser one, ascending
};

/// Which half-edges of a finer mesh the split of a coarser one gives: for each half-edge of
/// refine(coarse, split). start: for each half-edge of `coarse` what Unsplit::fine says.
[[nodiscard]] Buffer<Index> fine_half_edges(const Topology& coarse, Split split,
                                            const Topology& fine, const Buffer<Index>& start);

/// The coarser mesh of which `refine` makes this one, number for number; nothing if there is none,
/// or a boundary was trisected. It may break the promises of Topology, where different edges or
/// fans have the same vertices: see is_built. Then so do all coarser ones. Complexity: O(n), in the
/// order of memory.
[[nodiscard]] std::optional<Topology> unsplit_in_order(const Topology& fine, Split split);

/// Whether `build` makes this mesh of its faces. Complexity: O(n).
[[nodiscard]] bool is_built(const Topology& mesh);

struct CoarseFaces;
struct Conflict;

/// Ways to see the components of a mesh as split; none for those that are not.
class Recognition {
  public:
    /// `fine` must outlive this. quads_only: Catmull-Clark, the coarser mesh has quads only.
    /// Complexity: O(n).
    Recognition(const Topology& fine, Split split, bool quads_only = false);
    ~Recognition();

    [[nodiscard]] std::size_t components() const { return ways_.size(); }
    /// In how many ways component k is split: at most four. Regular tori have several, and closed
    /// Catmull-Clark meshes where coarse vertices and face points may be exchanged.
    [[nodiscard]] std::size_t ways(std::size_t k) const { return ways_[k].size(); }
    /// Whether the coarser faces of component k have, in one of its ways, as many corners as those
    /// that a split makes: else its coarser mesh comes from no other.
    [[nodiscard]] bool is_uniform(std::size_t k, std::size_t way) const {
        return (uneven_[k] >> ways_[k][way] & 1) == 0;
    }
    /// The component of each fine face.
    [[nodiscard]] const Components& parts() const { return parts_; }
    /// Every component has a way.
    [[nodiscard]] bool ok() const;
    /// `no_subdivision_connectivity`: of the first component without a way, and why. Requires: not
    /// ok().
    [[nodiscard]] Error error() const;

    /// The coarser mesh. choice: for each component the number of a way. Errors: those of build,
    /// which do not happen.
    [[nodiscard]] Result<Unsplit> unsplit(const std::vector<std::size_t>& choice) const;

  private:
    void take_ways(std::size_t component, std::span<const Conflict> conflicts);
    void label_open_components();
    void drop(std::size_t component, std::size_t way, const char* reason);
    [[nodiscard]] std::vector<std::uint8_t> bad_vertices() const;
    void check_coarse_edges(std::size_t way);
    /// Of all faces in one way for each component. See split_labels.h.
    [[nodiscard]] Buffer<std::uint8_t> labels_of(std::span<const std::size_t> ways) const;

    const Topology& fine_;
    Split split_;
    bool quads_only_;
    Components parts_;
    std::vector<std::uint8_t> labels_;  ///< [face]: which of its corners are old ones, in all ways
    std::vector<bool> paired_;          ///< [component]: its labels are those of the only way
    std::vector<std::vector<std::size_t>> ways_;     ///< [component]: those that it has
    std::vector<std::uint8_t> uneven_;               ///< [component]: a bit a way: not uniform
    std::vector<std::string> reasons_;               ///< [component]: why it has none
    std::vector<std::size_t> last_ways_;             ///< [component]: those checked last,
    std::unique_ptr<const CoarseFaces> last_faces_;  ///< and their faces
};

}  // namespace relief::mesh
