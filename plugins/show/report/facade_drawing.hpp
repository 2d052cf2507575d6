// The elevation of a facade: every anchor at its place, its verdict as shape and colour, its deviation as an
// exaggerated arrow.
#pragma once

#include <map>

#include "show/report/facade_view.hpp"
#include "show/report/plot.hpp"
#include "show/report/report.hpp"

namespace plumbline::report {

struct Elevation {
  std::vector<Spot> spots;
  Sight sight;
  Scale x, y;                    ///< [m] to px
  double width = 0, height = 0;  ///< of the drawing [px]
  double pixels_per_metre = 1;
  double exaggeration = 1;
  double left = 0, right = 0, low = 0, high = 0;  ///< what it has to hold [m]
  double spacing = 1, largest = 0;                ///< of anchors that are next to one another, and of differences [m]
  double from = -1e300, to = 1e300;               ///< the stretch of it that is drawn [m]
  std::map<int, std::string> prefixes;            ///< of names, left out in the drawing

  bool holds(double along) const { return along >= from && along < to; }
  Eigen::Vector2d drawn(const Eigen::Vector3d& point) const { return {x(sight.along(point)), y(sight.up.dot(point))}; }
};

/// As large as names and arrows need. Without spots where none has a place.
Elevation elevation_of(const AccuracyT& accuracy, const FacadeView& view);
/// The same in stretches of one scale, as many as a sheet of paper needs to have every name in letters that can be
/// read: ten times the smallest distance of its anchors is as much as one can hold.
std::vector<Elevation> stretches_of(const Elevation& whole);
/// A round deviation [m] whose arrow is 20 to 50 px long.
double scale_deviation(const Elevation& e);
/// True if something stands behind the anchors.
bool draw_elevation(Markup& html, const Elevation& e, const FacadeView& view, const ReportInput& input);
/// Thousands of anchors and panels as one shape for each verdict, without names: the tables and the view in space have
/// these.
/// True if something stands behind them.
bool draw_many(Markup& html, const Elevation& e, const FacadeView& view, const ReportInput& input);

}  // namespace plumbline::report
