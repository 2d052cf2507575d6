#include "survey/adjust/kept_network.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "least_squares/problem/reliability.hpp"
#include "survey/words/network_words.hpp"

namespace plumbline::survey {

KeptNetwork::KeptNetwork(const NetworkModel& model, NetworkProblem problem, least_squares::Solution solution,
                         double variance_factor)
    : ids_(model.ids),
      rows_(model.rows),
      roles_(model.roles),
      problem_(std::move(problem)),
      solution_(std::move(solution)),
      variance_factor_(variance_factor) {}

bool KeptNetwork::has(const std::string& id) const { return std::find(ids_.begin(), ids_.end(), id) != ids_.end(); }

int KeptNetwork::number(const std::string& id) const {
  const auto at = std::find(ids_.begin(), ids_.end(), id);
  if (at == ids_.end()) throw std::out_of_range("no point '" + id + "' in the network");
  return static_cast<int>(at - ids_.begin());
}

Eigen::Vector3d KeptNetwork::position(const std::string& id) const {
  const size_t point = static_cast<size_t>(number(id));
  const auto& value = problem_.problem.parameters[problem_.point_blocks[point]].value;
  Eigen::Vector3d position;
  for (size_t c = 0; c < 3; ++c)
    position(static_cast<Eigen::Index>(c)) = roles_[point][c] == CoordinateRole::unused ? kNotGiven : value[c];
  return position;
}

std::array<int, 3> KeptNetwork::unknowns(const std::string& id) const {
  const int block = problem_.point_blocks[number(id)];
  return {solution_.unknowns(block, 0), solution_.unknowns(block, 1), solution_.unknowns(block, 2)};
}

KeptNetwork::Estimate KeptNetwork::estimate() {
  Estimate result;
  result.step = least_squares::gauss_newton_step(solution_);
  result.cofactors = least_squares::cofactor_matrix(solution_);
  // |u + J dx|^2 = u'u + 2 g'dx + dx'N dx with N dx = -g.
  result.sum_of_squares = solution_.sum_of_squares() + solution_.normal.gradient().dot(result.step);
  return result;
}

std::vector<KeptNetwork::Conspicuous> KeptNetwork::conspicuous(const Eigen::MatrixXd& cofactors, double variance,
                                                               double critical) const {
  const auto reliability = least_squares::compute_reliability(
      problem_.problem, solution_, least_squares::Cofactors(Eigen::MatrixXd(cofactors / variance)), {});
  std::vector<Conspicuous> found;
  for (size_t r = 0; r < problem_.rows.size(); ++r) {
    const double w = reliability.rows[r].w / std::sqrt(variance);
    if (problem_.rows[r] < 0 || !(std::abs(w) > critical)) continue;
    const ResultRow& row = rows_[problem_.rows[r]];
    found.push_back({row.kind + " " + row.from + " -> " + row.to + " (" + place(row.source) + ")", w});
  }
  std::stable_sort(found.begin(), found.end(),
                   [](const Conspicuous& a, const Conspicuous& b) { return std::abs(a.w) > std::abs(b.w); });
  return found;
}

}  // namespace plumbline::survey
