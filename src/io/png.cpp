#include "relief/io/png.h"

#include <fmt/format.h>
#include <png.h>

#include "relief/io/file.h"

namespace relief::io {

namespace {

constexpr std::uint64_t kMaxPixels = std::uint64_t{1} << 28;

/// libpng's simplified interface: it keeps its jumps to itself and reports errors in the struct.
struct PngImage : png_image {
    PngImage() : png_image{} { version = PNG_IMAGE_VERSION; }
    PngImage(const PngImage&) = delete;
    PngImage& operator=(const PngImage&) = delete;
    ~PngImage() { png_image_free(this); }
};

}  // namespace

Result<Bytes> encode_png(const Image& image, PngEffort effort) {
    const bool channels_ok = image.channels == 3 || image.channels == 4;
    if (image.width < 1 || image.height < 1 || !channels_ok ||
        static_cast<std::uint64_t>(image.width) * static_cast<std::uint64_t>(image.height) >
            kMaxPixels)
        return Error{
            ErrorCode::InvalidArgument,
            fmt::format("an image of {} x {} pixels with {} channels can not be written as PNG; "
                        "use 3 or 4 channels and at most 2^28 pixels",
                        image.width, image.height, image.channels),
            ""};
    PngImage png;
    png.width = static_cast<png_uint_32>(image.width);
    png.height = static_cast<png_uint_32>(image.height);
    png.format = image.channels == 4 ? PNG_FORMAT_RGBA : PNG_FORMAT_RGB;
    if (effort == PngEffort::Fast) png.flags |= PNG_IMAGE_FLAG_FAST;
    if (image.pixels.size() != PNG_IMAGE_SIZE(png))
        return Error{ErrorCode::InvalidArgument, "the image has fewer or more bytes than pixels",
                     ""};

    Bytes bytes(PNG_IMAGE_PNG_SIZE_MAX(png));
    png_alloc_size_t size = bytes.size();
    if (!png_image_write_to_memory(&png, bytes.data(), &size, 0, image.pixels.data(), 0, nullptr))
        return Error{ErrorCode::CannotWrite, fmt::format("PNG: {}", png.message), ""};
    bytes.resize(size);
    return bytes;
}

Status write_png(const std::string& path, const Image& image) {
    const auto bytes = encode_png(image);
    if (!bytes.ok()) return Error{bytes.error().code, bytes.error().message, path};
    return write_file_atomically(path, *bytes);
}

Result<Image> read_png(const std::string& path) {
    RELIEF_TRY(const std::vector<std::uint8_t> bytes, read_file(path));
    const auto bad = [&](const std::string& message) {
        return Error{ErrorCode::BadFile, fmt::format("not a readable PNG: {}", message), path};
    };
    PngImage png;
    if (!png_image_begin_read_from_memory(&png, bytes.data(), bytes.size()))
        return bad(png.message);
    if (std::uint64_t{png.width} * png.height > kMaxPixels) return bad("more than 2^28 pixels");
    const int channels = (png.format & PNG_FORMAT_FLAG_ALPHA) != 0 ? 4 : 3;
    png.format = channels == 4 ? PNG_FORMAT_RGBA : PNG_FORMAT_RGB;
    Image image(static_cast<int>(png.width), static_cast<int>(png.height), channels);
    if (!png_image_finish_read(&png, nullptr, image.pixels.data(), 0, nullptr))
        return bad(png.message);
    return image;
}

}  // namespace relief::io
