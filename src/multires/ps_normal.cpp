#include "multires/ps_normal.h"

#include <algorithm>

#include "relief/core/parallel.h"

namespace relief::multires::ps {

using mesh::Index;
using mesh::kNone;
using mesh::VertexStars;
using spline::Hessian;
using spline::PsElement;
using spline::PsMatrix;
using spline::PsPolynomials;

namespace {

/// Triangles whose local results are kept at a time.
constexpr Index kChunk = 8192;
constexpr std::int64_t kGrain = 64;

/// Calls local(t) for all triangles in parallel and then scatter(t, result) in their order.
template <class Result, class Local, class Scatter>
void each_triangle(Index count, Local&& local, Scatter&& scatter) {
    std::vector<Result> results(std::min(count, kChunk));
    for (Index begin = 0; begin < count; begin += kChunk) {
        const Index end = std::min(count, begin + kChunk);
        parallel_for(begin, end, kGrain, [&](std::int64_t first, std::int64_t last) {
            for (auto t = static_cast<Index>(first); t < static_cast<Index>(last); ++t)
                results[t - begin] = local(t);
        });
        for (Index t = begin; t < end; ++t) scatter(t, results[t - begin]);
    }
}

/// The corner of triangle t that lies opposite its edge e.
Index opposite(const mesh::Triangulation& mesh, Index t, Index e) {
    for (Index k = 0; k < 3; ++k)
        if (mesh.triangle_edges[t][k] == e) return mesh.triangles[t][(k + 2) % 3];
    return kNone;
}

double second_derivative(const Hessian& h, Vec2 n) {
    return n.x * n.x * h.xx + 2 * n.x * n.y * h.xy + n.y * n.y * h.yy;
}

std::array<PsPolynomials, 9> basis_polynomials(const Space& space, Index t) {
    const PsElement element = space.element(t);
    const spline::PsBasis basis = space.basis(t);
    std::array<PsPolynomials, 9> result;
    for (std::size_t i = 0; i < 9; ++i) {
        std::array<spline::TangentPlane, 3> planes{};
        planes[i / 3] = basis[i];
        result[i] = element.polynomials(planes);
    }
    return result;
}

/// The jumps of second derivatives across the lines of the split, times the lines' lengths: each a
/// functional of the coefficients around.
class Jumps {
  public:
    Jumps(const Space& space, const VertexStars& graph, NormalMatrix& matrix)
        : space_(space), graph_(graph), matrix_(matrix) {}

    void add_inside(Index t) {
        const PsElement element = space_.element(t);
        const auto basis = basis_polynomials(space_, t);
        for (int k = 0; k < 3; ++k) {
            add_spoke(t, basis, element.edge_point(k), 2 * k, 2 * k + 1);
            add_spoke(t, basis, element.corner(k), (2 * k + 5) % 6, 2 * k);
        }
    }

    void add_edge(Index e) {
        const auto& mesh = space_.mesh;
        const auto [left, right] = mesh.edge_triangles[e];
        if (left == kNone || right == kNone) return;
        const Vec2 along = mesh.edge_vector(e);
        const Vec2 normal = turned(unit(along));
        const auto basis_left = basis_polynomials(space_, left);
        const auto basis_right = basis_polynomials(space_, right);
        const std::array<Index, 4> vertices{mesh.edges[e][0], mesh.edges[e][1],
                                            opposite(mesh, left, e), opposite(mesh, right, e)};
        const double weight = space_.split.edge_weight[e];
        for (int half = 0; half < 2; ++half) {
            const double size = (half == 0 ? 1 - weight : weight) * length(along);
            std::array<Column3, 4> functional{};
            const auto add = [&](Index t, const auto& basis, double sign) {
                const int piece = half_piece(t, e, half);
                for (std::size_t i = 0; i < 9; ++i) {
                    const Index v = mesh.triangles[t][i / 3];
                    const auto place = std::find(vertices.begin(), vertices.end(), v);
                    functional[static_cast<std::size_t>(place - vertices.begin())][i % 3] +=
                        sign * second_derivative(basis[i].hessian[static_cast<std::size_t>(piece)],
                                                 normal);
                }
            };
            add(left, basis_left, 1);
            add(right, basis_right, -1);
            matrix_.add_square(graph_, vertices.data(), 4, functional.data(), size * size);
        }
    }

  private:
    /// The piece of triangle t at the lower (0) or higher (1) half of its edge.
    [[nodiscard]] int half_piece(Index t, Index e, int half) const {
        Index k = 0;
        while (space_.mesh.triangle_edges[t][k] != e) ++k;
        const bool forward = space_.mesh.runs_forward(t, k);
        return static_cast<int>(2 * k) + (forward == (half == 0) ? 0 : 1);
    }

