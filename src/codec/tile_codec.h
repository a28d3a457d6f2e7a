#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "codec/integer_domain.h"
#include "codec/lattice_level.h"
#include "codec/tile_tree.h"
#include "relief/codec/raster_codec.h"
#include "relief/core/raster.h"
#include "relief/core/stream.h"

/// One tile of a closed-loop file: its chunks and the samples that they give. docs/format.md,
/// "Tiles of lattices".
namespace relief::codec {

class ByteReader;

/// What all tiles of a file share.
struct LatticeCoding {
    Profile profile = Profile::Dense;
    double tightening = 1;  ///< steps of level l are this to the power of l times finer, at most 4
    SampleType type = SampleType::Float32;
    std::optional<double> nodata = {};
    std::vector<IntegerDomain> domains = {};  ///< one a component
    LatticeMargin margin = {};

    [[nodiscard]] std::int32_t step(std::size_t component, int level) const;
    /// out[k] = the sample that v[k] stands for, k < n.
    void stored(std::size_t component, const std::int32_t* v, std::int64_t n, double* out) const;
};

/// A sample that no v brings within the bound; row and column in the lattice of its level.
struct LatticeRepair {
    std::size_t component = 0;
    int level = 0;
    std::int64_t row = 0;
    std::int64_t col = 0;
    double value = 0;
    friend bool operator==(const LatticeRepair&, const LatticeRepair&) = default;
};

/// Which levels stand together in a chunk, coarse to fine: `first` >= `last`. `first` is levels()
/// for the base lattice of the top tier.
struct LevelRange {
    int first = 0;
    int last = 0;
};
/// The chunks of each tile of a tier, coarse to fine.
[[nodiscard]] std::vector<LevelRange> chunk_ranges(const TileTree& tree, int tier);

/// Where a tile stands between two levels.
struct TileState {
    /// The decoded level, one a component; empty before the base lattice of the top tier.
    std::vector<LatticeLevel> levels;
    std::vector<std::unique_ptr<LevelCodec>> codecs;  ///< one a component
    std::vector<LatticeRepair> repairs;               ///< of all levels of this tile so far
};

/// The state before the first level of the top tier.
[[nodiscard]] TileState top_state(const LatticeCoding& coding);

/// Coders for one tile: which one, and the masks of its levels.
class TileCodec {
  public:
    /// `valid`: 1 or 0 for the samples of the tile's box; empty: all valid. It must outlive this.
    TileCodec(const LatticeCoding& coding, const TileTree& tree, int tier, std::int64_t tile,
              const Grid<std::uint8_t>& valid);

    [[nodiscard]] const LatticeBox& box() const { return box_; }

    /// Codes `level` of one component behind `state`, which moves on to it.
    /// `samples`: of the whole box. Errors: BadInput when the bytes, decoded again, do not give
    /// what was coded (a broken machine).
    [[nodiscard]] Result<Bytes> encode_level(int level, std::size_t component,
                                             GridView<const std::int32_t> samples,
                                             TileState& state) const;

    /// Errors: BadFile.
    [[nodiscard]] Status decode_level(int level, std::size_t component,
                                      std::span<const std::uint8_t> bytes, TileState& state) const;

    [[nodiscard]] bool has_valid() const { return has_valid_; }

    /// `level` without data: what is missing beside the coarse samples is interpolated.
    [[nodiscard]] LatticeLevel interpolate(int level, std::size_t component,
                                           LatticeLevel& coarse) const;

    /// Decodes all levels of a chunk, whose mask has been read off. Errors: BadFile.
    [[nodiscard]] Status decode_chunk(LevelRange range, std::span<const std::uint8_t> bytes,
                                      TileState& state) const;

    /// Reads the repairs of a level behind those in `repairs`. Errors: BadFile.
    [[nodiscard]] Status read_repairs(ByteReader& in, int level,
                                      std::vector<LatticeRepair>& repairs) const;

  private:
    [[nodiscard]] LatticeLevel begin_level(int level, std::size_t component,
                                           LatticeLevel* coarse) const;
    const LatticeCoding& coding_;
    const Grid<std::uint8_t>& valid_;
    bool has_valid_ = true;
    int levels_;    ///< of the tree
    int tier_bit_;  ///< the tier's lattice is that of this level
    LatticeBox box_;
    Borders borders_;
};

/// The samples of a tile, as its encoder has them.
struct TileSamples {
    std::vector<Grid<std::int32_t>> values;         ///< one a component
    std::vector<GridView<const double>> originals;  ///< before conversion; may be NaN in holes
    Grid<std::uint8_t> valid;                       ///< has holes; empty: all valid
};

struct TileError {
    double max = 0;
    double square = 0;  ///< sum of squares
};

struct EncodedTile {
    std::vector<Bytes> chunks;  ///< one for each of chunk_ranges; empty: nothing to say
    TileState state;            ///< after the finest level
    TileError error;            ///< of the samples, repairs applied
    /// Largest error of the tile's lattice when the last k + 1 chunks are missing and what they
    /// hold is interpolated.
    std::vector<double> coarse_errors;
    std::int64_t repairs = 0;
    std::int64_t nonzero = 0;  ///< samples with a quotient that is not zero
};

/// What is found out about a tile beside its bytes.
enum class TileCare : std::uint8_t {
    Verified,  ///< its errors
    Measured,  ///< and the coarse_errors
};

/// Encodes a tile, and decodes the bytes again to the symbols of which its samples are made; these,
/// in the sample type, are compared with the source, and repaired where they are off by more than
/// `bound`. `start`: as top_state or the tier above gives it. Errors: BadInput when the decoder
/// disagrees (a broken machine); never otherwise.
[[nodiscard]] Result<EncodedTile> encode_tile(const LatticeCoding& coding, const TileTree& tree,
                                              int tier, std::int64_t tile,
                                              const TileSamples& samples, TileState start,
                                              double bound, TileCare care);

/// The mask at the front of a tile's first chunk: rows x cols of its box, empty when all samples
/// are valid. `bytes` moves on to what follows it. Errors: BadFile.
[[nodiscard]] Result<Grid<std::uint8_t>> read_tile_mask(const LatticeBox& box,
                                                        std::span<const std::uint8_t>& bytes);

}  // namespace relief::codec
