#include "relief/mesh/scan.h"

#include "mesh/triangle_meshes.h"
#include "relief/mesh/triangle_locator.h"

namespace relief::mesh {
namespace {

/// What runs say, sample by sample.
std::vector<Index> painted(const std::vector<SampleRun>& runs, Index columns) {
    std::vector<Index> row(columns, kNone);
    Index end = 0;
    for (const SampleRun& run : runs) {
        EXPECT_LT(run.begin, run.end);
        EXPECT_GE(run.begin, end);  // disjoint, from left to right
        end = run.end;
        std::fill(row.begin() + run.begin, row.begin() + run.end, run.triangle);
    }
    EXPECT_LE(end, columns);
    return row;
}

/// A raster over the mesh and somewhat more.
SampleRows raster_over(const Triangulation& mesh, Index rows, Index columns, bool downwards) {
    Vec2 low{0, 0};
    for (Index v = 0; v < mesh.vertex_count(); ++v)
        low = {std::min(low.x, mesh.x[v]), std::min(low.y, mesh.y[v])};
    const Vec2 corner = 1.1 * low;
    SampleRows samples{mesh.origin + corner,
                       {-2 * corner.x / (columns - 1), -2 * corner.y / (rows - 1)},
                       rows,
                       columns};
    if (downwards) {
        samples.first.y = mesh.origin.y - corner.y;
        samples.step.y = -samples.step.y;
    }
    return samples;
}

TEST(RowScan, EverySampleHasTheTriangleOfTheLocator) {
    for (const Triangulation& mesh : test::triangulation_family()) {
        const TriangleLocator locator(mesh);
        for (const auto& [rows, columns] : {std::pair<Index, Index>{37, 53}, {200, 3}, {2, 211}}) {
            const SampleRows samples = raster_over(mesh, rows, columns, rows == 37);
            const RowScan scan(mesh, samples);
            for (Index r = 0; r < rows; ++r) {
                const std::vector<Index> row = painted(scan.runs(r), columns);
                for (Index c = 0; c < columns; ++c)
                    ASSERT_EQ(row[c], locator.locate(samples.at(r, c))) << r << ", " << c;
            }
        }
    }
}

/// All samples are vertices: on edges the smallest triangle wins.
TEST(RowScan, SamplesOnEdges) {
    const Triangulation mesh = test::built(test::triangle_grid(6, 4, 0, {2e6, -1e6}));
    const TriangleLocator locator(mesh);
    const SampleRows samples{{2e6 - 0.5, -1e6 - 0.5}, {0.5, 0.5}, 11, 15};
    const RowScan scan(mesh, samples);
    EXPECT_TRUE(scan.runs(0).empty());
    EXPECT_TRUE(scan.runs(10).empty());
    for (Index r = 1; r < 10; ++r) {
        const std::vector<SampleRun> runs = scan.runs(r);
        EXPECT_EQ(runs.front().begin, 1u);
        EXPECT_EQ(runs.back().end, 14u);
        const std::vector<Index> row = painted(runs, 15);
        for (Index c = 0; c < 15; ++c) ASSERT_EQ(row[c], locator.locate(samples.at(r, c)));
    }
    // The lowest row of samples is the lower border: triangles 0, 2, 4, .. have their sides there.
    EXPECT_EQ(scan.runs(1),
              (std::vector<SampleRun>{
                  {0, 1, 4}, {2, 4, 6}, {4, 6, 8}, {6, 8, 10}, {8, 10, 12}, {10, 12, 14}}));
}

TEST(RowScan, ARasterBesideTheMesh) {
    const Triangulation mesh = test::built(test::triangle_grid(2, 2));
    for (const Vec2 first : {Vec2{5, 0}, Vec2{-9, 0}, Vec2{0, 5}, Vec2{0, -9}, Vec2{1e18, -1e18}}) {
        const RowScan scan(mesh, {first, {0.5, 0.5}, 3, 3});
        for (Index r = 0; r < 3; ++r) EXPECT_TRUE(scan.runs(r).empty());
    }
    const RowScan one(mesh, {{0.75, 0.25}, {1, 1}, 1, 1});
    EXPECT_EQ(one.runs(0), (std::vector<SampleRun>{{0, 0, 1}}));
}

}  // namespace
}  // namespace relief::mesh
