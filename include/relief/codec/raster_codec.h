#pragma once

#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "relief/codec/oracle.h"
#include "relief/core/raster.h"
#include "relief/core/sampling.h"
#include "relief/core/stream.h"
#include "relief/multires/edit.h"
#include "relief/multires/scheme.h"

/// Rasters to .relief files and back: analysis, choice of coefficients for a goal, coding,
/// verification. See docs/format.md.
namespace relief::codec {

struct Goal {
    enum class Kind : std::uint8_t {
        Keep,      ///< value: per cent of the number of samples that are kept as coefficients; only
                   ///< thresholds
        RmsError,  ///< value: largest root mean square error, in data units
        MaxError,  ///< value: largest error of any sample, in data units; verified
        Bytes,     ///< value: largest file
        Lossless,
    };
    Kind kind = Kind::RmsError;
    double value = 0;
};

/// How hard the closed loop works: docs/codec.md.
enum class Profile : std::uint8_t {
    Fast,   ///< fixed predictors, static tables: several times as fast
    Dense,  ///< predictors and probabilities that learn: about 8 % smaller
};

struct EncodeOptions {
    std::optional<multires::SchemeSpec> spec = {};  ///< none: the best for the goal
    Goal goal = {};
    Effort effort = Effort::Refit;
    Profile profile = Profile::Dense;
    Progress progress = {};
};

/// What was achieved, measured on the decoded file in the raster's sample type.
struct EncodeReport {
    multires::SchemeSpec spec;
    bool closed_loop = false;          ///< quantised inside the prediction: docs/codec.md
    Profile profile = Profile::Dense;  ///< of the closed loop
    double lattice = 0;                ///< unit of which samples are multiples; 0: none was found
    std::int64_t samples = 0;          ///< rows x cols
    std::int64_t coefficients = 0;     ///< of the whole pyramid
    std::int64_t kept = 0;             ///< coefficients that are not zero, scaling band included
    std::int64_t corrected = 0;        ///< samples with a correction (max-error and lossless goals)
    std::uint64_t bytes = 0;
    double bits_per_sample = 0;
    double max_error = 0;
    double rms_error = 0;
    double energy_percent =
        0;  ///< 100 x squared error / squared (surface minus its coarsest reconstruction)
    double bound = 0;  ///< verified: the goal's for a max-error file, else max_error
};

struct EncodedRaster {
    Bytes bytes;
    EncodeReport report;
};

/// Errors: InvalidArgument (goal negative or not a number, percentage or size impossible, scheme
/// parameters); BadInput (no valid sample, empty); Cancelled. Complexity: O(samples) analysis; rate
/// control repeats quantisation and synthesis about 20 times, a byte goal coding too.
[[nodiscard]] Result<EncodedRaster> encode_raster(const Raster& raster,
                                                  const EncodeOptions& options);

/// The same from a source that is read in windows to a sink, tile by tile where the scheme can
/// (bounds by the closed loop; goals rms-error and bytes by scheme `cubic`): memory then grows with
/// the width of the raster and a 64th of its samples only. `spool` holds coded tiles until their
/// place in the file is known.
[[nodiscard]] Result<EncodeReport> encode_raster(const RasterSource& source,
                                                 const EncodeOptions& options, ByteSink& sink,
                                                 Spool& spool);

/// Rows and columns, 0 or 1 each, of a file's finest lattice in front of the raster's first sample.
/// They are there in closed-loop files of rasters that were interpolated from coarser grids, if
/// that makes the coarser grid the samples of level 1.
struct LatticeMargin {
    std::int64_t rows = 0;
    std::int64_t cols = 0;

