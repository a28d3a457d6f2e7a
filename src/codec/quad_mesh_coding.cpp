#include "codec/quad_mesh_coding.h"

#include <algorithm>
#include <cmath>

#include "codec/bytes.h"
#include "codec/packed.h"
#include "codec/value_lattice.h"

namespace relief::codec {

using mesh::Index;
using mesh::TurnedQuad;

namespace {

constexpr std::uint64_t kVarintBytes = 10;
constexpr const char* kMeshChunk = "mesh chunk";
constexpr const char* kNumberingChunk = "numbering chunk";

std::vector<double> axis(std::span<const Vec2> places, double Vec2::*coordinate) {
    std::vector<double> numbers;
    for (const Vec2& place : places) numbers.push_back(place.*coordinate);
    return numbers;
}

ValueLattice lattice_of(std::optional<int> digits) {
    if (!digits) return {.kind = ValueLattice::Kind::Float64};
    return {.kind = ValueLattice::Kind::Decimal, .digits = *digits};
}

/// Differences of the integers that stand for the coordinates.
void write_axis(const std::vector<double>& numbers, std::optional<int> digits, ByteWriter& out) {
    const ValueLattice lattice = lattice_of(digits);
    std::uint64_t last = 0;
    for (const double number : numbers) {
        const auto k = static_cast<std::uint64_t>(lattice.nearest(number));
        out.varint(zigzag(static_cast<std::int64_t>(k - last)));
        last = k;
    }
}

void read_axis(ByteReader& in, std::optional<int> digits, double Vec2::*coordinate,
               std::vector<Vec2>& places) {
    const ValueLattice lattice = lattice_of(digits);
    std::uint64_t k = 0;
    for (Vec2& place : places) {
        k += static_cast<std::uint64_t>(unzigzag(in.varint()));
        place.*coordinate = lattice.value(static_cast<std::int64_t>(k));
    }
}

/// Numbers of which each is mostly one more than the last.
class Sequence {
  public:
    std::uint64_t coded(std::uint64_t number) {
        const auto code = zigzag(static_cast<std::int64_t>(number - expected_));
        expected_ = number + 1;
        return code;
    }
    std::uint64_t decoded(std::uint64_t code) {
        const std::uint64_t number = expected_ + static_cast<std::uint64_t>(unzigzag(code));
        expected_ = number + 1;
        return number;
    }

