#pragma once

#include <cstddef>
#include <cstring>

#include "relief/core/vec3.h"

namespace relief::multires {

/// A point in the first three of four lanes, for the vector registers of 16 bytes that all machines
/// have. Lanes are rounded as scalars are.
template <class T>
struct Lanes {
    typedef T Register __attribute__((vector_size(16)));
    static constexpr std::size_t kEach = sizeof(Register) / sizeof(T);
    static constexpr std::size_t kRegisters = 4 / kEach;
    Register part[kRegisters];

    /// Reads a fourth scalar behind the point.
    static Lanes load(const Vec3<T>* from) { return load(&from->x); }
    /// The same where there may be none.
    static Lanes load_last(const Vec3<T>* from) {
        if constexpr (kRegisters == 1)
            return {{Register{from->x, from->y, from->z, 0}}};
        else
            return {{Register{from->x, from->y}, Register{from->z, 0}}};
    }
    static Lanes load(const T* from) {
        Lanes to;
        for (std::size_t k = 0; k < kRegisters; ++k)
            std::memcpy(&to.part[k], from + k * kEach, sizeof(Register));
        return to;
    }
    void store(Vec3<T>* to) const {
        std::memcpy(static_cast<void*>(to), &part[0], 2 * sizeof(T));
        to->z = part[2 / kEach][2 % kEach];
    }
    void store(T* to) const {
        for (std::size_t k = 0; k < kRegisters; ++k)
            std::memcpy(to + k * kEach, &part[k], sizeof(Register));
    }

    friend Lanes operator+(Lanes a, const Lanes& b) {
        for (std::size_t k = 0; k < kRegisters; ++k) a.part[k] += b.part[k];
        return a;
    }
    friend Lanes operator*(T s, Lanes a) {
        for (std::size_t k = 0; k < kRegisters; ++k) a.part[k] *= s;
        return a;
    }
};

}  // namespace relief::multires
