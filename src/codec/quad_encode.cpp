#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>

#include "codec/goal_search.h"
#include "codec/quad_chunks.h"
#include "codec/quad_nodal.h"
#include "codec/quad_values.h"
#include "multires/fvs_functionals.h"

namespace relief::codec {

using mesh::Index;
using mesh::Quadrangulation;
using multires::fvs_mesh::Decomposition;
using multires::fvs_mesh::Hierarchy;
using multires::fvs_mesh::NodalData;
namespace fvs_mesh = multires::fvs_mesh;

namespace {

constexpr int kMostLevels = 30;
constexpr double kLargestValue = 1e150;
/// Further refinements of the certified bound (section 8.1).
constexpr int kCertificate = 2;
/// Where searches end.
constexpr SearchLimits kHalvings = {.trials = 30, .close_enough = HUGE_VAL, .narrow = 1.0001};
/// How much longer the numbers of the final header may be than those of a trial.
constexpr std::uint64_t kHeaderSlack = 32;

Status check_heights(const QuadMesh& mesh) {
    for (std::size_t v = 0; v < mesh.vertices.size(); ++v)
        if (!(std::abs(mesh.vertices[v][2]) <= kLargestValue))
            return fvs_mesh::bad_data(
                "non_finite_data: z is not finite or beyond 1e150; correct or remove it",
                "vertex " + std::to_string(v));
    return {};
}

/// The input as the hierarchy sees it.
struct Source {
    PlaneMesh base;
    Hierarchy hierarchy;
    Numbering numbering;
    PlaceDigits digits;
    std::vector<double> heights;
    NodalData spline;

