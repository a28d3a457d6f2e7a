#include "codec/ps_chains.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "codec/number_coder.h"

namespace relief::codec {

namespace {

/// Shorter chains cost more than they save.
constexpr std::size_t kShortest = 6;
/// In mean distances: how far the second place of a chain may lie, and others from where the chain
/// leads.
constexpr double kFirstReach = 1.5;
constexpr double kReach = 0.15;
constexpr std::int64_t kMostMagnitude = std::int64_t{1} << 51;

using Index = std::uint32_t;
constexpr Index kNone = ~Index{0};

/// Places that are still there, in cells of about one place.
class PlaceCells {
  public:
    explicit PlaceCells(std::span<const GridPlace> places) : places_(places) {
        for (const GridPlace& p : places) {
            low_ = {std::min(low_.x, p.x), std::min(low_.y, p.y)};
            high_ = {std::max(high_.x, p.x), std::max(high_.y, p.y)};
        }
        const auto width = static_cast<double>(high_.x - low_.x) + 1;
        const auto height = static_cast<double>(high_.y - low_.y) + 1;
        const auto count = static_cast<double>(places.size());
        size_ = std::max(
            {std::sqrt(width) * std::sqrt(height / count), width / count, height / count, 1.0});
        cols_ = static_cast<std::int64_t>(width / size_) + 1;
        rows_ = static_cast<std::int64_t>(height / size_) + 1;
        first_.assign(static_cast<std::size_t>(cols_ * rows_), kNone);
        next_.resize(places.size());
        for (Index k = 0; k < places.size(); ++k) put_back(k);
    }

    /// The side of a cell: the mean distance of places.
    [[nodiscard]] double size() const { return size_; }
    [[nodiscard]] bool is_there(Index k) const { return next_[k] != k; }

    void put_back(Index k) {
        Index& first = first_[cell_of(places_[k])];
        next_[k] = first;
        first = k;
    }
    void take(Index k) {
        Index* link = &first_[cell_of(places_[k])];
        while (*link != k) link = &next_[*link];
        *link = next_[k];
        next_[k] = k;
    }

    /// The nearest place that is there, not farther than `reach`, which is at most two cells.
    [[nodiscard]] Index nearest(double x, double y, double reach) const {
        const auto cell = [this](double t, std::int64_t low) {
            return (t - static_cast<double>(low)) / size_;
        };
        const auto range = [](double from, double to, std::int64_t count) {
            return std::array{
                static_cast<std::int64_t>(std::clamp(from, 0.0, static_cast<double>(count))),
                static_cast<std::int64_t>(std::clamp(to, -1.0, static_cast<double>(count - 1)))};
        };
        const auto cols = range(cell(x - reach, low_.x), cell(x + reach, low_.x), cols_);
        const auto rows = range(cell(y - reach, low_.y), cell(y + reach, low_.y), rows_);
        Index best = kNone;
        double least = reach * reach;
        for (std::int64_t r = rows[0]; r <= rows[1]; ++r)
            for (std::int64_t c = cols[0]; c <= cols[1]; ++c)
                for (Index k = first_[static_cast<std::size_t>(r * cols_ + c)]; k != kNone;
                     k = next_[k]) {
                    const double dx = static_cast<double>(places_[k].x) - x;
                    const double dy = static_cast<double>(places_[k].y) - y;
                    const double square = dx * dx + dy * dy;
                    if (square > least || (square == least && best != kNone && k > best)) continue;
                    least = square;
                    best = k;
                }
        return best;
    }

  private:
    [[nodiscard]] std::size_t cell_of(const GridPlace& p) const {
        const auto along = [this](std::int64_t t) {
            return static_cast<std::int64_t>(static_cast<double>(t) / size_);
        };
        return static_cast<std::size_t>(along(p.y - low_.y) * cols_ + along(p.x - low_.x));
    }

