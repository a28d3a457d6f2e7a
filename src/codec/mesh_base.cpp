#include "codec/mesh_base.h"

#include <algorithm>
#include <optional>

#include "codec/mesh_border.h"
#include "codec/number_coder.h"

namespace relief::codec {

namespace {

using mesh::Index;
using mesh::kNone;
using Corner = MeshBorder::Corner;

constexpr std::uint32_t kLargestFace = 1U << 20;

/// How a corner of a face is told.
enum class Step : std::uint8_t {
    Along,   ///< the next vertex of the border
    Back,    ///< the last corner: the vertex before the gate
    Fresh,   ///< a new vertex
    Across,  ///< another vertex of the border
};

/// What the coder has learnt.
struct BaseModel {
    std::array<Slot, 24> hole;
    std::array<Slot, 96> along;
    std::array<Slot, 96> back;
    std::array<Slot, 24> fresh;
    std::array<Slot, 4> component;
    std::array<Slot, 64> size;
    NumberModel numbers;
};

/// One text for encoder and decoder. Source tells what is there: for the decoder, nothing.
template <class Coder, class Source>
class BaseCoder {
  public:
    BaseCoder(Coder& coder, Source& source, int sides, std::size_t vertices, std::size_t faces)
        : coder_(coder), source_(source), sides_(sides), vertices_(vertices), faces_(faces) {
        mesh_.points.reserve(std::min<std::size_t>(vertices, 1 << 20));
    }

    /// Nothing: the bytes are not those of a mesh of this size.
    std::optional<BaseMesh> run() {
        while (mesh_.faces.size() < faces_) {
            if (!code_seed()) return std::nullopt;
            for (; next_gate_ < gates_.size() && mesh_.faces.size() < faces_; ++next_gate_) {
                const Index gate = gates_[next_gate_];
                if (!border_.is_open(gate)) continue;
                if (!code_gate(gate)) return std::nullopt;
                forget_gates();
            }
        }
        if (mesh_.points.size() != vertices_) return std::nullopt;
        return std::move(mesh_);
    }

  private:
    static std::size_t class_of(Index degree) { return std::min<std::size_t>(degree, 7); }

    /// No mesh that anyone has is near it; what a damaged file claims is bounded by it.
    [[nodiscard]] std::size_t most_half_edges() const {
        return 64 * (vertices_ + faces_) + (1 << 20);
    }

    /// What was looked at is not kept.
    void forget_gates() {
        constexpr std::size_t many = 1 << 16;
        if (next_gate_ < many || 2 * next_gate_ < gates_.size()) return;
        gates_.erase(gates_.begin(), gates_.begin() + static_cast<std::ptrdiff_t>(next_gate_));
        next_gate_ = 0;
    }

    std::size_t code_size(std::size_t size) {
        if (sides_ != 0) return static_cast<std::size_t>(sides_);
        std::size_t result = 3;
        while (result < kLargestFace &&
               code_adaptive(coder_, result < size,
                             model_.size[std::min<std::size_t>(result - 3, 63)]))
            ++result;
        return result;
    }

    bool code_seed() {
        next_gate_ = 0;
        gates_.clear();
        source_.begin_component();
        const std::size_t size = code_size(source_.size());
        if (mesh_.points.size() + size > vertices_) return false;
        std::vector<Corner> corners(size);
        const std::size_t first = mesh_.points.size();
        for (std::size_t k = 0; k < size; ++k) {
            corners[k] = {static_cast<Index>(first + k), kNone, false};
            GridPoint expected{};
            if (k > 0)
                expected = mesh_.points.back();
            else if (first > 0)
                expected = mesh_.points[first - 1];
            code_point(source_.vertex(k), expected);
        }
        const auto edges = static_cast<Index>(border_.half_edges());
        border_.add_seed(corners);
        finish_face(corners, edges);
        return true;
    }

