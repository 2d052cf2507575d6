// PTS (a line with the number of points, then a point a line, once or several times) and XYZ (a point a line). What
// follows x, y and z in a line (intensity, colour, normal) is not used.
#include <charconv>
#include <optional>

#include "cloud/cloud_stream.hpp"
#include "text/text.hpp"

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

class TextPoints {
 public:
  TextPoints(CloudStream& stream, CloudSummary& summary) : stream_(stream), summary_(summary) {}

  /// Takes one line; a point of it, if there is one.
  std::optional<Eigen::Vector3d> take(const std::string& line) {
    const std::string_view text = formats::trim(line);
    if (is_remark(text)) return std::nullopt;
    if (text.find('\0') != std::string_view::npos)
      stream_.fail_at_line("this is no text; expected PLY, LAS, or text with a point a line");
    if (has_decimal_commas(text))
      stream_.fail_at_line("numbers with decimal commas, " + formats::quoted(text) + "; expected decimal points");
    split_words(text, words_);
    if (words_.size() == 1 && block_starts(words_[0])) return std::nullopt;
    Eigen::Vector3d point;
    for (int axis = 0; axis < 3; ++axis) {
      const auto value =
          static_cast<size_t>(axis) < words_.size() ? number_of(words_[static_cast<size_t>(axis)]) : std::nullopt;
      if (!value && taken_ == 0 && !counted_ && !headed_ && axis == 0 && words_.size() >= 3) {
        headed_ = true;  // names of columns
        return std::nullopt;
      }
      if (!value) stream_.fail_at_line("found " + formats::quoted(text) + ", expected x, y and z of a point");
      point(axis) = *value;
    }
    if (counted_ && left_ == 0)
      stream_.fail_at_line("more points than the " + std::to_string(announced_) + " that were announced");
    if (counted_) --left_;
    ++taken_;
    return point;
  }
  void end() const {
    if (counted_ && left_ > 0)
      stream_.fail_at_line(std::to_string(announced_) + " points are announced, the file ends after " +
                           std::to_string(announced_ - left_) + "; it was cut short");
  }

 private:
  bool block_starts(std::string_view word) {
    const auto count = formats::parse_integer(word);
    if (!count || *count < 0 || (counted_ && left_ > 0) || (!counted_ && taken_ > 0)) return false;
    // A point is four bytes of text or more ("0 0 0" without its last line end).
    if (static_cast<std::uint64_t>(*count) > stream_.left() / 5 + 1)
      stream_.fail_at_line(std::to_string(*count) + " points are announced, the file has " +
                           std::to_string(stream_.left()) + " bytes left; it was cut short");
    counted_ = true, announced_ = left_ = static_cast<std::uint64_t>(*count);
    summary_.format = "PTS";
    return true;
  }

  CloudStream& stream_;
  CloudSummary& summary_;
  std::vector<std::string_view> words_;
  bool counted_ = false, headed_ = false;
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
    batch.add(*point);
  }
  if (!sink) return summary;
  points.end();
  batch.flush();
  return summary;
}

}  // namespace plumbline::cloud
