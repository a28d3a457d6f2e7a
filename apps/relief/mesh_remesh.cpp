#include <fmt/format.h>

#include <algorithm>

#include "command.h"
#include "mesh_verbs.h"
#include "relief/io/mesh.h"

namespace relief::cli {

std::string repair_text(const mesh::RepairCounts& counts) {
    if (counts.nothing()) return "nothing had to be repaired\n";
    std::string text = "repaired:";
    const auto say = [&](std::uint64_t count, const char* what) {
        if (count > 0)
            text += fmt::format(" {} {},", grouped(static_cast<std::int64_t>(count)), what);
    };
    say(counts.faces_dropped, "bad faces dropped");
    say(counts.duplicates_dropped, "duplicate faces dropped");
    say(counts.corners_dropped, "repeated corners dropped");
    say(counts.faces_added, "faces cut at a repeated corner");
    say(counts.faces_turned, "faces turned");
    say(counts.edges_cut, "edges cut");
    say(counts.edges_split, "edges split");
    say(counts.vertices_added, "vertices split");
    say(counts.vertices_dropped, "unused vertices dropped");
    text.back() = '\n';
    return text;
}

void RemeshFlags::add_to(CLI::App& verb) {
    verb.add_option(
            "--base", base,
            "remeshing: faces of the base mesh, about; default: such that the result has as "
            "many faces as IN, or as an RMS goal needs. More if the tolerance is not met "
            "otherwise")
        ->check(CLI::Range(std::int64_t{1}, std::int64_t{1} << 31));
    verb.add_option("--features", features,
                    "remeshing: edges that turn by more than so many degrees stay sharp; 40 for "
                    "machine parts. Default: none, which is best for scans");
    add_length(verb, "--tolerance", tolerance,
               "remeshing: the largest distance between the surfaces, in data units, or with a d "
               "in diagonals of IN; default: 0.002d, with goals 10 times an RMS error or 0.6 times "
               "a largest one");
}

std::optional<double> RemeshFlags::tolerance_of(const PolygonMesh& mesh) const {
    if (!tolerance) return {};
    const double diagonal = diagonal_of(mesh);
    const bool relative = tolerance->of_diagonal || !(diagonal > 0);
    return relative ? tolerance->value : tolerance->value / diagonal;
}

Json remesh_json(const remesh::Remeshed& remeshed) {
    const remesh::RemeshReport& report = remeshed.report;
    return Json{{"vertices", remeshed.mesh.vertices.size()},
                {"faces", remeshed.mesh.polygon_count()},
                {"base_faces", report.base_faces},
                {"levels", report.levels},
                {"rms_error", report.rms_error},
                {"max_error", report.max_error},
                {"worst", report.worst},
                {"flips", report.flips},
                {"quality", report.quality},
                {"diagonal", report.diagonal},
                {"attempts", report.attempts}};
}

std::string remesh_text(const remesh::Remeshed& remeshed) {
    const remesh::RemeshReport& report = remeshed.report;
    const char* const few = report.vertices < remesh::kFewVertices
                                ? "warning: few_vertices: the facets of so coarse a mesh count as "
                                  "details; little is gained\n"
                                : "";
    return few + fmt::format(
                     "remeshed: {} vertices, {} faces; {} levels over {} faces; quality {:.2f}, {} "
                     "flips\n"
                     "surfaces: rms distance {} ({:.2g} of the diagonal), max {} ({:.2g}) at ({}, "
                     "{}, {})\n",
                     grouped(static_cast<std::int64_t>(remeshed.mesh.vertices.size())),
                     grouped(remeshed.mesh.polygon_count()), report.levels,
                     grouped(report.base_faces), report.quality, report.flips,
                     shown(report.rms_error), report.rms_error / report.diagonal,
                     shown(report.max_error), report.max_error / report.diagonal,
                     shown(report.worst[0]), shown(report.worst[1]), shown(report.worst[2]));
}

namespace {

struct Remesh {
    std::string in;
    std::string out;
    int levels = -1;
    bool repair = false;
    RemeshFlags flags;
};

Result<Outcome> run(const Remesh& options, const Globals& globals) {
    const Stopwatch watch;
    RELIEF_TRY(PolygonMesh mesh, read_polygons(options.in));
    std::string repairs;
    if (options.repair) {
        mesh::RepairedMesh repaired = mesh::repair(mesh);
        repairs = repair_text(repaired.counts);
        mesh = std::move(repaired.mesh);
    }
    remesh::RemeshOptions remeshing{.base_faces = options.flags.base,
                                    .feature_degrees = options.flags.features,
                                    .progress = progress_bar(globals, "remeshing")};
    if (options.levels >= 0) remeshing.levels = options.levels;
    if (const auto tolerance = options.flags.tolerance_of(mesh)) remeshing.tolerance = *tolerance;
    RELIEF_TRY(const remesh::Remeshed remeshed,
               located(remesh::remesh(mesh, remeshing), options.in));
    RELIEF_TRY(const auto missing, io::write_mesh(options.out, remeshed.mesh));
    Outcome outcome;
    outcome.json = remesh_json(remeshed);
    outcome.json.update(Json{{"left_out", missing}, {"seconds", watch.seconds()}});
    outcome.text = repairs + remesh_text(remeshed) + left_out(missing);
    return outcome;
}

}  // namespace

void add_remesh(Program& program) {
    auto options = std::make_shared<Remesh>();
    CLI::App* verb = add_verb(
        program, "remesh",
        "Turn any mesh of triangles into one with subdivision connectivity, of the same shape.",
        "  relief remesh scan.ply smooth.ply\n"
        "  relief remesh part.stl part.obj --features 40 --base 500 --levels 3",
        [options, &program] { return run(*options, program.globals); });
    verb->add_option("IN", options->in,
                     "a mesh (.obj, .off, .ply, .stl); polygons become triangles")
        ->required();
    verb->add_option("OUT", options->out, "the mesh: .obj, .off, .ply, .stl, .glb")->required();
    verb->add_option("--levels", options->levels,
                     "subdivisions of the base mesh; default: such that it has 250 to 1000 faces")
        ->check(CLI::Range(0, 12));
    options->flags.add_to(*verb);
    verb->add_flag("--repair", options->repair,
                   "first mend what is no oriented manifold: see 'relief info'");
}

}  // namespace relief::cli
