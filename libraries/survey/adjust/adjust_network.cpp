#include "survey/adjust/adjust_network.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <set>
#include <utility>

#include "survey/adjust/adjuster.hpp"
#include "survey/adjust/confirmed_causes.hpp"
#include "survey/adjust/exclusions.hpp"
#include "survey/adjust/kept_network.hpp"
#include "survey/doctor/find_causes.hpp"
#include "survey/model/observation_equations.hpp"
#include "survey/model/reduced_readings.hpp"
#include "survey/words/network_words.hpp"

namespace plumbline::survey {

using least_squares::Solution;

NetworkResult Adjuster::run(std::unique_ptr<KeptNetwork>* kept) {
  if (options_.robust_start && options_.remove_blunders) remove_by_robust_weights();
  Pass pass = adjust();
  if (options_.remove_blunders) snoop(pass);
  if (options_.estimate_variance_components) {
    estimate_variance_components(pass);
    if (options_.remove_blunders) mend(pass);
  }
  tell_rival_readings(pass, tell_contradicting_sights(pass));
  // Of the readings as they are taken in the end: what was mended is no contradiction any more, what was not still is.
  const MeasuredControl measured = options_.measure_control ? measured_control(pass) : MeasuredControl{};
  NetworkResult result = report(pass);
  result.measured_control = measured;
  if (kept)
    *kept =
        std::make_unique<KeptNetwork>(m_, std::move(pass.problem), std::move(pass.solution), result.variance_factor);
  return result;
}

namespace {

/// Values of the parameters that a network before had too; false if it had others.
bool start_from(const least_squares::Problem& before, least_squares::Problem& problem) {
  const auto& from = before.parameters;
  auto& to = problem.parameters;
  const bool same = std::equal(from.begin(), from.end(), to.begin(), to.end(), [](const auto& a, const auto& b) {
    return a.name == b.name && a.value.size() == b.value.size() && a.constant == b.constant;
  });
  for (std::size_t b = 0; same && b < to.size(); ++b) to[b].value = from[b].value;
  return same;
}

}  // namespace

namespace {

/// Residuals that no mistake of a few readings leaves.
bool ran_away(const Solution& solution) {
  constexpr double kSigma0 = 1000;
  const int degrees = solution.degrees_of_freedom();
  return degrees > 0 && solution.sum_of_squares() > kSigma0 * kSigma0 * degrees;
}

}  // namespace

Pass Adjuster::adjust(bool statistics, const Pass* before) {
  NetworkProblem problem = make_problem(m_, options_, state_);
  least_squares::SolverOptions solver;
  if (least_squares::UnknownIndex(problem.problem).count() == 0)
    throw NetworkError("there is nothing to determine: no point of the network is both observed and unknown");
  solver.datum_unknowns = datum_unknowns(m_, problem);
  if (before && start_from(before->problem.problem, problem.problem)) solver.before = &before->solution;
  solver.negligible_step = 3e-5;  // of a standard deviation: below a tenth of a micrometre in any real network
  try {
    Solution solution = least_squares::solve(problem.problem, solver);
    // Where it ran away, what its last equations leave open says nothing of the network.
    if (!solution.converged && ran_away(solution)) fail_to_converge(problem, solution);
    refuse_local_defects(problem, solution);
    if (!solution.converged) fail_to_converge(problem, solution);
    if (m_.unrelated) doubt(solution);
    Pass pass{std::move(problem), std::move(solution), {}, {}};
    if (statistics) add_statistics(pass);
    return pass;
  } catch (const least_squares::RankDefect& defect) {
    if (defect.directions.cols() == 0)
      throw NetworkError(
          "the adjustment runs away: its equations became singular on the way, though no movement of the network is "
          "open. Readings contradict each other grossly, or their units, or the approximate coordinates are wrong",
          {}, {}, PLUMBLINE_NOT_CONVERGED);
    const bool held = m_.datum == DatumMode::file || m_.datum == DatumMode::fixed;
    fail_with(name_defects(m_, problem, defect.directions),
              held ? ". Fix points, give control points, or adjust it as a free network (datum: inner)" : "");
  }
}

void Adjuster::fail_with(const std::vector<Finding>& defects, const std::string& advice) {
  std::string text = "rank defect: the network is not determined";
  for (const Finding& f : defects) text += "; " + f.text;
  std::set<std::string> points;
  for (const Finding& f : defects) points.insert(f.points.begin(), f.points.end());
  throw NetworkError(text + advice, defects, {points.begin(), points.end()});
}

void Adjuster::refuse_local_defects(const NetworkProblem& problem, const Solution& solution) const {
  const std::vector<Finding> defects = name_local_defects(m_, problem, solution.datum.null_space());
  if (!defects.empty()) fail_with(defects, ". Add observations there, or leave these points out");
}

void Adjuster::add_statistics(Pass& pass) const {
  pass.cofactors = least_squares::Cofactors(pass.solution, options_.largest_whole);
  least_squares::ReliabilityOptions reliability;
  reliability.alpha0 = options_.alpha0;
  reliability.power = options_.power;
  for (int block : pass.problem.point_blocks) {
    std::vector<int> unknowns;
    for (int k = 0; k < 3; ++k) unknowns.push_back(pass.solution.unknowns(block, k));
    reliability.groups.push_back(std::move(unknowns));
  }
  pass.reliability =
      least_squares::compute_reliability(pass.problem.problem, pass.solution, pass.cofactors, reliability);
}

void Adjuster::fail_to_converge(const NetworkProblem& problem, const Solution& solution) const {
  int worst = 0;
  solution.linearisation.residuals.cwiseAbs().maxCoeff(&worst);
  std::string text = "the adjustment does not converge: after " + std::to_string(solution.iterations()) +
                     " iterations v'Pv is " + fmt::format("{:.3g}", solution.sum_of_squares());
  if (problem.rows[worst] >= 0) {
    const ResultRow& row = m_.rows[problem.rows[worst]];
    const std::string at = place(row.source);
    text += "; the largest residual is that of the " + row.kind + " " + row.from + (row.from.empty() ? "" : " -> ") +
            row.to + (at.empty() ? "" : " (" + at + ")") + ": check its point names and value";
  }
  throw NetworkError(text, {}, {}, PLUMBLINE_NOT_CONVERGED);
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

namespace {

/// Points that observations touch.
size_t points_of(const SurveyObservations& survey) {
  std::set<std::string> ids;
  for (const Observation& o : survey.observations) ids.insert({o.from, o.to});
  return ids.size();
}

/// What is not determined may be left out where it is little beside the rest: a marker sighted once, a set-up that
/// hangs in the air. If it is much, something else is missing, and the user is to say what.
bool may_be_left_out(const std::vector<std::string>& points, size_t all, const AdjustOptions& options,
                     const ControlPoints& control) {
  constexpr size_t kShare = 3;
  if (points.empty() || kShare * points.size() > all) return false;
  const auto wanted = [&](const std::string& id) {
    return std::find(control.ids.begin(), control.ids.end(), id) != control.ids.end() ||
           std::find(options.datum_points.begin(), options.datum_points.end(), id) != options.datum_points.end();
  };
  return std::none_of(points.begin(), points.end(), wanted);
}

bool has_plan(const Point& p) { return !p.coordinates.head<2>().array().isNaN().any(); }

/// A job on known points is not determined as a free network: its backsights are sighted without a distance, its parts
/// share nothing but them. Then what the file gives is held, and that is said. False if it gives less than two
/// points, or of most (these are approximate), or if the user has said what the datum is.
bool hold_given(SurveyObservations& survey, const AdjustOptions& options, const ControlPoints& control,
                std::vector<Finding>& said) {
  const bool of_adjustment = is_of_adjustment_programs(survey);
  if (options.datum != DatumMode::automatic || !options.datum_points.empty() || !control.ids.empty() ||
      !survey.coordinates.empty() || of_adjustment)
    return false;
  std::set<std::string> observed;
  for (const Observation& o : survey.observations) observed.insert({o.from, o.to});
  std::vector<std::string> held;
  for (Point& p : survey.points) {
    if (!observed.contains(p.id) || !has_plan(p)) continue;
    if (p.roles[0] == CoordinateRole::fixed) return false;
    held.push_back(p.id);
  }
  if (held.size() < 2 || 2 * held.size() > observed.size()) return false;
  for (Point& p : survey.points)
    if (observed.contains(p.id) && has_plan(p))
      for (int k = 0; k < 3; ++k)
        if (!std::isnan(p.coordinates[k])) p.roles[k] = CoordinateRole::fixed;
  said.push_back({Finding::Severity::warning,
                  "the observations alone do not determine the network: the coordinates that the file gives of " +
                      join(held) + " are held as they are; an error in them goes into the result unseen",
                  held});
  return true;
}

/// Set-ups that hang on one point are turned by what the file states of their circles, if it does: an azimuth to the
/// first target, held. False if no other set-up than `held` that touches `open` has a stated orientation.
bool hold_orientations(SurveyObservations& survey, const std::vector<std::string>& open, const AdjustOptions& options,
                       std::set<int>& held, std::vector<Finding>& said) {
  constexpr double kHeld = 1e-7;  // [rad]
  if (options.datum != DatumMode::automatic) return false;
  const auto is_open = [&](const std::string& id) { return std::find(open.begin(), open.end(), id) != open.end(); };
  std::map<int, size_t> first;  // set-up -> its first direction
  std::set<int> touching;
  for (size_t i = 0; i < survey.observations.size(); ++i) {
    const Observation& o = survey.observations[i];
    if (o.set_up < 0 || o.kind != ObservationKind::direction || o.from == o.to) continue;
    if (std::isnan(survey.set_ups[o.set_up].stated_orientation)) continue;
    first.try_emplace(o.set_up, i);
    if ((is_open(o.from) || is_open(o.to)) && !held.contains(o.set_up)) touching.insert(o.set_up);
  }
  std::vector<std::string> names;
  for (const int s : touching) {
    const SetUp& set_up = survey.set_ups[s];
    held.insert(s);
    Observation azimuth = survey.observations[first.at(s)];
    azimuth.kind = ObservationKind::azimuth;
    azimuth.value = wrap_angle(azimuth.value + set_up.stated_orientation - (azimuth.face == 2 ? std::numbers::pi : 0));
    azimuth.sigma = kHeld;
    azimuth.set_up = azimuth.pointing = -1;
    azimuth.face = azimuth.set_number = 0;
    azimuth.corrections.push_back("stated orientation of set-up " + set_up.id + ", held");
    survey.observations.push_back(std::move(azimuth));
    names.push_back(set_up.id);
  }
  if (names.empty()) return false;
  said.push_back({Finding::Severity::warning,
                  "the observations alone do not orient " + std::string(names.size() == 1 ? "set-up " : "set-ups ") +
                      join(names) +
                      ": what the file states of the circle is held; an error in it goes into the "
                      "result unseen",
                  {}});
  return true;
}

bool any_is_given(const SurveyObservations& survey, const std::vector<std::string>& ids) {
  return std::any_of(survey.points.begin(), survey.points.end(), [&](const Point& p) {
    return has_plan(p) && std::find(ids.begin(), ids.end(), p.id) != ids.end();
  });
}

/// Where set-ups contradict each other, that is the cause, and what the solver says of it a consequence.
[[noreturn]] void fail_with_cause(const NetworkModel& model, const NetworkError& error) {
  if (model.contradiction.empty()) {
    // What might hold what is open, or has torn it.
    std::string text = error.what();
    for (const std::string& set_up : model.knocked) text += ". " + set_up;
    if (!model.known_beside_control.empty()) text += ". " + model.known_beside_control;
    throw NetworkError(text, error.findings, error.undetermined, error.kind());
  }
  std::vector<Finding> findings = {{Finding::Severity::warning, model.contradiction, {}}};
  findings.insert(findings.end(), error.findings.begin(), error.findings.end());
  throw NetworkError(model.contradiction + "; mend that first. As it is, " + error.what(), findings);
}

}  // namespace

NetworkResult adjust_as_it_is(const SurveyObservations& survey, const AdjustOptions& options,
                              const ControlPoints& all_control, std::unique_ptr<KeptNetwork>* kept) {
  std::vector<Finding> said;
  const ControlPoints control = without_excluded(all_control, options.exclude);
  SurveyObservations rest = without_excluded(survey, options.exclude, all_control, said);
  const size_t all = points_of(rest);
  std::vector<std::string> left_out;
  bool simple_start = true;
  std::set<int> oriented;  // set-ups whose stated orientation is held
  for (;;) {
    NetworkModel model;
    try {
      model = make_model(rest, options, control, simple_start);
      NetworkResult result = Adjuster(model, options).run(kept);
      result.left_out = left_out;
      result.readings -= static_cast<int>(oriented.size());  // nobody read what is held of them
      result.findings.insert(result.findings.begin() + result.compares_known_points(), said.begin(), said.end());
      return result;
    } catch (const NetworkError& error) {
      if (std::exchange(simple_start, false)) continue;  // the chain of set-ups is a shortcut, not a judgement
      std::vector<std::string> now = left_out;
      now.insert(now.end(), error.undetermined.begin(), error.undetermined.end());
      const bool little = !error.undetermined.empty() && may_be_left_out(now, all, options, control);
      const bool known = any_is_given(rest, error.undetermined);
      if (!error.undetermined.empty() && (known || !little) && hold_given(rest, options, control, said)) {
        simple_start = true;
        continue;
      }
      if (hold_orientations(rest, error.undetermined, options, oriented, said)) {
        simple_start = true;
        continue;
      }
      if (!little) fail_with_cause(model, error);
      said.push_back({Finding::Severity::warning,
                      "left out, the rest is adjusted: " + join(error.undetermined) + ". " + error.what(),
                      error.undetermined, Finding::Subject::left_out, error.what()});
      left_out = now;
      rest = without_points(rest, error.undetermined);
    }
  }
}

static NetworkResult adjust_network(const SurveyObservations& survey, const AdjustOptions& options,
                                    const ControlPoints& control, std::unique_ptr<KeptNetwork>* kept) {
  check_indices(survey);
  try {
    NetworkResult result = adjust_as_it_is(survey, options, control, kept);
    explain_scale(survey, options, control, result);
    if (result.validity != Validity::invalid) {
      explain_left_out(survey, options, control, result);
      return result;
    }
    const std::vector<Finding> causes = confirmed_causes(survey, options, control, result.sigma0);
    result.findings.insert(result.findings.begin(), causes.begin(), causes.end());
    return result;
  } catch (const NetworkError& error) {
    std::vector<Finding> findings = confirmed_causes(survey, options, control, kNotGiven);
    if (findings.empty()) throw;
    const std::string text = findings.front().text + ". " + error.what();
    findings.insert(findings.end(), error.findings.begin(), error.findings.end());
    throw NetworkError(text, findings, error.undetermined);
  }
}

NetworkResult adjust_network(const SurveyObservations& survey, const AdjustOptions& options,
                             const ControlPoints& control) {
  return adjust_network(survey, options, control, nullptr);
}

NetworkResult adjust_network(const SurveyObservations& survey, const AdjustOptions& options,
                             const ControlPoints& control, std::unique_ptr<KeptNetwork>& kept) {
  return adjust_network(survey, options, control, &kept);
}

}  // namespace plumbline::survey
