#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "codec/level_chunks.h"
#include "codec/value_lattice.h"
#include "relief/codec/mesh_codec.h"

namespace relief::codec {

/// The content of files of this kind.
inline constexpr const char* kMeshContent = "mesh";

/// How coefficients become integers. docs/format.md, "Details of meshes".
struct MeshQuantisation {
    double step = 1;        ///< of the finest details along the normal
    double gain = 2;        ///< of one step to the coarser one
    double tangential = 1;  ///< steps along the tangents are so many times longer

    /// Of the details of a step.
    [[nodiscard]] double step_of(int step_number, int steps) const {
        double size = step;
        for (int k = step_number + 1; k < steps; ++k) size /= gain;
        return size;
    }
    [[nodiscard]] double base_step(int steps) const { return 0.7 * step_of(0, steps); }
};

struct AttributeHeader {
    std::string name;
    int components = 0;
    SampleType type = SampleType::Float64;
    std::optional<std::uint64_t> elements = {};  ///< face-varying: how many
    ValueLattice lattice;
};

/// What the header of a file of a mesh says.
struct MeshHeader {
    multires::MeshSpec spec;
    int levels = 0;
    multires::LiftKind lift = multires::LiftKind::Chebyshev;
    bool boundary_corners = false;  ///< boundary vertices with one face stay
    int sides = 3;                  ///< of the faces of the base; 0: several
    std::uint64_t base_vertices = 0;
    std::uint64_t base_faces = 0;
    MeshQuantisation quantisation;
    std::optional<ValueLattice> lattice;  ///< of which all coordinates are; lossless files
    Goal goal;
    MeshDistance distance = MeshDistance::Vertices;
    double max_error = 0;
    double rms_error = 0;
    std::vector<AttributeHeader> attributes;
    std::vector<FaceLabels> labels;  ///< without of_face
    std::vector<std::string> libraries;
};

/// JSON text. Members with their default values are left out.
[[nodiscard]] std::string write_mesh_header(const MeshHeader& header);

/// Errors: BadFile naming the member that is missing, of the wrong type or out of range;
/// Unsupported for other contents.
[[nodiscard]] Result<MeshHeader> read_mesh_header(const std::string& text);

/// The numbers of chunks: the coarsest level adds the tags of the base, a finer one the details of
/// a step.
struct MeshChunks : LevelChunks {
    static constexpr std::size_t kTags = kFirstLevel;

    explicit MeshChunks(int level_count) : LevelChunks{level_count, 5} {}

    [[nodiscard]] static std::size_t step(int number) { return of_refined(number + 1); }
    [[nodiscard]] std::size_t order() const { return of_refined(levels) + 1; }
    [[nodiscard]] std::size_t exact() const { return order() + 1; }
    [[nodiscard]] std::size_t attributes() const { return order() + 2; }
    [[nodiscard]] std::size_t labels() const { return order() + 3; }
    [[nodiscard]] std::size_t creases() const { return last(); }
};

}  // namespace relief::codec
