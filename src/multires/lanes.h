#pragma once

#include <cstring>

#include "relief/core/vec3.h"

namespace relief::multires {

/// A point in the first three of four lanes, so that the vector units that all machines have work
/// on it as a whole. Each lane is rounded as a scalar is: results are those of Vec3.
template <class T>
struct Lanes {
    typedef T Vector __attribute__((vector_size(4 * sizeof(T))));
    Vector v;

    /// Reads a fourth scalar behind the point.
    static void load(const Vec3<T>* from, Lanes& to) { std::memcpy(&to.v, from, sizeof to.v); }
    /// The same where there may be none.
    static void load_last(const Vec3<T>* from, Lanes& to) {
        to.v = Vector{from->x, from->y, from->z, 0};
    }
    void store(Vec3<T>* to) const { std::memcpy(static_cast<void*>(to), &v, sizeof *to); }
};

}  // namespace relief::multires
