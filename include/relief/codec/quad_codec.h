#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "relief/codec/raster_codec.h"
#include "relief/core/stream.h"
#include "relief/mesh/quadrangulation.h"
#include "relief/multires/fvs_mesh.h"

/// Quad meshes with a height at every vertex, as C1 surfaces over the plane, to .relief files and
/// back. Source: fvs-hierarchical.md sections 6 and 8; docs/fvs.md, docs/format.md
/// "Quadrangulations".
///
/// The surface of a mesh is the spline fvs_mesh::interpolate_values through its vertices. A mesh
/// that is the refinement of a coarser one (mesh::refinement_of) has levels. As for rasters, level
/// 0 is the finest.
namespace relief::codec {

/// Vertices x, y, z and the corners of quads.
struct QuadMesh {
    std::vector<std::array<double, 3>> vertices;
    std::vector<std::array<mesh::Index, 4>> quads;

    friend bool operator==(const QuadMesh&, const QuadMesh&) = default;
};

struct QuadEncodeOptions {
    Goal goal = {Goal::Kind::Lossless, 0};
    int levels = -1;  ///< at most; -1: as many as the mesh has
};

/// What was achieved, measured on the decoded file.
struct QuadReport {
    int levels = 0;
    std::int64_t samples = 0;       ///< vertices
    std::int64_t coefficients = 0;  ///< numbers of the representation
    std::int64_t kept = 0;          ///< of them: all values, or the coefficients that are not zero
    std::uint64_t bytes = 0;
    double bits_per_sample = 0;
    double max_error = 0;       ///< of z at the vertices
    double rms_error = 0;       ///< of the same
    double energy_percent = 0;  ///< 100 x squared error / squared (z minus the coarsest surface)
    double bound = 0;           ///< of z at the vertices: the goal's, or max_error
    double surface_bound = 0;   ///< certified: of the decoded surface against the mesh's, anywhere
};

struct EncodedQuads {
    Bytes bytes;
    QuadReport report;
};

/// Goals: lossless; max-error, of every vertex; rms-error, of the vertices; bytes; keep: only
/// coefficients of the hierarchical basis that are large stay, of which the file then consists
/// (section 6, W = 1 / h). Other files hold values: their decoder estimates derivatives as the
/// encoder does. x, y and the numbering are kept exactly.
/// Errors: those of mesh::build with overlaps refused, naming the element; `non_finite_data`;
/// InvalidArgument for goals that are negative or not numbers, more levels than the mesh has, keep
/// without levels, or a size that can not be reached. Complexity: O(n log n), byte goals about 30
/// times that.
[[nodiscard]] Result<EncodedQuads> encode_quads(const QuadMesh& mesh,
                                                const QuadEncodeOptions& options);

/// Moves a vertex of a level up; finer levels follow by the spline through the moves, their details
/// stay.
struct QuadMove {
    int level = 0;
    std::uint64_t vertex = 0;  ///< in the numbering of QuadFile::decode(level)
    double rise = 0;

    friend bool operator==(const QuadMove&, const QuadMove&) = default;
};

/// A surface: `data` are those of the finest level of `hierarchy`.
struct QuadSurface {
    multires::fvs_mesh::Hierarchy hierarchy;
    multires::fvs_mesh::NodalData data;

    [[nodiscard]] int level() const { return hierarchy.levels(); }
};

/// An opened file of a quadrangulation, or a prefix of one. Several threads may read at once.
class QuadFile {
  public:
    /// Sees the first `visible` bytes of the source; nothing is trusted. Errors: BadFile saying
    /// what is damaged, or that the coarsest level is not there; Unsupported.
    [[nodiscard]] static Result<QuadFile> open(
        std::shared_ptr<const ByteSource> source,
        std::uint64_t visible = std::numeric_limits<std::uint64_t>::max());
    /// A whole file in memory.
    [[nodiscard]] static Result<QuadFile> open(Bytes bytes);

    QuadFile(QuadFile&&) noexcept;
    QuadFile& operator=(QuadFile&&) noexcept;
    ~QuadFile();

    [[nodiscard]] int levels() const;
    [[nodiscard]] Goal goal() const;
    /// Values of vertices, or coefficients of the hierarchical basis.
    [[nodiscard]] bool holds_values() const;
    /// "decimal", "step", "float32", "float64" for values; else empty.
    [[nodiscard]] std::string lattice() const;
    /// Distance of neighbouring values; 0 if it varies.
    [[nodiscard]] double step() const;
    [[nodiscard]] mesh::LevelCounts counts(int level) const;
    /// x least, y least, x most, y most of the coarsest mesh, which is all of the domain.
    [[nodiscard]] std::array<double, 4> extent() const;
    [[nodiscard]] double max_error() const;  ///< of the vertices, as verified by the encoder
    [[nodiscard]] double rms_error() const;
    [[nodiscard]] int version() const;
    [[nodiscard]] std::uint64_t size() const;  ///< of the whole file, in bytes
    [[nodiscard]] bool checksums_ok() const;   ///< of all chunks; reads them all
    [[nodiscard]] const std::vector<QuadMove>& moves() const;
    [[nodiscard]] bool edited() const { return !moves().empty(); }
    /// Errors: InvalidArgument for a vertex that does not exist or a rise that is not a number of
    /// at most 1e150.
    [[nodiscard]] Status check(const std::vector<QuadMove>& more) const;
    /// The finest level that is complete.
    [[nodiscard]] int finest_level() const;
    /// How many first bytes of the file `level` needs.
    [[nodiscard]] std::uint64_t bytes_for(int level) const;
    /// Bytes of the chunks "edits", "mesh", "level" (levels() .. 0) and "numbering", as `info`
    /// shows them.
    [[nodiscard]] std::vector<ChunkSummary> chunks() const;
    /// Largest error of z at the vertices of a level; none if edited, or for coarser levels of
    /// coefficients.
    [[nodiscard]] std::optional<double> bound(int level) const;
    /// Certified largest distance, along z, between the surface of a level and that of the encoded
    /// mesh; none if edited.
    [[nodiscard]] std::optional<double> surface_bound(int level) const;

    /// Errors: InvalidArgument for a level that the file does not have; BadFile.
    [[nodiscard]] Result<QuadSurface> surface(int level) const;
    /// What decode(level) calls the vertices of surface(level). Errors: as surface.
    [[nodiscard]] Result<std::vector<mesh::Index>> vertex_numbers(int level) const;
    /// Its vertices and quads; level 0 is numbered as what was encoded, others as mesh::refine
    /// does. Errors: as surface.
    [[nodiscard]] Result<QuadMesh> decode(int level) const;

  private:
    struct State;
    explicit QuadFile(std::unique_ptr<State> state);
    std::unique_ptr<State> state_;
};

/// The same file with `moves` added to those it has. Errors: those of QuadFile::check; BadFile.
[[nodiscard]] Result<Bytes> add_quad_moves(Bytes file, const std::vector<QuadMove>& moves);

}  // namespace relief::codec
