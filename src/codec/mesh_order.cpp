#include "codec/mesh_order.h"

#include <algorithm>
#include <array>

#include "codec/mesh_series.h"

namespace relief::codec {

namespace {

using mesh::Index;
using mesh::Topology;
using multires::MeshScheme;

/// A clamp of what was decoded; what is encoded stays.
Index below(std::int64_t value, Index count) {
    return static_cast<Index>(std::clamp<std::int64_t>(value, 0, std::int64_t{count} - 1));
}

/// The faces of each depth of a hierarchy whose last steps make four faces of one: face k of a
/// depth gives faces 4 k .. 4 k + 3 of the next. A face is as the first of those that stand at its
/// corners.
class FaceTree {
  public:
    explicit FaceTree(const MeshHierarchy& hierarchy)
        : corners_(static_cast<Index>(hierarchy.topology(hierarchy.steps()).sides)) {
        numbers_.emplace_back(hierarchy.topology(hierarchy.steps()).face_count, 0);
        if (hierarchy.spec().scheme == MeshScheme::Sqrt3) return;
        // Catmull-Clark bases may have faces that are split into other numbers.
        const int sides = static_cast<int>(corners_);
        for (int step = hierarchy.steps(); step > 0 && hierarchy.topology(step - 1).sides == sides;
             --step)
            numbers_.emplace_back(hierarchy.topology(step - 1).face_count, 0);
    }

    /// 0 is the finest.
    [[nodiscard]] std::size_t coarsest() const { return numbers_.size() - 1; }
    [[nodiscard]] Index corners() const { return corners_; }
    [[nodiscard]] std::vector<Index>& at(std::size_t level) { return numbers_[level]; }

    /// From the finest level to all others.
    void gather() {
        for (std::size_t level = 1; level < numbers_.size(); ++level)
            for (Index f = 0; f < at(level).size(); ++f)
                at(level)[f] = at(level - 1)[4 * f + first_of(level, f)];
    }

    /// Which of the faces at its corners has the smallest number.
    [[nodiscard]] Index first_of(std::size_t level, Index f) const {
        const auto begin = numbers_[level - 1].begin() + static_cast<std::ptrdiff_t>(4) * f;
        return static_cast<Index>(std::min_element(begin, begin + corners_) - begin);
    }

  private:
    Index corners_;
    std::vector<std::vector<Index>> numbers_;
};

/// One text for encoder and decoder.
template <class Coder>
class OrderCoder {
  public:
    OrderCoder(Series<Coder>& series, const MeshHierarchy& hierarchy)
        : series_(series),
          hierarchy_(hierarchy),
          finest_(hierarchy.topology(hierarchy.steps())),
          sides_(static_cast<Index>(finest_.sides)),
          tree_(hierarchy),
          turns_(tree_.coarsest() + 1) {
        last_.fill(-1);
    }

    /// together: vertices are numbered as one series, not those of each step and kind by
    /// themselves. False: faces do not occur once each.
    bool run(MeshOrder& order, bool together) {
        together = series_.code(together ? 1 : 0, kTurn) != 0;
        for (Index f = 0; f < finest_.face_count; ++f) tree_.at(0)[f] = order.corners[f] / sides_;
        tree_.gather();
        code_roots();
        for (std::size_t level = tree_.coarsest(); level > 0; --level) code_fours(level);
        const std::vector<Index>& faces = tree_.at(0);
        if (!is_permutation(faces)) return false;
        code_turns(order.corners);
        std::vector<Index> face_at(faces.size());
        for (Index f = 0; f < faces.size(); ++f) face_at[faces[f]] = f;
        std::vector<std::uint8_t> seen(finest_.vertex_count, 0);
        for (const Index f : face_at)
            for (Index k = 0; k < sides_; ++k) {
                const Index turn = order.corners[f] % sides_;
                const Index v = finest_.origin[sides_ * f + (k + sides_ - turn) % sides_];
                if (!seen[v]) code_vertex(order.vertices[v], together ? 0 : kind_of(v));
                seen[v] = 1;
            }
        return true;
    }

  private:
    static constexpr std::uint32_t kRoot = 0, kSibling = 1, kTurn = 2, kVertex = 3;
    static constexpr std::uint32_t kVertexKinds = NumberModel::kKinds - kVertex;
    static constexpr std::size_t kMostSteps = 32;

    /// What was known of the last face at such a place, and of the first of the four.
    struct Sibling {
        std::int64_t number = -1;
        std::int64_t first = 0;
        std::int64_t slope = 1;  ///< numbers here go on so many times as fast as there
    };

    /// A stride that occurs twice is expected again.
    void code_roots() {
        std::int64_t last = -1;
        std::int64_t difference = 0;
        std::int64_t stride = 1;
        for (Index& root : tree_.at(tree_.coarsest())) {
            root = below(series_.code_near(root, last + stride, kRoot), finest_.face_count);
            if (root - last == difference) stride = difference;
            difference = root - last;
            last = root;
        }
    }

