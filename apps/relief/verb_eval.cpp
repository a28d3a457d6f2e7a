#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <sstream>

#include "command.h"
#include "relief/io/file.h"
#include "relief/spline/box_surface.h"

namespace relief::cli {

namespace {

struct Eval {
    std::string in;
    std::vector<std::string> at;
    std::string points;
    std::string output;
    int derivatives = 0;
};

struct Point {
    double x = 0;
    double y = 0;
};

/// "X,Y", "X Y" or "X;Y"; further fields are ignored.
bool parse_point(std::string line, Point& point) {
    std::replace_if(line.begin(), line.end(), [](char c) { return c == ',' || c == ';' || c == '\t' || c == '\r'; }, ' ');
    std::istringstream fields(line);
    fields.imbue(std::locale::classic());
    return static_cast<bool>(fields >> point.x >> point.y) && std::isfinite(point.x) && std::isfinite(point.y);
}

Result<std::vector<Point>> read_points(const Eval& options) {
    std::vector<Point> points;
    for (const std::string& text : options.at) {
        Point point;
        if (!parse_point(text, point))
            return Error{ErrorCode::InvalidArgument, "--at takes X,Y in data units, not '" + text + "'", ""};
        points.push_back(point);
    }
    if (options.points.empty()) return points;
    RELIEF_TRY(const auto bytes, io::read_file(options.points));
    std::istringstream lines(std::string(bytes.begin(), bytes.end()));
    std::string line;
    for (std::int64_t number = 1; std::getline(lines, line); ++number) {
        if (line.find_first_not_of(" \t\r") == std::string::npos || line[0] == '#') continue;
        Point point;
        if (parse_point(line, point)) {
            points.push_back(point);
        } else if (number > 1) {  // the first line may be a heading
            return Error{ErrorCode::BadInput, "does not begin with two numbers: '" + line.substr(0, 60) + "'",
                         fmt::format("{}, line {}", options.points, number)};
        }
    }
    return points;
}

/// Value, gradient (d/dx, d/dy) and Hessian (xx, xy, yy) of one component.
using Jet = std::array<double, 6>;

Jet to_data_units(const spline::SurfaceJet<double>& jet, const PlaceMap& map) {
    // Rows of m: d(j, i) / dx and d(j, i) / dy.
    const double jx = map.inverse[0][0], jy = map.inverse[0][1], ix = map.inverse[1][0], iy = map.inverse[1][1];
    return {jet.value,
            jet.dj * jx + jet.di * ix,
            jet.dj * jy + jet.di * iy,
            jet.djj * jx * jx + 2 * jet.dij * jx * ix + jet.dii * ix * ix,
            jet.djj * jx * jy + jet.dij * (jx * iy + jy * ix) + jet.dii * ix * iy,
            jet.djj * jy * jy + 2 * jet.dij * jy * iy + jet.dii * iy * iy};
}

std::string heading(int components, int derivatives) {
    const std::array<const char*, 6> names = {"value", "dx", "dy", "dxx", "dxy", "dyy"};
    const int count = derivatives == 0 ? 1 : derivatives == 1 ? 3 : 6;
    std::string line = "x,y";
    for (int c = 0; c < components; ++c)
        for (int k = 0; k < count; ++k)
            line += fmt::format(",{}{}", names[static_cast<std::size_t>(k)], components > 1 ? std::to_string(c + 1) : "");
    return line + "\n";
}

bool in_hole(const codec::RasterFile& file, double i, double j) {
    return !file.mask().empty() && file.mask()(std::llround(i), std::llround(j)) == 0;
}

Result<Outcome> run(const Eval& options, const Globals& globals) {
    const Stopwatch watch;
    if (options.at.empty() && options.points.empty())
        return Error{ErrorCode::InvalidArgument, "give places with --at X,Y or --points FILE.csv", ""};
    RELIEF_TRY(const std::vector<Point> points, read_points(options));
    RELIEF_TRY(const codec::RasterFile file, open_relief(options.in));
    RELIEF_TRY(const auto net, file.control_net());
    std::vector<spline::BoxSurface<double>> surfaces;
    for (const Grid<double>& plane : net) {
        RELIEF_TRY(auto surface, spline::BoxSurface<double>::create(plane.view(), file.layout().spec.order));
        surfaces.push_back(std::move(surface));
    }
    const PlaceMap map(file.description().geo);
    const std::size_t count = options.derivatives == 0 ? 1 : options.derivatives == 1 ? 3 : 6;
    std::string csv = heading(file.layout().components, options.derivatives);
    Json values = Json::array();
    std::int64_t outside = 0;
    for (const Point& point : points) {
        double i = 0;
        double j = 0;
        map.to_lattice(point.x, point.y, i, j);
        // Places computed from sample centres may miss the border by rounding.
        constexpr double slack = 1e-9;
        const auto settle = [&](double v, std::int64_t n) {
            const double last = static_cast<double>(n - 1);
            return v < 0 && v > -slack * (1 + last) ? 0 : v > last && v < last + slack * (1 + last) ? last : v;
        };
        i = settle(i, file.layout().rows);
        j = settle(j, file.layout().cols);
        const bool inside = surfaces[0].contains(i, j) && !in_hole(file, i, j);
        outside += !inside;
        csv += fmt::format("{},{}", point.x, point.y);
        Json row = Json::array();
        for (const auto& surface : surfaces) {
            const Jet jet = inside ? to_data_units(surface.jet(i, j), map) : Jet{};
            for (std::size_t k = 0; k < count; ++k) {
                csv += inside ? fmt::format(",{}", jet[k]) : ",";
                if (globals.json) row.push_back(inside ? Json(jet[k]) : Json(nullptr));
            }
        }
        csv += "\n";
        if (globals.json) values.push_back(std::move(row));
    }
    Outcome outcome;
    if (!options.output.empty()) {
        RELIEF_CHECK(io::write_file_atomically(
            options.output, {reinterpret_cast<const std::uint8_t*>(csv.data()), csv.size()}));
        outcome.text = fmt::format("{}: {} points, {} outside\n", options.output, points.size(), outside);
    } else {
        outcome.text = std::move(csv);
        outcome.text_is_data = true;
    }
    outcome.json = Json{{"points", points.size()}, {"outside", outside}, {"seconds", watch.seconds()}};
    if (options.output.empty()) outcome.json["values"] = std::move(values);
    return outcome;
}

}  // namespace

void add_eval(Program& program) {
    auto options = std::make_shared<Eval>();
    CLI::App* verb = add_verb(program, "eval",
                              "Evaluate the spline anywhere: value, gradient, Hessian in data units, as CSV. Places outside "
                              "the surface or in a hole have empty fields.",
                              "  relief eval dem.relief --at 500123.5,4123456 --derivatives 1\n"
                              "  relief eval dem.relief --points places.csv --derivatives 2 > heights.csv",
                              [options, &program] { return run(*options, program.globals); });
    verb->add_option("IN", options->in, "the .relief file")->required();
    verb->add_option("--at", options->at, "X,Y in the raster's coordinates; column,row without a geotransform")
        ->take_all()
        ->allow_extra_args(false);
    verb->add_option("--points", options->points, "a file of X,Y lines; a heading line is skipped");
    verb->add_option("--derivatives", options->derivatives, "0: value (default), 1: gradient too, 2: Hessian too")
        ->check(CLI::Range(0, 2));
    verb->add_option("--output", options->output, "write the CSV here instead of standard output");
}

}  // namespace relief::cli
