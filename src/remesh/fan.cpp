#include "remesh/fan.h"

#include <algorithm>

namespace relief::remesh {

namespace {

using mesh::Index;
using mesh::kNone;

void join(CollapsingMesh& mesh, Index a, Index b, std::uint8_t sharp) {
    for (const auto& [h, other] : {std::pair{a, b}, {b, a}}) {
        if (h == kNone) continue;
        mesh.twin[h] = other;
        mesh.sharp[h] = other == kNone ? 1 : sharp;
    }
}

}  // namespace

CollapsingMesh::CollapsingMesh(const Surface& surface)
    : origin(surface.mesh.origin.data(), surface.mesh.origin.data() + surface.mesh.origin.size()),
      twin(surface.mesh.twin.data(), surface.mesh.twin.data() + surface.mesh.twin.size()),
      sharp(surface.sharp) {
    const Buffer<Index> first = mesh::outgoing(surface.mesh);
    out.assign(first.data(), first.data() + first.size());
}

void Fan::read(const CollapsingMesh& mesh, Index v) {
    vertex = v;
    spokes.clear();
    ring.clear();
    const Index first = mesh.out[v];
    Index h = first;
    do {
        spokes.push_back(h);
        ring.push_back(mesh.target(h));
        h = mesh.twin[CollapsingMesh::prev(h)];
    } while (h != first && h != kNone);
    closed = h == first;
    if (!closed) ring.push_back(mesh.origin[CollapsingMesh::prev(spokes.back())]);
}

void Fan::rotate(std::size_t first) {
    const auto by = static_cast<std::ptrdiff_t>(first);
    std::rotate(spokes.begin(), spokes.begin() + by, spokes.end());
    std::rotate(ring.begin(), ring.begin() + by, ring.end());
}

void collapse(CollapsingMesh& mesh, const Fan& fan, std::size_t target) {
    const Index w = fan.ring[target];
    Index ahead = kNone;  // of those that begin at w afterwards, one beside the faces that go
    if (target < fan.spokes.size()) {  // face (v, w, x)
        const Index spoke = fan.spokes[target];
        const Index w_to_x = CollapsingMesh::next(spoke);
        const Index x_to_v = CollapsingMesh::prev(spoke);
        const Index x = mesh.origin[x_to_v];
        const Index outside = mesh.twin[w_to_x];
        ahead = mesh.twin[x_to_v];
        join(mesh, outside, ahead, mesh.sharp[w_to_x] | mesh.sharp[x_to_v]);
        if (mesh.out[x] == x_to_v) mesh.out[x] = outside;
        if (mesh.out[w] == w_to_x) mesh.out[w] = ahead;
    }
    if (fan.closed || target > 0) {  // face (v, y, w)
        const Index spoke = fan.spokes[(target + fan.spokes.size() - 1) % fan.spokes.size()];
        const Index y_to_w = CollapsingMesh::next(spoke);
        const Index w_to_v = CollapsingMesh::prev(spoke);
        const Index y = mesh.origin[y_to_w];
        const Index inside = mesh.twin[spoke];
        join(mesh, mesh.twin[y_to_w], inside, mesh.sharp[y_to_w] | mesh.sharp[spoke]);
        if (mesh.out[y] == y_to_w) mesh.out[y] = inside;
        if (mesh.out[w] == w_to_v) mesh.out[w] = fan.closed ? ahead : fan.spokes[0];
    }
    for (std::size_t i = 0; i < fan.spokes.size(); ++i)
        if (i != target && fan.after(i) != target) mesh.origin[fan.spokes[i]] = w;
    mesh.out[fan.vertex] = kNone;
}

}  // namespace relief::remesh
