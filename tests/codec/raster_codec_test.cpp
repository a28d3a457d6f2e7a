#include "relief/codec/raster_codec.h"

#include <algorithm>
#include <functional>
#include <limits>

#include "relief/codec/container.h"
#include "relief/core/parallel.h"
#include "support.h"

namespace relief::codec {
namespace {

using multires::Move;
using multires::SchemeId;
using multires::SchemeSpec;
using test::Noise;
using Kind = Goal::Kind;

constexpr SampleType kTypes[] = {SampleType::UInt8,  SampleType::UInt16, SampleType::Int16,
                                 SampleType::UInt32, SampleType::Int32,  SampleType::Float32,
                                 SampleType::Float64};

/// Hills and noise over part of the range of a type; holes where `hole_share` of the noise falls.
Raster landscape(std::int64_t rows, std::int64_t cols, SampleType type, int components,
                 double hole_share, std::uint64_t seed) {
    const double low = is_integer(type) ? sample_range(type).first : -1000;
    const double high = is_integer(type) ? std::min(sample_range(type).second, 1e9) : 3000;
    Noise noise(seed);
    Raster raster;
    raster.rows = rows;
    raster.cols = cols;
    raster.type = type;
    for (int k = 0; k < components; ++k) {
        Grid<double> plane(rows, cols);
        for (std::int64_t r = 0; r < rows; ++r)
            for (std::int64_t c = 0; c < cols; ++c) {
                const double hill = std::sin(0.21 * static_cast<double>(r + k)) *
                                    std::cos(0.17 * static_cast<double>(c));
                plane(r, c) = stored_value(low + (high - low) * (0.5 + 0.4 * hill + 0.05 * noise()),
                                           type, {});
            }
        raster.planes.push_back(std::move(plane));
    }
    if (hole_share > 0) {
        raster.mask = Grid<std::uint8_t>(rows, cols);
        for (std::int64_t r = 0; r < rows; ++r)
            for (std::int64_t c = 0; c < cols; ++c) {
                raster.mask(r, c) =
                    0.5 * (noise() + 1) >= hole_share || (r == rows / 2 && c == cols / 2);
                if (raster.mask(r, c) == 0)
                    for (auto& plane : raster.planes) plane(r, c) = NAN;
            }
    }
    return raster;
}

/// Sizes from one sample on, types, components, holes.
rc::Gen<Raster> any_raster() {
    return rc::gen::apply(
        [](int rows, int cols, int type, int components, int holes, std::uint64_t seed) {
            return landscape(rows, cols, kTypes[type], components, 0.2 * holes, seed);
        },
        rc::gen::inRange(1, 40), rc::gen::inRange(1, 40), rc::gen::inRange(0, 7),
        rc::gen::inRange(1, 4), rc::gen::inRange(0, 3), rc::gen::arbitrary<std::uint64_t>());
}

/// None: what is best for the goal, the closed loop among it.
std::optional<SchemeSpec> any_scheme() {
    SchemeSpec spec;
    if (*rc::gen::inRange(0, 3) == 0) return {};
    spec.id = *rc::gen::element(SchemeId::Box, SchemeId::Barycentric, SchemeId::Cubic);
    if (spec.id == SchemeId::Cubic) {
        spec.exact = *rc::gen::arbitrary<bool>();
        return spec;
    }
    spec.order = *rc::gen::inRange(1, 3);
    spec.data_map =
        *rc::gen::element(multires::DataMap::Interpolate, multires::DataMap::QuasiInterpolate);
    return spec;
}

double spread(const Raster& raster) {
    double low = INFINITY;
    double high = -INFINITY;
    for (const auto& plane : raster.planes)
        for (std::int64_t r = 0; r < raster.rows; ++r)
            for (std::int64_t c = 0; c < raster.cols; ++c)
                if (raster.valid(r, c)) {
                    low = std::min(low, plane(r, c));
                    high = std::max(high, plane(r, c));
                }
    return high - low;
}

struct Errors {
    double max = 0;
    double square = 0;
    bool same_bits = true;
};

Errors errors(const Raster& original, const Raster& decoded) {
    Errors found;
    for (std::size_t p = 0; p < original.planes.size(); ++p)
        for (std::int64_t r = 0; r < original.rows; ++r)
            for (std::int64_t c = 0; c < original.cols; ++c) {
                if (!original.valid(r, c)) continue;
                const double before = original.planes[p](r, c);
                const double after = decoded.planes[p](r, c);
                found.max = std::max(found.max, std::abs(after - before));
                found.square += (after - before) * (after - before);
                found.same_bits = found.same_bits && before == after &&
                                  std::signbit(before) == std::signbit(after);
            }
    return found;
}

Raster decoded(const Bytes& bytes, int level = 0) {
    const auto file = RasterFile::open(bytes);
    RC_ASSERT(file.ok());
    auto raster = file->decode(level);
    RC_ASSERT(raster.ok());
    return *std::move(raster);
}

EncodedRaster encoded(const Raster& raster, const std::optional<SchemeSpec>& spec, Goal goal) {
    auto result = encode_raster(raster, {.spec = spec, .goal = goal});
    if (!result.ok()) RC_FAIL(result.error().text());
    return *std::move(result);
}

void prop(const char* what, const std::function<void()>& property) {
    EXPECT_TRUE(rc::check(what, property));
}

TEST(RasterCodec, MaxErrorHoldsAtEveryValidSample) {
    prop("largest error <= bound, and as reported", [] {
        const Raster raster = *any_raster();
        const double bound = spread(raster) * std::pow(10.0, -*rc::gen::inRange(0, 9));
        const auto file = encoded(raster, any_scheme(), {Kind::MaxError, bound});
        const Errors found = errors(raster, decoded(file.bytes));
        RC_ASSERT(found.max <= bound);
        RC_ASSERT(found.max == file.report.max_error);
        RC_ASSERT(file.report.bound == bound);
    });
}

TEST(RasterCodec, RmsErrorIsMet) {
    prop("root mean square error <= goal, and as reported", [] {
        const Raster raster = *any_raster();
        const double goal = spread(raster) * std::pow(10.0, -*rc::gen::inRange(1, 20));
        const auto file = encoded(raster, any_scheme(), {Kind::RmsError, goal});
        const Errors found = errors(raster, decoded(file.bytes));
        const double rms = std::sqrt(found.square / static_cast<double>(raster.valid_count()));
        // Rows are summed one by one there.
        RC_ASSERT(rms <= goal * (1 + 1e-12));
        RC_ASSERT(std::abs(rms - file.report.rms_error) <= 1e-12 * rms);
    });
}

TEST(RasterCodec, LosslessIsExactToTheBit) {
    prop("every bit returns", [] {
        Raster raster = *any_raster();
        if (!is_integer(raster.type))
            for (std::int64_t c = 0; c < raster.cols; c += 3)
                if (raster.valid(0, c))
                    raster.planes[0](0, c) =
                        c % 2 == 0 ? -0.0 : std::numeric_limits<float>::denorm_min();
        const auto file = encoded(raster, any_scheme(), {Kind::Lossless, 0});
        const Raster after = decoded(file.bytes);
        RC_ASSERT(errors(raster, after).same_bits);
        RC_ASSERT(after.type == raster.type);
        for (std::int64_t r = 0; r < raster.rows; ++r)
            for (std::int64_t c = 0; c < raster.cols; ++c)
                RC_ASSERT(after.valid(r, c) == raster.valid(r, c));
    });
}

TEST(RasterCodec, ByteGoalsAreKept) {
    prop("size <= goal, or told that none is that small", [] {
        const Raster raster = *any_raster();
        const double goal = *rc::gen::inRange(1, 5000);
        const auto file =
            encode_raster(raster, {.spec = any_scheme(), .goal = {Kind::Bytes, goal}});
        if (!file.ok()) {
            RC_ASSERT(file.error().code == ErrorCode::InvalidArgument);
            return;
        }
        RC_ASSERT(static_cast<double>(file->bytes.size()) <= goal);
        RC_ASSERT(file->report.bytes == file->bytes.size());
        RC_ASSERT(errors(raster, decoded(file->bytes)).max == file->report.max_error);
    });
}

TEST(RasterCodec, EveryLevelDecodesFromThePrefixThatItNames) {
    prop("decode(level) of bytes_for(level) bytes is that of the whole file, within its bound", [] {
        const Raster raster = *any_raster();
        const auto coded = encoded(raster, any_scheme(), {Kind::MaxError, 0.01 * spread(raster)});
        const auto whole = RasterFile::open(coded.bytes);
        RC_ASSERT(whole.ok());
        for (int level = whole->layout().levels(); level >= 0; --level) {
            const auto part = RasterFile::open(std::make_shared<MemorySource>(coded.bytes),
                                               whole->bytes_for(level));
            RC_ASSERT(part.ok());
            // Coarse levels share chunks.
            RC_ASSERT(part->finest_level() <= level);
            RC_ASSERT(part->bytes_for(level) == whole->bytes_for(level));
            const auto a = whole->decode(level);
            const auto b = part->decode(level);
            RC_ASSERT(a.ok() && b.ok());
            RC_ASSERT(whole->bound(level) == part->bound(level));
            const std::int64_t step = std::int64_t{1} << level;
            for (std::size_t p = 0; p < a->planes.size(); ++p)
                for (std::int64_t r = 0; r < a->rows; ++r)
                    for (std::int64_t c = 0; c < a->cols; ++c) {
                        if (!raster.valid(r * step, c * step)) continue;
                        RC_ASSERT(a->planes[p](r, c) == b->planes[p](r, c));
                        RC_ASSERT(
                            std::abs(a->planes[p](r, c) - raster.planes[p](r * step, c * step)) <=
                            *whole->bound(level));
                    }
            // The whole raster from the prefix.
            const auto full = part->decode(0);
            RC_ASSERT(full.ok());
            RC_ASSERT(part->bound(0).has_value() || !part->closed_loop());
            if (part->bound(0)) RC_ASSERT(errors(raster, *full).max <= *part->bound(0));
        }
    });
}

TEST(RasterCodec, SameBytesForAnyThreadCount) {
    const Raster raster = landscape(150, 170, SampleType::Float32, 2, 0.1, 5);
    std::vector<Bytes> files;
    for (const int threads : {1, 2, 5}) {
        set_thread_count(threads);
        const auto file = encode_raster(raster, {.goal = {Kind::MaxError, 3}});
        ASSERT_TRUE(file.ok());
        files.push_back(file->bytes);
    }
    set_thread_count(0);
    EXPECT_EQ(files[0], files[1]);
    EXPECT_EQ(files[0], files[2]);
}

TEST(RasterCodec, DescriptionSurvives) {
    Raster raster = landscape(9, 8, SampleType::Int16, 2, 0, 1);
    raster.nodata = -32768;
    raster.geo.transform = {{1.5, 0.1, 1e-17, -7.25, 3, 1.0 / 3}};
    raster.geo.crs = "LOCAL_CS[\"mine\"]";
    raster.geo.pixel_is_point = true;
    raster.unit = "ft";
    raster.scale = 0.1;
    raster.offset = -1000.0 / 3;
    raster.band_names = {"first", "zwölf"};
    raster.metadata = {{"b", "2"}, {"a", "x=y"}};
    const auto file = RasterFile::open(encode_raster(raster, {.goal = {Kind::Lossless, 0}})->bytes);
    ASSERT_TRUE(file.ok());
    const Raster& about = file->description();
    EXPECT_EQ(about.rows, 9);
    EXPECT_EQ(about.cols, 8);
    EXPECT_EQ(about.type, raster.type);
    EXPECT_EQ(about.nodata, raster.nodata);
    EXPECT_EQ(about.geo, raster.geo);
    EXPECT_EQ(about.unit, raster.unit);
    EXPECT_EQ(about.scale, raster.scale);
    EXPECT_EQ(about.offset, raster.offset);
    EXPECT_EQ(about.band_names, raster.band_names);
    EXPECT_EQ(about.metadata, raster.metadata);
    EXPECT_EQ(file->goal().kind, Kind::Lossless);
    EXPECT_EQ(file->layout().components, 2);
}

TEST(RasterCodec, NodataThatIsNotANumberSurvives) {
    Raster raster = landscape(5, 6, SampleType::Float32, 1, 0.3, 2);
    for (const double nodata : {static_cast<double>(NAN), static_cast<double>(INFINITY),
                                -static_cast<double>(INFINITY)}) {
        raster.nodata = nodata;
        const auto file =
            RasterFile::open(encode_raster(raster, {.goal = {Kind::MaxError, 1}})->bytes);
        ASSERT_TRUE(file.ok());
        const double read = *file->description().nodata;
        EXPECT_TRUE(read == nodata || (std::isnan(read) && std::isnan(nodata)));
    }
}

TEST(RasterCodec, MovesAreALayer) {
    prop("moves add their displacement, in any order of adding", [] {
        const Raster raster =
            landscape(*rc::gen::inRange(2, 40), *rc::gen::inRange(2, 40), SampleType::Float64, 2, 0,
                      *rc::gen::arbitrary<std::uint64_t>());
        const auto coded = encoded(raster, any_scheme(), {Kind::RmsError, 5});
        const auto file = RasterFile::open(coded.bytes);
        RC_ASSERT(file.ok());
        std::vector<Move> moves(static_cast<std::size_t>(*rc::gen::inRange(1, 4)));
        for (Move& move : moves) {
            move.level = *rc::gen::inRange(0, file->layout().levels() + 1);
            const LatticeBox box = multires::scaling_box(file->layout(), move.level);
            move.row = box.row0 + *rc::gen::inRange<std::int64_t>(0, box.rows);
            move.col = box.col0 + *rc::gen::inRange<std::int64_t>(0, box.cols);
            move.delta = {*rc::gen::inRange(-50, 50) / 4.0, *rc::gen::inRange(-50, 50) / 4.0};
        }
        const auto at_once = add_moves(coded.bytes, moves);
        RC_ASSERT(at_once.ok());
        Bytes one_by_one = coded.bytes;
        for (const Move& move : moves) {
            const auto next = add_moves(one_by_one, {move});
            RC_ASSERT(next.ok());
            one_by_one = *next;
        }
        RC_ASSERT(*at_once == one_by_one);

        const auto edited = RasterFile::open(*at_once);
        RC_ASSERT(edited.ok() && edited->checksums_ok() && !edited->bound(0));
        RC_ASSERT(edited->moves().size() == moves.size());
        const auto change = multires::samples_of(
            file->layout(), multires::displacement<double>(file->layout(), moves, 0), 0);
        const Raster before = *file->decode(0);
        const Raster after = *edited->decode(0);
        for (std::size_t p = 0; p < 2; ++p)
            for (std::int64_t r = 0; r < raster.rows; ++r)
                for (std::int64_t c = 0; c < raster.cols; ++c)
                    // One addition to a number below 2^13.
                    RC_ASSERT(std::abs(after.planes[p](r, c) - before.planes[p](r, c) -
                                       change[p](r, c)) <= 0x1p-39);
    });
}

TEST(RasterCodec, MovesThatCanNotBeAreRefused) {
    const Bytes file =
        encode_raster(landscape(20, 20, SampleType::Int16, 1, 0, 1), {.goal = {Kind::MaxError, 2}})
            ->bytes;
    for (const Move& move : {Move{.level = -1}, Move{.level = 99}, Move{.level = 1, .row = 1000},
                             Move{.level = 0, .col = -1}, Move{.delta = {NAN}},
                             Move{.delta = {0, 0, 0, INFINITY}}, Move{.delta = {1e301}}}) {
        const auto moved = add_moves(file, {move});
        ASSERT_FALSE(moved.ok());
        EXPECT_EQ(moved.error().code, ErrorCode::InvalidArgument) << moved.error().text();
    }
}

TEST(RasterCodec, GoalsAndRastersThatCanNotBeAreRefused) {
    const Raster raster = landscape(8, 8, SampleType::Float64, 1, 0, 1);
    const auto refused = [](const Raster& what, Goal goal, SchemeSpec spec = {}) {
        const auto result = encode_raster(what, {.spec = spec, .goal = goal});
        return result.ok() ? std::optional<ErrorCode>() : result.error().code;
    };
    for (const Kind kind : {Kind::Keep, Kind::RmsError, Kind::MaxError, Kind::Bytes})
        for (const double value : {-1.0, static_cast<double>(NAN), static_cast<double>(INFINITY)})
            EXPECT_EQ(refused(raster, {kind, value}), ErrorCode::InvalidArgument);
    EXPECT_EQ(refused(raster, {Kind::Lossless, 0}, {.order = 7}), ErrorCode::InvalidArgument);
    EXPECT_EQ(refused(raster, {Kind::Lossless, 0}, {.levels = 70}), ErrorCode::InvalidArgument);
    EXPECT_EQ(refused({}, {Kind::Lossless, 0}), ErrorCode::BadInput);
    for (const double value : {static_cast<double>(NAN), static_cast<double>(-INFINITY), 1e46}) {
        Raster bad = landscape(8, 8, SampleType::Float64, 1, 0, 1);
        bad.planes[0](3, 4) = value;
        EXPECT_EQ(refused(bad, {Kind::Lossless, 0}), ErrorCode::BadInput);
        // Where it is marked as a hole it does no harm.
        bad.mask = Grid<std::uint8_t>(8, 8, std::uint8_t{1});
        bad.mask(3, 4) = 0;
        EXPECT_EQ(refused(bad, {Kind::Lossless, 0}), std::nullopt);
    }
    Raster holes = landscape(4, 4, SampleType::Float64, 1, 0, 1);
    holes.mask = Grid<std::uint8_t>(4, 4, std::uint8_t{0});
    EXPECT_EQ(refused(holes, {Kind::Lossless, 0}), ErrorCode::BadInput);
}

/// At loose bounds the smaller of both loops is written, unless something else was asked for.
TEST(RasterCodec, LooseBoundsTryBothLoops) {
    const Raster raster = landscape(300, 260, SampleType::Float32, 1, 0, 5);
    EncodeOptions options{.goal = {Kind::MaxError, 400}};
    const EncodedRaster best = *encode_raster(raster, options);
    EXPECT_FALSE(best.report.closed_loop);
    EXPECT_LE(best.report.max_error, 400);
    options.profile = Profile::Fast;
    EXPECT_TRUE(encode_raster(raster, options)->report.closed_loop);
    options.profile = Profile::Dense;
    options.spec = SchemeSpec{.id = SchemeId::Fvs};
    const EncodedRaster closed = *encode_raster(raster, options);
    EXPECT_TRUE(closed.report.closed_loop);
    EXPECT_LT(best.bytes.size(), closed.bytes.size());
}

TEST(RasterCodec, LargestSamplesSurvive) {
    Raster raster = landscape(12, 12, SampleType::Float64, 1, 0, 1);
    for (std::int64_t r = 0; r < 12; ++r)
        for (std::int64_t c = 0; c < 12; ++c)
            raster.planes[0](r, c) = (r + c) % 2 == 0 ? 1e45 : -1e45;
    for (const SchemeId id :
         {SchemeId::Box, SchemeId::Barycentric, SchemeId::Cubic, SchemeId::Fvs}) {
        const SchemeSpec spec{.id = id};
        const auto file = encode_raster(raster, {.spec = spec, .goal = {Kind::Lossless, 0}});
        ASSERT_TRUE(file.ok()) << file.error().text();
        EXPECT_TRUE(errors(raster, *RasterFile::open(file->bytes)->decode(0)).same_bits);
    }
}

TEST(RasterCodec, ProgressCancels) {
    const Raster raster = landscape(30, 30, SampleType::Float32, 1, 0, 1);
    for (const Kind kind : {Kind::RmsError, Kind::MaxError, Kind::Bytes, Kind::Keep}) {
        double last = 0;
        bool rising = true;
        const auto watch = [&](double done) {
            rising = rising && done >= last && done <= 1;
            last = done;
            return true;
        };
        ASSERT_TRUE(encode_raster(raster, {.goal = {kind, 1500}, .progress = watch}).ok());
        EXPECT_TRUE(rising);
        EXPECT_EQ(last, 1);
        const auto stopped =
            encode_raster(raster, {.goal = {kind, 1500}, .progress = [](double) { return false; }});
        ASSERT_FALSE(stopped.ok());
        EXPECT_EQ(stopped.error().code, ErrorCode::Cancelled);
    }
}

}  // namespace
}  // namespace relief::codec
