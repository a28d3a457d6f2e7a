#include "relief/io/mesh.h"

#include <cmath>
#include <fstream>
#include <iterator>
#include <random>

#include "../fuzz/mesh_readers.h"
#include "io/scratch.h"
#include "relief/io/file_kind.h"

namespace relief::io {
namespace {

using Vertices = std::vector<std::array<double, 3>>;

PolygonMesh off(const std::string& text) {
    const auto mesh = parse_off(text, "a.off");
    EXPECT_TRUE(mesh.ok()) << (mesh.ok() ? "" : mesh.error().text());
    return mesh.ok() ? *mesh : PolygonMesh();
}
PolygonMesh obj(const std::string& text) {
    const auto mesh = parse_obj(text, "a.obj");
    EXPECT_TRUE(mesh.ok()) << (mesh.ok() ? "" : mesh.error().text());
    return mesh.ok() ? *mesh : PolygonMesh();
}

TEST(Off, VerticesAndPolygonsOfAnySize) {
    const PolygonMesh mesh =
        off("OFF  # a comment\n\n 5 2 0\r\n0 0 0\n1 0 -1.5e2\n\t1 1 +2\n0 1 .5\n-1 .5 1e-300\n"
            "4 0 1 2 3\n3 0 3 4 # last\n\n");
    EXPECT_EQ(mesh.vertices,
              (Vertices{{0, 0, 0}, {1, 0, -150}, {1, 1, 2}, {0, 1, 0.5}, {-1, 0.5, 1e-300}}));
    EXPECT_EQ(mesh.offsets, (std::vector<std::int64_t>{0, 4, 7}));
    EXPECT_EQ(mesh.corners, (std::vector<std::int32_t>{0, 1, 2, 3, 0, 3, 4}));
}

TEST(Off, ColoursNormalsAndCountsInTheFirstLine) {
    const Vertices triangle = {{0, 0, 7}, {1, 0, 8}, {0, 1, 9}};
    EXPECT_EQ(off("OFF 3 1 3\n0 0 7\n1 0 8\n0 1 9\n3 0 1 2 255 0 0").vertices, triangle);
    EXPECT_EQ(off("COFF\n3 1 3\n0 0 7 1 2 3 4\n1 0 8 1 2 3 4\n0 1 9 1 2 3 4\n3 0 1 2").vertices,
              triangle);
    EXPECT_EQ(off("STCNOFF\n3 1\n0 0 7 0 0 1\n1 0 8 0 0 1\n0 1 9 0 0 1\n3 2 1 0\n").corners,
              (std::vector<std::int32_t>{2, 1, 0}));
    EXPECT_EQ(off("OFF\n0 0 0\n"), PolygonMesh());
}

TEST(Off, ErrorsNameTheLine) {
    const auto refuse = [](const std::string& text, const std::string& where,
                           const std::string& says, ErrorCode code = ErrorCode::BadInput) {
        const auto mesh = parse_off(text, "a.off");
        ASSERT_FALSE(mesh.ok()) << text;
        EXPECT_EQ(mesh.error().where, "a.off, " + where) << text;
        EXPECT_NE(mesh.error().message.find(says), std::string::npos) << mesh.error().message;
        EXPECT_EQ(mesh.error().code, code) << text;
    };
    const std::string vertices = "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n";
    refuse("", "line 0", "empty");
    refuse("PLY\n", "line 1", "'PLY'");
    refuse("4OFF\n1 1 1\n", "line 1", "'4OFF'", ErrorCode::Unsupported);
    refuse("OFF BINARY\n", "line 1", "binary", ErrorCode::Unsupported);
    refuse("OFF\n3\n", "line 2", "numbers of vertices");
    refuse("OFF\n-1 0 0\n", "line 2", "numbers of vertices");
    refuse("OFF\n3000000000 0 0\n", "line 2", "too_many_elements");
    refuse("OFF\n2000000000 0 0\n0 0 0\n", "line 2", "too short for 2000000000 vertices");
    refuse("OFF\n1 2000000000 0\n0 0 0\n", "line 2", "too short");
    refuse("OFF\n2 0 0\n0 0 0\n# one is missing\n", "line 4", "after 1 of 2 vertices");
    refuse("OFF\n1 0 0\n0 x 0\n", "line 3", "'x'");
    refuse("OFF\n1 0 0\n0 0 1e999\n", "line 3", "'1e999'");
    refuse(vertices + "# 3 0 1 2\n\n", "line 7", "after 0 of 1 polygons");
    refuse(vertices + "2 0 1 2\n", "line 6", "at least 3");
    refuse(vertices + "3 0 1\n   ", "line 6", "3 corners");
    refuse(vertices + "3 0 1 3\n", "line 6", "index_out_of_range: a polygon names vertex 3 of 3");
    refuse(vertices + "3 0 1 -1\n", "line 6", "index_out_of_range");
    refuse(vertices + "999999999999 0 1 2\n", "line 6", "999999999999 corners");
    refuse(vertices + "3 0 1 2\n3 0 1 2\n", "line 7", "more than");
}

TEST(Obj, FacesInAllNotations) {
    const PolygonMesh mesh =
        obj("# head\nmtllib x.mtl\no thing\nv 0 0 0\nv 1 0 1 1.0\nv 1 1 2 .1 .2 .3\nvt 0 0\n"
            "f 1 2/1 3/1/1 4//1\nv 0 1 3\ns off\nf -1 -2 -3\r\nf 1/-1 2/-1 3/-1 # tail\n");
    EXPECT_EQ(mesh.vertices, (Vertices{{0, 0, 0}, {1, 0, 1}, {1, 1, 2}, {0, 1, 3}}));
    EXPECT_EQ(mesh.offsets, (std::vector<std::int64_t>{0, 4, 7, 10}));
    EXPECT_EQ(mesh.corners, (std::vector<std::int32_t>{0, 1, 2, 3, 3, 2, 1, 0, 1, 2}));
}

TEST(Obj, ErrorsNameTheLine) {
    const auto refuse = [](const std::string& text, const std::string& where,
                           const std::string& says) {
        const auto mesh = parse_obj(text, "a.obj");
        ASSERT_FALSE(mesh.ok()) << text;
        EXPECT_EQ(mesh.error().where, "a.obj, " + where) << text;
        EXPECT_NE(mesh.error().message.find(says), std::string::npos) << mesh.error().message;
    };
    const std::string vertices = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
    refuse("v 0 0\n", "line 1", "three numbers");
    refuse(vertices + "f 1 2\n", "line 4", "at least 3");
    refuse(vertices + "f 1 2 0\n", "line 4", "vertex 0 of 3");
    refuse(vertices + "f 1 2 -4\n", "line 4", "vertex -4 of 3");
    refuse(vertices + "f 1 2 5\nf 1 2 4\nv 1 1 1\n", "line 4", "vertex 5 of 4");
    refuse(vertices + "f 1 2 3\nf 1 2 99999999999\n", "line 5", "index_out_of_range");
    for (const std::string corner : {"3/", "3//", "3/1/", "/3", "a", "3.0", "3/1/1/1", "3///"})
        refuse(vertices + "f 1 2 " + corner + "\n", "line 4", "corner of a face");
}

class MeshFiles : public Scratch {};

TEST_F(MeshFiles, ReadWhatWasWrittenToTheBit) {
    PolygonMesh mesh;
    mesh.vertices = {{0.1, -0.0, 1e300}, {1.0 / 3, 2e6 + 0.125, -5e-324}, {3, 4, 5}, {-1, 2, 9}};
    mesh.add_polygon(std::array<std::int32_t, 4>{0, 1, 2, 3});
    mesh.add_polygon(std::array<std::int32_t, 3>{3, 2, 0});
    for (const std::string name : {"a.off", "a.obj", "B.OFF", "B.Obj"}) {
        ASSERT_TRUE(write_mesh(path(name), mesh).ok());
        EXPECT_EQ(recognise(path(name)), FileKind::Mesh);
        const auto read = read_mesh(path(name));
        ASSERT_TRUE(read.ok()) << read.error().text();
        EXPECT_EQ(*read, mesh);
        EXPECT_TRUE(std::signbit(read->vertices[0][1]));
    }
    EXPECT_EQ(files(), (std::vector<std::string>{"B.OFF", "B.Obj", "a.obj", "a.off"}));
}

TEST_F(MeshFiles, FormatsThatAreNotThere) {
    EXPECT_EQ(write_mesh(path("a.ply"), {}).error().code, ErrorCode::InvalidArgument);
    EXPECT_EQ(write_mesh(path("no/a.off"), {}).error().code, ErrorCode::CannotWrite);
    EXPECT_EQ(read_mesh(path("a.off")).error().code, ErrorCode::NotFound);
    std::ofstream(path("a.ply")) << "ply\n";
    EXPECT_EQ(read_mesh(path("a.ply")).error().code, ErrorCode::Unsupported);
    EXPECT_TRUE(files() == std::vector<std::string>{"a.ply"});
}

/// Lines cut, doubled and spoilt.
TEST(HostileText, MutationsAreReadOrRefused) {
    std::mt19937 engine(5);
    for (const auto& [file, target] :
         {std::pair{"off/quads.off", &fuzz::off}, std::pair{"off/coloured.off", &fuzz::off},
          std::pair{"obj/quad.obj", &fuzz::obj}, std::pair{"obj/negative.obj", &fuzz::obj}}) {
        std::ifstream stream(std::string(RELIEF_TEST_DATA) + "/../../fuzz/corpus/" + file);
        const std::vector<std::uint8_t> seed{std::istreambuf_iterator<char>(stream), {}};
        ASSERT_FALSE(seed.empty()) << file;
        for (int k = 0; k < 5000; ++k) {
            auto text = seed;
            for (std::uint32_t edits = 1 + engine() % 4; edits > 0 && !text.empty(); --edits) {
                const std::size_t at = engine() % text.size();
                constexpr std::string_view alphabet = "0123456789-+.eE/# \n\rvfOFC\0";
                if (engine() % 3 == 0) {
                    text.resize(at);
                } else if (engine() % 2 == 0) {
                    text[at] = static_cast<std::uint8_t>(alphabet[engine() % alphabet.size()]);
                } else {
                    const std::vector<std::uint8_t> part(text.begin(),
                                                         text.begin() + std::ptrdiff_t(at / 2));
                    text.insert(text.begin() + std::ptrdiff_t(at), part.begin(), part.end());
                }
            }
            target(text);
        }
    }
}

}  // namespace
}  // namespace relief::io
