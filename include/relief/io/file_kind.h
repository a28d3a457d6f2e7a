#pragma once

#include <cstdint>
#include <string>

namespace relief::io {

enum class FileKind : std::uint8_t { Relief, Raster, Mesh, Points, Unknown };

/// What a file is. First its content: the .relief signature, PLY, OFF, glTF, ASCII STL and ESRI
/// grid headers; then its extension: .obj .off .ply .stl .glb are meshes (.glb is only written),
/// .xyz .csv .txt points; then whether GDAL knows a raster in it. Unknown if it can not be read.
/// Never writes or prints.
[[nodiscard]] FileKind recognise(const std::string& path);

/// Whether a raster is of a format that keeps everything in the file itself. Others can name files
/// and addresses that are then read too.
[[nodiscard]] bool is_self_contained(const std::string& path);

/// Whether a file of this name is to be a mesh: .obj .off .ply .stl .glb.
[[nodiscard]] bool names_mesh(const std::string& path);
/// Whether a file of this name is to hold points: .xyz .csv .txt.
[[nodiscard]] bool names_points(const std::string& path);

}  // namespace relief::io
