#include <array>
#include <bit>
#include <nlohmann/json.hpp>
#include <random>

#include "../fuzz/decoders.h"
#include "../fuzz/lattice_decoders.h"
#include "codec/levels.h"

/// The fuzzers' functions on a small corpus and its mutations, so that every test run covers them.
namespace relief::codec {
namespace {

template <class Target>
void run_mutations(const Bytes& seed, Target target, int count = 3000) {
    target(seed);
    std::mt19937 engine(99);
    for (int k = 0; k < count; ++k) {
        Bytes bytes = seed;
        for (std::uint32_t edits = 1 + engine() % 4; edits > 0 && !bytes.empty(); --edits) {
            const std::size_t at = engine() % bytes.size();
            switch (engine() % 4) {
                case 0:
                    bytes[at] = static_cast<std::uint8_t>(engine());
                    break;
                case 1:
                    bytes[at] = engine() % 2 ? 0xff : 0;
                    break;
                case 2:
                    bytes.resize(at);
                    break;
                default:
                    bytes.insert(bytes.begin() + static_cast<std::ptrdiff_t>(at), bytes.begin(),
                                 bytes.begin() + static_cast<std::ptrdiff_t>(at / 2));
            }
        }
        target(bytes);
    }
}

TEST(HostileBytes, Streams) {
    Bytes seed = {2, 0xfe, 3, 30, 41, 1, 0, 3, 50, 33, 2};
    std::span<const std::uint8_t> shape(seed);
    fuzz::Level level = fuzz::Level::from(shape);
    GeometricSource source(0.7, 6);
    for (Grid<std::int32_t>& grid : level.grids) fill(grid, source);
    const auto coded = encode_stream(level.bands, {});
    ASSERT_TRUE(coded.ok());
    seed.push_back(static_cast<std::uint8_t>(coded->planes));
    seed.push_back(static_cast<std::uint8_t>(3 * coded->planes));
    seed.insert(seed.end(), coded->bytes.begin(), coded->bytes.end());
    run_mutations(
        seed, [](const Bytes& bytes) { fuzz::stream(bytes); }, 1000);
    run_mutations(
        Bytes(40, 0xff), [](const Bytes& bytes) { fuzz::stream(bytes); }, 1000);
}

TEST(HostileBytes, Masks) {
    Bytes seed = {40, 50};
    const Grid<std::uint8_t> noise = [] {
        Grid<std::uint8_t> image(40, 50);
        std::mt19937 engine(1);
        for (std::int64_t r = 0; r < 40; ++r)
            for (std::int64_t c = 0; c < 50; ++c)
                image(r, c) = (r / 8 + c / 8) % 2 == 0 || engine() % 30 == 0;
        return image;
    }();
    const Bytes coded = encode_mask(noise.view());
    seed.insert(seed.end(), coded.begin(), coded.end());
    run_mutations(seed, [](const Bytes& bytes) { fuzz::mask(bytes); });
    run_mutations(Bytes(300, 0xff), [](const Bytes& bytes) { fuzz::mask(bytes); });
}

void append_part(Bytes& bytes, const Bytes& part) {
    bytes.push_back(static_cast<std::uint8_t>(part.size()));
    bytes.push_back(static_cast<std::uint8_t>(part.size() >> 8));
    bytes.insert(bytes.end(), part.begin(), part.end());
}

/// A shape and its levels as an encoder writes them.
Bytes coded_levels(const Bytes& shape_bytes) {
    fuzz::Parts in(shape_bytes);
    const fuzz::LevelShape shape(in);
    const auto codec = shape.profile == Profile::Dense ? make_dense_codec() : make_fast_codec();
    Bytes seed = shape_bytes;
    LatticeLevel level = shape.coarse();
    while (level.level > 0) {
        LatticeLevel next = shape.below(level);
        Grid<std::int32_t> source(next.rows(), next.cols());
        for (std::int64_t r = 0; r < next.rows(); ++r)
            for (std::int64_t c = 0; c < next.cols(); ++c)
                source(r, c) = static_cast<std::int32_t>(40 * (r % 7) + c + shape.noise(c, r) % 9);
        Bytes coded;
        EXPECT_TRUE(codec->encode(next, source.view(), coded));
        append_part(seed, coded);
        fill_edge_margins(next);
        level = std::move(next);
    }
    return seed;
}

TEST(HostileBytes, Levels) {
    for (const int profile : {0, 1})
        for (const int holes : {0, 60}) {
            // All borders; 23 x 18 samples, three levels, step 3, samples below 512.
            const Bytes shape = {static_cast<std::uint8_t>(30 + profile), 22, 17, 2, 4, 9,
                                 static_cast<std::uint8_t>(holes),        5};
            run_mutations(
                coded_levels(shape), [](const Bytes& bytes) { fuzz::lattice_level(bytes); }, 600);
        }
    run_mutations(
        Bytes(300, 0xff), [](const Bytes& bytes) { fuzz::lattice_level(bytes); }, 600);
}

/// The chunks of a valid file of one tile, behind what fuzz::tile asks for.
Bytes tile_seed(const Bytes& file) {
    const ContainerReader reader = *ContainerReader::open(file);
    const LatticeCoding coding = *read_header(reader.header())->lattice;
    const IntegerDomain& domain = coding.domains[0];
    Bytes seed = {
        12,
        17,
        static_cast<std::uint8_t>(coding.profile == Profile::Dense),
        static_cast<std::uint8_t>(coding.type),
        static_cast<std::uint8_t>(domain.step - 1),
        static_cast<std::uint8_t>(std::bit_width(static_cast<std::uint32_t>(domain.highest)))};
    for (std::size_t k = 1; k < reader.chunks().size(); ++k) append_part(seed, *reader.chunk(k));
    return seed;
}

TEST(HostileBytes, Tiles) {
    int tiles = 0;
    for (const Bytes& file : fuzz::valid_rasters()) {
        if (!RasterFile::open(file)->closed_loop()) continue;
        ++tiles;
        run_mutations(
            tile_seed(file), [](const Bytes& bytes) { fuzz::tile(bytes); }, 1000);
    }
    EXPECT_EQ(tiles, 4);
    run_mutations(
        Bytes(300, 1), [](const Bytes& bytes) { fuzz::tile(bytes); }, 1000);
}

TEST(HostileBytes, Containers) {
    ContainerWriter writer;
    for (int k = 0; k < 3; ++k) writer.add(Bytes(20, static_cast<std::uint8_t>(k)));
    run_mutations(*writer.finish(R"({"scheme":"box"})"),
                  [](const Bytes& bytes) { fuzz::container(bytes); });
}

TEST(HostileBytes, RasterFiles) {
    for (const Bytes& file : fuzz::valid_rasters())
        run_mutations(
            file, [](const Bytes& bytes) { fuzz::raster(bytes); }, 500);
}

TEST(HostileBytes, RasterChunksWhoseChecksumsHold) {
    for (std::uint8_t file = 0; file < fuzz::valid_rasters().size(); ++file) {
        // One edit of three bytes in each of a few chunks; mutation moves and multiplies them.
        Bytes edits = {file};
        for (const int chunk : {0, 1, 2, 3})
            for (const int byte : {chunk, 7 * chunk, 0, 3, 1, 255, 16})
                edits.push_back(static_cast<std::uint8_t>(byte));
        run_mutations(
            edits, [](const Bytes& bytes) { fuzz::raster_chunks(bytes); }, 400);
    }
}

TEST(HostileBytes, RasterHeaders) {
    const Bytes& file = fuzz::valid_rasters()[0];
    const std::string header = ContainerReader::open(file)->header();
    run_mutations(
        Bytes(header.begin(), header.end()), [](const Bytes& bytes) { fuzz::raster_header(bytes); },
        1000);
}

/// `member` of the header of a valid file replaced by JSON text.
Result<RasterFile> with_member(const std::string& path, const std::string& value) {
    const Bytes& file = fuzz::valid_rasters()[0];
    const ContainerReader reader = *ContainerReader::open(file);
    auto header = nlohmann::json::parse(reader.header());
    header[nlohmann::json::json_pointer(path)] = nlohmann::json::parse(value);
    return RasterFile::open(fuzz::rebuilt(reader, header.dump(), fuzz::chunks_of(reader)));
}

TEST(HostileBytes, HeaderMembersOutOfRangeAreNamed) {
    ASSERT_TRUE(with_member("/rows", "13").ok());
    for (const auto& [path, value, says] : std::vector<std::array<std::string, 3>>{
             {"/rows", "0", "size"},
             {"/rows", "-13", "size"},
             {"/rows", "2147483648", "size"},
             {"/rows", "18446744073709551615", "size"},
             {"/rows", "13.0", "rows"},
             {"/rows", "2147483647", "claims 18 x 2147483647 samples"},
             {"/cols", "100000000", "claims 100000000 x 13 samples"},
             {"/components", "5", "components"},
             {"/components", "4294967297", "components"},
             {"/type", "\"int128\"", "int128"},
             {"/mask", "false", "chunks"},
             {"/mask", "1", "mask"},
             {"/scheme/levels", "4294967298", "levels"},
             {"/scheme/levels", "-1", "levels"},
             {"/scheme/levels", "60", "pyramid"},
             {"/scheme/order", "9", "order"},
             {"/scheme/name", "\"cubism\"", "newer version"},
             {"/scheme", "[]", "scheme"},
             {"/content", "\"mesh\"", "holds 'mesh'"},
             {"/georeference", "{\"transform\": [1, 2, 3]}", "6 numbers"}}) {
        const auto opened = with_member(path, value);
        ASSERT_FALSE(opened.ok()) << path << " " << value;
        EXPECT_NE(opened.error().text().find(says), std::string::npos)
            << path << " " << value << ": " << opened.error().text();
    }
}

TEST(HostileBytes, DeeplyNestedHeadersAreNoTrouble) {
    const std::string deep(200000, '[');
    const Bytes& file = fuzz::valid_rasters()[0];
    const ContainerReader reader = *ContainerReader::open(file);
    std::string header = reader.header();
    header.insert(1, "\"scheme\":{\"deep\":" + deep + std::string(200000, ']') + "},");
    fuzz::raster_header(Bytes(header.begin(), header.end()));
}

TEST(HostileBytes, ChunksThatStandTwiceOrNotAtAll) {
    const Bytes& file = fuzz::valid_rasters().back();
    const ContainerReader reader = *ContainerReader::open(file);
    const auto chunks = fuzz::chunks_of(reader);
    for (std::size_t gone = 0; gone < chunks.size(); ++gone) {
        ContainerWriter without;
        ContainerWriter twice;
        for (std::size_t k = 0; k < chunks.size(); ++k) {
            if (k != gone) without.add(chunks[k]);
            for (int copies = k == gone ? 2 : 1; copies > 0; --copies) twice.add(chunks[k]);
        }
        EXPECT_FALSE(RasterFile::open(*twice.finish(reader.header())).ok());
        EXPECT_FALSE(RasterFile::open(*without.finish(reader.header())).ok());
    }
}

}  // namespace
}  // namespace relief::codec
