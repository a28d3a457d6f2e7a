#include "io/virtual_file.h"

#include <cpl_vsi_virtual.h>
#include <fmt/format.h>

#include <mutex>
#include <utility>

#include "io/gdal_scope.h"

namespace relief::io::detail {

namespace {

struct CloseFile {
    void operator()(VSIVirtualHandle* file) const {
        const GdalScope quiet;
        VSIFCloseL(reinterpret_cast<VSILFILE*>(file));
    }
};
using File = std::unique_ptr<VSIVirtualHandle, CloseFile>;

class VirtualSource final : public ByteSource {
  public:
    VirtualSource(std::string path, File file, std::uint64_t size)
        : path_(std::move(path)), file_(std::move(file)), size_(size) {}

    [[nodiscard]] std::uint64_t size() const override { return size_; }

    Status read(std::uint64_t offset, std::span<std::uint8_t> into) const override {
        const GdalScope gdal;
        if (read_at(offset, into) == into.size()) return {};
        return Error{ErrorCode::BadFile,
                     fmt::format("can not read {} bytes from byte {} on{}", into.size(), offset,
                                 gdal.because()),
                     path_};
    }

  private:
    /// GDAL keeps what it fetches in order, in pieces of 16 KiB, so that small reads share them.
    /// Large ones are fetched beside each other.
    [[nodiscard]] std::size_t read_at(std::uint64_t offset, std::span<std::uint8_t> into) const {
        constexpr std::size_t piece = 16384;
        if (into.size() > piece && file_->HasPRead())
            return file_->PRead(into.data(), into.size(), offset);
        const std::lock_guard lock(mutex_);
        if (file_->Seek(offset, SEEK_SET) != 0) return 0;
        return file_->Read(into.data(), 1, into.size());
    }

    std::string path_;
    File file_;
    std::uint64_t size_;
    mutable std::mutex mutex_;  ///< of the place in the file
};

}  // namespace

Result<std::shared_ptr<const ByteSource>> open_virtual_source(const std::string& path) {
    const GdalScope gdal;
    File file(reinterpret_cast<VSIVirtualHandle*>(VSIFOpenExL(path.c_str(), "rb", TRUE)));
    if (!file || file->Seek(0, SEEK_END) != 0)
        return Error{ErrorCode::NotFound, "can not read" + gdal.because(), path};
    const std::uint64_t size = file->Tell();
    return std::shared_ptr<const ByteSource>(
        std::make_shared<VirtualSource>(path, std::move(file), size));
}

Error VirtualOutput::cannot_write(const std::string& because) const {
    return {ErrorCode::CannotWrite, "can not write" + because, path_};
}

Result<std::unique_ptr<VirtualOutput>> VirtualOutput::create(const std::string& path) {
    const GdalScope gdal;
    VSILFILE* file = VSIFOpenExL(path.c_str(), "wb", TRUE);
    if (!file) return Error{ErrorCode::CannotWrite, "can not write" + gdal.because(), path};
    return std::make_unique<VirtualOutput>(path, file);
}

VirtualOutput::~VirtualOutput() {
    if (!file_) return;
    const GdalScope quiet;
    VSIFCloseL(static_cast<VSILFILE*>(file_));
    VSIUnlink(path_.c_str());
}

Status VirtualOutput::write(std::span<const std::uint8_t> bytes) {
    const GdalScope gdal;
    if (VSIFWriteL(bytes.data(), 1, bytes.size(), static_cast<VSILFILE*>(file_)) == bytes.size())
        return {};
    return cannot_write(gdal.because());
}

Status VirtualOutput::commit() {
    const GdalScope gdal;
    if (VSIFCloseL(static_cast<VSILFILE*>(std::exchange(file_, nullptr))) == 0) return {};
    VSIUnlink(path_.c_str());
    return cannot_write(gdal.because());
}

}  // namespace relief::io::detail
