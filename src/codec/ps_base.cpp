#include "codec/ps_base.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <numeric>
#include <tuple>
#include <utility>

#include "codec/bytes.h"
#include "codec/mesh_base.h"
#include "codec/number_coder.h"
#include "codec/value_lattice.h"
#include "relief/mesh/delaunay.h"

namespace relief::codec {

namespace {

using mesh::Index;
using mesh::kNone;
using mesh::Triangulation;
using Triangles = std::vector<std::array<Index, 3>>;

constexpr int kMostGridBits = 50;
constexpr double kPeel = mesh::DelaunayOptions().peel;

Error damaged(const std::string& what) {
    return {ErrorCode::BadFile, what + "; the file is damaged", "mesh chunk"};
}

/// The exponent of the largest power of two of which all coordinates are multiples.
int common_exponent(const Triangulation& mesh) {
    int least = std::numeric_limits<int>::max();
    for (const auto* axis : {&mesh.x, &mesh.y})
        for (const double t : *axis) {
            if (t == 0) continue;
            int exponent = 0;
            const auto mantissa =
                static_cast<std::int64_t>(std::ldexp(std::frexp(t, &exponent), 53));
            const auto bits = static_cast<std::uint64_t>(std::abs(mantissa));
            least = std::min(least, exponent - 53 + std::countr_zero(bits));
        }
    return least;
}

/// The centre of the bounding box.
Vec2 centre_of(std::span<const Vec2> places) {
    Vec2 low = places.front();
    Vec2 high = low;
    for (const Vec2& p : places) {
        low = {std::min(low.x, p.x), std::min(low.y, p.y)};
        high = {std::max(high.x, p.x), std::max(high.y, p.y)};
    }
    return midpoint(low, high);
}

/// Decimals that give the places relative to the origin back, if there are any.
std::optional<PlaceGrid> decimal_grid(const Triangulation& mesh, int exponent) {
    for (int digits = 0; digits <= kMostDigits10; ++digits) {
        PlaceGrid grid{digits, {}, mesh.origin};
        PlaceGrid rounding{digits, exponent, mesh.origin};
        bool plain = true;
        bool rounded = true;
        std::vector<Vec2> places;
        for (Index v = 0; v < mesh.vertex_count() && (plain || rounded); ++v) {
            places.push_back(grid.place(grid.nearest(mesh.origin + mesh.vertex(v))));
            const Vec2 x = places.back() - mesh.origin;
            plain = plain && x == mesh.vertex(v);
            rounded = rounded && rounding.rounded(x) == mesh.vertex(v);
        }
        if (!plain && !rounded) continue;
        if (!plain) grid = rounding;
        if (centre_of(places) == mesh.origin) grid.origin.reset();
        return grid;
    }
    return std::nullopt;
}

PlaceGrid grid_of(const Triangulation& mesh) {
    const int exponent = common_exponent(mesh);
    if (const auto decimals = decimal_grid(mesh, exponent)) return *decimals;
    double most = 0;
    for (Index v = 0; v < mesh.vertex_count(); ++v)
        most = std::max({most, std::abs(mesh.x[v]), std::abs(mesh.y[v])});
    int bits = 0;
    std::frexp(most, &bits);
    return {{}, std::max(exponent, bits - kMostGridBits), mesh.origin};
}

std::vector<GridPlace> grid_places(const Triangulation& mesh, const PlaceGrid& grid) {
    const Vec2 origin = grid.digits ? mesh.origin : Vec2();
    std::vector<GridPlace> places;
    places.reserve(mesh.x.size());
    for (Index v = 0; v < mesh.vertex_count(); ++v)
        places.push_back(grid.nearest(origin + mesh.vertex(v)));
    return places;
}

/// Places as a decoder knows them.
struct Places {
    Vec2 origin;
    std::vector<Vec2> source;    ///< in the source's frame, or without digits relative
    std::vector<Vec2> relative;  ///< to the origin
};

Places places_of(std::span<const GridPlace> grid_places, const PlaceGrid& grid) {
    Places places;
    for (const GridPlace& k : grid_places) places.source.push_back(grid.place(k));
    if (!grid.digits) {
        places.origin = grid.origin.value_or(Vec2());
        places.relative = places.source;
        return places;
    }
    places.origin = grid.origin ? *grid.origin : centre_of(places.source);
    for (const Vec2& p : places.source) places.relative.push_back(grid.rounded(p - places.origin));
    return places;
}

Triangulation connected(Vec2 origin, std::span<const Vec2> relative, Triangles triangles) {
    std::vector<double> x;
    std::vector<double> y;
    for (const Vec2& p : relative) {
        x.push_back(p.x);
        y.push_back(p.y);
    }
    return mesh::connect(origin, std::move(x), std::move(y), std::move(triangles));
}

std::array<Index, 3> sorted(std::array<Index, 3> corners) {
    std::sort(corners.begin(), corners.end());
    return corners;
}

/// Of each place its number among others; none if they are not the same, or two are one.
std::optional<std::vector<Index>> numbers_of(std::span<const GridPlace> places,
                                             std::span<const GridPlace> others) {
    using Entry = std::tuple<std::int64_t, std::int64_t, Index>;
    const auto entries = [](std::span<const GridPlace> list) {
        std::vector<Entry> sorted_entries;
        for (Index k = 0; k < list.size(); ++k)
            sorted_entries.emplace_back(list[k].x, list[k].y, k);
        std::sort(sorted_entries.begin(), sorted_entries.end());
        return sorted_entries;
    };
    const std::vector<Entry> here = entries(places);
    const std::vector<Entry> there = entries(others);
    const auto place = [](const Entry& e) { return std::pair(std::get<0>(e), std::get<1>(e)); };
    std::vector<Index> numbers(here.size());
    for (std::size_t k = 0; k < here.size(); ++k) {
        if (place(here[k]) != place(there[k])) return std::nullopt;
        if (k > 0 && place(here[k]) == place(here[k - 1])) return std::nullopt;
        numbers[std::get<2>(here[k])] = std::get<2>(there[k]);
    }
    return numbers;
}

/// The mesh with other numbers.
Triangulation renumbered(const Triangulation& mesh, const PsNumbering& numbering) {
    std::vector<Vec2> relative;
    for (const Index v : numbering.vertices) relative.push_back(mesh.vertex(v));
    std::vector<Index> back(mesh.x.size());
    for (Index k = 0; k < back.size(); ++k) back[numbering.vertices[k]] = k;
    Triangles triangles;
    for (std::size_t t = 0; t < numbering.triangles.size(); ++t) {
        const auto& corners = mesh.triangles[numbering.triangles[t]];
        auto& turned = triangles.emplace_back();
        for (std::size_t k = 0; k < 3; ++k) turned[k] = back[corners[(k + numbering.turns[t]) % 3]];
    }
    return connected(mesh.origin, relative, std::move(triangles));
}

bool is_identity(const PsNumbering& numbering) {
    const auto counts = [](const std::vector<Index>& list) {
        for (std::size_t k = 0; k < list.size(); ++k)
            if (list[k] != k) return false;
        return true;
    };
    return counts(numbering.vertices) && counts(numbering.triangles) &&
           std::all_of(numbering.turns.begin(), numbering.turns.end(),
                       [](Index turn) { return turn == 0; });
}

/// Numbers in series, each expected to follow the last: one text for both directions.
template <class Coder>
class SeriesCoder {
  public:
    explicit SeriesCoder(Coder& coder) : numbers_(coder, model_) {}

