#include "place/pose/opencv_solvers.hpp"

#include <cmath>
#include <opencv2/calib3d.hpp>
#include <stdexcept>

#include "geometry/similarity.hpp"

namespace plumbline::pose {
namespace {

/// Image coordinates are normalised and free of distortion, so OpenCV's camera is the identity.
struct Data {
  std::vector<cv::Point3d> points;
  std::vector<cv::Point2d> image;
  void add(const Eigen::Vector3d& point, const Eigen::Vector3d& bearing) {
    points.emplace_back(point.x(), point.y(), point.z());
    image.emplace_back(bearing.x() / bearing.z(), bearing.y() / bearing.z());
  }
};

void append(const std::vector<cv::Mat>& rotations, const std::vector<cv::Mat>& translations, PoseHypotheses& poses) {
  for (std::size_t i = 0; i < rotations.size(); ++i) {
    const Eigen::Vector3d r(rotations[i].ptr<double>()), t(translations[i].ptr<double>());
    if (r.allFinite() && t.allFinite()) poses.push_back({quaternion_from_rotation_vector(r), t});
  }
}

PoseHypotheses solve(const Data& data, cv::SolvePnPMethod method) {
  std::vector<cv::Mat> rotations, translations;
  try {
    cv::solvePnPGeneric(data.points, data.image, cv::Matx33d::eye(), cv::noArray(), rotations, translations, false,
                        method);
  } catch (const cv::Exception&) {
    return {};  // what OpenCV asserts of its input does not hold for every sample
  }
  PoseHypotheses poses;
  append(rotations, translations, poses);
  return poses;
}

Data all_corners(const std::vector<const TagView*>& sample) {
  Data data;
  for (const TagView* tag : sample)
    for (int i = 0; i < 4; ++i) data.add(tag->corner_in_world(i), tag->bearings[i]);
  return data;
}

/// From one corner of each of the first three tags, another corner each time, so that three tags in one line still span
/// a triangle; and once more from other corners. Of fewer tags, three corners of what there is.
PoseHypotheses minimal(const std::vector<const TagView*>& sample, cv::SolvePnPMethod method) {
  PoseHypotheses poses;
  for (const std::size_t first : {0, 2}) {
    Data data;
    for (std::size_t k = 0; k < 3; ++k) {
      const std::size_t i = (first + k) % 4;
      const TagView& tag = *sample[k % sample.size()];
      data.add(tag.corner_in_world(static_cast<int>(i)), tag.bearings[i]);
    }
    std::vector<cv::Mat> rotations, translations;
    cv::solveP3P(data.points, data.image, cv::Matx33d::eye(), cv::noArray(), rotations, translations, method);
    append(rotations, translations, poses);
  }
  return poses;
}

PoseHypotheses sqpnp(const std::vector<const TagView*>& sample) {
  return solve(all_corners(sample), cv::SOLVEPNP_SQPNP);
}
PoseHypotheses iterative(const std::vector<const TagView*>& sample) {
  return solve(all_corners(sample), cv::SOLVEPNP_ITERATIVE);
}
PoseHypotheses p3p(const std::vector<const TagView*>& sample) { return minimal(sample, cv::SOLVEPNP_P3P); }
PoseHypotheses ap3p(const std::vector<const TagView*>& sample) { return minimal(sample, cv::SOLVEPNP_AP3P); }

/// Poses of one tag by itself, cam_from_tag. OpenCV asks for top left, top right, bottom right, bottom left.
PoseHypotheses single_tag(const TagView& tag) {
  Data data;
  for (const int i : {3, 2, 1, 0}) data.add(tag.corner_in_tag(i), tag.bearings[i]);
  return solve(data, cv::SOLVEPNP_IPPE_SQUARE);
}

/// Least-squares rotation and translation of centre points.
RigidTransform align(const Eigen::Matrix3Xd& world, const Eigen::Matrix3Xd& camera) {
  const Eigen::Vector3d world_mean = world.rowwise().mean(), camera_mean = camera.rowwise().mean();
  const Eigen::Matrix3d moment = (camera.colwise() - camera_mean) * (world.colwise() - world_mean).transpose();
  const Eigen::Matrix3d rotation = rotation_of_moment(moment);
  return {Eigen::Quaterniond(rotation).normalized(), camera_mean - rotation * world_mean};
}

PoseHypotheses ippe_square(const std::vector<const TagView*>& sample) {
  std::vector<PoseHypotheses> of_tag;
  std::size_t combinations = 1;
  for (const TagView* tag : sample) {
    of_tag.push_back(single_tag(*tag));
    combinations *= of_tag.back().size();
  }
  PoseHypotheses poses;
  const auto count = static_cast<Eigen::Index>(sample.size());
  for (std::size_t combination = 0; combination < combinations; ++combination) {
    Eigen::Matrix3Xd world(3, count), camera(3, count);
    std::size_t rest = combination;
    for (std::size_t k = 0; k < sample.size(); ++k) {
      const RigidTransform& cam_from_tag = of_tag[k][rest % of_tag[k].size()];
      rest /= of_tag[k].size();
      world.col(static_cast<Eigen::Index>(k)) = sample[k]->world_from_tag.translation;
      camera.col(static_cast<Eigen::Index>(k)) = cam_from_tag.translation;
      // A lone tag's pose, with the plate's nominal rotation: rough, but it needs no spread of the tags.
      poses.push_back(cam_from_tag * sample[k]->world_from_tag.inverse());
    }
    if (sample.size() > 2) poses.push_back(align(world, camera));  // the centres of two tags leave a rotation open
  }
  return poses;
}

struct Named {
  const char* name;
  PoseHypotheses (*solve)(const std::vector<const TagView*>&);
};
constexpr Named solvers[] = {
    {"sqpnp", sqpnp}, {"ippe_square", ippe_square}, {"p3p", p3p}, {"ap3p", ap3p}, {"iterative", iterative}};

}  // namespace

const std::vector<std::string>& opencv_solver_names() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> list;
    for (const Named& solver : solvers) list.emplace_back(solver.name);
    return list;
  }();
  return names;
}

TagPoseSolver make_opencv_solver(const std::string& name) {
  std::string known;
  for (const Named& solver : solvers) {
    if (name == solver.name) return solver.solve;
    known += (known.empty() ? "" : ", ") + std::string(solver.name);
  }
  throw std::runtime_error("unknown OpenCV solver '" + name + "'; known are " + known);
}

}  // namespace plumbline::pose
