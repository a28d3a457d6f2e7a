#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "codec/number_coder.h"
#include "codec/value_lattice.h"
#include "relief/core/result.h"
#include "relief/core/stream.h"
#include "relief/multires/ps_lift.h"

/// Quantised coefficients of Powell-Sabin splines, level by level: docs/format.md, "Level chunks of
/// coefficients of splines".
namespace relief::codec {

/// How steps follow the areas A of the triangles at vertices, whose roots are the L2 norms of
/// B-splines and wavelets but for a factor near 1.
enum class StepLaw : std::uint8_t {
    Norm,      ///< ~ A^(-1/2): least L2 error
    RootNorm,  ///< ~ A^(-1/4)
    Flat,      ///< all equal
};

struct PsQuantisation {
    multires::ps::Update update = multires::ps::Update::Semi2Moments;
    double step = 1;  ///< where A is its mean on the finest level
    StepLaw law = StepLaw::Norm;
};

inline constexpr double kLargestPsStep = 1e200;

/// Heights of one level: all of the base, or details of the new vertices of a step; [component].
using LevelHeights = std::vector<multires::ps::Coefficients>;

/// Codes the levels of a hierarchy from the coarsest on.
class PsLevels {
  public:
    /// The first levels of a file are in `hierarchy`, which must outlive this; its finest one has
    /// so many vertices.
    PsLevels(const multires::ps::Hierarchy& hierarchy, std::uint64_t finest_vertices,
             const PsQuantisation& quantisation);

    /// The next level; `heights` become what a decoder sees. Of quotients of heights and steps,
    /// fractions from 1 - `rounding` on are rounded up. Complexity: O(n log n) for the base, else
    /// O(n).
    [[nodiscard]] Bytes encode_next(LevelHeights& heights, double rounding);
    /// heights: of the size of the level. Errors: BadFile.
    [[nodiscard]] Status decode_next(std::span<const std::uint8_t> bytes, LevelHeights& heights);

    /// How many numbers were not zero, or of the base.
    [[nodiscard]] std::int64_t kept() const { return kept_; }

  private:
    using Triple = std::array<std::int64_t, 3>;
    using Triples = std::vector<Triple>;  ///< [vertex of the level]

    template <class Coder>
    bool code_next(Coder& coder, LevelHeights& heights, double rounding);
    template <class Coder>
    bool code_base(Coder& coder, LevelHeights& heights, double rounding);
    template <class Coder>
    bool code_details(Coder& coder, LevelHeights& heights, double rounding);
    template <class Coder>
    bool code_triple(Coder& coder, std::size_t component, std::size_t place, std::uint32_t kind,
                     double rounding, double step, multires::ps::Heights& heights,
                     const multires::ps::Heights& expected, std::span<const std::size_t> beside,
                     std::span<const std::size_t> below);
    [[nodiscard]] std::vector<double> steps_of(const mesh::Triangulation& mesh) const;

    const multires::ps::Hierarchy& hierarchy_;
    PsQuantisation quantisation_;
    double mean_area_ = 0;  ///< of the triangles at a vertex of the finest level
    NumberModel model_;
    int next_ = 0;
    std::vector<Triples> numbers_;  ///< [component]: of the level
    std::vector<Triples> before_;   ///< of the level below it
    std::int64_t kept_ = 0;
};

/// What lossless files add to the heights of the finest level, in the lattices of the components.
[[nodiscard]] Bytes write_exact_heights(const LevelHeights& decoded, const LevelHeights& exact,
                                        std::span<const ValueLattice> lattices);
/// In place. Errors: BadFile.
[[nodiscard]] Status read_exact_heights(std::span<const std::uint8_t> bytes,
                                        std::span<const ValueLattice> lattices,
                                        LevelHeights& heights);

}  // namespace relief::codec
