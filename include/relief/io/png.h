#pragma once

#include <cstdint>
#include <string>

#include "relief/core/result.h"
#include "relief/core/stream.h"
#include "relief/io/image.h"

/// Pictures as PNG files.
namespace relief::io {

/// A small file, or one that is made several times as fast.
enum class PngEffort : std::uint8_t { Small, Fast };

/// 8-bit RGB or RGBA as the bytes of a file. Errors: InvalidArgument (empty image, wrong channels
/// or pixel count, more than 2^28 pixels).
[[nodiscard]] Result<Bytes> encode_png(const Image& image, PngEffort effort = PngEffort::Small);

/// Writes 8-bit RGB or RGBA; the file appears only when complete.
/// Errors: InvalidArgument (empty image, wrong channels or pixel count), CannotWrite.
[[nodiscard]] Status write_png(const std::string& path, const Image& image);

/// Reads any PNG as 8-bit RGB, or RGBA if it has transparency. Images of more than 2^28 pixels are
/// refused. Errors: NotFound, BadFile.
[[nodiscard]] Result<Image> read_png(const std::string& path);

}  // namespace relief::io
