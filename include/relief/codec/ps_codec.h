#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "relief/codec/raster_codec.h"
#include "relief/core/stream.h"
#include "relief/multires/ps_gradients.h"
#include "relief/multires/ps_lift.h"

/// Powell-Sabin splines of one to three components on triangulations to .relief files and back.
/// Source: powell-sabin.md sections 4, 7, 8, 12 and 13; docs/powell-sabin.md, docs/format.md
/// "Powell-Sabin splines".
namespace relief::codec {

/// The spline through values at the vertices of the base. Gradients are those of
/// multires::ps::estimate_gradients, which a decoder estimates again: one number a vertex.
struct PsValues {
    std::vector<std::vector<double>> components;  ///< [component][vertex]
    multires::ps::GradientOptions gradients = {};
};

/// Coefficients on the base refined `levels` times by multires::ps::refine with its default
/// options: heights of control triangles of the finest level.
struct PsSplines {
    int levels = 0;
    std::vector<multires::ps::Coefficients> components;  ///< [component][vertex]
};

/// Points at which errors are measured, instead of everywhere: what a spline was fitted to. Those
/// outside the domain are compared with the nearest point of its boundary.
struct PsData {
    std::vector<Vec2> points;                 ///< in the coordinates of the base's source
    std::vector<std::vector<double>> values;  ///< [component][point]
    std::vector<double> weights = {};         ///< of the root mean square; empty: all 1
};

/// What coordinates and values are: kept for those who use the surface, not looked at.
struct PsReference {
    std::string crs = {};   ///< of x and y, as GeoReference::crs
    std::string unit = {};  ///< of the values: "m", "ft"; empty: unknown

    friend bool operator==(const PsReference&, const PsReference&) = default;
};

struct PsModel {
    mesh::Triangulation base;
    std::variant<PsValues, PsSplines> surface;
    PsData data = {};
    PsReference reference = {};
};

struct PsEncodeOptions {
    Goal goal = {Goal::Kind::Lossless, 0};
    /// Vertices and triangles keep their numbers; otherwise the file is smaller if the base is not
    /// the Delaunay triangulation of its vertices, whose own order costs nothing.
    bool keep_order = true;
    Progress progress = {};
};

/// What was achieved, measured on the decoded file.
struct PsReport {
    std::int64_t vertices = 0;  ///< of the base
    std::int64_t triangles = 0;
    int levels = 0;
    bool delaunay = false;          ///< the triangles follow from the vertices
    std::int64_t samples = 0;       ///< numbers of the data, or of the representation
    std::int64_t coefficients = 0;  ///< numbers of the representation
    std::int64_t kept = 0;          ///< of them: those of the coarsest level, and all not zero
    std::uint64_t bytes = 0;
    std::uint64_t base_bytes = 0;  ///< of them: places of vertices, and triangles
    double bits_per_sample = 0;
    /// At the data; without data, of values at the vertices, or a bound of the surface anywhere.
    double max_error = 0;
    double rms_error = 0;  ///< at the data, of the values, or of the surface: sqrt(integral / area)
    /// 100 x squared error / squared (data, values or surface minus the coarsest level; if that is
    /// the only one, minus the mean).
    double energy_percent = 0;
    double bound = 0;          ///< of max_error: the goal's, or what was measured
    double surface_bound = 0;  ///< certified: of the decoded surface against the model's, anywhere
};

struct EncodedPs {
    Bytes bytes;
    PsReport report;
};

/// Goals: lossless, to the bit of every value or height; max-error, rms-error: at the data, or
/// without data of the values at the vertices, or of the surface everywhere; bytes; keep, of
/// details of coefficients, those of the largest L2 norm. The base is kept exactly. Without
/// keep_order it may be numbered anew, and coefficients are carried over by their tangent planes,
/// which costs a rounding.
/// Errors: those of mesh::build for the base, of multires::ps; `size_mismatch`, `component_count`,
/// `non_finite_data`; InvalidArgument for goals that are negative or not numbers, keep of values,
/// or an error or a size that can not be reached; Cancelled. Complexity: O(n log n) for each of up
/// to 24 trials.
[[nodiscard]] Result<EncodedPs> encode_ps(const PsModel& model, const PsEncodeOptions& options);

/// Moves the control triangle of a vertex: its tangent plane rises and tilts. Finer levels follow
/// by refinement, their details stay.
struct PsMove {
    int level = 0;             ///< 0: the finest
    std::uint64_t vertex = 0;  ///< of that level
    int component = 0;
    double rise = 0;
    Vec2 tilt;  ///< added to the gradient

