#include <array>
#include <cmath>
#include <iostream>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>

#include "contest.h"
#include "draco_peer.h"
#include "relief/codec/mesh_codec.h"
#include "relief/io/file.h"
#include "relief/io/mesh.h"
#include "relief/mesh/closest.h"
#include "simplify_peer.h"

/// Measures .relief files of a scan, and finds for each the smallest file of Draco whose surface is
/// as near the scan: of the scan itself, and of simplifications of it. One line of JSON for each
/// file. Errors are fractions of the diagonal of the scan.
namespace relief::peers {

namespace {

using nlohmann::json;

constexpr int kFewestBits = 8;
constexpr int kMostBits = 13;

/// Numbers of faces in a geometric sequence from the scan's own, which is left out, to 1 %.
std::vector<std::int64_t> fewer_faces(std::int64_t count) {
    constexpr int kSteps = 11;
    std::vector<std::int64_t> faces;
    for (int k = 1; k <= kSteps; ++k)
        faces.push_back(
            std::llround(static_cast<double>(count) * std::pow(0.01, k / double{kSteps})));
    return faces;
}

/// At fewer samples than files of relief are measured at: there are hundreds of meshes.
Result<double> rms_between(const PolygonMesh& scan, const PolygonMesh& mesh) {
    constexpr std::int64_t kSamples = 20000;
    RELIEF_TRY(const auto distance, mesh::surface_distance(scan, mesh, kSamples));
    return distance.rms();
}

/// A mesh, and what Draco makes of it: measured when it is asked for.
class Candidate {
  public:
    Candidate(std::string simplifier, PolygonMesh mesh)
        : simplifier_(std::move(simplifier)), mesh_(std::move(mesh)) {}

    [[nodiscard]] const std::string& simplifier() const { return simplifier_; }
    [[nodiscard]] std::int64_t faces() const { return mesh_.polygon_count(); }

    /// Of the mesh before Draco.
    [[nodiscard]] Result<double> rms(const PolygonMesh& scan) {
        if (!own_rms_) {
            RELIEF_TRY(own_rms_, rms_between(scan, mesh_));
        }
        return *own_rms_;
    }
    [[nodiscard]] Result<double> rms(const PolygonMesh& scan, int bits) {
        const auto known = rms_.find(bits);
        if (known != rms_.end()) return known->second;
        RELIEF_TRY(const PolygonMesh decoded, draco_decoded(mesh_, {bits, 0}));
        RELIEF_TRY(const double rms, rms_between(scan, decoded));
        return rms_[bits] = rms;
    }
    /// The smallest file of some speeds; its errors depend on the bits alone.
    [[nodiscard]] Result<std::size_t> bytes(int bits) {
        const auto known = bytes_.find(bits);
        if (known != bytes_.end()) return known->second;
        std::optional<std::size_t> smallest;
        for (const int speed : {0, 1, 3, 5, 7}) {
            RELIEF_TRY(const Bytes file, draco_encode(mesh_, {bits, speed}));
            if (!smallest || file.size() < *smallest) smallest = file.size();
        }
        return bytes_[bits] = *smallest;
    }

  private:
    std::string simplifier_;
    PolygonMesh mesh_;
    std::optional<double> own_rms_;
    std::map<int, double> rms_;
    std::map<int, std::size_t> bytes_;
};

struct Cheapest {
    json line;
    std::size_t bytes = 0;
};

class Comparison {
  public:
    explicit Comparison(PolygonMesh scan) : scan_(std::move(scan)), diagonal_(diagonal_of(scan_)) {
        original_.emplace_back("", scan_);
    }

    [[nodiscard]] Status simplify() {
        const std::vector<std::int64_t> faces = fewer_faces(scan_.polygon_count());
        RELIEF_CHECK(add("OpenMesh", openmesh_simplified(scan_, faces)));
#ifdef RELIEF_PEER_CGAL
        RELIEF_CHECK(add("CGAL", cgal_simplified(scan_, faces)));
#endif
        return {};
    }

