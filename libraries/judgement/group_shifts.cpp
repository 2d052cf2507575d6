#include "judgement/group_shifts.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>

#include "geometry/median.hpp"
#include "geometry/statistics.hpp"

namespace plumbline::judgement {
namespace {

using Eigen::Index;

constexpr std::size_t kFewest = 4;
constexpr double kLevel = 1e-3;
constexpr double kFollows = 4.685;  ///< in scatters: what is farther off follows something else (Tukey)
/// Below this a scatter is rounding [m].
constexpr double kSmallestScatter = 2e-5;

struct Group {
  std::string kind, name;
  int floor = 0;
  std::vector<std::size_t> members;
};

struct Found {
  Eigen::Vector3d shift = Eigen::Vector3d::Zero(), spread = Eigen::Vector3d::Zero();
  std::vector<std::size_t> following;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< of the shift
  double statistic = 0, critical = 0;
};

std::vector<Group> groups_of(const std::vector<GroupMember>& members) {
  std::map<int, Group> floors, columns;
  std::map<std::string, Group> facades, batches;
  std::map<std::pair<std::string, int>, Group> both;
  for (std::size_t i = 0; i < members.size(); ++i) {
    const GroupMember& m = members[i];
    if (m.floor > 0) {
      Group& group = floors[m.floor];
      group.kind = "floor", group.name = "Floor " + std::to_string(m.floor), group.floor = m.floor;
      group.members.push_back(i);
    }
    if (m.column > 0) {
      Group& group = columns[m.column];
      group.kind = "column", group.name = "Column " + std::to_string(m.column), group.members.push_back(i);
    }
    if (!m.facade.empty()) {
      Group& group = facades[m.facade];
      group.kind = "facade", group.name = "Facade " + m.facade, group.members.push_back(i);
    }
    if (!m.batch.empty()) {
      Group& group = batches[m.batch];
      group.kind = "batch", group.name = "Print batch " + m.batch, group.members.push_back(i);
    }
    if (!m.facade.empty() && m.floor > 0) {
      Group& group = both[{m.facade, m.floor}];
      group.kind = "floor of a facade", group.floor = m.floor;
      group.name = "Floor " + std::to_string(m.floor) + " of facade " + m.facade, group.members.push_back(i);
    }
  }
  std::vector<Group> all;
  // What is the whole building is told as the common shift; one that holds the same anchors as another is that.
  const auto add = [&](auto& map) {
    for (auto& [key, group] : map) {
      const bool known =
          std::any_of(all.begin(), all.end(), [&, &g = group](const Group& o) { return o.members == g.members; });
      if (group.members.size() >= kFewest && group.members.size() < members.size() && !known) all.push_back(group);
    }
  };
  add(facades), add(floors), add(columns), add(batches), add(both);
  return all;
}

/// Mean of those that stay together, and how sure it is.
Found examine(const Group& group, const std::vector<Eigen::Vector3d>& deviations, const Eigen::MatrixXd& covariance,
              double level) {
  Found found;
  Eigen::Vector3d middle;
  std::vector<double> sizes;
  for (int k = 0; k < 3; ++k) {
    std::vector<double> values;
    for (const std::size_t i : group.members) values.push_back(deviations[i][k]);
    middle[k] = upper_median(values);
    for (const double value : values) sizes.push_back(std::abs(value - middle[k]));
  }
  const double scatter = std::max(1.4826 * upper_median(sizes), kSmallestScatter);
  for (const std::size_t i : group.members)
    if ((deviations[i] - middle).cwiseAbs().maxCoeff() <= kFollows * scatter) found.following.push_back(i);
  const double n = static_cast<double>(found.following.size());
  if (found.following.size() < kFewest) return found;
  for (const std::size_t i : found.following) found.shift += deviations[i] / n;
  double squares = 0;
  for (const std::size_t i : found.following) {
    const Eigen::Vector3d rest = deviations[i] - found.shift;
    found.spread += rest.cwiseAbs2() / (n - 1);
    squares += rest.squaredNorm();
  }
  found.spread = found.spread.cwiseSqrt();
  const double freedom = 3 * (n - 1);
  double variance = std::max(squares / freedom, kSmallestScatter * kSmallestScatter);
  if (covariance.size() != 0) {  // anchors that happen to lie alike were not measured better for that
    double measured = 0;
    for (const std::size_t i : found.following)
      for (int k = 0; k < 3; ++k)
        measured += covariance(3 * static_cast<Index>(i) + k, 3 * static_cast<Index>(i) + k) / (3 * n);
    variance = std::max(variance, measured);
  }
  found.covariance = variance / n * Eigen::Matrix3d::Identity();
  if (covariance.size() != 0) {  // errors of the measurement that the group shares do not average out
    Eigen::Matrix3d shared = Eigen::Matrix3d::Zero();
    for (const std::size_t i : found.following)
      for (const std::size_t j : found.following)
        if (i != j) shared += covariance.block<3, 3>(3 * static_cast<Index>(i), 3 * static_cast<Index>(j)) / (n * n);
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(0.5 * (shared + shared.transpose()));
    found.covariance +=
        eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(0).asDiagonal() * eigen.eigenvectors().transpose();
  }
  found.statistic = found.shift.dot(found.covariance.ldlt().solve(found.shift));
  found.critical = 3 * fisher_f_quantile(1 - level, 3, freedom);
  return found;
}

std::string mm(double metres) {
  char text[32];
  std::snprintf(text, sizeof text, "%.1f mm", 1e3 * std::abs(metres));
  return text;
}

/// "hangs 12.0 mm low and 3.1 mm too far out": what of the shift is worth saying.
std::string way_of(const Eigen::Vector3d& shift, const Eigen::Matrix3d& covariance, const bim::FacadeFrame* frame) {
  std::string text;
  const auto part = [&](const Eigen::Vector3d& direction, const char* positive, const char* negative) {
    const double length = direction.dot(shift), u = std::sqrt(direction.dot(covariance * direction));
    if (std::abs(length) < std::max(0.3 * shift.norm(), 2 * u)) return;
    text += (text.empty() ? "" : ", ") + mm(length) + " ± " + mm(u) + " " + (length > 0 ? positive : negative);
  };
  part(Eigen::Vector3d::UnitZ(), "high", "low");
  if (frame) {
    part(frame->out, "too far out", "too far in");
    part(frame->right, "too far to the right", "too far to the left");
  } else {
    part(Eigen::Vector3d::UnitX(), "too far in +x", "too far in −x");
    part(Eigen::Vector3d::UnitY(), "too far in +y", "too far in −y");
  }
  return text;
}

/// The frame that all members share, if it is confirmed and level.
const bim::FacadeFrame* common_frame(const std::vector<GroupMember>& members, const std::vector<std::size_t>& of) {
  const bim::FacadeFrame& first = members[of.front()].frame;
  for (const std::size_t i : of) {
    const bim::FacadeFrame& frame = members[i].frame;
    if (!frame.confirmed || !frame.known() || std::abs(frame.out.z()) > 0.5 || frame.out.dot(first.out) < 0.99)
      return nullptr;
  }
  return &first;
}

std::unique_ptr<GroupShiftT> row_of(const Group& group, const Found& found) {
  auto row = std::make_unique<GroupShiftT>();
  row->kind = group.kind, row->name = group.name, row->floor = group.floor;
  row->anchors = static_cast<int>(group.members.size()), row->following = static_cast<int>(found.following.size());
  row->shift = found.shift, row->spread = found.spread;
  row->u = found.covariance.diagonal().cwiseSqrt();
  row->statistic = found.statistic, row->critical = found.critical;
  return row;
}

}  // namespace

std::vector<std::unique_ptr<GroupShiftT>> group_shifts(const std::vector<GroupMember>& members,
                                                       const Eigen::MatrixXd& covariance, double smallest_tolerance,
                                                       const WouldPass& would_pass) {
  std::vector<Group> groups = groups_of(members);
  std::vector<Eigen::Vector3d> left;
  for (const GroupMember& member : members) left.push_back(member.deviation);
  const double level = kLevel / std::max<double>(1, static_cast<double>(groups.size()));
  std::vector<std::unique_ptr<GroupShiftT>> told;
  for (const Group& group : groups) told.push_back(row_of(group, examine(group, left, covariance, level)));
  std::vector<bool> taken(groups.size());
  for (std::size_t round = 0; round < groups.size(); ++round) {
    std::size_t best = groups.size();
    Found strongest;
    for (std::size_t g = 0; g < groups.size(); ++g) {
      if (taken[g]) continue;
      Found found = examine(groups[g], left, covariance, level);
      const bool significant = found.statistic > found.critical && found.critical > 0 &&
                               3 * found.following.size() >= 2 * groups[g].members.size() &&
                               found.shift.norm() >= 0.5 * smallest_tolerance;
      // Of groups that say it as clearly, the larger one.
      const double clear = found.statistic / std::max(found.critical, 1e-12);
      if (significant && (best == groups.size() || clear > strongest.statistic / strongest.critical * 1.0001))
        best = g, strongest = std::move(found);
    }
    if (best == groups.size()) break;
    taken[best] = true;
    auto row = row_of(groups[best], strongest);
    row->significant = true;
    for (const std::size_t i : strongest.following) {
      const Eigen::Vector3d corrected = left[i] - strongest.shift;
      row->would_pass += would_pass && !would_pass(i, left[i]) && would_pass(i, corrected);
      left[i] = corrected;
    }
    row->words = row->name + (row->kind.starts_with("floor") ? " hangs " : " stands ") +
                 way_of(strongest.shift, strongest.covariance, common_frame(members, strongest.following)) + " (" +
                 std::to_string(row->following) + " of its " + std::to_string(row->anchors) +
                 " anchors share it" +
                 (would_pass ? "; without it " + std::to_string(row->would_pass) + " more would pass" : "") +
                 "): one cause to look for, before single anchors are reset.";
    told[best] = std::move(row);
  }
  std::stable_sort(told.begin(), told.end(), [](const auto& a, const auto& b) {
    return a->significant != b->significant ? a->significant
                                            : a->significant && a->statistic / a->critical > b->statistic / b->critical;
  });
  return told;
}

}  // namespace plumbline::judgement
