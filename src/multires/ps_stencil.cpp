#include "multires/ps_stencil.h"

#include <algorithm>
#include <cmath>

#include "multires/ps_errors.h"

namespace relief::multires::ps {

using mesh::Index;
using mesh::kNone;

namespace {

constexpr double kSmallestPivot = 1e-13;

/// The corners of a triangle; or the ends of an edge and the corners opposite it.
std::vector<Index> nearest_vertices(const mesh::Triangulation& mesh, std::size_t stencil) {
    if (stencil < mesh.triangles.size())
        return {mesh.triangles[stencil].begin(), mesh.triangles[stencil].end()};
    const auto e = static_cast<Index>(stencil - mesh.triangles.size());
    std::vector<Index> vertices(mesh.edges[e].begin(), mesh.edges[e].end());
    for (const Index t : mesh.edge_triangles[e]) {
        if (t == kNone) continue;
        for (const Index v : mesh.triangles[t])
            if (v != mesh.edges[e][0] && v != mesh.edges[e][1]) vertices.push_back(v);
    }
    return vertices;
}

void sort_unique(std::vector<Index>& vertices) {
    std::sort(vertices.begin(), vertices.end());
    vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
}

std::vector<StepRows> all_rows(const Space& coarse, const Refinement& step) {
    std::vector<StepRows> rows(step.fine.mesh.vertex_count());
    for_each_index(rows.size(), [&](Index v) { rows[v] = step_rows(coarse, step, v); });
    return rows;
}

}  // namespace

LevelProducts::LevelProducts(const Space& coarse_space, const Refinement& refinement)
    : coarse(coarse_space),
      step(refinement),
      coarse_gram(gram_matrix(coarse)),
      fine_gram(gram_matrix(step.fine)),
      coarse_moments(moments(coarse, coarse_gram)),
      fine_moments(moments(step.fine, fine_gram)),
      rows(all_rows(coarse, step)),
      neighbours(mesh::vertex_neighbours(coarse.mesh)) {}

UpdateStencil::UpdateStencil(const LevelProducts& level, std::size_t stencil, Update update)
    : level_(level) {
    const mesh::Triangulation& mesh = level.coarse.mesh;
    const std::size_t triangles = mesh.triangles.size();
    const bool inside = stencil < triangles;
    first_new_ = static_cast<Index>(mesh.vertex_count() +
                                    (inside ? stencil : triangles + 2 * (stencil - triangles)));
    new_count_ = inside ? 1 : 2;
    vertices_ = nearest_vertices(mesh, stencil);
    if (update == Update::Semi2 || update == Update::Semi2Moments) {
        const std::vector<Index> inner = vertices_;
        for (const Index v : inner) {
            const auto ring = level.neighbours.of(v);
            vertices_.insert(vertices_.end(), ring.begin(), ring.end());
        }
    }
    sort_unique(vertices_);
    build_gram();
    if (update != Update::Moments) {
        system_ = SmallCholesky::factor(gram_, 3 * vertices_.size(), kSmallestPivot);
        solvable_ = system_.has_value();
    }
    if (solvable_ && (update == Update::Moments || update == Update::Semi2Moments)) build_moments();
}

void UpdateStencil::build_gram() {
    const std::size_t size = 3 * vertices_.size();
    gram_.assign(size * size, 0);
    const BlockMatrix& gram = level_.coarse_gram;
    for (std::size_t i = 0; i < vertices_.size(); ++i)
        for (std::size_t at = gram.first[vertices_[i]]; at < gram.first[vertices_[i] + 1]; ++at) {
            const auto found =
                std::lower_bound(vertices_.begin(), vertices_.end(), gram.column[at]);
            if (found == vertices_.end() || *found != gram.column[at]) continue;
            const auto k = static_cast<std::size_t>(found - vertices_.begin());
            for (std::size_t j = 0; j < 3; ++j)
                for (std::size_t l = 0; l < 3; ++l)
                    gram_[(3 * i + j) * size + 3 * k + l] = gram.block[at][3 * j + l];
        }
}

/// Moments about the middle of the stencil, in units of its size, so that the system of three is
/// well scaled.
std::array<double, 3> UpdateStencil::scaled(const Moments& moments, Vec2 vertex) const {
    const Vec2 way = vertex - centre_;
    return {moments.mass, (moments.first.x + moments.mass * way.x) / size_,
            (moments.first.y + moments.mass * way.y) / size_};
}

void UpdateStencil::build_moments() {
    const mesh::Triangulation& mesh = level_.coarse.mesh;
    for (const Index v : vertices_) centre_ = centre_ + mesh.vertex(v);
    centre_ = (1.0 / static_cast<double>(vertices_.size())) * centre_;
    size_ = 0;
    for (const Index v : vertices_) size_ = std::max(size_, length(mesh.vertex(v) - centre_));
    for (const Index v : vertices_)
        for (const Moments& function : level_.coarse_moments[v])
            moment_.push_back(scaled(function, mesh.vertex(v)));

    // Y = W^-1 M^T, W the Gram matrix, or the functions' integrals for Moments.
    correction_ = moment_;
    if (system_) {
        system_->solve<3>(correction_[0].data());
    } else {
        for (std::array<double, 3>& row : correction_) {
            const double mass = row[0];
            for (double& number : row) number /= mass;
        }
    }
    std::vector<double> square(9);  // M Y
    for (int m = 0; m < 3; ++m)
        for (int n = 0; n < 3; ++n)
            for (std::size_t k = 0; k < moment_.size(); ++k)
                square[3 * m + n] += moment_[k][m] * correction_[k][n];
    moment_system_ = SmallCholesky::factor(std::move(square), 3, kSmallestPivot);
    solvable_ = moment_system_.has_value();
}

/// L2 products of the coarse functions with the spline of these details.
std::vector<double> UpdateStencil::products(std::span<const Heights> details) const {
    std::vector<double> sum(3 * vertices_.size());
    const BlockMatrix& gram = level_.fine_gram;
    for (Index n = 0; n < new_count_; ++n) {
        const Index v = first_new_ + n;
        for (std::size_t at = gram.first[v]; at < gram.first[v + 1]; ++at) {
            Heights product{};
            for (int j = 0; j < 3; ++j)
                for (int l = 0; l < 3; ++l) product[j] += gram.block[at][3 * l + j] * details[n][l];
            const StepRows& rows = level_.rows[gram.column[at]];
            for (int k = 0; k < rows.count; ++k) {
                const auto found =
                    std::lower_bound(vertices_.begin(), vertices_.end(), rows.vertex[k]);
                if (found == vertices_.end() || *found != rows.vertex[k]) continue;
                double* to = sum.data() + 3 * (found - vertices_.begin());
                for (int j = 0; j < 3; ++j)
                    for (int l = 0; l < 3; ++l) to[l] += rows.block[k][j][l] * product[j];
            }
        }
    }
    return sum;
}

/// The moments of the details' spline, less those of the coarse spline u.
std::array<double, 3> UpdateStencil::missing_moments(std::span<const Heights> details,
                                                     const std::vector<double>& u) const {
    std::array<double, 3> missing{};
    for (Index n = 0; n < new_count_; ++n) {
        const Index v = first_new_ + n;
        for (int j = 0; j < 3; ++j) {
            const auto moment = scaled(level_.fine_moments[v][j], level_.step.fine.mesh.vertex(v));
            for (int m = 0; m < 3; ++m) missing[m] += moment[m] * details[n][j];
        }
    }
    for (std::size_t k = 0; k < u.size(); ++k)
        for (int m = 0; m < 3; ++m) missing[m] -= moment_[k][m] * u[k];
    return missing;
}

std::vector<double> UpdateStencil::increments(std::span<const Heights> details) const {
    std::vector<double> u(3 * vertices_.size());
    if (system_) {
        u = products(details);
        system_->solve(u.data());
    }
    if (moment_system_) {
        std::array<double, 3> missing = missing_moments(details, u);
        moment_system_->solve(missing.data());
        for (std::size_t k = 0; k < u.size(); ++k)
            for (int m = 0; m < 3; ++m) u[k] += correction_[k][m] * missing[m];
    }
    return u;
}

double UpdateStencil::squared_norm(std::span<const Heights> details,
                                   const std::vector<double>& u) const {
    double square = 0;
    for (Index n = 0; n < new_count_; ++n)
        for (Index m = 0; m < new_count_; ++m) {
            const auto* block = level_.fine_gram.find(first_new_ + n, first_new_ + m);
            if (block == nullptr) continue;
            for (int j = 0; j < 3; ++j)
                for (int l = 0; l < 3; ++l)
                    square += details[n][j] * (*block)[3 * j + l] * details[m][l];
        }
    const std::vector<double> product = products(details);
    for (std::size_t i = 0; i < u.size(); ++i) {
        double image = 0;
        for (std::size_t k = 0; k < u.size(); ++k) image += gram_[i * u.size() + k] * u[k];
        square += u[i] * (image - 2 * product[i]);
    }
    return square;
}

}  // namespace relief::multires::ps
