#pragma once

#include <cstdint>
#include <vector>

#include "codec/spooled_file.h"
#include "codec/tile_codec.h"
#include "relief/codec/container.h"
#include "relief/core/stream.h"

/// The closed loop over a whole raster, tile by tile. docs/codec.md.
namespace relief::codec {

struct LatticeOptions {
    Profile profile = Profile::Dense;
    double bound = 0;            ///< largest error of a sample; 0: lossless
    bool measure_coarse = true;  ///< find the bounds of coarser prefixes
    Progress progress = {};
};

struct LatticeEncoding {
    LatticeCoding coding;
    std::vector<SpooledChunk> chunks;  ///< in the order of the file
    std::int64_t samples = 0;          ///< valid ones
    std::int64_t nonzero = 0;
    std::int64_t repairs = 0;
    bool has_holes = false;
    double max_error = 0;
    double square_error = 0;
    /// Sum of squares of the samples less the bilinear surface through the coarsest lattice.
    double coarse_energy = 0;
};

/// What the closed loop needs to know of a raster before it can start.
struct Survey {
    std::int64_t valid = 0;
    std::vector<SampleStatistics> components;
    Raster coarse;  ///< every 8th sample of both axes
};

/// A few strips of rows, spread over a raster, for statistics. They begin with even rows.
[[nodiscard]] std::vector<LatticeBox> sample_strips(const Raster& about);

/// Reads the raster once. Errors: BadInput for a valid sample that is not a finite number, with its
/// place, and when no sample is valid; those of the source; Cancelled.
[[nodiscard]] Result<Survey> survey(const RasterSource& source, const Progress& progress);

/// Sum of squares of the valid samples of a strip, rows row0 .. of a raster like `about`, less the
/// bilinear surface through the raster's coarsest lattice.
[[nodiscard]] double coarse_energy(const RasterView& strip, std::int64_t row0, const Survey& survey,
                                   const Raster& about);

/// Whether the samples fit the closed loop's integers at this bound; sets the domains. Reads the
/// raster again for float samples that seem to lie on a lattice. Errors: of the source.
[[nodiscard]] Result<bool> choose_domains(const RasterSource& source, const Survey& survey,
                                          double bound, LatticeCoding& coding);

/// Encodes the raster; `coding` has its domains. Reads the raster once more, a row of tiles at a
/// time. Errors: those of the source and the spool; Cancelled. Memory: a 64th of the samples, and
/// rows of tiles.
[[nodiscard]] Result<LatticeEncoding> encode_lattice(const RasterSource& source,
                                                     const Survey& survey, LatticeCoding coding,
                                                     const LatticeOptions& options, Spool& spool);

}  // namespace relief::codec
