#include <array>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>

#include "../fuzz/mesh_readers.h"
#include "io/mesh_testing.h"
#include "io/scratch.h"
#include "relief/io/file.h"
#include "relief/io/file_kind.h"

namespace relief::io {
namespace {

class MeshFiles : public Scratch {
  protected:
    void write(const std::string& name, const std::string& bytes) const {
        std::ofstream(path(name), std::ios::binary) << bytes;
    }
};

TEST_F(MeshFiles, ReadWhatWasWrittenToTheBit) {
    PolygonMesh mesh;
    mesh.vertices = {{0.1, -0.0, 1e300}, {1.0 / 3, 2e6 + 0.125, -5e-324}, {3, 4, 5}, {-1, 2, 9}};
    mesh.add_polygon(std::array<std::int32_t, 4>{0, 1, 2, 3});
    mesh.add_polygon(std::array<std::int32_t, 3>{3, 2, 0});
    for (const std::string name : {"a.off", "a.obj", "a.ply", "B.OFF", "B.Obj"}) {
        EXPECT_EQ(value_of(write_mesh(path(name), mesh)), std::vector<std::string>());
        EXPECT_EQ(recognise(path(name)), FileKind::Mesh);
        const auto read = read_mesh(path(name));
        ASSERT_TRUE(read.ok()) << read.error().text();
        EXPECT_EQ(read->mesh, mesh);
        EXPECT_EQ(read->degenerate_facets, 0);
        EXPECT_TRUE(std::signbit(read->mesh.vertices[0][1]));
    }
    EXPECT_EQ(files(), (Names{"B.OFF", "B.Obj", "a.obj", "a.off", "a.ply"}));
}

TEST_F(MeshFiles, OptionsAndWhatIsLeftOut) {
    PolygonMesh mesh;
    mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    mesh.add_polygon(std::array{0, 1, 2});
    mesh.creases = {{0, 1, HUGE_VAL}};
    const auto text_of = [&](const std::string& name) {
        const auto bytes = value_of(read_file(path(name)));
        return std::string(bytes.begin(), bytes.end());
    };
    ASSERT_TRUE(write_mesh(path("a.ply"), mesh, {.ply = PlyEncoding::Ascii}).ok());
    EXPECT_NE(text_of("a.ply").find("format ascii 1.0"), std::string::npos);
    ASSERT_TRUE(write_mesh(path("a.ply"), mesh).ok());
    EXPECT_NE(text_of("a.ply").find("format binary_little_endian 1.0"), std::string::npos);
    for (const std::string name : {"a.off", "a.stl", "a.glb"}) {
        EXPECT_EQ(value_of(write_mesh(path(name), mesh)), (Names{"crease"}));
        EXPECT_EQ(recognise(path(name)), FileKind::Mesh);
    }
    EXPECT_EQ(value_of(read_mesh(path("a.stl"))).mesh.corners, mesh.corners);
    expect_refused(read_mesh(path("a.glb")), path("a.glb"), "written but not read",
                   ErrorCode::Unsupported);
}

TEST_F(MeshFiles, FilesAreRecognisedByContentFirst) {
    const std::string triangle = "0 0 0\n1 0 0\n0 1 0\n";
    const std::string facet =
        "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 "
        "0\nendloop\nendfacet\n";
    std::string binary(84 + 50, '\0');
    binary[80] = 1;
    detail::append_little_endian(binary, 1.0F);
    binary.replace(84 + 24, 4, binary.substr(84 + 50));
    binary.replace(84 + 40, 4, binary.substr(84 + 50));
    binary.resize(84 + 50);
    write("a.obj", "STOFF 3 1\n0 0 0 0 0\n1 0 0 0 0\n0 1 0 0 0\n3 0 1 2\n");
    write("b",
          "ply\nformat ascii 1.0\nelement vertex 3\nproperty int x\nproperty int y\n"
          "property int z\nelement face 1\nproperty list uchar int vertex_index\nend_header\n" +
              triangle + "3 0 1 2\n");
    write("c", "Solid\n" + facet + "endsolid\n");
    write("d.x", binary);
    write("e.OBJ", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    for (const std::string name : {"a.obj", "b", "c", "d.x", "e.OBJ"}) {
        const LoadedMesh loaded = value_of(read_mesh(path(name)));
        EXPECT_EQ(loaded.mesh.vertices, (Vertices{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}})) << name;
        EXPECT_EQ(loaded.mesh.corners, (Indices{0, 1, 2})) << name;
    }
    EXPECT_EQ(recognise(path("b")), FileKind::Mesh);
    EXPECT_EQ(recognise(path("c")), FileKind::Mesh);
}

TEST_F(MeshFiles, ErrorsNameTheFile) {
    PolygonMesh mesh;
    const auto refuse = [&](const std::string& name, const std::string& where,
                            const std::string& says, ErrorCode code) {
        expect_refused(write_mesh(path(name), mesh), where, says, code);
    };
    refuse("a.xyz", path("a.xyz"), ".obj, .off, .ply, .stl or .glb", ErrorCode::InvalidArgument);
    refuse("no/a.off", path("no/a.off"), "create", ErrorCode::CannotWrite);
    refuse("a.glb", path("a.glb"), "at least one polygon", ErrorCode::BadInput);
    mesh.vertices = {{0, 0, NAN}};
    refuse("a.off", path("a.off") + ", vertex 0", "non_finite_vertex", ErrorCode::BadInput);
    mesh.vertices = {{0, 0, 1e300}};
    refuse("a.stl", path("a.stl") + ", vertex 0", "too large", ErrorCode::BadInput);
    EXPECT_TRUE(files().empty()) << "what is refused leaves nothing behind";

    write("a.ply", "v 0 0 0\n");
    write("a.stl", "v 0 0 0\n");
    write("a.off", "v 0 0 0\n");
    write("a.txt", "v 0 0 0\n");
    expect_refused(read_mesh(path("a.ply")), path("a.ply") + ", line 1", "word ply");
    expect_refused(read_mesh(path("a.stl")), path("a.stl") + ", byte 8", "84 bytes");
    expect_refused(read_mesh(path("a.off")), path("a.off") + ", line 1", "word OFF");
    expect_refused(read_mesh(path("a.txt")), path("a.txt"), "not read", ErrorCode::Unsupported);
    expect_refused(read_mesh(path("a.obj")), path("a.obj"), "can not read", ErrorCode::NotFound);
}

struct KnownMesh {
    const char* file;
    std::size_t vertices;
    std::int64_t triangles;
    std::int64_t quads;
    std::int64_t others;
};

/// What the files are said to hold where they come from.
constexpr KnownMesh kKnown[] = {{"armadillo.off", 26002, 52000, 0, 0},
                                {"bear.off", 13826, 27648, 0, 0},
                                {"blade.off", 8231, 16222, 0, 0},
                                {"bull.off", 6200, 12396, 0, 0},
                                {"bunny00.off", 37706, 75408, 0, 0},
                                {"bunny_adaptive.off", 5884, 11764, 0, 0},
                                {"camel.off", 9770, 19536, 0, 0},
                                {"cat_head.obj", 131, 248, 0, 0},
                                {"cross_quad.off", 40, 0, 38, 0},
                                {"dodecahedron_poly.obj", 20, 0, 0, 12},
                                {"elephant-with-holes.off", 2798, 4463, 0, 0},
                                {"elephant.off", 2775, 5558, 0, 0},
                                {"fandisk.off", 6475, 12946, 0, 0},
                                {"fandisk_quads.off", 766, 0, 764, 0},
                                {"hemisphere.off", 1861, 3600, 0, 0},
                                {"hole_capsule.off", 89, 0, 76, 0},
                                {"lion-head.off", 8356, 16674, 0, 0},
                                {"man.off", 17495, 34986, 0, 0},
                                {"moebius.obj", 280, 0, 224, 0},
                                {"mpi.off", 90, 13, 12, 27},
                                {"mushroom.off", 2337, 4608, 0, 0},
                                {"osd_catmark_cube_level0.obj", 26, 0, 24, 0},
                                {"osd_catmark_cube_level4.obj", 6146, 0, 6144, 0},
                                {"osd_catmark_edgecorner_level0.obj", 156, 0, 112, 0},
                                {"osd_catmark_edgecorner_level4.obj", 29316, 0, 28672, 0},
                                {"osd_catmark_flap_level0.obj", 21, 0, 12, 0},
                                {"osd_catmark_flap_level4.obj", 3201, 0, 3072, 0},
                                {"osd_catmark_tent_level0.obj", 49, 0, 36, 0},
                                {"osd_catmark_tent_level4.obj", 9409, 0, 9216, 0},
                                {"osd_loop_icosahedron_level0.obj", 42, 80, 0, 0},
                                {"osd_loop_icosahedron_level4.obj", 10242, 20480, 0, 0},
                                {"osd_loop_saddle_edgecorner_level0.obj", 15, 16, 0, 0},
                                {"osd_loop_saddle_edgecorner_level4.obj", 2145, 4096, 0, 0},
                                {"spot.ply", 2930, 5856, 0, 0},
                                {"spot_control_mesh.obj", 188, 4, 160, 16},
                                {"spot_quadrangulated.obj", 2930, 0, 2928, 0},
                                {"suzanne.obj", 507, 32, 468, 0},
                                {"three_peaks.off", 1907, 3671, 0, 0},
                                {"torus_quad.off", 25, 0, 25, 0},
                                {"triple_vierbein.obj", 75, 108, 0, 0}};

std::filesystem::path real_meshes() {
    const char* chosen = std::getenv("RELIEF_DATA");
    return std::filesystem::path(chosen ? chosen : RELIEF_SHARED_DATA) / "meshes";
}

TEST(RealMeshes, HoldWhatTheyAreSaidTo) {
    int found = 0;
    for (const KnownMesh& known : kKnown) {
        const std::string path = (real_meshes() / known.file).string();
        if (!std::filesystem::exists(path)) continue;
        ++found;
        const PolygonMesh mesh = value_of(read_mesh(path)).mesh;
        std::array<std::int64_t, 3> sizes{};
        for (std::int64_t k = 0; k < mesh.polygon_count(); ++k)
            ++sizes[std::min<std::size_t>(mesh.polygon(k).size() - 3, 2)];
        EXPECT_EQ(mesh.vertices.size(), known.vertices) << known.file;
        EXPECT_EQ(sizes, (std::array{known.triangles, known.quads, known.others})) << known.file;
        EXPECT_TRUE(check(mesh).ok()) << known.file;
        const PolygonMesh again = ply(detail::encode_ply(mesh, PlyEncoding::Binary).bytes);
        EXPECT_EQ(again.vertices, mesh.vertices) << known.file;
        EXPECT_EQ(again.corners, mesh.corners) << known.file;
    }
    if (found == 0)
        GTEST_SKIP() << "there are no meshes in " << real_meshes()
                     << "; set RELIEF_DATA to the folder that holds meshes/";
}

TEST(RealMeshes, SpotTwice) {
    const auto file = real_meshes() / "spot_quadrangulated.obj";
    if (!std::filesystem::exists(file)) GTEST_SKIP() << file << " is not there";
    const PolygonMesh quads = value_of(read_mesh(file.string())).mesh;
    const MeshAttribute* uv = quads.attribute("uv");
    ASSERT_NE(uv, nullptr);
    EXPECT_TRUE(uv->face_varying());
    EXPECT_EQ(uv->element_count(), 3225);
    const PolygonMesh triangles = value_of(read_mesh((real_meshes() / "spot.ply").string())).mesh;
    ASSERT_EQ(triangles.vertices.size(), quads.vertices.size());
    double furthest = 0;
    for (std::size_t v = 0; v < quads.vertices.size(); ++v)
        for (std::size_t k = 0; k < 3; ++k)
            furthest =
                std::max(furthest, std::abs(quads.vertices[v][k] - triangles.vertices[v][k]));
    EXPECT_LT(furthest, 2e-6) << "one file has 6 decimals, the other floats of at most 1.2";
}

using Target = void (*)(std::span<const std::uint8_t>);

std::vector<std::pair<std::string, Target>> seeds() {
    return {{"obj/labels.obj", &fuzz::obj}, {"obj/negative.obj", &fuzz::obj},
            {"obj/quad.obj", &fuzz::obj},   {"off/coloured.off", &fuzz::off},
            {"off/parts.off", &fuzz::off},  {"off/quads.off", &fuzz::off},
            {"ply/ascii.ply", &fuzz::ply},  {"ply/big.ply", &fuzz::ply},
            {"ply/little.ply", &fuzz::ply}, {"stl/ascii.stl", &fuzz::stl},
            {"stl/binary.stl", &fuzz::stl}};
}

std::vector<std::uint8_t> seed_bytes(const std::string& file) {
    std::ifstream stream(std::string(RELIEF_TEST_DATA) + "/../../fuzz/corpus/" + file,
                         std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), {}};
}

TEST(HostileMeshes, CutAnywhere) {
    for (const auto& [file, target] : seeds()) {
        const auto seed = seed_bytes(file);
        ASSERT_FALSE(seed.empty()) << file;
        for (std::size_t size = 0; size < seed.size(); ++size) target(std::span(seed).first(size));
    }
}

/// What is cut is not taken for whole, where the format tells.
TEST(HostileMeshes, CutFilesAreRefused) {
    for (const std::string file : {"ply/big.ply", "ply/little.ply", "stl/binary.stl"}) {
        const auto seed = seed_bytes(file);
        for (std::size_t size = 0; size < seed.size(); ++size) {
            const auto part = std::span(seed).first(size);
            const bool read = file.starts_with("ply") ? parse_ply(part, "mesh").ok()
                                                      : parse_stl(part, "mesh").ok();
            EXPECT_FALSE(read) << file << ", " << size;
        }
    }
}

/// Lines cut, doubled and spoilt.
TEST(HostileMeshes, MutationsAreReadOrRefused) {
    std::mt19937 engine(5);
    for (const auto& [file, target] : seeds()) {
        const auto seed = seed_bytes(file);
        ASSERT_FALSE(seed.empty()) << file;
        for (int k = 0; k < 3000; ++k) {
            auto text = seed;
            for (std::uint32_t edits = 1 + engine() % 4; edits > 0 && !text.empty(); --edits) {
                const std::size_t at = engine() % text.size();
                constexpr std::string_view alphabet = "0123456789-+.eE/# \n\rvfOFCgst\0\xFF";
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
