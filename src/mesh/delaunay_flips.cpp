#include "mesh/delaunay_flips.h"

#include <utility>

#include "mesh/lattice_predicates.h"

namespace relief::mesh {

namespace {

/// How much a direction is wanted among edges of the same length.
int direction_rank(Vec2 d) {
    if (d.y == 0) return 1;
    if (d.x == 0) return 2;
    return (d.x > 0) == (d.y > 0) ? 0 : 3;
}

class Inserter {
  public:
    explicit Inserter(std::span<const Vec2> sites) {
        const std::size_t half_edges = 3 * (2 * sites.size() - 2);
        mesh_ = {sites, Buffer<Index>(half_edges), Buffer<Index>(half_edges), 0};
    }

    FlipMesh run(std::span<const Index> order) {
        start(order[0], order[1], order[2]);
        Index near = 0;
        for (const Index v : order.subspan(3)) near = insert(v, near);
        join_by_shorter_diagonals();
        return std::move(mesh_);
    }

  private:
    [[nodiscard]] Vec2 site(Index v) const { return mesh_.sites[v]; }
    [[nodiscard]] Index infinite() const { return mesh_.infinite(); }
    static Index next(Index h) { return FlipMesh::next(h); }
    static Index prev(Index h) { return FlipMesh::prev(h); }

    void link(Index g, Index h) {
        mesh_.twin[g] = h;
        mesh_.twin[h] = g;
    }

    /// The number of its first half-edge.
    Index add_triangle(Index a, Index b, Index c) {
        const Index h = 3 * mesh_.triangle_count++;
        mesh_.origin[h] = a;
        mesh_.origin[h + 1] = b;
        mesh_.origin[h + 2] = c;
        return h;
    }

    void start(Index a, Index b, Index c) {
        if (exact_orient(site(a), site(b), site(c)) < 0) std::swap(b, c);
        add_triangle(a, b, c);
        const Index ba = add_triangle(b, a, infinite());
        const Index cb = add_triangle(c, b, infinite());
        const Index ac = add_triangle(a, c, infinite());
        link(0, ba);
        link(1, cb);
        link(2, ac);
        link(ba + 1, ac + 2);
        link(cb + 1, ba + 2);
        link(ac + 1, cb + 2);
    }

    /// Any half-edge of the triangle with p inside or on its border, or of the infinite one of a
    /// hull edge that p lies beyond. In Delaunay triangulations such a walk ends.
    [[nodiscard]] Index locate(Vec2 p, Index h) const {
        for (Index k = 0; k < 3; ++k, h = next(h))
            if (mesh_.origin[h] == infinite()) {
                h = mesh_.twin[next(h)];
                break;
            }
        for (int tested = 0; tested < 3;) {
            if (exact_orient(site(mesh_.origin[h]), site(mesh_.origin[next(h)]), p) >= 0) {
                h = next(h);
                ++tested;
                continue;
            }
            h = mesh_.twin[h];
            if (mesh_.origin[prev(h)] == infinite()) return h;
            h = next(h);
            tested = 1;  // p is on the right side of the edge that was crossed
        }
        return h;
    }

    /// Returns a half-edge of a triangle at v.
    Index insert(Index v, Index near) {
        const Index ab = locate(site(v), near);
        const Index bc = next(ab);
        const Index ca = prev(ab);
        const Index a = mesh_.origin[ab];
        const Index b = mesh_.origin[bc];
        const Index c = mesh_.origin[ca];
        const Index beyond_bc = mesh_.twin[bc];
        const Index beyond_ca = mesh_.twin[ca];
        mesh_.origin[ca] = v;
        const Index second = add_triangle(b, c, v);
        const Index third = add_triangle(c, a, v);
        link(second, beyond_bc);
        link(third, beyond_ca);
        link(bc, second + 2);
        link(second + 1, third + 2);
        link(third + 1, ca);
        stack_.assign({ab, second, third});
        flip_while_in_circle(v);
        return ab;
    }

    /// The stack holds half-edges of triangles at v, opposite to it.
    void flip_while_in_circle(Index v) {
        const Vec2 p = site(v);
        while (!stack_.empty()) {
            const Index h = stack_.back();
            const Index g = mesh_.twin[h];
            if (!in_circle(g, p)) {
                stack_.pop_back();
                continue;
            }
            flip(h);
            stack_.push_back(prev(g));
        }
    }

    /// Whether p lies inside the circle of the triangle of half-edge g, beside which it lies: with
    /// a corner at infinity it is the half-plane beyond the hull's edge, and that edge.
    [[nodiscard]] bool in_circle(Index g, Vec2 p) const {
        const Index a = mesh_.origin[g];
        const Index b = mesh_.origin[next(g)];
        const Index c = mesh_.origin[prev(g)];
        if (c == infinite()) return exact_orient(site(a), site(b), p) >= 0;
        if (a == infinite()) return exact_orient(site(b), site(c), p) > 0;
        if (b == infinite()) return exact_orient(site(c), site(a), p) > 0;
        return exact_in_circle(site(a), site(b), site(c), p) > 0;
    }

    /// Turns the edge of h in its quad. Afterwards h and prev(g) are sides of the quad, opposite to
    /// the corner that h was opposite to.
    void flip(Index h) {
        const Index g = mesh_.twin[h];
        const Index after_h = next(h);
        const Index after_g = next(g);
        mesh_.origin[after_h] = mesh_.origin[prev(g)];
        mesh_.origin[after_g] = mesh_.origin[prev(h)];
        const Index beyond_g = mesh_.twin[after_g];
        const Index beyond_h = mesh_.twin[after_h];
        link(h, beyond_g);
        link(g, beyond_h);
        link(after_h, after_g);
    }

    /// Whether the quad of h has its corners on a circle and its other diagonal is the wanted one.
    [[nodiscard]] bool wants_other_diagonal(Index h) const {
        const Index g = mesh_.twin[h];
        const Index a = mesh_.origin[h];
        const Index b = mesh_.origin[g];
        const Index c = mesh_.origin[prev(h)];
        const Index d = mesh_.origin[prev(g)];
        if (a == infinite() || b == infinite() || c == infinite() || d == infinite()) return false;
        const Vec2 now = site(b) - site(a);
        const Vec2 other = site(d) - site(c);
        const int shorter = exact_compare_lengths(other, now);
        if (shorter < 0 || (shorter == 0 && direction_rank(other) >= direction_rank(now)))
            return false;
        return exact_in_circle(site(a), site(b), site(c), site(d)) == 0;
    }

    /// Every flip replaces an edge by one that comes before it in a fixed order, so this ends.
    void join_by_shorter_diagonals() {
        const auto consider = [this](Index h) {
            if (!wants_other_diagonal(h)) return;
            const Index g = mesh_.twin[h];
            flip(h);
            stack_.insert(stack_.end(), {h, prev(h), g, prev(g)});
        };
        for (Index h = 0; h < 3 * mesh_.triangle_count; ++h) {
            if (mesh_.twin[h] < h) continue;
            consider(h);
            while (!stack_.empty()) {
                const Index side = stack_.back();
                stack_.pop_back();
                consider(side);
            }
        }
    }

    FlipMesh mesh_;
    std::vector<Index> stack_;
};

}  // namespace

FlipMesh triangulate(std::span<const Vec2> sites, std::span<const Index> order) {
    return Inserter(sites).run(order);
}

}  // namespace relief::mesh
