#include <benchmark/benchmark.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <vector>

#include "conversation.h"
#include "relief/codec/mesh_codec.h"
#include "relief/codec/raster_codec.h"
#include "relief/multires/subdivide.h"
#include "shapes.h"
#include "transform_bench.h"

// What the editor's server does for one move of a drag, from the text of the command to the bytes
// for the page, and for a first picture. Drags are scripts of commands whose moves go up and down;
// their time is the median of a move, of one thread, which other programs do not disturb.
namespace relief::editor {
namespace {

using multires::MeshScheme;
using multires::SchemeId;

/// Counts what is sent.
class Meter final : public Outbox {
  public:
    void send(PageId /*page*/, Message message) override {
        if (const auto* text = std::get_if<std::string>(&message)) {
            refused = refused || text->find("\"ok\":false") != std::string::npos;
            last_text = *text;
        } else {
            geometry += std::get<Bytes>(message).size();
        }
    }

    std::string last_text;
    std::size_t geometry = 0;
    bool refused = false;
};

/// A page that is alone.
class Page {
  public:
    explicit Page(const Bytes& file)
        : talk_(*Conversation::create({.name = "bench", .file = source_of(file)}, meter)) {
        talk_.join(kPage);
        hello = Json::parse(meter.last_text);
    }

    void say(const std::string& text) {
        talk_.receive(kPage, read_request(text), [] { return true; });
    }
    void say(const Json& message) { say(message.dump()); }

    Meter meter;
    Json hello;

  private:
    static constexpr PageId kPage = 1;
    static std::shared_ptr<const ByteSource> source_of(const Bytes& file) {
        return std::make_shared<MemorySource>(file);
    }

