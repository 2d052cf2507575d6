// Accuracy of model points against survey points: equations (1)-(3) and (9)-(13) of the paper, each with its
// uncertainty.
//
// The result is the artifact `Accuracy` (schemas/artifacts/accuracy.fbs) in its C++ form, so that there is one
// definition of every quantity, its unit and its meaning.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "artifacts/accuracy.hpp"
#include "building/judgement/block_covariance.hpp"

namespace plumbline::judgement {

/// Points in the survey frame with one covariance matrix.
struct PointSet {
  std::vector<std::string> ids;
  std::vector<Eigen::Vector3d> positions;  ///< [m]
  BlockCovariance covariance;              ///< 3n x 3n [m²], order x0 y0 z0 x1 ...
};

/// One row of the anchor table.
struct AnchorEntry {
  std::string id;
  int floor = 0;   ///< counted from 1 at the bottom; 0 if unknown
  int column = 0;  ///< vertical marker column; 0 if it belongs to none
  int row = 0;
  AnchorUse use = AnchorUse::check;
};

/// How model and survey depend on each other.
enum class Correlation {
  from_control,  ///< the model was adjusted to the survey of its control anchors with their covariance, as in (5)
  independent,   ///< the model knows nothing of this survey
};

struct Options {
  std::vector<double> tolerances;          ///< [m] sweep of (3) and (10); empty: 2 to 8 mm in steps of 0.5 mm
  double tau = 0.005;                      ///< [m] headline tolerance of the verdicts
  double guard_factor = 1.645;             ///< k of the guard band; 1.645 gives 5 % risk on one side
  double confidence = 0.95;                ///< of all intervals and tests
  bool name_contradicting_checks = false;  ///< and tell uncertainties that are too small by the others alone
  bool drift_on_control = false;           ///< computes D(F) on control anchors too, marked as no evidence
  Correlation correlation = Correlation::from_control;
};

struct Inputs {
  std::vector<AnchorEntry> anchors;
  PointSet model;
  PointSet survey;
  /// Measured by total station alone: the model is the survey, `survey` is empty, and nothing is compared with it.
  bool model_is_survey = false;
  /// Control anchors that the model was adjusted without, because they contradict it: it shares no error with them.
  std::set<std::string> not_adjusted_to;
  bool of_photographs = false;    ///< with model_is_survey: not a total station but photographs alone measured it
  std::optional<PointSet> truth;  ///< simulation only; taken as exact whatever its covariance
  /// The truth is of anchors, model and survey are of plates: standard deviation of a plate's place on its anchor, on
  /// each axis [m].
  double mounting_sigma = 0;
  std::vector<std::string> ties;  ///< points of the model that are no anchors and not missed in the table
};

/// Evaluates the model. Anchors without a finite model or reference position are listed with the reason and left out of
/// every mean; they never make the others fail. Throws std::runtime_error if the anchor table is empty or holds an id
/// twice, a point set holds an id twice or a covariance of the wrong size, or an option is out of its range.
AccuracyT evaluate_accuracy(Inputs inputs, const Options& options);

/// 2.0, 2.5 ... 8.0 mm [m].
std::vector<double> default_tolerances();

}  // namespace plumbline::judgement
