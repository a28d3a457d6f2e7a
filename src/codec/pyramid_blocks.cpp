#include "codec/pyramid_blocks.h"

#include <algorithm>

#include "codec/embedded_quantiser.h"
#include "codec/pyramid_code.h"
#include "relief/core/parallel.h"
#include "relief/multires/cubic_window.h"

namespace relief::codec {

namespace {

/// Blocks that are kept, besides two rows of tiles.
constexpr std::size_t kFewestKept = 24;

}  // namespace

Result<multires::Planes<double>> cubic_surface(const multires::PyramidLayout& layout, int level,
                                               const LatticeBox& window, const PyramidPart& part) {
    multires::Planes<double> planes;
    for (std::size_t c = 0; c < static_cast<std::size_t>(layout.components); ++c) {
        std::vector<GridView<const double>> bands;
        for (const multires::Planes<double>& band : part.bands) bands.push_back(band[c].view());
        RELIEF_TRY(Grid<double> plane,
                   multires::cubic::synthesise_window<double>(layout, level, window, bands));
        planes.push_back(std::move(plane));
    }
    return planes;
}

PyramidBlocks::PyramidBlocks(const ContainerReader& container,
                             const multires::PyramidLayout& layout, const PyramidCoding& coding,
                             std::size_t first_chunk)
    : container_(container),
      layout_(layout),
      coding_(coding),
      first_chunk_(first_chunk),
      streams_(layout),
      order_{coding.layers.size(), streams_.streams()},
      capacity_(kFewestKept) {
    const auto across = static_cast<std::size_t>(layout.cols / TileTree::kTile + 1);
    capacity_ += 2 * across * TileTree::kTierLevels;
}

Result<PyramidBlocks::BlockPointer> PyramidBlocks::block(std::size_t stream) const {
    {
        const std::lock_guard lock(mutex_);
        if (const auto found = index_.find(stream); found != index_.end()) {
            recent_.splice(recent_.begin(), recent_, found->second);
            return found->second->second;
        }
    }
    RELIEF_TRY(Block decoded, decode(stream));
    BlockPointer pointer = std::make_shared<const Block>(std::move(decoded));
    const std::lock_guard lock(mutex_);
    if (index_.contains(stream)) return pointer;
    recent_.emplace_front(stream, pointer);
    index_[stream] = recent_.begin();
    if (recent_.size() > capacity_) {
        index_.erase(recent_.back().first);
        recent_.pop_back();
    }
    return pointer;
}

/// A stream is known as far as its chunks are at hand and sound, and its parent is.
Result<PyramidBlocks::Block> PyramidBlocks::decode(std::size_t stream) const {
    BlockPointer above;
    if (const auto parent = streams_.parent(stream)) {
        RELIEF_TRY(above, block(*parent));
    }
    Block result;
    result.parts = streams_.parts(stream);
    const std::size_t most = above ? above->layers : coding_.layers.size();
    std::vector<StreamText> texts(static_cast<std::size_t>(layout_.components));
    for (; result.layers < most; ++result.layers) {
        const std::size_t number = chunk(result.layers, stream);
        if (!container_.complete(number)) break;
        const Result<Bytes> bytes = container_.chunk(number);
        result.damaged = !bytes.ok() || !append_chunk(*bytes, texts).ok();
        if (!result.damaged) continue;
        if (stream == 0 && result.layers == 0)
            return Error{ErrorCode::BadFile,
                         "the coarsest level is damaged; nothing can be decoded",
                         "chunk " + std::to_string(number)};
        break;
    }
    for (std::size_t c = 0; c < texts.size(); ++c) {
        const Status state =
            decode_component(c, texts[c].bytes, texts[c].planes, above.get(), result);
        if (!state.ok()) return state.error();
    }
    return result;
}

Status PyramidBlocks::decode_component(std::size_t component, std::span<const std::uint8_t> bytes,
                                       int planes, const Block* above, Block& block) const {
    std::vector<StreamBand> bands;
    for (const BandPart& part : block.parts) {
        Grid<std::int32_t>& values = block.values.emplace_back(part.box.rows, part.box.cols);
        const multires::BandLayout& band = layout_.bands[part.band];
        bands.push_back({band.level, band.channel, part.box, values.view()});
    }
    std::vector<ParentBand> parents;
    for (std::size_t k = 0; above && k < above->parts.size(); ++k) {
        const multires::BandLayout& band = layout_.bands[above->parts[k].band];
        parents.push_back({band.level, band.channel, above->parts[k].box,
                           above->values[component * above->parts.size() + k].view()});
    }
    const int lowest = block.layers == 0 ? planes : coding_.layers[block.layers - 1];
    RELIEF_TRY(const KnownBits known,
               decode_stream({bytes, planes, 3 * std::max(planes - lowest, 0)}, bands, parents));
    block.known.push_back(known);
    return {};
}

void PyramidBlocks::copy(const Block& block, const std::vector<LatticeBox>& boxes,
                         PyramidPart& out) const {
    for (std::size_t k = 0; k < block.parts.size(); ++k) {
        const std::size_t band = block.parts[k].band;
        const LatticeBox& from = block.parts[k].box;
        const LatticeBox part = intersection(from, boxes[band]);
        if (part.count() == 0) continue;
        for (std::size_t c = 0; c < block.known.size(); ++c) {
            const Grid<std::int32_t>& values = block.values[c * block.parts.size() + k];
            Grid<double>& plane = out.bands[band][c];
            const GridView<double> to =
                part_of(plane.view(), relative(part, boxes[band].row0, boxes[band].col0));
            reconstruct_band<double>(part_of(values.view(), relative(part, from.row0, from.col0)),
                                     block.known[c], coding_.step_of(layout_, band), to);
            if (band == 0) add_to(to, coding_.means[c]);
        }
    }
}

Result<PyramidPart> PyramidBlocks::read(const std::vector<LatticeBox>& boxes,
                                        int finest_level) const {
    PyramidPart out;
    out.fewest_layers = coding_.layers.size();
    std::vector<LatticeBox> wanted = boxes;
    for (std::size_t k = 0; k < boxes.size(); ++k) {
        const multires::BandLayout& band = layout_.bands[k];
        const bool dropped = band.channel > 0 && band.level <= finest_level;
        if (dropped) wanted[k] = {};
        multires::Planes<double>& planes = out.bands.emplace_back();
        for (int c = 0; c < layout_.components; ++c)
            planes.push_back(dropped ? Grid<double>(boxes[k].rows, boxes[k].cols, 0.0)
                                     : Grid<double>(boxes[k].rows, boxes[k].cols));
    }
    for (std::size_t g = 0; g < streams_.groups().size(); ++g) {
        std::vector<std::size_t> met;
        for (std::size_t k = 0; k < wanted.size(); ++k) {
            const int level = layout_.bands[k].level;
            const StreamLayout::Group& group = streams_.groups()[g];
            if (wanted[k].count() == 0 || level > group.coarsest || level < group.finest) continue;
            const auto more = streams_.meeting(g, level, wanted[k]);
            met.insert(met.end(), more.begin(), more.end());
        }
        std::sort(met.begin(), met.end());
        met.erase(std::unique(met.begin(), met.end()), met.end());
        std::vector<Status> states(met.size());
        std::vector<std::pair<std::size_t, bool>> found(met.size());  // layers, damaged
        parallel_for(0, static_cast<std::int64_t>(met.size()), 1,
                     [&](std::int64_t first, std::int64_t last) {
                         for (auto k = static_cast<std::size_t>(first);
                              k < static_cast<std::size_t>(last); ++k) {
                             const Result<BlockPointer> decoded = block(met[k]);
                             if (!decoded.ok()) {
                                 states[k] = decoded.error();
                                 continue;
                             }
                             copy(**decoded, wanted, out);
                             found[k] = {(*decoded)->layers, (*decoded)->damaged};
                         }
                     });
        for (std::size_t k = 0; k < met.size(); ++k) {
            RELIEF_CHECK(states[k]);
            out.fewest_layers = std::min(out.fewest_layers, found[k].first);
            if (met[k] != 0) out.most_layers = std::max(out.most_layers, found[k].first);
            if (found[k].second) out.damaged.push_back(streams_.samples(met[k]));
        }
    }
    out.most_layers = std::max(out.most_layers, out.fewest_layers);
    return out;
}

}  // namespace relief::codec
