#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <vector>

#include "relief/core/polygon_mesh.h"
#include "relief/core/result.h"
#include "relief/core/vec3.h"
#include "relief/mesh/index.h"

/// Closest points on surfaces, and how far surfaces are from each other. Polygons are the fans of
/// triangles around their first corners. Coordinates may be as large as 1e75, which no square of an
/// area overflows, and the results are the same for any number of threads.
namespace relief::mesh {

/// A triangle of a polygon.
struct FanTriangle {
    std::array<Vec3<double>, 3> corners;
    Index face = 0;
};
/// In the order of the polygons. Requires: the mesh passes relief::check. Complexity: O(n).
[[nodiscard]] std::vector<FanTriangle> fan_triangles(const PolygonMesh& mesh);

/// The point of a triangle that is closest to p. Right for triangles of any shape, also those that
/// are a line or a point: off by roundings of the coordinates' differences.
[[nodiscard]] Vec3<double> closest_point(const std::array<Vec3<double>, 3>& triangle,
                                         const Vec3<double>& p);

/// A point of a surface.
struct SurfacePoint {
    Vec3<double> point;
    double distance = 0;  ///< from where it was asked for
    Index face = 0;
    Index triangle = 0;  ///< in the tree's own order: where to begin with a point nearby
};

/// Finds closest points by a tree of boxes. Immutable; several threads may ask.
class TriangleTree {
  public:
    /// Complexity: O(n log n).
    explicit TriangleTree(const std::vector<FanTriangle>& triangles);

    [[nodiscard]] bool empty() const { return triangles_.empty(); }
    /// The closest point of the surface, or any that is not farther than `enough`. Of several that
    /// are equally close it is always the same. Requires: not empty, p finite. Complexity: O(log n)
    /// for points near the surface, O(n) for the centre of a sphere.
    [[nodiscard]] SurfacePoint closest(const Vec3<double>& p, double enough = 0) const;
    /// The same, faster where the triangle `first` of the tree is near p. Of several that are
    /// equally close it may be another one.
    [[nodiscard]] SurfacePoint closest_from(Index first, const Vec3<double>& p,
                                            double enough = 0) const;

  private:
    static constexpr double kMost = std::numeric_limits<double>::infinity();

    /// Empty until it includes something.
    struct Box {
        std::array<double, 3> low{kMost, kMost, kMost};
        std::array<double, 3> high{-kMost, -kMost, -kMost};

        void include(const std::array<double, 3>& p);
        void include(const Box& box);
        [[nodiscard]] double squared_distance(const Vec3<double>& p) const;
    };
    /// The first child follows its parent; `second` is 0 in a leaf.
    struct Node {
        Box box;
        Index begin = 0;
        Index end = 0;
        Index second = 0;
    };
    struct Item;

    void build(const std::vector<FanTriangle>& triangles, std::vector<Item>& items, Index begin,
               Index end);
    [[nodiscard]] SurfacePoint search(SurfacePoint best, double least, const Vec3<double>& p,
                                      double enough) const;

    std::vector<FanTriangle> triangles_;  ///< in the order of leaves, the longest side first
    std::vector<Node> nodes_;
};

/// How far the points of one surface are from another.
struct DirectedDistance {
    double largest = 0;
    double rms = 0;         ///< root mean square over its area
    Vec3<double> farthest;  ///< the point that is farthest
};

struct SurfaceDistance {
    DirectedDistance a_to_b;
    DirectedDistance b_to_a;

    [[nodiscard]] double largest() const;  ///< of both
    [[nodiscard]] double rms() const;      ///< the larger of both
};

/// Measures from a to b and back at `samples` points each way, which are spread evenly over the
/// area and always the same; for the largest distances at the vertices of faces too. Surfaces
/// without area have samples on each triangle. Requires: both meshes pass relief::check, samples >=
/// 1. Errors: BadInput `empty_mesh`. Complexity: O((n + samples) log n) for surfaces that are near
/// each other. Source: mesh-codec-and-remesh.md, the head.
[[nodiscard]] Result<SurfaceDistance> surface_distance(const PolygonMesh& a, const PolygonMesh& b,
                                                       std::int64_t samples = 60000);
/// The same, with the tree of a's fan_triangles.
[[nodiscard]] Result<SurfaceDistance> surface_distance(const PolygonMesh& a,
                                                       const TriangleTree& tree_of_a,
                                                       const PolygonMesh& b,
                                                       std::int64_t samples = 60000);

/// The distance of each vertex of a mesh from a surface. Requires: the mesh passes relief::check,
/// the surface is not empty.
[[nodiscard]] std::vector<double> vertex_distances(const PolygonMesh& mesh,
                                                   const TriangleTree& surface);

}  // namespace relief::mesh
