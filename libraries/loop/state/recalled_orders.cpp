#include "loop/state/recalled_orders.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "loop/state/bracket_places.hpp"
#include "loop/state/date.hpp"

namespace plumbline::loop {
namespace {

/// Of which release a report tells; 0: it does not say.
int revision_of(const LoopItemT& item, const ActualT& actual) {
  if (actual.revision != 0) return actual.revision;
  const bool has_job = !actual.job.empty() && std::count(item.jobs.begin(), item.jobs.end(), actual.job) > 0;
  return has_job ? item.revision : 0;
}

}  // namespace

void RecalledOrders::read_journal() {
  lines_.emplace();
  for (const std::string& text : state_.journal) {
    const auto line = nlohmann::json::parse(text, nullptr, false);
    if (!line.is_object()) continue;
    (*lines_)[{line.value("kind", ""), line.value("item", "")}].push_back(
        {line.value("from", ""), line.value("to", ""), line.value("by", ""), line.value("at", ""),
         line.value("rests_on", std::vector<std::string>())});
  }
}

bool RecalledOrders::was_recalled(const LoopItemT& item, int revision) {
  const std::vector<Line>& lines = (*lines_)[{item.kind, item.id}];
  if (std::none_of(lines.begin(), lines.end(), [](const Line& line) { return line.to == name_of(ItemStatus::stale); }))
    return false;
  if (revision != item.revision) return revision < item.revision;
  const auto last = std::find_if(lines.rbegin(), lines.rend(), [](const Line& line) { return line.from != line.to; });
  return item.status == ItemStatus::planned && last != lines.rend() && last->from == name_of(ItemStatus::stale);
}

bool RecalledOrders::is_known(const LoopItemT& item, const ActualT& actual, const Because& because) {
  // Files of reports are given again, and grow, from round to round.
  const std::string by = because.by.empty() ? because.told_by : because.by;
  const std::vector<Line>& lines = (*lines_)[{item.kind, item.id}];
  return std::any_of(lines.begin(), lines.end(), [&](const Line& line) {
    return line.by == by && ((!actual.at.empty() && line.at == actual.at) || line.rests_on == because.rests_on);
  });
}

void RecalledOrders::take(const LoopItemT& item, const ActualT& actual, Because because) {
  const int revision = revision_of(item, actual);
  const bool ends = actual.outcome == "done" || actual.outcome == "failed" || actual.outcome == "skipped";
  if (!ends || revision <= 0 || item.revision == 0) return;
  if (!lines_) read_journal();
  if (!was_recalled(item, revision) || is_known(item, actual, because)) return;
  const bool untouched = actual.outcome == "skipped" || (actual.outcome == "failed" && item.kind == "panel");
  because.why = "reported " + actual.outcome + " on an order that was recalled: not taken" +
                (untouched              ? ""
                 : item.kind == "panel" ? "; look whether it hangs"
                                        : "; it is asked for again once it is measured after that");
  note_recalled_order(state_, item, because, revision, untouched ? revision : 0);
  (*lines_)[{item.kind, item.id}].push_back({name_of(item.status), name_of(item.status),
                                             because.by.empty() ? because.told_by : because.by,
                                             because.at.empty() ? because.told_at : because.at, because.rests_on});
}

void answer_recalled_orders(LoopStateT& state, const InstallationPlanT& plan, const MachineOptions& options) {
  const std::optional<double> measured = seconds_of(options.measured_at);
  if (!measured) return;
  std::map<std::string, std::map<int, double>> open;  // by bracket and revision: when it was reported last
  for (const std::string& text : state.journal) {
    if (text.find("_revision\":") == std::string::npos) continue;
    const auto line = nlohmann::json::parse(text, nullptr, false);
    if (!line.is_object() || line.value("kind", "") != "bracket") continue;
    const std::string name = line.value("item", "");
    if (const int answered = line.value("answered_revision", 0); answered > 0) {
      open[name].erase(answered);
    } else if (const int reported = line.value("reported_revision", 0); reported > 0) {
      const std::optional<double> at = seconds_of(line.value("at", ""));
      if (at) open[name][reported] = std::max(open[name][reported], *at);
    }
  }
  for (const auto& bracket : plan.brackets) {
    const auto reports = open.find(bracket->id);
    if (reports == open.end() || !bracket->measured.allFinite()) continue;
    for (const auto& item : state.items) {
      if (item->kind != "bracket" || item->id != bracket->id || !is_measured_anew(*item, *bracket, "")) continue;
      for (const auto& [revision, at] : reports->second) {
        if (at >= *measured) continue;
        const Because because{"measured after what was reported on the order that was recalled",
                              {},
                              {},
                              {plan.basis},
                              ItemReason::other,
                              kProgram,
                              options.at};
        note_recalled_order(state, *item, because, 0, revision);
        // What it is asked for by now was planned before that was done.
        if (item->status != ItemStatus::released) continue;
        move(state, *item, ItemStatus::stale, because), move(state, *item, ItemStatus::planned, because);
        item->pending.setZero();
      }
    }
  }
}

}  // namespace plumbline::loop
