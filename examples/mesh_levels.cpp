// Encodes a mesh that was made by subdivision, losing no more than MAX_ERROR of any vertex, and
// writes the control mesh that was found beneath it. usage: mesh_levels MESH OUT.relief MAX_ERROR
// OUT_MESH
#include <cstdio>
#include <cstdlib>

#include "relief/codec/mesh_codec.h"
#include "relief/io/file.h"
#include "relief/io/mesh.h"

relief::Status run(const char* mesh_path, const char* relief_path, double max_error,
                   const char* coarse_path) {
    using namespace relief;
    RELIEF_TRY(const io::LoadedMesh loaded, io::read_mesh(mesh_path));
    codec::MeshEncodeOptions options;
    options.goal = {codec::Goal::Kind::MaxError, max_error};
    RELIEF_TRY(const auto encoded, codec::encode_mesh(loaded.mesh, options));
    RELIEF_CHECK(io::write_file_atomically(relief_path, encoded.bytes));
    std::printf("%.2f bits a vertex, %d levels above %lld faces\n", encoded.report.bits_per_sample,
                encoded.report.levels, static_cast<long long>(encoded.report.base_faces));

    RELIEF_TRY(auto bytes, io::read_file(relief_path));
    RELIEF_TRY(const auto file, codec::MeshFile::open(std::move(bytes)));
    RELIEF_TRY(const PolygonMesh coarsest, file.decode(file.levels()));
    RELIEF_CHECK(io::write_mesh(coarse_path, coarsest));
    return {};
}

int main(int argc, char** argv) {
    if (argc != 5) return 2;
    const relief::Status done = run(argv[1], argv[2], std::atof(argv[3]), argv[4]);
    if (done.ok()) return 0;
    std::fprintf(stderr, "mesh_levels: %s\n", done.error().text().c_str());
    return 1;
}
