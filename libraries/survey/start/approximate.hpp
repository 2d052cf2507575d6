// Approximate coordinates, with or without any known point: set-ups become rigid figures of polar coordinates that are
// chained by the points they share; intersections, resections, trilateration, levelling and vectors give the rest.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "survey/model/station_reduction.hpp"
#include "survey/model/survey_observations.hpp"

namespace plumbline::survey {

struct Approximation {
  std::map<std::string, Eigen::Vector3d> points;  ///< E, N, H [m]; NaN where nothing determines the component
  std::vector<double> orientations;               ///< one per set-up [rad]; NaN without directions or without place
};

/// `points` holds what is known beforehand (NaN: unknown) and is never changed. Without any known point the first
/// figure defines the frame: its station is the origin, its circle's zero points north; of distances alone, one end of
/// the first is the origin and the other is east of it.
///
/// Two distances leave two places for a point, and so do others. Where no third observation decides at once, both are
/// followed; the result is every set of coordinates that was found, in the order of how well all observations agree
/// with it (at most 8 sets, at least one). Only the adjustment can tell which is right, or that several are possible.
///
/// With `unrelated`, parts that nothing connects each have a frame of their own, so that the adjustment can be asked
/// what is missing between them.
std::vector<Approximation> approximate_coordinates(const SurveyObservations& survey,
                                                   const std::vector<MeanObservation>& observations,
                                                   const std::map<std::string, Eigen::Vector3d>& points,
                                                   bool unrelated = false);

}  // namespace plumbline::survey
