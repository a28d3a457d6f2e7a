#include "codec/pyramid_tiles.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <string>

#include "codec/decimal.h"
#include "codec/pyramid_code.h"
#include "codec/pyramid_measure.h"
#include "codec/pyramid_search.h"
#include "codec/spooled_file.h"
#include "codec/tile_details.h"
#include "codec/tile_masks.h"
#include "relief/codec/fill.h"
#include "relief/core/parallel.h"

namespace relief::codec {

namespace {

using Kind = Goal::Kind;
using multires::Planes;

/// Tiles that are chosen at once, for which there is memory.
constexpr std::size_t kAtOnce = 4;
/// Where a search is near enough to its goal: at first, without least squares, and in the end.
constexpr double kRoughly = 0.9;
constexpr double kRefinement = 1.05;
constexpr double kClosely = 0.99;
/// Stands for bounds and errors that are not known yet: a number of many digits.
constexpr double kLongNumber = 123456.78901234567;
/// What a step gives: a file on the spool.
struct Attempt {
    PyramidCoding coding;
    std::vector<SpooledChunk> chunks;  ///< of the streams, in the order of the file
    std::int64_t kept = 0;
    std::shared_ptr<const SpooledFile> file;
    SurfaceError error;
};

class TiledEncoder {
  public:
    TiledEncoder(const RasterSource& source, const EncodeOptions& options, Spool& spool,
                 multires::PyramidLayout layout)
        : source_(source),
          options_(options),
          spool_(spool),
          layout_(std::move(layout)),
          streams_(layout_),
          tree_(layout_.rows, layout_.cols),
          blocks_(blocks_of(tree_)) {
        for (const Block& block : blocks_) cores_.push_back(block.core);
    }

    Result<std::optional<EncodeReport>> run(ByteSink& sink) {
        RELIEF_CHECK(survey());
        RELIEF_CHECK(analyse_coarse());
        for (double most = options_.goal.value;;) {
            RELIEF_TRY(std::optional<Attempt> best, choose(most));
            if (!best) return std::optional<EncodeReport>();
            RELIEF_TRY(const EncodeReport report, finish(*best));
            const double over = static_cast<double>(report.bytes) - options_.goal.value;
            if (options_.goal.kind != Kind::Bytes || over <= 0) {
                RELIEF_CHECK(best->file->copy_to(sink));
                if (options_.progress) options_.progress(1);
                return std::optional<EncodeReport>(report);
            }
            most -= over;
        }
    }

  private:
    [[nodiscard]] LatticeBox raster() const { return {0, 0, layout_.rows, layout_.cols}; }
    [[nodiscard]] int components() const { return layout_.components; }

    /// Reads the raster once: checks it, keeps its masks, and the values of level kFine.
    Status survey() {
        const std::int64_t rows = level_size(layout_.rows, kFine);
        const std::int64_t cols = level_size(layout_.cols, kFine);
        for (int c = 0; c < components(); ++c) scaling_.emplace_back(rows, cols);
        near_valid_ = Grid<std::uint8_t>(rows, cols, 0);
        masks_.resize(static_cast<std::size_t>(tree_.tier(0).tiles()));
        for (std::size_t k = 0; k < blocks_.size(); ++k) {
            if (cancelled(0.1 * static_cast<double>(k) / static_cast<double>(blocks_.size())))
                return cancelled_error();
            RELIEF_CHECK(survey(blocks_[k]));
        }
        if (samples_ == 0)
            return Error{ErrorCode::BadInput,
                         "no sample is valid: every one is NODATA or not a number", ""};
        if (samples_ == layout_.rows * layout_.cols) masks_.clear();
        return {};
    }

    Status survey(const Block& block) {
        RELIEF_TRY(const Window window, read_window(source_, block.window));
        RELIEF_CHECK(check_samples(window.samples, block.window.row0, block.window.col0));
        RELIEF_CHECK(keep_masks(block, window.samples));
        RELIEF_TRY(const multires::PyramidLayout fine, fine_layout(layout_, block.window));
        RELIEF_TRY(const Pyramid<double> pyramid,
                   multires::analyse<double>(window.target().planes, fine.spec));
        const LatticeBox part =
            lattice_of(block, kFine, raster(), {0, 0, scaling_[0].rows(), scaling_[0].cols()});
        const LatticeBox local =
            relative(part, block.window.row0 >> kFine, block.window.col0 >> kFine);
        for (std::size_t c = 0; c < scaling_.size(); ++c)
            for (std::int64_t r = 0; r < part.rows; ++r)
                std::copy_n(pyramid.bands[0][c].row(local.row0 + r) + local.col0, part.cols,
                            scaling_[c].row(part.row0 + r) + part.col0);
        for (std::size_t k = 1; k < pyramid.bands.size(); ++k) note_magnitudes(block, pyramid, k);
        return {};
    }

