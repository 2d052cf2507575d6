// The half of a survey reader that no format differs in: set-ups with unique names, points made when first seen,
// pointings and sets counted, what could not be used listed (with a cap, so that a gigabyte of garbage gives a page of
// messages), and the verdict at the end whether the file gave anything.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <unordered_set>

#include "survey/model/survey_observations.hpp"

namespace plumbline::survey {

/// One sentence that lists the formats the project reads, for the errors of files that are none of them.
std::string understood_formats();

/// International foot and US survey foot [m].
inline constexpr double kFoot = 0.3048;
inline constexpr double kUsSurveyFoot = 1200.0 / 3937.0;

double gon_to_rad(double gon);
double degrees_to_rad(double degrees);
/// `angle` [rad] in [0, 2 pi).
double wrap_to_circle(double angle);
/// 1 for a zenith angle [rad] in [0, pi], 2 in (pi, 2 pi).
int face_of_zenith_angle(double zenith_angle);
/// Degrees, minutes and seconds packed as DDD.MMSSs -> [rad]; nullopt when minutes or seconds reach 60.
std::optional<double> packed_degrees_to_rad(double packed);

/// One sighting in the units of the structs; NaN where not measured.
struct Sighting {
  std::string to;
  double direction = kNotGiven;
  double zenith_angle = kNotGiven;
  double slope_distance = kNotGiven;
  double horizontal_distance = kNotGiven;
  double height_difference = kNotGiven;
  double target_height = kNotGiven;
  double instrument_height = kNotGiven;  ///< only where it differs from the set-up's
  int face = 0;                          ///< 0: taken from the zenith angle
  SourcePosition source;
  std::vector<std::string> direction_corrections, zenith_corrections, distance_corrections;
};

class SurveyBuilder {
 public:
  SurveyBuilder(std::string file, std::string format);

  SurveyObservations survey;

  SourcePosition at(int line, int column = 0) const { return {file_, line, column}; }

  /// Records text that could not be used. After 200 entries only the count goes on.
  void skip(int line, int column, std::string_view found, const std::string& expected);
  /// A warning about the file as a whole; the same text is kept once.
  void warn(const std::string& text);

  /// Begins a set-up on `station`; observations that follow belong to it. Its id is the station's name, with "/2", "/3"
  /// for further occupations. Returns its index.
  int start_set_up(const std::string& station, double instrument_height, const SourcePosition& source);
  /// Index of the set-up that observations go to now, -1 before the first.
  int current_set_up() const { return current_; }
  void select_set_up(int index) { current_ = index; }
  /// Begins a set-up on a station whose name the file does not give ("free-station-1", ...), with a warning.
  int start_unnamed_set_up(double instrument_height, const SourcePosition& source);

  /// The point `id`, made when it is new.
  Point& point(const std::string& id, const SourcePosition& source);
  /// Says that coordinates of `id` which are finite here were keyed in as known, unless they differ from the ones kept.
  void know_coordinates(const std::string& id, const Eigen::Vector3d& coordinates, const SourcePosition& source);
  /// `id` was computed from readings of this file: whatever says so afterwards, it is not known.
  void compute_coordinates(const std::string& id);
  bool has_point(const std::string& id) const { return points_.contains(id); }
  /// Gives `id` coordinates E, N, H (NaN: none). The first ones stay; others more than 1 cm away are warned of.
  void give_coordinates(const std::string& id, const Eigen::Vector3d& coordinates, const SourcePosition& source);

  /// Index of the instrument called so, made when it is new.
  int instrument(const std::string& name);
  /// Observations that follow are of the instrument called so. As long as a file names one alone it is that of the file
  /// (NetworkInfo::instrument); with a second, observations say which is theirs.
  void use_instrument(const std::string& name);

  /// Adds what `sighting` has, as observations of one pointing from the current set-up. A distance of zero is none.
  /// Returns false when there is nothing in it.
  bool add(const Sighting& sighting);
  void add(Observation observation);

  /// The file's observations; throws SurveyReadError when there are neither observations nor coordinates, with what the
  /// first skipped text was, or `found_nothing` if nothing was skipped.
  SurveyObservations finish(const std::string& found_nothing, const std::string& expected);

 private:
  void number_sets();
  void drop_empty_set_ups();
  void distrust_zero_heights();
  void add_kind(const Sighting& sighting, ObservationKind kind, double value, int face,
                const std::vector<std::string>& corrections);

  std::string file_;
  int current_ = -1;
  int pointings_ = 0;
  int unnamed_ = 0;
  int instrument_ = -1;  // of use_instrument() where the file names several
  std::size_t skipped_beyond_cap_ = 0;
  std::unordered_map<std::string, std::size_t> points_;
  std::unordered_map<std::string, int> occupations_;
  std::unordered_set<std::string> set_up_ids_, warnings_, computed_;
};

}  // namespace plumbline::survey
