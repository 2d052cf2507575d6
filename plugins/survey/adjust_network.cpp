#include "adjust_network.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "geometry/statistics.hpp"
#include "network_model.hpp"

namespace plumbline::survey {

namespace {

using adjustment::Reliability;
using adjustment::Solution;

/// One adjustment of the rows that are in.
struct Pass {
  NetworkProblem problem;
  Solution solution;
  Eigen::MatrixXd cofactors;
  Reliability reliability;
};

class Adjuster {
 public:
  Adjuster(NetworkModel& model, const AdjustOptions& options) : m_(model), options_(options) {
    state_.removed.assign(m_.rows.size(), 0);
  }

  NetworkResult run() {
    if (options_.robust_start && options_.remove_blunders) remove_by_robust_weights();
    Pass pass = adjust();
    if (options_.remove_blunders) snoop(pass);
    if (options_.estimate_variance_components) {
      estimate_variance_components(pass);
      if (options_.remove_blunders) snoop(pass);
    }
    return report(pass);
  }

 private:
  /// Solves; with `statistics` also cofactors and reliability. RankDefect becomes words.
  Pass adjust(bool statistics = true) {
    NetworkProblem problem = make_problem(m_, options_, state_);
    adjustment::SolverOptions solver;
    if (adjustment::UnknownIndex(problem.problem).count() == 0)
      throw NetworkError("there is nothing to determine: no point of the network is both observed and unknown");
    solver.datum_unknowns = datum_unknowns(m_, problem);
    solver.negligible_step = 3e-5;  // of a standard deviation: below a tenth of a micrometre in any real network
    try {
      Solution solution = adjustment::solve(problem.problem, solver);
      refuse_local_defects(problem, solution);
      if (!solution.converged) fail_to_converge(problem, solution);
      Pass pass{std::move(problem), std::move(solution), {}, {}};
      if (statistics) add_statistics(pass);
      return pass;
    } catch (const adjustment::RankDefect& defect) {
      const bool held = m_.datum == DatumMode::file || m_.datum == DatumMode::fixed;
      fail_with(name_defects(m_, problem, defect.directions),
                held ? ". Fix points, give control points, or adjust it as a free network (datum: inner)" : "");
    }
  }

  [[noreturn]] static void fail_with(const std::vector<Finding>& defects, const std::string& advice) {
    std::string text = "rank defect: the network is not determined";
    for (const Finding& f : defects) text += "; " + f.text;
    throw NetworkError(text + advice, defects);
  }

  /// Inner constraints choose among positions of the whole network; they must not stand in for missing observations.
  void refuse_local_defects(const NetworkProblem& problem, const Solution& solution) const {
    const std::vector<Finding> defects = name_local_defects(m_, problem, solution.datum.null_space());
    if (!defects.empty()) fail_with(defects, ". Add observations there, or leave these points out");
  }

  void add_statistics(Pass& pass) const {
    pass.cofactors = adjustment::cofactor_matrix(pass.solution);
    adjustment::ReliabilityOptions reliability;
    reliability.alpha0 = options_.alpha0;
    reliability.power = options_.power;
    for (int block : pass.problem.point_blocks) {
      std::vector<int> unknowns;
      for (int k = 0; k < 3; ++k) unknowns.push_back(pass.solution.unknowns(block, k));
      reliability.groups.push_back(std::move(unknowns));
    }
    pass.reliability =
        adjustment::compute_reliability(pass.problem.problem, pass.solution, pass.cofactors, reliability);
  }

  [[noreturn]] void fail_to_converge(const NetworkProblem& problem, const Solution& solution) const {
    int worst = 0;
    solution.linearisation.residuals.cwiseAbs().maxCoeff(&worst);
    std::string text = "the adjustment does not converge: after " + std::to_string(solution.iterations()) +
                       " iterations v'Pv is " + std::to_string(solution.sum_of_squares());
    if (problem.rows[worst] >= 0) {
      const ResultRow& row = m_.rows[problem.rows[worst]];
      text += "; the largest residual is that of the " + row.kind + " " + row.from + " -> " + row.to + " (" +
              row.source.file + ":" + std::to_string(row.source.line) + "): check its point names and value";
    }
    throw NetworkError(text);
  }

