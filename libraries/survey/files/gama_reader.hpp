// Parts of gama_reader.cpp: one run over a gama-local file. Clusters of observations are read in gama_clusters.cpp.
#pragma once

#include <Eigen/Core>
#include <initializer_list>
#include <numbers>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "survey/files/survey_builder.hpp"
#include "survey/files/xml_file.hpp"

namespace plumbline::survey {

namespace gama {

inline constexpr double kGon = std::numbers::pi / 200;
inline constexpr double kCc = kGon * 1e-4;
inline constexpr double kArcsecond = std::numbers::pi / 180 / 3600;
inline constexpr double kMillimetre = 1e-3;

/// One observation while its cluster is read: the unit of its standard deviation decides how the cov-mat is scaled.
struct ClusterItem {
  int observation = -1;
  double sigma_unit = kMillimetre;
  double sense = 1;  // -1: the sign of the value was changed
};

/// A gama-g3 network (root gnu-gama-data), whose E and N are of a map of its own.
SurveyObservations read_g3(const text::XmlFile& xml, const std::string& file);

class GamaReader {
 public:
  GamaReader(std::string_view bytes, const std::string& file)
      : xml_(bytes, file, {"obs", "point", "height-differences", "coordinates", "vectors"}),
        builder_(file, "gama-xml"),
        file_(file) {}

  SurveyObservations read();

 private:
  void skip(pugi::xml_node node, const std::string& found, const std::string& expected);
  /// What gama-local does not define would change nothing where it is read, and the file is meant otherwise.
  void skip_unknown_attributes();
  void read_network(pugi::xml_node network);
  void read_parameters(pugi::xml_node node);

  /// A number of an attribute; `fallback` where it is missing, and where it is no number (which is listed).
  double number(pugi::xml_node node, const char* name, double fallback);
  void read_block(pugi::xml_node block);
  Eigen::Vector2d to_frame(double x, double y) const { return axes_ * Eigen::Vector2d(x, y); }

  void read_point(pugi::xml_node node);
  void set_role(Point& point, char axis, CoordinateRole role, pugi::xml_node node);

  /// Value of an angle [rad] and the unit of its standard deviation [rad].
  bool read_angle(pugi::xml_node node, double& value, double& unit);
  bool read_length(pugi::xml_node node, double& value);

  /// a + b D^c mm with D in km; b and c default to 0 and 1.
  double default_distance_sigma(double length) const;
  void read_observations(pugi::xml_node cluster);
  ClusterItem read_observation(pugi::xml_node node, const std::string& cluster_from, int set_up);

  /// Value and standard deviation by kind, then into the survey.
  ClusterItem add(pugi::xml_node node, Observation o);

  /// Points that no <point> declares are not part of the network.
  void ensure_points(std::initializer_list<std::string> ids, const SourcePosition& source);

  /// Upper band by rows, as the file writes it, n x n in its own units; empty if absent or wrong.
  Eigen::MatrixXd read_covariance(pugi::xml_node cluster, int size);

  /// Covariances replace standard deviations; what then has none is not usable and leaves the survey.
  void finish_cluster(pugi::xml_node cluster, const std::vector<ClusterItem>& items);
  void read_height_differences(pugi::xml_node cluster);
  void read_coordinates(pugi::xml_node cluster);
  void read_vectors(pugi::xml_node cluster);
  void check_fixed_points(const SurveyObservations& survey) const;

  text::XmlFile xml_;
  SurveyBuilder builder_;
  std::string file_;
  Eigen::Matrix2d axes_ = Eigen::Matrix2d::Identity();  // E, N of the file's x and y
  double sense_ = 1;
  double direction_sigma_ = kNotGiven, angle_sigma_ = kNotGiven, zenith_sigma_ = kNotGiven, azimuth_sigma_ = kNotGiven;
  std::vector<double> distance_model_;
  std::set<std::string> with_role_, declared_;
};

}  // namespace gama

}  // namespace plumbline::survey
