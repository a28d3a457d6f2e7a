#include "multires/fvs_mesh_support.h"
#include "multires/small_cholesky.h"
#include "relief/core/parallel.h"
#include "relief/multires/fvs_mesh_coding.h"

namespace relief::multires::fvs_mesh {
namespace {

using mesh::Index;
using mesh::Quadrangulation;
using test::built;
using test::hierarchy_of;
using test::largest_difference;
using test::unit_square;

Decomposition zero(const Hierarchy& hierarchy) {
    Decomposition d{make_nodal<double>(hierarchy.mesh(0)), {}};
    for (int m = 0; m < hierarchy.levels(); ++m)
        d.details.push_back(make_details<double>(hierarchy.mesh(m)));
    return d;
}

/// All details of a level, the edges' values and tangentials in turn: the order of the reference
/// vectors.
std::vector<double*> columns(Details<double>& d) {
    std::vector<double*> list;
    for (std::size_t e = 0; e < d.edge_value.size(); ++e)
        list.insert(list.end(), {&d.edge_value[e], &d.edge_tangential[e]});
    for (std::size_t q = 0; q < d.centre_value.size(); ++q)
        list.insert(list.end(), {&d.centre_value[q], &d.centre_dx[q], &d.centre_dy[q]});
    for (double& n : d.normal) list.push_back(&n);
    return list;
}

TEST(FvsUpdate, GoldenMatrixOfTheUnitSquare) {
    const nlohmann::json& golden = test::fvs_golden()["l2_update"]["U"];
    // Corners counter-clockwise, as the reference vectors number them.
    const test::QuadMesh square = {{{0, 0}, {1, 0}, {1, 1}, {0, 1}}, {{0, 1, 2, 3}}};
    const Hierarchy hierarchy = hierarchy_of(built(square), 1);
    const Update update = *Update::create(hierarchy);
    ASSERT_EQ(golden.size(), 16u);
    for (std::size_t j = 0; j < 23; ++j) {
        Decomposition d = zero(hierarchy);
        *columns(d.details[0])[j] = 1;
        update.apply(hierarchy.mesh(0), 1, d.details[0], 1, d.base);
        const std::vector<double> column = flat(d.base);
        for (std::size_t i = 0; i < 16; ++i)
            EXPECT_NEAR(column[i], golden[i][j].get<double>(), 1e-9);
    }
}

TEST(FvsUpdate, RoundTrip) {
    for (const Quadrangulation& base : test::mesh_family()) {
        const Hierarchy hierarchy = hierarchy_of(base, 3);
        const Update update = *Update::create(hierarchy);
        const NodalData data = test::noise_data(hierarchy.mesh(3), 29);
        const Decomposition d = *decompose_lifted(hierarchy, update, data);
        EXPECT_LT(largest_difference(*reconstruct_lifted(hierarchy, update, d, 3), data), 1e-11);
        EXPECT_EQ(d.details[2].edge_value, decompose(hierarchy, data)->details[2].edge_value);
    }
}

TEST(FvsUpdate, WeightsAreNormsOfTheLiftedBasis) {
    for (const Quadrangulation& base : test::mesh_family()) {
        const Hierarchy hierarchy = hierarchy_of(base, 2);
        const Update update = *Update::create(hierarchy);
        for (int m = 1; m <= 2; ++m) {
            Details<double> weights = update.weights()[m - 1];
            const auto expected = columns(weights);
            for (std::size_t j = 0; j < expected.size(); j += 7) {
                Decomposition d = zero(hierarchy);
                *columns(d.details[m - 1])[j] = 1;
                const NodalData atom = *reconstruct_lifted(hierarchy, update, d, m);
                // A difference of squares: half the digits where the update leaves little.
                EXPECT_NEAR(l2_norm(hierarchy.mesh(m), atom), *expected[j], 1e-8);
            }
        }
    }
}

/// On one quad the block is the whole coarse space, so the coarse spline is the L2 projection of
/// the fine one: no other is nearer.
TEST(FvsUpdate, OneQuadIsProjected) {
    for (std::uint64_t seed = 1; seed < 10; ++seed) {
        const Hierarchy hierarchy = hierarchy_of(built(test::random_quad(seed)), 1);
        const Update update = *Update::create(hierarchy);
        const NodalData fine = test::noise_data(hierarchy.mesh(1), seed);
        Decomposition d = *decompose_lifted(hierarchy, update, fine);
        const double error = [&] {
            Decomposition rest = d;
            rest.base = make_nodal<double>(hierarchy.mesh(0));
            return l2_norm(hierarchy.mesh(1), *reconstruct_lifted(hierarchy, update, rest, 1));
        }();
        for (std::size_t k = 0; k < 4; ++k) {
            for (const double change : {-1e-3, 1e-3}) {
                NodalData other = d.base;
                other.value[k] += change;
                other.normal[k] -= change;
                NodalData remainder = predict(hierarchy.mesh(0), other);
                for_each_nodal(
                    [](std::vector<double>& a, const std::vector<double>& b) {
                        for (std::size_t i = 0; i < a.size(); ++i) a[i] -= b[i];
                    },
                    remainder, fine);
                EXPECT_GT(l2_norm(hierarchy.mesh(1), remainder), error);
            }
        }
    }
}

/// Largest over smallest eigenvalue of the mass matrix of the basis functions divided by their
/// norms, by power iteration on A and on its inverse.
double condition(const std::vector<std::vector<double>>& gram) {
    const std::size_t n = gram.size();
    std::vector<double> scaled(n * n);
    for (std::size_t i = 0; i < n; ++i)
        for (std::size_t j = 0; j < n; ++j)
            scaled[n * i + j] = gram[i][j] / std::sqrt(gram[i][i] * gram[j][j]);
    const auto factor = SmallCholesky::factor(scaled, n, 0);
    if (!factor) return INFINITY;
    double eigenvalue[2] = {};
    for (int inverse = 0; inverse < 2; ++inverse) {
        std::vector<double> x(n);
        for (std::size_t i = 0; i < n; ++i) x[i] = 1.0 / static_cast<double>(i + 1);
        for (int k = 0; k < 2000; ++k) {
            std::vector<double> y(n);
            if (inverse) {
                y = x;
                factor->solve(y.data());
            } else {
                for (std::size_t i = 0; i < n; ++i)
                    for (std::size_t j = 0; j < n; ++j) y[i] += scaled[n * i + j] * x[j];
            }
            double norm = 0;
            for (const double v : y) norm += v * v;
            eigenvalue[inverse] = std::sqrt(norm);
            for (std::size_t i = 0; i < n; ++i) x[i] = y[i] / eigenvalue[inverse];
        }
    }
    return eigenvalue[0] * eigenvalue[1];
}

/// Condition of the whole basis, with or without the update.
double basis_condition(int levels, bool lifted) {
    const Hierarchy hierarchy = unit_square(levels);
    const Update update = *Update::create(hierarchy);
    std::vector<NodalData> atoms;
    Decomposition d = zero(hierarchy);
    const auto add_atom = [&](double& coefficient) {
        coefficient = 1;
        atoms.push_back(lifted ? *reconstruct_lifted(hierarchy, update, d, levels)
                               : *reconstruct(hierarchy, d, levels));
        coefficient = 0;
    };
    for_each_nodal(
        [&](std::vector<double>& numbers) {
            for (double& number : numbers) add_atom(number);
        },
        d.base);
    for (Details<double>& level : d.details)
        for (double* number : columns(level)) add_atom(*number);
    const Quadrangulation& mesh = hierarchy.mesh(levels);
    std::vector<std::vector<double>> gram(atoms.size(), std::vector<double>(atoms.size()));
    for (Index q = 0; q < mesh.quad_count(); ++q) {
        const auto mass = spline::FvsElement(mesh.corners(q)).mass_matrix();
        std::vector<std::array<double, 16>> local;
        for (const NodalData& atom : atoms)
            local.push_back(spline::fvs_flat(quad_data(mesh, atom, q)));
        for (std::size_t i = 0; i < atoms.size(); ++i) {
            std::array<double, 16> image{};
            for (std::size_t r = 0; r < 256; ++r) image[r / 16] += mass[r] * local[i][r % 16];
            for (std::size_t j = 0; j < atoms.size(); ++j)
                for (std::size_t r = 0; r < 16; ++r) gram[i][j] += image[r] * local[j][r];
        }
    }
    return condition(gram);
}

TEST(FvsUpdate, StabilisesTheBasis) {
    // Section 9 prints two to three digits.
    EXPECT_NEAR(basis_condition(1, false), 5.3e3, 0.05e3);
    EXPECT_NEAR(basis_condition(2, false), 1.0e5, 0.05e5);
    EXPECT_NEAR(basis_condition(1, true), 328, 0.6);
    EXPECT_NEAR(basis_condition(2, true), 341, 0.6);
}

double mean_square(const Hierarchy& hierarchy, int level, const NodalData& a, const NodalData& b) {
    const auto points = test::square_points(129);
    const auto x = test::jets(hierarchy, level, a, points);
    const auto y = test::jets(hierarchy, level, b, points);
    double sum = 0;
    for (std::size_t k = 0; k < points.size(); ++k)
        sum += (x[k].value - y[k].value) * (x[k].value - y[k].value);
    return sum / static_cast<double>(points.size());
}

/// Rms error on Franke's function when `details` details remain.
template <class Limits, class Rebuild>
double rms_of(Decomposition full, std::uint64_t details, const NodalData& data,
              const Hierarchy& hierarchy, const Limits& limits, const Rebuild& rebuild) {
    double low = 1e-12;
    double high = 1;
    for (int k = 0; k < 60; ++k) {
        const double epsilon = std::sqrt(low * high);
        Decomposition kept = full;
        std::uint64_t count = 0;
        const auto counts = threshold(kept, limits(epsilon));
        for (std::size_t m = 1; m < counts.size(); ++m) count += counts[m];
        (count > details ? low : high) = epsilon;
    }
    threshold(full, limits(high));
    return std::sqrt(mean_square(hierarchy, hierarchy.levels(), rebuild(full), data));
}

TEST(FvsUpdate, LowersTheErrorAtEqualSize) {
    const Hierarchy hierarchy = unit_square(5);
    const Update update = *Update::create(hierarchy);
    const NodalData data = interpolate(hierarchy.mesh(5), [](Vec2 p) { return test::franke(p); });
    for (const std::uint64_t details : {100u, 200u, 400u}) {
        const double plain = rms_of(
            *decompose(hierarchy, data), details, data, hierarchy,
            [&](double e) { return threshold_limits(hierarchy, e, Convention::Text); },
            [&](const Decomposition& d) { return *reconstruct(hierarchy, d, 5); });
        const double lifted = rms_of(
            *decompose_lifted(hierarchy, update, data), details, data, hierarchy,
            [&](double e) { return lifted_limits(update, e); },
            [&](const Decomposition& d) { return *reconstruct_lifted(hierarchy, update, d, 5); });
        // Section 9: 2.75e-3 -> 1.50e-3, 8.8e-4 -> 5.1e-4, 1.83e-4 -> 1.00e-4.
        EXPECT_LT(lifted, 0.7 * plain) << details;
    }
}

TEST(FvsUpdate, CoarseLevelsAreCloserWithIt) {
    const Hierarchy hierarchy = unit_square(5);
    const Update update = *Update::create(hierarchy);
    const NodalData data = interpolate(hierarchy.mesh(5), [](Vec2 p) { return test::franke(p); });
    const auto coarse_rms = [&](const NodalData& level2) {
        NodalData fine = level2;
        for (int m = 2; m < 5; ++m) fine = predict(hierarchy.mesh(m), fine);
        return std::sqrt(mean_square(hierarchy, 5, fine, data));
    };
    const double plain = coarse_rms(*reconstruct(hierarchy, *decompose(hierarchy, data), 2));
    const double lifted = coarse_rms(
        *reconstruct_lifted(hierarchy, update, *decompose_lifted(hierarchy, update, data), 2));
    // Section 9 prints two digits: 7.6e-3 -> 2.5e-3.
    EXPECT_NEAR(plain, 7.6e-3, 1e-4);
    EXPECT_NEAR(lifted, 2.5e-3, 1e-4);
}

TEST(FvsUpdate, SameBytesForAnyNumberOfThreads) {
    const Hierarchy hierarchy = hierarchy_of(built(test::grid_mesh(9, 7, 1, 0.19)), 2);
    const NodalData data = test::noise_data(hierarchy.mesh(2), 31);
    Decomposition found[2];
    for (int k = 0; k < 2; ++k) {
        set_thread_count(k == 0 ? 1 : 4);
        found[k] = *decompose_lifted(hierarchy, *Update::create(hierarchy), data);
    }
    set_thread_count(0);
    EXPECT_TRUE(found[0].base == found[1].base && found[0].details == found[1].details);
}

}  // namespace
}  // namespace relief::multires::fvs_mesh
