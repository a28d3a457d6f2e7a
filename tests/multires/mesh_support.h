#pragma once

#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

#include "relief/multires/mesh_step.h"
#include "shapes.h"
#include "support.h"

/// Steps of subdivision over small meshes of all kinds, and those of the reference vectors.
namespace relief::test {

using mesh::FaceList;
using mesh::Index;
using mesh::Split;
using mesh::Topology;
using multires::MeshStep;
using multires::MeshTags;
using multires::step_rules;
using multires::StepOptions;
using multires::StepRules;
using Points = std::vector<Vec3<double>>;

inline Points points_of(const nlohmann::json& json) {
    Points points;
    for (const auto& p : json) points.push_back({p[0], p[1], p[2]});
    return points;
}

inline Points points_of(const test::Shape& shape) {
    Points points;
    for (const auto& p : shape.points) points.push_back({p[0], p[1], p[2]});
    return points;
}

inline double distance(const Points& a, const Points& b) {
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

inline Level level_of(const nlohmann::json& record) {
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

inline Points noisy(Points points, unsigned seed, double size) {
    test::Noise noise(seed);
    for (auto& p : points) p += size * Vec3<double>{noise(), noise(), noise()};
    return points;
}

/// Random sharp edges and corners.
inline MeshTags some_tags(const Topology& mesh, unsigned seed) {
    std::mt19937 random(seed);
    MeshTags tags;
    tags.sharp.assign(mesh.edge_count, 0);
    for (Index h = 0; h < mesh.half_edge_count(); ++h)
        if (!mesh.on_boundary(h) && random() % 5 == 0) tags.sharp[mesh.edge[h]] = 1;
    tags.corner.assign(mesh.vertex_count, 0);
    tags.corner[random() % mesh.vertex_count] = 1;
    return tags;
}

inline std::vector<std::pair<std::string, Level>> all_levels() {
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

}  // namespace relief::test
