#include "show/report/installation_page.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>

#include "building/ifc/edge_words.hpp"
#include "building/ifc/temperature_words.hpp"
#include "show/report/format.hpp"
#include "show/report/language.hpp"
#include "show/report/plot.hpp"
#include "show/report/sections.hpp"

namespace plumbline::report {

namespace {

struct FloorWork {
  std::vector<std::string> set, hang, measure, look, wait;
  std::string last;  ///< who worked there last
  int panels = 0, verified = 0;
};

bool nobody_saw(const LoopItemT& item) {
  return item.kind == "panel" && item.status == ItemStatus::relocalised && item.hangs && !item.seen;
}

/// Why a panel that hangs is to be taken down; empty: it is not.
std::string why_down(const LoopItemT& item) {
  if (item.gone) return item.hangs ? "the design does not have it any more" : "";
  return item.status == ItemStatus::rework && item.hangs ? item.why : "";
}

std::map<int, FloorWork, std::greater<>> work_of(const LoopStateT& state) {
  std::map<int, FloorWork, std::greater<>> floors;
  for (const auto& item : state.items) {
    FloorWork& floor = floors[item->floor];
    if (!why_down(*item).empty()) floor.look.push_back(item->id);
    if (item->gone) continue;
    const bool is_panel = item->kind == "panel";
    floor.panels += is_panel, floor.verified += is_panel && item->status == ItemStatus::verified;
    if (!item->by.empty()) floor.last = item->by;
    switch (item->status) {
      case ItemStatus::released:
      case ItemStatus::executing:
        (is_panel ? floor.hang : floor.set).push_back(item->id);
        break;
      case ItemStatus::executed:
      case ItemStatus::relocalised:
        (nobody_saw(*item) ? floor.look : floor.measure).push_back(item->id);
        break;
      case ItemStatus::rejected:
        floor.look.push_back(item->id);
        break;
      case ItemStatus::planned:
        if (is_panel) floor.wait.push_back(item->id);
        break;
      default:
        break;
    }
  }
  return floors;
}

/// "F01-C01-R1, F01-C02-R1, … +14": the tables below have all.
std::string some_of(const std::vector<std::string>& ids) {
  constexpr std::size_t kShown = 6;
  if (ids.empty()) return unknown;
  std::string text;
  for (std::size_t i = 0; i < std::min(ids.size(), kShown); ++i) text += (i ? ", " : "") + ids[i];
  return verbatim(ids.size() > kShown ? text + ", … +" + std::to_string(ids.size() - kShown) : text);
}

std::string floor_word(int floor) { return floor > 0 ? std::to_string(floor) : std::string("not known"); }

void write_next_table(Markup& html, const LoopStateT& state, const std::map<int, std::string>& robots) {
  Scope wide(html, "div", {{"class", "wide"}});
  Scope table(html, "table");
  table_head(html, {"Floor", left("Robot"), left("Set"), left("Hang"), left("Measure"), left("A person looks at"),
                    left("Waits"), "Panels verified"});
  Scope body(html, "tbody");
  for (const auto& [number, floor] : work_of(state)) {
    const auto robot = robots.find(number);
    const std::string who = robot != robots.end() ? robot->second
                            : floor.last.empty()  ? std::string("any")
                                                  : "any (last: " + floor.last + ")";
    Scope row(html, "tr");
    html.element("th", {{"scope", "row"}}, floor_word(number));
    for (const std::string& cell : {who, some_of(floor.set), some_of(floor.hang), some_of(floor.measure),
                                    some_of(floor.look), some_of(floor.wait)})
      html.element("td", {{"class", "words"}, {"style", "min-width:5em"}}, cell);
    html.element("td", std::to_string(floor.verified) + " of " + std::to_string(floor.panels));
  }
}

void write_some(Markup& html, const std::vector<std::string>& lines) {
  constexpr std::size_t kShown = 12;
  Scope list(html, "ul");
  for (std::size_t i = 0; i < std::min(lines.size(), kShown); ++i) html.element("li", lines[i]);
  if (lines.size() > kShown)
    html.element("li", std::to_string(lines.size() - kShown) + " more: the table of brackets and panels has all");
}

void write_by_hand(Markup& html, const InstallationPlanT& plan, const LoopStateT& state) {
  std::vector<std::string> lines;
  for (const std::string& control : state.moved_control)
    lines.push_back(control + " moved: nothing there is verified or released before somebody has looked at it");
  for (const std::string& doubt : plan.doubts) lines.push_back("The measurement is not to be trusted: " + doubt);
  if (const auto refused = std::count_if(state.refused.begin(), state.refused.end(),
                                         [&](const auto& report) { return report->round == state.round; });
      refused > 0)
    lines.push_back(count(static_cast<int>(refused), "report was", "reports were") +
                    " not taken in this round: the table of reports below says why");
  for (const std::string& words : plan.relaxations) lines.push_back(words);
  for (const auto& item : state.items)
    if (const std::string why = why_down(*item); !why.empty())
      lines.push_back(
          (item->gone ? "look whether " + item->id + " is to be taken down: " : "take down " + item->id + ": ") + why);
    else if (item->status == ItemStatus::rejected || nobody_saw(*item))
      lines.push_back(item->id + ": " + item->why);
  if (lines.empty()) return;
  Scope box(html, "div", {{"class", "warnings"}});
  html.element("h2", "For a person");
  write_some(html, lines);
}

/// Panels that wait for something other than their brackets and the panels below: what the next step asks for.
void write_waiting(Markup& html, const LoopStateT& state) {
  std::vector<std::string> lines;
  for (const auto& item : state.items)
    if (item->kind == "panel" && item->status == ItemStatus::planned && !item->why.empty() &&
        item->reason != ItemReason::waits_for_brackets && item->reason != ItemReason::waits_for_panel)
      lines.push_back(item->id + ": " + item->why);
  if (lines.empty()) return;
  html.element("h3", "What waits, and for what");
  write_some(html, lines);
}

}  // namespace

std::set<std::string> idle_brackets(const InstallationPlanT& plan, const LoopStateT& state) {
  std::set<std::string> bare, idle;
  for (const auto& bracket : plan.brackets)
    if (bracket->use == BracketUse::nothing || bracket->use == BracketUse::sill) bare.insert(bracket->id);
  for (const auto& item : state.items)
    if (item->kind == "bracket" && item->status == ItemStatus::planned && bare.count(item->id) > 0)
      idle.insert(item->id);
  return idle;
}

void write_next(Markup& html, const InstallationPlanT& plan, const LoopStateT& state,
                const std::map<int, std::string>& robots) {
  int panels = 0, verified = 0, rejected = 0, unseen = 0;
  for (const auto& item : state.items) {
    rejected += !why_down(*item).empty();
    if (item->gone) continue;
    panels += item->kind == "panel", rejected += item->status == ItemStatus::rejected, unseen += nobody_saw(*item);
    verified += item->kind == "panel" && item->status == ItemStatus::verified;
  }
  // Panels that were verified stay so while somebody is to look at control, at a bracket or at the measurement.
  const bool all =
      panels > 0 && verified == panels && rejected == 0 && state.moved_control.empty() && plan.doubts.empty();
  const auto verdict = all                                            ? ToleranceVerdict::pass
                       : rejected > 0 || !state.moved_control.empty() ? ToleranceVerdict::fail
                                                                      : ToleranceVerdict::undecided;
  Scope part(html, "section", {{"id", "next"}});
  {
    const std::string heading = plan.doubts.empty()
                                    ? "Next: " + state.next
                                    : "Mend the measurement, it decides nothing: " + plan.doubts.front();
    Scope box(html, "div", {{"class", std::string("verdict ") + verdict_class(verdict)}});
    {
      Scope svg = drawing(html, 44, 46, heading);
      verdict_symbol(html, 22, 23, 16, verdict, false);
    }
    Scope words(html, "div");
    html.element("strong", heading);
    html.element("p", std::to_string(verified) + " of " + count(panels, "panel hangs and is", "panels hang and are") +
                          " verified after round " + std::to_string(state.round) + " (revision " +
                          std::to_string(state.revision) + "); " +
                          count(rejected + unseen, "item waits", "items wait") + " for a person.");
  }
  write_next_table(html, state, robots);
  write_by_hand(html, plan, state);
  write_waiting(html, state);
}

namespace {

void write_reworks(Markup& html, const std::vector<LoopChange>& changes) {
  html.element("h3", "What was done again or given to a person, and why");
  std::vector<const LoopChange*> wrong;
  for (const LoopChange& change : changes)
    if (change.to == "REWORK" || change.to == "REJECTED" || change.to == "STALE") wrong.push_back(&change);
  if (wrong.empty()) {
    html.element("p", "Nothing.");
    return;
  }
  Scope wide(html, "div", {{"class", "wide"}});
  Scope table(html, "table", {{"class", "sortable"}});
  table_head(html, {"Round", left("Item"), left("Before"), left("Now"), left("Why")});
  Scope body(html, "tbody");
  for (const LoopChange* change : wrong)
    table_row(html, {std::to_string(change->round + 1), left(verbatim(change->item)), left(change->from),
                     left(change->to), sentence(change->why)});
}

struct Heights {
  int n = 0;
  double without = 0, now = 0, worst_without = 0, worst_now = 0;
};

/// What the loop has taken off the drift: of the highest floor against the lowest.
void write_drift(Markup& html, const std::map<int, Heights>& floors) {
  const auto known = floors.upper_bound(0);  // 0: on which floor it is, is not known
  if (known == floors.end() || known == std::prev(floors.end())) return;
  const auto& [low, lowest] = *known;
  const auto& [high, highest] = *floors.rbegin();
  const double now = highest.now / highest.n - lowest.now / lowest.n;
  const double without = highest.without / highest.n - lowest.without / lowest.n;
  html.element("p", "From floor " + floor_word(low) + " to floor " + floor_word(high) + " the mean height drifts by " +
                        signed_mm(now, 1) + " mm; without what was set it would by " + signed_mm(without, 1) +
                        " mm: the drift that closing the loop prevented is " +
                        signed_mm(std::abs(without) - std::abs(now), 1) + " mm.");
}

/// What the heights of anchors that panels hang on would be without what was set, and are: by floor, so that drift
/// shows. `idle`: brackets on which none hangs.
void write_heights(Markup& html, const InstallationPlanT& plan, const LoopStateT& state,
                   const std::set<std::string>& idle) {
  std::map<std::string, const LoopItemT*> items;
  for (const auto& item : state.items)
    if (item->kind == "bracket") items[item->id] = item.get();
  std::map<int, Heights> floors;
  for (const auto& bracket : plan.brackets) {
    const auto item = items.find(bracket->id);
    if (item == items.end() || !bracket->measured.allFinite() || bracket->axes.size() != 3) continue;
    if (idle.count(bracket->id) > 0) continue;
    const double now = bracket->axes[1].dot(bracket->measured - bracket->design);
    const double without = now - item->second->setting.y();
    Heights& h = floors[bracket->floor];
    ++h.n, h.now += now, h.without += without;
    h.worst_now = std::max(h.worst_now, std::abs(now)), h.worst_without = std::max(h.worst_without, std::abs(without));
  }
  if (floors.empty()) return;
  html.element("h3", "Heights of the brackets, as they are and without what was set");
  write_drift(html, floors);
  Scope wide(html, "div", {{"class", "wide"}});
  Scope table(html, "table");
  table_head(html, {"Floor", "Brackets measured", "Mean without setting [mm]", "Mean as it is [mm]",
                    "Largest without setting [mm]", "Largest as it is [mm]"});
  Scope body(html, "tbody");
  for (const auto& [floor, h] : floors)
    table_row(html, {floor_word(floor), std::to_string(h.n), signed_mm(h.without / h.n, 1), signed_mm(h.now / h.n, 1),
                     mm(h.worst_without, 1), mm(h.worst_now, 1)});
}

}  // namespace

void write_rounds(Markup& html, const InstallationPlanT& plan, const LoopStateT& state) {
  const std::vector<LoopChange> changes = changes_of(state);
  const std::set<std::string> idle = idle_brackets(plan, state);
  Scope part(html, "section", {{"id", "rounds"}});
  html.element("h2", "The loop so far");
  for (const auto& [kind, heading] : {std::pair{"panel", "Panels"}, {"bracket", "Brackets"}}) {
    const bool brackets = kind == std::string("bracket");
    const auto rounds = states_by_round(state, changes, kind, brackets ? idle : std::set<std::string>());
    html.element("h3", std::string(heading) + " by state after each round");
    draw_rounds(html, rounds, heading);
    write_state_legend(html, rounds);
    if (brackets && !idle.empty())
      html.element("p", {{"class", "note"}},
                   "Not counted: " + std::to_string(idle.size()) +
                       " on which no panel hangs. Nothing is to be set there: " + some_of({idle.begin(), idle.end()}) +
                       ".");
  }
  write_reworks(html, changes);
  write_heights(html, plan, state, idle);
  for (const std::string& words : {ifc::edge_words(plan), ifc::temperature_words(plan)})
    if (!words.empty()) html.element("p", {{"class", "note"}}, words);
}

void write_refused(Markup& html, const LoopStateT& state) {
  if (state.refused.empty()) return;
  constexpr std::size_t kShown = 200;
  Scope part(html, "section", {{"id", "refused"}});
  html.element("h2", "Reports that were not taken");
  html.element("p",
               "They changed nothing. Mend the file and run the round again with the same words: what was done and is "
               "not reported looks like a bracket that somebody moved. Of a round before, measure the item.");
  {
    Scope wide(html, "div", {{"class", "wide"}});
    Scope table(html, "table", {{"class", "sortable"}});
    table_head(html, {"Round", left("Report"), left("What is wrong, and what to do")});
    Scope body(html, "tbody");
    for (std::size_t i = 0; i < std::min(kShown, state.refused.size()); ++i) {
      const RefusedReportT& refused = *state.refused[state.refused.size() - 1 - i];
      table_row(html, {std::to_string(refused.round), left(refused.report), sentence(refused.why)});
    }
  }
  if (state.refused.size() > kShown)
    html.element("p", {{"class", "note"}},
                 std::to_string(state.refused.size() - kShown) + " more, older ones: state.json has all.");
}

void write_items(Markup& html, const InstallationPlanT& plan, const LoopStateT& state) {
  std::map<std::pair<std::string, std::string>, const LoopItemT*> items;
  for (const auto& item : state.items) items[{item->kind, item->id}] = item.get();
  const std::set<std::string> idle = idle_brackets(plan, state);
  Scope part(html, "section", {{"id", "items"}});
  html.element("h2", "Panels and brackets");
  {
    Scope wide(html, "div", {{"class", "wide"}});
    Scope table(html, "table", {{"class", "sortable"}});
    table_head(html,
               {"Panel", "Floor", left("State"), left("Gate"), "p inside", left("Decided by"), "Reworks", left("Why")});
    Scope body(html, "tbody");
    for (const auto& panel : plan.panels) {
      const auto found = items.find({"panel", panel->id});
      if (found == items.end()) continue;
      const LoopItemT& item = *found->second;
      const char* gate = panel->gate == GateDecision::go ? "GO" : panel->gate == GateDecision::no_go ? "NO_GO" : "HOLD";
      table_row(html, {verbatim(panel->id), floor_word(panel->floor), left(state_word(item.status)), left(gate),
                       std::isfinite(panel->p_in) ? fixed(panel->p_in, 3) : std::string(unknown),
                       sentence(panel->decided_by), std::to_string(item.reworks), sentence(item.why)});
    }
  }
  Scope wide(html, "div", {{"class", "wide"}});
  Scope table(html, "table", {{"class", "sortable"}});
  table_head(html, {"Bracket", "Floor", left("State"), "Right [mm]", "Up [mm]", "Out [mm]", "Set right [mm]",
                    "Set up [mm]", "Set out [mm]", "u up [mm]", left("Why")});
  Scope body(html, "tbody");
  for (const auto& bracket : plan.brackets) {
    const auto found = items.find({"bracket", bracket->id});
    if (found == items.end() || bracket->axes.size() != 3) continue;
    const LoopItemT& item = *found->second;
    const Eigen::Vector3d off = bracket->measured - bracket->design;
    table_row(html, {verbatim(bracket->id), floor_word(bracket->floor),
                     left(idle.count(bracket->id) > 0 ? "NOT NEEDED" : state_word(item.status)),
                     signed_mm(bracket->axes[0].dot(off), 1), signed_mm(bracket->axes[1].dot(off), 1),
                     signed_mm(bracket->axes[2].dot(off), 1), signed_mm(item.setting.x(), 1),
                     signed_mm(item.setting.y(), 1), signed_mm(item.setting.z(), 1),
                     mm(std::abs(bracket->axes[1].cwiseAbs().dot(bracket->sigma)), 1), sentence(item.why)});
  }
}

}  // namespace plumbline::report
