// The surveyor of the simulated campaign: where the total station stands, which targets it points at, and what it
// reads.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "building.hpp"
#include "survey/model/survey_observations.hpp"

namespace plumbline::simulate {

struct SurveyOptions {
  std::string instrument = "ics50_assumed";  ///< a built-in profile of the survey library
  double noise_scale = 1.0;                  ///< multiplies every standard deviation of the instrument
  int sets = 2;                              ///< rounds, each in two faces
  double distance = 9.0;                     ///< of the set-ups from the facade [m]
  double control_sigma = 0.5e-3;             ///< of the ground control points' given coordinates, each axis [m]
  double set_up_height_sigma = 0.0;          ///< error of the measured instrument height of a set-up [m]
  bool known_marks = false;                  ///< the set-ups' marks are control points, too
};

/// A ground control point: it carries the datum.
struct GroundPoint {
  std::string id;
  Eigen::Vector3d truth = Eigen::Vector3d::Zero();  ///< [m], building frame
  Eigen::Vector3d given = Eigen::Vector3d::Zero();  ///< [m], what control.csv says
  double sigma = 0;                                 ///< of `given`, each axis [m]
  double target_height = 0;                         ///< of the pole that stands on it [m]
};

/// One set-up of the total station over a mark of unknown coordinates.
struct PlannedSetUp {
  std::string id;
  int floor = 0;                                   ///< storey it serves, from 1
  Eigen::Vector3d axis = Eigen::Vector3d::Zero();  ///< truth: the instrument's centre [m]
  double instrument_height = 0;                    ///< truth: above the mark [m]
  double orientation = 0;                          ///< truth: azimuth of the circle's zero [rad]
  Eigen::Vector3d given_mark =
      Eigen::Vector3d::Zero();             ///< what control.csv says of the mark below, if it is known [m]
  std::vector<std::size_t> anchors;        ///< indices into Building::anchors
  std::vector<std::size_t> ground_points;  ///< indices into StationPlan::ground_points
};

struct StationPlan {
  std::vector<GroundPoint> ground_points;
  std::vector<PlannedSetUp> set_ups;
};

/// Two set-ups a floor at the height of the floor. Each sees all plates of its own storey and of the storey below, so
/// that adjacent floors share two rows of markers; the two lowest storeys also see the ground control points.
StationPlan plan_set_ups(const Building& building, const SurveyOptions& options, std::uint64_t seed);

/// Rules of the paper's sections 6.2 and 6.4 that the plan breaks, in words; empty if it keeps them all:
/// every marker in at least two set-ups, at least two rows of markers in common between adjacent floors, no sight
/// flatter than `largest_incidence` [rad, from the facade's normal], one vertical column of markers through all floors,
/// three control points.
std::vector<std::string> broken_station_rules(const Building& building, const StationPlan& plan,
                                              double largest_incidence = 1.0472);

/// What the instrument reads: rounds in two faces with collimation, index and random errors, target centring and the
/// distance's a + b ppm. Without sigmas: the instrument profile knows them.
survey::SurveyObservations observe(const Building& building, const StationPlan& plan, const SurveyOptions& options,
                                   std::uint64_t seed);

}  // namespace plumbline::simulate
