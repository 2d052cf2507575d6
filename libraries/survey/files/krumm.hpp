// The plain-text networks (.dat) of F. Krumm's collection of worked adjustment examples, University of Stuttgart:
// sections in brackets, '%' and '#' for comments.
#pragma once

#include <string>
#include <string_view>

#include "survey/model/survey_observations.hpp"

namespace plumbline::survey {

/// Reads coordinates, datum (fix, free, dyn with standard deviations or a covariance matrix), distances (also
/// correlated), directions, angles, azimuths and grid bearings, zenith and vertical angles, levelled and trigonometric
/// height differences, baselines with covariance, and restrictions that are distances. Axes x, y are taken as E, N;
/// angles are clockwise, in gon or as the section says (dms). Behind a value stand, all optional: its standard
/// deviation, for distances a second one (sigma^2 = sigma_c^2 + s sigma_s^2, or as the comment above the section has
/// it), then instrument and target height. A line without standard deviation has that of the line before it, before
/// the first that of [Sigma0]. Directions of one station are one set-up. A mark without coordinates that serves as the
/// arm of angles and of an azimuth from one station only orients them: the angles become azimuths.
/// Ellipsoidal coordinates, position angles and other restrictions are listed as skipped. Throws SurveyReadError when
/// there is nothing else.
SurveyObservations read_krumm(std::string_view bytes, const std::string& file);

}  // namespace plumbline::survey
