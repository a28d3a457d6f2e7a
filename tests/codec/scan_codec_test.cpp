#include "relief/codec/scan_codec.h"

#include <utility>

#include "../remesh/meshes.h"
#include "relief/mesh/closest.h"
#include "support.h"

/// Meshes without levels to files.
namespace relief::codec {
namespace {

using Kind = Goal::Kind;

/// Of 4^splits x 8 faces; its facets are details of fine goals.
PolygonMesh scan(int splits) {
    return test::polygons_of(test::bumpy_sphere(splits, 0.3));
}

EncodedScan encoded(const PolygonMesh& mesh, const ScanEncodeOptions& options) {
    auto result = encode_scan(mesh, options);
    if (!result.ok()) throw std::runtime_error(result.error().text());
    return *std::move(result);
}

/// That a file keeps its promise, and says what it does.
void expect_near(const EncodedScan& file, const PolygonMesh& mesh, double goal) {
    const PolygonMesh decoded = *MeshFile::open(file.encoded.bytes)->decode(0);
    const mesh::SurfaceDistance distance = *mesh::surface_distance(mesh, decoded);
    EXPECT_LE(distance.rms(), goal);
    EXPECT_NEAR(distance.rms(), file.encoded.report.rms_error, 1e-9 * goal);
    EXPECT_EQ(file.encoded.report.levels, file.remeshed.levels);
    EXPECT_EQ(file.remeshed.report.flips, 0);
}

TEST(ScanCodec, TakesAFinerRemeshWhereTheGoalNeedsOne) {
    const PolygonMesh mesh = scan(4);
    const double goal = 8e-4 * diagonal_of(mesh);
    ScanEncodeOptions options{.goal = {Kind::RmsError, goal}, .effort = ScanEffort::Once};
    const EncodedScan once = encoded(mesh, options);
    options.effort = ScanEffort::Suited;
    const EncodedScan suited = encoded(mesh, options);
    EXPECT_GT(once.remeshed.report.rms_error, 0.4 * goal);
    EXPECT_LT(suited.remeshed.report.rms_error, 0.8 * once.remeshed.report.rms_error);
    EXPECT_LT(suited.encoded.bytes.size(), once.encoded.bytes.size());
    expect_near(once, mesh, goal);
    expect_near(suited, mesh, goal);
    // What takes little of its goal is left as it is.
    options.goal.value *= 10;
    const EncodedScan coarse = encoded(mesh, options);
    EXPECT_LE(coarse.remeshed.mesh.polygon_count(), mesh.polygon_count() + 64);
}

TEST(ScanCodec, LooksForTheSmallestFile) {
    const PolygonMesh mesh = scan(3);
    const double goal = 3e-3 * diagonal_of(mesh);
    ScanEncodeOptions options{.goal = {Kind::RmsError, goal}, .tolerance = 0.02};
    const EncodedScan suited = encoded(mesh, options);
    options.effort = ScanEffort::Smallest;
    const EncodedScan smallest = encoded(mesh, options);
    EXPECT_LT(smallest.encoded.bytes.size(), suited.encoded.bytes.size());
    expect_near(smallest, mesh, goal);

    options.goal = {Kind::Bytes, 500};
    const EncodedScan nearest = encoded(mesh, options);
    options.effort = ScanEffort::Once;
    const EncodedScan first = encoded(mesh, options);
    EXPECT_LE(nearest.encoded.bytes.size(), 500U);
    EXPECT_LT(nearest.encoded.report.rms_error, first.encoded.report.rms_error);
}

TEST(ScanCodec, SizesAreThoseThatWereAskedFor) {
    const PolygonMesh mesh = scan(4);
    const EncodedScan file = encoded(mesh, {.goal = {Kind::RmsError, 1e-3 * diagonal_of(mesh)},
                                            .base_faces = 60,
                                            .levels = 2,
                                            .tolerance = 0.1,
                                            .effort = ScanEffort::Smallest});
    EXPECT_EQ(file.remeshed.levels, 2);
    EXPECT_LE(file.remeshed.report.base_faces, 60);
}

TEST(ScanCodec, RefusesWhatCanNotBe) {
    const PolygonMesh mesh = scan(3);
    const auto refused = [&](const ScanEncodeOptions& options) {
        return encode_scan(mesh, options).error();
    };
    EXPECT_EQ(refused({.goal = {Kind::Lossless, 0}}).code, ErrorCode::InvalidArgument);
    EXPECT_EQ(refused({.goal = {Kind::RmsError, -1}}).code, ErrorCode::InvalidArgument);
    EXPECT_EQ(refused({.goal = {Kind::RmsError, 0.1}, .levels = 13}).code,
              ErrorCode::InvalidArgument);
    EXPECT_EQ(refused({.goal = {Kind::RmsError, 0.1}, .levels = -1}).code,
              ErrorCode::InvalidArgument);
    EXPECT_EQ(refused({.goal = {Kind::RmsError, 0.1}, .base_faces = 0}).code,
              ErrorCode::InvalidArgument);
    EXPECT_TRUE(
        refused({.goal = {Kind::RmsError, 1e-9}, .tolerance = 0.05, .effort = ScanEffort::Once})
            .message.starts_with("goal_out_of_reach"));
    const Progress stop = [](double) { return false; };
    EXPECT_EQ(refused({.goal = {Kind::RmsError, 0.1}, .remeshing = stop}).code,
              ErrorCode::Cancelled);
    EXPECT_EQ(refused({.goal = {Kind::RmsError, 0.1}, .encoding = stop}).code,
              ErrorCode::Cancelled);
    // In the middle of a search.
    bool has_one = false;
    const Progress stop_later = [&](double done) { return !std::exchange(has_one, done == 1); };
    EXPECT_EQ(refused({.goal = {Kind::RmsError, 0.1},
                       .effort = ScanEffort::Smallest,
                       .remeshing = stop_later})
                  .code,
              ErrorCode::Cancelled);
    EXPECT_EQ(encode_scan({}, {.goal = {Kind::RmsError, 0.1}}).error().code, ErrorCode::BadInput);
}

}  // namespace
}  // namespace relief::codec
