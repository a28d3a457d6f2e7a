#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "relief/multires/subdivide.h"

/// Forward subdivision with kept memory: the faces of the finest mesh once, its points again and
/// again. Source: reverse-subdivision.md sections 2 to 5, performance.md sections 2 and 3.
namespace relief::multires {

/// What is sharp in a mesh.
struct SharpFeatures {
    struct Edge {
        mesh::Index half_edge = 0;
        double sharpness = 0;
    };
    struct Vertex {
        mesh::Index vertex = 0;
        double sharpness = 0;
    };
    std::vector<Edge> edges;       ///< by one of their half-edges; those of the boundary for ever
    std::vector<Vertex> vertices;  ///< ascending
};

/// The rules of one step, for arrays over the vertices of a coarse mesh. Every vertex of the finer
/// mesh has its smooth rule; what is sharp there, a sparse list, then takes its place.
struct ForwardRules {
    /// The smooth rules of the first vertices, and of all others, whose valence is regular.
    std::vector<rules::RingRule> first;
    rules::RingRule others;

    struct Term {
        mesh::Index coarse = 0;
        double weight = 0;
    };
    /// A fine vertex that becomes smooth x (what its smooth rule says) + the sum of its terms.
    struct Mask {
        mesh::Index fine = 0;
        std::size_t terms_end = 0;  ///< its terms follow those of the mask before
        double smooth = 0;
    };
    std::vector<Mask> masks;
    std::vector<Term> terms;

    /// Even sqrt(3) steps: faces with a boundary edge, ascending.
    std::vector<mesh::Index> trisected;
};

/// Subdivides a base mesh some steps: `prepare` computes the meshes between the base and the finest
/// one, and the rules; then `faces` and `points` are read from them as often as needed, as for the
/// frames of an animation. All memory is kept for later calls, also for those with other meshes.
/// Results are the same bytes on every machine. One call at a time; all need a `prepare` that
/// succeeded.
class Subdivider {
  public:
    /// The base must stay as it is until the next `prepare`. Errors: InvalidArgument for steps < 1,
    /// sharpness that is negative, not a number or of another size, for sharp edges inside a
    /// sqrt(3) mesh, and for alpha; those of mesh::check_split, of any step. Complexity: O(the mesh
    /// before the finest).
    [[nodiscard]] Status prepare(const mesh::Topology& base, const Sharpness& sharpness,
                                 const MeshSpec& spec, int steps);

    /// Of the finest mesh, whose faces all have `sides` corners.
    [[nodiscard]] mesh::MeshCounts counts() const;
    [[nodiscard]] int sides() const { return mesh::sides_after(splits_.back()); }

    /// The corners of the finest faces, in the numbers of mesh::refine. Requires: room for
    /// counts().half_edges. Complexity: O(result).
    void faces(std::span<mesh::Index> corners) const;

    /// An array over the vertices of the finest mesh from one over those of the base: places, or
    /// what is to follow them. T: float or double. Requires: as many elements as the base has
    /// vertices, room for counts().vertices; they may not overlap. Complexity: O(result).
    template <class T>
    void points(std::span<const Vec3<T>> base, std::span<Vec3<T>> fine);

    /// The finest mesh with its half-edges. Complexity: O(result).
    [[nodiscard]] Result<mesh::Topology> finest() const;
    /// What is left of the sharpness after all steps. Requires: `finest` as this gave it.
    [[nodiscard]] Sharpness sharpness(const mesh::Topology& finest) const;

  private:
    [[nodiscard]] const mesh::Topology& level(std::size_t depth) const {
        return depth == 0 ? *base_ : levels_[depth - 1];
    }

    const mesh::Topology* base_ = nullptr;
    std::vector<mesh::Split> splits_;     ///< [step]
    std::vector<mesh::Topology> levels_;  ///< depths 1 to steps - 1, and more from earlier calls
    std::vector<ForwardRules> rules_;     ///< [step]
    SharpFeatures left_;
    bool has_sharp_edges_ = false;
    bool has_sharp_vertices_ = false;
    Buffer<std::byte> sums_;
};

}  // namespace relief::multires
