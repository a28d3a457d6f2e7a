#pragma once

#include <array>
#include <vector>

#include "relief/core/result.h"
#include "relief/multires/pyramid.h"

/// The one table of scheme `barycentric`: its 1D sequences. Analysis correlates, synthesis
/// convolves:
///   s(x) = sum a(n) c(2x + n),  d(x) = sum b(n) c(2x + n),  c(y) = sum_x p(y - 2x) s(x) + q(y -
///   2x) d(x).
/// The specification's section 2 gives the derivations; sums: p 2, a 1 (after division by D).
namespace relief::multires {

/// taps[k] belongs to n = first + k.
struct Sequence {
    int first = 0;
    std::vector<double> taps;

    [[nodiscard]] int last() const { return first + static_cast<int>(taps.size()) - 1; }
    [[nodiscard]] double operator()(int n) const {
        return n < first || n > last() ? 0.0 : taps[static_cast<std::size_t>(n - first)];
    }
};

/// a and b are the analysis filters if `poles` is empty; otherwise a / D(z^2), b / D(z^2) are, with
/// D(z) = gain * product over poles of (1 - pole z)(1 - pole / z).
struct FilterBank {
    Sequence a, b, p, q;
    std::vector<double> poles;
    double gain = 1;
    int margin = 0;  ///< coarse steps until the slowest pole has decayed below 1e-16
};

/// Spline orders d = 1 .. 4. Compact pairs (d, dual) offered: (1,1) (1,3) (1,5) (2,2) (2,4) (3,1)
/// (3,3) (4,2) (4,4); dual 0 means d. The truncated families have order 2 only. Errors:
/// InvalidArgument naming what exists.
[[nodiscard]] Result<FilterBank> filter_bank(int order, Family family, int dual_order);

/// Which of the two sequences acts along e1, e2, e3 in channel 0 (aaa) .. 7 (bbb); true: b or q.
/// Channels are numbered aaa, aab, aba, baa, abb, bab, bba, bbb: the paper's 0 .. 7.
[[nodiscard]] std::array<bool, 3> channel_letters(int channel);
[[nodiscard]] const char* channel_name(int channel);

/// A kernel on the hexagonal lattice: taps[i - box.row0][j - box.col0].
struct HexKernel {
    LatticeBox box;
    std::vector<double> taps;

    [[nodiscard]] double operator()(int i, int j) const {
        return box.contains(i, j)
                   ? taps[static_cast<std::size_t>((i - box.row0) * box.cols + j - box.col0)]
                   : 0.0;
    }
};

/// scale * sum over all l of f(i + l) g(j + l) h(l): the projection of a tensor product along
/// (1,1,1).
[[nodiscard]] HexKernel project(const Sequence& f, const Sequence& g, const Sequence& h,
                                double scale);

/// Analysis kernel of a channel (numerators, where the bank has poles) and synthesis kernel (all
/// shifts, times 1/2).
[[nodiscard]] HexKernel analysis_kernel(const FilterBank& bank, int channel);
[[nodiscard]] HexKernel synthesis_kernel(const FilterBank& bank, int channel);

}  // namespace relief::multires
