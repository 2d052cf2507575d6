#include "survey/network/network_parts.hpp"

#include <algorithm>
#include <functional>
#include <map>
#include <numeric>

namespace plumbline::survey {

std::vector<int> parts_of(const NetworkProblem& p) {
  std::vector<int> parent(p.problem.parameters.size());
  std::iota(parent.begin(), parent.end(), 0);
  const std::function<int(int)> root = [&](int i) {
    while (parent[i] != i) i = parent[i] = parent[parent[i]];
    return i;
  };
  std::set<int> common;
  for (const auto& [name, block] : p.common_blocks) common.insert(block);
  common.insert(p.extra_blocks.begin(), p.extra_blocks.end());
  for (const auto& residual : p.problem.residuals) {
    int first = -1;
    for (int block : residual->parameters) {
      if (common.contains(block)) continue;
      if (first < 0)
        first = root(block);
      else
        parent[root(block)] = first;
    }
  }
  for (size_t i = 0; i < parent.size(); ++i) parent[i] = root(static_cast<int>(i));
  return parent;
}

std::vector<std::set<int>> neighbours_of(const NetworkProblem& p) {
  std::map<int, int> point_of;
  for (size_t i = 0; i < p.point_blocks.size(); ++i) point_of[p.point_blocks[i]] = static_cast<int>(i);
  std::vector<std::set<int>> neighbours(p.point_blocks.size());
  for (const auto& residual : p.problem.residuals)
    for (int a : residual->parameters)
      for (int b : residual->parameters)
        if (a != b && point_of.contains(a) && point_of.contains(b)) neighbours[point_of[a]].insert(point_of[b]);
  return neighbours;
}

std::vector<std::vector<int>> groups_behind(int hinge, const std::vector<std::set<int>>& neighbours) {
  std::vector<char> seen(neighbours.size(), 0);
  seen[hinge] = 1;
  std::vector<std::vector<int>> groups;
  for (int start : neighbours[hinge]) {
    if (seen[start]) continue;
    std::vector<int> group = {start};
    seen[start] = 1;
    for (size_t k = 0; k < group.size(); ++k)
      for (int next : neighbours[group[k]])
        if (!seen[next]) {
          seen[next] = 1;
          group.push_back(next);
        }
    groups.push_back(std::move(group));
  }
  std::stable_sort(groups.begin(), groups.end(), [](const auto& a, const auto& b) { return a.size() < b.size(); });
  return groups;
}

}  // namespace plumbline::survey
