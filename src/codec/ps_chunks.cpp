#include "codec/ps_chunks.h"

#include "relief/codec/container.h"

namespace relief::codec {

namespace {

constexpr std::size_t kMoveBytes = 4 + 1 + 8 + 3 * 8;

}  // namespace

Result<Bytes> write_ps_file(const PsHeader& header, const PsContents& contents) {
    ContainerWriter writer;
    writer.add({});
    writer.add(contents.mesh);
    for (std::size_t m = 0; m < contents.levels.size(); ++m)
        writer.add(contents.levels[m], contents.bounds[m]);
    writer.add(contents.correction, contents.bounds.back());
    return writer.finish(write_ps_header(header));
}

Result<LevelHeights> splines_through(const multires::ps::Space& space, const VertexValues& values,
                                     const multires::ps::GradientOptions& gradients) {
    LevelHeights splines;
    for (const std::vector<double>& component : values) {
        RELIEF_TRY(const std::vector<Vec2> slopes,
                   estimate_gradients(space.mesh, component, gradients));
        multires::ps::TangentPlanes planes;
        for (std::size_t v = 0; v < component.size(); ++v)
            planes.push_back({component[v], slopes[v]});
        splines.push_back(coefficients(space, planes));
    }
    return splines;
}

multires::ps::Coefficients refined(const multires::ps::Hierarchy& hierarchy, int level,
                                   multires::ps::Coefficients spline) {
    for (int m = level; m < hierarchy.levels(); ++m)
        spline = prolong(hierarchy.space(m), hierarchy.step(m), spline);
    return spline;
}

Bytes write_ps_moves(const std::vector<PsMove>& moves) {
    ByteWriter out;
    for (const PsMove& move : moves) {
        out.u32(static_cast<std::uint32_t>(move.level));
        out.u8(static_cast<std::uint8_t>(move.component));
        out.u64(move.vertex);
        for (const double number : {move.rise, move.tilt.x, move.tilt.y}) out.f64(number);
    }
    return out.take();
}

Result<std::vector<PsMove>> read_ps_moves(std::span<const std::uint8_t> bytes) {
    return read_records<PsMove>(bytes, kMoveBytes, [](ByteReader& in, PsMove& move) {
        move.level = read_move_level(in);
        move.component = in.u8();
        move.vertex = in.u64();
        for (double* number : {&move.rise, &move.tilt.x, &move.tilt.y}) *number = in.f64();
    });
}

}  // namespace relief::codec