    std::span<const GridPlace> places_;
    GridPlace low_{std::numeric_limits<std::int64_t>::max(),
                   std::numeric_limits<std::int64_t>::max()};
    GridPlace high_{std::numeric_limits<std::int64_t>::min(),
                    std::numeric_limits<std::int64_t>::min()};
    double size_ = 1;
    std::int64_t cols_ = 0;
    std::int64_t rows_ = 0;
    std::vector<Index> first_;  ///< [cell]
    std::vector<Index> next_;   ///< of a place in its cell; itself: taken
};

/// Goes on from the last two places of a chain as long as something is near where they lead.
void grow(std::span<const GridPlace> places, PlaceCells& cells, std::vector<Index>& chain) {
    while (true) {
        const GridPlace& at = places[chain.back()];
        const GridPlace& before = places[chain[chain.size() < 2 ? 0 : chain.size() - 2]];
        const auto x = static_cast<double>(2 * at.x - before.x);
        const auto y = static_cast<double>(2 * at.y - before.y);
        const double reach = (chain.size() < 2 ? kFirstReach : kReach) * cells.size();
        const Index next = cells.nearest(x, y, reach);
        if (next == kNone) return;
        cells.take(next);
        chain.push_back(next);
    }
}

/// One text for encoder and decoder.
template <class Coder>
class ChainCoder {
  public:
    explicit ChainCoder(Coder& coder) : coder_(coder), numbers_(coder, model_) {}

    /// begins: null for a decoder. False: a place is out of range.
    bool run(std::span<GridPlace> places, const std::vector<std::uint8_t>* begins) {
        GridPlace at;
        GridPlace step;
        std::size_t length = 0;
        for (std::size_t k = 0; k < places.size(); ++k) {
            const bool anew = code_adaptive(coder_, begins && (*begins)[k] != 0,
                                            begin_[std::min<std::size_t>(length, 15)]);
            length = anew ? 0 : length + 1;
            if (anew) step = {};
            const std::uint32_t kind = static_cast<std::uint32_t>(std::min<std::size_t>(length, 2));
            const GridPlace expected = {at.x + step.x, at.y + step.y};
            GridPlace& place = places[k];
            place.x = code(place.x, expected.x, 2 * kind);
            place.y = code(place.y, expected.y, 2 * kind + 1);
            if (std::abs(place.x) > kMostMagnitude || std::abs(place.y) > kMostMagnitude)
                return false;
            step = length == 0 ? GridPlace{} : GridPlace{place.x - at.x, place.y - at.y};
            at = place;
        }
        return true;
    }

  private:
    std::int64_t code(std::int64_t value, std::int64_t expected, std::uint32_t kind) {
        const auto difference = static_cast<std::int64_t>(static_cast<std::uint64_t>(value) -
                                                          static_cast<std::uint64_t>(expected));
        Surrounding& own = last_[kind];
        const std::int64_t q = numbers_.code(difference, kind, own, last_[kind ^ 1]);
        own.magnitude /= 2;
        own.balance = 0;
        own.count = 1;
        own.add(q);
        return static_cast<std::int64_t>(static_cast<std::uint64_t>(expected) +
                                         static_cast<std::uint64_t>(q));
    }

    Coder& coder_;
    NumberModel model_;
    NumberCoder<Coder> numbers_;
    std::array<Slot, 16> begin_;
    std::array<Surrounding, 6> last_;
};

}  // namespace

PlaceChains find_chains(std::vector<GridPlace> places) {
    sort_places(places);
    PlaceCells cells(places);
    PlaceChains chains;
    std::vector<std::uint8_t> is_chained(places.size());
    std::vector<Index> chain;
    for (Index start = 0; start < places.size(); ++start) {
        if (!cells.is_there(start)) continue;
        cells.take(start);
        chain.assign(1, start);
        grow(places, cells, chain);
        std::reverse(chain.begin(), chain.end());
        if (chain.size() > 1) grow(places, cells, chain);
        if (chain.size() < kShortest) {
            for (const Index k : chain) cells.put_back(k);
            cells.take(start);  // for the set
            continue;
        }
        for (const Index k : chain) {
            chains.begins.push_back(k == chain.front() ? 1 : 0);
            chains.chained.push_back(places[k]);
            is_chained[k] = 1;
        }
    }
    for (Index k = 0; k < places.size(); ++k)
        if (is_chained[k] == 0) chains.rest.push_back(places[k]);
    return chains;
}

Bytes write_chains(const PlaceChains& chains) {
    std::vector<GridPlace> places = chains.chained;
    RangeEncoder encoder;
    ChainCoder(encoder).run(places, &chains.begins);
    return encoder.finish();
}

Result<std::vector<GridPlace>> read_chains(std::span<const std::uint8_t> bytes,
                                           std::uint64_t count) {
    std::vector<GridPlace> places(static_cast<std::size_t>(count));
    RangeDecoder decoder(bytes);
    if (ChainCoder(decoder).run(places, nullptr) && decoder.at_end()) return places;
    return Error{ErrorCode::BadFile, "the places of its vertices are damaged", "mesh chunk"};
}

}  // namespace relief::codec
