#include "codec/ps_place_set.h"

#include <algorithm>
#include <array>
#include <bit>

#include "codec/bytes.h"
#include "codec/number_coder.h"
#include "codec/packed.h"

namespace relief::codec {

namespace {

constexpr std::int64_t kMostMagnitude = std::int64_t{1} << 50;
constexpr int kMostBits = 51;
/// Up to here every count of a half has a probability of its own.
constexpr std::uint32_t kFew = 16;

Error damaged() {
    return {ErrorCode::BadFile, "the places of its vertices are damaged", "mesh chunk"};
}

/// 2^bits[0] x 2^bits[1] places from `low` on.
struct Cell {
    std::array<std::int64_t, 2> low{};
    std::array<int, 2> bits{};

    /// The longer side is halved, of equal ones x.
    [[nodiscard]] std::size_t axis() const { return bits[0] >= bits[1] ? 0 : 1; }
    [[nodiscard]] bool is_point() const { return bits[0] == 0 && bits[1] == 0; }
    [[nodiscard]] std::array<Cell, 2> halves() const {
        const std::size_t i = axis();
        Cell lower = *this;
        --lower.bits[i];
        Cell upper = lower;
        upper.low[i] += std::int64_t{1} << lower.bits[i];
        return {lower, upper};
    }
    [[nodiscard]] bool has(const GridPlace& p) const {
        return p.x - low[0] < std::int64_t{1} << bits[0] && p.y - low[1] < std::int64_t{1}
                                                                               << bits[1];
    }
};

/// The cell that the halving begins with.
Cell cell_around(std::span<const GridPlace> places) {
    Cell cell;
    if (places.empty()) return cell;
    GridPlace low = places.front();
    GridPlace high = low;
    for (const GridPlace& p : places) {
        low = {std::min(low.x, p.x), std::min(low.y, p.y)};
        high = {std::max(high.x, p.x), std::max(high.y, p.y)};
    }
    cell.low = {low.x, low.y};
    const auto bits = [](std::int64_t extent) {
        return static_cast<int>(std::bit_width(static_cast<std::uint64_t>(extent)));
    };
    cell.bits = {bits(high.x - low.x), bits(high.y - low.y)};
    return cell;
}

/// Moves the places of the lower half to the front.
std::size_t halve(std::span<GridPlace> places, const Cell& lower) {
    const auto middle = std::partition(places.begin(), places.end(),
                                       [&](const GridPlace& p) { return lower.has(p); });
    return static_cast<std::size_t>(middle - places.begin());
}

struct SetModel {
    /// [count][bits told so far]
    std::array<std::array<Slot, 2 * kFew>, kFew + 1> few;
    NumberModel many;
};

/// One text for encoder and decoder, which fills `places` in order.
template <class Coder>
class SetCoder {
  public:
    explicit SetCoder(Coder& coder) : coder_(coder) {}

    /// False: the bytes are not those of a set.
    bool run(std::span<GridPlace> places, const Cell& cell, std::int64_t imbalance = 0) {
        if (places.empty()) return true;
        if (places.size() == 1) {
            code_one(places.front(), cell);
            return true;
        }
        if (cell.is_point()) {
            std::fill(places.begin(), places.end(), GridPlace{cell.low[0], cell.low[1]});
            return true;
        }
        const auto [lower, upper] = cell.halves();
        std::size_t count = Coder::kDecodes ? 0 : halve(places, lower);
        const auto all = static_cast<std::int64_t>(places.size());
        if (places.size() <= kFew)
            count = code_few(static_cast<std::uint32_t>(count),
                             static_cast<std::uint32_t>(places.size()));
        else
            count = code_many(static_cast<std::int64_t>(count), all, imbalance);
        if (count > places.size()) return false;
        const std::int64_t difference = static_cast<std::int64_t>(count) - all / 2;
        return run(places.first(count), lower, difference) &&
               run(places.subspan(count), upper, difference);
    }

  private:
    /// A count of at most `all`, bit by bit.
    std::uint32_t code_few(std::uint32_t count, std::uint32_t all) {
        auto& slots = model_.few[all];
        std::uint32_t told = 1;
        for (int bit = static_cast<int>(std::bit_width(all)) - 1; bit >= 0; --bit)
            told = told << 1 | static_cast<std::uint32_t>(
                                   code_adaptive(coder_, (count >> bit & 1) != 0, slots[told]));
        return told - std::bit_floor(told);
    }

    /// Even places leave a half with n / 2 +- sqrt(n) / 2 of n; others go on as the cell around
    /// did.
    std::size_t code_many(std::int64_t count, std::int64_t all, std::int64_t imbalance) {
        Surrounding even;
        even.add(std::int64_t{1} << (std::bit_width(static_cast<std::uint64_t>(all)) / 2));
        even.count = 2;
        Surrounding around;
        around.add(imbalance / 2);
        const std::int64_t difference =
            NumberCoder<Coder>(coder_, model_.many).code(count - all / 2, 0, even, around);
        if (difference < -all || difference > all) return static_cast<std::size_t>(all) + 1;
        return static_cast<std::size_t>(all / 2 + difference);
    }

    void code_one(GridPlace& place, const Cell& cell) {
        place.x = cell.low[0] + code_offset(place.x - cell.low[0], cell.bits[0]);
        place.y = cell.low[1] + code_offset(place.y - cell.low[1], cell.bits[1]);
    }

    std::int64_t code_offset(std::int64_t offset, int bits) {
        std::int64_t known = 0;
        while (bits > 0) {
            const int some = std::min(bits, 16);
            bits -= some;
            const auto part = static_cast<std::uint32_t>(offset >> bits & ((1 << some) - 1));
            known = known << some | coder_.code_raw(part, some);
        }
        return known;
    }

    Coder& coder_;
    SetModel model_;
};

/// The halving without a code.
void sort_in(std::span<GridPlace> places, const Cell& cell) {
    if (places.size() < 2 || cell.is_point()) return;
    const auto [lower, upper] = cell.halves();
    const std::size_t count = halve(places, lower);
    sort_in(places.first(count), lower);
    sort_in(places.subspan(count), upper);
}

}  // namespace

Bytes write_place_set(std::vector<GridPlace> places) {
    const Cell cell = cell_around(places);
    ByteWriter out;
    for (const std::size_t i : {0U, 1U}) {
        out.varint(zigzag(cell.low[i]));
        out.u8(static_cast<std::uint8_t>(cell.bits[i]));
    }
    RangeEncoder encoder;
    SetCoder(encoder).run(places, cell);
    out.bytes(encoder.finish());
    return out.take();
}

Result<std::vector<GridPlace>> read_place_set(std::span<const std::uint8_t> bytes,
                                              std::uint64_t count) {
    ByteReader in(bytes);
    Cell cell;
    for (const std::size_t i : {0U, 1U}) {
        cell.low[i] = unzigzag(in.varint());
        cell.bits[i] = in.u8();
        if (in.failed() || cell.low[i] < -kMostMagnitude || cell.low[i] > kMostMagnitude ||
            cell.bits[i] > kMostBits)
            return damaged();
    }
    std::vector<GridPlace> places(static_cast<std::size_t>(count));
    RangeDecoder decoder(in.rest());
    if (!SetCoder(decoder).run(places, cell) || !decoder.at_end()) return damaged();
    return places;
}

void sort_places(std::vector<GridPlace>& places) {
    sort_in(places, cell_around(places));
}

}  // namespace relief::codec
