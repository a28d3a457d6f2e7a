#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "relief/core/result.h"

/// Piecewise quadratic surfaces for ParaView and other programs that are built on VTK.
namespace relief::io {

/// Numbers at each control point.
struct VtkField {
    std::string name;
    int components = 1;
    std::span<const double> values;  ///< `components` a point; not a number: nothing there
};

/// Triangles as quadratic Bezier nets in space. A cell names the control points of the corners 0,
/// 1, 2 and of the sides 0-1, 1-2, 2-0: 200, 020, 002, 110, 011, 101. Fields are nets too.
struct BezierTriangles {
    std::span<const std::array<double, 3>> points;
    std::span<const std::array<std::uint32_t, 6>> cells;
    std::vector<VtkField> fields = {};
};

/// Writes a VTK XML file of an unstructured grid (.vtu) with cells of type 76,
/// VTK_BEZIER_TRIANGLE, which VTK draws from version 9 on; numbers are appended as raw bytes. The
/// file appears when it is complete. Errors: InvalidArgument (a field of another size, or without
/// components); BadInput `non_finite_vertex`, `index_out_of_range`; CannotWrite. Complexity:
/// O(size), memory for one megabyte of the file.
[[nodiscard]] Status write_vtu(const std::string& path, const BezierTriangles& triangles);

}  // namespace relief::io
