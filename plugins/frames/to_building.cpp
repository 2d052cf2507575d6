#include "frames/to_building.hpp"

#include <cmath>
#include <limits>
#include <map>

#include "geometry/packed_symmetric.hpp"
#include "ifc/georeference.hpp"

namespace plumbline::frames {
namespace {

using bim::CommonPoints;
using bim::PlanTransform;

CommonPoints common_points(const PointsT& survey, const PointsT& design) {
  std::map<std::string, const PointT*> known;
  for (const auto& point : design.points) known[point->id] = point.get();
  CommonPoints common;
  for (const auto& point : survey.points) {
    const auto found = known.find(point->id);
    if (found == known.end() || !point->position.allFinite() || !found->second->position.allFinite()) continue;
    common.ids.push_back(point->id);
    common.survey.push_back(point->position), common.design.push_back(found->second->position);
  }
  return common;
}

std::vector<bim::Reading> readings(const DesignT& design) {
  if (!design.map_conversion) return {};
  const DesignMapConversionT& map = *design.map_conversion;
  return bim::readings_of({map.eastings, map.northings, map.orthogonal_height, map.x_axis_abscissa, map.x_axis_ordinate,
                           map.scale, map.scale_given, map.crs_name, map.map_unit},
                          design.length_unit);
}

/// What is applied: survey_from_design, and the covariance of (angle, translation).
struct Choice {
  PlanTransform transform;
  Eigen::Matrix4d covariance = Eigen::Matrix4d::Zero();
};

/// Positions and their covariance; what all have in common through the transform is added to it.
PointsT moved(const PointsT& points, const Choice& choice) {
  PointsT out = points;
  const auto n = static_cast<Eigen::Index>(points.points.size());
  const double c = std::cos(choice.transform.angle), s = std::sin(choice.transform.angle),
               k = 1 / choice.transform.scale;
  Eigen::Matrix3d turn;
  turn << k * c, k * s, 0, -k * s, k * c, 0, 0, 0, 1;
  Eigen::MatrixXd common(3 * n, 4);
  for (Eigen::Index i = 0; i < n; ++i) {
    auto& point = out.points[static_cast<std::size_t>(i)];
    const Eigen::Vector3d from = point->position;
    point->position = bim::design_from_survey(choice.transform, from);
    // p = k R(-angle)(q - t): by the angle it moves by -up × (what R turns), by t against it.
    const Eigen::Vector3d arm = turn * (from - choice.transform.translation);
    common.block<3, 1>(3 * i, 0) = Eigen::Vector3d(arm.y(), -arm.x(), 0);
    common.block<3, 3>(3 * i, 1) = -turn;
  }
  const bool uncertain = choice.covariance.cwiseAbs().maxCoeff() > 0;
  if (points.covariance.empty() && !uncertain) {
    for (auto& point : out.points) point->sigma = (turn.cwiseAbs2() * point->sigma.cwiseAbs2()).cwiseSqrt();
    return out;
  }
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(3 * n, 3 * n);
  if (!points.covariance.empty())
    covariance = unpack_symmetric(points.covariance, static_cast<std::size_t>(3 * n), "input 'points'");
  else
    for (Eigen::Index i = 0; i < n; ++i)
      covariance.block<3, 3>(3 * i, 3 * i) = points.points[static_cast<std::size_t>(i)]->sigma.cwiseAbs2().asDiagonal();
  for (Eigen::Index i = 0; i < n; ++i)
    covariance.middleRows<3>(3 * i) = (turn * covariance.middleRows<3>(3 * i)).eval();
  for (Eigen::Index i = 0; i < n; ++i)
    covariance.middleCols<3>(3 * i) = (covariance.middleCols<3>(3 * i) * turn.transpose()).eval();
  if (uncertain) covariance += common * choice.covariance * common.transpose();
  out.covariance = pack_symmetric(covariance);
  for (Eigen::Index i = 0; i < n; ++i)
    out.points[static_cast<std::size_t>(i)]->sigma = covariance.diagonal().segment<3>(3 * i).cwiseMax(0).cwiseSqrt();
  return out;
}

TransformT artifact_of(const Choice& choice) {
  TransformT out;
  const double angle = -choice.transform.angle;
  out.to_from_from.rotation = Eigen::Quaterniond(std::cos(angle / 2), 0, 0, std::sin(angle / 2));
  out.scale = 1 / choice.transform.scale;
  out.to_from_from.translation = bim::design_from_survey(choice.transform, Eigen::Vector3d::Zero());
  if (choice.covariance.cwiseAbs().maxCoeff() == 0) return out;
  // (rotation vector, translation) of building_from_survey, to first order: the turn reversed, the shift turned back.
  const double c = std::cos(choice.transform.angle), s = std::sin(choice.transform.angle);
  Eigen::Matrix3d turn;
  turn << c, s, 0, -s, c, 0, 0, 0, 1;
  const Eigen::Vector3d& t = out.to_from_from.translation;
  Eigen::Matrix<double, 6, 4> rows = Eigen::Matrix<double, 6, 4>::Zero();
  rows(2, 0) = -1;
  rows.block<3, 1>(3, 0) = Eigen::Vector3d(t.y(), -t.x(), 0);
  rows.block<3, 3>(3, 1) = -turn;
  const Eigen::Matrix<double, 6, 6> covariance = rows * choice.covariance * rows.transpose();
  for (int i = 0; i < 6; ++i)
    for (int j = 0; j <= i; ++j) out.covariance.push_back(covariance(i, j));
  return out;
}

}  // namespace

void ToBuilding::run(Context& context) {
  const PointsT survey = points.unpack();
  const DesignT read = design.unpack();
  const CommonPoints common = common_points(survey, designed.unpack());
  const auto known = readings(read);
  const std::string& how = *use;
  Choice choice;
  if (how == "fitted") {
    choice.transform = bim::fit_plan(common, choice.covariance);
    context.warn(
        "the survey was fitted to the design by its anchors (shift and turn): a common shift of the building cannot be "
        "seen");
  } else if (how == "given") {
    if (translation->size() != 3)
      throw std::runtime_error("parameter 'translation' has " + std::to_string(translation->size()) +
                               " numbers, expected E N H of the design's origin with use=given");
    choice.transform = {*rotation, *grid_scale, Eigen::Vector3d(translation->data())};
    if (!sigmas->empty() && sigmas->size() != 4)
      throw std::runtime_error("parameter 'sigmas' has " + std::to_string(sigmas->size()) +
                               " numbers, expected four: rotation, E, N, H");
    for (std::size_t i = 0; i < sigmas->size(); ++i)
      choice.covariance(static_cast<int>(i), static_cast<int>(i)) = (*sigmas)[i] * (*sigmas)[i];
  } else if (how != "same") {
    const auto reading = std::find_if(known.begin(), known.end(), [&](const bim::Reading& r) { return r.use == how; });
    if (reading == known.end())
      throw std::runtime_error(known.empty() ? read.file_name +
                                                   " has no map conversion; frames.with.use=given takes numbers, "
                                                   "frames.with.use=fitted the anchors"
                                             : "the map conversion of " + read.file_name +
                                                   " reads the same with use=map_conversion: take that");
    choice.transform = reading->transform;
  }
  const double left = bim::misfit(common, choice.transform);
  if (how == "same") {
    if (const std::string gap = bim::explain_gap(common, known, read.file_name); !gap.empty())
      throw std::runtime_error(gap);
  } else if (left > 1) {
    const std::string gap = bim::explain_gap(common, known, read.file_name);
    throw std::runtime_error("with frames.with.use=" + how + " the survey is " + std::to_string(left) +
                             " m from the design (median)" + (gap.empty() ? "; without it, it is not" : "; " + gap));
  }
  if (common.ids.empty())
    context.warn("survey and design name no anchor alike, so nothing shows that they share a frame");
  else
    context.metric("misfit_of_survey_and_design", left, "m");
  building.commit(moved(survey, choice));
  PlatesT turned = plates.unpack();
  const double angle = -choice.transform.angle;
  const Eigen::Quaterniond turn(std::cos(angle / 2), 0, 0, std::sin(angle / 2));
  for (auto& plate : turned.plates) plate->nominal_rotation = (turn * plate->nominal_rotation).normalized();
  building_plates.commit(turned);
  transform.commit(artifact_of(choice));
}

}  // namespace plumbline::frames
