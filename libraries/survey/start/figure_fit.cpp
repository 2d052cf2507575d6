// Levelled motions of a set-up's figure onto points: robust, then least squares.
#include <algorithm>
#include <cmath>
#include <limits>

#include "survey/model/observation_equations.hpp"
#include "survey/start/set_up_chain.hpp"

namespace plumbline::survey {

namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

Vector2d turned(const Vector2d& p, double rotation) {
  const double c = std::cos(rotation), s = std::sin(rotation);
  return {p.x() * c + p.y() * s, -p.x() * s + p.y() * c};
}

double azimuth(const Vector2d& d) { return std::atan2(d.x(), d.y()); }

/// Truncated squares over all pairs: a point that does not agree costs 1, however far off it is. Ends where it reaches
/// `limit`, since it only grows; `agree` is not counted to the end then.
double cost_of(const FigureFit& fit, const std::vector<FigurePair>& pairs, int& agree,
               double limit = std::numeric_limits<double>::infinity()) {
  const double c = std::cos(fit.rotation), s = std::sin(fit.rotation);
  double cost = 0;
  agree = 0;
  for (const FigurePair& p : pairs) {
    const Vector3d local = p.sight->place(fit.scale, fit.constant);
    Vector3d d =
        Vector3d(local.x() * c + local.y() * s, -local.x() * s + local.y() * c, local.z()) + fit.shift - p.target;
    if (std::isnan(d.z())) d.z() = 0;
    const double share = d.squaredNorm() / (p.tolerance * p.tolerance);
    cost += std::min(1.0, share);
    agree += share <= 1;
    if (cost >= limit) break;
  }
  return cost;
}

std::optional<FigureFit> fit_of_two(const FigurePair& a, const FigurePair& b, double scale) {
  const Vector3d from = b.sight->place(scale) - a.sight->place(scale), to = b.target - a.target;
  const double allowed = a.tolerance + b.tolerance;
  if (std::abs(from.head<2>().norm() - to.head<2>().norm()) > allowed || to.head<2>().norm() < 2 * allowed)
    return std::nullopt;
  if (std::abs(from.z() - to.z()) > allowed) return std::nullopt;  // NaN passes: a height that is not compared
  FigureFit fit;
  fit.scale = scale;
  fit.rotation = wrap_angle(azimuth(to.head<2>()) - azimuth(from.head<2>()));
  const Vector3d first = a.target - fit(*a.sight), second = b.target - fit(*b.sight);
  fit.shift = 0.5 * (first + second);
  if (std::isnan(fit.shift.z())) fit.shift.z() = or_else(first.z(), or_else(second.z(), 0));
  return fit;
}

/// Least squares over the pairs that agree.
void refine(const std::vector<FigurePair>& pairs, FigureFit& fit) {
  Vector3d from = Vector3d::Zero(), to = Vector3d::Zero();
  double weights = 0, lift = 0, lift_weights = 0;
  std::vector<const FigurePair*> used;
  for (const FigurePair& p : pairs) {
    if (!agrees(fit, p)) continue;
    const double w = 1 / (p.tolerance * p.tolerance);
    const Vector3d local = p.sight->place(fit.scale, fit.constant);
    used.push_back(&p);
    weights += w;
    from.head<2>() += w * local.head<2>();
    to.head<2>() += w * p.target.head<2>();
    if (const double up = p.target.z() - local.z(); !std::isnan(up)) lift += w * up, lift_weights += w;
  }
  if (used.size() < 2) return;
  from /= weights, to /= weights;
  double sine = 0, cosine = 0;
  for (const FigurePair* p : used) {
    const double w = 1 / (p->tolerance * p->tolerance);
    const Vector2d a = p->sight->place(fit.scale, fit.constant).head<2>() - from.head<2>(),
                   b = p->target.head<2>() - to.head<2>();
    cosine += w * a.dot(b);
    sine += w * (b.x() * a.y() - b.y() * a.x());
  }
  fit.rotation = std::atan2(sine, cosine);
  fit.shift.head<2>() = to.head<2>() - turned(from.head<2>(), fit.rotation);
  if (lift_weights > 0) fit.shift.z() = lift / lift_weights;
}

}  // namespace

Vector3d FigureFit::operator()(const LocalSight& sight) const {
  const Vector3d local = sight.place(scale, constant);
  const Vector2d plan = turned(local.head<2>(), rotation);
  return Vector3d(plan.x(), plan.y(), local.z()) + shift;
}

bool agrees(const FigureFit& fit, const FigurePair& pair) {
  Vector3d d = fit(*pair.sight) - pair.target;
  if (std::isnan(d.z())) d.z() = 0;
  return d.norm() <= pair.tolerance;
}

std::optional<FigureFit> fit_robustly(const std::vector<FigurePair>& pairs, double scale) {
  constexpr size_t kHypotheses = 400;
  const size_t n = pairs.size();
  if (n < 2) return std::nullopt;
  std::optional<FigureFit> best;
  double least = static_cast<double>(n);
  const size_t all = n * (n - 1) / 2, step = std::max<size_t>(1, all / kHypotheses);
  // Neighbours in the list come last: long baselines turn least with the noise of their ends.
  size_t count = 0;
  for (size_t apart = n - 1; apart >= 1; --apart)
    for (size_t a = 0; a + apart < n; ++a, ++count) {
      if (count % step != 0) continue;
      auto fit = fit_of_two(pairs[a], pairs[a + apart], scale);
      if (!fit) continue;
      double cost = cost_of(*fit, pairs, fit->agree, least);
      if (cost >= least) continue;
      least = cost;
      best = fit;
    }
  if (!best) return std::nullopt;
  for (int round = 0; round < 3; ++round) {
    FigureFit better = *best;
    refine(pairs, better);
    const double cost = cost_of(better, pairs, better.agree);
    if (cost >= least) break;
    least = cost;
    best = better;
  }
  best->compared = static_cast<int>(n);
  return best;
}

FigureFit with_constant(const std::vector<FigurePair>& pairs, const FigureFit& fit) {
  constexpr double kLargest = 0.1, kStep = 0.0025;
  int agree = 0;
  double least = cost_of(fit, pairs, agree);
  FigureFit best = fit;
  // Outwards from none, each from the fit of its neighbour, so that the points that agree can follow.
  for (const double direction : {1.0, -1.0}) {
    FigureFit trial = fit;
    for (double constant = kStep; constant <= kLargest; constant += kStep) {
      trial.constant = direction * constant;
      for (int round = 0; round < 3; ++round) refine(pairs, trial);
      const double cost = cost_of(trial, pairs, trial.agree);
      if (cost >= least) continue;
      least = cost;
      best = trial;
    }
  }
  // It must explain nearly all that did not agree before.
  return pairs.size() - static_cast<size_t>(best.agree) <= (pairs.size() - static_cast<size_t>(agree)) / 4 ? best : fit;
}

}  // namespace plumbline::survey
