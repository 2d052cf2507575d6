#include "photo/markers/survey_frame.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <stdexcept>

#include "photo/markers/robust_similarity.hpp"

namespace plumbline::markers {

namespace {

/// [m] A start; blunders are found by the adjustment, if they are not exchanged neighbours.
double tolerance_among(const std::vector<SurveyedTag>& surveyed) {
  constexpr double largest = 0.05, smallest = 0.005;
  double closest = 2 * largest;
  for (size_t k = 0; k < surveyed.size(); ++k)
    for (size_t l = k + 1; l < surveyed.size(); ++l)
      closest = std::min(closest, (surveyed[k].position - surveyed[l].position).norm());
  return std::max(smallest, closest / 2);
}

}  // namespace

SurveyFrame fit_to_survey(const MarkerResult& network, const std::vector<SurveyedTag>& surveyed) {
  const double tolerance = tolerance_among(surveyed);
  std::map<int, const AdjustedMarker*> placed;
  for (const auto& marker : network.markers) placed[marker.marker] = &marker;
  std::vector<size_t> used;
  for (size_t k = 0; k < surveyed.size(); ++k)
    if (placed.count(surveyed[k].marker) && !surveyed[k].check) used.push_back(k);
  SurveyFrame frame;
  frame.found.assign(surveyed.size(), Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN()));
  frame.distance.assign(surveyed.size(), std::numeric_limits<double>::quiet_NaN());
  frame.agrees.assign(surveyed.size(), false);
  RobustSimilarity fit;
  const auto in_network = [&](size_t k, double scale) -> Eigen::Vector3d {
    const RigidTransform& tag = placed.at(surveyed[k].marker)->world_from_tag;
    return tag.translation - tag.rotation * surveyed[k].tag_centre_in_plate / scale;
  };
  // Offsets on the plate are metres, the network's unit may be none: its scale comes from the pass before.
  for (int pass = 0; pass < 3; ++pass) {
    std::vector<Eigen::Vector3d> from, to;
    for (const size_t k : used) {
      from.push_back(in_network(k, pass == 0 ? 1 : fit.motion.scale));
      to.push_back(surveyed[k].position);
    }
    fit = fit_similarity_robustly(from, to, tolerance);
  }
  frame.motion = fit.motion;
  for (size_t m = 0; m < used.size(); ++m) frame.agrees[used[m]] = fit.agrees[m];
  for (size_t k = 0; k < surveyed.size(); ++k) {
    if (!placed.count(surveyed[k].marker)) continue;
    frame.found[k] = frame.motion * in_network(k, frame.motion.scale);
    frame.distance[k] = (frame.found[k] - surveyed[k].position).norm();
  }
  return frame;
}

RigidTransform in_survey_frame(const SurveyFrame& frame, const RigidTransform& cam_from_network) {
  const Eigen::Vector3d centre = frame.motion * cam_from_network.inverse().translation;
  const Eigen::Quaterniond rotation = (cam_from_network.rotation * frame.motion.rotation.conjugate()).normalized();
  return {rotation, -(rotation * centre)};
}

}  // namespace plumbline::markers
