#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "survey_files/gsi.hpp"
#include "survey_files/gsi_words.hpp"
#include "survey_files/survey_builder.hpp"
#include "text/text.hpp"

namespace plumbline::survey {
namespace {

constexpr double kLongestDistance = 1e5;  // [m]; no instrument measures farther, so longer ones are damage
constexpr std::size_t kCodesListed = 10;

class GsiReader {
 public:
  GsiReader(std::string_view bytes, const std::string& file, const GsiOptions& options)
      : decoded_(formats::decode_text(bytes)), builder_(file, "gsi"), options_(options) {}

  SurveyObservations read();

 private:
  void read_block(const GsiBlock& block);
  void read_code_block(const GsiBlock& block);
  void read_heights(const GsiBlock& block);
  void read_info(const GsiBlock& block);
  bool starts_station(const GsiBlock& block, bool has_measurement);
  void start_station(const std::optional<std::string>& station, double height, const SourcePosition& source);
  void settle_instrument_height(Sighting& sighting);
  void lose_station(const GsiBlock& block, const GsiWord& word, const std::string& expected);
  bool passes_cut_line(const GsiBlock& block, bool has_measurement);
  void read_sighting(const GsiBlock& block, const std::string& target);
  void read_zenith_angle(const GsiWord& word, Sighting& sighting);
  void describe_point(const GsiBlock& block, const std::string& id);
  void warn_of_vertical_reference();

  std::optional<std::string> name(const GsiWord* word);
  std::optional<double> angle(const GsiWord* word);
  std::optional<double> length(const GsiWord* word);
  Eigen::Vector3d coordinates(const GsiBlock& block, int east);
  void reject(const GsiWord& word, const std::string& expected) {
    builder_.skip(line_, word.column, word.whole, expected);
  }

