#include "loop/state_nodes.hpp"

#include <map>

#include "loop/state/plan_artifact.hpp"

namespace plumbline::loop {

void UpdateState::run(Context& context) {
  LoopStateT state;
  if (before) state = before.unpack();
  std::size_t taken = 0, refused = 0;
  if (reports) {
    const ActualsT actuals = reports.unpack();
    const auto objections = apply_actuals(state, actuals);
    for (const std::string& line : actuals.refused) context.warn(line);
    for (const std::string& objection : objections) context.warn(objection);
    taken += actuals.items.size() - objections.size(), refused += actuals.refused.size() + objections.size();
  }
  if (!moved_control->empty()) recall(state, *moved_control, "control point " + moved_control->front() + " moved");
  for (const std::string& id : *accept)
    if (!accept_item(state, id))
      throw std::runtime_error("'accept' names '" + id + "', which is no rejected bracket or panel of the state");
  context.metric("reports_taken", static_cast<double>(taken), "1");
  context.metric("reports_refused", static_cast<double>(refused), "1");
  after.commit(state);
}

namespace {

/// "floor 2: set F02-C01-R1, ...; hang F02-P01; waiting: ...".
std::string next_words(const LoopStateT& state) {
  std::map<int, std::map<std::string, std::vector<std::string>>> floors;
  int counts[9] = {};
  for (const auto& item : state.items) {
    ++counts[static_cast<int>(item->status)];
    auto& floor = floors[item->floor];
    if (item->status == ItemStatus::released) floor[item->kind == "bracket" ? "1 set" : "2 hang"].push_back(item->id);
    if (item->status == ItemStatus::executed || item->status == ItemStatus::relocalised)
      floor["3 measure"].push_back(item->id);
    if (item->status == ItemStatus::rejected) floor["4 look at"].push_back(item->id + " (" + item->why + ")");
  }
  std::string text = "round " + std::to_string(state.round) + ", revision " + std::to_string(state.revision) + ":";
  for (int status = 0; status < 9; ++status)
    if (counts[status] > 0)
      text += " " + std::to_string(counts[status]) + " " + name_of(static_cast<ItemStatus>(status));
  text += "\n";
  for (const std::string& control : state.moved_control) text += "check the control: " + control + " moved\n";
  for (const auto& [floor, lists] : floors)
    for (const auto& [what, ids] : lists) {
      text += "floor " + std::to_string(floor) + ": " + what.substr(2);
      for (std::size_t i = 0; i < ids.size(); ++i) text += (i == 0 ? " " : ", ") + ids[i];
      text += "\n";
    }
  if (state.done) text += "nothing is left that could be done without a person\n";
  return text;
}

}  // namespace

void ReleaseState::run(Context& context) {
  LoopStateT state = before.unpack();
  MachineOptions options;
  options.most_reworks = static_cast<int>(*most_reworks);
  options.setting_tolerance = *setting_tolerance, options.verified = *verified;
  const std::size_t control = state.moved_control.size();
  apply_plan(state, plan.unpack(), options);
  close_round(state);
  for (std::size_t i = control; i < state.moved_control.size(); ++i)
    context.warn(state.moved_control[i] + " moved since the last measurement: nothing there is verified or released");
  int panels = 0, hanging = 0, released = 0, reworks = 0;
  for (const auto& item : state.items) {
    panels += item->kind == "panel", hanging += item->kind == "panel" && item->status == ItemStatus::verified;
    released += item->status == ItemStatus::released, reworks += item->reworks;
  }
  context.metric("done", state.done, "1");
  context.metric("panels", panels, "1");
  context.metric("panels_verified", hanging, "1");
  context.metric("released", released, "1");
  context.metric("given_up", state.given_up, "1");
  context.metric("reworks", reworks, "1");
  std::string lines;
  for (const std::string& line : state.journal) lines += line + "\n";
  journal.commit(text_file("journal.jsonl", "application/jsonl", lines));
  next.commit(text_file("next.txt", "text/plain", next_words(state)));
  after.commit(state);
}

}  // namespace plumbline::loop
