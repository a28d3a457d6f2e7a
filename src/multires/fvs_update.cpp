#include <algorithm>
#include <atomic>
#include <cmath>

#include "multires/fvs_functionals.h"
#include "multires/small_cholesky.h"
#include "relief/core/parallel.h"
#include "relief/multires/fvs_mesh_coding.h"

namespace relief::multires::fvs_mesh {

using mesh::Index;
using mesh::Quadrangulation;
using spline::FvsElement;

namespace {

constexpr std::int64_t kGrain = 64;

using Mass = std::array<double, 256>;

// --- one quad and its refinement
// Numbers of the refined quad: value, dx, dy of its 9 vertices (corners v_i, middles M_i, centre
// c), then the normal derivatives of its 12 edges: halves 2i and 2i + 1 of side i, and inner edge i
// from M_i to c; all sides run counter-clockwise.

constexpr int kFine = 3 * 9 + 12;
constexpr int kNew = 23;

constexpr int half_normal(int side, int half) {
    return 27 + 2 * side + half;
}
constexpr int inner_normal(int side) {
    return 35 + side;
}

/// New functionals of a quad: for side i 4i: value, 4i + 1: tangential, 4i + 2, 4i + 3: halves; 16:
/// value, dx, dy at c; 19 + i: inner edges.
constexpr int kSideColumns = 4;
constexpr int kFirstInside = 16;
constexpr int kFirstInner = 19;

using FineVector = std::array<double, kFine>;

/// Which of the 39 numbers are the 16 of child i, and their signs: (v_i, M_i, c, M_(i-1)).
struct ChildFunctionals {
    std::array<int, 16> id;
    std::array<double, 16> sign;
};
ChildFunctionals child_functionals(int i) {
    const int before = (i + 3) % 4;
    const std::array<int, 4> vertex = {i, 4 + i, 8, 4 + before};
    ChildFunctionals f;
    f.sign.fill(1);
    for (int k = 0; k < 12; ++k) f.id[k] = 3 * vertex[k / 3] + k % 3;
    f.id[12] = half_normal(i, 0);
    f.id[13] = inner_normal(i);
    f.id[14] = inner_normal(before);
    f.id[15] = half_normal(before, 1);
    f.sign[14] = -1;
    return f;
}

/// The refined numbers of the spline with the given 16.
FineVector refined(const FvsElement& element, const spline::FvsData& data) {
    FineVector fine{};
    const auto set_vertex = [&](int v, double value, Vec2 gradient) {
        fine[3 * v] = value;
        fine[3 * v + 1] = gradient.x;
        fine[3 * v + 2] = gradient.y;
    };
    const spline::FvsQuadMiddle middle = element.middle(element.ordinates(data));
    set_vertex(8, middle.value, middle.gradient);
    for (int i = 0; i < 4; ++i) {
        const int j = (i + 1) % 4;
        const Vec2 side = element.corners()[j] - element.corners()[i];
        const Vec2 along = unit(side);
        const Vec2 across = turned(along);
        const spline::FvsEdgeMiddle edge = spline::fvs_edge_middle(
            length(side), {data.value[i], data.value[j]},
            {dot(data.gradient[i], along), dot(data.gradient[j], along)},
            {dot(data.gradient[i], across), dot(data.gradient[j], across)}, data.normal[i]);
        set_vertex(i, data.value[i], data.gradient[i]);
        set_vertex(4 + i, edge.value, edge.tangential * along + data.normal[i] * across);
        fine[half_normal(i, 0)] = edge.half_normals[0];
        fine[half_normal(i, 1)] = edge.half_normals[1];
        fine[inner_normal(i)] = middle.inner_normals[i];
    }
    return fine;
}

/// The refined numbers of one new functional.
FineVector inserted(const FvsElement& element, int column) {
    FineVector fine{};
    if (column >= kFirstInner) {
        fine[inner_normal(column - kFirstInner)] = 1;
    } else if (column >= kFirstInside) {
        fine[3 * 8 + column - kFirstInside] = 1;
    } else {
        const int side = column / kSideColumns;
        const int middle = 3 * (4 + side);
        const QuadCorners& v = element.corners();
        const Vec2 along = unit(v[(side + 1) % 4] - v[side]);
        switch (column % kSideColumns) {
            case 0:
                fine[middle] = 1;
                break;
            case 1:
                fine[middle + 1] = along.x;
                fine[middle + 2] = along.y;
                break;
            default:
                fine[half_normal(side, column % kSideColumns - 2)] = 1;
        }
    }
    return fine;
}

/// Integrals over one parent quad: of coarse basis function i times new basis function j, and of
/// the squares of the latter.
struct QuadProducts {
    std::array<std::array<double, 16>, kNew> with_coarse;
    std::array<double, kNew> squares;
};

QuadProducts quad_products(const FvsElement& element, const Mass* children) {
    std::array<FineVector, kFine> mass{};
    for (int child = 0; child < 4; ++child) {
        const ChildFunctionals f = child_functionals(child);
        for (int i = 0; i < 16; ++i)
            for (int j = 0; j < 16; ++j)
                mass[f.id[i]][f.id[j]] += f.sign[i] * f.sign[j] * children[child][16 * i + j];
    }
    std::array<FineVector, 16> coarse;
    for (int i = 0; i < 16; ++i) {
        std::array<double, 16> flat{};
        flat[i] = 1;
        coarse[i] = refined(element, spline::fvs_data(flat));
    }
    const auto product = [](const FineVector& a, const FineVector& b) {
        double sum = 0;
        for (int k = 0; k < kFine; ++k) sum += a[k] * b[k];
        return sum;
    };
    QuadProducts products;
    for (int column = 0; column < kNew; ++column) {
        const FineVector fine = inserted(element, column);
        FineVector image{};
        for (int k = 0; k < kFine; ++k)
            if (fine[k] != 0)
                for (int r = 0; r < kFine; ++r) image[r] += mass[k][r] * fine[k];
        for (int i = 0; i < 16; ++i) products.with_coarse[column][i] = product(coarse[i], image);
        products.squares[column] = product(fine, image);
    }
    return products;
}

/// Which of the level's details the columns of a side are, and how they look from the quad: an edge
/// that runs against the side has its halves exchanged and its derivatives reversed.
int side_column(int side, int column, bool forward) {
    const bool half = column >= 2;
    return kSideColumns * side + (half && !forward ? 5 - column : column);
}
double side_sign(int column, bool forward) {
    return column == 0 || forward ? 1.0 : -1.0;
}

// --- one block of coarse functionals

struct Block {
    std::vector<std::size_t> ids;  ///< those of the first quad, then those of the second it lacks

