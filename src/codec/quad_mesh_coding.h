#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "relief/core/result.h"
#include "relief/core/stream.h"
#include "relief/core/vec2.h"
#include "relief/mesh/coarsen.h"
#include "relief/mesh/quadrangulation.h"

/// The chunks of a file that hold what is not z: docs/format.md, "Quadrangulations".
namespace relief::codec {

/// Digits after the point of all coordinates of an axis; none: they are doubles of any kind.
struct PlaceDigits {
    std::optional<int> x;
    std::optional<int> y;

    [[nodiscard]] static PlaceDigits of(std::span<const Vec2> places);
    /// The place with these digits that is nearest.
    [[nodiscard]] Vec2 rounded(Vec2 place) const;
};

/// Vertices and quads in their order.
struct PlaneMesh {
    std::vector<Vec2> vertices;
    std::vector<std::array<mesh::Index, 4>> quads;
};

[[nodiscard]] Bytes write_mesh(const PlaneMesh& mesh, const PlaceDigits& digits);
/// Errors: BadFile.
[[nodiscard]] Result<PlaneMesh> read_mesh(std::span<const std::uint8_t> bytes,
                                          std::uint64_t vertices, std::uint64_t quads,
                                          const PlaceDigits& digits);

/// The vertices of a level of the hierarchy: those of the base as they were given, others where
/// refinement puts them.
[[nodiscard]] std::vector<Vec2> places_of(const mesh::Quadrangulation& level,
                                          std::span<const Vec2> base, const PlaceDigits& digits);

/// How the finest level of a hierarchy and the mesh that it stands for differ.
struct Numbering {
    std::vector<mesh::Index> vertices;  ///< of each vertex of the hierarchy, its number in the mesh
    std::vector<mesh::TurnedQuad> quads;  ///< of each quad of the hierarchy
    std::vector<Vec2> places;             ///< of the vertices of the hierarchy, as in the mesh
};

/// Empty if `numbering` says nothing: same numbers, and places as `expected`.
[[nodiscard]] Bytes write_numbering(const Numbering& numbering, std::span<const Vec2> expected);
/// Errors: BadFile, also for numbers that do not occur once each.
[[nodiscard]] Result<Numbering> read_numbering(std::span<const std::uint8_t> bytes,
                                               std::span<const Vec2> expected, std::size_t quads);

}  // namespace relief::codec
