#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "codec/number_coder.h"
#include "relief/core/result.h"
#include "relief/core/stream.h"
#include "relief/multires/mesh_hierarchy.h"

/// Quantised details of meshes, step by step. docs/format.md, "Details of meshes".
namespace relief::codec {

/// A detail along tangent, bitangent and normal, in steps.
using QuantisedDetail = std::array<std::int64_t, 3>;

/// Those of one step: of its new vertices, and of its stiff ones.
struct QuantisedStep {
    std::vector<QuantisedDetail> fresh;
    std::vector<QuantisedDetail> stiff;
};

/// Codes the steps of a hierarchy in their order. A number's contexts are those around it that are
/// known, and those of the step before at the corners of its edge or face.
class MeshDetails {
  public:
    /// Must outlive this.
    explicit MeshDetails(const multires::MeshHierarchy& hierarchy) : hierarchy_(hierarchy) {}

    /// Requires: the sizes of the next step. Complexity: O(n).
    [[nodiscard]] Bytes encode_next(const QuantisedStep& details);
    /// Errors: BadFile.
    [[nodiscard]] Result<QuantisedStep> decode_next(std::span<const std::uint8_t> bytes);

  private:
    template <class Coder>
    void code_next(Coder& coder, QuantisedStep& details);

    const multires::MeshHierarchy& hierarchy_;
    NumberModel model_;
    int next_ = 0;
    std::vector<QuantisedDetail> before_;  ///< of the new vertices of the step before
};

}  // namespace relief::codec
