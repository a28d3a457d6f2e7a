// A program of somebody else: a raster becomes a file and a raster again. usage: consumer OUT.tif
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>

#include "relief/codec/raster_codec.h"
#include "relief/core/version.h"
#include "relief/edit/session.h"
#include "relief/io/raster.h"
#include "relief/io/synthetic.h"

namespace {

constexpr double kBound = 0.001;

relief::Status run(const char* path) {
    using namespace relief;
    const Raster surface = io::franke(65);
    codec::EncodeOptions options;
    options.goal = {codec::Goal::Kind::MaxError, kBound};
    RELIEF_TRY(auto encoded, codec::encode_raster(surface, options));
    RELIEF_TRY(const auto file, codec::RasterFile::open(std::move(encoded.bytes)));
    RELIEF_TRY(const Raster decoded, file.decode(0));
    double worst = 0;
    for (std::int64_t row = 0; row < 65; ++row)
        for (std::int64_t col = 0; col < 65; ++col)
            worst = std::max(worst,
                             std::abs(decoded.planes[0](row, col) - surface.planes[0](row, col)));
    RELIEF_CHECK(io::write_raster(path, decoded));
    std::printf("relief %s: within the bound: %s\n", library_version(),
                worst > 0 && worst <= kBound ? "yes" : "no");
    return {};
}

}  // namespace

int main(int count, char** arguments) {
    char headers[32];
    std::snprintf(headers, sizeof headers, "%d.%d.%d", RELIEF_VERSION_MAJOR, RELIEF_VERSION_MINOR,
                  RELIEF_VERSION_PATCH);
    if (count != 2 || std::strcmp(headers, relief::library_version()) != 0) return 2;
    const relief::Status done = run(arguments[1]);
    if (!done.ok()) std::fprintf(stderr, "%s\n", done.error().text().c_str());
    return done.ok() ? 0 : 1;
}
