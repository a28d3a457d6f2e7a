#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "relief/io/raster.h"
#include "relief/io/synthetic.h"
#include "reproduce.h"

namespace {

namespace fs = std::filesystem;
using relief::reproduce::Row;
using relief::reproduce::Terrain;

/// The rasters named on the command line, the demonstration's elevation model and those of
/// RELIEF_DATA; a synthetic terrain always.
std::vector<Terrain> load_terrains(std::vector<std::string> paths, bool quiet) {
    std::vector<Terrain> terrains;
    terrains.push_back({"ridged 257 (synthetic)", relief::io::ridged(257, 1)});
    const char* data = std::getenv("RELIEF_DATA");
    const fs::path folder = fs::path(data ? data : "../shared/data") / "terrain";
    std::error_code error;
    std::vector<std::string> found;
    for (const auto& entry : fs::directory_iterator(folder, error))
        if (entry.path().extension() == ".tif") found.push_back(entry.path().string());
    std::sort(found.begin(), found.end());
    if (found.empty() && !quiet)
        fmt::print(stderr,
                   "relief-reproduce: no rasters in {}: those rows are skipped (set RELIEF_DATA)\n",
                   folder.string());
    paths.insert(paths.end(), found.begin(), found.end());
    for (const std::string& path : paths) {
        auto raster = relief::io::read_raster(path);
        if (!raster.ok()) {
            fmt::print(stderr, "relief-reproduce: {}\n", raster.error().text());
            continue;
        }
        terrains.push_back({fs::path(path).stem().string(), *std::move(raster)});
    }
    return terrains;
}

void print_table(const std::vector<Row>& rows) {
    fmt::print("{:<24} {:<46} {:>12} {:>12}  {}\n", "case", "quantity", "paper", "ours", "note");
    std::string source;
    for (const Row& row : rows) {
        if (row.source != source) fmt::print("\n{}\n", source = row.source);
        fmt::print("{:<24} {:<46} {:>12} {:>12.6g}  {}\n", row.item, row.quantity,
                   row.paper ? fmt::format("{:.6g}", *row.paper) : "-", row.ours, row.note);
    }
}

}  // namespace

int main(int argc, char** argv) {
    CLI::App app{"Prints every number of the source papers beside ours."};
    bool json = false;
    std::vector<std::string> paths;
    std::string figures;
    app.add_flag("--json", json, "a JSON list of {source, case, quantity, paper, ours, note}");
    app.add_option("--figures", figures,
                   "only draw figures of reverse subdivision and of Powell-Sabin splines into this "
                   "folder")
        ->check(CLI::ExistingDirectory);
    app.add_option("RASTER", paths, "more terrain for the compression figures");
    try {
        app.parse(argc, argv);
    } catch (const CLI::Success& success) {
        return app.exit(success);
    } catch (const CLI::ParseError& error) {
        fmt::print(stderr, "relief-reproduce: {}\n", error.what());
        return 2;
    }
    if (!figures.empty()) {
        relief::Status drawn = relief::reproduce::reverse_figures(figures);
        if (drawn.ok()) drawn = relief::reproduce::powell_sabin_figures(figures);
        if (drawn.ok()) return 0;
        fmt::print(stderr, "relief-reproduce: {}\n", drawn.error().text());
        return 1;
    }
    std::vector<Row> rows = relief::reproduce::barycentric_rows(load_terrains(paths, json));
    for (Row& row : relief::reproduce::fvs_rows()) rows.push_back(std::move(row));
    for (Row& row : relief::reproduce::reverse_rows()) rows.push_back(std::move(row));
    for (Row& row : relief::reproduce::powell_sabin_rows()) rows.push_back(std::move(row));
    if (!json) {
        print_table(rows);
        return 0;
    }
    nlohmann::ordered_json list = nlohmann::ordered_json::array();
    for (const Row& row : rows)
        list.push_back(
            {{"source", row.source},
             {"case", row.item},
             {"quantity", row.quantity},
             {"paper", row.paper ? nlohmann::ordered_json(*row.paper) : nullptr},
             {"ours", std::isfinite(row.ours) ? nlohmann::ordered_json(row.ours) : nullptr},
             {"note", row.note}});
    fmt::print("{}\n", list.dump(1));
    return 0;
}
