#pragma once

#include <cstdint>
#include <span>

#include "codec/quad_values.h"
#include "relief/core/stream.h"
#include "relief/multires/fvs_mesh.h"

namespace relief::codec {

/// Codes the hierarchical coefficients of a spline, values and derivatives, level by level: each
/// kind of number of a level is stored to 2^-24 of its largest.
class QuadNodal {
  public:
    /// The hierarchy must outlive this.
    explicit QuadNodal(const multires::fvs_mesh::Hierarchy& hierarchy);

    /// The next level of `coefficients`, which are rounded as a decoder will see them.
    [[nodiscard]] Bytes encode_next(multires::fvs_mesh::Decomposition& coefficients);
    /// Errors: BadFile if the bytes are not those of a level.
    [[nodiscard]] Status decode_next(std::span<const std::uint8_t> bytes,
                                     multires::fvs_mesh::Decomposition& coefficients);

  private:
    using Quantised = multires::fvs_mesh::Nodal<std::int64_t>;
    using QuantisedDetails = multires::fvs_mesh::Details<std::int64_t>;

    template <class Coder>
    void code_base(Coder& coder, Quantised& numbers);
    template <class Coder>
    void code_details(Coder& coder, QuantisedDetails& numbers);
    template <class Coder>
    void code_number(Coder& coder, std::int64_t& number, QuadNumber kind,
                     std::span<const mesh::Index> quads);
    [[nodiscard]] const mesh::Quadrangulation& parent() const {
        return hierarchy_.mesh(next_ > 0 ? next_ - 1 : 0);
    }
    void begin_level();

    const multires::fvs_mesh::Hierarchy& hierarchy_;
    NumberModel model_;
    int next_ = 0;
    QuadSums sums_{0};
    QuadSums below_{0};
};

}  // namespace relief::codec
