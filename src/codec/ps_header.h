#pragma once

#include <optional>
#include <string>
#include <vector>

#include "codec/level_chunks.h"
#include "codec/ps_base.h"
#include "codec/ps_details.h"
#include "codec/value_lattice.h"
#include "relief/codec/ps_codec.h"
#include "relief/multires/ps_gradients.h"

namespace relief::codec {

/// The content of files of this kind.
inline constexpr const char* kPsContent = "powell-sabin";

/// What the header of a file of a Powell-Sabin spline says.
struct PsHeader {
    PsBaseHeader base;
    int components = 1;
    int levels = 0;
    /// Files of values: where gradients come from. None: coefficients.
    std::optional<multires::ps::GradientOptions> gradients;
    PsQuantisation quantisation;  ///< of coefficients
    /// Of each component: that of its values; of coefficients in lossless files, else none.
    std::vector<ValueLattice> lattices;
    Goal goal;
    PsReference reference;
    double max_error = 0;
    double rms_error = 0;
    double surface_error = 0;  ///< certified; 0: no bit of the surface differs
};

/// JSON text. Members with their default values are left out.
[[nodiscard]] std::string write_ps_header(const PsHeader& header);

/// Errors: BadFile naming the member that is missing, of the wrong type or out of range;
/// Unsupported for other contents.
[[nodiscard]] Result<PsHeader> read_ps_header(const std::string& text);

/// The numbers of chunks: after the finest level stands the correction.
struct PsChunks : LevelChunks {
    explicit PsChunks(int level_count) : LevelChunks{level_count, 1} {}

    [[nodiscard]] std::size_t correction() const { return last(); }
};

}  // namespace relief::codec
