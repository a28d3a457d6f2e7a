#include <fmt/format.h>

#include "command.h"
#include "mesh_verbs.h"
#include "relief/io/mesh.h"
#include "relief/mesh/repair.h"
#include "relief/multires/polygon_subdivision.h"

namespace relief::cli {

namespace {

struct Subdivide {
    std::string in;
    std::string out;
    std::string scheme;
    int levels = 1;
    bool limit = false;
    bool corners = false;
    bool repair = false;
};

Result<Outcome> run(const Subdivide& options) {
    const Stopwatch watch;
    RELIEF_TRY(PolygonMesh polygons, read_polygons(options.in));
    if (options.repair) polygons = mesh::repair(polygons).mesh;
    RELIEF_TRY(const multires::MeshScheme scheme, multires::mesh_scheme_from_name(options.scheme));
    const auto fine =
        multires::subdivide(polygons, {scheme}, {options.levels, options.limit, options.corners});
    if (!fine.ok()) return located(fine.error(), options.in);
    RELIEF_TRY(const auto missing, io::write_mesh(options.out, *fine));
    Outcome outcome;
    outcome.json = Json{{"vertices", fine->vertices.size()},
                        {"faces", fine->polygon_count()},
                        {"left_out", missing},
                        {"seconds", watch.seconds()}};
    outcome.text = fmt::format("{}: {} vertices, {} faces\n", options.out,
                               grouped(static_cast<std::int64_t>(fine->vertices.size())),
                               grouped(fine->polygon_count())) +
                   left_out(missing);
    return outcome;
}

}  // namespace

void add_subdivide(Program& program) {
    auto options = std::make_shared<Subdivide>();
    CLI::App* verb =
        add_verb(program, "subdivide",
                 "Subdivide a mesh: smooth surfaces with boundaries, creases and corners.",
                 "  relief subdivide cube.obj smooth.ply --scheme catmull-clark --levels 4\n"
                 "  relief subdivide model.stl limit.glb --scheme loop --levels 2 --limit",
                 [options] { return run(*options); });
    verb->add_option("IN", options->in, "a mesh (.obj, .off, .ply, .stl) or a .relief file of one")
        ->required();
    verb->add_option("OUT", options->out, "the mesh: .obj, .off, .ply, .stl, .glb")->required();
    verb->add_option("--scheme", options->scheme,
                     "sqrt3 and loop for triangles, catmull-clark for all polygons")
        ->required()
        ->check(CLI::IsMember({"sqrt3", "loop", "catmull-clark"}));
    verb->add_option("--levels", options->levels, "how often (default 1)")
        ->check(CLI::Range(0, 30));
    verb->add_flag("--limit", options->limit,
                   "move the vertices to where they go in the end, with the normals there");
    verb->add_flag("--boundary-corners", options->corners,
                   "boundary vertices of one face stay where they are");
    verb->add_flag("--repair", options->repair,
                   "first mend what is no oriented manifold: see 'relief info'");
}

}  // namespace relief::cli