    [[nodiscard]] Result<json> measure(const std::string& path) {
        RELIEF_TRY(Bytes bytes, io::read_file(path));
        const std::size_t size = bytes.size();
        RELIEF_TRY(const auto file, codec::MeshFile::open(std::move(bytes)));
        RELIEF_TRY(const PolygonMesh decoded, file.decode(0));
        RELIEF_TRY(const auto distance, mesh::surface_distance(scan_, decoded));
        std::optional<Cheapest> draco;
        RELIEF_CHECK(improve(draco, original_, distance.rms()));
        std::optional<Cheapest> peer = draco;
        for (std::vector<Candidate>& meshes : simplified_)
            RELIEF_CHECK(improve(peer, meshes, distance.rms()));
        const auto line_of = [](const std::optional<Cheapest>& found) {
            return found ? found->line : json();
        };
        return json{{"file", stem(path)},
                    {"bytes", size},
                    {"rms", distance.rms() / diagonal_},
                    {"largest", distance.largest() / diagonal_},
                    {"draco", line_of(draco)},
                    {"peer", line_of(peer)}};
    }

  private:
    [[nodiscard]] Status add(const char* library, Simplified meshes) {
        if (!meshes.ok()) return meshes.error();
        std::vector<Candidate>& candidates = simplified_.emplace_back();
        for (auto mesh = meshes->rbegin(); mesh != meshes->rend(); ++mesh)
            candidates.emplace_back(library, std::move(*mesh));
        return {};
    }

    /// The smallest file within an error of any of the meshes, which are sorted by their faces: of
    /// those that are smaller than what is known, if there are any.
    [[nodiscard]] Status improve(std::optional<Cheapest>& best, std::vector<Candidate>& meshes,
                                 double rms) {
        for (Candidate& candidate : meshes) {
            RELIEF_TRY(const std::size_t fewest, candidate.bytes(kFewestBits));
            if (best && fewest >= best->bytes) return {};
            RELIEF_TRY(const double own, candidate.rms(scan_));
            if (own <= rms) RELIEF_CHECK(improve(best, candidate, rms));
        }
        return {};
    }

    [[nodiscard]] Status improve(std::optional<Cheapest>& best, Candidate& candidate, double rms) {
        for (int bits = kFewestBits; bits <= kMostBits; ++bits) {
            RELIEF_TRY(const std::size_t bytes, candidate.bytes(bits));
            if (best && bytes >= best->bytes) return {};
            RELIEF_TRY(const double reached, candidate.rms(scan_, bits));
            if (reached > rms) continue;
            best = Cheapest{{{"simplifier", candidate.simplifier()},
                             {"faces", candidate.faces()},
                             {"bits", bits},
                             {"bytes", bytes},
                             {"rms", reached / diagonal_}},
                            bytes};
        }
        return {};
    }

    PolygonMesh scan_;
    double diagonal_;
    std::vector<Candidate> original_;
    std::vector<std::vector<Candidate>> simplified_;  ///< [library], the fewest faces first
};

Status run(const std::string& scan, const std::vector<std::string>& files) {
    RELIEF_TRY(io::LoadedMesh loaded, io::read_mesh(scan));
    Comparison comparison(std::move(loaded.mesh));
    RELIEF_CHECK(comparison.simplify());
    for (const std::string& file : files) {
        RELIEF_TRY(const json line, comparison.measure(file));
        std::cout << line.dump() << std::endl;
    }
    return {};
}

}  // namespace

}  // namespace relief::peers

int main(int count, char** arguments) {
    using namespace relief::peers;
    if (count < 2) {
        std::cerr << "usage: relief_remesh_codecs SCAN [FILE.relief]...\n";
        return 2;
    }
    const nlohmann::json libraries = {{"Draco", draco_version()},
                                      {"OpenMesh", RELIEF_OPENMESH_VERSION},
                                      {"CGAL", RELIEF_CGAL_VERSION}};
    std::cout << nlohmann::json{{"libraries", libraries}}.dump() << std::endl;
    const relief::Status done = run(arguments[1], {arguments + 2, arguments + count});
    if (done.ok()) return 0;
    std::cerr << arguments[1] << ": " << done.error().text() << '\n';
    return 1;
}
