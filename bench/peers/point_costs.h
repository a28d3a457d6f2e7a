#pragma once

#include <nlohmann/json.hpp>
#include <vector>

#include "point_peer.h"

/// What relief takes for splines on triangulations, besides what its peers do, too.
namespace relief::peers {

/// Best and median of some runs.
[[nodiscard]] nlohmann::json summary(std::vector<double> seconds);

/// Samples a second of rasters with few and with many samples in a triangle.
[[nodiscard]] Result<nlohmann::json> rasters(const Samples& sites, int runs);

/// What the parts of building a surface take.
[[nodiscard]] Result<nlohmann::json> building(const Samples& sites, int runs);

/// Resident bytes a vertex that stay while a spline is evaluated.
[[nodiscard]] Result<nlohmann::json> memory(const Samples& sites);

/// Three triadic steps from 5000 triangles, with a spline.
[[nodiscard]] Result<nlohmann::json> refinement(int runs);

/// Least squares of all samples on 20 000 vertices, with cross validation: on one thread its clock,
/// on two the wall's.
[[nodiscard]] Result<nlohmann::json> least_squares(const Samples& samples, int runs);

}  // namespace relief::peers
