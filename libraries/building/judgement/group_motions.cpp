#include "building/judgement/group_motions.hpp"

#include <Eigen/Cholesky>
#include <Eigen/QR>
#include <algorithm>
#include <map>

#include "geometry/median.hpp"
#include "geometry/statistics.hpp"

namespace plumbline::judgement {
namespace {

using Eigen::Vector3d;

constexpr std::size_t kWitnesses = 3, kWitnessesOfATurn = 6;  // anchors that were in order

/// d = shift + turn x (place - centre).
struct RigidMotion {
  Vector3d shift = Vector3d::Zero(), turn = Vector3d::Zero(), centre = Vector3d::Zero();
  Vector3d at(const Vector3d& place) const { return shift + turn.cross(place - centre); }
};

double statistic_of(const MeasuredTwice& pair, const Vector3d& motion) {
  const Vector3d d = pair.d - motion;
  return d.dot(pair.covariance.ldlt().solve(d));
}

Vector3d median_of(const std::vector<const MeasuredTwice*>& pairs) {
  Vector3d median;
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<double> values;
    for (const auto* pair : pairs) values.push_back(pair->d[axis]);
    median[axis] = upper_median(std::move(values));
  }
  return median;
}

/// Least squares; of anchors in a row the turn about it is none.
RigidMotion fitted(const std::vector<const MeasuredTwice*>& pairs) {
  RigidMotion motion;
  for (const auto* pair : pairs) motion.centre += pair->place / static_cast<double>(pairs.size());
  const auto n = static_cast<Eigen::Index>(pairs.size());
  Eigen::MatrixXd a(3 * n, 6);
  Eigen::VectorXd b(3 * n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const Vector3d arm = pairs[static_cast<std::size_t>(i)]->place - motion.centre;
    a.block<3, 3>(3 * i, 0).setIdentity();
    for (Eigen::Index k = 0; k < 3; ++k) a.block<3, 1>(3 * i, 3 + k) = Vector3d::Unit(k).cross(arm);
    b.segment<3>(3 * i) = pairs[static_cast<std::size_t>(i)]->d;
  }
  Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> solver;
  solver.setThreshold(1e-6);
  const Eigen::VectorXd x = solver.compute(a).solve(b);
  motion.shift = x.head<3>(), motion.turn = x.tail<3>();
  return motion;
}

std::vector<const MeasuredTwice*> following(const std::vector<const MeasuredTwice*>& pairs, const RigidMotion& motion,
                                            double critical) {
  std::vector<const MeasuredTwice*> found;
  for (const auto* pair : pairs)
    if (statistic_of(*pair, motion.at(pair->place)) <= critical) found.push_back(pair);
  return found;
}

bool are_most(std::size_t some, std::size_t all) { return 3 * some >= 2 * all; }

/// The motion that two thirds of the witnesses follow; false if there is none.
bool find_motion(const std::vector<const MeasuredTwice*>& witnesses, double critical, RigidMotion& motion) {
  constexpr int kRounds = 10;
  if (witnesses.size() >= kWitnessesOfATurn) {
    std::vector<const MeasuredTwice*> kept = witnesses;
    for (int round = 0; round < kRounds && are_most(kept.size(), witnesses.size()); ++round) {
      motion = fitted(kept);
      auto next = following(witnesses, motion, critical);
      if (next == kept) return true;
      kept = std::move(next);
    }
  }
  motion = {};
  motion.shift = median_of(witnesses);
  return are_most(following(witnesses, motion, critical).size(), witnesses.size());
}

std::map<std::string, std::vector<std::size_t>> groups_of(const std::vector<MeasuredTwice>& pairs) {
  std::map<std::string, std::vector<std::size_t>> groups;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const AsBuiltChangeT& change = *pairs[i].change;
    groups["the building"].push_back(i);
    if (change.floor > 0) groups["floor " + std::to_string(change.floor)].push_back(i);
    if (!change.facade.empty()) groups["facade " + change.facade].push_back(i);
    if (pairs[i].column > 0) groups["column " + std::to_string(pairs[i].column)].push_back(i);
  }
  return groups;
}

}  // namespace

GroupMotions group_motions(const std::vector<MeasuredTwice>& pairs, double critical) {
  GroupMotions result;
  result.follows.assign(pairs.size(), -1);
  const double moved_alone = chi_squared_quantile(0.95, 3);
  for (const auto& [name, members] : groups_of(pairs)) {
    std::vector<const MeasuredTwice*> witnesses;
    for (const std::size_t i : members)
      if (pairs[i].change->before == ToleranceVerdict::pass && pairs[i].covariance.allFinite())
        witnesses.push_back(&pairs[i]);
    if (witnesses.size() < kWitnesses) continue;
    const std::size_t still = following(witnesses, {}, moved_alone).size();
    RigidMotion motion;
    if (2 * still > witnesses.size() || !find_motion(witnesses, critical, motion)) continue;
    GroupMotion group{name, Vector3d::Zero(), static_cast<int>(witnesses.size())};
    for (const auto* witness : witnesses) group.mean += witness->d / static_cast<double>(witnesses.size());
    for (const std::size_t i : members)
      if (result.follows[i] < 0 && pairs[i].covariance.allFinite() &&
          statistic_of(pairs[i], motion.at(pairs[i].place)) <= critical)
        result.follows[i] = static_cast<int>(result.groups.size());
    result.groups.push_back(std::move(group));
  }
  return result;
}

}  // namespace plumbline::judgement
