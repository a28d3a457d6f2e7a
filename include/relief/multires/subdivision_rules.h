#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "relief/core/result.h"
#include "relief/mesh/split.h"

/// The rules of sqrt(3), Loop and Catmull-Clark subdivision. Source: reverse-subdivision.md
/// sections 3 to 5.
///
/// A step maps coarse vertices c to fine ones g, which are the old vertices and new ones on edges
/// and faces. New vertices are weighted means of coarse ones; old vertices follow from them:
///     g_old = D c + K g_new                                                    (identity 1)
/// with D diagonal and K reaching only the new vertices of the faces and edges at the old vertex.
/// Forward subdivision, its reversal, lifting and the norms of details all use these two halves.
namespace relief::multires {

enum class MeshScheme : std::uint8_t { Sqrt3, Loop, CatmullClark };

/// "sqrt3", "loop", "catmull-clark".
[[nodiscard]] const char* mesh_scheme_name(MeshScheme scheme);
/// Errors: InvalidArgument listing the names.
[[nodiscard]] Result<MeshScheme> mesh_scheme_from_name(std::string_view name);

/// How step 0, 1, .. from the base is split: sqrt(3) begins with an odd one.
[[nodiscard]] mesh::Split split_of(MeshScheme scheme, int step);

/// Which rule an old vertex has: by its number of sharp edges, 0, 1, 2 or more.
enum class VertexKind : std::uint8_t { Smooth, Dart, Crease, Corner };

namespace rules {

/// New vertices: weights.
inline constexpr double kLoopEdgeEnd = 3.0 / 8;
inline constexpr double kLoopEdgeWing = 1.0 / 8;
inline constexpr double kSharpEdgeEnd = 1.0 / 2;
inline constexpr double kQuadEdgeEnd = 1.0 / 4;   ///< Catmull-Clark: ends
inline constexpr double kQuadEdgeFace = 1.0 / 4;  ///< and points of both faces
inline constexpr double kFacePoint3 = 1.0 / 3;    ///< sqrt(3): corners
/// sqrt(3), trisected boundary edge from a to b, the point next to a: a, b, and the vertex before
/// a.
inline constexpr double kThirdNear = 16.0 / 27;
inline constexpr double kThirdFar = 10.0 / 27;
inline constexpr double kThirdBeyond = 1.0 / 27;
/// The same where a is a corner.
inline constexpr double kThirdOfCorner = 2.0 / 3;
inline constexpr double kThirdOfCornerFar = 1.0 / 3;

/// Old vertices on creases and boundaries: D, and K for each of the two new vertices beside it on
/// the curve.
struct CurveRule {
    double self = 1;
    double point = 0;
};
inline constexpr CurveRule kDyadicCurve{1.0 / 2, 1.0 / 4};
inline constexpr CurveRule kTernaryCurve{3.0 / 11, 4.0 / 11};

/// The same rules in their classical form: the vertex itself, and each of the two beside it.
inline constexpr CurveRule kDyadicMask{3.0 / 4, 1.0 / 8};
inline constexpr CurveRule kTernaryMask{19.0 / 27, 4.0 / 27};

/// Old vertices that are smooth: D, and K for each new vertex on an edge and on a face at it.
struct SmoothRule {
    double self = 1;
    double edge = 0;
    double face = 0;
};
/// The weight of the neighbours together (sqrt(3)), or of each (Loop), in the classical form of the
/// rule. Requires: n >= 2 (sqrt(3), Loop).
[[nodiscard]] double sqrt3_alpha(mesh::Index n);
[[nodiscard]] double loop_alpha(mesh::Index n);
/// Requires: n >= 3, or 2 for Loop and Catmull-Clark; alpha in [0, 2/3).
[[nodiscard]] SmoothRule sqrt3_smooth(mesh::Index n, double alpha);
[[nodiscard]] SmoothRule loop_smooth(mesh::Index n);
[[nodiscard]] SmoothRule catmull_clark_smooth(mesh::Index n);

/// Smooth vertices in the classical form of their rule, which holds for darts too: the weights of
/// the vertex itself and of each vertex of its ring; for Catmull-Clark the ring are the other ends
/// of its edges and the points of its faces.
struct RingRule {
    double self = 1;
    double ring = 0;
};
/// Requires: n >= 2.
[[nodiscard]] RingRule sqrt3_ring(mesh::Index n, double alpha);
[[nodiscard]] RingRule loop_ring(mesh::Index n);
[[nodiscard]] RingRule catmull_clark_ring(mesh::Index n);

/// A vertex with one sharp edge, Loop: K of the new vertices of its edges, the sharp one first,
/// counter-clockwise. Requires: n >= 2. Complexity: O(n).
struct DartRule {
    double self = 1;
    std::vector<double> edges;
};
[[nodiscard]] DartRule loop_dart(mesh::Index n);

}  // namespace rules

}  // namespace relief::multires
