#include <mutex>

#include "landscape.h"
#include "relief/codec/container.h"
#include "relief/codec/measure.h"
#include "relief/codec/raster_codec.h"
#include "relief/core/parallel.h"
#include "support.h"

/// Open-loop files of several tiles: prefixes, windows, damage.
namespace relief::codec {
namespace {

using multires::SchemeId;
using Kind = Goal::Kind;

/// 2 x 2 tiles of tier 0 and one of tier 1.
const Raster& large() {
    static const Raster raster = landscape(780, 801);
    return raster;
}

const Bytes& large_file() {
    static const Bytes file = encode_raster(large(), {.spec = {{.id = SchemeId::Cubic}},
                                                      .goal = {Kind::RmsError, 0.7},
                                                      .effort = Effort::Select})
                                  ->bytes;
    return file;
}

std::shared_ptr<MemorySource> source_of(const Bytes& bytes) {
    return std::make_shared<MemorySource>(bytes);
}

TEST(PyramidFile, EndsOfLayersHaveTheirBoundAndErrorsFall) {
    const ContainerReader container = *ContainerReader::open(large_file());
    std::vector<std::uint64_t> ends;
    for (const ChunkInfo& chunk : container.chunks())
        if (std::isfinite(chunk.bound) && (ends.empty() || chunk.length > 0))
            ends.push_back(chunk.offset + chunk.length);
    ASSERT_GE(ends.size(), 3U);
    EXPECT_EQ(ends.back(), large_file().size());
    double last = 1e9;
    double last_bound = 1e9;
    for (const std::uint64_t end : ends) {
        const auto file = RasterFile::open(source_of(large_file()), end);
        ASSERT_TRUE(file.ok());
        const Measure found = *measure(large(), *file->decode(0));
        ASSERT_TRUE(file->bound(0).has_value());
        // The directory keeps 8 bits, rounded up.
        EXPECT_LE(found.max_error, *file->bound(0));
        EXPECT_GE(found.max_error, *file->bound(0) * (1 - 0x1p-6));
        EXPECT_LT(found.rms_error, last);
        EXPECT_LE(*file->bound(0), last_bound);
        last = found.rms_error;
        last_bound = *file->bound(0);
    }
    EXPECT_LE(last, 0.7);
}

TEST(PyramidFile, EveryPrefixDecodesAndMoreBytesTellMore) {
    const std::uint64_t head = ContainerReader::open(large_file())->head_size();
    double last = 1e9;
    bool opened = false;
    for (std::uint64_t n = head + 50; n < large_file().size(); n += large_file().size() / 12) {
        const auto file = RasterFile::open(source_of(large_file()), n);
        if (!file.ok()) {
            EXPECT_FALSE(opened);
            continue;
        }
        opened = true;
        const auto decoded = file->decode(0);
        ASSERT_TRUE(decoded.ok()) << decoded.error().text();
        const Measure found = *measure(large(), *decoded);
        EXPECT_LE(found.rms_error, 1.01 * last) << "of " << n << " bytes";
        EXPECT_LE(found.max_error, file->bound(0).value_or(1e9));
        last = found.rms_error;
    }
    EXPECT_TRUE(opened);
}

TEST(PyramidFile, WindowsAreCropsToTheBit) {
    for (const bool exact : {false, true}) {
        const Bytes bytes = exact ? encode_raster(landscape(120, 140, 2),
                                                  {.spec = {{.id = SchemeId::Cubic, .exact = true}},
                                                   .goal = {Kind::RmsError, 0.7}})
                                        ->bytes
                                  : large_file();
        const auto file = *RasterFile::open(bytes);
        test::Noise noise(5);
        for (int level = 0; level <= file.layout().levels(); ++level) {
            const Raster whole = *file.decode(level);
            for (int k = 0; k < 4; ++k) {
                const auto part = [&](std::int64_t n) {
                    return static_cast<std::int64_t>((noise() + 1) / 2 * static_cast<double>(n));
                };
                LatticeBox box{part(whole.rows), part(whole.cols), 0, 0};
                box.rows = 1 + part(std::min<std::int64_t>(whole.rows - box.row0, 200));
                box.cols = 1 + part(std::min<std::int64_t>(whole.cols - box.col0, 200));
                const auto window = file.decode_window(level, box);
                ASSERT_TRUE(window.ok());
                for (std::size_t p = 0; p < whole.planes.size(); ++p)
                    for (std::int64_t r = 0; r < box.rows; ++r)
                        for (std::int64_t c = 0; c < box.cols; ++c)
                            ASSERT_EQ(window->raster.planes[p](r, c),
                                      whole.planes[p](box.row0 + r, box.col0 + c));
            }
        }
    }
}

/// Remembers which bytes were read.
class WatchedSource final : public ByteSource {
  public:
    explicit WatchedSource(Bytes bytes) : source_(std::move(bytes)) {}
    [[nodiscard]] std::uint64_t size() const override { return source_.size(); }
    Status read(std::uint64_t offset, std::span<std::uint8_t> into) const override {
        const std::lock_guard lock(mutex_);
        read_ += into.size();
        return source_.read(offset, into);
    }
    [[nodiscard]] std::uint64_t bytes_read() const { return read_; }

