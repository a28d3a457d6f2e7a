#include "codec/mesh_order.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "shapes.h"

namespace relief::codec {
namespace {

using mesh::Index;
using mesh::Topology;
using multires::MeshScheme;

MeshHierarchy hierarchy(const test::Shape& base, MeshScheme scheme, int steps) {
    return *MeshHierarchy::create(base.topology(), {}, {.scheme = scheme}, steps);
}

const Topology& finest(const MeshHierarchy& all) {
    return all.topology(all.steps());
}

/// number(f): that of face f in the mesh, turn(f): which of its corners is the first.
template <class Number, class Turn>
MeshOrder numbered(const MeshHierarchy& all, Number number, Turn turn) {
    MeshOrder order = same_order(finest(all));
    const auto sides = static_cast<Index>(finest(all).sides);
    for (Index f = 0; f < order.corners.size(); ++f)
        order.corners[f] = sides * number(f) + turn(f) % sides;
    return order;
}

/// Vertices as the faces of the mesh name them first.
void number_by_faces(const MeshHierarchy& all, MeshOrder& order) {
    const Topology& mesh = finest(all);
    const auto sides = static_cast<Index>(mesh.sides);
    std::vector<Index> corner_of(mesh.half_edge_count());
    for (Index f = 0; f < mesh.face_count; ++f)
        for (Index k = 0; k < sides; ++k)
            corner_of[order.corners[f] / sides * sides + (order.corners[f] + k) % sides] =
                sides * f + k;
    std::vector<Index> number(mesh.vertex_count, mesh::kNone);
    Index next = 0;
    for (const Index h : corner_of)
        if (number[mesh.origin[h]] == mesh::kNone) number[mesh.origin[h]] = next++;
    order.vertices = number;
}

std::size_t expect_round_trip(const MeshHierarchy& all, const MeshOrder& order) {
    const Bytes bytes = write_order(order, all);
    const auto decoded = read_order(bytes, all);
    EXPECT_TRUE(decoded.ok());
    if (decoded.ok()) {
        EXPECT_EQ(*decoded, order);
    }
    return bytes.size();
}

std::vector<MeshHierarchy> families() {
    std::vector<MeshHierarchy> all;
    all.push_back(hierarchy(test::flipped(test::icosahedron(), 30, 3), MeshScheme::Loop, 3));
    all.push_back(hierarchy(test::grid(4, 3, true), MeshScheme::Loop, 1));
    all.push_back(hierarchy(test::double_torus(), MeshScheme::CatmullClark, 2));
    all.push_back(hierarchy(test::tetrahedron(), MeshScheme::CatmullClark, 3));
    all.push_back(hierarchy(test::grid(4, 3, true), MeshScheme::Sqrt3, 3));
    return all;
}

TEST(MeshOrder, AnyOrderReturns) {
    std::mt19937 random(5);
    for (const MeshHierarchy& all : families()) {
        EXPECT_EQ(expect_round_trip(all, same_order(finest(all))), 0U);
        for (int k = 0; k < 3; ++k) {
            std::vector<Index> faces(finest(all).face_count);
            for (Index f = 0; f < faces.size(); ++f) faces[f] = f;
            std::shuffle(faces.begin(), faces.end(), random);
            MeshOrder order = numbered(
                all, [&](Index f) { return faces[f]; }, [&](Index) { return Index(random() % 4); });
            std::shuffle(order.vertices.begin(), order.vertices.end(), random);
            expect_round_trip(all, order);
        }
    }
}

/// Numberings by rule cost bytes, not bits a vertex.
TEST(MeshOrder, RulesCostLittle) {
    const MeshHierarchy all =
        hierarchy(test::flipped(test::icosahedron(), 30, 3), MeshScheme::Loop, 5);
    const Index faces = finest(all).face_count;
    const auto same = [](Index f) { return f; };
    // The faces of a four begin at other corners; vertices follow the faces.
    MeshOrder turned = numbered(all, same, [](Index f) { return f % 4; });
    number_by_faces(all, turned);
    EXPECT_LT(expect_round_trip(all, turned), 150U);  // 10242 vertices
    // First the corner faces of all fours, then the three others of each; the last face first.
    const auto blocks = [&](Index f) {
        const Index four = faces / 4 - 1 - f / 4;
        return f % 4 == 0 ? four : faces / 4 + 3 * four + f % 4 - 1;
    };
    MeshOrder blocked = numbered(all, blocks, [](Index) { return Index(1); });
    number_by_faces(all, blocked);
    EXPECT_LT(expect_round_trip(all, blocked), 150U);
}

TEST(MeshOrder, HostileBytes) {
    std::mt19937 random(3);
    for (const MeshHierarchy& all : families()) {
        MeshOrder order = numbered(
            all, [](Index f) { return f; }, [](Index f) { return f % 3; });
        std::reverse(order.vertices.begin(), order.vertices.end());
        const Bytes bytes = write_order(order, all);
        for (int k = 0; k < 200; ++k) {
            Bytes altered = bytes;
            for (unsigned edits = 0; edits <= random() % 4; ++edits)
                altered[random() % altered.size()] = static_cast<std::uint8_t>(random());
            if (random() % 4 == 0) altered.resize(1 + random() % altered.size());
            const auto decoded = read_order(altered, all);
            if (!decoded.ok()) continue;
            std::vector<Index> numbers = decoded->vertices;
            std::sort(numbers.begin(), numbers.end());
            for (Index v = 0; v < numbers.size(); ++v) ASSERT_EQ(numbers[v], v);
        }
    }
}

}  // namespace
}  // namespace relief::codec
