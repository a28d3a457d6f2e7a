#include <algorithm>
#include <cmath>

#include "relief/remesh/surface.h"

namespace relief::remesh {

namespace {

using mesh::Index;
using Point = Vec3<double>;
using Weights = std::array<double, 3>;

constexpr int kMostFaces = 400;
/// What is left of a step that need not be gone, as a share of it.
constexpr double kRest = 1e-12;
/// A boundary stops a point that meets it for so many times.
constexpr int kMostSlides = 20;

/// How fast the weights of the corners change along a vector. False: the face has no area.
bool rates_of(const std::array<Point, 3>& corners, const Point& along, Weights& rates) {
    const Point e1 = corners[1] - corners[0];
    const Point e2 = corners[2] - corners[0];
    const Point normal = cross(e1, e2);
    const double square = dot(normal, normal);
    if (!(square > 0)) return false;
    rates[1] = dot(cross(along, e2), normal) / square;
    rates[2] = dot(cross(e1, along), normal) / square;
    rates[0] = -rates[1] - rates[2];
    return std::isfinite(rates[0]);
}

void normalise(Weights& weights) {
    for (double& w : weights) w = std::max(w, 0.0);
    const double sum = weights[0] + weights[1] + weights[2];
    for (double& w : weights) w /= sum;
}

}  // namespace

Place walk(const Surface& surface, const Place& from, const Point& step) {
    const mesh::Topology& mesh = surface.mesh;
    Place here = from;
    Weights& weights = here.weights;
    const Point& start = surface.face_normals[here.face];
    Point rest = step - dot(step, start) * start;
    const double enough = kRest * kRest * dot(rest, rest);
    int slides = 0;
    for (int count = 0; count < kMostFaces && dot(rest, rest) > enough; ++count) {
        const Index* corner = mesh.origin.data() + 3 * here.face;
        const std::array<Point, 3> corners = {surface.points[corner[0]], surface.points[corner[1]],
                                              surface.points[corner[2]]};
        Weights rates;
        if (!rates_of(corners, rest, rates)) break;
        double gone = 1;
        std::size_t exit = 3;  // the corner whose weight becomes 0
        for (std::size_t k = 0; k < 3; ++k)
            if (rates[k] < 0 && -weights[k] / rates[k] < gone) {
                gone = std::max(0.0, -weights[k] / rates[k]);
                exit = k;
            }
        for (std::size_t k = 0; k < 3; ++k) weights[k] += gone * rates[k];
        if (exit == 3) break;
        weights[exit] = 0;
        rest = (1 - gone) * rest;
        const std::size_t from_corner = (exit + 1) % 3;
        const std::size_t to_corner = (exit + 2) % 3;
        const Index h = 3 * here.face + static_cast<Index>(from_corner);
        const Point side = corners[to_corner] - corners[from_corner];
        const double size = length(side);
        if (!(size > 0)) break;
        const Point along = 1 / size * side;
        const double ahead = dot(rest, along);
        if (mesh.on_boundary(h)) {
            if (++slides > kMostSlides) break;
            rest = ahead * along;
            continue;
        }
        // The face across runs along the edge the other way: both perpendiculars point into it.
        const double across =
            std::max(0.0, dot(rest, cross(along, surface.face_normals[here.face])));
        const Index twin = mesh.twin[h];
        here.face = twin / 3;
        const Weights before = weights;
        weights[twin % 3] = before[to_corner];
        weights[(twin + 1) % 3] = before[from_corner];
        weights[(twin + 2) % 3] = 0;
        rest = ahead * along + across * cross(along, surface.face_normals[here.face]);
    }
    normalise(weights);
    return here;
}

}  // namespace relief::remesh
