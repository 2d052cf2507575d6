// Adjustment of a survey network: from readings to coordinates with full covariance, tests, and words about what is
// wrong.
#pragma once

#include <map>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "least_squares/problem/reliability.hpp"
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

/// What the user wants left out, and why; printed with the result.
struct ExcludedItem {
  enum class Kind { point, set_up, line } kind = Kind::point;
  std::string what;  ///< name of the point or set-up; "file:line" or "line" of a reading
  std::string reason;
};
/// "point A7: knocked over", "set-up S3: on a moving slab", "line job.gsi:57: read twice". Throws std::invalid_argument
/// that says what was expected.
ExcludedItem parse_exclusion(const std::string& text);

inline constexpr const char* kPlane = "plane";

struct AdjustOptions {
  InstrumentProfile profile;
  std::map<std::string, InstrumentProfile> instruments;  ///< by the name that the survey has for them; else `profile`
  /// An instrument stands beside its mark by one amount in a set-up: an unknown of the set-up with the centring of the
  /// profile as its prior. false: part of each reading by itself, as STAR*NET has it in direction sets.
  bool centring_per_set_up = true;
  DatumMode datum = DatumMode::automatic;
  std::vector<std::string> datum_points;  ///< empty: all that qualify
  double alpha = 0.05;                    ///< global test
  double alpha0 = 0.001;                  ///< w-tests
  double power = 0.80;                    ///< for MDBs
  /// Mistakes are mended: wrong readings are taken out, errors that a set-up has in common estimated, units and turned
  /// circles put right. Otherwise they are only named.
  bool remove_blunders = false;
  double removal_alpha = 0.003;  ///< chance that a sound network loses a reading, over all its tests (Sidak)
  double largest_removed_share = 0.10;
  bool robust_start =
      false;  ///< Huber weights find the start of data snooping; else only where it ends unclean without
  std::vector<ExcludedItem> exclude;
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
  /// Map of E and N ("EPSG:25832", "utm:32"); empty: a plane of its own in which lengths are true; kPlane: likewise,
  /// and coordinates that look like those of a map are none.
  std::string map;
  double geoid_height = 0;    ///< of the geoid above the map's ellipsoid [m]
  double known_sigma = 1e-4;  ///< [m], each coordinate of points that were keyed in as known, where nothing states it
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
/// A point that was known before, and where the readings and the other known points put it.
struct KnownPoint {
  std::string id;
  Eigen::Vector3d difference = Eigen::Vector3d::Zero();          ///< as measured minus as known [m]; 0: nobody can tell
  Eigen::Vector3d sigma = Eigen::Vector3d::Constant(kNotGiven);  ///< of the known coordinates [m]; NaN: not known
  double statistic = 0, critical = 0;                            ///< of the difference, chi-squared with `rank`
  int rank = 0;                                                  ///< independent conditions
  bool stands() const { return rank == 0 || statistic <= critical; }
};

class NetworkError : public std::runtime_error {
 public:
  explicit NetworkError(const std::string& message, std::vector<Finding> what_was_found = {},
                        std::vector<std::string> points = {})
      : std::runtime_error(message), findings(std::move(what_was_found)), undetermined(std::move(points)) {}
  std::vector<Finding> findings;
  std::vector<std::string> undetermined;  ///< points without which the rest might be adjusted; may be empty
};

/// One scalar of the adjustment: a mean observation, or a component of observed coordinates, vectors, local
/// coordinates, priors.
struct ResultRow {
  std::string kind, set_up, from, to, detail;
  double value = 0;
  least_squares::RowStatistics statistics;
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

/// An error that the readings of a set-up may have in common, as the network would estimate it.
struct CommonEstimate {
  double value = kNotGiven, sigma = kNotGiven;  ///< NaN: the network cannot tell it from its unknowns
};

struct ResultSetUp {
  std::string id, station;
  double orientation = kNotGiven, orientation_sigma = kNotGiven;  ///< [rad]
  double instrument_height = kNotGiven;                           ///< as noted [m]
  double instrument_height_correction = kNotGiven;                ///< [m]; NaN: not estimated, or it cannot be
  Eigen::Vector2d tilt = Eigen::Vector2d::Constant(kNotGiven);    ///< about E and N [rad]; NaN likewise
  CommonEstimate collimation;                                     ///< by its readings in two faces [rad]
  CommonEstimate index;                                           ///< of the zenith angles [rad]
  CommonEstimate constant;                                        ///< of the distances [m]
  CommonEstimate scale;                                           ///< of the distances [1]
};

struct ResultParameter {
  std::string name;
  double value = 0, sigma = 0;
};

struct ResultPointing {
  std::string set_up, to;
  least_squares::BlockTest test;
  double critical = 0;
  bool flagged = false;
};

struct ResultGroup {
  std::string name;
  double applied_factor = 1;  ///< on the standard deviations
  least_squares::VarianceComponent component;
};

struct SnoopingAction {
  int row = 0;
  bool restored = false;
  double w = 0, estimated_blunder = 0;
  double sum_of_squares = 0;  ///< after the action
  int degrees_of_freedom = 0;
};

/// Whether the coordinates may be used.
enum class Validity {
  sound,     ///< every test passes, or nothing can be tested
  doubtful,  ///< tests fail; the coordinates are those of the readings as they are
  invalid    ///< mistakes are left that bend the network: its coordinates and ellipses are not a result
};

struct NetworkResult {
  Validity validity = Validity::sound;
  std::string verdict;                ///< one sentence: may it be used, and why not
  std::vector<std::string> left_out;  ///< points that the observations do not determine
  std::vector<ResultPoint> points;
  std::vector<ResultSetUp> set_ups;
  std::vector<ResultRow> rows;
  std::vector<ResultParameter> parameters;
  std::vector<ResultPointing> pointings;
  std::vector<ResultGroup> groups;
  std::vector<SnoopingAction> snooping;
  std::vector<Finding> findings;
  std::vector<KnownPoint> known_points;    ///< control with a standard deviation, largest difference first
  DatumMode datum = DatumMode::automatic;  ///< as used
  std::vector<std::string> datum_points;
  std::string frame;          ///< the map and its scale in words; empty: a plane in which lengths are true
  Eigen::MatrixXd cofactors;  ///< of all unknowns, already multiplied by variance_factor
  double variance_factor = 1;
  Eigen::MatrixXd null_space;  ///< of the network without datum (unknowns x defect)
  int observations = 0, unknowns = 0, defect = 0, degrees_of_freedom = 0, iterations = 0;
  double sum_of_squares = 0;  ///< v' P v
  double sigma0 = 1;          ///< a posteriori, of unit weight
  double sum_of_redundancy_numbers = 0;
  least_squares::GlobalTest global_test;
  double critical_w = 0, critical_tau = 0;

