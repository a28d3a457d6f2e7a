#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "relief/mesh/closest.h"
#include "relief/remesh/surface.h"

namespace relief::remesh {

/// Triangles whose vertices lie on a surface and move along it.
struct MovingMesh {
    const Surface* surface = nullptr;
    std::vector<mesh::Index> corners;  ///< three a face
    std::vector<Place> places;         ///< [vertex]
    std::vector<Vec3<double>> points;  ///< at the places
    std::vector<Vec3<double>> normals;
    std::vector<std::uint8_t> fixed;  ///< [vertex]: 1: it does not move
    /// The corners at each vertex v: of_vertex[first[v]] .. of_vertex[first[v + 1] - 1].
    std::vector<mesh::Index> first;
    std::vector<mesh::Index> of_vertex;

    MovingMesh(const Surface& on, std::span<const mesh::Index> faces, std::vector<Place> at);

    [[nodiscard]] std::size_t face_count() const { return corners.size() / 3; }
    [[nodiscard]] std::span<const mesh::Index> corners_at(mesh::Index v) const {
        return std::span(of_vertex).subspan(first[v], first[v + 1] - first[v]);
    }
    void put(mesh::Index v, const Place& place);

    /// How well a face lies on the surface: its quality, 1 if equilateral, and negative if its
    /// normal is opposed to those of the surface at its corners.
    [[nodiscard]] double fit(mesh::Index face) const;
    [[nodiscard]] bool flipped(mesh::Index face) const { return !(fit(face) > 0); }
    [[nodiscard]] std::vector<mesh::Index> flips() const;
    /// Of the faces at a vertex.
    [[nodiscard]] double worst_fit(mesh::Index v) const;
    /// The vertices of faces, followed by those next to them.
    [[nodiscard]] std::vector<mesh::Index> around(std::span<const mesh::Index> faces) const;

    /// Moves all vertices that are not fixed; vertices of faces that would be flipped and are not
    /// now stay, until there are none. Complexity: O(n).
    void move(const std::vector<Vec3<double>>& steps);

    /// Moves vertices around flipped faces to where the worst face at each is better. Complexity:
    /// O(n + flips).
    void untangle();

    /// The mean length of edges at each vertex.
    [[nodiscard]] std::vector<double> edge_lengths() const;
    [[nodiscard]] std::vector<mesh::FanTriangle> triangles() const;
};

}  // namespace relief::remesh
