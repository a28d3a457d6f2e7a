#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <map>
#include <string_view>

#include "command.h"
#include "ps_verbs.h"
#include "quad_verbs.h"
#include "relief/codec/raster_surface.h"
#include "relief/core/sampling.h"
#include "relief/io/file.h"

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

/// A number that fills the field, but for blanks and quotes.
bool parse_number(std::string_view field, double& value) {
    constexpr std::string_view around = " \t\r\"'";
    const std::size_t first = field.find_first_not_of(around);
    if (first == std::string_view::npos) return false;
    field = field.substr(first, field.find_last_not_of(around) + 1 - first);
    if (field.size() > 1 && field[0] == '+' && field[1] != '-') field.remove_prefix(1);
    const auto [end, error] = std::from_chars(field.data(), field.data() + field.size(), value);
    return error == std::errc() && end == field.data() + field.size() && std::isfinite(value);
}

/// The first two fields of a line, separated by the first of ; tab , blank that is in it; further
/// ones are ignored.
bool parse_point(std::string_view line, Point& point) {
    for (const char separator : {';', '\t', ',', ' '}) {
        const std::size_t first = line.find_first_not_of(' ');
        if (first == std::string_view::npos) return false;
        const std::size_t end = line.find(separator, first);
        if (end == std::string_view::npos) continue;
        const std::size_t next = line.find_first_not_of(' ', end + 1);
        if (next == std::string_view::npos) return false;
        return parse_number(line.substr(0, end), point.x) &&
               parse_number(line.substr(next, line.find(separator, next) - next), point.y);
    }
    return false;
}

/// The first line may name the columns.
bool is_heading(std::string_view line, std::int64_t number) {
    return number == 1 && line.find_first_of("0123456789") != line.find_first_not_of(" \t\"'+-.");
}

