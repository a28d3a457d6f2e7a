#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "contest.h"
#include "relief/core/result.h"
#include "relief/core/vec2.h"

/// Interpolants of scattered data behind one interface, in the calling thread.
namespace relief::peers {

/// Samples of a function over the unit square, whose corners are among them.
struct Samples {
    std::vector<Vec2> places;
    std::vector<double> values;
};

class PointPeer {
  public:
    PointPeer() = default;
    PointPeer(const PointPeer&) = delete;
    PointPeer& operator=(const PointPeer&) = delete;
    virtual ~PointPeer() = default;

    [[nodiscard]] virtual std::string name() const = 0;
    /// All that evaluation needs, in place of what was built before.
    [[nodiscard]] virtual Status build(const Samples& sites) = 0;
    /// Values at places in no order.
    [[nodiscard]] virtual Status evaluate(std::span<const Vec2> places,
                                          std::span<double> values) = 0;
    /// Values in the middle of side x side cells of the unit square, row by row.
    [[nodiscard]] virtual Status raster(std::int64_t side, std::span<double> values) = 0;
};

/// What happens to slivers between the sites of the hull.
enum class Slivers {
    Peeled,  ///< mesh::DelaunayOptions as they are; beside the domain the nearest point counts
    Kept,    ///< as the others do
};
[[nodiscard]] std::unique_ptr<PointPeer> relief_points(Slivers slivers = Slivers::Peeled);
#ifdef RELIEF_PEER_CGAL
[[nodiscard]] std::unique_ptr<PointPeer> cgal_points();
#endif

}  // namespace relief::peers
