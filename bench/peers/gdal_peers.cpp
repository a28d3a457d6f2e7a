#include <cpl_string.h>
#include <cpl_vsi.h>
#include <gdal.h>

#include <utility>

#include "peer.h"

namespace relief::peers {

namespace {

/// The name of a file in GDAL's memory, which ends with this.
struct MemoryFile {
    MemoryFile() = default;
    MemoryFile(const MemoryFile&) = delete;
    MemoryFile& operator=(const MemoryFile&) = delete;
    ~MemoryFile() { VSIUnlink(kPath); }

    static constexpr const char* kPath = "/vsimem/peer.tif";
};

struct DatasetClose {
    void operator()(GDALDatasetH dataset) const { GDALClose(dataset); }
};
using Dataset = std::unique_ptr<void, DatasetClose>;

GDALDataType type_of(const Field& field) {
    return field.integer() ? GDT_Int16 : GDT_Float32;
}

/// The samples as a dataset that looks at them where they are.
Dataset wrap(const Field& field) {
    const auto cols = static_cast<int>(field.cols());
    const auto rows = static_cast<int>(field.rows());
    Dataset dataset(
        GDALCreate(GDALGetDriverByName("MEM"), "", cols, rows, 0, type_of(field), nullptr));
    const void* samples =
        std::visit([](const auto& values) -> const void* { return values.data(); }, field.values);
    char address[32] = {};
    address[CPLPrintPointer(address, const_cast<void*>(samples), sizeof address)] = '\0';
    CPLStringList options;
    options.SetNameValue("DATAPOINTER", address);
    if (!dataset || GDALAddBand(dataset.get(), type_of(field), options.List()) != CE_None)
        return nullptr;
    return dataset;
}

Result<Decoded> read(const Bytes& bytes, const Field& about, const LatticeBox& window) {
    const MemoryFile file;
    VSIFCloseL(VSIFileFromMemBuffer(file.kPath, const_cast<GByte*>(bytes.data()), bytes.size(),
                                    FALSE));  // it only reads
    const Dataset dataset(GDALOpen(file.kPath, GA_ReadOnly));
    const auto cols = static_cast<int>(window.cols);
    const auto rows = static_cast<int>(window.rows);
    const auto fill = [&](auto values) -> Result<Decoded> {
        if (!dataset ||
            GDALDatasetRasterIO(dataset.get(), GF_Read, static_cast<int>(window.col0),
                                static_cast<int>(window.row0), cols, rows, values.data(), cols,
                                rows, type_of(about), 1, nullptr, 0, 0, 0) != CE_None)
            return refused(ErrorCode::BadFile, "GDAL reading");
        return Decoded(std::move(values));
    };
    const auto count = static_cast<std::size_t>(window.count());
    return about.integer() ? fill(std::vector<std::int16_t>(count))
                           : fill(std::vector<float>(count));
}

/// A GeoTIFF or COG in memory, in tiles of 512 x 512.
class GeoTiff final : public Peer {
  public:
    GeoTiff(std::string name, const char* driver, std::vector<const char*> options)
        : name_(std::move(name)), driver_(driver), options_(std::move(options)) {}

    [[nodiscard]] std::string name() const override { return name_; }
    [[nodiscard]] bool offers(const Field&, const Goal& goal) const override {
        return goal.kind == Goal::Kind::Lossless;
    }
    [[nodiscard]] bool has_windows() const override { return true; }

    [[nodiscard]] Result<Bytes> encode(const Field& field, const Goal&) const override {
        CPLStringList options;
        for (const char* option : options_) options.AddString(option);
        const bool plain = std::string_view(driver_) == "GTiff";
        if (plain) options.AddString(field.integer() ? "PREDICTOR=2" : "PREDICTOR=3");
        const Dataset from = wrap(field);
        if (!from) return refused(ErrorCode::BadInput, "GDAL's driver MEM");
        const MemoryFile file;
        Dataset copy(GDALCreateCopy(GDALGetDriverByName(driver_), file.kPath, from.get(), FALSE,
                                    options.List(), nullptr, nullptr));
        if (!copy) return refused(ErrorCode::BadInput, "GDAL writing");
        copy.reset();  // writes the rest
        vsi_l_offset size = 0;
        const GByte* data = VSIGetMemFileBuffer(file.kPath, &size, FALSE);
        Bytes bytes(data, data + size);
        return bytes;
    }

    [[nodiscard]] Result<Decoded> decode(const Bytes& bytes, const Field& about,
                                         const Goal&) const override {
        return read(bytes, about, {0, 0, about.raster.rows, about.raster.cols});
    }
    [[nodiscard]] Result<Decoded> decode_window(const Bytes& bytes, const Field& about,
                                                const LatticeBox& window) const override {
        return read(bytes, about, window);
    }

  private:
    std::string name_;
    const char* driver_;
    std::vector<const char*> options_;
};

}  // namespace

Peers gdal_peers() {
    GDALAllRegister();
    Peers all;
    const auto tiff = [&all](const char* name, const char* compression) {
        all.push_back(std::make_unique<GeoTiff>(
            name, "GTiff",
            std::vector{compression, "TILED=YES", "BLOCKXSIZE=512", "BLOCKYSIZE=512"}));
    };
    tiff("DEFLATE", "COMPRESS=DEFLATE");
    tiff("ZSTD", "COMPRESS=ZSTD");
    all.push_back(std::make_unique<GeoTiff>(
        "COG ZSTD", "COG", std::vector{"COMPRESS=ZSTD", "PREDICTOR=YES", "BLOCKSIZE=512"}));
    return all;
}

}  // namespace relief::peers
