#include "io/gdal_scope.h"

#include <cpl_conv.h>
#include <fmt/format.h>

#include <algorithm>
#include <mutex>

namespace relief::io::detail {

namespace {

void prepare_gdal() {
    GDALAllRegister();
    constexpr GIntBig enough = GIntBig{1} << 26;
    const bool chosen = CPLGetConfigOption("GDAL_CACHEMAX", nullptr) != nullptr;
    GDALSetCacheMax64(chosen ? std::max(GDALGetCacheMax64(), enough) : enough);
}

}  // namespace

GdalScope::GdalScope() {
    CPLPushErrorHandlerEx(&GdalScope::collect, this);
    static std::once_flag prepared;
    std::call_once(prepared, prepare_gdal);
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

void reserve_block_cache(double bytes) {
    static std::mutex mutex;
    const auto wanted = static_cast<GIntBig>(std::min(bytes, 0x1p30));
    const std::lock_guard lock(mutex);
    if (wanted > GDALGetCacheMax64()) GDALSetCacheMax64(wanted);
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

bool is_virtual_path(const std::string& path) {
    return path.starts_with("/vsi");
}

int CPL_STDCALL report_progress(double fraction, const char* /*message*/, void* progress) {
    const Progress& report = *static_cast<const Progress*>(progress);
    return !report || report(fraction) ? TRUE : FALSE;
}

}  // namespace relief::io::detail
