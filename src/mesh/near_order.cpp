#include "relief/mesh/near_order.h"

#include <algorithm>

namespace relief::mesh {

namespace {

/// Faces of the queue that are fetched ahead.
constexpr Index kAhead = 16;

/// Faces are renumbered as they are reached, and written as they leave the queue: by then all
/// around them have numbers.
template <Index Sides>
class Search {
  public:
    explicit Search(const Topology& mesh)
        : mesh_(mesh), face_(mesh.face_count), vertex_(mesh.vertex_count) {
        std::fill_n(face_.data(), face_.size(), kNone);
        std::fill_n(vertex_.data(), vertex_.size(), kNone);
        Topology& near = result_.mesh;
        near.vertex_count = mesh.vertex_count;
        near.edge_count = mesh.edge_count;
        near.face_count = mesh.face_count;
        near.sides = mesh.sides;
        near.origin = Buffer<Index>(mesh.origin.size());
        near.twin = Buffer<Index>(mesh.twin.size());
        result_.vertices = Buffer<Index>(mesh.vertex_count);
        result_.faces = Buffer<Index>(mesh.face_count);
    }

    Renumbered run() {
        Index written = 0;
        for (Index seed = 0; seed < mesh_.face_count; ++seed) {
            if (face_[seed] != kNone) continue;
            reach(seed);
            for (; written < reached_; ++written) {
                if (written + kAhead < reached_) fetch(result_.faces[written + kAhead]);
                write(written);
            }
        }
        return std::move(result_);
    }

  private:
    void fetch(Index face) const {
        __builtin_prefetch(&mesh_.twin[Sides * face]);
        __builtin_prefetch(&mesh_.origin[Sides * face]);
    }

    Index reach(Index face) {
        if (face_[face] == kNone) {
            result_.faces[reached_] = face;
            face_[face] = reached_++;
        }
        return face_[face];
    }

    Index name(Index vertex) {
        if (vertex_[vertex] == kNone) {
            result_.vertices[named_] = vertex;
            vertex_[vertex] = named_++;
        }
        return vertex_[vertex];
    }

    void write(Index face) {
        const Index from = Sides * result_.faces[face];
        for (Index k = 0; k < Sides; ++k) {
            const Index twin = mesh_.twin[from + k];
            result_.mesh.origin[Sides * face + k] = name(mesh_.origin[from + k]);
            result_.mesh.twin[Sides * face + k] =
                twin == kNone ? kNone : Sides * reach(twin / Sides) + twin % Sides;
        }
    }

    const Topology& mesh_;
    Buffer<Index> face_;    ///< numbers; kNone: not reached
    Buffer<Index> vertex_;  ///< numbers; kNone: not named
    Index reached_ = 0;
    Index named_ = 0;
    Renumbered result_;
};

}  // namespace

Renumbered near_order(const Topology& mesh) {
    return mesh.sides == 4 ? Search<4>(mesh).run() : Search<3>(mesh).run();
}

}  // namespace relief::mesh
