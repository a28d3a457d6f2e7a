#include <rapidcheck.h>

#include <cmath>
#include <map>
#include <random>
#include <set>

#include "io/mesh_formats.h"
#include "io/mesh_testing.h"

namespace relief::io {
namespace {

/// Numbers of a type: small ones, and some of all magnitudes.
class Numbers {
  public:
    explicit Numbers(std::mt19937& engine) : engine_(engine) {}

    double of(SampleType type) {
        if (type == SampleType::UInt8) return below(256);
        if (is_integer(type)) return below(30000);
        const double fine =
            std::ldexp(static_cast<double>(engine_()) - 0x1p31,
                       type == SampleType::Float32 ? below(60) - 60 : below(1000) - 600);
        const double number = below(3) == 0 ? below(4) - 1 : fine;
        return type == SampleType::Float32 ? static_cast<double>(static_cast<float>(number))
                                           : number;
    }
    int below(int end) { return static_cast<int>(engine_() % static_cast<unsigned>(end)); }

  private:
    std::mt19937& engine_;
};

PolygonMesh random_polygons(Numbers& numbers, SampleType places) {
    PolygonMesh mesh;
    mesh.vertices.resize(static_cast<std::size_t>(3 + numbers.below(20)));
    for (auto& vertex : mesh.vertices)
        for (double& coordinate : vertex) coordinate = numbers.of(places);
    for (int k = numbers.below(12); k >= 0; --k) {
        Indices polygon(static_cast<std::size_t>(3 + numbers.below(5)));
        for (std::int32_t& v : polygon) v = numbers.below(static_cast<int>(mesh.vertices.size()));
        mesh.add_polygon(polygon);
    }
    return mesh;
}

/// Face-varying elements are different and numbered in the order of the corners, as PLY has them.
MeshAttribute random_attribute(Numbers& numbers, const PolygonMesh& mesh, const std::string& name,
                               int components, SampleType type) {
    MeshAttribute attribute{name, components, type};
    const bool face_varying = numbers.below(2) == 0;
    const auto add_element = [&] {
        for (int k = 0; k < components; ++k) attribute.values.push_back(numbers.of(type));
    };
    if (!face_varying) {
        for (std::size_t v = 0; v < mesh.vertices.size(); ++v) add_element();
        return attribute;
    }
    std::set<Values> seen;
    for (std::int64_t f = 0; f < mesh.polygon_count(); ++f) {
        const bool without = f > 0 && numbers.below(4) == 0;
        for (std::size_t c = 0; c < mesh.polygon(f).size(); ++c) {
            const auto count = static_cast<std::int32_t>(attribute.element_count());
            if (without || (count > 0 && numbers.below(3) > 0)) {
                attribute.corners.push_back(without ? -1 : numbers.below(count));
                continue;
            }
            const auto size = attribute.values.size();
            add_element();
            Values element(attribute.values.begin() + static_cast<std::ptrdiff_t>(size),
                           attribute.values.end());
            const bool is_new = seen.insert(element).second;
            if (!is_new) attribute.values.resize(size);
            attribute.corners.push_back(is_new ? count : 0);
        }
    }
    return attribute;
}

/// Names are used in the order of the faces, as OBJ has them.
FaceLabels random_labels(Numbers& numbers, const PolygonMesh& mesh, const std::string& keyword) {
    FaceLabels labels{keyword};
    for (std::int64_t f = 0; f < mesh.polygon_count(); ++f) {
        const auto count = static_cast<int>(labels.names.size());
        const int label = f == 0 ? count : numbers.below(count + 2) - 1;
        if (label == count) labels.names.push_back("n " + std::to_string(count) + "#");
        labels.of_face.push_back(label);
    }
    return labels;
}

double random_sharpness(Numbers& numbers) {
    return numbers.below(2) == 0 ? HUGE_VAL : 0.1 + numbers.below(9);
}

PolygonMesh random_mesh(Numbers& numbers, SampleType places, SampleType colours,
                        SampleType others) {
    PolygonMesh mesh = random_polygons(numbers, places);
    const auto sometimes = [&] { return numbers.below(2) == 0; };
    const int more = numbers.below(2);
    if (sometimes())
        mesh.attributes.push_back(random_attribute(numbers, mesh, "uv", 2 + more, others));
    if (sometimes())
        mesh.attributes.push_back(random_attribute(numbers, mesh, "colour", 3 + more, colours));
    if (sometimes())
        mesh.attributes.push_back(random_attribute(numbers, mesh, "normal", 3, others));
    for (const char* keyword : {"o", "g", "usemtl", "s"})
        if (sometimes()) mesh.labels.push_back(random_labels(numbers, mesh, keyword));
    if (sometimes()) mesh.libraries = {"a.mtl", "b c.mtl"};
    for (int k = numbers.below(4); k > 0; --k)
        mesh.creases.push_back({k, k % 2, random_sharpness(numbers)});
    mesh.creases.erase(std::remove_if(mesh.creases.begin(), mesh.creases.end(),
                                      [&](const CreaseEdge& crease) {
                                          return crease.a == crease.b ||
                                                 static_cast<std::size_t>(crease.a) >=
                                                     mesh.vertices.size();
                                      }),
                       mesh.creases.end());
    for (int k = numbers.below(3); k > 0; --k)
        mesh.sharp_vertices.push_back({k, random_sharpness(numbers)});
    return mesh;
}

/// An attribute whose corners name its elements as they name the vertices.
bool looks_like_vertices(const MeshAttribute& attribute, const PolygonMesh& mesh) {
    return attribute.corners == mesh.corners &&
           attribute.element_count() == static_cast<std::int64_t>(mesh.vertices.size());
}

TEST(MeshRoundTrip, PlyKeepsEverything) {
    EXPECT_TRUE(rc::check([] {
        std::mt19937 engine(*rc::gen::arbitrary<std::uint32_t>());
        Numbers numbers(engine);
        const auto any = rc::gen::element(SampleType::UInt8, SampleType::UInt16, SampleType::Int16,
                                          SampleType::UInt32, SampleType::Int32,
                                          SampleType::Float32, SampleType::Float64);
        const PolygonMesh mesh = random_mesh(
            numbers, *rc::gen::element(SampleType::Float32, SampleType::Float64), *any, *any);
        RC_ASSERT(check(mesh).ok());
        for (const PlyEncoding encoding : {PlyEncoding::Binary, PlyEncoding::Ascii}) {
            const detail::EncodedMesh file = detail::encode_ply(mesh, encoding);
            RC_ASSERT(file.left_out.empty());
            const auto read = parse_ply(bytes_of(file.bytes), "a.ply");
            RC_ASSERT(read.ok());
            RC_ASSERT(*read == mesh);
        }
    }));
}

TEST(MeshRoundTrip, ObjKeepsAllButTypesAndColoursOfCorners) {
    EXPECT_TRUE(rc::check([] {
        std::mt19937 engine(*rc::gen::arbitrary<std::uint32_t>());
        Numbers numbers(engine);
        PolygonMesh mesh =
            random_mesh(numbers, SampleType::Float64, SampleType::Float64, SampleType::Float64);
        const detail::EncodedMesh file = detail::encode_obj(mesh);
        const auto read = parse_obj(bytes_of(file.bytes), "a.obj");
        RC_ASSERT(read.ok());
        std::vector<std::string> left_out;
        for (MeshAttribute& attribute : mesh.attributes)
            if (attribute.name == "colour" && attribute.face_varying()) {
                left_out.push_back(attribute.name);
            } else if (looks_like_vertices(attribute, mesh)) {
                attribute.corners.clear();
            }
        std::erase_if(mesh.attributes, [&](const MeshAttribute& attribute) {
            return !left_out.empty() && attribute.name == "colour";
        });
        // Random colours go beyond 1; those that are whole are taken for bytes.
        for (MeshAttribute& attribute : mesh.attributes)
            if (const auto* found = read->attribute(attribute.name)) attribute.type = found->type;
        RC_ASSERT(file.left_out == left_out);
        RC_ASSERT(*read == mesh);
    }));
}

TEST(MeshRoundTrip, OffKeepsWhatItSays) {
    EXPECT_TRUE(rc::check([] {
        std::mt19937 engine(*rc::gen::arbitrary<std::uint32_t>());
        Numbers numbers(engine);
        PolygonMesh mesh = random_mesh(numbers, SampleType::Float64,
                                       *rc::gen::element(SampleType::UInt8, SampleType::Float64),
                                       SampleType::Float64);
        const detail::EncodedMesh file = detail::encode_off(mesh);
        const auto read = parse_off(bytes_of(file.bytes), "a.off");
        RC_ASSERT(read.ok());
        const std::set<std::string> left_out(file.left_out.begin(), file.left_out.end());
        std::erase_if(mesh.attributes,
                      [&](const auto& attribute) { return left_out.contains(attribute.name); });
        for (const FaceLabels& labels : mesh.labels) RC_ASSERT(left_out.contains(labels.keyword));
        RC_ASSERT(left_out.contains("mtllib") == !mesh.libraries.empty());
        RC_ASSERT(left_out.contains("crease") == !mesh.creases.empty());
        RC_ASSERT(left_out.contains("corner") == !mesh.sharp_vertices.empty());
        mesh.labels.clear();
        mesh.libraries.clear();
        mesh.creases.clear();
        mesh.sharp_vertices.clear();
        RC_ASSERT(*read == mesh);
    }));
}

/// The places of the corners of all triangles; those that are degenerate are left out.
std::vector<std::array<double, 3>> triangle_corners(const PolygonMesh& mesh) {
    std::vector<std::array<double, 3>> places;
    for (std::int64_t f = 0; f < mesh.polygon_count(); ++f) {
        const auto polygon = mesh.polygon(f);
        detail::for_fan(polygon.size(), [&](std::size_t a, std::size_t b, std::size_t c) {
            const auto place = [&](std::size_t k) {
                return mesh.vertices[static_cast<std::size_t>(polygon[k])];
            };
            if (place(a) == place(b) || place(b) == place(c) || place(c) == place(a)) return;
            for (const std::size_t k : {a, b, c}) places.push_back(place(k));
        });
    }
    return places;
}

TEST(MeshRoundTrip, StlKeepsTriangles) {
    EXPECT_TRUE(rc::check([] {
        std::mt19937 engine(*rc::gen::arbitrary<std::uint32_t>());
        Numbers numbers(engine);
        const PolygonMesh mesh = random_polygons(numbers, SampleType::Float32);
        const auto file = detail::encode_stl(mesh);
        RC_ASSERT(file.ok());
        const auto read = parse_stl(bytes_of(file->bytes), "a.stl");
        RC_ASSERT(read.ok());
        RC_ASSERT(check(read->mesh).ok());
        RC_ASSERT(triangle_corners(read->mesh) == triangle_corners(mesh));
        const auto triangles =
            static_cast<std::int64_t>(mesh.corners.size()) - 2 * mesh.polygon_count();
        RC_ASSERT(read->mesh.polygon_count() + read->degenerate_facets == triangles);
        const std::set<std::array<double, 3>> places(read->mesh.vertices.begin(),
                                                     read->mesh.vertices.end());
        RC_ASSERT(places.size() == read->mesh.vertices.size());
    }));
}

}  // namespace
}  // namespace relief::io
