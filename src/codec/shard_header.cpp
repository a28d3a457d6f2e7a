#include "codec/shard_header.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "codec/json_reader.h"
#include "relief/core/json.h"

namespace relief::codec {

namespace {

using Json = nlohmann::json;
using Reader = JsonReader;

constexpr const char* kContent = "raster-shard";

/// What encoders know of the integers and files do not say.
Json domains_json(const LatticeCoding& coding) {
    Json list = Json::array();
    for (const IntegerDomain& domain : coding.domains)
        list.push_back({{"rounding", json_number(domain.rounding)}, {"outliers", domain.outliers}});
    return list;
}

Status read_domains(const Json& list, LatticeCoding& coding) {
    if (list.size() != coding.domains.size())
        return bad_header("the number of its integer domains is not that of its components");
    for (std::size_t c = 0; c < list.size(); ++c) {
        if (!list[c].is_object()) return bad_header("an integer domain is not an object");
        Reader reader(list[c]);
        coding.domains[c].rounding = reader.get("rounding", 0.0, true);
        coding.domains[c].outliers = reader.get("outliers", false, true);
        RELIEF_CHECK(reader.status());
        if (!(coding.domains[c].rounding >= 0))
            return bad_header("the rounding of its integers is out of range");
    }
    return {};
}

Json tile_json(const ShardTile& tile) {
    return {{"tile", tile.number},
            {"max", json_number(tile.about.error.max)},
            {"square", json_number(tile.about.error.square)},
            {"coarse", json_numbers(tile.about.coarse_errors)},
            {"nonzero", tile.about.nonzero},
            {"repairs", tile.about.repairs}};
}

Status read_tile(const Json& json, const TileTree& tree, ShardTile& tile) {
    if (!json.is_object()) return bad_header("a tile is not an object");
    Reader reader(json);
    TileSummary& about = tile.about;
    tile.number = reader.get<std::int64_t>("tile", 0, true);
    about.error.max = reader.get("max", 0.0, true);
    about.error.square = reader.get("square", 0.0, true);
    about.nonzero = reader.get<std::int64_t>("nonzero", 0, true);
    about.repairs = reader.get<std::int64_t>("repairs", 0, true);
    for (const Json& error : reader.array("coarse"))
        about.coarse_errors.push_back(error.is_number() ? error.get<double>() : INFINITY);
    RELIEF_CHECK(reader.status());
    const std::size_t coarse = chunk_ranges(tree, 0).size() - (tree.tiers() == 1 ? 1 : 0);
    const auto is_error = [](double error) { return error >= 0; };
    const bool right =
        tile.number >= 0 && tile.number < tree.tier(0).tiles() && is_error(about.error.max) &&
        is_error(about.error.square) && about.coarse_errors.size() == coarse &&
        std::all_of(about.coarse_errors.begin(), about.coarse_errors.end(), is_error);
    if (!right) return bad_header("the number or the errors of a tile are out of range");
    return {};
}

}  // namespace

std::string write_shard_header(const ShardHeader& header) {
    Json json{{"content", kContent},
              {"raster", Json::parse(write_header(header.raster))},
              {"valid", header.valid},
              {"domains", domains_json(*header.raster.lattice)},
              {"tiles", Json::array()}};
    if (header.plan) json["plan"] = *header.plan;
    for (const ShardTile& tile : header.tiles) json["tiles"].push_back(tile_json(tile));
    return json.dump();
}

Result<ShardHeader> read_shard_header(const std::string& text) {
    const Json json = parse_json<Json>(text);
    if (!json.is_object()) return bad_header("the header is not a JSON object");
    Reader reader(json);
    const auto content = reader.get<std::string>("content", "", true);
    RELIEF_CHECK(reader.status());
    if (content != kContent)
        return Error{ErrorCode::Unsupported, "holds '" + content + "' and is no shard of a raster",
                     "header"};
    ShardHeader header;
    RELIEF_TRY(header.raster, read_header(reader.object("raster")));
    header.valid = reader.get<std::int64_t>("valid", 0, true);
    if (json.contains("plan")) header.plan = reader.get<std::uint32_t>("plan", 0);
    const Json& domains = reader.array("domains");
    const Json& tiles = reader.array("tiles");
    RELIEF_CHECK(reader.status());
    if (!header.raster.lattice) return bad_header("it is not of the closed loop");
    if (header.valid < 1) return bad_header("it has no valid sample");
    RELIEF_CHECK(read_domains(domains, *header.raster.lattice));
    const TileTree tree(header.raster.lattice_rows(), header.raster.lattice_cols());
    for (const Json& item : tiles) RELIEF_CHECK(read_tile(item, tree, header.tiles.emplace_back()));
    const auto ascends = [](const ShardTile& a, const ShardTile& b) {
        return a.number >= b.number;
    };
    if (std::adjacent_find(header.tiles.begin(), header.tiles.end(), ascends) != header.tiles.end())
        return bad_header("its tiles do not ascend");
    return header;
}

}  // namespace relief::codec
