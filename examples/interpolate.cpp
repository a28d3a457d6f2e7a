// Reads points x y z, passes a smooth surface through them, and writes heights and slopes along the
// line between two places as a table. usage: interpolate POINTS OUT.csv X0 Y0 X1 Y1
#include <cstdio>
#include <cstdlib>

#include "relief/io/points.h"
#include "relief/multires/ps_interpolant.h"

relief::Status run(const char* points_path, const char* table_path, relief::Vec2 from,
                   relief::Vec2 to) {
    using namespace relief;
    RELIEF_TRY(const io::PointSet set, io::read_points(points_path));
    RELIEF_TRY(const auto surface, multires::ps::Interpolant::create(set.places, set.values[0]));

    std::vector<Vec2> places;
    for (int k = 0; k <= 100; ++k) places.push_back(from + 0.01 * k * (to - from));
    std::vector<spline::PlaneJet> jets(places.size());
    RELIEF_CHECK(surface.evaluate(places, jets, multires::ps::Outside::Nan));

    std::vector<double> x, y, height, slope;
    for (std::size_t k = 0; k < places.size(); ++k) {
        x.push_back(places[k].x);
        y.push_back(places[k].y);
        height.push_back(jets[k].value);
        slope.push_back(length(jets[k].gradient));
    }
    const io::CsvColumn table[] = {{"x", x}, {"y", y}, {"height", height}, {"slope", slope}};
    return io::write_csv(table_path, table);
}

int main(int argc, char** argv) {
    if (argc != 7) return 2;
    const auto number = [&](int k) { return std::atof(argv[k]); };
    const relief::Status done =
        run(argv[1], argv[2], {number(3), number(4)}, {number(5), number(6)});
    if (done.ok()) return 0;
    std::fprintf(stderr, "interpolate: %s\n", done.error().text().c_str());
    return 1;
}
