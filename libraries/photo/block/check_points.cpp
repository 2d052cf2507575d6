#include "photo/block/check_points.hpp"

#include <fmt/core.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <limits>

#include "geometry/statistics.hpp"

namespace plumbline::block {

namespace {

constexpr double kRisk = 1e-3;

double nees_of(const Eigen::VectorXd& d, const Eigen::MatrixXd& covariance) {
  const Eigen::LLT<Eigen::MatrixXd> factor(covariance);
  if (factor.info() == Eigen::Success) return d.dot(factor.solve(d));
  return d.isZero(0) ? 0 : std::numeric_limits<double>::infinity();
}

std::string triple(const Eigen::Vector3d& v) {
  return fmt::format("{:.1f}, {:.1f}, {:.1f} mm", 1e3 * v.x(), 1e3 * v.y(), 1e3 * v.z());
}

std::string words_of(const JudgedCheckPoint& point, const Eigen::Vector3d& sigma) {
  const std::string text = fmt::format(" (largest |w| {:.1f})", point.w.cwiseAbs().maxCoeff());
  return "check point " + point.name + " contradicts the block: it is off by " + triple(point.difference) +
         ", where the standard deviations of block and survey are " + triple(sigma) + text +
         ". Its coordinates, its name or a measurement of it is wrong, or the block is worse there than it states";
}

}  // namespace

double check_limit(std::size_t points) {
  const double level = -std::expm1(std::log1p(-kRisk) / static_cast<double>(points == 0 ? 1 : points));
  return chi_squared_quantile(1 - level, 3);
}

CheckJudgement judge_check_points(const std::vector<std::string>& names, const Eigen::VectorXd& differences,
                                  const Eigen::MatrixXd& covariance, bool joint) {
  CheckJudgement result;
  result.limit = check_limit(names.size());
  std::vector<Eigen::Index> agreeing;
  for (std::size_t i = 0; i < names.size(); ++i) {
    const Eigen::Index at = 3 * static_cast<Eigen::Index>(i);
    const Eigen::Matrix3d own = covariance.block<3, 3>(at, at);
    const Eigen::Vector3d sigma = own.diagonal().cwiseMax(0).cwiseSqrt();
    JudgedCheckPoint point{names[i], differences.segment<3>(at), {}, 0, false};
    point.w = point.difference.cwiseQuotient(sigma);
    point.nees = nees_of(point.difference, own);
    point.contradicts = !(point.nees <= result.limit);
    if (point.contradicts)
      result.words.push_back(words_of(point, sigma));
    else
      agreeing.insert(agreeing.end(), {at, at + 1, at + 2});
    result.points.push_back(point);
  }
  result.holds = result.words.empty();
  if (!joint || agreeing.size() < 6) return result;  // one point alone was judged above
  result.freedom = static_cast<double>(agreeing.size());
  result.nees = nees_of(differences(agreeing), covariance(agreeing, agreeing));
  result.joint_limit = chi_squared_quantile(1 - kRisk, result.freedom);
  if (result.nees <= result.joint_limit) return result;
  result.holds = false;
  result.words.push_back(
      fmt::format("the check points together are off by more than the standard deviations of block and survey state: "
                  "NEES {:.0f} of {:.0f} degrees of freedom (at most {:.0f}). They are about {:.1f} times too small",
                  result.nees, result.freedom, result.joint_limit, std::sqrt(result.nees / result.freedom)));
  return result;
}

}  // namespace plumbline::block
