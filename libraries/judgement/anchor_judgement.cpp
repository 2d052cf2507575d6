// One anchor: its lengths against their tolerances, and the probability that it is within all of them.
#include <Eigen/Eigenvalues>
#include <array>
#include <cmath>

#include "geometry/statistics.hpp"
#include "judgement/deviation.hpp"
#include "judgement/tolerance.hpp"

namespace plumbline::judgement {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

/// One to three directions; no heap.
using Span = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor, 3, 3>;

/// Directions that span what an axis measures: one for a signed length, two or three for the length of a vector.
Span span_of(Axis axis, const Eigen::Vector3d& normal) {
  const Eigen::Vector3d up = Eigen::Vector3d::UnitZ();
  Span rows;
  switch (axis) {
    case Axis::horizontal:
      rows = Eigen::Matrix3d::Identity().topRows<2>();
      break;
    case Axis::vertical:
      rows = up.transpose();
      break;
    case Axis::in_plane:
      rows.resize(2, 3);
      rows << up.cross(normal).transpose(), up.transpose();
      break;
    case Axis::out_of_plane:
      rows = normal.transpose();
      break;
    default:
      rows = Eigen::Matrix3d::Identity();
  }
  return rows;
}

double value_of(const Span& span, const Eigen::Vector3d& d) {
  if (span.rows() == 1) return span.row(0).dot(d);
  double squares = 0;
  for (Eigen::Index i = 0; i < span.rows(); ++i) squares += std::pow(span.row(i).dot(d), 2);
  return std::sqrt(squares);
}

/// Along the vector; where there is none the direction is open and the largest axis stands for all.
double uncertainty_of(const Span& span, const Eigen::Vector3d& d, const Eigen::MatrixXd& covariance) {
  if (covariance.size() == 0 || !covariance.allFinite()) return nan;
  const Eigen::MatrixXd s = span * covariance * span.transpose();
  const Eigen::VectorXd v = span * d;
  const double length = v.norm();
  const double variance = length > 1e-9 ? v.dot(s * v) / (length * length)
                                        : Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(s).eigenvalues().maxCoeff();
  return std::sqrt(std::max(0.0, variance));
}

constexpr int kSamples = 4096;

/// Points of Halton's sequence (bases 2, 3, 5) as standard normal deviates: the same on every machine.
const std::vector<Eigen::Vector3d>& normal_points() {
  static const std::vector<Eigen::Vector3d> points = [] {
    std::vector<Eigen::Vector3d> made(kSamples);
    const std::array<int, 3> bases = {2, 3, 5};
    for (int i = 0; i < kSamples; ++i)
      for (int k = 0; k < 3; ++k) {
        double fraction = 0, digit = 1;
        for (int rest = i + 1; rest > 0; rest /= bases[static_cast<std::size_t>(k)])
          fraction += (digit /= bases[static_cast<std::size_t>(k)]) * (rest % bases[static_cast<std::size_t>(k)]);
        made[static_cast<std::size_t>(i)][k] = normal_quantile(fraction);
      }
    return made;
  }();
  return points;
}

/// P(every judged length is within its tolerance) for a true deviation that is normal about the estimate; to 0.1 %, by
/// quasi-Monte Carlo, since horizontal and vertical are correlated and a length is not normal.
double pass_probability(const Eigen::Vector3d& d, const Eigen::MatrixXd& covariance,
                        const std::vector<std::pair<Span, double>>& judged) {
  if (judged.empty() || covariance.size() == 0 || !covariance.allFinite()) return nan;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(Eigen::Matrix3d(covariance.topLeftCorner<3, 3>()));
  const Eigen::Matrix3d root = eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(0).cwiseSqrt().asDiagonal();
  int inside = 0;
  for (const Eigen::Vector3d& point : normal_points()) {
    const Eigen::Vector3d sample = d + root * point;
    bool within = true;
    for (const auto& [span, tolerance] : judged) within = within && std::abs(value_of(span, sample)) <= tolerance;
    inside += within;
  }
  return static_cast<double>(inside) / kSamples;
}

}  // namespace

void judge_anchor(const Eigen::Vector3d& deviation, const Eigen::MatrixXd& covariance, const Eigen::Vector3d& normal,
                  const Tolerances& tolerances, double guard_factor, AnchorDeviationT& out, bool with_probability) {
  std::vector<std::pair<Span, double>> judged;
  double usage = -1;
  out.verdict = ToleranceVerdict::not_measured;
  for (const Axis axis : {Axis::horizontal, Axis::vertical, Axis::in_plane, Axis::out_of_plane, Axis::space}) {
    auto entry = std::make_unique<JudgedAxisT>();
    entry->axis = name_of(axis);
    const auto tolerance = tolerances.find(axis);
    if (tolerance != tolerances.end())
      entry->tolerance = tolerance->second.value, entry->source = tolerance->second.source;
    const bool facade = axis == Axis::in_plane || axis == Axis::out_of_plane;
    if (deviation.allFinite() && (!facade || normal.allFinite())) {
      const Span span = span_of(axis, normal);
      entry->value = value_of(span, deviation);
      entry->u = uncertainty_of(span, deviation, covariance);
      if (entry->tolerance > 0) {
        entry->verdict = evaluate::verdict_of(entry->value, entry->u, entry->tolerance, guard_factor);
        judged.emplace_back(span, entry->tolerance);
        const double used = std::abs(entry->value) / entry->tolerance;
        if (entry->verdict > out.verdict || (entry->verdict == out.verdict && used > usage))
          out.verdict = entry->verdict, out.decided_by = entry->axis, usage = used;
      }
    }
    out.axes.push_back(std::move(entry));
  }
  out.deviation = deviation;
  if (covariance.size() != 0)
    for (Eigen::Index row = 0; row < 3; ++row)
      for (Eigen::Index column = 0; column < 3; ++column) out.covariance.push_back(covariance(row, column));
  if (with_probability && deviation.allFinite()) out.pass_probability = pass_probability(deviation, covariance, judged);
}

}  // namespace plumbline::judgement