    void include(const QuadFunctionals& quad) {
        for (const std::size_t id : quad.id)
            if (std::find(ids.begin(), ids.end(), id) == ids.end()) ids.push_back(id);
    }
    [[nodiscard]] std::size_t position(std::size_t id) const {
        return static_cast<std::size_t>(std::find(ids.begin(), ids.end(), id) - ids.begin());
    }
};

}  // namespace

/// Makes the columns of one level.
class UpdateBuilder {
  public:
    UpdateBuilder(const Quadrangulation& parent, const std::vector<Mass>& parent_mass,
                  const std::vector<Mass>& child_mass)
        : parent_(parent), parent_mass_(parent_mass), at_(mesh::vertex_quads(parent)) {
        products_.resize(parent.quad_count());
        parallel_for(0, static_cast<std::int64_t>(parent.quad_count()), kGrain,
                     [&](std::int64_t first, std::int64_t last) {
                         for (std::int64_t q = first; q < last; ++q)
                             products_[q] =
                                 quad_products(FvsElement(parent.corners(static_cast<Index>(q))),
                                               &child_mass[4 * q]);
                     });
    }

    Result<Update::Level> build(Details<double>& weights) {
        Update::Level level;
        level.quad_columns.resize(parent_.quad_count());
        level.edge_columns.resize(parent_.edge_count());
        level.edge_quads = mesh::edge_quads(parent_);
        weights = make_details<double>(parent_);
        std::atomic<bool> singular = false;
        parallel_for(0, static_cast<std::int64_t>(parent_.quad_count()), kGrain,
                     [&](std::int64_t first, std::int64_t last) {
                         for (std::int64_t q = first; q < last; ++q)
                             if (!quad_columns(static_cast<Index>(q), level, weights))
                                 singular = true;
                     });
        parallel_for(0, static_cast<std::int64_t>(parent_.edge_count()), kGrain,
                     [&](std::int64_t first, std::int64_t last) {
                         for (std::int64_t e = first; e < last; ++e)
                             if (!edge_columns(static_cast<Index>(e), level, weights))
                                 singular = true;
                     });
        if (!singular) return level;
        return bad_data(
            "degenerate_quad: a quad is so thin that its mass matrix is singular; see "
            "the warnings of the mesh and improve its smallest angle");
    }

