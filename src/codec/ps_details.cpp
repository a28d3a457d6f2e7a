#include "codec/ps_details.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "codec/ps_plane_sums.h"
#include "codec/ps_surroundings.h"

namespace relief::codec {

using mesh::Index;
using mesh::kNone;
using mesh::Triangulation;
using multires::ps::Heights;
using multires::ps::Space;

namespace {

constexpr double kLargestHeight = 1e150;
constexpr double kLargestQuotient = 0x1p62;
/// Gradients are held near those around by so much.
constexpr double kTrust = 0.25;
/// Kinds of numbers, for contexts: corners of control triangles of the base, and of vertices in
/// triangles and on edges.
constexpr std::uint32_t kBaseKind = 0;
constexpr std::uint32_t kCentreKind = 3;
constexpr std::uint32_t kEdgeKind = 6;

/// The area of the triangles at each vertex.
std::vector<double> ring_areas(const Triangulation& mesh) {
    std::vector<double> areas(mesh.x.size());
    for (Index t = 0; t < mesh.triangle_count(); ++t) {
        const TriangleCorners c = mesh.corners(t);
        const double area = 0.5 * orient(c[0], c[1], c[2]);
        for (const Index v : mesh.triangles[t]) areas[v] += area;
    }
    return areas;
}

std::int64_t quotient(double height, double step, double rounding) {
    const double q = std::min(std::floor(std::abs(height) / step + rounding), kLargestQuotient);
    return static_cast<std::int64_t>(height < 0 ? -q : q);
}

/// The tangent plane at a vertex from those known around: on a quadratic, value + gradient . d / 2
/// of each is the value sought - its gradient . d / 2, d leading from the one to the other.
spline::TangentPlane expected_plane(const Triangulation& mesh, Index v,
                                    std::span<const Index> around,
                                    std::span<const spline::TangentPlane> planes) {
    PlaneSums sums;
    Vec2 gradient;
    for (const Index u : around) {
        const Vec2 half = 0.5 * (mesh.vertex(u) - mesh.vertex(v));
        sums.add(half, planes[u].value - dot(planes[u].gradient, half));
        gradient = gradient + planes[u].gradient;
    }
    return sums.plane((1 / sums.count) * gradient, kTrust);
}

}  // namespace

PsLevels::PsLevels(const multires::ps::Hierarchy& hierarchy, std::uint64_t finest_vertices,
                   const PsQuantisation& quantisation)
    : hierarchy_(hierarchy), quantisation_(quantisation) {
    double all = 0;
    for (const double area : ring_areas(hierarchy.space(0).mesh)) all += area;
    mean_area_ = all / static_cast<double>(finest_vertices);
}

std::vector<double> PsLevels::steps_of(const Triangulation& mesh) const {
    std::vector<double> steps(mesh.x.size(), quantisation_.step);
    if (quantisation_.law == StepLaw::Flat) return steps;
    const std::vector<double> areas = ring_areas(mesh);
    for (std::size_t v = 0; v < steps.size(); ++v) {
        const double norm = std::sqrt(mean_area_ / areas[v]);
        steps[v] *= quantisation_.law == StepLaw::Norm ? norm : std::sqrt(norm);
    }
    return steps;
}

template <class Coder>
bool PsLevels::code_triple(Coder& coder, std::size_t component, std::size_t place,
                           std::uint32_t kind, double rounding, double step, Heights& heights,
                           const Heights& expected, std::span<const std::size_t> beside,
                           std::span<const std::size_t> below) {
    const Triples& numbers = numbers_[component];
    Surrounding near;
    for (const std::size_t other : beside)
        for (const std::int64_t q : numbers[other]) near.add(q);
    Surrounding far;
    for (const std::size_t other : below)
        for (const std::int64_t q : before_[component][other]) far.add(q);
    for (std::size_t c = 0; c < component; ++c)
        for (const std::int64_t q : numbers_[c][place]) far.add(q);
    bool good = true;
    for (std::size_t j = 0; j < 3; ++j) {
        std::int64_t& q = numbers_[component][place][j];
        if (!Coder::kDecodes) q = quotient(heights[j] - expected[j], step, rounding);
        q = NumberCoder<Coder>(coder, model_)
                .code(q, kind + static_cast<std::uint32_t>(j), near, far);
        near.add(q);
        heights[j] = expected[j] + static_cast<double>(q) * step;
        good = good && std::abs(heights[j]) <= kLargestHeight;
        kept_ += kind == kBaseKind || q != 0 ? 1 : 0;
    }
    return good;
}

template <class Coder>
bool PsLevels::code_base(Coder& coder, LevelHeights& heights, double rounding) {
    const Space& space = hierarchy_.space(0);
    const std::vector<double> steps = steps_of(space.mesh);
    std::vector<multires::ps::TangentPlanes> planes(
        heights.size(), multires::ps::TangentPlanes(space.mesh.x.size()));
    std::vector<std::size_t> beside;
    Index last = 0;
    PsSurroundings surroundings(space.mesh);
    return surroundings.each([&](Index v, std::span<const Index> around) {
        beside.assign(around.begin(), around.end());
        for (std::size_t c = 0; c < heights.size(); ++c) {
            const auto plane =
                around.empty() ? planes[c][last] : expected_plane(space.mesh, v, around, planes[c]);
            const TriangleCorners& control = space.control[v];
            if (!code_triple(coder, c, v, kBaseKind, rounding, steps[v], heights[c][v],
                             multires::ps::heights(control, plane), beside, {}))
                return false;
            planes[c][v] = multires::ps::tangent_plane(control, heights[c][v]);
        }
        last = v;
        return true;
    });
}

template <class Coder>
bool PsLevels::code_details(Coder& coder, LevelHeights& heights, double rounding) {
    const Triangulation& coarse = hierarchy_.space(next_ - 1).mesh;
    const std::vector<double> steps = steps_of(hierarchy_.space(next_).mesh);
    const std::size_t old = coarse.x.size();
    // Details of the level below belong to its vertices from here on.
    const std::size_t first_below = next_ > 1 ? hierarchy_.space(next_ - 2).mesh.x.size() : 0;
    std::vector<std::size_t> beside;
    std::vector<std::size_t> below;
    const auto add_below = [&](Index v) {
        if (v >= first_below) below.push_back(v - first_below);
    };
    const auto code = [&](std::size_t place, std::uint32_t kind) {
        bool good = true;
        for (std::size_t c = 0; c < heights.size(); ++c)
            good = code_triple(coder, c, place, kind, rounding, steps[old + place],
                               heights[c][place], {}, beside, below) &&
                   good;
        return good;
    };
    for (Index t = 0; t < coarse.triangle_count(); ++t) {
        beside.clear();
        below.clear();
        for (Index k = 0; k < 3; ++k) {
            const Index other = coarse.neighbour(t, k);
            if (other < t) beside.push_back(other);
            add_below(coarse.triangles[t][k]);
        }
        if (!code(t, kCentreKind)) return false;
    }
    const std::size_t triangles = coarse.triangles.size();
    for (Index e = 0; e < coarse.edge_count(); ++e) {
        beside.clear();
        for (const Index t : coarse.edge_triangles[e]) {
            if (t == kNone) continue;
            beside.push_back(t);
            for (const Index other : coarse.triangle_edges[t])
                if (other < e)
                    for (const std::size_t end : {0U, 1U})
                        beside.push_back(triangles + 2 * std::size_t{other} + end);
        }
        for (const std::size_t end : {0U, 1U}) {
            const std::size_t place = triangles + 2 * std::size_t{e} + end;
            below.clear();
            add_below(coarse.edges[e][end]);
            if (!code(place, kEdgeKind)) return false;
            beside.push_back(place);
        }
    }
    return true;
}

template <class Coder>
bool PsLevels::code_next(Coder& coder, LevelHeights& heights, double rounding) {
    before_ = std::move(numbers_);
    numbers_.assign(heights.size(), Triples(heights.front().size()));
    const bool good =
        next_ == 0 ? code_base(coder, heights, rounding) : code_details(coder, heights, rounding);
    ++next_;
    return good;
}

Bytes PsLevels::encode_next(LevelHeights& heights, double rounding) {
    RangeEncoder encoder;
    code_next(encoder, heights, rounding);
    return encoder.finish();
}

Status PsLevels::decode_next(std::span<const std::uint8_t> bytes, LevelHeights& heights) {
    RangeDecoder decoder(bytes);
    const int level = next_;
    if (code_next(decoder, heights, 0) && decoder.at_end()) return {};
    return Error{ErrorCode::BadFile, "the coefficients of a level are damaged",
                 "level " + std::to_string(level) + " of the refinement"};
}

namespace {

/// One text for encoder and decoder.
template <class Coder>
bool code_exact(Coder& coder, const LevelHeights* exact, std::span<const ValueLattice> lattices,
                LevelHeights& heights) {
    NumberModel model;
    NumberCoder<Coder> numbers(coder, model);
    bool good = true;
    for (std::size_t c = 0; c < heights.size(); ++c) {
        const ValueLattice& lattice = lattices[c];
        Surrounding before;
        for (std::size_t v = 0; v < heights[c].size(); ++v) {
            Surrounding triple;
            for (std::size_t j = 0; j < 3; ++j) {
                double& height = heights[c][v][j];
                const auto near = static_cast<std::uint64_t>(lattice.nearest(height));
                const auto target =
                    exact ? static_cast<std::uint64_t>(lattice.nearest((*exact)[c][v][j])) : near;
                const std::int64_t q = numbers.code(static_cast<std::int64_t>(target - near),
                                                    static_cast<std::uint32_t>(j), triple, before);
                triple.add(q);
                height =
                    lattice.value(static_cast<std::int64_t>(near + static_cast<std::uint64_t>(q)));
                good = good && std::abs(height) <= kLargestHeight;
            }
            before = triple;
        }
    }
    return good;
}

}  // namespace

Bytes write_exact_heights(const LevelHeights& decoded, const LevelHeights& exact,
                          std::span<const ValueLattice> lattices) {
    LevelHeights heights = decoded;
    RangeEncoder encoder;
    code_exact(encoder, &exact, lattices, heights);
    return encoder.finish();
}

Status read_exact_heights(std::span<const std::uint8_t> bytes,
                          std::span<const ValueLattice> lattices, LevelHeights& heights) {
    RangeDecoder decoder(bytes);
    if (code_exact(decoder, nullptr, lattices, heights) && decoder.at_end()) return {};
    return Error{ErrorCode::BadFile, "the corrections of its coefficients are damaged",
                 "correction chunk"};
}

}  // namespace relief::codec
