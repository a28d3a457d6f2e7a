#include <opensubdiv/far/primvarRefiner.h>
#include <opensubdiv/far/topologyDescriptor.h>

#include "mesh_peer.h"

namespace relief::peers {

namespace {

namespace Far = OpenSubdiv::Far;
namespace Sdc = OpenSubdiv::Sdc;

/// The interface that PrimvarRefiner asks of values.
struct Value {
    float x = 0;
    float y = 0;
    float z = 0;

    void Clear(void* = nullptr) { *this = {}; }
    void AddWithWeight(const Value& from, float weight) {
        x += weight * from.x;
        y += weight * from.y;
        z += weight * from.z;
    }
};

class Refinement {
  public:
    explicit Refinement(const Subdividing& task) : task_(task) {
        const mesh::FaceList& faces = task.base.faces;
        for (std::size_t f = 0; f < faces.size(); ++f)
            sizes_.push_back(static_cast<int>(faces[f].size()));
        corners_.assign(faces.corners.begin(), faces.corners.end());
        for (const auto& p : task.base.points)
            base_.push_back(
                {static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z)});
    }

    bool refine() {
        Far::TopologyDescriptor descriptor;
        descriptor.numVertices = static_cast<int>(base_.size());
        descriptor.numFaces = static_cast<int>(sizes_.size());
        descriptor.numVertsPerFace = sizes_.data();
        descriptor.vertIndicesPerFace = corners_.data();
        Sdc::Options rules;
        rules.SetVtxBoundaryInterpolation(Sdc::Options::VTX_BOUNDARY_EDGE_ONLY);
        const Sdc::SchemeType scheme =
            task_.scheme == MeshScheme::Loop ? Sdc::SCHEME_LOOP : Sdc::SCHEME_CATMARK;
        using Factory = Far::TopologyRefinerFactory<Far::TopologyDescriptor>;
        refiner_.reset(Factory::Create(descriptor, {scheme, rules}));
        if (!refiner_) return false;
        refiner_->RefineUniform(Far::TopologyRefiner::UniformOptions(task_.steps));
        return true;
    }

    void place() {
        values_.resize(static_cast<std::size_t>(refiner_->GetNumVerticesTotal()));
        std::copy(base_.begin(), base_.end(), values_.begin());
        const Far::PrimvarRefiner points(*refiner_);
        Value* from = values_.data();
        for (int level = 1; level <= task_.steps; ++level) {
            Value* const to = from + refiner_->GetLevel(level - 1).GetNumVertices();
            points.Interpolate(level, from, to);
            from = to;
        }
    }

    [[nodiscard]] Polygons polygons() const {
        const Far::TopologyLevel& finest = refiner_->GetLevel(task_.steps);
        Polygons result;
        for (int f = 0; f < finest.GetNumFaces(); ++f) {
            const auto face = finest.GetFaceVertices(f);
            result.faces.add(std::vector<mesh::Index>(face.begin(), face.end()));
        }
        const auto count = static_cast<std::size_t>(finest.GetNumVertices());
        for (std::size_t v = values_.size() - count; v < values_.size(); ++v)
            result.points.push_back({values_[v].x, values_[v].y, values_[v].z});
        return result;
    }

  private:
    const Subdividing& task_;
    std::vector<int> sizes_;
    std::vector<int> corners_;
    std::vector<Value> base_;
    std::unique_ptr<Far::TopologyRefiner> refiner_;
    std::vector<Value> values_;
};

class OpenSubdivPeer final : public MeshPeer {
  public:
    [[nodiscard]] std::string name() const override { return "OpenSubdiv"; }
    [[nodiscard]] std::string scalar() const override { return "float"; }
    [[nodiscard]] bool offers(MeshScheme scheme) const override {
        return scheme != MeshScheme::Sqrt3;
    }

    [[nodiscard]] Result<SubdivisionTimes> measure(const Subdividing& task) const override {
        Refinement refinement(task);
        SubdivisionTimes times;
        times.first = -thread_seconds();
        if (!refinement.refine()) return refused();
        refinement.place();
        times.first += thread_seconds();
        times.points = -thread_seconds();
        refinement.place();
        times.points += thread_seconds();
        return times;
    }

    [[nodiscard]] Result<Polygons> result(const Subdividing& task) const override {
        Refinement refinement(task);
        if (!refinement.refine()) return refused();
        refinement.place();
        return refinement.polygons();
    }

  private:
    static Error refused() { return {ErrorCode::BadInput, "OpenSubdiv refuses the mesh", ""}; }
};

}  // namespace

MeshPeers opensubdiv_peers() {
    MeshPeers peers;
    peers.push_back(std::make_unique<OpenSubdivPeer>());
    return peers;
}

}  // namespace relief::peers