  private:
    bool quad_columns(Index q, Update::Level& level, Details<double>& weights) const {
        Block block;
        const QuadFunctionals own = quad_functionals(parent_, q);
        block.include(own);
        const auto factor = factored(block, {&parent_.quads[q], 1});
        if (!factor) return false;
        double* const targets[7] = {&weights.centre_value[q],
                                    &weights.centre_dx[q],
                                    &weights.centre_dy[q],
                                    &weights.normal[inner_edge(q, 0)],
                                    &weights.normal[inner_edge(q, 1)],
                                    &weights.normal[inner_edge(q, 2)],
                                    &weights.normal[inner_edge(q, 3)]};
        for (int column = 0; column < 7; ++column) {
            const QuadProducts& products = products_[q];
            std::array<double, 16> right;
            for (int i = 0; i < 16; ++i)
                right[i] = own.sign[i] * products.with_coarse[kFirstInside + column][i];
            double* u = &level.quad_columns[q][16 * column];
            *targets[column] =
                solve(*factor, products.squares[kFirstInside + column], right.data(), 16, u);
        }
        return true;
    }

    bool edge_columns(Index e, Update::Level& level, Details<double>& weights) const {
        Block block;
        std::vector<std::array<Index, 4>> corners;
        for (const Index q : level.edge_quads[e]) {
            if (q == mesh::kNoQuad) continue;
            block.include(quad_functionals(parent_, q));
            corners.push_back(parent_.quads[q]);
        }
        const auto factor = factored(block, corners);
        if (!factor) return false;
        double* const targets[4] = {&weights.edge_value[e], &weights.edge_tangential[e],
                                    &weights.normal[2 * e], &weights.normal[2 * e + 1]};
        for (int column = 0; column < 4; ++column) {
            std::array<double, 25> right{};
            double square = 0;
            for (const Index q : level.edge_quads[e])
                if (q != mesh::kNoQuad) square += add_products(e, q, column, block, right);
            *targets[column] = solve(*factor, square, right.data(), block.ids.size(),
                                     &level.edge_columns[e][25 * column]);
        }
        return true;
    }

    /// Adds what quad q contributes to the right-hand side of a column of edge e; returns its part
    /// of the square.
    double add_products(Index e, Index q, int column, const Block& block,
                        std::array<double, 25>& right) const {
        const auto& edges = parent_.quad_edges[q];
        const auto side =
            static_cast<int>(std::find(edges.begin(), edges.end(), e) - edges.begin());
        const bool forward = parent_.quad_signs[q][side] > 0;
        const int local = side_column(side, column, forward);
        const QuadFunctionals own = quad_functionals(parent_, q);
        for (int i = 0; i < 16; ++i)
            right[block.position(own.id[i])] +=
                side_sign(column, forward) * own.sign[i] * products_[q].with_coarse[local][i];
        return products_[q].squares[local];
    }

    /// The columns u of the projection, and the norm of what it leaves: |E|^2 - u . right.
    static double solve(const SmallCholesky& factor, double square, const double* right,
                        std::size_t n, double* u) {
        std::copy_n(right, n, u);
        factor.solve(u);
        double projected = 0;
        for (std::size_t i = 0; i < n; ++i) projected += u[i] * right[i];
        return std::sqrt(std::max(square - projected, 0.0));
    }

    /// The mass matrix of the whole level, restricted to the block, of which `quads` lists the
    /// corners.
    [[nodiscard]] std::optional<SmallCholesky> factored(
        const Block& block, std::span<const std::array<Index, 4>> quads) const {
        std::vector<Index> around;
        for (const auto& corners : quads)
            for (const Index v : corners)
                around.insert(around.end(), at_.of(v).begin(), at_.of(v).end());
        std::sort(around.begin(), around.end());
        around.erase(std::unique(around.begin(), around.end()), around.end());
        const std::size_t n = block.ids.size();
        std::vector<double> mass(n * n);
        for (const Index q : around) {
            const QuadFunctionals f = quad_functionals(parent_, q);
            std::array<std::size_t, 16> at;
            for (int i = 0; i < 16; ++i) at[i] = block.position(f.id[i]);
            for (int i = 0; i < 16; ++i)
                for (int j = 0; j < 16; ++j)
                    if (at[i] < n && at[j] < n)
                        mass[n * at[i] + at[j]] +=
                            f.sign[i] * f.sign[j] * parent_mass_[q][16 * i + j];
        }
        return SmallCholesky::factor(std::move(mass), n, 0);
    }

    [[nodiscard]] std::size_t inner_edge(Index q, int i) const {
        return 2 * std::size_t{parent_.edge_count()} + 4 * std::size_t{q} + i;
    }

