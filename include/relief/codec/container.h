#pragma once

#include <atomic>
#include <cstdint>
#include <limits>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "relief/core/result.h"
#include "relief/core/stream.h"

/// The .relief file: a JSON header, a directory and chunks, coarse first, so that a prefix of a
/// file is a coarser file. What the k-th chunk is follows from the header. Every byte is specified
/// in docs/format.md.
namespace relief::codec {

/// One chunk in the directory.
struct ChunkInfo {
    std::uint64_t offset = 0;    ///< from the start of the file
    std::uint64_t length = 0;    ///< 0: the chunk has nothing to say
    std::uint32_t checksum = 0;  ///< lower half of the XXH3-64 of the bytes
    /// Largest error of the surface decoded up to and including this chunk, in the units of the
    /// data; infinite: not known. The file keeps 8 leading bits, rounded up.
    double bound = std::numeric_limits<double>::infinity();
};

/// The version that is written.
inline constexpr std::uint16_t kContainerVersion = 1;

/// The largest header that is read, as JSON text.
inline constexpr std::uint32_t kHeaderLimit = std::uint32_t{16} << 20;

/// The lower half of the XXH3-64 of some bytes.
[[nodiscard]] std::uint32_t chunk_checksum(std::span<const std::uint8_t> bytes);

/// The beginning of a file: all that stands before its first chunk. Of the chunks, length,
/// checksum and bound count. Errors: InvalidArgument for a header over kHeaderLimit, more than 2^40
/// chunks, or a bound that is negative or not a number. Complexity: O(chunks).
[[nodiscard]] Result<Bytes> container_head(const std::string& header,
                                           const std::vector<ChunkInfo>& chunks);

/// Builds a file in memory. Invariant: chunks stand in the order in which they were added.
class ContainerWriter {
  public:
    void add(std::span<const std::uint8_t> bytes,
             double bound = std::numeric_limits<double>::infinity());
    /// The file. `header`: JSON text. Errors: as container_head.
    [[nodiscard]] Result<Bytes> finish(const std::string& header) const;

  private:
    std::vector<ChunkInfo> directory_;
    Bytes chunks_;
};

/// Reads a file or a prefix of one. Invariant: header and directory are verified.
class ContainerReader {
  public:
    /// What stands before the header has so many bytes at most.
    static constexpr std::size_t kLargestPreamble = 32;

    /// Sees the first `visible` bytes of the source. A file that is shorter than its directory says
    /// opens too: chunks past its end are never complete. Errors: BadFile for what is not a .relief
    /// file and, naming the byte, for altered or cut off headers and directories; Unsupported for
    /// one of another version. Allocates no more than the sizes of the source and the header allow.
    /// Complexity: O(directory).
    [[nodiscard]] static Result<ContainerReader> open(
        std::shared_ptr<const ByteSource> source,
        std::uint64_t visible = std::numeric_limits<std::uint64_t>::max());

    /// A file in memory.
    [[nodiscard]] static Result<ContainerReader> open(Bytes bytes) {
        return open(std::make_shared<MemorySource>(std::move(bytes)));
    }

    [[nodiscard]] const std::string& header() const { return header_; }
    [[nodiscard]] const std::vector<ChunkInfo>& chunks() const { return directory_; }
    /// Where the first chunk begins.
    [[nodiscard]] std::uint64_t head_size() const { return head_size_; }
    /// Where the last chunk ends: the size of the whole file.
    [[nodiscard]] std::uint64_t complete_size() const;
    /// Bytes that are there to be read.
    [[nodiscard]] std::uint64_t visible_size() const { return visible_; }
    /// Bytes that were read from the source so far, the head included.
    [[nodiscard]] std::uint64_t bytes_read() const { return *read_; }
    /// All bytes of chunk k are at hand. Chunks stand in order, so are those before it.
    [[nodiscard]] bool complete(std::size_t k) const;
    /// How many chunks are complete.
    [[nodiscard]] std::size_t complete_chunks() const;

    /// The bytes of chunk k, by several threads at once. Requires: k < chunks().size(). Errors:
    /// BadFile when they are not complete or do not have their checksum.
    [[nodiscard]] Result<Bytes> chunk(std::size_t k) const;
    /// All complete chunks have their checksums. Complexity: O(bytes).
    [[nodiscard]] bool checksums_ok() const;

  private:
    std::shared_ptr<const ByteSource> source_;
    std::uint64_t visible_ = 0;
    std::uint64_t head_size_ = 0;
    std::string header_;
    std::vector<ChunkInfo> directory_;
    /// Shared, because readers move and count in const functions.
    std::shared_ptr<std::atomic<std::uint64_t>> read_ =
        std::make_shared<std::atomic<std::uint64_t>>(0);
};

/// What a file is a file of: "raster", "quadrangulation", "mesh" or "powell-sabin". Errors: as
/// ContainerReader::open; BadFile for a header that does not say.
[[nodiscard]] Result<std::string> content_of(std::shared_ptr<const ByteSource> source);

}  // namespace relief::codec