    friend bool operator==(const LatticeMargin&, const LatticeMargin&) = default;
};

/// A band as `info` shows it.
struct BandInfo {
    multires::BandLayout layout;
    double step = 0;  ///< quantiser step; 0 when the band is not in the prefix
};

/// A chunk as `info` shows it.
struct ChunkSummary {
    std::string kind;  ///< "scaling", "details", "lattice", "mask", "correction", "edits"
    int level = 0;
    std::int64_t count = 1;  ///< chunks of this kind and level: one a tile
    std::uint64_t bytes = 0;
    double max_error = 0;  ///< of the surface decoded up to these chunks; infinite: not known
};

/// A part of a raster, decoded.
struct DecodedRaster {
    Raster raster;
    /// Verified largest error of its samples; none when the file is edited or it is not known.
    std::optional<double> bound = {};
    /// Parts of the raster, in its finest samples, that are coarser than they should be because
    /// chunks are damaged.
    std::vector<LatticeBox> damaged = {};
};

/// Errors: BadFile naming the damaged part, if there is one.
[[nodiscard]] Status check_damage(const std::vector<LatticeBox>& damaged);

/// Control coefficients of a part of a level.
struct ControlPart {
    multires::LevelCoefficients<double> net;
    /// Of closed-loop files, whose coefficients are samples: 0 in holes, where the net is an
    /// interpolation; empty: no holes.
    Grid<std::uint8_t> mask = {};
    std::vector<LatticeBox> damaged = {};  ///< of closed-loop files, as of DecodedRaster
};

/// An opened .relief raster, or a prefix of one. What a prefix lacks is filled in from what it has:
/// every level can be decoded, and its bound says how far it is off. Several threads may read at
/// once.
class RasterFile {
  public:
    /// Sees the first `visible` bytes of the source; nothing is trusted. Errors: BadFile saying
    /// what is damaged, or that not even the coarsest level is there; Unsupported.
    [[nodiscard]] static Result<RasterFile> open(
        std::shared_ptr<const ByteSource> source,
        std::uint64_t visible = std::numeric_limits<std::uint64_t>::max());
    /// A whole file in memory.
    [[nodiscard]] static Result<RasterFile> open(Bytes bytes);

    RasterFile(RasterFile&&) noexcept;
    RasterFile& operator=(RasterFile&&) noexcept;
    ~RasterFile();

    /// Type, georeference, NODATA, unit, names: a raster without planes and mask, of the finest
    /// level's size.
    [[nodiscard]] const Raster& description() const;
    /// The scheme that the file was made with.
    [[nodiscard]] const multires::SchemeSpec& spec() const;
    /// The bands of the control coefficients of all levels. Files of the closed loop have those of
    /// scheme `cubic`: their control coefficients are samples. Rows and columns are those of the
    /// finest lattice, the raster's and the margin's.
    [[nodiscard]] const multires::PyramidLayout& layout() const;
    [[nodiscard]] LatticeMargin margin() const;
    /// Smallest and largest sample of the original, as the closed loop noted them to its unit.
    /// Where they were too far apart for it, up to a hundredth of the samples lies outside. None:
    /// not known, or edited.
    [[nodiscard]] std::optional<std::pair<double, double>> original_range(int component) const;
    /// Some samples are not valid.
    [[nodiscard]] bool has_holes() const;
    /// Made by the closed loop, in tiles that are decoded on demand.
    [[nodiscard]] bool closed_loop() const;
    /// Of a closed-loop file: "fast" or "dense"; else empty.
    [[nodiscard]] std::string profile() const;
    [[nodiscard]] std::vector<BandInfo> bands() const;
    [[nodiscard]] std::vector<ChunkSummary> chunks() const;
    [[nodiscard]] const std::vector<multires::Move>& moves() const;
    [[nodiscard]] Goal goal() const;
    [[nodiscard]] double max_error() const;  ///< of the whole file, as verified by its encoder
    [[nodiscard]] double rms_error() const;
    [[nodiscard]] int version() const;         ///< of the container
    [[nodiscard]] std::uint64_t size() const;  ///< of the whole file, in bytes
    /// All bytes of the file are there.
    [[nodiscard]] bool complete() const;
    [[nodiscard]] bool checksums_ok() const;  ///< of all chunks; reads them all
    [[nodiscard]] bool edited() const { return !moves().empty(); }
    /// The finest level that is complete: 0 when all of them are.
    [[nodiscard]] int finest_level() const;
    /// Verified error of the raster of `level`, at the samples that it has; none if edited or
    /// unknown.
    [[nodiscard]] std::optional<double> bound(int level) const;
    /// Verified error, at all samples of the original raster, of the surface that the file gives
    /// when nothing finer than `level` is read; none if edited or unknown.
    [[nodiscard]] std::optional<double> surface_bound(int level) const;
    /// Bytes of the file that were read so far. Coarse tiles are kept, others read again.
    [[nodiscard]] std::uint64_t bytes_read() const;
    /// How many first bytes of the file decoding `level` needs.
    [[nodiscard]] std::uint64_t bytes_for(int level) const;

