#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "relief/codec/point_codec.h"
#include "relief/mesh/triangle_locator.h"
#include "relief/multires/ps_surface.h"

namespace relief::codec {
namespace {

namespace ps = multires::ps;

struct Data {
    std::vector<Vec2> points;
    std::vector<double> values;
    std::vector<double> weights;

    [[nodiscard]] PsData view() const { return {points, {values}, weights}; }
};

double wave(Vec2 p) {
    return std::sin(3 * p.x) * std::cos(2 * p.y) + p.x;
}

/// A lattice of n x n over [0, 2]^2, moved by less than half a step inside.
Data lattice(int n) {
    Data data;
    std::uint32_t hash = 7;
    const auto noise = [&] {
        hash = hash * 1664525U + 1013904223U;
        return static_cast<double>(hash >> 8) / (1U << 24) - 0.5;
    };
    const double step = 2.0 / (n - 1);
    for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j) {
            const bool inside = i > 0 && j > 0 && i < n - 1 && j < n - 1;
            const double shake = inside ? 0.8 * step : 0;
            const Vec2 p{j * step + shake * noise(), i * step + shake * noise()};
            data.points.push_back(p);
            data.values.push_back(wave(p));
        }
    return data;
}

/// How far the decoded surface is from each point.
std::vector<double> errors(const Data& data, const EncodedPoints& encoded) {
    const auto file = PsFile::open(encoded.bytes);
    EXPECT_TRUE(file.ok());
    const auto level = file->surface(0);
    EXPECT_TRUE(level.ok());
    const auto surface = ps::Surface::create(level->space, level->components);
    const mesh::TriangleLocator locator(level->space.mesh);
    std::vector<spline::PlaneJet> jets(data.points.size());
    EXPECT_TRUE(ps::evaluate(*surface, locator, data.points, jets, ps::Outside::Nearest).ok());
    std::vector<double> found;
    for (std::size_t k = 0; k < jets.size(); ++k)
        found.push_back(std::abs(jets[k].value - data.values[k]));
    return found;
}

double largest(const std::vector<double>& numbers) {
    return *std::max_element(numbers.begin(), numbers.end());
}

TEST(PointEncode, InterpolationPassesThroughWeightedMeans) {
    Data data = lattice(9);
    data.weights.assign(81, 1);
    data.weights[40] = 3;
    data.points.push_back(data.points[40]);
    data.values.push_back(data.values[40] + 2);
    data.weights.push_back(1);
    const auto encoded = encode_points(data.view(), Interpolation{});
    ASSERT_TRUE(encoded.ok()) << encoded.error().text();
    EXPECT_EQ(encoded->merged, 1U);
    EXPECT_EQ(encoded->report.vertices, 81);
    const auto off = errors(data, *encoded);
    // Vertices are points moved by 2^-51 of the extent.
    for (std::size_t k = 0; k < 81; ++k) EXPECT_NEAR(off[k], k == 40 ? 0.5 : 0, 1e-13);
    EXPECT_NEAR(off[81], 1.5, 1e-13);
    EXPECT_NEAR(encoded->report.max_error, 1.5, 1e-13);

    data.weights.assign(82, 0);
    const auto unweighted = encode_points(data.view(), Interpolation{});
    ASSERT_TRUE(unweighted.ok()) << unweighted.error().text();
    EXPECT_NEAR(errors(data, *unweighted)[40], 1, 1e-13);
}

TEST(PointEncode, InsertionKeepsTheBound) {
    const Data data = lattice(60);
    for (const double bound : {0.3, 0.03, 0.003}) {
        const auto encoded =
            encode_points(data.view(), Insertion{}, Goal{Goal::Kind::MaxError, bound});
        ASSERT_TRUE(encoded.ok()) << encoded.error().text();
        EXPECT_LE(largest(errors(data, *encoded)), bound);
        EXPECT_EQ(encoded->beyond, 0U);
        EXPECT_EQ(encoded->reason, "");
    }
}

TEST(PointEncode, ALimitOfVerticesIsTold) {
    const Data data = lattice(40);
    const double bound = 0.01;
    const auto encoded = encode_points(data.view(), Insertion{.most_vertices = 20},
                                       Goal{Goal::Kind::MaxError, bound});
    ASSERT_TRUE(encoded.ok()) << encoded.error().text();
    EXPECT_LE(encoded->report.vertices, 20);
    const auto off = errors(data, *encoded);
    EXPECT_EQ(encoded->beyond, static_cast<std::size_t>(std::count_if(
                                   off.begin(), off.end(), [&](double e) { return e > bound; })));
    EXPECT_GT(encoded->beyond, 0U);
    EXPECT_NE(encoded->reason, "");
}

TEST(PointEncode, LeastSquaresOnTrianglesLeaveOthersOut) {
    const Data data = lattice(40);
    const std::vector<Vec2> corners{{0, 0}, {1, 0}, {1, 1}, {0, 1}};
    const std::vector<std::array<mesh::Index, 3>> triangles{{0, 1, 2}, {0, 2, 3}};
    auto base = mesh::build(corners, triangles);
    ASSERT_TRUE(base.ok());
    const auto encoded =
        encode_points(data.view(), Approximation{*base, 2, 1e-12}, Goal{Goal::Kind::Lossless, 0});
    ASSERT_TRUE(encoded.ok()) << encoded.error().text();
    const auto inside = std::count_if(data.points.begin(), data.points.end(),
                                      [](Vec2 p) { return p.x <= 1 && p.y <= 1; });
    EXPECT_EQ(encoded->outside, data.points.size() - static_cast<std::size_t>(inside));
    EXPECT_EQ(encoded->report.levels, 2);
    EXPECT_EQ(encoded->report.vertices, 4);
    const auto file = PsFile::open(encoded->bytes);
    ASSERT_TRUE(file.ok());
    EXPECT_EQ(file->counts(0).triangles, 162U);
    Data there;
    for (std::size_t k = 0; k < data.points.size(); ++k) {
        if (data.points[k].x > 1 || data.points[k].y > 1) continue;
        there.points.push_back(data.points[k]);
        there.values.push_back(data.values[k]);
    }
    EXPECT_NEAR(largest(errors(there, *encoded)), encoded->report.max_error, 1e-14);

    const Data far{{{5, 5}, {6, 5}, {5, 6}}, {1, 2, 3}, {}};
    const auto nothing = encode_points(far.view(), Approximation{*base});
    ASSERT_FALSE(nothing.ok());
    EXPECT_TRUE(nothing.error().message.starts_with("no_data")) << nothing.error().message;
}

TEST(PointEncode, CodeAddsAThousandthWhereNothingIsAsked) {
    Data data = lattice(40);
    for (std::size_t k = 0; k < data.values.size(); ++k) data.values[k] += k % 2 == 0 ? 0.1 : -0.1;
    const Approximation method{std::size_t{50}};
    const auto exact = encode_points(data.view(), method, Goal{Goal::Kind::Lossless, 0});
    const auto close = encode_points(data.view(), method);
    ASSERT_TRUE(exact.ok() && close.ok());
    EXPECT_LE(close->report.rms_error, 1.001 * exact->report.rms_error);
    EXPECT_LT(2 * close->bytes.size(), exact->bytes.size());
    EXPECT_EQ(close->smoothing, exact->smoothing);
}

TEST(PointEncode, Errors) {
    const Data data = lattice(10);
    const auto code_of = [](const auto& result) {
        return result.ok() ? "none"
                           : result.error().message.substr(0, result.error().message.find(':'));
    };
    EXPECT_EQ(code_of(encode_points({data.points, {{}}, {}}, Interpolation{})), "size_mismatch");
    EXPECT_EQ(code_of(encode_points(data.view(), Approximation{std::size_t{9}, 12})),
              "too_many_elements");
    EXPECT_EQ(code_of(encode_points(data.view(), Approximation{std::size_t{9}},
                                    Goal{Goal::Kind::MaxError, 1e-9})),
              "bound_not_reached");
    const auto unbounded = encode_points(data.view(), Insertion{});
    ASSERT_FALSE(unbounded.ok());
    EXPECT_EQ(unbounded.error().code, ErrorCode::InvalidArgument);

    for (const double bad : {std::nan(""), HUGE_VAL, 1e200}) {
        Data wrong = data;
        wrong.points[3].y = bad;
        EXPECT_EQ(code_of(encode_points(wrong.view(), Interpolation{})), "non_finite_input");
        wrong = data;
        wrong.values[4] = bad;
        const auto named = encode_points(wrong.view(), Insertion{}, Goal{Goal::Kind::MaxError, 1});
        EXPECT_EQ(code_of(named), "non_finite_input");
        EXPECT_EQ(named.error().where, "point 4");
    }
    const auto negative = encode_points(data.view(), Insertion{}, Goal{Goal::Kind::MaxError, -1});
    ASSERT_FALSE(negative.ok());
    EXPECT_EQ(negative.error().code, ErrorCode::InvalidArgument);

    Data twice = data;
    twice.points.push_back(data.points[55]);
    twice.values.push_back(data.values[55] + 1);
    const Goal goal{Goal::Kind::MaxError, 0.4};
    EXPECT_EQ(code_of(encode_points(twice.view(), Insertion{}, goal)), "bound_not_reached");
    // Values that are apart by nearly twice the bound leave the code little room.
    const Goal tight{Goal::Kind::MaxError, 0.51};
    const auto close = encode_points(twice.view(), Insertion{}, tight);
    ASSERT_TRUE(close.ok()) << close.error().text();
    EXPECT_LE(largest(errors(twice, *close)), 0.51);
    const auto cancelled =
        encode_points(data.view(), Insertion{}, goal, [](double) { return false; });
    ASSERT_FALSE(cancelled.ok());
    EXPECT_EQ(cancelled.error().code, ErrorCode::Cancelled);
}

}  // namespace
}  // namespace relief::codec
