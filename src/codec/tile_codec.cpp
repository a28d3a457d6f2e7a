#include "codec/tile_codec.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <iterator>
#include <string>

#include "codec/bytes.h"
#include "codec/lattice_base.h"
#include "codec/lattice_fill.h"
#include "codec/sample_rows.h"
#include "relief/codec/mask_coder.h"

namespace relief::codec {

namespace {

/// Coarser levels of the top tier share one chunk: they are small.
constexpr int kSmallLevels = 4;
/// Rows whose errors are added up at the same time.
constexpr std::int64_t kRowsTogether = 4;

enum class MaskForm : std::uint8_t { AllValid, NoneValid, Coded };

Error damaged(const char* what) {
    return Error{ErrorCode::BadFile, std::string(what) + "; the file is damaged", "tile"};
}

std::size_t sample_bytes(SampleType type) {
    switch (type) {
        case SampleType::UInt8:
            return 1;
        case SampleType::UInt16:
        case SampleType::Int16:
            return 2;
        case SampleType::UInt32:
        case SampleType::Int32:
        case SampleType::Float32:
            return 4;
        case SampleType::Float64:
            break;
    }
    return 8;
}

void write_sample(ByteWriter& out, double value, SampleType type) {
    if (type == SampleType::Float64) return out.f64(value);
    if (type == SampleType::Float32) return out.f32(static_cast<float>(value));
    const auto bits = static_cast<std::uint64_t>(static_cast<std::int64_t>(value));
    for (std::size_t k = 0; k < sample_bytes(type); ++k)
        out.u8(static_cast<std::uint8_t>(bits >> (8 * k)));
}

double read_sample(ByteReader& in, SampleType type) {
    switch (type) {
        case SampleType::UInt8:
            return in.u8();
        case SampleType::UInt16:
            return in.u16();
        case SampleType::Int16:
            return static_cast<std::int16_t>(in.u16());
        case SampleType::UInt32:
            return in.u32();
        case SampleType::Int32:
            return static_cast<std::int32_t>(in.u32());
        case SampleType::Float32:
            return static_cast<double>(in.f32());
        case SampleType::Float64:
            break;
    }
    return in.f64();
}

Bytes write_mask(const TileSamples& samples, bool has_valid) {
    ByteWriter out;
    const Grid<std::uint8_t>& valid = samples.valid;
    if (valid.empty()) {
        out.u8(static_cast<std::uint8_t>(MaskForm::AllValid));
    } else if (!has_valid) {
        out.u8(static_cast<std::uint8_t>(MaskForm::NoneValid));
    } else {
        const Bytes coded = encode_mask(valid.view());
        out.u8(static_cast<std::uint8_t>(MaskForm::Coded));
        out.varint(coded.size());
        out.bytes(coded);
    }
    return out.take();
}

bool same_samples(const LatticeLevel& a, const LatticeLevel& b) {
    for (std::int64_t r = 0; r < a.rows(); ++r)
        if (!std::equal(a.values.row(r), a.values.row(r) + a.cols(), b.values.row(r))) return false;
    return true;
}

Error disagreement(const LatticeBox& box) {
    return {ErrorCode::BadInput,
            "what was written does not decode to what was meant; the machine or this program is at "
            "fault",
            "tile at row " + std::to_string(box.row0) + ", column " + std::to_string(box.col0)};
}

}  // namespace

std::int32_t LatticeCoding::step(std::size_t component, int level) const {
    const std::int32_t step = domains[component].step;
    double factor = 1;
    for (int l = 0; l < level && factor < 4; ++l) factor *= tightening;
    const double finer = step / std::min(factor, 4.0);
    return 2 * static_cast<std::int32_t>(std::floor((finer - 1) / 2 + 0.5)) + 1;
}

void LatticeCoding::stored(std::size_t component, const std::int32_t* v, std::int64_t n,
                           double* out) const {
    value_row(v, n, domains[component], out);
    stored_row(out, n, type, nodata, out);
}

std::vector<LevelRange> chunk_ranges(const TileTree& tree, int tier) {
    std::vector<LevelRange> ranges;
    const int finest = TileTree::kTierLevels * tier;
    int level = tree.coarsest_of(tier);
    if (tier == tree.tiers() - 1) {
        const int last = std::min(tree.levels(), finest + kSmallLevels);
        ranges.push_back({tree.levels(), last});
        level = last - 1;
    }
    for (; level >= finest; --level) ranges.push_back({level, level});
    return ranges;
}

TileState top_state(const LatticeCoding& coding) {
    TileState state;
    for (std::size_t c = 0; c < coding.domains.size(); ++c)
        state.codecs.push_back(coding.profile == Profile::Dense ? make_dense_codec()
                                                                : make_fast_codec());
    return state;
}

TileCodec::TileCodec(const LatticeCoding& coding, const TileTree& tree, int tier, std::int64_t tile,
                     const Grid<std::uint8_t>& valid)
    : coding_(coding),
      valid_(valid),
      levels_(tree.levels()),
      tier_bit_(TileTree::kTierLevels * tier),
      box_(tree.box(tier, tile)) {
    for (std::int64_t r = 0; r < valid.rows(); ++r) {
        const std::uint8_t* row = valid.row(r);
        has_valid_ = std::find(row, row + valid.cols(), std::uint8_t{1}) != row + valid.cols();
        if (has_valid_) break;
    }
    const TileTree::Tier& all = tree.tier(tier);
    borders_.north = box_.row0 == 0;
    borders_.west = box_.col0 == 0;
    borders_.south = box_.row0 + box_.rows == all.rows;
    borders_.east = box_.col0 + box_.cols == all.cols;
}

LatticeLevel TileCodec::begin_level(int level, std::size_t component, LatticeLevel* coarse) const {
    const int shift = level - tier_bit_;
    const std::int64_t rows = level_size(box_.rows, shift);
    const std::int64_t cols = level_size(box_.cols, shift);
    LatticeLevel next;
    if (coarse) {
        next = refine(*coarse, rows, cols);
    } else {
        next.level = level;
        next.values = MarginGrid<std::int32_t>(rows, cols);
        next.quotients = MarginGrid<std::int16_t>(rows, cols);
        next.valid = MarginGrid<std::uint8_t>(rows, cols);
    }
    next.borders = borders_;
    next.lowest = 0;
    next.highest = coding_.domains[component].highest;
    next.step = coding_.step(component, level);
    next.raw_bits = coding_.domains[component].raw_bits;
    next.all_valid = valid_.empty();
    for (std::int64_t r = 0; r < rows; ++r) {
        std::uint8_t* to = next.valid.row(r);
        if (valid_.empty()) {
            std::fill_n(to, cols, std::uint8_t{1});
            continue;
        }
        const std::uint8_t* from = valid_.row(r << shift);
        if (shift == 0) {
            std::copy_n(from, cols, to);
            continue;
        }
        for (std::int64_t c = 0; c < cols; ++c) to[c] = from[c << shift];
    }
    return next;
}

Result<Bytes> TileCodec::encode_level(int level, std::size_t component,
                                      GridView<const std::int32_t> samples,
                                      TileState& state) const {
    LatticeLevel* coarse = state.levels.size() > component ? &state.levels[component] : nullptr;
    LatticeLevel next = begin_level(level, component, coarse);
    const int shift = level - tier_bit_;
    Grid<std::int32_t> picked;
    if (shift > 0) {
        picked = Grid<std::int32_t>(next.rows(), next.cols());
        for (std::int64_t r = 0; r < next.rows(); ++r)
            for (std::int64_t c = 0; c < next.cols(); ++c)
                picked(r, c) = samples(r << shift, c << shift);
        samples = picked.view();
    }
    Bytes bytes;
    if (coarse) {
        if (!state.codecs[component]->encode(next, samples, bytes)) return disagreement(box_);
        fill_edge_margins(next);
        *coarse = std::move(next);
    } else {
        bytes = encode_base(next, samples);
        LatticeLevel again = begin_level(level, component, nullptr);
        if (!decode_base(bytes, again).ok() || !same_samples(next, again))
            return disagreement(box_);
        state.levels.push_back(std::move(next));
    }
    return bytes;
}

Status TileCodec::decode_level(int level, std::size_t component,
                               std::span<const std::uint8_t> bytes, TileState& state) const {
    LatticeLevel* coarse = state.levels.size() > component ? &state.levels[component] : nullptr;
    LatticeLevel next = begin_level(level, component, coarse);
    if (!coarse) {
        RELIEF_CHECK(decode_base(bytes, next));
        state.levels.push_back(std::move(next));
        return {};
    }
    RELIEF_CHECK(state.codecs[component]->decode(next, bytes));
    fill_edge_margins(next);
    *coarse = std::move(next);
    return {};
}

LatticeLevel TileCodec::interpolate(int level, std::size_t component, LatticeLevel& coarse) const {
    LatticeLevel next = begin_level(level, component, &coarse);
    fill_level(next);
    return next;
}

Status TileCodec::read_repairs(ByteReader& in, int level,
                               std::vector<LatticeRepair>& repairs) const {
    const int shift = level - tier_bit_;
    const auto rows = static_cast<std::uint64_t>(level_size(box_.rows, shift));
    const auto cols = static_cast<std::uint64_t>(level_size(box_.cols, shift));
    const std::uint64_t all = rows * cols * coding_.domains.size();
    const std::uint64_t count = in.varint();
    if (in.failed() || count > in.rest().size()) return damaged("a list of repairs is too long");
    std::uint64_t index = 0;
    for (std::uint64_t k = 0; k < count; ++k) {
        const std::uint64_t skipped = in.varint();
        if (skipped >= all || index + skipped >= all) return damaged("a repair lies outside");
        index += skipped;
        const double value = read_sample(in, coding_.type);
        if (in.failed() || !std::isfinite(value)) return damaged("a repair is not a number");
        const std::uint64_t sample = index % (rows * cols);
        repairs.push_back({index / (rows * cols), level, static_cast<std::int64_t>(sample / cols),
                           static_cast<std::int64_t>(sample % cols), value});
        ++index;
    }
    return {};
}

Status TileCodec::decode_chunk(LevelRange range, std::span<const std::uint8_t> bytes,
                               TileState& state) const {
    ByteReader in(bytes);
    for (int level = range.first; level >= range.last; --level) {
        for (std::size_t c = 0; c < coding_.domains.size(); ++c) {
            const auto coded = in.take(in.varint());
            if (in.failed()) return damaged("a level is cut off");
            RELIEF_CHECK(decode_level(level, c, coded, state));
        }
        RELIEF_CHECK(read_repairs(in, level, state.repairs));
    }
    if (!in.rest().empty()) return damaged("bytes are left over");
    return {};
}

Result<Grid<std::uint8_t>> read_tile_mask(const LatticeBox& box,
                                          std::span<const std::uint8_t>& bytes) {
    ByteReader in(bytes);
    const std::uint8_t form = in.u8();
    if (in.failed() || form > static_cast<std::uint8_t>(MaskForm::Coded))
        return damaged("its mask has no known form");
    Grid<std::uint8_t> valid;
    if (form == static_cast<std::uint8_t>(MaskForm::NoneValid))
        valid = Grid<std::uint8_t>(box.rows, box.cols, 0);
    if (form == static_cast<std::uint8_t>(MaskForm::Coded)) {
        const auto coded = in.take(in.varint());
        if (in.failed()) return damaged("its mask is cut off");
        valid = Grid<std::uint8_t>(box.rows, box.cols);
        RELIEF_CHECK(decode_mask(coded, valid.view()));
    }
    bytes = in.rest();
    return valid;
}

namespace {

/// Encodes one tile and checks what it wrote.
class TileEncoder {
  public:
    TileEncoder(const LatticeCoding& coding, const TileTree& tree, int tier, std::int64_t tile,
                const TileSamples& samples, double bound, TileCare care)
        : coding_(coding),
          samples_(samples),
          bound_(bound),
          care_(care),
          top_(tier == tree.tiers() - 1),
          finest_(TileTree::kTierLevels * tier),
          levels_(tree.levels()),
          ranges_(chunk_ranges(tree, tier)),
          codec_(coding, tree, tier, tile, samples.valid) {
        for (std::size_t c = 0; c < coding.domains.size(); ++c)
            beyond_.push_back(coding.domains[c].outliers ? largest_outlier(c) : 0);
    }