    friend bool operator==(const PsMove&, const PsMove&) = default;
};

/// A level, ready for multires::ps::Surface.
struct PsSurface {
    multires::ps::Space space;
    std::vector<multires::ps::Coefficients> components;
};

struct PsCounts {
    std::uint64_t vertices = 0;
    std::uint64_t triangles = 0;

    friend bool operator==(const PsCounts&, const PsCounts&) = default;
};

/// An opened file of a Powell-Sabin spline, or a prefix of one. Several threads may read at once.
class PsFile {
  public:
    /// Sees the first `visible` bytes of the source; nothing is trusted. Errors: BadFile saying
    /// what is damaged, or that the coarsest level is not there; Unsupported.
    [[nodiscard]] static Result<PsFile> open(
        std::shared_ptr<const ByteSource> source,
        std::uint64_t visible = std::numeric_limits<std::uint64_t>::max());
    /// A whole file in memory.
    [[nodiscard]] static Result<PsFile> open(Bytes bytes);

    PsFile(PsFile&&) noexcept;
    PsFile& operator=(PsFile&&) noexcept;
    ~PsFile();

    [[nodiscard]] int levels() const;
    [[nodiscard]] int components() const;
    [[nodiscard]] Goal goal() const;
    [[nodiscard]] const PsReference& reference() const;
    /// Values at vertices, or coefficients.
    [[nodiscard]] bool holds_values() const;
    [[nodiscard]] bool lossless() const;  ///< no bit of the surface differs from the model's
    /// The triangles are those of mesh::delaunay.
    [[nodiscard]] bool delaunay() const;
    [[nodiscard]] PsCounts counts(int level) const;
    /// x least, y least, x most, y most.
    [[nodiscard]] std::array<double, 4> extent() const;
    [[nodiscard]] double max_error() const;  ///< as verified by the encoder
    [[nodiscard]] double rms_error() const;
    [[nodiscard]] int version() const;
    [[nodiscard]] std::uint64_t size() const;  ///< of the whole file, in bytes
    [[nodiscard]] bool checksums_ok() const;   ///< of all chunks; reads them all
    [[nodiscard]] const std::vector<PsMove>& moves() const;
    [[nodiscard]] bool edited() const { return !moves().empty(); }
    /// Errors: InvalidArgument for a vertex or component that does not exist, or a number that is
    /// not at most 1e150.
    [[nodiscard]] Status check(const std::vector<PsMove>& more) const;
    /// The finest level that is complete.
    [[nodiscard]] int finest_level() const;
    /// How many first bytes of the file `level` needs.
    [[nodiscard]] std::uint64_t bytes_for(int level) const;
    /// Bytes of the chunks "edits", "mesh", "level" (levels() .. 0) and "correction".
    [[nodiscard]] std::vector<ChunkSummary> chunks() const;
    /// Largest error of level 0 where errors are measured; none if edited, or for other levels.
    [[nodiscard]] std::optional<double> bound(int level) const;
    /// Certified largest difference between the surface of a level and the encoded one, of any
    /// component; none if edited.
    [[nodiscard]] std::optional<double> surface_bound(int level) const;

    /// The base, with the numbers that it was encoded with.
    [[nodiscard]] const mesh::Triangulation& base() const;
    /// The values at the vertices, without moves. Errors: InvalidArgument if there are none;
    /// BadFile.
    [[nodiscard]] Result<PsValues> values() const;
    /// Errors: InvalidArgument for a level that the file does not have; BadFile. Complexity: O(n)
    /// of the level.
    [[nodiscard]] Result<PsSurface> surface(int level) const;

  private:
    struct State;
    explicit PsFile(std::unique_ptr<State> state);
    std::unique_ptr<State> state_;
};

/// The file with more moves. Errors: those of PsFile::open and check.
[[nodiscard]] Result<Bytes> add_ps_moves(Bytes file, const std::vector<PsMove>& moves);

}  // namespace relief::codec
