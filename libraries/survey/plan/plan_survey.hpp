// What a planned layout of markers and set-ups will be able to say, before anybody measures: the rules of marker and
// station placement, the covariance the adjustment will have, and the sights or set-up that mend what fails.
#pragma once

#include <string>
#include <vector>

#include "survey/adjust/adjust_network.hpp"
#include "survey/model/instrument_profile.hpp"

namespace plumbline::survey {

struct PlannedMarker {
  std::string id;
  Eigen::Vector3d position;  ///< [m]
  Eigen::Vector3d normal;    ///< outward of the facade; NaN: unknown, then incidence is not checked
  int floor = 1;
  int column = 0;  ///< vertical marker column; 0: none
};

struct PlannedSetUp {
  std::string id;
  Eigen::Vector3d position;            ///< of the instrument's tilting axis [m]
  std::vector<std::string> sees = {};  ///< markers it is to sight; empty: all within the limits
};

struct PlanOptions {
  InstrumentProfile profile;
  int set_ups_per_marker = 2;
  int shared_markers = 2;           ///< that set-ups seeing both of two adjacent floors see on each of them
  int markers_per_floor = 6;        ///< three columns of two
  double spacing = 2.0;             ///< of the marker grid: from each marker to the nearest one [m]
  double spacing_tolerance = 0.5;   ///< [m]
  double largest_range = 60;        ///< [m]
  double largest_incidence = 1.05;  ///< between sight and plate normal [rad], 60 degrees
  double steepest_sight = 0.87;     ///< elevation of a sight [rad], 50 degrees
  int sets = 1;                     ///< in both faces
  double tolerance = 0.005;         ///< height transfer is to be known to a fifth of it [m]
};

struct PlannedRule {
  std::string name;
  bool holds = true;
  std::string text;                 ///< what was found
  std::vector<std::string> points;  ///< it concerns
};

struct PlannedSight {
  std::string set_up, marker;
  double length = 0;     ///< [m]
  double incidence = 0;  ///< between sight and plate normal [rad]; NaN if the normal is unknown
};

/// Something added to the plan with which a rule holds; tried out, not guessed.
struct PlanRemedy {
  std::string rule, text;
  int sightings = 0;                ///< that it costs; a new set-up counts as kSetUpCost more
  std::vector<PlannedSight> added;  ///< empty: more sets, or a marker to mount
};

/// Setting up and levelling takes about as long as this many sightings.
inline constexpr int kSetUpCost = 10;

struct PlannedTransfer {
  int from_floor = 0, to_floor = 0;
  int column = 0;    ///< 0: between the means of the floors, equation (13); else within this marker column
  double sigma = 0;  ///< [m]
};

struct PlannedDrift {
  int floor = 0;
  double sigma = 0;  ///< of D(F), equation (2), by the survey alone [m]
};

struct PlanResult {
  std::vector<PlannedSight> sights;
  std::vector<PlannedRule> rules;
  NetworkResult predicted;  ///< datum: the markers of the lowest floor
  std::vector<int> floors;  ///< ascending
  std::vector<PlannedTransfer> transfers;
  std::vector<PlannedDrift> drifts;
  std::vector<PlanRemedy> remedies;  ///< cheapest first
  bool adjustable = false;           ///< false: `predicted` and the sigmas are empty, a rule says why
};

/// Throws std::runtime_error without markers or set-ups, and for a `sees` that names no marker.
PlanResult plan_survey(const std::vector<PlannedMarker>& markers, const std::vector<PlannedSetUp>& set_ups,
                       const PlanOptions& options);

/// The exact readings of all sights of the plan, with the standard deviations of the profile, and the datum that the
/// prediction uses: what a simulation adds noise to. Throws like plan_survey().
SurveyObservations planned_readings(const std::vector<PlannedMarker>& markers, const std::vector<PlannedSetUp>& set_ups,
                                    const PlanOptions& options);
AdjustOptions planned_adjustment(const std::vector<PlannedMarker>& markers, const std::vector<PlannedSetUp>& set_ups,
                                 const PlanOptions& options);

}  // namespace plumbline::survey
