// What the finders of boards with markers share.
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <opencv2/calib3d.hpp>
#include <vector>

namespace plumbline::detect {

inline double side(const std::array<Eigen::Vector2d, 4>& c) {
  return 0.25 * ((c[0] - c[1]).norm() + (c[1] - c[2]).norm() + (c[2] - c[3]).norm() + (c[3] - c[0]).norm());
}

using TagCorners = std::array<Eigen::Vector2d, 4>;

/// How the tags of a board are drawn on it, all alike: corner k of what is seen is corner quarter + k of what the board
/// file has, or quarter − k in a mirror, which tags never are: then their rows count from the other end.
struct TagTurn {
  int quarter = 0;
  bool mirrored = false;
};

inline TagTurn turn_of(const std::vector<TagCorners>& expected, const std::vector<TagCorners>& seen) {
  TagTurn best;
  double lowest = 1e300;
  for (const bool mirrored : {false, true})
    for (int quarter = 0; quarter < 4; ++quarter) {
      double sum = 0;
      for (size_t i = 0; i < seen.size(); ++i)
        for (int k = 0; k < 4; ++k)
          sum += (seen[i][k] - expected[i][(quarter + (mirrored ? 4 - k : k)) % 4]).squaredNorm();
      if (sum < lowest) lowest = sum, best = {quarter, mirrored};
    }
  return best;
}

inline cv::Point2f point(const Eigen::Vector2d& p) { return {static_cast<float>(p.x()), static_cast<float>(p.y())}; }

inline Eigen::Matrix3d homography(const std::vector<cv::Point2f>& from, const std::vector<cv::Point2f>& to,
                                  int method) {
  const cv::Mat h = cv::findHomography(from, to, method, 3);
  if (h.empty()) return Eigen::Matrix3d::Constant(std::nan(""));
  Eigen::Matrix3d m;
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) m(r, c) = h.at<double>(r, c);
  return m;
}

inline Eigen::Vector2d mapped(const Eigen::Matrix3d& h, const Eigen::Vector2d& p) {
  return (h * p.homogeneous()).hnormalized();
}

}  // namespace plumbline::detect
