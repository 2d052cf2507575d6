// The reader of Krumm's files, section by section; private to survey_files/krumm*.cpp.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/text/text.hpp"
#include "survey/files/geodetic_frame.hpp"
#include "survey/files/krumm.hpp"
#include "survey/files/krumm_sections.hpp"
#include "survey/files/survey_builder.hpp"

namespace plumbline::survey {

class KrummReader {
 public:
  KrummReader(std::string_view bytes, const std::string& file)
      : decoded_(text::decode_text(bytes)), builder_(file, "krumm") {}
  SurveyObservations read();

 private:
  using Parts = std::vector<std::string_view>;  // of a line, between blanks

  void read_heading(std::string_view text);
  void read_line(std::string_view text);
  void read_coordinates(const Parts& parts);
  void read_ellipsoid(const Parts& parts);
  void read_geodetic(const Parts& parts);
  void add_point(std::string_view name, const Eigen::Vector3d& at);
  void read_datum(const Parts& parts);
  std::optional<std::pair<std::string, int>> component(std::string_view word);
  void read_observation(const Parts& parts);
  bool read_rest(const Parts& parts, std::size_t first, Observation& observation);
  /// Of what a line gives, or the lines above it; NaN for an angle without.
  double sigma_from(double constant, double second, const Observation& observation) const;
  void read_levelling(const Parts& parts);
  void read_correlated(const Parts& parts);
  void read_baseline(const Parts& parts);
  void read_restriction(std::string_view text);
  void read_sigma0(const Parts& parts);
  void place(Observation observation);
  void finish_dynamic_datum();
  void finish_correlated();
  void orient_by_marks();
  std::optional<double> value_of(std::string_view word, ObservationKind kind) const;
  std::optional<double> sigma_of(std::string_view word, ObservationKind kind) const;
  std::vector<double> numbers(const Parts& parts, std::size_t first);
  void reject(std::string_view found, const std::string& expected) {
    const std::size_t place = line_text_.find(found);
    builder_.skip(line_, place == std::string_view::npos ? 1 : static_cast<int>(place) + 1, found, expected);
  }
  static bool is_angle(ObservationKind kind) {
    return kind == ObservationKind::direction || kind == ObservationKind::angle || kind == ObservationKind::azimuth ||
           kind == ObservationKind::zenith_angle;
  }

  struct DynamicRow {
    std::string point;
    int axis = 2;
    std::vector<double> values;
    SourcePosition source;
  };

  text::DecodedText decoded_;
  SurveyBuilder builder_;
  KrummSection section_;
  bool in_section_ = false;
  std::string comment_;  // the block of comments above
  KrummDistanceSigma distance_sigma_ = KrummDistanceSigma::squares;
  std::string_view line_text_;
  int line_ = 0;
  CoordinateRole datum_role_ = CoordinateRole::fixed;
  bool dynamic_ = false;
  std::vector<DynamicRow> dynamic_rows_;
  std::optional<TransverseMercator> plane_;  // of [Ellipsoid]
  double sigma0_ = kNotGiven;
  double first_sigma_ = kNotGiven, second_sigma_ = 0;  // that hold until others are given
  std::map<std::string, int> set_ups_;
  std::vector<int> correlated_;
  std::vector<std::vector<double>> correlated_rows_;
};

}  // namespace plumbline::survey
