// What StarNetReader has read so far, line by line; starnet_reader.cpp reads options and coordinates,
// starnet_measurements.cpp what was measured.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "base/text/text.hpp"
#include "survey/files/survey_builder.hpp"

namespace plumbline::survey {

bool is_angle_kind(ObservationKind kind);  ///< measured by a circle

class StarNetReader {
 public:
  using Parts = std::vector<std::string_view>;

  StarNetReader(std::string_view bytes, const std::string& file)
      : decoded_(text::decode_text(bytes)), builder_(file, "starnet") {}
  SurveyObservations read();

 private:
  void read_line(std::string_view text);
  void read_option(const Parts& parts);
  void read_units(const std::vector<std::string>& words);
  void read_coordinates(const Parts& parts);
  void read_elevation(const Parts& parts);
  std::optional<std::size_t> coordinates_of(const Parts& parts);  ///< how many of C's numbers are coordinates
  void add_control(const std::string& id, const std::vector<int>& axes, const Eigen::VectorXd& values,
                   const std::vector<double>& sigmas);  ///< [m], independent
  /// Whether the line has no more than `most` words; otherwise the first of the others is refused.
  bool ends_at(const Parts& parts, std::size_t most, const char* has);
  void read_measured(std::string_view code, const Parts& parts);
  void read_direction(std::string_view code, const Parts& parts);
  void read_traverse(std::string_view code, const Parts& parts);
  void read_levelled(const Parts& parts);
  void read_level_weight(const Parts& parts);
  void leave_out_side_shots();
  void read_gps_option(const Parts& parts);
  void read_vector(std::string_view code, const Parts& parts);
  void finish_vector();
  bool names(std::string_view joined, std::size_t count, std::vector<std::string>& out);
  /// Values of `kinds`, their standard deviations, HI/HT; each becomes an observation like `like`.
  void take(const Parts& parts, std::size_t first, const std::vector<ObservationKind>& kinds, Observation like);
  std::vector<ObservationKind> polar() const;
  std::optional<double> angle(std::string_view text) const;
  std::optional<double> bearing(std::string_view text) const;
  std::optional<double> value_of(std::string_view text, ObservationKind kind) const;
  std::optional<double> sigma_of(std::string_view text, ObservationKind kind) const;
  void reject(std::string_view found, const std::string& expected) { builder_.skip(line_, 1, found, expected); }

  text::DecodedText decoded_;
  SurveyBuilder builder_;
  int line_ = 0;
  double metres_ = 1;
  int instrument_ = -1;                // of .INST
  std::set<int> side_shots_;           // lines of SS
  std::optional<VectorGroup> vector_;  // whose G2 and G3 may follow
  bool gps_correlations_ = false;      // G2 and G3 are standard deviations and correlations, not variances
  double gps_horizontal_ = 1, gps_vertical_ = 1;
  bool add_centring_ = false;        // .ADDCENTERING ON, to standard deviations that are written
  double level_weight_ = kNotGiven;  // .LWEIGHT, of a line of 1 km [m]
  enum class AngleUnit { dms, gon, degrees } unit_ = AngleUnit::dms;
  bool east_first_ = false, has_order_ = false, from_at_to_ = false, three_ = true, has_dimension_ = false,
       delta_ = false;
  std::string set_at_;          // station of the direction set
  std::string at_, backsight_;  // of the traverse
  Observation pending_like_;    // of the traverse line that waits for its foresight
  std::string pending_, line_text_;
  char separator_ = '-';                 // between the names of stations
  std::size_t records_ = 0, freed_ = 0;  ///< lines; values that '*' frees
  int off_since_ = 0;                    // line of .DATA OFF; 0: on
  bool used_order_ = false, used_angles_ = false, has_units_ = false;
};

}  // namespace plumbline::survey
