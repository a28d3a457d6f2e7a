#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "relief/mesh/quadrangulation.h"

/// Recognises meshes that are refinements of coarser ones, whatever their numbering. Source:
/// fvs-hierarchical.md section 3.
namespace relief::mesh {

/// A quad of another mesh, and which of its corners is corner 0 here.
struct TurnedQuad {
    Index quad = 0;
    Index turn = 0;

    friend bool operator==(const TurnedQuad&, const TurnedQuad&) = default;
};

/// The quadrangulation whose refinement a finer one is.
struct Coarsening {
    Quadrangulation mesh;
    std::vector<Index> vertices;  ///< of the finer mesh, ascending: those that the coarser one has
    std::vector<std::array<TurnedQuad, 4>> children;  ///< child i of every quad, (v_i, M_i, c, ..)
};

/// Undoes `refine`: nothing if the mesh is no refinement, which also asks that midpoints and
/// centres lie where refinement puts them, to 1e-9 of the coarser quad's sides. Coarse quads are in
/// the order of their first children and begin with those; so a mesh that refine has made gives
/// back the vertices and quads it was made of, in their order. Complexity: O(n log n).
[[nodiscard]] std::optional<Coarsening> coarsen(const Quadrangulation& fine);

/// What a mesh was refined from.
struct Refinement {
    int levels = 0;                           ///< refinements that lead from base to the mesh
    std::vector<Index> vertices;              ///< of the mesh: those of base
    std::vector<std::array<Index, 4>> quads;  ///< of base; corners count in `vertices`
    std::vector<TurnedQuad> finest;  ///< for each quad of base refined `levels` times: its number
                                     ///< in the mesh
};

/// Coarsens as often as possible, but at most `most` times. Complexity: O(n log n).
[[nodiscard]] Refinement refinement_of(const Quadrangulation& mesh, int most);

}  // namespace relief::mesh
