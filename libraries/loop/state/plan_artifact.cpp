// their own.
#include "loop/state/plan_artifact.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "building/ifc/edge_words.hpp"
#include "building/ifc/temperature_words.hpp"
#include "loop/state/bracket_places.hpp"
#include "loop/state/hash.hpp"
#include "loop/state/rounds_estimate.hpp"

namespace plumbline::loop {
namespace {

std::string holds_words(const std::array<bool, 3>& holds) {
  std::string words;
  for (std::size_t k = 0; k < 3; ++k)
    if (holds[k]) words += (words.empty() ? "" : "+") + std::string(kDirections[k]);
  return words;
}

/// Hash of the anchor's own measurement by this campaign.
std::string own_basis(const Facade& facade, std::size_t index) {
  const std::string& basis = facade.brackets[index].basis;
  return basis.empty() ? basis_of_bracket(facade, index) : basis;
}

std::unique_ptr<BracketSettingT> bracket_artifact(const Facade& facade, const std::string& guid, const Fit& fit,
                                                  std::size_t index, bool is_used) {
  const Bracket& bracket = facade.brackets[index];
  auto out = std::make_unique<BracketSettingT>();
  out->id = bracket.id, out->guid = guid, out->floor = bracket.floor;
  out->design = bracket.design, out->measured = bracket.design + bracket.deviation;
  out->sigma = facade.covariance.diagonal().segment<3>(3 * static_cast<Eigen::Index>(index)).cwiseMax(0).cwiseSqrt();
  for (int k = 0; k < 3; ++k) out->axes.push_back(bracket.axes.col(k));
  out->asked = fit.asked[index], out->setting = fit.settings[index];
  out->low = bracket.type.low, out->high = bracket.type.high, out->type = bracket.type.name;
  out->fixed = bracket.fixed, out->basis = own_basis(facade, index);
  out->difference_sigma = bracket.difference_sigma, out->campaigns = bracket.campaigns;
  out->use = is_used                   ? BracketUse::panel
             : bracket.is_sill         ? BracketUse::sill
             : bracket.holds_unplanned ? BracketUse::not_planned
                                       : BracketUse::nothing;
  return out;
}

/// Of a panel that hangs; empty where its hooks do not tell. Errors that are rare have no part in it.
std::vector<double> centre_sigma(const Facade& facade, const Fit& fit, std::size_t j) {
  const Panel& panel = facade.panels[j];
  if (!panel.installed || fit.poses[j].held.empty()) return {};
  std::vector<JudgedValue> along(3);
  for (int k = 0; k < 3; ++k) {
    const auto row = fit.poses[j].movement(panel, panel.centre, panel.axes.col(k));
    if (!fit.poses[j].tells(row)) return {};
    along[k].panel = j, along[k].direction = k, along[k].rows = {{j, row}};
  }
  along[2].edges = {{5 * j + 4, 1.0}};  // its face
  const Eigen::MatrixXd own = errors_of({&along[0], &along[1], &along[2]}, facade, fit.poses).covariance_when(-1);
  const Eigen::Vector3d sigma = (panel.axes * own * panel.axes.transpose()).diagonal().cwiseMax(0).cwiseSqrt();
  return {sigma.x(), sigma.y(), sigma.z()};
}

std::unique_ptr<PlannedPanelT> panel_artifact(const Facade& facade, const std::string& guid, const Fit& fit,
                                              const PanelGate& gate, std::size_t index) {
  const Panel& panel = facade.panels[index];
  auto out = std::make_unique<PlannedPanelT>();
  out->id = panel.id, out->guid = guid, out->floor = panel.floor;
  for (const Hook& hook : panel.hooks) {
    out->brackets.push_back(facade.brackets[hook.bracket].id);
    out->holds.push_back(holds_words(hook.holds));
  }
  if (panel.below)
    for (const auto& [sill, part] : panel.below->sills) out->sills.push_back(facade.brackets[sill].id);
  out->depends_on = panel.depends_on, out->centre = panel.centre;
  out->corners.assign(panel.corners.begin(), panel.corners.end());
  out->shift = fit.twists[index].head<3>(), out->rotation = fit.twists[index].tail<3>() / fit.poses[index].arm;
  out->installed = panel.installed, out->centre_sigma = centre_sigma(facade, fit, index);
  out->gate = gate.verdict == GateVerdict::go      ? GateDecision::go
              : gate.verdict == GateVerdict::no_go ? GateDecision::no_go
                                                   : GateDecision::hold;
  out->obstacle = gate.obstacle == Obstacle::none           ? PanelObstacle::none
                  : gate.obstacle == Obstacle::no_bracket   ? PanelObstacle::no_bracket
                  : gate.obstacle == Obstacle::not_measured ? PanelObstacle::not_measured
                  : gate.obstacle == Obstacle::one_bracket  ? PanelObstacle::one_bracket
                  : gate.obstacle == Obstacle::not_judged || gate.obstacle == Obstacle::assumed_sill
                      ? PanelObstacle::not_said  // held stays held
                      : PanelObstacle::hooks_do_not_tell;
  out->p_in = gate.p_in, out->reason = gate.reason;
  if (gate.decided_by >= 0) out->decided_by = fit.judged[gate.decided_by].words(facade);
  if (gate.measure.bracket >= 0) {
    out->measure = facade.brackets[gate.measure.bracket].id;
    out->p_in_measured = gate.measure.p_in;
  }
  for (const std::size_t relaxed : gate.relaxed) out->by_hand.push_back(static_cast<int>(relaxed));
  out->robot_sigma = gate.robot_sigma, out->p_in_repeated = gate.p_repeated;
  return out;
}

/// Of what this campaign measured, and of the design that it is held against.
std::string basis_of(const Facade& facade) {
  std::string text;
  for (std::size_t b = 0; b < facade.brackets.size(); ++b) {
    const Eigen::Vector3d& design = facade.brackets[b].design;
    text += own_basis(facade, b) + sha256_hex({design.x(), design.y(), design.z()}, 1e-6);
  }
  return sha256_hex(text);
}

}  // namespace

InstallationPlanT plan_artifact(const Facade& facade, const Fit& fit, const std::vector<PanelGate>& gates,
                                const PlanNames& names) {
  InstallationPlanT out;
  std::set<std::size_t> used;
  for (const Panel& panel : facade.panels)
    for (const Hook& hook : panel.hooks) used.insert(hook.bracket);
  for (std::size_t b = 0; b < facade.brackets.size(); ++b)
    out.brackets.push_back(
        bracket_artifact(facade, names.brackets.empty() ? "" : names.brackets[b], fit, b, used.count(b) > 0));
  for (const std::size_t j : installation_order(facade.panels)) {
    out.panels.push_back(panel_artifact(facade, names.panels.empty() ? "" : names.panels[j], fit, gates[j], j));
    if (facade.panels[j].installed) continue;
    out.go += gates[j].verdict == GateVerdict::go, out.hold += gates[j].verdict == GateVerdict::hold;
    out.no_go += gates[j].verdict == GateVerdict::no_go;
  }
  for (std::size_t v = 0; v < fit.judged.size(); ++v) {
    auto length = std::make_unique<PlannedLengthT>();
    length->name = fit.judged[v].words(facade);
    for (const auto& [panel, row] : fit.judged[v].rows) length->panels.push_back(facade.panels[panel].id);
    const Quantity quantity = fit.judged[v].quantity;
    length->quantity = quantity == Quantity::corner ? "corner" : quantity == Quantity::gap ? "gap" : "step";
    length->value = fit.values[v].value, length->u = fit.values[v].u;
    length->low = fit.judged[v].low, length->high = fit.judged[v].high;
    out.lengths.push_back(std::move(length));
  }
  for (const Relaxation& relaxed : fit.relaxations)
    out.relaxations.push_back(relaxed.words), out.relaxation_topics.push_back(relaxed.topic);
  out.notes = names.notes;
  out.notes.insert(out.notes.end(), fit.notes.begin(), fit.notes.end());
  out.setting_sigma = facade.errors.setting, out.station_sigma = facade.errors.station;
  out.guard_factor = facade.errors.guard_factor;
  out.basis = basis_of(facade);
  return out;
}

void add_unplanned(InstallationPlanT& plan, const std::string& id, const std::string& guid, int floor,
                   const Eigen::Vector3d& place, const std::string& why) {
  auto panel = std::make_unique<PlannedPanelT>();
  panel->id = id, panel->guid = guid, panel->floor = floor, panel->reason = why;
  panel->gate = GateDecision::hold, panel->obstacle = PanelObstacle::no_bracket;
  panel->centre = place, panel->shift.setZero(), panel->rotation.setZero();
  const auto above =
      std::find_if(plan.panels.begin(), plan.panels.end(), [&](const auto& other) { return other->floor > floor; });
  plan.panels.insert(above, std::move(panel));
  ++plan.hold;
}

void apply_state(Facade& facade, const LoopStateT& state) {
  std::map<std::string, const LoopItemT*> items;
  for (const auto& item : state.items) items[item->kind + " " + item->id] = item.get();
  for (Panel& panel : facade.panels) {
    const auto item = items.find("panel " + panel.id);
    if (item == items.end()) continue;
    const ItemStatus status = item->second->status;
    panel.installed = item->second->hangs || status == ItemStatus::executed || status == ItemStatus::relocalised ||
                      status == ItemStatus::verified;
    for (const Hook& hook : panel.hooks)
      if (panel.installed) facade.brackets[hook.bracket].fixed = true;
  }
  for (Bracket& bracket : facade.brackets) {
    const auto item = items.find("bracket " + bracket.id);
    if (item == items.end()) continue;
    const ItemStatus status = item->second->status;
    bracket.fixed = bracket.fixed || status == ItemStatus::executed || status == ItemStatus::relocalised ||
                    status == ItemStatus::verified;
    const Eigen::Vector3d used = setting_of(*item->second, bracket.design + bracket.deviation, bracket.axes);
    bracket.type.low -= used, bracket.type.high -= used;
    bracket.type.low = bracket.type.low.cwiseMin(0.0), bracket.type.high = bracket.type.high.cwiseMax(0.0);
  }
}

namespace {

constexpr const char* kSettingsHead =
    "bracket;floor;right_mm;up_mm;out_mm;left_mm_at_most;right_mm_at_most;down_mm_at_most;up_mm_at_most;"
    "in_mm_at_most;out_mm_at_most;type\n";

std::string settings_row(const BracketSettingT& bracket, const Eigen::Vector3d& setting) {
  std::string text = bracket.id + ";" + std::to_string(bracket.floor);
  const auto add = [&](double metres) { text += fmt::format(";{:.1f}", 1e3 * metres + 0.0); };
  for (int k = 0; k < 3; ++k) add(setting[k]);
  for (int k = 0; k < 3; ++k) add(-bracket.low[k]), add(bracket.high[k]);
  return text + ";" + bracket.type + "\n";
}

}  // namespace

std::string settings_csv(const InstallationPlanT& plan) {
  std::string text = kSettingsHead;
  for (const auto& bracket : plan.brackets)
    if (!bracket->fixed && bracket->use != BracketUse::sill && bracket->asked.allFinite())
      text += settings_row(*bracket, bracket->setting);
  return text;
}

std::string settings_csv(const InstallationPlanT& plan, const std::map<std::string, Eigen::Vector3d>& asked) {
  std::string text = kSettingsHead;
  for (const auto& bracket : plan.brackets)
    if (const auto setting = asked.find(bracket->id); setting != asked.end())
      text += settings_row(*bracket, setting->second);
  return text;
}

namespace {

/// VERIFIED is a probability too: what is left of it, over all that hang.
std::string hanging_words(const InstallationPlanT& plan) {
  int panels = 0;
  double outside = 0;
  for (const auto& panel : plan.panels)
    if (panel->installed && panel->p_in >= 0) ++panels, outside += 1 - panel->p_in;
  return panels == 0
             ? std::string()
             : fmt::format("{} judged; of these {:.2f} are expected to be outside their limits (the sum of 1 - p)",
                           panels, outside);
}

const char* gate_word(GateDecision gate) {
  return gate == GateDecision::go ? "GO" : gate == GateDecision::no_go ? "NO_GO" : "HOLD";
}

/// Panels that are GO as planned, after one that may not be hung: they wait with it, also through others.
std::vector<std::string> waiting_in_turn(const InstallationPlanT& plan) {
  std::map<std::string, const PlannedPanelT*> stopped_by;  // in the order of the plan: what is before comes first
  std::vector<std::string> lines;
  for (const auto& panel : plan.panels) {
    if (panel->installed) continue;
    if (panel->gate != GateDecision::go) {
      stopped_by[panel->id] = panel.get();
      continue;
    }
    for (const std::string& id : panel->depends_on) {
      const auto before = stopped_by.find(id);
      if (before == stopped_by.end()) continue;
      const PlannedPanelT* stop = before->second;
      stopped_by[panel->id] = stop;
      lines.push_back(panel->id + ": GO, and waits for " + stop->id + ", which is to hang before it and is " +
                      gate_word(stop->gate));
      break;
    }
  }
  return lines;
}

}  // namespace

std::string installation_words(const InstallationPlanT& plan) {
  std::string text = std::to_string(plan.go) + " panels GO, " + std::to_string(plan.hold) + " HOLD, " +
                     std::to_string(plan.no_go) + " NO_GO\n";
  const auto part = [&](const char* title, const std::vector<std::string>& lines) {
    if (!lines.empty()) text += std::string("\n") + title + "\n";
    for (const std::string& line : lines) text += "  " + line + "\n";
  };
  part("By hand first", plan.relaxations);
  std::vector<std::string> waiting, forbidden;
  for (const auto& panel : plan.panels) {
    if (panel->installed || panel->gate == GateDecision::go) continue;
    (panel->gate == GateDecision::hold ? waiting : forbidden).push_back(panel->id + ": " + panel->reason);
  }
  part("NO_GO", forbidden);
  part("HOLD", waiting);
  part("In their turn", waiting_in_turn(plan));
  if (const std::string hanging = hanging_words(plan); !hanging.empty()) part("What hangs", {hanging});
  part("Campaigns beside each other", plan.consistency);
  part("Not planned", plan.notes);
  part("Taken of who sets brackets",
       {fmt::format("{:.2f} mm each bracket and direction (setting_sigma), {:.2f} mm common to a floor (station_sigma)",
                    1e3 * plan.setting_sigma, 1e3 * plan.station_sigma)});
  std::vector<std::string> left_out;
  for (const std::string& words : {ifc::edge_words(plan), ifc::temperature_words(plan)})
    if (!words.empty()) left_out.push_back(words);
  part("What the plan leaves out", left_out);
  return text;
}

FileT text_file(const std::string& name, const std::string& media_type, const std::string& text) {
  FileT file;
  file.name = name, file.media_type = media_type;
  file.content.assign(text.begin(), text.end());
  return file;
}

}  // namespace plumbline::loop