    Result<EncodedTile> run(TileState start) {
        EncodedTile tile;
        tile.state = std::move(start);
        std::vector<ByteWriter> chunks(ranges_.size());
        chunks[0].bytes(write_mask(samples_, codec_.has_valid()));
        if (!top_ && !codec_.has_valid()) return without_samples(std::move(tile), chunks[0]);
        if (!top_) note_error_without(tile);
        std::vector<std::vector<Bytes>> coded(static_cast<std::size_t>(levels_) + 1);
        for (std::size_t k = 0; k < ranges_.size(); ++k) {
            for (int level = ranges_[k].first; level >= ranges_[k].last; --level) {
                for (std::size_t c = 0; c < coding_.domains.size(); ++c) {
                    RELIEF_TRY(Bytes bytes, codec_.encode_level(level, c, samples_.values[c].view(),
                                                                tile.state));
                    coded[static_cast<std::size_t>(level)].push_back(std::move(bytes));
                }
            }
            if (k + 1 < ranges_.size()) note_error_without(tile);
        }
        std::reverse(tile.coarse_errors.begin(), tile.coarse_errors.end());
        measure(tile);
        for (std::size_t k = 0; k < ranges_.size(); ++k) {
            for (int level = ranges_[k].first; level >= ranges_[k].last; --level)
                write_level(coded[static_cast<std::size_t>(level)], level, tile.state, chunks[k]);
            tile.chunks.push_back(chunks[k].take());
        }
        tile.repairs = static_cast<std::int64_t>(tile.state.repairs.size());
        if (!reads_back(tile, coded)) return disagreement(codec_.box());
        return tile;
    }

