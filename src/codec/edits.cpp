#include "codec/edits.h"

namespace relief::codec {

Status write_with_edits(const ContainerReader& file, const Bytes& edits, ByteSink& sink) {
    std::vector<ChunkInfo> chunks = file.chunks();
    chunks[kEditsChunk].length = edits.size();
    chunks[kEditsChunk].checksum = chunk_checksum(edits);
    RELIEF_TRY(const Bytes head, container_head(file.header(), chunks));
    RELIEF_CHECK(sink.write(head));
    RELIEF_CHECK(sink.write(edits));
    for (std::size_t k = kEditsChunk + 1; k < chunks.size(); ++k) {
        RELIEF_TRY(const Bytes chunk, file.chunk(k));
        RELIEF_CHECK(sink.write(chunk));
    }
    return {};
}

Result<Bytes> with_edits(const ContainerReader& file, const Bytes& edits) {
    MemorySink sink;
    RELIEF_CHECK(write_with_edits(file, edits, sink));
    return sink.take();
}

}  // namespace relief::codec