    /// The mask of the tile, and which values of level kFine have valid samples around them.
    Status keep_masks(const Block& block, const Raster& window) {
        for (std::int64_t r = 0; r < window.rows; ++r)
            for (std::int64_t c = 0; c < window.cols; ++c) {
                if (!window.valid(r, c)) continue;
                const std::int64_t row = block.window.row0 + r;
                const std::int64_t col = block.window.col0 + c;
                samples_ += block.core.contains(row, col);
                const std::int64_t i = std::min((row + kUnit / 2) >> kFine, near_valid_.rows() - 1);
                const std::int64_t j = std::min((col + kUnit / 2) >> kFine, near_valid_.cols() - 1);
                near_valid_(i, j) = 1;
            }
        const LatticeBox local = relative(block.core, block.window.row0, block.window.col0);
        const Bytes mask =
            window.mask.empty() ? Bytes() : encode_tile_mask(part_of(window.mask.view(), local));
        RELIEF_TRY(masks_[static_cast<std::size_t>(block.tile)], spooled(mask, spool_));
        return {};
    }

    /// The largest magnitude of a band of a block, and its energy, as weighted by its norm.
    void note_magnitudes(const Block& block, const Pyramid<double>& pyramid, std::size_t band) {
        const multires::BandLayout& about = pyramid.layout.bands[band];
        const LatticeBox& all = layout_.bands[coarse_bands(layout_) - 1 + band].box;
        const LatticeBox part =
            relative(lattice_of(block, about.level, raster(), all),
                     block.window.row0 >> about.level, block.window.col0 >> about.level);
        for (const Grid<double>& plane : pyramid.bands[band])
            for (std::int64_t r = part.row0; r < part.row0 + part.rows; ++r)
                for (std::int64_t c = part.col0; c < part.col0 + part.cols; ++c) {
                    const double weighted = std::abs(plane(r, c)) * about.norm_samples;
                    largest_ = std::max(largest_, weighted);
                    energy_ += weighted * weighted;
                }
    }

    /// The pyramid over the values of level kFine. Norms are an 8th of those of the whole raster,
    /// so that an 8th of the step quantises bands alike.
    Status analyse_coarse() {
        const bool holes = samples_ < layout_.rows * layout_.cols;
        if (!holes) near_valid_ = {};
        for (Grid<double>& plane : scaling_)
            if (holes) plane = filled(plane.view(), near_valid_);
        for (const Grid<double>& plane : scaling_) coarse_target_.planes.push_back(plane.view());
        if (holes) coarse_target_.mask = near_valid_.view();
        multires::SchemeSpec spec = layout_.spec;
        spec.levels -= kFine;
        RELIEF_TRY(coarse_, multires::analyse<double>(coarse_target_.planes, spec));
        means_ = means_of(coarse_.bands[0]);
        for (std::size_t k = 0; k < coarse_.bands.size(); ++k) {
            double& norm = coarse_.layout.bands[k].norm_samples;
            norm = layout_.bands[k].norm_samples / static_cast<double>(kUnit);
            for (std::size_t c = 0; c < coarse_.bands[k].size(); ++c) {
                const Grid<double>& plane = coarse_.bands[k][c];
                const double weight = norm * static_cast<double>(kUnit);
                const double most = largest_magnitude(plane, k == 0 ? means_[c] : 0) * weight;
                largest_ = std::max(largest_, most);
                if (k > 0)
                    for (std::int64_t r = 0; r < plane.rows(); ++r)
                        for (std::int64_t i = 0; i < plane.cols(); ++i)
                            energy_ += std::pow(plane(r, i) * weight, 2);
            }
        }
        return {};
    }