  private:
    [[nodiscard]] bool is_valid(std::int64_t r, std::int64_t c) const {
        return samples_.valid.empty() || samples_.valid(r, c) != 0;
    }

    /// The largest distance of a sample from what its integer stands for.
    [[nodiscard]] double largest_outlier(std::size_t component) const {
        const IntegerDomain& domain = coding_.domains[component];
        const GridView<const double>& originals = samples_.originals[component];
        double largest = 0;
        for (std::int64_t r = 0; r < originals.rows; ++r)
            for (std::int64_t c = 0; c < originals.cols; ++c)
                if (is_valid(r, c))
                    largest = std::max(
                        largest,
                        std::abs(originals(r, c) - domain.value(samples_.values[component](r, c))));
        return largest;
    }

    /// Whether the chunks hold the mask, the levels and the repairs that they should.
    bool reads_back(const EncodedTile& tile, const std::vector<std::vector<Bytes>>& coded) const {
        for (std::size_t k = 0; k < ranges_.size(); ++k) {
            std::span<const std::uint8_t> bytes(tile.chunks[k]);
            if (k == 0 && !same_mask(bytes)) return false;
            ByteReader in(bytes);
            for (int level = ranges_[k].first; level >= ranges_[k].last; --level) {
                for (const Bytes& expected : coded[static_cast<std::size_t>(level)]) {
                    const auto found = in.take(in.varint());
                    if (!std::equal(found.begin(), found.end(), expected.begin(), expected.end()))
                        return false;
                }
                std::vector<LatticeRepair> repairs;
                if (!codec_.read_repairs(in, level, repairs).ok() ||
                    repairs != repairs_of(tile.state, level))
                    return false;
            }
            if (in.failed() || !in.rest().empty()) return false;
        }
        return true;
    }

