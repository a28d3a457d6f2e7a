#include "relief/io/points.h"

#include <limits>
#include <random>

#include "../fuzz/point_reader.h"
#include "io/mesh_testing.h"
#include "io/scratch.h"
#include "relief/io/file.h"
#include "relief/io/file_kind.h"

namespace relief::io {
namespace {

using Places = std::vector<Vec2>;

PointSet points(const std::string& text, const PointColumns& columns = {}) {
    return value_of(parse_points(bytes_of(text), "a.xyz", columns));
}

TEST(Points, BlanksCommasAndSemicolons) {
    const Places places{{1, 2}, {-4.5, 5e2}};
    const std::vector<double> values{3, 0.25};
    for (const std::string text :
         {"1 2 3\n-4.5 5e2 .25\n", "1\t2   3\r\n  -4.5 +5e2\t0.25", "1,2,3\n-4.5,5e2,.25\n",
          "1 , 2 , 3\n\n-4.5, 5e2, 0.25\n\n", "1;2;3;\n-4.5;5e2;.25;7\n",
          "# a comment\n1 2 3 # and another\n#\n-4.5 5e2 .25",
          "\xEF\xBB\xBF\"1\",\"2\",3\n-4.5,5e2,.25", "1 2 3 1 1\n-4.5 5e2 .25 2 1\n"}) {
        const PointSet set = points(text);
        EXPECT_EQ(set.places, places) << text;
        EXPECT_EQ(set.values[0], values) << text;
        EXPECT_TRUE(set.weights.empty());
    }
}

TEST(Points, NamesOfColumns) {
    const auto same = [](const PointSet& set) {
        EXPECT_EQ(set.places, (Places{{1, 2}, {4, 5}}));
        EXPECT_EQ(set.values[0], (std::vector<double>{3, 6}));
    };
    same(points("x,y,z\n1,2,3\n4,5,6"));
    same(points("X Y Z\n1 2 3\n4 5 6"));
    same(points("Elevation;LAT;Lon\n3;2;1\n6;5;4"));
    same(points("longitude,latitude,bathymetry_m\n1,2,3\n4,5,6"));
    same(points("name,northing,easting,height\n\"a, b\",2,1,3\nc,5,4,6\n"));
    const PointSet weighted = points("w,value,x,y\n0.5,3,1,2\n0,6,4,5");
    same(weighted);
    EXPECT_EQ(weighted.weights, (std::vector<double>{0.5, 0}));
    same(points("w,q,x,y\n0.5,3,1,2\n0,6,4,5"));  // q is the first that is nothing else
}

TEST(Points, ColumnsOfChoice) {
    const std::string text = "id,x,y,z,sigma,temp\n7,1,2,3,4,5\n";
    const PointSet temperature = points(text, {.values = {"TEMP"}, .weight = "sigma"});
    EXPECT_EQ(temperature.values[0], (std::vector<double>{5}));
    EXPECT_EQ(temperature.weights, (std::vector<double>{4}));
    EXPECT_EQ(points(text, {.x = "1", .values = {"2"}}).places, (Places{{7, 2}}));
    EXPECT_EQ(points(text, {.x = "1", .values = {"2"}}).values[0], (std::vector<double>{1}));
    const PointSet numbers =
        points("7 1 2 3\n", {.x = "2", .y = "3", .values = {"4"}, .weight = "1"});
    EXPECT_EQ(numbers.places, (Places{{1, 2}}));
    EXPECT_EQ(numbers.values[0], (std::vector<double>{3}));
    EXPECT_EQ(numbers.weights, (std::vector<double>{7}));
    const PointSet space = points("u,v,x,y,z\n1,2,3,4,5\n6,7,8,9,0\n",
                                  {.x = "u", .y = "v", .values = {"x", "y", "5"}});
    EXPECT_EQ(space.places, (Places{{1, 2}, {6, 7}}));
    EXPECT_EQ(space.values, (std::vector<std::vector<double>>{{3, 8}, {4, 9}, {5, 0}}));
    const PointSet places = points("1 2\n3 4 nothing\n", {.values_needed = false});
    EXPECT_EQ(places.places, (Places{{1, 2}, {3, 4}}));
    EXPECT_TRUE(places.values.empty());
    EXPECT_EQ(points("lat,lon\n1,2", {.values_needed = false}).places, (Places{{2, 1}}));
}

TEST(Points, ErrorsNameTheLine) {
    const auto refuse = [](const std::string& text, const std::string& where,
                           const std::string& says, const PointColumns& columns = {}) {
        expect_refused(parse_points(bytes_of(text), "a.csv", columns), where, says);
    };
    refuse("", "a.csv", "no point");
    refuse("# only\nx,y,z\n", "a.csv", "no point");
    refuse("1 2\n", "a.csv, line 1", "value (column 3) is missing");
    refuse("\n1,2,3\n4,5,\n", "a.csv, line 3", "value (column 3) is missing");
    refuse("1,2,3\n4,,5\n", "a.csv, line 2", "y (column 2) is missing");
    refuse("1,2,3\n4,5,NaN\n", "a.csv, line 2", "'NaN', not finite");
    refuse("1,inf,3\n", "a.csv, line 1", "'inf', not finite");
    refuse("1 2 3\n1 2 3x\n", "a.csv, line 2", "'3x', not a number");
    refuse("1;2;3\n1;2;3,5\n", "a.csv, line 2", "'3,5', not a number");
    refuse("a,b,c\n1,2,3\n", "a.csv, line 1",
           "no column is called x or the like; it has 'a', 'b', 'c'");
    refuse("x,y\n1,2\n", "a.csv, line 1", "no column of values");
    refuse("x,y,z\n1,2,3\n", "a.csv, line 1", "no column is called 'q'", {.values = {"q"}});
    refuse("x,y,z\n1,2,3\n", "a.csv, line 2", "value (column 9) is missing", {.values = {"9"}});
    refuse("1 2 3 -1\n", "a.csv, line 1", "weight (column 4) is negative", {.weight = "4"});
    refuse("1 2 3\n" + std::string(1100000, ' ') + "\n", "a.csv, line 2", "longer than a megabyte");
    refuse("1 2 3\n" + std::string(1100000, '7'), "a.csv, line 2", "longer than a megabyte");
}

class PointFiles : public Scratch {
  protected:
    void write(const std::string& name, const std::string& text) {
        ASSERT_TRUE(write_file_atomically(path(name), bytes_of(text)).ok());
    }
};

/// Larger than what is read at a time; every line has another length.
TEST_F(PointFiles, LinesAcrossPieces) {
    std::string text = "x y z\n";
    for (int k = 0; k < 300000; ++k)
        text += std::to_string(k) + " " + std::to_string(k * 0.5) + " " + std::to_string(k % 977) +
                "\n";
    ASSERT_GT(text.size(), std::size_t{5} << 20);
    write("a.xyz", text);
    const PointSet set = value_of(read_points(path("a.xyz")));
    ASSERT_EQ(set.places.size(), 300000u);
    for (int k = 0; k < 300000; ++k) {
        ASSERT_EQ(set.places[k], (Vec2{double(k), k * 0.5}));
        ASSERT_EQ(set.values[0][k], k % 977);
    }
    write("a.xyz", text + "1 2\n");
    expect_refused(read_points(path("a.xyz")), path("a.xyz") + ", line 300002", "is missing");
    expect_refused(read_points(path("none.xyz")), path("none.xyz"), "can not read",
                   ErrorCode::NotFound);
}

TEST_F(PointFiles, AreRecognisedByTheirExtension) {
    for (const char* name : {"a.xyz", "b.CSV", "c.txt"}) {
        write(name, "1 2 3\n");
        EXPECT_EQ(recognise(path(name)), FileKind::Points);
    }
}

TEST_F(PointFiles, ResultsAreReadBackAsTheyWere) {
    const std::vector<double> x{0.1, 2e6, -0.0};
    const std::vector<double> y{1 / 3.0, 1e-300, 5};
    const std::vector<double> value{1, 2, 3};
    const std::vector<double> slope{std::numeric_limits<double>::quiet_NaN(), 7, 8};
    const std::vector<CsvColumn> columns{{"x", x}, {"y", y}, {"value", value}, {"slope", slope}};
    ASSERT_TRUE(write_csv(path("out.csv"), columns).ok());
    const auto bytes = *read_file(path("out.csv"));
    EXPECT_EQ(std::string(bytes.begin(), bytes.end()),
              "x,y,value,slope\n0.1,0.3333333333333333,1,\n2000000,1e-300,2,7\n-0,5,3,8\n");
    const PointSet set = value_of(read_points(path("out.csv")));
    EXPECT_EQ(set.places, (Places{{x[0], y[0]}, {x[1], y[1]}, {x[2], y[2]}}));
    EXPECT_EQ(set.values[0], value);
    const std::vector<CsvColumn> uneven{{"x", x}, {"y", std::span(y).first(2)}};
    EXPECT_EQ(write_csv(path("bad.csv"), uneven).error().code, ErrorCode::InvalidArgument);
    EXPECT_EQ(write_csv(path("none/out.csv"), columns).error().code, ErrorCode::CannotWrite);
    EXPECT_EQ(files(), Names{"out.csv"});
}

TEST(Points, MutationsAreReadOrRefused) {
    const std::string corpus = "\"Lon\",lat;z,w\n1,2,3,4\n5 6 7 8\n-1e5,.5,nan,# x\n\"a\"b,1,2,3\n";
    std::mt19937 random(3);
    for (int round = 0; round < 20000; ++round) {
        std::string text = corpus.substr(random() % 20);
        for (int edit = 0; edit < 4; ++edit)
            text[random() % text.size()] = corpus[random() % corpus.size()];
        text.resize(random() % (text.size() + 1));
        fuzz::points(bytes_of(text));
    }
}

}  // namespace
}  // namespace relief::io
