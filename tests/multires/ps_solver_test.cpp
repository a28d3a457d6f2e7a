#include "multires/ps_solver.h"

#include "ps_testing.h"

namespace relief::multires::ps {
namespace {

using namespace test;

Space square() {
    return golden_space(golden_cases()[0]);
}

TEST(PsSolver, Inverse) {
    const Space space = square();
    const BlockMatrix gram = gram_matrix(space);
    const Coefficients spline = random_spline(space, 1);
    Solver solver(gram);
    ASSERT_EQ(solver.factor(gram), std::nullopt);
    const Coefficients again = solver.solve(gram.times(spline));
    for (std::size_t v = 0; v < spline.size(); ++v)
        for (std::size_t j = 0; j < 3; ++j)
            EXPECT_NEAR(again[v][j], spline[v][j], 1e-11) << v;  // the condition is about 1e3
}

TEST(PsSolver, PatternServesOtherMatricesOfAnyScale) {
    const Space space = square();
    const BlockMatrix gram = gram_matrix(space);
    BlockMatrix small = gram;
    for (auto& block : small.block)
        for (double& element : block) element *= 1e-200;
    Solver solver(gram);
    ASSERT_EQ(solver.factor(small), std::nullopt);
    const Coefficients spline = random_spline(space, 2);
    const Coefficients again = solver.solve(small.times(spline));
    for (std::size_t v = 0; v < spline.size(); ++v)
        EXPECT_NEAR(again[v][0], spline[v][0], 1e-11) << v;
}

TEST(PsSolver, LostPivotsAreNamed) {
    const Space space = square();
    BlockMatrix gram = gram_matrix(space);
    Solver solver(gram);
    // The energy has no smallest spline: planes cost nothing.
    EXPECT_NE(solver.factor(thin_plate_matrix(space)), std::nullopt);
    const Index lost = 2;
    for (Index v = 0; v < space.mesh.vertex_count(); ++v) {
        if (gram.find(lost, v) == nullptr) continue;
        gram.at(lost, v) = {};
        gram.at(v, lost) = {};
    }
    EXPECT_EQ(solver.factor(gram), lost);
    // With a shift the vertex gets nothing, the others what they had.
    ASSERT_EQ(solver.factor(gram, 1e-12), std::nullopt);
    Coefficients spline = random_spline(space, 3);
    spline[lost] = {};
    const Coefficients again = solver.solve(gram.times(spline));
    for (std::size_t v = 0; v < spline.size(); ++v)
        EXPECT_NEAR(again[v][1], spline[v][1], 1e-8) << v;  // the condition times the shift
}

}  // namespace
}  // namespace relief::multires::ps
