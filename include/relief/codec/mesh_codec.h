#pragma once

#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "relief/codec/raster_codec.h"
#include "relief/core/polygon_mesh.h"
#include "relief/core/stream.h"
#include "relief/multires/mesh_moves.h"

/// Meshes with subdivision connectivity to .relief files and back. Source:
/// mesh-codec-and-remesh.md section 2; docs/reverse-subdivision.md, docs/format.md "Meshes".
///
/// The mesh is analysed by reverse subdivision, details are quantised in frames along the surface,
/// and what the file decodes to is measured vertex by vertex. Level 0 is the mesh; each level above
/// is a coarser one.
namespace relief::codec {

/// Between which points of two meshes errors are measured.
enum class MeshDistance : std::uint8_t {
    Vertices,  ///< from each vertex to where it was
    Surface,   ///< from the points of either surface to the other: mesh::surface_distance
};
/// "vertices", "surface".
[[nodiscard]] const char* mesh_distance_name(MeshDistance distance);

struct MeshEncodeOptions {
    Goal goal = {Goal::Kind::Lossless, 0};
    /// What max-error and rms-error mean, and what is reported. By surface, files are smaller:
    /// places of vertices along it count for little.
    MeshDistance distance = MeshDistance::Vertices;
    /// By surface: what distances are measured from in place of the mesh itself, which is another
    /// mesh of the same surface. It must outlive the call.
    const PolygonMesh* original = nullptr;
    /// None: what makes the smallest file, or the smallest error.
    std::optional<multires::MeshScheme> scheme = {};
    int levels = -1;                   ///< at most; -1: as many as the mesh has
    std::optional<double> alpha = {};  ///< sqrt(3): StepOptions
    multires::LiftKind lift = multires::LiftKind::Chebyshev;
    /// Vertices and faces keep their numbers; otherwise the file is smaller where these are not
    /// those of subdivision.
    bool keep_order = true;
    Progress progress = {};
};

/// What was achieved, measured on the decoded file. Lengths are in the units of the mesh.
struct MeshReport {
    multires::MeshScheme scheme = multires::MeshScheme::Loop;
    int levels = 0;
    std::int64_t samples = 0;       ///< vertices
    std::int64_t coefficients = 0;  ///< vectors of the representation
    std::int64_t kept = 0;          ///< of them: those of the base, and details that are not zero
    std::uint64_t bytes = 0;
    double bits_per_sample = 0;
    double max_error = 0;       ///< the largest distance
    double rms_error = 0;       ///< root mean square: of the vertices', or over the area
    double energy_percent = 0;  ///< 100 x squared error / squared (mesh minus its coarsest surface)
    double bound = 0;           ///< of max_error: the goal's, or what was measured
    std::int64_t base_vertices = 0;
    std::int64_t base_faces = 0;
    std::int64_t faces = 0;
    std::int64_t lost_creases = 0;  ///< sharp edges that no edge of the base is the origin of: they
                                    ///< are kept as tags of the finest level
};

struct EncodedMesh {
    Bytes bytes;
    MeshReport report;
};

/// Goals: lossless, to the bit of every coordinate; max-error and rms-error, by `distance`; bytes;
/// keep, of the details, the largest for their level. A max-error by surface holds for all vertices
/// of both meshes and 60000 points spread evenly over each of them; an rms-error is that of these
/// points, the larger one of both ways. Attributes, labels and creases are kept exactly. Creases
/// and corners that are sharp for ever take part in the transform.
/// Errors: those of relief::check and mesh::build, naming the element; BadInput
/// no_subdivision_connectivity, naming the component; InvalidArgument for goals that are negative
/// or not numbers, a size that can not be reached, or distances by surface of coordinates above
/// 1e75; BadInput `goal_out_of_reach` if the mesh itself is farther from an original; Cancelled.
/// Complexity: O(n) for each of some 15 trials, O(n log n) by surface.
[[nodiscard]] Result<EncodedMesh> encode_mesh(const PolygonMesh& mesh,
                                              const MeshEncodeOptions& options);

/// Moves a control vertex; finer levels follow by subdivision, their details turn and grow with the
/// surface.
struct MeshMove {
    int level = 0;
    std::uint64_t vertex = 0;       ///< in the numbering of MeshFile::decode(level)
    std::array<double, 3> delta{};  ///< of at most kLargest

