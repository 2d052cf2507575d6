#include "survey/adjust/adjust_network.hpp"

#include "survey/adjust/adjuster.hpp"

namespace plumbline::survey {

using adjustment::Solution;

NetworkResult Adjuster::run() {
  if (options_.robust_start && options_.remove_blunders) remove_by_robust_weights();
  Pass pass = adjust();
  if (options_.remove_blunders) snoop(pass);
  if (options_.estimate_variance_components) {
    estimate_variance_components(pass);
    if (options_.remove_blunders) snoop(pass);
  }
  return report(pass);
}

Pass Adjuster::adjust(bool statistics) {
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
    if (m_.unrelated) doubt(solution);
    Pass pass{std::move(problem), std::move(solution), {}, {}};
    if (statistics) add_statistics(pass);
    return pass;
  } catch (const adjustment::RankDefect& defect) {
    const bool held = m_.datum == DatumMode::file || m_.datum == DatumMode::fixed;
    fail_with(name_defects(m_, problem, defect.directions),
              held ? ". Fix points, give control points, or adjust it as a free network (datum: inner)" : "");
  }
}

void Adjuster::fail_with(const std::vector<Finding>& defects, const std::string& advice) {
  std::string text = "rank defect: the network is not determined";
  for (const Finding& f : defects) text += "; " + f.text;
  throw NetworkError(text + advice, defects);
}

void Adjuster::refuse_local_defects(const NetworkProblem& problem, const Solution& solution) const {
  const std::vector<Finding> defects = name_local_defects(m_, problem, solution.datum.null_space());
  if (!defects.empty()) fail_with(defects, ". Add observations there, or leave these points out");
}

void Adjuster::add_statistics(Pass& pass) const {
  pass.cofactors = adjustment::cofactor_matrix(pass.solution);
  adjustment::ReliabilityOptions reliability;
  reliability.alpha0 = options_.alpha0;
  reliability.power = options_.power;
  for (int block : pass.problem.point_blocks) {
    std::vector<int> unknowns;
    for (int k = 0; k < 3; ++k) unknowns.push_back(pass.solution.unknowns(block, k));
    reliability.groups.push_back(std::move(unknowns));
  }
  pass.reliability = adjustment::compute_reliability(pass.problem.problem, pass.solution, pass.cofactors, reliability);
}

void Adjuster::fail_to_converge(const NetworkProblem& problem, const Solution& solution) const {
  int worst = 0;
  solution.linearisation.residuals.cwiseAbs().maxCoeff(&worst);
  std::string text = "the adjustment does not converge: after " + std::to_string(solution.iterations()) +
                     " iterations v'Pv is " + std::to_string(solution.sum_of_squares());
  if (problem.rows[worst] >= 0) {
    const ResultRow& row = m_.rows[problem.rows[worst]];
    text += "; the largest residual is that of the " + row.kind + " " + row.from + " -> " + row.to + " (" +
            place(row.source) + "): check its point names and value";
  }
  throw NetworkError(text);
}

void Adjuster::doubt(const Solution& solution) const {
  constexpr double kLargestSigma0 = 5;
  const int degrees = solution.degrees_of_freedom();
  if (degrees > 0 && solution.sum_of_squares() < kLargestSigma0 * kLargestSigma0 * degrees) return;
  throw NetworkError(
      "no approximate coordinates could be found that fit all observations: parts of the network are tied to each "
      "other "
      "by too few points in common; give approximate coordinates of its set-ups");
}

NetworkResult adjust_network(const SurveyObservations& survey, const AdjustOptions& options,
                             const ControlPoints& control) {
  NetworkModel model = make_model(survey, options, control);
  return Adjuster(model, options).run();
}

}  // namespace plumbline::survey