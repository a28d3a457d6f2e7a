#include "codec/mesh_details.h"

#include <algorithm>
#include <string>
#include <utility>

#include "relief/mesh/walk.h"

namespace relief::codec {

namespace {

using mesh::Index;
using mesh::kNone;
using mesh::Split;
using mesh::Topology;
using multires::StepRules;

/// Kinds of numbers, for contexts: the axis, beside an earlier number that is not 0 or not.
enum class DetailKind : std::uint32_t { Axis = 0, StiffAxis = 3, AxisBeside = 6 };

std::uint32_t kind_of(DetailKind kind, std::size_t axis) {
    return static_cast<std::uint32_t>(kind) + static_cast<std::uint32_t>(axis);
}

/// New vertices around one of them, and the coarse vertices that it lies between.
struct Neighbourhood {
    std::vector<Index> beside;  ///< places among the new vertices, coded before
    std::vector<Index> corners;
};

/// In the order of the new vertices: visit(place, neighbourhood).
class Walker {
  public:
    Walker(const Topology& mesh, const StepRules& rules) : mesh_(mesh), rules_(rules) {}

    template <class Visit>
    void run(Visit visit) {
        if (rules_.split == Split::Loop || rules_.split == Split::CatmullClark) {
            mesh::each_edge(mesh_, [&](Index h, Index next, Index) {
                begin({mesh_.origin[h], mesh_.origin[next]});
                beside_edge(h);
                if (!mesh_.on_boundary(h)) beside_edge(mesh_.twin[h]);
                visit(mesh_.edge[h], around_);
            });
            if (rules_.split == Split::CatmullClark) run_faces(visit);
            return;
        }
        run_triangles(visit);
    }

  private:
    void begin(std::initializer_list<Index> corners) {
        around_.beside.clear();
        around_.corners.assign(corners);
    }
    void add(Index place, Index here) {
        if (place < here) around_.beside.push_back(place);
    }
    /// The sides before and behind on the same face.
    void beside_edge(Index h) {
        add(mesh_.edge[mesh_.next(h)], mesh_.edge[h]);
        add(mesh_.edge[mesh_.prev(h)], mesh_.edge[h]);
    }

    template <class Visit>
    void run_faces(Visit visit) {
        for (Index f = 0; f < mesh_.face_count; ++f) {
            const Index place = mesh_.edge_count + f;
            begin({});
            for (Index h = mesh_.first_of(f); h < mesh_.first_of(f + 1); ++h) {
                around_.corners.push_back(mesh_.origin[h]);
                add(mesh_.edge[h], place);
            }
            visit(place, around_);
        }
    }

    /// sqrt(3): faces; two points where one is trisected.
    template <class Visit>
    void run_triangles(Visit visit) {
        const Index first = mesh_.vertex_count;
        for (Index f = 0; f < mesh_.face_count; ++f) {
            const Index place = rules_.face_points[f] - first;
            const Index side = rules_.trisections.empty() ? kNone : mesh::boundary_side(mesh_, f);
            for (Index k = 0; k < (side == kNone ? 1U : 2U); ++k) {
                const Index* v = mesh_.origin.data() + 3 * f;
                begin({v[0], v[1], v[2]});
                for (Index h = 3 * f; h < 3 * f + 3; ++h)
                    if (!mesh_.on_boundary(h))
                        add(rules_.face_points[mesh_.twin[h] / 3] - first, place + k);
                if (k == 1) add(place, place + 1);
                visit(place + k, around_);
            }
        }
    }

    const Topology& mesh_;
    const StepRules& rules_;
    Neighbourhood around_;
};

}  // namespace

template <class Coder>
void MeshDetails::code_next(Coder& coder, QuantisedStep& details) {
    const Topology& mesh = hierarchy_.topology(next_);
    const StepRules& rules = hierarchy_.rules(next_);
    const Index old =
        next_ == 0 ? mesh.vertex_count : static_cast<Index>(hierarchy_.vertices(next_ - 1));
    NumberCoder<Coder> numbers(coder, model_);
    Walker walker(mesh, rules);
    walker.run([&](Index place, const Neighbourhood& around) {
        // The normal first: it says most.
        bool beside = false;
        for (const std::size_t axis : {2U, 0U, 1U}) {
            Surrounding near;
            for (const Index x : around.beside) near.add(details.fresh[x][axis]);
            Surrounding far;
            for (const Index v : around.corners)
                if (v >= old) far.add(before_[v - old][axis]);
            std::int64_t& q = details.fresh[place][axis];
            const DetailKind kind = beside ? DetailKind::AxisBeside : DetailKind::Axis;
            q = numbers.code(q, kind_of(kind, axis), near, far);
            beside = beside || q != 0;
        }
    });
    Surrounding sum;
    for (QuantisedDetail& detail : details.stiff)
        for (std::size_t axis = 0; axis < 3; ++axis) {
            detail[axis] =
                numbers.code(detail[axis], kind_of(DetailKind::StiffAxis, axis), sum, {});
            sum.add(detail[axis]);
        }
    before_ = details.fresh;
    ++next_;
}

Bytes MeshDetails::encode_next(const QuantisedStep& details) {
    QuantisedStep copy = details;
    RangeEncoder encoder;
    code_next(encoder, copy);
    return encoder.finish();
}

Result<QuantisedStep> MeshDetails::decode_next(std::span<const std::uint8_t> bytes) {
    const StepRules& rules = hierarchy_.rules(next_);
    QuantisedStep details;
    details.fresh.resize(rules.new_count);
    details.stiff.resize(rules.stiff.size());
    RangeDecoder decoder(bytes);
    code_next(decoder, details);
    if (decoder.at_end()) return details;
    return Error{ErrorCode::BadFile, "its numbers do not fit its bytes; the file is damaged",
                 "step " + std::to_string(next_ - 1)};
}

}  // namespace relief::codec
