#pragma once

#include <cmath>
#include <limits>
#include <vector>

#include "relief/core/vec3.h"

namespace relief::multires {

/// Solves A x = b for the three coordinates at once, from x = 0: for a singular A with b in its
/// range, the smallest solution. product(x, y): y = A x, A symmetric, not negative. Ends when
/// residuals are `tolerance` times b, or get no smaller. All sums are in the order of elements.
template <class T, class Product>
std::vector<Vec3<T>> conjugate_gradient(const std::vector<Vec3<T>>& b, Product product,
                                        double tolerance = 1e-15) {
    const auto squares = [](const std::vector<Vec3<T>>& u, const std::vector<Vec3<T>>& v) {
        Vec3<double> sum;
        for (std::size_t k = 0; k < u.size(); ++k)
            sum += Vec3<double>{double{u[k].x} * v[k].x, double{u[k].y} * v[k].y,
                                double{u[k].z} * v[k].z};
        return sum;
    };
    const auto ratio = [](const Vec3<double>& a, const Vec3<double>& c) {
        const auto divide = [](double p, double q) { return q > 0 ? p / q : 0; };
        return Vec3<double>{divide(a.x, c.x), divide(a.y, c.y), divide(a.z, c.z)};
    };
    const auto scaled = [](const Vec3<double>& s, const Vec3<T>& v) {
        return Vec3<T>{static_cast<T>(s.x * v.x), static_cast<T>(s.y * v.y),
                       static_cast<T>(s.z * v.z)};
    };
    std::vector<Vec3<T>> x(b.size());
    std::vector<Vec3<T>> residual = b;
    std::vector<Vec3<T>> direction = b;
    std::vector<Vec3<T>> image(b.size());
    Vec3<double> square = squares(residual, residual);
    const auto size = [](const Vec3<double>& v) { return v.x + v.y + v.z; };
    const double small = size(square) * tolerance * tolerance + std::numeric_limits<double>::min();
    const std::size_t most = 8 * static_cast<std::size_t>(std::sqrt(double(b.size()))) + 400;
    for (std::size_t step = 0; step < most && size(square) > small; ++step) {
        product(direction, image);
        const Vec3<double> length = ratio(square, squares(direction, image));
        for (std::size_t k = 0; k < b.size(); ++k) {
            x[k] += scaled(length, direction[k]);
            residual[k] -= scaled(length, image[k]);
        }
        const Vec3<double> next = squares(residual, residual);
        const Vec3<double> turn = ratio(next, square);
        for (std::size_t k = 0; k < b.size(); ++k)
            direction[k] = residual[k] + scaled(turn, direction[k]);
        square = next;
    }
    return x;
}

}  // namespace relief::multires
