#pragma once

#include <cpl_error.h>

#include <exception>
#include <new>
#include <string>

#include "relief/core/result.h"

/// Relief's errors as GDAL's.
namespace relief::gdal {

/// The error, about the file of this name, as a GDAL failure.
void report(const Error& error, const std::string& name);
void report(const std::exception& thrown);

/// What `work` returns, or `failed` if it throws: GDAL's callers know no exceptions.
template <class T, class Work>
T guarded(T failed, Work work) {
    try {
        return work();
    } catch (const std::exception& thrown) {
        report(thrown);
    }
    return failed;
}

}  // namespace relief::gdal
