#include "relief/io/file_kind.h"

#include <algorithm>
#include <string_view>

#include "io/extension.h"
#include "io/gdal_scope.h"
#include "io/mesh_formats.h"
#include "relief/io/file.h"

namespace relief::io {

namespace {

bool is_one_of(std::string_view text, std::initializer_list<std::string_view> list) {
    return std::find(list.begin(), list.end(), text) != list.end();
}

FileKind by_content(std::string_view head) {
    using namespace std::string_view_literals;
    if (head.starts_with("RELIEF\x89"sv)) return FileKind::Relief;
    const std::string_view first_word = head.substr(0, head.find_first_of(" \t\r\n"sv));
    if (first_word == "ply" || head.starts_with("glTF"sv)) return FileKind::Mesh;
    if (detail::is_off_keyword(first_word)) return FileKind::Mesh;
    const std::string word = detail::lower_case(std::string(first_word));
    if (word == "solid") return FileKind::Mesh;
    // An ESRI grid is often called .txt.
    if (is_one_of(word, {"ncols", "nrows"})) return FileKind::Raster;
    return FileKind::Unknown;
}

/// The driver that would open it; null: none.
GDALDriverH raster_driver(const std::string& path) {
    const detail::GdalScope gdal;
    return GDALIdentifyDriverEx(path.c_str(), GDAL_OF_RASTER, nullptr, nullptr);
}

}  // namespace

bool is_self_contained(const std::string& path) {
    GDALDriverH driver = raster_driver(path);
    return driver && is_one_of(GDALGetDriverShortName(driver),
                               {"GTiff", "PNG", "JPEG", "WEBP", "BMP", "GIF", "JP2OpenJPEG",
                                "AAIGrid", "GRASSASCIIGrid", "SRTMHGT", "netCDF", "GRIB", "DTED",
                                "USGSDEM", "GSAG", "GSBG", "GS7BG", "BT"});
}

bool names_mesh(const std::string& path) {
    return is_one_of(detail::extension_of(path), {".obj", ".off", ".ply", ".stl", ".glb"});
}

bool names_points(const std::string& path) {
    return is_one_of(detail::extension_of(path), {".xyz", ".csv", ".txt"});
}

FileKind recognise(const std::string& path) {
    if (const auto head = read_file(path, 64)) {
        const FileKind kind =
            by_content({reinterpret_cast<const char*>(head->data()), head->size()});
        if (kind != FileKind::Unknown) return kind;
        if (names_mesh(path)) return FileKind::Mesh;
        if (names_points(path)) return FileKind::Points;
    }
    return raster_driver(path) != nullptr ? FileKind::Raster : FileKind::Unknown;
}

}  // namespace relief::io
