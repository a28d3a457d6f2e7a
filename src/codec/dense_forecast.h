#pragma once

#include <cstdint>
#include <vector>

#include "codec/dense_least_squares.h"
#include "codec/dense_tables.h"
#include "codec/lattice_level.h"

namespace relief::codec::dense {

/// What a modelled quotient counts: the step, and what raw bits tell.
[[nodiscard]] inline double modelled_step(const LatticeLevel& level) {
    return static_cast<double>(std::int64_t{level.step} << level.raw_bits);
}

/// What is known of the samples of a row before the row is coded. Element k belongs to column
/// first + 2 k.
struct RowForecast {
    std::int64_t first = 0;
    std::int64_t count = 0;
    std::vector<double> line;             ///< the prediction without its western sample
    std::vector<double> second;           ///< the second opinion
    std::vector<float> calm;              ///< the scale without the quotients of this pass
    std::vector<std::int32_t> around;     ///< weighted |q| of this pass, without the western one
    std::vector<std::uint8_t> texture;    ///< class of the texture in steps
    std::vector<std::uint8_t> inherited;  ///< class of the sum of |q| of the nearest samples

    /// For the samples of one kind in a row.
    void make(const LatticeLevel& level, Kind kind, std::int64_t row, const Weights& weights);

  private:
    void resize(std::int64_t samples);
    void predict(const LatticeLevel& level, const Stencil& stencil, std::int64_t row,
                 const Weights& weights);
    void measure(const LatticeLevel& level, const Stencil& stencil, std::int64_t row);

    std::vector<double> base_;
    std::vector<float> roughness_;  ///< in steps
};

}  // namespace relief::codec::dense
