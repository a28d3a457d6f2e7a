#include <filesystem>

#include "conversation.h"
#include "relief/io/drape.h"
#include "relief/io/file.h"
#include "relief/io/png.h"

namespace relief::editor {

namespace {

using Show = edit::View::Show;

/// Graphics cards take textures of this size everywhere.
constexpr int kLargestDrape = 4096;

Status write_text(const std::string& path, const std::string& text) {
    const auto* first = reinterpret_cast<const std::uint8_t*>(text.data());
    return io::write_file_atomically(path, {first, text.size()});
}

const char* suffix_of(Show show) {
    switch (show) {
        case Show::Edited:
            return "-edited";
        case Show::Original:
            return "";
        case Show::Compressed:
            return "-compressed";
    }
    return "";
}

bool is_known(const std::string& format, edit::Kind kind) {
    if (format == "tif") return kind == edit::Kind::Raster;
    return format == "relief" || format == "glb" || format == "obj" || format == "ply";
}

}  // namespace

Result<Bytes> Conversation::shown_file() const {
    const Show show = session_.view().show;
    if (show == Show::Edited) return session_.file();
    const auto& file = show == Show::Original ? document_.file : compressed_;
    if (!file)
        return Error{ErrorCode::Unsupported, "there is no file of the compressed surface", ""};
    Bytes bytes(file->size());
    RELIEF_CHECK(file->read(0, bytes));
    return bytes;
}

Result<std::string> Conversation::export_as(const std::string& format, const std::string& folder,
                                            const FileAccess& files) {
    if (writer_) {
        RELIEF_CHECK(adopt(pages_.at(*writer_)));
    }
    const std::string stem = folder + "/" + std::filesystem::path(document_.name).stem().string();
    if (format == "script") {
        const std::string script = stem + "-script.json";
        RELIEF_CHECK(write_text(script, text_of(session_.script()) + "\n"));
        return script;
    }
    if (!is_known(format, session_.description().kind))
        return Error{ErrorCode::InvalidArgument,
                     "this kind of surface can not be exported as \"" + format + "\"", ""};
    RELIEF_TRY(const Bytes bytes, shown_file());
    const std::string name = stem + suffix_of(session_.view().show);
    const std::string relief = name + ".relief";
    RELIEF_CHECK(io::write_file_atomically(relief, bytes));
    if (format == "relief") return relief;
    const std::string out = name + "." + format;
    RELIEF_CHECK(files.decode(relief, session_.view().level, out));
    return out;
}

Result<Json> Conversation::drape(const std::string& path) {
    const edit::Bounds bounds = session_.bounds();
    Json rect = Json::array({bounds.min.x, bounds.min.y, bounds.max.x, bounds.max.y});
    const auto& tiles = session_.description().tiles;
    if (tiles && !session_.description().parametric) {
        // A raster's picture covers its cells; samples are their middles.
        const auto [dx, dy] = tiles->spacing;
        rect = Json::array({bounds.min.x - dx / 2, bounds.min.y - dy / 2, bounds.max.x + dx / 2,
                            bounds.max.y + dy / 2});
    }
    RELIEF_TRY(
        const io::Image image,
        io::read_drape(path, document_.terrain ? &*document_.terrain : nullptr, kLargestDrape));
    RELIEF_TRY(drape_, io::encode_png(image, io::PngEffort::Fast));
    return Json{{"rect", std::move(rect)}};
}

}  // namespace relief::editor
