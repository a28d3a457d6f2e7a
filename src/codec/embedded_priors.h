#pragma once

#include <cstdint>
#include <string_view>

namespace relief::codec {

/// What a stream expects before it has seen anything: for each context of EmbeddedContexts the
/// character kPriorEven + log odds of a 1 in units of kPriorStep / 256, at most 28 units. Trained
/// on terrain of several kinds at 0.05 to 3 bits a sample.
extern const std::string_view kEmbeddedPriors;

inline constexpr char kPriorEven = '?';
inline constexpr std::int32_t kPriorStep = 80;
inline constexpr std::uint32_t kPriorVisits = 12;  ///< as if they came from so many decisions

}  // namespace relief::codec
