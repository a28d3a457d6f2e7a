#pragma once

#include <cstdint>

#include "edit/cell_mesh.h"

namespace relief::edit {

/// How the cells of a mesh are cut into triangles for the screen: each side into `cuts` equal
/// parts. Points are the mesh's vertices, then cuts - 1 on each edge, from its first end, then
/// those inside each cell, row by row.
class CellGrid {
  public:
    /// As many cuts as give at most 300 000 triangles, from 1 to 32. The mesh must outlive the
    /// grid and keep its address.
    explicit CellGrid(const CellMesh& mesh);

    [[nodiscard]] const CellMesh& mesh() const { return *mesh_; }
    [[nodiscard]] std::size_t cuts() const { return cuts_; }
    /// Points on an edge, and inside a cell.
    [[nodiscard]] std::size_t edge_points() const { return cuts_ - 1; }
    [[nodiscard]] std::size_t cell_points() const { return inner_.size(); }
    [[nodiscard]] std::uint32_t edge_point(mesh::Index e, std::size_t k) const {
        return static_cast<std::uint32_t>(mesh_->vertices.size() + edge_points() * e + k);
    }
    [[nodiscard]] std::uint32_t cell_point(mesh::Index c, std::size_t k) const {
        return static_cast<std::uint32_t>(
            mesh_->vertices.size() + edge_points() * mesh_->edges.size() + cell_points() * c + k);
    }

    /// Where point k of an edge lies, as the part of the way from its first end.
    [[nodiscard]] double edge_part(std::size_t k) const {
        return static_cast<double>(k + 1) / static_cast<double>(cuts_);
    }
    [[nodiscard]] Vec2 edge_place(mesh::Index e, std::size_t k) const;
    [[nodiscard]] Vec2 cell_place(mesh::Index c, std::size_t k) const;

    /// Corners of the triangles, and the ends of the parts of the edges.
    [[nodiscard]] std::vector<std::uint32_t> triangles() const;
    [[nodiscard]] std::vector<std::uint32_t> lines() const;

  private:
    /// In a triangle a / cuts and b / cuts are weights of corners 1 and 2; in a quad they are
    /// the parts of the way from corner 0 to corner 1 and to corner 3.
    struct Step {
        std::size_t a = 0;
        std::size_t b = 0;
    };
    [[nodiscard]] std::uint32_t side_point(mesh::Index c, std::size_t side, std::size_t k) const;
    [[nodiscard]] std::uint32_t point(mesh::Index c, Step at) const;
    /// How many points of row b there are.
    [[nodiscard]] std::size_t row_length(std::size_t b) const {
        return mesh_->sides == 3 ? cuts_ + 1 - b : cuts_ + 1;
    }

    const CellMesh* mesh_;
    std::size_t cuts_;
    std::vector<Step> inner_;
    std::vector<std::size_t> inner_row_;  ///< where each row begins in inner_
};

}  // namespace relief::edit
