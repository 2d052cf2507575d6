// Observation equations of a levelled total station, level, GNSS vector and coordinate sensor, as residual blocks.
// Frame: E, N, H right-handed, H up, metres; directions and azimuths clockwise from +N, radians.
// With d = X_to + TH e3 - X_from - IH e3, h = hypot(dE, dN), q = dH - (1 - k) h^2 / (2 R):
//   direction           atan2(dE, dN) - orientation + collimation |d| / h
//   azimuth             atan2(dE, dN)
//   zenith angle        atan2(h, q) + index
//   slope distance      (1 + scale) |d| + constant
//   horizontal distance (1 + scale) h + constant
//   height difference   dH
// Kahmen, Angewandte Geodäsie, ch. 5 and 6; R = 6 371 000 m.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "least_squares/problem/problem.hpp"
#include "survey/model/map_frame.hpp"
#include "survey/model/survey_observations.hpp"

namespace plumbline::survey {

inline constexpr double kEarthRadius = 6371000.0;  ///< [m]
/// Sights steeper than this (horizontal distance [m]) give no direction: it would be noise of the centring.
inline constexpr double kShortestHorizontal = 0.05;

/// One scalar observation with the parameters it depends on, as positions in ResidualBlock::parameters; -1: does not.
struct Equation {
  ObservationKind kind = ObservationKind::direction;
  double value = 0;              ///< [rad] or [m]
  double instrument_height = 0;  ///< above `from` [m]
  double target_height = 0;      ///< above `to` [m]
  double second_target_height = 0;
  double map_scale = 1;                    ///< horizontal length on the map over that on the ground
  double rise = 0, second_rise = 0;        ///< of the geoid from `from` to `to`, `second_to` [m]
  int from = -1, to = -1, second_to = -1;  ///< point blocks (E, N, H)
  int orientation = -1;                    ///< block of 1
  int centring = -1;                       ///< block of 2: E, N by which the instrument stood beside `from` [m]
  int tilt = -1;  ///< block of 2: rotation about E and N of what the instrument takes for vertical [rad]
  int instrument_height_correction = -1;  ///< block of 1 [m]
  int scale = -1;                         ///< block of 1 [1]
  int additive_constant = -1;             ///< block of 1 [m]
  int index = -1;                         ///< vertical index, block of 1 [rad]
  double index_factor = 1;                ///< -1: an index of the circle, read in face 2
  int collimation = -1;                   ///< block of 1 [rad]; of directions
  double face = 1;                        ///< of the collimation: -1 in face 2
  int refraction = -1;     ///< refraction coefficient k, block of 1; -1 with curvature = false: neither is applied
  bool curvature = false;  ///< apply earth curvature; refraction_coefficient is used where `refraction` is -1
  double refraction_coefficient = 0.13;
};

/// Scalar observations with a common covariance (a pointing, or a correlated group).
class ObservationBlock : public least_squares::ResidualBlock {
 public:
  bool evaluate(const double* const* values, double* residuals, double* const* jacobians) const override;
  std::vector<Equation> equations;  ///< one per row
};

/// Observed coordinates: row r is component `axis` of point block `point`.
class CoordinateBlock : public least_squares::ResidualBlock {
 public:
  bool evaluate(const double* const* values, double* residuals, double* const* jacobians) const override;
  struct Row {
    int point = 0, axis = 0;
    double value = 0;
  };
  std::vector<Row> equations;
};

/// Coordinate differences, three rows each.
class VectorBlock : public least_squares::ResidualBlock {
 public:
  bool evaluate(const double* const* values, double* residuals, double* const* jacobians) const override;
  struct Vector {
    int from = 0, to = 0;
    double from_height = 0, to_height = 0;  ///< of the antennas above their points [m]
  };
  std::vector<Vector> vectors;
  Eigen::VectorXd observed;             ///< 3n
  std::shared_ptr<const MapFrame> map;  ///< of geocentric differences; null: dE, dN, dH
  int slope = -1;                       ///< of the geoid to the east and north [rad], among the parameters; -1: none
};

/// A point in the frame of a levelled set-up: p = R(orientation) (X + TH e3 - S - IH e3), y at the zero of the circle.
class LocalCoordinateBlock : public least_squares::ResidualBlock {
 public:
  bool evaluate(const double* const* values, double* residuals, double* const* jacobians) const override;
  Eigen::Vector3d observed;
  double instrument_height = 0, target_height = 0;
  double map_scale = 1;  ///< as in Equation
  // parameters: station, target, orientation, [instrument height correction]
};

/// A parameter known with a standard deviation: v = x - value, all components of the one block.
class PriorBlock : public least_squares::ResidualBlock {
 public:
  bool evaluate(const double* const* values, double* residuals, double* const* jacobians) const override;
  Eigen::VectorXd prior;
};

/// Into (-pi, pi].
double wrap_angle(double angle);

}  // namespace plumbline::survey
