#include "build/loop/planner_node.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <set>

#include "base/text/words.hpp"
#include "building/ifc/doubt_words.hpp"
#include "loop/gate/assumed_sills.hpp"
#include "loop/gate/gate.hpp"
#include "loop/gate/station_error.hpp"
#include "loop/state/control_change.hpp"
#include "loop/state/gone_items.hpp"
#include "loop/state/plan_artifact.hpp"
#include "loop/state/reading_keys.hpp"

namespace plumbline::loop {

FacadeRules PlannerNode::rules() {
  FacadeRules rules;
  for (const std::string& text : *brackets) rules.brackets.push_back(parse_bracket_rule(text));
  for (const std::string& text : *hooks) rules.hooks.push_back(parse_hook_rule(text));
  for (const std::string& text : *after) {
    auto [panel, before] = parse_dependence(text);
    auto& known = rules.after[panel];
    known.insert(known.end(), before.begin(), before.end());
  }
  rules.standing = *standing;
  rules.errors = {*setting_sigma, *station_sigma, *edge_sigma,  *face_sigma,    *guard_factor, *slip_share,
                  *slip_sigma,    *knock_share,   *knock_sigma, *control_share, *control_sigma};
  rules.step_tolerance = *step_tolerance;
  if (!facade_normal->empty()) {
    if (facade_normal->size() != 3)
      throw std::runtime_error("facade_normal has " + std::to_string(facade_normal->size()) +
                               " numbers; expected x, y, z");
    rules.normal = Eigen::Vector3d((*facade_normal)[0], (*facade_normal)[1], (*facade_normal)[2]);
  }
  return rules;
}

/// This campaign and those before as one estimate, where they rest on the same control and have no reading in common;
/// else this one alone, and why.
RoundsEstimate PlannerNode::with_campaigns_before(FacadeInput& input, LoopStateT* before, InstallationPlanT& result) {
  std::vector<std::string> said;
  if (control)
    for (const auto& point : control.unpack().points)
      if (std::find(input.control.begin(), input.control.end(), point->id) != input.control.end()) {
        auto mark = std::make_unique<ControlMarkT>();
        mark->id = point->id, mark->place = point->position;
        result.control.push_back(std::move(mark));
      }
  RepeatedReadings repeated;
  if (readings) {
    const std::vector<ReadingKey> keys = reading_keys(readings.unpack());
    for (const ReadingKey& key : keys) {
      result.readings.push_back(key.hash);
      result.readings.insert(result.readings.end(), key.rounded.begin(), key.rounded.end());
    }
    if (before) repeated = repeated_readings(keys, before->readings);
  }
  if (before)
    if (const ControlChange change = control_change(before->control, result.control); !change.none()) {
      before->estimate = nullptr;
      said.push_back(words_of(change) + ". It counts alone, and the next ones with it");
    }
  const bool alone = before && !before->estimate;
  RoundsEstimate rounds = combine_rounds(input.facade, before, {*drift_per_storey}, 500, repeated.targets);
  if (control && input.facade.own.size() == 0 && rounds.words.empty())
    said.push_back("none of the " + std::to_string(control->points()->size()) +
                   " points of 'control' is in the model: what campaigns share is not known, and each counts alone");
  // The same campaign planned once more is no other one that repeats it.
  const bool once_more = repeated.count == repeated.all && !alone && rounds.estimate && before &&
                         rounds.estimate->campaigns == before->estimate->campaigns;
  if (repeated.count > 0 && !once_more) said.push_back(words_of(repeated));
  rounds.words.insert(rounds.words.begin(), said.begin(), said.end());
  return rounds;
}

namespace {

/// How far corners of panels are from the design, each direction, root mean square [m]: of those that hang as measured,
/// of all others as planned; nan: none is told.
double rms_corner(const InstallationPlanT& plan, bool hanging_only) {
  std::set<std::string> hanging;
  for (const auto& panel : plan.panels)
    if (panel->installed) hanging.insert(panel->id);
  double sum = 0;
  int count = 0;
  for (const auto& length : plan.lengths)
    if (length->quantity == "corner" && std::isfinite(length->value) &&
        (!hanging_only || hanging.contains(length->panels.front())))
      sum += length->value * length->value, ++count;
  return count > 0 ? std::sqrt(sum / count) : kUnknown;
}

/// In words, and what it is about.
struct PlanDoubt {
  std::string words, topic;
};

std::vector<PlanDoubt> doubts_of(const plumbline::Deviation& deviation) {
  std::vector<PlanDoubt> doubts;
  if (deviation.doubts())
    for (const auto* doubt : *deviation.doubts()) {
      MeasurementDoubtT one;
      doubt->UnPackTo(&one);
      doubts.push_back({ifc::in_words(one), EnumNameMeasurementPart(one.part) + ("/" + one.about)});
    }
  return doubts;
}

/// A measurement that is in doubt proves nothing.
void hold_all(InstallationPlanT& plan, const std::vector<PlanDoubt>& doubts) {
  for (const PlanDoubt& doubt : doubts) plan.doubts.push_back(doubt.words), plan.doubt_topics.push_back(doubt.topic);
  plan.hold += plan.go, plan.go = 0;
  for (auto& panel : plan.panels)
    if (panel->gate == GateDecision::go) {
      panel->gate = GateDecision::hold;
      panel->reason = "the measurement is in doubt: " + plan.doubts.front() + "; " + panel->reason;
    }
}

/// Of the direction that is known worst: along the view, mostly.
double largest_variance(const Eigen::Matrix3d& covariance) {
  return Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(covariance, Eigen::EigenvaluesOnly).eigenvalues()[2];
}

}  // namespace

void PlannerNode::add_stations(FacadeInput& input, Context& context) {
  const PosesT poses = stations.unpack();
  if (poses.calibration == CalibrationErrors::taken_as_exact)
    throw std::runtime_error(
        "'stations': these poses take the calibration of the camera as exact, so what they state of themselves is too "
        "little and every probability of the plan too high; give the camera its standard deviations (camera.yaml: "
        "sigmas), or take the poses of an adjustment that estimates it, such as adjust.schur");
  std::vector<Eigen::Vector3d> places;
  for (const Bracket& bracket : input.facade.brackets) places.push_back(bracket.design);
  Eigen::MatrixXd& known = input.facade.stations;
  known = station_covariances(poses, places);
  double worst = 0;
  for (std::size_t b = 0; b < places.size(); ++b)
    if (input.facade.brackets[b].measured() && !input.facade.brackets[b].fixed)
      worst = std::max(worst, largest_variance(known.block<3, 3>(3 * static_cast<Eigen::Index>(b),
                                                                 3 * static_cast<Eigen::Index>(b))));
  context.metric("station_sigma", std::sqrt(worst + std::pow(input.facade.errors.station, 2)), "m");
  input.notes.push_back(
      "robots know their place by what they see: a bracket to " + text::millimetres(std::sqrt(worst)) +
      " at worst, in the direction that is known worst; " +
      (poses.joint_covariance.empty()
           ? "brackets of one robot share it, those of two robots share nothing, as far as the poses say"
           : "brackets of one robot share it, those of two robots as much as their poses do"));
  if (poses.calibration == CalibrationErrors::not_said) {
    input.notes.push_back(
        "whether the robots' poses hold the uncertainty of their calibration is not said: where they do not, they "
        "state three to five times too little, and p is too high");
    context.warn(input.notes.back());
  }
}

void PlannerNode::run(Context& context) {
  LoopStateT before;
  if (state) before = state.unpack();
  std::vector<std::string> known;
  if (control)
    for (const auto* point : *control->points()) known.push_back(point->id()->str());
  const DesignT designed = design.unpack();
  FacadeInput input =
      facade_of(deviation.unpack(), model.unpack(), designed, state ? &before : nullptr, rules(), known);
  const std::vector<std::string> faults = faults_of(input.facade);
  if (!faults.empty()) {
    std::string text = "this facade cannot be planned:";
    for (std::size_t i = 0; i < std::min<std::size_t>(faults.size(), 20); ++i) text += "\n  " + faults[i];
    if (faults.size() > 20) text += "\n  and " + std::to_string(faults.size() - 20) + " more";
    throw std::runtime_error(text);
  }
  if (brackets->empty())
    input.notes.push_back(
        "what brackets can be set by was not said: 20 mm sideways, 15 mm in height and 25 mm out of plane are assumed");
  if (stations) add_stations(input, context);
  std::vector<PlanDoubt> doubts = doubts_of(*deviation);
  InstallationPlanT told;
  RoundsEstimate rounds;
  if (doubts.empty()) {
    rounds = with_campaigns_before(input, state ? &before : nullptr, told);
    // An old measurement verifies nothing that was done since.
    if (!rounds.repetition.empty()) doubts.push_back({rounds.repetition, "measured before"});
  }
  const Fit fit = settings(input.facade);
  const GateOptions how{*go_probability, *go_probability, *measurement_sigma};
  std::vector<PanelGate> gates = judge_plan(input.facade, fit, how);
  doubt_assumed_sills(input.facade, fit, how, gates);
  if (const std::string assumed = assumed_sill_words(input.facade); !assumed.empty()) {
    input.notes.push_back(assumed);
    context.warn(assumed);
  }
  InstallationPlanT result = plan_artifact(input.facade, fit, gates, {input.guids, input.panel_guids, input.notes});
  for (const UnplannedPanel& panel : input.unplanned)
    add_unplanned(result, panel.id, panel.guid, panel.floor, panel.place, panel.why);
  result.estimate = std::move(rounds.estimate), result.consistency = std::move(rounds.words);
  result.control = std::move(told.control), result.readings = std::move(told.readings);
  GoneItems gone = gone_items(designed, result, before);
  result.gone = std::move(gone.guids);
  if (!gone.missing.empty()) result.notes.push_back(gone.missing), context.warn(gone.missing);
  for (const std::string& line : result.consistency) context.warn(line);
  result.go_probability = *go_probability,
  result.design_file = deviation->design_file() ? deviation->design_file()->str() : "";
  if (!doubts.empty()) hold_all(result, doubts);
  for (const std::string& relaxed : result.relaxations) context.warn(relaxed);
  context.metric("panels_go", result.go, "1");
  context.metric("panels_hold", result.hold, "1");
  context.metric("panels_no_go", result.no_go, "1");
  context.metric("rms_corner", rms_corner(result, false), "m");
  if (const double hanging = rms_corner(result, true); std::isfinite(hanging))
    context.metric("rms_corner_hanging", hanging, "m");
  context.metric("relaxations", static_cast<double>(result.relaxations.size()), "1");
  table.commit(text_file("settings.csv", "text/csv", settings_csv(result)));
  words.commit(text_file("installation.txt", "text/plain", installation_words(result)));
  plan.commit(result);
}

}  // namespace plumbline::loop