    /// A face among the four that come from one, counted from the first; a middle triangle turns
    /// with its four.
    struct Place {
        Index kind = 0;
        Index turn = 0;
    };
    [[nodiscard]] Place place_of(std::size_t level, Index f) const {
        if (level == tree_.coarsest()) return {};
        const Index four = turns_[level + 1][f / 4];
        const Index k = f % 4;
        if (k < tree_.corners()) return {(k + tree_.corners() - four) % tree_.corners(), 0};
        return {k, four};
    }

    /// Which of the four is as the face that they come from; then the others.
    void code_fours(std::size_t level) {
        std::array<Index, 4> turns{};
        std::array<Sibling, 4> siblings;
        const Index corners = tree_.corners();
        for (Index f = 0; f < tree_.at(level).size(); ++f) {
            const Place place = place_of(level, f);
            Index& turn = turns[place.kind];
            const Index wanted = (tree_.first_of(level, f) + corners - place.turn) % corners;
            turn = below(series_.code_near(wanted, turn, kTurn), corners);
            const Index first = (turn + place.turn) % corners;
            turns_[level].push_back(first);
            Index* four = tree_.at(level - 1).data() + std::size_t{4} * f;
            four[first] = tree_.at(level)[f];
            for (Index k = 1; k < 4; ++k) {
                Index& number = four[k < corners ? (first + k) % corners : k];
                number = code_sibling(number, four[first], k, siblings[k]);
            }
        }
    }

    Index code_sibling(Index number, std::int64_t first, Index k, Sibling& last) {
        const std::int64_t run = first - last.first;
        const std::int64_t expected = last.number < 0 ? first + k : last.number + last.slope * run;
        number = below(series_.code_near(number, expected, kSibling), finest_.face_count);
        const std::int64_t rise = number - last.number;
        if (last.number >= 0 && run != 0 && rise % run == 0) last.slope = rise / run;
        last.number = number;
        last.first = first;
        return number;
    }

    /// Which corner of the mesh's face the first corner is.
    void code_turns(std::vector<Index>& corners) {
        std::array<Index, 4> turns{};
        for (Index f = 0; f < finest_.face_count; ++f) {
            const Place place = place_of(0, f);
            Index& turn = turns[place.kind];
            turn =
                below(series_.code_near((corners[f] + place.turn) % sides_, turn, kTurn), sides_);
            corners[f] = sides_ * tree_.at(0)[f] + (turn + sides_ - place.turn) % sides_;
        }
    }

    /// By the step that made a vertex; points on edges and in faces are told apart.
    [[nodiscard]] std::size_t kind_of(Index v) const {
        int depth = 0;
        while (v >= hierarchy_.vertices(depth)) ++depth;
        if (depth == 0) return 0;
        const Topology& coarse = hierarchy_.topology(depth - 1);
        const bool in_face = v - coarse.vertex_count >= coarse.edge_count;
        return 2 * static_cast<std::size_t>(depth) - (in_face ? 0 : 1);
    }

    void code_vertex(Index& number, std::size_t kind) {
        std::int64_t& last = last_[kind];
        const std::uint32_t context =
            kVertex + std::min(static_cast<std::uint32_t>(kind), kVertexKinds - 1);
        number = below(series_.code_near(number, last + 1, context), finest_.vertex_count);
        last = number;
    }

    Series<Coder>& series_;
    const MeshHierarchy& hierarchy_;
    const Topology& finest_;
    Index sides_;
    FaceTree tree_;
    std::vector<std::vector<Index>> turns_;  ///< [level][face]: which of its four is as it
    std::array<std::int64_t, 2 * kMostSteps + 1> last_{};
};

}  // namespace

MeshOrder same_order(const Topology& finest) {
    MeshOrder order;
    const auto sides = static_cast<Index>(finest.sides);
    for (Index v = 0; v < finest.vertex_count; ++v) order.vertices.push_back(v);
    for (Index f = 0; f < finest.face_count; ++f) order.corners.push_back(sides * f);
    return order;
}

Bytes write_order(const MeshOrder& order, const MeshHierarchy& hierarchy) {
    if (order == same_order(hierarchy.topology(hierarchy.steps()))) return {};
    const auto bytes_with = [&](bool together) {
        MeshOrder copy = order;
        return encoded([&](auto& series) { OrderCoder(series, hierarchy).run(copy, together); });
    };
    Bytes together = bytes_with(true);
    Bytes apart = bytes_with(false);
    return together.size() < apart.size() ? together : apart;
}

Result<MeshOrder> read_order(std::span<const std::uint8_t> bytes, const MeshHierarchy& hierarchy) {
    MeshOrder order = same_order(hierarchy.topology(hierarchy.steps()));
    if (bytes.empty()) return order;
    bool sound = false;
    RELIEF_CHECK(decoded(bytes, "order", [&](auto& series) {
        sound = OrderCoder(series, hierarchy).run(order, false);
    }));
    if (sound && is_permutation(order.vertices)) return order;
    return damaged_chunk("order");
}

}  // namespace relief::codec
