#include "relief/multires/attributes.h"

#include <array>
#include <span>

#include "relief/mesh/walk.h"

namespace relief::multires {

namespace {

using mesh::Index;
using mesh::Split;
using mesh::Topology;

constexpr std::int32_t kNoElement = -1;

/// Elements are added to those that are there.
class CornerSplit {
  public:
    CornerSplit(const Topology& mesh, const CornerValues& coarse)
        : mesh_(mesh),
          coarse_(coarse),
          fine_(coarse),
          on_side_(mesh.half_edge_count(), kNoElement) {
        fine_.of_corner.clear();
        mesh::each_half_edge(mesh, [&](Index, Index h, Index next, Index) {
            const Index twin = mesh.twin[h];
            const bool joined = !mesh.on_boundary(h) && twin < h && at(twin) == at(next) &&
                                at(mesh.next(twin)) == at(h);
            on_side_[h] = joined ? on_side_[twin] : mean(std::array{at(h), at(next)});
        });
    }

    CornerValues loop() {
        for (Index f = 0; f < mesh_.face_count; ++f) {
            const Index h = 3 * f;
            for (Index k = 0; k < 3; ++k)
                add({at(h + k), on_side_[h + k], on_side_[h + (k + 2) % 3]});
            add({on_side_[h], on_side_[h + 1], on_side_[h + 2]});
        }
        return std::move(fine_);
    }

    CornerValues catmull_clark() {
        for (Index f = 0; f < mesh_.face_count; ++f) {
            const Index first = mesh_.first_of(f);
            const std::int32_t middle =
                mean(std::span(coarse_.of_corner).subspan(first, mesh_.size_of(f)));
            for (Index h = first; h < first + mesh_.size_of(f); ++h)
                add({at(h), on_side_[h], middle, on_side_[mesh_.prev(h)]});
        }
        return std::move(fine_);
    }

  private:
    [[nodiscard]] std::int32_t at(Index h) const { return coarse_.of_corner[h]; }

    void add(std::initializer_list<std::int32_t> face) {
        fine_.of_corner.insert(fine_.of_corner.end(), face);
    }

    std::int32_t mean(std::span<const std::int32_t> elements) {
        if (elements[0] == kNoElement) return kNoElement;
        const auto components = static_cast<std::size_t>(coarse_.components);
        const auto number = static_cast<std::int32_t>(fine_.values.size() / components);
        for (std::size_t c = 0; c < components; ++c) {
            double sum = 0;
            for (const std::int32_t e : elements)
                sum += coarse_.values[static_cast<std::size_t>(e) * components + c];
            fine_.values.push_back(sum / static_cast<double>(elements.size()));
        }
        return number;
    }

    const Topology& mesh_;
    const CornerValues& coarse_;
    CornerValues fine_;
    std::vector<std::int32_t> on_side_;  ///< [half-edge]: of the point on it
};

}  // namespace

CornerValues subdivided(const Topology& coarse, Split split, const CornerValues& corners) {
    CornerSplit parts(coarse, corners);
    return split == Split::Loop ? parts.loop() : parts.catmull_clark();
}

std::vector<std::int32_t> subdivided_labels(const Topology& coarse, Split split,
                                            const std::vector<std::int32_t>& labels) {
    std::vector<std::int32_t> fine;
    for (Index f = 0; f < coarse.face_count; ++f)
        fine.insert(fine.end(), split == Split::Loop ? 4 : coarse.size_of(f), labels[f]);
    return fine;
}

}  // namespace relief::multires
