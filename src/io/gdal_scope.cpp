#include "io/gdal_scope.h"

#include <cpl_conv.h>
#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <mutex>
#include <set>

namespace relief::io {

namespace {

std::atomic<bool> g_left_alone{false};

}  // namespace

void leave_gdal_to_its_program() {
    g_left_alone = true;
}

GDALDataType gdal_type(SampleType type) {
    switch (type) {
        case SampleType::UInt8:
            return GDT_Byte;
        case SampleType::UInt16:
            return GDT_UInt16;
        case SampleType::Int16:
            return GDT_Int16;
        case SampleType::UInt32:
            return GDT_UInt32;
        case SampleType::Int32:
            return GDT_Int32;
        case SampleType::Float32:
            return GDT_Float32;
        case SampleType::Float64:
            return GDT_Float64;
    }
    return GDT_Unknown;
}

namespace detail {

namespace {

constexpr std::int64_t kCache = std::int64_t{1} << 26;
constexpr std::int64_t kMostRoom = std::int64_t{1} << 30;

/// The wants of all that need room in the block cache; `least` is always there.
struct CacheDemand {
    std::mutex mutex;
    std::int64_t least = kCache;
    std::multiset<std::int64_t> wants;

    void apply() const {
        if (g_left_alone) return;
        GDALSetCacheMax64(wants.empty() ? least : std::max(least, *wants.rbegin()));
    }
};

CacheDemand& cache_demand() {
    static CacheDemand demand;
    return demand;
}

void prepare_gdal() {
    GDALAllRegister();
    CacheDemand& demand = cache_demand();
    const std::lock_guard lock(demand.mutex);
    if (CPLGetConfigOption("GDAL_CACHEMAX", nullptr))
        demand.least = std::max<std::int64_t>(GDALGetCacheMax64(), kCache);
    demand.apply();
}

}  // namespace

GdalScope::GdalScope() {
    CPLPushErrorHandlerEx(&GdalScope::collect, this);
    static std::once_flag prepared;
    if (!g_left_alone) std::call_once(prepared, prepare_gdal);
}

GdalScope::~GdalScope() {
    CPLPopErrorHandler();
}

std::string GdalScope::because() const {
    return message_.empty() ? "" : fmt::format(" (GDAL: {})", message_);
}

void GdalScope::collect(CPLErr level, CPLErrorNum number, const char* message) {
    if (level == CE_Debug) return CPLDefaultErrorHandler(level, number, message);
    auto* self = static_cast<GdalScope*>(CPLGetErrorHandlerUserData());
    const bool failure = level >= CE_Failure;
    if (failure || !self->failed_) self->message_ = message;
    self->failed_ = self->failed_ || failure;
}

CacheRoom::CacheRoom(double bytes)
    : bytes_(static_cast<std::int64_t>(std::min(bytes, static_cast<double>(kMostRoom)))) {
    CacheDemand& demand = cache_demand();
    const std::lock_guard lock(demand.mutex);
    demand.wants.insert(bytes_);
    demand.apply();
}

CacheRoom::~CacheRoom() {
    CacheDemand& demand = cache_demand();
    const std::lock_guard lock(demand.mutex);
    demand.wants.erase(demand.wants.find(bytes_));
    demand.apply();
}

bool is_virtual_path(const std::string& path) {
    return path.starts_with("/vsi");
}

int CPL_STDCALL report_progress(double fraction, const char* /*message*/, void* progress) {
    const Progress& report = *static_cast<const Progress*>(progress);
    return !report || report(fraction) ? TRUE : FALSE;
}

}  // namespace detail

}  // namespace relief::io
