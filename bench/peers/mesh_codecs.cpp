#include <algorithm>
#include <cmath>
#include <iostream>
#include <nlohmann/json.hpp>
#include <optional>

#include "contest.h"
#include "draco_peer.h"
#include "mesh_shapes.h"
#include "relief/codec/mesh_codec.h"
#include "relief/io/mesh.h"
#include "relief/mesh/closest.h"

/// Measures relief and Draco on meshes with subdivision connectivity: one line of JSON for each
/// file. Errors are fractions of the diagonal of the bounding box.
namespace relief::peers {

namespace {

using codec::Goal;
using codec::MeshDistance;
using nlohmann::json;

void print(const json& line) {
    std::cout << line.dump() << std::endl;
}

double largest_move(const PolygonMesh& a, const PolygonMesh& b) {
    double largest = 0;
    for (std::size_t v = 0; v < a.vertices.size(); ++v)
        largest = std::max(largest, std::hypot(a.vertices[v][0] - b.vertices[v][0],
                                               a.vertices[v][1] - b.vertices[v][1],
                                               a.vertices[v][2] - b.vertices[v][2]));
    return largest;
}

/// Only places and polygons: what Draco is given too.
PolygonMesh shape_of(const PolygonMesh& mesh) {
    return {.vertices = mesh.vertices, .offsets = mesh.offsets, .corners = mesh.corners};
}

/// Bits of Draco at most: its places are float.
constexpr int kFewestBits = 5;
constexpr int kMostBits = 20;

class Comparison {
  public:
    Comparison(std::string name, PolygonMesh mesh)
        : name_(std::move(name)), mesh_(std::move(mesh)), diagonal_(diagonal_of(mesh_)) {}

    /// Errors: those of encode_mesh.
    [[nodiscard]] Status run() {
        RELIEF_TRY(order_, order_bytes());
        for (const double error : {1e-3, 3e-4, 1e-4})
            RELIEF_CHECK(relief(Goal::Kind::RmsError, MeshDistance::Surface, error));
        RELIEF_CHECK(relief(Goal::Kind::MaxError, MeshDistance::Vertices, 1e-4));
        for (int bits = kFewestBits; bits <= kMostBits && !draco_is_nearer(); ++bits)
            RELIEF_CHECK(draco(bits));
        return {};
    }

  private:
    [[nodiscard]] json line(const char* codec) const {
        return {{"mesh", name_}, {"vertices", mesh_.vertices.size()}, {"codec", codec}};
    }

    /// What it takes more to keep the numbers of vertices and faces: of a file without details.
    [[nodiscard]] Result<std::uint64_t> order_bytes() {
        codec::MeshEncodeOptions options{.goal = {Goal::Kind::Keep, 0}};
        RELIEF_TRY(const auto kept, codec::encode_mesh(mesh_, options));
        scheme_ = kept.report.scheme;
        options.scheme = scheme_;
        options.keep_order = false;
        RELIEF_TRY(const auto free, codec::encode_mesh(mesh_, options));
        return kept.bytes.size() - std::min(kept.bytes.size(), free.bytes.size());
    }

    [[nodiscard]] Status relief(Goal::Kind kind, MeshDistance distance, double error) {
        RELIEF_TRY(const auto encoded, codec::encode_mesh(mesh_, {.goal = {kind, error * diagonal_},
                                                                  .distance = distance,
                                                                  .scheme = scheme_,
                                                                  .keep_order = false}));
        RELIEF_TRY(const codec::MeshFile file, codec::MeshFile::open(encoded.bytes));
        const codec::MeshReport& report = encoded.report;
        const bool rms = kind == Goal::Kind::RmsError;
        json result = line("relief");
        result["scheme"] = multires::mesh_scheme_name(report.scheme);
        result["levels"] = report.levels;
        result["base_vertices"] = report.base_vertices;
        result["goal"] = rms ? "surface rms" : "vertex max";
        result["value"] = error;
        result["error"] = (rms ? report.rms_error : report.max_error) / diagonal_;
        result["bytes"] = report.bytes;
        result["base_bytes"] = file.bytes_for(report.levels);
        result["order_bytes"] = order_;
        double& nearest = rms ? nearest_rms_ : nearest_max_;
        nearest = std::min(nearest, result["error"].get<double>());
        print(result);
        return {};
    }

    /// Files of more bits have no smaller errors than any file of relief.
    [[nodiscard]] bool draco_is_nearer() const {
        return draco_rms_ <= nearest_rms_ && draco_max_ <= nearest_max_;
    }

    /// The smallest file of some speeds; its errors depend on the bits alone.
    [[nodiscard]] Status draco(int bits) {
        json result = line("Draco");
        result["bits"] = bits;
        for (const int speed : {0, 1, 3, 5, 7}) {
            RELIEF_TRY(const Bytes bytes, draco_encode(mesh_, {bits, speed}));
            if (result.contains("bytes") && result["bytes"] <= bytes.size()) continue;
            result["bytes"] = bytes.size();
            result["speed"] = speed;
        }
        RELIEF_TRY(const PolygonMesh decoded, draco_decoded(mesh_, {bits, 0}));
        RELIEF_TRY(const auto distance, mesh::surface_distance(mesh_, decoded));
        draco_rms_ = distance.rms() / diagonal_;
        draco_max_ = largest_move(mesh_, decoded) / diagonal_;
        result["surface rms"] = draco_rms_;
        result["vertex max"] = draco_max_;
        print(result);
        return {};
    }

    std::string name_;
    PolygonMesh mesh_;
    double diagonal_;
    std::uint64_t order_ = 0;
    std::optional<multires::MeshScheme> scheme_;
    double nearest_rms_ = HUGE_VAL;  ///< of relief
    double nearest_max_ = HUGE_VAL;
    double draco_rms_ = HUGE_VAL;  ///< of the last file
    double draco_max_ = HUGE_VAL;
};

Result<std::vector<NamedMesh>> meshes_of(const std::vector<std::string>& arguments) {
    std::vector<NamedMesh> meshes;
    for (const std::string& argument : arguments) {
        if (argument == "--exact") {
            for (NamedMesh& mesh : exact_surfaces()) meshes.push_back(std::move(mesh));
        } else if (argument == "--waves") {
            for (const int steps : {5, 6, 7})
                meshes.push_back({"smooth L" + std::to_string(steps), wavy_sphere(steps, 0)});
            meshes.push_back({"rough L6", wavy_sphere(6, 0.005)});
        } else {
            RELIEF_TRY(const io::LoadedMesh loaded, io::read_mesh(argument));
            meshes.push_back({stem(argument), shape_of(loaded.mesh)});
        }
    }
    return meshes;
}

int run(int count, char** arguments) {
    if (count < 2) {
        std::cerr << "usage: relief_mesh_codecs [--waves] [--exact] [mesh]...\n";
        return 2;
    }
    const auto meshes = meshes_of({arguments + 1, arguments + count});
    if (!meshes.ok()) {
        std::cerr << meshes.error().text() << '\n';
        return 1;
    }
    print({{"libraries", {{"Draco", draco_version()}}}});
    for (const NamedMesh& mesh : *meshes) {
        const Status done = Comparison(mesh.name, mesh.mesh).run();
        if (done.ok()) continue;
        std::cerr << mesh.name << ": " << done.error().text() << '\n';
        return 1;
    }
    return 0;
}

}  // namespace

}  // namespace relief::peers

int main(int count, char** arguments) {
    return relief::peers::run(count, arguments);
}