  double critical_w() const { return normal_quantile(1 - 0.5 * options_.alpha0); }

  /// Baarda's iterated data snooping: the worst goes, the rest is adjusted again, what was removed is tested again.
  void snoop(Pass& pass) {
    const int most =
        std::max(1, static_cast<int>(options_.largest_removed_share * static_cast<double>(m_.rows.size())));
    std::set<int> kept;      // removal would have left a point uncontrolled
    std::set<int> restored;  // came back once already
    while (static_cast<int>(std::count(state_.removed.begin(), state_.removed.end(), 1)) < most) {
      const int worst = worst_row(pass, kept);
      if (worst < 0) break;
      const auto [w, blunder] = row_test(pass, worst);
      state_.removed[worst] = 1;
      try {
        Pass next = adjust();
        if (makes_uncontrolled(pass, next)) throw NetworkError("uncontrolled");
        pass = std::move(next);
      } catch (const NetworkError&) {
        state_.removed[worst] = 0;
        kept.insert(worst);
        note_kept(worst, w);
        continue;
      }
      log_action(worst, false, w, blunder, pass);
      restore_innocent(pass, restored);
    }
  }

  int worst_row(const Pass& pass, const std::set<int>& kept) const {
    int worst = -1;
    double largest = critical_w();
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

  std::pair<double, double> row_test(const Pass& pass, int row) const {
    const auto at = std::find(pass.problem.rows.begin(), pass.problem.rows.end(), row) - pass.problem.rows.begin();
    const auto& s = pass.reliability.rows[static_cast<size_t>(at)];
    return {s.w, s.estimated_blunder};
  }

  /// True if a point that had controlled observations has none any more.
  bool makes_uncontrolled(const Pass& before, const Pass& after) const {
    const std::set<std::string> had = controlled_points(before), has = controlled_points(after);
    return !std::includes(has.begin(), has.end(), had.begin(), had.end());
  }

  std::set<std::string> controlled_points(const Pass& pass) const {
    std::set<std::string> points;
    for (size_t r = 0; r < pass.problem.rows.size(); ++r) {
      const int row = pass.problem.rows[r];
      if (row < 0 || pass.reliability.rows[r].redundancy_number < 0.01) continue;
      for (const std::string& id : {m_.rows[row].from, m_.rows[row].to})
        if (!id.empty() && is_unknown(id)) points.insert(id);
    }
    return points;
  }

  bool is_unknown(const std::string& id) const {
    for (CoordinateRole role : m_.roles[m_.index.at(id)])
      if (role == CoordinateRole::free || role == CoordinateRole::constrained) return true;
    return false;
  }

  void note_kept(int row, double w) {
    const ResultRow& r = m_.rows[row];
    m_.findings.push_back({Finding::Severity::warning,
                           r.kind + " " + r.from + " -> " + r.to + " fails its test (w = " + std::to_string(w) +
                               ") but stays: without it a point would not be controlled",
                           {r.from, r.to}});
  }

  void log_action(int row, bool restored, double w, double blunder, const Pass& pass) {
    actions_.push_back({row, restored, w, blunder, pass.solution.sum_of_squares(), pass.solution.degrees_of_freedom()});
  }

  /// A removed observation that agrees with the network without it was masked by another blunder.
  void restore_innocent(Pass& pass, std::set<int>& restored) {
    for (int row = 0; row < static_cast<int>(m_.observations.size()); ++row) {
      if (!state_.removed[row] || restored.contains(row)) continue;
      const adjustment::RowStatistics test = removed_statistics(pass, row);
      if (std::abs(test.w) > critical_w()) continue;
      restored.insert(row);
      state_.removed[row] = 0;
      pass = adjust();
      log_action(row, true, test.w, test.estimated_blunder, pass);
    }
  }

  /// Test of an observation that took no part: its misfit against its own and the network's uncertainty. This is the w
  /// the observation had before it was removed, with all other removed ones out.
  adjustment::RowStatistics removed_statistics(const Pass& pass, int row) const {
    const auto block = single_block(m_, options_, state_, pass.problem, row);
    const adjustment::Problem& problem = pass.problem.problem;
    std::vector<const double*> values;
    std::vector<std::vector<double>> storage;
    std::vector<double*> jacobians;
    for (int p : block->parameters) {
      if (p < 0) return {};
      values.push_back(problem.parameters[p].value.data());
      storage.emplace_back(problem.parameters[p].tangent(), 0.0);
    }
    for (auto& s : storage) jacobians.push_back(s.data());
    adjustment::RowStatistics result;
    result.sigma = 1 / block->whitening()(0, 0);
    if (!block->evaluate(values.data(), &result.residual, jacobians.data())) return result;
    Eigen::VectorXd a = Eigen::VectorXd::Zero(pass.solution.unknowns.count());
    for (size_t k = 0; k < block->parameters.size(); ++k)
      for (size_t c = 0; c < storage[k].size(); ++c) {
        const int unknown = pass.solution.unknowns(block->parameters[k], static_cast<int>(c));
        if (unknown >= 0) a[unknown] += storage[k][c];
      }
    const double network = a.dot(pass.cofactors * a);
    const double total = std::sqrt(result.sigma * result.sigma + network);
    result.sigma_adjusted = std::sqrt(network);
    result.redundancy_number = result.sigma * result.sigma / (total * total);
    result.w = result.residual / total;
    result.estimated_blunder = -result.residual;
    const double delta0 = adjustment::non_centrality(options_.alpha0, options_.power);
    result.mdb = delta0 * total;
    result.bias_to_noise = delta0 * std::sqrt(network) / result.sigma;
    return result;
  }

  /// Huber weights by iteration; observations they push out start as removed and must earn their way back.
  void remove_by_robust_weights() {
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
      pass = adjust(false);
    }
    const auto most = static_cast<size_t>(options_.largest_removed_share * static_cast<double>(m_.rows.size()));
    std::vector<std::pair<double, int>> suspects;
    for (size_t row = 0; row < state_.weight_factors.size(); ++row)
      if (state_.weight_factors[row] < kHuber / 6.0) suspects.emplace_back(state_.weight_factors[row], row);
    std::sort(suspects.begin(), suspects.end());
    if (suspects.size() > most) suspects.resize(most);
    state_.weight_factors.clear();
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
      std::fill(state_.removed.begin(), state_.removed.end(), 0);
      actions_.clear();
    }
  }

