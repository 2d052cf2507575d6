// The result of an adjustment as tables for a spreadsheet.
#pragma once

#include <set>
#include <string>
#include <utility>
#include <vector>

#include "artifacts/points.hpp"
#include "artifacts/survey_network.hpp"

namespace plumbline::survey {

struct TableFormat {
  char decimal = '.', delimiter = ',';
};

/// Numbers of markers that are paired: each with its `count` nearest; instrument stations are no markers unless there
/// is nothing else.
std::vector<std::pair<std::size_t, std::size_t>> neighbouring_markers(const std::vector<std::string>& ids,
                                                                      const std::vector<Eigen::Vector3d>& positions,
                                                                      const std::set<std::string>& stations, int count);

/// Two names, "A B" or "A;B". Throws std::runtime_error.
std::pair<std::string, std::string> split_pair(const std::string& text);

/// One row a point: coordinates and standard deviations in the axes of `network`, which the header names, and the 95 %
/// confidence ellipse in plan (azimuth of its major axis clockwise from north) and interval in height. `points` are the
/// same points in E, N, H with their covariance.
std::string coordinate_table(const SurveyNetworkT& network, const PointsT& points, const TableFormat& format);

/// One row an observation: angles in gon, their residuals in mgon, lengths in m and mm; the unit is named in each row.
std::string observation_table(const SurveyNetworkT& network, const TableFormat& format);

/// One row a pair: the difference b - a in E, N, H, its standard deviations and covariance, 95 % ellipse and interval.
/// Pairs: `wanted` ("A B", names without blanks, or "A;B"), and every marker with its `neighbour_count` nearest ones;
/// instrument stations are no markers unless there is nothing else. Throws std::runtime_error for a pair or a point
/// that is none.
std::string relative_table(const SurveyNetworkT& network, const PointsT& points, const std::vector<std::string>& wanted,
                           int neighbour_count, const TableFormat& format);

}  // namespace plumbline::survey
