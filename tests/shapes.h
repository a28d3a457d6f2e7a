#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <numeric>
#include <random>
#include <set>
#include <utility>
#include <vector>

#include "relief/mesh/topology.h"

/// Small meshes of all kinds for tests.
namespace relief::test {

using Point = std::array<double, 3>;

struct Shape {
    mesh::FaceList faces;
    std::vector<Point> points;

    [[nodiscard]] mesh::Index size() const { return static_cast<mesh::Index>(points.size()); }
    [[nodiscard]] mesh::Topology topology() const {
        auto built = mesh::build(faces, size());
        if (!built.ok()) throw std::runtime_error(built.error().text());
        return *std::move(built);
    }
    void add(std::initializer_list<mesh::Index> face) { faces.add(std::vector<mesh::Index>(face)); }
};

inline Shape tetrahedron() {
    Shape shape{{}, {{1, 1, 1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}}};
    for (const auto& f : {std::array<mesh::Index, 3>{0, 1, 2}, {0, 2, 3}, {0, 3, 1}, {1, 3, 2}})
        shape.faces.add(f);
    return shape;
}

inline Shape octahedron() {
    Shape shape{{}, {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}}};
    for (const mesh::Index z : {4U, 5U})
        for (const auto& [x, y] : {std::pair{0U, 2U}, {2U, 1U}, {1U, 3U}, {3U, 0U}})
            z == 4 ? shape.add({x, y, z}) : shape.add({y, x, z});
    return shape;
}

inline Shape icosahedron() {
    const double t = (1 + std::sqrt(5.0)) / 2;
    Shape shape{{},
                {{-1, t, 0},
                 {1, t, 0},
                 {-1, -t, 0},
                 {1, -t, 0},
                 {0, -1, t},
                 {0, 1, t},
                 {0, -1, -t},
                 {0, 1, -t},
                 {t, 0, -1},
                 {t, 0, 1},
                 {-t, 0, -1},
                 {-t, 0, 1}}};
    for (const auto& f : {std::array<mesh::Index, 3>{0, 11, 5},
                          {0, 5, 1},
                          {0, 1, 7},
                          {0, 7, 10},
                          {0, 10, 11},
                          {1, 5, 9},
                          {5, 11, 4},
                          {11, 10, 2},
                          {10, 7, 6},
                          {7, 1, 8},
                          {3, 9, 4},
                          {3, 4, 2},
                          {3, 2, 6},
                          {3, 6, 8},
                          {3, 8, 9},
                          {4, 9, 5},
                          {2, 4, 11},
                          {6, 2, 10},
                          {8, 6, 7},
                          {9, 8, 1}})
        shape.faces.add(f);
    return shape;
}

/// A bumpy grid of cols x rows cells over the plane; as a torus if `periodic`.
inline Shape grid(mesh::Index cols, mesh::Index rows, bool triangles, bool periodic = false) {
    Shape shape;
    const mesh::Index width = periodic ? cols : cols + 1;
    const mesh::Index height = periodic ? rows : rows + 1;
    for (mesh::Index r = 0; r < height; ++r)
        for (mesh::Index c = 0; c < width; ++c) {
            const double u = 2 * M_PI * c / cols;
            const double v = 2 * M_PI * r / rows;
            const double bump = 0.2 * std::sin(3 * u + 1) * std::cos(2 * v);
            if (periodic)
                shape.points.push_back({(3 + std::cos(v) + bump) * std::cos(u),
                                        (3 + std::cos(v) + bump) * std::sin(u),
                                        std::sin(v) + bump});
            else
                shape.points.push_back({double(c), double(r), bump});
        }
    for (mesh::Index r = 0; r < rows; ++r)
        for (mesh::Index c = 0; c < cols; ++c) {
            const auto at = [&](mesh::Index i, mesh::Index j) {
                return (i % height) * width + j % width;
            };
            const mesh::Index v0 = at(r, c);
            const mesh::Index v1 = at(r, c + 1);
            const mesh::Index v2 = at(r + 1, c + 1);
            const mesh::Index v3 = at(r + 1, c);
            if (triangles) {
                shape.add({v0, v1, v2});
                shape.add({v0, v2, v3});
            } else {
                shape.add({v0, v1, v2, v3});
            }
        }
    return shape;
}

using Cell = std::array<int, 3>;