  /// Förstner's iterated estimate; a group changes only if it has enough redundancy to say something.
  void estimate_variance_components(Pass& pass) {
    constexpr double kEnoughRedundancy = 10, kClosest = 0.01, kLeast = 0.2, kMost = 5;
    for (int iteration = 0; iteration < 20; ++iteration) {
      const auto components = adjustment::variance_components(pass.problem.problem, pass.solution, pass.reliability);
      double change = 0;
      for (size_t g = 0; g < components.size() && g < kGiven; ++g) {
        if (components[g].redundancy < kEnoughRedundancy) continue;
        double& factor = state_.sigma_factors[g];
        const double wanted = std::clamp(factor * std::sqrt(components[g].factor), kLeast, kMost);
        change = std::max(change, std::abs(wanted * wanted / (factor * factor) - 1));
        factor = wanted;
      }
      if (change < kClosest) return;
      pass = adjust();
    }
    m_.findings.push_back(
        {Finding::Severity::warning, "variance components did not settle within 20 iterations; the last are used", {}});
  }

  NetworkResult report(Pass& pass);
  void report_points(const Pass& pass, NetworkResult& result) const;
  void report_set_ups(const Pass& pass, NetworkResult& result) const;
  void report_rows(const Pass& pass, NetworkResult& result) const;
  void report_pointings(const Pass& pass, NetworkResult& result) const;