    /// The line from Z to `end` between two pieces.
    void add_spoke(Index t, const std::array<PsPolynomials, 9>& basis, Vec2 end, int before,
                   int after) {
        const Vec2 normal = turned(unit(end));
        std::array<Column3, 3> functional{};
        for (std::size_t i = 0; i < 9; ++i)
            functional[i / 3][i % 3] =
                second_derivative(basis[i].hessian[static_cast<std::size_t>(before)], normal) -
                second_derivative(basis[i].hessian[static_cast<std::size_t>(after)], normal);
        matrix_.add_square(graph_, space_.mesh.triangles[t].data(), 3, functional.data(),
                           dot(end, end));
    }

    const Space& space_;
    const VertexStars& graph_;
    NormalMatrix& matrix_;
};

Block3& block_of(NormalMatrix& matrix, const VertexStars& graph, Index v, Index w) {
    if (v == w) return matrix.diagonal[v];
    const auto around = graph.of(v);
    const auto place = std::lower_bound(around.begin(), around.end(), w) - around.begin();
    return matrix.off_diagonal[graph.first[v] + static_cast<std::size_t>(place)];
}

}  // namespace

VertexStars coupling(const mesh::Triangulation& mesh, Energy energy) {
    VertexStars near = mesh::vertex_neighbours(mesh);
    if (energy == Energy::ThinPlate) return near;
    std::vector<std::array<Index, 2>> across;
    for (Index e = 0; e < mesh.edge_count(); ++e) {
        const auto [left, right] = mesh.edge_triangles[e];
        if (left == kNone || right == kNone) continue;
        const Index a = opposite(mesh, left, e);
        const Index b = opposite(mesh, right, e);
        if (a == b) continue;
        across.push_back({a, b});
        across.push_back({b, a});
    }
    std::sort(across.begin(), across.end());
    VertexStars all;
    all.first.push_back(0);
    auto next = across.begin();
    for (Index v = 0; v < mesh.vertex_count(); ++v) {
        const auto begin = static_cast<std::ptrdiff_t>(all.items.size());
        const auto around = near.of(v);
        all.items.insert(all.items.end(), around.begin(), around.end());
        for (; next != across.end() && (*next)[0] == v; ++next) all.items.push_back((*next)[1]);
        std::sort(all.items.begin() + begin, all.items.end());
        all.items.erase(std::unique(all.items.begin() + begin, all.items.end()), all.items.end());
        all.first.push_back(static_cast<Index>(all.items.size()));
    }
    return all;
}

void NormalMatrix::add(const VertexStars& graph, const std::array<Index, 3>& vertices,
                       const PsMatrix& matrix) {
    for (std::size_t k = 0; k < 3; ++k)
        for (std::size_t l = 0; l < 3; ++l) {
            Block3& block = block_of(*this, graph, vertices[k], vertices[l]);
            for (std::size_t i = 0; i < 3; ++i)
                for (std::size_t j = 0; j < 3; ++j)
                    block[3 * i + j] += matrix[9 * (3 * k + i) + 3 * l + j];
        }
}

void NormalMatrix::add_square(const VertexStars& graph, const Index* vertices, std::size_t count,
                              const Column3* functional, double factor) {
    for (std::size_t k = 0; k < count; ++k)
        for (std::size_t l = 0; l < count; ++l) {
            Block3& block = block_of(*this, graph, vertices[k], vertices[l]);
            for (std::size_t i = 0; i < 3; ++i)
                for (std::size_t j = 0; j < 3; ++j)
                    block[3 * i + j] += factor * functional[k][i] * functional[l][j];
        }
}

NormalMatrix combined(const NormalMatrix& a, double factor, const NormalMatrix& b) {
    NormalMatrix sum = a;
    const auto add = [&](std::vector<Block3>& to, const std::vector<Block3>& from) {
        for (std::size_t k = 0; k < to.size(); ++k)
            for (std::size_t i = 0; i < 9; ++i) to[k][i] += factor * from[k][i];
    };
    add(sum.diagonal, b.diagonal);
    add(sum.off_diagonal, b.off_diagonal);
    return sum;
}

NormalMatrix energy_matrix(const Space& space, const VertexStars& graph, Energy energy) {
    NormalMatrix matrix(graph);
    const auto& mesh = space.mesh;
    if (energy == Energy::ThinPlate) {
        each_triangle<PsMatrix>(
            mesh.triangle_count(),
            [&](Index t) { return space.element(t).thin_plate_matrix(space.basis(t)); },
            [&](Index t, const PsMatrix& local) { matrix.add(graph, mesh.triangles[t], local); });
        return matrix;
    }
    Jumps jumps(space, graph, matrix);
    for (Index t = 0; t < mesh.triangle_count(); ++t) jumps.add_inside(t);
    for (Index e = 0; e < mesh.edge_count(); ++e) jumps.add_edge(e);
    return matrix;
}

SortedSites::SortedSites(const Space& space, const DataSites& sites)
    : space_(space), weights_(sites.weights.begin(), sites.weights.end()) {
    const std::size_t count = sites.points.size();
    first_.assign(space.mesh.triangle_count() + 1, 0);
    for (const Index t : sites.triangles) ++first_[t + 1];
    for (std::size_t t = 1; t < first_.size(); ++t) first_[t] += first_[t - 1];
    point_.resize(count);
    std::vector<std::uint64_t> next(first_.begin(), first_.end() - 1);
    for (std::size_t k = 0; k < count; ++k) point_[next[sites.triangles[k]]++] = k;
    offset_.resize(count);
    piece_.resize(count);
    for (Index t = 0; t < space.mesh.triangle_count(); ++t) {
        if (first_[t] == first_[t + 1]) continue;
        const PsElement element = space.element(t);
        for (std::uint64_t k = first_[t]; k < first_[t + 1]; ++k) {
            offset_[k] = sites.points[point_[k]] - space.mesh.origin - element.centre();
            piece_[k] = static_cast<std::uint8_t>(element.piece_of(offset_[k]));
        }
    }
    total_weight_ = weights_.empty() ? static_cast<double>(count) : 0;
    for (const double w : weights_) total_weight_ += w;
}

SortedSites::BasisPolynomials SortedSites::basis_of(Index t) const {
    return basis_polynomials(space_, t);
}

std::array<double, 9> SortedSites::row(const BasisPolynomials& basis, std::size_t k) const {
    std::array<double, 9> values{};
    const Vec2 d = offset_[k];
    for (std::size_t i = 0; i < 9; ++i) {
        const Hessian& h = basis[i].hessian[piece_[k]];
        values[i] = basis[i].value + dot(basis[i].gradient, d) +
                    0.5 * (h.xx * d.x * d.x + 2 * h.xy * d.x * d.y + h.yy * d.y * d.y);
    }
    return values;
}

NormalMatrix SortedSites::normal_matrix(const VertexStars& graph) const {
    NormalMatrix matrix(graph);
    const auto local = [&](Index t) {
        PsMatrix sum{};
        if (first_[t] == first_[t + 1]) return sum;
        const BasisPolynomials basis = basis_of(t);
        for (std::uint64_t k = first_[t]; k < first_[t + 1]; ++k) {
            const std::array<double, 9> values = row(basis, k);
            const double w = weight(point_[k]);
            for (std::size_t i = 0; i < 9; ++i) {
                const double wi = w * values[i];
                for (std::size_t j = 0; j < 9; ++j) sum[9 * i + j] += wi * values[j];
            }
        }
        return sum;
    };
    each_triangle<PsMatrix>(space_.mesh.triangle_count(), local, [&](Index t, const PsMatrix& sum) {
        if (first_[t] < first_[t + 1]) matrix.add(graph, space_.mesh.triangles[t], sum);
    });
    return matrix;
}

void SortedSites::adjoint(std::span<const double> factors, std::size_t count,
                          std::span<std::vector<Column3>> out) const {
    for (std::vector<Column3>& column : out) column.assign(space_.mesh.vertex_count(), Column3{});
    using Sums = std::vector<std::array<double, 9>>;
    const auto local = [&](Index t) {
        Sums sums;
        if (first_[t] == first_[t + 1]) return sums;
        sums.assign(count, {});
        const BasisPolynomials basis = basis_of(t);
        for (std::uint64_t k = first_[t]; k < first_[t + 1]; ++k) {
            const std::array<double, 9> values = row(basis, k);
            const double* factor = factors.data() + count * point_[k];
            for (std::size_t s = 0; s < count; ++s)
                for (std::size_t i = 0; i < 9; ++i) sums[s][i] += factor[s] * values[i];
        }
        return sums;
    };
    each_triangle<Sums>(space_.mesh.triangle_count(), local, [&](Index t, const Sums& sums) {
        for (std::size_t s = 0; s < sums.size(); ++s)
            for (std::size_t i = 0; i < 9; ++i)
                out[s][space_.mesh.triangles[t][i / 3]][i % 3] += sums[s][i];
    });
}

void SortedSites::evaluate(std::span<const Heights> spline, std::span<double> out) const {
    const auto& mesh = space_.mesh;
    parallel_for(0, mesh.triangle_count(), kGrain, [&](std::int64_t begin, std::int64_t end) {
        for (auto t = static_cast<Index>(begin); t < static_cast<Index>(end); ++t) {
            if (first_[t] == first_[t + 1]) continue;
            std::array<spline::TangentPlane, 3> planes;
            for (std::size_t k = 0; k < 3; ++k) {
                const Index v = mesh.triangles[t][k];
                planes[k] = tangent_plane(space_.control[v], spline[v]);
            }
            const PsPolynomials surface = space_.element(t).polynomials(planes);
            for (std::uint64_t k = first_[t]; k < first_[t + 1]; ++k) {
                const Vec2 d = offset_[k];
                const Hessian& h = surface.hessian[piece_[k]];
                out[point_[k]] = surface.value + dot(surface.gradient, d) +
                                 0.5 * (h.xx * d.x * d.x + 2 * h.xy * d.x * d.y + h.yy * d.y * d.y);
            }
        }
    });
}

}  // namespace relief::multires::ps
