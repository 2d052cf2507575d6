// Set-ups as rigid figures of polar coordinates, chained by the markers they share with robust fits, so that a swapped
// name or a gross reading neither carries a figure away nor hides. The chain is both the start of the adjustment and
// what the check of the set-ups (check_set_ups.hpp) compares each of them with.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "survey/model/instrument_profile.hpp"
#include "survey/model/station_reduction.hpp"

namespace plumbline::survey {

/// A sight with direction and distance as a point in the set-up's own frame: x to the right of the circle's zero, y
/// along it, z up, origin in the station's mark.
struct LocalSight {
  std::string point;
  Eigen::Vector3d ray = Eigen::Vector3d::Zero();  ///< from the tilting axis [m]; z NaN: no zenith angle
  double heights = 0;                             ///< instrument height - target height [m]
  double sigma = 0;                               ///< largest of along, across and up [m]
  int order = -1;                                 ///< first reading of it in the survey; -1: the station's own mark
  std::vector<int> observations;                  ///< mean observations it is made of

  /// With distances `scale` times those noted, less `constant`.
  Eigen::Vector3d place(double scale, double constant = 0) const {
    const double length = std::isnan(ray.z()) ? ray.head<2>().norm() : ray.norm();
    const double factor = length > 0 ? scale - constant / length : scale;
    return factor * ray + Eigen::Vector3d(0, 0, heights);
  }
};

struct SetUpFigure {
  int set_up = -1;
  std::vector<LocalSight> sights;  ///< the station's own mark first
};

/// Levelled similarity: azimuth += rotation (clockwise), then shift.
struct FigureFit {
  double rotation = 0, scale = 1;
  double constant = 0;  ///< by which distances are too long [m]
  Eigen::Vector3d shift = Eigen::Vector3d::Zero();
  int agree = 0, compared = 0;  ///< points that fit, and points there were

  Eigen::Vector3d operator()(const LocalSight& sight) const;
};

/// A point of a figure and where it ought to be. A NaN height is not compared.
struct FigurePair {
  const LocalSight* sight = nullptr;
  Eigen::Vector3d target;
  double tolerance = 0;  ///< [m]
};

bool agrees(const FigureFit& fit, const FigurePair& pair);

/// The levelled motion with which most points agree within their tolerance (all pairs of points as hypotheses, at most
/// about 400 of them, truncated squares; then least squares over those that agree). nullopt with fewer than two pairs,
/// or if no two agree.
std::optional<FigureFit> fit_robustly(const std::vector<FigurePair>& pairs, double scale);

/// The fit with an additive constant of up to 0.1 m with which more points agree than without: a wrong prism constant,
/// which is the adjustment's to estimate, must not pass for anything else. `fit` itself if there is none.
FigureFit with_constant(const std::vector<FigurePair>& pairs, const FigureFit& fit);

class SetUpChain {
 public:
  /// `profile` gives the standard deviations that the file lacks.
  SetUpChain(const SurveyObservations& survey, const std::vector<MeanObservation>& observations,
             const InstrumentProfile& profile);

  const std::vector<SetUpFigure>& figures() const { return figures_; }
  bool placed(size_t figure) const { return fits_[figure].has_value(); }
  const FigureFit& fit(size_t figure) const { return *fits_[figure]; }

  /// Where most of the placed figures but one (-1: all) see a point.
  struct Place {
    Eigen::Vector3d position;
    double sigma = 0;
    int agree = 0, views = 0;  ///< figures that see it there, and that see it
  };
  std::optional<Place> place_of(const std::string& point, int without = -1) const;
  /// The sights of a figure beside what all others say of the same points.
  std::vector<FigurePair> pairs_of(size_t figure) const;
  std::vector<std::string> points() const;

 private:
  static std::optional<FigureFit> best_fit(const std::vector<FigurePair>& pairs);
  size_t choose_root() const;
  void grow(size_t root);

  std::vector<SetUpFigure> figures_;
  std::vector<std::optional<FigureFit>> fits_;
  std::map<std::string, std::vector<std::pair<int, int>>> views_;  ///< point -> figure, sight
};

/// Units a distance may have been noted in, as metres: feet, and what else is met.
struct LengthUnit {
  const char* name;
  double metres;
};
inline constexpr LengthUnit kLengthUnits[] = {
    {"feet", 0.3048}, {"millimetres", 0.001}, {"centimetres", 0.01}, {"yards", 0.9144}};

/// Coordinates and orientations from the chain: in the frame of `known` points if two of them or more are in it and
/// most agree, in that of the set-up with most sights (its station the origin, its circle's zero north) if none is
/// known; nullopt otherwise, or if no figure could be placed. Points the chain does not reach are not among them.
struct ChainStart {
  std::map<std::string, Eigen::Vector3d> points;
  std::vector<double> orientations;  ///< one per set-up [rad]; NaN: not placed
};
std::optional<ChainStart> start_from_chain(const SetUpChain& chain, size_t set_ups,
                                           const std::map<std::string, Eigen::Vector3d>& known);

}  // namespace plumbline::survey
