#include "survey/files/gsi_reader.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/text/words.hpp"

namespace plumbline::survey {
namespace {

constexpr std::size_t kCodesListed = 10;

}  // namespace

SurveyObservations GsiReader::read() {
  std::vector<GsiNoise> noise;
  std::vector<GsiBlock> all;
  for (const text::Line& line : text::split_lines(decoded_.text)) {
    noise.clear();
    auto in_line = gsi_blocks(line, noise);
    if (!noise.empty())
      builder_.skip(noise.front().line, noise.front().column, noise.front().text,
                    "a GSI word: word index, information, sign and 8 or 16 characters, e.g. '31..00+00012345'");
    for (GsiBlock& block : in_line) all.push_back(std::move(block));
  }
  const std::size_t blocks = all.size();
  plan_ = plan_gsi_stations(all, options_, options_.us_survey_foot ? kUsSurveyFoot : kFoot);
  for (std::size_t i = 0; i < all.size(); ++i) read_block(all[i], i);
  level_.finish();
  if (decoded_.encoding != text::Encoding::utf8)
    builder_.warn(std::string("text encoding taken as ") + text::name_of(decoded_.encoding));
  if (!other_codes_.empty()) {
    std::vector<std::string> codes;
    for (const std::string& code : other_codes_) codes.push_back(text::quoted(code));
    builder_.warn("code blocks that begin no set-up were passed over (codes " + text::join(codes, kCodesListed) +
                  "); if one of them begins a set-up, name it in the reader's station codes");
  }
  if (renamed_ > 0)
    builder_.warn(std::to_string(renamed_) + " sightings have a point number that was used before for another place (" +
                  first_renamed_ + " is the first): they are points of their own, named with '/2'");
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

// What gsi_stations.cpp found: a set-up that begins here, a height that 83 shows to have changed, an oriented circle.
void GsiReader::begin_planned(const GsiBlock& block, std::size_t number) {
  if (const auto start = plan_.starts.find(number); start != plan_.starts.end()) {
    const GsiStart& found = start->second;
    const SourcePosition source = builder_.at(line_, block.words.front().column);
    start_station(found.station.empty() ? std::nullopt : std::optional(found.station), found.instrument_height, source);
    SetUp& set_up = builder_.survey.set_ups[builder_.current_set_up()];
    set_up.stated_orientation = found.orientation;
    turn_ = found.turn;
    // Where the axis is known and no point below it, the point is the axis.
    if (found.station.empty()) {
      set_up.instrument_height = instrument_height_ = kNotGiven;
      builder_.give_coordinates(set_up.station, found.coordinates, source);
    }
    builder_.warn("the sightings from line " + std::to_string(line_) + " on " + found.reason);
  }
  if (const auto height = plan_.instrument_height.find(number); height != plan_.instrument_height.end()) {
    instrument_height_ = std::round(height->second * 1e3) / 1e3;
    height_is_of_set_up_ = true;
    builder_.warn("line " + std::to_string(line_) + ": word 83 shows the instrument height " +
                  text::format_fixed(instrument_height_, 3) + " m from here on; it is taken");
  }
  if (plan_.oriented.contains(number) && builder_.current_set_up() >= 0) {
    SetUp& set_up = builder_.survey.set_ups[builder_.current_set_up()];
    if (std::isnan(set_up.stated_orientation)) set_up.stated_orientation = 0;
  }
}

void GsiReader::read_block(const GsiBlock& block, std::size_t number) {
  line_ = block.line;
  if (read_level_block(block)) return;
  if (block.words.front().index == 41) return read_code_block(block);
  read_info(block);
  read_heights(block);
  begin_planned(block, number);
  const GsiWord* id_word = block.find(11);
  const bool has_measurement = std::any_of(block.words.begin(), block.words.end(), [](const GsiWord& w) {
    return w.index == 21 || w.index == 22 || w.index == 31 || w.index == 32 || w.index == 33;
  });
  if (plan_.continued.contains(number) && builder_.current_set_up() >= 0) return continue_station(block);
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
    const auto other = plan_.renamed.find(number);
    if (other != plan_.renamed.end() && renamed_++ == 0)
      first_renamed_ = "'" + *id + "' in line " + std::to_string(line_);
    const std::string target = other == plan_.renamed.end() ? *id : other->second;
    const auto offset = plan_.offsets.find(number);
    read_sighting(block, offset == plan_.offsets.end() ? target : sighted_beside(target, offset->second));
  } else {
    give_coordinates(*id, block, 81);
    describe_point(block, *id);
  }
}

// Words 81 to 83 hold the point that was meant, 21, 22 and 31 the reading to a target beside it.
std::string GsiReader::sighted_beside(const std::string& id, const Eigen::Vector3d& offset) {
  const std::string name = id + " (sighted)";
  std::string by;
  for (int axis = 0; axis < 3; ++axis)
    if (std::abs(offset[axis]) > 5e-4)
      by += std::string(by.empty() ? "" : ", ") + "ENH"[axis] + " " + (offset[axis] > 0 ? "+" : "") +
            text::format_fixed(offset[axis], 3);
  builder_.warn("line " + std::to_string(line_) + ": the coordinates of " + text::quoted(id) +
                " are not those of what was sighted but lie beside it (" + by +
                " m): an offset was keyed, or its coordinates. What was sighted is a point of its own here, " +
                text::quoted(name) + "; add the offset to it");
  return name;
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
  if (const GsiWord* word = block.find(13)) builder_.use_instrument(std::string(word->text()));
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

// The block of a station whose targets were measured before it: the same set-up, with the circle turned.
void GsiReader::continue_station(const GsiBlock& block) {
  turn_ = 0;
  station_coordinates_ = coordinates(block, 84);
  const SetUp& set_up = builder_.survey.set_ups[builder_.current_set_up()];
  give_coordinates(set_up.station, block, 84);
}

void GsiReader::start_station(const std::optional<std::string>& station, double height, const SourcePosition& source) {
  turn_ = 0;
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
  SetUp& set_up = builder_.survey.set_ups[builder_.current_set_up()];
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
    other_codes_.insert(text);
    return;
  }
  const GsiWord* station = block.find(rule->station_word);
  if (!station || !station->complete())
    return lose_station(block, station ? *station : code,
                        "the station's name in word " + std::to_string(rule->station_word));
  double height = kNotGiven;
  if (const GsiWord* word = block.find(rule->height_word)) {
    const auto value = word->complete() ? text::parse_number(word->text()) : std::nullopt;
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
    const bool same_name =
        named && current >= 0 && !lost_station_ && builder_.survey.set_ups[current].station == station_word->text();
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
  const std::string station = builder_.survey.set_ups[builder_.current_set_up()].station;
  if (has_measurement)
    builder_.give_coordinates(station, here, source);
  else
    give_coordinates(station, block, 84);
  return true;
}

SurveyObservations read_gsi(std::string_view bytes, const std::string& file, const GsiOptions& options) {
  return GsiReader(bytes, file, options).read();
}

}  // namespace plumbline::survey
