#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <string_view>

#include "command.h"
#include "level_files.h"
#include "ps_verbs.h"
#include "quad_verbs.h"
#include "relief/codec/plane_surface.h"
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
bool parse_point(std::string_view line, Vec2& point) {
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

Result<std::vector<Vec2>> read_points(const Eval& options) {
    std::vector<Vec2> points;
    for (const std::string& text : options.at) {
        Vec2 point;
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
        Vec2 point;
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

/// The jets of all components at each point: jets[point * components + component]; NaN outside the
/// surface and in holes.
struct Evaluated {
    std::size_t components = 1;
    std::vector<spline::PlaneJet> jets;
};

template <class File>
Result<Evaluated> evaluate_file(const Eval& options, const std::vector<Vec2>& points) {
    RELIEF_TRY(const File file, open_file<File>(options.in));
    const auto surface = codec::plane_surface(file);
    if (!surface.ok()) return located(surface.error(), options.in);
    Evaluated result{static_cast<std::size_t>((*surface)->components()), {}};
    result.jets.resize(points.size() * result.components);
    if (const Status status = (*surface)->evaluate(points, options.derivatives, result.jets);
        !status.ok())
        return located(status.error(), options.in);
    return result;
}

Result<Evaluated> evaluate(const Eval& options, const std::vector<Vec2>& points) {
    if (holds_ps(options.in)) return evaluate_file<codec::PsFile>(options, points);
    if (holds_quads(options.in)) return evaluate_file<codec::QuadFile>(options, points);
    return evaluate_file<codec::RasterFile>(options, points);
}

std::array<double, 6> numbers_of(const spline::PlaneJet& jet) {
    return {jet.value, jet.gradient.x, jet.gradient.y, jet.xx, jet.xy, jet.yy};
}

Result<Outcome> run(const Eval& options, const Globals& globals) {
    const Stopwatch watch;
    if (options.at.empty() && options.points.empty())
        return Error{ErrorCode::InvalidArgument, "give places with --at X,Y or --points FILE.csv",
                     ""};
    RELIEF_TRY(const std::vector<Vec2> points, read_points(options));
    RELIEF_TRY(const Evaluated evaluated, evaluate(options, points));
    const std::size_t components = evaluated.components;

    const std::size_t count = options.derivatives == 0 ? 1 : options.derivatives == 1 ? 3 : 6;
    std::string csv = heading(static_cast<int>(components), options.derivatives);
    const bool listed = globals.json && options.output.empty();
    Json values = Json::array();
    std::size_t outside = 0;
    for (std::size_t n = 0; n < points.size(); ++n) {
        fmt::format_to(std::back_inserter(csv), "{},{}", points[n].x, points[n].y);
        Json row = Json::array();
        const bool inside = !std::isnan(evaluated.jets[n * components].value);
        for (std::size_t c = 0; c < components; ++c) {
            const auto numbers = numbers_of(evaluated.jets[n * components + c]);
            for (std::size_t k = 0; k < count; ++k) {
                csv += ',';
                if (inside) fmt::format_to(std::back_inserter(csv), "{}", numbers[k]);
                if (listed) row.push_back(inside ? Json(numbers[k]) : Json(nullptr));
            }
        }
        csv += '\n';
        if (listed) values.push_back(std::move(row));
        outside += !inside;
    }
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
