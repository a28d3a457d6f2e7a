#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <numeric>
#include <random>

#include "../fuzz/quads.h"
#include "codec/number_coder.h"
#include "codec/value_lattice.h"
#include "mesh/meshes.h"
#include "multires/fvs_functionals.h"
#include "relief/core/parallel.h"

namespace relief::codec {
namespace {

using Kind = Goal::Kind;
using test::built;
using test::Noise;
namespace fvs_mesh = multires::fvs_mesh;

double height(Vec2 p) {
    return 2 * std::exp(-0.1 * (p.x - 2) * (p.x - 2) - 0.2 * (p.y - 1) * (p.y - 1)) + 0.3 * p.x -
           0.02 * p.x * p.y;
}

/// The surface of `height` on a mesh refined some times, with noise.
QuadMesh surface_on(mesh::Quadrangulation plane, int levels, double noise = 0) {
    for (int m = 0; m < levels; ++m) plane = *refine(plane);
    Noise random(11);
    QuadMesh mesh{{}, plane.quads};
    for (mesh::Index v = 0; v < plane.vertex_count(); ++v) {
        const Vec2 p = plane.origin + plane.vertex(v);
        const Vec2 near = 0.01 * (p - plane.origin);
        mesh.vertices.push_back({p.x, p.y, height(100 * near) + noise * random()});
    }
    return mesh;
}

QuadMesh shuffled(const QuadMesh& mesh, unsigned seed) {
    std::mt19937 engine(seed);
    std::vector<mesh::Index> number(mesh.vertices.size());
    std::iota(number.begin(), number.end(), 0U);
    std::shuffle(number.begin(), number.end(), engine);
    QuadMesh out;
    out.vertices.resize(number.size());
    for (std::size_t v = 0; v < number.size(); ++v) out.vertices[number[v]] = mesh.vertices[v];
    for (auto quad : mesh.quads) {
        for (mesh::Index& v : quad) v = number[v];
        std::rotate(quad.begin(), quad.begin() + static_cast<int>(engine() % 4), quad.end());
        out.quads.push_back(quad);
    }
    std::shuffle(out.quads.begin(), out.quads.end(), engine);
    return out;
}

EncodedQuads encoded(const QuadMesh& mesh, Goal goal, int levels = -1) {
    auto result = encode_quads(mesh, {.goal = goal, .levels = levels});
    EXPECT_TRUE(result.ok()) << (result.ok() ? "" : result.error().text());
    return *std::move(result);
}
QuadFile opened(const Bytes& bytes) {
    auto file = QuadFile::open(bytes);
    EXPECT_TRUE(file.ok()) << (file.ok() ? "" : file.error().text());
    return *std::move(file);
}

double largest_difference(const QuadMesh& a, const QuadMesh& b) {
    double most = a.vertices.size() == b.vertices.size() ? 0 : INFINITY;
    for (std::size_t v = 0; v < std::min(a.vertices.size(), b.vertices.size()); ++v)
        most = std::max(most, std::abs(a.vertices[v][2] - b.vertices[v][2]));
    return most;
}
void expect_same_plane(const QuadMesh& a, const QuadMesh& b) {
    EXPECT_EQ(a.quads, b.quads);
    ASSERT_EQ(a.vertices.size(), b.vertices.size());
    for (std::size_t v = 0; v < a.vertices.size(); ++v) {
        EXPECT_EQ(a.vertices[v][0], b.vertices[v][0]);
        EXPECT_EQ(a.vertices[v][1], b.vertices[v][1]);
    }
}

TEST(ValueLattice, FindsDecimals) {
    EXPECT_EQ(decimal_digits(std::vector<double>{1, -3, 0}), 0);
    EXPECT_EQ(decimal_digits(std::vector<double>{0.1, 2.25, -1e6}), 2);
    EXPECT_EQ(decimal_digits(std::vector<double>{1.0 / 1024}), 10);
    EXPECT_FALSE(decimal_digits(std::vector<double>{1.0 / 3}));
    EXPECT_FALSE(decimal_digits(std::vector<double>{-0.0}));
    EXPECT_FALSE(decimal_digits(std::vector<double>{INFINITY}));
    EXPECT_FALSE(decimal_digits(std::vector<double>{1e15, 0.001}));  // not both below 2^50
}

TEST(ValueLattice, ExactLatticesGiveBackEveryBit) {
    std::mt19937_64 engine(3);
    for (const std::vector<double>& values :
         {std::vector<double>{0.1, 123.45, -7, 0}, std::vector<double>{0.1F, -0.0F, 3e38F},
          std::vector<double>{0.1, 1.0 / 3, -0.0, 1e-310, -1e150}}) {
        const ValueLattice lattice = ValueLattice::exact(values);
        for (const double value : values)
            EXPECT_EQ(ordinal_of(lattice.value(lattice.nearest(value))), ordinal_of(value));
    }
    for (int k = 0; k < 1000; ++k) {
        const auto ordinal = static_cast<std::int64_t>(engine());
        if (!std::isnan(double_at(ordinal))) {
            EXPECT_EQ(ordinal_of(double_at(ordinal)), ordinal);
        }
    }
    EXPECT_LT(ordinal_of(-1.0), ordinal_of(-0.0));
    EXPECT_EQ(ordinal_of(std::nextafter(1.0, 2.0)), ordinal_of(1.0) + 1);
}

TEST(ValueLattice, ToleranceIsMet) {
    const ValueLattice cents{.kind = ValueLattice::Kind::Decimal, .digits = 2};
    EXPECT_EQ(cents.within(0.05).multiple, 11);
    EXPECT_EQ(cents.within(0.009).multiple, 1);
    EXPECT_EQ(cents.within(1).multiple, 201);
    const ValueLattice odd = cents.within(0.05);
    for (int k = -500; k <= 500; ++k)
        EXPECT_LE(std::abs(odd.value(odd.nearest(k / 100.0)) - k / 100.0), 0.05 + 1e-15);
    const ValueLattice doubles{.kind = ValueLattice::Kind::Float64};
    EXPECT_EQ(doubles.within(0.25).step, 0.5);
    EXPECT_EQ(doubles.within(0.25).nearest(-1.3), -3);
}

TEST(NumberCoder, CodesEveryInteger) {
    std::mt19937_64 engine(1);
    std::vector<std::int64_t> numbers = {0, 1, -1, 2, INT64_MAX, INT64_MIN, INT64_MIN + 1, -5};
    for (int k = 0; k < 4000; ++k)
        numbers.push_back(static_cast<std::int64_t>(engine()) >> (engine() % 64));
    const auto run = [&](auto& coder, const std::vector<std::int64_t>* source) {
        NumberModel model;
        NumberCoder numbers_coder(coder, model);
        std::vector<std::int64_t> out;
        for (std::size_t k = 0; k < numbers.size(); ++k) {
            Surrounding near;
            Surrounding far;
            for (std::size_t j = 1; j <= std::min<std::size_t>(k, 3); ++j) near.add(out[k - j]);
            if (k > 100) far.add(out[k - 100]);
            const auto kind = static_cast<std::uint32_t>(k % NumberModel::kKinds);
            out.push_back(numbers_coder.code(source ? (*source)[k] : 0, kind, near, far));
        }
        return out;
    };
    RangeEncoder encoder;
    EXPECT_EQ(run(encoder, &numbers), numbers);
    const Bytes bytes = encoder.finish();
    RangeDecoder decoder(bytes);
    EXPECT_EQ(run(decoder, nullptr), numbers);
    EXPECT_TRUE(decoder.at_end());
}

TEST(NumberCoder, LearnsQuickly) {
    RangeEncoder zeros;
    NumberModel model;
    NumberCoder coder(zeros, model);
    Surrounding near;
    for (int k = 0; k < 20000; ++k) {
        coder.code(0, 0, near, near);
        near.add(0);
    }
    EXPECT_LT(zeros.finish().size(), 20U);
    // Geometric numbers of mean 4: 1 + log2(..) bits of entropy, here 4.6 with the sign.
    std::mt19937 engine(4);
    std::geometric_distribution<int> magnitude(0.2);
    RangeEncoder noise;
    NumberModel fresh;
    NumberCoder again(noise, fresh);
    Surrounding around;
    for (int k = 0; k < 5000; ++k) {
        const int q = magnitude(engine) * (engine() % 2 ? 1 : -1);
        again.code(q, 0, around, around);
        if (k % 8 == 0) around = {};
        around.add(q);
    }
    EXPECT_LT(noise.finish().size(), 5000 * 4.6 / 8);
}

TEST(QuadFile, LosslessIsExactInEveryBitAndNumber) {
    unsigned seed = 1;
    for (const auto& base : test::mesh_family())
        for (const int levels : {0, 2}) {
            const QuadMesh mesh = shuffled(surface_on(base, levels, 0.01), seed++);
            const EncodedQuads file = encoded(mesh, {Kind::Lossless, 0});
            EXPECT_GE(file.report.levels, levels);
            EXPECT_EQ(file.report.max_error, 0);
            EXPECT_EQ(file.report.surface_bound, 0);
            EXPECT_EQ(file.report.bytes, file.bytes.size());
            const auto decoded = opened(file.bytes).decode(0);
            ASSERT_TRUE(decoded.ok()) << decoded.error().text();
            EXPECT_EQ(*decoded, mesh);
        }
}

TEST(QuadFile, DecimalsAndFloatsCostLess) {
    QuadMesh mesh = surface_on(built(test::grid_mesh(12, 12, 1, 0.15)), 0);
    const auto bytes_with = [&](auto round) {
        QuadMesh rounded = mesh;
        for (auto& vertex : rounded.vertices) vertex[2] = round(vertex[2]);
        const EncodedQuads file = encoded(rounded, {Kind::Lossless, 0});
        EXPECT_EQ(*opened(file.bytes).decode(0), rounded);
        return file.bytes.size();
    };
    const auto doubles = bytes_with([](double z) { return z; });
    const auto floats = bytes_with([](double z) { return static_cast<float>(z); });
    const auto cents = bytes_with([](double z) { return std::rint(100 * z) / 100; });
    EXPECT_LT(static_cast<double>(floats), static_cast<double>(doubles) - 169 * 29.0 / 8 * 0.9);
    EXPECT_LT(cents, floats - 169);
}

/// Headers keep four digits of errors, rounded up.
void expect_stated(double stated, double error) {
    EXPECT_GE(stated, error);
    EXPECT_LE(stated, error * (1 + 1.001e-3));
}

TEST(QuadFile, NoVertexExceedsTheBoundAndNoPointTheCertificate) {
    for (const auto& base : test::mesh_family())
        for (const int levels : {0, 2})
            for (const double tolerance : {0.5, 0.01}) {
                const QuadMesh mesh = surface_on(base, levels, 0.003);
                const EncodedQuads coded = encoded(mesh, {Kind::MaxError, tolerance});
                const QuadFile file = opened(coded.bytes);
                const QuadMesh decoded = *file.decode(0);
                expect_same_plane(decoded, mesh);
                EXPECT_LE(largest_difference(decoded, mesh), tolerance);
                EXPECT_EQ(largest_difference(decoded, mesh), coded.report.max_error);
                EXPECT_EQ(coded.report.bound, tolerance);
                expect_stated(*file.bound(0), coded.report.max_error);
                EXPECT_LE(*file.bound(0), tolerance);

                const QuadFile lossless = opened(encoded(mesh, {Kind::Lossless, 0}).bytes);
                const QuadSurface original = *lossless.surface(0);
                std::vector<Vec2> points;
                const auto& finest = original.hierarchy.mesh(original.level());
                for (mesh::Index q = 0; q < finest.quad_count(); ++q) {
                    const QuadCorners v = finest.corners(q);
                    points.push_back(finest.origin + diagonals(v).centre);
                    points.push_back(finest.origin + 0.6 * v[0] + 0.3 * v[1] + 0.1 * v[2]);
                }
                std::vector<spline::PlaneJet> exact(points.size());
                ASSERT_TRUE(fvs_mesh::evaluate(original.hierarchy, original.level(), original.data,
                                               points, exact, fvs_mesh::Outside::Clamp)
                                .ok());
                for (int level = 0; level <= file.levels(); ++level) {
                    const QuadSurface surface = *file.surface(level);
                    std::vector<spline::PlaneJet> jets(points.size());
                    ASSERT_TRUE(fvs_mesh::evaluate(surface.hierarchy, surface.level(), surface.data,
                                                   points, jets, fvs_mesh::Outside::Clamp)
                                    .ok());
                    for (std::size_t k = 0; k < points.size(); ++k)
                        EXPECT_LE(std::abs(jets[k].value - exact[k].value),
                                  *file.surface_bound(level));
                }
                expect_stated(*file.surface_bound(0), coded.report.surface_bound);
            }
}

TEST(QuadFile, LevelsAreTheVerticesOfTheCoarserMeshes) {
    const auto base = built(test::star_mesh(5));
    const QuadMesh mesh = surface_on(base, 3, 0.01);
    const QuadFile file = opened(encoded(mesh, {Kind::Lossless, 0}).bytes);
    ASSERT_EQ(file.levels(), 3);
    mesh::Quadrangulation plane = base;
    for (int level = 3; level >= 0; --level) {
        const QuadMesh decoded = *file.decode(level);
        EXPECT_EQ(decoded.quads, plane.quads);
        ASSERT_EQ(decoded.vertices.size(), plane.vertex_count());
        for (mesh::Index v = 0; v < plane.vertex_count(); ++v)
            EXPECT_EQ(decoded.vertices[v][2], mesh.vertices[v][2]) << level << " " << v;
        for (mesh::Index v = 0; v < plane.vertex_count(); ++v)
            for (const std::size_t k : {0U, 1U})  // coordinates below 2, a rounding for each level
                EXPECT_NEAR(decoded.vertices[v][k], mesh.vertices[v][k], 4 * 4.5e-16);
        plane = *refine(plane);
    }
    const Status missing = file.decode(4).ok() ? Status() : Status(file.decode(4).error());
    EXPECT_FALSE(missing.ok());
    EXPECT_NE(missing.error().message.find("levels 0 to 3"), std::string::npos);
}

TEST(QuadFile, LevelsCanBeFewer) {
    const QuadMesh mesh = surface_on(built(test::grid_mesh(8, 8)), 0);
    EXPECT_EQ(encoded(mesh, {Kind::Lossless, 0}).report.levels, 3);
    EXPECT_EQ(encoded(mesh, {Kind::Lossless, 0}, 1).report.levels, 1);
    EXPECT_EQ(encoded(mesh, {Kind::Lossless, 0}, 0).report.levels, 0);
    const auto more = encode_quads(mesh, {.goal = {Kind::Lossless, 0}, .levels = 4});
    ASSERT_FALSE(more.ok());
    EXPECT_EQ(more.error().code, ErrorCode::InvalidArgument);
}

TEST(QuadFile, RmsAndByteGoals) {
    for (const int levels : {0, 3}) {
        const QuadMesh mesh = surface_on(built(test::grid_mesh(5, 4, 1, 0.15)), levels, 0.05);
        for (const double target : {0.2, 0.01}) {
            const EncodedQuads file = encoded(mesh, {Kind::RmsError, target});
            const QuadMesh decoded = *opened(file.bytes).decode(0);
            double sum = 0;
            for (std::size_t v = 0; v < mesh.vertices.size(); ++v)
                sum += std::pow(decoded.vertices[v][2] - mesh.vertices[v][2], 2);
            const double rms = std::sqrt(sum / static_cast<double>(mesh.vertices.size()));
            EXPECT_LE(rms, target);
            EXPECT_GE(rms, 0.7 * target);  // 30 vertices: a step further misses the goal
            EXPECT_NEAR(rms, file.report.rms_error, 1e-12);
        }
        const auto lossless = encoded(mesh, {Kind::Lossless, 0}).bytes.size();
        const auto large = static_cast<double>(lossless + 40);
        EXPECT_EQ(encoded(mesh, {Kind::Bytes, large}).report.max_error, 0);
        const auto least = encoded(mesh, {Kind::MaxError, 100}).bytes.size();
        const double half = static_cast<double>(lossless + least) / 2;
        const EncodedQuads file = encoded(mesh, {Kind::Bytes, half});
        EXPECT_LE(file.bytes.size(), half);
        EXPECT_GE(file.bytes.size(), half - 80);
        EXPECT_GT(file.report.max_error, 0);
        const auto tiny = encode_quads(mesh, {.goal = {Kind::Bytes, 50}});
        EXPECT_FALSE(tiny.ok());
    }
}

TEST(QuadFile, KeepDropsSmallDetails) {
    const QuadMesh mesh = surface_on(built(test::grid_mesh(2, 2, 1, 0.1)), 3);
    const std::int64_t vertices = 17 * 17;
    const EncodedQuads some = encoded(mesh, {Kind::Keep, 50});
    EXPECT_EQ(some.report.samples, vertices);
    EXPECT_EQ(some.report.coefficients, 3 * vertices + 2 * 16 * 17);
    EXPECT_EQ(some.report.kept, vertices / 2);
    EXPECT_GT(some.report.energy_percent, 0);
    EXPECT_LT(some.report.energy_percent, 1);
    EXPECT_LE(some.report.max_error, some.report.surface_bound);
    const QuadFile file = opened(some.bytes);
    EXPECT_FALSE(file.holds_values());
    EXPECT_EQ(largest_difference(*file.decode(0), mesh), some.report.max_error);
    // All of them, to 2^-24 of the largest value and derivatives over four levels.
    const EncodedQuads all = encoded(mesh, {Kind::Keep, 1000});
    EXPECT_EQ(all.report.kept, all.report.coefficients);
    EXPECT_LT(all.report.max_error, 1e-6);
    EXPECT_LT(some.bytes.size(), all.bytes.size() / 4);
    const EncodedQuads none = encoded(mesh, {Kind::Keep, 0});
    EXPECT_EQ(none.report.kept, 3 * 9 + 12);
    EXPECT_GT(none.report.max_error, some.report.max_error);
    EXPECT_FALSE(
        encode_quads(surface_on(built(test::star_mesh(3)), 0), {.goal = {Kind::Keep, 50}}).ok());
}

TEST(QuadFile, TheRefinedNumberingCostsNothing) {
    const QuadMesh mesh = surface_on(built(test::grid_mesh(3, 2, 0.5, 0.1)), 3);
    const QuadMesh other = shuffled(mesh, 7);
    const auto chunks = opened(encoded(mesh, {Kind::MaxError, 0.01}).bytes).chunks();
    EXPECT_EQ(chunks.back().kind, "numbering");
    EXPECT_EQ(chunks.back().bytes, 0U);
    const auto costly = opened(encoded(other, {Kind::MaxError, 0.01}).bytes).chunks();
    EXPECT_GT(costly.back().bytes, mesh.vertices.size());
}

TEST(QuadFile, PrefixesHoldCoarserLevels) {
    const QuadMesh mesh = surface_on(built(test::grid_mesh(3, 3, 1, 0.1)), 2, 0.1);
    const Bytes bytes = encoded(shuffled(mesh, 3), {Kind::MaxError, 0.001}).bytes;
    const auto source = std::make_shared<MemorySource>(bytes);
    const QuadFile whole = opened(bytes);
    EXPECT_EQ(whole.finest_level(), 0);
    EXPECT_EQ(whole.bytes_for(0), bytes.size());
    for (int level = 2; level >= 0; --level) {
        const auto prefix = QuadFile::open(source, whole.bytes_for(level));
        ASSERT_TRUE(prefix.ok());
        EXPECT_EQ(prefix->finest_level(), level);
        EXPECT_EQ(*prefix->decode(level), *whole.decode(level));
        if (level > 0) {
            EXPECT_EQ(prefix->decode(level - 1).error().code, ErrorCode::BadFile);
        }
    }
    EXPECT_FALSE(QuadFile::open(source, whole.bytes_for(2) - 1).ok());
}

TEST(QuadFile, NumbersOfVerticesAreThoseOfDecodedMeshes) {
    const QuadMesh mesh = shuffled(surface_on(built(test::grid_mesh(4, 3, 1, 0.15)), 2), 5);
    const QuadFile file = opened(encoded(mesh, {Kind::Lossless, 0}).bytes);
    for (int level = 0; level <= file.levels(); ++level) {
        const QuadMesh decoded = *file.decode(level);
        const QuadSurface surface = *file.surface(level);
        const mesh::Quadrangulation& plane = surface.hierarchy.mesh(surface.level());
        const std::vector<mesh::Index> numbers = *file.vertex_numbers(level);
        ASSERT_EQ(numbers.size(), decoded.vertices.size());
        for (mesh::Index v = 0; v < numbers.size(); ++v) {
            const auto& [x, y, z] = decoded.vertices[numbers[v]];
            EXPECT_NEAR(x, plane.origin.x + plane.x[v], 1e-12);
            EXPECT_NEAR(y, plane.origin.y + plane.y[v], 1e-12);
            EXPECT_EQ(z, surface.data.value[v]);
        }
    }
    EXPECT_FALSE(file.vertex_numbers(3).ok());
}

TEST(QuadFile, MovesAddTheSplineThroughThem) {
    const QuadMesh mesh = shuffled(surface_on(built(test::grid_mesh(4, 3, 1, 0.15)), 2, 0.05), 5);
    const Bytes bytes = encoded(mesh, {Kind::Lossless, 0}).bytes;
    // A vertex of the finest level rises by itself, under its own number.
    const QuadFile one = opened(*add_quad_moves(bytes, {{0, 17, 2.5}}));
    QuadMesh expected = mesh;
    expected.vertices[17][2] += 2.5;
    EXPECT_EQ(*one.decode(0), expected);
    EXPECT_TRUE(one.edited());
    EXPECT_FALSE(one.bound(0));
    EXPECT_FALSE(one.surface_bound(0));
    // Of a coarser one with the surface: what is added is the spline through the move.
    const Bytes moved = *add_quad_moves(bytes, {{2, 9, -3}});
    const QuadFile before = opened(bytes);
    const QuadFile after = opened(moved);
    const QuadSurface coarse = *before.surface(2);
    const mesh::Quadrangulation& base = coarse.hierarchy.mesh(0);
    std::vector<double> rise(base.vertex_count());
    rise[9] = -3;
    const auto added = *fvs_mesh::interpolate_values(base, rise);
    EXPECT_EQ(after.decode(2)->vertices[9][2], before.decode(2)->vertices[9][2] - 3);
    const QuadSurface fine = *before.surface(1);
    const auto predicted = predict(base, added).value;
    const QuadMesh b1 = *before.decode(1);
    const QuadMesh a1 = *after.decode(1);
    for (std::size_t v = 0; v < predicted.size(); ++v)
        EXPECT_NEAR(a1.vertices[v][2] - b1.vertices[v][2], predicted[v], 1e-14);
    // Moves add up, and their opposites take them back.
    const Bytes back = *add_quad_moves(moved, {{2, 9, 3}});
    EXPECT_EQ(*opened(back).decode(0), mesh);
    EXPECT_EQ(opened(back).moves().size(), 2U);
}

TEST(QuadFile, MovesThatDoNotExist) {
    const Bytes bytes = encoded(surface_on(built(test::grid_mesh(2, 2)), 0), {}).bytes;
    for (const auto& [move, says] :
         std::vector<std::pair<QuadMove, std::string>>{{{0, 9, 1}, "vertices 0 to 8"},
                                                       {{1, 4, 1}, "vertices 0 to 3"},
                                                       {{2, 0, 1}, "levels 0 to 1"},
                                                       {{-1, 0, 1}, "levels 0 to 1"},
                                                       {{0, 0, INFINITY}, "1e150"},
                                                       {{0, 0, std::nan("")}, "1e150"}}) {
        const auto moved = add_quad_moves(bytes, {move});
        ASSERT_FALSE(moved.ok());
        EXPECT_EQ(moved.error().code, ErrorCode::InvalidArgument);
        EXPECT_NE(moved.error().message.find(says), std::string::npos) << moved.error().text();
    }
}

TEST(QuadFile, BadMeshesAreNamed) {
    const QuadMesh good = surface_on(built(test::grid_mesh(2, 2)), 0);
    const auto refused = [](const QuadMesh& mesh, const std::string& name,
                            const std::string& where) {
        const auto file = encode_quads(mesh, {.goal = {Kind::Lossless, 0}});
        ASSERT_FALSE(file.ok()) << name;
        EXPECT_TRUE(file.error().message.starts_with(name)) << file.error().text();
        EXPECT_EQ(file.error().where, where);
    };
    QuadMesh mesh = good;
    mesh.vertices[3][2] = std::nan("");
    refused(mesh, "non_finite_data", "vertex 3");
    mesh = good;
    mesh.vertices[3][0] = INFINITY;
    refused(mesh, "non_finite_vertex", "vertex 3");
    mesh = good;
    std::reverse(mesh.quads[2].begin(), mesh.quads[2].end());
    refused(mesh, "clockwise", "quad 2");
    mesh = good;
    mesh.quads[1][2] = 9;
    refused(mesh, "index_out_of_range", "quad 1");
    refused({}, "empty_mesh", "");
    for (const Goal goal : {Goal{Kind::MaxError, -1}, Goal{Kind::RmsError, std::nan("")},
                            Goal{Kind::Bytes, INFINITY}})
        EXPECT_EQ(encode_quads(good, {.goal = goal}).error().code, ErrorCode::InvalidArgument);
}

TEST(QuadFile, SameBytesForAnyNumberOfThreads) {
    const QuadMesh mesh = surface_on(built(test::grid_mesh(9, 7, 1, 0.15)), 2, 0.05);
    std::vector<Bytes> files;
    for (const int threads : {1, 2, 5}) {
        set_thread_count(threads);
        files.push_back(encoded(mesh, {Kind::MaxError, 0.01}).bytes);
        files.push_back(encoded(mesh, {Kind::Keep, 60}).bytes);
    }
    set_thread_count(0);
    for (std::size_t k = 2; k < files.size(); ++k) EXPECT_EQ(files[k], files[k % 2]);
}

TEST(QuadFile, ContentIsKnown) {
    const Bytes bytes = encoded(surface_on(built(test::star_mesh(3)), 1), {}).bytes;
    EXPECT_EQ(*content_of(std::make_shared<MemorySource>(bytes)), "quadrangulation");
    EXPECT_FALSE(RasterFile::open(bytes).ok());
    EXPECT_EQ(RasterFile::open(bytes).error().code, ErrorCode::Unsupported);
}

template <class Target>
void run_mutations(const Bytes& seed, Target target, int count) {
    target(seed);
    std::mt19937 engine(99);
    for (int k = 0; k < count; ++k) {
        Bytes bytes = seed;
        for (std::uint32_t edits = 1 + engine() % 4; edits > 0 && !bytes.empty(); --edits) {
            const std::size_t at = engine() % bytes.size();
            if (engine() % 4 == 0)
                bytes.resize(at);
            else
                bytes[at] = static_cast<std::uint8_t>(engine() % 2 ? engine() : 0xff);
        }
        target(bytes);
    }
}

TEST(HostileQuads, Files) {
    for (const Bytes& file : fuzz::valid_quad_files())
        run_mutations(
            file, [](const Bytes& bytes) { fuzz::quads(bytes); }, 300);
}

TEST(HostileQuads, EveryPrefix) {
    for (const Bytes& file : fuzz::valid_quad_files())
        for (std::size_t size = 1; size < file.size(); ++size)
            fuzz::quads(std::span(file).first(size));
}

TEST(HostileQuads, ChunksWhoseChecksumsHold) {
    std::mt19937 engine(7);
    for (std::uint8_t file = 0; file < fuzz::valid_quad_files().size(); ++file)
        for (int k = 0; k < 400; ++k) {
            Bytes edits = {file};
            for (std::uint32_t count = 1 + engine() % 3; count > 0; --count)
                for (const std::uint32_t byte : {static_cast<std::uint32_t>(engine() % 8),
                                                 static_cast<std::uint32_t>(engine() % 120), 0U, 2U,
                                                 static_cast<std::uint32_t>(engine() % 256),
                                                 static_cast<std::uint32_t>(engine() % 256)})
                    edits.push_back(static_cast<std::uint8_t>(byte));
            fuzz::quad_chunks(edits);
        }
}

TEST(HostileQuads, Headers) {
    for (const Bytes& file : fuzz::valid_quad_files()) {
        const std::string header = ContainerReader::open(file)->header();
        run_mutations(
            Bytes(header.begin(), header.end()),
            [](const Bytes& bytes) { fuzz::quad_header(bytes); }, 100);
    }
}

TEST(HostileQuads, HeaderMembersOutOfRangeAreNamed) {
    const Bytes& file = fuzz::valid_quad_files()[0];
    const ContainerReader reader = *ContainerReader::open(file);
    for (const auto& [path, value, says] : std::vector<std::array<std::string, 3>>{
             {"/content", "\"raster\"", "holds 'raster'"},
             {"/vertices", "-1", "vertices"},
             {"/vertices", "4294967296", "too many"},
             {"/vertices", "2147483647", "too small"},
             {"/vertices", "10", "damaged"},
             {"/quads", "2147483647", "too small"},
             {"/quads", "5", "damaged"},
             {"/scheme/levels", "3", "chunks"},
             {"/scheme/levels", "31", "levels"},
             {"/scheme/levels", "-1", "levels"},
             {"/scheme/name", "\"box\"", "newer version"},
             {"/values/kind", "\"quaternion\"", "newer version"},
             {"/values/digits", "16", "out of range"},
             {"/values/multiple", "2", "out of range"},
             {"/values", "[]", "values"},
             {"/x_digits", "16", "x_digits"},
             {"/goal/value", "[]", "value"}}) {
        auto header = nlohmann::json::parse(reader.header());
        header[nlohmann::json::json_pointer(path)] = nlohmann::json::parse(value);
        const auto opened =
            QuadFile::open(fuzz::rebuilt(reader, header.dump(), fuzz::chunks_of(reader)));
        ASSERT_FALSE(opened.ok()) << path << " " << value;
        EXPECT_NE(opened.error().text().find(says), std::string::npos)
            << path << " " << value << ": " << opened.error().text();
    }
}

TEST(HostileQuads, LevelsThatTheFileIsTooSmallFor) {
    // A square with 14 levels of zeros would have 2^28 vertices.
    const Bytes file = encoded(surface_on(built(test::grid_mesh(1, 1)), 0), {}).bytes;
    const ContainerReader reader = *ContainerReader::open(file);
    auto header = nlohmann::json::parse(reader.header());
    header["scheme"]["levels"] = 14;
    auto chunks = fuzz::chunks_of(reader);
    chunks.resize(chunks.size() + 14);
    const auto opened = QuadFile::open(fuzz::rebuilt(reader, header.dump(), chunks));
    ASSERT_FALSE(opened.ok());
    EXPECT_NE(opened.error().message.find("too small"), std::string::npos);
}

}  // namespace
}  // namespace relief::codec