  private:
    std::uint64_t expected_ = 0;
};

bool same_numbers(const Numbering& numbering) {
    for (std::size_t v = 0; v < numbering.vertices.size(); ++v)
        if (numbering.vertices[v] != v) return false;
    for (std::size_t q = 0; q < numbering.quads.size(); ++q)
        if (numbering.quads[q] != TurnedQuad{static_cast<Index>(q), 0}) return false;
    return true;
}

bool same_places(std::span<const Vec2> a, std::span<const Vec2> b) {
    for (std::size_t v = 0; v < a.size(); ++v)
        if (ordinal_of(a[v].x) != ordinal_of(b[v].x) || ordinal_of(a[v].y) != ordinal_of(b[v].y))
            return false;
    return true;
}

void write_place(double place, double expected, ByteWriter& out) {
    out.varint(zigzag(static_cast<std::int64_t>(static_cast<std::uint64_t>(ordinal_of(place)) -
                                                static_cast<std::uint64_t>(ordinal_of(expected)))));
}

double read_place(ByteReader& in, double expected) {
    return double_at(static_cast<std::int64_t>(static_cast<std::uint64_t>(ordinal_of(expected)) +
                                               static_cast<std::uint64_t>(unzigzag(in.varint()))));
}

/// False: a number is out of range or stands twice.
bool read_numbers(ByteReader& in, Numbering& numbering) {
    Sequence sequence;
    std::vector<std::uint8_t> met(numbering.vertices.size());
    for (Index& vertex : numbering.vertices) {
        const std::uint64_t number = sequence.decoded(in.varint());
        if (number >= met.size() || met[number]++ != 0) return false;
        vertex = static_cast<Index>(number);
    }
    sequence = {};
    met.assign(numbering.quads.size(), 0);
    for (TurnedQuad& quad : numbering.quads) {
        const std::uint64_t number = sequence.decoded(in.varint());
        if (number >= met.size() || met[number]++ != 0) return false;
        quad.quad = static_cast<Index>(number);
    }
    for (TurnedQuad& quad : numbering.quads) {
        quad.turn = in.u8();
        if (quad.turn > 3) return false;
    }
    return true;
}

}  // namespace

PlaceDigits PlaceDigits::of(std::span<const Vec2> places) {
    return {decimal_digits(axis(places, &Vec2::x)), decimal_digits(axis(places, &Vec2::y))};
}

Vec2 PlaceDigits::rounded(Vec2 place) const {
    const auto round = [](double number, std::optional<int> digits) {
        const ValueLattice lattice = lattice_of(digits);
        return lattice.value(lattice.nearest(number));
    };
    return {round(place.x, x), round(place.y, y)};
}

Bytes write_mesh(const PlaneMesh& mesh, const PlaceDigits& digits) {
    ByteWriter out;
    write_axis(axis(mesh.vertices, &Vec2::x), digits.x, out);
    write_axis(axis(mesh.vertices, &Vec2::y), digits.y, out);
    std::int64_t first = 0;
    for (const auto& quad : mesh.quads) {
        std::int64_t last = first;
        for (const Index v : quad) {
            out.varint(zigzag(v - last));
            last = v;
        }
        first = quad[0];
    }
    return pack(out.take());
}

Result<PlaneMesh> read_mesh(std::span<const std::uint8_t> bytes, std::uint64_t vertices,
                            std::uint64_t quads, const PlaceDigits& digits) {
    const Error damaged{ErrorCode::BadFile, "the mesh is damaged", kMeshChunk};
    RELIEF_TRY(const Bytes numbers,
               unpack(bytes, kVarintBytes * (2 * vertices + 4 * quads), kMeshChunk));
    if (numbers.size() < 2 * vertices + 4 * quads) return damaged;
    ByteReader in(numbers);
    PlaneMesh mesh;
    mesh.vertices.resize(static_cast<std::size_t>(vertices));
    mesh.quads.resize(static_cast<std::size_t>(quads));
    read_axis(in, digits.x, &Vec2::x, mesh.vertices);
    read_axis(in, digits.y, &Vec2::y, mesh.vertices);
    std::uint64_t first = 0;
    for (auto& quad : mesh.quads) {
        std::uint64_t vertex = first;
        for (Index& v : quad) {
            vertex += static_cast<std::uint64_t>(unzigzag(in.varint()));
            if (vertex >= vertices) return damaged;
            v = static_cast<Index>(vertex);
        }
        first = quad[0];
    }
    if (in.failed() || !in.rest().empty()) return damaged;
    return mesh;
}

std::vector<Vec2> places_of(const mesh::Quadrangulation& level, std::span<const Vec2> base,
                            const PlaceDigits& digits) {
    std::vector<Vec2> places(base.begin(), base.end());
    for (auto v = static_cast<Index>(base.size()); v < level.vertex_count(); ++v)
        places.push_back(digits.rounded(level.origin + level.vertex(v)));
    return places;
}

Bytes write_numbering(const Numbering& numbering, std::span<const Vec2> expected) {
    const bool numbers = !same_numbers(numbering);
    const bool places = !same_places(numbering.places, expected);
    if (!numbers && !places) return {};
    ByteWriter out;
    out.u8(static_cast<std::uint8_t>(numbers) + 2 * static_cast<std::uint8_t>(places));
    if (numbers) {
        Sequence sequence;
        for (const Index number : numbering.vertices) out.varint(sequence.coded(number));
        sequence = {};
        for (const TurnedQuad& quad : numbering.quads) out.varint(sequence.coded(quad.quad));
        for (const TurnedQuad& quad : numbering.quads) out.u8(static_cast<std::uint8_t>(quad.turn));
    }
    if (places)
        for (std::size_t v = 0; v < expected.size(); ++v) {
            write_place(numbering.places[v].x, expected[v].x, out);
            write_place(numbering.places[v].y, expected[v].y, out);
        }
    return pack(out.take());
}

Result<Numbering> read_numbering(std::span<const std::uint8_t> bytes,
                                 std::span<const Vec2> expected, std::size_t quads) {
    Numbering numbering{std::vector<Index>(expected.size()), std::vector<TurnedQuad>(quads),
                        std::vector<Vec2>(expected.begin(), expected.end())};
    for (std::size_t v = 0; v < expected.size(); ++v) numbering.vertices[v] = static_cast<Index>(v);
    for (std::size_t q = 0; q < quads; ++q) numbering.quads[q].quad = static_cast<Index>(q);
    if (bytes.empty()) return numbering;

    const Error damaged{ErrorCode::BadFile, "the numbering of the mesh is damaged",
                        kNumberingChunk};
    const std::uint64_t most = 1 + kVarintBytes * (3 * expected.size() + quads) + quads;
    RELIEF_TRY(const Bytes text, unpack(bytes, most, kNumberingChunk));
    ByteReader in(text);
    const std::uint8_t parts = in.u8();
    if ((parts & 1) != 0 && !read_numbers(in, numbering)) return damaged;
    if ((parts & 2) != 0)
        for (Vec2& place : numbering.places) {
            place.x = read_place(in, place.x);
            place.y = read_place(in, place.y);
        }
    if (parts > 3 || in.failed() || !in.rest().empty()) return damaged;
    const auto finite = [](Vec2 p) { return std::isfinite(p.x) && std::isfinite(p.y); };
    if (!std::all_of(numbering.places.begin(), numbering.places.end(), finite)) return damaged;
    return numbering;
}

}  // namespace relief::codec