    bool code_gate(Index gate) {
        source_.at_gate(gate);
        const Index a = border_.origin(gate);
        const Index b = border_.target(gate);
        const std::size_t holes = is_hole(border_.next(gate)) + is_hole(border_.prev(gate));
        const std::size_t context =
            3 * class_of(std::min(border_.degree(a), border_.degree(b))) + holes;
        if (code_adaptive(coder_, source_.is_hole(), model_.hole[context])) {
            holes_.resize(border_.half_edges(), 0);
            holes_[gate] = 1;
            return true;
        }
        const std::size_t size = code_size(source_.size());
        if (size > vertices_ || border_.half_edges() + size > most_half_edges()) return false;
        std::vector<Corner> corners(size);
        corners[0] = {a, gate, true};
        corners[1] = {b, border_.next(gate), false};
        for (std::size_t k = 2; k < size; ++k)
            if (!code_corner(gate, corners, k)) return false;
        // The last side is known where the border before the gate begins with it.
        Corner& last = corners[size - 1];
        last.glued = last.out == border_.prev(gate) && last.out != gate;
        const auto edges = static_cast<Index>(border_.half_edges());
        if (!is_sound(gate, corners)) return false;
        border_.add_face(gate, corners);
        finish_face(corners, edges);
        return true;
    }

    /// No vertex twice, no side on a hole or glued twice.
    bool is_sound(Index gate, const std::vector<Corner>& corners) {
        seen_.resize(mesh_.points.size(), 0);
        bool sound = true;
        for (const Corner& corner : corners) {
            sound = sound && seen_[corner.vertex] == 0;
            seen_[corner.vertex] = 1;
            const bool glued = corner.glued && corner.out != gate;
            sound = sound && !(glued && (is_hole(corner.out) || !border_.is_open(corner.out)));
        }
        for (const Corner& corner : corners) seen_[corner.vertex] = 0;
        return sound;
    }

    [[nodiscard]] bool is_hole(Index edge) const { return edge < holes_.size() && holes_[edge]; }

    bool code_corner(Index gate, std::vector<Corner>& corners, std::size_t k) {
        Corner& before = corners[k - 1];
        const bool is_last = k + 1 == corners.size();
        const Step wanted = source_.step(k, before.out, border_.prev(gate));
        const Step step = code_step(wanted, gate, before, is_last);
        switch (step) {
            case Step::Along:
                before.glued = true;
                corners[k] = {border_.target(before.out), border_.next(before.out), false};
                break;
            case Step::Back:
                corners[k] = {border_.origin(border_.prev(gate)), border_.prev(gate), false};
                break;
            case Step::Fresh: {
                if (mesh_.points.size() == vertices_) return false;
                corners[k] = {static_cast<Index>(mesh_.points.size()), kNone, false};
                code_point(source_.vertex(k), expected_point(gate, corners, k));
                break;
            }
            case Step::Across: {
                const std::uint32_t count = static_cast<std::uint32_t>(border_.half_edges());
                const Index out = code_uniform(source_.across(k), count);
                if (out >= count || !border_.is_open(out)) return false;
                corners[k] = {border_.origin(out), out, false};
                break;
            }
        }
        last_ = step;
        return true;
    }

    Step code_step(Step wanted, Index gate, const Corner& before, bool is_last) {
        const auto last = static_cast<std::size_t>(last_);
        const bool can_go_along = before.out != kNone && !is_hole(before.out);
        const Index back = border_.prev(gate);
        const bool same = can_go_along && border_.target(before.out) == border_.origin(back);
        if (can_go_along) {
            const std::size_t context =
                (3 * class_of(border_.degree(before.vertex)) + (is_last ? same ? 2 : 1 : 0)) * 4 +
                last;
            if (code_adaptive(coder_, wanted == Step::Along, model_.along[context]))
                return Step::Along;
        }
        if (is_last && !is_hole(back)) {
            const std::size_t context =
                (3 * class_of(border_.degree(border_.origin(gate))) + (same ? 1 : 0)) * 4 + last;
            if (code_adaptive(coder_, wanted == Step::Back, model_.back[context]))
                return Step::Back;
        }
        const bool fresh = code_adaptive(coder_, wanted == Step::Fresh,
                                         model_.fresh[4 * std::min<std::size_t>(sides_, 4) + last]);
        return fresh ? Step::Fresh : Step::Across;
    }

    /// value < count.
    std::uint32_t code_uniform(std::uint32_t value, std::uint32_t count) {
        return code_low_bits(coder_, value, static_cast<int>(std::bit_width(count - 1)));
    }

