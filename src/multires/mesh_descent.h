#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "relief/mesh/recognise.h"
#include "relief/multires/mesh_hierarchy.h"

namespace relief::multires {

/// A level that was found, and how to get back to the finer one.
struct FoundLevel {
    mesh::Unsplit unsplit;
    mesh::Split split = mesh::Split::Loop;
    MeshTags tags;
    bool in_order = false;  ///< the finer one has the numbers of the split
};

/// For each half-edge of a mesh where its split has what Unsplit::fine names.
[[nodiscard]] Buffer<mesh::Index> own_starts(const mesh::Topology& coarse, mesh::Split split);

/// Tags of the coarser mesh: an edge is sharp if both of its halves are. lost: gets the sharp edges
/// inside the finer mesh that are no halves of such an edge, in their order; may be null.
MeshTags coarser_tags(const MeshTags& tags, const mesh::Topology& fine, const FoundLevel& found,
                      std::vector<mesh::Index>* lost);

/// The levels below a mesh, the finest step first. Where components can be seen as split in several
/// ways, those are taken from which it goes on; of several of these, the one whose subdivision is
/// nearest to the points.
class MeshDescent {
  public:
    using Points = std::vector<Vec3<double>>;

    /// All but `even` must outlive this. even: sqrt(3), the parity of the finest step. points:
    /// empty: of several ways the first.
    MeshDescent(const mesh::Topology& mesh, std::span<const Vec3<double>> points,
                const MeshTags& tags, MeshScheme scheme, bool even)
        : mesh_(mesh), tags_(tags), scheme_(scheme), even_(even), points_(points) {}

    /// Goes down as far as meshes have the numbers of subdivision: no other way could be meant.
    void read_in_order(int most);
    /// Goes on in any order.
    void search(int most);

    /// Why the search ended.
    [[nodiscard]] const std::optional<Error>& reason() const { return reason_; }
    [[nodiscard]] std::vector<std::unique_ptr<FoundLevel>>& levels() { return levels_; }

  private:
    /// [component]: ways to see it.
    using Choices = std::vector<std::vector<std::size_t>>;
    /// What is below a choice of ways.
    struct Ahead {
        std::vector<std::size_t> choice;
        std::unique_ptr<FoundLevel> found;
        std::unique_ptr<const mesh::Recognition> next;
    };
    /// The components seen in some ways, and how far subdivision stays from the points.
    struct Attempt {
        std::vector<std::size_t> choice;
        std::unique_ptr<FoundLevel> found;
        Points coarse;
        std::vector<double> squares;  ///< [component]: of the distances
    };

    [[nodiscard]] mesh::Split split_at(std::size_t level) const {
        return split_of(scheme_, even_ == (level % 2 == 0) ? 1 : 0);
    }
    [[nodiscard]] const mesh::Topology& finer(std::size_t k) const {
        return k == 0 ? mesh_ : levels_[k - 1]->unsplit.mesh;
    }
    [[nodiscard]] const mesh::Topology& finest_left() const { return finer(levels_.size()); }
    [[nodiscard]] const MeshTags& tags_left() const {
        return levels_.empty() ? tags_ : levels_.back()->tags;
    }
    [[nodiscard]] std::span<const Vec3<double>> points_at(std::size_t k) const {
        return k == 0 ? points_ : coarser_points_[k - 1];
    }

    void link_levels_in_order();
    [[nodiscard]] Result<std::span<const Vec3<double>>> points_left();
    [[nodiscard]] Result<std::unique_ptr<FoundLevel>> found(
        const std::vector<std::size_t>& choice) const;
    [[nodiscard]] Result<std::unique_ptr<FoundLevel>> choose();
    [[nodiscard]] Result<Choices> choices_that_go_on(const Choices& all);
    [[nodiscard]] Result<std::unique_ptr<FoundLevel>> nearest(const Choices& choices);
    [[nodiscard]] Result<Attempt> attempted(std::vector<std::size_t> choice);

    const mesh::Topology& mesh_;
    const MeshTags& tags_;
    MeshScheme scheme_;
    bool even_;
    std::vector<std::unique_ptr<FoundLevel>> levels_;
    std::unique_ptr<const mesh::Recognition> recognition_;  ///< of the coarsest mesh so far
    std::optional<Ahead> ahead_;
    std::span<const Vec3<double>> points_;
    std::vector<Points> coarser_points_;  ///< of levels_, as far as asked for
    std::optional<Error> reason_;
};

}  // namespace relief::multires
