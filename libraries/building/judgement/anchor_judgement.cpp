// One anchor: its lengths against their tolerances, and the probability that it is within all of them.
#include <Eigen/Eigenvalues>
#include <cmath>
#include <optional>

#include "building/ifc/limit_words.hpp"
#include "building/ifc/tolerance_source.hpp"
#include "building/judgement/conformance.hpp"
#include "building/judgement/deviation.hpp"
#include "building/judgement/figures.hpp"
#include "geometry/linear_algebra/decompositions.hpp"

namespace plumbline::judgement {
namespace {

/// One to three directions; no heap.
using Span = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor, 3, 3>;

/// Directions that span what an axis measures: one for a signed length, two or three for the length of a vector.
Span span_of(Axis axis, const ifc::FacadeFrame& facade) {
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
      rows << facade.right.transpose(), facade.up.transpose();
      break;
    case Axis::out_of_plane:
      rows = facade.out.transpose();
      break;
    default:
      rows = Eigen::Matrix3d::Identity();
  }
  return rows;
}

std::string words_of(Axis axis) {
  return axis == Axis::in_plane ? "in the facade's plane" : "out of the facade's plane";
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
  const double variance =
      length > 1e-9 ? v.dot(s * v) / (length * length) : linear_algebra::SymmetricEigen(s).eigenvalues().maxCoeff();
  return std::sqrt(std::max(0.0, variance));
}

/// An axis that cannot be told, or only by a guess, is undecided: skipped it would be a pass.
std::string doubt_of(Axis axis, const ifc::FacadeFrame& facade, const Tolerance& tolerance) {
  if (axis != Axis::in_plane && axis != Axis::out_of_plane) return "";
  if (!facade.known())
    return "not judged " + words_of(axis) + ": " +
           (facade.note.empty() ? "nothing says which way it faces" : facade.note);
  if (facade.source == ifc::FacadeSource::guess)
    return "not judged " + words_of(axis) + ": which way it faces is only guessed";
  if (!facade.confirmed && axis == Axis::out_of_plane && !std::isnan(tolerance.below))
    return "not judged " + words_of(axis) + ": its tolerance has two sides, and which way it faces is not confirmed";
  return "";
}

/// A judged axis: its place in the result and among what is held against limits.
struct Entry {
  JudgedAxisT* axis;
  std::optional<std::size_t> limited;
};

/// The worst decides; of equal verdicts that which is least likely within its tolerance, then that which uses most of
/// it.
void decide(const std::vector<Entry>& entries, AnchorDeviationT& out) {
  double likely = 2, usage = -1;
  ToleranceVerdict worst = ToleranceVerdict::not_measured;
  for (const Entry& entry : entries) {
    const JudgedAxisT& axis = *entry.axis;
    const double p = std::isnan(axis.probability) ? 2 : axis.probability;
    const double used = ifc::share_of_limits(axis);
    if (axis.verdict < worst) continue;
    if (axis.verdict == worst && (p > likely || (p == likely && used <= usage))) continue;
    worst = axis.verdict, likely = p, usage = used, out.decided_by = axis.axis;
  }
}

}  // namespace

void judge_anchor(const Eigen::Vector3d& deviation, const Eigen::MatrixXd& covariance, const ifc::FacadeFrame& facade,
                  const Tolerances& tolerances, const DeviationOptions& options, AnchorDeviationT& out) {
  std::vector<Limited> limits;
  std::vector<Entry> judged;
  std::string doubt;
  out.verdict = ToleranceVerdict::not_measured;
  for (const Axis axis : {Axis::horizontal, Axis::vertical, Axis::in_plane, Axis::out_of_plane, Axis::space}) {
    auto entry = std::make_unique<JudgedAxisT>();
    entry->axis = name_of(axis);
    const auto found = tolerances.find(axis);
    const bool asked = found != tolerances.end();
    const Tolerance tolerance = asked ? found->second : Tolerance{};
    const bool told =
        deviation.allFinite() && (facade.known() || (axis != Axis::in_plane && axis != Axis::out_of_plane));
    const Span span = told ? span_of(axis, facade) : Span();
    if (told) {
      entry->value = value_of(span, deviation);
      // On which side the outside is is not known: neither is the sign.
      if (axis == Axis::out_of_plane && !facade.confirmed) entry->value = std::abs(entry->value);
      entry->u = uncertainty_of(span, deviation, covariance);
    }
    if (asked) {
      entry->tolerance = tolerance.nearer_limit(told ? entry->value : 0), entry->source = tolerance.source;
      entry->above = tolerance.value, entry->below = tolerance.lower();
    }
    if (asked && deviation.allFinite()) {
      const std::string reason = doubt_of(axis, facade, tolerance);
      judged.push_back({entry.get(), {}});
      if (reason.empty())
        judged.back().limited = limits.size(),
        limits.push_back({span, tolerance.value, tolerance.lower(), ifc::is_default_tolerance(tolerance.source)});
      else
        doubt += (doubt.empty() ? "" : "; ") + reason;
    }
    out.axes.push_back(std::move(entry));
  }
  const Conformance found = conformance(deviation, covariance, limits, options.risk, options.tau);
  for (const Entry& entry : judged) {
    if (entry.limited) entry.axis->probability = found.of_each[*entry.limited];
    entry.axis->verdict = verdict_of(entry.axis->probability, options.risk);
  }
  if (!judged.empty()) out.verdict = verdict_of(found.probability, options.risk);
  out.pass_probability = found.probability, out.tau_pass = found.tau_pass, out.tau_fail = found.tau_fail;
  if (!doubt.empty()) {
    out.note += (out.note.empty() ? "" : "; ") + doubt;
    out.pass_probability = nan, out.tau_pass = std::numeric_limits<double>::infinity();
    if (out.verdict != ToleranceVerdict::fail) out.verdict = ToleranceVerdict::undecided;
  }
  decide(judged, out);
  out.deviation = deviation;
  if (covariance.size() != 0)
    for (Eigen::Index row = 0; row < 3; ++row)
      for (Eigen::Index column = 0; column < 3; ++column) out.covariance.push_back(covariance(row, column));
}

}  // namespace plumbline::judgement
