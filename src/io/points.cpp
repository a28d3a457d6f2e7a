#include "relief/io/points.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <optional>
#include <string_view>
#include <utility>

#include "io/extension.h"
#include "io/mesh_formats.h"
#include "io/text_lines.h"
#include "relief/io/file.h"

namespace relief::io {

namespace detail {

namespace {

constexpr std::size_t kLongestLine = std::size_t{1} << 20;
constexpr std::size_t kMostPoints = 0x7FFFFFFF;

/// What columns are for.
constexpr std::size_t kX = 0;
constexpr std::size_t kY = 1;
constexpr std::size_t kWeight = 2;
constexpr std::size_t kValue = 3;  ///< of the first component; those of the others follow
constexpr std::size_t kKinds = 4;

constexpr std::array<std::string_view, kKinds> kKindNames = {"x", "y", "weight", "value"};

/// Names of columns, the most telling first.
constexpr std::array<std::array<std::string_view, 8>, kKinds> kKnownNames = {{
    {"x", "lon", "long", "longitude", "easting", "east"},
    {"y", "lat", "latitude", "northing", "north"},
    {"weight", "w"},
    {"z", "elevation", "elev", "height", "altitude", "depth", "value"},
}};

std::size_t kind_of(std::size_t role) {
    return std::min(role, kValue);
}

std::string_view trimmed(std::string_view word) {
    const std::size_t first = word.find_first_not_of(Words::kBlanks);
    if (first == std::string_view::npos) return {};
    return word.substr(first, word.find_last_not_of(Words::kBlanks) + 1 - first);
}

/// Cuts lines into fields.
class Fields {
  public:
    /// ' ' stands for blanks.
    static char separator_of(std::string_view line) {
        for (const char separator : {';', ','})
            if (line.find(separator) != std::string_view::npos) return separator;
        return ' ';
    }

    /// The first `most` fields of a line.
    static void split(std::string_view line, char separator, std::size_t most,
                      std::vector<std::string_view>& fields) {
        fields.clear();
        line = trimmed(line);
        for (bool more = !line.empty(); more && fields.size() < most;) {
            const bool quoted = line.starts_with('"');
            const std::size_t quote = quoted ? line.find('"', 1) : 0;
            const std::size_t end = end_of_field(line, separator, quote);
            std::string_view field = trimmed(line.substr(0, end));
            if (quoted && field.size() > 1 && field.ends_with('"'))
                field = trimmed(field.substr(1, field.size() - 2));
            fields.push_back(field);
            more = end != std::string_view::npos;
            if (more) line = skip_blanks(line.substr(separator == ' ' ? end : end + 1));
        }
    }

  private:
    static std::size_t end_of_field(std::string_view line, char separator, std::size_t from) {
        return separator == ' ' ? line.find_first_of(Words::kBlanks, from)
                                : line.find(separator, from);
    }
    static std::string_view skip_blanks(std::string_view line) {
        return line.substr(std::min(line.find_first_not_of(Words::kBlanks), line.size()));
    }
};

/// The number of a column from 0, if the choice is one.
std::optional<std::size_t> chosen_number(const std::string& choice) {
    std::size_t number = 0;
    if (!parse_number(std::string_view(choice), number) || number == 0) return std::nullopt;
    return number - 1;
}

class PointReader {
  public:
    PointReader(const std::string& name, const PointColumns& columns)
        : name_(name), choices_{columns.x, columns.y} {
        if (columns.values_needed) {
            choices_.push_back(columns.weight);
            choices_.insert(choices_.end(), columns.values.begin(), columns.values.end());
            if (columns.values.empty()) choices_.emplace_back();
            points_.values.resize(choices_.size() - kValue);
        }
        column_.resize(choices_.size());
        numbers_.resize(choices_.size());
    }

    /// The next line of the file, without its end.
    Status take(std::string_view line) {
        ++number_;
        if (number_ == 1 && line.starts_with("\xEF\xBB\xBF")) line.remove_prefix(3);
        line = trimmed(line.substr(0, line.find('#')));
        if (line.empty()) return {};
        if (!known_) {
            RELIEF_TRY(const bool names, set_columns(line));
            if (names) return {};
        }
        return take_point(line);
    }

    Result<PointSet> finish() {
        if (points_.places.empty())
            return Error{ErrorCode::BadInput, "there is no point in it; a point needs a line",
                         name_};
        return std::move(points_);
    }

