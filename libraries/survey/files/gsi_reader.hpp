// The reader of gsi_reader.cpp, whose sightings and words are in gsi_sightings.cpp and level readings in
// gsi_levels.cpp.
#pragma once

#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "base/text/text.hpp"
#include "survey/files/gsi.hpp"
#include "survey/files/gsi_stations.hpp"
#include "survey/files/gsi_words.hpp"
#include "survey/files/levelling.hpp"
#include "survey/files/survey_builder.hpp"

namespace plumbline::survey {

class GsiReader {
 public:
  GsiReader(std::string_view bytes, const std::string& file, const GsiOptions& options)
      : decoded_(text::decode_text(bytes)), builder_(file, "gsi"), options_(options) {}

  SurveyObservations read();

 private:
  void read_block(const GsiBlock& block, std::size_t number);
  void begin_planned(const GsiBlock& block, std::size_t number);
  bool read_level_block(const GsiBlock& block);
  void read_staff(const GsiBlock& block, const GsiWord& word);
  void add_stored_difference(const std::string& id, double height, const GsiBlock& block);
  void read_code_block(const GsiBlock& block);
  void read_heights(const GsiBlock& block);
  void read_info(const GsiBlock& block);
  bool starts_station(const GsiBlock& block, bool has_measurement);
  void start_station(const std::optional<std::string>& station, double height, const SourcePosition& source);
  void continue_station(const GsiBlock& block);
  void settle_instrument_height(Sighting& sighting);
  void lose_station(const GsiBlock& block, const GsiWord& word, const std::string& expected);
  bool passes_cut_line(const GsiBlock& block, bool has_measurement);
  void read_sighting(const GsiBlock& block, const std::string& target);
  std::string sighted_beside(const std::string& id, const Eigen::Vector3d& offset);
  void read_zenith_angle(const GsiWord& word, Sighting& sighting);
  void describe_point(const GsiBlock& block, const std::string& id);
  void warn_of_vertical_reference();

  std::optional<std::string> name(const GsiWord* word);
  std::optional<double> angle(const GsiWord* word);
  std::optional<double> length(const GsiWord* word);
  Eigen::Vector3d coordinates(const GsiBlock& block, int east);
  /// The coordinates in words `east` to `east` + 2, as known where they were keyed in.
  void give_coordinates(const std::string& id, const GsiBlock& block, int east);
  void reject(const GsiWord& word, const std::string& expected) {
    builder_.skip(line_, word.column, word.whole, expected);
  }

  text::DecodedText decoded_;
  SurveyBuilder builder_;
  const GsiOptions& options_;
  GsiStations plan_;
  LevelRun level_{builder_};
  bool is_level_ = false;
  struct LineHeight {  // that the level wrote last in its line [m]
    std::string id;
    double height = 0, distance = 0;
    bool has_readings = false;  // the line has staff readings
  } line_height_;
  int line_ = 0;
  double instrument_height_ = kNotGiven, target_height_ = kNotGiven;
  bool height_is_of_set_up_ = false;  // given at the start of the current set-up or since
  std::size_t observations_at_start_ = 0;
  bool lost_station_ = false;
  double turn_ = 0;  // [rad], of the circle, which the block of this station tells only behind its targets
  Eigen::Vector3d station_coordinates_ = Eigen::Vector3d::Constant(kNotGiven);
  std::size_t renamed_ = 0;
  std::string first_renamed_;
  std::set<std::string> other_codes_;
  std::vector<int> words_of_sighting_;  // of the last one that was not cut off
};

}  // namespace plumbline::survey