  NetworkModel& m_;
  const AdjustOptions& options_;
  StochasticState state_;
  std::vector<SnoopingAction> actions_;
};

void Adjuster::report_points(const Pass& pass, NetworkResult& result) const {
  for (size_t i = 0; i < m_.ids.size(); ++i) {
    ResultPoint point;
    point.id = m_.ids[i];
    point.roles = m_.roles[i];
    const int block = pass.problem.point_blocks[i];
    for (int k = 0; k < 3; ++k) {
      const bool exists = m_.roles[i][k] != CoordinateRole::unused;
      point.position[k] = exists ? pass.problem.problem.parameters[block].value[k] : kNotGiven;
      point.unknowns[k] = pass.solution.unknowns(block, k);
    }
    result.points.push_back(std::move(point));
  }
}

void Adjuster::report_set_ups(const Pass& pass, NetworkResult& result) const {
  const auto sigma = [&](int block) {
    const int u = pass.solution.unknowns(block, 0);
    return std::sqrt(result.cofactors(u, u));
  };
  for (size_t i = 0; i < m_.survey.set_ups.size(); ++i) {
    ResultSetUp set_up{m_.survey.set_ups[i].id, m_.survey.set_ups[i].station};
    if (const int block = pass.problem.orientation_blocks[i]; block >= 0) {
      set_up.orientation = wrap_angle(pass.problem.problem.parameters[block].value[0]);
      set_up.orientation_sigma = sigma(block);
    }
    if (const int block = pass.problem.height_correction_blocks[i]; block >= 0)
      set_up.instrument_height_correction = pass.problem.problem.parameters[block].value[0];
    result.set_ups.push_back(std::move(set_up));
  }
  for (const auto& [name, block] : pass.problem.common_blocks)
    result.parameters.push_back({name, pass.problem.problem.parameters[block].value[0], sigma(block)});
}

void Adjuster::report_rows(const Pass& pass, NetworkResult& result) const {
  result.rows = m_.rows;
  const auto finish = [&](ResultRow& row, const adjustment::RowStatistics& statistics) {
    row.statistics = statistics;
    row.flagged = std::abs(statistics.w) > result.critical_w;
    if (statistics.external_group >= 0) row.external_point = m_.ids[statistics.external_group];
  };
  for (size_t r = 0; r < pass.problem.rows.size(); ++r)
    if (pass.problem.rows[r] >= 0) finish(result.rows[pass.problem.rows[r]], pass.reliability.rows[r]);
  for (size_t row = 0; row < result.rows.size(); ++row) {
    if (!state_.removed[row]) continue;
    result.rows[row].removed = true;
    finish(result.rows[row], removed_statistics(pass, static_cast<int>(row)));
  }
  // Observations that cannot be used at all are told of in the findings and have no figures here.
  std::vector<ResultRow> rows;
  std::vector<int> position(result.rows.size(), -1);
  for (size_t row = 0; row < result.rows.size(); ++row) {
    if (row < m_.dropped.size() && m_.dropped[row]) continue;
    position[row] = static_cast<int>(rows.size());
    rows.push_back(std::move(result.rows[row]));
  }
  result.rows = std::move(rows);
  result.snooping = actions_;
  for (SnoopingAction& action : result.snooping) action.row = position[action.row];
}

void Adjuster::report_pointings(const Pass& pass, NetworkResult& result) const {
  for (size_t b = 0; b < pass.problem.problem.residuals.size(); ++b) {
    const auto& block = pass.solution.linearisation.blocks[b];
    const int row = pass.problem.rows[block.row];
    if (block.rows < 2 || row < 0 || pass.problem.block_names[b].empty()) continue;
    ResultPointing pointing;
    pointing.set_up = pass.problem.block_names[b];
    pointing.to = m_.rows[row].to;
    pointing.test = pass.reliability.blocks[b];
    if (pointing.test.rank > 0) {
      pointing.critical = chi_squared_quantile(1 - options_.alpha0, pointing.test.rank);
      pointing.flagged = pointing.test.statistic > pointing.critical;
    }
    result.pointings.push_back(std::move(pointing));
  }
}

NetworkResult Adjuster::report(Pass& pass) {
  NetworkResult result;
  const Solution& s = pass.solution;
  result.datum = m_.datum;
  result.datum_points = m_.datum_points;
  result.observations = s.linearisation.rows;
  result.unknowns = s.unknowns.count();
  result.defect = s.datum.defect();
  result.degrees_of_freedom = s.degrees_of_freedom();
  result.iterations = s.iterations();
  result.sum_of_squares = s.sum_of_squares();
  if (result.degrees_of_freedom > 0) result.sigma0 = std::sqrt(result.sum_of_squares / result.degrees_of_freedom);
  result.sum_of_redundancy_numbers = pass.reliability.sum_of_redundancy_numbers;
  result.global_test = adjustment::global_test(result.sum_of_squares, result.degrees_of_freedom, options_.alpha);
  result.critical_w = critical_w();
  result.critical_tau = adjustment::tau_critical(options_.alpha0, result.degrees_of_freedom);
  result.null_space = s.datum.null_space();
  const bool scale = options_.scale_with_sigma0 == Switch::on ||
                     (options_.scale_with_sigma0 == Switch::automatic && m_.survey.info.use_a_posteriori_sigma0);
  if (scale && result.degrees_of_freedom > 0) result.variance_factor = result.sigma0 * result.sigma0;
  const auto components = adjustment::variance_components(pass.problem.problem, s, pass.reliability);
  for (size_t g = 0; g < components.size() && g < kGroups; ++g)
    if (components[g].rows > 0) result.groups.push_back({kGroupNames[g], state_.sigma_factors[g], components[g]});
  report_rows(pass, result);
  result.cofactors = std::move(pass.cofactors);
  if (result.variance_factor != 1) result.cofactors *= result.variance_factor;
  report_points(pass, result);
  report_set_ups(pass, result);
  report_pointings(pass, result);
  result.findings = m_.findings;
  const std::vector<Finding> examined = examine(m_, result);
  result.findings.insert(result.findings.end(), examined.begin(), examined.end());
  return result;
}

}  // namespace