    Conversation talk_;
};

const Bytes& raster_file(SchemeId id, std::int64_t side) {
    static std::map<std::pair<SchemeId, std::int64_t>, Bytes> files;
    Bytes& file = files[{id, side}];
    if (!file.empty()) return file;
    Raster raster;
    raster.rows = raster.cols = side;
    raster.planes.push_back(Grid<double>(side, side));
    for (std::int64_t r = 0; r < side; ++r)
        for (std::int64_t c = 0; c < side; ++c) {
            const auto x = static_cast<double>(r);
            const auto y = static_cast<double>(c);
            double height = 0;
            for (double size = 512; size >= 2; size /= 2)
                height += size * std::sin(x / size + std::cos(y / size)) * std::cos(y / size);
            raster.planes[0](r, c) = std::round(10 * height) / 10;
        }
    const multires::SchemeSpec spec{.id = id, .order = 2, .levels = 5};
    file = codec::encode_raster(raster, {.spec = spec, .goal = {codec::Goal::Kind::MaxError, 0.5}})
               ->bytes;
    return file;
}

/// 984064 vertices: a torus of 31 x 31 faces, subdivided five times, with bumps.
const Bytes& mesh_file(MeshScheme scheme) {
    static std::map<MeshScheme, Bytes> files;
    Bytes& file = files[scheme];
    if (!file.empty()) return file;
    const test::Shape torus = test::grid(31, 31, scheme == MeshScheme::Loop, true);
    multires::SubdividedMesh<double> fine{torus.topology(), {{}}, {}};
    for (const auto& p : torus.points) fine.arrays[0].push_back({p[0], p[1], p[2]});
    fine = *multires::subdivide(std::move(fine), {.scheme = scheme}, 5);
    PolygonMesh mesh;
    for (const auto& p : fine.arrays[0])
        mesh.vertices.push_back({p.x, p.y, p.z + 0.02 * std::sin(9 * p.x) * std::cos(8 * p.y)});
    const mesh::FaceList faces = mesh::faces_of(fine.mesh);
    mesh.offsets = faces.offsets;
    mesh.corners.assign(faces.corners.begin(), faces.corners.end());
    file = codec::encode_mesh(mesh, {.goal = {codec::Goal::Kind::MaxError, 1e-5}, .scheme = scheme})
               ->bytes;
    return file;
}

double median(std::vector<double> numbers) {
    std::nth_element(numbers.begin(),
                     numbers.begin() + static_cast<std::ptrdiff_t>(numbers.size() / 2),
                     numbers.end());
    return numbers[numbers.size() / 2];
}

/// The moves of a drag of one point.
std::vector<std::string> circle(int level, std::uint64_t point, double size, double radius) {
    constexpr int moves = 64;
    std::vector<std::string> script;
    for (int k = 0; k < moves; ++k) {
        const double angle = 2 * 3.14159265358979323846 * k / moves;
        Json move{{"id", k + 100},  {"do", "drag"},      {"of", "move"},
                  {"level", level}, {"points", {point}}, {"delta", size * (1.5 + std::sin(angle))}};
        if (radius > 0) move["falloff"] = {{"radius", radius}, {"profile", "smooth"}};
        script.push_back(move.dump());
    }
    return script;
}

void run_drag(benchmark::State& state, Page& page, const std::vector<std::string>& script) {
    std::vector<double> times;
    std::size_t bytes = 0;
    set_thread_count(1);
    for (auto _ : state)
        for (const std::string& move : script) {
            page.meter.geometry = 0;
            times.push_back(bench::time_of(CLOCK_THREAD_CPUTIME_ID, [&] { page.say(move); }));
            bytes = page.meter.geometry;
        }
    set_thread_count(0);
    if (page.meter.refused) state.SkipWithError("a command was refused");
    const auto touched = Json::parse(page.meter.last_text)["touched"].get<double>();
    state.counters["median_ms"] = median(times) / 1e6;
    state.counters["bytes"] = static_cast<double>(bytes);
    state.counters["touched"] = touched;
    state.counters["bytes_per_touched"] = static_cast<double>(bytes) / touched;
}

/// All tiles of details 1 and up, and 8 x 8 of the finest around the middle.
Json tiles_shown(const Json& raster) {
    Json tiles = Json::array();
    const auto side = raster["rows"].get<std::int64_t>() - 1;
    for (int lod = raster["coarsest"]; lod >= 0; --lod) {
        const std::int64_t count = std::max<std::int64_t>(side / (std::int64_t{128} << lod), 1);
        const std::int64_t first = lod == 0 ? count / 2 - 4 : 0;
        const std::int64_t end = lod == 0 ? count / 2 + 4 : count;
        for (std::int64_t r = first; r < end; ++r)
            for (std::int64_t c = first; c < end; ++c) tiles.push_back({lod, r, c});
    }
    return tiles;
}

void drag_raster(benchmark::State& state, SchemeId id, double radius) {
    Page page(raster_file(id, 2049));
    page.say(Json{{"id", 1}, {"ask", "view"}, {"level", 0}});
    page.say(Json{{"id", 2}, {"ask", "tiles"}, {"tiles", tiles_shown(page.hello["raster"])}});
    const Json& level = page.hello["levels"][3];
    const auto rows = level["rows"].get<std::uint64_t>();
    const auto cols = level["cols"].get<std::uint64_t>();
    page.say(Json{{"id", 3},
                  {"ask", "net"},
                  {"level", 3},
                  {"window", {rows / 2 - 80, cols / 2 - 80, 160, 160}}});
    run_drag(state, page, circle(3, rows / 2 * cols + cols / 2, 20, radius));
}

void drag_mesh(benchmark::State& state, MeshScheme scheme) {
    Page page(mesh_file(scheme));
    page.say(Json{{"id", 1}, {"ask", "view"}, {"level", 0}, {"net", true}, {"net_level", 3}});
    run_drag(state, page, circle(3, 5000, 0.02, 0));
}

/// From the bytes of a file to those of the first picture.
template <class Ask>
void open(benchmark::State& state, const Bytes& file, Ask first_picture) {
    std::vector<double> wall, all_threads;
    std::size_t bytes = 0;
    for (auto _ : state) {
        const double cpu = bench::nanoseconds(CLOCK_PROCESS_CPUTIME_ID);
        wall.push_back(bench::time_of(CLOCK_MONOTONIC, [&] {
            Page page(file);
            first_picture(page);
            bytes = page.meter.geometry;
        }));
        all_threads.push_back(bench::nanoseconds(CLOCK_PROCESS_CPUTIME_ID) - cpu);
    }
    state.counters["median_ms"] = median(wall) / 1e6;
    state.counters["all_threads_ms"] = median(all_threads) / 1e6;
    state.counters["bytes"] = static_cast<double>(bytes);
    state.counters["file_bytes"] = static_cast<double>(file.size());
}

void open_raster(benchmark::State& state, SchemeId id) {
    open(state, raster_file(id, 4096), [](Page& page) {
        const Json tile = {page.hello["raster"]["coarsest"], 0, 0};
        page.say(Json{{"id", 1}, {"ask", "view"}, {"level", 0}});
        page.say(Json{{"id", 2}, {"ask", "tiles"}, {"tiles", {tile}}});
    });
}

void open_mesh(benchmark::State& state, MeshScheme scheme) {
    open(state, mesh_file(scheme), [](Page& page) {
        page.say(Json{{"id", 1}, {"ask", "view"}, {"level", 0}});
    });
}

constexpr std::pair<const char*, SchemeId> kRasters[] = {
    {"box", SchemeId::Box}, {"cubic", SchemeId::Cubic}, {"fvs", SchemeId::Fvs}};
constexpr std::pair<const char*, MeshScheme> kMeshes[] = {
    {"loop", MeshScheme::Loop}, {"catmull-clark", MeshScheme::CatmullClark}};

/// Samples, so that five control points of level 3 on each side follow.
constexpr double kFalloff = 40;

const bool registered = [] {
    const auto add = [](const std::string& name, auto... arguments) {
        return benchmark::RegisterBenchmark(name.c_str(), arguments...)
            ->Unit(benchmark::kMillisecond)
            ->UseRealTime();
    };
    for (const auto& [name, id] : kRasters) {
        add("editor/drag/" + std::string(name), drag_raster, id, 0);
        add("editor/drag_with_falloff/" + std::string(name), drag_raster, id, kFalloff);
        add("editor/open/" + std::string(name), open_raster, id)->Iterations(5);
    }
    for (const auto& [name, scheme] : kMeshes) {
        add("editor/drag/" + std::string(name), drag_mesh, scheme);
        add("editor/open/" + std::string(name), open_mesh, scheme)->Iterations(5);
    }
    return true;
}();

}  // namespace
}  // namespace relief::editor
