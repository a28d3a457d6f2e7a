#include <fmt/format.h>

#include <array>
#include <cmath>
#include <functional>

#include "functions.h"
#include "relief/multires/fvs_mesh.h"
#include "reproduce.h"

namespace relief::reproduce {

namespace {

namespace fvs = multires::fvs_mesh;
using spline::PlaneJet;

constexpr const char* kSource = "fvs (Hong, Schumaker)";
constexpr int kGrid = 101;  ///< points a side at which errors are measured; the paper gives none

using Function = std::function<PlaneJet(Vec2)>;

// --- the paper's functions

/// exp(-R / (R - |p - (1/2, 1/2)|^2)) on the disc of squared radius R: the definition that gives
/// the paper's numbers.
PlaneJet disc(Vec2 p) {
    constexpr double R = 1.0 / 128;
    const Vec2 d = p - Vec2{0.5, 0.5};
    const double rest = R - dot(d, d);
    if (rest <= 0) return {};
    const double value = std::exp(-R / rest);
    return {value, (-2 * R * value / (rest * rest)) * d};
}

// --- table 1

mesh::Quadrangulation unit_square() {
    const std::array<Vec2, 4> corners = {Vec2{0, 0}, {1, 0}, {1, 1}, {0, 1}};
    const std::array<std::array<mesh::Index, 4>, 1> quads = {{{0, 1, 2, 3}}};
    return *mesh::build(corners, quads);
}

void table1(Rows& rows) {
    constexpr std::array<std::array<double, 4>, 9> printed = {{{1, 4, 4, 16},
                                                               {4, 12, 9, 39},
                                                               {16, 40, 25, 115},
                                                               {64, 144, 81, 387},
                                                               {256, 544, 289, 1411},
                                                               {1024, 2112, 1089, 5379},
                                                               {4096, 8320, 4225, 20995},
                                                               {16384, 33024, 16641, 82947},
                                                               {65536, 131584, 66049, 329731}}};
    const fvs::Hierarchy hierarchy = *fvs::Hierarchy::create(unit_square(), 8);
    for (int m = 0; m <= 8; ++m) {
        const mesh::Quadrangulation& level = hierarchy.mesh(m);
        const std::array<double, 4> ours = {double(level.quad_count()), double(level.edge_count()),
                                            double(level.vertex_count()),
                                            3.0 * level.vertex_count() + level.edge_count()};
        constexpr std::array<const char*, 4> names = {"quads", "edges", "vertices", "dimension"};
        for (std::size_t k = 0; k < 4; ++k)
            rows.add("table 1", fmt::format("{}, level {}", names[k], m),
                     printed[static_cast<std::size_t>(m)][k], ours[k]);
    }
}

// --- section 7

struct Errors {
    double largest = 0;
    double mean_square = 0;
};

Errors errors(const fvs::Hierarchy& hierarchy, int level, const fvs::NodalData& data,
              const Function& f) {
    std::vector<Vec2> points;
    for (int r = 0; r < kGrid; ++r)
        for (int c = 0; c < kGrid; ++c) points.push_back({c / (kGrid - 1.0), r / (kGrid - 1.0)});
    std::vector<PlaneJet> jets(points.size());
    if (!fvs::evaluate(hierarchy, level, data, points, jets).ok()) return {NAN, NAN};
    Errors e;
    for (std::size_t k = 0; k < points.size(); ++k) {
        const double d = std::abs(jets[k].value - f(points[k]).value);
        e.largest = std::max(e.largest, d);
        e.mean_square += d * d / static_cast<double>(points.size());
    }
    return e;
}

/// One line of numbers that the paper's section 7 prints.
struct Printed {
    double kept = 0;
    double largest = 0;
    double mean_square = 0;
    const char* note = "";
};

void add_case(Rows& rows, const std::string& item, const std::string& what, double kept,
              const Errors& e, const std::optional<Printed>& printed) {
    const auto paper = [&](double Printed::*number) {
        return printed ? std::optional(*printed.*number) : std::nullopt;
    };
    const std::string note = printed ? printed->note : "";
    rows.add(item, what + ": kept", paper(&Printed::kept), kept);
    rows.add(item, what + ": largest error", paper(&Printed::largest), e.largest, note);
    rows.add(item, what + ": mean square error", paper(&Printed::mean_square), e.mean_square, note);
}

struct Example {
    const char* name;
    Function f;
    int interpolation_level;  ///< of the uncompressed spline that the paper compares with
    Printed interpolation;
    std::vector<double> epsilons;
    double paper_epsilon;
    Printed compressed;
};

void section7(Rows& rows, const Example& example) {
    const std::string item = fmt::format("section 7, {}", example.name);
    const fvs::Hierarchy hierarchy = *fvs::Hierarchy::create(unit_square(), 6);
    const int level = example.interpolation_level;
    const fvs::NodalData low = fvs::interpolate(hierarchy.mesh(level), example.f);
    add_case(rows, item, fmt::format("level {}", level),
             static_cast<double>(3 * low.value.size() + low.normal.size()),
             errors(hierarchy, level, low, example.f), example.interpolation);
    const fvs::Decomposition full =
        *fvs::decompose(hierarchy, fvs::interpolate(hierarchy.mesh(6), example.f));
    for (const auto& [convention, name] :
         {std::pair{fvs::Convention::Const, "2^l eps"}, {fvs::Convention::Text, "2^m eps"}})
        for (const double epsilon : example.epsilons) {
            fvs::Decomposition kept = full;
            std::uint64_t count = 0;
            for (const std::uint64_t n :
                 fvs::threshold(kept, fvs::threshold_limits(hierarchy, epsilon, convention)))
                count += n;
            // The printed algorithm is "2^m eps", but only "2^l eps" gives the printed numbers.
            const bool printed =
                epsilon == example.paper_epsilon && convention == fvs::Convention::Const;
            add_case(rows, item, fmt::format("level 6, eps {}, {}", epsilon, name),
                     static_cast<double>(count),
                     errors(hierarchy, 6, *fvs::reconstruct(hierarchy, kept, 6), example.f),
                     printed ? std::optional(example.compressed) : std::nullopt);
        }
}

}  // namespace

std::vector<Row> fvs_rows() {
    Rows rows(kSource);
    table1(rows);
    section7(rows,
             {"f1 (Franke)",
              franke,
              1,
              {39, 0.25, 0.00625, "not reproduced by the printed function"},
              {0.001, 0.002, 0.005, 0.01, 0.02, 0.05},
              0.02,
              {37, 0.099, 0.0008, "count exact; the paper's f1 may differ from the printed"}});
    section7(rows, {"f2 (disc)",
                    disc,
                    3,
                    {387, 0.117, 0.000147, "the grid of the paper is not known"},
                    {0.0005, 0.001, 0.0023, 0.005, 0.01},
                    0.0023,
                    {385, 0.0074, 0.000004, "r0^2 = 1/128, r^2 for r: erratum"}});
    return std::move(rows).take();
}

}  // namespace relief::reproduce
