#include "multires/ps_gradient_rules.h"

#include <Eigen/SVD>
#include <algorithm>
#include <cmath>

namespace relief::multires::ps {

namespace {

constexpr std::size_t kEnough = 9;
constexpr double kNear = 1e-6;
constexpr double kDependent = 1e-4;  ///< of singular values
constexpr Eigen::Index kUnknowns = 5;

using Rows = Eigen::Matrix<double, Eigen::Dynamic, kUnknowns>;

}  // namespace

Vec2 quadratic_gradient(const mesh::Triangulation& mesh, std::span<const double> values,
                        mesh::Index v, StencilSearch& search) {
    const auto points = search.rings(v, kEnough);
    const Vec2 centre = mesh.vertex(v);
    double squares = 0;
    for (const mesh::Index w : points) {
        const Vec2 d = mesh.vertex(w) - centre;
        squares += dot(d, d);
    }
    const double size = std::sqrt(squares / static_cast<double>(points.size()));
    const auto count = static_cast<Eigen::Index>(points.size());
    Rows rows(count, kUnknowns);
    Eigen::VectorXd data(count);
    for (Eigen::Index q = 0; q < count; ++q) {
        const mesh::Index w = points[static_cast<std::size_t>(q)];
        const Vec2 d = 1 / size * (mesh.vertex(w) - centre);
        const double weight = 1 / std::max(dot(d, d), kNear);
        rows.row(q) << d.x, d.y, 0.5 * d.x * d.x, d.x * d.y, 0.5 * d.y * d.y;
        rows.row(q) *= weight;
        data(q) = weight * (values[w] - values[v]);
    }
    if (count >= kUnknowns) {
        const Eigen::JacobiSVD<Eigen::MatrixXd> svd(rows,
                                                    Eigen::ComputeThinU | Eigen::ComputeThinV);
        const auto& sigma = svd.singularValues();
        if (sigma(kUnknowns - 1) >= kDependent * sigma(0)) {
            const Eigen::VectorXd x = svd.solve(data);
            return {x(0) / size, x(1) / size};
        }
    }
    // The plane of least norm.
    const Eigen::MatrixXd plane = rows.leftCols(2);
    const Eigen::VectorXd x =
        Eigen::JacobiSVD<Eigen::MatrixXd>(plane, Eigen::ComputeThinU | Eigen::ComputeThinV)
            .solve(data);
    return {x(0) / size, x(1) / size};
}

}  // namespace relief::multires::ps
