// Adjustment of a survey network: from readings to coordinates with full covariance, tests, and words about what is
// wrong.
#pragma once

#include <map>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "adjustment/reliability.hpp"
#include "survey/model/instrument_profile.hpp"
#include "survey/model/station_reduction.hpp"
#include "survey/model/survey_observations.hpp"

namespace plumbline::survey {

enum class DatumMode {
  automatic,  ///< weighted if control has a covariance, fixed if it has none, as the file says if it says something,
              ///< else inner
  file,       ///< roles of the points in the file
  fixed,      ///< control points (or `datum_points` with their coordinates in the file) held
  weighted,   ///< control coordinates are observations with their covariance
  inner       ///< free network: inner constraints on `datum_points`, or on all points
};

enum class Switch { automatic, off, on };

struct AdjustOptions {
  InstrumentProfile profile;
  DatumMode datum = DatumMode::automatic;
  std::vector<std::string> datum_points;  ///< empty: all that qualify
  double alpha = 0.05;                    ///< global test
  double alpha0 = 0.001;                  ///< w-tests
  double power = 0.80;                    ///< for MDBs
  bool remove_blunders = false;           ///< data snooping takes observations out; otherwise it only flags
  double largest_removed_share = 0.10;
  bool robust_start = false;  ///< Huber weights find the start of data snooping
  bool estimate_variance_components = false;
  Switch scale_with_sigma0 = Switch::automatic;  ///< automatic: as the file asks
  Switch curvature =
      Switch::automatic;  ///< earth curvature and refraction; automatic: not for files of reduced observations
  double refraction_coefficient = 0.13;
  // Optional unknowns; a sigma of 0 leaves them out. Priors are 0 (refraction: refraction_coefficient).
  double scale_sigma = 0;              ///< [1], e.g. 10e-6
  double additive_constant_sigma = 0;  ///< [m]
  double refraction_sigma = 0;         ///< [1], e.g. 0.15
  double vertical_index_sigma = 0;     ///< [rad], one for all set-ups
  double tilt_sigma = 0;               ///< [rad], two per set-up
  double instrument_height_sigma = 0;  ///< [m], one per set-up
};

/// Points known beforehand.
struct ControlPoints {
  std::vector<std::string> ids;
  Eigen::VectorXd coordinates;  ///< 3n: E, N, H of each [m]
  Eigen::MatrixXd covariance;   ///< 3n x 3n [m^2]; 0 x 0: without error
};

struct Finding {
  enum class Severity { note, warning, error } severity = Severity::note;
  std::string text;
  std::vector<std::string> points;
};

/// The network cannot be adjusted; what() says why in words, `findings` in detail.
class NetworkError : public std::runtime_error {
 public:
  explicit NetworkError(const std::string& message, std::vector<Finding> what_was_found = {})
      : std::runtime_error(message), findings(std::move(what_was_found)) {}
  std::vector<Finding> findings;
};

/// One scalar of the adjustment: a mean observation, or a component of observed coordinates, vectors, local
/// coordinates, priors.
struct ResultRow {
  std::string kind, set_up, from, to, detail;
  double value = 0;
  adjustment::RowStatistics statistics;
  int group = 0;
  bool removed = false, flagged = false, removable = false;
  int sets = 1;
  SourcePosition source;
  std::vector<std::string> corrections;
  std::string external_point;
};

struct ResultPoint {
  std::string id;
  Eigen::Vector3d position;                    ///< NaN: component does not exist
  std::array<int, 3> unknowns = {-1, -1, -1};  ///< into `cofactors`
  std::array<CoordinateRole, 3> roles = {};
};

struct ResultSetUp {
  std::string id, station;
  double orientation = kNotGiven, orientation_sigma = kNotGiven;  ///< [rad]
  double instrument_height_correction = kNotGiven;                ///< [m]
};

struct ResultParameter {
  std::string name;
  double value = 0, sigma = 0;
};

struct ResultPointing {
  std::string set_up, to;
  adjustment::BlockTest test;
  double critical = 0;
  bool flagged = false;
};

struct ResultGroup {
  std::string name;
  double applied_factor = 1;  ///< on the standard deviations
  adjustment::VarianceComponent component;
};

struct SnoopingAction {
  int row = 0;
  bool restored = false;
  double w = 0, estimated_blunder = 0;
  double sum_of_squares = 0;  ///< after the action
  int degrees_of_freedom = 0;
};

struct NetworkResult {
  std::vector<ResultPoint> points;
  std::vector<ResultSetUp> set_ups;
  std::vector<ResultRow> rows;
  std::vector<ResultParameter> parameters;
  std::vector<ResultPointing> pointings;
  std::vector<ResultGroup> groups;
  std::vector<SnoopingAction> snooping;
  std::vector<Finding> findings;
  DatumMode datum = DatumMode::automatic;  ///< as used
  std::vector<std::string> datum_points;
  Eigen::MatrixXd cofactors;  ///< of all unknowns, already multiplied by variance_factor
  double variance_factor = 1;
  Eigen::MatrixXd null_space;  ///< of the network without datum (unknowns x defect)
  int observations = 0, unknowns = 0, defect = 0, degrees_of_freedom = 0, iterations = 0;
  double sum_of_squares = 0;  ///< v' P v
  double sigma0 = 1;          ///< a posteriori, of unit weight
  double sum_of_redundancy_numbers = 0;
  adjustment::GlobalTest global_test;
  double critical_w = 0, critical_tau = 0;

  const ResultPoint& point(const std::string& id) const;  ///< throws std::out_of_range
  /// Covariance of the coordinates of two points [m^2]; zero for constant components, NaN for those that do not exist.
  Eigen::Matrix3d covariance(const ResultPoint& a, const ResultPoint& b) const;
  Eigen::Vector3d sigma(const ResultPoint& p) const { return covariance(p, p).diagonal().cwiseSqrt(); }
  /// Covariance of b - a: what two markers are known relative to each other.
  Eigen::Matrix3d relative_covariance(const ResultPoint& a, const ResultPoint& b) const;
  /// 3n x 3n in the order of `points`.
  Eigen::MatrixXd full_covariance() const;
};

/// Several files of one campaign as one network: set-ups and pointings renumbered, points of the same name united.
SurveyObservations merge_surveys(const std::vector<SurveyObservations>& surveys);

/// Throws NetworkError: no observations, undetermined coordinates, rank defect (named), no convergence.
NetworkResult adjust_network(const SurveyObservations& survey, const AdjustOptions& options,
                             const ControlPoints& control = {});

}  // namespace plumbline::survey
