// The result of an adjustment as tables for a spreadsheet.
#pragma once

#include <string>
#include <vector>

#include "artifacts/points.hpp"
#include "artifacts/survey_network.hpp"

namespace plumbline::survey {

struct TableFormat {
  char decimal = '.', delimiter = ',';
};

/// One row a point: coordinates and standard deviations in the axes of `network`, which the header names, and the 95 %
/// confidence ellipse in plan (azimuth of its major axis clockwise from north) and interval in height. `points` are the
/// same points in E, N, H with their covariance.
std::string coordinate_table(const SurveyNetworkT& network, const PointsT& points, const TableFormat& format);

/// One row a pair: the difference b - a in E, N, H, its standard deviations and covariance, 95 % ellipse and interval.
/// Pairs: `wanted` ("A B", names without blanks, or "A;B"), and every marker with its `neighbour_count` nearest ones;
/// instrument stations are no markers unless there is nothing else. Throws std::runtime_error for a pair or a point
/// that is none.
std::string relative_table(const SurveyNetworkT& network, const PointsT& points, const std::vector<std::string>& wanted,
                           int neighbour_count, const TableFormat& format);

}  // namespace plumbline::survey
