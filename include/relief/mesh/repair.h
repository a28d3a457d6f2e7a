#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "relief/core/polygon_mesh.h"
#include "relief/mesh/topology.h"

/// What keeps a polygon mesh from being an oriented manifold, and how that is mended. Geometry
/// plays no part: vertices at the same place are different.
namespace relief::mesh {

enum class MeshProblemKind : std::uint8_t {
    MissingVertex,   ///< a face names a vertex that does not exist
    RepeatedCorner,  ///< a face names a vertex twice
    TooFewCorners,   ///< fewer than three different corners are left without repetitions
    DuplicateFace,   ///< the corners of an earlier face, in either direction
    CrowdedEdge,     ///< more than two faces
    TurnedFace,      ///< runs along an edge in the same direction as the only other face there
    SeveralFans,     ///< the faces of a vertex do not all hang together by edges at it
    UnusedVertex,    ///< no face with three different corners names it
};
inline constexpr std::size_t kMeshProblemKinds = 8;

struct MeshProblem {
    MeshProblemKind kind = MeshProblemKind::MissingVertex;
    Index element = kNone;                    ///< SeveralFans, UnusedVertex: a vertex; else a face
    std::array<Index, 2> edge{kNone, kNone};  ///< CrowdedEdge, TurnedFace: its ends, ascending
    std::string message;  ///< begins with the name that `build` gives to such an error

    friend bool operator==(const MeshProblem&, const MeshProblem&) = default;
};

struct MeshDiagnosis {
    std::vector<MeshProblem> problems;  ///< by kinds, and within each by elements
    std::array<std::uint64_t, kMeshProblemKinds> counts{};  ///< of all, listed or not

    [[nodiscard]] bool healthy() const { return counts == decltype(counts){}; }
    [[nodiscard]] std::uint64_t count(MeshProblemKind kind) const {
        return counts[static_cast<std::size_t>(kind)];
    }
};

/// All problems, of which at most `listed` of each kind are named. Edges and vertices are judged
/// without the faces that repair drops, and faces that name a vertex twice as what repair makes of
/// them. A mesh without problems and with a face is one that `build` accepts. Requires: offsets
/// ascend within the corners, fewer than 2^31 corners and vertices. Complexity: O(n log n).
[[nodiscard]] MeshDiagnosis diagnose(const FaceList& faces, Index vertex_count,
                                     std::size_t listed = 100);

struct RepairCounts {
    std::uint64_t faces_dropped = 0;  ///< MissingVertex, TooFewCorners
    std::uint64_t duplicates_dropped = 0;
    std::uint64_t corners_dropped = 0;  ///< of faces with a repeated corner that are kept
    std::uint64_t faces_added = 0;      ///< by faces that fall apart at a repeated corner
    std::uint64_t faces_turned = 0;
    std::uint64_t edges_cut = 0;         ///< of two faces that can not be oriented alike
    std::uint64_t edges_split = 0;       ///< of more than two faces
    std::uint64_t vertices_added = 0;    ///< by those that are given to several fans
    std::uint64_t vertices_dropped = 0;  ///< that no face uses

    [[nodiscard]] bool nothing() const { return *this == RepairCounts{}; }
    friend bool operator==(const RepairCounts&, const RepairCounts&) = default;
};

/// A mended mesh and where its elements come from.
struct Repaired {
    FaceList faces;
    Index vertex_count = 0;
    std::vector<Index> vertices;       ///< the old number of each vertex
    std::vector<Index> sources;        ///< the old face of each face, ascending
    std::vector<Index> corners;        ///< of each corner: its place in the old FaceList::corners
    std::vector<std::uint8_t> turned;  ///< for each face: 1 if its corners run the other way
    RepairCounts counts;
};

/// Makes faces that `build` accepts, unless none is left:
/// - A face that names a vertex twice falls apart there into loops; those of three and more corners
///   stay. So a corner that is repeated, or a spike, just goes.
/// - Faces with fewer corners or missing vertices and all but the first of equal faces are dropped.
/// - Faces that hang together by edges of two faces are oriented alike, as the majority of them is.
///   Where that is impossible (on a Moebius band) edges are cut open, those that disagreed before.
/// - Edges of more faces are split: faces that hang together elsewhere stay joined if just two of
///   them meet here, in opposite directions; all others get an edge of their own.
/// - Each fan of a vertex gets its own vertex; unused vertices are dropped.
///
/// Faces and vertices keep their order, faces their first corners; vertices that are added come
/// last. A mesh that is healthy stays as it is. Requires: as diagnose. Complexity: O(n log n).
[[nodiscard]] Repaired repair(const FaceList& faces, Index vertex_count);

struct RepairedMesh {
    PolygonMesh mesh;
    RepairCounts counts;
};

/// The same for a mesh with all that it carries: attributes, labels, creases and sharp vertices
/// follow, those of split vertices and edges to all their copies. Creases along no edge of the
/// repaired mesh are left out; normals of turned faces keep their direction. Requires: the mesh
/// passes relief::check; so does the result. Complexity: O(n log n).
[[nodiscard]] RepairedMesh repair(const PolygonMesh& mesh);

/// The polygons of a mesh. Requires: the mesh passes relief::check. Complexity: O(n).
[[nodiscard]] FaceList faces_of(const PolygonMesh& mesh);

}  // namespace relief::mesh
