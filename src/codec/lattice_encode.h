#pragma once

#include <cstdint>
#include <map>
#include <vector>

#include "codec/lattice_assembly.h"
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

/// The tiers above the finest, and the finest tiles on which their steps were tried, which are part
/// of the file.
struct CoarseEncoding {
    LatticeCoding coding;                                 ///< with its tightening
    std::vector<std::vector<std::vector<Bytes>>> chunks;  ///< [tier - 1][tile]
    std::map<std::int64_t, EncodedTile> finest;
};
/// `coding` has its domains. Reads a few tiles. Errors: as encode_lattice.
[[nodiscard]] Result<CoarseEncoding> encode_coarse_tiers(const RasterSource& source,
                                                         const Survey& survey, LatticeCoding coding,
                                                         const LatticeOptions& options);

/// Samples of a tile with their integers. They refer to `part`.
[[nodiscard]] TileSamples tile_samples(const LatticeCoding& coding, const RasterView& part);
/// A part of a view.
[[nodiscard]] RasterView part_of(const RasterView& view, const LatticeBox& box);

/// Encodes the raster; `coding` has its domains. Reads the raster once more, a row of tiles at a
/// time. Errors: those of the source and the spool; Cancelled. Memory: a 64th of the samples, and
/// rows of tiles.
[[nodiscard]] Result<LatticeEncoding> encode_lattice(const RasterSource& source,
                                                     const Survey& survey, LatticeCoding coding,
                                                     const LatticeOptions& options, Spool& spool);

}  // namespace relief::codec
