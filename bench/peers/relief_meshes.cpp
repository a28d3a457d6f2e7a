#include "mesh_peer.h"
#include "relief/multires/subdivider.h"

namespace relief::peers {

namespace {

/// What a caller of relief keeps from call to call.
template <class T>
class Kept {
  public:
    explicit Kept(const Subdividing& task) : task_(task) {
        for (const auto& p : task.base.points)
            places_.push_back({static_cast<T>(p.x), static_cast<T>(p.y), static_cast<T>(p.z)});
    }

    Status build() {
        RELIEF_TRY(base_, mesh::build(task_.base.faces,
                                      static_cast<mesh::Index>(task_.base.points.size())));
        return {};
    }
    Status subdivide() {
        RELIEF_CHECK(subdivider_.prepare(base_, {}, {.scheme = task_.scheme}, task_.steps));
        corners_.renew(subdivider_.counts().half_edges);
        points_.renew(subdivider_.counts().vertices);
        subdivider_.faces({corners_.data(), corners_.size()});
        place();
        return {};
    }
    void place() { subdivider_.points<T>(places_, {points_.data(), points_.size()}); }

    [[nodiscard]] Polygons polygons() const {
        Polygons result;
        const auto sides = static_cast<std::size_t>(subdivider_.sides());
        for (std::size_t k = 0; k < corners_.size(); k += sides)
            result.faces.add({corners_.data() + k, sides});
        for (std::size_t v = 0; v < points_.size(); ++v)
            result.points.push_back({points_[v].x, points_[v].y, points_[v].z});
        return result;
    }

  private:
    const Subdividing& task_;
    mesh::Topology base_;
    std::vector<Vec3<T>> places_;
    multires::Subdivider subdivider_;
    Buffer<mesh::Index> corners_;
    Buffer<Vec3<T>> points_;
};

template <class T>
class Relief final : public MeshPeer {
  public:
    [[nodiscard]] std::string name() const override {
        return sizeof(T) == sizeof(float) ? "relief" : "relief double";
    }
    [[nodiscard]] std::string scalar() const override {
        return sizeof(T) == sizeof(float) ? "float" : "double";
    }
    [[nodiscard]] bool offers(MeshScheme) const override { return true; }

    [[nodiscard]] Result<SubdivisionTimes> measure(const Subdividing& task) const override {
        Kept<T> kept(task);
        SubdivisionTimes times;
        times.first = -thread_seconds();
        RELIEF_CHECK(kept.build());
        RELIEF_CHECK(kept.subdivide());
        times.first += thread_seconds();
        times.kept = -thread_seconds();
        RELIEF_CHECK(kept.subdivide());
        times.kept += thread_seconds();
        times.points = -thread_seconds();
        kept.place();
        times.points += thread_seconds();
        return times;
    }

    [[nodiscard]] Result<Polygons> result(const Subdividing& task) const override {
        Kept<T> kept(task);
        RELIEF_CHECK(kept.build());
        RELIEF_CHECK(kept.subdivide());
        return kept.polygons();
    }
};

}  // namespace

MeshPeers relief_meshes() {
    MeshPeers peers;
    peers.push_back(std::make_unique<Relief<float>>());
    peers.push_back(std::make_unique<Relief<double>>());
    return peers;
}

}  // namespace relief::peers