Result<std::vector<Point>> read_points(const Eval& options) {
    std::vector<Point> points;
    for (const std::string& text : options.at) {
        Point point;
        if (!parse_point(text, point))
            return Error{ErrorCode::InvalidArgument,
                         "--at takes X,Y in data units, not '" + text + "'", ""};
        points.push_back(point);
    }
    if (options.points.empty()) return points;
    RELIEF_TRY(const auto bytes, io::read_file(options.points));
    std::string_view rest(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    constexpr std::string_view byte_order_mark = "\xEF\xBB\xBF";
    if (rest.starts_with(byte_order_mark)) rest.remove_prefix(byte_order_mark.size());
    for (std::int64_t number = 1; !rest.empty(); ++number) {
        const std::string_view line = rest.substr(0, rest.find('\n'));
        rest.remove_prefix(std::min(line.size() + 1, rest.size()));
        if (line.find_first_not_of(" \t\r") == std::string_view::npos || line[0] == '#') continue;
        Point point;
        if (parse_point(line, point)) {
            points.push_back(point);
        } else if (!is_heading(line, number)) {
            return Error{
                ErrorCode::BadInput,
                fmt::format("does not begin with two numbers: '{}'; give X,Y with decimal points",
                            line.substr(0, 60)),
                fmt::format("{}, line {}", options.points, number)};
        }
    }
    return points;
}

/// Value, gradient (d/dx, d/dy) and Hessian (xx, xy, yy) of one component.
using Jet = std::array<double, 6>;

/// The chain rule.
Jet to_data_units(const PlaceMap& map, const spline::SurfaceJet<double>& jet) {
    const auto [x, y] = map.gradient(jet.di, jet.dj);
    const auto [xx, xy, yy] = map.hessian(jet.dii, jet.dij, jet.djj);
    return {jet.value, x, y, xx, xy, yy};
}

std::string heading(int components, int derivatives) {
    const std::array<const char*, 6> names = {"value", "dx", "dy", "dxx", "dxy", "dyy"};
    const int count = derivatives == 0 ? 1 : derivatives == 1 ? 3 : 6;
    std::string line = "x,y";
    for (int c = 0; c < components; ++c)
        for (int k = 0; k < count; ++k)
            line += fmt::format(",{}{}", names[static_cast<std::size_t>(k)],
                                components > 1 ? std::to_string(c + 1) : "");
    return line + "\n";
}

/// Points on the lattice of a file; those outside the surface or in a hole are marked.
struct LatticePoints {
    std::vector<double> i;
    std::vector<double> j;
    std::vector<std::uint8_t> inside;
};

LatticePoints locate(const std::vector<Point>& points, const PlaceMap& map,
                     const codec::RasterFile& file) {
    // Places computed from sample centres may miss the border by rounding.
    const auto settled = [](double v, std::int64_t n) {
        const double last = static_cast<double>(n - 1);
        const double slack = 1e-9 * (1 + last);
        return v < -slack || v > last + slack ? NAN : std::clamp(v, 0.0, last);
    };
    LatticePoints found;
    for (const Point& point : points) {
        const double i = settled(map.row(point.x, point.y), file.description().rows);
        const double j = settled(map.col(point.x, point.y), file.description().cols);
        const bool inside = !std::isnan(i) && !std::isnan(j);
        found.i.push_back(inside ? i : 0);
        found.j.push_back(inside ? j : 0);
        found.inside.push_back(inside);
    }
    return found;
}

/// Points of one part of the raster, which are evaluated together.
struct Group {
    LatticeBox window;
    std::vector<std::size_t> points;
};

/// Files in tiles are read where points are; others as a whole.
std::vector<Group> groups_of(const codec::RasterFile& file, const LatticePoints& at) {
    constexpr std::int64_t side = 512;
    const std::int64_t rows = file.description().rows;
    const std::int64_t cols = file.description().cols;
    const bool together = !file.closed_loop() || rows * cols <= (std::int64_t{1} << 22);
    std::map<std::pair<std::int64_t, std::int64_t>, Group> groups;
    for (std::size_t n = 0; n < at.i.size(); ++n) {
        if (!at.inside[n]) continue;
        const std::int64_t row = together ? 0 : static_cast<std::int64_t>(at.i[n]) / side * side;
        const std::int64_t col = together ? 0 : static_cast<std::int64_t>(at.j[n]) / side * side;
        Group& group = groups[{row, col}];
        group.window = together ? LatticeBox{0, 0, rows, cols}
                                : LatticeBox{row, col, std::min(side + 1, rows - row),
                                             std::min(side + 1, cols - col)};
        group.points.push_back(n);
    }
    std::vector<Group> list;
    for (auto& [place, group] : groups) list.push_back(std::move(group));
    return list;
}

/// All derivatives of all components at the points of a group, in data units.
Status evaluate(const codec::RasterFile& file, const Group& group, int derivatives,
                const PlaceMap& map, LatticePoints& at, std::vector<std::vector<Jet>>& jets) {
    RELIEF_TRY(const auto surface, codec::RasterSurface::create(file, 0, group.window));
    std::vector<double> i;
    std::vector<double> j;
    for (const std::size_t n : group.points) {
        i.push_back(at.i[n]);
        j.push_back(at.j[n]);
        at.inside[n] = surface.valid(at.i[n], at.j[n]);
    }
    std::array<std::vector<double>, 6> parts;
    for (auto& part : parts) part.resize(i.size());
    for (int c = 0; c < surface.components(); ++c) {
        RELIEF_CHECK(surface.evaluate(
            c, i, j, derivatives, {parts[0], parts[1], parts[2], parts[3], parts[4], parts[5]}));
        for (std::size_t k = 0; k < i.size(); ++k)
            jets[static_cast<std::size_t>(c)][group.points[k]] = to_data_units(
                map,
                {parts[0][k], parts[1][k], parts[2][k], parts[3][k], parts[4][k], parts[5][k]});
    }
    return {};
}

Result<std::vector<std::vector<Jet>>> evaluate(const codec::RasterFile& file, int derivatives,
                                               LatticePoints& at, const PlaceMap& map) {
    std::vector<std::vector<Jet>> components(static_cast<std::size_t>(file.layout().components),
                                             std::vector<Jet>(at.i.size()));
    for (const Group& group : groups_of(file, at))
        RELIEF_CHECK(evaluate(file, group, derivatives, map, at, components));
    return components;
}

/// The jets of all components at all points, and which points are inside.
struct Evaluated {
    std::vector<std::vector<Jet>> components;
    std::vector<std::uint8_t> inside;
};

Result<Evaluated> evaluate_mesh(const Eval& options, const std::vector<Point>& points) {
    std::vector<Vec2> places;
    for (const Point& point : points) places.push_back({point.x, point.y});
    RELIEF_TRY(const auto jets, evaluate_quads(options.in, places));
    Evaluated result{{std::vector<Jet>(points.size())}, std::vector<std::uint8_t>(points.size())};
    for (std::size_t n = 0; n < points.size(); ++n) {
        result.inside[n] = jets[n].has_value();
        result.components[0][n] = jets[n].value_or(Jet{});
    }
    return result;
}

Result<Evaluated> evaluate_triangles(const Eval& options, const std::vector<Point>& points) {
    std::vector<Vec2> places;
    for (const Point& point : points) places.push_back({point.x, point.y});
    RELIEF_TRY(const PsJets found, evaluate_ps(options.in, places));
    const auto components = static_cast<std::size_t>(found.components);
    Evaluated result{std::vector<std::vector<Jet>>(components, std::vector<Jet>(points.size())),
                     std::vector<std::uint8_t>(points.size())};
    for (std::size_t n = 0; n < points.size(); ++n) {
        result.inside[n] = !std::isnan(found.jets[n * components].value);
        for (std::size_t c = 0; c < components; ++c) {
            const spline::PlaneJet& jet = found.jets[n * components + c];
            result.components[c][n] = {jet.value, jet.gradient.x, jet.gradient.y,
                                       jet.xx,    jet.xy,         jet.yy};
        }
    }
    return result;
}

Result<Evaluated> evaluate_raster(const Eval& options, const std::vector<Point>& points) {
    RELIEF_TRY(const codec::RasterFile file, open_relief(options.in));
    const auto map = PlaceMap::create(file.description().geo);
    if (!map.ok()) return located(map.error(), options.in);
    LatticePoints at = locate(points, *map, file);
    auto components = evaluate(file, options.derivatives, at, *map);
    if (!components.ok()) return located(components.error(), options.in);
    return Evaluated{*std::move(components), std::move(at.inside)};
}

Result<Outcome> run(const Eval& options, const Globals& globals) {
    const Stopwatch watch;
    if (options.at.empty() && options.points.empty())
        return Error{ErrorCode::InvalidArgument, "give places with --at X,Y or --points FILE.csv",
                     ""};
    RELIEF_TRY(const std::vector<Point> points, read_points(options));
    RELIEF_TRY(const Evaluated evaluated, holds_ps(options.in) ? evaluate_triangles(options, points)
                                          : holds_quads(options.in)
                                              ? evaluate_mesh(options, points)
                                              : evaluate_raster(options, points));
    const auto& [components, inside] = evaluated;

    const std::size_t count = options.derivatives == 0 ? 1 : options.derivatives == 1 ? 3 : 6;
    std::string csv = heading(static_cast<int>(components.size()), options.derivatives);
    const bool listed = globals.json && options.output.empty();
    Json values = Json::array();
    for (std::size_t n = 0; n < points.size(); ++n) {
        fmt::format_to(std::back_inserter(csv), "{},{}", points[n].x, points[n].y);
        Json row = Json::array();
        for (const auto& jets : components)
            for (std::size_t k = 0; k < count; ++k) {
                csv += ',';
                if (inside[n]) fmt::format_to(std::back_inserter(csv), "{}", jets[n][k]);
                if (listed) row.push_back(inside[n] ? Json(jets[n][k]) : Json(nullptr));
            }
        csv += '\n';
        if (listed) values.push_back(std::move(row));
    }
    const auto outside = std::count(inside.begin(), inside.end(), 0);
    Outcome outcome;
    if (!options.output.empty()) {
        RELIEF_CHECK(io::write_file_atomically(
            options.output, {reinterpret_cast<const std::uint8_t*>(csv.data()), csv.size()}));
        outcome.text =
            fmt::format("{}: {} points, {} outside\n", options.output, points.size(), outside);
    } else {
        outcome.text = std::move(csv);
        outcome.text_is_data = true;
    }
    outcome.json =
        Json{{"points", points.size()}, {"outside", outside}, {"seconds", watch.seconds()}};
    if (listed) outcome.json["values"] = std::move(values);
    return outcome;
}

}  // namespace

void add_eval(Program& program) {
    auto options = std::make_shared<Eval>();
    CLI::App* verb =
        add_verb(program, "eval",
                 "Evaluate the spline anywhere: value, gradient, Hessian in data units, as CSV. "
                 "Places outside "
                 "the surface or in a hole have empty fields.",
                 "  relief eval dem.relief --at 500123.5,4123456 --derivatives 1\n"
                 "  relief eval dem.relief --points places.csv --derivatives 2 > heights.csv",
                 [options, &program] { return run(*options, program.globals); });
    verb->add_option("IN", options->in, "the .relief file")->required();
    verb->add_option("--at", options->at,
                     "X,Y in the coordinates of the raster, mesh or points; column,row without a "
                     "geotransform")
        ->take_all()
        ->allow_extra_args(false);
    verb->add_option("--points", options->points, "a file of X,Y lines; a heading line is skipped");
    verb->add_option("--derivatives", options->derivatives,
                     "0: value (default), 1: gradient too, 2: Hessian too")
        ->check(CLI::Range(0, 2));
    verb->add_option("--output", options->output, "write the CSV here instead of standard output");
}

}  // namespace relief::cli
