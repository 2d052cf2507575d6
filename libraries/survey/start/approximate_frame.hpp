// Part of approximate.cpp: a frame that grows from the points it knows. What rays and circles place in it is in
// approximate_intersection.cpp, what slope distances place in approximate_spheres.cpp, what needs an iteration in
// approximate_point.cpp, the rest in approximate_frame.cpp.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "survey/model/survey_observations.hpp"
#include "survey/start/approximate_choices.hpp"
#include "survey/start/approximate_figure.hpp"

namespace plumbline::survey {

/// Clockwise from +y [rad].
double azimuth_between(const Eigen::Vector2d& from, const Eigen::Vector2d& to);

/// What one observation says of a point that is not placed, seen from one that is.
struct PointCondition {
  enum Kind { ray, angle, slope, horizontal, elevation, rise } kind;
  Eigen::Vector3d known;   ///< [m]
  double value = 0;        ///< azimuth from `known`, angle from `known` to `second` at the point, ... [rad, m]
  Eigen::Vector3d second;  ///< angle only
  /// [rad], or parts of the distance; of a height difference, parts of 10 m.
  double misclosure(const Eigen::Vector3d& p) const;
};

class Frame {
 public:
  /// `name` tells its choices from those of other frames.
  Frame(const SurveyObservations& survey, const Figures& figures, Choices& choices, std::string name)
      : survey_(survey),
        figures_(figures),
        choices_(choices),
        name_(std::move(name)),
        orientation_(figures.figures.size(), kNotGiven) {}

  void set_plan(const std::string& id, const Eigen::Vector2d& p) { plan_.emplace(id, p); }
  void set_height(const std::string& id, double h) { height_.emplace(id, h); }
  bool has_plan(const std::string& id) const { return plan_.contains(id); }
  bool has_height(const std::string& id) const { return height_.contains(id); }
  const std::map<std::string, Eigen::Vector2d>& plan() const { return plan_; }
  const std::map<std::string, double>& height() const { return height_; }
  double orientation(size_t figure) const { return orientation_[figure]; }

  /// A point of a network in the plane.
  bool heightless(const std::string& id) const { return figures_.heightless.contains(id); }

  /// Places everything that follows from what is known; `guess`: where two places are equally good, takes one.
  void grow(bool guess);

  /// Starts a frame without known points: the station is the origin, the zero of the circle is north.
  void seed(size_t figure);

  /// Starts a frame of unknown scale, for networks of angles: the station is the origin, the zero of the circle is
  /// north, `target` is a kilometre away. Distances and heights wait until the scale is settled.
  void seed_shape(size_t figure, const std::string& target);

  /// Starts a frame from a measured distance alone: one end is the origin, the other is east of it. If all its
  /// distances are slopes, a third point lies level with them (`third` not empty). False if these distances are not
  /// measured.
  bool seed_distance(const std::string& a, const std::string& b, const std::string& third);

  /// Starts a frame whose north is right: the beginning of a vector is the origin.
  void seed_vector(const std::string& from);

  /// What the distances, directions and height differences between placed points disagree with them: each counts up to
  /// 1, reached at a tenth of the sight's length.
  double misfit() const;

  /// Gives such a frame the scale of the distances between its points, else that of the points it shares with `known`,
  /// else leaves the kilometre and returns false.
  bool settle_scale(const Frame& known);

  /// Turns a seeded frame so that azimuths and vectors between its points are right, if there are any.
  void settle_north();

  /// Takes over the points of another frame. False if the two share too little: two points, or one if the other's north
  /// is settled; with `guess` any north is believed.
  bool adopt(const Frame& other, bool guess);

  /// Takes over a frame that shares nothing with this one, as it is.
  bool adopt_unrelated(const Frame& other);

 private:
  bool grow_well_determined();

  /// Plane position of a sight's target seen from the station with the circle's zero as north; nullopt without
  /// distance.
  std::optional<Eigen::Vector2d> local_position(const Figure& figure, const PolarSight& s) const;

  /// A slope distance becomes horizontal with the heights of both ends; in a network without heights it is taken as it
  /// is.
  double horizontal_of(const std::string& a, const std::string& b, double horizontal, double slope,
                       double heights) const;

  /// Station and orientation from >= 2 known targets with direction and distance.
  bool place_free_station(size_t f);
  bool orient(size_t f);
  std::optional<double> mean_orientation(const Figure& figure) const;

  /// Another figure on the same station (an azimuth, another round) that is oriented and sights a common target.
  bool orient_by_neighbour(size_t f);

  /// A figure whose station is not placed yet, sighted from an oriented one that it sights itself.
  bool orient_by_reverse_sight(size_t f);
  bool place_polar(size_t f);
  bool carry_heights(size_t f);
  bool carry_height(const std::string& from, const std::string& to, double difference);
  bool carry_height_differences();
  bool carry_vectors();

  /// One point at a time, so that what it determines well comes before the next intersection.
  bool grow_by_intersection(bool accept_ambiguous);
  void add_circle(const std::string& known, const std::string& unknown, double radius,
                  std::map<std::string, std::vector<Locus>>& loci) const;
  void collect_loci(size_t f, std::map<std::string, std::vector<Locus>>& loci) const;
  /// Two known targets of an instrument that is not oriented: the circle of their angle.
  void collect_angle_loci(const Figure& figure, std::vector<Locus>& loci) const;
  bool place_by_resection(size_t f);
  double resection_misfit(const Eigen::Vector2d& p, const std::vector<const PolarSight*>& known) const;

  struct Sphere {
    Eigen::Vector3d centre;
    double radius;
  };
  std::map<std::string, std::vector<Sphere>> collect_spheres() const;
  /// Differences of the spheres' equations are linear in the place: four spheres give one, three (or centres in one
  /// plane) give two.
  bool place_by_slope_distances(bool accept_ambiguous);
  /// Where the plan is known already, a slope distance puts the point above or below the other.
  bool place_height_by_slope_distances();
  std::map<std::string, std::vector<PointCondition>> collect_conditions() const;
  /// The last resort in space: iterated from starts all around.
  bool place_by_conditions();
  std::optional<double> slope_between(const std::string& a, const std::string& b) const;

  /// By how much a frame whose north is arbitrary has to be turned so that its first set-up with a stated orientation
  /// has it; where none is stated, so that the zero of its first circle is north.
  double stated_turn() const;

  /// Measured by own length of each distance between placed points.
  std::vector<double> scales_of_distances() const;
  bool adopt_plan(const Frame& other, bool guess);
  bool adopt_height(const Frame& other);

  const SurveyObservations& survey_;
  const Figures& figures_;
  Choices& choices_;
  std::string name_;
  std::map<std::string, Eigen::Vector2d> plan_;
  std::map<std::string, double> height_;
  std::vector<double> orientation_;
  bool seeded_ = false;      // its north is arbitrary
  bool scale_open_ = false;  // its unit of length is arbitrary
};

}  // namespace plumbline::survey
