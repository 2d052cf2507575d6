// A free network of tags brought into the frame of a survey by the points that both know.
#pragma once

#include <string>
#include <vector>

#include "geometry/similarity.hpp"
#include "photo/markers/marker_block.hpp"

namespace plumbline::markers {

/// A surveyed point and the tag that shows it.
struct SurveyedTag {
  int marker = 0;  ///< index into MarkerBlock::markers
  std::string name;
  Eigen::Vector3d position = Eigen::Vector3d::Zero();             ///< of the point, in the survey's frame [m]
  Eigen::Vector3d tag_centre_in_plate = Eigen::Vector3d::Zero();  ///< seen from the point, axes of the tag [m]
  bool check =
      false;  ///< a check point: it has no part in the motion, and is looked at only to say whose place is whose
};

struct SurveyFrame {
  SimilarityMotion motion;             ///< from the network's frame to the survey's
  std::vector<Eigen::Vector3d> found;  ///< where the network has each surveyed point [m]; nan: it does not hold it
  std::vector<double> distance;        ///< of each from where the survey has it [m]; nan likewise
  std::vector<bool> agrees;            ///< those that the motion was fitted to
};

/// Points agree to 50 mm, or to half of the distance of the closest two: exchanged ones do not. Throws
/// std::runtime_error: fewer than three of them are in the network, or they lie on one line.
SurveyFrame fit_to_survey(const MarkerResult& network, const std::vector<SurveyedTag>& surveyed);

/// cam_from_survey of an image of the network.
RigidTransform in_survey_frame(const SurveyFrame& frame, const RigidTransform& cam_from_network);

}  // namespace plumbline::markers
