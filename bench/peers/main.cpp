#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <limits>
#include <nlohmann/json.hpp>

#include "peer.h"
#include "relief/core/parallel.h"

/// Measures relief and its peers on rasters: one line of JSON for each codec and goal. The codecs
/// get samples in memory and give bytes in memory, in one thread, whose own clock is read.
namespace relief::peers {

namespace {

using nlohmann::json;

/// A measurement is repeated until it has taken so long, or so often.
struct Patience {
    double seconds = 0.3;
    int runs = 5;
};

/// The best time of some runs of `work`, which returns a Result; the last result in `result`.
template <class T, class Work>
double best_seconds(clockid_t clock, const Patience& patience, Result<T>& result, Work work) {
    double best = std::numeric_limits<double>::infinity();
    double all = 0;
    for (int run = 0; run < patience.runs && all < patience.seconds; ++run) {
        const double start = seconds_of(clock);
        result = work();
        const double took = seconds_of(clock) - start;
        if (!result.ok()) break;
        best = std::min(best, took);
        all += took;
    }
    return best;
}

const char* kind_name(const Goal& goal) {
    if (goal.kind == Goal::Kind::Lossless) return "lossless";
    return goal.kind == Goal::Kind::MaxError ? "max-error" : "bytes";
}

class Comparison {
  public:
    Comparison(std::string name, const Field& field, const Patience& patience)
        : name_(std::move(name)), field_(field), patience_(patience), peers_(all_peers()) {}

    void run() {
        const Goal lossless{Goal::Kind::Lossless, 0};
        at_bound(lossless);
        if (!field_.integer()) at_bound({Goal::Kind::MaxError, 0.1});
        for (const double bound : {1.0, 5.0, 20.0}) at_bound({Goal::Kind::MaxError, bound});
        for (const double bits : {0.25, 0.5, 1.0, 2.0}) at_rate(bits);
        if (field_.count() >= kLarge) windows(lossless);
        if (field_.count() >= kLarge) two_threads({Goal::Kind::MaxError, 1});
    }

  private:
    static constexpr std::size_t kLarge = 1'000'000;
    static constexpr std::int64_t kWindow = 256;

    [[nodiscard]] json line(const Peer& peer, const Goal& goal) const {
        return {{"raster", name_},           {"type", field_.integer() ? "int16" : "float32"},
                {"samples", field_.count()}, {"valid", field_.valid_count},
                {"codec", peer.name()},      {"goal", kind_name(goal)},
                {"value", goal.value}};
    }

    static void print(const json& line) { std::cout << line.dump() << std::endl; }

    void at_bound(const Goal& goal) const {
        for (const auto& peer : peers_)
            if (peer->offers(field_, goal)) print(measured(*peer, goal));
    }

    /// Files of one size: what JPEG 2000 really needs for so many bits a sample, where it is there.
    void at_rate(double bits) const {
        double budget = std::floor(bits * static_cast<double>(field_.count()) / 8);
        const auto to_size = [&](bool masked) {
            for (const auto& peer : peers_) {
                const double mask = masked ? 0 : static_cast<double>(field_.mask_bytes);
                const Goal goal{Goal::Kind::Bytes, budget - mask};
                if (peer->has_mask() != masked || !peer->offers(field_, goal) || goal.value < 1)
                    continue;
                json result = measured(*peer, goal);
                result["bits"] = bits;
                print(result);
                if (!masked && result.contains("bytes")) budget = result["bytes"];
            }
        };
        to_size(false);
        to_size(true);
    }

    [[nodiscard]] json measured(const Peer& peer, const Goal& goal) const {
        json result = line(peer, goal);
        Result<Bytes> bytes = Bytes{};
        const double encoding = best_seconds(CLOCK_THREAD_CPUTIME_ID, patience_, bytes,
                                             [&] { return peer.encode(field_, goal); });
        if (!bytes.ok()) return with_error(result, bytes.error());
        Result<Decoded> decoded = Decoded{};
        const double decoding = best_seconds(CLOCK_THREAD_CPUTIME_ID, patience_, decoded,
                                             [&] { return peer.decode(*bytes, field_, goal); });
        if (!decoded.ok()) return with_error(result, decoded.error());
        const auto off = deviation(field_, *decoded, bound_of(goal));
        if (!off.ok()) return with_error(result, off.error());
        result["bytes"] = bytes->size() + (peer.has_mask() ? 0 : field_.mask_bytes);
        result["encode_seconds"] = encoding;
        result["decode_seconds"] = decoding;
        result["max_error"] = off->max_error;
        result["rms_error"] = off->rms_error;
        result["over"] = off->over;
        return result;
    }

    static json with_error(json line, const Error& error) {
        line["error"] = error.text();
        return line;
    }

    /// A window in the middle of a lossless file, against the whole of it.
    void windows(const Goal& goal) const {
        const LatticeBox window{(field_.raster.rows - kWindow) / 2,
                                (field_.raster.cols - kWindow) / 2, kWindow, kWindow};
        for (const auto& peer : peers_) {
            if (!peer->has_windows() || !peer->offers(field_, goal)) continue;
            const auto bytes = peer->encode(field_, goal);
            if (!bytes.ok()) continue;
            Result<Decoded> decoded = Decoded{};
            json result = line(*peer, goal);
            result["goal"] = "window";
            result["window_samples"] = window.count();
            result["decode_seconds"] =
                best_seconds(CLOCK_THREAD_CPUTIME_ID, patience_, decoded,
                             [&] { return peer->decode_window(*bytes, field_, window); });
            print(decoded.ok() ? result : with_error(result, decoded.error()));
        }
    }

    /// Wall time on one thread and on two.
    void two_threads(const Goal& goal) const {
        for (const auto& peer : relief_codecs()) {
            if (!peer->offers(field_, goal)) continue;
            json result = line(*peer, goal);
            result["goal"] = "threads";
            for (const int threads : {1, 2}) {
                set_thread_count(threads);
                Result<Bytes> bytes = Bytes{};
                Result<Decoded> decoded = Decoded{};
                result["encode_seconds"].push_back(best_seconds(
                    CLOCK_MONOTONIC, patience_, bytes, [&] { return peer->encode(field_, goal); }));
                if (bytes.ok())
                    result["decode_seconds"].push_back(
                        best_seconds(CLOCK_MONOTONIC, patience_, decoded,
                                     [&] { return peer->decode(*bytes, field_, goal); }));
            }
            set_thread_count(1);
            print(result);
        }
    }

    std::string name_;
    const Field& field_;
    Patience patience_;
    Peers peers_;
};

int run(int count, char** arguments) {
    Patience patience;
    std::vector<std::string> paths(arguments + 1, arguments + count);
    if (!paths.empty() && paths[0] == "--once") {
        patience.runs = 1;
        paths.erase(paths.begin());
    }
    if (paths.empty()) {
        std::cerr << "usage: relief_peers [--once] raster...\n";
        return 2;
    }
    set_thread_count(1);
    json versions;
    for (const Library& library : libraries()) versions[library.name] = library.version;
    std::cout << json{{"libraries", versions}}.dump() << std::endl;
    for (const std::string& path : paths) {
        const auto field = read_field(path);
        if (!field.ok()) {
            std::cerr << field.error().text() << '\n';
            return 1;
        }
        Comparison(stem(path), *field, patience).run();
    }
    return 0;
}

}  // namespace

}  // namespace relief::peers

int main(int count, char** arguments) {
    return relief::peers::run(count, arguments);
}
