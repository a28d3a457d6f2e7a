#include "codec/lattice_fill.h"

#include "codec/fast_planes.h"
#include "codec/fast_rows.h"

namespace relief::codec {

void fill_level(LatticeLevel& level) {
    const fast::RowRule rule(level.lowest, level.highest, 1);
    fast::LatticePlanes planes(level, rule);
    for (std::int64_t i = 0; i < planes.diagonal_rows(); ++i)
        fast::predict_row(planes.diagonal_neighbours(i), planes.diagonal_cols(), rule,
                          planes.diagonal_values(i));
    for (std::int64_t r = 0; r < level.rows(); ++r) {
        fast::predict_row(planes.edge_neighbours(r), planes.edge_cols(r), rule,
                          planes.edge_values(r));
        planes.merge_row(r, level);
    }
    fill_edge_margins(level);
}

}  // namespace relief::codec
