#include "codec/spooled_file.h"

#include <algorithm>

namespace relief::codec {

namespace {

constexpr std::uint64_t kCopyBlock = std::uint64_t{1} << 20;

}  // namespace

Result<SpooledChunk> spooled(std::span<const std::uint8_t> bytes, Spool& spool, double bound) {
    SpooledChunk chunk;
    chunk.info = {0, bytes.size(), chunk_checksum(bytes), bound};
    RELIEF_TRY(chunk.place, spool.append(bytes));
    return chunk;
}

Result<std::shared_ptr<const SpooledFile>> SpooledFile::create(const std::string& header,
                                                               std::vector<SpooledChunk> chunks,
                                                               const ByteSource& spool) {
    std::vector<ChunkInfo> directory;
    for (const SpooledChunk& chunk : chunks) directory.push_back(chunk.info);
    auto file = std::make_shared<SpooledFile>();
    RELIEF_TRY(file->head_, container_head(header, directory));
    file->size_ = file->head_.size();
    for (SpooledChunk& chunk : chunks) {
        chunk.info.offset = file->size_;
        file->size_ += chunk.info.length;
    }
    file->chunks_ = std::move(chunks);
    file->spool_ = &spool;
    return std::shared_ptr<const SpooledFile>(std::move(file));
}

std::uint64_t SpooledFile::end_of(std::size_t k) const {
    return chunks_[k].info.offset + chunks_[k].info.length;
}

Status SpooledFile::read(std::uint64_t offset, std::span<std::uint8_t> into) const {
    if (offset < head_.size() && !into.empty()) {
        const auto first = static_cast<std::ptrdiff_t>(offset);
        const std::size_t count = std::min<std::size_t>(head_.size() - offset, into.size());
        std::copy_n(head_.begin() + first, count, into.begin());
        offset += count;
        into = into.subspan(count);
    }
    auto chunk = std::partition_point(chunks_.begin(), chunks_.end(), [&](const SpooledChunk& c) {
        return c.info.offset + c.info.length <= offset;
    });
    for (; !into.empty(); ++chunk) {
        const std::uint64_t inside = offset - chunk->info.offset;
        const auto count = static_cast<std::size_t>(
            std::min<std::uint64_t>(chunk->info.length - inside, into.size()));
        RELIEF_CHECK(spool_->read(chunk->place + inside, into.first(count)));
        offset += count;
        into = into.subspan(count);
    }
    return {};
}

Status SpooledFile::copy_to(ByteSink& sink) const {
    Bytes block;
    for (std::uint64_t at = 0; at < size_; at += block.size()) {
        block.resize(static_cast<std::size_t>(std::min(kCopyBlock, size_ - at)));
        RELIEF_CHECK(read(at, block));
        RELIEF_CHECK(sink.write(block));
    }
    return {};
}

}  // namespace relief::codec
