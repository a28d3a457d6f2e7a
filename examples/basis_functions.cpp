// Writes the basis functions of one level side by side, each divided by its largest value: the
// scaling function, then the wavelets. usage: basis_functions SCHEME ORDER OUT.tif
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>

#include "relief/io/raster.h"
#include "relief/multires/scheme.h"
#include "relief/spline/box_surface.h"

using namespace relief;

constexpr int kSide = 25;                 // samples of the lattice
constexpr int kTile = 8 * kSide - 7;      // eight points a lattice step
constexpr int kMiddle = (kSide - 1) / 4;  // in steps of the coarser level

Result<Grid<double>> basis_function(const multires::PyramidLayout& layout, std::size_t band) {
    multires::Pyramid<double> pyramid{layout, {}};
    for (const auto& other : layout.bands)
        pyramid.bands.emplace_back().emplace_back(other.box.rows, other.box.cols, 0.0);
    const LatticeBox& box = layout.bands[band].box;
    pyramid.bands[band][0](kMiddle - box.row0, kMiddle - box.col0) = 1;
    const auto net = multires::coefficients(pyramid);
    RELIEF_TRY(const auto surface,
               spline::BoxSurface<double>::create(net.planes[0].view(), layout.spec.order));
    Grid<double> tile(kTile, kTile);
    surface.evaluate_grid(0, 0.125, 0, 0.125, tile.view());
    return tile;
}

Status run(const char* scheme, int order, const char* path) {
    RELIEF_TRY(const auto id, multires::scheme_from_name(scheme));
    RELIEF_TRY(const auto layout,
               multires::layout({.id = id, .order = order, .levels = 1}, kSide, kSide, 1));
    const auto count = static_cast<std::int64_t>(layout.bands.size());
    Raster all;
    all.rows = kTile;
    all.cols = kTile * count;
    all.planes.emplace_back(all.rows, all.cols);
    for (std::int64_t k = 0; k < count; ++k) {
        RELIEF_TRY(const Grid<double> tile, basis_function(layout, static_cast<std::size_t>(k)));
        double largest = 0;
        for (int r = 0; r < kTile; ++r)
            for (int c = 0; c < kTile; ++c) largest = std::max(largest, std::abs(tile(r, c)));
        for (int r = 0; r < kTile; ++r)
            for (int c = 0; c < kTile; ++c) all.planes[0](r, k * kTile + c) = tile(r, c) / largest;
    }
    return io::write_raster(path, all);
}

int main(int argc, char** argv) {
    if (argc != 4) return std::fputs("usage: basis_functions SCHEME ORDER OUT.tif\n", stderr), 2;
    const Status done = run(argv[1], std::atoi(argv[2]), argv[3]);
    if (!done.ok()) std::fprintf(stderr, "basis_functions: %s\n", done.error().text().c_str());
    return done.ok() ? 0 : 1;
}
