#include "dataset.h"

#include <cpl_string.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

#include "band.h"
#include "relief/codec/container.h"
#include "relief/core/parallel.h"
#include "relief/io/file.h"
#include "relief/io/gdal.h"
#include "report.h"

namespace relief::gdal {

namespace {

/// Pixels that are decoded at a time, and that are kept afterwards.
constexpr std::int64_t kPiece = std::int64_t{1} << 24;
constexpr std::int64_t kKept = std::int64_t{1} << 22;
/// Smaller overviews are of no use.
constexpr std::int64_t kSmallestOverview = 16;

constexpr std::string_view kMagic = "RELIEF\x89\r\n\x1a";

/// What a file that is no raster is.
Error other_content(const std::string& content) {
    const auto is = [](const char* what) {
        return Error{ErrorCode::Unsupported,
                     fmt::format("is {}, no raster; 'relief decode' turns it into one", what), ""};
    };
    if (content == "powell-sabin") return is("a spline on triangles");
    const auto is_mesh = [](const char* what) {
        return Error{ErrorCode::Unsupported,
                     fmt::format("is {}, no raster; 'relief decode' turns it into a mesh", what),
                     ""};
    };
    if (content == "quadrangulation") return is_mesh("a spline on quads");
    if (content == "mesh") return is_mesh("a mesh");
    return {ErrorCode::Unsupported, fmt::format("holds '{}', no raster", content), ""};
}

Result<std::shared_ptr<OpenFile>> open_file(const std::string& path) {
    RELIEF_TRY(const auto source, io::open_source(path));
    RELIEF_TRY(const std::string content, codec::content_of(source));
    if (content != "raster") return other_content(content);
    RELIEF_TRY(auto file, codec::RasterFile::open(source));
    return std::make_shared<OpenFile>(std::move(file));
}

/// Where 0 .. count - 1 is cut: nowhere if it has at most `most` lines, else at multiples of tiles
/// beyond `before`. The ends, with 0 and count.
std::vector<std::int64_t> cuts(std::int64_t count, std::int64_t before, std::int64_t most) {
    std::vector<std::int64_t> ends{0};
    const std::int64_t step = std::max<std::int64_t>(1, most / kBlock) * kBlock;
    for (std::int64_t end = step - before; count > most && end < count; end += step)
        ends.push_back(end);
    ends.push_back(count);
    return ends;
}

/// Pieces of a raster, row by row, in front of whose first tiles `before` rows and columns lie.
std::vector<LatticeBox> pieces_of(std::int64_t rows, std::int64_t cols, const LatticeBox& before) {
    const auto across = cuts(cols, before.col0 % kBlock, kPiece / kBlock);
    const auto down = cuts(rows, before.row0 % kBlock, kPiece / std::min(cols, kPiece / kBlock));
    std::vector<LatticeBox> pieces;
    for (std::size_t i = 1; i < down.size(); ++i)
        for (std::size_t j = 1; j < across.size(); ++j)
            pieces.push_back(
                {down[i - 1], across[j - 1], down[i] - down[i - 1], across[j] - across[j - 1]});
    return pieces;
}

template <class T>
void put_as(const double* values, std::int64_t n, void* out) {
    T* to = static_cast<T*>(out);
    for (std::int64_t k = 0; k < n; ++k) to[k] = static_cast<T>(values[k]);
}

/// Requires: values that the type has.
void put_samples(const double* values, std::int64_t n, SampleType type, void* out) {
    switch (type) {
        case SampleType::UInt8:
            return put_as<std::uint8_t>(values, n, out);
        case SampleType::UInt16:
            return put_as<std::uint16_t>(values, n, out);
        case SampleType::Int16:
            return put_as<std::int16_t>(values, n, out);
        case SampleType::UInt32:
            return put_as<std::uint32_t>(values, n, out);
        case SampleType::Int32:
            return put_as<std::int32_t>(values, n, out);
        case SampleType::Float32:
            return put_as<float>(values, n, out);
        case SampleType::Float64:
            return put_as<double>(values, n, out);
    }
}

const char* goal_text(codec::Goal::Kind kind) {
    constexpr std::array<const char*, 5> names = {"KEEP", "RMSE", "MAX_Z_ERROR", "BYTES",
                                                  "LOSSLESS"};
    return names[static_cast<std::size_t>(kind)];
}

/// The domain RELIEF of the metadata.
CPLStringList facts_of(const codec::RasterFile& file) {
    CPLStringList facts;
    const auto set = [&](const std::string& name, const std::string& value) {
        facts.SetNameValue(name.c_str(), value.c_str());
    };
    set("SCHEME", std::string(multires::scheme_name(file.spec().id)));
    set("ORDER", std::to_string(file.spec().order));
    if (file.closed_loop()) set("PROFILE", CPLString(file.profile()).toupper());
    set("GOAL", goal_text(file.goal().kind));
    if (file.goal().kind != codec::Goal::Kind::Lossless)
        set("GOAL_VALUE", fmt::format("{}", file.goal().value));
    set("BYTES", std::to_string(file.size()));
    set("MAX_ERROR", fmt::format("{}", file.max_error()));
    set("RMS_ERROR", fmt::format("{}", file.rms_error()));
    set("EDITS", std::to_string(file.moves().size()));
    set("LEVELS", std::to_string(file.layout().levels()));
    for (int level = 0; level <= file.layout().levels(); ++level) {
        const std::string prefix = fmt::format("LEVEL_{}_", level);
        const LatticeBox box = file.box(level);
        set(prefix + "SIZE", fmt::format("{},{}", box.cols, box.rows));
        set(prefix + "BYTES", std::to_string(file.bytes_for(level)));
        if (const auto bound = file.bound(level)) set(prefix + "BOUND", fmt::format("{}", *bound));
        if (const auto bound = file.surface_bound(level))
            set(prefix + "SURFACE_BOUND", fmt::format("{}", *bound));
    }
    return facts;
}

CPLStringList derived_of(const std::string& path) {
    using codec::Quantity;
    constexpr std::array<std::pair<Quantity, const char*>, 5> quantities = {
        {{Quantity::Slope, "slope in degrees"},
         {Quantity::Aspect, "degrees from north that the slope faces"},
         {Quantity::Hillshade, "shaded relief"},
         {Quantity::Dx, "change per unit of x"},
         {Quantity::Dy, "change per unit of y"}}};
    CPLStringList names;
    int number = 0;
    for (const auto& [quantity, text] : quantities) {
        const std::string prefix = fmt::format("DERIVED_SUBDATASET_{}_", ++number);
        names.SetNameValue(
            (prefix + "NAME").c_str(),
            fmt::format("RELIEF:\"{}\":{}", path, codec::quantity_name(quantity)).c_str());
        names.SetNameValue((prefix + "DESC").c_str(), text);
    }
    return names;
}

}  // namespace

Way way_of(const PixelWindow& window, const Pixels& pixels, GDALRIOResampleAlg resampling) {
    if (!window.unscaled()) {
        const bool between_samples = resampling == GRIORA_NearestNeighbour ||
                                     resampling == GRIORA_Bilinear || resampling == GRIORA_Cubic ||
                                     resampling == GRIORA_CubicSpline ||
                                     resampling == GRIORA_Lanczos;
        return between_samples ? Way::Direct : Way::Gdal;
    }
    const bool large = window.width >= kBlock && window.height >= kBlock;
    if (large || pixels.kept_whole()) return Way::Direct;
    const auto blocks = [](double first, double count, std::int64_t size) {
        const double block = std::min<double>(kBlock, static_cast<double>(size));
        return block * (std::floor((first + count - 1) / block) - std::floor(first / block) + 1);
    };
    const Raster& about = pixels.description();
    const double decoded =
        blocks(window.x, window.width, about.cols) * blocks(window.y, window.height, about.rows);
    return 2 * window.width * window.height >= decoded ? Way::Direct : Way::Blocks;
}

PixelWindow window_of(int x, int y, int width, int height, int cols, int rows,
                      const GDALRasterIOExtraArg& extra) {
    if (extra.bFloatingPointWindowValidity)
        return {extra.dfXOff, extra.dfYOff, extra.dfXSize, extra.dfYSize, cols, rows};
    return {static_cast<double>(x),
            static_cast<double>(y),
            static_cast<double>(width),
            static_cast<double>(height),
            cols,
            rows};
}

void store(const Raster& raster, const LatticeBox& part, const HoleCode& holes,
           const Wanted& wanted, const PixelBuffer& buffer) {
    const bool as_stored = wanted.component != Wanted::kMask &&
                           buffer.type == io::gdal_type(raster.type) &&
                           buffer.pixel_space == GDALGetDataTypeSizeBytes(buffer.type);
    const auto put = [&](const double* values, std::int64_t r) {
        GByte* out = static_cast<GByte*>(wanted.data) + r * buffer.line_space;
        if (as_stored)
            put_samples(values, part.cols, raster.type, out);
        else
            GDALCopyWords64(values, GDT_Float64, sizeof(double), out, buffer.type,
                            static_cast<int>(buffer.pixel_space), part.cols);
    };
    const bool mask = wanted.component == Wanted::kMask;
    const Grid<double>* plane =
        mask ? nullptr : &raster.planes[static_cast<std::size_t>(wanted.component)];
    const double hole = mask ? 0 : holes.nodata.value_or(0);
    parallel_for(0, part.rows, 64, [&](std::int64_t first, std::int64_t last) {
        std::vector<double> row(static_cast<std::size_t>(part.cols));
        for (std::int64_t r = first; r < last; ++r) {
            const double* values = mask ? nullptr : plane->row(part.row0 + r) + part.col0;
            if (mask || !raster.mask.empty()) {
                for (std::int64_t c = 0; c < part.cols; ++c) {
                    const bool valid = raster.valid(part.row0 + r, part.col0 + c);
                    const double value = mask ? 255 : values[c];
                    row[static_cast<std::size_t>(c)] = valid ? value : hole;
                }
                values = row.data();
            }
            put(values, r);
        }
    });
}

Dataset::Dataset(Pixels pixels) : pixels_(std::move(pixels)) {
    const Raster& about = pixels_.description();
    nRasterXSize = static_cast<int>(about.cols);
    nRasterYSize = static_cast<int>(about.rows);
    eAccess = GA_ReadOnly;
    for (int k = 1; k <= pixels_.components(); ++k) SetBand(k, new Band(*this, k));
    if (pixels_.holes().mask_band) mask_ = std::make_unique<MaskBand>(*this);
}

Dataset::~Dataset() {
    FlushCache(true);
}

void Dataset::add_overviews(int level) {
    const codec::RasterFile& file = pixels_.file();
    for (++level; level <= file.layout().levels(); ++level) {
        const LatticeBox box = file.box(level);
        if (std::min(box.rows, box.cols) < kSmallestOverview) return;
        auto pixels = Pixels::create(pixels_.shared_file(), pixels_.quantity(),
                                     file.samples_of_level(level, box));
        if (!pixels.ok()) return;
        Dataset& overview = *overviews_.emplace_back(std::make_unique<Dataset>(*std::move(pixels)));
        overview.SetDescription(GetDescription());
        overview.nPamFlags |= GPF_NOSAVE;
    }
}

void Dataset::describe(const OpenOptions& options) {
    Raster about = description_of(pixels_.description());
    const codec::RasterFile& file = pixels_.file();
    const bool samples = options.quantity == codec::Quantity::Value && !options.resolution;
    codec::note_origin(file, samples ? file.bound(options.level.value_or(0)) : std::nullopt, about);
    CPLStringList metadata;
    for (const auto& [name, value] : about.metadata)
        metadata.SetNameValue(name.c_str(), value.c_str());
    metadata.SetNameValue(GDALMD_AREA_OR_POINT,
                          about.geo.pixel_is_point ? GDALMD_AOP_POINT : GDALMD_AOP_AREA);
    // GDALPamDataset's would note all this as changes to be kept beside the file.
    GDALDataset::SetMetadata(metadata.List());
    GDALDataset::SetMetadata(facts_of(file).List(), "RELIEF");
    CPLStringList structure;
    structure.SetNameValue("COMPRESSION", "RELIEF");
    structure.SetNameValue("COMPRESSION_REVERSIBILITY",
                           file.max_error() == 0 && !file.edited() ? "LOSSLESS" : "LOSSY");
    GDALDataset::SetMetadata(structure.List(), "IMAGE_STRUCTURE");
    if (!options.special()) derived_ = derived_of(options.path);

    if (about.geo.crs.empty()) return;
    CPLPushErrorHandler(CPLQuietErrorHandler);
    const io::SpatialReference reference = io::reference_of(about.geo.crs);
    CPLPopErrorHandler();
    if (reference)
        reference_ = *OGRSpatialReference::FromHandle(reference.get());
    else
        CPLError(CE_Warning, CPLE_AppDefined,
                 "%s: its coordinate reference system is not known here; set it with -a_srs",
                 options.path.c_str());
}

int Dataset::identify(GDALOpenInfo* info) {
    if (names_derived(info->pszFilename)) return TRUE;
    const std::string_view head(reinterpret_cast<const char*>(info->pabyHeader),
                                static_cast<std::size_t>(info->nHeaderBytes));
    return head.starts_with(kMagic) ? TRUE : FALSE;
}

namespace {

Result<Pixels> open_pixels(const OpenOptions& options) {
    RELIEF_TRY(auto file, open_file(options.path));
    RELIEF_TRY(const Sampling places, pixels_of(file->file, options));
    return Pixels::create(std::move(file), options.quantity, places);
}

}  // namespace

GDALDataset* Dataset::open(GDALOpenInfo* info) {
    if (!identify(info)) return nullptr;
    return guarded<GDALDataset*>(nullptr, [&]() -> GDALDataset* {
        if (info->eAccess == GA_Update) {
            CPLError(CE_Failure, CPLE_NotSupported,
                     "%s: .relief files are not written in place; 'relief edit' moves their "
                     "surfaces, gdal_translate -of RELIEF makes new ones",
                     info->pszFilename);
            return nullptr;
        }
        set_threads();
        const auto options = parse_open_options(info->pszFilename, info->papszOpenOptions);
        auto pixels = options.ok() ? open_pixels(*options) : options.error();
        if (!pixels.ok()) {
            report(pixels.error(), options.ok() ? options->path : info->pszFilename);
            return nullptr;
        }
        auto dataset = std::make_unique<Dataset>(*std::move(pixels));
        dataset->describe(*options);
        dataset->SetDescription(info->pszFilename);
        if (!options->resolution) dataset->add_overviews(options->level.value_or(0));
        const bool special = options->special();
        if (special) {
            dataset->SetPhysicalFilename(options->path.c_str());
            dataset->SetSubdatasetName(options->view_name().c_str());
        }
        char** siblings = special ? nullptr : info->GetSiblingFiles();
        dataset->TryLoadXML(siblings);
        dataset->oOvManager.Initialize(dataset.get(), special ? ":::VIRTUAL:::" : info->pszFilename,
                                       siblings);
        return dataset.release();
    });
}

CPLErr Dataset::GetGeoTransform(double* transform) {
    if (GDALPamDataset::GetGeoTransform(transform) == CE_None) return CE_None;
    const auto& own = pixels_.description().geo.transform;
    if (!own) return CE_Failure;
    std::copy(own->begin(), own->end(), transform);
    return CE_None;
}

const OGRSpatialReference* Dataset::GetSpatialRef() const {
    const OGRSpatialReference* kept = GDALPamDataset::GetSpatialRef();
    if (kept) return kept;
    return reference_.IsEmpty() ? nullptr : &reference_;
}

char** Dataset::GetMetadataDomainList() {
    return CSLAddString(GDALPamDataset::GetMetadataDomainList(), "DERIVED_SUBDATASETS");
}

char** Dataset::GetMetadata(const char* domain) {
    if (domain && EQUAL(domain, "DERIVED_SUBDATASETS")) return derived_.List();
    return GDALPamDataset::GetMetadata(domain);
}

CPLErr Dataset::deliver(const PixelWindow& window, const PixelBuffer& buffer,
                        const std::vector<Wanted>& wanted, GDALRasterIOExtraArg* extra) {
    LatticeBox before;
    if (window.unscaled()) {
        const bool finest = pixels_.places().rows.step == 1;
        const codec::LatticeMargin margin =
            finest ? pixels_.file().margin() : codec::LatticeMargin();
        before.row0 = static_cast<std::int64_t>(window.y) + margin.rows;
        before.col0 = static_cast<std::int64_t>(window.x) + margin.cols;
    }
    return guarded(CE_Failure, [&] {
        for (const LatticeBox& piece : pieces_of(window.rows, window.cols, before)) {
            if (deliver_piece(window, piece, buffer, wanted) != CE_None) return CE_Failure;
            const double done =
                static_cast<double>(piece.row0 + piece.rows) / static_cast<double>(window.rows);
            if (!extra || !extra->pfnProgress || extra->pfnProgress(done, "", extra->pProgressData))
                continue;
            CPLError(CE_Failure, CPLE_UserInterrupt, "%s: reading was cancelled", GetDescription());
            return CE_Failure;
        }
        return CE_None;
    });
}

CPLErr Dataset::deliver_piece(const PixelWindow& window, const LatticeBox& piece,
                              const PixelBuffer& buffer, const std::vector<Wanted>& wanted) {
    // Heights between those of samples are no integers.
    SampleType type = pixels_.description().type;
    if (is_integer(type) && GDALDataTypeIsFloating(buffer.type))
        type = buffer.type == GDT_Float32 ? SampleType::Float32 : SampleType::Float64;
    const auto raster = pixels_.read(window.part(piece), type);
    if (!raster.ok()) {
        report(raster.error(), GetDescription());
        return CE_Failure;
    }
    const GSpacing offset = piece.row0 * buffer.line_space + piece.col0 * buffer.pixel_space;
    for (const Wanted& one : wanted)
        store(**raster, {0, 0, piece.rows, piece.cols}, pixels_.holes(),
              {one.component, static_cast<GByte*>(one.data) + offset}, buffer);
    if (piece.count() > kKept) pixels_.forget();
    return CE_None;
}

CPLErr Dataset::IBuildOverviews(const char* resampling, int count, const int* factors,
                                int band_count, const int* bands, GDALProgressFunc progress,
                                void* progress_data, CSLConstList options) {
    overviews_.clear();
    return GDALPamDataset::IBuildOverviews(resampling, count, factors, band_count, bands, progress,
                                           progress_data, options);
}

CPLErr Dataset::IRasterIO(GDALRWFlag flag, int x, int y, int width, int height, void* data,
                          int cols, int rows, GDALDataType type, int count, int* bands,
                          GSpacing pixel_space, GSpacing line_space, GSpacing band_space,
                          GDALRasterIOExtraArg* extra) {
    const PixelWindow window = window_of(x, y, width, height, cols, rows, *extra);
    if (flag != GF_Read || way_of(window, pixels_, extra->eResampleAlg) != Way::Direct)
        return GDALPamDataset::IRasterIO(flag, x, y, width, height, data, cols, rows, type, count,
                                         bands, pixel_space, line_space, band_space, extra);
    std::vector<Wanted> wanted;
    for (int k = 0; k < count; ++k)
        wanted.push_back({bands[k] - 1, static_cast<GByte*>(data) + k * band_space});
    return deliver(window, {type, pixel_space, line_space}, wanted, extra);
}

}  // namespace relief::gdal
