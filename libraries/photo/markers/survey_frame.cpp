#include "photo/markers/survey_frame.hpp"

#include <cmath>
#include <limits>
#include <map>
#include <stdexcept>

#include "photo/markers/robust_similarity.hpp"

namespace plumbline::markers {

SurveyFrame fit_to_survey(const MarkerResult& network, const std::vector<SurveyedTag>& surveyed) {
  constexpr double tolerance = 0.05;  // [m]: a start; blunders are found by the adjustment
  std::map<int, const AdjustedMarker*> placed;
  for (const auto& marker : network.markers) placed[marker.marker] = &marker;
  std::vector<size_t> used;
  for (size_t k = 0; k < surveyed.size(); ++k)
    if (placed.count(surveyed[k].marker)) used.push_back(k);
  SurveyFrame frame;
  frame.distance.assign(surveyed.size(), std::numeric_limits<double>::quiet_NaN());
  frame.agrees.assign(surveyed.size(), false);
  RobustSimilarity fit;
  // Offsets on the plate are metres, the network's unit may be none: its scale comes from the pass before.
  for (int pass = 0; pass < 3; ++pass) {
    std::vector<Eigen::Vector3d> from, to;
    for (const size_t k : used) {
      const RigidTransform& tag = placed.at(surveyed[k].marker)->world_from_tag;
      const double scale = pass == 0 ? 1 : fit.motion.scale;
      from.push_back(tag.translation - tag.rotation * surveyed[k].tag_centre_in_plate / scale);
      to.push_back(surveyed[k].position);
    }
    fit = fit_similarity_robustly(from, to, tolerance);
  }
  frame.motion = fit.motion;
  for (size_t m = 0; m < used.size(); ++m)
    frame.distance[used[m]] = fit.distances[m], frame.agrees[used[m]] = fit.agrees[m];
  return frame;
}

RigidTransform in_survey_frame(const SurveyFrame& frame, const RigidTransform& cam_from_network) {
  const Eigen::Vector3d centre = frame.motion * cam_from_network.inverse().translation;
  const Eigen::Quaterniond rotation = (cam_from_network.rotation * frame.motion.rotation.conjugate()).normalized();
  return {rotation, -(rotation * centre)};
}

}  // namespace plumbline::markers
