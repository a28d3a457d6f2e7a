#include "relief/codec/plane_surface.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <mutex>
#include <optional>
#include <vector>

#include "relief/codec/raster_surface.h"
#include "relief/core/sampling.h"
#include "relief/mesh/triangle_locator.h"
#include "relief/multires/ps_surface.h"

namespace relief::codec {

namespace {

using spline::PlaneJet;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr PlaneJet kNothing{kNan, {kNan, kNan}, kNan, kNan, kNan};

/// The chain rule.
PlaneJet to_data_units(const PlaceMap& map, const spline::SurfaceJet<double>& jet) {
    const auto [x, y] = map.gradient(jet.di, jet.dj);
    const auto [xx, xy, yy] = map.hessian(jet.dii, jet.dij, jet.djj);
    return {jet.value, {x, y}, xx, xy, yy};
}

/// A lattice coordinate of 0 .. n - 1; NaN outside. Places computed from sample centres may miss
/// the border by rounding.
double settled(double v, std::int64_t n) {
    const double last = static_cast<double>(n - 1);
    const double slack = 1e-9 * (1 + last);
    return v >= -slack && v <= last + slack ? std::clamp(v, 0.0, last) : kNan;
}

/// Points of one part of a raster, which are evaluated together.
struct Group {
    LatticeBox window;
    std::vector<std::size_t> places;  ///< their numbers
    std::vector<double> i;
    std::vector<double> j;
};

class RasterPlane final : public PlaneSurface {
  public:
    RasterPlane(const RasterFile& file, const PlaceMap& map)
        : file_(file),
          map_(map),
          rows_(file.description().rows),
          cols_(file.description().cols),
          in_tiles_(file.closed_loop() && rows_ * cols_ > kWhole) {}

    [[nodiscard]] int components() const override { return file_.layout().components; }

    [[nodiscard]] Status evaluate(std::span<const Vec2> places, int derivatives,
                                  std::span<PlaneJet> out) const override {
        RELIEF_CHECK(check(places, derivatives, out));
        std::fill(out.begin(), out.end(), kNothing);
        for (const auto& [first, group] : groups(places)) {
            std::optional<RasterSurface> part;
            if (in_tiles_) {
                RELIEF_TRY(part, RasterSurface::create(file_, 0, group.window));
            }
            const RasterSurface* surface = part ? &*part : nullptr;
            if (surface == nullptr) {
                RELIEF_TRY(surface, whole(group.window));
            }
            RELIEF_CHECK(evaluate(*surface, group, derivatives, out));
        }
        return {};
    }

  private:
    /// Files in tiles of more samples are read where places are.
    static constexpr std::int64_t kWhole = std::int64_t{1} << 22;
    static constexpr std::int64_t kSide = 512;

    using Groups = std::map<std::pair<std::int64_t, std::int64_t>, Group>;

    [[nodiscard]] Groups groups(std::span<const Vec2> places) const {
        Groups groups;
        for (std::size_t n = 0; n < places.size(); ++n) {
            const double i = settled(map_.row(places[n].x, places[n].y), rows_);
            const double j = settled(map_.col(places[n].x, places[n].y), cols_);
            if (std::isnan(i) || std::isnan(j)) continue;
            const std::int64_t row = in_tiles_ ? static_cast<std::int64_t>(i) / kSide * kSide : 0;
            const std::int64_t col = in_tiles_ ? static_cast<std::int64_t>(j) / kSide * kSide : 0;
            Group& group = groups[{row, col}];
            group.window = in_tiles_ ? LatticeBox{row, col, std::min(kSide + 1, rows_ - row),
                                                  std::min(kSide + 1, cols_ - col)}
                                     : LatticeBox{0, 0, rows_, cols_};
            group.places.push_back(n);
            group.i.push_back(i);
            group.j.push_back(j);
        }
        return groups;
    }

    Result<const RasterSurface*> whole(const LatticeBox& window) const {
        const std::lock_guard lock(mutex_);
        if (!whole_) {
            RELIEF_TRY(whole_, RasterSurface::create(file_, 0, window));
        }
        return &*whole_;
    }