    /// None: no step comes so near to the raster.
    Result<std::optional<Attempt>> choose(double most) {
        const bool by_rms = options_.goal.kind == Kind::RmsError;
        const double goal = by_rms ? options_.goal.value : most;
        const double values = static_cast<double>(samples_) * components();
        const double spread = std::sqrt(energy_ / values);
        double start = 4 * goal;
        std::optional<Attempt> nothing;
        if (!by_rms) {
            RELIEF_TRY(nothing, attempt(largest_step(), Effort::Select));
            const auto least = static_cast<double>(nothing->file->size());
            if (least > goal)
                return Error{ErrorCode::InvalidArgument,
                             "no file is that small; this raster's header and structure alone "
                             "take " +
                                 std::to_string(nothing->file->size()) + " bytes",
                             ""};
            if (!(spread > 0)) return nothing;
            start = std::max(8 * spread * std::exp2(-16 * goal / values), 1e-6 * spread);
        }
        const auto measure = [&](const Attempt& a) {
            return by_rms ? a.error.rms(samples_) / goal
                          : static_cast<double>(a.file->size()) / goal;
        };
        const auto find = [&](double step, double close_enough, Effort effort, double from) {
            return search<Attempt>(
                step, by_rms, close_enough,
                [&](double s) -> Result<Attempt> {
                    RELIEF_TRY(Attempt a, attempt(s, effort));
                    if (by_rms) {
                        RELIEF_TRY(a.error, measured(reference(), a.file));
                    }
                    return a;
                },
                measure, [&](double done) { return cancelled(from + 0.4 * done); });
        };
        RELIEF_TRY(const std::optional<Attempt> rough, find(start, kRoughly, Effort::Select, 0.1));
        if (!rough) return nothing;
        double refined = rough->coding.step;
        // Least squares take some per cent off the error.
        if (by_rms && options_.effort != Effort::Select) refined *= kRefinement / measure(*rough);
        RELIEF_TRY(std::optional<Attempt> found, find(refined, kClosely, options_.effort, 0.5));
        return found ? std::move(found) : std::move(nothing);
    }

    [[nodiscard]] double least_step() const { return std::max(largest_ / 0x1p29, 1e-290); }
    [[nodiscard]] double largest_step() const { return 4 * 0x1p29 * least_step(); }

    /// The file that a step gives.
    Result<Attempt> attempt(double step, Effort effort) {
        Attempt result;
        result.coding.means = means_;
        result.coding.step = rounded_up(std::clamp(step, least_step(), kLargestStep), 6);
        PyramidCoding eighth = result.coding;
        eighth.step /= static_cast<double>(kUnit);
        QuantisedPyramid coarse =
            quantise(improved(copy_of(coarse_), coarse_target_, eighth, effort), eighth);
        const std::span<const StreamLayout::Group> groups(streams_.groups());
        const auto first_fine = static_cast<std::size_t>(
            std::find_if(groups.begin(), groups.end(),
                         [](const auto& group) { return group.finest <= kFine; }) -
            groups.begin());
        coarse.boxes.resize(layout_.bands.size());
        RELIEF_TRY(std::vector<CodedStream> coded,
                   encode_streams(layout_, streams_, coarse, groups.first(first_fine)));
        std::vector<std::vector<SpooledChunk>> places(coded.size());
        for (std::size_t k = 0; k < groups[first_fine].first; ++k)
            RELIEF_CHECK(put_away(coded[k], places[k]));
        result.kept = count_kept(coarse);
        auto surface = Pyramid<double>::allocate(coarse_.layout);
        reconstruct(coarse, eighth, 0, 0, surface);
        const Planes<double> below = multires::synthesise(surface);
        for (std::size_t first = 0; first < blocks_.size(); first += kAtOnce) {
            if (cancelled(done_)) return cancelled_error();
            const std::size_t last = std::min(first + kAtOnce, blocks_.size());
            RELIEF_TRY(const std::int64_t kept,
                       encode_blocks(first, last, {below, coarse, result.coding, effort}, coded));
            result.kept += kept;
            for (std::size_t k = first; k < last; ++k)
                for (const std::size_t number : streams_of(blocks_[k]))
                    RELIEF_CHECK(put_away(coded[number], places[number]));
        }
        result.coding.layers = choose_layers(coded);
        RELIEF_CHECK(make_chunks(coded, places, result));
        RELIEF_TRY(result.file, file_of(result, {}, {}));
        return result;
    }

