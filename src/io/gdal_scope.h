#pragma once

#include <cpl_error.h>

#include <cstdint>
#include <memory>
#include <string>
#include <type_traits>

#include "relief/io/gdal.h"

/// What the raster reader and writer share: GDAL's life time, messages, handles and types.
namespace relief::io::detail {

/// Registers GDAL's drivers and bounds its block cache, once, unless GDAL was left to its program
/// (relief/io/gdal.h). While it lives, GDAL's messages of this thread are kept here, not printed.
class GdalScope {
  public:
    GdalScope();
    GdalScope(const GdalScope&) = delete;
    GdalScope& operator=(const GdalScope&) = delete;
    ~GdalScope();

    [[nodiscard]] bool failed() const { return failed_; }
    /// " (GDAL: the last failure, or else the last warning)", or nothing.
    [[nodiscard]] std::string because() const;

  private:
    static void CPL_STDCALL collect(CPLErr level, CPLErrorNum number, const char* message);

    std::string message_;
    bool failed_ = false;
};

struct CloseDataset {
    void operator()(GDALDatasetH dataset) const { GDALClose(dataset); }
};
using Dataset = std::unique_ptr<std::remove_pointer_t<GDALDatasetH>, CloseDataset>;

/// Room for `bytes`, at most 1 GiB, in GDAL's block cache while it lives. Without it the cache has
/// 64 MiB, or more if the user's GDAL_CACHEMAX says so. Nothing if GDAL was left to its program.
class CacheRoom {
  public:
    explicit CacheRoom(double bytes);
    CacheRoom(const CacheRoom&) = delete;
    CacheRoom& operator=(const CacheRoom&) = delete;
    ~CacheRoom();

  private:
    std::int64_t bytes_;
};

/// Whether `path` names something that only GDAL's virtual file systems know.
[[nodiscard]] bool is_virtual_path(const std::string& path);

/// A GDALProgressFunc; `progress` points at a Progress, which may be empty.
int CPL_STDCALL report_progress(double fraction, const char* message, void* progress);

}  // namespace relief::io::detail
