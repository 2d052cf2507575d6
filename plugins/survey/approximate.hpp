// Approximate coordinates, with or without any known point: set-ups become rigid figures of polar coordinates that are
// chained by the points they share; intersections, resections, levelling and vectors give the rest.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "formats/survey_observations.hpp"
#include "mean_observations.hpp"

namespace plumbline::survey {

struct Approximation {
  std::map<std::string, Eigen::Vector3d> points;  ///< E, N, H [m]; NaN where nothing determines the component
  std::vector<double> orientations;               ///< one per set-up [rad]; NaN without directions or without place
};

/// `points` holds what is known beforehand (NaN: unknown) and is never changed. Without any known point the first
/// figure defines the frame: its station is the origin, its circle's zero points north.
Approximation approximate_coordinates(const SurveyObservations& survey,
                                      const std::vector<MeanObservation>& observations,
                                      const std::map<std::string, Eigen::Vector3d>& points);

}  // namespace plumbline::survey
