#pragma once

#include <array>
#include <cstdint>

/// Row kernels of the lifting steps. Like those of relief/core/rows.h they have a scalar twin that
/// gives the same bytes. `out` may be the row it starts from and must not overlap the others. No
/// alignment is required.
namespace relief::multires::box {

/// out[j] = centre * vertices[j] + ring * (((r0 + r1) + (r2 + r3)) + (r4 + r5)), r = around[.][j].
template <class T>
void step_row(T centre, T ring, const T* vertices, const std::array<const T*, 6>& around,
              std::int64_t n, T* out);

/// out[j] = edges[j] + (ends * (v0 + v1) + opposite * (v2 + v3)), v = vertices[.][j].
template <class T>
void predict_row(T ends, T opposite, const T* edges, const std::array<const T*, 4>& vertices,
                 std::int64_t n, T* out);

/// out[j] = edges[j] + ends * (begin[j] + end[j]).
template <class T>
void predict_row_from_ends(T ends, const T* edges, const T* begin, const T* end, std::int64_t n,
                           T* out);

}  // namespace relief::multires::box
