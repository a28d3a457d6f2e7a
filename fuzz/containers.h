#pragma once

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <span>
#include <string>
#include <vector>

#include "relief/codec/container.h"

/// Files taken apart and put together again, for fuzzers and tests of what is inside.
namespace relief::codec::fuzz {

inline void require(bool condition) {
    if (!condition) std::abort();
}

inline std::vector<Bytes> chunks_of(const ContainerReader& reader) {
    std::vector<Bytes> chunks;
    for (std::size_t k = 0; k < reader.chunks().size(); ++k) chunks.push_back(*reader.chunk(k));
    return chunks;
}

/// The same file with another header, chunks altered or added; all checksums hold.
inline Bytes rebuilt(const ContainerReader& reader, const std::string& header,
                     const std::vector<Bytes>& chunks) {
    ContainerWriter writer;
    for (std::size_t k = 0; k < chunks.size(); ++k)
        writer.add(chunks[k], k < reader.chunks().size() ? reader.chunks()[k].bound : 1);
    const auto file = writer.finish(header);
    return file.ok() ? *file : Bytes();
}

/// Edits: chunk, place (2 bytes), count, and as many bytes that are added to those there; count 255
/// cuts the chunk off at the place instead.
inline void edit_chunks(std::span<const std::uint8_t> bytes, std::vector<Bytes>& chunks) {
    while (bytes.size() >= 4) {
        auto& chunk = chunks[bytes[0] % chunks.size()];
        const std::size_t place = (bytes[1] | bytes[2] << 8) % (chunk.size() + 1);
        const std::size_t count = bytes[3];
        bytes = bytes.subspan(4);
        if (count == 255) {
            chunk.resize(place);
            continue;
        }
        const std::size_t used = std::min(count, bytes.size());
        if (chunk.size() < place + used) chunk.resize(place + used);
        for (std::size_t k = 0; k < used; ++k)
            chunk[place + k] = static_cast<std::uint8_t>(chunk[place + k] + bytes[k]);
        bytes = bytes.subspan(used);
    }
}

}  // namespace relief::codec::fuzz
