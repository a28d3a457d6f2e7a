#include "multires/ps_sites.h"

namespace relief::multires::ps {

using mesh::Index;
using spline::PsElement;
using spline::PsMatrix;
using spline::PsPolynomials;

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

std::array<double, 9> SortedSites::row(const BasisPolynomials& basis, std::size_t k) const {
    std::array<double, 9> values{};
    for (std::size_t i = 0; i < 9; ++i) values[i] = basis[i].jet(piece_[k], offset_[k]).value;
    return values;
}

BlockMatrix SortedSites::normal_matrix(const mesh::VertexStars& coupled) const {
    const auto local = [&](Index t) {
        PsMatrix sum{};
        if (first_[t] == first_[t + 1]) return sum;
        const BasisPolynomials basis = basis_polynomials(space_, t);
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
    BlockMatrix matrix(coupled);
    each_triangle<PsMatrix>(space_.mesh.triangle_count(), local, [&](Index t, const PsMatrix& sum) {
        if (first_[t] < first_[t + 1]) matrix.add(space_.mesh.triangles[t], sum);
    });
    return matrix;
}

std::vector<Coefficients> SortedSites::adjoint(std::span<const double> factors,
                                               std::size_t count) const {
    using Sums = std::vector<std::array<double, 9>>;
    const auto local = [&](Index t) {
        Sums sums;
        if (first_[t] == first_[t + 1]) return sums;
        sums.assign(count, {});
        const BasisPolynomials basis = basis_polynomials(space_, t);
        for (std::uint64_t k = first_[t]; k < first_[t + 1]; ++k) {
            const std::array<double, 9> values = row(basis, k);
            const double* factor = factors.data() + count * point_[k];
            for (std::size_t s = 0; s < count; ++s)
                for (std::size_t i = 0; i < 9; ++i) sums[s][i] += factor[s] * values[i];
        }
        return sums;
    };
    std::vector<Coefficients> out(count, Coefficients(space_.mesh.vertex_count()));
    each_triangle<Sums>(space_.mesh.triangle_count(), local, [&](Index t, const Sums& sums) {
        for (std::size_t s = 0; s < sums.size(); ++s)
            for (std::size_t i = 0; i < 9; ++i)
                out[s][space_.mesh.triangles[t][i / 3]][i % 3] += sums[s][i];
    });
    return out;
}

void SortedSites::evaluate(std::span<const Heights> spline, std::span<double> out) const {
    const TangentPlanes planes = tangent_planes(space_, spline);
    for_each_index(space_.mesh.triangle_count(), [&](Index t) {
        if (first_[t] == first_[t + 1]) return;
        const auto& v = space_.mesh.triangles[t];
        const PsPolynomials surface =
            space_.element(t).polynomials(std::array{planes[v[0]], planes[v[1]], planes[v[2]]});
        for (std::uint64_t k = first_[t]; k < first_[t + 1]; ++k)
            out[point_[k]] = surface.jet(piece_[k], offset_[k]).value;
    });
}

}  // namespace relief::multires::ps