    [[nodiscard]] const Quadrangulation& finest() const {
        return hierarchy.mesh(hierarchy.levels());
    }
};

/// The input's numbers of the vertices and quads of the finest level.
Numbering numbering_of(const QuadMesh& input, const Quadrangulation& finest,
                       std::vector<mesh::TurnedQuad> quads) {
    Numbering numbering{std::vector<Index>(finest.vertex_count()), std::move(quads), {}};
    for (std::size_t q = 0; q < finest.quads.size(); ++q) {
        const auto [number, turn] = numbering.quads[q];
        for (std::size_t i = 0; i < 4; ++i)
            numbering.vertices[finest.quads[q][i]] = input.quads[number][(i + turn) % 4];
    }
    for (const Index v : numbering.vertices)
        numbering.places.push_back({input.vertices[v][0], input.vertices[v][1]});
    return numbering;
}

Result<Source> prepare(const QuadMesh& input, int levels) {
    std::vector<Vec2> places;
    for (const auto& [x, y, z] : input.vertices) places.push_back({x, y});
    RELIEF_TRY(const Quadrangulation finest,
               mesh::build(places, input.quads, {.check_overlap = true}));
    RELIEF_CHECK(check_heights(input));
    mesh::Refinement refinement = refinement_of(finest, levels < 0 ? kMostLevels : levels);
    if (levels > refinement.levels)
        return bad_argument("the mesh is a refinement of " + std::to_string(refinement.levels) +
                            " levels, not of " + std::to_string(levels));
    PlaneMesh base{{}, std::move(refinement.quads)};
    for (const Index v : refinement.vertices) base.vertices.push_back(places[v]);
    RELIEF_TRY(Quadrangulation base_mesh, mesh::build(base.vertices, base.quads));
    RELIEF_TRY(Hierarchy hierarchy, Hierarchy::create(std::move(base_mesh), refinement.levels));
    Source source{std::move(base), std::move(hierarchy), {}, PlaceDigits::of(places), {}, {}};
    source.numbering = numbering_of(input, source.finest(), std::move(refinement.finest));
    for (const Index v : source.numbering.vertices) source.heights.push_back(input.vertices[v][2]);
    RELIEF_TRY(source.spline, fvs_mesh::interpolate_values(source.finest(), source.heights));
    return source;
}

/// Root mean square and largest difference.
struct Errors {
    double max = 0;
    double rms = 0;
};

Errors errors_between(const std::vector<double>& a, const std::vector<double>& b) {
    Errors errors;
    double sum = 0;
    for (std::size_t k = 0; k < a.size(); ++k) {
        const double difference = std::abs(a[k] - b[k]);
        errors.max = std::max(errors.max, difference);
        sum += difference * difference;
    }
    errors.rms = std::sqrt(sum / static_cast<double>(a.size()));
    return errors;
}

std::vector<std::int64_t> integers_of(const std::vector<double>& values,
                                      const ValueLattice& lattice) {
    std::vector<std::int64_t> integers;
    for (const double value : values) integers.push_back(lattice.nearest(value));
    return integers;
}

std::vector<double> on_lattice(const std::vector<double>& values, const ValueLattice& lattice) {
    std::vector<double> rounded;
    for (const double value : values) rounded.push_back(lattice.value(lattice.nearest(value)));
    return rounded;
}

/// The levels of a file, and the splines that they give.
struct Coded {
    std::optional<ValueLattice> lattice;
    std::vector<Bytes> levels;
    std::vector<NodalData> splines;
    std::int64_t kept = 0;
};

Result<std::vector<Bytes>> code_values(const Source& source, const ValueLattice& lattice) {
    const std::vector<std::int64_t> integers = integers_of(source.heights, lattice);
    QuadValues values(source.hierarchy, lattice);
    std::vector<Bytes> levels;
    for (int m = 0; m <= source.hierarchy.levels(); ++m) {
        RELIEF_TRY(Bytes level, values.encode_next(integers));
        levels.push_back(std::move(level));
    }
    return levels;
}

Result<Coded> coded_values(const Source& source, const ValueLattice& lattice) {
    Coded coded{lattice, {}, {}, static_cast<std::int64_t>(source.heights.size())};
    RELIEF_TRY(coded.levels, code_values(source, lattice));
    const std::vector<double> values = on_lattice(source.heights, lattice);
    for (int m = 0; m <= source.hierarchy.levels(); ++m) {
        const Quadrangulation& mesh = source.hierarchy.mesh(m);
        RELIEF_TRY(auto spline, fvs_mesh::interpolate_values(
                                    mesh, std::span(values).first(mesh.vertex_count())));
        coded.splines.push_back(std::move(spline));
    }
    return coded;
}

/// Sets all but the `count` largest details, relative to 1 / h, to zero. Returns how many stay.
std::int64_t keep_largest(const Hierarchy& hierarchy, std::uint64_t count,
                          Decomposition& coefficients) {
    const auto limits = threshold_limits(hierarchy, 1, fvs_mesh::Convention::Text);
    std::vector<double> sizes;
    const auto collect = [&](const std::vector<double>& numbers, const std::vector<double>& limit) {
        for (std::size_t k = 0; k < numbers.size(); ++k)
            sizes.push_back(std::abs(numbers[k]) / limit[k]);
    };
    for (std::size_t m = 0; m < limits.size(); ++m)
        fvs_mesh::for_each_detail(collect, coefficients.details[m], limits[m]);
    if (count >= sizes.size()) return static_cast<std::int64_t>(sizes.size());
    std::vector<double> sorted = sizes;
    const auto last = sorted.begin() + static_cast<std::ptrdiff_t>(count);
    std::nth_element(sorted.begin(), last, sorted.end(), std::greater<>());
    const double largest_dropped = *last;
    std::int64_t kept = 0;
    std::size_t next = 0;
    const auto drop = [&](std::vector<double>& numbers) {
        for (double& number : numbers) {
            if (sizes[next++] <= largest_dropped) number = 0;
            kept += number != 0;
        }
    };
    for (auto& details : coefficients.details) fvs_mesh::for_each_detail(drop, details);
    return kept;
}

Result<Coded> coded_coefficients(const Source& source, double percent) {
    const Hierarchy& hierarchy = source.hierarchy;
    if (hierarchy.levels() == 0)
        return bad_argument(
            "the mesh is no refinement of a coarser one: it has no details to drop; ask for "
            "another goal");
    RELIEF_TRY(Decomposition coefficients, decompose(hierarchy, source.spline));
    const std::uint64_t base =
        3 * std::uint64_t{hierarchy.mesh(0).vertex_count()} + hierarchy.mesh(0).edge_count();
    const double wanted =
        std::min(percent / 100 * static_cast<double>(source.heights.size()), 1e15);
    const auto count = static_cast<std::uint64_t>(wanted);
    Coded coded;
    coded.kept = static_cast<std::int64_t>(base) +
                 keep_largest(hierarchy, count > base ? count - base : 0, coefficients);
    QuadNodal nodal(hierarchy);
    for (int m = 0; m <= hierarchy.levels(); ++m)
        coded.levels.push_back(nodal.encode_next(coefficients));
    for (int m = 0; m <= hierarchy.levels(); ++m) {
        RELIEF_TRY(auto spline, reconstruct(hierarchy, coefficients, m));
        coded.splines.push_back(std::move(spline));
    }
    return coded;
}

/// A spline of a level, on the finest mesh.
NodalData refined(const Hierarchy& hierarchy, int level, NodalData spline) {
    for (int m = level; m < hierarchy.levels(); ++m) spline = predict(hierarchy.mesh(m), spline);
    return spline;
}

QuadHeader header_of(const Source& source, const Goal& goal,
                     const std::optional<ValueLattice>& lattice, const Errors& errors) {
    QuadHeader header;
    header.vertices = source.base.vertices.size();
    header.quads = source.base.quads.size();
    header.levels = source.hierarchy.levels();
    header.x_digits = source.digits.x;
    header.y_digits = source.digits.y;
    header.lattice = lattice;
    header.goal = goal;
    header.max_error = errors.max;
    header.rms_error = errors.rms;
    return header;
}

Bytes numbering_chunk(const Source& source) {
    return write_numbering(source.numbering,
                           places_of(source.finest(), source.base.vertices, source.digits));
}

/// How large a file of values would be.
Result<std::uint64_t> size_on(const Source& source, const Goal& goal, const ValueLattice& lattice) {
    RELIEF_TRY(const auto levels, code_values(source, lattice));
    const Errors errors = errors_between(source.heights, on_lattice(source.heights, lattice));
    QuadHeader header = header_of(source, goal, lattice, errors);
    header.surface_error = errors.max;
    RELIEF_TRY(const Bytes file,
               write_quad_file(header, source.base, levels, std::vector<double>(levels.size()),
                               numbering_chunk(source)));
    return file.size();
}

/// A step with which all values become 0 or nearly so.
double longest_step(const std::vector<double>& values) {
    double most = 0;
    for (const double value : values) most = std::max(most, std::abs(value));
    return 4 * most;
}

ValueLattice steps_of(double step) {
    return {.kind = ValueLattice::Kind::Step, .step = step};
}

bool never_cancelled(double) {
    return false;
}

Result<ValueLattice> lattice_for_rms(const std::vector<double>& heights, double target) {
    const double longest = longest_step(heights);
    if (!(target > 0) || !(longest > target)) return ValueLattice::exact(heights);
    const auto try_step = [&](double step) -> Result<Tried<ValueLattice>> {
        const ValueLattice lattice = steps_of(step);
        const double rms = errors_between(heights, on_lattice(heights, lattice)).rms;
        return Tried<ValueLattice>{lattice, step, rms / target};
    };
    RELIEF_TRY(const Tried<ValueLattice> finest, try_step(target));
    RELIEF_TRY(const Tried<ValueLattice> best,
               bisect(finest, longest, kHalvings, try_step, never_cancelled));
    const ValueLattice exact = ValueLattice::exact(heights);
    const bool finer_than_data =
        exact.kind == ValueLattice::Kind::Decimal && best.unit <= exact.value(1);
    return finer_than_data || best.share > 1 ? exact : best.candidate;
}

double share_of_bytes(std::uint64_t size, const Goal& goal) {
    return static_cast<double>(size + kHeaderSlack) / goal.value;
}

Result<ValueLattice> lattice_for_bytes(const Source& source, const Goal& goal) {
    const ValueLattice exact = ValueLattice::exact(source.heights);
    RELIEF_TRY(const std::uint64_t lossless, size_on(source, goal, exact));
    if (share_of_bytes(lossless, goal) <= 1) return exact;
    const double longest = longest_step(source.heights);
    // By the number of steps in a unit.
    const auto try_steps = [&](double steps) -> Result<Tried<ValueLattice>> {
        const ValueLattice lattice = steps_of(1 / steps);
        RELIEF_TRY(const std::uint64_t size, size_on(source, goal, lattice));
        return Tried<ValueLattice>{lattice, steps, share_of_bytes(size, goal)};
    };
    const double fewest = 1 / (longest > 0 ? longest : 1);
    RELIEF_TRY(const Tried<ValueLattice> coarsest, try_steps(fewest));
    if (coarsest.share > 1) {
        RELIEF_TRY(const std::uint64_t smallest, size_on(source, goal, coarsest.candidate));
        return bad_argument("the mesh alone needs about " +
                            std::to_string(smallest + kHeaderSlack) + " bytes; allow more");
    }
    RELIEF_TRY(const Tried<ValueLattice> best,
               bisect(coarsest, 0x1p48 * fewest, kHalvings, try_steps, never_cancelled));
    return best.candidate;
}

Result<Coded> code(const Source& source, const Goal& goal) {
    switch (goal.kind) {
        case Goal::Kind::Keep:
            return coded_coefficients(source, goal.value);
        case Goal::Kind::MaxError:
            return coded_values(source, lattice_within(source.heights, goal.value));
        case Goal::Kind::RmsError: {
            RELIEF_TRY(const ValueLattice lattice, lattice_for_rms(source.heights, goal.value));
            return coded_values(source, lattice);
        }
        case Goal::Kind::Bytes: {
            RELIEF_TRY(const ValueLattice lattice, lattice_for_bytes(source, goal));
            return coded_values(source, lattice);
        }
        default:
            return coded_values(source, ValueLattice::exact(source.heights));
    }
}

/// Mean of the squared differences between z and the surface of the coarsest level.
Result<double> coarsest_square(const Source& source) {
    const Quadrangulation& base = source.hierarchy.mesh(0);
    RELIEF_TRY(const auto spline, fvs_mesh::interpolate_values(
                                      base, std::span(source.heights).first(base.vertex_count())));
    const double rms =
        errors_between(source.heights, refined(source.hierarchy, 0, spline).value).rms;
    return rms * rms;
}

/// Of the surfaces of all levels against that of the input.
std::vector<double> surface_bounds(const Source& source, const Coded& coded) {
    std::vector<double> bounds;
    for (int m = 0; m <= source.hierarchy.levels(); ++m) {
        const NodalData spline =
            refined(source.hierarchy, m, coded.splines[static_cast<std::size_t>(m)]);
        bounds.push_back(
            spline == source.spline
                ? 0
                : fvs_mesh::error_bound(source.finest(), spline, source.spline, kCertificate));
    }
    return bounds;
}

/// What the file says must be what was meant.
Status verify(const Bytes& file, const QuadMesh& input, const Source& source,
              const std::vector<double>& heights) {
    const Error differs{ErrorCode::BadInput,
                        "the decoded file differs from what was encoded; please report this mesh",
                        ""};
    RELIEF_TRY(const QuadFile opened, QuadFile::open(file));
    RELIEF_TRY(const QuadMesh decoded, opened.decode(0));
    if (decoded.quads != input.quads) return differs;
    for (std::size_t k = 0; k < heights.size(); ++k) {
        const Index v = source.numbering.vertices[k];
        const std::array<double, 3> expected = {input.vertices[v][0], input.vertices[v][1],
                                                heights[k]};
        for (std::size_t i = 0; i < 3; ++i)
            if (ordinal_of(decoded.vertices[v][i]) != ordinal_of(expected[i])) return differs;
    }
    return {};
}

}  // namespace

Result<EncodedQuads> encode_quads(const QuadMesh& mesh, const QuadEncodeOptions& options) {
    RELIEF_CHECK(check_goal(options.goal));
    RELIEF_TRY(const Source source, prepare(mesh, options.levels));
    RELIEF_TRY(const Coded coded, code(source, options.goal));
    const std::vector<double>& heights = coded.splines.back().value;
    const Errors errors = errors_between(source.heights, heights);
    QuadHeader header = header_of(source, options.goal, coded.lattice, errors);
    const std::vector<double> bounds = surface_bounds(source, coded);
    header.surface_error = bounds.back();
    RELIEF_TRY(Bytes file,
               write_quad_file(header, source.base, coded.levels, bounds, numbering_chunk(source)));
    RELIEF_CHECK(verify(file, mesh, source, heights));

    QuadReport report;
    report.levels = header.levels;
    report.samples = static_cast<std::int64_t>(mesh.vertices.size());
    report.coefficients =
        coded.lattice ? report.samples : 3 * report.samples + source.finest().edge_count();
    report.kept = coded.kept;
    report.bytes = file.size();
    report.bits_per_sample =
        8 * static_cast<double>(file.size()) / static_cast<double>(report.samples);
    report.max_error = errors.max;
    report.rms_error = errors.rms;
    RELIEF_TRY(const double square, coarsest_square(source));
    report.energy_percent = square > 0 ? 100 * errors.rms * errors.rms / square : 0;
    report.bound = options.goal.kind == Goal::Kind::MaxError ? options.goal.value : errors.max;
    report.surface_bound = bounds.back();
    return EncodedQuads{std::move(file), report};
}

}  // namespace relief::codec
