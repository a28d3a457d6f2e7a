#include "codec/ps_places.h"

#include <algorithm>
#include <cmath>

#include "codec/bytes.h"
#include "codec/ps_chains.h"
#include "codec/value_lattice.h"

namespace relief::codec {

namespace {

constexpr std::int64_t kMostMagnitude = std::int64_t{1} << 50;

}  // namespace

Bytes write_places(std::vector<GridPlace> places) {
    ByteWriter plain;
    plain.varint(0);
    plain.bytes(write_place_set(places));
    const PlaceChains chains = find_chains(std::move(places));
    const Bytes lines = write_chains(chains);
    ByteWriter mixed;
    mixed.varint(chains.chained.size());
    mixed.varint(lines.size());
    mixed.bytes(lines);
    mixed.bytes(write_place_set(chains.rest));
    return mixed.size() < plain.size() ? mixed.take() : plain.take();
}

Result<std::vector<GridPlace>> read_places(std::span<const std::uint8_t> bytes,
                                           std::uint64_t count) {
    ByteReader in(bytes);
    const std::uint64_t chained = in.varint();
    const auto lines = in.take(chained == 0 ? 0 : in.varint());
    if (in.failed() || chained > count)
        return Error{ErrorCode::BadFile, "the places of its vertices are damaged", "mesh chunk"};
    RELIEF_TRY(std::vector<GridPlace> places, read_place_set(in.rest(), count - chained));
    if (chained == 0) return places;
    RELIEF_TRY(const std::vector<GridPlace> more, read_chains(lines, chained));
    places.insert(places.end(), more.begin(), more.end());
    return places;
}

Vec2 PlaceGrid::place(GridPlace k) const {
    const auto x = static_cast<double>(k.x);
    const auto y = static_cast<double>(k.y);
    if (digits) return {x / power_of_ten(*digits), y / power_of_ten(*digits)};
    return {std::ldexp(x, *exponent), std::ldexp(y, *exponent)};
}

GridPlace PlaceGrid::nearest(Vec2 place) const {
    const auto on_grid = [this](double t) {
        const double k = digits ? t * power_of_ten(*digits) : std::ldexp(t, -*exponent);
        constexpr auto most = static_cast<double>(kMostMagnitude);
        return static_cast<std::int64_t>(std::rint(std::clamp(k, -most, most)));
    };
    return {on_grid(place.x), on_grid(place.y)};
}

Vec2 PlaceGrid::rounded(Vec2 x) const {
    if (!exponent) return x;
    const auto round = [e = *exponent](double t) {
        return std::ldexp(std::rint(std::ldexp(t, -e)), e);
    };
    return {round(x.x), round(x.y)};
}

}  // namespace relief::codec
