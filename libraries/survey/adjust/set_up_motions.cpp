// What an instrument does while it reads, and a target that sends every distance back from beside it: a vertical axis
// that leans, a tripod that sinks or twists, an edge. Nothing that is estimated would put the readings right, as nobody
// knows that it was so from the first reading on; but without these hypotheses an index or a turned circle explains
// them, is taken off, and bends what is sound.
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <set>

#include "survey/adjust/adjuster.hpp"

namespace plumbline::survey {

namespace {

using TestRows = std::vector<std::pair<int, double>>;

constexpr std::size_t kFewestRows = 6;  // rows of a motion
/// Each is a solve. Beyond, those whose distances fit worst: one edge stands out among them, and where 300 other
/// targets are worse there is more to mend first, after which the rest is tried again.
constexpr std::size_t kMostEdges = 300;

/// Of a tilt about two axes: as |w| of one hypothesis it would explain less, as it had two amounts to choose.
double penalty_of_two(double statistic) {
  return statistic > 1 ? 2 * std::log(std::sqrt(std::numbers::pi / 2 * statistic)) : statistic;
}

}  // namespace

Eigen::Vector3d Adjuster::sight_of(const Pass& pass, int row) const {
  const auto point = [&](const std::string& id) {
    const int block = pass.problem.point_blocks[m_.index.at(id)];
    return Eigen::Map<const Eigen::Vector3d>(pass.problem.problem.parameters[block].value.data());
  };
  return point(m_.rows[row].to) - point(m_.rows[row].from);
}

/// Of tilts about the east and the north axis by 1.
Eigen::Vector2d Adjuster::effect_of_tilt(const Pass& pass, int row) const {
  const Eigen::Vector3d d = sight_of(pass, row);
  const double h = d.head<2>().norm();
  if (!(h > 0) || !std::isfinite(d.z())) return Eigen::Vector2d::Zero();
  if (m_.rows[row].kind == "zenith_angle") return Eigen::Vector2d(d.y(), -d.x()) / h;
  return m_.rows[row].kind == "direction" ? Eigen::Vector2d(-d.head<2>() * d.z() / (h * h))
                                          : Eigen::Vector2d::Zero().eval();
}

void Adjuster::add_tilts(const Pass& pass, const std::map<int, std::vector<int>>& of_set_up,
                         std::vector<CommonError>& found) const {
  for (const auto& [set_up, rows] : of_set_up) {
    std::vector<Hypothesis> axes(3);  // about E, about N, both by the same: what they have in common
    for (const int r : rows) {
      const Eigen::Vector2d effect = effect_of_tilt(pass, pass.problem.rows[r]);
      if (effect.isZero(0)) continue;
      axes[0].rows.emplace_back(r, effect.x()), axes[1].rows.emplace_back(r, effect.y());
      axes[2].rows.emplace_back(r, effect.sum());
    }
    if (axes[0].rows.size() < kFewestRows) continue;
    const std::vector<CommonError> t = test(pass, axes);
    if (!(t[0].sigma > 0 && t[1].sigma > 0 && t[2].sigma > 0)) continue;
    const auto information = [&](int k) { return 1 / (t[k].sigma * t[k].sigma); };
    Eigen::Matrix2d m;
    m(0, 0) = information(0), m(1, 1) = information(1);
    m(0, 1) = m(1, 0) = 0.5 * (information(2) - information(0) - information(1));
    const Eigen::Vector2d b(t[0].size * information(0), t[1].size * information(1));
    if (!(m.determinant() > 1e-3 * m(0, 0) * m(1, 1))) continue;
    const Eigen::Vector2d tilt = m.inverse() * b;
    CommonError& e = found.emplace_back();
    e.kind = CommonError::Kind::tilt, e.set_up = set_up, e.observations = static_cast<int>(axes[0].rows.size());
    e.size = tilt.norm(), e.w = std::sqrt(std::max(0.0, b.dot(tilt)));
    e.sigma = e.w > 0 ? e.size / e.w : 0;
    e.penalty = penalty_of_two(e.w * e.w);
  }
}

std::vector<CommonError> Adjuster::set_up_motions(const Pass& pass) const {
  if (clean(pass)) return {};
  std::map<int, std::vector<int>> of_set_up;               // rows of the problem
  std::map<std::string, std::map<int, TestRows>> targets;  // distances to a target, by set-up
  std::vector<Hypothesis> hypotheses;
  for (int r = 0; r < static_cast<int>(pass.problem.rows.size()); ++r) {
    const int row = pass.problem.rows[r];
    if (row < 0 || static_cast<std::size_t>(row) >= m_.observations.size() || !m_.rows[row].removable) continue;
    const int own = set_up_of_row_[row];
    if (own < 0) continue;
    of_set_up[own].push_back(r);
    if (group_of(m_.observations[row].observation.kind) == kDistances) targets[m_.rows[row].to][own].emplace_back(r, 1);
  }
  for (const auto& [set_up, rows] : of_set_up) {
    std::vector<int> order;
    for (const int r : rows) order.push_back(m_.observations[pass.problem.rows[r]].members.front());
    const auto [first, last] = std::minmax_element(order.begin(), order.end());
    const double span = *last - *first;
    if (!(span > 0)) continue;
    TestRows sink, twist;
    for (std::size_t k = 0; k < rows.size(); ++k) {
      const int row = pass.problem.rows[rows[k]];
      const double time = (order[k] - *first) / span;
      const double height = effect_of_instrument_height(pass, row);
      if (height != 0) sink.emplace_back(rows[k], time * height);
      if (m_.rows[row].kind == "direction") twist.emplace_back(rows[k], time);
    }
    for (auto& [kind, list] : {std::pair(CommonError::Kind::sink, &sink), {CommonError::Kind::twist, &twist}}) {
      if (list->size() < kFewestRows) continue;
      CommonError e;
      e.kind = kind, e.set_up = set_up;
      hypotheses.push_back({e, std::move(*list)});
    }
  }
  std::vector<std::pair<double, Hypothesis>> edges;  // with minus the largest |w|
  for (const auto& [id, by_set_up] : targets) {
    if (by_set_up.size() < 2) continue;
    CommonError e;
    e.kind = CommonError::Kind::edge, e.set = id;
    TestRows rows;
    for (const auto& [set_up, own] : by_set_up) rows.insert(rows.end(), own.begin(), own.end());
    std::sort(rows.begin(), rows.end());
    double worst = 0;
    for (const auto& [r, one] : rows) {
      e.sights.push_back(pass.problem.rows[r]);
      worst = std::max(worst, std::abs(pass.reliability.rows[r].w));
    }
    edges.push_back({-worst, {std::move(e), std::move(rows)}});
  }
  std::stable_sort(edges.begin(), edges.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  if (edges.size() > kMostEdges) edges.resize(kMostEdges);
  for (auto& [worst, edge] : edges) hypotheses.push_back(std::move(edge));
  std::vector<CommonError> found = test(pass, hypotheses);
  add_tilts(pass, of_set_up, found);
  erase_chance(pass, found);
  return found;
}

/// Of many that are tried one is large by chance, and the more so the noisier all readings are than stated: by the
/// median of |w|, which mistakes of less than half of them leave as it is.
void Adjuster::erase_chance(const Pass& pass, std::vector<CommonError>& motions) const {
  constexpr double kMedianOfNoise = 0.6745;  // of |w| of normally distributed readings
  std::vector<double> sizes;
  for (std::size_t r = 0; r < pass.problem.rows.size(); ++r)
    if (const double w = std::abs(pass.reliability.rows[r].w); pass.problem.rows[r] >= 0 && std::isfinite(w))
      sizes.push_back(w);
  if (sizes.empty()) return;
  const auto middle = sizes.begin() + static_cast<std::ptrdiff_t>(sizes.size() / 2);
  std::nth_element(sizes.begin(), middle, sizes.end());
  const double least = critical_removal() * std::max(1.0, *middle / kMedianOfNoise);
  const double choices = 2 * std::log(std::max(1.0, static_cast<double>(motions.size())));
  std::erase_if(motions, [&](CommonError& e) {
    e.penalty += choices;
    return !(e.w * e.w - e.penalty > least * least);
  });
}

}  // namespace plumbline::survey