    static std::vector<LatticeRepair> repairs_of(const TileState& state, int level) {
        std::vector<LatticeRepair> repairs;
        std::copy_if(state.repairs.begin(), state.repairs.end(), std::back_inserter(repairs),
                     [level](const LatticeRepair& repair) { return repair.level == level; });
        return repairs;
    }

    bool same_mask(std::span<const std::uint8_t>& bytes) const {
        const auto valid = read_tile_mask(codec_.box(), bytes);
        if (!valid.ok()) return false;
        for (std::int64_t r = 0; r < valid->rows(); ++r)
            for (std::int64_t c = 0; c < valid->cols(); ++c)
                if (((*valid)(r, c) != 0) != is_valid(r, c)) return false;
        return !valid->empty() || codec_.has_valid();
    }

    /// Only the mask is written; samples are interpolated, for the neighbours' sake.
    EncodedTile without_samples(EncodedTile tile, ByteWriter& first) const {
        for (std::size_t c = 0; c < tile.state.levels.size(); ++c)
            while (tile.state.levels[c].level > finest_)
                tile.state.levels[c] =
                    codec_.interpolate(tile.state.levels[c].level - 1, c, tile.state.levels[c]);
        tile.chunks.resize(ranges_.size());
        tile.chunks[0] = first.take();
        tile.coarse_errors.assign(ranges_.size(), 0.0);
        return tile;
    }

    /// Notes the largest error of the tile when nothing finer than the state's level is known.
    void note_error_without(EncodedTile& tile) const {
        if (care_ != TileCare::Measured) return;
        double largest = 0;
        for (std::size_t c = 0; c < tile.state.levels.size(); ++c) {
            LatticeLevel& known = tile.state.levels[c];
            if (known.level == finest_) continue;
            LatticeLevel filled;
            LatticeLevel* from = &known;
            for (int level = known.level - 1; level > finest_; --level) {
                filled = codec_.interpolate(level, c, *from);
                from = &filled;
            }
            const std::int32_t off =
                largest_filling_error(*from, samples_.values[c].view(), samples_.valid);
            // Conversion of samples to integers is half a unit off at most, but for outliers.
            const IntegerDomain& domain = coding_.domains[c];
            largest = std::max(largest, domain.unit * (static_cast<double>(off) + 0.5) +
                                            domain.rounding + beyond_[c]);
        }
        tile.coarse_errors.push_back(largest);
    }