    [[nodiscard]] Error error(std::string message, std::int64_t line) const {
        return {ErrorCode::BadInput, std::move(message), fmt::format("{}, line {}", name_, line)};
    }
    [[nodiscard]] Error too_long() const {
        return error("is longer than a megabyte; this is no list of points", number_ + 1);
    }

  private:
    using Column = std::optional<std::size_t>;

    /// From the first line that says something; whether it names the columns.
    Result<bool> set_columns(std::string_view line) {
        known_ = true;
        separator_ = Fields::separator_of(line);
        Fields::split(line, separator_, kLongestLine, fields_);
        const bool names = !holds_numbers();
        for (std::size_t role = 0; role < choices_.size(); ++role) {
            RELIEF_TRY(column_[role],
                       names ? named_column(role) : Result<Column>(chosen_column(role)));
            if (column_[role]) field_count_ = std::max(field_count_, *column_[role] + 1);
        }
        return names;
    }

    /// Only weights may be missing.
    [[nodiscard]] bool needed(std::size_t role) const {
        return role != kWeight || !choices_[role].empty();
    }

    /// Whether all needed columns of the first line are numbers.
    [[nodiscard]] bool holds_numbers() const {
        for (std::size_t role = 0; role < choices_.size(); ++role) {
            if (!needed(role)) continue;
            const Column column = chosen_column(role);
            double number = 0;
            if (!column) return false;
            if (*column >= fields_.size() || fields_[*column].empty()) continue;
            if (!parse_number(fields_[*column], number)) return false;
        }
        return true;
    }

    /// Of a file that does not name its columns; none if one is chosen by name.
    [[nodiscard]] Column chosen_column(std::size_t role) const {
        if (!needed(role)) return std::nullopt;
        if (choices_[role].empty()) return role < kWeight ? role : 2;
        return chosen_number(choices_[role]);
    }

    Result<Column> named_column(std::size_t role) const {
        if (const auto number = chosen_number(choices_[role])) return Column(number);
        if (!choices_[role].empty()) {
            if (const Column found = find(lower_case(choices_[role]))) return found;
            return error(fmt::format("no column is called {}; it has {}",
                                     detail::quoted(choices_[role]), names_of_columns()),
                         number_);
        }
        for (const std::string_view known : kKnownNames[kind_of(role)])
            if (const Column found = known.empty() ? Column() : find(known)) return found;
        if (role == kWeight) return Column();
        if (role >= kValue) return first_other_column();
        return error(
            fmt::format("no column is called {} or the like; it has {}: say which is {}",
                        kKindNames[kind_of(role)], names_of_columns(), kKindNames[kind_of(role)]),
            number_);
    }

    [[nodiscard]] Column find(std::string_view name) const {
        const auto found = std::find_if(
            fields_.begin(), fields_.end(),
            [&](std::string_view field) { return lower_case(std::string(field)) == name; });
        if (found == fields_.end()) return std::nullopt;
        return static_cast<std::size_t>(found - fields_.begin());
    }

    [[nodiscard]] Result<Column> first_other_column() const {
        const auto others = std::span(column_).first(kValue);
        for (std::size_t column = 0; column < fields_.size(); ++column)
            if (std::find(others.begin(), others.end(), Column(column)) == others.end())
                return Column(column);
        return error("there is no column of values beside the places; say which is value", number_);
    }

    [[nodiscard]] std::string names_of_columns() const {
        std::string names;
        for (std::size_t k = 0; k < std::min<std::size_t>(fields_.size(), 10); ++k)
            names += (k ? ", " : "") + detail::quoted(fields_[k]);
        return names;
    }

    Status take_point(std::string_view line) {
        Fields::split(line, separator_, field_count_, fields_);
        for (std::size_t role = 0; role < choices_.size(); ++role) {
            if (!column_[role]) continue;
            RELIEF_CHECK(read_field(role, numbers_[role]));
        }
        if (points_.places.size() == kMostPoints)
            return error("too_many_points: at most 2^31 - 1 are read; split the file", number_);
        points_.places.push_back({numbers_[kX], numbers_[kY]});
        for (std::size_t m = 0; m < points_.values.size(); ++m)
            points_.values[m].push_back(numbers_[kValue + m]);
        if (column_.size() > kWeight && column_[kWeight])
            points_.weights.push_back(numbers_[kWeight]);
        return {};
    }

