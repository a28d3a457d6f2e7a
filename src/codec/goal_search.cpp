#include "codec/goal_search.h"

#include <string>

#include "codec/raster_header.h"

namespace relief::codec {

Status check_goal(const Goal& goal) {
    const bool number = goal.value >= 0 && std::isfinite(goal.value);
    if (goal.kind != Goal::Kind::Lossless && !number)
        return Error{ErrorCode::InvalidArgument,
                     "the goal " + std::string(goal_name(goal.kind)) +
                         " must be a number that is not negative",
                     ""};
    if (goal.kind == Goal::Kind::Bytes && goal.value < 1)
        return Error{ErrorCode::InvalidArgument, "a file has at least one byte", ""};
    return {};
}

}  // namespace relief::codec