  formats::DecodedText decoded_;
  SurveyBuilder builder_;
  const GsiOptions& options_;
  int line_ = 0;
  double instrument_height_ = kNotGiven, target_height_ = kNotGiven;
  bool height_is_of_set_up_ = false;  // given at the start of the current set-up or since
  std::size_t observations_at_start_ = 0;
  bool lost_station_ = false;
  Eigen::Vector3d station_coordinates_ = Eigen::Vector3d::Constant(kNotGiven);
  std::vector<std::string> other_codes_;
  std::vector<int> words_of_sighting_;  // of the last one that was not cut off
};

SurveyObservations GsiReader::read() {
  std::vector<GsiNoise> noise;
  std::size_t blocks = 0;
  for (const formats::Line& line : formats::split_lines(decoded_.text)) {
    noise.clear();
    const auto in_line = gsi_blocks(line, noise);
    if (!noise.empty())
      builder_.skip(noise.front().line, noise.front().column, noise.front().text,
                    "a GSI word: word index, information, sign and 8 or 16 characters, e.g. '31..00+00012345'");
    blocks += in_line.size();
    for (const GsiBlock& block : in_line) read_block(block);
  }
  if (decoded_.encoding != formats::Encoding::utf8)
    builder_.warn(std::string("text encoding taken as ") + formats::name_of(decoded_.encoding));
  if (!other_codes_.empty()) {
    std::string list;
    for (std::size_t i = 0; i < std::min(other_codes_.size(), kCodesListed); ++i)
      list += (i ? ", " : "") + formats::quoted(other_codes_[i]);
    builder_.warn("code blocks that begin no set-up were passed over (codes " + list +
                  (other_codes_.size() > kCodesListed ? ", ..." : "") +
                  "); if one of them begins a set-up, name it in the reader's station codes");
  }
  warn_of_vertical_reference();
  return builder_.finish(blocks == 0 ? "no GSI block" : std::to_string(blocks) + " GSI blocks without measurements",
                         blocks == 0 ? understood_formats() : "words 21, 22, 31 (measurements) or 81, 82, 83");
}

// A horizon reference is not recorded in the file. It shows as angles that all stay nearer to zero than to 100 gon.
// Steep sights up a facade look alike when few, hence only a warning.
void GsiReader::warn_of_vertical_reference() {
  if (options_.vertical_reference != GsiVerticalReference::zenith) return;
  std::size_t count = 0;
  double sum = 0;
  for (const Observation& observation : builder_.survey.observations) {
    if (observation.kind != ObservationKind::zenith_angle) continue;
    const double from_zero = std::abs(std::remainder(observation.value, 2 * std::numbers::pi));
    if (from_zero >= std::numbers::pi / 2) return;
    sum += from_zero;
    ++count;
  }
  if (count > 0 && sum / static_cast<double>(count) < std::numbers::pi / 4)
    builder_.warn(
        "all vertical angles are below 100 gon and small: if the instrument counted from the horizon, set the "
        "reader's vertical reference to 'horizon'");
}

void GsiReader::read_block(const GsiBlock& block) {
  line_ = block.line;
  if (block.words.front().index == 41) return read_code_block(block);
  read_info(block);
  read_heights(block);
  const GsiWord* id_word = block.find(11);
  const bool has_measurement = std::any_of(block.words.begin(), block.words.end(), [](const GsiWord& w) {
    return w.index == 21 || w.index == 22 || w.index == 31 || w.index == 32 || w.index == 33;
  });
  if (starts_station(block, has_measurement) && !has_measurement) return;
  const bool has_target_coordinates = block.find(81) || block.find(82) || block.find(83);
  if (!passes_cut_line(block, has_measurement)) return;
  if (!has_measurement && !has_target_coordinates) return;
  const auto id = name(id_word);
  if (!id) {
    if (!id_word) reject(block.words.front(), "word 11 with the point's name before its measurements");
    return;
  }
  if (has_measurement) {
    read_sighting(block, *id);
  } else {
    builder_.give_coordinates(*id, coordinates(block, 81), builder_.at(line_, id_word->column));
    describe_point(block, *id);
  }
}

// A line may be cut between two words, where each that is left is whole. It shows as the beginning of the sighting
// before: without any measurement left it is damage; otherwise what is left is sound, and may have been meant.
bool GsiReader::passes_cut_line(const GsiBlock& block, bool has_measurement) {
  std::vector<int> words;
  for (const GsiWord& word : block.words) words.push_back(word.index);
  const bool beginning = words.front() == 11 && words.size() < words_of_sighting_.size() &&
                         std::equal(words.begin(), words.end(), words_of_sighting_.begin());
  if (!beginning) {
    if (has_measurement) words_of_sighting_ = std::move(words);
    return true;
  }
  std::string missing;
  bool readings_missing = false;
  for (std::size_t i = words.size(); i < words_of_sighting_.size(); ++i) {
    const int index = words_of_sighting_[i];
    missing += (missing.empty() ? "" : ", ") + std::to_string(index);
    readings_missing = readings_missing || index == 22 || (index >= 31 && index <= 33);
  }
  if (!has_measurement) {
    reject(block.words.back(), "words " + missing + " after it, as the sighting before has them");
    return false;
  }
  // A distance alone may be missing because none was measured.
  if (readings_missing && (!block.find(22) || words_of_sighting_.size() > words.size() + 1))
    builder_.warn("line " + std::to_string(line_) + " ends where the sighting before goes on with words " + missing +
                  ": if it was cut off, these readings are lost");
  return true;
}

void GsiReader::read_info(const GsiBlock& block) {
  const auto take = [&](int index, std::string& into) {
    if (const GsiWord* word = block.find(index); word && into.empty()) into = std::string(word->text());
  };
  NetworkInfo& info = builder_.survey.info;
  take(12, info.instrument_serial);
  take(13, info.instrument);
  take(913, info.title);
  take(914, info.operator_name);
}

// Heights hold until changed.
void GsiReader::read_heights(const GsiBlock& block) {
  if (const auto height = length(block.find(87))) target_height_ = *height;
  if (const auto height = length(block.find(88))) {
    instrument_height_ = *height;
    height_is_of_set_up_ = true;
  }
}

void GsiReader::start_station(const std::optional<std::string>& station, double height, const SourcePosition& source) {
  height_is_of_set_up_ = !std::isnan(height);
  if (height_is_of_set_up_) instrument_height_ = height;
  if (station)
    builder_.start_set_up(*station, instrument_height_, source);
  else
    builder_.start_unnamed_set_up(instrument_height_, source);
  observations_at_start_ = builder_.survey.observations.size();
  lost_station_ = false;
}

// The first sighting settles the height of its set-up; later changes belong to their observations.
void GsiReader::settle_instrument_height(Sighting& sighting) {
  SetUp& set_up = builder_.survey.set_ups[static_cast<std::size_t>(builder_.current_set_up())];
  if (std::isnan(instrument_height_)) return;
  if (builder_.survey.observations.size() > observations_at_start_) {
    if (instrument_height_ != set_up.instrument_height) sighting.instrument_height = instrument_height_;
    return;
  }
  set_up.instrument_height = instrument_height_;
  if (!height_is_of_set_up_)
    builder_.warn("set-up '" + set_up.id + "' (line " + std::to_string(set_up.source.line) +
                  ") gives no instrument height; the one before is taken to hold");
}

// Sightings after an unreadable start must not be taken for those of the station before.
void GsiReader::lose_station(const GsiBlock& block, const GsiWord& word, const std::string& expected) {
  builder_.skip(block.line, word.column, word.whole, expected);
  lost_station_ = true;
}

void GsiReader::read_code_block(const GsiBlock& block) {
  const GsiWord& code = block.words.front();
  const std::string text(code.text());
  if (!code.complete()) return lose_station(block, code, "a whole code word 41 with 8 or 16 characters");
  const auto rule = std::find_if(options_.station_codes.begin(), options_.station_codes.end(),
                                 [&](const GsiStationCode& candidate) { return candidate.code == text; });
  if (rule == options_.station_codes.end()) {
    if (std::find(other_codes_.begin(), other_codes_.end(), text) == other_codes_.end() &&
        other_codes_.size() <= kCodesListed)
      other_codes_.push_back(text);
    return;
  }
  const GsiWord* station = block.find(rule->station_word);
  if (!station || !station->complete())
    return lose_station(block, station ? *station : code,
                        "the station's name in word " + std::to_string(rule->station_word));
  double height = kNotGiven;
  if (const GsiWord* word = block.find(rule->height_word)) {
    const auto value = word->complete() ? formats::parse_number(word->text()) : std::nullopt;
    if (value)
      height = (word->negative ? -*value : *value) / (1.0 / rule->height_unit);
    else
      reject(*word, "an instrument height, as code block " + text + " has it in this word");
  }
  start_station(std::string(station->text()), height, builder_.at(line_, code.column));
}

// Rules (a) and (c) of the header; true if the block began a set-up.
bool GsiReader::starts_station(const GsiBlock& block, bool has_measurement) {
  const GsiWord* station_word = block.find(16);
  const bool has_coordinates = block.find(84) && block.find(85);
  if (!station_word && !has_coordinates) return false;
  const Eigen::Vector3d here = has_coordinates ? coordinates(block, 84) : Eigen::Vector3d::Constant(kNotGiven).eval();
  const int current = builder_.current_set_up();
  // A measuring block repeats its station; coordinates of zero are what instruments write before one is set.
  if (has_measurement) {
    const bool named = station_word != nullptr;
    const bool same_name = named && current >= 0 && !lost_station_ &&
                           builder_.survey.set_ups[static_cast<std::size_t>(current)].station == station_word->text();
    const bool same_place = (here.array() == station_coordinates_.array()).all();
    const bool not_set = here[0] == 0 && here[1] == 0;
    if (named ? same_name : (not_set || (same_place && current >= 0 && !lost_station_))) return false;
  }
  const GsiWord* name_word = station_word ? station_word : has_measurement ? nullptr : block.find(11);
  const SourcePosition source = builder_.at(line_, block.words.front().column);
  const double height = length(block.find(88)).value_or(kNotGiven);
  if (name_word) {
    const auto station = name(name_word);
    if (!station) {
      lost_station_ = true;
      return true;
    }
    start_station(*station, height, source);
  } else {
    start_station(std::nullopt, height, source);
  }
  station_coordinates_ = here;
  const std::string& station = builder_.survey.set_ups[static_cast<std::size_t>(builder_.current_set_up())].station;
  builder_.give_coordinates(station, here, source);
  return true;
}

void GsiReader::read_sighting(const GsiBlock& block, const std::string& target) {
  if (builder_.current_set_up() < 0 || lost_station_) {
    start_station(std::nullopt, length(block.find(88)).value_or(kNotGiven),
                  builder_.at(line_, block.words.front().column));
  }
  Sighting sighting;
  sighting.to = target;
  sighting.source = builder_.at(line_, block.words.front().column);
  sighting.target_height = target_height_;
  settle_instrument_height(sighting);
  if (const auto direction = angle(block.find(21))) sighting.direction = *direction;
  if (const GsiWord* word = block.find(22)) read_zenith_angle(*word, sighting);
  const GsiWord* slope = block.find(31);
  const GsiWord* horizontal = block.find(32);
  const GsiWord* height = block.find(33);
  // 32 and 33 are computed from 31 where that is there: only the measured value counts.
  if (slope) {
    sighting.slope_distance = length(slope).value_or(kNotGiven);
    sighting.distance_corrections = gsi_distance_corrections(block, *slope, options_.us_survey_foot);
  } else if (horizontal || height) {
    sighting.horizontal_distance = length(horizontal).value_or(kNotGiven);
    if (!block.find(22)) sighting.height_difference = length(height).value_or(kNotGiven);
    sighting.distance_corrections =
        gsi_distance_corrections(block, horizontal ? *horizontal : *height, options_.us_survey_foot);
    sighting.distance_corrections.push_back("reduced by the instrument (curvature and refraction as set there)");
  }
  for (double* distance : {&sighting.slope_distance, &sighting.horizontal_distance}) {
    if (*distance >= 0 && *distance <= kLongestDistance) continue;
    if (!std::isnan(*distance)) reject(slope ? *slope : *horizontal, "a distance between 0 and 100 km");
    *distance = kNotGiven;
  }
  builder_.add(sighting);
  describe_point(block, target);
}

void GsiReader::read_zenith_angle(const GsiWord& word, Sighting& sighting) {
  if (options_.vertical_reference == GsiVerticalReference::percent) {
    const auto digits = gsi_digits(word);
    if (!digits) return reject(word, "a slope in percent, all characters digits");
    const double percent = (word.negative ? -1e-5 : 1e-5) * static_cast<double>(*digits);
    sighting.zenith_angle = std::atan2(100.0, percent);
    sighting.zenith_corrections.push_back("from a slope in percent; the face is not known");
    return;
  }
  const auto value = angle(&word);
  if (!value) return;
  sighting.zenith_angle = *value;
  if (options_.vertical_reference == GsiVerticalReference::horizon) {
    sighting.zenith_angle = std::numbers::pi / 2 - *value;
    sighting.zenith_corrections.push_back("counted from the horizon in the file");
  }
}

// Instruments fill a remark nobody keyed in with dashes.
void GsiReader::describe_point(const GsiBlock& block, const std::string& id) {
  Point& point = builder_.point(id, builder_.at(line_, block.words.front().column));
  for (int index = 71; index <= 79; ++index) {
    const GsiWord* word = block.find(index);
    if (!word) continue;
    const std::string text(word->text());
    if (text.find_first_not_of("-?0 ") == std::string::npos) continue;
    std::string& into = index == 71 ? point.code : point.description;
    if (into.empty()) into = text;
  }
}

std::optional<std::string> GsiReader::name(const GsiWord* word) {
  if (!word) return std::nullopt;
  if (!word->complete() || word->text().empty()) {
    reject(*word, "a name of " + std::to_string(word->digits) + " characters; the line seems cut");
    return std::nullopt;
  }
  return std::string(word->text());
}

std::optional<double> GsiReader::angle(const GsiWord* word) {
  if (!word) return std::nullopt;
  const GsiValue value = gsi_angle(*word);
  if (value.expected) {
    reject(*word, value.expected);
    return std::nullopt;
  }
  if (word->unit == '3' || word->unit == '4') builder_.survey.info.angles_in_degrees = true;
  return value.value;
}

std::optional<double> GsiReader::length(const GsiWord* word) {
  if (!word) return std::nullopt;
  const GsiValue value = gsi_length(*word, options_.us_survey_foot ? kUsSurveyFoot : kFoot);
  if (value.expected) {
    reject(*word, value.expected);
    return std::nullopt;
  }
  return value.value;
}

Eigen::Vector3d GsiReader::coordinates(const GsiBlock& block, int east) {
  Eigen::Vector3d result;
  for (int axis = 0; axis < 3; ++axis) result[axis] = length(block.find(east + axis)).value_or(kNotGiven);
  return result;
}

}  // namespace

SurveyObservations read_gsi(std::string_view bytes, const std::string& file, const GsiOptions& options) {
  return GsiReader(bytes, file, options).read();
}

}  // namespace plumbline::survey