    /// Null: all samples of the row are valid.
    [[nodiscard]] const std::uint8_t* valid_row(std::int64_t r) const {
        return samples_.valid.empty() ? nullptr : samples_.valid.row(r);
    }

    /// Errors of the decoded samples; those over the bound become repairs.
    void measure(EncodedTile& tile) const {
        const LatticeBox& box = codec_.box();
        Grid<double> errors(kRowsTogether, box.cols, 0);
        std::vector<double> stored(static_cast<std::size_t>(box.cols));
        for (std::size_t c = 0; c < coding_.domains.size(); ++c)
            for (std::int64_t row = 0; row < box.rows; row += kRowsTogether) {
                const std::int64_t rows = std::min(kRowsTogether, box.rows - row);
                for (std::int64_t k = 0; k < rows; ++k)
                    measure_row(tile, c, row + k, stored.data(), errors.row(k));
                if (bound_ > 0) add_squares(errors, rows, tile.error.square);
            }
    }

    void measure_row(EncodedTile& tile, std::size_t component, std::int64_t r, double* stored,
                     double* errors) const {
        const std::int64_t cols = codec_.box().cols;
        const LatticeLevel& level = tile.state.levels[component];
        const double* wanted = samples_.originals[component].row(r);
        const std::int16_t* quotients = level.quotients.row(r);
        tile.nonzero += cols - std::count(quotients, quotients + cols, 0);
        coding_.stored(component, level.values.row(r), cols, stored);
        RowErrors row = error_row(stored, wanted, valid_row(r), cols, bound_, errors);
        for (std::int64_t c = 0; c < cols && !row.within; ++c)
            if (is_valid(r, c) && !is_within(stored[c], wanted[c], bound_)) {
                repair(tile, component, r, c, wanted[c]);
                errors[c] = 0;
            }
        if (!row.within) row.largest = *std::max_element(errors, errors + cols);
        tile.error.max = std::max(tile.error.max, row.largest);
    }

    /// Adds squares, each row's from left to right and then the rows in order. Several rows at a
    /// time: an addition has to wait for the one before.
    static void add_squares(const Grid<double>& errors, std::int64_t rows, double& sum) {
        std::array<double, kRowsTogether> squares{};
        for (std::int64_t c = 0; c < errors.cols(); ++c)
            for (std::int64_t k = 0; k < kRowsTogether; ++k)
                squares[static_cast<std::size_t>(k)] += errors(k, c) * errors(k, c);
        for (std::int64_t k = 0; k < rows; ++k) sum += squares[static_cast<std::size_t>(k)];
    }

    /// Samples of the tier above are repaired there.
    void repair(EncodedTile& tile, std::size_t component, std::int64_t r, std::int64_t c,
                double value) const {
        const int most = top_ ? levels_ - finest_ : TileTree::kTierLevels;
        const int shift = std::min(
            most, std::countr_zero(static_cast<std::uint64_t>(r | c) | (std::uint64_t{1} << most)));
        if (!top_ && shift == most) return;
        tile.state.repairs.push_back({component, finest_ + shift, r >> shift, c >> shift, value});
    }

    void write_level(const std::vector<Bytes>& coded, int level, const TileState& state,
                     ByteWriter& out) const {
        for (const Bytes& bytes : coded) {
            out.varint(bytes.size());
            out.bytes(bytes);
        }
        const int shift = level - finest_;
        const std::int64_t rows = level_size(codec_.box().rows, shift);
        const std::int64_t cols = level_size(codec_.box().cols, shift);
        const std::vector<LatticeRepair> repairs = repairs_of(state, level);
        out.varint(repairs.size());
        std::int64_t next = 0;
        for (const LatticeRepair& repair : repairs) {  // in order of component, row and column
            const auto plane = static_cast<std::int64_t>(repair.component) * rows;
            const std::int64_t index = (plane + repair.row) * cols + repair.col;
            out.varint(static_cast<std::uint64_t>(index - next));
            write_sample(out, repair.value, coding_.type);
            next = index + 1;
        }
    }

    const LatticeCoding& coding_;
    const TileSamples& samples_;
    double bound_;
    TileCare care_;
    bool top_;
    int finest_;
    int levels_;
    std::vector<LevelRange> ranges_;
    TileCodec codec_;
    std::vector<double> beyond_;  ///< how far samples of a component lie outside of its integers
};

}  // namespace

Result<EncodedTile> encode_tile(const LatticeCoding& coding, const TileTree& tree, int tier,
                                std::int64_t tile, const TileSamples& samples, TileState start,
                                double bound, TileCare care) {
    return TileEncoder(coding, tree, tier, tile, samples, bound, care).run(std::move(start));
}

}  // namespace relief::codec
