#include <random>

#include "../fuzz/decoders.h"
#include "codec/levels.h"

/// The fuzzers' functions on a small corpus and its mutations, so that every test run covers them.
namespace relief::codec {
namespace {

using Bytes = std::vector<std::uint8_t>;

template <class Target>
void run_mutations(const Bytes& seed, Target target) {
    target(seed);
    std::mt19937 engine(99);
    for (int k = 0; k < 3000; ++k) {
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

TEST(HostileBytes, Bands) {
    Bytes seed = {2, 0xfe, 3, 30, 41, 1, 5, 0xf7, 50, 33, 0};
    std::span<const std::uint8_t> shape(seed);
    fuzz::Level level = fuzz::Level::from(shape);
    GeometricSource source(0.7, 6);
    for (Grid<std::int32_t>& grid : level.grids) fill(grid, source);
    const Bytes coded = encode_level(level.bands, {});
    seed.insert(seed.end(), coded.begin(), coded.end());
    run_mutations(seed, [](const Bytes& bytes) { fuzz::bands(bytes); });
    run_mutations(Bytes(40, 0xff), [](const Bytes& bytes) { fuzz::bands(bytes); });
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

TEST(HostileBytes, Containers) {
    ContainerWriter writer(R"({"scheme":"box"})");
    for (int k = 0; k < 3; ++k)
        ASSERT_TRUE(writer.add({}, Bytes(20, static_cast<std::uint8_t>(k))).ok());
    run_mutations(*writer.finish(), [](const Bytes& bytes) { fuzz::container(bytes); });
}

}  // namespace
}  // namespace relief::codec
