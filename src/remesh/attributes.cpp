#include "remesh/attributes.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <utility>

#include "relief/core/raster.h"

namespace relief::remesh {

namespace {

using mesh::Index;
using mesh::kNone;

/// How often the way from the middle of a face to its corner is halved where a seam crosses it.
constexpr int kHalvings = 8;

void make_unit(double* normal) {
    const double size =
        std::sqrt(normal[0] * normal[0] + normal[1] * normal[1] + normal[2] * normal[2]);
    for (int k = 0; size > 0 && k < 3; ++k) normal[k] /= size;
}

/// The values of an attribute anywhere on a surface.
class Field {
  public:
    Field(const PolygonMesh& source, const Surface& surface, const MeshAttribute& attribute)
        : source_(source), surface_(surface), attribute_(attribute) {}

    /// The element at a corner of a face of the surface; -1: none.
    [[nodiscard]] std::int32_t element(Index face, std::size_t k) const {
        const auto corner = static_cast<std::size_t>(surface_.corner_sources[face][k]);
        return attribute_.face_varying() ? attribute_.corners[corner] : source_.corners[corner];
    }
    void append(const Place& place, std::vector<double>& values) const {
        const std::size_t first = values.size();
        for (int c = 0; c < attribute_.components; ++c) {
            double value = 0;
            for (std::size_t k = 0; k < 3; ++k)
                value += place.weights[k] * attribute_.element(element(place.face, k))[c];
            values.push_back(value);
        }
        if (attribute_.name == "normal") make_unit(values.data() + first);
        for (std::size_t k = first; k < values.size(); ++k)
            values[k] = stored_value(values[k], attribute_.type, {});
    }

  private:
    const PolygonMesh& source_;
    const Surface& surface_;
    const MeshAttribute& attribute_;
};

/// The faces of the surface that hang together by sides along which both have the same elements.
std::vector<Index> charts_of(const Surface& surface, const Field& field) {
    const mesh::Topology& mesh = surface.mesh;
    std::vector<Index> chart(mesh.face_count, kNone);
    std::vector<Index> waiting;
    Index count = 0;
    for (Index first = 0; first < mesh.face_count; ++first) {
        if (chart[first] != kNone || field.element(first, 0) < 0) continue;
        chart[first] = count;
        waiting.push_back(first);
        while (!waiting.empty()) {
            const Index f = waiting.back();
            waiting.pop_back();
            for (Index k = 0; k < 3; ++k) {
                const Index twin = mesh.twin[3 * f + k];
                if (twin == kNone || chart[twin / 3] != kNone) continue;
                const bool joined =
                    field.element(f, k) == field.element(twin / 3, (twin + 1) % 3) &&
                    field.element(f, (k + 1) % 3) == field.element(twin / 3, twin % 3);
                if (!joined) continue;
                chart[twin / 3] = count;
                waiting.push_back(twin / 3);
            }
        }
        ++count;
    }
    return chart;
}

/// Where the middle of each face is on the surface.
std::vector<Place> middles_of(const MovingMesh& mesh) {
    std::vector<Place> middles;
    for (Index f = 0; f < mesh.face_count(); ++f) {
        const Index* v = mesh.corners.data() + 3 * f;
        const auto on = [&](Index u) { return mesh.surface->point(mesh.places[u]); };
        const Vec3<double> start = on(v[0]);
        const Vec3<double> middle = 1.0 / 3 * (start + on(v[1]) + on(v[2]));
        middles.push_back(walk(*mesh.surface, mesh.places[v[0]], middle - start));
    }
    return middles;
}

/// Values of corners, one element for each vertex and chart, but for those cut off at seams.
class CornerSampler {
  public:
    CornerSampler(const PolygonMesh& source, const MovingMesh& mesh, const MeshAttribute& attribute)
        : mesh_(mesh),
          field_(source, *mesh.surface, attribute),
          charts_(charts_of(*mesh.surface, field_)) {}

    void sample(const std::vector<Place>& middles, MeshAttribute& result) {
        for (Index f = 0; f < mesh_.face_count(); ++f) {
            const Index chart = charts_[middles[f].face];
            for (Index k = 0; k < 3; ++k)
                result.corners.push_back(
                    chart == kNone ? -1
                                   : element(mesh_.corners[3 * f + k], chart, middles[f], result));
        }
    }

  private:
    std::int32_t element(Index v, Index chart, const Place& middle, MeshAttribute& result) {
        const Place& place = mesh_.places[v];
        if (charts_[place.face] != chart) return append(nearest(v, chart, middle), result);
        const auto [found, is_new] = numbers_.emplace(std::pair{v, chart}, 0);
        if (is_new) found->second = append(place, result);
        return found->second;
    }
    std::int32_t append(const Place& place, MeshAttribute& result) const {
        field_.append(place, result.values);
        return static_cast<std::int32_t>(result.element_count() - 1);
    }
    /// The last place of the chart on the way from the middle of a face to its corner.
    [[nodiscard]] Place nearest(Index v, Index chart, const Place& middle) const {
        const Surface& surface = *mesh_.surface;
        const Vec3<double> way = surface.point(mesh_.places[v]) - surface.point(middle);
        Place inside = middle;
        double reached = 0;
        double step = 0.5;
        for (int k = 0; k < kHalvings; ++k, step /= 2) {
            const Place further = walk(surface, middle, (reached + step) * way);
            if (charts_[further.face] != chart) continue;
            reached += step;
            inside = further;
        }
        return inside;
    }

    const MovingMesh& mesh_;
    Field field_;
    std::vector<Index> charts_;
    std::map<std::pair<Index, Index>, std::int32_t> numbers_;
};

}  // namespace

void take_attributes(const PolygonMesh& source, const MovingMesh& mesh, PolygonMesh& result) {
    result.libraries = source.libraries;
    if (source.attributes.empty() && source.labels.empty()) return;
    const std::vector<Place> middles = middles_of(mesh);
    for (const MeshAttribute& attribute : source.attributes) {
        MeshAttribute& added = result.attributes.emplace_back();
        added.name = attribute.name;
        added.components = attribute.components;
        added.type = attribute.type;
        if (attribute.face_varying()) {
            CornerSampler(source, mesh, attribute).sample(middles, added);
            continue;
        }
        const Field field(source, *mesh.surface, attribute);
        for (const Place& place : mesh.places) field.append(place, added.values);
    }
    for (const FaceLabels& labels : source.labels) {
        FaceLabels& added = result.labels.emplace_back(labels);
        added.of_face.clear();
        for (const Place& middle : middles)
            added.of_face.push_back(labels.of_face[mesh.surface->face_sources[middle.face]]);
    }
}

}  // namespace relief::remesh
