// How many brackets and panels stood in each state after each round.
#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "show/report/format.hpp"
#include "show/report/installation_page.hpp"
#include "show/report/plot.hpp"
#include "show/report/sections.hpp"

namespace plumbline::report {

namespace {

const std::vector<std::pair<ItemStatus, const char*>>& states_in_order() {
  static const std::vector<std::pair<ItemStatus, const char*>> states = {
      {ItemStatus::verified, "VERIFIED"}, {ItemStatus::relocalised, "RELOCALISED"},
      {ItemStatus::executed, "EXECUTED"}, {ItemStatus::executing, "EXECUTING"},
      {ItemStatus::released, "RELEASED"}, {ItemStatus::planned, "PLANNED"},
      {ItemStatus::rework, "REWORK"},     {ItemStatus::stale, "STALE"},
      {ItemStatus::rejected, "REJECTED"}};
  return states;
}

/// Dark to light from done to open, orange for what a person must look at: told apart without colours by their order.
const char* colour_of(const std::string& state) {
  static const std::map<std::string, const char*> colours = {
      {"VERIFIED", "#0072b2"},  {"RELOCALISED", "#4f9fcf"}, {"EXECUTED", "#8fc1e3"},
      {"EXECUTING", "#b7d7ee"}, {"RELEASED", "#009e73"},    {"PLANNED", "#d9d9d9"},
      {"REWORK", "#e69f00"},    {"STALE", "#e69f00"},       {"REJECTED", "#d55e00"}};
  const auto found = colours.find(state);
  return found == colours.end() ? "#999999" : found->second;
}

}  // namespace

std::string state_word(ItemStatus status) {
  for (const auto& [state, word] : states_in_order())
    if (state == status) return word;
  return "?";
}

std::vector<LoopChange> changes_of(const LoopStateT& state) {
  std::vector<LoopChange> changes;
  for (const std::string& text : state.journal) {
    const auto line = nlohmann::json::parse(text, nullptr, false);
    if (!line.is_object()) continue;
    const auto word = [&](const char* key) { return line.value(key, std::string()); };
    changes.push_back({line.value("round", 0), word("kind"), word("item"), word("from"), word("to"), word("by"),
                       word("at"), word("why")});
  }
  return changes;
}

std::vector<std::map<std::string, int>> states_by_round(const LoopStateT& state, const std::vector<LoopChange>& changes,
                                                        const std::string& kind,
                                                        const std::set<std::string>& left_out) {
  std::map<std::string, std::string> now;
  for (const auto& item : state.items)
    if (item->kind == kind && left_out.count(item->id) == 0) now[item->id] = "PLANNED";
  std::vector<std::map<std::string, int>> rounds;
  std::size_t next = 0;
  for (int round = 0; round < std::max(1, state.round); ++round) {
    for (; next < changes.size() && changes[next].round <= round; ++next)
      if (changes[next].kind == kind && left_out.count(changes[next].item) == 0)
        now[changes[next].item] = changes[next].to;
    std::map<std::string, int> counts;
    for (const auto& [id, word] : now) ++counts[word];
    rounds.push_back(std::move(counts));
  }
  return rounds;
}

void draw_rounds(Markup& html, const std::vector<std::map<std::string, int>>& rounds, const std::string& what) {
  const double chart_width = 900, chart_height = 240, left_edge = 60, bottom = 200, top = 16;
  int most = 1;
  for (const auto& counts : rounds) {
    int sum = 0;
    for (const auto& [state, n] : counts) sum += n;
    most = std::max(most, sum);
  }
  Scope svg = drawing(html, chart_width, chart_height, what + " by state after each round");
  const double step = (chart_width - left_edge - 10) / static_cast<double>(rounds.size());
  const Scale y{0, static_cast<double>(most), bottom, top};
  for (const double tick : ticks(0, most, 4)) {
    line(html, left_edge, y(tick), chart_width - 10, y(tick), "grid");
    label(html, left_edge - 8, y(tick) + 4, fixed(tick, 0), "tick", "end");
  }
  for (std::size_t r = 0; r < rounds.size(); ++r) {
    double sum = 0;
    for (const auto& [state, word] : states_in_order()) {
      const auto found = rounds[r].find(word);
      if (found == rounds[r].end()) continue;
      const double x = left_edge + step * static_cast<double>(r) + 0.1 * step;
      html.empty("rect", {{"x", px(x)},
                          {"y", px(y(sum + found->second))},
                          {"width", px(0.8 * step)},
                          {"height", px(y(sum) - y(sum + found->second))},
                          {"fill", colour_of(word)}});
      sum += found->second;
    }
    if (rounds.size() <= 30 || r % 5 == 0)
      label(html, left_edge + step * (static_cast<double>(r) + 0.5), bottom + 18, std::to_string(r + 1), "tick",
            "middle");
  }
  label(html, 0.5 * chart_width, chart_height - 4, "round", "tick", "middle");
}

void write_state_legend(Markup& html, const std::vector<std::map<std::string, int>>& rounds) {
  std::set<std::string> used;
  for (const auto& counts : rounds)
    for (const auto& [state, n] : counts) used.insert(state);
  Scope p(html, "p", {{"class", "note"}});
  for (const auto& [state, word] : states_in_order()) {
    if (!used.count(word)) continue;
    html.element(
        "span",
        {{"style", std::string("display:inline-block;width:0.9em;height:0.9em;margin:0 0.3em 0 0.8em;background:") +
                       colour_of(word)}},
        "");
    html.text(word);
  }
}

}  // namespace plumbline::report