    template <class Integer>
    void code(Integer& number, std::int64_t expected, std::uint32_t kind) {
        const auto difference = static_cast<std::int64_t>(static_cast<std::uint64_t>(number) -
                                                          static_cast<std::uint64_t>(expected));
        const std::int64_t q = numbers_.code(difference, kind, last_[kind], {});
        last_[kind] = {};
        last_[kind].add(q);
        number = static_cast<Integer>(static_cast<std::uint64_t>(expected) +
                                      static_cast<std::uint64_t>(q));
    }

  private:
    NumberModel model_;
    NumberCoder<Coder> numbers_;
    std::array<Surrounding, NumberModel::kKinds> last_;
};

template <class Coder>
void code_numbering(Coder& coder, PsNumbering& numbering) {
    SeriesCoder<Coder> series(coder);
    std::int64_t next = 0;
    for (Index& v : numbering.vertices) {
        series.code(v, next, 0);
        next = std::int64_t{v} + 1;
    }
    next = 0;
    for (std::size_t t = 0; t < numbering.triangles.size(); ++t) {
        series.code(numbering.triangles[t], next, 1);
        series.code(numbering.turns[t], 0, 2);
        next = std::int64_t{numbering.triangles[t]} + 1;
    }
}

Bytes write_numbering(PsNumbering numbering) {
    RangeEncoder encoder;
    code_numbering(encoder, numbering);
    return encoder.finish();
}

bool is_permutation(const std::vector<Index>& list) {
    std::vector<std::uint8_t> met(list.size());
    return std::all_of(list.begin(), list.end(),
                       [&](Index k) { return k < met.size() && met[k]++ == 0; });
}

Result<PsNumbering> read_numbering(std::span<const std::uint8_t> bytes, std::size_t vertices,
                                   std::size_t triangles) {
    PsNumbering numbering{std::vector<Index>(vertices), std::vector<Index>(triangles),
                          std::vector<Index>(triangles)};
    RangeDecoder decoder(bytes);
    code_numbering(decoder, numbering);
    const bool turns = std::all_of(numbering.turns.begin(), numbering.turns.end(),
                                   [](Index turn) { return turn < 3; });
    if (!decoder.at_end() || !turns || !is_permutation(numbering.vertices) ||
        !is_permutation(numbering.triangles))
        return damaged("the numbers of its vertices and triangles are no permutation");
    return numbering;
}

/// What the grid lost, as places among doubles.
template <class Coder>
void code_fractions(Coder& coder, std::span<const Vec2> grid, std::vector<Vec2>& places) {
    SeriesCoder<Coder> series(coder);
    for (std::size_t v = 0; v < grid.size(); ++v)
        for (const auto& [axis, kind] : {std::pair(&Vec2::x, 0U), std::pair(&Vec2::y, 1U)}) {
            std::int64_t ordinal = ordinal_of(places[v].*axis);
            series.code(ordinal, ordinal_of(grid[v].*axis), kind);
            places[v].*axis = double_at(ordinal);
        }
}

Bytes write_fractions(const Triangulation& mesh, std::span<const Vec2> grid) {
    std::vector<Vec2> places;
    for (Index v = 0; v < mesh.vertex_count(); ++v) places.push_back(mesh.vertex(v));
    const bool exact = std::equal(places.begin(), places.end(), grid.begin());
    RangeEncoder encoder;
    if (!exact) code_fractions(encoder, grid, places);
    return exact ? Bytes() : encoder.finish();
}

/// Where fans meet in one vertex only, each fan gets a vertex of its own.
struct Fans {
    Triangles triangles;
    std::vector<Index> vertex;  ///< of each vertex: that of the mesh
};

Fans separate_fans(const Triangulation& mesh) {
    Fans fans{Triangles(mesh.triangles.size()), std::vector<Index>(mesh.x.size())};
    std::iota(fans.vertex.begin(), fans.vertex.end(), 0U);
    for (auto& corners : fans.triangles) corners.fill(kNone);
    std::vector<std::uint8_t> taken(mesh.x.size());
    const auto corner_of = [&](Index t, Index v) {
        const auto& c = mesh.triangles[t];
        return static_cast<Index>(std::find(c.begin(), c.end(), v) - c.begin());
    };
    for (Index t = 0; t < mesh.triangle_count(); ++t)
        for (Index k = 0; k < 3; ++k) {
            if (fans.triangles[t][k] != kNone) continue;
            const Index v = mesh.triangles[t][k];
            const Index name = taken[v]++ == 0 ? v : static_cast<Index>(fans.vertex.size());
            if (name != v) fans.vertex.push_back(v);
            taken[v] = 1;
            // Both ways round, across the sides at the corner.
            for (const Index side : {2U, 0U})
                for (Index at = t; at != kNone;) {
                    const Index corner = corner_of(at, v);
                    if (at != t && fans.triangles[at][corner] == name) break;
                    fans.triangles[at][corner] = name;
                    at = mesh.neighbour(at, (corner + side) % 3);
                    if (at == t) break;
                }
        }
    return fans;
}

/// Parts of the chunk, each with its length before it.
struct Parts {
    Bytes places;  ///< a set, or connectivity with places
    Bytes joined;  ///< vertices that are one
    Bytes fractions;
    Bytes numbering;

