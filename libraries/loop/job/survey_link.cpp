#include "loop/job/survey_link.hpp"

#include <cmath>
#include <stdexcept>

#include "artifacts/frame_artifact.hpp"

namespace plumbline::loop {
namespace {

/// The step that all three numbers are multiples of: a millimetre, a tenth of one; nan: finer.
double step_of(const Eigen::Vector3d& place) {
  constexpr double kRepresented = 1e-7;  // by doubles, some thousands of kilometres from the origin
  for (const double step : {1e-3, 1e-4}) {
    const Eigen::Vector3d rounded = step * (place / step).array().round();
    if ((place - rounded).cwiseAbs().maxCoeff() < kRepresented) return step;
  }
  return std::nan("");
}

}  // namespace

SurveyLink survey_link(const TransformT& building_from_survey) {
  FrameLink link = frame_link(building_from_survey, "building", "survey");
  // How well the whole is known to stand as designed (datum_sigma) makes no second frame of one.
  const bool is_same = link.linear() == Eigen::Matrix3d::Identity() && link.to_from_from.translation.isZero(0);
  if (is_same) return std::nullopt;
  constexpr double kLevel = 1e-6;  // a tenth of a millimetre in a hundred metres
  const Eigen::Vector3d up = link.to_from_from.rotation * Eigen::Vector3d::UnitZ();
  if (const double lean = up.head<2>().norm(); lean > kLevel)
    throw std::runtime_error("the survey leans by " + std::to_string(1e3 * lean) +
                             " mm per metre against the design (" + link.origin +
                             "): no tool and no robot can be set up in such a frame; expected one whose heights are "
                             "vertical: frames.with.use=fitted, map_conversion or given");
  return link;
}

FrameLink link_about(const FrameLink& building_from_survey, const Eigen::Vector3d& place) {
  FrameLink out = building_from_survey;
  const Eigen::Vector3d arm = out.to_from_from.rotation * place,
                        scales(out.scale, out.scale, out.plan_only ? 1.0 : out.scale);
  out.to_from_from.translation = building_from_survey.apply(place);
  // A small turn r moves the place by S (r x arm), a change of scale by the arm.
  Matrix7 change = Matrix7::Identity();
  change.block<3, 3>(3, 0) = -(scales.asDiagonal() * skew(arm));
  change.block<3, 1>(3, 6) = arm.cwiseProduct(Eigen::Vector3d(1, 1, out.plan_only ? 0 : 1));
  out.covariance = change * out.covariance * change.transpose();
  return out;
}

void bring_to_building(ActualT& actual, const SurveyLink& survey) {
  if (!actual.measured.allFinite()) return;
  actual.step = step_of(actual.measured);
  if (!survey) return;
  const Eigen::Vector3d east = survey->to_from_from.rotation * Eigen::Vector3d::UnitX();
  actual.written_turn = std::atan2(east.y(), east.x());
  actual.measured = survey->apply(actual.measured);
  actual.sigma = (survey->linear().cwiseAbs2() * actual.sigma.cwiseAbs2()).cwiseSqrt();
}

}  // namespace plumbline::loop