    /// Faces are expected to go on as the one before the gate.
    GridPoint expected_point(Index gate, const std::vector<Corner>& corners, std::size_t k) const {
        const GridPoint& a = mesh_.points[corners[0].vertex];
        const GridPoint& b = mesh_.points[corners[1].vertex];
        GridPoint expected{};
        if (k > 2) {  // beside the side of the gate
            const GridPoint& c = mesh_.points[corners[k - 1].vertex];
            for (std::size_t i = 0; i < 3; ++i) expected[i] = c[i] + a[i] - b[i];
            return expected;
        }
        // `gate` is a side b, a of a known face; in front of b stands the corner before.
        const auto [begin, size] = face_of(gate);
        const Index side = gate - begin;
        const GridPoint& z = mesh_.points[mesh_.faces.corners[begin + (side + size - 1) % size]];
        const bool triangle = corners.size() == 3;
        for (std::size_t i = 0; i < 3; ++i) expected[i] = (triangle ? a[i] : b[i]) + b[i] - z[i];
        return expected;
    }

    [[nodiscard]] std::pair<Index, Index> face_of(Index half_edge) const {
        const std::size_t f = face_of_[half_edge];
        const auto begin = static_cast<Index>(mesh_.faces.offsets[f]);
        return {begin, static_cast<Index>(mesh_.faces.offsets[f + 1]) - begin};
    }

    void code_point(const GridPoint& point, const GridPoint& expected) {
        NumberCoder<Coder> numbers(coder_, model_.numbers);
        GridPoint coded{};
        for (std::size_t i = 0; i < 3; ++i) {
            const auto difference = static_cast<std::int64_t>(
                static_cast<std::uint64_t>(point[i]) - static_cast<std::uint64_t>(expected[i]));
            const std::int64_t q =
                numbers.code(difference, static_cast<std::uint32_t>(i), recent_[i], all_);
            coded[i] = static_cast<std::int64_t>(static_cast<std::uint64_t>(expected[i]) +
                                                 static_cast<std::uint64_t>(q));
            remember(i, q);
        }
        mesh_.points.push_back(coded);
    }

    /// Magnitudes of the last few; all coordinates together.
    void remember(std::size_t axis, std::int64_t q) {
        constexpr std::uint32_t some = 8;
        for (Surrounding* sum : {&recent_[axis], &all_}) {
            if (sum->count >= some) {
                sum->magnitude /= 2;
                sum->balance = 0;
                sum->count /= 2;
            }
            sum->add(q);
        }
    }

    void finish_face(const std::vector<Corner>& corners, Index first_edge) {
        for (std::size_t k = 0; k < corners.size(); ++k) {
            mesh_.faces.corners.push_back(corners[k].vertex);
            face_of_.push_back(static_cast<Index>(mesh_.faces.size()));
            const auto edge = static_cast<Index>(first_edge + k);
            if (border_.is_open(edge)) gates_.push_back(edge);
        }
        mesh_.faces.offsets.push_back(static_cast<std::int64_t>(mesh_.faces.corners.size()));
        source_.take_face(corners, first_edge);
    }

    Coder& coder_;
    Source& source_;
    int sides_;
    std::size_t vertices_;
    std::size_t faces_;
    BaseModel model_;
    BaseMesh mesh_;
    MeshBorder border_;
    std::vector<Index> gates_;
    std::size_t next_gate_ = 0;
    std::vector<Index> face_of_;       ///< [coded half-edge]
    std::vector<std::uint8_t> holes_;  ///< [coded half-edge]: the border is that of the mesh
    std::vector<std::uint8_t> seen_;   ///< [coded vertex]
    std::array<Surrounding, 3> recent_;
    Surrounding all_;
    Step last_ = Step::Fresh;
};

/// What the decoder knows beforehand.
struct NoSource {
    void begin_component() {}
    void at_gate(Index) {}
    [[nodiscard]] static bool is_hole() { return false; }
    [[nodiscard]] static std::size_t size() { return 0; }
    [[nodiscard]] static GridPoint vertex(std::size_t) { return {}; }
    [[nodiscard]] static Step step(std::size_t, Index, Index) { return Step::Fresh; }
    [[nodiscard]] static std::uint32_t across(std::size_t) { return 0; }
    void take_face(const std::vector<Corner>&, Index) {}
};

/// The mesh that is encoded.
class KnownMesh {
  public:
    KnownMesh(const mesh::Topology& mesh, std::span<const GridPoint> points)
        : mesh_(mesh),
          points_(points),
          coded_(mesh.half_edge_count(), kNone),
          vertex_(mesh.vertex_count, kNone),
          into_boundary_(mesh.vertex_count, kNone) {
        for (Index h = 0; h < mesh.half_edge_count(); ++h)
            if (mesh.on_boundary(h)) into_boundary_[mesh.target(h)] = h;
    }

