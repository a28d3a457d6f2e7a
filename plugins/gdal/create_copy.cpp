#include "create_copy.h"

#include <cpl_conv.h>
#include <cpl_string.h>
#include <fmt/format.h>

#include <array>
#include <cmath>
#include <utility>

#include "dataset.h"
#include "relief/codec/raster_codec.h"
#include "relief/io/file.h"
#include "relief/io/gdal.h"
#include "report.h"

namespace relief::gdal {

const char* const kCreationOptions =
    "<CreationOptionList>"
    "<Option name='MAX_Z_ERROR' type='float' description='Largest error of any pixel, verified; 0: "
    "none'/>"
    "<Option name='RMSE' type='float' description='Largest root mean square error'/>"
    "<Option name='BYTES' type='int' description='Largest size of the file'/>"
    "<Option name='LOSSLESS' type='boolean' default='YES' description='Every pixel exactly; the "
    "default without another goal'/>"
    "<Option name='SCHEME' type='string-select' description='Kind of surface; by default the best "
    "for the goal'><Value>FVS</Value><Value>CUBIC</Value><Value>BOX</Value>"
    "<Value>BARYCENTRIC</Value></Option>"
    "<Option name='PROFILE' type='string-select' default='DENSE' description='FAST: several times "
    "the speed, about 8 % larger (of scheme FVS)'><Value>DENSE</Value><Value>FAST</Value></Option>"
    "</CreationOptionList>";

namespace {

Error wrong(std::string message) {
    return {ErrorCode::InvalidArgument, std::move(message), ""};
}

Result<codec::Goal> goal_of(CSLConstList options) {
    using Kind = codec::Goal::Kind;
    constexpr std::array<std::pair<const char*, Kind>, 3> goals = {
        {{"MAX_Z_ERROR", Kind::MaxError}, {"RMSE", Kind::RmsError}, {"BYTES", Kind::Bytes}}};
    const char* lossless = CSLFetchNameValue(options, "LOSSLESS");
    codec::Goal goal{Kind::Lossless, 0};
    int named = lossless && CPLTestBool(lossless) ? 1 : 0;
    for (const auto& [name, kind] : goals) {
        const char* text = CSLFetchNameValue(options, name);
        if (!text) continue;
        ++named;
        char* end = nullptr;
        goal = {kind, CPLStrtod(text, &end)};
        if (end == text || *end != '\0' || !std::isfinite(goal.value))
            return wrong(fmt::format("{} takes a number, not '{}'", name, text));
    }
    if (named > 1) return wrong("give one of MAX_Z_ERROR, RMSE, BYTES and LOSSLESS");
    if (named == 0 && lossless) return wrong("LOSSLESS=NO needs MAX_Z_ERROR, RMSE or BYTES");
    if (goal.kind == Kind::MaxError && goal.value == 0) goal.kind = Kind::Lossless;
    return goal;
}

Result<codec::EncodeOptions> encode_options(CSLConstList options) {
    codec::EncodeOptions encode;
    RELIEF_TRY(encode.goal, goal_of(options));
    if (const char* scheme = CSLFetchNameValue(options, "SCHEME")) {
        encode.spec.emplace();
        RELIEF_TRY(encode.spec->id, multires::scheme_from_name(CPLString(scheme).tolower()));
    }
    const char* profile = CSLFetchNameValueDef(options, "PROFILE", "DENSE");
    if (!EQUAL(profile, "DENSE") && !EQUAL(profile, "FAST"))
        return wrong(fmt::format("PROFILE is DENSE or FAST, not '{}'", profile));
    encode.profile = EQUAL(profile, "FAST") ? codec::Profile::Fast : codec::Profile::Dense;
    return encode;
}

Status encode(const std::string& path, GDALDataset* source, const codec::EncodeOptions& options) {
    RELIEF_TRY(const io::RasterReader reader, io::reader_of(source));
    RELIEF_TRY(io::OutputFile sink, io::OutputFile::create(path));
    io::FileSpool spool(path);
    RELIEF_TRY(const auto made, codec::encode_raster(reader, options, sink, spool));
    (void)made;
    return sink.commit();
}

/// What the file has no place for, such as ground control points, is kept beside it by GDAL. Its
/// own metadata would make CloneInfo believe that there is nothing to add: it has all of them.
void clone_rest(GDALDataset* source, Dataset& copy) {
    copy.CloneInfo(source, GCIF_PAM_DEFAULT &
                               ~(GCIF_GEOTRANSFORM | GCIF_PROJECTION | GCIF_METADATA | GCIF_MASK));
    if (char** rpc = source->GetMetadata("RPC")) copy.SetMetadata(rpc, "RPC");
}

}  // namespace

GDALDataset* create_copy(const char* path, GDALDataset* source, int /*strict*/, char** list,
                         GDALProgressFunc progress, void* progress_data) {
    return guarded<GDALDataset*>(nullptr, [&]() -> GDALDataset* {
        set_threads();
        auto options = encode_options(list);
        if (options.ok())
            options->progress = [&](double done) {
                return progress(done, "", progress_data) != FALSE;
            };
        const Status made = options.ok() ? encode(path, source, *options) : options.error();
        if (!made.ok()) {
            report(made.error(), path);
            return nullptr;
        }
        GDALOpenInfo info(path, GDAL_OF_RASTER | GDAL_OF_READONLY);
        auto* copy = static_cast<Dataset*>(Dataset::open(&info));
        if (copy) clone_rest(source, *copy);
        return copy;
    });
}

}  // namespace relief::gdal
