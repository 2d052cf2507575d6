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
  std::map<int, std::string> prefixes;  ///< of names, left out in the drawing

  Eigen::Vector2d drawn(const Eigen::Vector3d& point) const { return {x(sight.along(point)), y(sight.up.dot(point))}; }
};

/// As large as names and arrows need. Without spots where none has a place.
Elevation elevation_of(const AccuracyT& accuracy, const FacadeView& view);
/// A round deviation [m] whose arrow is 20 to 50 px long.
double scale_deviation(const Elevation& e);
/// True if something stands behind the anchors.
bool draw_elevation(Markup& html, const Elevation& e, const FacadeView& view, const ReportInput& input);
/// Thousands of anchors and panels as one shape for each verdict, without names: the tables and the view in space have
/// these.
/// True if something stands behind them.
bool draw_many(Markup& html, const Elevation& e, const FacadeView& view, const ReportInput& input);

}  // namespace plumbline::report