    const Quadrangulation& parent_;
    const std::vector<Mass>& parent_mass_;
    mesh::VertexQuads at_;
    std::vector<QuadProducts> products_;
};

namespace {

std::vector<Mass> masses(const Quadrangulation& mesh) {
    std::vector<Mass> list(mesh.quad_count());
    parallel_for(0, static_cast<std::int64_t>(mesh.quad_count()), kGrain,
                 [&](std::int64_t first, std::int64_t last) {
                     for (std::int64_t q = first; q < last; ++q)
                         list[q] = FvsElement(mesh.corners(static_cast<Index>(q))).mass_matrix();
                 });
    return list;
}

}  // namespace

Result<Update> Update::create(const Hierarchy& hierarchy) {
    Update update;
    update.weights_.resize(static_cast<std::size_t>(hierarchy.levels()));
    std::vector<Mass> parent_mass = masses(hierarchy.mesh(0));
    for (int m = 1; m <= hierarchy.levels(); ++m) {
        std::vector<Mass> child_mass = masses(hierarchy.mesh(m));
        UpdateBuilder builder(hierarchy.mesh(m - 1), parent_mass, child_mass);
        RELIEF_TRY(Level level, builder.build(update.weights_[m - 1]));
        update.levels_.push_back(std::move(level));
        parent_mass = std::move(child_mass);
    }
    return update;
}

void Update::apply(const Quadrangulation& parent, int level, const Details<double>& details,
                   double sign, NodalData& low) const {
    const Level& columns = levels_[level - 1];
    std::vector<double> sum = flat(low);
    for (Index q = 0; q < parent.quad_count(); ++q) {
        const QuadFunctionals own = quad_functionals(parent, q);
        const std::size_t inner = 2 * std::size_t{parent.edge_count()} + 4 * std::size_t{q};
        const double amounts[7] = {details.centre_value[q],   details.centre_dx[q],
                                   details.centre_dy[q],      details.normal[inner],
                                   details.normal[inner + 1], details.normal[inner + 2],
                                   details.normal[inner + 3]};
        for (int column = 0; column < 7; ++column)
            for (int i = 0; i < 16; ++i)
                sum[own.id[i]] += sign * amounts[column] * columns.quad_columns[q][16 * column + i];
    }
    for (Index e = 0; e < parent.edge_count(); ++e) {
        Block block;
        for (const Index q : columns.edge_quads[e])
            if (q != mesh::kNoQuad) block.include(quad_functionals(parent, q));
        const double amounts[4] = {details.edge_value[e], details.edge_tangential[e],
                                   details.normal[2 * e], details.normal[2 * e + 1]};
        for (int column = 0; column < 4; ++column)
            for (std::size_t i = 0; i < block.ids.size(); ++i)
                sum[block.ids[i]] +=
                    sign * amounts[column] * columns.edge_columns[e][25 * column + i];
    }
    low = nodal(parent, sum);
}

Result<Decomposition> decompose_lifted(const Hierarchy& hierarchy, const Update& update,
                                       NodalData finest) {
    RELIEF_CHECK(check(hierarchy.mesh(hierarchy.levels()), finest));
    Decomposition out;
    out.details.resize(static_cast<std::size_t>(hierarchy.levels()));
    NodalData fine = std::move(finest);
    for (int m = hierarchy.levels(); m > 0; --m) {
        const Quadrangulation& parent = hierarchy.mesh(m - 1);
        NodalData low = restrict_to(parent, fine);
        out.details[m - 1] = extract(parent, fine, predict(parent, low));
        update.apply(parent, m, out.details[m - 1], 1, low);
        fine = std::move(low);
    }
    out.base = std::move(fine);
    return out;
}

Result<NodalData> reconstruct_lifted(const Hierarchy& hierarchy, const Update& update,
                                     const Decomposition& coefficients, int level) {
    RELIEF_CHECK(check_sizes(hierarchy, coefficients.base, coefficients.details, level));
    NodalData data = coefficients.base;
    for (int m = 1; m <= level; ++m) {
        const Quadrangulation& parent = hierarchy.mesh(m - 1);
        update.apply(parent, m, coefficients.details[m - 1], -1, data);
        data = predict(parent, data);
        insert(parent, coefficients.details[m - 1], data);
    }
    RELIEF_CHECK(check(hierarchy.mesh(level), data));
    return data;
}

std::vector<Details<double>> lifted_limits(const Update& update, double epsilon) {
    std::vector<Details<double>> limits = update.weights();
    for (Details<double>& level : limits)
        for_each_detail(
            [epsilon](std::vector<double>& numbers) {
                for (double& number : numbers) number = epsilon / number;
            },
            level);
    return limits;
}

}  // namespace relief::multires::fvs_mesh
