// What a drawing of a facade shows: anchors and panels before whom one stands, and behind them a picture or a heat map.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "artifacts/accuracy.hpp"
#include "artifacts/deviation.hpp"

namespace plumbline::report {

/// An anchor in the plane of the facade.
struct Spot {
  std::string id;
  int floor = 0;
  bool control = false;
  Eigen::Vector3d position = Eigen::Vector3d::Zero(), difference = Eigen::Vector3d::Zero();  ///< [m]; nan: not measured
  double number = 0;                                                                         ///< beside the name [m]
  ToleranceVerdict verdict = ToleranceVerdict::not_measured;
  std::string facade;            ///< empty: none that is known
  double along = 0, height = 0;  ///< [m]
};

/// A panel as a quadrangle.
struct Quad {
  std::string name;
  ToleranceVerdict verdict;
  std::vector<Eigen::Vector3d> corners;  ///< bottom left, bottom right, top right, top left
};

/// How one stands before a facade: to the right and up; where it bends it is unrolled.
struct Sight {
  Eigen::Vector3d right = Eigen::Vector3d::Zero(), up = Eigen::Vector3d::UnitZ();  ///< zero: as the anchors spread
  std::vector<std::pair<double, double>> unrolled;                                 ///< along `right`, and unrolled [m]

  double along(const Eigen::Vector3d& p) const {
    const double s = right.dot(p);
    if (unrolled.size() < 2) return s;
    std::size_t i = 1;
    while (i + 1 < unrolled.size() && unrolled[i].first < s) ++i;
    const auto& [from, length] = unrolled[i - 1];
    const auto& [to, end] = unrolled[i];
    return length + (end - length) / (to - from) * (s - from);
  }
};

enum class Behind { nothing, picture, heat };

/// What one drawing shows.
struct FacadeView {
  std::string question;
  std::string name;    ///< "model minus survey"
  std::string number;  ///< what stands beside the names
  std::vector<Spot> spots;
  std::vector<Quad> panels;
  Sight sight;
  Behind behind = Behind::nothing;
};

/// Of the model against the survey.
FacadeView model_view(const AccuracyT& accuracy);
/// As-built minus design of a facade with its panels; out of its plane (the arrows then stand for that, outward drawn
/// upward), or in it. `facade` null: of the anchors that belong to none.
/// `floor`: of that floor alone.
FacadeView built_view(const DeviationT& deviation, const FacadeT* facade, bool out_of_plane,
                      std::optional<int> floor = std::nullopt);
/// The same spots by facade, for the comparison with the survey.
FacadeView only_of(const FacadeView& all, const FacadeT& facade, const DeviationT& deviation);

}  // namespace plumbline::report
