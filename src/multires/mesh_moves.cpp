#include "relief/multires/mesh_moves.h"

namespace relief::multires {

namespace {

std::vector<Vec3<double>> turned(const std::vector<LocalDetail>& details,
                                 const std::vector<MeshFrame>& now) {
    std::vector<Vec3<double>> result(details.size());
    for (std::size_t k = 0; k < result.size(); ++k) result[k] = details[k].turned(now[k]);
    return result;
}

}  // namespace

GlobalDetails turned(const LocalDetails& details, const DetailFrames& now) {
    return {turned(details.fresh, now.fresh()), turned(details.stiff, now.stiff())};
}

}  // namespace relief::multires
