#include "report.h"

namespace relief::gdal {

namespace {

CPLErrorNum number_of(ErrorCode code) {
    switch (code) {
        case ErrorCode::InvalidArgument:
            return CPLE_IllegalArg;
        case ErrorCode::NotFound:
            return CPLE_OpenFailed;
        case ErrorCode::CannotWrite:
            return CPLE_FileIO;
        case ErrorCode::Unsupported:
            return CPLE_NotSupported;
        case ErrorCode::Cancelled:
            return CPLE_UserInterrupt;
        case ErrorCode::BadInput:
        case ErrorCode::BadFile:
            break;
    }
    return CPLE_AppDefined;
}

}  // namespace

void report(const Error& error, const std::string& name) {
    const std::string text = error.text();
    const std::string about = text.find(name) == std::string::npos ? name + ": " + text : text;
    CPLError(CE_Failure, number_of(error.code), "%s", about.c_str());
}

void report(const std::exception& thrown) {
    if (dynamic_cast<const std::bad_alloc*>(&thrown))
        CPLError(CE_Failure, CPLE_OutOfMemory, "RELIEF: not enough memory; read smaller windows");
    else
        CPLError(CE_Failure, CPLE_AppDefined, "RELIEF: %s", thrown.what());
}

}  // namespace relief::gdal
