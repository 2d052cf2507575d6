// What an adjustment of a survey network comes to: coordinates with their covariances, tests, and words about what is
// wrong.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "least_squares/problem/reliability.hpp"
#include "survey/model/adjust_options.hpp"

namespace plumbline::survey {

/// A point that was known before, and where the readings and the other known points put it.
struct KnownPoint {
  std::string id;
  Eigen::Vector3d difference = Eigen::Vector3d::Zero();          ///< as measured minus as known [m]; 0: nobody can tell
  Eigen::Vector3d sigma = Eigen::Vector3d::Constant(kNotGiven);  ///< of the known coordinates [m]; NaN: not known
  double statistic = 0, critical = 0;                            ///< of the difference, chi-squared with `rank`
  /// What it takes off v'Pv where it is let go. Of a point that is held the statistic is less: its own coordinates and
  /// those of its neighbours are rounded.
  double explained = 0;
  int rank = 0;  ///< independent conditions
  bool stands() const { return rank == 0 || statistic <= critical; }
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
  int readings = 0;  ///< of the files that it comes from; 0: none, or counted with the first component
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

/// What the readings alone say of the known points, as a free network would: compare it modulo its datum only.
struct MeasuredControl {
  std::vector<std::string> ids;  ///< none: it was not asked for, or the readings do not tell
  Eigen::VectorXd coordinates;   ///< 3n [m]; NaN where a point has none
  Eigen::MatrixXd covariance;    ///< 3n x 3n [m^2]
  int defect = 0;                ///< of the free network
  double sum_of_squares = 0;     ///< of the readings alone
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
  bool without_readings = false;      ///< a list of coordinates, taken as given
  std::vector<std::string> left_out;  ///< points that the observations do not determine
  std::string common_error;           ///< explains the readings better than any single one; in words; empty: none
  int errors_taken_off = 0;           ///< that readings had in common, estimated
  std::string undecided;              ///< errors that explain them alike, of which one was taken off; empty: none
  std::string either;  ///< readings of which one was taken out and another may be the wrong one, in words; empty: none
  std::vector<ResultPoint> points;
  std::vector<ResultSetUp> set_ups;
  std::vector<ResultRow> rows;
  std::vector<ResultParameter> parameters;
  std::vector<ResultPointing> pointings;
  std::vector<ResultGroup> groups;
  std::vector<SnoopingAction> snooping;
  std::vector<Finding> findings;
  std::vector<KnownPoint> known_points;  ///< weighted or held; worst first, then by difference
  /// Known points that were left out, held against the result (left_out_control.hpp).
  std::vector<KnownPoint> left_out_known;
  MeasuredControl measured_control;        ///< if AdjustOptions::measure_control
  DatumMode datum = DatumMode::automatic;  ///< as used
  std::vector<std::string> datum_points;
  std::string frame;  ///< the map and its scale in words; empty: a plane in which lengths are true
  /// Of all unknowns, already multiplied by variance_factor. Of large networks not one matrix unless it was asked for;
  /// then the external effects of rows are those on the points of the row itself.
  least_squares::Cofactors cofactors;
  double variance_factor = 1;
  Eigen::MatrixXd null_space;  ///< of the network without datum (unknowns x defect)
  int readings = 0;            ///< of the files, each face and set by itself, that the result rests on
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
  /// 3n x 3n in the order of `points`. Throws std::runtime_error where the network is too large for it.
  Eigen::MatrixXd full_covariance() const;
  /// The same of some of the points, by their numbers, in the order given; of any network.
  Eigen::MatrixXd covariance_of(const std::vector<std::size_t>& some) const;
};

}  // namespace plumbline::survey
