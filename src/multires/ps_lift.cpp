#include "relief/multires/ps_lift.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "multires/ps_errors.h"
#include "multires/ps_solver.h"
#include "multires/ps_stencil.h"

namespace relief::multires::ps {

using mesh::Index;

namespace {

constexpr std::size_t kChunk = 4096;  ///< stencils whose increments are held at a time
constexpr std::int64_t kStencilGrain = 32;

Error singular(Index vertex) {
    return bad_input(
        "singular_system: triangles there are so thin that their B-splines can not be told apart; "
        "remove them, or lift without update",
        "vertex " + std::to_string(vertex));
}

Error bad_level(int level, int levels) {
    return {ErrorCode::InvalidArgument,
            "level_out_of_range: choose one from 0 to " + std::to_string(levels),
            "level " + std::to_string(level)};
}

std::span<const Heights> new_details(const UpdateStencil& stencil, const LevelProducts& level,
                                     std::span<const Heights> details) {
    return details.subspan(stencil.first_new() - level.coarse.mesh.vertex_count(),
                           stencil.new_count());
}

/// What one stencil adds.
struct Increment {
    bool solved = false;
    std::vector<Index> vertices;
    std::vector<double> numbers;
};

/// U d by stencils, added in their order.
Result<Coefficients> local_update(const Space& coarse, const Refinement& step,
                                  std::span<const Heights> details, Update update) {
    const LevelProducts level(coarse, step);
    Coefficients sum(coarse.mesh.vertex_count());
    std::vector<Increment> increments(std::min(kChunk, level.stencils()));
    for (std::size_t begin = 0; begin < level.stencils(); begin += kChunk) {
        const std::size_t count = std::min(kChunk, level.stencils() - begin);
        parallel_for(0, static_cast<std::int64_t>(count), kStencilGrain,
                     [&](std::int64_t first, std::int64_t last) {
                         for (std::int64_t k = first; k < last; ++k) {
                             const UpdateStencil stencil(level, begin + std::size_t(k), update);
                             increments[k] = {stencil.solvable(), stencil.vertices(), {}};
                             if (stencil.solvable())
                                 increments[k].numbers =
                                     stencil.increments(new_details(stencil, level, details));
                         }
                     });
        for (std::size_t k = 0; k < count; ++k) {
            const Increment& increment = increments[k];
            if (!increment.solved) return singular(increment.vertices[0]);
            for (std::size_t i = 0; i < increment.numbers.size(); ++i)
                sum[increment.vertices[i / 3]][i % 3] += increment.numbers[i];
        }
    }
    return sum;
}

/// U d = G^-1 P^T G' (0, d).
Result<Coefficients> full_update(const Space& coarse, const Refinement& step,
                                 std::span<const Heights> details) {
    Coefficients fine(coarse.mesh.vertex_count());
    fine.insert(fine.end(), details.begin(), details.end());
    const Coefficients products =
        transpose_prolong(coarse, step, gram_matrix(step.fine).times(fine));
    const BlockMatrix gram = gram_matrix(coarse);
    Solver solver(gram);
    if (const auto lost = solver.factor(gram)) return singular(*lost);
    return solver.solve(products);
}

/// U d.
Result<Coefficients> update_of(const Space& coarse, const Refinement& step,
                               std::span<const Heights> details, Update update) {
    if (update == Update::None) return Coefficients(coarse.mesh.vertex_count());
    if (update == Update::Full) return full_update(coarse, step, details);
    return local_update(coarse, step, details, update);
}

Status check_details(const Space& coarse, const Refinement& step, const Lifted& lifted) {
    RELIEF_CHECK(check(coarse.mesh, lifted.coarse));
    Coefficients all = lifted.coarse;
    all.insert(all.end(), lifted.details.begin(), lifted.details.end());
    return check(step.fine.mesh, all);
}

}  // namespace

Result<Hierarchy> Hierarchy::create(Space base, int levels, const RefineOptions& options) {
    if (levels < 0)
        return Error{ErrorCode::InvalidArgument, "level_out_of_range: choose 0 or more levels",
                     "level " + std::to_string(levels)};
    Hierarchy hierarchy(std::move(base));
    for (int level = 0; level < levels; ++level) {
        RELIEF_TRY(Refinement step, refine(hierarchy.space(level), options));
        hierarchy.steps_.push_back(std::move(step));
    }
    return hierarchy;
}

Result<Lifted> analyse(const Space& coarse, const Refinement& step, std::span<const Heights> fine,
                       Update update) {
    RELIEF_CHECK(check(step.fine.mesh, fine));
    const Index n = coarse.mesh.vertex_count();
    Lifted lifted;
    lifted.coarse.resize(n);
    for_each_index(n, [&](Index v) {
        lifted.coarse[v] = heights(coarse.control[v], tangent_plane(step.fine.control[v], fine[v]));
    });
    const Coefficients predicted = prolong(coarse, step, lifted.coarse);
    lifted.details.assign(fine.begin() + n, fine.end());
    for_each_index(lifted.details.size(), [&](Index k) {
        for (int j = 0; j < 3; ++j) lifted.details[k][j] -= predicted[n + k][j];
    });
    RELIEF_TRY(const Coefficients change, update_of(coarse, step, lifted.details, update));
    for_each_index(n, [&](Index v) {
        for (int j = 0; j < 3; ++j) lifted.coarse[v][j] += change[v][j];
    });
    return lifted;
}

Result<Coefficients> synthesise(const Space& coarse, const Refinement& step, const Lifted& lifted,
                                Update update) {
    RELIEF_CHECK(check_details(coarse, step, lifted));
    RELIEF_TRY(const Coefficients change, update_of(coarse, step, lifted.details, update));
    const Index n = coarse.mesh.vertex_count();
    Coefficients interpolating = lifted.coarse;
    for_each_index(n, [&](Index v) {
        for (int j = 0; j < 3; ++j) interpolating[v][j] -= change[v][j];
    });
    Coefficients fine = prolong(coarse, step, interpolating);
    for_each_index(lifted.details.size(), [&](Index k) {
        for (int j = 0; j < 3; ++j) fine[n + k][j] += lifted.details[k][j];
    });
    return fine;
}

Result<Decomposition> analyse(const Hierarchy& hierarchy, Coefficients finest, Update update) {
    Decomposition decomposition{std::move(finest), {}};
    decomposition.details.resize(static_cast<std::size_t>(hierarchy.levels()));
    for (int level = hierarchy.levels(); level-- > 0;) {
        RELIEF_TRY(Lifted lifted, analyse(hierarchy.space(level), hierarchy.step(level),
                                          decomposition.base, update));
        decomposition.base = std::move(lifted.coarse);
        decomposition.details[static_cast<std::size_t>(level)] = std::move(lifted.details);
    }
    return decomposition;
}

Result<Coefficients> synthesise(const Hierarchy& hierarchy, const Decomposition& decomposition,
                                int level, Update update) {
    const int levels = std::min(hierarchy.levels(), static_cast<int>(decomposition.details.size()));
    if (level < 0 || level > levels) return bad_level(level, levels);
    Lifted lifted{decomposition.base, {}};
    for (int l = 0; l < level; ++l) {
        lifted.details = decomposition.details[static_cast<std::size_t>(l)];
        RELIEF_TRY(lifted.coarse,
                   synthesise(hierarchy.space(l), hierarchy.step(l), lifted, update));
    }
    return std::move(lifted.coarse);
}

Result<DetailNorms> detail_norms(const Space& coarse, const Refinement& step, Update update) {
    const LevelProducts level(coarse, step);
    const Index n = coarse.mesh.vertex_count();
    const std::size_t count = step.fine.mesh.vertex_count() - n;
    DetailNorms norms{Coefficients(count), Coefficients(count, Heights{1, 1, 1})};
    if (update == Update::None) {
        for_each_index(count, [&](Index k) {
            const auto* block = level.fine_gram.find(n + k, n + k);
            for (int j = 0; j < 3; ++j) norms.l2[k][j] = std::sqrt((*block)[4 * j]);
        });
        return norms;
    }
    if (update == Update::Full) update = Update::Semi2;
    const std::size_t bad = first_failure(level.stencils(), [&](Index k) {
        const UpdateStencil stencil(level, k, update);
        if (!stencil.solvable()) return false;
        for (Index v = 0; v < stencil.new_count(); ++v)
            for (int j = 0; j < 3; ++j) {
                std::array<Heights, 2> unit{};
                unit[v][j] = 1;
                const auto details = std::span<const Heights>(unit).first(stencil.new_count());
                const std::vector<double> u = stencil.increments(details);
                const Index detail = stencil.first_new() - n + v;
                norms.l2[detail][j] = std::sqrt(std::max(stencil.squared_norm(details, u), 0.0));
                for (const double number : u) norms.bound[detail][j] += std::abs(number);
            }
        return true;
    });
    if (bad < level.stencils()) return singular(UpdateStencil(level, bad, update).vertices()[0]);
    return norms;
}

}  // namespace relief::multires::ps
