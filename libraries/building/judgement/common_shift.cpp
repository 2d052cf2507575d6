#include "building/judgement/common_shift.hpp"

#include <fmt/core.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <optional>

#include "geometry/median.hpp"
#include "geometry/statistics.hpp"
#include "plumbline/rigid_transform.hpp"

namespace plumbline::judgement {
namespace {

using Eigen::Index;

constexpr double kTukey = 4.685;
/// Below this a scatter is rounding [m]: exact test data, or a design that was made from the measurement.
constexpr double kSmallestScatter = 2e-5;

/// Rows of d = t + r × (p − c), the rotation in units that move the farthest anchor by one metre.
struct Motion {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  double reach = 1e-3;
  Eigen::MatrixXd rows;  ///< 3n x 6

  explicit Motion(const std::vector<Eigen::Vector3d>& positions) {
    for (const auto& p : positions) centre += p / static_cast<double>(positions.size());
    for (const auto& p : positions) reach = std::max(reach, (p - centre).norm());
    rows.resize(3 * static_cast<Index>(positions.size()), 6);
    for (std::size_t i = 0; i < positions.size(); ++i) {
      rows.block<3, 3>(3 * static_cast<Index>(i), 0).setIdentity();
      rows.block<3, 3>(3 * static_cast<Index>(i), 3) = -skew((positions[i] - centre) / reach);
    }
  }
};

struct Fit {
  Eigen::Matrix<double, 6, 1> x = Eigen::Matrix<double, 6, 1>::Zero();
  Eigen::MatrixXd gain;                                                        ///< 6 x 3n: x = gain · d
  Eigen::Matrix<double, 6, 6> cofactor = Eigen::Matrix<double, 6, 6>::Zero();  ///< pseudo-inverse of the normal matrix
  Eigen::VectorXd weights;                                                     ///< one an anchor
  double scatter = 0;
  Eigen::Vector3d scale = Eigen::Vector3d::Zero();   ///< robust scatter along x, y, z
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();  ///< covariance of what is left of an anchor
  int rank = 0, freedom = 0;                         ///< freedom: of `spread`
};

/// Weighted solution; motions that the anchors cannot tell (a turn about their own line) stay zero.
void solve(const Motion& motion, const Eigen::VectorXd& d, Fit& fit) {
  Eigen::VectorXd w(d.size());
  for (Index i = 0; i < d.size(); ++i) w[i] = fit.weights[i / 3];
  const Eigen::MatrixXd weighted = motion.rows.transpose() * w.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, 6, 6>> eigen(weighted * motion.rows);
  const double limit = 1e-4 * eigen.eigenvalues().maxCoeff();
  fit.cofactor.setZero(), fit.rank = 0;
  for (int k = 0; k < 6; ++k) {
    if (!(eigen.eigenvalues()[k] > limit)) continue;
    ++fit.rank;
    fit.cofactor += eigen.eigenvectors().col(k) * eigen.eigenvectors().col(k).transpose() / eigen.eigenvalues()[k];
  }
  fit.gain = fit.cofactor * weighted;
  fit.x = fit.gain * d;
}

/// What is farther off than this along an axis does not count [m].
Eigen::Vector3d reach_of(const Fit& fit) { return kTukey * fit.scale; }

/// What stood out is left out, the rest counts alike. What was cut off belongs to the scatter all the same: it is taken
/// as far off as the cut (the winsorised variance of a trimmed mean, Tukey and McLaughlin 1963).
void least_squares_of_the_rest(const Motion& motion, const Eigen::VectorXd& d, Fit& fit) {
  fit.weights = (fit.weights.array() > 0).cast<double>();
  const int kept = static_cast<int>(fit.weights.sum());
  if (kept < 4) return;
  solve(motion, d, fit);
  const Eigen::VectorXd residual = d - motion.rows * fit.x;
  const Eigen::Vector3d reach = reach_of(fit);
  double squares = 0;
  for (Index i = 0; i < fit.weights.size(); ++i) {
    const Eigen::Vector3d r = residual.segment<3>(3 * i), cut = r.cwiseMin(reach).cwiseMax(-reach);
    fit.spread += cut * cut.transpose(), squares += fit.weights[i] * r.squaredNorm();
  }
  fit.scatter = std::max(std::sqrt(squares / (3 * kept - fit.rank)), kSmallestScatter);
  fit.freedom = kept - (fit.rank + 2) / 3;
  const double n = static_cast<double>(fit.weights.size());
  fit.spread *= n / kept / std::max(1.0, n - (fit.rank + 2) / 3);
  fit.spread += kSmallestScatter * kSmallestScatter * Eigen::Matrix3d::Identity();
}

/// Of the motion, by what anchors scatter about it: more out of a facade's plane than in height, or the other way
/// round.
Eigen::Matrix<double, 6, 6> covariance_of_motion(const Fit& fit) {
  Eigen::Matrix<double, 6, 6> s = Eigen::Matrix<double, 6, 6>::Zero();
  for (Index i = 0; i < fit.weights.size(); ++i)
    s += fit.gain.middleCols<3>(3 * i) * fit.spread * fit.gain.middleCols<3>(3 * i).transpose();
  return s;
}

Fit robust_fit(const Motion& motion, const Eigen::VectorXd& d) {
  const Index n = d.size() / 3;
  Fit fit;
  fit.weights = Eigen::VectorXd::Ones(n);
  for (int k = 0; k < 3; ++k) {
    std::vector<double> values;
    for (Index i = 0; i < n; ++i) values.push_back(d[3 * i + k]);
    fit.x[k] = upper_median(values);
  }
  for (int iteration = 0; iteration < 30; ++iteration) {
    const Eigen::VectorXd residual = d - motion.rows * fit.x;
    for (Index k = 0; k < 3; ++k) {
      std::vector<double> sizes;
      for (Index i = 0; i < n; ++i) sizes.push_back(std::abs(residual[3 * i + k]));
      fit.scale[k] = std::max(1.4826 * upper_median(sizes), kSmallestScatter);
    }
    for (Index i = 0; i < n; ++i) {
      const double u = residual.segment<3>(3 * i).cwiseAbs().cwiseQuotient(reach_of(fit)).maxCoeff();
      fit.weights[i] = u < 1 ? (1 - u * u) * (1 - u * u) : 0;
    }
    if ((fit.weights.array() > 0).count() < 4) break;
    const Eigen::Matrix<double, 6, 1> before = fit.x;
    solve(motion, d, fit);
    if ((fit.x - before).norm() < 1e-9) break;
  }
  least_squares_of_the_rest(motion, d, fit);
  return fit;
}

std::string finding_of(const CommonShiftT& shift) {
  const auto mm = [](double metres) { return fmt::format("{:+.1f} mm", 1e3 * metres); };
  std::string words = std::to_string(shift.following) + " of " + std::to_string(shift.anchors) +
                      " anchors are shifted together by " + mm(shift.shift.x()) + " in x, " + mm(shift.shift.y()) +
                      " in y, " + mm(shift.shift.z()) + " in z";
  if (shift.rotation.norm() > 1e-7) {
    words +=
        fmt::format(", and turned by {:.3f} mrad about ({:.2f} {:.2f} {:.2f})", 1e3 * shift.rotation.norm(),
                    shift.rotation.normalized().x(), shift.rotation.normalized().y(), shift.rotation.normalized().z());
  }
  return words;
}

/// `passing`: anchors that pass as they are; nothing where no anchor can pass.
std::string words_of(const CommonShiftT& shift, std::optional<int> passing) {
  std::string words =
      shift.finding +
      ": the survey and the design do not share their datum, or the building stands elsewhere. Check control points "
      "and grid lines before any anchor is mended";
  if (passing)
    words += "; without the common part " + std::to_string(shift.would_pass) + " of " + std::to_string(shift.anchors) +
             " would pass instead of " + std::to_string(*passing);
  return words + ".";
}

}  // namespace

std::unique_ptr<CommonShiftT> common_shift(
    const std::vector<Eigen::Vector3d>& positions, const std::vector<Eigen::Vector3d>& deviations,
    const judgement::BlockCovariance& covariance, double smallest_tolerance,
    const std::function<int(const std::vector<Eigen::Vector3d>& corrected)>& would_pass) {
  const auto n = static_cast<Index>(positions.size());
  if (n < 4) return nullptr;
  const Motion motion(positions);
  Eigen::VectorXd d(3 * n);
  for (Index i = 0; i < n; ++i) d.segment<3>(3 * i) = deviations[i];
  const Fit fit = robust_fit(motion, d);
  auto out = std::make_unique<CommonShiftT>();
  out->anchors = static_cast<int>(n);
  out->following = static_cast<int>((fit.weights.array() > 0).count());
  out->shift = fit.x.head<3>(), out->rotation = fit.x.tail<3>() / motion.reach, out->centre = motion.centre;
  out->scatter = fit.scatter;
  const Eigen::VectorXd moved = motion.rows * fit.x;
  out->largest_effect = 0;
  std::vector<Eigen::Vector3d> corrected;
  for (Index i = 0; i < n; ++i) {
    out->largest_effect = std::max(out->largest_effect, moved.segment<3>(3 * i).norm());
    corrected.push_back(d.segment<3>(3 * i) - moved.segment<3>(3 * i));
  }
  if (fit.rank == 0 || fit.freedom <= 2) return out;
  Eigen::Matrix<double, 6, 6> s = covariance_of_motion(fit);
  for (const auto& cluster : covariance.clusters()) {
    Eigen::MatrixXd gain(6, cluster.matrix.rows());
    for (std::size_t k = 0; k < cluster.items.size(); ++k)
      gain.middleCols<3>(3 * static_cast<Index>(k)) = fit.gain.middleCols<3>(3 * cluster.items[k]);
    s += gain * cluster.matrix.times(gain.transpose());
  }
  if (const Eigen::MatrixXd& common = covariance.common(); common.size() > 0) {
    Eigen::Matrix<double, 6, 3> gain = Eigen::Matrix<double, 6, 3>::Zero();
    for (Index i = 0; i < n; ++i) gain += fit.gain.middleCols<3>(3 * i);
    s += gain * common * gain.transpose();
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, 6, 6>> eigen(s);
  out->statistic = 0;
  for (int k = 0; k < 6; ++k)
    if (eigen.eigenvalues()[k] > 1e-12 * eigen.eigenvalues().maxCoeff())
      out->statistic += std::pow(eigen.eigenvectors().col(k).dot(fit.x), 2) / eigen.eigenvalues()[k];
  // Hotelling's T², as the scatter of three directions was estimated.
  const double f = fit.freedom;
  out->critical = fit.rank * f / (f - 2) * fisher_f_quantile(0.999, fit.rank, f - 2);
  out->significant = out->statistic > out->critical && 3 * out->following >= 2 * out->anchors &&
                     out->largest_effect >= 0.5 * smallest_tolerance;
  if (!out->significant) return out;
  if (would_pass) out->would_pass = would_pass(corrected);
  for (Index i = 0; i < n; ++i)
    if (fit.weights[i] > 0) out->members.push_back(static_cast<int>(i));
  out->finding = finding_of(*out);
  out->words = words_of(*out, would_pass ? std::optional<int>(would_pass(deviations)) : std::nullopt);
  return out;
}

}  // namespace plumbline::judgement