    Status read_field(std::size_t role, double& number) const {
        const std::size_t column = *column_[role];
        const auto refuse = [&](std::string_view what) {
            return error(
                fmt::format("{} (column {}) {}", kKindNames[kind_of(role)], column + 1, what),
                number_);
        };
        if (column >= fields_.size() || fields_[column].empty())
            return refuse("is missing; complete or remove the line");
        if (!parse_number(fields_[column], number))
            return refuse("is " + detail::quoted(fields_[column]) +
                          ", not a number; correct it or choose another column");
        if (!std::isfinite(number))
            return refuse("is " + detail::quoted(fields_[column]) +
                          ", not finite; remove the line");
        if (role == kWeight && number < 0) return refuse("is negative; weights are 0 or more");
        return {};
    }

    const std::string& name_;
    std::vector<std::string> choices_;  ///< of each role
    bool known_ = false;                ///< the columns
    char separator_ = ' ';
    std::vector<Column> column_;   ///< of each role
    std::vector<double> numbers_;  ///< of each role, in the last line
    std::size_t field_count_ = 0;
    std::vector<std::string_view> fields_;
    std::int64_t number_ = 0;
    PointSet points_;
};

/// Gives all complete lines of `text` to the reader; what is left is the beginning of another.
Status take_lines(PointReader& reader, std::string_view& text) {
    for (std::size_t end = text.find('\n'); end != std::string_view::npos; end = text.find('\n')) {
        if (end > kLongestLine) return reader.too_long();
        RELIEF_CHECK(reader.take(text.substr(0, end)));
        text.remove_prefix(end + 1);
    }
    return text.size() > kLongestLine ? Status(reader.too_long()) : Status();
}

}  // namespace

}  // namespace detail

Result<PointSet> parse_points(std::span<const std::uint8_t> bytes, const std::string& name,
                              const PointColumns& columns) {
    detail::PointReader reader(name, columns);
    std::string_view text = detail::text_of(bytes);
    RELIEF_CHECK(detail::take_lines(reader, text));
    RELIEF_CHECK(reader.take(text));
    return reader.finish();
}

Result<PointSet> read_points(const std::string& path, const PointColumns& columns) {
    constexpr std::uint64_t kPiece = std::uint64_t{1} << 22;
    RELIEF_TRY(const auto source, open_source(path));
    detail::PointReader reader(path, columns);
    std::string piece;
    for (std::uint64_t offset = 0; offset < source->size();) {
        const std::size_t begun = piece.size();
        const std::uint64_t size = std::min(kPiece, source->size() - offset);
        piece.resize(begun + size);
        RELIEF_CHECK(
            source->read(offset, {reinterpret_cast<std::uint8_t*>(piece.data()) + begun, size}));
        offset += size;
        std::string_view text = piece;
        RELIEF_CHECK(detail::take_lines(reader, text));
        piece.erase(0, piece.size() - text.size());
    }
    RELIEF_CHECK(reader.take(piece));
    return reader.finish();
}

Status write_csv(const std::string& path, std::span<const CsvColumn> columns) {
    constexpr std::size_t kPiece = std::size_t{1} << 20;
    const std::size_t count = columns.empty() ? 0 : columns[0].values.size();
    for (const CsvColumn& column : columns)
        if (column.values.size() != count)
            return Error{ErrorCode::InvalidArgument,
                         fmt::format("column '{}' has {} values and the first {}; they must agree",
                                     column.name, column.values.size(), count),
                         path};
    RELIEF_TRY(OutputFile file, OutputFile::create(path));
    std::string text;
    const auto flush = [&] {
        Status written =
            file.write({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
        text.clear();
        return written;
    };
    for (const CsvColumn& column : columns)
        text += (&column == &columns[0] ? "" : ",") + column.name;
    text += '\n';
    for (std::size_t k = 0; k < count; ++k) {
        for (const CsvColumn& column : columns) {
            if (&column != &columns[0]) text += ',';
            if (std::isfinite(column.values[k]))
                fmt::format_to(std::back_inserter(text), "{}", column.values[k]);
        }
        text += '\n';
        if (text.size() >= kPiece) RELIEF_CHECK(flush());
    }
    RELIEF_CHECK(flush());
    return file.commit();
}

}  // namespace relief::io
