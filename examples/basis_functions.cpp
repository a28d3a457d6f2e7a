// Writes the basis functions of one level, four in a row, each divided by its largest magnitude:
// the scaling function, then the wavelets. Each is seen REACH lattice steps to all sides of its
// middle. usage: basis_functions SCHEME ORDER REACH OUT.tif
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>

#include "relief/io/raster.h"
#include "relief/multires/scheme.h"
#include "relief/spline/box_surface.h"

using namespace relief;

constexpr int kSide = 33;  // samples of the lattice, the middle one being 16
constexpr int kTile = 129;

Result<Grid<double>> basis_function(const multires::PyramidLayout& layout, std::size_t band,
                                    double reach) {
    multires::Pyramid<double> pyramid{layout, {}};
    for (const auto& other : layout.bands)
        pyramid.bands.emplace_back().emplace_back(other.box.rows, other.box.cols, 0.0);
    const LatticeBox& box = layout.bands[band].box;
    pyramid.bands[band][0](8 - box.row0, 8 - box.col0) = 1;
    const auto net = multires::coefficients(pyramid);
    RELIEF_TRY(const auto surface,
               spline::BoxSurface<double>::create(net.planes[0].view(), layout.spec.order));
    Grid<double> tile(kTile, kTile);
    const double step = 2 * reach / (kTile - 1);
    surface.evaluate_grid(16 - reach, step, 16 - reach, step, tile.view());
    return tile;
}

Status run(const char* scheme, int order, double reach, const char* path) {
    RELIEF_TRY(const auto id, multires::scheme_from_name(scheme));
    RELIEF_TRY(const auto layout,
               multires::layout({.id = id, .order = order, .levels = 1}, kSide, kSide, 1));
    Raster all;
    all.rows = kTile * (static_cast<std::int64_t>(layout.bands.size()) / 4);
    all.cols = kTile * 4;
    all.planes.emplace_back(all.rows, all.cols);
    for (std::size_t k = 0; k < layout.bands.size(); ++k) {
        RELIEF_TRY(const Grid<double> tile, basis_function(layout, k, reach));
        double most = 0;
        for (int r = 0; r < kTile; ++r)
            for (int c = 0; c < kTile; ++c) most = std::max(most, std::abs(tile(r, c)));
        double* corner = all.planes[0].row(kTile * int(k / 4)) + kTile * (k % 4);
        for (int r = 0; r < kTile; ++r)
            for (int c = 0; c < kTile; ++c)
                corner[r * all.planes[0].stride() + c] = tile(r, c) / most;
    }
    return io::write_raster(path, all);
}

int main(int argc, char** argv) {
    if (argc != 5) return 2;
    const Status done = run(argv[1], std::atoi(argv[2]), std::atof(argv[3]), argv[4]);
    if (!done.ok()) std::fprintf(stderr, "basis_functions: %s\n", done.error().text().c_str());
    return done.ok() ? 0 : 1;
}
