#pragma once

#include <optional>
#include <vector>

#include "codec/ps_base.h"
#include "codec/ps_details.h"
#include "codec/ps_values.h"
#include "relief/codec/ps_codec.h"

namespace relief::codec {

/// A model that was checked, numbered as its file will be.
struct PsSource {
    CodedPsBase base;
    multires::ps::Hierarchy hierarchy;
    std::optional<PsValues> values;
    LevelHeights splines;  ///< on the finest level, also of values
    PsData data;
    PsReference reference;

    [[nodiscard]] const multires::ps::Space& finest() const {
        return hierarchy.space(hierarchy.levels());
    }
};

/// Errors: as encode_ps, for its model.
[[nodiscard]] Result<PsSource> prepare_ps(const PsModel& model, bool keep_order);

}  // namespace relief::codec
