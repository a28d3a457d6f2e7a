// Encodes a raster so that no sample is off by more than MAX_ERROR, opens the file again and asks
// the surface for a height and its slope. usage: quickstart RASTER OUT.relief MAX_ERROR ROW COLUMN
#include <cstdio>
#include <cstdlib>

#include "relief/codec/raster_codec.h"
#include "relief/io/file.h"
#include "relief/io/raster.h"
#include "relief/multires/surface.h"

relief::Status run(const char* raster_path, const char* relief_path, double max_error, double row,
                   double column) {
    using namespace relief;
    RELIEF_TRY(const Raster dem, io::read_raster(raster_path));
    codec::EncodeOptions options;
    options.goal = {codec::Goal::Kind::MaxError, max_error};
    RELIEF_TRY(const auto encoded, codec::encode_raster(dem, options));
    RELIEF_CHECK(io::write_file_atomically(relief_path, encoded.bytes));
    std::printf("%zu bytes, every sample within %g\n", encoded.bytes.size(), encoded.report.bound);

    RELIEF_TRY(auto bytes, io::read_file(relief_path));
    RELIEF_TRY(const auto file, codec::RasterFile::open(std::move(bytes)));
    RELIEF_TRY(const auto net, file.control_net());
    RELIEF_TRY(const auto surface,
               multires::Surface<double>::create(file.layout().spec, net[0].view()));
    const auto at = surface.jet(row, column);  // any point, not only samples
    std::printf("height %.3f, slope %.3f a row and %.3f a column\n", at.value, at.di, at.dj);
    return {};
}

int main(int argc, char** argv) {
    if (argc != 6) return 2;
    const relief::Status done =
        run(argv[1], argv[2], std::atof(argv[3]), std::atof(argv[4]), std::atof(argv[5]));
    if (done.ok()) return 0;
    std::fprintf(stderr, "quickstart: %s\n", done.error().text().c_str());
    return 1;
}
