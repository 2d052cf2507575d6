// PTS (a line with the number of points, then a point a line, once or several times) and XYZ (a point a line). What
// stands in a line besides x, y and z (intensity, colour, normal) is not used.
#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <optional>

#include "base/text/text.hpp"
#include "surface/cloud/cloud_stream.hpp"
#include "surface/cloud/unit_names.hpp"

namespace plumbline::cloud {
namespace {

/// The words of a line, apart at blanks, commas and semicolons.
void split_words(std::string_view line, std::vector<std::string_view>& words) {
  words.clear();
  constexpr std::string_view between = " \t,;";
  for (size_t at = line.find_first_not_of(between); at != std::string_view::npos;) {
    const size_t end = std::min(line.find_first_of(between, at), line.size());
    words.push_back(line.substr(at, end - at));
    at = line.find_first_not_of(between, end);
  }
}

/// NaN and infinity are numbers here: a point without place.
std::optional<double> number_of(std::string_view word) {
  double value = 0;
  if (word.starts_with('+')) word.remove_prefix(1);
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error != std::errc() || end != word.data() + word.size()) return std::nullopt;
  return value;
}

/// "12,5 3,25 1,0": a comma within each of three words between blanks or semicolons.
bool has_decimal_commas(std::string_view line) {
  int words = 0;
  constexpr std::string_view between = " \t;";
  for (size_t at = line.find_first_not_of(between); at != std::string_view::npos && words < 3; ++words) {
    const size_t end = std::min(line.find_first_of(between, at), line.size());
    const std::string_view word = line.substr(at, end - at);
    const size_t comma = word.find(',');
    if (comma == std::string_view::npos || comma == 0 || comma + 1 == word.size()) return false;
    at = line.find_first_not_of(between, end);
  }
  return words == 3;
}

bool is_remark(std::string_view line) { return line.empty() || line.starts_with('#') || line.starts_with("//"); }

/// "Easting [m]" is "easting".
std::string plain_name(std::string_view name) {
  std::string plain = text::to_lower(std::string(name.substr(0, name.find_first_of("[("))));
  for (const char quote : {'"', '\''}) std::erase(plain, quote);
  return plain;
}

/// What stands in the brackets of a name: "m" of "X[m]" and of "[m]".
std::string in_brackets(std::string_view word) {
  const size_t from = word.find_first_of("[(");
  if (from == std::string_view::npos) return "";
  return text::to_lower(std::string(word.substr(from + 1, word.find_first_of("])", from) - from - 1)));
}

/// Takes brackets that stand by themselves to the name before them; what they say, name by name.
std::vector<std::string> join_brackets(std::vector<std::string_view>& names) {
  std::vector<std::string> said;
  std::vector<std::string_view> joined;
  for (const std::string_view name : names) {
    const bool alone = !joined.empty() && name.find_first_of("[(") == 0;
    if (!alone) joined.push_back(name), said.push_back(in_brackets(name));
    if (alone) said.back() = in_brackets(name);
  }
  names = std::move(joined);
  return said;
}

/// Which columns x, y and z stand in, by their names; nothing if the names do not say it, or say it twice.
std::optional<std::array<size_t, 3>> columns_of(const std::vector<std::string_view>& names) {
  constexpr std::array<std::array<std::string_view, 6>, 3> others{{{"easting", "east", "e", "coordx", "x_coord", "x"},
                                                                   {"northing", "north", "n", "coordy", "y_coord", "y"},
                                                                   {"height", "elevation", "elev", "h", "up", "z"}}};
  std::array<size_t, 3> columns{};
  for (const bool plain : {true, false}) {
    std::array<int, 3> found{};
    for (size_t column = 0; column < names.size(); ++column)
      for (size_t axis = 0; axis < 3; ++axis) {
        const std::string name = plain_name(names[column]);
        const bool is = plain ? name == others[axis].back()
                              : std::find(others[axis].begin(), others[axis].end(), name) != others[axis].end();
        if (is) ++found[axis], columns[axis] = column;
      }
    if (found == std::array<int, 3>{1, 1, 1}) return columns;
  }
  return std::nullopt;
}

class TextPoints {
 public:
  TextPoints(CloudStream& stream, CloudSummary& summary) : stream_(stream), summary_(summary) {}

  /// Takes one line; a point of it, if there is one.
  std::optional<Eigen::Vector3d> take(const std::string& line) {
    std::string_view text = text::trim(line);
    if (stream_.line_number() == 1 && text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);  // a byte order mark
    if (is_remark(text)) return take_remark(text);
    if (text.find('\0') != std::string_view::npos)
      stream_.fail_at_line("this is no text; expected PLY, LAS, or text with a point a line");
    if (has_decimal_commas(text))
      stream_.fail_at_line("numbers with decimal commas, " + text::quoted(text) + "; expected decimal points");
    split_words(text, words_);
    if (words_.size() == 1 && block_starts(words_[0])) return std::nullopt;
    if (taken_ == 0 && !counted_ && !headed_ && words_.size() >= 3 && !number_of(words_[0])) return take_names(text);
    // A remark with as many words as there are columns names them; another only has x, y and z in it.
    if (remarked_ > 0 && remarked_ != words_.size()) columns_ = {0, 1, 2}, headed_ = false, summary_.unit = unknown_;
    remarked_ = 0;
    Eigen::Vector3d point;
    for (size_t axis = 0; axis < 3; ++axis) {
      const auto value = columns_[axis] < words_.size() ? number_of(words_[columns_[axis]]) : std::nullopt;
      if (!value) stream_.fail_at_line("found " + text::quoted(text) + ", expected x, y and z of a point");
      point(static_cast<Eigen::Index>(axis)) = *value;
      steps_.take(static_cast<Eigen::Index>(axis), *value, step_of_text(words_[columns_[axis]]));
    }
    look_at_index();
    if (counted_ && left_ == 0)
      stream_.fail_at_line("more points than the " + std::to_string(announced_) + " that were announced");
    if (counted_) --left_;
    ++taken_;
    return point;
  }
  Eigen::Vector3d resolution() const { return steps_.found(); }
  void end() const {
    if (is_index_ && taken_ >= 10) refuse_index();
    if (counted_ && left_ > 0)
      stream_.fail_at_line(std::to_string(announced_) + " points are announced, the file ends after " +
                           std::to_string(announced_ - left_) + "; it was cut short");
  }

