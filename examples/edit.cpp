// Lifts one control coefficient of level 3 by 100 m. The details ride along, and only the samples
// under the basis function of that coefficient change.
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "relief/io/synthetic.h"
#include "relief/multires/edit.h"
#include "relief/multires/scheme.h"

relief::Status run() {
    using namespace relief;
    const Raster hills = io::ridged(129, 1);
    RELIEF_TRY(auto pyramid, multires::analyse<double>({hills.planes[0].view()}, {.order = 2}));
    const multires::Move lift{.level = 3, .row = 8, .col = 8, .delta = {100.0}};
    RELIEF_CHECK(multires::apply_moves(pyramid, {lift}));
    const multires::Planes<double> edited = multires::synthesise(pyramid);

    int changed = 0;
    double most = 0;
    for (int row = 0; row < 129; ++row)
        for (int col = 0; col < 129; ++col) {
            const double rise = edited[0](row, col) - hills.planes[0](row, col);
            changed += std::abs(rise) > 1e-9;
            most = std::max(most, rise);
        }
    std::printf("%d samples changed, by up to %.4f m\n", changed, most);
    return {};
}

int main() {
    const relief::Status done = run();
    if (done.ok()) return 0;
    std::fprintf(stderr, "edit: %s\n", done.error().text().c_str());
    return 1;
}
