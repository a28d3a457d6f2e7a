#include "relief/core/version.h"

#define RELIEF_TEXT(number) #number
#define RELIEF_VERSION_TEXT(major, minor, patch) \
    RELIEF_TEXT(major) "." RELIEF_TEXT(minor) "." RELIEF_TEXT(patch)

namespace relief {

const char* library_version() noexcept {
    return RELIEF_VERSION_TEXT(RELIEF_VERSION_MAJOR, RELIEF_VERSION_MINOR, RELIEF_VERSION_PATCH);
}

}  // namespace relief
