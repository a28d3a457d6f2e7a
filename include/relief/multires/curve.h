#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "relief/core/banded.h"
#include "relief/core/result.h"

/// Cubic B-spline curves by themselves: subdivision and its reversal. Boundaries and creases of
/// surfaces have the same rules. Source: reverse-subdivision.md section 6.
namespace relief::multires {

/// How many fine points a coarse one becomes: 2, or 3 as boundaries of sqrt(3) surfaces do.
enum class CurveSplit : std::uint8_t { Dyadic, Ternary };

enum class CurveEnds : std::uint8_t {
    Closed,
    Natural,  ///< open; as if the curve went straight on: ends stay where they are
    Knots,    ///< open, ternary: the source paper's knots 0 0 0 0 5 8 11 .., which each step sets
              ///< anew
};

/// What coarse points are made of. All give back those of a subdivided curve.
enum class CurveReversal : std::uint8_t {
    LeastSquares,  ///< all fine points: the coarse curve whose subdivision is nearest
    Local,         ///< the fine point itself and the two beside it; not for knots
    Wide,          ///< closed, ternary: three on each side
    Paper,         ///< closed, ternary: four on each side, and the source paper's details
};

struct CurveOptions {
    CurveSplit split = CurveSplit::Ternary;
    CurveEnds ends = CurveEnds::Closed;
    CurveReversal reversal = CurveReversal::LeastSquares;
};

namespace rules {

struct Fraction {
    std::int64_t numerator = 0;
    std::int64_t denominator = 1;

    [[nodiscard]] constexpr double value() const {
        return static_cast<double>(numerator) / static_cast<double>(denominator);
    }
};

/// Weights of a coarse point in the fine ones from its own on, to both sides.
inline constexpr std::array<Fraction, 3> kDyadicCurveMask{{{6, 8}, {4, 8}, {1, 8}}};
inline constexpr std::array<Fraction, 5> kTernaryCurveMask{
    {{19, 27}, {16, 27}, {10, 27}, {4, 27}, {1, 27}}};

/// Reversal: weights of the fine points, in the same order. The last one is the source paper's.
inline constexpr std::array<Fraction, 2> kDyadicReversal{{{2, 1}, {-1, 2}}};
inline constexpr std::array<Fraction, 2> kTernaryReversal{{{11, 3}, {-4, 3}}};
inline constexpr std::array<Fraction, 4> kWideReversal{{{251, 147}, {8, 21}, {-48, 49}, {12, 49}}};
inline constexpr std::array<Fraction, 5> kPaperReversal{
    {{463, 477}, {244, 477}, {-98, 477}, {-248, 477}, {109, 477}}};
/// What the detail at fine point 3k + 1 adds to points 3k - 1 .. 3k + 3: q5 q4 q3 q2 q1 of (A.2).
/// That at 3k - 1 is the mirror image.
inline constexpr std::array<Fraction, 5> kPaperCorrection{{{-39839315, 17758786},
                                                           {11774114, 8879393},
                                                           {1, 1},
                                                           {13321692, 8879393},
                                                           {11710197, 17758786}}};
/// The detail at 3k + 1 from points 3k - 4 .. 3k + 7: b1 to b12 of (A.1).
inline constexpr std::array<Fraction, 12> kPaperDetail{{{-360908824401952, 6124761750733245},
                                                        {821150352767744, 6124761750733245},
                                                        {324486832948544, 6124761750733245},
                                                        {-227763072235964, 680529083414805},
                                                        {276752921024, 1311231374595},
                                                        {34302231721304, 680529083414805},
                                                        {-149920452798584, 6124761750733245},
                                                        {-412135978326626, 6124761750733245},
                                                        {276003571289944, 6124761750733245},
                                                        {-1740361028, 513090537885},
                                                        {-4404178928, 513090537885},
                                                        {1935707674, 513090537885}}};

}  // namespace rules

/// V: a number or a vector.
template <class V>
struct CurveCoefficients {
    std::vector<V> coarse;
    std::vector<V> details;  ///< of the new points, in their order: g - P c, but for Paper

    friend bool operator==(const CurveCoefficients&, const CurveCoefficients&) = default;
};

/// One step, both ways. Fine point k of a coarse one is number 2 k or 3 k, new points are between
/// them. V: double or Vec3<double>. Sums are added in a fixed order. Complexity: O(n).
class CurveStep {
  public:
    /// Errors: InvalidArgument `invalid_parameter` for a reversal that these curves do not have, or
    /// fewer coarse points than 3 (closed), 2 (natural ends) or 4 (knots).
    [[nodiscard]] static Result<CurveStep> create(std::size_t coarse_count,
                                                  const CurveOptions& options);

    [[nodiscard]] std::size_t coarse_count() const { return coarse_count_; }
    [[nodiscard]] std::size_t fine_count() const { return subdivision_.size(); }

    /// P c. Requires: as many points as coarse_count.
    template <class V>
    [[nodiscard]] std::vector<V> subdivide(const std::vector<V>& coarse) const;
    /// Requires: as many points as fine_count.
    template <class V>
    [[nodiscard]] CurveCoefficients<V> analyse(const std::vector<V>& fine) const;
    /// The reverse: exact to rounding.
    template <class V>
    [[nodiscard]] std::vector<V> synthesise(const CurveCoefficients<V>& coefficients) const;

    struct Weight {
        std::size_t point = 0;
        double weight = 0;
    };
    using Row = std::vector<Weight>;
    /// P: for each fine point those coarse ones that it is made of.
    [[nodiscard]] const std::vector<Row>& subdivision() const { return subdivision_; }

  private:
    CurveStep(std::size_t coarse_count, const CurveOptions& options);

    [[nodiscard]] std::size_t arity() const { return options_.split == CurveSplit::Dyadic ? 2 : 3; }
    [[nodiscard]] bool closed() const { return options_.ends == CurveEnds::Closed; }
    [[nodiscard]] bool is_paper() const { return options_.reversal == CurveReversal::Paper; }
    [[nodiscard]] bool is_new(std::size_t i) const { return i % arity() != 0; }
    [[nodiscard]] bool is_free(std::size_t k) const {
        return closed() || (k > 0 && k + 1 < coarse_count_);
    }
    [[nodiscard]] std::size_t place(std::size_t k) const;
    [[nodiscard]] BandedCholesky factored(const std::vector<Row>& rows) const;
    template <class Taps>
    [[nodiscard]] Row taps_around(std::size_t k, const Taps& taps) const;

    void subdivide_by_mask();
    void subdivide_by_knots();
    void add_gathering();
    void add_paper_details();
    template <class V>
    [[nodiscard]] std::vector<V> gathered(const std::vector<V>& fine) const;
    template <class V>
    void solve(const BandedCholesky& matrix, std::vector<V>& coarse) const;

    std::size_t coarse_count_;
    CurveOptions options_;
    std::vector<Row> subdivision_;
    /// [coarse point]: what its residuals satisfy, (gathering) (g - P c) = 0; none for ends.
    std::vector<Row> gathering_;
    std::vector<Row> old_rows_;  ///< [coarse point]: its old points, as numbers of coarse ones
    BandedCholesky fit_;         ///< LeastSquares: P^T P
    BandedCholesky old_fit_;     ///< the normal equations of old_rows_
    /// Paper: [new point] from fine points, and what they add to these.
    std::vector<Row> details_;
    std::vector<Row> corrections_;
};

}  // namespace relief::multires
