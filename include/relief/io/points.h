#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "relief/core/result.h"
#include "relief/core/vec2.h"

/// Scattered points from text files (.xyz .csv .txt), and columns of numbers to CSV. See
/// docs/triangulations.md.
namespace relief::io {

/// Which columns of a file are what: a name of its first line, whatever its case, or a number
/// from 1. Empty: the column with a well-known name (x, lon, easting, ..; y, lat, northing, ..; z,
/// elevation, height, value, ..; weight, w), for the value else the first of the other columns;
/// without a line of names the columns 1, 2 and 3, and no weight.
struct PointColumns {
    std::string x = {};
    std::string y = {};
    std::vector<std::string> values = {};  ///< of each component; none: there is one
    std::string weight = {};
    bool values_needed = true;  ///< false: a file of places, without values and weights
};

/// Samples of functions over the plane. All numbers are finite.
struct PointSet {
    std::vector<Vec2> places;
    std::vector<std::vector<double>> values;  ///< [component][place]; empty if not needed
    std::vector<double> weights;  ///< of each place, not negative; empty if the file has none
};

/// A text of one point a line: numbers between semicolons, or else commas, or else blanks, as in
/// the first line; more columns are left out, as are # and what follows it on a line, quotes around
/// a word, and blank lines. The first line may name the columns: it does if a needed column of it
/// is not a number. Errors: BadInput in "name, line n": a number is missing, no number, not finite,
/// a weight is negative, a named column does not exist, a line is longer than a megabyte; BadInput:
/// there is no point, or there are 2^31.
[[nodiscard]] Result<PointSet> parse_points(std::span<const std::uint8_t> bytes,
                                            const std::string& name,
                                            const PointColumns& columns = {});

/// Reads a file, piece by piece: in memory are the points only. Errors: NotFound, BadFile, and
/// those of parse_points. Complexity: O(size), about 0.1 us a number.
[[nodiscard]] Result<PointSet> read_points(const std::string& path,
                                           const PointColumns& columns = {});

struct CsvColumn {
    std::string name;
    std::span<const double> values;  ///< what is not a number becomes an empty field
};

/// Writes a line of names and one line for each element of the columns, numbers with the fewest
/// digits that give the same double. The file appears when it is complete. Errors: InvalidArgument
/// for columns of different sizes; CannotWrite.
[[nodiscard]] Status write_csv(const std::string& path, std::span<const CsvColumn> columns);

}  // namespace relief::io
