#pragma once

#include <vector>

#include "relief/codec/container.h"

namespace relief::codec {

/// A chunk on a spool.
struct SpooledChunk {
    std::uint64_t place = 0;
    ChunkInfo info;
};

/// Puts a chunk on a spool. Errors: those of the spool.
[[nodiscard]] Result<SpooledChunk> spooled(std::span<const std::uint8_t> bytes, Spool& spool,
                                           double bound = std::numeric_limits<double>::infinity());

/// A file that is not written yet: its head, and chunks on a spool or elsewhere, which must outlive
/// it.
class SpooledFile final : public ByteSource {
  public:
    SpooledFile() = default;
    /// Errors: as container_head.
    [[nodiscard]] static Result<std::shared_ptr<const SpooledFile>> create(
        const std::string& header, std::vector<SpooledChunk> chunks, const ByteSource& spool);

    [[nodiscard]] std::uint64_t size() const override { return size_; }
    Status read(std::uint64_t offset, std::span<std::uint8_t> into) const override;
    /// Where chunk k ends.
    [[nodiscard]] std::uint64_t end_of(std::size_t k) const;
    Status copy_to(ByteSink& sink) const;

  private:
    Bytes head_;
    std::vector<SpooledChunk> chunks_;  ///< info.offset: in the file
    const ByteSource* spool_ = nullptr;
    std::uint64_t size_ = 0;
};

}  // namespace relief::codec
