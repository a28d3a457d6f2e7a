#include "edit/mesh_region.h"

#include <algorithm>

#include "relief/mesh/walk.h"

namespace relief::edit {

namespace {

using mesh::Index;
using mesh::kNone;
using mesh::Topology;

constexpr int kFar = -1;

/// Finds the faces of a region.
class Search {
  public:
    Search(const Topology& mesh, const VertexFaces& around)
        : mesh_(mesh),
          around_(around),
          has_(mesh.face_count, false),
          rings_(mesh.vertex_count, kFar) {}

    void spread(std::span<const Index> seeds, int rings) {
        std::vector<Index> circle(seeds.begin(), seeds.end());
        for (const Index v : circle) rings_[v] = 0;
        for (int ring = 0; ring < rings && !circle.empty(); ++ring) {
            next_.clear();
            for (const Index v : circle) add_around(v, ring + 1);
            std::swap(circle, next_);
        }
    }

    /// Adds faces until each vertex has one fan of them.
    void close(int ring, mesh::Split split) {
        while (close_once(ring, split)) {
        }
    }

    [[nodiscard]] bool has(Index f) const { return has_[f]; }
    [[nodiscard]] int ring(Index v) const { return rings_[v]; }

  private:
    bool add(Index f, int ring) {
        if (has_[f]) return false;
        has_[f] = true;
        for (const Index v : mesh_.corners(f)) {
            if (rings_[v] != kFar) continue;
            rings_[v] = ring;
            next_.push_back(v);
        }
        return true;
    }

    bool add_around(Index v, int ring) {
        bool any = false;
        for (const Index f : around_.of(v)) any = add(f, ring) || any;
        return any;
    }

    [[nodiscard]] bool is_cut(Index h) const {
        return !mesh_.on_boundary(h) && !has_[mesh_.face_of(mesh_.twin[h])];
    }

    bool close_once(int ring, mesh::Split split) {
        std::vector<std::uint8_t> fans(mesh_.vertex_count, 0);
        std::vector<Index> across;  // half-edges of faces that are missing
        std::vector<Index> pinched;
        for (Index f = 0; f < mesh_.face_count; ++f) {
            if (!has_[f]) continue;
            int ends = 0;
            for (Index h = mesh_.first_of(f); h < mesh_.first_of(f + 1); ++h) {
                if (!mesh_.on_boundary(h) && !is_cut(h)) continue;
                ++ends;
                if (fans[mesh_.origin[h]]++ > 0) pinched.push_back(mesh_.origin[h]);
            }
            if (split != mesh::Split::Sqrt3Even || ends < 2) continue;
            for (Index h = mesh_.first_of(f); h < mesh_.first_of(f + 1); ++h)
                if (is_cut(h)) across.push_back(mesh_.twin[h]);
        }
        bool any = false;
        for (const Index v : pinched) any = add_around(v, ring) || any;
        for (const Index h : across) any = add(mesh_.face_of(h), ring) || any;
        return any;
    }

    const Topology& mesh_;
    const VertexFaces& around_;
    std::vector<bool> has_;
    std::vector<int> rings_;
    std::vector<Index> next_;
};

/// Takes a region out of its mesh.
class Extraction {
  public:
    Extraction(const Topology& mesh, const multires::MeshTags& tags, const Search& found)
        : mesh_(mesh), tags_(tags), found_(found) {}

    MeshRegion run() {
        take_vertices();
        take_faces();
        link();
        take_tags();
        return std::move(region_);
    }

  private:
    void take_vertices() {
        place_.assign(mesh_.vertex_count, kNone);
        for (Index v = 0; v < mesh_.vertex_count; ++v) {
            if (found_.ring(v) == kFar) continue;
            place_[v] = static_cast<Index>(region_.vertices.size());
            region_.vertices.push_back(v);
            region_.rings.push_back(found_.ring(v));
        }
        region_.mesh.vertex_count = static_cast<Index>(region_.vertices.size());
    }

    void take_faces() {
        first_.assign(mesh_.face_count, kNone);
        std::vector<Index> firsts;
        for (Index f = 0; f < mesh_.face_count; ++f) {
            if (!found_.has(f)) continue;
            first_[f] = static_cast<Index>(region_.half_edges.size());
            firsts.push_back(first_[f]);
            for (Index h = mesh_.first_of(f); h < mesh_.first_of(f + 1); ++h)
                region_.half_edges.push_back(h);
        }
        Topology& part = region_.mesh;
        const auto count = static_cast<Index>(region_.half_edges.size());
        part.face_count = static_cast<Index>(firsts.size());
        part.sides = mesh_.sides;
        part.origin = Buffer<Index>(count);
        for (Index h = 0; h < count; ++h)
            part.origin[h] = place_[mesh_.origin[region_.half_edges[h]]];
        if (part.sides != 0) return;
        firsts.push_back(count);
        part.first = Buffer<Index>(firsts.size());
        std::copy(firsts.begin(), firsts.end(), part.first.data());
        part.face = Buffer<Index>(count);
        for (Index f = 0; f < part.face_count; ++f)
            std::fill(part.face.data() + firsts[f], part.face.data() + firsts[f + 1], f);
    }

    void link() {
        Topology& part = region_.mesh;
        part.twin = Buffer<Index>(part.half_edge_count());
        part.edge = Buffer<Index>(part.half_edge_count());
        for (Index h = 0; h < part.half_edge_count(); ++h) {
            const Index twin = mesh_.twin[region_.half_edges[h]];
            const Index f = twin == kNone ? kNone : mesh_.face_of(twin);
            const bool inside = f != kNone && first_[f] != kNone;
            part.twin[h] = inside ? first_[f] + (twin - mesh_.first_of(f)) : kNone;
            if (part.is_first(h)) region_.on_cut.push_back(f != kNone && !inside);
            part.edge[h] = part.is_first(h) ? part.edge_count++ : part.edge[part.twin[h]];
        }
    }

    void take_tags() {
        const Topology& part = region_.mesh;
        std::vector<std::uint8_t>& corner = region_.tags.corner;
        corner.assign(part.vertex_count, 0);
        for (Index v = 0; v < part.vertex_count && !tags_.corner.empty(); ++v)
            corner[v] = tags_.corner[region_.vertices[v]];
        if (!tags_.sharp.empty()) region_.tags.sharp.assign(part.edge_count, 0);
        for (Index h = 0; h < part.half_edge_count(); ++h) {
            if (!tags_.sharp.empty())
                region_.tags.sharp[part.edge[h]] = tags_.sharp[mesh_.edge[region_.half_edges[h]]];
            if (!region_.on_cut[part.edge[h]]) continue;
            region_.has_cut = true;
            corner[part.origin[h]] = 1;
            corner[part.target(h)] = 1;
        }
    }

    const Topology& mesh_;
    const multires::MeshTags& tags_;
    const Search& found_;
    MeshRegion region_;
    std::vector<Index> place_;  ///< [vertex of the mesh]
    std::vector<Index> first_;  ///< [face of the mesh]: its first half-edge in the region
};

}  // namespace

MeshRegion region_around(const Topology& mesh, const multires::MeshTags& tags,
                         const VertexFaces& around, std::span<const Index> seeds, int rings,
                         mesh::Split split) {
    Search search(mesh, around);
    search.spread(seeds, rings);
    search.close(rings, split);
    return Extraction(mesh, tags, search).run();
}

}  // namespace relief::edit