    static constexpr double kLargest = 1e150;
    friend bool operator==(const MeshMove&, const MeshMove&) = default;
};

/// What the levels of a file are made of, its moves left out. Depth 0 is the base; vertices have
/// the numbers of the hierarchy.
struct MeshParts {
    std::unique_ptr<multires::MeshHierarchy> hierarchy;
    multires::MeshTransform transform;              ///< with the lifts of all steps
    std::vector<std::vector<Vec3<double>>> points;  ///< [depth]: what each level decodes to
    std::vector<multires::LocalDetails> details;    ///< [step]
    std::vector<mesh::Index> numbers;               ///< [vertex of the finest depth]: in decode(0)
    std::vector<MeshAttribute> attributes;          ///< those of decode(0)
};

/// An opened file of a mesh, or a prefix of one. Several threads may read at once.
class MeshFile {
  public:
    /// Sees the first `visible` bytes of the source; nothing is trusted. Errors: BadFile saying
    /// what is damaged, or that the base is not there; Unsupported.
    [[nodiscard]] static Result<MeshFile> open(
        std::shared_ptr<const ByteSource> source,
        std::uint64_t visible = std::numeric_limits<std::uint64_t>::max());
    /// A whole file in memory.
    [[nodiscard]] static Result<MeshFile> open(Bytes bytes);

    MeshFile(MeshFile&&) noexcept;
    MeshFile& operator=(MeshFile&&) noexcept;
    ~MeshFile();

    [[nodiscard]] const multires::MeshSpec& spec() const;
    [[nodiscard]] int levels() const;
    [[nodiscard]] Goal goal() const;
    [[nodiscard]] bool lossless() const;
    [[nodiscard]] double step() const;  ///< of the finest details along the normal
    [[nodiscard]] mesh::MeshCounts counts(int level) const;
    [[nodiscard]] MeshDistance distance() const;  ///< what errors are
    [[nodiscard]] double max_error() const;       ///< as verified by the encoder
    [[nodiscard]] double rms_error() const;
    [[nodiscard]] int version() const;
    [[nodiscard]] std::uint64_t size() const;  ///< of the whole file, in bytes
    [[nodiscard]] bool checksums_ok() const;   ///< of all chunks; reads them all
    [[nodiscard]] const std::vector<MeshMove>& moves() const;
    [[nodiscard]] bool edited() const { return !moves().empty(); }
    /// Errors: InvalidArgument for a vertex that does not exist or a move that is not a number of
    /// at most 1e150.
    [[nodiscard]] Status check(const std::vector<MeshMove>& more) const;
    /// The finest level that is complete.
    [[nodiscard]] int finest_level() const;
    /// How many first bytes of the file `level` needs.
    [[nodiscard]] std::uint64_t bytes_for(int level) const;
    /// Bytes of the chunks, as `info` shows them.
    [[nodiscard]] std::vector<ChunkSummary> chunks() const;
    /// Largest error; none if edited, or for other levels than 0.
    [[nodiscard]] std::optional<double> bound(int level) const;

    /// The mesh of a level, with its attributes, labels and creases; level 0 is numbered as what
    /// was encoded, others as mesh::refine does. At coarser levels vertices have the attributes of
    /// the vertices that they became; Loop and Catmull-Clark corners those of the finest corners
    /// there, faces the labels of the finest faces at their first corners; and of a prefix that
    /// ends before the attributes there are none. Errors: InvalidArgument for a level that the file
    /// does not have; BadFile. Complexity: O(n) of the finest level that is decoded; of all with
    /// attributes.
    [[nodiscard]] Result<PolygonMesh> decode(int level) const;
    /// Errors: BadFile, also for a prefix. Complexity: O(n).
    [[nodiscard]] Result<MeshParts> parts() const;

  private:
    struct State;
    explicit MeshFile(std::unique_ptr<State> state);
    std::unique_ptr<State> state_;
};

/// The file with more moves. Errors: those of MeshFile::open and check.
[[nodiscard]] Result<Bytes> add_mesh_moves(Bytes file, const std::vector<MeshMove>& moves);

}  // namespace relief::codec
