#pragma once

#include <memory>
#include <vector>

#include "containers.h"
#include "relief/codec/raster_shards.h"

/// What is done with bytes that claim to be shards.
namespace relief::codec::fuzz {

/// As the plan, and as the only shard: if that makes a file, it can be opened.
inline void shards(std::span<const std::uint8_t> bytes) {
    const auto source = std::make_shared<MemorySource>(Bytes(bytes.begin(), bytes.end()));
    if (const auto plan = RasterPlan::open(source); plan.ok())
        for (const std::int64_t tile : plan->missing_tiles()) {
            const LatticeBox box = plan->samples(tile);
            require(box.rows > 0 && box.cols > 0 &&
                    box.row0 + box.rows <= plan->description().rows &&
                    box.col0 + box.cols <= plan->description().cols);
        }
    MemorySink sink;
    if (merge_shards({source}, sink).ok()) require(RasterFile::open(sink.take()).ok());
}

/// The bytes are the header of a shard whose chunks are sound: what is in it reaches further.
inline void shard_header(const Bytes& shard, std::span<const std::uint8_t> header) {
    const auto reader = ContainerReader::open(shard);
    require(reader.ok());
    shards(rebuilt(*reader, std::string(header.begin(), header.end()), chunks_of(*reader)));
}

}  // namespace relief::codec::fuzz