    void begin_component() {
        while (coded_[mesh_.first_of(seed_)] != kNone) ++seed_;
        first_ = mesh_.first_of(seed_);
    }
    void at_gate(Index gate) { first_ = mesh_.twin[half_edges_[gate]]; }
    [[nodiscard]] bool is_hole() const { return first_ == kNone; }
    [[nodiscard]] std::size_t size() const { return mesh_.size_of(mesh_.face_of(first_)); }

    [[nodiscard]] Index corner(std::size_t k) const {
        const Index f = mesh_.face_of(first_);
        const Index begin = mesh_.first_of(f);
        return begin + (first_ - begin + static_cast<Index>(k)) % mesh_.size_of(f);
    }
    [[nodiscard]] GridPoint vertex(std::size_t k) const { return points_[mesh_.origin[corner(k)]]; }

    /// out: the border edge that leaves corner k - 1.
    [[nodiscard]] Step step(std::size_t k, Index out, Index back) const {
        const Index h = corner(k);
        if (vertex_[mesh_.origin[h]] == kNone) return Step::Fresh;
        if (out != kNone && mesh_.twin[half_edges_[out]] == corner(k - 1)) return Step::Along;
        if (k + 1 == size() && mesh_.twin[half_edges_[back]] == h) return Step::Back;
        return Step::Across;
    }

    /// The border edge behind corner k, clockwise.
    [[nodiscard]] std::uint32_t across(std::size_t k) const {
        Index h = corner(k);
        if (vertex_[mesh_.origin[h]] == kNone) return 0;
        while (true) {
            Index twin = mesh_.twin[h];
            if (twin == kNone) twin = into_boundary_[mesh_.origin[h]];
            if (coded_[twin] != kNone) return coded_[twin];
            h = mesh_.next(twin);
        }
    }

    void take_face(const std::vector<Corner>& corners, Index first_edge) {
        corners_.push_back(first_);
        for (std::size_t k = 0; k < corners.size(); ++k) {
            const Index h = corner(k);
            coded_[h] = static_cast<Index>(first_edge + k);
            half_edges_.push_back(h);
            Index& number = vertex_[mesh_.origin[h]];
            if (number != kNone) continue;
            number = corners[k].vertex;
            vertices_.push_back(mesh_.origin[h]);
        }
    }

    [[nodiscard]] std::vector<Index> take_vertices() { return std::move(vertices_); }
    [[nodiscard]] std::vector<Index> take_corners() { return std::move(corners_); }

  private:
    const mesh::Topology& mesh_;
    std::span<const GridPoint> points_;
    std::vector<Index> coded_;          ///< [half-edge]
    std::vector<Index> vertex_;         ///< [vertex]: coded
    std::vector<Index> into_boundary_;  ///< [vertex]
    std::vector<Index> half_edges_;     ///< [coded half-edge]
    std::vector<Index> vertices_;       ///< [coded vertex]
    std::vector<Index> corners_;        ///< [coded face]
    Index seed_ = 0;
    Index first_ = kNone;  ///< the half-edge that the face begins with
};

}  // namespace

CodedBase encode_base(const mesh::Topology& mesh, std::span<const GridPoint> points) {
    RangeEncoder encoder;
    KnownMesh source(mesh, points);
    BaseCoder<RangeEncoder, KnownMesh> coder(encoder, source, mesh.sides, mesh.vertex_count,
                                             mesh.face_count);
    coder.run();
    return {encoder.finish(), source.take_vertices(), source.take_corners()};
}

Result<BaseMesh> decode_base(std::span<const std::uint8_t> bytes, int sides, std::uint64_t vertices,
                             std::uint64_t faces) {
    RangeDecoder decoder(bytes);
    NoSource source;
    BaseCoder<RangeDecoder, NoSource> coder(decoder, source, sides, vertices, faces);
    std::optional<BaseMesh> mesh = coder.run();
    if (!mesh || !decoder.at_end())
        return Error{
            ErrorCode::BadFile,
            "it does not hold a mesh of " + std::to_string(faces) + " faces; the file is damaged",
            "base chunk"};
    return *std::move(mesh);
}

}  // namespace relief::codec
