#pragma once

#include <array>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "command.h"
#include "relief/codec/polygons.h"
#include "relief/codec/ps_codec.h"
#include "relief/core/polygon_mesh.h"
#include "relief/io/image.h"
#include "relief/io/points.h"
#include "relief/mesh/triangulation.h"
#include "relief/multires/ps_surface.h"

/// The verbs on scattered points and on .relief files of Powell-Sabin splines. The verbs' own files
/// parse the options and come here by what the input is.
namespace relief::cli {

/// A .relief file that holds a Powell-Sabin spline. False for anything else, also if it is damaged.
[[nodiscard]] bool holds_ps(const std::string& path);
/// A file of scattered points.
[[nodiscard]] bool is_points(const std::string& path);

[[nodiscard]] Result<codec::PsFile> open_ps(const std::string& path,
                                            std::optional<std::uint64_t> max_bytes = {});

/// A level of a file, ready to be evaluated.
struct PsLevel {
    std::unique_ptr<const codec::PsSurface> data;
    multires::ps::Surface surface;

    [[nodiscard]] const multires::ps::Space& space() const { return data->space; }
};
[[nodiscard]] Result<PsLevel> open_level(const codec::PsFile& file, int level);

/// "X,Y,VALUE[,WEIGHT]" or "U,V,X,Y,Z[,WEIGHT]": names or numbers of columns. Empty: those with
/// well-known names.
[[nodiscard]] Result<io::PointColumns> columns_of(const std::string& text);
/// Says what --columns takes, for --help.
inline constexpr const char* kColumnsHelp =
    "X,Y,VALUE[,WEIGHT] of points: names or numbers (from 1) of columns; default: by known names, "
    "else the first three. U,V,X,Y,Z[,WEIGHT]: a surface in space over the plane of U and V";

/// What coordinates and values are, as options.
struct ReferenceOptions {
    std::string crs = {};
    std::string unit = {};

    void add_to(CLI::App& verb);
    /// Errors: InvalidArgument for a CRS that is not known.
    [[nodiscard]] Result<codec::PsReference> reference() const;

    friend bool operator==(const ReferenceOptions&, const ReferenceOptions&) = default;
};

struct FitVerb {
    std::string in;
    std::string out;
    std::optional<codec::Goal> goal = {};
    std::optional<std::int64_t> vertices = {};
    std::string mesh = {};
    std::optional<double> smoothing = {};
    std::string energy = {};
    std::string gradients = {};
    int levels = 0;
    std::string columns = {};
    ReferenceOptions reference = {};
};
[[nodiscard]] Result<Outcome> fit_points(const FitVerb& verb, const Globals& globals);

struct TrianglesVerb {
    std::string in;
    std::string out;
    codec::Goal goal;
    bool over_uv = false;  ///< in the plane of their texture coordinates; a surface in space
    ReferenceOptions reference = {};
};
/// Triangles over the plane, with values at their vertices.
[[nodiscard]] Result<Outcome> encode_triangles(const TrianglesVerb& verb,
                                               const SchemeOptions& scheme, const Globals& globals);
struct PsDecodeVerb {
    std::string in;
    std::string out;
    int level = 0;
    std::optional<std::uint64_t> max_bytes;
    std::optional<double> cell;
    double scale = 1;
    std::vector<std::int64_t> window;
};
/// By the extension of OUT a mesh, Bezier triangles (.vtu), a table of vertices (.csv) or a raster.
[[nodiscard]] Result<Outcome> decode_ps(const PsDecodeVerb& verb, const Globals& globals);
/// The triangulation of a level with the heights of the spline; for three components the surface in
/// space with its parameters as "uv".
[[nodiscard]] Result<PolygonMesh> polygons_of(const codec::PsFile& file, int level);

/// The six quadratic Bezier triangles of each triangle as a .vtu file, with fields "value" and, of
/// the first component, "gradient".
[[nodiscard]] Status write_bezier(const PsLevel& level, const std::string& path);

[[nodiscard]] Result<Outcome> info_of_ps(const std::string& path);
[[nodiscard]] Result<Outcome> info_of_points(const std::string& path);

/// Points with a surface, at the points; or two surfaces, at the vertices of A and all over it.
[[nodiscard]] Result<Outcome> compare_ps(const std::string& a, const std::string& b,
                                         const std::string& columns);
struct PsEditVerb {
    std::string in;
    std::string out;
    int level = 0;                   ///< of `moves`
    std::vector<std::string> moves;  ///< "INDEX:DZ[,DX,DY]"
    std::string script;              ///< a file with more of them; empty: none
};
[[nodiscard]] Result<Outcome> edit_ps(const PsEditVerb& verb);
/// Writes a file that is `in` with more moves, and says what they did.
[[nodiscard]] Result<Outcome> write_edited_ps(const std::string& in, const std::string& out,
                                              Bytes edited);

/// A level as a raster of about so many columns over its extent.
[[nodiscard]] Result<Raster> picture_raster(const std::string& path, int level, int columns);

struct PsWireVerb {
    int width = 1200;
    double exaggeration = 0;           ///< 0: from the mean slope
    std::optional<double> viewer;      ///< degrees clockwise from north
    std::optional<int> control_level;  ///< its control triangles over the surface
};
/// The surface in perspective with its triangles, or with control triangles.
[[nodiscard]] Result<io::Image> draw_ps(const std::string& path, const PsWireVerb& verb);

}  // namespace relief::cli
