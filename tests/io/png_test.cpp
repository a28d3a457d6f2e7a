#include "relief/io/png.h"

#include "io/scratch.h"
#include "relief/io/file.h"

namespace relief::io {
namespace {

using PngTest = Scratch;

Image noise(int width, int height, int channels) {
    Image image(width, height, channels);
    std::uint32_t state = 1;
    for (std::uint8_t& sample : image.pixels) {
        state = state * 1664525U + 1013904223U;
        sample = static_cast<std::uint8_t>(state >> 24);
    }
    return image;
}

TEST_F(PngTest, RoundTripKeepsEverySample) {
    for (const int channels : {3, 4}) {
        const Image image = noise(37, 21, channels);
        ASSERT_TRUE(write_png(path("a.png"), image).ok());
        const auto back = read_png(path("a.png"));
        ASSERT_TRUE(back.ok());
        EXPECT_EQ(back->width, 37);
        EXPECT_EQ(back->height, 21);
        EXPECT_EQ(back->channels, channels);
        EXPECT_EQ(back->pixels, image.pixels);
    }
    EXPECT_EQ(files(), Names{"a.png"});
}

TEST_F(PngTest, TruncatedOrAlteredFilesAreRefused) {
    ASSERT_TRUE(write_png(path("a.png"), noise(40, 30, 3)).ok());
    const auto bytes = *read_file(path("a.png"));
    for (std::size_t keep = 0; keep < bytes.size() - 12; keep += 97) {
        ASSERT_TRUE(write_file_atomically(path("b.png"), {bytes.data(), keep}).ok());
        EXPECT_EQ(read_png(path("b.png")).error().code, ErrorCode::BadFile) << keep;
    }
    EXPECT_EQ(read_png(path("none.png")).error().code, ErrorCode::NotFound);
}

TEST_F(PngTest, ImpossibleImagesAreRefused) {
    EXPECT_EQ(write_png(path("a.png"), Image()).error().code, ErrorCode::InvalidArgument);
    Image wrong(4, 4, 3);
    wrong.pixels.pop_back();
    EXPECT_EQ(write_png(path("a.png"), wrong).error().code, ErrorCode::InvalidArgument);
    EXPECT_EQ(write_png(path("no/a.png"), noise(2, 2, 3)).error().code, ErrorCode::CannotWrite);
    EXPECT_EQ(files(), Names{});
}

}  // namespace
}  // namespace relief::io
