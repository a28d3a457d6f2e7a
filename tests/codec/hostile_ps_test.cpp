#include <gtest/gtest.h>

#include <array>
#include <nlohmann/json.hpp>
#include <random>

#include "../fuzz/ps.h"
#include "codec/ps_chains.h"
#include "codec/ps_places.h"

namespace relief::codec {
namespace {

template <class Target>
void run_mutations(const Bytes& seed, Target target, int count) {
    target(seed);
    std::mt19937 engine(99);
    for (int k = 0; k < count; ++k) {
        Bytes bytes = seed;
        for (std::uint32_t edits = 1 + engine() % 4; edits > 0 && !bytes.empty(); --edits) {
            const std::size_t at = engine() % bytes.size();
            if (engine() % 4 == 0)
                bytes.resize(at);
            else
                bytes[at] = static_cast<std::uint8_t>(engine() % 2 ? engine() : 0xff);
        }
        target(bytes);
    }
}

TEST(PlaceSet, GivesBackEveryPlace) {
    std::mt19937_64 engine(5);
    for (const int bits : {0, 1, 3, 20, 50})
        for (const std::size_t count : {1U, 2U, 3U, 17U, 300U}) {
            std::vector<GridPlace> places(count);
            const std::int64_t half = std::int64_t{1} << bits;
            for (GridPlace& p : places) {
                p.x = static_cast<std::int64_t>(engine() % (2 * half + 1)) - half;
                p.y = static_cast<std::int64_t>(engine() % (half / 8 + 1));
            }
            const Bytes bytes = write_place_set(places);
            sort_places(places);
            const auto decoded = read_place_set(bytes, count);
            ASSERT_TRUE(decoded.ok());
            EXPECT_EQ(*decoded, places);
        }
}

TEST(PlaceChains, LinesAreFoundAndCostLittle) {
    std::mt19937 engine(6);
    std::vector<GridPlace> places;
    for (int line = 0; line < 40; ++line)
        for (int k = 0; k < 100; ++k)
            places.push_back({50 * k + static_cast<int>(engine() % 3),
                              line * 3000 + 10 * k + static_cast<int>(engine() % 3)});
    for (int k = 0; k < 300; ++k)
        places.push_back({static_cast<int>(engine() % 5000), static_cast<int>(engine() % 120000)});
    std::shuffle(places.begin(), places.end(), engine);
    const PlaceChains chains = find_chains(places);
    EXPECT_GT(chains.chained.size(), 3800U);
    EXPECT_EQ(chains.begins.size(), chains.chained.size());
    const auto lines = read_chains(write_chains(chains), chains.chained.size());
    ASSERT_TRUE(lines.ok());
    EXPECT_EQ(*lines, chains.chained);
    const Bytes bytes = write_places(places);
    auto decoded = *read_places(bytes, places.size());
    sort_places(places);
    sort_places(decoded);
    EXPECT_EQ(decoded, places);
    // Second differences of independent thirds have 2 x 3 bits; 300 places have 29 each.
    EXPECT_LT(bytes.size(), (4000 * 7 + 300 * 32) / 8);
    EXPECT_LT(2 * bytes.size(), write_place_set(places).size());
}

TEST(HostilePs, Files) {
    for (const Bytes& file : fuzz::valid_ps_files())
        run_mutations(
            file, [](const Bytes& bytes) { fuzz::ps_files(bytes); }, 120);
}

TEST(HostilePs, EveryPrefix) {
    for (const Bytes& file : fuzz::valid_ps_files())
        for (std::size_t size = 1; size < file.size(); size += 1 + size / 64)
            fuzz::ps_files(std::span(file).first(size));
}

TEST(HostilePs, ChunksWhoseChecksumsHold) {
    std::mt19937 engine(7);
    for (std::uint8_t file = 0; file < fuzz::valid_ps_files().size(); ++file)
        for (int k = 0; k < 150; ++k) {
            Bytes edits = {file};
            for (std::uint32_t count = 1 + engine() % 3; count > 0; --count)
                for (const std::uint32_t byte : {static_cast<std::uint32_t>(engine() % 6),
                                                 static_cast<std::uint32_t>(engine() % 120), 0U, 2U,
                                                 static_cast<std::uint32_t>(engine() % 256),
                                                 static_cast<std::uint32_t>(engine() % 256)})
                    edits.push_back(static_cast<std::uint8_t>(byte));
            fuzz::ps_chunks(edits);
        }
}

TEST(HostilePs, Headers) {
    for (const Bytes& file : fuzz::valid_ps_files()) {
        const std::string header = ContainerReader::open(file)->header();
        run_mutations(
            Bytes(header.begin(), header.end()), [](const Bytes& bytes) { fuzz::ps_header(bytes); },
            60);
    }
}

TEST(HostilePs, HeaderMembersOutOfRangeAreNamed) {
    const Bytes& values = fuzz::valid_ps_files()[0];
    const Bytes& splines = fuzz::valid_ps_files()[4];
    for (const auto& [path, value, says] :
         std::vector<std::array<std::string, 3>>{{"/content", "\"raster\"", "holds 'raster'"},
                                                 {"/base/vertices", "-1", "vertices"},
                                                 {"/base/vertices", "4294967296", "too many"},
                                                 {"/base/vertices", "2147483647", "too small"},
                                                 {"/base/vertices", "11", "damaged"},
                                                 {"/base/triangles", "100", "more triangles"},
                                                 {"/base/triangles", "3", "damaged"},
                                                 {"/base/digits", "16", "digits"},
                                                 {"/base/digits", "\"x\"", "digits"},
                                                 {"/base/exponent", "5000", "exponent"},
                                                 {"/base/origin", "[1]", "origin"},
                                                 {"/base/peel", "2", "peel"},
                                                 {"/components", "4", "components"},
                                                 {"/scheme/name", "\"box\"", "newer version"},
                                                 {"/scheme/levels", "13", "levels"},
                                                 {"/scheme/levels", "-1", "levels"},
                                                 {"/scheme/update", "\"moon\"", "newer version"},
                                                 {"/gradients/rule", "\"moon\"", "newer version"},
                                                 {"/gradients/tilt", "-1", "gradients"},
                                                 {"/values", "[1]", "values"},
                                                 {"/values", "[]", "lattices"},
                                                 {"/details/step", "0", "step"},
                                                 {"/details/law", "\"moon\"", "newer version"},
                                                 {"/georeference", "7", "georeference"},
                                                 {"/georeference/crs", "4326", "crs"},
                                                 {"/unit", "[]", "unit"},
                                                 {"/goal/value", "[]", "value"}}) {
        const bool of_splines = path.starts_with("/details") || path.starts_with("/scheme/");
        const ContainerReader reader = *ContainerReader::open(of_splines ? splines : values);
        auto header = nlohmann::json::parse(reader.header());
        header[nlohmann::json::json_pointer(path)] = nlohmann::json::parse(value);
        const auto opened =
            PsFile::open(fuzz::rebuilt(reader, header.dump(), fuzz::chunks_of(reader)));
        ASSERT_FALSE(opened.ok()) << path << " " << value;
        EXPECT_NE(opened.error().text().find(says), std::string::npos)
            << path << " " << value << ": " << opened.error().text();
    }
}

TEST(HostilePs, LevelsThatTheFileIsTooSmallFor) {
    const ContainerReader reader = *ContainerReader::open(fuzz::valid_ps_files()[4]);
    auto header = nlohmann::json::parse(reader.header());
    header["scheme"]["levels"] = 9;
    auto chunks = fuzz::chunks_of(reader);
    chunks.resize(chunks.size() + 7);
    const auto opened = PsFile::open(fuzz::rebuilt(reader, header.dump(), chunks));
    ASSERT_FALSE(opened.ok());
    EXPECT_NE(opened.error().message.find("too small"), std::string::npos);
}

TEST(HostilePs, DamageIsNamed) {
    const Bytes& file = fuzz::valid_ps_files()[4];
    const ContainerReader reader = *ContainerReader::open(file);
    for (std::size_t k = 1; k + 1 < reader.chunks().size(); ++k) {
        Bytes damaged = file;
        damaged[static_cast<std::size_t>(reader.chunks()[k].offset)] ^= 1;
        const auto opened = PsFile::open(damaged);
        if (k == 1) {
            EXPECT_EQ(opened.error().code, ErrorCode::BadFile);
            continue;
        }
        ASSERT_TRUE(opened.ok());
        EXPECT_FALSE(opened->checksums_ok());
        const int level = opened->levels() - static_cast<int>(k - 2);
        const auto surface = opened->surface(level);
        ASSERT_FALSE(surface.ok());
        EXPECT_NE(surface.error().message.find("checksum"), std::string::npos);
        EXPECT_EQ(level == opened->levels() || opened->surface(level + 1).ok(), true);
    }
}

}  // namespace
}  // namespace relief::codec
