#include "relief/multires/subdivision_rules.h"

#include <array>
#include <string>

namespace relief::multires {

const char* mesh_scheme_name(MeshScheme scheme) {
    constexpr std::array<const char*, 3> names{"sqrt3", "loop", "catmull-clark"};
    return names[static_cast<std::size_t>(scheme)];
}

Result<MeshScheme> mesh_scheme_from_name(std::string_view name) {
    for (const MeshScheme scheme : {MeshScheme::Sqrt3, MeshScheme::Loop, MeshScheme::CatmullClark})
        if (name == mesh_scheme_name(scheme)) return scheme;
    return Error{ErrorCode::InvalidArgument,
                 "meshes have the schemes loop, sqrt3 and catmull-clark, and over the plane quads "
                 "fvs, triangles powell-sabin; not " +
                     std::string(name),
                 ""};
}

mesh::Split split_of(MeshScheme scheme, int step) {
    if (scheme == MeshScheme::Loop) return mesh::Split::Loop;
    if (scheme == MeshScheme::CatmullClark) return mesh::Split::CatmullClark;
    return step % 2 == 0 ? mesh::Split::Sqrt3Odd : mesh::Split::Sqrt3Even;
}

namespace rules {

namespace {

constexpr double kTwoPi = 6.28318530717958647692;

/// cos(2 pi / n): the same bits on every machine, which a library's cosine does not promise.
double cosine(mesh::Index n) {
    constexpr std::array<double, 7> exact{0, 1, -1, -0.5, 0, 0, 0.5};
    if (n < exact.size() && n != 5) return exact[n];
    const double square = kTwoPi / n * (kTwoPi / n);  // at most 1.6
    double sum = 1;
    for (int k = 11; k > 0; --k) sum = 1 - square / ((2 * k - 1) * (2 * k)) * sum;
    return sum;
}

}  // namespace

double sqrt3_alpha(mesh::Index n) {
    return (4 - 2 * cosine(n)) / 9;
}

double loop_alpha(mesh::Index n) {
    const double s = 3.0 / 8 + cosine(n) / 4;
    return (5.0 / 8 - s * s) / n;
}

SmoothRule sqrt3_smooth(mesh::Index n, double alpha) {
    return {1 - 1.5 * alpha, 0, 1.5 * alpha / n};
}

SmoothRule loop_smooth(mesh::Index n) {
    const double s = 3.0 / 8 + cosine(n) / 4;
    return {1.6 * s * s, 1.6 * loop_alpha(n), 0};
}

SmoothRule catmull_clark_smooth(mesh::Index n) {
    const double square = static_cast<double>(n) * n;
    return {(static_cast<double>(n) - 3) / n, 4 / square, -1 / square};
}

RingRule sqrt3_ring(mesh::Index n, double alpha) {
    return {1 - alpha, alpha / n};
}

RingRule loop_ring(mesh::Index n) {
    const double alpha = loop_alpha(n);
    return {1 - n * alpha, alpha};
}

RingRule catmull_clark_ring(mesh::Index n) {
    const double square = static_cast<double>(n) * n;
    return {(static_cast<double>(n) - 2) / n, 1 / square};
}

/// The sum over all edges of (weight of a neighbour in the new vertex of the edge) x is 1 for every
/// neighbour; the wings of the sharp edge have none, so that the other edges make a tridiagonal
/// system.
DartRule loop_dart(mesh::Index n) {
    std::vector<double> pivots(n, kLoopEdgeEnd);
    std::vector<double> x(n, 1.0);
    for (std::size_t i = 2; i < n; ++i) {
        const double factor = kLoopEdgeWing / pivots[i - 1];
        pivots[i] -= factor * kLoopEdgeWing;
        x[i] -= factor * x[i - 1];
    }
    for (std::size_t i = n - 1; i > 0; --i)
        x[i] = (x[i] - (i + 1 < n ? kLoopEdgeWing * x[i + 1] : 0)) / pivots[i];
    x[0] = (1 - kLoopEdgeWing * (x[1] + x[n - 1])) / kSharpEdgeEnd;

    const double alpha = loop_alpha(n);
    DartRule rule;
    double ends = kSharpEdgeEnd * x[0];
    for (std::size_t i = 1; i < n; ++i) ends += kLoopEdgeEnd * x[i];
    rule.self = 1 - n * alpha - alpha * ends;
    for (const double weight : x) rule.edges.push_back(alpha * weight);
    return rule;
}

}  // namespace rules

}  // namespace relief::multires