const ResultPoint& NetworkResult::point(const std::string& id) const {
  for (const ResultPoint& p : points)
    if (p.id == id) return p;
  throw std::out_of_range("no point '" + id + "' in the network");
}

Eigen::Matrix3d NetworkResult::covariance(const ResultPoint& a, const ResultPoint& b) const {
  Eigen::Matrix3d c;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      const bool exist = !std::isnan(a.position[i]) && !std::isnan(b.position[j]);
      const bool both = a.unknowns[i] >= 0 && b.unknowns[j] >= 0;
      c(i, j) = !exist ? kNotGiven : both ? cofactors(a.unknowns[i], b.unknowns[j]) : 0.0;
    }
  return c;
}

Eigen::Matrix3d NetworkResult::relative_covariance(const ResultPoint& a, const ResultPoint& b) const {
  const Eigen::Matrix3d ab = covariance(a, b);
  return covariance(a, a) + covariance(b, b) - ab - ab.transpose();
}

Eigen::MatrixXd NetworkResult::full_covariance() const {
  const auto n = static_cast<Eigen::Index>(points.size());
  Eigen::MatrixXd full(3 * n, 3 * n);
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = 0; j < n; ++j)
      full.block<3, 3>(3 * i, 3 * j) = covariance(points[static_cast<size_t>(i)], points[static_cast<size_t>(j)]);
  return full;
}

NetworkResult adjust_network(const SurveyObservations& survey, const AdjustOptions& options,
                             const ControlPoints& control) {
  NetworkModel model = make_model(survey, options, control);
  return Adjuster(model, options).run();
}

}  // namespace plumbline::survey
