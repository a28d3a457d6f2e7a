#include "codec/quad_chunks.h"

#include <algorithm>

#include "codec/bytes.h"
#include "codec/json_reader.h"

namespace relief::codec {

namespace {

constexpr std::uint64_t kMoveBytes = 4 + 8 + 8;
constexpr std::uint64_t kAlwaysPlausible = std::uint64_t{1} << 22;
constexpr std::uint64_t kVerticesPerByte = std::uint64_t{1} << 15;

}  // namespace

Result<Bytes> write_quad_file(const QuadHeader& header, const PlaneMesh& base,
                              const std::vector<Bytes>& levels, const std::vector<double>& bounds,
                              const Bytes& numbering) {
    ContainerWriter writer;
    writer.add({});
    writer.add(write_mesh(base, digits_of(header)));
    for (std::size_t m = 0; m < levels.size(); ++m) writer.add(levels[m], bounds[m]);
    writer.add(numbering, bounds.back());
    return writer.finish(write_quad_header(header));
}

bool is_plausible(std::uint64_t vertices, std::uint64_t file_size) {
    return vertices <= kAlwaysPlausible || vertices / kVerticesPerByte <= file_size;
}

Bytes write_quad_moves(const std::vector<QuadMove>& moves) {
    ByteWriter out;
    for (const QuadMove& move : moves) {
        out.u32(static_cast<std::uint32_t>(move.level));
        out.u64(move.vertex);
        out.f64(move.rise);
    }
    return out.take();
}

Result<std::vector<QuadMove>> read_quad_moves(std::span<const std::uint8_t> bytes) {
    if (bytes.size() % kMoveBytes != 0)
        return Error{ErrorCode::BadFile, "the edits are damaged", "edits chunk"};
    ByteReader in(bytes);
    std::vector<QuadMove> moves(bytes.size() / kMoveBytes);
    for (QuadMove& move : moves) {
        move.level = static_cast<int>(std::min<std::uint32_t>(in.u32(), 1000));
        move.vertex = in.u64();
        move.rise = in.f64();
    }
    return moves;
}

Result<std::string> content_of(std::shared_ptr<const ByteSource> source) {
    RELIEF_TRY(const ContainerReader container, ContainerReader::open(std::move(source)));
    const auto json = nlohmann::json::parse(container.header(), nullptr, false);
    if (!json.is_object()) return bad_header("the header is not a JSON object");
    JsonReader reader(json);
    auto content = reader.get<std::string>("content", "", true);
    RELIEF_CHECK(reader.status());
    return content;
}

}  // namespace relief::codec
