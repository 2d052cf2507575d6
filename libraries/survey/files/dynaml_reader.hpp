// Part of dynaml_reader.cpp and dynaml_clusters.cpp.
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <string>
#include <vector>

#include "survey/files/geodetic_frame.hpp"
#include "survey/files/survey_builder.hpp"
#include "survey/files/xml_file.hpp"

namespace plumbline::survey {

/// What DynAdjust calls a type of measurement: "a GNSS baseline (G)".
std::string name_of_dynaml_type(const std::string& type);

class DynaMlReader {
 public:
  DynaMlReader(std::string_view bytes, const std::string& file)
      : xml_(bytes, file, {"DnaStation", "DnaMeasurement"}), builder_(file, "dynaml") {}

  SurveyObservations read();

 private:
  struct Station {
    std::string name, constraints;
    Geodetic place;
    pugi::xml_node node;
  };

  void read_station(pugi::xml_node node);
  std::optional<Geodetic> place_of(pugi::xml_node coordinates, const std::string& type);
  void place_stations();
  void hold(const Station& station);
  void read_measurement(pugi::xml_node node);
  void read_single(pugi::xml_node node, ObservationKind kind, bool vertical_angle);
  void read_directions(pugi::xml_node node);
  void read_direction(pugi::xml_node node, const std::string& from, const std::string& to, int set_up);
  void read_height(pugi::xml_node node);
  void read_baselines(pugi::xml_node node, const std::string& type);
  void read_points(pugi::xml_node node);
  bool read_covariance(pugi::xml_node block, const char* const (&names)[3][3], Eigen::Ref<Eigen::MatrixXd> c);
  /// Covariance of the blocks `parts` of a cluster, those behind each in its elements `between`: 3 n x 3 n [m^2]; empty
  /// where something is wrong with it, which is told.
  Eigen::MatrixXd covariance_of(pugi::xml_node cluster, const std::vector<pugi::xml_node>& parts, const char* between);
  /// Vscale, Pscale, Lscale, Hscale; Pscale and Lscale are one.
  std::optional<std::array<double, 4>> scales_of(pugi::xml_node cluster);
  bool read_axes(pugi::xml_node part, const char* expected, Eigen::Ref<Eigen::VectorXd> values);
  std::optional<double> number(pugi::xml_node parent, const char* name, const char* expected);
  std::optional<double> angle(pugi::xml_node parent, const char* name);
  /// [rad] or [m]; above zero.
  std::optional<double> sigma(pugi::xml_node parent, bool angular);
  bool is_ignored(pugi::xml_node node) { return !text::child_text(node, "Ignore").empty(); }
  void reject(pugi::xml_node node, const std::string& found, const std::string& expected) {
    const SourcePosition at = xml_.position(node);
    builder_.skip(at.line, at.column, found, expected);
  }

  text::XmlFile xml_;
  SurveyBuilder builder_;
  std::vector<Station> stations_;
  std::optional<GroundPlane> plane_;  ///< that the stations lie in
  bool has_point_clusters_ = false;
  std::size_t ignored_ = 0;
  int pointings_ = 0;
};

}  // namespace plumbline::survey
