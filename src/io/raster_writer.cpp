#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "io/raster_output.h"

namespace relief::io {

namespace {

using detail::HoleCode;

/// How holes are marked when nothing is known about the samples.
HoleCode hole_code(const Raster& description, Holes holes) {
    if (description.nodata && detail::in_type(*description.nodata, description.type))
        return {.nodata = description.nodata};
    if (holes == Holes::None) return {};
    if (is_integer(description.type)) return {.mask_band = true};
    return {.nodata = std::numeric_limits<double>::quiet_NaN()};
}

Error wrong(std::string message, const std::string& path) {
    return {ErrorCode::InvalidArgument, std::move(message), path};
}

}  // namespace

/// Rows below `next` are taken, by `tiff` or else into `raster`.
struct RasterWriter::State {
    std::string path;
    WriteOptions options;
    Raster raster;  ///< the description, and the samples of formats that are written at once
    std::size_t components = 1;
    bool takes_holes = false;
    std::optional<detail::TiffOutput> tiff = {};
    std::int64_t next = 0;

    void prepare_samples();
    [[nodiscard]] Status check(std::int64_t first_row, const Raster& strip) const;
    void collect(const Raster& strip);
};

void RasterWriter::State::prepare_samples() {
    for (std::size_t k = 0; k < components; ++k)
        raster.planes.emplace_back(raster.rows, raster.cols);
    raster.mask = Grid<std::uint8_t>(raster.rows, raster.cols);
}

Status RasterWriter::State::check(std::int64_t first_row, const Raster& strip) const {
    if (first_row != next)
        return wrong(fmt::format("strips go from top to bottom: row {} comes next, not row {}",
                                 next, first_row),
                     path);
    if (strip.cols != raster.cols || strip.planes.size() != components)
        return wrong(fmt::format("a strip has {} columns and {} planes here, not {} and {}",
                                 raster.cols, components, strip.cols, strip.planes.size()),
                     path);
    if (strip.rows < 1 || strip.rows > raster.rows - next)
        return wrong(fmt::format("{} rows do not fit: {} are left of {}", strip.rows,
                                 raster.rows - next, raster.rows),
                     path);
    RELIEF_CHECK(detail::check_samples(strip, path));
    if (takes_holes) return {};
    const auto row = detail::row_with_hole(strip);
    if (!row) return {};
    return wrong(fmt::format("row {} has a hole; say when creating the file that holes are "
                             "possible, or give a nodata value",
                             first_row + *row),
                 path);
}

void RasterWriter::State::collect(const Raster& strip) {
    for (std::int64_t r = 0; r < strip.rows; ++r) {
        for (std::size_t k = 0; k < components; ++k)
            std::copy_n(strip.planes[k].row(r), strip.cols, raster.planes[k].row(next + r));
        std::uint8_t* mask = raster.mask.row(next + r);
        if (strip.mask.empty())
            std::fill_n(mask, strip.cols, std::uint8_t{1});
        else
            std::copy_n(strip.mask.row(r), strip.cols, mask);
    }
}

RasterWriter::RasterWriter(std::unique_ptr<State> state) : state_(std::move(state)) {}
RasterWriter::RasterWriter(RasterWriter&& other) noexcept = default;
RasterWriter::~RasterWriter() = default;

Result<RasterWriter> RasterWriter::create(const std::string& path, const Raster& description,
                                          int components, Holes holes,
                                          const WriteOptions& options) {
    const detail::GdalScope gdal;
    const auto planes = static_cast<std::size_t>(std::max(components, 0));
    RELIEF_CHECK(detail::check_description(description, planes, path));
    RELIEF_TRY(GDALDriverH driver, detail::choose_driver(path, options));
    auto state = std::make_unique<State>();
    state->path = path;
    state->options = options;
    state->raster = description_of(description);
    state->components = planes;
    if (detail::is_geotiff(driver)) {
        const HoleCode code = hole_code(description, holes);
        RELIEF_TRY(detail::TiffOutput tiff,
                   detail::TiffOutput::create(path, description, planes, code, options));
        state->tiff.emplace(std::move(tiff));
        state->takes_holes = code.nodata || code.mask_band;
    } else {
        // What can not appear is refused before the work. Virtual files have no directory to try.
        if (!detail::is_virtual_path(path)) RELIEF_CHECK(StagedOutput::beside(path));
        state->prepare_samples();
        state->takes_holes = holes == Holes::Possible || description.nodata;
    }
    return RasterWriter(std::move(state));
}

Status RasterWriter::write(std::int64_t first_row, const Raster& strip) {
    State& state = *state_;
    RELIEF_CHECK(state.check(first_row, strip));
    if (state.tiff) {
        RELIEF_CHECK(state.tiff->write(strip, 0, strip.rows));
    } else {
        state.collect(strip);
    }
    state.next += strip.rows;
    const double fraction =
        static_cast<double>(state.next) / static_cast<double>(state.raster.rows);
    if (state.tiff && state.options.progress && !state.options.progress(fraction))
        return Error{ErrorCode::Cancelled, "writing was cancelled", state.path};
    return {};
}

Status RasterWriter::commit() {
    State& state = *state_;
    if (state.next < state.raster.rows)
        return wrong(fmt::format("only {} of {} rows are written", state.next, state.raster.rows),
                     state.path);
    if (state.tiff) return state.tiff->commit();
    return write_raster(state.path, state.raster, state.options);
}

}  // namespace relief::io
