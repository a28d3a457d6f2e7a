#include "relief/io/vtk.h"

#include <limits>

#include "io/mesh_formats.h"
#include "io/mesh_testing.h"
#include "io/scratch.h"
#include "relief/io/file.h"

namespace relief::io {
namespace {

using detail::load_number;

class Vtu : public Scratch {
  protected:
    [[nodiscard]] std::string read(const std::string& name) const {
        const auto bytes = *read_file(path(name));
        return {bytes.begin(), bytes.end()};
    }
};

/// The value of an attribute of the array with a name.
std::string attribute(const std::string& file, const std::string& array, const std::string& name) {
    const std::size_t tag = file.rfind("<DataArray", file.find("Name=\"" + array + "\""));
    const std::size_t at = file.find(" " + name + "=\"", tag) + name.size() + 3;
    return file.substr(at, file.find('"', at) - at);
}

template <class Number>
std::vector<Number> array_of(const std::string& file, const std::string& name) {
    const std::string mark = "<AppendedData encoding=\"raw\">\n_";
    const std::size_t start =
        file.find(mark) + mark.size() + std::stoul(attribute(file, name, "offset"));
    const auto* bytes = reinterpret_cast<const std::uint8_t*>(file.data()) + start;
    std::vector<Number> numbers(load_number<std::uint64_t>(bytes) / sizeof(Number));
    EXPECT_LE(start + 8 + numbers.size() * sizeof(Number), file.size());
    for (std::size_t k = 0; k < numbers.size(); ++k)
        numbers[k] = load_number<Number>(bytes + 8 + k * sizeof(Number));
    return numbers;
}

const std::vector<std::array<double, 3>> kPoints{{0, 0, 1},   {1, 0, 2},     {0, 1, 3},
                                                 {0.5, 0, 4}, {0.5, 0.5, 5}, {0, 0.5, 6},
                                                 {1, 1, 7},   {1, 0.5, 8},   {0.5, 1, 9}};
const std::vector<std::array<std::uint32_t, 6>> kCells{{0, 1, 2, 3, 4, 5}, {1, 6, 2, 7, 8, 4}};

TEST_F(Vtu, HoldsPointsCellsAndFields) {
    const std::vector<double> slopes{1,  2,  3,  4,  5,  6,  7,  8,  9,
                                     10, 11, 12, 13, 14, 15, 16, 17, -0.1};
    const std::vector<double> residual{1, 2, 3, 4, 5, 6, 7, 8, std::nan("")};
    ASSERT_TRUE(write_vtu(path("a.vtu"),
                          {kPoints, kCells, {{"slope", 2, slopes}, {"a<\"b\"&", 1, residual}}})
                    .ok());
    const std::string file = read("a.vtu");
    EXPECT_EQ(file.find("<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\""), 0u);
    EXPECT_NE(file.find("<Piece NumberOfPoints=\"9\" NumberOfCells=\"2\">"), std::string::npos);
    EXPECT_TRUE(file.ends_with("\n</AppendedData>\n</VTKFile>\n"));
    EXPECT_EQ(attribute(file, "Points", "NumberOfComponents"), "3");
    EXPECT_EQ(attribute(file, "Points", "type"), "Float64");
    EXPECT_EQ(attribute(file, "connectivity", "type"), "Int64");
    EXPECT_EQ(attribute(file, "types", "type"), "UInt8");
    std::vector<double> coordinates;
    for (const auto& p : kPoints) coordinates.insert(coordinates.end(), p.begin(), p.end());
    EXPECT_EQ(array_of<double>(file, "Points"), coordinates);
    EXPECT_EQ(array_of<std::int64_t>(file, "connectivity"),
              (std::vector<std::int64_t>{0, 1, 2, 3, 4, 5, 1, 6, 2, 7, 8, 4}));
    EXPECT_EQ(array_of<std::int64_t>(file, "offsets"), (std::vector<std::int64_t>{6, 12}));
    EXPECT_EQ(array_of<std::uint8_t>(file, "types"), (std::vector<std::uint8_t>{76, 76}));
    EXPECT_EQ(attribute(file, "slope", "NumberOfComponents"), "2");
    EXPECT_EQ(array_of<double>(file, "slope"), slopes);
    const auto values = array_of<double>(file, "a&#60;&#34;b&#34;&#38;");
    ASSERT_EQ(values.size(), 9u);
    EXPECT_EQ(values[7], 8);
    EXPECT_TRUE(std::isnan(values[8]));
}

/// More than what is written at a time.
TEST_F(Vtu, LargeArraysAreWhole) {
    std::vector<std::array<double, 3>> points;
    std::vector<std::array<std::uint32_t, 6>> cells;
    for (std::uint32_t k = 0; k < 120000; ++k) {
        points.push_back({double(k), 0.5 * k, -1.0 * k});
        if (k >= 5) cells.push_back({k, k - 1, k - 2, k - 3, k - 4, k - 5});
    }
    ASSERT_TRUE(write_vtu(path("a.vtu"), {points, cells}).ok());
    const std::string file = read("a.vtu");
    const auto coordinates = array_of<double>(file, "Points");
    const auto corners = array_of<std::int64_t>(file, "connectivity");
    const auto offsets = array_of<std::int64_t>(file, "offsets");
    ASSERT_EQ(coordinates.size(), 3 * points.size());
    ASSERT_EQ(corners.size(), 6 * cells.size());
    for (std::size_t k = 0; k < points.size(); ++k) ASSERT_EQ(coordinates[3 * k + 1], 0.5 * k);
    for (std::size_t k = 0; k < cells.size(); ++k) {
        ASSERT_EQ(corners[6 * k + 5], std::int64_t(k));
        ASSERT_EQ(offsets[k], std::int64_t(6 * k + 6));
    }
    EXPECT_EQ(array_of<std::uint8_t>(file, "types"), std::vector<std::uint8_t>(cells.size(), 76));
}

TEST_F(Vtu, RefusesWhatDoesNotFit) {
    const std::string where = path("a.vtu");
    auto points = kPoints;
    points[4][1] = std::numeric_limits<double>::infinity();
    auto cells = kCells;
    cells[1][3] = 9;
    const auto error = [&](const BezierTriangles& triangles) {
        return write_vtu(where, triangles).error();
    };
    EXPECT_EQ(error({points, kCells}).where, where + ", point 4");
    EXPECT_EQ(error({points, kCells}).message.substr(0, 17), "non_finite_vertex");
    EXPECT_EQ(error({kPoints, cells}).where, where + ", cell 1");
    EXPECT_EQ(error({kPoints, cells}).message.substr(0, 18), "index_out_of_range");
    const std::vector<double> values(9);
    for (const int components : {0, 2, -1}) {
        EXPECT_EQ(error({kPoints, kCells, {{"f", components, values}}}).code,
                  ErrorCode::InvalidArgument);
    }
    EXPECT_EQ(write_vtu(path("none/a.vtu"), {kPoints, kCells}).error().code,
              ErrorCode::CannotWrite);
    EXPECT_TRUE(files().empty());
}

}  // namespace
}  // namespace relief::io