    /// The streams of a tile's fine levels, coarse ones first.
    [[nodiscard]] std::vector<std::size_t> streams_of(const Block& block) const {
        std::vector<std::size_t> numbers;
        for (int level = kFine; level >= 1; --level)
            numbers.push_back(streams_.stream_of(streams_.group_of_level(level), block.tile));
        return numbers;
    }

    /// Returns how many coefficients are not zero.
    Result<std::int64_t> encode_blocks(std::size_t first, std::size_t last,
                                       const CoarserLevels& coarser,
                                       std::vector<CodedStream>& coded) const {
        std::vector<Result<std::int64_t>> kept(last - first, std::int64_t{0});
        parallel_for(0, static_cast<std::int64_t>(last - first), 1,
                     [&](std::int64_t begin, std::int64_t end) {
                         for (auto k = static_cast<std::size_t>(begin);
                              k < static_cast<std::size_t>(end); ++k)
                             kept[k] = encode_block(blocks_[first + k], coarser, coded);
                     });
        std::int64_t sum = 0;
        for (const Result<std::int64_t>& count : kept) {
            RELIEF_TRY(const std::int64_t n, count);
            sum += n;
        }
        return sum;
    }

    Result<std::int64_t> encode_block(const Block& block, const CoarserLevels& coarser,
                                      std::vector<CodedStream>& coded) const {
        RELIEF_TRY(QuantisedPyramid details, choose_details(source_, layout_, block, coarser));
        const QuantisedPyramid* above = &coarser.quantised;
        for (const std::size_t number : streams_of(block)) {
            RELIEF_TRY(coded[number],
                       encode_one_stream(layout_, streams_, number, details, *above));
            above = &details;
        }
        return count_kept(details);
    }

    /// Streams wait on the spool.
    Status put_away(CodedStream& stream, std::vector<SpooledChunk>& places) {
        for (EmbeddedStream& component : stream) {
            SpooledChunk chunk;
            chunk.info.length = component.bytes.size();
            RELIEF_TRY(chunk.place, spool_.append(component.bytes));
            places.push_back(chunk);
            component.bytes = Bytes();
        }
        return {};
    }

    Status make_chunks(std::vector<CodedStream>& coded,
                       const std::vector<std::vector<SpooledChunk>>& places, Attempt& result) {
        const std::vector<int>& layers = result.coding.layers;
        const ChunkOrder order{layers.size(), coded.size()};
        result.chunks.resize(order.count());
        for (std::size_t layer = 0; layer < layers.size(); ++layer)
            for (std::size_t k = 0; k < coded.size(); ++k) {
                for (std::size_t c = 0; c < coded[k].size(); ++c) {
                    coded[k][c].bytes.resize(static_cast<std::size_t>(places[k][c].info.length));
                    RELIEF_CHECK(spool_.read(places[k][c].place, coded[k][c].bytes));
                }
                RELIEF_TRY(SpooledChunk chunk, spooled(chunk_of(coded[k], layers, layer), spool_));
                result.chunks[order.place(layer, k)] = chunk;
                for (EmbeddedStream& component : coded[k]) component.bytes = Bytes();
            }
        return {};
    }

    [[nodiscard]] std::size_t first_stream_chunk() const { return 1 + masks_.size(); }

    /// Bounds that are empty are not known yet.
    Result<std::shared_ptr<const SpooledFile>> file_of(const Attempt& a,
                                                       const std::vector<double>& layer_errors,
                                                       std::vector<double> level_errors) const {
        RasterHeader header;
        header.description = description_of(source_.description());
        header.components = components();
        header.has_mask = !masks_.empty();
        header.spec = layout_.spec;
        header.goal = options_.goal;
        header.pyramid = a.coding;
        const bool known = !layer_errors.empty();
        header.max_error = known ? a.error.max : kLongNumber;
        header.rms_error = known ? a.error.rms(samples_) : kLongNumber;
        level_errors.resize(static_cast<std::size_t>(layout_.levels()), rounded_up(kLongNumber, 3));
        header.pyramid.bounds = std::move(level_errors);

        std::vector<SpooledChunk> chunks(1);  // no edits
        if (!masks_.empty())
            for (const std::int64_t tile : tree_.hilbert_order(0))
                chunks.push_back(masks_[static_cast<std::size_t>(tile)]);
        chunks.insert(chunks.end(), a.chunks.begin(), a.chunks.end());
        const ChunkOrder order{a.coding.layers.size(), streams_.streams()};
        for (std::size_t layer = 0; layer < layer_errors.size(); ++layer)
            chunks[first_stream_chunk() + order.end_of(layer)].info.bound = layer_errors[layer];
        SpooledChunk corrections;
        if (known) corrections.info.bound = a.error.max;
        chunks.push_back(corrections);
        return SpooledFile::create(write_header(header), std::move(chunks), spool_);
    }

