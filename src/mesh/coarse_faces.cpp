#include "mesh/coarse_faces.h"

#include <algorithm>
#include <utility>

namespace relief::mesh {

namespace {

/// Collects the coarse faces of all fine faces with a label.
class Emitter {
  public:
    Emitter(const Topology& fine, Split split, const Label* labels)
        : fine_(fine), split_(split), labels_(labels) {}

    CoarseFaces run() {
        const std::size_t corners =
            fine_.origin.size() / (split_ == Split::Sqrt3Odd || split_ == Split::Sqrt3Even ? 3 : 4);
        coarse_.faces.corners.reserve(corners);
        coarse_.fine.reserve(corners);
        if (split_ == Split::Loop)
            add_centres();
        else
            add_fans();
        if (split_ == Split::Sqrt3Even) add_trisected();
        return std::move(coarse_);
    }

  private:
    /// Across the sides of a middle face are its corners.
    void add_centres() {
        for (Index f = 0; f < fine_.face_count; ++f) {
            if (labels_[f] != kCentre) continue;
            for (Index h = 3 * f; h < 3 * f + 3; ++h) {
                const Index out = fine_.prev(fine_.twin[h]);
                coarse_.add(fine_.origin[out], out);
            }
            coarse_.end_face();
        }
    }

    /// Around face points.
    void add_fans() {
        const auto out = outgoing(fine_);
        for (Index v = 0; v < fine_.vertex_count; ++v) {
            const Label label = labels_[fine_.face_of(out[v])];
            if (label == kUnlabelled || fine_.on_boundary(out[v]) ||
                role_of(split_, label, out[v] - fine_.first_of(fine_.face_of(out[v]))) !=
                    kFacePoint)
                continue;
            Index h = out[v];
            do {
                const Index corner = fine_.face_of(h);
                if (split_ == Split::CatmullClark) {
                    const Index old = fine_.next(fine_.next(h));
                    coarse_.add(fine_.origin[old], old);
                } else if (role_of(split_, labels_[corner], fine_.next(h) - 3 * corner) == kOld) {
                    coarse_.add(fine_.target(h), fine_.next(h));
                }
                h = rotated(fine_, h);
            } while (h != out[v]);
            coarse_.end_face();
        }
    }

    /// Even sqrt(3): (p, q, c) on the boundary is the middle of (a, b, c).
    void add_trisected() {
        Buffer<Index> before(fine_.vertex_count);
        for (Index h = 0; h < fine_.half_edge_count(); ++h)
            if (fine_.on_boundary(h)) before[fine_.target(h)] = h;
        const auto out = outgoing(fine_);
        for (Index f = 0; f < fine_.face_count; ++f) {
            const Label label = labels_[f];
            if (label > 2) continue;
            const Index middle = 3 * f + (label + 1U) % 3;
            if (!fine_.on_boundary(middle)) continue;
            const Index last = fine_.target(out[fine_.target(middle)]);
            const Index to_p = fine_.twin[fine_.prev(middle)];
            if (to_p == kNone) continue;  // its vertices are refused
            coarse_.add(fine_.origin[before[fine_.origin[middle]]], middle);
            coarse_.add(last, fine_.next(out[fine_.target(middle)]));
            coarse_.add(fine_.origin[3 * f + label], fine_.next(to_p));
            coarse_.end_face();
        }
    }

    const Topology& fine_;
    Split split_;
    const Label* labels_;
    CoarseFaces coarse_;
};

}  // namespace

CoarseFaces coarse_faces(const Topology& fine, Split split, const Label* labels) {
    return Emitter(fine, split, labels).run();
}

CoarseFaces sorted(const CoarseFaces& coarse, Index vertex_count, std::vector<Index>& old) {
    Buffer<Index> rank(vertex_count);
    std::fill_n(rank.data(), vertex_count, kNone);
    for (const Index v : coarse.faces.corners) rank[v] = 0;
    for (Index v = 0; v < vertex_count; ++v) {
        if (rank[v] == kNone) continue;
        rank[v] = static_cast<Index>(old.size());
        old.push_back(v);
    }
    struct Face {
        Index second;
        Index number;
        Index turn;
    };
    const std::size_t count = coarse.faces.size();
    Buffer<Index> ends(old.size() + 1);
    std::fill_n(ends.data(), ends.size(), Index{0});
    Buffer<Index> turns(count);
    for (std::size_t f = 0; f < count; ++f) {
        const auto corners = coarse.faces[f];
        turns[f] =
            static_cast<Index>(std::min_element(corners.begin(), corners.end()) - corners.begin());
        ++ends[rank[corners[turns[f]]]];
    }
    Index sum = 0;
    for (std::size_t v = 0; v < ends.size(); ++v) sum += std::exchange(ends[v], sum);
    Buffer<Face> order(count);
    for (std::size_t f = 0; f < count; ++f) {
        const auto corners = coarse.faces[f];
        const Index turn = turns[f];
        order[ends[rank[corners[turn]]]++] = {corners[turn + 1 == corners.size() ? 0 : turn + 1],
                                              static_cast<Index>(f), turn};
    }
    Index begin = 0;
    for (std::size_t v = 0; v < old.size(); ++v) {
        std::sort(order.data() + begin, order.data() + ends[v],
                  [](const Face& a, const Face& b) { return a.second < b.second; });
        begin = ends[v];
    }
    CoarseFaces result;
    result.faces.corners.reserve(coarse.fine.size());
    result.faces.offsets.reserve(count + 1);
    result.fine.reserve(coarse.fine.size());
    for (std::size_t k = 0; k < count; ++k) {
        const auto corners = coarse.faces[order[k].number];
        const auto first = static_cast<std::size_t>(coarse.faces.offsets[order[k].number]);
        std::size_t corner = order[k].turn;
        for (std::size_t n = 0; n < corners.size(); ++n) {
            result.add(rank[corners[corner]], coarse.fine[first + corner]);
            corner = corner + 1 == corners.size() ? 0 : corner + 1;
        }
        result.end_face();
    }
    return result;
}

}  // namespace relief::mesh
