#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "codec/number_coder.h"
#include "codec/value_lattice.h"
#include "relief/core/stream.h"
#include "relief/multires/fvs_mesh.h"

namespace relief::codec {

/// Kinds of numbers on quadrangulations, for contexts. Files with values only have three of them.
enum class QuadNumber : std::uint32_t {
    Value,
    Dx,
    Dy,
    Normal,
    EdgeValue,
    EdgeTangential,
    CentreValue,
    CentreDx,
    CentreDy,
    NewNormal,
};

/// Sums of the numbers that a level has in each quad of its parent level (level 0: of itself).
class QuadSums {
  public:
    explicit QuadSums(std::size_t quads) : sums_(quads) {}

    [[nodiscard]] const Surrounding& operator[](std::size_t quad) const { return sums_[quad]; }
    [[nodiscard]] std::size_t size() const { return sums_.size(); }
    /// Of the one or two quads of an edge, or all of a vertex.
    [[nodiscard]] Surrounding around(std::span<const mesh::Index> quads) const {
        Surrounding sum;
        for (const mesh::Index q : quads)
            if (q != mesh::kNoQuad) sum.add(sums_[q]);
        return sum;
    }
    void add(std::span<const mesh::Index> quads, std::int64_t number) {
        for (const mesh::Index q : quads)
            if (q != mesh::kNoQuad) sums_[q].add(number);
    }
    /// Of the numbers one level below around quads of `count`: a quad itself, or its parent.
    [[nodiscard]] Surrounding below(std::span<const mesh::Index> quads, std::size_t count) const {
        const bool refined = count != sums_.size();
        Surrounding sum;
        for (const mesh::Index q : quads)
            if (q != mesh::kNoQuad) sum.add(sums_[refined ? q / 4 : q]);
        return sum;
    }

  private:
    std::vector<Surrounding> sums_;
};

/// Codes the values at the vertices of a hierarchy, level by level, as integers of a lattice. Level
/// 0 is predicted from vertices around, others by the spline through the level below. The lattice
/// is the same for all levels, so errors do not add up.
class QuadValues {
  public:
    /// The hierarchy must outlive this.
    QuadValues(const multires::fvs_mesh::Hierarchy& hierarchy, const ValueLattice& lattice);

    /// The next level. Requires: an integer for each of its vertices. Errors: `non_finite_data` if
    /// the derivatives of values overflow.
    [[nodiscard]] Result<Bytes> encode_next(std::span<const std::int64_t> integers);
    /// Errors: BadFile if the bytes are not those of a level.
    [[nodiscard]] Status decode_next(std::span<const std::uint8_t> bytes);

    /// Values of all levels so far.
    [[nodiscard]] const std::vector<double>& values() const { return values_; }

  private:
    template <class Coder>
    Status code_next(Coder& coder, const std::int64_t* source);
    template <class Coder>
    bool code_base(Coder& coder, const std::int64_t* source);
    template <class Coder>
    bool code_refined(Coder& coder, const std::int64_t* source,
                      const std::vector<double>& predicted);
    template <class Coder>
    bool code_value(Coder& coder, const std::int64_t* source, mesh::Index vertex, double predicted,
                    QuadNumber kind, std::span<const mesh::Index> quads);

    const multires::fvs_mesh::Hierarchy& hierarchy_;
    ValueLattice lattice_;
    NumberModel model_;
    int next_ = 0;
    std::vector<double> values_;
    QuadSums sums_{0};
    QuadSums below_{0};
};

}  // namespace relief::codec
