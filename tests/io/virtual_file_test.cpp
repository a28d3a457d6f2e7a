#include <cpl_vsi.h>
#include <gdal.h>

#include <numeric>
#include <thread>

#include "io/scratch.h"
#include "relief/io/file.h"
#include "relief/io/file_kind.h"
#include "relief/io/gdal.h"

namespace relief::io {
namespace {

using VirtualFile = Scratch;

Bytes numbers(std::size_t count) {
    Bytes bytes(count);
    std::iota(bytes.begin(), bytes.end(), std::uint8_t{3});
    return bytes;
}

TEST_F(VirtualFile, IsWrittenAndRead) {
    const std::string path = "/vsimem/relief-virtual-test";
    const Bytes bytes = numbers(100000);
    {
        auto file = OutputFile::create(path);
        ASSERT_TRUE(file.ok());
        const std::span<const std::uint8_t> all(bytes);
        ASSERT_TRUE(file->write(all.first(70000)).ok());
        ASSERT_TRUE(file->write(all.subspan(70000)).ok());
        ASSERT_TRUE(file->commit().ok());
    }
    EXPECT_EQ(*read_file(path), bytes);
    EXPECT_EQ(*read_file(path, 10), numbers(10));
    const auto source = open_source(path);
    ASSERT_TRUE(source.ok());
    EXPECT_EQ((*source)->size(), bytes.size());
    // Small parts and large ones, which are read in different ways, by several threads.
    std::vector<int> wrong(4);
    std::vector<std::thread> threads;
    for (std::size_t t = 0; t < wrong.size(); ++t)
        threads.emplace_back([&, t] {
            for (std::size_t k = 0; k < 50; ++k) {
                Bytes part(k % 2 == 0 ? 100 : 40000);
                const std::size_t offset = (k * 997 + t * 13) % 60000;
                const bool read = (*source)->read(offset, part).ok();
                wrong[t] +=
                    !read || !std::equal(part.begin(), part.end(),
                                         bytes.begin() + static_cast<std::ptrdiff_t>(offset));
            }
        });
    for (std::thread& thread : threads) thread.join();
    EXPECT_EQ(wrong, std::vector<int>(4));
    Bytes beyond(2);
    const Status past = (*source)->read(bytes.size() - 1, beyond);
    ASSERT_FALSE(past.ok());
    EXPECT_EQ(past.error().code, ErrorCode::BadFile);
    VSIUnlink(path.c_str());
}

TEST_F(VirtualFile, IsGoneWithoutCommit) {
    const std::string path = "/vsimem/relief-virtual-test";
    {
        auto file = OutputFile::create(path);
        ASSERT_TRUE(file.ok());
        ASSERT_TRUE(file->write(numbers(10)).ok());
    }
    const auto read = read_file(path);
    ASSERT_FALSE(read.ok());
    EXPECT_EQ(read.error().code, ErrorCode::NotFound);
    EXPECT_EQ(read.error().where, path);
    EXPECT_FALSE(OutputFile::create("/vsicurl/only-for-reading").ok());
}

TEST_F(VirtualFile, IsRecognised) {
    const std::string path = "/vsimem/relief-virtual-test";
    ASSERT_TRUE(write_file_atomically(path, Bytes{'R', 'E', 'L', 'I', 'E', 'F', 0x89}).ok());
    EXPECT_EQ(recognise(path), FileKind::Relief);
    VSIUnlink(path.c_str());
}

TEST_F(VirtualFile, RastersThatAreOpenAlreadyAreRead) {
    Raster raster;
    raster.rows = 20;
    raster.cols = 30;
    raster.planes.emplace_back(20, 30, 7.5);
    raster.planes[0](3, 4) = -2;
    ASSERT_TRUE(write_raster(path("a.tif"), raster).ok());
    GDALDatasetH dataset = GDALOpen(path("a.tif").c_str(), GA_ReadOnly);
    ASSERT_NE(dataset, nullptr);
    {
        const auto reader = reader_of(dataset);
        ASSERT_TRUE(reader.ok());
        const auto part = reader->read({3, 4, 2, 2});
        ASSERT_TRUE(part.ok());
        EXPECT_EQ(part->planes[0](0, 0), -2);
        EXPECT_EQ(part->planes[0](1, 1), 7.5);
    }
    // The reader leaves it open.
    EXPECT_EQ(GDALGetRasterXSize(dataset), 30);
    GDALClose(dataset);
}

}  // namespace
}  // namespace relief::io