    [[nodiscard]] Bytes joined_up() const {
        ByteWriter out;
        for (const Bytes* part : {&places, &joined, &fractions}) {
            out.varint(part->size());
            out.bytes(*part);
        }
        out.bytes(numbering);
        return out.take();
    }
};

struct PartViews {
    std::span<const std::uint8_t> places;
    std::span<const std::uint8_t> joined;
    std::span<const std::uint8_t> fractions;
    std::span<const std::uint8_t> numbering;
};

Result<PartViews> parts_of(std::span<const std::uint8_t> chunk) {
    ByteReader in(chunk);
    PartViews parts;
    for (auto* part : {&parts.places, &parts.joined, &parts.fractions})
        *part = in.take(in.varint());
    if (in.failed()) return damaged("its parts do not fit");
    parts.numbering = in.rest();
    return parts;
}

/// Vertices and triangles in the order of the code.
struct Coded {
    std::vector<GridPlace> places;
    Triangles triangles;
};

/// Triangles of places that are known.
Result<Triangles> delaunay_of(std::vector<GridPlace>& places, const PsBaseHeader& header) {
    const Places known = places_of(places, header.grid);
    RELIEF_TRY(mesh::Delaunay result, mesh::delaunay(known.source, {.peel = *header.peel}));
    if (result.mesh.x.size() != places.size()) return damaged("two of its vertices are one");
    std::vector<GridPlace> ordered(places.size());
    for (std::size_t k = 0; k < places.size(); ++k) ordered[result.vertex_of_point[k]] = places[k];
    places = std::move(ordered);
    return std::move(result.mesh.triangles);
}

Result<Coded> decode_delaunay(const PartViews& parts, const PsBaseHeader& header) {
    Coded coded;
    RELIEF_TRY(coded.places, read_places(parts.places, header.vertices));
    auto triangles = delaunay_of(coded.places, header);
    if (!triangles.ok()) return damaged(triangles.error().message);
    coded.triangles = *std::move(triangles);
    if (coded.triangles.size() != header.triangles)
        return damaged("its vertices have other triangles");
    return coded;
}

/// Which coded vertices are the same as others: pairs (number, number of the one that stays), the
/// first of the pairs ascending.
Result<std::vector<Index>> read_joined(std::span<const std::uint8_t> bytes,
                                       std::uint64_t vertices) {
    ByteReader in(bytes);
    std::vector<std::pair<std::uint64_t, std::uint64_t>> pairs;
    while (!in.rest().empty() && !in.failed()) {
        const std::uint64_t last = pairs.empty() ? 0 : pairs.back().first;
        const std::uint64_t gap = in.varint();
        pairs.emplace_back(last + std::min(gap, std::uint64_t{1} << 32), in.varint());
    }
    const std::uint64_t all = vertices + pairs.size();
    std::vector<Index> number(static_cast<std::size_t>(all), kNone);
    bool good = !in.failed();
    for (const auto& [again, first] : pairs) {
        good = good && again < all && first < again && number[again] == kNone;
        if (good) number[again] = static_cast<Index>(first);
    }
    if (!good) return damaged("its joined vertices are out of range");
    Index next = 0;
    for (Index& n : number) n = n == kNone ? next++ : number[n];
    return number;
}

Bytes write_joined(const std::vector<std::pair<Index, Index>>& pairs) {
    ByteWriter out;
    Index last = 0;
    for (const auto& [again, first] : pairs) {
        out.varint(again - last);
        out.varint(first);
        last = again;
    }
    return out.take();
}

Result<Coded> decode_connectivity(const PartViews& parts, const PsBaseHeader& header) {
    RELIEF_TRY(const std::vector<Index> number, read_joined(parts.joined, header.vertices));
    RELIEF_TRY(const BaseMesh base, decode_base(parts.places, 3, number.size(), header.triangles));
    Coded coded{std::vector<GridPlace>(static_cast<std::size_t>(header.vertices)), {}};
    for (std::size_t k = number.size(); k-- > 0;)
        coded.places[number[k]] = {base.points[k][0], base.points[k][1]};
    for (std::size_t t = 0; t < base.faces.size(); ++t) {
        const auto face = base.faces[t];
        coded.triangles.push_back({number[face[0]], number[face[1]], number[face[2]]});
    }
    return coded;
}

void renumber(const PsNumbering& numbering, Coded& coded) {
    Coded other{std::vector<GridPlace>(coded.places.size()), Triangles(coded.triangles.size())};
    for (std::size_t v = 0; v < coded.places.size(); ++v)
        other.places[numbering.vertices[v]] = coded.places[v];
    for (std::size_t t = 0; t < coded.triangles.size(); ++t)
        for (std::size_t k = 0; k < 3; ++k)
            other.triangles[numbering.triangles[t]][(k + numbering.turns[t]) % 3] =
                numbering.vertices[coded.triangles[t][k]];
    coded = std::move(other);
}

/// The last step of decoding: places become coordinates.
Result<Triangulation> built(Coded coded, std::span<const std::uint8_t> fractions,
                            const PlaceGrid& grid) {
    Places places = places_of(coded.places, grid);
    if (!fractions.empty()) {
        const std::vector<Vec2> on_grid = places.relative;
        RangeDecoder decoder(fractions);
        code_fractions(decoder, on_grid, places.relative);
        if (!decoder.at_end()) return damaged("the places of its vertices are damaged");
    }
    const auto checked =
        mesh::build(places.relative, coded.triangles, {.strict_orientation = true});
    if (!checked.ok()) return damaged(checked.error().text());
    return connected(places.origin, places.relative, std::move(coded.triangles));
}

/// The last step of encoding: `numbering` leads from the code to the mesh.
CodedPsBase finished(const Triangulation& mesh, const PsBaseHeader& header, Parts parts,
                     PsNumbering numbering, bool keep_order) {
    CodedPsBase coded{header, {}, mesh, {}};
    if (!is_identity(numbering)) {
        if (keep_order) {
            parts.numbering = write_numbering(numbering);
        } else {
            coded.mesh = renumbered(mesh, numbering);
            coded.numbering = std::move(numbering);
        }
    }
    const Places known = places_of(grid_places(coded.mesh, header.grid), header.grid);
    parts.fractions = write_fractions(coded.mesh, known.relative);
    coded.chunk = parts.joined_up();
    return coded;
}

/// None: the mesh is no Delaunay triangulation.
std::optional<CodedPsBase> encode_delaunay(const Triangulation& mesh, const PsBaseHeader& header,
                                           bool keep_order) {
    const std::vector<GridPlace> places = grid_places(mesh, header.grid);
    std::vector<GridPlace> ordered = places;
    sort_places(ordered);
    auto triangles = delaunay_of(ordered, header);
    if (!triangles.ok()) return std::nullopt;
    auto vertices = numbers_of(ordered, places);
    if (!vertices) return std::nullopt;
    auto numbering = numbering_of(*triangles, mesh.triangles, *std::move(vertices));
    if (!numbering) return std::nullopt;
    Parts parts;
    parts.places = write_places(places);
    return finished(mesh, header, std::move(parts), *std::move(numbering), keep_order);
}

Result<CodedPsBase> encode_connectivity(const Triangulation& mesh, const PsBaseHeader& header,
                                        bool keep_order) {
    const Fans fans = separate_fans(mesh);
    mesh::FaceList faces;
    for (const auto& corners : fans.triangles) faces.add(corners);
    RELIEF_TRY(const mesh::Topology topology,
               mesh::build(faces, static_cast<Index>(fans.vertex.size())));
    const std::vector<GridPlace> places = grid_places(mesh, header.grid);
    std::vector<GridPoint> points;
    for (const Index v : fans.vertex) points.push_back({places[v].x, places[v].y, 0});
    const CodedBase base = encode_base(topology, points);

    std::vector<Index> first(mesh.x.size(), kNone);  // coded vertices
    std::vector<std::pair<Index, Index>> joined;
    PsNumbering numbering;
    for (Index k = 0; k < base.vertices.size(); ++k) {
        const Index v = fans.vertex[base.vertices[k]];
        if (first[v] == kNone) {
            first[v] = k;
            numbering.vertices.push_back(v);
        } else {
            joined.emplace_back(k, first[v]);
        }
    }
    for (const Index h : base.corners) {
        numbering.triangles.push_back(h / 3);
        numbering.turns.push_back(h % 3);
    }
    Parts parts;
    parts.places = base.bytes;
    parts.joined = write_joined(joined);
    return finished(mesh, header, std::move(parts), std::move(numbering), keep_order);
}

}  // namespace

std::optional<PsNumbering> numbering_of(std::span<const std::array<Index, 3>> triangles,
                                        std::span<const std::array<Index, 3>> others,
                                        std::vector<Index> vertices) {
    if (triangles.size() != others.size()) return std::nullopt;
    using Entry = std::pair<std::array<Index, 3>, Index>;
    std::vector<Entry> there;
    for (Index t = 0; t < others.size(); ++t) there.emplace_back(sorted(others[t]), t);
    std::sort(there.begin(), there.end());
    PsNumbering numbering{std::move(vertices), {}, {}};
    for (const auto& corners : triangles) {
        std::array<Index, 3> renamed{};
        for (std::size_t k = 0; k < 3; ++k) renamed[k] = numbering.vertices[corners[k]];
        const auto found = std::lower_bound(there.begin(), there.end(), Entry(sorted(renamed), 0));
        if (found == there.end() || found->first != sorted(renamed)) return std::nullopt;
        const auto& twin = others[found->second];
        const auto* turn = std::find(twin.begin(), twin.end(), renamed[0]);
        numbering.triangles.push_back(found->second);
        numbering.turns.push_back(static_cast<Index>(turn - twin.begin()));
    }
    return numbering;
}

PsLevelCounts level_counts(const Triangulation& base, int refined) {
    constexpr std::uint64_t enough = std::uint64_t{1} << 56;
    PsLevelCounts counts{base.vertex_count(), base.edge_count(), base.triangle_count()};
    for (int m = 0; m < refined && counts.vertices < enough; ++m)
        counts = {counts.vertices + counts.triangles + 2 * counts.edges,
                  3 * counts.edges + 9 * counts.triangles, 9 * counts.triangles};
    return counts;
}

Result<CodedPsBase> encode_ps_base(const Triangulation& mesh, bool keep_order) {
    std::vector<Vec2> vertices;
    for (Index v = 0; v < mesh.vertex_count(); ++v) vertices.push_back(mesh.vertex(v));
    RELIEF_CHECK(mesh::build(vertices, mesh.triangles, {.strict_orientation = true}));
    PsBaseHeader header{mesh.vertex_count(), mesh.triangle_count(), grid_of(mesh), {}};
    for (const double peel : {kPeel, 0.0}) {
        header.peel = peel;
        if (auto coded = encode_delaunay(mesh, header, keep_order)) return *std::move(coded);
    }
    header.peel.reset();
    return encode_connectivity(mesh, header, keep_order);
}

Result<Triangulation> decode_ps_base(std::span<const std::uint8_t> chunk,
                                     const PsBaseHeader& header) {
    RELIEF_TRY(const PartViews parts, parts_of(chunk));
    RELIEF_TRY(Coded coded,
               header.peel ? decode_delaunay(parts, header) : decode_connectivity(parts, header));
    if (!parts.numbering.empty()) {
        RELIEF_TRY(const PsNumbering numbering,
                   read_numbering(parts.numbering, coded.places.size(), coded.triangles.size()));
        renumber(numbering, coded);
    }
    return built(std::move(coded), parts.fractions, header.grid);
}

}  // namespace relief::codec
