#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "relief/core/result.h"

/// The .relief file: a JSON header, a directory and chunks, coarse first, so that a prefix of a
/// file is a coarser file. Every byte is specified in docs/format.md.
namespace relief::codec {

/// What a chunk holds. Readers keep chunks of kinds they do not know and leave them alone.
enum class ChunkKind : std::uint16_t {
    Level = 1,       ///< bands of one level of one tile: encode_level
    Mask = 2,        ///< valid samples of one tile: encode_mask
    Correction = 3,  ///< samples that decoding gets wrong, with their values
};

/// One chunk in the directory.
struct ChunkInfo {
    ChunkKind kind = ChunkKind::Level;
    std::uint16_t level = 0;   ///< levels count from 1, the finest, as in multires::BandLayout
    std::uint32_t index = 0;   ///< tile, or whatever the header says
    std::uint64_t offset = 0;  ///< from the start of the file
    std::uint64_t length = 0;
    std::uint64_t checksum = 0;  ///< XXH3-64 of the bytes
    /// Largest error and root mean square error of the surface decoded up to and including this
    /// chunk, in the units of the data; infinite: not known.
    double bound = std::numeric_limits<double>::infinity();
    double rms = std::numeric_limits<double>::infinity();
};

/// The largest header that is read, as JSON text.
inline constexpr std::uint32_t kHeaderLimit = std::uint32_t{16} << 20;

/// Builds a file in memory. Invariant: chunks stand in the order in which they were added.
class ContainerWriter {
  public:
    /// `header`: JSON text, up to kHeaderLimit bytes.
    explicit ContainerWriter(std::string header) : header_(std::move(header)) {}

    /// `info` says kind, level, index, bound and rms; the place and checksum are found here.
    /// Errors: InvalidArgument for a bound or rms that is negative or not a number.
    Status add(const ChunkInfo& info, std::span<const std::uint8_t> bytes);

    /// The file. Errors: InvalidArgument for a header over kHeaderLimit or 2^32 chunks and more.
    /// Complexity: O(bytes).
    [[nodiscard]] Result<std::vector<std::uint8_t>> finish() const;

  private:
    std::string header_;
    std::vector<ChunkInfo> directory_;  ///< offsets from the first chunk
    std::vector<std::uint8_t> chunks_;
};

/// Reads a file or a prefix of one, which must outlive the reader. Invariant: header and directory
/// are verified, and the directory's chunks follow each other without gaps.
class ContainerReader {
  public:
    /// How many bytes of a file open() must see, from its first kPreambleSize bytes or more.
    /// Errors: BadFile for what is not a .relief file, Unsupported for one of a newer version.
    static constexpr std::size_t kPreambleSize = 32;
    [[nodiscard]] static Result<std::uint64_t> directory_end(
        std::span<const std::uint8_t> first_bytes);

    /// `bytes`: the beginning of a file of `file_size` bytes; all of it when the two agree. A file
    /// that is shorter than its directory says opens too: chunks past its end are never complete.
    /// Errors: those of directory_end, and BadFile, which names the byte, for altered or cut off
    /// headers and directories. Allocates no more than the sizes of `bytes` and the header allow.
    /// Complexity: O(directory).
    [[nodiscard]] static Result<ContainerReader> open(std::span<const std::uint8_t> bytes,
                                                      std::uint64_t file_size);

    [[nodiscard]] const std::string& header() const { return header_; }
    [[nodiscard]] const std::vector<ChunkInfo>& chunks() const { return directory_; }
    /// Where the last chunk ends: the size of the whole file.
    [[nodiscard]] std::uint64_t complete_size() const;
    /// All bytes of chunk k are at hand. Chunks stand in order, so are those before it.
    [[nodiscard]] bool complete(std::size_t k) const;
    /// How many chunks are complete.
    [[nodiscard]] std::size_t complete_chunks() const;

    /// The bytes of chunk k. Requires: k < chunks().size().
    /// Errors: BadFile when they are not complete or do not have their checksum.
    [[nodiscard]] Result<std::span<const std::uint8_t>> chunk(std::size_t k) const;
    /// All complete chunks have their checksums. Complexity: O(bytes).
    [[nodiscard]] bool checksums_ok() const;

  private:
    std::span<const std::uint8_t> bytes_;
    std::string header_;
    std::vector<ChunkInfo> directory_;
    std::uint64_t directory_end_ = 0;
};

}  // namespace relief::codec
