#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "relief/codec/oracle.h"
#include "relief/core/raster.h"
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

struct EncodeOptions {
    multires::SchemeSpec spec = {};
    Goal goal = {};
    Effort effort = Effort::Refit;
    Progress progress = {};
};

/// What was achieved, measured on the decoded file in the raster's sample type.
struct EncodeReport {
    multires::SchemeSpec spec;
    std::int64_t samples = 0;       ///< rows x cols
    std::int64_t coefficients = 0;  ///< of the whole pyramid
    std::int64_t kept = 0;          ///< coefficients that are not zero, scaling band included
    std::int64_t corrected = 0;     ///< samples with a correction (max-error and lossless goals)
    std::uint64_t bytes = 0;
    double bits_per_sample = 0;
    double max_error = 0;
    double rms_error = 0;
    double energy_percent =
        0;  ///< 100 x squared error / squared (surface minus its coarsest reconstruction)
    double bound = 0;  ///< verified: the goal's for a max-error file, else max_error
};

struct EncodedRaster {
    std::vector<std::uint8_t> bytes;
    EncodeReport report;
};

/// Errors: InvalidArgument (goal negative or not a number, percentage or size impossible, scheme
/// parameters); BadInput (no valid sample, empty); Cancelled. Complexity: O(samples) analysis; rate
/// control repeats quantisation and synthesis about 20 times, a byte goal coding too.
[[nodiscard]] Result<EncodedRaster> encode_raster(const Raster& raster,
                                                  const EncodeOptions& options);

/// A band as `info` shows it.
struct BandInfo {
    multires::BandLayout layout;
    double step = 0;  ///< quantiser step; 0 when the band is not in the prefix
};

/// A chunk as `info` shows it.
struct ChunkSummary {
    std::string kind;  ///< "scaling", "details", "mask", "correction", "edits"
    int level = 0;
    std::uint64_t bytes = 0;
    double max_error = 0;  ///< of the surface decoded up to this chunk, and of its level's raster,
                           ///< against the original
    double rms_error = 0;
};

/// An opened .relief raster, or a prefix of one: which levels it can give is `finest_level`.
class RasterFile {
  public:
    /// A whole file. Everything is checked, nothing trusted. Errors: BadFile saying what is damaged
    /// or cut off; Unsupported.
    [[nodiscard]] static Result<RasterFile> open(std::vector<std::uint8_t> bytes);
    /// The first bytes of a file of `file_size` bytes, which may itself have lost its end: chunks
    /// that are not complete are left out. Errors: as open, and BadFile when not even the coarsest
    /// level is complete.
    [[nodiscard]] static Result<RasterFile> open_prefix(std::vector<std::uint8_t> bytes,
                                                        std::uint64_t file_size);

    RasterFile(RasterFile&&) noexcept;
    RasterFile& operator=(RasterFile&&) noexcept;
    ~RasterFile();

    /// Type, georeference, NODATA, unit, names: a raster without planes and mask, of the finest
    /// level's size.
    [[nodiscard]] const Raster& description() const;
    [[nodiscard]] const multires::PyramidLayout& layout() const;
    [[nodiscard]] std::vector<BandInfo> bands() const;
    [[nodiscard]] std::vector<ChunkSummary> chunks() const;
    [[nodiscard]] const std::vector<multires::Move>& moves() const;
    [[nodiscard]] Goal goal() const;
    [[nodiscard]] double max_error() const;  ///< of the whole file, as verified by its encoder
    [[nodiscard]] double rms_error() const;
    [[nodiscard]] int version() const;         ///< of the container
    [[nodiscard]] std::uint64_t size() const;  ///< of the whole file, in bytes
    [[nodiscard]] bool checksums_ok() const;   ///< of all chunks; reads them all
    [[nodiscard]] bool edited() const { return !moves().empty(); }
    /// The finest level of detail in this prefix: 0 when all of them are.
    [[nodiscard]] int finest_level() const;
    /// Verified error of the surface of `level` at all samples of the original raster, and of
    /// decode(level) at its own; none if edited.
    [[nodiscard]] std::optional<double> bound(int level) const;
    /// Bytes of the file that decoding `level` reads.
    [[nodiscard]] std::uint64_t bytes_for(int level) const;

    /// Scaling coefficients of `level`, moves included; corrections are not part of them.
    [[nodiscard]] Result<multires::LevelCoefficients<double>> coefficients(int level) const;

    /// Control coefficients (relief/multires/surface.h) of a surface that passes through decode(0)
    /// before its rounding to the sample type (for the quasi-interpolating and coefficient data
    /// maps: the surface that the file describes).
    [[nodiscard]] Result<multires::Planes<double>> control_net() const;

    /// The raster of `level`: size, transform, mask and values in the sample type. Errors:
    /// InvalidArgument for a level that the file does not have; BadFile for damage.
    [[nodiscard]] Result<Raster> decode(int level) const;

    /// The valid samples: 1 valid, 0 hole; empty when there are no holes.
    [[nodiscard]] const Grid<std::uint8_t>& mask() const;

  private:
    struct State;
    explicit RasterFile(std::unique_ptr<State> state);
    std::unique_ptr<State> state_;
};

/// The same file with `moves` added to those it has. The data of all levels is untouched: moves are
/// a layer of their own. They stand before the levels, so that every prefix has them. Errors:
/// InvalidArgument for a coefficient that does not exist or a displacement that is not a number of
/// at most 1e300; BadFile.
[[nodiscard]] Result<std::vector<std::uint8_t>> add_moves(std::span<const std::uint8_t> file,
                                                          const std::vector<multires::Move>& moves);

/// Sum of squares of (surface minus its reconstruction from the coarsest scaling coefficients) over
/// valid samples: the denominator of energy_percent.
[[nodiscard]] Result<double> detail_energy(const Raster& raster, const multires::SchemeSpec& spec);

}  // namespace relief::codec
