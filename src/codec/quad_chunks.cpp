#include "codec/quad_chunks.h"

namespace relief::codec {

namespace {

constexpr std::size_t kMoveBytes = 4 + 8 + 8;

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
    return read_records<QuadMove>(bytes, kMoveBytes, [](ByteReader& in, QuadMove& move) {
        move.level = read_move_level(in);
        move.vertex = in.u64();
        move.rise = in.f64();
    });
}

}  // namespace relief::codec
