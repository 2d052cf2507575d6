#include "place/frames/fitted_frame.hpp"

#include <fmt/core.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "geometry/median.hpp"
#include "geometry/similarity.hpp"

namespace plumbline::frames {
namespace {

using ifc::CommonPoints;

CommonPoints subset(const CommonPoints& common, const std::vector<int>& used) {
  CommonPoints out;
  for (const int i : used) {
    out.ids.push_back(common.ids[i]);
    out.survey.push_back(common.survey[i]), out.design.push_back(common.design[i]);
  }
  return out;
}

void require_figure(const std::vector<Eigen::Vector3d>& points) {
  constexpr double kWidth = 0.5;  // [m], as of a level fit
  const auto n = static_cast<double>(points.size());
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& p : points) middle += p / n;
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  for (const Eigen::Vector3d& p : points) scatter += (p - middle) * (p - middle).transpose() / n;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(scatter, Eigen::EigenvaluesOnly);
  if (axes.eigenvalues()(1) < kWidth * kWidth)
    throw std::runtime_error("the anchors that survey and design both name lie in one line: the turn about it is open");
}

RigidTransform least_squares(const CommonPoints& points, Freedom freedom) {
  RigidTransform found;
  if (freedom == Freedom::space) {
    require_figure(points.design);
    const SimilarityMotion motion = fit_similarity(points.survey, points.design, false);
    found.rotation = motion.rotation, found.translation = motion.translation;
    return found;
  }
  Eigen::Matrix4d unused;
  const ifc::PlanTransform plan = ifc::fit_plan(points, unused);
  const double angle = 0 - plan.angle;  // and not -0
  found.rotation = Eigen::Quaterniond(std::cos(angle / 2), 0, 0, std::sin(angle / 2));
  found.translation = ifc::design_from_survey(plan, Eigen::Vector3d::Zero());
  return found;
}

/// Anchors that lie within 4.03 standard deviations (99.9 % of chi-squared with 3 degrees of freedom) of where `way`
/// puts them; the standard deviation is that of the median, and no building is set better than to 2 mm.
std::vector<int> following(const CommonPoints& common, const RigidTransform& way) {
  constexpr double kMedianOfChi3 = 1.5382, kRejected = 4.0333, kSetByHand = 0.002;
  std::vector<double> distances;
  for (std::size_t i = 0; i < common.ids.size(); ++i)
    distances.push_back((way * common.survey[i] - common.design[i]).norm());
  const double sigma = std::max(median(distances) / kMedianOfChi3, kSetByHand);
  std::vector<int> used;
  for (std::size_t i = 0; i < distances.size(); ++i)
    if (distances[i] <= kRejected * sigma) used.push_back(static_cast<int>(i));
  return used;
}

using Matrix6 = Eigen::Matrix<double, 6, 6>;

/// Of (rotation vector in the building, translation): an anchor at p moves by w x (p - middle) + s, the shift s and the
/// turn w being independent of each other, each of this variance at the anchors [m²].
Matrix6 covariance_at(const CommonPoints& points, const RigidTransform& building_from_survey, Freedom freedom,
                      double variance) {
  const auto n = static_cast<double>(points.ids.size());
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& p : points.design) middle += p / n;
  Eigen::Matrix3d turns = Eigen::Matrix3d::Zero();
  for (const Eigen::Vector3d& p : points.design) {
    const Eigen::Matrix3d arm = skew(p - middle);
    turns += arm.transpose() * arm;
  }
  Matrix6 own = Matrix6::Zero(), to_origin = Matrix6::Identity();
  if (freedom == Freedom::space)
    own.topLeftCorner<3, 3>() = variance * n * turns.inverse();
  else if (turns(2, 2) > 0)
    own(2, 2) = variance * n / turns(2, 2);
  own.bottomRightCorner<3, 3>() = variance * Eigen::Matrix3d::Identity();
  to_origin.bottomLeftCorner<3, 3>() = -skew(building_from_survey.translation - middle);
  return to_origin * own * to_origin.transpose();
}

/// Of one axis of the mean, from what the fit leaves of the anchors.
double variance_of_fit(const CommonPoints& points, const RigidTransform& building_from_survey, Freedom freedom) {
  const auto n = static_cast<double>(points.ids.size());
  double squares = 0;
  for (std::size_t i = 0; i < points.ids.size(); ++i)
    squares += (building_from_survey * points.survey[i] - points.design[i]).squaredNorm();
  return squares / (3 * n - (freedom == Freedom::space ? 6 : 4)) / n;
}

std::string origin_words(const CommonPoints& common, const CommonPoints& used) {
  if (used.ids.size() == common.ids.size()) return fmt::format("fitted to {} anchors", common.ids.size());
  std::string names;
  std::size_t told = 0, u = 0;
  constexpr std::size_t kNamed = 5;
  for (const std::string& id : common.ids) {
    if (u < used.ids.size() && used.ids[u] == id) {
      ++u;
    } else if (++told <= kNamed) {
      names += (names.empty() ? "" : ", ") + id;
    }
  }
  if (told > kNamed) names += fmt::format(" and {} more", told - kNamed);
  return fmt::format("fitted to {} of {} anchors, without {}, which stand elsewhere", used.ids.size(),
                     common.ids.size(), names);
}

}  // namespace

FrameLink fit_frame(const CommonPoints& common, Freedom freedom, double datum_sigma) {
  if (common.ids.size() < 4)
    throw std::runtime_error(fmt::format(
        "the design can be fitted to four anchors or more that survey and design both name, found {}: with fewer "
        "nothing is left to judge them by",
        common.ids.size()));
  CommonPoints used = common;
  FrameLink link;
  link.to = "building", link.from = "survey";
  link.to_from_from = least_squares(used, freedom);
  constexpr int kRounds = 20;  // three mostly; sets that take turns end it
  std::vector<int> last;
  for (int round = 0; round < kRounds; ++round) {
    const std::vector<int> now = following(common, link.to_from_from);
    if (now == last) break;
    last = now, used = subset(common, now);
    link.to_from_from = least_squares(used, freedom);
  }
  link.origin = origin_words(common, used);
  link.plan_only = freedom == Freedom::level;
  link.covariance.topLeftCorner<6, 6>() =
      covariance_at(used, link.to_from_from, freedom, variance_of_fit(used, link.to_from_from, freedom));
  add_datum(used, freedom, datum_sigma, link);
  return link;
}

void add_datum(const CommonPoints& common, Freedom freedom, double datum_sigma, FrameLink& link) {
  if (!std::isfinite(datum_sigma) || common.ids.empty()) return;
  link.covariance.topLeftCorner<6, 6>() += covariance_at(common, link.to_from_from, freedom, datum_sigma * datum_sigma);
}

}  // namespace plumbline::frames
