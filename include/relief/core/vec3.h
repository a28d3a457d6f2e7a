#pragma once

#include <cmath>

/// Points and vectors of space. Only operations that IEEE 754 rounds correctly are used, so results
/// are the same on every machine.
namespace relief {

template <class T>
struct Vec3 {
    T x = 0;
    T y = 0;
    T z = 0;

    friend bool operator==(const Vec3&, const Vec3&) = default;

    constexpr Vec3& operator+=(const Vec3& b) {
        x += b.x;
        y += b.y;
        z += b.z;
        return *this;
    }
    constexpr Vec3& operator-=(const Vec3& b) {
        x -= b.x;
        y -= b.y;
        z -= b.z;
        return *this;
    }
    friend constexpr Vec3 operator+(const Vec3& a, const Vec3& b) {
        return {a.x + b.x, a.y + b.y, a.z + b.z};
    }
    friend constexpr Vec3 operator-(const Vec3& a, const Vec3& b) {
        return {a.x - b.x, a.y - b.y, a.z - b.z};
    }
    friend constexpr Vec3 operator*(T s, const Vec3& a) { return {s * a.x, s * a.y, s * a.z}; }
};

template <class T>
[[nodiscard]] constexpr T dot(const Vec3<T>& a, const Vec3<T>& b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
template <class T>
[[nodiscard]] constexpr Vec3<T> cross(const Vec3<T>& a, const Vec3<T>& b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
template <class T>
[[nodiscard]] T length(const Vec3<T>& a) {
    return std::sqrt(dot(a, a));
}

}  // namespace relief
