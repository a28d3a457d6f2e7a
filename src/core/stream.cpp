#include "relief/core/stream.h"

#include <algorithm>
#include <cstring>
#include <string>

namespace relief {

namespace {

Status copy_out(const Bytes& bytes, std::uint64_t offset, std::span<std::uint8_t> into) {
    if (offset > bytes.size() || into.size() > bytes.size() - offset)
        return Error{ErrorCode::BadFile, "ends where more bytes were expected",
                     "byte " + std::to_string(bytes.size())};
    if (!into.empty()) std::memcpy(into.data(), bytes.data() + offset, into.size());
    return {};
}

}  // namespace

Status MemorySource::read(std::uint64_t offset, std::span<std::uint8_t> into) const {
    return copy_out(bytes_, offset, into);
}

Status MemorySink::write(std::span<const std::uint8_t> bytes) {
    bytes_.insert(bytes_.end(), bytes.begin(), bytes.end());
    return {};
}

Status MemorySpool::read(std::uint64_t offset, std::span<std::uint8_t> into) const {
    return copy_out(bytes_, offset, into);
}

Result<std::uint64_t> MemorySpool::append(std::span<const std::uint8_t> bytes) {
    const std::uint64_t offset = bytes_.size();
    bytes_.insert(bytes_.end(), bytes.begin(), bytes.end());
    return offset;
}

Raster description_of(const Raster& raster) {
    Raster description;
    description.rows = raster.rows;
    description.cols = raster.cols;
    description.type = raster.type;
    description.nodata = raster.nodata;
    description.geo = raster.geo;
    description.unit = raster.unit;
    description.scale = raster.scale;
    description.offset = raster.offset;
    description.band_names = raster.band_names;
    description.metadata = raster.metadata;
    return description;
}

std::int64_t RasterView::valid_count() const {
    if (!mask.data) return rows * cols;
    std::int64_t count = rows * cols;
    for (std::int64_t r = 0; r < rows; ++r)
        count -= std::count(mask.row(r), mask.row(r) + cols, std::uint8_t{0});
    return count;
}

RasterView view_of(const Raster& raster, const LatticeBox& window) {
    const auto part = [&]<class T>(const Grid<T>& grid) {
        return GridView<const T>(grid.row(window.row0) + window.col0, window.rows, window.cols,
                                 grid.stride());
    };
    RasterView view{.rows = window.rows, .cols = window.cols};
    for (const Grid<double>& plane : raster.planes) view.planes.push_back(part(plane));
    if (!raster.mask.empty()) view.mask = part(raster.mask);
    return view;
}

RasterView view_of(const Raster& raster) {
    return view_of(raster, {0, 0, raster.rows, raster.cols});
}

Result<RasterView> RasterSource::view(const LatticeBox& window, Raster& room) const {
    RELIEF_TRY(room, read(window));
    return view_of(room, {0, 0, window.rows, window.cols});
}

MemoryRaster::MemoryRaster(const Raster& raster)
    : raster_(raster), description_(description_of(raster)) {}

Result<Raster> MemoryRaster::read(const LatticeBox& window) const {
    Raster part;
    part.rows = window.rows;
    part.cols = window.cols;
    for (const Grid<double>& plane : raster_.planes) {
        Grid<double> cut(window.rows, window.cols);
        for (std::int64_t r = 0; r < window.rows; ++r)
            std::copy_n(plane.row(window.row0 + r) + window.col0, window.cols, cut.row(r));
        part.planes.push_back(std::move(cut));
    }
    if (raster_.mask.empty()) return part;
    part.mask = Grid<std::uint8_t>(window.rows, window.cols);
    for (std::int64_t r = 0; r < window.rows; ++r)
        std::copy_n(raster_.mask.row(window.row0 + r) + window.col0, window.cols, part.mask.row(r));
    return part;
}

}  // namespace relief
