#include "loop/simulate/trial.hpp"

#include <algorithm>
#include <cmath>
#include <set>

#include "loop/job/job.hpp"
#include "loop/state/plan_artifact.hpp"
#include "loop/state/rounds_estimate.hpp"

namespace plumbline::loop {

const char* name_of(Strategy strategy) {
  return strategy == Strategy::open            ? "open"
         : strategy == Strategy::measured_once ? "measured once"
         : strategy == Strategy::unattended    ? "closed, no one"
                                               : "closed";
}

namespace {

/// Floors `from` to `to` of a facade, with what joins them.
Facade part_of(const Facade& whole, int from, int to) {
  Facade part;
  part.errors = whole.errors;
  std::vector<std::size_t> brackets, panel_at(whole.panels.size(), whole.panels.size());
  std::vector<std::size_t> bracket_at(whole.brackets.size());
  for (std::size_t b = 0; b < whole.brackets.size(); ++b)
    if (whole.brackets[b].floor >= from && whole.brackets[b].floor <= to) {
      bracket_at[b] = part.brackets.size();
      brackets.push_back(b), part.brackets.push_back(whole.brackets[b]);
    }
  for (std::size_t j = 0; j < whole.panels.size(); ++j) {
    if (whole.panels[j].floor < from || whole.panels[j].floor > to) continue;
    panel_at[j] = part.panels.size();
    part.panels.push_back(whole.panels[j]);
    for (Hook& hook : part.panels.back().hooks) hook.bracket = bracket_at[hook.bracket];
  }
  for (Joint joint : whole.joints) {
    joint.a = panel_at[joint.a], joint.b = panel_at[joint.b];
    if (joint.a < whole.panels.size() && joint.b < whole.panels.size()) part.joints.push_back(joint);
  }
  std::vector<Eigen::Index> rows;
  for (const std::size_t b : brackets)
    for (Eigen::Index k = 0; k < 3; ++k) rows.push_back(3 * static_cast<Eigen::Index>(b) + k);
  part.covariance = whole.covariance(rows, rows);
  if (whole.own.size() > 0) part.own = whole.own(rows, rows);
  return part;
}

/// The other anchors of the campaign are compared with the campaign before, too, though nothing is planned for them
/// yet.
void add_other_brackets(InstallationPlanT& plan, const Facade& measured) {
  std::set<std::string> planned;
  for (const auto& bracket : plan.brackets) planned.insert(bracket->id);
  Facade others;
  for (const Bracket& bracket : measured.brackets)
    if (!planned.count(bracket.id)) others.brackets.push_back(bracket);
  const auto n = static_cast<Eigen::Index>(others.brackets.size());
  others.covariance.setZero(3 * n, 3 * n);  // for their standard deviations
  for (std::size_t b = 0, i = 0; b < measured.brackets.size(); ++b)
    if (!planned.count(measured.brackets[b].id)) {
      const auto from = 3 * static_cast<Eigen::Index>(b), to = 3 * static_cast<Eigen::Index>(i++);
      others.covariance.block<3, 3>(to, to) = measured.covariance.block<3, 3>(from, from);
    }
  Fit nothing;
  nothing.asked.assign(others.brackets.size(), Eigen::Vector3d::Zero()), nothing.settings = nothing.asked;
  InstallationPlanT seen = plan_artifact(others, nothing, {});
  for (auto& bracket : seen.brackets) plan.brackets.push_back(std::move(bracket));
}

/// Poses and values of the whole design: hooks measured everywhere.
struct Truth {
  std::vector<PanelPose> poses;
  std::vector<JudgedValue> judged;
  explicit Truth(Facade design) {
    for (Bracket& bracket : design.brackets) bracket.deviation.setZero();
    for (const Panel& panel : design.panels) poses.push_back(pose_of(panel, design.brackets));
    std::vector<std::string> untold;
    judged = judged_values(design, poses, untold);
  }
};

double excess(double value, const JudgedValue& judged) {
  return std::max({0.0, judged.low - value, value - judged.high});
}

/// Whether all panels that a length belongs to hang.
bool hang(const JudgedValue& judged, const std::vector<bool>& hung) {
  return std::all_of(judged.rows.begin(), judged.rows.end(), [&](const auto& row) { return hung[row.first]; });
}

/// By panel, how far its worst length is outside [m]; infinite for one that does not hang.
std::vector<double> worst_excess(const std::vector<JudgedValue>& judged, const std::vector<double>& values,
                                 const std::vector<bool>& hung) {
  std::vector<double> worst(hung.size(), 0.0);
  for (std::size_t v = 0; v < judged.size(); ++v)
    for (const auto& [panel, row] : judged[v].rows)
      if (hang(judged[v], hung)) worst[panel] = std::max(worst[panel], excess(values[v], judged[v]));
  for (std::size_t j = 0; j < hung.size(); ++j)
    if (!hung[j]) worst[j] = std::numeric_limits<double>::infinity();
  return worst;
}

void look_at_truth(const SimulatedSite& site, const std::vector<bool>& hung, TrialResult& result) {
  const Truth truth(site.design());
  const auto& panels = site.design().panels;
  const std::vector<double> values = site.true_values(truth.judged, truth.poses);
  const std::vector<double> worst = worst_excess(truth.judged, values, hung);
  result.panels = static_cast<int>(panels.size());
  result.inside_by_floor.assign(static_cast<std::size_t>(panels.back().floor), 0);
  double height = 0;
  int top = 0;
  for (std::size_t j = 0; j < panels.size(); ++j)
    if (worst[j] == 0) ++result.panels_inside, ++result.inside_by_floor[panels[j].floor - 1];
  for (std::size_t v = 0; v < values.size(); ++v) {
    const JudgedValue& judged = truth.judged[v];
    if (!hang(judged, hung)) continue;
    if (judged.quantity != Quantity::corner)
      ++result.joints, result.joints_inside += excess(values[v], judged) == 0;
    else if (judged.direction == 1 && panels[judged.panel].floor == panels.back().floor)
      height += values[v], ++top;
  }
  result.top_height = top > 0 ? height / top : kUnknown;
}

void measured_once(SimulatedSite& site, TrialResult& result) {
  const Facade facade = site.measure(1);
  const Fit fit = plan_settings(facade);
  Facade apart = facade;
  apart.covariance = Eigen::MatrixXd(facade.covariance.diagonal().asDiagonal());
  const std::vector<PanelGate> gates = judge_plan(facade, fit);
  std::set<int> limited;
  for (const Relaxation& relaxed : fit.relaxations) limited.insert(relaxed.bracket);
  for (const Panel& panel : facade.panels)
    result.infeasible += std::any_of(panel.hooks.begin(), panel.hooks.end(), [&](const Hook& hook) {
      return limited.count(static_cast<int>(hook.bracket)) > 0;
    });
  for (std::size_t b = 0; b < fit.settings.size(); ++b) {
    result.settings += fit.settings[b].norm() > 0;
    if (fit.settings[b].norm() > 0) site.set(b, fit.settings[b], 1);
  }
  // What the plan states is of the building as it was measured; panels load it afterwards.
  const std::vector<double> values = site.true_values(fit.judged, fit.poses);
  const std::vector<double> worst = worst_excess(fit.judged, values, std::vector<bool>(facade.panels.size(), true));
  for (std::size_t j = 0; j < gates.size(); ++j) result.stated.push_back({gates[j].p_in, worst[j] == 0});
  for (std::size_t v = 0; v < values.size(); ++v) {
    if (fit.judged[v].quantity == Quantity::corner) continue;
    const double off = values[v] - fit.values[v].value;
    const double u = std::sqrt(errors_of({&fit.judged[v]}, apart, fit.poses).covariance()(0, 0));
    result.joint_nees += off * off / (fit.values[v].u * fit.values[v].u),
        result.joint_nees_diagonal += off * off / (u * u);
    ++result.joint_values;
  }
  for (int floor = 1; floor <= facade.panels.back().floor; ++floor) site.hang(floor);
}

std::string planted_at(const SimulatedSite& site, const Panel& panel) {
  std::string words;
  for (const Hook& hook : panel.hooks)
    for (const PlantedFault& fault : site.planted())
      if (fault.item == site.design().brackets[hook.bracket].id && fault.size > 0)
        words += "; " + fault.item + ": " + fault.kind + " in round " + std::to_string(fault.round);
  return words;
}

/// `looked_at`: ids of items and floors that a person accepted.
std::vector<bool> count_verified(const SimulatedSite& site, const LoopStateT& state,
                                 const std::set<std::string>& looked_at, TrialResult& result) {
  const Truth truth(site.design());
  const auto& panels = site.design().panels;
  std::set<std::string> verified;
  for (const auto& item : state.items) {
    result.reworks += item->reworks;
    if (item->kind != "panel") continue;
    if (item->status == ItemStatus::verified)
      verified.insert(item->id);
    else
      result.left.push_back(item->id + " " + name_of(item->status) + ": " + item->why);
  }
  std::vector<bool> hung;
  for (const Panel& panel : panels) hung.push_back(verified.count(panel.id) > 0);
  const std::vector<double> worst = worst_excess(truth.judged, site.true_values(truth.judged, truth.poses), hung);
  for (std::size_t j = 0; j < panels.size(); ++j) {
    if (!hung[j]) continue;
    ++result.verified, result.verified_wrong += worst[j] > 0;
    result.by_person += looked_at.contains(panels[j].id) ||
                        std::any_of(panels[j].hooks.begin(), panels[j].hooks.end(), [&](const Hook& hook) {
                          return looked_at.contains(site.design().brackets[hook.bracket].id);
                        });
    result.verified_worst = std::max(result.verified_worst, worst[j]);
    if (worst[j] > 0) result.wrong.push_back(panels[j].id + planted_at(site, panels[j]));
  }
  return hung;
}

/// Faults that left a hook 2 mm off or more from where the state believes it, and that a verified bracket still has.
void count_planted(const SimulatedSite& site, const LoopStateT& state, TrialResult& result) {
  result.planted = static_cast<int>(site.planted().size());
  for (const PlantedFault& fault : site.planted()) ++result.planted_by_kind[fault.kind];
  for (const auto& item : state.items) {
    if (item->kind == "panel" && item->status == ItemStatus::verified && !site.hangs(item->id))
      ++result.planted_verified, result.missed.push_back(item->id + ": VERIFIED, and does not hang");
    if (item->kind != "bracket" || item->status != ItemStatus::verified || !item->expected.allFinite()) continue;
    for (std::size_t b = 0; b < site.design().brackets.size(); ++b) {
      const Bracket& bracket = site.design().brackets[b];
      if (bracket.id != item->id) continue;
      // On the control that there is.
      const Eigen::Vector3d place =
          bracket.design + site.true_deviations()[b] + site.control_height(bracket.floor) * Eigen::Vector3d::UnitZ();
      const double off = (place - item->expected).cwiseAbs().maxCoeff();
      if (off <= 0.0045) continue;  // tolerance of a setting and four standard deviations of a campaign
      ++result.planted_verified;
      for (const PlantedFault& fault : site.planted())
        if (fault.item == item->id || fault.item == "floor " + std::to_string(bracket.floor))
          result.missed.push_back(item->id + ": " + fault.kind + " in round " + std::to_string(fault.round));
      for (const std::string& line : state.journal)
        if (line.find("\"" + item->id + "\"") != std::string::npos) result.missed.push_back(line);
    }
  }
}

void look_at_plates_of(SimulatedSite& site, const std::string& id, TrialResult& result) {
  for (const Panel& panel : site.design().panels) {
    if (panel.id != id) continue;
    for (const Hook& hook : panel.hooks) site.mend_plate(site.design().brackets[hook.bracket].id);
  }
  ++result.looks;
}

/// A person goes where the state sends one: to brackets that moved without explanation, once to each that was set too
/// often, and to the control of a floor that was in doubt twice in a row (once may have been the campaign).
void look_at_what_is_asked(SimulatedSite& site, LoopStateT& state, std::set<std::string>& in_doubt,
                           std::set<std::string>& set_too_often, std::set<std::string>& looked_at,
                           TrialResult& result) {
  const std::vector<std::string> control = state.moved_control;
  for (const std::string& name : control)
    if (in_doubt.count(name)) accept_item(state, name), ++result.looks;
  in_doubt = {state.moved_control.begin(), state.moved_control.end()};
  std::vector<std::string> rejected;
  for (const auto& item : state.items) {
    const bool is_elsewhere = item->reason == ItemReason::measured_elsewhere;
    const bool is_doubtful = is_elsewhere || item->reason == ItemReason::look;
    const bool was_set_too_often = item->kind == "bracket" && item->reason == ItemReason::reworked_too_often;
    if (item->status != ItemStatus::rejected || !(is_doubtful || was_set_too_often)) continue;
    if (!is_doubtful && !set_too_often.insert(item->id).second) continue;
    rejected.push_back(item->id);
    if (item->kind == "bracket") site.mend_plate(item->id), ++result.looks;
    if (item->kind == "panel" && is_elsewhere) look_at_plates_of(site, item->id, result);
  }
  for (const auto& item : state.items)
    if (item->kind == "panel" && item->status == ItemStatus::relocalised && item->hangs && !item->seen)
      rejected.push_back(item->id), ++result.looks;
  for (const std::string& id : rejected) site.hang_what_does_not(id), accept_item(state, id), looked_at.insert(id);
}

/// A campaign, and the plan for floors `from` to `to` on it and on those before.
InstallationPlanT plan_on(const Facade& measured, int from, int to, const LoopStateT& state, bool& is_limited) {
  Facade all = measured;
  RoundsEstimate rounds = combine_rounds(all, &state);
  Facade facade = part_of(all, from, to);
  apply_state(facade, state);
  const Fit fit = plan_settings(facade);
  InstallationPlanT plan = plan_artifact(facade, fit, judge_plan(facade, fit));
  add_other_brackets(plan, all);
  plan.estimate = std::move(rounds.estimate), plan.consistency = std::move(rounds.words);
  is_limited = !fit.relaxations.empty();
  return plan;
}

/// All floors by the last campaigns: what was verified while the building was lower and lighter is verified by what it
/// is now.
void look_at_all_floors(SimulatedSite& site, LoopStateT& state, int& round) {
  constexpr int kMostCampaigns = 4;
  const MachineOptions options;
  for (int again = 0; again < kMostCampaigns; ++again) {
    state.round = ++round;
    bool is_limited = false;
    apply_plan(state, plan_on(site.measure(round), 1, site.design().panels.back().floor, state, is_limited), options);
    close_round(state);
    const bool is_sure = std::none_of(state.items.begin(), state.items.end(), [](const auto& item) {
      return item->kind == "panel" && item->status == ItemStatus::relocalised;
    });
    if (is_sure) return;
  }
}

std::vector<bool> closed(SimulatedSite& site, bool attended, TrialResult& result) {
  constexpr int kMostRounds = 20;  // of one floor
  LoopStateT state;
  const MachineOptions options;
  std::set<std::string> in_doubt, set_too_often, looked_at;
  int round = 0;
  for (int floor = 1; floor <= site.design().panels.back().floor; ++floor) {
    std::set<std::string> limited;
    for (int again = 0; again < kMostRounds; ++again) {
      state.round = ++round;
      bool is_limited = false;
      const InstallationPlanT plan = plan_on(site.measure(round), std::max(1, floor - 1), floor, state, is_limited);
      apply_plan(state, plan, options);
      note_jobs(plan, state);
      for (const auto& panel : plan.panels)
        if (panel->floor == floor && panel->gate == GateDecision::no_go && is_limited) limited.insert(panel->id);
      for (const auto& item : state.items)
        result.settings += item->kind == "bracket" && item->status == ItemStatus::released;
      apply_actuals(state, site.execute(state, round));
      close_round(state);
      if (attended) look_at_what_is_asked(site, state, in_doubt, set_too_often, looked_at, result);
      bool open = false;
      for (const auto& item : state.items)
        open = open || (item->kind == "panel" && item->floor == floor && item->status != ItemStatus::verified &&
                        item->status != ItemStatus::rejected);
      if (!open) break;
    }
    for (const auto& item : state.items)
      result.infeasible += item->kind == "panel" && item->floor == floor && item->status != ItemStatus::verified &&
                           limited.count(item->id) > 0;
  }
  look_at_all_floors(site, state, round);
  result.rounds = round, result.journal = state.journal;
  count_planted(site, state, result);
  return count_verified(site, state, looked_at, result);
}

}  // namespace

TrialResult run_trial(const SiteOptions& options, Strategy strategy, std::uint64_t seed) {
  SimulatedSite site(options, seed);
  TrialResult result;
  if (strategy == Strategy::open) site.set_to_design();
  if (strategy == Strategy::measured_once) measured_once(site, result);
  std::vector<bool> hung(site.design().panels.size(), true);
  if (strategy == Strategy::closed || strategy == Strategy::unattended)
    hung = closed(site, strategy == Strategy::closed, result);
  look_at_truth(site, hung, result);
  return result;
}

}  // namespace plumbline::loop
