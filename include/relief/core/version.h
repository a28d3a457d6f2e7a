#pragma once

/// The version of these headers, by the rules of Semantic Versioning; before 1.0 a new minor
/// version may change any interface. The build reads it here. Files have a version of their own.
#define RELIEF_VERSION_MAJOR 0
#define RELIEF_VERSION_MINOR 1
#define RELIEF_VERSION_PATCH 0

namespace relief {

/// That of the library that is linked, as "0.1.0": with a shared one it may be another patch than
/// that of the headers.
[[nodiscard]] const char* library_version() noexcept;

}  // namespace relief
