#include "build/loop/state_nodes.hpp"

#include "loop/job/job.hpp"
#include "loop/state/date.hpp"
#include "loop/state/measured_in_part.hpp"
#include "loop/state/next_words.hpp"
#include "loop/state/plan_artifact.hpp"
#include "loop/state/setting_scatter.hpp"
#include "loop/state/state_file.hpp"

namespace plumbline::loop {

namespace {

void check_date(const char* name, const std::string& date) {
  if (!date.empty() && !seconds_of(date))
    throw std::runtime_error(std::string(name) + " is '" + date +
                             "'; expected ISO 8601 with a zone, such as 2026-05-02T08:00:00Z");
}

}  // namespace

void UpdateState::run(Context& context) {
  LoopStateT state;
  if (before) state = before.unpack();
  check_date("now", *now);
  if (const std::string doubt = time_doubt(state, *now); !doubt.empty()) throw std::runtime_error(doubt);
  std::size_t taken = 0, refused = 0;
  if (reports) {
    const ActualsT actuals = reports.unpack();
    std::vector<std::string> doubted;
    const auto objections = apply_actuals(state, actuals, &doubted, *now);
    for (const std::string& line : actuals.refused) context.warn(line);
    for (const std::string& objection : objections) context.warn(objection);
    for (const std::string& doubt : doubted) context.warn(doubt);
    note_refused(state, actuals.refused), note_refused(state, objections);
    taken += actuals.items.size() - objections.size(), refused += actuals.refused.size() + objections.size();
  }
  const Teller teller{*by, *now};
  if (!moved_control->empty())
    recall(state, *moved_control, "control point " + moved_control->front() + " moved", teller);
  for (const std::string& id : *accept)
    if (const std::string objection = accept_look(state, id, teller); !objection.empty())
      // It may be left from a round before: no error.
      context.warn("'accept': " + objection + ": nothing is accepted");
  for (const std::string& id : *removed)
    if (const std::string objection = remove_look(state, id, teller); !objection.empty())
      context.warn("'removed': " + objection + ": nothing changes");
  const bool is_told = !moved_control->empty() || !accept->empty() || !removed->empty();
  if (is_told && by->empty() && !now->empty())
    context.warn("who looked is not said: the journal has 'a person'; reported.with.by=NAME says it");
  context.metric("reports_taken", static_cast<double>(taken), "1");
  context.metric("reports_refused", static_cast<double>(refused), "1");
  after.commit(state);
}

void ReleaseState::run(Context& context) {
  LoopStateT state = before.unpack();
  MachineOptions options;
  options.most_reworks = static_cast<int>(*most_reworks);
  options.setting_tolerance = *setting_tolerance, options.verified = *verified;
  options.at = *released_at;
  check_date("released_at", options.at);
  options.measured_at = *measured_at;
  check_date("measured_at", options.measured_at);
  check_date("valid_until", *valid_until);
  // Before anything is released that nobody may take.
  if (!valid_until->empty() && !options.at.empty() && *seconds_of(*valid_until) <= *seconds_of(options.at))
    throw std::runtime_error("the job would be valid until " + *valid_until + ", and it is released at " + options.at +
                             ": every robot would refuse it; nothing is released");
  const InstallationPlanT planned = plan.unpack();
  const SettingScatter scatter = setting_scatter(state, planned, options.measured_at);
  for (const std::string& words : scatter_words(scatter, planned)) context.warn(words);
  apply_plan(state, planned, options);
  note_jobs(planned, state);
  close_round(state);
  const std::vector<std::string> in_part = measured_in_part(planned, state);
  for (const std::string& panel : in_part)
    context.warn("Measured in part: " + panel + ": measure what is missing; nothing is decided of that panel.");
  if (!in_part.empty()) context.metric("invalid", 1, "1");  // exit code 3 (framework/cli/run.cpp)
  for (const std::string& control : state.moved_control)
    context.warn(control +
                 " moved: nothing there is verified or released; look at it, measure again, and if it is in "
                 "order give accept=['" +
                 look_word(state, control) + "'] to update.state");
  // The loop ends here: whoever started it reads this first.
  if (state.done) context.warn("next: " + next_step(state) + " (next.txt)");
  int panels = 0, hanging = 0, released = 0, reworks = 0;
  for (const auto& item : state.items) {
    if (item->gone) continue;
    panels += item->kind == "panel", hanging += item->kind == "panel" && item->status == ItemStatus::verified;
    released += item->status == ItemStatus::released, reworks += item->reworks;
  }
  context.metric("done", state.done, "1");
  context.metric("panels", panels, "1");
  context.metric("panels_verified", hanging, "1");
  context.metric("released", released, "1");
  context.metric("given_up", state.given_up, "1");
  context.metric("reworks", reworks, "1");
  if (scatter.brackets > 0) {
    context.metric("brackets_set", scatter.brackets, "1");
    context.metric("setting_scatter", scatter.setting(), "m");
    if (!scatter.stations.empty()) context.metric("station_scatter", scatter.station(), "m");
  }
  std::string lines;
  for (const std::string& line : state.journal) lines += line + "\n";
  journal.commit(text_file("journal.jsonl", "application/jsonl", lines));
  file.commit(text_file("state.json", "application/json", state_json(state)));
  next.commit(text_file("next.txt", "text/plain", next_words(state)));
  after.commit(state);
}

}  // namespace plumbline::loop
