#pragma once

#include <memory>
#include <string>

#include "relief/core/stream.h"

/// Files in GDAL's virtual file systems: /vsicurl/, /vsizip/, /vsimem/ and the like.
namespace relief::io::detail {

/// Errors: NotFound; reading: BadFile.
[[nodiscard]] Result<std::shared_ptr<const ByteSource>> open_virtual_source(
    const std::string& path);

/// A file that is written in place, there being no general way to rename one; without a commit it
/// is removed.
class VirtualOutput final : public ByteSink {
  public:
    /// Errors: CannotWrite.
    [[nodiscard]] static Result<std::unique_ptr<VirtualOutput>> create(const std::string& path);
    VirtualOutput(std::string path, void* file) : path_(std::move(path)), file_(file) {}
    ~VirtualOutput() override;

    Status write(std::span<const std::uint8_t> bytes) override;
    Status commit();

  private:
    [[nodiscard]] Error cannot_write(const std::string& because) const;

    std::string path_;
    void* file_;  ///< a VSILFILE; null once committed
};

}  // namespace relief::io::detail
