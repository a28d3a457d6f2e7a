#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "ps_verbs.h"
#include "relief/codec/plane_surface.h"

namespace relief::cli {

namespace ps = multires::ps;

namespace {

/// Rows and columns of samples over the extent, beside the vertices.
constexpr int kSamples = 512;

/// Values of the reference and of the other at places; not a number: outside.
struct Pairs {
    std::vector<Vec2> places;
    std::vector<double> reference;  ///< components a place
    std::vector<double> other = {};
    std::size_t components = 1;
};

Result<std::vector<double>> values_at(const std::string& path, const std::vector<Vec2>& places) {
    RELIEF_TRY(const codec::PsFile file, open_ps(path));
    const auto surface = codec::plane_surface(file);
    if (!surface.ok()) return located(surface.error(), path);
    std::vector<spline::PlaneJet> jets(places.size() *
                                       static_cast<std::size_t>((*surface)->components()));
    if (const Status status = (*surface)->evaluate(places, 0, jets); !status.ok())
        return located(status.error(), path);
    std::vector<double> values;
    for (const spline::PlaneJet& jet : jets) values.push_back(jet.value);
    return values;
}

Result<Pairs> at_points(const std::string& points, const std::string& file,
                        const std::string& columns_text) {
    RELIEF_TRY(const io::PointColumns columns, columns_of(columns_text));
    RELIEF_TRY(io::PointSet set, io::read_points(points, columns));
    Pairs pairs{std::move(set.places), {}};
    pairs.components = set.values.size();
    for (std::size_t k = 0; k < pairs.places.size(); ++k)
        for (const auto& component : set.values) pairs.reference.push_back(component[k]);
    RELIEF_TRY(pairs.other, values_at(file, pairs.places));
    if (pairs.other.size() == pairs.reference.size()) return pairs;
    return Error{ErrorCode::BadInput,
                 "has another number of components than the points; --columns says which they are",
                 file};
}

/// The vertices of A and samples all over it.
Result<Pairs> of_surfaces(const std::string& a, const std::string& b) {
    RELIEF_TRY(const codec::PsFile file, open_ps(a));
    RELIEF_TRY(const PsLevel level, open_level(file, 0));
    const mesh::Triangulation& mesh = level.space().mesh;
    Pairs pairs;
    pairs.components = static_cast<std::size_t>(level.surface.components());
    for (mesh::Index v = 0; v < mesh.vertex_count(); ++v)
        pairs.places.push_back(mesh.origin + mesh.vertex(v));
    const auto [west, south, east, north] = file.extent();
    for (int row = 0; row < kSamples; ++row)
        for (int col = 0; col < kSamples; ++col)
            pairs.places.push_back({west + (east - west) * (col + 0.5) / kSamples,
                                    south + (north - south) * (row + 0.5) / kSamples});
    RELIEF_TRY(pairs.reference, values_at(a, pairs.places));
    RELIEF_TRY(pairs.other, values_at(b, pairs.places));
    if (pairs.other.size() == pairs.reference.size()) return pairs;
    return Error{ErrorCode::BadInput, "have different numbers of components", a + " and " + b};
}

struct Differences {
    std::int64_t samples = 0;
    std::int64_t outside = 0;  ///< of one of them only
    double square = 0;
    double most = 0;
    std::size_t worst = 0;  ///< place
    double low = INFINITY;  ///< of the reference
    double high = -INFINITY;
    double energy = 0;  ///< squared distance of the reference from its mean
};

Differences differences_of(const Pairs& pairs) {
    Differences d;
    double sum = 0;
    for (std::size_t k = 0; k < pairs.reference.size(); ++k) {
        const double reference = pairs.reference[k];
        const double other = pairs.other[k];
        d.outside += std::isnan(reference) != std::isnan(other);
        if (std::isnan(reference) || std::isnan(other)) continue;
        ++d.samples;
        sum += reference;
        d.low = std::min(d.low, reference);
        d.high = std::max(d.high, reference);
        const double off = std::abs(other - reference);
        d.square += off * off;
        if (off > d.most) d.worst = k / pairs.components;
        d.most = std::max(d.most, off);
    }
    const double mean = sum / static_cast<double>(d.samples);
    for (std::size_t k = 0; k < pairs.reference.size(); ++k)
        if (!std::isnan(pairs.reference[k]) && !std::isnan(pairs.other[k]))
            d.energy += (pairs.reference[k] - mean) * (pairs.reference[k] - mean);
    return d;
}

double diagonal_of(const Pairs& pairs, const Differences& d) {
    Vec2 low{INFINITY, INFINITY};
    Vec2 high{-INFINITY, -INFINITY};
    for (const Vec2& p : pairs.places) {
        low = {std::min(low.x, p.x), std::min(low.y, p.y)};
        high = {std::max(high.x, p.x), std::max(high.y, p.y)};
    }
    return std::hypot(high.x - low.x, high.y - low.y, d.high - d.low);
}

}  // namespace

Result<Outcome> compare_ps(const std::string& a, const std::string& b, const std::string& columns) {
    const bool points_first = is_points(a);
    if (!(points_first || holds_ps(a)) || !(is_points(b) || holds_ps(b)) ||
        (points_first && is_points(b)))
        return Error{ErrorCode::BadInput,
                     "points are compared with a Powell-Sabin spline, and that with another one",
                     a + " and " + b};
    RELIEF_TRY(Pairs pairs, points_first   ? at_points(a, b, columns)
                            : is_points(b) ? at_points(b, a, columns)
                                           : of_surfaces(a, b));
    if (!points_first && is_points(b)) std::swap(pairs.reference, pairs.other);
    const Differences d = differences_of(pairs);
    if (d.samples == 0)
        return Error{ErrorCode::BadInput, "have no place in common", a + " and " + b};
    const double mean_square = d.square / static_cast<double>(d.samples);
    const double rms = std::sqrt(mean_square);
    const double percent = d.energy > 0 ? 100 * d.square / d.energy : 0;
    const Vec2 worst = pairs.places[d.worst];
    Outcome outcome;
    outcome.json = Json{{"samples", d.samples},
                        {"max_error", d.most},
                        {"rms_error", rms},
                        {"mean_square", mean_square},
                        {"psnr_db", json_number(20 * std::log10((d.high - d.low) / rms))},
                        {"energy_percent", percent},
                        {"diagonal", diagonal_of(pairs, d)},
                        {"worst", Json{{"x", worst.x}, {"y", worst.y}}},
                        {"outside", d.outside}};
    outcome.text =
        fmt::format("{} places: max error {} at {}, {}; rms error {}; error energy {:.4g} %\n",
                    grouped(d.samples), shown(d.most), worst.x, worst.y, shown(rms), percent);
    if (d.outside > 0)
        outcome.text += fmt::format("{} places lie outside one of them\n", grouped(d.outside));
    return outcome;
}

}  // namespace relief::cli
