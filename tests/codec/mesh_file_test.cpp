#include <gtest/gtest.h>

#include <cstring>
#include <map>

#include "../fuzz/meshes.h"
#include "relief/codec/mesh_codec.h"
#include "relief/mesh/closest.h"
#include "relief/multires/polygon_subdivision.h"
#include "relief/multires/subdivide.h"
#include "shapes.h"
#include "support.h"

/// Meshes to files and back.
namespace relief::codec {
namespace {

using Kind = Goal::Kind;
using mesh::Index;
using multires::MeshScheme;
using test::Shape;

PolygonMesh polygons(const mesh::FaceList& faces, const std::vector<Vec3<double>>& points) {
    PolygonMesh mesh;
    for (const auto& p : points) mesh.vertices.push_back({p.x, p.y, p.z});
    mesh.offsets = faces.offsets;
    mesh.corners.assign(faces.corners.begin(), faces.corners.end());
    return mesh;
}

/// A subdivided mesh with bumps; noise 0: a pure subdivision surface.
PolygonMesh subdivided(const Shape& base, MeshScheme scheme, int steps, double noise) {
    multires::SubdividedMesh<double> mesh{base.topology(), {{}}, {}};
    for (const auto& p : base.points) mesh.arrays[0].push_back({p[0], p[1], p[2]});
    mesh = *multires::subdivide(std::move(mesh), {.scheme = scheme}, steps);
    test::Noise random(5);
    for (auto& p : mesh.arrays[0]) p += noise * Vec3<double>{random(), random(), random()};
    return polygons(mesh::faces_of(mesh.mesh), mesh.arrays[0]);
}

PolygonMesh shuffled(const PolygonMesh& mesh, unsigned seed) {
    Shape shape;
    for (const auto& v : mesh.vertices) shape.points.push_back(v);
    for (std::int64_t f = 0; f < mesh.polygon_count(); ++f)
        shape.faces.add(std::vector<Index>(mesh.polygon(f).begin(), mesh.polygon(f).end()));
    const Shape mixed = test::shuffled(shape, seed);
    PolygonMesh result;
    result.vertices = mixed.points;
    result.offsets = mixed.faces.offsets;
    result.corners.assign(mixed.faces.corners.begin(), mixed.faces.corners.end());
    return result;
}

struct Distances {
    double max = 0;
    double rms = 0;
};
Distances distances(const PolygonMesh& a, const PolygonMesh& b) {
    Distances result;
    EXPECT_EQ(a.vertices.size(), b.vertices.size());
    for (std::size_t v = 0; v < a.vertices.size(); ++v) {
        double square = 0;
        for (std::size_t k = 0; k < 3; ++k)
            square += std::pow(a.vertices[v][k] - b.vertices[v][k], 2);
        result.max = std::max(result.max, std::sqrt(square));
        result.rms += square;
    }
    result.rms = std::sqrt(result.rms / static_cast<double>(a.vertices.size()));
    return result;
}

struct Case {
    std::string name;
    PolygonMesh mesh;
    MeshScheme scheme;
};

std::vector<Case> cases(double noise) {
    const Shape holed = test::without_faces(test::grid(5, 5, true, true), {7, 8, 30});
    return {
        {"loop", subdivided(test::flipped(test::icosahedron(), 40, 3), MeshScheme::Loop, 3, noise),
         MeshScheme::Loop},
        {"loop open",
         subdivided(test::flipped(test::grid(4, 3, true), 20, 2), MeshScheme::Loop, 2, noise),
         MeshScheme::Loop},
        {"sqrt3",
         subdivided(test::flipped(test::icosahedron(), 40, 3), MeshScheme::Sqrt3, 4, noise),
         MeshScheme::Sqrt3},
        {"sqrt3 holes", subdivided(holed, MeshScheme::Sqrt3, 3, noise), MeshScheme::Sqrt3},
        {"quads", subdivided(test::double_torus(), MeshScheme::CatmullClark, 3, noise),
         MeshScheme::CatmullClark},
        {"polygons",
         subdivided(test::both(test::tetrahedron(), test::grid(2, 2, false)),
                    MeshScheme::CatmullClark, 2, noise),
         MeshScheme::CatmullClark},
        {"cube", subdivided(test::cube(), MeshScheme::CatmullClark, 2, noise),
         MeshScheme::CatmullClark}};
}

TEST(MeshFile, MaxErrorHoldsAtEveryVertex) {
    for (const Case& c : cases(0.01)) {
        for (const bool mixed : {false, true}) {
            const PolygonMesh mesh = mixed ? shuffled(c.mesh, 3) : c.mesh;
            for (const double bound : {0.05, 1e-3, 1e-6}) {
                const auto encoded = encode_mesh(mesh, {.goal = {Kind::MaxError, bound}});
                ASSERT_TRUE(encoded.ok()) << c.name << " " << encoded.error().text();
                EXPECT_EQ(encoded->report.scheme, c.scheme);
                const MeshFile file = *MeshFile::open(encoded->bytes);
                const auto decoded = file.decode(0);
                ASSERT_TRUE(decoded.ok()) << c.name << decoded.error().text();
                EXPECT_EQ(decoded->corners, mesh.corners) << c.name;
                const Distances off = distances(mesh, *decoded);
                EXPECT_LE(off.max, bound) << c.name;
                EXPECT_NEAR(off.max, encoded->report.max_error, 1e-15);
                EXPECT_NEAR(off.rms, encoded->report.rms_error, 1e-12 * off.rms);
                EXPECT_GT(off.max, 0.5 * std::min(bound, 0.01)) << c.name;
                EXPECT_GE(file.max_error(), off.max);
            }
        }
    }
}

TEST(MeshFile, LosslessIsExactToTheBit) {
    for (Case& c : cases(0.01)) {
        for (const int kind : {0, 1, 2}) {
            for (auto& v : c.mesh.vertices)
                for (double& x : v)
                    if (kind == 1)
                        x = static_cast<float>(x);
                    else if (kind == 2)
                        x = std::nearbyint(x * 1000) / 1000;
            const auto encoded = encode_mesh(c.mesh, {});
            ASSERT_TRUE(encoded.ok()) << encoded.error().text();
            const PolygonMesh decoded = *MeshFile::open(encoded->bytes)->decode(0);
            ASSERT_EQ(decoded.vertices.size(), c.mesh.vertices.size());
            EXPECT_EQ(0, std::memcmp(decoded.vertices.data(), c.mesh.vertices.data(),
                                     24 * decoded.vertices.size()))
                << c.name << kind;
            EXPECT_EQ(encoded->report.max_error, 0);
        }
    }
}

TEST(MeshFile, RmsAndByteGoals) {
    for (const Case& c : cases(0.02)) {
        const auto encoded = encode_mesh(c.mesh, {.goal = {Kind::RmsError, 2e-3}});
        ASSERT_TRUE(encoded.ok()) << encoded.error().text();
        const Distances off = distances(c.mesh, *MeshFile::open(encoded->bytes)->decode(0));
        EXPECT_LE(off.rms, 2e-3) << c.name;
        EXPECT_GE(off.rms, 0.9 * 2e-3) << c.name;
        const double bytes = 0.8 * static_cast<double>(encoded->bytes.size());
        const auto smaller = encode_mesh(c.mesh, {.goal = {Kind::Bytes, bytes}});
        ASSERT_TRUE(smaller.ok()) << c.name << smaller.error().text();
        EXPECT_LE(static_cast<double>(smaller->bytes.size()), bytes);
        EXPECT_GE(static_cast<double>(smaller->bytes.size()), 0.85 * bytes) << c.name;
        const auto half = encode_mesh(c.mesh, {.goal = {Kind::Keep, 50}});
        ASSERT_TRUE(half.ok());
        EXPECT_LE(half->report.kept, static_cast<std::int64_t>(c.mesh.vertices.size() / 2 + 1));
        EXPECT_GE(half->report.kept, static_cast<std::int64_t>(0.48 * c.mesh.vertices.size()));
    }
    const auto none = encode_mesh(cases(0)[0].mesh, {.goal = {Kind::Bytes, 60}});
    ASSERT_FALSE(none.ok());
    EXPECT_NE(none.error().text().find("no file is that small"), std::string::npos);
}

/// What is promised of surfaces is what mesh::surface_distance measures, and takes less.
TEST(MeshFile, DistancesOfSurfaces) {
    for (const Case& c : cases(0.01)) {
        if (c.name != "loop" && c.name != "quads") continue;
        for (const bool mixed : {c.name == "loop"}) {
            const PolygonMesh mesh = mixed ? shuffled(c.mesh, 3) : c.mesh;
            for (const Goal& goal : {Goal{Kind::RmsError, 1e-3}, Goal{Kind::MaxError, 3e-3}}) {
                MeshEncodeOptions options{.goal = goal, .distance = MeshDistance::Surface};
                const auto encoded = encode_mesh(mesh, options);
                ASSERT_TRUE(encoded.ok()) << c.name << " " << encoded.error().text();
                const MeshFile file = *MeshFile::open(encoded->bytes);
                EXPECT_EQ(file.distance(), MeshDistance::Surface);
                const auto distance = *mesh::surface_distance(mesh, *file.decode(0));
                EXPECT_EQ(distance.largest(), encoded->report.max_error) << c.name;
                EXPECT_EQ(distance.rms(), encoded->report.rms_error) << c.name;
                // Headers have four digits.
                EXPECT_NEAR(distance.rms(), file.rms_error(), 1e-3 * distance.rms()) << c.name;
                EXPECT_LE(distance.largest(), file.max_error()) << c.name;
                const bool rms = goal.kind == Kind::RmsError;
                EXPECT_LE(rms ? distance.rms() : distance.largest(), goal.value) << c.name;
                options.distance = MeshDistance::Vertices;
                if (rms) {
                    EXPECT_LT(encoded->bytes.size(), encode_mesh(mesh, options)->bytes.size());
                }
            }
        }
    }
    PolygonMesh large = cases(0)[0].mesh;
    for (auto& v : large.vertices) v[0] *= 1e80;
    const auto refused = encode_mesh(large, {.distance = MeshDistance::Surface});
    ASSERT_FALSE(refused.ok());
    EXPECT_NE(refused.error().text().find("at most 1e75"), std::string::npos);
}

/// A pure subdivision surface takes hardly more than its base.
TEST(MeshFile, PureSurfacesAreSmall) {
    const PolygonMesh mesh =
        subdivided(test::flipped(test::icosahedron(), 40, 3), MeshScheme::Loop, 6, 0);
    const auto encoded = encode_mesh(mesh, {.goal = {Kind::MaxError, 1e-4}});
    ASSERT_TRUE(encoded.ok());
    EXPECT_EQ(encoded->report.levels, 6);
    const MeshFile file = *MeshFile::open(encoded->bytes);
    const std::uint64_t base = file.bytes_for(6);
    EXPECT_LE(8.0 * static_cast<double>(encoded->bytes.size() - base),
              0.02 * static_cast<double>(mesh.vertices.size()));
}

TEST(MeshFile, LevelsAndPrefixes) {
    for (const Case& c : cases(0.01)) {
        const auto encoded = *encode_mesh(c.mesh, {.goal = {Kind::MaxError, 1e-3}});
        const MeshFile file = *MeshFile::open(encoded.bytes);
        EXPECT_EQ(file.finest_level(), 0);
        EXPECT_TRUE(file.checksums_ok());
        for (int level = 0; level <= file.levels(); ++level) {
            const auto mesh = file.decode(level);
            ASSERT_TRUE(mesh.ok()) << c.name << mesh.error().text();
            EXPECT_EQ(mesh->vertices.size(), file.counts(level).vertices);
            EXPECT_EQ(static_cast<std::uint64_t>(mesh->polygon_count()), file.counts(level).faces);
            const auto prefix = MeshFile::open(std::make_shared<MemorySource>(encoded.bytes),
                                               file.bytes_for(level));
            ASSERT_TRUE(prefix.ok()) << c.name << prefix.error().text();
            EXPECT_EQ(prefix->finest_level(), level) << c.name;
            EXPECT_EQ(*prefix->decode(level), *mesh) << c.name;
            if (level > 0) {
                EXPECT_FALSE(prefix->decode(level - 1).ok());
            }
        }
        EXPECT_FALSE(file.decode(file.levels() + 1).ok());
    }
}

/// Vertices and corners of coarser levels have what those of the finest one have at the same
/// vertex, which its random normal tells.
void expect_coarse_attributes(const MeshFile& file, const PolygonMesh& finest) {
    for (int level = 1; level <= file.levels(); ++level) {
        const PolygonMesh coarse = *file.decode(level);
        ASSERT_EQ(coarse.attributes.size(), finest.attributes.size());
        const MeshAttribute& normal = *coarse.attribute("normal");
        const MeshAttribute& fine_normal = *finest.attribute("normal");
        const MeshAttribute& uv = *coarse.attribute("uv");
        const MeshAttribute& fine_uv = *finest.attribute("uv");
        std::map<double, std::size_t> vertex_of;  // random normals differ
        for (std::size_t v = 0; v < finest.vertices.size(); ++v)
            vertex_of[fine_normal.values[3 * v]] = v;
        for (std::size_t c = 0; c < coarse.corners.size(); ++c) {
            const auto v = static_cast<std::size_t>(coarse.corners[c]);
            ASSERT_EQ(vertex_of.count(normal.values[3 * v]), 1U);
            const std::size_t fine = vertex_of[normal.values[3 * v]];
            EXPECT_EQ(normal.values[3 * v + 2], fine_normal.values[3 * fine + 2]);
            if (uv.corners[c] < 0) continue;
            bool found = false;  // an element of a corner at that vertex
            for (std::size_t k = 0; k < finest.corners.size() && !found; ++k)
                found = finest.corners[k] == static_cast<std::int32_t>(fine) &&
                        fine_uv.corners[k] >= 0 &&
                        *fine_uv.element(fine_uv.corners[k]) == *uv.element(uv.corners[c]);
            EXPECT_TRUE(found) << level << " " << c;
        }
        ASSERT_EQ(coarse.labels.size(), 1U);
        EXPECT_EQ(coarse.labels[0].names, finest.labels[0].names);
    }
}

TEST(MeshFile, AttributesLabelsAndCreasesStay) {
    for (const unsigned seed : {0U, 4U}) {
        PolygonMesh mesh = subdivided(test::cube(), MeshScheme::CatmullClark, 3, 0.01);
        if (seed > 0) mesh = shuffled(mesh, seed);
        test::Noise noise(3);
        MeshAttribute colour{"colour", 3, SampleType::UInt8, {}, {}};
        MeshAttribute normal{"normal", 3, SampleType::Float32, {}, {}};
        for (std::size_t v = 0; v < mesh.vertices.size(); ++v)
            for (int k = 0; k < 3; ++k) {
                colour.values.push_back(std::floor(128 + 120 * mesh.vertices[v][0] / 2));
                normal.values.push_back(static_cast<float>(noise()));
            }
        MeshAttribute uv{"uv", 2, SampleType::Float64, {}, {}};
        for (std::size_t c = 0; c < mesh.corners.size(); ++c) {
            uv.corners.push_back(c < 8 ? -1 : static_cast<std::int32_t>(c / 2));
            if (c % 2 == 0) uv.values.insert(uv.values.end(), {noise(), 0.5});
        }
        mesh.attributes = {colour, normal, uv};
        FaceLabels groups{"g", {"left", "right"}, {}};
        for (std::int64_t f = 0; f < mesh.polygon_count(); ++f)
            groups.of_face.push_back(static_cast<std::int32_t>(f % 3) - 1);
        mesh.labels = {groups};
        mesh.libraries = {"things.mtl"};
        mesh.creases = {{mesh.corners[0], mesh.corners[1], 2.5},
                        {mesh.corners[1], mesh.corners[2], HUGE_VAL}};
        mesh.sharp_vertices = {{3, HUGE_VAL}};
        for (const bool keep : {true, false}) {
            const auto encoded =
                encode_mesh(mesh, {.goal = {Kind::MaxError, 0.01}, .keep_order = keep});
            ASSERT_TRUE(encoded.ok()) << encoded.error().text();
            EXPECT_EQ(encoded->report.lost_creases, 1);
            const PolygonMesh decoded = *MeshFile::open(encoded->bytes)->decode(0);
            EXPECT_EQ(decoded.libraries, mesh.libraries);
            if (!keep) {
                EXPECT_EQ(decoded.attributes[0].values.size(), colour.values.size());
                continue;
            }
            expect_coarse_attributes(*MeshFile::open(encoded->bytes), decoded);
            EXPECT_EQ(decoded.attributes, mesh.attributes);
            EXPECT_EQ(decoded.labels, mesh.labels);
            EXPECT_EQ(decoded.creases, mesh.creases);
            EXPECT_EQ(decoded.sharp_vertices, mesh.sharp_vertices);
        }
    }
}

/// Corners of the boundary that stay without being marked are not among those that are.
TEST(MeshFile, MarkedCornersTakeNoSpaceBesideOthers) {
    PolygonMesh base = polygons(test::grid(6, 6, true).faces, {});
    test::Noise random(3);
    for (const auto& p : test::grid(6, 6, true).points)
        base.vertices.push_back({p[0], p[1], 0.3 * random()});
    for (const int v : {1, 3, 5}) base.sharp_vertices.push_back({v, HUGE_VAL});
    PolygonMesh mesh = *multires::subdivide(base, multires::MeshSpec{MeshScheme::Loop},
                                            {.steps = 2, .boundary_corners = true});
    mesh.sharp_vertices = base.sharp_vertices;
    for (const bool keep : {true, false}) {
        const auto encoded =
            encode_mesh(mesh, {.goal = {Kind::MaxError, 1e-3}, .levels = 2, .keep_order = keep});
        ASSERT_TRUE(encoded.ok()) << encoded.error().text();
        const MeshFile file = *MeshFile::open(encoded->bytes);
        // Nothing but the base has details: the corners are where they were.
        EXPECT_EQ(encoded->report.kept, encoded->report.base_vertices);
        EXPECT_EQ(file.chunks().back().kind, "creases");
        EXPECT_EQ(file.chunks().back().bytes, 1U);
        EXPECT_EQ(file.decode(0)->sharp_vertices.size(), mesh.sharp_vertices.size());
        EXPECT_GT(file.decode(1)->sharp_vertices.size(), mesh.sharp_vertices.size());
    }
}

/// Without its order a shuffled mesh takes less.
TEST(MeshFile, OrderHasItsPrice) {
    const PolygonMesh mesh = shuffled(
        subdivided(test::flipped(test::icosahedron(), 40, 3), MeshScheme::Loop, 3, 0.01), 9);
    const Goal goal{Kind::MaxError, 1e-3};
    const auto kept = *encode_mesh(mesh, {.goal = goal});
    const auto free = *encode_mesh(mesh, {.goal = goal, .keep_order = false});
    EXPECT_LT(free.bytes.size(), kept.bytes.size() - mesh.vertices.size());
    const PolygonMesh decoded = *MeshFile::open(free.bytes)->decode(0);
    EXPECT_EQ(decoded.polygon_count(), mesh.polygon_count());
}

/// Sharp creases that come from the base make details small.
TEST(MeshFile, CreasesTakePart) {
    multires::SubdividedMesh<double> mesh{test::cube().topology(), {{}}, {}};
    for (const auto& p : test::cube().points) mesh.arrays[0].push_back({p[0], p[1], p[2]});
    mesh.sharpness.edges.assign(mesh.mesh.edge_count, 0);
    for (Index h = 0; h < 4; ++h) mesh.sharpness.edges[mesh.mesh.edge[h]] = HUGE_VAL;
    mesh = *multires::subdivide(std::move(mesh), {.scheme = MeshScheme::CatmullClark}, 4);
    PolygonMesh with = polygons(mesh::faces_of(mesh.mesh), mesh.arrays[0]);
    const PolygonMesh without = with;
    for (Index h = 0; h < mesh.mesh.half_edge_count(); ++h)
        if (mesh.mesh.is_first(h) && mesh.sharpness.edges[mesh.mesh.edge[h]] > 0)
            with.creases.push_back({static_cast<std::int32_t>(mesh.mesh.origin[h]),
                                    static_cast<std::int32_t>(mesh.mesh.target(h)), HUGE_VAL});
    const Goal goal{Kind::MaxError, 1e-4};
    const auto sharp = *encode_mesh(with, {.goal = goal});
    EXPECT_EQ(sharp.report.lost_creases, 0);
    EXPECT_EQ(sharp.report.kept, 8);
    EXPECT_GT(encode_mesh(without, {.goal = goal})->report.kept, 100);
    EXPECT_EQ(MeshFile::open(sharp.bytes)->decode(4)->creases.size(), 4U);
}

/// Moves commute with rotations, translations and scaling; what is not moved stays.
TEST(MeshFile, MovesTurnDetails) {
    for (const Case& c : cases(0.01)) {
        const auto encoded = *encode_mesh(c.mesh, {.goal = {Kind::MaxError, 1e-4}});
        const MeshFile file = *MeshFile::open(encoded.bytes);
        const int level = file.levels();
        const PolygonMesh base = *file.decode(level);
        const PolygonMesh fine = *file.decode(0);
        const auto moved = [](const std::array<double, 3>& p) {
            return std::array<double, 3>{2 * (-p[1]) + 1, 2 * p[0] - 3, 2 * p[2] + 0.5};
        };
        std::vector<MeshMove> moves;
        for (std::size_t v = 0; v < base.vertices.size(); ++v) {
            const auto to = moved(base.vertices[v]);
            moves.push_back({level,
                             v,
                             {to[0] - base.vertices[v][0], to[1] - base.vertices[v][1],
                              to[2] - base.vertices[v][2]}});
        }
        const Bytes edited = *add_mesh_moves(encoded.bytes, moves);
        const MeshFile opened = *MeshFile::open(edited);
        EXPECT_TRUE(opened.edited());
        EXPECT_FALSE(opened.bound(0).has_value());
        const PolygonMesh result = *opened.decode(0);
        PolygonMesh expected = fine;
        for (auto& v : expected.vertices) v = moved(v);
        EXPECT_LT(distances(result, expected).max, 1e-10) << c.name;
        // One vertex of the finest level.
        const Bytes one = *add_mesh_moves(encoded.bytes, {{0, 5, {1, 2, 3}}});
        PolygonMesh single = fine;
        for (std::size_t k = 0; k < 3; ++k) single.vertices[5][k] += 1.0 + double(k);
        EXPECT_LT(distances(*MeshFile::open(one)->decode(0), single).max, 1e-12) << c.name;
        EXPECT_FALSE(add_mesh_moves(encoded.bytes, {{0, 1 << 30, {}}}).ok());
        EXPECT_FALSE(add_mesh_moves(encoded.bytes, {{level + 1, 0, {}}}).ok());
        EXPECT_FALSE(add_mesh_moves(encoded.bytes, {{0, 0, {NAN, 0, 0}}}).ok());
    }
}

/// A hundred changes of level leave the bytes as they are: coarser levels are but read, and the
/// finest one gives the same file again.
TEST(MeshFile, LevelChangesLeaveTheBytes) {
    const auto all = cases(0.01);
    for (const Case& c : {all[1], all[3], all[6]}) {
        const Bytes first = encode_mesh(c.mesh, {})->bytes;
        Bytes bytes = first;
        for (int change = 0; change < 100; ++change) {
            const MeshFile file = *MeshFile::open(bytes);
            const int level = change % (file.levels() + 1);
            const PolygonMesh mesh = *file.decode(level);
            if (level == 0) bytes = encode_mesh(mesh, {})->bytes;
        }
        EXPECT_EQ(bytes, first) << c.name;
    }
}

TEST(MeshFile, Refusals) {
    PolygonMesh mesh = subdivided(test::icosahedron(), MeshScheme::Loop, 1, 0);
    const auto error_of = [](const PolygonMesh& some, const MeshEncodeOptions& options) {
        const auto encoded = encode_mesh(some, options);
        return encoded.ok() ? std::string() : encoded.error().text();
    };
    PolygonMesh plain;
    for (const auto& p : test::icosahedron().points) plain.vertices.push_back(p);
    const Shape spoiled = test::flipped(test::icosahedron(), 9, 2);
    plain.offsets = spoiled.faces.offsets;
    plain.corners.assign(spoiled.faces.corners.begin(), spoiled.faces.corners.end());
    EXPECT_NE(error_of(plain, {}).find("no_subdivision_connectivity"), std::string::npos);
    EXPECT_NE(error_of(mesh, {.goal = {Kind::MaxError, -1}}).find("not negative"),
              std::string::npos);
    EXPECT_NE(error_of(mesh, {.scheme = MeshScheme::CatmullClark}).find("not_quads"),
              std::string::npos);
    mesh.vertices[3][1] = NAN;
    EXPECT_NE(error_of(mesh, {}).find("non_finite"), std::string::npos);
    mesh.vertices[3][1] = 0;
    mesh.corners[4] = 9999;
    EXPECT_NE(error_of(mesh, {}).find("index_out_of_range"), std::string::npos);
}

/// Coordinates from denormals to the largest doubles.
TEST(MeshFile, ExtremeCoordinates) {
    for (const double scale : {1e-310, 1e-160, 1e140, 1e300}) {
        PolygonMesh mesh = subdivided(test::icosahedron(), MeshScheme::Loop, 2, 0.01);
        for (auto& v : mesh.vertices)
            for (double& x : v) x *= scale;
        const auto encoded = encode_mesh(mesh, {});
        if (!encoded.ok()) {
            EXPECT_NE(encoded.error().message.size(), 0U);
            continue;
        }
        EXPECT_EQ(*MeshFile::open(encoded->bytes)->decode(0), mesh) << scale;
    }
}

/// Random edits of files, and of their chunks with checksums that hold.
TEST(MeshFile, HostileBytes) {
    std::mt19937 random(7);
    const auto noise = [&](std::size_t size) {
        Bytes bytes(size);
        for (auto& byte : bytes) byte = static_cast<std::uint8_t>(random());
        return bytes;
    };
    for (const Bytes& bytes : fuzz::valid_mesh_files()) {
        fuzz::meshes(bytes);
        for (int k = 0; k < 60; ++k) {
            Bytes altered = bytes;
            for (unsigned edits = 0; edits <= random() % 3; ++edits)
                altered[random() % altered.size()] = static_cast<std::uint8_t>(random());
            if (random() % 4 == 0) altered.resize(random() % altered.size());
            fuzz::meshes(altered);
        }
    }
    for (int k = 0; k < 300; ++k) fuzz::mesh_chunks(noise(1 + random() % 24));
    for (const Bytes& file : fuzz::valid_mesh_files()) {
        std::string header = ContainerReader::open(file)->header();
        for (int k = 0; k < 10; ++k) {
            std::string altered = header;
            altered[random() % altered.size()] = static_cast<char>('0' + random() % 10);
            fuzz::mesh_header(
                {reinterpret_cast<const std::uint8_t*>(altered.data()), altered.size()});
        }
    }
}

}  // namespace
}  // namespace relief::codec
