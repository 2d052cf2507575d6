#include <cmath>
#include <map>
#include <utility>

#include "base/text/text.hpp"
#include "survey/files/field_books.hpp"
#include "survey/files/levelling.hpp"
#include "survey/files/survey_builder.hpp"

namespace plumbline::survey {
namespace {

constexpr double kLongestStaff = 10, kLongestSight = 300, kHeightsAgree = 0.003;  // [m]

/// A staff reading with the height that the level computed from it.
struct Reading {
  StaffReading staff;
  double height = kNotGiven;
};

class TopconLevelReader {
 public:
  TopconLevelReader(std::string_view bytes, const std::string& file)
      : decoded_(text::decode_text(bytes)), builder_(file, "topcon-dl"), level_(builder_) {}
  SurveyObservations read();

 private:
  void read_text_line(std::string_view text);
  void read_csv_line(std::string_view text);
  void begin_line(const std::string& start);
  void require_metres(std::string_view text) const;
  bool accept(const Reading& reading, std::string_view text);
  void find_positions();
  void add_position(std::vector<Reading> back, std::vector<Reading> ahead);

  text::DecodedText decoded_;
  SurveyBuilder builder_;
  LevelRun level_;
  int line_ = 0;
  std::string start_;                      // bench mark that the line begins on
  std::vector<Reading> readings_;          // of the line, in their order; which is back and which ahead is not written
  std::vector<Reading> back_, ahead_;      // of one position of the level, where it is
  std::map<std::string, double> heights_;  // as the level has them
};

std::string word_behind(std::string_view text, std::string_view mark) {
  const std::size_t at = text.find(mark);
  if (at == std::string_view::npos) return "";
  const auto words = text::split_blanks(text.substr(at + mark.size()));
  return words.empty() ? "" : std::string(words.front());
}

void TopconLevelReader::require_metres(std::string_view text) const {
  for (std::size_t at = text.find('('); at != std::string_view::npos; at = text.find('(', at + 1))
    if (!text.substr(at).starts_with("(m)"))
      throw SurveyReadError(builder_.at(line_, static_cast<int>(at) + 1), text::quoted(text), "lengths in metres (m)");
}

bool TopconLevelReader::accept(const Reading& reading, std::string_view text) {
  const StaffReading& s = reading.staff;
  if (!s.point.empty() && std::abs(s.value) <= kLongestStaff && s.distance >= 0 && s.distance <= kLongestSight)
    return true;
  builder_.skip(line_, 1, text, "a point, a staff reading of at most 10 m and a distance of at most 300 m");
  return false;
}

void TopconLevelReader::begin_line(const std::string& start) {
  find_positions();
  start_ = start;
  heights_.clear();
}

// "A 3.37 0.1602 15:09": point, distance, staff, and behind the staff ahead its height.
void TopconLevelReader::read_text_line(std::string_view text) {
  if (const std::string start = word_behind(text, "START BM#:"); !start.empty()) return begin_line(start);
  if (text.starts_with("GH(")) {
    require_metres(text);
    const auto height = text::parse_number(word_behind(text, ":"));
    if (!height) return builder_.skip(line_, 1, text, "the height of the bench mark");
    heights_[start_] = *height;
    if (!start_.empty()) builder_.know_coordinates(start_, {kNotGiven, kNotGiven, *height}, builder_.at(line_, 1));
    return;
  }
  if (text.starts_with("Dist.")) return require_metres(text);
  const auto words = text::split_blanks(text);
  const auto number = [&](std::size_t k) {
    return words.size() > k ? text::parse_number(words[k]).value_or(kNotGiven) : kNotGiven;
  };
  const bool heading =
      text.starts_with("DL-") || text == "Leveling" || text.starts_with("JOB") || text.starts_with("END");
  if (heading && std::isnan(number(1))) return;
  Reading r{{StaffReading::Kind::back, std::string(words[0]), number(2), number(1), builder_.at(line_, 1)}, number(3)};
  if (accept(r, text)) readings_.push_back(std::move(r));
}

/// Back is the bench mark first, then the point that was ahead before. BFFB and a line there and back have the same
/// names and give the same two differences.
void TopconLevelReader::find_positions() {
  const std::vector<Reading> all = std::exchange(readings_, {});
  std::string from = start_;
  for (std::size_t i = 0; i < all.size();) {
    const auto name = [&](std::size_t k) { return i + k < all.size() ? all[i + k].staff.point : std::string(); };
    const auto is = [&](const std::string& a, const std::string& b, const std::string& c, const std::string& d) {
      return name(0) == a && name(1) == b && name(2) == c && name(3) == d;
    };
    const std::string& to = name(0) == from ? (name(1) == from ? name(2) : name(1)) : name(0);
    const bool named = !from.empty() && !to.empty() && from != to;
    std::string order;
    if (named && is(from, to, to, from))
      order = "BFFB";
    else if (named && is(from, from, to, to))
      order = "BBFF";
    else if (named && is(to, from, from, to))
      order = "FBBF";
    else if (named && name(0) == from && name(1) == to)
      order = "BF";
    else if (named && name(0) == to && name(1) == from)
      order = "FB";
    std::vector<Reading> back, ahead;
    for (const char side : order) (side == 'B' ? back : ahead).push_back(all[i++]);
    if (order.empty()) {
      builder_.skip(all[i].staff.source.line, 1, all[i].staff.point,
                    "readings of " + (from.empty() ? "the bench mark that the line begins on" : text::quoted(from)) +
                        " and of the next point, as BF, BFFB, BBFF, FB or FBBF");
      ++i;
      continue;
    }
    from = to;
    add_position(std::move(back), std::move(ahead));
  }
}

/// The heights that the level computed show whether back and ahead are what they are taken for.
void TopconLevelReader::add_position(std::vector<Reading> back, std::vector<Reading> ahead) {
  if (back.empty() || ahead.empty()) {
    for (const auto* side : {&back, &ahead})
      for (const Reading& r : *side)
        builder_.skip(r.staff.source.line, 1, r.staff.point, "a reading back and one ahead of the same position");
    return;
  }
  const auto known = heights_.find(back.front().staff.point);
  const double from = std::isnan(back.front().height) && known != heights_.end() ? known->second : back.front().height;
  double to = kNotGiven;
  for (const Reading& r : ahead)
    if (std::isnan(to)) to = r.height;
  const double difference = back.front().staff.value - ahead.front().staff.value;
  if (std::abs(to - from - difference) > kHeightsAgree)
    return builder_.skip(ahead.front().staff.source.line, 1, text::format_fixed(to, 4),
                         "the height " + text::format_fixed(from + difference, 4) + " of " +
                             text::quoted(ahead.front().staff.point) + ", which the readings give");
  if (!std::isnan(to)) heights_[ahead.front().staff.point] = to;
  for (Reading& r : back) r.staff.kind = StaffReading::Kind::back, level_.add(std::move(r.staff));
  for (Reading& r : ahead) r.staff.kind = StaffReading::Kind::ahead, level_.add(std::move(r.staff));
  level_.finish_position();
}

// "0001,A,0,1,1,40.53,1.40786,20.00000,": number, point, two settings, 1 back or 2 ahead, distance, staff, height.
void TopconLevelReader::read_csv_line(std::string_view text) {
  const auto cells = text::split(text, ',');
  const auto number = [&](std::size_t k) {
    return cells.size() > k ? text::parse_number(cells[k]).value_or(kNotGiven) : kNotGiven;
  };
  if (cells.size() < 8 || (number(4) != 1 && number(4) != 2))
    return builder_.skip(line_, 1, text, "a reading back (1) or ahead (2)");
  const bool is_back = number(4) == 1;
  Reading r{{is_back ? StaffReading::Kind::back : StaffReading::Kind::ahead, std::string(text::trim(cells[1])),
             number(6), number(5), builder_.at(line_, 1)},
            number(7)};
  if (!accept(r, text)) return;
  std::vector<Reading>& side = is_back ? back_ : ahead_;
  if (!side.empty() && side.front().staff.point != r.staff.point)
    add_position(std::exchange(back_, {}), std::exchange(ahead_, {}));
  (is_back ? back_ : ahead_).push_back(std::move(r));
}

SurveyObservations TopconLevelReader::read() {
  bool csv = false, first = true;
  for (const text::Line& line : text::split_lines(decoded_.text)) {
    line_ = line.number;
    const std::string_view text = text::trim(line.text);
    if (text.empty()) continue;
    if (is_topcon_level(text)) {
      builder_.survey.info.instrument = text.substr(0, text.find(','));
      csv = text.find(',') != std::string_view::npos;
      if (csv) builder_.warn("the file does not say the unit of its lengths: they are taken as metres");
    } else if (first) {
      break;
    } else if (csv) {
      read_csv_line(text);
    } else {
      read_text_line(text);
    }
    first = false;
  }
  find_positions();
  if (!back_.empty() || !ahead_.empty()) add_position(std::move(back_), std::move(ahead_));
  level_.finish();
  return builder_.finish(first ? "no head of a level" : "no reading", first ? understood_formats() : "staff readings");
}

}  // namespace

bool is_topcon_level(std::string_view line) {
  if (line.starts_with("DL-100")) return true;
  if (!line.starts_with("SDL") && !line.starts_with("DL-") && !line.starts_with("DL5")) return false;
  const std::string_view model = line.substr(0, line.find(','));
  return model.size() < line.size() && model.size() <= 8 &&
         model.find_first_of("0123456789") != std::string_view::npos && text::split(line, ',').size() >= 6;
}

SurveyObservations read_topcon_level(std::string_view bytes, const std::string& file) {
  return TopconLevelReader(bytes, file).read();
}

}  // namespace plumbline::survey
