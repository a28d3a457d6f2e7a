#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "relief/core/vec3.h"
#include "relief/multires/subdivision_rules.h"

/// One step of subdivision with all its rules, forwards and backwards. Source:
/// reverse-subdivision.md sections 1 to 5.
namespace relief::multires {

/// Sharp features of a mesh: boundary edges are sharp anyway.
struct MeshTags {
    std::vector<std::uint8_t> sharp;  ///< [edge]: 1 if it is; empty: none but those of the boundary
    std::vector<std::uint8_t> corner;  ///< [vertex]; empty: none but where three sharp edges meet

    [[nodiscard]] bool is_sharp(const mesh::Topology& mesh, mesh::Index h) const {
        return mesh.on_boundary(h) || (!sharp.empty() && sharp[mesh.edge[h]] != 0);
    }
    friend bool operator==(const MeshTags&, const MeshTags&) = default;
};

/// Marks boundary vertices with a single face as corners: then they stay where they are.
void tag_boundary_corners(const mesh::Topology& mesh, MeshTags& tags);

/// Tags of the finer mesh: both halves of sharp edges, and corners.
[[nodiscard]] MeshTags refined(const MeshTags& tags, const mesh::Topology& coarse,
                               const mesh::Topology& fine, mesh::Split split);

/// A weight of identity 1: `point` counts the new vertices from 0.
struct PointWeight {
    mesh::Index vertex = 0;
    mesh::Index point = 0;
    double weight = 0;
};

/// An apex of a trisected triangle also depends on the ends of its boundary edge.
struct ApexWeight {
    mesh::Index apex = 0;
    mesh::Index from = 0;
    mesh::Index to = 0;
    double weight = 0;
};

/// The two new points of a trisected boundary edge, and the vertices of the curve around them.
struct Trisection {
    mesh::Index point = 0;  ///< the first one, from 0
    mesh::Index from = 0;
    mesh::Index to = 0;
    mesh::Index before = 0;
    mesh::Index after = 0;
    bool from_corner = false;
    bool to_corner = false;
};

/// Catmull-Clark vertices inside the surface with three edges: their D is 0, so that what is around
/// them gives c, together for those that are neighbours: 3 c_v + (sum of neighbours' c) = known.
/// Section 5.2.
struct StiffVertices {
    std::vector<mesh::Index> vertices;                   ///< ascending
    std::vector<std::array<mesh::Index, 3>> neighbours;  ///< which are stiff too: places; kNone
    /// Whole components in which neighbours have other colours: there, P loses the alternating sum
    /// of all c. vertices: places; sign: +1 or -1.
    struct Alternating {
        std::vector<mesh::Index> places;
        std::vector<std::int8_t> signs;
    };
    std::vector<Alternating> alternating;

    [[nodiscard]] std::size_t size() const { return vertices.size(); }
};

/// D and K of identity 1, and what new vertices need besides the mesh.
struct StepRules {
    mesh::Split split = mesh::Split::Loop;
    mesh::Index new_count = 0;
    Buffer<VertexKind> kinds;         ///< [vertex]
    Buffer<double> self;              ///< [vertex]: D
    Buffer<double> point;             ///< [vertex]: K of each new point around it, but of those of
                                      ///< `points`; Catmull-Clark: of edges; of faces -1/4 of it
    std::vector<PointWeight> points;  ///< of vertices that are not smooth
    std::vector<ApexWeight> apexes;
    std::vector<Trisection> trisections;
    std::vector<std::uint8_t> sharp;  ///< [edge] inside the surface; empty: none
    StiffVertices stiff;
    mesh::FacePoints face_points;  ///< of Catmull-Clark and sqrt(3)
};

struct StepOptions {
    /// sqrt(3): in place of the weight of neighbours by valence; 0 <= alpha < 2/3.
    std::optional<double> alpha = {};
};

/// Errors: InvalidArgument `invalid_parameter` for alpha, and for sharp edges inside a sqrt(3)
/// mesh; BadInput `unsupported_valence` for a vertex inside a sqrt(3) mesh with two edges;
/// those of mesh::refine. Complexity: O(n).
[[nodiscard]] Result<StepRules> step_rules(const mesh::Topology& coarse, const MeshTags& tags,
                                           mesh::Split split, const StepOptions& options = {});

/// The linear maps of a step. P takes coarse vertices to fine ones; vectors over the fine mesh have
/// its old vertices first. T: float or double. Sums are added in a fixed order. Complexity: O(n).
template <class T>
class MeshStep {
  public:
    using Points = Vec3<T>*;
    using ConstPoints = const Vec3<T>*;

    /// Both must outlive this.
    MeshStep(const mesh::Topology& coarse, const StepRules& rules) : mesh_(coarse), rules_(rules) {}

    [[nodiscard]] std::size_t coarse_count() const { return mesh_.vertex_count; }
    [[nodiscard]] std::size_t new_count() const { return rules_.new_count; }
    [[nodiscard]] const mesh::Topology& coarse() const { return mesh_; }
    [[nodiscard]] const StepRules& rules() const { return rules_; }

    /// fresh = P_new c.
    void predict(ConstPoints c, Points fresh) const;
    /// c += P_new^T y; y is altered.
    void predict_adjoint(Points y, Points c) const;
    /// old = K fresh.
    void gather(ConstPoints fresh, Points old) const;
    /// fresh += K^T old.
    void gather_adjoint(ConstPoints old, Points fresh) const;
    /// old += D c, with the apexes' part of identity 1.
    void add_self(ConstPoints c, Points old) const;
    /// c = D^T old.
    void self_adjoint(ConstPoints old, Points c) const;

    /// (old, fresh) = P c. old and c must differ.
    void apply(ConstPoints c, Points old, Points fresh) const;
    /// c = P^T (old, fresh); fresh is altered.
    void adjoint(ConstPoints old, Points fresh, Points c) const;

    /// In place: the old vertices of `fine` to c, the new ones to details g - P c. residuals: that
    /// of each stiff vertex, which its details do not give. scratch: of coarse size.
    void analyse(Points fine, Points residuals, Points scratch) const;
    /// The reverse.
    void synthesise(Points fine, ConstPoints residuals, Points scratch) const;

  private:
    void solve_stiff(ConstPoints fine, ConstPoints gathered, Points c) const;

    const mesh::Topology& mesh_;
    const StepRules& rules_;
};

}  // namespace relief::multires
