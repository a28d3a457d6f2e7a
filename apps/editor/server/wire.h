#pragma once

#include <cstdint>

#include "relief/core/stream.h"
#include "relief/edit/geometry.h"

/// Geometry as the page reads it. Source: docs/protocol.md, "Binary messages".
namespace relief::editor {

/// What a message answers (0: nothing that was asked), and of which state of the surface it is.
struct Stamp {
    std::uint64_t id = 0;
    std::uint64_t revision = 0;
};

[[nodiscard]] Bytes surface_message(const edit::SurfaceGeometry& surface, const Stamp& stamp);
[[nodiscard]] Bytes surface_patch(const edit::SurfacePatch& patch, const Stamp& stamp);
/// A whole tile. Requires: `rect` is all of it.
[[nodiscard]] Bytes tile_message(const edit::TileGeometry& tile, const Stamp& stamp);
[[nodiscard]] Bytes tile_patch(const edit::TileGeometry& part, const Stamp& stamp);
[[nodiscard]] Bytes net_message(const edit::NetGeometry& net, const Stamp& stamp);
[[nodiscard]] Bytes net_patch(const edit::NetGeometry& part, const Stamp& stamp);

}  // namespace relief::editor