  private:
    MemorySource source_;
    mutable std::mutex mutex_;
    mutable std::uint64_t read_ = 0;
};

TEST(PyramidFile, WindowsAndCoarseLevelsReadTheirStreamsOnly) {
    const auto small = std::make_shared<WatchedSource>(large_file());
    ASSERT_TRUE(RasterFile::open(small)->decode_window(0, {100, 100, 60, 60}).ok());
    // Of four tiles one, and all that is coarse.
    EXPECT_LT(small->bytes_read(), large_file().size() / 2);
    const auto coarse = std::make_shared<WatchedSource>(large_file());
    ASSERT_TRUE(RasterFile::open(coarse)->decode(3).ok());
    EXPECT_LT(coarse->bytes_read(), large_file().size() / 10);
}

TEST(PyramidFile, DamageCostsATileAndIsNamed) {
    const ContainerReader container = *ContainerReader::open(large_file());
    const Raster whole = *RasterFile::open(large_file())->decode(0);
    int hurt = 0;
    for (std::size_t k = 1; k < container.chunks().size(); k += 5) {
        const ChunkInfo& chunk = container.chunks()[k];
        if (chunk.length == 0) continue;
        Bytes bytes = large_file();
        bytes[chunk.offset + chunk.length / 2] ^= 0x10;
        const auto file = RasterFile::open(bytes);
        ASSERT_TRUE(file.ok());
        EXPECT_FALSE(file->checksums_ok());
        const auto decoded = file->decode_window(0, {0, 0, whole.rows, whole.cols});
        if (k == 1) {
            EXPECT_EQ(decoded.error().code, ErrorCode::BadFile);
            continue;
        }
        ASSERT_TRUE(decoded.ok()) << decoded.error().text();
        ASSERT_EQ(decoded->damaged.size(), 1U);
        EXPECT_EQ(file->decode(0).error().code, ErrorCode::BadFile);
        const LatticeBox& box = decoded->damaged[0];
        hurt += box.rows < whole.rows;
        // Synthesis carries details of levels 1 to 3 twelve coefficients of each far.
        constexpr std::int64_t reach = 12 * (2 + 4 + 8);
        for (std::int64_t r = 0; r < whole.rows; ++r)
            for (std::int64_t c = 0; c < whole.cols; ++c) {
                const bool far = r < box.row0 - reach || r >= box.row0 + box.rows + reach ||
                                 c < box.col0 - reach || c >= box.col0 + box.cols + reach;
                if (!far) continue;
                ASSERT_EQ(decoded->raster.planes[0](r, c), whole.planes[0](r, c));
            }
        // What is known of the other layers is used.
        EXPECT_LT(measure(large(), decoded->raster)->rms_error, 150);
    }
    EXPECT_GT(hurt, 1);
}

TEST(PyramidFile, SameBytesForAnyThreadCount) {
    const Raster raster = landscape(790, 120, 2);
    std::vector<Bytes> files;
    for (const int threads : {1, 3}) {
        set_thread_count(threads);
        files.push_back(
            encode_raster(raster, {.goal = {Kind::Bytes, 30000}, .effort = Effort::Select})->bytes);
    }
    set_thread_count(0);
    EXPECT_EQ(files[0], files[1]);
    EXPECT_LE(files[0].size(), 30000U);
    EXPECT_GE(files[0].size(), 29850U);
}

}  // namespace
}  // namespace relief::codec