    [[nodiscard]] Status evaluate(const RasterSurface& surface, const Group& group, int derivatives,
                                  std::span<PlaneJet> out) const {
        std::array<std::vector<double>, 6> parts;
        for (auto& part : parts) part.resize(group.i.size());
        const auto count = static_cast<std::size_t>(surface.components());
        for (std::size_t c = 0; c < count; ++c) {
            RELIEF_CHECK(
                surface.evaluate(static_cast<int>(c), group.i, group.j, derivatives,
                                 {parts[0], parts[1], parts[2], parts[3], parts[4], parts[5]}));
            for (std::size_t k = 0; k < group.i.size(); ++k)
                if (surface.valid(group.i[k], group.j[k]))
                    out[group.places[k] * count + c] =
                        to_data_units(map_, {parts[0][k], parts[1][k], parts[2][k], parts[3][k],
                                             parts[4][k], parts[5][k]});
        }
        return {};
    }

    const RasterFile& file_;
    PlaceMap map_;
    std::int64_t rows_;
    std::int64_t cols_;
    bool in_tiles_;
    mutable std::mutex mutex_;
    mutable std::optional<RasterSurface> whole_;
};

class QuadPlane final : public PlaneSurface {
  public:
    explicit QuadPlane(QuadSurface surface) : surface_(std::move(surface)) {}

    [[nodiscard]] int components() const override { return 1; }

    [[nodiscard]] Status evaluate(std::span<const Vec2> places, int derivatives,
                                  std::span<PlaneJet> out) const override {
        RELIEF_CHECK(check(places, derivatives, out));
        std::vector<Vec2> inside;
        std::vector<std::size_t> numbers;
        for (std::size_t k = 0; k < places.size(); ++k) {
            if (!surface_.hierarchy.locator().locate(places[k])) continue;
            inside.push_back(places[k]);
            numbers.push_back(k);
        }
        std::vector<PlaneJet> jets(inside.size());
        RELIEF_CHECK(multires::fvs_mesh::evaluate(surface_.hierarchy, surface_.level(),
                                                  surface_.data, inside, jets));
        std::fill(out.begin(), out.end(), kNothing);
        for (std::size_t k = 0; k < jets.size(); ++k) out[numbers[k]] = jets[k];
        return {};
    }

  private:
    QuadSurface surface_;
};

class PsPlane final : public PlaneSurface {
  public:
    explicit PsPlane(PsSurface data) : data_(std::move(data)), locator_(data_.space.mesh) {}

    Status prepare() {
        RELIEF_TRY(surface_, multires::ps::Surface::create(data_.space, data_.components));
        return {};
    }

    [[nodiscard]] int components() const override { return surface_->components(); }

    [[nodiscard]] Status evaluate(std::span<const Vec2> places, int derivatives,
                                  std::span<PlaneJet> out) const override {
        RELIEF_CHECK(check(places, derivatives, out));
        return multires::ps::evaluate(*surface_, locator_, places, out, multires::ps::Outside::Nan);
    }

  private:
    PsSurface data_;
    mesh::TriangleLocator locator_;
    std::optional<multires::ps::Surface> surface_;
};

}  // namespace

Status PlaneSurface::check(std::span<const Vec2> places, int derivatives,
                           std::span<const PlaneJet> out) const {
    if (derivatives < 0 || derivatives > 2)
        return Error{ErrorCode::InvalidArgument,
                     "derivatives must be 0, 1 or 2, not " + std::to_string(derivatives), ""};
    if (out.size() != places.size() * static_cast<std::size_t>(components()))
        return Error{ErrorCode::InvalidArgument,
                     "the jets must be as many as places times components", ""};
    return {};
}

Result<std::unique_ptr<const PlaneSurface>> plane_surface(const RasterFile& file) {
    RELIEF_TRY(const PlaceMap map, PlaceMap::create(file.description().geo));
    return std::unique_ptr<const PlaneSurface>(std::make_unique<RasterPlane>(file, map));
}

Result<std::unique_ptr<const PlaneSurface>> plane_surface(const QuadFile& file) {
    RELIEF_TRY(QuadSurface surface, file.surface(0));
    return std::unique_ptr<const PlaneSurface>(std::make_unique<QuadPlane>(std::move(surface)));
}

Result<std::unique_ptr<const PlaneSurface>> plane_surface(const PsFile& file) {
    RELIEF_TRY(PsSurface data, file.surface(0));
    auto surface = std::make_unique<PsPlane>(std::move(data));
    RELIEF_CHECK(surface->prepare());
    return std::unique_ptr<const PlaneSurface>(std::move(surface));
}

}  // namespace relief::codec