  /// Something measured says of a known point where it is: the first finding then tells of all of them.
  bool compares_known_points() const;
  const ResultPoint& point(const std::string& id) const;  ///< throws std::out_of_range
  /// Covariance of the coordinates of two points [m^2]; zero for constant components, NaN for those that do not exist.
  Eigen::Matrix3d covariance(const ResultPoint& a, const ResultPoint& b) const;
  Eigen::Vector3d sigma(const ResultPoint& p) const { return covariance(p, p).diagonal().cwiseSqrt(); }
  /// Covariance of b - a: what two markers are known relative to each other.
  Eigen::Matrix3d relative_covariance(const ResultPoint& a, const ResultPoint& b) const;
  /// 3n x 3n in the order of `points`.
  Eigen::MatrixXd full_covariance() const;
};

/// Throws NetworkError: no observations, undetermined coordinates, rank defect (named), no convergence.
NetworkResult adjust_network(const SurveyObservations& survey, const AdjustOptions& options,
                             const ControlPoints& control = {});

class KeptNetwork;  // kept_network.hpp
/// The same, and the adjusted network itself, for who goes on from there.
NetworkResult adjust_network(const SurveyObservations& survey, const AdjustOptions& options,
                             const ControlPoints& control, std::unique_ptr<KeptNetwork>& kept);

}  // namespace plumbline::survey
