#include "codec/lattice_fill.h"

#include "codec/fast_rows.h"
#include "codec/fast_samples.h"

namespace relief::codec {

void fill_level(LatticeLevel& level) {
    const fast::RowRule rule(level.lowest, level.highest, 1);
    fast::SampleRows(level, rule).for_each([&](const fast::SampleRow& row) {
        fast::predict_row(row.neighbours, row.n, rule, row.values);
    });
}

}  // namespace relief::codec
