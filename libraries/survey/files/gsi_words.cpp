#include "survey/files/gsi_words.hpp"

#include <algorithm>
#include <numbers>

#include "survey/files/survey_builder.hpp"

namespace plumbline::survey {
namespace {

using text::CharacterLine;

constexpr std::size_t kHead = 7;  // word index, information and sign

bool is_digit(char c) { return c >= '0' && c <= '9'; }

// Whether a word's head stands at `i`: two digits, four characters of information, a sign.
bool is_head(const CharacterLine& line, std::size_t i) {
  if (i + kHead > line.size() || !is_digit(line.at(i)) || !is_digit(line.at(i + 1))) return false;
  for (std::size_t k = i + 2; k < i + 6; ++k)
    if (!is_digit(line.at(k)) && line.at(k) != '.' && line.at(k) != '?') return false;
  return line.at(i + 6) == '+' || line.at(i + 6) == '-';
}

// 11 and 41 use characters 3 to 6 as block number, so that they are never the indices 110 or 410.
int word_index(const CharacterLine& line, std::size_t i) {
  const int two = (line.at(i) - '0') * 10 + (line.at(i + 1) - '0');
  if (two == 11 || two == 41 || !is_digit(line.at(i + 2))) return two;
  return two * 10 + (line.at(i + 2) - '0');
}

std::size_t next_blank(const CharacterLine& line, std::size_t i) {
  while (i < line.size() && line.at(i) != ' ' && line.at(i) != '\t') ++i;
  return i;
}

// Data characters of the words of a line whose first word stands at `i`. The star decides; a line that lost its star
// shows by the place of its first blank.
std::size_t data_width(const CharacterLine& line, std::size_t i, bool star) {
  return star || next_blank(line, i) - i == kHead + 16 ? 16 : 8;
}

// Where the word at `i` ends: by position if a blank or the end follows there, else at the next blank.
std::size_t word_end(const CharacterLine& line, std::size_t i, std::size_t digits) {
  const std::size_t end = i + kHead + digits;
  if (end >= line.size()) {
    // A cut word may be followed by whole ones when the cut happened inside a line; text may hold blanks, heads not.
    for (std::size_t k = i + kHead; k < line.size(); ++k)
      if (line.at(k) == ' ' && is_head(line, k + 1)) return k;
    return line.size();
  }
  if (line.at(end) == ' ' || line.at(end) == '\t') return end;
  return next_blank(line, i);
}

}  // namespace

bool GsiWord::complete() const { return data.size() == digits || CharacterLine(data).size() == digits; }

std::string_view GsiWord::text() const {
  std::string_view value = text::trim(data);
  const std::size_t first = value.find_first_not_of('0');
  if (first == std::string_view::npos) return value.empty() ? value : value.substr(0, 1);
  return text::trim(value.substr(first));
}

const GsiWord* GsiBlock::find(int index) const {
  const auto found = std::find_if(words.begin(), words.end(), [&](const GsiWord& w) { return w.index == index; });
  return found == words.end() ? nullptr : &*found;
}

bool GsiWord::is_blank() const {
  return data.find("---") != std::string_view::npos && data.find_first_not_of("-0 ") == std::string_view::npos;
}

std::optional<long long> gsi_digits(const GsiWord& word) {
  if (!word.complete() || word.data.empty()) return std::nullopt;
  for (const char c : word.data)
    if (!is_digit(c)) return std::nullopt;
  return text::parse_integer(word.data);  // at most 16 digits
}

GsiValue gsi_angle(const GsiWord& word) {
  const auto digits = gsi_digits(word);
  if (!digits) return {0, word.digits == 8 ? "an angle of 8 digits" : "an angle of 16 digits"};
  const auto count = static_cast<double>(*digits);
  double angle = 0;
  if (word.unit == '2') {
    angle = gon_to_rad(count / 1e5);
  } else if (word.unit == '3') {
    angle = degrees_to_rad(count / 1e5);
  } else if (word.unit == '4') {
    const long long degrees = *digits / 100'000, minutes = *digits / 1'000 % 100, tenths = *digits % 1'000;
    if (minutes >= 60 || tenths >= 600) return {0, "minutes and seconds below 60 in DDDMMSSs"};
    angle = degrees_to_rad(static_cast<double>(degrees) + static_cast<double>(minutes) / 60.0 +
                           static_cast<double>(tenths) / 36'000.0);
  } else if (word.unit == '5') {
    angle = count / 1e4 * (std::numbers::pi / 3200.0);
  } else {
    return {0, "the unit digit of an angle: 2 gon, 3 or 4 degrees, 5 mil"};
  }
  if (angle > 4 * std::numbers::pi) return {0, "an angle within the circle"};
  return {word.negative ? -angle : angle, nullptr};
}

GsiValue gsi_length(const GsiWord& word, double foot) {
  const auto digits = gsi_digits(word);
  if (!digits) return {0, word.digits == 8 ? "a length of 8 digits" : "a length of 16 digits"};
  const double count = (word.negative ? -1.0 : 1.0) * static_cast<double>(*digits);
  // Divided by powers of ten, so that 29462 mm is the double nearest to 29.462.
  switch (word.unit) {
    case '0':
      return {count / 1e3, nullptr};
    case '1':
      return {count / 1e3 * foot, nullptr};
    case '6':
      return {count / 1e4, nullptr};
    case '7':
      return {count / 1e4 * foot, nullptr};
    case '8':
      return {count / 1e5, nullptr};
    default:
      return {0, "the unit digit of a length: 0, 6 or 8 metres, 1 or 7 feet"};
  }
}

std::vector<std::string> gsi_distance_corrections(const GsiBlock& block, const GsiWord& distance, bool us_survey_foot) {
  std::vector<std::string> done;
  if (distance.unit == '1' || distance.unit == '7')
    done.push_back(us_survey_foot ? "from US survey feet" : "from international feet");
  std::string constants;
  if (const GsiWord* word = block.find(51); word && word->complete()) {
    // ppm, then the prism constant behind a second sign whose place differs between instruments.
    const std::size_t sign = word->data.find_first_of("+-", 1);
    const auto ppm = text::parse_integer(word->data.substr(0, sign));
    const auto prism = sign == std::string_view::npos ? std::nullopt : text::parse_integer(word->data.substr(sign));
    if (ppm && prism)
      constants =
          "ppm " + std::to_string(word->negative ? -*ppm : *ppm) + ", prism constant " + std::to_string(*prism) + " mm";
  }
  if (const GsiWord* word = block.find(59)) {
    if (const auto digits = gsi_digits(*word))
      constants += (constants.empty() ? "" : ", ") + std::string("ppm ") +
                   text::format_fixed((word->negative ? -1e-4 : 1e-4) * static_cast<double>(*digits), 4);
  }
  if (const GsiWord* word = block.find(58)) {
    if (const auto digits = gsi_digits(*word))
      constants +=
          (constants.empty() ? "" : ", ") + std::string("prism constant ") +
          text::format_fixed(
              (word->negative ? -1.0 : 1.0) * (word->unit == '6' ? 0.1 : 1.0) * static_cast<double>(*digits), 1) +
          " mm";
  }
  if (!constants.empty()) done.push_back("in the instrument: " + constants);
  return done;
}

std::vector<GsiBlock> gsi_blocks(const text::Line& source, std::vector<GsiNoise>& noise) {
  const CharacterLine line(source.text);
  std::vector<GsiBlock> blocks;
  std::size_t digits = 0;
  for (std::size_t i = 0; i < line.size();) {
    if (line.at(i) == ' ' || line.at(i) == '\t' || line.at(i) == '\0') {
      ++i;
      continue;
    }
    const bool star = line.at(i) == '*';
    if (star) ++i;
    if (!is_head(line, i)) {
      const std::size_t end = std::max(i + 1, next_blank(line, i));
      noise.push_back({source.number, static_cast<int>(i) + 1, line.part(i, end - i)});
      i = end;
      continue;
    }
    const int index = word_index(line, i);
    if (blocks.empty() || star || index == 11 || index == 41) {
      blocks.push_back({source.number, {}});
      if (star || digits == 0) digits = data_width(line, i, star);
    }
    const std::size_t end = word_end(line, i, digits);
    GsiWord word;
    word.index = index;
    word.whole = line.part(i, end - i);
    word.data = line.part(i + kHead, end - i - kHead);
    word.unit = line.at(i + 5);
    word.negative = line.at(i + 6) == '-';
    word.digits = digits;
    word.column = static_cast<int>(i) + 1;
    blocks.back().words.push_back(word);
    i = end;
  }
  return blocks;
}

}  // namespace plumbline::survey