    /// Control coefficients of `level`, moves included; corrections are not part of them.
    [[nodiscard]] Result<multires::LevelCoefficients<double>> coefficients(int level) const;

    /// Control coefficients of `level` that lie in `part`, and perhaps others. Complexity: as
    /// decode_window.
    [[nodiscard]] Result<multires::LevelCoefficients<double>> coefficients(
        int level, const LatticeBox& part) const;
    /// The same, with what is known of them.
    [[nodiscard]] Result<ControlPart> control_part(int level, const LatticeBox& part) const;

    /// Control coefficients (relief/multires/surface.h) of a surface that passes through decode(0)
    /// before its rounding to the sample type (for the quasi-interpolating and coefficient data
    /// maps: the surface that the file describes).
    [[nodiscard]] Result<multires::Planes<double>> control_net() const;

    /// Errors: InvalidArgument for a level that the file does not have or a window that is not
    /// inside its raster.
    [[nodiscard]] Status check_window(int level, const LatticeBox& window) const;

    /// A window of the raster of `level`: size, transform, mask, and values in the sample type.
    /// Damage is filled in from coarser levels, and named. Errors: as check_window; BadFile when
    /// nothing can be decoded.
    /// Complexity: O(window and the tiles that it meets) if decodes_parts(), else O(raster).
    [[nodiscard]] Result<DecodedRaster> decode_window(int level, const LatticeBox& window) const;

    /// The whole raster of `level`. Errors: as decode_window, and BadFile for any damage.
    [[nodiscard]] Result<Raster> decode(int level) const;

    /// The schemes `fvs` and `cubic` decode windows without the rest, unless the file is edited.
    [[nodiscard]] bool decodes_parts() const;

    /// Where the samples of a window of the raster of `level` lie in the finest one.
    [[nodiscard]] Sampling samples_of_level(int level, const LatticeBox& window) const;

    /// Rows and columns of the raster of `level`. Sample (r, c) of a level above 0 lies at
    /// (r 2^level - margin().rows, c 2^level - margin().cols) of the raster.
    [[nodiscard]] LatticeBox box(int level) const;

  private:
    struct State;
    explicit RasterFile(std::unique_ptr<State> state);
    std::unique_ptr<State> state_;
};

/// Adds to the metadata of a raster that was decoded from `file`, within `bound` of the original
/// where that is known, what its reader may want to know: RELIEF_SCHEME, RELIEF_LEVELS,
/// RELIEF_MAX_ERROR. What an earlier encoding said goes.
void note_origin(const RasterFile& file, std::optional<double> bound, Raster& raster);

/// The same file with `moves` added to those it has. The data of all levels is untouched: moves are
/// a layer of their own. They stand before the levels, so that every prefix has them. Errors:
/// InvalidArgument for a coefficient that does not exist or a displacement that is not a number of
/// at most 1e300; BadFile; those of the sink.
Status add_moves(const std::shared_ptr<const ByteSource>& source,
                 const std::vector<multires::Move>& moves, ByteSink& sink);

/// The same in memory.
[[nodiscard]] Result<Bytes> add_moves(Bytes file, const std::vector<multires::Move>& moves);

/// The file as it was before any move. Errors: BadFile; those of RasterFile::open.
[[nodiscard]] Result<Bytes> without_moves(const std::shared_ptr<const ByteSource>& source);

/// Sum of squares of (surface minus its reconstruction from the coarsest scaling coefficients) over
/// valid samples: the denominator of energy_percent. The closed loop (scheme fvs) takes the
/// bilinear surface through the coarsest lattice.
[[nodiscard]] Result<double> detail_energy(const Raster& raster, const multires::SchemeSpec& spec);

}  // namespace relief::codec
