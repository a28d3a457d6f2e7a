#include "mesh/seed_spread.h"

#include <utility>

namespace relief::mesh {

namespace {

/// Faces of the queue that are fetched ahead.
constexpr std::size_t kAhead = 8;

/// What labels in all ways say at once.
struct Tables {
    std::array<std::array<std::array<PackedLabels, 256>, 4>, 4> across;  ///< [side][its][labels]
    std::array<std::array<PackedLabels, 256>, 4> may_end;  ///< [side][labels]: low bits
    RoleTable roles;

    Tables(Split split, Index sides) {
        const std::size_t ways = way_count(split);
        for (unsigned labels = 0; labels < 256; ++labels)
            for (Index k = 0; k < sides; ++k) {
                may_end[k][labels] = 0;
                roles[k][labels] = 0;
                for (std::size_t way = 0; way < ways; ++way) {
                    const Label label = label_in(split, static_cast<PackedLabels>(labels), way);
                    may_end[k][labels] |=
                        static_cast<PackedLabels>(mesh::may_end(split, label, k) << 2 * way);
                    roles[k][labels] |=
                        static_cast<PackedRoles>(role_of(split, label, k) << 3 * way);
                }
                for (Index m = 0; m < sides; ++m) set_across(split, labels, k, m);
            }
    }

  private:
    void set_across(Split split, unsigned labels, Index k, Index m) {
        unsigned wanted = 0;
        for (std::size_t way = 0; way < way_count(split); ++way) {
            const Label label = label_in(split, static_cast<PackedLabels>(labels), way);
            const int other = label_across(split, label, k, m);
            wanted |= static_cast<unsigned>(other == kCentre ? 3 : other) << 2 * way;
        }
        across[k][m][labels] = static_cast<PackedLabels>(wanted);
    }
};

const Tables& tables_of(Split split) {
    static const Tables loop(Split::Loop, 3);
    static const Tables quads(Split::CatmullClark, 4);
    static const Tables odd(Split::Sqrt3Odd, 3);
    static const Tables even(Split::Sqrt3Even, 3);
    switch (split) {
        case Split::Loop:
            return loop;
        case Split::CatmullClark:
            return quads;
        case Split::Sqrt3Odd:
            return odd;
        case Split::Sqrt3Even:
            break;
    }
    return even;
}

}  // namespace

const RoleTable& role_table(Split split) {
    return tables_of(split).roles;
}

namespace {

template <Index Sides>
class Spreader {
  public:
    Spreader(const Topology& fine, Split split)
        : fine_(fine), tables_(tables_of(split)), queue_(fine.face_count) {
        for (std::size_t way = 0; way < way_count(split); ++way) {
            seed_ |= static_cast<PackedLabels>(way << 2 * way);
            all_ |= static_cast<PackedLabels>(1U << 2 * way);
        }
        result_.parts.of_face.assign(fine.face_count, kNone);
        result_.labels.resize(fine.face_count);
    }

    SeedSpread run() {
        for (Index f = 0; f < fine_.face_count; ++f) {
            if (result_.parts.of_face[f] != kNone) continue;
            result_.conflicts.emplace_back();
            alive_ = all_;
            spread_from(f);
            ++result_.parts.count;
        }
        return std::move(result_);
    }

  private:
    void spread_from(Index seed) {
        std::size_t end = 0;
        const auto reach = [&](Index f, PackedLabels labels) {
            result_.parts.of_face[f] = result_.parts.count;
            result_.labels[f] = labels;
            queue_[end++] = f;
        };
        reach(seed, seed_);
        for (std::size_t k = 0; k < end; ++k) {
            if (k + kAhead < end) __builtin_prefetch(&fine_.twin[Sides * queue_[k + kAhead]]);
            const Index f = queue_[k];
            const PackedLabels labels = result_.labels[f];
            for (Index side = 0; side < Sides; ++side) {
                const Index twin = fine_.twin[Sides * f + side];
                if (twin == kNone) {
                    end_ways(~tables_.may_end[side][labels], kBoundaryPattern, f);
                    continue;
                }
                const Index g = twin / Sides;
                const PackedLabels wanted = tables_.across[side][twin % Sides][labels];
                if (result_.parts.of_face[g] == kNone) {
                    reach(g, wanted);
                    continue;
                }
                const int differ = result_.labels[g] ^ wanted;
                end_ways(differ | differ >> 1, kLabelConflict, g);
            }
        }
    }

    /// ways: low bits.
    void end_ways(int ways, const char* reason, Index face) {
        const int ended = ways & alive_;
        if (ended == 0) return;
        alive_ = static_cast<PackedLabels>(alive_ & ~ended);
        for (std::size_t way = 0; way < kMostWays; ++way)
            if (ended >> 2 * way & 1) result_.conflicts.back()[way] = {reason, face};
    }

    const Topology& fine_;
    const Tables& tables_;
    Buffer<Index> queue_;
    PackedLabels seed_ = 0;
    PackedLabels all_ = 0;
    PackedLabels alive_ = 0;
    SeedSpread result_;
};

}  // namespace

SeedSpread spread_seeds(const Topology& fine, Split split) {
    if (split == Split::CatmullClark) return Spreader<4>(fine, split).run();
    return Spreader<3>(fine, split).run();
}

}  // namespace relief::mesh
