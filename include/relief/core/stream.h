#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "relief/core/raster.h"
#include "relief/core/result.h"

/// Where bytes and samples come from and go to, when they need not be in memory as a whole.
namespace relief {

using Bytes = std::vector<std::uint8_t>;

/// Bytes that can be read at any place, by several threads at once.
class ByteSource {
  public:
    ByteSource() = default;
    ByteSource(const ByteSource&) = delete;
    ByteSource& operator=(const ByteSource&) = delete;
    virtual ~ByteSource() = default;

    [[nodiscard]] virtual std::uint64_t size() const = 0;
    /// Fills `into` from `offset` on. Requires: offset + into.size() <= size(). Errors: BadFile.
    virtual Status read(std::uint64_t offset, std::span<std::uint8_t> into) const = 0;
};

/// Bytes in memory.
class MemorySource final : public ByteSource {
  public:
    explicit MemorySource(Bytes bytes) : bytes_(std::move(bytes)) {}
    [[nodiscard]] std::uint64_t size() const override { return bytes_.size(); }
    Status read(std::uint64_t offset, std::span<std::uint8_t> into) const override;

  private:
    Bytes bytes_;
};

/// Takes bytes in order.
class ByteSink {
  public:
    ByteSink() = default;
    ByteSink(const ByteSink&) = delete;
    ByteSink& operator=(const ByteSink&) = delete;
    virtual ~ByteSink() = default;

    /// Errors: CannotWrite.
    virtual Status write(std::span<const std::uint8_t> bytes) = 0;
};

class MemorySink final : public ByteSink {
  public:
    Status write(std::span<const std::uint8_t> bytes) override;
    [[nodiscard]] Bytes take() { return std::move(bytes_); }

  private:
    Bytes bytes_;
};

/// A place for bytes that are needed again before the work is done.
class Spool : public ByteSource {
  public:
    /// Returns where the bytes begin. Not by several threads at once. Errors: CannotWrite.
    [[nodiscard]] virtual Result<std::uint64_t> append(std::span<const std::uint8_t> bytes) = 0;
};

class MemorySpool final : public Spool {
  public:
    [[nodiscard]] std::uint64_t size() const override { return bytes_.size(); }
    Status read(std::uint64_t offset, std::span<std::uint8_t> into) const override;
    [[nodiscard]] Result<std::uint64_t> append(std::span<const std::uint8_t> bytes) override;

  private:
    Bytes bytes_;
};

/// Planes and mask of a window of a raster that is kept elsewhere.
struct RasterView {
    std::int64_t rows = 0;
    std::int64_t cols = 0;
    std::vector<GridView<const double>> planes = {};
    GridView<const std::uint8_t> mask = {};  ///< without data: all valid

    /// Null: all samples of the row are valid.
    [[nodiscard]] const std::uint8_t* valid_row(std::int64_t r) const {
        return mask.data ? mask.row(r) : nullptr;
    }
    [[nodiscard]] bool valid(std::int64_t row, std::int64_t col) const {
        return !mask.data || mask(row, col) != 0;
    }
    [[nodiscard]] std::int64_t valid_count() const;
};
/// Requires: a window inside the raster, which must outlive the view.
[[nodiscard]] RasterView view_of(const Raster& raster, const LatticeBox& window);
[[nodiscard]] RasterView view_of(const Raster& raster);

/// A raster that is read in windows, each perhaps more than once, by several threads.
class RasterSource {
  public:
    RasterSource() = default;
    RasterSource(const RasterSource&) = delete;
    RasterSource& operator=(const RasterSource&) = delete;
    virtual ~RasterSource() = default;

    /// Everything but planes and mask.
    [[nodiscard]] virtual const Raster& description() const = 0;
    [[nodiscard]] virtual int components() const = 0;
    /// Planes and mask of a window inside the raster; the other members are unspecified.
    [[nodiscard]] virtual Result<Raster> read(const LatticeBox& window) const = 0;
    /// The same where it lies, if it is in memory, or else read into `room`, which must outlive the
    /// view.
    [[nodiscard]] virtual Result<RasterView> view(const LatticeBox& window, Raster& room) const;
};

/// A raster in memory, which must outlive the source.
class MemoryRaster final : public RasterSource {
  public:
    explicit MemoryRaster(const Raster& raster);
    [[nodiscard]] const Raster& description() const override { return description_; }
    [[nodiscard]] int components() const override {
        return static_cast<int>(raster_.planes.size());
    }
    [[nodiscard]] Result<Raster> read(const LatticeBox& window) const override;
    [[nodiscard]] Result<RasterView> view(const LatticeBox& window, Raster&) const override {
        return view_of(raster_, window);
    }

  private:
    const Raster& raster_;
    Raster description_;
};

/// Everything of a raster but its planes and mask.
[[nodiscard]] Raster description_of(const Raster& raster);

}  // namespace relief
