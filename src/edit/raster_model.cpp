#include "edit/raster_model.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "edit/touched_boxes.h"

namespace relief::edit {

namespace {

/// Nets of more points are asked for in windows.
constexpr std::int64_t kWholeNet = 65536;
/// Tiles of the file's surface that are kept: some 100 MB.
constexpr std::size_t kCachedTiles = 256;
constexpr double kLargest = 1e300;  ///< what files keep

/// A part of a row by row array.
template <class T>
std::vector<T> cropped(const std::vector<T>& all, std::int64_t cols, const LatticeBox& rect) {
    std::vector<T> part;
    if (all.empty()) return part;
    part.reserve(static_cast<std::size_t>(rect.count()));
    for (std::int64_t r = rect.row0; r < rect.row0 + rect.rows; ++r) {
        const auto first = all.begin() + r * cols + rect.col0;
        part.insert(part.end(), first, first + rect.cols);
    }
    return part;
}

OriginalSurfaces::Part cropped(const OriginalSurfaces::Part& all, std::int64_t cols,
                               const LatticeBox& rect) {
    OriginalSurfaces::Part part;
    for (const Jets& jets : all.components) {
        Jets& out = part.components.emplace_back();
        out.value = cropped(jets.value, cols, rect);
        out.di = cropped(jets.di, cols, rect);
        out.dj = cropped(jets.dj, cols, rect);
        out.dii = cropped(jets.dii, cols, rect);
        out.dij = cropped(jets.dij, cols, rect);
        out.djj = cropped(jets.djj, cols, rect);
    }
    part.valid = cropped(all.valid, cols, rect);
    return part;
}

std::array<double, 2> spacing_of(const GeoReference& geo) {
    if (!geo.transform) return {1, 1};
    const auto& t = *geo.transform;
    const double x = std::hypot(t[1], t[4]);
    const double y = std::hypot(t[2], t[5]);
    const bool usable = x > 0 && y > 0 && std::isfinite(x) && std::isfinite(y);
    return usable ? std::array{x, y} : std::array{1.0, 1.0};
}

/// How much further than values normals change, in steps of the lattice that is drawn: slopes of
/// bicubic splines die out by 0.27 a step.
std::int64_t normals_reach(const multires::SchemeSpec& spec) {
    return spec.id == multires::SchemeId::Cubic ? 12 : 1;
}

LatticeBox grown(const LatticeBox& box, std::int64_t by) {
    return {box.row0 - by, box.col0 - by, box.rows + 2 * by, box.cols + 2 * by};
}

}  // namespace

RasterModel::RasterModel(std::shared_ptr<const ByteSource> source, codec::RasterFile bare,
                         const std::vector<multires::Move>& own)
    : source_(std::move(source)),
      bare_(std::make_unique<codec::RasterFile>(std::move(bare))),
      surfaces_(*bare_),
      own_moves_(own),
      own_(bare_->layout()),
      all_(bare_->layout()) {
    own_.add(own);
    all_.add(own);
}

Result<std::unique_ptr<Model>> RasterModel::open(std::shared_ptr<const ByteSource> source,
                                                 const OpenOptions& options) {
    RELIEF_TRY(codec::RasterFile file, codec::RasterFile::open(source));
    const std::vector<multires::Move> own = file.moves();
    if (!own.empty()) {
        RELIEF_TRY(Bytes bare, codec::without_moves(source));
        RELIEF_TRY(file, codec::RasterFile::open(std::move(bare)));
    }
    std::unique_ptr<RasterModel> model(new RasterModel(std::move(source), std::move(file), own));
    RELIEF_CHECK(model->describe(options));
    return std::unique_ptr<Model>(std::move(model));
}

Result<std::unique_ptr<Model>> open_raster(std::shared_ptr<const ByteSource> file,
                                           const OpenOptions& options) {
    return RasterModel::open(std::move(file), options);
}

Status RasterModel::describe(const OpenOptions& options) {
    const codec::RasterFile& file = *bare_;
    const multires::PyramidLayout& layout = file.layout();
    grid_ = {layout.rows, layout.cols, file.margin(),
             options.spacing.value_or(spacing_of(file.description().geo))};

    Description& d = description_;
    d.kind = Kind::Raster;
    d.scheme = multires::scheme_name(file.spec().id);
    const bool has_orders = file.spec().id == multires::SchemeId::Box ||
                            file.spec().id == multires::SchemeId::Barycentric;
    d.order = has_orders ? file.spec().order : 0;
    for (int level = 0; level <= layout.levels(); ++level) {
        const LatticeBox box = multires::scaling_box(layout, level);
        d.levels.push_back({static_cast<std::uint64_t>(box.count()), 0, file.bytes_for(level),
                            box.rows, box.cols});
    }
    d.components = layout.components;
    d.parametric = layout.components == 3;
    d.unit = file.description().unit;
    d.crs = file.description().geo.crs;
    if (own_moves_.empty() && std::isfinite(file.max_error())) d.bound = file.max_error();
    d.bytes = file.size();
    d.tiles = TileInfo{layout.rows, layout.cols, TileGrid::kTile, grid_.coarsest(), grid_.spacing};

    // The frame of page coordinates is that of a picture of everything.
    frame_ = {&grid_, {}, d.parametric};
    bounds_ = kNothing;
    RELIEF_TRY(const TileGeometry all, tile({}, {grid_.coarsest(), 0, 0}));
    if (!(bounds_.min.z <= bounds_.max.z)) bounds_ = {};
    const Vec3<double> middle = 0.5 * (bounds_.min + bounds_.max);
    d.origin = d.parametric ? middle : Vec3<double>{0, 0, middle.z};
    bounds_ = {bounds_.min - d.origin, bounds_.max - d.origin};
    frame_.origin = d.origin;
    return {};
}

std::unique_ptr<NetGraph> RasterModel::graph(int level) const {
    return std::make_unique<LatticeGraph>(multires::scaling_box(bare_->layout(), level), level,
                                          grid_.spacing);
}

multires::Move RasterModel::file_move(const PointMove& move) const {
    const LatticePoint p = point_of(multires::scaling_box(bare_->layout(), move.level), move.point);
    const Vec3<double>& d = move.delta;
    if (description_.parametric) return {move.level, p.row, p.col, {d.x, d.y, d.z, 0}};
    return {move.level, p.row, p.col, {d.z, 0, 0, 0}};
}

Status RasterModel::check(const PointMove& move) const {
    if (move.slope.x != 0 || move.slope.y != 0)
        return wrong("control points of a raster have no slope; move them");
    if (!description_.parametric && (move.delta.x != 0 || move.delta.y != 0))
        return wrong("control points of a height field move up and down only");
    const auto small = [](double x) { return std::abs(x) <= kLargest; };
    if (!small(move.delta.x) || !small(move.delta.y) || !small(move.delta.z))
        return wrong("a displacement is not a number of at most 1e300");
    return {};
}

void RasterModel::mark(const std::vector<multires::Move>& moves) {
    changed_.insert(changed_.end(), moves.begin(), moves.end());
    if (net_ && net_->depends_on(moves)) net_.reset();
}

Status RasterModel::push(std::vector<PointMove> group) {
    Group& added = groups_.emplace_back();
    for (const PointMove& move : group) added.moves.push_back(file_move(move));
    added.undo = all_.add(added.moves);
    mark(added.moves);
    return {};
}

void RasterModel::pop() {
    const Group last = std::move(groups_.back());
    groups_.pop_back();
    all_.restore(last.undo);
    mark(last.moves);
}

RasterModel::Shown RasterModel::shown(const View& view) const {
    using Show = View::Show;
    if (view.show == Show::Compressed && compressed_)
        return {compressed_surfaces_.get(), nullptr, view.level};
    return {&surfaces_, view.show == Show::Original ? &own_ : &all_, view.level};
}

Result<const OriginalSurfaces::Part*> RasterModel::cached(const Shown& shown, const TileName& name,
                                                          int derivatives) const {
    const CacheKey key{shown.surfaces, shown.level, derivatives, name};
    const auto found = cache_.find(key);
    if (found != cache_.end()) {
        found->second.used = ++uses_;
        return &found->second.part;
    }
    RELIEF_TRY(const LatticeBox rect, grid_.rect_of(name));
    RELIEF_TRY(auto part,
               shown.surfaces->part(shown.level, grid_.places_of(name, rect), derivatives));
    if (cache_.size() >= kCachedTiles)
        cache_.erase(std::min_element(
            cache_.begin(), cache_.end(),
            [](const auto& a, const auto& b) { return a.second.used < b.second.used; }));
    return &cache_.insert_or_assign(key, Cached{++uses_, std::move(part)}).first->second.part;
}

Result<OriginalSurfaces::Part> RasterModel::jets(const Shown& shown, const TileName& name,
                                                 const LatticeBox& rect, int derivatives) const {
    RELIEF_TRY(const OriginalSurfaces::Part* whole, cached(shown, name, derivatives));
    RELIEF_TRY(const LatticeBox all, grid_.rect_of(name));
    OriginalSurfaces::Part part = cropped(*whole, all.cols, rect);
    if (shown.moves)
        RELIEF_CHECK(shown.moves->add_to(part.components, shown.level, grid_.places_of(name, rect),
                                         derivatives));
    return part;
}

Result<TileGeometry> RasterModel::draw(const View& view, const TileName& name,
                                       const LatticeBox& rect) const {
    const Places places = grid_.places_of(name, rect);
    RELIEF_TRY(const auto part, jets(shown(view), name, rect, view.extras.curvature ? 2 : 1));
    TileGeometry out;
    out.tile = name;
    out.rect = rect;
    frame_.draw(places, part, out);
    if (view.extras.error) {
        RELIEF_TRY(const auto before, jets(original(), name, rect, 1));
        frame_.draw_errors(places, part, before, out);
    }
    widen(out);
    return out;
}

void RasterModel::widen(const TileGeometry& tile) const {
    const auto valid = [&](std::size_t k) { return tile.valid.empty() || tile.valid[k] != 0; };
    for (std::size_t k = 0; k < tile.position.size(); ++k)
        if (valid(k))
            include(bounds_, {tile.position[k][0], tile.position[k][1], tile.position[k][2]});
    float low = HUGE_VALF, high = -HUGE_VALF;
    for (std::size_t k = 0; k < tile.height.size(); ++k) {
        if (!valid(k)) continue;
        low = std::min(low, tile.height[k]);
        high = std::max(high, tile.height[k]);
    }
    if (!(low <= high)) return;
    include(bounds_, {tile.x0, tile.y0, low});
    include(bounds_, {tile.x1, tile.y1, high});
}

Result<TileGeometry> RasterModel::tile(const View& view, const TileName& name) const {
    RELIEF_TRY(const LatticeBox rect, grid_.rect_of(name));
    return draw(view, name, rect);
}

Result<SurfaceGeometry> RasterModel::surface(const View&) const {
    return wrong("a raster is drawn in tiles");
}

std::vector<multires::Move> RasterModel::all_moves() const {
    std::vector<multires::Move> moves = own_moves_;
    for (const Group& group : groups_)
        moves.insert(moves.end(), group.moves.begin(), group.moves.end());
    return moves;
}

Result<const RasterNet*> RasterModel::net_of(int level, const LatticeBox& window) const {
    if (!net_ || net_->level() != level || !(net_->window() == window)) {
        RELIEF_TRY(net_, RasterNet::create(*bare_, all_moves(), level, window));
    }
    return &*net_;
}

Result<NetGeometry> RasterModel::net(int level, const std::optional<LatticeBox>& window) const {
    const LatticeBox all = multires::scaling_box(bare_->layout(), level);
    if (!window && all.count() > kWholeNet)
        return wrong("the control net of level " + std::to_string(level) + " has " +
                     std::to_string(all.count()) + " points; ask for a window of it");
    const LatticeBox asked = window ? LatticeBox{window->row0 + all.row0, window->col0 + all.col0,
                                                 window->rows, window->cols}
                                    : all;
    const bool inside = asked.rows > 0 && asked.cols > 0 && asked.rows <= all.rows &&
                        asked.cols <= all.cols && asked == intersection(asked, all);
    if (!inside || asked.count() > kWholeNet)
        return wrong("the window is not inside the control net, or has more than " +
                     std::to_string(kWholeNet) + " points");
    RELIEF_TRY(const RasterNet* net, net_of(level, asked));
    return draw_net(*net, all, frame_, all_);
}

Result<Change> RasterModel::changes(const View& view, const std::vector<TileName>& held) {
    Change change;
    const std::vector<LatticeBox> boxes = touched_boxes(bare_->layout(), changed_, view.level);
    change.touched = covered(touched_boxes(bare_->layout(), changed_, 0));
    const bool follows = view.show == View::Show::Edited;
    for (const TileName& name : held) {
        const int drawn = std::max(view.level, name.lod);
        const std::int64_t margin = normals_reach(bare_->layout().spec) << drawn;
        for (const LatticeBox& box : boxes) {
            if (!follows) break;
            const LatticeBox rect = grid_.part_in(name, grown(box, margin));
            if (rect.count() == 0) continue;
            RELIEF_TRY(TileGeometry part, draw(view, name, rect));
            change.tiles.push_back(std::move(part));
        }
    }
    changed_.clear();
    return change;
}

Result<std::optional<Probe>> RasterModel::at(const View& view, Vec2 page) const {
    if (description_.parametric) return std::optional<Probe>();
    const Vec2 lattice = grid_.lattice_place(page);
    const auto inside = [](double p, std::int64_t margin, std::int64_t count) {
        return p >= static_cast<double>(margin) && p <= static_cast<double>(count - 1);
    };
    if (!inside(lattice.x, grid_.margin.rows, grid_.rows) ||
        !inside(lattice.y, grid_.margin.cols, grid_.cols))
        return std::optional<Probe>();
    const Places place{0, {lattice.x}, {lattice.y}};
    const Shown what = shown(view);
    RELIEF_TRY(OriginalSurfaces::Part part, what.surfaces->part(what.level, place, 1));
    if (!part.valid.empty() && part.valid[0] == 0) return std::optional<Probe>();
    if (what.moves) RELIEF_CHECK(what.moves->add_to(part.components, what.level, place, 1));
    const Jets& jets = part.components[0];
    Probe probe;
    probe.value = jets.value[0];
    probe.gradient = {jets.dj[0] / grid_.spacing[0], -jets.di[0] / grid_.spacing[1]};
    probe.slope = std::atan(length(probe.gradient)) * 180 / 3.14159265358979323846;
    const double row = lattice.x - static_cast<double>(grid_.margin.rows);
    const double col = lattice.y - static_cast<double>(grid_.margin.cols);
    probe.place = {col, row};
    if (const auto& t = bare_->description().geo.transform)
        probe.place = {(*t)[0] + (*t)[1] * (col + 0.5) + (*t)[2] * (row + 0.5),
                       (*t)[3] + (*t)[4] * (col + 0.5) + (*t)[5] * (row + 0.5)};
    return std::optional<Probe>(probe);
}

Result<Bytes> RasterModel::file() const {
    std::vector<multires::Move> moves;
    for (const Group& group : groups_)
        moves.insert(moves.end(), group.moves.begin(), group.moves.end());
    MemorySink sink;
    RELIEF_CHECK(codec::add_moves(source_, moves, sink));
    return sink.take();
}

Result<Measurement> RasterModel::measure(const View& view) const {
    const Shown what = shown(view);
    Measurement worst;
    double squares = 0;
    double count = 0;
    const std::int64_t tiles_down = std::max<std::int64_t>((grid_.rows - 2) / TileGrid::kTile, 0);
    const std::int64_t tiles_right = std::max<std::int64_t>((grid_.cols - 2) / TileGrid::kTile, 0);
    for (std::int64_t k = 0; k < (tiles_down + 1) * (tiles_right + 1); ++k) {
        const TileName name{0, k / (tiles_right + 1), k % (tiles_right + 1)};
        RELIEF_TRY(const LatticeBox rect, grid_.rect_of(name));
        const Places places = grid_.places_of(name, rect);
        RELIEF_TRY(OriginalSurfaces::Part now, what.surfaces->part(what.level, places, 0));
        if (what.moves) RELIEF_CHECK(what.moves->add_to(now.components, what.level, places, 0));
        RELIEF_TRY(OriginalSurfaces::Part before, surfaces_.part(0, places, 0));
        RELIEF_CHECK(own_.add_to(before.components, 0, places, 0));
        for (std::size_t n = 0; n < places.count(); ++n) {
            if (!before.valid.empty() && before.valid[n] == 0) continue;
            const Vec3<double> p = frame_.place(now.components, places, n);
            const Vec3<double> off = p - frame_.place(before.components, places, n);
            const double square = dot(off, off);
            squares += square;
            count += 1;
            if (square <= worst.max_error * worst.max_error) continue;
            worst.max_error = std::sqrt(square);
            worst.place = p;
        }
    }
    worst.rms_error = count > 0 ? std::sqrt(squares / count) : 0;
    return worst;
}

Result<Compression> RasterModel::compress(double max_error, const Progress& progress) {
    RELIEF_TRY(Bytes edited, file());
    RELIEF_TRY(const codec::RasterFile opened, codec::RasterFile::open(std::move(edited)));
    RELIEF_TRY(const Raster raster, opened.decode(0));
    codec::EncodeOptions options;
    options.goal = {codec::Goal::Kind::MaxError, max_error};
    options.profile = codec::Profile::Fast;
    options.progress = progress;
    RELIEF_TRY(codec::EncodedRaster encoded, codec::encode_raster(raster, options));
    const auto bytes = std::make_shared<MemorySource>(std::move(encoded.bytes));
    RELIEF_TRY(codec::RasterFile file, codec::RasterFile::open(bytes));
    cache_.clear();
    compressed_ = std::make_unique<codec::RasterFile>(std::move(file));
    compressed_surfaces_ = std::make_unique<OriginalSurfaces>(*compressed_);
    const codec::EncodeReport& report = encoded.report;
    return Compression{report.bytes,     report.kept,      report.coefficients,
                       report.max_error, report.rms_error, bytes};
}

}  // namespace relief::edit
