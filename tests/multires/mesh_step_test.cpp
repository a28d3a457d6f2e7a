#include "relief/multires/mesh_step.h"

#include <gtest/gtest.h>

#include <memory>

#include "shapes.h"
#include "support.h"

namespace relief::multires {
namespace {

using mesh::FaceList;
using mesh::Index;
using mesh::Split;
using mesh::Topology;
using Points = std::vector<Vec3<double>>;

Points points_of(const nlohmann::json& json) {
    Points points;
    for (const auto& p : json) points.push_back({p[0], p[1], p[2]});
    return points;
}

Points points_of(const test::Shape& shape) {
    Points points;
    for (const auto& p : shape.points) points.push_back({p[0], p[1], p[2]});
    return points;
}

double distance(const Points& a, const Points& b) {
    EXPECT_EQ(a.size(), b.size());
    double largest = 0;
    for (std::size_t k = 0; k < std::min(a.size(), b.size()); ++k)
        largest = std::max(largest, length(a[k] - b[k]));
    return largest;
}

/// A step with its data.
struct Level {
    Topology coarse;
    MeshTags tags;
    StepRules rules;

    Level(Topology mesh, MeshTags its_tags, Split split, const StepOptions& options = {})
        : coarse(std::move(mesh)), tags(std::move(its_tags)) {
        auto made = step_rules(coarse, tags, split, options);
        if (!made.ok()) throw std::runtime_error(made.error().text());
        rules = *std::move(made);
    }

    [[nodiscard]] MeshStep<double> step() const { return {coarse, rules}; }

