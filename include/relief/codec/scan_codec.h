#pragma once

#include <cstdint>
#include <optional>

#include "relief/codec/mesh_codec.h"
#include "relief/core/polygon_mesh.h"
#include "relief/remesh/remesh.h"

/// Any triangle mesh to a .relief file: remeshed, and coded so that the errors are those from the
/// mesh itself. Source: mesh-codec-and-remesh.md sections 4 and 5; docs/remeshing.md.
namespace relief::codec {

/// How much is tried for a small file.
enum class ScanEffort : std::uint8_t {
    Once,      ///< one remesh
    Suited,    ///< a finer one if the first takes too much of an RMS goal
    Smallest,  ///< coarser and finer bases and other levels too, as long as files get smaller
};

struct ScanEncodeOptions {
    /// Any but lossless.
    Goal goal = {Goal::Kind::RmsError, 0};
    /// Faces of the base, levels: taken as they are, as far as the tolerance allows.
    std::optional<std::int64_t> base_faces = {};
    std::optional<int> levels = {};
    std::optional<double> feature_degrees = {};
    /// Of the remesh, as a fraction of the diagonal. None: 10 times an RMS goal and at least 2e-3,
    /// 0.6 times a goal for the largest error, 4e-3 for sizes; less where goals can not be reached
    /// so.
    std::optional<double> tolerance = {};
    ScanEffort effort = ScanEffort::Suited;
    multires::LiftKind lift = multires::LiftKind::Chebyshev;
    /// Of each remesh, and of each search for quantisation steps.
    Progress remeshing = {};
    Progress encoding = {};
};

struct EncodedScan {
    remesh::Remeshed remeshed;  ///< what was coded
    EncodedMesh encoded;
};

/// Errors: those of remesh::remesh and encode_mesh, after nearer remeshes were tried.
/// InvalidArgument for the goal lossless. Complexity: that of both for one remesh, at most five to
/// get near enough, some ten for the smallest file.
[[nodiscard]] Result<EncodedScan> encode_scan(const PolygonMesh& mesh,
                                              const ScanEncodeOptions& options);

}  // namespace relief::codec
