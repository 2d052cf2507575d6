// Data snooping, robust start and variance components of the adjustment.
#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "geometry/statistics.hpp"
#include "survey/adjust/adjuster.hpp"

namespace plumbline::survey {

double Adjuster::critical_w() const { return normal_quantile(1 - 0.5 * options_.alpha0); }

double Adjuster::critical_removal() const {
  const auto tests = static_cast<double>(m_.rows.size() + 5 * m_.survey.set_ups.size());
  const double one = -std::expm1(std::log1p(-options_.removal_alpha) / std::max(1.0, tests));
  return std::max(critical_w(), normal_quantile(1 - 0.5 * one));
}

int Adjuster::removed() const { return static_cast<int>(std::count(state_.removed.begin(), state_.removed.end(), 1)); }

bool Adjuster::clean(const Pass& pass) const {
  constexpr double kClearly = 0.001;
  return worst_row(pass, {}) < 0 &&
         least_squares::global_test(pass.solution.sum_of_squares(), pass.solution.degrees_of_freedom(), kClearly)
                 .verdict != least_squares::GlobalTest::Verdict::high;
}

void Adjuster::snoop(Pass& pass) {
  set_aside(pass);
  const NetworkModel model = m_;
  const StochasticState before = state_;
  const std::vector<SnoopingAction> actions = actions_;
  const std::string undecided = undecided_;
  mend(pass);
  // What a wrong known point contradicts is not to be mended by taking its readings out.
  if (clean(pass) || stopped_ || options_.robust_start || !rows_of_wrong_points(pass).empty()) return;
  // Blunders may mask each other: once more, with the suspects of a robust adjustment out from the start.
  const NetworkModel mended = m_;
  const StochasticState after = state_;
  const std::vector<SnoopingAction> taken = actions_;
  const std::string told = undecided_;
  m_ = model, state_ = before, actions_ = actions, undecided_ = undecided;
  find_set_ups_of_rows();
  try {
    remove_by_robust_weights();
    Pass other = adjust();
    mend(other);
    if (clean(other)) {
      pass = std::move(other);
      return;
    }
  } catch (const NetworkError&) {  // the first attempt stands
  }
  m_ = mended, state_ = after, actions_ = taken, undecided_ = told;
  find_set_ups_of_rows();
}

void Adjuster::set_aside(Pass& pass) {
  std::vector<int> rows;
  for (const int row : m_.set_aside)
    if (m_.rows[row].removable && !m_.dropped[row]) rows.push_back(row);
  if (rows.empty()) return;
  for (const int row : rows) state_.removed[row] = 1;
  try {
    Pass without = adjust(true, &pass);
    pass = std::move(without);
  } catch (const NetworkError&) {  // they carry the network: it is told of, and the tests decide
    for (const int row : rows) state_.removed[row] = 0;
    return;
  }
  for (const int row : rows) {
    const auto test = removed_statistics(pass, row);
    log_action(row, false, test.w, test.estimated_blunder, pass);
  }
  std::set<int> restored;
  restore_innocent(pass, restored);
}

void Adjuster::mend(Pass& pass) {
  const int most = std::max(1, static_cast<int>(options_.largest_removed_share * static_cast<double>(m_.rows.size())));
  std::set<int> kept;      // removal would have left a point uncontrolled
  std::set<int> restored;  // came back once already
  std::set<int> left;      // beside an error that nobody can mend
  for (;;) {
    if (const CommonError error = largest_common_error(pass, common_errors(pass), left); error.observations > 0) {
      // What would be taken out or off there follows from it.
      if (!can_be_mended(error.kind) || !error.equal.empty()) {
        stopped_ = true;
        left.merge(rows_beside(pass, error));
        kept.insert(left.begin(), left.end());
        continue;
      }
      if (!estimate(pass, error)) refused_.insert(error.key());
      continue;
    }
    if (worst_row(pass, kept) < 0) return;
    kept.merge(rows_of_wrong_points(pass));
    const std::vector<int> worst = worst_rows(pass, kept, most - removed());
    if (worst.empty()) return;
    if (worst.size() == 1 || !remove_together(pass, worst, restored)) remove_worst(pass, worst.front(), kept, restored);
  }
}

/// The worst row, and of a large network those that have nothing to do with it or each other: their stations see no
/// point in common. Each would go by itself too, and every removal is an adjustment of the whole. A row that is much
/// smaller may be its shadow and waits.
std::vector<int> Adjuster::worst_rows(const Pass& pass, const std::set<int>& kept, int most) const {
  constexpr double kShadow = 0.3;  // of the largest |w|
  std::vector<std::pair<double, int>> failing;
  for (size_t r = 0; r < pass.problem.rows.size(); ++r) {
    const int row = pass.problem.rows[r];
    if (row < 0 || !m_.rows[row].removable || kept.contains(row)) continue;
    const double w = std::abs(pass.reliability.rows[r].w);
    if (w > critical_removal()) failing.emplace_back(-w, row);
  }
  std::stable_sort(failing.begin(), failing.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<int> rows;
  if (failing.size() < 2) {
    for (const auto& [w, row] : failing)
      if (most > 0) rows.push_back(row);
    return rows;
  }
  std::map<std::string, std::set<std::string>> seen_from;
  for (const ResultRow& r : m_.rows) seen_from[r.from].insert({r.from, r.to});
  std::set<std::string> touched;
  for (const auto& [w, row] : failing) {
    if (static_cast<int>(rows.size()) >= most || -w < kShadow * -failing.front().first) break;
    const ResultRow& r = m_.rows[row];
    const std::set<std::string>& own = seen_from.at(r.from);
    if (std::any_of(own.begin(), own.end(), [&](const std::string& id) { return touched.contains(id); })) continue;
    rows.push_back(row);
    touched.insert(own.begin(), own.end());
  }
  return rows;
}

bool Adjuster::remove_together(Pass& pass, const std::vector<int>& rows, std::set<int>& restored) {
  std::vector<std::pair<double, double>> tests;
  for (const int row : rows) {
    tests.push_back(row_test(pass, row));
    state_.removed[row] = 1;
  }
  try {
    Pass next = adjust(true, &pass);
    if (makes_uncontrolled(pass, next)) throw NetworkError("uncontrolled");
    pass = std::move(next);
  } catch (const NetworkError&) {  // one by one it is found which may not go
    for (const int row : rows) state_.removed[row] = 0;
    return false;
  }
  for (size_t k = 0; k < rows.size(); ++k) log_action(rows[k], false, tests[k].first, tests[k].second, pass);
  restore_innocent(pass, restored);
  return true;
}

bool Adjuster::remove_worst(Pass& pass, int worst, std::set<int>& kept, std::set<int>& restored) {
  const auto [w, blunder] = row_test(pass, worst);
  state_.removed[worst] = 1;
  try {
    Pass next = adjust(true, &pass);
    if (makes_uncontrolled(pass, next)) throw NetworkError("uncontrolled");
    pass = std::move(next);
  } catch (const NetworkError&) {
    state_.removed[worst] = 0;
    kept.insert(worst);
    note_kept(worst, w);
    return false;
  }
  log_action(worst, false, w, blunder, pass);
  restore_innocent(pass, restored);
  return true;
}

int Adjuster::worst_row(const Pass& pass, const std::set<int>& kept) const {
  int worst = -1;
  double largest = critical_removal();
  for (size_t r = 0; r < pass.problem.rows.size(); ++r) {
    const int row = pass.problem.rows[r];
    if (row < 0 || !m_.rows[row].removable || kept.contains(row)) continue;
    const double w = std::abs(pass.reliability.rows[r].w);
    if (w <= largest) continue;
    largest = w;
    worst = row;
  }
  return worst;
}

std::set<int> Adjuster::rows_of_wrong_points(const Pass& pass) const {
  constexpr double kClearly = 10.8;  // of v'Pv: a point has three coordinates to explain with, a reading one
  // A sight to the wrong prism makes direction, distance and zenith angle wrong together.
  std::map<std::pair<int, std::string>, double> sights;
  for (size_t r = 0; r < pass.problem.rows.size(); ++r)
    if (const int row = pass.problem.rows[r]; row >= 0 && m_.rows[row].removable)
      sights[{set_up_of_row_[row], m_.rows[row].to}] += std::pow(pass.reliability.rows[r].w, 2);
  double single = 0;
  for (const auto& [sight, squares] : sights) single = std::max(single, squares);
  std::set<int> rows;
  for (const KnownPoint& k : compare_with_known(m_, pass.problem, pass.solution, pass.cofactors, false)) {
    if (k.stands() || k.explained < single + kClearly) continue;
    for (int row = 0; row < static_cast<int>(m_.observations.size()); ++row)
      if (m_.rows[row].removable && (m_.rows[row].from == k.id || m_.rows[row].to == k.id)) rows.insert(row);
  }
  return rows;
}

std::pair<double, double> Adjuster::row_test(const Pass& pass, int row) const {
  const auto at = std::find(pass.problem.rows.begin(), pass.problem.rows.end(), row) - pass.problem.rows.begin();
  const auto& s = pass.reliability.rows[at];
  return {s.w, s.estimated_blunder};
}

bool Adjuster::makes_uncontrolled(const Pass& before, const Pass& after) const {
  const std::set<std::string> had = controlled_points(before), has = controlled_points(after);
  return !std::includes(has.begin(), has.end(), had.begin(), had.end());
}

std::set<std::string> Adjuster::controlled_points(const Pass& pass) const {
  std::set<std::string> points;
  for (size_t r = 0; r < pass.problem.rows.size(); ++r) {
    const int row = pass.problem.rows[r];
    if (row < 0 || pass.reliability.rows[r].controlled < 0.01) continue;
    for (const std::string& id : {m_.rows[row].from, m_.rows[row].to})
      if (!id.empty() && is_unknown(id)) points.insert(id);
  }
  return points;
}

bool Adjuster::is_unknown(const std::string& id) const {
  for (CoordinateRole role : m_.roles[m_.index.at(id)])
    if (role == CoordinateRole::free || role == CoordinateRole::constrained) return true;
  return false;
}

void Adjuster::note_kept(int row, double w) {
  const ResultRow& r = m_.rows[row];
  m_.findings.push_back({Finding::Severity::warning,
                         r.kind + " " + r.from + " -> " + r.to + " fails its test (w = " + std::to_string(w) +
                             ") but stays: without it a point would not be controlled",
                         {r.from, r.to}});
}

void Adjuster::log_action(int row, bool restored, double w, double blunder, const Pass& pass) {
  actions_.push_back({row, restored, w, blunder, pass.solution.sum_of_squares(), pass.solution.degrees_of_freedom()});
}

void Adjuster::restore_innocent(Pass& pass, std::set<int>& restored) {
  for (int row = 0; row < static_cast<int>(m_.observations.size()); ++row) {
    if (!state_.removed[row] || restored.contains(row)) continue;
    const least_squares::RowStatistics test = removed_statistics(pass, row);
    if (std::abs(test.w) > critical_removal()) continue;
    restored.insert(row);
    state_.removed[row] = 0;
    pass = adjust(true, &pass);
    log_action(row, true, test.w, test.estimated_blunder, pass);
  }
}

std::optional<Adjuster::TakenOut> Adjuster::taken_out(const Pass& pass, int row) const {
  const auto block = single_block(m_, options_, state_, pass.problem, row);
  const least_squares::Problem& problem = pass.problem.problem;
  std::vector<const double*> values;
  std::vector<std::vector<double>> storage;
  std::vector<double*> jacobians;
  for (int p : block->parameters) {
    if (p < 0) return std::nullopt;
    values.push_back(problem.parameters[p].value.data());
    storage.emplace_back(problem.parameters[p].tangent(), 0.0);
  }
  for (auto& s : storage) jacobians.push_back(s.data());
  TakenOut result;
  result.sigma = 1 / block->whitening()(0, 0);
  if (!block->evaluate(values.data(), &result.residual, jacobians.data())) return std::nullopt;
  result.gradient = Eigen::VectorXd::Zero(pass.solution.unknowns.count());
  for (size_t k = 0; k < block->parameters.size(); ++k)
    for (size_t c = 0; c < storage[k].size(); ++c) {
      const int unknown = pass.solution.unknowns(block->parameters[k], static_cast<int>(c));
      if (unknown >= 0) result.gradient[unknown] += storage[k][c];
    }
  return result;
}

least_squares::RowStatistics Adjuster::removed_statistics(const Pass& pass, int row) const {
  const std::optional<TakenOut> out = taken_out(pass, row);
  if (!out) return {};
  const Eigen::VectorXd& a = out->gradient;
  least_squares::RowStatistics result;
  result.sigma = out->sigma, result.residual = out->residual;
  const double network = a.dot(pass.cofactors.times(a));
  const double total = std::sqrt(result.sigma * result.sigma + network);
  result.sigma_adjusted = std::sqrt(network);
  result.redundancy_number = result.controlled = result.sigma * result.sigma / (total * total);
  result.w = result.residual / total;
  result.estimated_blunder = -result.residual;
  const double delta0 = least_squares::non_centrality(options_.alpha0, options_.power);
  result.mdb = delta0 * total;
  result.bias_to_noise = delta0 * std::sqrt(network) / result.sigma;
  return result;
}

void Adjuster::remove_by_robust_weights() {
  constexpr double kHuber = 2.0;
  state_.weight_factors.assign(m_.observations.size(), 1.0);
  Pass pass = adjust(false);
  for (int iteration = 0; iteration < 10; ++iteration) {
    for (size_t r = 0; r < pass.problem.rows.size(); ++r) {
      const int row = pass.problem.rows[r];
      if (row < 0 || !m_.rows[row].removable) continue;
      const double unit =
          pass.solution.linearisation.residuals[static_cast<Eigen::Index>(r)] / std::sqrt(state_.weight_factors[row]);
      state_.weight_factors[row] = std::min(1.0, kHuber / std::max(1e-12, std::abs(unit)));
    }
    pass = adjust(false, &pass);
  }
  const auto most = static_cast<size_t>(options_.largest_removed_share * static_cast<double>(m_.rows.size()));
  std::vector<std::pair<double, int>> suspects;
  for (size_t row = 0; row < state_.weight_factors.size(); ++row)
    if (!state_.removed[row] && state_.weight_factors[row] < kHuber / 6.0)
      suspects.emplace_back(state_.weight_factors[row], row);
  std::sort(suspects.begin(), suspects.end());
  if (suspects.size() > most) suspects.resize(most);
  state_.weight_factors.clear();
  const std::vector<char> before = state_.removed;
  const std::vector<SnoopingAction> actions = actions_;
  for (const auto& [weight, row] : suspects) state_.removed[row] = 1;
  if (suspects.empty()) return;
  try {
    Pass clean = adjust();
    std::set<int> restored;
    for (const auto& [weight, row] : suspects) {
      const auto test = removed_statistics(clean, row);
      log_action(row, false, test.w, test.estimated_blunder, clean);
    }
    restore_innocent(clean, restored);
  } catch (const NetworkError&) {  // too much at once: plain data snooping decides one by one
    state_.removed = before;
    actions_ = actions;
  }
}

void Adjuster::estimate_variance_components(Pass& pass) {
  constexpr double kEnoughRedundancy = 10, kClosest = 0.01, kLeast = 0.2, kMost = 5;
  for (int iteration = 0; iteration < 20; ++iteration) {
    const auto components = least_squares::variance_components(pass.problem.problem, pass.solution, pass.reliability);
    double change = 0;
    for (size_t g = 0; g < components.size() && g < kGiven; ++g) {
      if (components[g].redundancy < kEnoughRedundancy) continue;
      double& factor = state_.sigma_factors[g];
      const double wanted = std::clamp(factor * std::sqrt(components[g].factor), kLeast, kMost);
      change = std::max(change, std::abs(wanted * wanted / (factor * factor) - 1));
      factor = wanted;
    }
    if (change < kClosest) return;
    pass = adjust(true, &pass);
  }
  m_.findings.push_back(
      {Finding::Severity::warning, "variance components did not settle within 20 iterations; the last are used", {}});
}

}  // namespace plumbline::survey
