#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <variant>

#include "relief/codec/ps_codec.h"
#include "relief/multires/ps_adaptive.h"

/// Surfaces through and near scattered points, as .relief files: functions over the plane, or
/// surfaces in space over a plane of parameters. Source: powell-sabin.md section
/// 12; docs/scattered.md.
namespace relief::codec {

/// The spline through all points, on their Delaunay triangulation. Points at one place count as
/// one, with the weighted means of their values.
struct Interpolation {
    multires::ps::GradientOptions gradients = {};
};

/// The spline nearest to the points by smoothed least squares.
struct Approximation {
    /// About how many vertices, which are points all over the domain; or the triangles.
    std::variant<std::size_t, mesh::Triangulation> base;
    int levels = 0;  ///< refinements of the base, each into nine times as many triangles
    std::optional<double> smoothing = {};  ///< none: by cross validation (multires/ps_fit.h)
    multires::ps::Energy energy = multires::ps::Energy::ThinPlate;
};

/// A spline of one component on some of the points, with more vertices where points are farther off
/// than the goal, which is a largest error.
struct Insertion {
    std::size_t most_vertices = static_cast<std::size_t>(-1);
    std::optional<double> smoothing = {};  ///< above 0; none: 1e-10, or interpolation if smaller
    multires::ps::Energy energy = multires::ps::Energy::ThinPlate;
};

using PointMethod = std::variant<Interpolation, Approximation, Insertion>;

/// What is wanted of the surface of points, for those who leave the method open.
struct FitWishes {
    std::optional<std::size_t> vertices = {};  ///< least squares on about so many points,
    std::optional<mesh::Triangulation> triangles =
        {};          ///< or on these; or with a bound at most so many
    int levels = 0;  ///< of least squares
    std::optional<multires::ps::GradientRule> gradients = {};  ///< interpolation with this rule
    std::optional<double> smoothing = {};
    std::optional<multires::ps::Energy> energy = {};
};

/// Least squares where vertices or triangles are given, insertion for a largest error, else
/// interpolation. Errors: InvalidArgument for wishes that do not go together, fewer than three
/// vertices, and smoothing that is negative or not a number.
[[nodiscard]] Result<PointMethod> point_method(FitWishes wishes, const std::optional<Goal>& goal);

struct EncodedPoints {
    Bytes bytes;
    PsReport report;
    std::optional<double> smoothing;  ///< of the least squares
    std::size_t merged = 0;           ///< Interpolation: points that share the vertex of another
    std::size_t outside = 0;  ///< Approximation: points outside the base, which are left out
    std::size_t beyond = 0;   ///< Insertion: points that are not within the goal
    std::string reason;       ///< why they are not; empty if there are none
};

/// A spline of the components of the points' values, one to three. Goals as encode_ps, measured at
/// the points. None: for least squares the error of the spline may
/// grow by a thousandth, otherwise lossless. Insertion divides a largest error between spline
/// and code as makes the smallest file of up to three; if the spline needs more than most_vertices,
/// `beyond` says how many points are off, and the code adds a quarter of the bound at most.
/// Errors: those of mesh::delaunay, multires::ps and encode_ps; BadInput `bound_not_reached` if a
/// goal is out of reach, with the reason, `no_data` if no point lies on the base; InvalidArgument
/// for an Insertion with another goal, and for a finest level of more than
/// 2^23 vertices; Cancelled.
[[nodiscard]] Result<EncodedPoints> encode_points(const PsData& data, const PointMethod& method,
                                                  std::optional<Goal> goal = {},
                                                  const Progress& progress = {},
                                                  const PsReference& reference = {});

}  // namespace relief::codec
