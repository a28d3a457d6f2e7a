#include "relief/codec/ps_codec.h"

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>

#include "../fuzz/ps.h"
#include "codec/value_lattice.h"
#include "franke.h"
#include "mesh/triangle_meshes.h"
#include "relief/core/parallel.h"
#include "relief/mesh/triangle_locator.h"
#include "relief/multires/ps_surface.h"

namespace relief::codec {
namespace {

using Kind = Goal::Kind;
using fuzz::splines_on;
using fuzz::values_on;
using mesh::Index;
using mesh::Triangulation;
using relief::test::Noise;
namespace ps = multires::ps;

PsFile opened(const Bytes& bytes) {
    auto file = PsFile::open(bytes);
    EXPECT_TRUE(file.ok()) << (file.ok() ? "" : file.error().text());
    return *std::move(file);
}

EncodedPs encoded(const PsModel& model, Goal goal, bool keep_order = true) {
    auto result = encode_ps(model, {.goal = goal, .keep_order = keep_order});
    EXPECT_TRUE(result.ok()) << (result.ok() ? "" : result.error().text());
    return *std::move(result);
}

void expect_same_mesh(const Triangulation& a, const Triangulation& b) {
    EXPECT_EQ(a.origin, b.origin);
    EXPECT_EQ(a.x, b.x);
    EXPECT_EQ(a.y, b.y);
    EXPECT_EQ(a.triangles, b.triangles);
    EXPECT_EQ(a.edges, b.edges);
}

/// A spline at points of the source, by evaluation alone.
std::vector<double> values_at(const ps::Space& space, const ps::Coefficients& spline,
                              const std::vector<Vec2>& points) {
    const auto surface = *ps::Surface::create(space, std::span(&spline, 1));
    const mesh::TriangleLocator locator(space.mesh);
    std::vector<spline::PlaneJet> jets(points.size());
    EXPECT_TRUE(evaluate(surface, locator, points, jets, ps::Outside::Nearest).ok());
    std::vector<double> values;
    for (const auto& jet : jets) values.push_back(jet.value);
    return values;
}

std::vector<Vec2> points_in(const Triangulation& mesh) {
    std::vector<Vec2> points;
    for (Index t = 0; t < mesh.triangle_count(); ++t) {
        const TriangleCorners c = mesh.corners(t);
        points.push_back(mesh.origin + (0.2 * c[0] + (0.3 * c[1] + 0.5 * c[2])));
        points.push_back(mesh.origin + (0.7 * c[0] + (0.1 * c[1] + 0.2 * c[2])));
    }
    return points;
}

/// Franke's function on scattered places.
PsModel franke_values(int count, bool decimals) {
    Triangulation mesh = fuzz::scattered(count, decimals);
    std::vector<double> values;
    for (Index v = 0; v < mesh.vertex_count(); ++v) {
        const Vec2 p = (decimals ? 0.01 : 1.0) * (mesh.origin + mesh.vertex(v));
        values.push_back(relief::test::franke(p.x, p.y).value);
    }
    return {std::move(mesh), PsValues{{values}}, {}};
}

PsModel franke_splines(int levels, int components = 1) {
    const Triangulation mesh = fuzz::scattered(14, false);
    const auto hierarchy = *ps::Hierarchy::create(*ps::make_space(mesh), levels);
    const ps::Space& space = hierarchy.space(levels);
    PsSplines splines{levels, {}};
    for (int c = 0; c < components; ++c) {
        auto& spline = splines.components.emplace_back();
        for (Index v = 0; v < space.mesh.vertex_count(); ++v) {
            const Vec2 p = space.mesh.origin + space.mesh.vertex(v);
            const auto jet = relief::test::franke(p.x, p.y);
            spline.push_back(ps::heights(space.control[v],
                                         {(1 + c) * jet.value, (1.0 + c) * Vec2{jet.x, jet.y}}));
        }
    }
    return {mesh, std::move(splines), {}};
}

const ps::Coefficients& spline_of(const PsModel& model, std::size_t component = 0) {
    return std::get<PsSplines>(model.surface).components[component];
}
const std::vector<double>& values_of(const PsModel& model) {
    return std::get<PsValues>(model.surface).components[0];
}

TEST(PsCodec, BasesAreKeptToTheBit) {
    for (const Triangulation& mesh : relief::test::triangulation_family()) {
        const PsModel model{mesh, values_on(mesh, 1, 0), {}};
        const EncodedPs file = encoded(model, {Kind::Lossless, 0});
        expect_same_mesh(opened(file.bytes).base(), mesh);
        EXPECT_EQ(file.report.vertices, mesh.vertex_count());
        EXPECT_EQ(file.report.triangles, mesh.triangle_count());
        EXPECT_EQ(file.report.max_error, 0);
        EXPECT_EQ(file.report.surface_bound, 0);
        EXPECT_EQ(opened(file.bytes).values()->components[0], values_of(model));
    }
}

TEST(PsCodec, DelaunayTrianglesCostNothing) {
    for (const bool decimals : {false, true}) {
        Noise noise(8);
        std::vector<Vec2> places;
        for (int k = 0; k < 400; ++k) {
            const Vec2 p = {noise(), noise()};
            places.push_back(decimals ? Vec2{std::rint(5000 * p.x) / 10, std::rint(5000 * p.y) / 10}
                                      : p);
        }
        const Triangulation mesh = (*mesh::delaunay(places)).mesh;
        const EncodedPs file = encoded({mesh, values_on(mesh, 1, 1), {}}, {Kind::Lossless, 0});
        EXPECT_TRUE(file.report.delaunay);
        expect_same_mesh(opened(file.bytes).base(), mesh);
        // A set of n of m places has log2(m^n / n!) bits; doubles lie on 2^51 lines each way.
        const double n = mesh.vertex_count();
        const double m = decimals ? 1e8 : 0x1p102;
        const double set = n * std::log2(m) - std::lgamma(n + 1) / std::log(2.0);
        const double bits = 8 * static_cast<double>(file.report.base_bytes);
        EXPECT_LT(bits, set + 0.5 * n + 8 * 20);
        EXPECT_GT(bits, set - 0.5 * n);
    }
}

TEST(PsCodec, DoublesOnNoGridAreKept) {
    std::vector<Vec2> places;
    for (const Vec2 p : points_in(fuzz::scattered(60, false)))
        places.push_back({p.x * p.x * p.x, std::sqrt(p.y)});  // bits far below the grid
    const auto delaunay = *mesh::delaunay(places);
    std::vector<Vec2> ordered(places.size());
    for (std::size_t k = 0; k < places.size(); ++k)
        ordered[delaunay.vertex_of_point[k]] = places[k];
    auto triangles = delaunay.mesh.triangles;
    for (const bool hole : {false, true}) {
        if (hole) triangles.erase(triangles.begin() + 40);
        const Triangulation mesh = *mesh::build(ordered, triangles);
        const EncodedPs file = encoded({mesh, values_on(mesh, 1, 0.5), {}}, {Kind::Lossless, 0});
        EXPECT_EQ(file.report.delaunay, !hole);
        expect_same_mesh(opened(file.bytes).base(), mesh);
    }
}

TEST(PsCodec, DelaunayTrianglesUnderOtherNumbers) {
    const Triangulation mesh = fuzz::scattered(200, true);
    std::vector<Index> number(mesh.x.size());
    std::iota(number.begin(), number.end(), 0U);
    std::shuffle(number.begin(), number.end(), std::mt19937(4));
    std::vector<Vec2> places(mesh.x.size());
    for (Index v = 0; v < mesh.vertex_count(); ++v)
        for (double Vec2::*axis : {&Vec2::x, &Vec2::y}) {
            const double decimal = mesh.origin.*axis + mesh.vertex(v).*axis;
            places[number[v]].*axis = std::rint(10 * decimal) / 10;
        }
    auto triangles = mesh.triangles;
    std::reverse(triangles.begin(), triangles.end());
    for (auto& corners : triangles) {
        for (Index& v : corners) v = number[v];
        std::rotate(corners.begin(), corners.begin() + corners[0] % 3, corners.end());
    }
    const Triangulation shuffled = *mesh::build(places, triangles);
    const PsModel model{shuffled, values_on(shuffled, 1, 0.1), {}};
    const EncodedPs kept = encoded(model, {Kind::Lossless, 0});
    EXPECT_TRUE(kept.report.delaunay);
    expect_same_mesh(opened(kept.bytes).base(), shuffled);
    EXPECT_EQ(opened(kept.bytes).values()->components[0], values_of(model));
    const EncodedPs free = encoded(model, {Kind::Lossless, 0}, false);
    EXPECT_LT(free.bytes.size() + 100, kept.bytes.size());
    const PsFile file = opened(free.bytes);
    EXPECT_EQ(file.base().triangles, mesh.triangles);
    for (Index v = 0; v < mesh.vertex_count(); ++v)
        EXPECT_EQ(file.values()->components[0][v], values_of(model)[number[v]]);
}

TEST(PsCodec, NumbersOfOtherTriangulationsMayBeGivenUp) {
    for (const Triangulation& mesh : relief::test::triangulation_family()) {
        const PsModel model{mesh, splines_on(mesh, 1, 1), {}};
        const EncodedPs file = encoded(model, {Kind::Lossless, 0}, false);
        const PsSurface surface = *opened(file.bytes).surface(0);
        const auto hierarchy = *ps::Hierarchy::create(*ps::make_space(mesh), 1);
        const std::vector<Vec2> points = points_in(mesh);
        const auto before = values_at(hierarchy.space(1), spline_of(model), points);
        const auto after = values_at(surface.space, surface.components[0], points);
        // Roundings of coordinates of 2e6, of whose product the heights are, and of their change.
        double largest = 1;
        for (const double z : before) largest = std::max(largest, std::abs(z));
        for (std::size_t k = 0; k < points.size(); ++k)
            EXPECT_NEAR(before[k], after[k], 1e-12 * largest);
    }
}

TEST(PsCodec, LosslessIsExactInEveryBit) {
    for (const int components : {1, 3})
        for (const int levels : {0, 2}) {
            const PsModel model = franke_splines(levels, components);
            const EncodedPs file = encoded(model, {Kind::Lossless, 0});
            EXPECT_EQ(file.report.max_error, 0);
            EXPECT_EQ(file.report.rms_error, 0);
            EXPECT_EQ(file.report.surface_bound, 0);
            EXPECT_TRUE(opened(file.bytes).lossless());
            const PsSurface surface = *opened(file.bytes).surface(0);
            for (int c = 0; c < components; ++c)
                EXPECT_EQ(surface.components[c], spline_of(model, static_cast<std::size_t>(c)));
            const auto numbers = static_cast<double>(file.report.coefficients);
            EXPECT_EQ(numbers, 3.0 * components * static_cast<double>(spline_of(model).size()));
            EXPECT_LT(file.report.bits_per_sample, 64 + 8 * 500 / numbers);
        }
}

TEST(PsCodec, NoPointOfTheSurfaceExceedsTheBound) {
    const PsModel model = franke_splines(2, 2);
    const auto hierarchy = *ps::Hierarchy::create(*ps::make_space(model.base), 2);
    const std::vector<Vec2> points = points_in(hierarchy.space(2).mesh);
    for (const double bound : {0.1, 0.001}) {
        const EncodedPs coded = encoded(model, {Kind::MaxError, bound});
        EXPECT_LE(coded.report.max_error, bound);
        EXPECT_EQ(coded.report.bound, bound);
        EXPECT_EQ(coded.report.max_error, coded.report.surface_bound);
        const PsFile file = opened(coded.bytes);
        EXPECT_GE(*file.bound(0), coded.report.max_error);
        EXPECT_LE(*file.bound(0), bound);
        for (std::size_t c = 0; c < 2; ++c) {
            const auto exact = values_at(hierarchy.space(2), spline_of(model, c), points);
            for (int level = 0; level <= 2; ++level) {
                const PsSurface surface = *file.surface(level);
                const auto decoded = values_at(surface.space, surface.components[c], points);
                for (std::size_t k = 0; k < points.size(); ++k)
                    EXPECT_LE(std::abs(decoded[k] - exact[k]), *file.surface_bound(level) + 1e-14);
                EXPECT_FALSE(level > 0 && file.bound(level));
            }
        }
    }
}

TEST(PsCodec, RmsIsThatOfTheSurface) {
    const PsModel model = franke_splines(2);
    const auto hierarchy = *ps::Hierarchy::create(*ps::make_space(model.base), 2);
    for (const double target : {0.02, 0.0005}) {
        const EncodedPs coded = encoded(model, {Kind::RmsError, target});
        EXPECT_LE(coded.report.rms_error, target);
        EXPECT_GE(coded.report.rms_error, 0.9 * target);
        const PsSurface surface = *opened(coded.bytes).surface(0);
        // By midpoints of the sides of triangles cut in 64, exact for quadratics: of the sixes of
        // each triangle the borders are crossed, hence 2 per cent.
        const auto& mesh = surface.space.mesh;
        double square = 0;
        double area = 0;
        std::vector<Vec2> points;
        std::vector<double> weights;
        for (Index t = 0; t < mesh.triangle_count(); ++t) {
            const TriangleCorners c = mesh.corners(t);
            for (int i = 0; i < 8; ++i)
                for (int j = 0; j < 8 - i; ++j) {
                    const double a = (i + 1.0 / 3) / 8;
                    const double b = (j + 1.0 / 3) / 8;
                    points.push_back(mesh.origin + (a * c[0] + (b * c[1] + (1 - a - b) * c[2])));
                    weights.push_back(orient(c[0], c[1], c[2]));
                }
        }
        const auto exact = values_at(hierarchy.space(2), spline_of(model), points);
        const auto decoded = values_at(surface.space, surface.components[0], points);
        for (std::size_t k = 0; k < points.size(); ++k) {
            square += weights[k] * (decoded[k] - exact[k]) * (decoded[k] - exact[k]);
            area += weights[k];
        }
        EXPECT_NEAR(std::sqrt(square / area), coded.report.rms_error, 0.02 * target);
    }
}

TEST(PsCodec, KeepDropsDetailsOfSmallNorm) {
    const PsModel model = franke_splines(2);
    double before = INFINITY;
    for (const double percent : {0.0, 5.0, 20.0, 100.0}) {
        const EncodedPs coded = encoded(model, {Kind::Keep, percent});
        const auto numbers = static_cast<double>(coded.report.coefficients);
        const double base = 3.0 * static_cast<double>(coded.report.vertices);
        // Those below half a step of 2^-24 of the largest are zero all the same.
        EXPECT_LE(coded.report.kept, std::max(base, percent / 100 * numbers));
        EXPECT_GE(coded.report.kept, std::max(base, 0.95 * percent / 100 * numbers));
        EXPECT_LT(coded.report.rms_error, before);
        before = coded.report.rms_error;
        if (percent == 0) {
            EXPECT_NEAR(coded.report.energy_percent, 100, 1e-3);
        }
    }
    EXPECT_LT(before, 1e-6);  // 2^-24 of the largest height, not of each
    const auto refused = encode_ps(franke_values(30, false), {.goal = {Kind::Keep, 50}});
    EXPECT_EQ(refused.error().code, ErrorCode::InvalidArgument);
}

TEST(PsCodec, ByteGoals) {
    for (const PsModel& model : {franke_splines(2), franke_values(500, true)}) {
        const auto lossless = encoded(model, {Kind::Lossless, 0}).bytes.size();
        const auto least = encoded(model, {Kind::MaxError, 100}).bytes.size();
        const auto half = static_cast<double>(lossless + least) / 2;
        const EncodedPs coded = encoded(model, {Kind::Bytes, half});
        EXPECT_LE(coded.bytes.size(), half);
        EXPECT_GE(coded.bytes.size(), 0.95 * half - 40);
        EXPECT_EQ(coded.bytes.size(), coded.report.bytes);
        const auto tiny = encode_ps(model, {.goal = {Kind::Bytes, 50}});
        ASSERT_FALSE(tiny.ok());
        EXPECT_EQ(tiny.error().code, ErrorCode::InvalidArgument);
    }
}

TEST(PsCodec, ValuesAreWithinTheBound) {
    for (const bool decimals : {false, true})
        for (const double bound : {0.05, 0.001}) {
            const PsModel model = franke_values(300, decimals);
            const EncodedPs coded = encoded(model, {Kind::MaxError, bound});
            const PsFile file = opened(coded.bytes);
            const auto values = file.values()->components[0];
            double most = 0;
            for (std::size_t v = 0; v < values.size(); ++v)
                most = std::max(most, std::abs(values[v] - values_of(model)[v]));
            EXPECT_LE(most, bound);
            EXPECT_EQ(most, coded.report.max_error);
            // The surface goes through them with the gradients that anyone estimates.
            const PsSurface surface = *file.surface(0);
            const auto slopes = *ps::estimate_gradients(model.base, values);
            for (Index v = 0; v < model.base.vertex_count(); ++v) {
                const auto plane =
                    ps::tangent_plane(surface.space.control[v], surface.components[0][v]);
                // Heights as far as 1 off, gradients times neighbours' distances of 0.05 or 5.
                EXPECT_NEAR(plane.value, values[v], 1e-12);
                EXPECT_NEAR(plane.gradient.x, slopes[v].x, 1e-10 * (decimals ? 1 : 100));
            }
        }
}

TEST(PsCodec, GradientOptionsAreKept) {
    PsModel model = franke_values(60, false);
    std::get<PsValues>(model.surface).gradients = {ps::GradientRule::Quadratic, 0.25, INFINITY};
    const PsFile file = opened(encoded(model, {Kind::Lossless, 0}).bytes);
    const PsValues values = *file.values();
    EXPECT_EQ(values.gradients.rule, ps::GradientRule::Quadratic);
    EXPECT_EQ(values.gradients.tilt, 0.25);
    EXPECT_EQ(values.gradients.limit, INFINITY);
}

TEST(PsCodec, ErrorsAreMeasuredAtTheData) {
    PsModel model = franke_values(200, false);
    const auto space = *ps::make_space(model.base);
    Noise noise(3);
    for (int k = 0; k < 2000; ++k) {
        const Vec2 p = {0.5 + 0.45 * noise(), 0.5 + 0.45 * noise()};
        model.data.points.push_back(p);
        model.data.weights.push_back(k % 2 == 0 ? 1 : 3);
    }
    model.data.values = {std::vector<double>()};
    for (const Vec2& p : model.data.points)
        model.data.values[0].push_back(relief::test::franke(p.x, p.y).value);
    const EncodedPs exact = encoded(model, {Kind::Lossless, 0});
    EXPECT_GT(exact.report.max_error, 0);
    EXPECT_EQ(exact.report.surface_bound, 0);
    EXPECT_EQ(exact.report.samples, 2000);
    const double goal = 1.5 * exact.report.max_error;
    const EncodedPs coded = encoded(model, {Kind::MaxError, goal});
    const PsSurface surface = *opened(coded.bytes).surface(0);
    const auto decoded = values_at(surface.space, surface.components[0], model.data.points);
    double most = 0;
    double square = 0;
    for (std::size_t k = 0; k < decoded.size(); ++k) {
        const double error = std::abs(decoded[k] - model.data.values[0][k]);
        most = std::max(most, error);
        square += model.data.weights[k] * error * error;
    }
    EXPECT_LE(most, goal);
    EXPECT_NEAR(most, coded.report.max_error, 1e-14);  // points are located alike, and rounded
    EXPECT_NEAR(std::sqrt(square / 4000), coded.report.rms_error, 1e-14);
    EXPECT_LT(coded.bytes.size(), exact.bytes.size());
    const auto refused = encode_ps(model, {.goal = {Kind::MaxError, 0.5 * exact.report.max_error}});
    ASSERT_FALSE(refused.ok());
    EXPECT_EQ(refused.error().code, ErrorCode::InvalidArgument);
    EXPECT_NE(refused.error().message.find("misses the data"), std::string::npos);
}

TEST(PsCodec, PrefixesAreCoarserSurfaces) {
    const PsModel model = franke_splines(2);
    const Bytes bytes = encoded(model, {Kind::MaxError, 0.001}).bytes;
    const auto source = std::make_shared<MemorySource>(bytes);
    const PsFile whole = opened(bytes);
    for (int level = 0; level <= 2; ++level) {
        const auto prefix = PsFile::open(source, whole.bytes_for(level));
        ASSERT_TRUE(prefix.ok());
        // The correction is empty, so the last level is complete with its own chunk.
        EXPECT_EQ(prefix->finest_level(), level);
        EXPECT_EQ(prefix->surface(level)->components, whole.surface(level)->components);
        if (level > 0) {
            EXPECT_EQ(prefix->surface(level - 1).error().code, ErrorCode::BadFile);
        }
        EXPECT_EQ(prefix->counts(level).vertices, whole.surface(level)->space.mesh.vertex_count());
    }
    EXPECT_FALSE(PsFile::open(source, whole.bytes_for(2) - 1).ok());
}

TEST(PsCodec, MovesArePlanesThatAreRefined) {
    const PsModel model = franke_splines(2, 2);
    const Bytes bytes = encoded(model, {Kind::MaxError, 0.001}).bytes;
    const PsFile before = opened(bytes);
    const PsMove move{2, 5, 1, 0.75, {2, -3}};
    const PsFile after = opened(*add_ps_moves(bytes, {move}));
    EXPECT_TRUE(after.edited());
    EXPECT_EQ(after.moves(), std::vector{move});
    EXPECT_FALSE(after.bound(0));
    EXPECT_FALSE(after.surface_bound(2));
    // What is added is one spline of the coarsest level, on all levels.
    const ps::Space coarse = before.surface(2)->space;
    ps::Coefficients bump(coarse.mesh.x.size());
    bump[5] = ps::heights(coarse.control[5], {0.75, {2, -3}});
    const std::vector<Vec2> points = points_in(coarse.mesh);
    const auto rise = values_at(coarse, bump, points);
    EXPECT_GT(*std::max_element(rise.begin(), rise.end()), 0.1);
    for (int level = 0; level <= 2; ++level) {
        const PsSurface a = *before.surface(level);
        const PsSurface b = *after.surface(level);
        EXPECT_EQ(a.components[0], b.components[0]);
        const auto old = values_at(a.space, a.components[1], points);
        const auto moved = values_at(b.space, b.components[1], points);
        for (std::size_t k = 0; k < points.size(); ++k)
            EXPECT_NEAR(moved[k], old[k] + rise[k], 1e-13);
    }
    // Moves of the finest level stay where they are.
    const PsFile fine = opened(*add_ps_moves(bytes, {{0, 100, 0, 1, {}}}));
    EXPECT_EQ(fine.surface(1)->components, before.surface(1)->components);
    const PsSurface moved = *fine.surface(0);
    const PsSurface still = *before.surface(0);
    for (Index v = 0; v < moved.space.mesh.vertex_count(); ++v)
        for (std::size_t j = 0; j < 3; ++j)
            EXPECT_EQ(moved.components[0][v][j], still.components[0][v][j] + (v == 100 ? 1 : 0));
}

TEST(PsCodec, MovesThatDoNotExist) {
    const Bytes bytes = encoded(franke_splines(1), {Kind::MaxError, 0.01}).bytes;
    for (const auto& [move, says] :
         std::vector<std::pair<PsMove, std::string>>{{{1, 14, 0, 1, {}}, "vertices 0 to 13"},
                                                     {{2, 0, 0, 1, {}}, "levels 0 to 1"},
                                                     {{-1, 0, 0, 1, {}}, "levels 0 to 1"},
                                                     {{0, 0, 1, 1, {}}, "components 0 to 0"},
                                                     {{0, 0, 0, INFINITY, {}}, "1e150"},
                                                     {{0, 0, 0, 0, {0, std::nan("")}}, "1e150"}}) {
        const auto moved = add_ps_moves(bytes, {move});
        ASSERT_FALSE(moved.ok());
        EXPECT_EQ(moved.error().code, ErrorCode::InvalidArgument);
        EXPECT_NE(moved.error().message.find(says), std::string::npos) << moved.error().text();
    }
}

TEST(PsCodec, FilesKeepWhatNumbersAre) {
    PsModel model = franke_values(30, true);
    const PsFile plain = *PsFile::open(encode_ps(model, {})->bytes);
    EXPECT_EQ(plain.reference(), PsReference());
    model.reference = {"EPSG:32633", "m"};
    const Bytes bytes = encode_ps(model, {})->bytes;
    EXPECT_EQ(PsFile::open(bytes)->reference(), model.reference);
    EXPECT_EQ(PsFile::open(*add_ps_moves(bytes, {{0, 3, 0, 1, {}}}))->reference(), model.reference);
    model.reference.unit = "\xB0";  // a degree sign that is not UTF-8
    EXPECT_EQ(PsFile::open(encode_ps(model, {})->bytes)->reference().unit, "\uFFFD");
}

TEST(PsCodec, BadModelsAreNamed) {
    const PsModel good = franke_splines(1);
    const auto refused = [](const PsModel& model, const std::string& name) {
        const auto file = encode_ps(model, {});
        ASSERT_FALSE(file.ok()) << name;
        EXPECT_TRUE(file.error().message.starts_with(name)) << file.error().text();
    };
    PsModel model = good;
    std::get<PsSplines>(model.surface).components[0][3][1] = std::nan("");
    refused(model, "non_finite");
    model = good;
    std::get<PsSplines>(model.surface).levels = 0;
    refused(model, "size_mismatch");
    model = good;
    std::get<PsSplines>(model.surface).components.clear();
    refused(model, "component_count");
    model = good;
    std::swap(model.base.triangles[0][0], model.base.triangles[0][1]);
    refused(model, "clockwise");
    model = good;
    model.data = {{{0.5, 0.5}}, {{1}, {2}}, {}};
    refused(model, "size_mismatch");
    model = franke_values(20, false);
    std::get<PsValues>(model.surface).components[0][3] = INFINITY;
    refused(model, "non_finite_data");
    for (const Goal goal : {Goal{Kind::MaxError, -1}, Goal{Kind::RmsError, std::nan("")},
                            Goal{Kind::Bytes, INFINITY}, Goal{Kind::Bytes, 0}})
        EXPECT_EQ(encode_ps(good, {.goal = goal}).error().code, ErrorCode::InvalidArgument);
}

TEST(PsCodec, CanBeCancelled) {
    const auto cancelled = encode_ps(franke_splines(1), {.goal = {Kind::MaxError, 0.01},
                                                         .progress = [](double) { return false; }});
    EXPECT_EQ(cancelled.error().code, ErrorCode::Cancelled);
}

TEST(PsCodec, SameBytesForAnyNumberOfThreads) {
    std::vector<Bytes> files;
    for (const int threads : {1, 2, 5}) {
        set_thread_count(threads);
        files.push_back(encoded(franke_splines(2), {Kind::RmsError, 0.001}).bytes);
        files.push_back(encoded(franke_values(700, true), {Kind::MaxError, 0.001}).bytes);
    }
    set_thread_count(0);
    for (std::size_t k = 2; k < files.size(); ++k) EXPECT_EQ(files[k], files[k % 2]);
}

TEST(PsCodec, RandomModels) {
    rc::check("values and bases come back within the bound", [] {
        const int count = *rc::gen::inRange(3, 40);
        const int digits = *rc::gen::inRange(0, 4);
        const auto cells = static_cast<int>(power_of_ten(digits));
        std::vector<Vec2> places;
        std::vector<double> values;
        for (int k = 0; k < count; ++k) {
            places.push_back({*rc::gen::inRange(-9 * cells, 9 * cells) / power_of_ten(digits),
                              *rc::gen::inRange(-9 * cells, 9 * cells) / power_of_ten(digits)});
            values.push_back(*rc::gen::inRange(-1000, 1000) / 8.0);
        }
        const auto delaunay = mesh::delaunay(places);
        RC_PRE(delaunay.ok());
        values.resize(delaunay->mesh.x.size());
        const double bound = *rc::gen::element(0.0, 0.3, 40.0);
        const PsModel model{delaunay->mesh, PsValues{{values}}, {}};
        const auto coded = encode_ps(model, {.goal = {Kind::MaxError, bound}});
        RC_ASSERT(coded.ok());
        RC_ASSERT(coded->report.delaunay);
        RC_ASSERT(coded->report.max_error <= bound);
        RC_ASSERT(opened(coded->bytes).base().x == model.base.x);
    });
}

}  // namespace
}  // namespace relief::codec
