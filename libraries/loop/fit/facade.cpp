#include "loop/fit/facade.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <queue>
#include <set>
#include <stdexcept>
#include <utility>

namespace plumbline::loop {

Eigen::Matrix3d facade_axes(const Eigen::Vector3d& outward) {
  const Eigen::Vector3d level(outward.x(), outward.y(), 0);
  if (!outward.allFinite() || level.norm() < 1e-6 * outward.norm() || !(outward.norm() > 0))
    throw std::runtime_error("the direction out of the facade is (" + std::to_string(outward.x()) + ", " +
                             std::to_string(outward.y()) + ", " + std::to_string(outward.z()) +
                             "); expected one that is not vertical");
  Eigen::Matrix3d axes;
  axes.col(2) = level.normalized();
  axes.col(1) = Eigen::Vector3d::UnitZ();
  axes.col(0) = axes.col(1).cross(axes.col(2));
  return axes;
}

namespace {

/// The panels of a cycle, in its order: from any panel that was never free.
std::string cycle_among(const std::vector<Panel>& panels, const std::map<std::string, std::size_t>& index,
                        const std::vector<bool>& placed) {
  std::size_t at = 0;
  while (placed[at]) ++at;
  std::vector<std::size_t> way;
  while (std::find(way.begin(), way.end(), at) == way.end()) {
    way.push_back(at);
    for (const std::string& before : panels[at].depends_on)
      if (const auto found = index.find(before); found != index.end() && !placed[found->second]) {
        at = found->second;
        break;
      }
  }
  std::string words = panels[at].id;
  for (auto it = std::find(way.begin(), way.end(), at) + 1; it != way.end(); ++it) words += " needs " + panels[*it].id;
  return words + " needs " + panels[at].id;
}

}  // namespace

std::vector<std::size_t> installation_order(const std::vector<Panel>& panels) {
  std::map<std::string, std::size_t> index;
  for (std::size_t i = 0; i < panels.size(); ++i) index.emplace(panels[i].id, i);
  std::vector<std::size_t> open(panels.size(), 0);
  std::vector<std::vector<std::size_t>> followers(panels.size());
  for (std::size_t i = 0; i < panels.size(); ++i)
    for (const std::string& before : panels[i].depends_on)
      if (const auto found = index.find(before); found != index.end()) ++open[i], followers[found->second].push_back(i);
  using Entry = std::pair<int, std::size_t>;  // floor, then the order given
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> free;
  for (std::size_t i = 0; i < panels.size(); ++i)
    if (open[i] == 0) free.emplace(panels[i].floor, i);
  std::vector<std::size_t> order;
  std::vector<bool> placed(panels.size(), false);
  while (!free.empty()) {
    const std::size_t next = free.top().second;
    free.pop();
    order.push_back(next), placed[next] = true;
    for (const std::size_t follower : followers[next])
      if (--open[follower] == 0) free.emplace(panels[follower].floor, follower);
  }
  if (order.size() < panels.size())
    throw std::runtime_error("dependsOn goes in a circle: " + cycle_among(panels, index, placed) +
                             "; take one of these dependencies out");
  return order;
}

namespace {

void check_bracket(const Bracket& bracket, std::vector<std::string>& faults) {
  for (int k = 0; k < 3; ++k) {
    const double low = bracket.type.low[k], high = bracket.type.high[k], step = bracket.type.step[k];
    if (!(low <= high) || !(step >= 0))
      faults.push_back("bracket " + bracket.id + " (type " + bracket.type.name + "): its range " + kDirections[k] +
                       " is " + std::to_string(1e3 * low) + " to " + std::to_string(1e3 * high) + " mm in steps of " +
                       std::to_string(1e3 * step) + " mm; expected the smaller value first and a step not below 0");
  }
  if (!bracket.design.allFinite()) faults.push_back("bracket " + bracket.id + " has no place in the design");
}

void check_panel(const Panel& panel, std::size_t brackets, std::vector<std::string>& faults) {
  std::set<std::size_t> seen;
  for (const Hook& hook : panel.hooks) {
    if (hook.bracket >= brackets)
      faults.push_back("panel " + panel.id + " hangs on bracket number " + std::to_string(hook.bracket) +
                       ", but there are " + std::to_string(brackets));
    else if (!seen.insert(hook.bracket).second)
      faults.push_back("panel " + panel.id + " hangs twice on bracket number " + std::to_string(hook.bracket));
  }
  for (int k = 0; k < 3; ++k)
    if (!(panel.limits[k] + panel.limits.back(k) > 0))
      faults.push_back("panel " + panel.id + ": the tolerance " + kDirections[k] + " is " +
                       std::to_string(1e3 * panel.limits[k]) + " mm; expected more than 0");
}

void check_joint(const Joint& joint, const std::vector<Panel>& panels, std::vector<std::string>& faults) {
  if (joint.a >= panels.size() || joint.b >= panels.size() || joint.a == joint.b) {
    faults.push_back("a joint names panels " + std::to_string(joint.a) + " and " + std::to_string(joint.b) + " of " +
                     std::to_string(panels.size()));
  } else if (!(joint.least < joint.most) || !(joint.step_most > 0)) {
    faults.push_back("the joint of " + panels[joint.a].id + " and " + panels[joint.b].id + " may be " +
                     std::to_string(1e3 * joint.least) + " to " + std::to_string(1e3 * joint.most) +
                     " mm wide; expected a smaller and a larger width");
  }
}

}  // namespace

std::vector<std::string> faults_of(const Facade& facade) {
  std::vector<std::string> faults;
  std::set<std::string> ids;
  for (const Bracket& bracket : facade.brackets) {
    if (!ids.insert(bracket.id).second) faults.push_back("bracket " + bracket.id + " occurs twice");
    check_bracket(bracket, faults);
  }
  const std::set<std::string> brackets = std::exchange(ids, {});
  for (const Panel& panel : facade.panels) {
    if (!ids.insert(panel.id).second) faults.push_back("panel " + panel.id + " occurs twice");
    if (brackets.count(panel.id))
      faults.push_back("panel " + panel.id + " has the name of a bracket: reports could be on either");
    check_panel(panel, facade.brackets.size(), faults);
  }
  for (const Joint& joint : facade.joints) check_joint(joint, facade.panels, faults);
  const auto n = static_cast<Eigen::Index>(3 * facade.brackets.size());
  if (facade.covariance.rows() != n || facade.covariance.cols() != n)
    faults.push_back("the covariance of the deviations is " + std::to_string(facade.covariance.rows()) + " x " +
                     std::to_string(facade.covariance.cols()) + ", expected " + std::to_string(n) + " x " +
                     std::to_string(n) + " for " + std::to_string(facade.brackets.size()) + " brackets");
  try {
    installation_order(facade.panels);
  } catch (const std::runtime_error& circle) {
    faults.push_back(circle.what());
  }
  return faults;
}

}  // namespace plumbline::loop
