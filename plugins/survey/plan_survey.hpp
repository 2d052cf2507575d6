// What a planned layout of markers and set-ups will be able to say, before anybody measures: the rules of marker and
// station placement, the covariance the adjustment will have, and the sight or set-up that mends what fails.
#pragma once

#include <string>
#include <vector>

#include "adjust_network.hpp"
#include "instrument_profile.hpp"

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
  Eigen::Vector3d position;  ///< of the instrument's tilting axis [m]
};

struct PlanOptions {
  InstrumentProfile profile;
  int set_ups_per_marker = 2;
  int shared_markers = 2;           ///< that set-ups seeing both of two adjacent floors see on each of them
  double largest_range = 60;        ///< [m]
  double largest_incidence = 1.05;  ///< between sight and plate normal [rad], 60 degrees
  double steepest_sight = 0.87;     ///< elevation of a sight [rad], 50 degrees
  int sets = 1;                     ///< in both faces
  double tolerance = 0.005;         ///< height transfer is to be known to a fifth of it [m]
};

struct PlannedRule {
  std::string name;
  bool holds = true;
  std::string text;  ///< what was found
  std::vector<std::string> points;
};

struct PlannedSight {
  std::string set_up, marker;
  double length = 0;     ///< [m]
  double incidence = 0;  ///< [rad]; NaN if the normal is unknown
};

struct PlanResult {
  std::vector<PlannedSight> sights;
  std::vector<PlannedRule> rules;
  NetworkResult predicted;             ///< datum: the markers of the lowest floor
  std::vector<int> floors;             ///< ascending
  std::vector<double> transfer_sigma;  ///< floor k to k + 1: mean height difference, equation (13) [m]
  std::vector<double> drift_sigma;     ///< of D(F), equation (2), by the survey alone [m]
  std::vector<std::string> remedies;   ///< cheapest first, in words
  bool adjustable = false;             ///< false: `predicted` and the sigmas are empty, a rule says why
};

/// Throws std::runtime_error without markers or set-ups.
PlanResult plan_survey(const std::vector<PlannedMarker>& markers, const std::vector<PlannedSetUp>& set_ups,
                       const PlanOptions& options);

}  // namespace plumbline::survey
