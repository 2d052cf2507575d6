// Parts of approximate.cpp: sights as one figure per set-up, and plane geometry on them.
#pragma once

#include <Eigen/Core>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "survey/model/station_reduction.hpp"
#include "survey/model/survey_observations.hpp"

namespace plumbline::survey {

/// What one set-up saw of one target; NaN where it did not.
struct PolarSight {
  std::string to;
  double direction = kNotGiven;   ///< [rad]
  double horizontal = kNotGiven;  ///< [m]
  double slope = kNotGiven;       ///< [m]
  double zenith = kNotGiven;      ///< [rad]
  double heights = 0;             ///< instrument height - target height [m]
  double height_difference =
      kNotGiven;  ///< H(to) - H(station) between the points [m], where it follows from the sight alone
};

/// All sights of one set-up, or of one chain of angles with a common arm.
struct Figure {
  int set_up = -1;
  std::string station;
  bool oriented_to_north = false;  ///< azimuths: the circle's zero is north
  std::vector<PolarSight> sights;

  PolarSight& sight_to(const std::string& target);
};

/// Single lines between points that belong to no figure.
struct HeightDifference {
  std::string from, to;
  double value = 0;
};
struct DistanceLine {
  std::string from, to;
  double horizontal = kNotGiven, slope = kNotGiven, heights = 0;
};

struct Figures {
  std::vector<Figure> figures;
  std::vector<HeightDifference> height_differences;
  std::vector<DistanceLine> distances;
  std::set<std::string> heightless;  ///< points of a network in the plane
  /// What iterations from all around have found, by the bytes of their conditions: searches that differ in a late
  /// choice meet the same conditions again. One search at a time.
  std::shared_ptr<std::map<std::string, std::vector<std::pair<double, Eigen::Vector3d>>>> places_found =
      std::make_shared<std::map<std::string, std::vector<std::pair<double, Eigen::Vector3d>>>>();
};

Figures make_figures(const SurveyObservations& survey, const std::vector<MeanObservation>& observations);

/// Plane rigid motion that brings `from` onto `to`: azimuth += rotation (clockwise).
struct PlaneMotion {
  double rotation = 0;
  Eigen::Vector2d translation = Eigen::Vector2d::Zero();
  double rms = 0;
  Eigen::Vector2d operator()(const Eigen::Vector2d& p) const;
};
/// Needs >= 2 pairs that do not coincide; nullopt otherwise. Closed form (Horn 1987 in the plane), no scale.
std::optional<PlaneMotion> fit_plane(const std::vector<Eigen::Vector2d>& from, const std::vector<Eigen::Vector2d>& to);

/// Lines on which an unknown point lies: a ray from a known point, a circle about one, or the circle from which two
/// known points are seen under a measured angle.
struct Locus {
  Eigen::Vector2d origin;
  double azimuth = kNotGiven;  ///< ray if not NaN
  double radius = kNotGiven;   ///< circle otherwise
  double angle = kNotGiven;    ///< clockwise from `left` to `right`, if the circle is that of an angle [rad]
  Eigen::Vector2d left = Eigen::Vector2d::Zero(), right = Eigen::Vector2d::Zero();
  double misfit(const Eigen::Vector2d& p) const;
};
/// nullopt where the three points are nearly on a line, so that the circle has no centre.
std::optional<Locus> locus_of_angle(const Eigen::Vector2d& left, const Eigen::Vector2d& right, double angle);
/// 0, 1 or 2 points.
std::vector<Eigen::Vector2d> intersect(const Locus& a, const Locus& b);
/// Of all pairwise intersections the one that all loci agree with best, then those far from it that they agree with as
/// well (two circles meet twice). Empty if no pair meets.
std::vector<Eigen::Vector2d> best_intersections(const std::vector<Locus>& loci);
/// Station from directions (clockwise) to three known points; nullopt on the danger circle. Pierlot and Van
/// Droogenbroeck (2014).
std::optional<Eigen::Vector2d> resection(const Eigen::Vector2d known[3], const double directions[3]);

}  // namespace plumbline::survey
