// Points of a surface artifact as a test looks at them: read from the tiles' files, with what is stated of their
// errors.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstring>
#include <string>
#include <vector>

#include "artifacts/surface_points.hpp"
#include "test_support.hpp"

namespace plumbline::test {

struct StatedPoint {
  Eigen::Vector3d place;             ///< [m]
  double sigma;                      ///< random, along the surface's normal [m]
  Eigen::MatrixXd by_common_errors;  ///< 3 x rank: displacement by the common errors [m]
};

/// `folder`: where the tiles lie.
inline std::vector<StatedPoint> stated_points(const SurfacePointsT& surface, const std::string& folder) {
  std::vector<StatedPoint> points;
  for (const auto& tile : surface.tiles) {
    const std::string bytes = read_file(folder + tile->uri.substr(tile->uri.rfind('/')));
    EXPECT_EQ(bytes.size(), 16 * tile->points);
    EXPECT_EQ(tile->factor.size(), 6 * static_cast<size_t>(surface.rank));
    const Eigen::Map<const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>> factor(
        tile->factor.data(), 6, surface.rank);
    for (size_t i = 0; i + 16 <= bytes.size(); i += 16) {
      float values[4];
      std::memcpy(values, bytes.data() + i, sizeof values);
      const Eigen::Vector3d arm(static_cast<double>(values[0]), static_cast<double>(values[1]),
                                static_cast<double>(values[2]));
      StatedPoint point{tile->centre + arm, static_cast<double>(values[3]), factor.topRows<3>()};
      for (Eigen::Index c = 0; c < factor.cols(); ++c)
        point.by_common_errors.col(c) += Eigen::Vector3d(factor.block<3, 1>(3, c)).cross(arm);
      points.push_back(std::move(point));
    }
  }
  return points;
}

}  // namespace plumbline::test