 private:
  /// A first column that nobody named and that counts the points is no coordinate: the scan would seem to lie
  /// elsewhere.
  void look_at_index() {
    constexpr std::uint64_t kSure = 100;  // points
    if (!is_index_) return;
    const auto first = number_of(words_[0]);
    if (taken_ == 0 && first) index_ = *first;
    is_index_ = !headed_ && words_.size() >= 4 && first && (index_ == 0 || index_ == 1) &&
                *first == index_ + static_cast<double>(taken_);
    if (is_index_ && taken_ == kSure) refuse_index();
  }
  [[noreturn]] void refuse_index() const {
    stream_.fail_at_line(
        "the first column counts the points, and columns without names are x, y and z; take it out, or name the "
        "columns "
        "in a first line, such as 'index x y z'");
  }
  /// Names of columns in the first line; where x, y and z are not named, nobody knows which columns they are.
  std::optional<Eigen::Vector3d> take_names(std::string_view text) {
    const std::vector<std::string> said = join_brackets(words_);
    const auto columns = columns_of(words_);
    if (!columns)
      stream_.fail_at_line("the columns are named " + text::quoted(text) +
                           "; expected x, y and z, or easting, northing and height, each once");
    columns_ = *columns, headed_ = true;
    take_units(said);
    return std::nullopt;
  }
  void take_units(const std::vector<std::string>& said) {
    std::array<double, 3> units{};
    for (size_t axis = 0; axis < 3; ++axis) units[axis] = unit_named(said[columns_[axis]]);
    double unit = std::numeric_limits<double>::quiet_NaN();  // of those that say one
    bool one = true;
    for (const double said_unit : units)
      if (std::isfinite(said_unit)) one = one && (!std::isfinite(unit) || unit == said_unit), unit = said_unit;
    if (!one)
      stream_.fail_at_line("x is in " + said[columns_[0]] + ", y in " + said[columns_[1]] + ", z in " +
                           said[columns_[2]] + "; expected one unit");
    summary_.unit = unit;
    for (const size_t column : columns_) summary_.either_foot = summary_.either_foot || says_feet(said[column]);
  }
  /// A remark before the first point may name the columns: "//X Y Z R G B".
  std::optional<Eigen::Vector3d> take_remark(std::string_view text) {
    if (taken_ > 0 || counted_ || headed_) return std::nullopt;
    split_words(text.substr(std::min(text.find_first_not_of("#/ "), text.size())), words_);
    const std::vector<std::string> said = join_brackets(words_);
    const auto columns = columns_of(words_);
    if (!columns) return std::nullopt;
    columns_ = *columns, headed_ = true, remarked_ = words_.size();
    take_units(said);
    return std::nullopt;
  }
  bool block_starts(std::string_view word) {
    const auto count = text::parse_integer(word);
    if (count && counted_ && left_ > 0 && left_ == announced_)
      stream_.fail_at_line(
          "two whole numbers, " + std::to_string(announced_) + " and " + std::to_string(*count) +
          ", at the start of a scan: this is a PTX file, which is not read; write it out as PTS, LAS or PLY from the "
          "scanner's program or with CloudCompare, in metres, with each scan's own transformation applied");
    if (!count || *count < 0 || (counted_ && left_ > 0) || (!counted_ && taken_ > 0)) return false;
    // A point is four bytes of text or more ("0 0 0" without its last line end).
    if (static_cast<std::uint64_t>(*count) > stream_.left() / 5 + 1)
      stream_.fail_at_line(std::to_string(*count) + " points are announced, the file has " +
                           std::to_string(stream_.left()) + " bytes left; it was cut short");
    counted_ = true, announced_ = left_ = static_cast<std::uint64_t>(*count);
    summary_.scans = summary_.format == "PTS" ? summary_.scans + 1 : 1;
    summary_.format = "PTS";
    return true;
  }

  CloudStream& stream_;
  CloudSummary& summary_;
  std::vector<std::string_view> words_;
  std::array<size_t, 3> columns_ = {0, 1, 2};
  size_t remarked_ = 0;  ///< words of the remark that named them, until the first point
  static constexpr double unknown_ = std::numeric_limits<double>::quiet_NaN();
  Steps steps_;
  bool counted_ = false, headed_ = false, is_index_ = true;  // until a point says otherwise
  double index_ = 0;
  std::uint64_t announced_ = 0, left_ = 0, taken_ = 0;
};

}  // namespace

CloudSummary read_text(CloudStream& stream, const PointSink& sink) {
  CloudSummary summary;
  summary.format = "XYZ";
  TextPoints points(stream, summary);
  PointBatch batch(summary, stream, sink);
  std::string line;
  while (stream.line(line)) {
    const auto point = points.take(line);
    if (!point) continue;
    if (!sink) return summary;
    batch.add(*point, static_cast<size_t>(summary.scans - 1));
  }
  if (!sink) return summary;
  points.end();
  batch.flush();
  summary.resolution = points.resolution();
  return summary;
}

}  // namespace plumbline::cloud