/// The quads around some unit cubes; edges of the solid must not touch only each other.
inline Shape voxels(const std::set<Cell>& cells) {
    Shape shape;
    std::map<Cell, mesh::Index> numbers;
    const auto vertex = [&](Cell p) {
        const auto [found, is_new] = numbers.emplace(p, shape.size());
        if (is_new) shape.points.push_back({double(p[0]), double(p[1]), double(p[2])});
        return found->second;
    };
    for (const Cell& cell : cells)
        for (std::size_t axis = 0; axis < 3; ++axis)
            for (const int side : {0, 1}) {
                Cell other = cell;
                other[axis] += side ? 1 : -1;
                if (cells.count(other)) continue;
                std::array<mesh::Index, 4> quad{};
                for (std::size_t k = 0; k < 4; ++k) {
                    Cell corner = cell;
                    corner[axis] += side;
                    corner[(axis + 1) % 3] += k == 1 || k == 2;
                    corner[(axis + 2) % 3] += k >= 2;
                    quad[side ? k : 3 - k] = vertex(corner);
                }
                shape.faces.add(quad);
            }
    return shape;
}

inline Shape cube() {
    Shape shape = voxels({{0, 0, 0}});
    for (Point& p : shape.points)
        for (double& x : p) x = 2 * x - 1;
    return shape;
}

/// Genus 2: a slab with two holes.
inline Shape double_torus() {
    std::set<Cell> cells;
    for (int x = 0; x < 5; ++x)
        for (int y = 0; y < 3; ++y)
            if (y != 1 || (x != 1 && x != 3)) cells.insert({x, y, 0});
    return voxels(cells);
}

inline Shape triangulated(const Shape& shape) {
    Shape result{{}, shape.points};
    for (std::size_t f = 0; f < shape.faces.size(); ++f) {
        const auto face = shape.faces[f];
        for (std::size_t k = 1; k + 1 < face.size(); ++k)
            result.add({face[0], face[k], face[k + 1]});
    }
    return result;
}

/// Random edge flips that keep triangles manifold: valences from 3 on.
inline Shape flipped(const Shape& shape, int flips, unsigned seed) {
    Shape result = shape;
    std::mt19937 random(seed);
    for (int k = 0; k < flips; ++k) {
        const mesh::Topology mesh = result.topology();
        const mesh::Index h = random() % mesh.half_edge_count();
        const mesh::Index twin = mesh.twin[h];
        if (twin == mesh::kNone) continue;
        const auto valences = mesh::valences(mesh);
        const mesh::Index a = mesh.origin[h];
        const mesh::Index b = mesh.target(h);
        const mesh::Index l = mesh.origin[mesh.prev(h)];
        const mesh::Index r = mesh.origin[mesh.prev(twin)];
        bool joined = l == r || valences[a] <= 3 || valences[b] <= 3;
        for (mesh::Index g = 0; g < mesh.half_edge_count(); ++g)
            joined = joined || (mesh.origin[g] == l && mesh.target(g) == r) ||
                     (mesh.origin[g] == r && mesh.target(g) == l);
        if (joined) continue;
        Shape next{{}, result.points};
        for (std::size_t f = 0; f < result.faces.size(); ++f)
            if (f == h / 3)
                next.add({l, a, r});
            else if (f == twin / 3)
                next.add({l, r, b});
            else
                next.faces.add(result.faces[f]);
        result = next;
    }
    return result;
}

/// The same with vertices, faces and first corners in another order. numbers[v]: the new number.
inline Shape shuffled(const Shape& shape, unsigned seed,
                      std::vector<mesh::Index>* numbers = nullptr) {
    std::mt19937 random(seed);
    std::vector<mesh::Index> number(shape.points.size());
    std::iota(number.begin(), number.end(), mesh::Index{0});
    std::shuffle(number.begin(), number.end(), random);
    std::vector<std::size_t> order(shape.faces.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::shuffle(order.begin(), order.end(), random);
    Shape result;
    result.points.resize(shape.points.size());
    for (std::size_t v = 0; v < number.size(); ++v) result.points[number[v]] = shape.points[v];
    for (const std::size_t f : order) {
        std::vector<mesh::Index> face;
        for (const mesh::Index v : shape.faces[f]) face.push_back(number[v]);
        std::rotate(face.begin(), face.begin() + static_cast<long>(random() % face.size()),
                    face.end());
        result.faces.add(face);
    }
    if (numbers) *numbers = number;
    return result;
}

/// Side by side.
inline Shape both(const Shape& a, const Shape& b) {
    Shape result = a;
    for (const Point& p : b.points) result.points.push_back({p[0] + 20, p[1], p[2]});
    for (std::size_t f = 0; f < b.faces.size(); ++f) {
        std::vector<mesh::Index> face;
        for (const mesh::Index v : b.faces[f]) face.push_back(v + a.size());
        result.faces.add(face);
    }
    return result;
}

/// Without some faces, which leaves holes; vertices must stay used.
inline Shape without_faces(const Shape& shape, const std::set<std::size_t>& faces) {
    Shape result{{}, shape.points};
    for (std::size_t f = 0; f < shape.faces.size(); ++f)
        if (!faces.count(f)) result.faces.add(shape.faces[f]);
    return result;
}

}  // namespace relief::test