    [[nodiscard]] Points subdivided(const Points& c) const {
        Points fine(c.size() + rules.new_count);
        step().apply(c.data(), fine.data(), fine.data() + c.size());
        return fine;
    }
    /// Coarse vertices and details; residuals of stiff vertices.
    [[nodiscard]] std::pair<Points, Points> analysed(Points fine) const {
        Points scratch(fine.size());
        Points residuals(rules.stiff.size());
        step().analyse(fine.data(), residuals.data(), scratch.data());
        return {fine, residuals};
    }
    [[nodiscard]] Points synthesised(Points fine, const Points& residuals) const {
        Points scratch(fine.size());
        step().synthesise(fine.data(), residuals.data(), scratch.data());
        return fine;
    }
};

Level level_of(const nlohmann::json& record) {
    FaceList faces;
    for (const auto& face : record["coarse_faces"]) faces.add(face.get<std::vector<Index>>());
    Topology coarse = *mesh::build(faces, static_cast<Index>(record["coarse"].size()));
    MeshTags tags;
    tags.sharp.assign(coarse.edge_count, 0);
    for (const auto& ends : record["sharp"])
        for (Index h = 0; h < coarse.half_edge_count(); ++h) {
            const Index a = coarse.origin[h];
            const Index b = coarse.target(h);
            if (std::min(a, b) == ends[0].get<Index>() && std::max(a, b) == ends[1].get<Index>())
                tags.sharp[coarse.edge[h]] = !coarse.on_boundary(h);
        }
    tags.corner.assign(coarse.vertex_count, 0);
    for (const auto& v : record["corners"]) tags.corner[v.get<Index>()] = 1;
    const std::string scheme = record["scheme"];
    const Split split = scheme == "loop"      ? Split::Loop
                        : scheme == "cc"      ? Split::CatmullClark
                        : record["mode"] == 2 ? Split::Sqrt3Even
                                              : Split::Sqrt3Odd;
    return {std::move(coarse), std::move(tags), split};
}

Points noisy(Points points, unsigned seed, double size) {
    test::Noise noise(seed);
    for (auto& p : points) p += size * Vec3<double>{noise(), noise(), noise()};
    return points;
}

TEST(SubdivisionRules, ReferenceTables) {
    const auto tables = test::reference("reverse_subdivision.json")["tables"];
    constexpr double close = 1e-14;  // the tables' digits
    for (const auto& row : tables["sqrt3"]) {
        const Index n = row[0];
        const auto rule = rules::sqrt3_smooth(n, rules::sqrt3_alpha(n));
        EXPECT_NEAR(rules::sqrt3_alpha(n), row[1].get<double>(), close);
        EXPECT_NEAR(rule.self, row[2].get<double>(), close);
        EXPECT_NEAR(rule.face, row[3].get<double>(), close);
    }
    for (const auto& row : tables["loop"]) {
        const Index n = row[0];
        EXPECT_NEAR(rules::loop_alpha(n), row[1].get<double>(), close);
        EXPECT_NEAR(rules::loop_smooth(n).self, row[2].get<double>(), close);
        EXPECT_NEAR(rules::loop_smooth(n).edge, row[3].get<double>(), close);
    }
    for (const auto& row : tables["cc"]) {
        const auto rule = rules::catmull_clark_smooth(row[0]);
        EXPECT_NEAR(rule.self, row[1].get<double>(), close);
        EXPECT_NEAR(rule.edge, row[2].get<double>(), close);
        EXPECT_NEAR(rule.face, row[3].get<double>(), close);
    }
}

/// D + (all of K) = 1: constants stay.
TEST(SubdivisionRules, WeightsAddUp) {
    for (Index n = 2; n < 40; ++n) {
        const auto loop = rules::loop_smooth(n);
        EXPECT_NEAR(loop.self + n * loop.edge, 1, 1e-14) << n;
        const auto quad = rules::catmull_clark_smooth(n);
        EXPECT_NEAR(quad.self + n * (quad.edge + quad.face), 1, 1e-14) << n;
        const auto dart = rules::loop_dart(n);
        double sum = dart.self;
        for (const double w : dart.edges) sum += w;
        EXPECT_NEAR(sum, 1, 1e-14) << n;
        if (n < 3) continue;
        const auto sqrt3 = rules::sqrt3_smooth(n, rules::sqrt3_alpha(n));
        EXPECT_NEAR(sqrt3.self + n * sqrt3.face, 1, 1e-14) << n;
    }
}

TEST(MeshStep, ReferenceVectors) {
    const auto golden = test::reference("reverse_subdivision.json");
    const double close = golden["tolerances"]["plain"];
    for (const auto& record : golden["decompositions"]) {
        const Level level = level_of(record);
        const Points coarse = points_of(record["coarse"]);
        EXPECT_LT(distance(level.subdivided(coarse), points_of(record["fine"])), close)
            << record["name"];
        const Points g = points_of(record["g"]);
        const auto [fine, residuals] = level.analysed(g);
        // Stiff vertices: the record has them apart, packed ones are tested with the packing.
        const bool stiff = record.contains("explicit");
        const auto& expected = stiff ? record["explicit"] : record["plain"];
        Points c(fine.begin(), fine.begin() + static_cast<long>(coarse.size()));
        Points d(fine.begin() + static_cast<long>(coarse.size()), fine.end());
        const auto& expected_c = expected.contains("c") ? expected["c"] : record["plain"]["c"];
        EXPECT_LT(distance(c, points_of(expected_c)), 10 * close) << record["name"];
        EXPECT_LT(distance(d, points_of(expected["d"])), 10 * close) << record["name"];
        if (stiff) {
            EXPECT_EQ(level.rules.stiff.vertices, expected["v3"].get<std::vector<Index>>());
            EXPECT_LT(distance(residuals, points_of(expected["r"])), 10 * close);
        }
        EXPECT_LT(distance(level.synthesised(fine, residuals), g), 1e-13) << record["name"];
    }
}

/// Rules by hand, section 14.
TEST(MeshStep, HandValues) {
    const Level cube(test::cube().topology(), {}, Split::CatmullClark);
    const Points quads = cube.subdivided(points_of(test::cube()));
    for (std::size_t v = 0; v < 8; ++v) EXPECT_NEAR(std::abs(quads[v].x), 5.0 / 9, 1e-15);
    for (std::size_t v = 8; v < 20; ++v)
        EXPECT_NEAR(length(quads[v]), std::sqrt(2 * 0.75 * 0.75), 1e-15);
    const Level loop(test::octahedron().topology(), {}, Split::Loop);
    const Points triangles = loop.subdivided(points_of(test::octahedron()));
    EXPECT_NEAR(triangles[0].x, 0.515625, 1e-15);
    EXPECT_NEAR(length(triangles[6]), std::sqrt(2.0) * 3 / 8, 1e-15);
    const Level sqrt3(test::octahedron().topology(), {}, Split::Sqrt3Odd);
    const Points kites = sqrt3.subdivided(points_of(test::octahedron()));
    EXPECT_NEAR(kites[0].x, 5.0 / 9, 1e-15);
    EXPECT_NEAR(std::abs(kites[6].y), 1.0 / 3, 1e-15);
}

/// Random sharp edges and corners.
MeshTags some_tags(const Topology& mesh, unsigned seed) {
    std::mt19937 random(seed);
    MeshTags tags;
    tags.sharp.assign(mesh.edge_count, 0);
    for (Index h = 0; h < mesh.half_edge_count(); ++h)
        if (!mesh.on_boundary(h) && random() % 5 == 0) tags.sharp[mesh.edge[h]] = 1;
    tags.corner.assign(mesh.vertex_count, 0);
    tags.corner[random() % mesh.vertex_count] = 1;
    return tags;
}

std::vector<std::pair<std::string, Level>> all_levels() {
    std::vector<std::pair<std::string, Level>> levels;
    const auto add = [&](const std::string& name, const test::Shape& shape, Split split,
                         bool tagged) {
        Topology mesh = shape.topology();
        MeshTags tags = tagged ? some_tags(mesh, 7) : MeshTags();
        if (split == Split::Sqrt3Even) {
            Topology odd = *mesh::refine(mesh, Split::Sqrt3Odd);
            tags = refined(tags, mesh, odd, Split::Sqrt3Odd);
            mesh = std::move(odd);
        }
        levels.emplace_back(name, Level(std::move(mesh), std::move(tags), split));
    };
    const test::Shape holed = test::without_faces(test::grid(5, 5, true, true), {7, 8, 30});
    for (const Split split : {Split::Loop, Split::Sqrt3Odd, Split::Sqrt3Even}) {
        add("tetrahedron", test::tetrahedron(), split, false);
        add("flipped", test::flipped(test::icosahedron(), 60, 5), split, false);
        add("genus 2", test::triangulated(test::double_torus()), split, false);
        add("open", test::flipped(test::grid(4, 3, true), 20, 2), split, false);
        add("holed torus", holed, split, false);
    }
    for (const Split split : {Split::Loop, Split::CatmullClark}) {
        add("tagged", test::flipped(test::icosahedron(), 60, 5), split, true);
        add("tagged open", test::grid(5, 4, true), split, true);
    }
    add("genus 2", test::double_torus(), Split::CatmullClark, false);
    add("tagged genus 2", test::double_torus(), Split::CatmullClark, true);
    add("open quads", test::grid(4, 3, false), Split::CatmullClark, false);
    add("voxels", test::voxels({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}}), Split::CatmullClark, false);
    add("mixed", test::both(test::tetrahedron(), test::double_torus()), Split::CatmullClark, false);
    return levels;
}

/// AP = I, BP = 0.
TEST(MeshStep, SubdivisionIsUndone) {
    for (const auto& [name, level] : all_levels()) {
        Points c = noisy(Points(level.coarse.vertex_count), 3, 1);
        const auto [fine, residuals] = level.analysed(level.subdivided(c));
        const Points back(fine.begin(), fine.begin() + static_cast<long>(c.size()));
        EXPECT_LT(distance(back, c), 1e-12) << name;  // weights are at most 15
        for (std::size_t x = c.size(); x < fine.size(); ++x)
            ASSERT_LT(length(fine[x]), 1e-12) << name;
        for (const auto& r : residuals) ASSERT_LT(length(r), 1e-12) << name;
    }
}

/// PA + QB = I.
TEST(MeshStep, PerfectReconstruction) {
    for (const auto& [name, level] : all_levels()) {
        const Points g = noisy(Points(level.coarse.vertex_count + level.rules.new_count), 4, 1);
        const auto [fine, residuals] = level.analysed(g);
        EXPECT_LT(distance(level.synthesised(fine, residuals), g), 1e-13) << name;
    }
}

/// <P c, e> = <c, P^T e>, and constants stay.
TEST(MeshStep, AdjointAndConstants) {
    for (const auto& [name, level] : all_levels()) {
        const Points c = noisy(Points(level.coarse.vertex_count), 5, 1);
        Points e = noisy(Points(c.size() + level.rules.new_count), 6, 1);
        const Points fine = level.subdivided(c);
        Vec3<double> left;
        for (std::size_t k = 0; k < e.size(); ++k)
            left += {e[k].x * fine[k].x, e[k].y * fine[k].y, e[k].z * fine[k].z};
        Points image(c.size());
        level.step().adjoint(e.data(), e.data() + c.size(), image.data());
        Vec3<double> right;
        for (std::size_t k = 0; k < c.size(); ++k)
            right += {c[k].x * image[k].x, c[k].y * image[k].y, c[k].z * image[k].z};
        EXPECT_LT(length(left - right), 1e-11) << name;
        const Points ones = level.subdivided(Points(c.size(), {1, 2, 3}));
        for (const auto& p : ones) ASSERT_LT(length(p - Vec3<double>{1, 2, 3}), 1e-14) << name;
    }
}

/// Also with other weights of neighbours.
TEST(MeshStep, AlphaOfSqrt3) {
    const Level level(test::flipped(test::icosahedron(), 40, 1).topology(), {}, Split::Sqrt3Odd,
                      {.alpha = 0.125});
    EXPECT_EQ(level.rules.self[0], 1 - 1.5 * 0.125);
    const Points g = noisy(Points(level.coarse.vertex_count + level.rules.new_count), 4, 1);
    const auto [fine, residuals] = level.analysed(g);
    EXPECT_LT(distance(level.synthesised(fine, residuals), g), 1e-14);
    const Topology mesh = test::octahedron().topology();
    for (const double alpha : {-0.1, 2.0 / 3, std::nan("")}) {
        const auto rules = step_rules(mesh, {}, Split::Sqrt3Odd, {.alpha = alpha});
        ASSERT_FALSE(rules.ok());
        EXPECT_NE(rules.error().text().find("invalid_parameter"), std::string::npos);
    }
}

TEST(MeshStep, Refusals) {
    const Topology mesh = test::icosahedron().topology();
    MeshTags tags;
    tags.sharp.assign(mesh.edge_count, 0);
    tags.sharp[3] = 1;
    const auto sharp = step_rules(mesh, tags, Split::Sqrt3Odd);
    ASSERT_FALSE(sharp.ok());
    EXPECT_NE(sharp.error().text().find("invalid_parameter: sqrt(3) subdivision has no sharp"),
              std::string::npos);
    EXPECT_FALSE(step_rules(test::cube().topology(), {}, Split::Loop).ok());
    tags.sharp.pop_back();
    EXPECT_FALSE(step_rules(mesh, tags, Split::Loop).ok());
}

/// A cube and its component's alternating vector, which P loses.
TEST(MeshStep, CubicBipartiteMeshes) {
    const Level cube(test::cube().topology(), {}, Split::CatmullClark);
    ASSERT_EQ(cube.rules.stiff.alternating.size(), 1U);
    Points alternating(8);
    const auto& component = cube.rules.stiff.alternating[0];
    for (std::size_t k = 0; k < 8; ++k)
        alternating[cube.rules.stiff.vertices[component.places[k]]].x = component.signs[k];
    for (const auto& p : cube.subdivided(alternating)) EXPECT_LT(length(p), 1e-15);
    const Level tetrahedron(test::tetrahedron().topology(), {}, Split::CatmullClark);
    EXPECT_EQ(tetrahedron.rules.stiff.size(), 4U);
    EXPECT_TRUE(tetrahedron.rules.stiff.alternating.empty());
}

}  // namespace
}  // namespace relief::multires
