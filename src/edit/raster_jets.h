#pragma once

#include <array>
#include <map>
#include <memory>
#include <vector>

#include "relief/codec/raster_surface.h"
#include "relief/core/vec3.h"
#include "relief/multires/edit.h"

/// Values and derivatives of a raster's surfaces at the samples of tiles.
namespace relief::edit {

/// A grid of places in a raster's finest lattice: rows rows[0] < rows[1] < .., the same for
/// columns. Those of a tile are 2^lod apart but for the last.
struct Places {
    int lod = 0;
    std::vector<double> rows;
    std::vector<double> cols;

    [[nodiscard]] std::size_t count() const { return rows.size() * cols.size(); }
};

/// Of one component, row by row; per step of the finest lattice.
struct Jets {
    std::vector<double> value, di, dj;
    std::vector<double> dii, dij, djj;  ///< empty: not asked for

    explicit Jets(std::size_t size = 0, int derivatives = 0);
};
void add(Jets& to, const Jets& from);

/// The surfaces of a file, by level: what lies below the moves. Several threads may not ask at
/// once.
class OriginalSurfaces {
  public:
    /// The file must outlive this and keep its address.
    explicit OriginalSurfaces(const codec::RasterFile& file) : file_(file), surfaces_(file) {}

    struct Part {
        std::vector<Jets> components;
        std::vector<std::uint8_t> valid;  ///< empty: all are
    };
    /// Of the surface of `level`, or of level places.lod if that is coarser. Errors: BadFile.
    [[nodiscard]] Result<Part> part(int level, const Places& places, int derivatives) const;

  private:
    const codec::RasterFile& file_;
    mutable codec::RasterSurfaces surfaces_;
};

/// What moves add, by level: the coefficients that they changed.
class MoveFields {
  public:
    using Delta = std::array<double, 4>;
    using Key = std::pair<std::int64_t, std::int64_t>;  ///< row, column
    /// What was there before a group of moves.
    struct Undo {
        struct Entry {
            int level = 0;
            Key key;
            std::optional<Delta> before;
        };
        std::vector<Entry> entries;
    };

    explicit MoveFields(const multires::PyramidLayout& layout);

    [[nodiscard]] bool empty() const;
    Undo add(const std::vector<multires::Move>& moves);
    void restore(const Undo& undo);
    /// The sum of what moved at a control point.
    [[nodiscard]] Delta at(int level, std::int64_t row, std::int64_t col) const;

    /// What moves of `level` and coarser ones add at places. Complexity: O(places near moves).
    [[nodiscard]] Status add_to(std::vector<Jets>& components, int level, const Places& places,
                                int derivatives) const;

  private:
    using Field = std::map<Key, Delta>;

    /// Where moves of a level are in a box: the smallest box around them.
    [[nodiscard]] LatticeBox moved_in(int level, const LatticeBox& box) const;
    /// Moves of `level` and of coarser ones as coefficients of `level`; nothing if there are none.
    [[nodiscard]] Result<std::optional<multires::LevelCoefficients<double>>> coefficients(
        int level, LatticeBox window) const;
    /// Moves of `level` alone.
    [[nodiscard]] multires::LevelCoefficients<double> own(int level,
                                                          const LatticeBox& window) const;
    [[nodiscard]] Status add_surface(const multires::LevelCoefficients<double>& net, int level,
                                     std::vector<Jets>& components, const Places& places,
                                     int derivatives) const;
    [[nodiscard]] Status add_own(std::vector<Jets>& components, int level, const Places& places,
                                 int derivatives) const;

    const multires::PyramidLayout* layout_;
    std::vector<Field> fields_;  ///< by level
};

}  // namespace relief::edit
