#include "codec/mesh_coarse.h"

#include <cstddef>
#include <numeric>

namespace relief::codec {

namespace {

using mesh::Index;

/// Two corners that have the same element, unless a seam crosses face `face`.
struct Joint {
    Index face = 0;
    Index first = 0;
    Index second = 0;
};

/// Where the corners of a depth are in finer meshes: for each half-edge one that begins at the same
/// vertex, in a face that lies in the same face, or if none does partly so.
struct CornerPlaces {
    std::vector<Index> half_edges;
    std::vector<Joint> joints;  ///< between places, of faces that finer ones lie across

    template <class Place>
    void move(Place place) {
        for (Index& h : half_edges) h = place(h);
        for (Joint& joint : joints) {
            joint.first = place(joint.first);
            joint.second = place(joint.second);
        }
    }
};

/// A step of sqrt(3) from one of the meshes that have twins.
struct Sqrt3Step {
    const mesh::Topology& coarse;
    mesh::Split split;
    Buffer<Index> faces;  ///< [half-edge]: the fine face there

    Sqrt3Step(const MeshHierarchy& hierarchy, int step)
        : coarse(hierarchy.topology(step)),
          split(hierarchy.rules(step).split),
          faces(mesh::sqrt3_faces(coarse, split)) {}

    [[nodiscard]] bool is_trisected(Index h) const {
        return split == mesh::Split::Sqrt3Even && coarse.on_boundary(h);
    }
    /// The fine half-edge that begins at the corner of h, half within its face: it belongs to the
    /// fine face at h, or in front of a trisected edge to that across the edge before.
    [[nodiscard]] Index half_within(Index h) const {
        return 3 * faces[is_trisected(h) ? coarse.twin[coarse.prev(h)] : h];
    }
};

/// Two steps of sqrt(3) cut every triangle into nine. At its corner lies the one that the second
/// step makes of the edge into the corner's face that the first step made there.
Index after_two_steps(const Sqrt3Step& first, const mesh::Topology& between,
                      const Sqrt3Step& second, Index h) {
    if (first.is_trisected(h)) return 3 * second.faces[first.half_within(h)];
    const Index inwards = first.half_within(h) + 2;  // from the point of the face to the corner
    const Index outwards = between.twin[inwards];
    if (outwards != mesh::kNone) return 3 * second.faces[outwards];
    return 3 * second.faces[inwards] + 1;  // a third of a trisected edge
}

/// One step of sqrt(3): three faces lie half within a face, around its point. A seam between these
/// crosses the face.
CornerPlaces after_one_step(const Sqrt3Step& step) {
    CornerPlaces places;
    const mesh::Topology& coarse = step.coarse;
    for (Index h = 0; h < coarse.half_edge_count(); ++h)
        places.half_edges.push_back(step.half_within(h));
    for (Index f = 0; f < coarse.face_count; ++f) {
        const Index side =
            step.split == mesh::Split::Sqrt3Even ? mesh::boundary_side(coarse, f) : mesh::kNone;
        const auto at_point = [&](Index h) { return 3 * step.faces[h] + 2; };
        if (side == mesh::kNone) {
            places.joints.push_back({f, at_point(3 * f), at_point(3 * f + 1)});
            places.joints.push_back({f, at_point(3 * f), at_point(3 * f + 2)});
            continue;
        }
        // Beside the face in the middle: (first point, second point, corner across).
        const Index middle = 3 * step.faces[side];
        places.joints.push_back({f, middle, step.half_within(side) + 1});
        places.joints.push_back({f, middle, at_point(coarse.prev(side))});
        places.joints.push_back({f, middle + 1, at_point(coarse.next(side))});
    }
    return places;
}

/// In the finest mesh.
CornerPlaces finest_places(const MeshHierarchy& hierarchy, int depth) {
    CornerPlaces places;
    const int steps = hierarchy.steps();
    if (hierarchy.spec().scheme != multires::MeshScheme::Sqrt3) {
        places.half_edges.resize(hierarchy.topology(depth).half_edge_count());
        std::iota(places.half_edges.begin(), places.half_edges.end(), Index{0});
        for (int step = depth; step < steps; ++step)
            places.move([&](Index h) {
                return mesh::halves(hierarchy.topology(step), hierarchy.rules(step).split, h)[0];
            });
        return places;
    }
    if ((steps - depth) % 2 != 0) {
        places = after_one_step(Sqrt3Step(hierarchy, depth++));
    } else {
        places.half_edges.resize(hierarchy.topology(depth).half_edge_count());
        std::iota(places.half_edges.begin(), places.half_edges.end(), Index{0});
    }
    for (; depth < steps; depth += 2) {
        const Sqrt3Step first(hierarchy, depth);
        const Sqrt3Step second(hierarchy, depth + 1);
        places.move([&](Index h) {
            return after_two_steps(first, hierarchy.topology(depth + 1), second, h);
        });
    }
    return places;
}

/// The same in the numbers of the mesh.
CornerPlaces mesh_places(const MeshOrder& order, const MeshHierarchy& hierarchy, int depth) {
    const auto sides = static_cast<Index>(hierarchy.topology(hierarchy.steps()).sides);
    CornerPlaces places = finest_places(hierarchy, depth);
    places.move([&](Index h) {
        const Index first = order.corners[h / sides];
        return first / sides * sides + (first % sides + h % sides) % sides;
    });
    return places;
}

MeshAttribute of_vertices(const MeshAttribute& fine, const MeshOrder& order, std::size_t count) {
    MeshAttribute coarse{fine.name, fine.components, fine.type, {}, {}};
    for (std::size_t v = 0; v < count; ++v) {
        const double* element = fine.element(order.vertices[v]);
        coarse.values.insert(coarse.values.end(), element, element + fine.components);
    }
    return coarse;
}

/// Elements in the order in which corners name them first. Faces without an element at some corner,
/// and those that a seam crosses, have none.
MeshAttribute of_corners(const MeshAttribute& fine, const CornerPlaces& places,
                         const PolygonMesh& coarse) {
    MeshAttribute result{fine.name, fine.components, fine.type, {}, {}};
    std::vector<bool> crossed(static_cast<std::size_t>(coarse.polygon_count()));
    for (const Joint& joint : places.joints)
        if (fine.corners[joint.first] != fine.corners[joint.second]) crossed[joint.face] = true;
    std::vector<std::int32_t> number(static_cast<std::size_t>(fine.element_count()), -1);
    for (std::size_t f = 0; f < crossed.size(); ++f) {
        const auto first = static_cast<std::size_t>(coarse.offsets[f]);
        const auto end = static_cast<std::size_t>(coarse.offsets[f + 1]);
        bool has_all = !crossed[f];
        for (std::size_t c = first; c < end; ++c)
            has_all = has_all && fine.corners[places.half_edges[c]] >= 0;
        for (std::size_t c = first; c < end; ++c) {
            if (!has_all) {
                result.corners.push_back(-1);
                continue;
            }
            const std::int32_t own = fine.corners[places.half_edges[c]];
            std::int32_t& element = number[static_cast<std::size_t>(own)];
            if (element < 0) {
                element = static_cast<std::int32_t>(result.element_count());
                result.values.insert(result.values.end(), fine.element(own),
                                     fine.element(own) + fine.components);
            }
            result.corners.push_back(element);
        }
    }
    return result;
}

}  // namespace

void take_coarse_extras(const PolygonMesh& fine, const MeshOrder& order,
                        const MeshHierarchy& hierarchy, int depth, PolygonMesh& coarse) {
    const CornerPlaces places = mesh_places(order, hierarchy, depth);
    for (const MeshAttribute& attribute : fine.attributes)
        coarse.attributes.push_back(attribute.face_varying()
                                        ? of_corners(attribute, places, coarse)
                                        : of_vertices(attribute, order, coarse.vertices.size()));
    const auto sides = static_cast<Index>(hierarchy.topology(hierarchy.steps()).sides);
    for (const FaceLabels& labels : fine.labels) {
        FaceLabels& added =
            coarse.labels.emplace_back(FaceLabels{labels.keyword, labels.names, {}});
        for (std::size_t f = 0; f + 1 < coarse.offsets.size(); ++f)
            added.of_face.push_back(
                labels.of_face[places.half_edges[static_cast<std::size_t>(coarse.offsets[f])] /
                               sides]);
    }
}

}  // namespace relief::codec
