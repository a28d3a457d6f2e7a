#include <algorithm>
#include <cmath>
#include <cstring>
#include <iostream>

#include "point_costs.h"
#include "point_peer.h"
#include "relief/core/parallel.h"
#include "relief/io/file.h"

/// Measures relief and its peers at interpolating scattered data: one line of JSON for each library
/// and number of sites, and what relief takes for the rest. One thread, whose own clock is read,
/// where nothing else is said.
namespace relief::peers {

namespace {

using nlohmann::json;

constexpr std::int64_t kRasterSide = 1024;
constexpr double kBorder = 0.05;  ///< of the unit square

/// A file of doubles: x, y and value of each sample.
Result<Samples> read(const std::string& path) {
    RELIEF_TRY(const std::vector<std::uint8_t> bytes, io::read_file(path));
    std::vector<double> numbers(bytes.size() / sizeof(double));
    std::memcpy(numbers.data(), bytes.data(), numbers.size() * sizeof(double));
    Samples samples;
    for (std::size_t k = 0; k + 2 < numbers.size(); k += 3) {
        samples.places.push_back({numbers[k], numbers[k + 1]});
        samples.values.push_back(numbers[k + 2]);
    }
    return samples;
}

bool is_inner(Vec2 place) {
    const auto inside = [](double t) { return t >= kBorder && t <= 1 - kBorder; };
    return inside(place.x) && inside(place.y);
}

json errors_of(const Samples& truth, std::span<const double> values) {
    double inner = 0;
    double border = 0;
    double square = 0;
    double count = 0;
    for (std::size_t k = 0; k < values.size(); ++k) {
        const double error = std::abs(values[k] - truth.values[k]);
        if (!is_inner(truth.places[k])) {
            border = std::max(border, error);
            continue;
        }
        inner = std::max(inner, error);
        square += error * error;
        ++count;
    }
    return {{"inner_rms", std::sqrt(square / count)}, {"inner_max", inner}, {"border_max", border}};
}

template <class Body>
Status append_time(std::vector<double>& seconds, Body&& body) {
    const double start = thread_seconds();
    RELIEF_CHECK(body());
    seconds.push_back(thread_seconds() - start);
    return {};
}

Status measure(PointPeer& peer, const Samples& sites, const Samples& truth, int runs) {
    std::vector<double> building;
    std::vector<double> evaluating;
    std::vector<double> painting;
    std::vector<double> values(truth.places.size());
    std::vector<double> raster(kRasterSide * kRasterSide);
    for (int run = 0; run < runs; ++run) {
        RELIEF_CHECK(append_time(building, [&] { return peer.build(sites); }));
        RELIEF_CHECK(append_time(evaluating, [&] { return peer.evaluate(truth.places, values); }));
        RELIEF_CHECK(append_time(painting, [&] { return peer.raster(kRasterSide, raster); }));
    }
    json line{{"library", peer.name()},
              {"sites", sites.places.size()},
              {"build", summary(building)},
              {"random", summary(evaluating)},
              {"raster", summary(painting)}};
    line.update(errors_of(truth, values));
    std::cout << line.dump() << std::endl;
    return {};
}

Status run(std::vector<std::string> paths, int runs) {
    if (paths.size() < 2)
        return Error{ErrorCode::InvalidArgument, "name files of doubles: queries, sites ..", ""};
    RELIEF_TRY(const Samples queries, read(paths.front()));
    std::vector<std::unique_ptr<PointPeer>> peers;
    peers.push_back(relief_points());
    peers.push_back(relief_points(Slivers::Kept));
#ifdef RELIEF_PEER_CGAL
    peers.push_back(cgal_points());
#endif
    set_thread_count(1);
    std::cout << json{{"libraries", {{"CGAL", RELIEF_CGAL_VERSION}}}}.dump() << std::endl;
    for (std::size_t k = 1; k < paths.size(); ++k) {
        RELIEF_TRY(const Samples sites, read(paths[k]));
        for (const auto& peer : peers) RELIEF_CHECK(measure(*peer, sites, queries, runs));
    }
    RELIEF_TRY(const Samples fewest, read(paths[1]));
    RELIEF_TRY(const Samples most, read(paths.back()));
    for (const auto& cost : {rasters(fewest, runs), building(most, runs), memory(most),
                             refinement(runs), least_squares(most, runs)}) {
        if (!cost.ok()) return cost.error();
        std::cout << cost->dump() << std::endl;
    }
    return {};
}

}  // namespace

}  // namespace relief::peers

int main(int count, char** arguments) {
    std::vector<std::string> paths(arguments + 1, arguments + count);
    int runs = 3;
    if (!paths.empty() && paths[0] == "--once") {
        runs = 1;
        paths.erase(paths.begin());
    }
    const relief::Status status = relief::peers::run(std::move(paths), runs);
    if (status.ok()) return 0;
    std::cerr << status.error().text() << '\n';
    return 1;
}