    /// Measures what the file is at every layer and level, and says so in its head.
    Result<EncodeReport> finish(Attempt& best) {
        const Reference against = reference();
        RELIEF_TRY(best.error, measured(against, best.file));
        if (cancelled(0.92)) return cancelled_error();
        std::vector<double> layers;
        const ChunkOrder order{best.coding.layers.size(), streams_.streams()};
        for (std::size_t k = 0; k + 1 < order.layers; ++k) {
            const std::size_t last = first_stream_chunk() + order.end_of(k);
            RELIEF_TRY(const SurfaceError error,
                       measured(against, best.file, best.file->end_of(last)));
            layers.push_back(error.max);
        }
        layers.push_back(best.error.max);
        if (cancelled(0.95)) return cancelled_error();
        RELIEF_TRY(const ContainerReader container, ContainerReader::open(best.file));
        const PyramidBlocks blocks(container, layout_, best.coding, first_stream_chunk());
        RELIEF_TRY(LevelErrors levels, measured_levels(against, layout_, blocks));
        for (double& error : levels.largest) error = rounded_up(error, 3);
        RELIEF_TRY(best.file, file_of(best, layers, levels.largest));
        RELIEF_TRY([[maybe_unused]] const RasterFile opened, RasterFile::open(best.file));
        return report_of(best, levels.coarsest_square);
    }

    [[nodiscard]] EncodeReport report_of(const Attempt& best, double coarsest_square) const {
        EncodeReport report = size_report(source_.description(), best.file->size());
        report.spec = layout_.spec;
        report.coefficients = layout_.coefficients();
        report.kept = best.kept;
        set_errors(report, best.error, samples_, coarsest_square);
        report.bound = best.error.max;
        return report;
    }

    [[nodiscard]] Reference reference() {
        return {source_, cores_, [this] { return cancelled(done_); }};
    }

    bool cancelled(double done) {
        done_ = std::max(done_, done);
        return options_.progress && !options_.progress(done_);
    }

    const RasterSource& source_;
    const EncodeOptions& options_;
    Spool& spool_;
    multires::PyramidLayout layout_;
    StreamLayout streams_;
    TileTree tree_;
    std::vector<Block> blocks_;
    std::vector<LatticeBox> cores_;
    std::int64_t samples_ = 0;         ///< valid ones
    std::vector<SpooledChunk> masks_;  ///< by tile; none: all samples are valid
    Planes<double> scaling_;           ///< values of level kFine
    Grid<std::uint8_t> near_valid_;    ///< which of them have valid samples around them
    Target coarse_target_;
    Pyramid<double> coarse_;     ///< over them
    std::vector<double> means_;  ///< of the scaling band
    double largest_ = 0;         ///< weighted magnitude of a coefficient
    double energy_ = 0;          ///< sum of squares of weighted details
    double done_ = 0;
};

}  // namespace

bool fits_tiles(const Raster& about, int components, const multires::SchemeSpec& spec,
                const Goal& goal) {
    const bool rates = goal.kind == Kind::Bytes || (goal.kind == Kind::RmsError && goal.value > 0);
    if (spec.id != multires::SchemeId::Cubic || spec.exact || !rates) return false;
    const auto layout = multires::layout(spec, about.rows, about.cols, components);
    return layout.ok() && layout->levels() > kFine && TileTree(about.rows, about.cols).tiers() > 1;
}

Result<std::optional<EncodeReport>> encode_tiles(const RasterSource& source,
                                                 const multires::SchemeSpec& spec,
                                                 const EncodeOptions& options, ByteSink& sink,
                                                 Spool& spool) {
    const Raster& about = source.description();
    RELIEF_TRY(multires::PyramidLayout layout,
               multires::layout(spec, about.rows, about.cols, source.components()));
    return TiledEncoder(source, options, spool, std::move(layout)).run(sink);
}

}  // namespace relief::codec
