#include "relief/multires/ps_lift.h"

#include <Eigen/Dense>

#include "ps_testing.h"
#include "relief/core/parallel.h"
#include "relief/multires/ps_energy.h"

namespace relief::multires::ps {
namespace {

using namespace test;

constexpr std::array kUpdates = {Update::None,  Update::Moments,      Update::Semi,
                                 Update::Semi2, Update::Semi2Moments, Update::Full};

Eigen::VectorXd vector_of(const Coefficients& spline) {
    Eigen::VectorXd vector(3 * static_cast<Eigen::Index>(spline.size()));
    for (std::size_t k = 0; k < spline.size(); ++k)
        for (int j = 0; j < 3; ++j) vector[static_cast<Eigen::Index>(3 * k) + j] = spline[k][j];
    return vector;
}

double product(const BlockMatrix& gram, const Coefficients& a, const Coefficients& b) {
    return vector_of(a).dot(vector_of(gram.times(b)));
}

double largest_difference(const Coefficients& a, const Coefficients& b) {
    return (vector_of(a) - vector_of(b)).cwiseAbs().maxCoeff();
}

/// The wavelet of detail `number` (3 per new vertex) in the fine space.
Coefficients wavelet(const Space& coarse, const Refinement& step, std::size_t number,
                     Update update) {
    Lifted lifted{Coefficients(coarse.mesh.vertex_count()),
                  Coefficients(step.fine.mesh.vertex_count() - coarse.mesh.vertex_count())};
    lifted.details[number / 3][number % 3] = 1;
    return must(synthesise(coarse, step, lifted, update));
}

TEST(PsEnergy, Golden) {
    for (const auto& item : golden_cases()) {
        const Space space = golden_space(item);
        const Coefficients spline = golden_coefficients(item["c"]);
        const BlockMatrix gram = gram_matrix(space);
        const auto& expected = item["energies"];
        const auto near = [](double value, const nlohmann::json& number) {
            EXPECT_NEAR(value, number.get<double>(), 1e-11 * std::abs(number.get<double>()));
        };
        near(product(gram, spline, spline), expected["l2"]);
        near(thin_plate_energy(space, spline), expected["thin_plate"]);
        near(product(thin_plate_matrix(space), spline, spline), expected["thin_plate"]);
        near(jump_energy(space, spline), expected["jump"]);
        near(product(jump_matrix(space), spline, spline), expected["jump"]);
        double integral = 0;
        double trace = 0;
        double area = 0;
        const auto masses = moments(space, gram);
        for (Index v = 0; v < space.mesh.vertex_count(); ++v)
            for (int j = 0; j < 3; ++j) {
                integral += masses[v][j].mass * spline[v][j];
                area += masses[v][j].mass;
                trace += (*gram.find(v, v))[4 * j];
            }
        near(integral, expected["integral"]);
        near(trace, expected["gram_trace"]);
        double triangles = 0;
        for (Index t = 0; t < space.mesh.triangle_count(); ++t) {
            const TriangleCorners v = space.mesh.corners(t);
            triangles += 0.5 * orient(v[0], v[1], v[2]);
        }
        EXPECT_NEAR(area, triangles, 1e-12 * triangles);
    }
}

TEST(PsEnergy, QuadraticsAndPlanes) {
    for (const Space& space : space_family()) {
        TangentPlanes quadratic;
        TangentPlanes plane;
        double area = 0;
        for (Index t = 0; t < space.mesh.triangle_count(); ++t) {
            const TriangleCorners v = space.mesh.corners(t);
            area += 0.5 * orient(v[0], v[1], v[2]);
        }
        for (Index v = 0; v < space.mesh.vertex_count(); ++v) {
            const Vec2 p = space.mesh.vertex(v);
            quadratic.push_back({p.x * p.x + 3 * p.x * p.y - 2 * p.y * p.y,
                                 {2 * p.x + 3 * p.y, 3 * p.x - 4 * p.y}});
            plane.push_back({1 + p.x - 2 * p.y, {1, -2}});
        }
        const double energy = area * (4 + 2 * 9 + 16);
        const Coefficients spline = coefficients(space, quadratic);
        EXPECT_NEAR(thin_plate_energy(space, spline), energy, 1e-9 * energy);
        EXPECT_LE(jump_energy(space, spline), 1e-10 * energy);
        EXPECT_LE(thin_plate_energy(space, coefficients(space, plane)), 1e-9);
    }
}

/// The scaled Gram matrix of minimal triangles has a condition below 60 on all shapes.
TEST(PsEnergy, WellConditioned) {
    for (const Space& space : space_family()) {
        const BlockMatrix gram = gram_matrix(space);
        const auto size = static_cast<Eigen::Index>(3 * space.mesh.vertex_count());
        Eigen::MatrixXd dense(size, size);
        for (Eigen::Index k = 0; k < size; ++k) {
            Coefficients unit(space.mesh.vertex_count());
            unit[static_cast<std::size_t>(k / 3)][static_cast<std::size_t>(k % 3)] = 1;
            dense.col(k) = vector_of(gram.times(unit));
        }
        const Eigen::VectorXd scale = dense.diagonal().cwiseSqrt().cwiseInverse();
        dense = scale.asDiagonal() * dense * scale.asDiagonal();
        const Eigen::VectorXd values =
            Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(dense).eigenvalues();
        EXPECT_LT(values.maxCoeff() / values.minCoeff(), 60);
    }
}

TEST(PsLift, Golden) {
    const std::array<std::pair<const char*, Update>, 5> updates = {{
        {"none", Update::None},
        {"moments", Update::Moments},
        {"semi", Update::Semi},
        {"semi2", Update::Semi2},
        {"semi2m", Update::Semi2Moments},
    }};
    for (const auto& item : golden_cases()) {
        if (!item.contains("lifting") || item["lifting"].is_null()) continue;
        const auto& expected = item["lifting"];
        const Space coarse = golden_space(item);
        const Refinement step = must(refine(coarse));
        const Coefficients fine = golden_coefficients(expected["fine"]);
        for (const auto& [name, update] : updates) {
            const Lifted lifted = must(analyse(coarse, step, fine, update));
            EXPECT_LE(largest_difference(lifted.details, golden_coefficients(expected["detail"])),
                      1e-11 * 10);  // details of up to 10
            EXPECT_LE(
                largest_difference(lifted.coarse, golden_coefficients(expected[name]["coarse"])),
                1e-9)
                << name;
            const DetailNorms norms = must(detail_norms(coarse, step, update));
            const auto& weights = expected[name]["weight_L2"];
            for (std::size_t k = 0; k < weights.size(); ++k)
                for (std::size_t j = 0; j < 3; ++j)
                    EXPECT_NEAR(norms.l2[k][j], weights[k][j].get<double>(), 1e-10) << name;
        }
    }
}

TEST(PsLift, Reconstructs) {
    const Space base = must(make_space(relief::test::built(
        relief::test::without_triangle(relief::test::triangle_grid(4, 3, 0.15), 10))));
    const Hierarchy hierarchy = must(Hierarchy::create(base, 2));
    const Coefficients finest = random_spline(hierarchy.space(2), 1);
    for (const Update update : kUpdates) {
        const Decomposition decomposition = must(analyse(hierarchy, finest, update));
        const Coefficients again = must(synthesise(hierarchy, decomposition, 2, update));
        EXPECT_LE(largest_difference(again, finest), 1e-12);
        // A prefix of levels is the spline of its level.
        const Lifted last = must(analyse(hierarchy.space(1), hierarchy.step(1), finest, update));
        EXPECT_LE(
            largest_difference(must(synthesise(hierarchy, decomposition, 1, update)), last.coarse),
            1e-11);
    }
}

TEST(PsLift, CoarseSplinesHaveNoDetails) {
    for (const Space& coarse : space_family()) {
        const Refinement step = must(refine(coarse));
        const Coefficients spline = random_spline(coarse, 3);
        const Coefficients fine = prolong(coarse, step, spline);
        const Lifted lifted = must(analyse(coarse, step, fine));
        for (const Heights& detail : lifted.details)
            for (const double number : detail) EXPECT_NEAR(number, 0, 1e-12);
        EXPECT_LE(largest_difference(lifted.coarse, spline), 1e-11);
    }
}

/// Full is the projection; Semi2 nearly so; the moments of wavelets vanish where they should.
TEST(PsLift, Orthogonality) {
    const Space coarse =
        must(make_space(relief::test::built(relief::test::triangle_grid(4, 4, 0.19))));
    const Refinement step = must(refine(coarse));
    const BlockMatrix gram = gram_matrix(step.fine);
    const auto fine_moments = moments(step.fine, gram);
    for (const Update update : kUpdates) {
        double worst_product = 0;
        double worst_mean = 0;
        for (std::size_t number = 0; number < 3 * 60; number += 7) {
            const Coefficients psi = wavelet(coarse, step, number, update);
            const Coefficients products = transpose_prolong(coarse, step, gram.times(psi));
            const double norm = std::sqrt(product(gram, psi, psi));
            double mean = 0;
            for (Index v = 0; v < psi.size(); ++v)
                for (int j = 0; j < 3; ++j) mean += fine_moments[v][j].mass * psi[v][j];
            const Index v = coarse.mesh.vertex_count() + static_cast<Index>(number / 3);
            worst_mean = std::max(worst_mean, std::abs(mean / fine_moments[v][number % 3].mass));
            for (const Heights& triple : products)
                for (const double p : triple)
                    worst_product = std::max(worst_product, std::abs(p) / norm);
        }
        const bool keeps_moments =
            update == Update::Moments || update == Update::Semi2Moments || update == Update::Full;
        if (update == Update::None) {
            EXPECT_NEAR(worst_mean, 1, 1e-12);
        } else {
            // Measured: 0.34 for Semi, 0.05 for Semi2.
            EXPECT_LE(worst_mean, keeps_moments ? 1e-12 : 0.5);
        }
        if (update == Update::Full) {
            EXPECT_LE(worst_product, 1e-12);
        }
    }
}

TEST(PsLift, NormsAreThoseOfTheWavelets) {
    const Space coarse = must(make_space(relief::test::built(relief::test::triangle_star(6))));
    const Refinement step = must(refine(coarse));
    const BlockMatrix gram = gram_matrix(step.fine);
    for (const Update update : kUpdates) {
        const DetailNorms norms = must(detail_norms(coarse, step, update));
        for (std::size_t number = 0; number < 3 * norms.l2.size(); ++number) {
            const Coefficients psi = wavelet(coarse, step, number, update);
            const double norm = std::sqrt(product(gram, psi, psi));
            const double stated = norms.l2[number / 3][number % 3];
            if (update == Update::Full) {
                EXPECT_GE(stated, norm * (1 - 1e-12));
                EXPECT_LE(stated, norm * 1.1);
                continue;
            }
            EXPECT_NEAR(stated, norm, 1e-11);
            // B-splines lie between 0 and 1.
            const TangentPlanes planes = tangent_planes(step.fine, psi);
            for (const auto& plane : planes)
                EXPECT_LE(std::abs(plane.value), norms.bound[number / 3][number % 3] + 1e-12);
        }
    }
}

/// Condition of the Gram matrix of the normalised basis of two levels on the unit square: the
/// specification's table.
TEST(PsLift, StabilityOfTheBasis) {
    const Space coarse = must(make_space(relief::test::built(relief::test::triangle_grid(1, 1))));
    const Refinement step = must(refine(coarse));
    const BlockMatrix gram = gram_matrix(step.fine);
    const std::array<std::pair<Update, double>, 6> expected = {{{Update::None, 3.9e4},
                                                                {Update::Moments, 1.1e4},
                                                                {Update::Semi, 1836},
                                                                {Update::Semi2, 1690},
                                                                {Update::Semi2Moments, 1690},
                                                                {Update::Full, 1690}}};
    for (const auto& [update, condition] : expected) {
        const Eigen::Index coarse_size = 3 * coarse.mesh.vertex_count();
        const Eigen::Index size = 3 * step.fine.mesh.vertex_count();
        Eigen::MatrixXd basis(size, size);
        for (Eigen::Index k = 0; k < size; ++k) {
            if (k < coarse_size) {
                Coefficients unit(coarse.mesh.vertex_count());
                unit[static_cast<std::size_t>(k / 3)][static_cast<std::size_t>(k % 3)] = 1;
                basis.col(k) = vector_of(prolong(coarse, step, unit));
            } else {
                basis.col(k) = vector_of(
                    wavelet(coarse, step, static_cast<std::size_t>(k - coarse_size), update));
            }
        }
        Eigen::MatrixXd products(size, size);
        for (Eigen::Index k = 0; k < size; ++k) {
            Coefficients column(step.fine.mesh.vertex_count());
            for (Eigen::Index i = 0; i < size; ++i)
                column[static_cast<std::size_t>(i / 3)][static_cast<std::size_t>(i % 3)] =
                    basis(i, k);
            products.col(k) = basis.transpose() * vector_of(gram.times(column));
        }
        const Eigen::VectorXd scale = products.diagonal().cwiseSqrt().cwiseInverse();
        products = scale.asDiagonal() * products * scale.asDiagonal();
        const Eigen::VectorXd values =
            Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(products).eigenvalues();
        // The table has two to four digits.
        EXPECT_NEAR(values.maxCoeff() / values.minCoeff(), condition, 0.05 * condition);
    }
}

TEST(PsLift, SameBytesForAnyThreadCount) {
    const Space coarse =
        must(make_space(relief::test::built(relief::test::triangle_grid(12, 12, 0.15))));
    const Refinement step = must(refine(coarse));
    const Coefficients fine = random_spline(step.fine, 4);
    for (const Update update : {Update::Semi2Moments, Update::Full}) {
        const Lifted several = must(analyse(coarse, step, fine, update));
        const Coefficients back = must(synthesise(coarse, step, several, update));
        set_thread_count(1);
        const Lifted one = must(analyse(coarse, step, fine, update));
        EXPECT_EQ(one.coarse, several.coarse);
        EXPECT_EQ(one.details, several.details);
        EXPECT_EQ(must(synthesise(coarse, step, one, update)), back);
        set_thread_count(0);
    }
}

TEST(PsLift, Errors) {
    const Space base = must(make_space(relief::test::built(relief::test::triangle_grid(1, 1))));
    EXPECT_FALSE(Hierarchy::create(base, -1).ok());
    const Hierarchy hierarchy = must(Hierarchy::create(base, 1));
    const Coefficients wrong(3);
    EXPECT_FALSE(analyse(hierarchy, wrong).ok());
    Decomposition decomposition = must(analyse(hierarchy, random_spline(hierarchy.space(1), 1)));
    EXPECT_FALSE(synthesise(hierarchy, decomposition, 2).ok());
    EXPECT_FALSE(synthesise(hierarchy, decomposition, -1).ok());
    decomposition.details[0].pop_back();
    EXPECT_FALSE(synthesise(hierarchy, decomposition, 1).ok());
    decomposition.details[0].push_back({NAN, 0, 0});
    EXPECT_FALSE(synthesise(hierarchy, decomposition, 1).ok());
}

}  // namespace
}  // namespace relief::multires::ps
