#include "build/evaluate/rule_account.hpp"

#include <algorithm>

#include "build/evaluate/unused_row.hpp"
#include "building/judgement/figures.hpp"

namespace plumbline::judgement {

RuleAccount::RuleAccount(const ToleranceTable& tolerances, const Mounting& mounting, const HeldBelow& held_below)
    : tolerances_(tolerances),
      mounting_(mounting),
      held_below_(held_below),
      rules_(tolerances.rules.size()),
      mounting_rules_(mounting.rules.size()),
      held_rules_(held_below.rules.size()),
      sill_rules_(held_below.sills.size()) {}

void RuleAccount::count_anchor(const ifc::ElementFacts& anchor, const ToleranceFindings& findings,
                               const std::string& guid) {
  for (std::size_t i = 0; i < sill_rules_.size(); ++i) sill_rules_[i] += held_below_.sills[i].matches(anchor);
  for (const std::size_t rule : findings.rules) ++rules_[rule].first;
  note(findings, guid);
  const std::vector<std::size_t> mounted_by = ifc::selecting(mounting_.rules, anchor);
  mounting_rules_.select(mounted_by, guid);
  mounting_rules_.apply(mounted_by, mounting_.that_hold(mounted_by));
}

void RuleAccount::see_panel(const ifc::ElementFacts& panel, const std::string& guid) {
  held_by_.push_back(ifc::selecting(held_below_.rules, panel));
  held_rules_.select(held_by_.back(), guid);
}

void RuleAccount::count_panel(std::size_t seen, const ToleranceFindings& findings, const std::string& guid) {
  for (const std::size_t rule : findings.rules) ++rules_[rule].second;
  held_rules_.apply(held_by_[seen], ifc::last_of(held_by_[seen]));
  note(findings, guid);
}

void RuleAccount::note(const ToleranceFindings& findings, const std::string& guid) {
  in_force_.insert(findings.in_force.begin(), findings.in_force.end());
  wider_.insert(findings.wider.begin(), findings.wider.end());
  widened_.insert(findings.widened.begin(), findings.widened.end());
  for (const std::size_t rule : findings.rules) selected_[rule].insert(guid);
  for (const auto& [rule, later] : findings.replaced) replaced_[rule].insert(later);
}

/// Why a rule that selects something is not judged: a later, wider one stands in its place. Empty: it decides, or
/// nothing that it asks for is lost.
std::string RuleAccount::why_idle(std::size_t rule) const {
  const auto later = widened_.find(rule);
  if (in_force_.contains(rule) || later == widened_.end()) return {};
  // A rule of the run stands in the place of the project's row because somebody wants it so; that is told.
  if (tolerances_.rules[rule].of_table && !tolerances_.rules[later->second].of_table) return {};
  return "it holds nowhere: '" + tolerances_.rules[later->second].text +
         "' stands after it and is wider; put the narrower rule last, or take it out";
}

/// A rule that decides nothing because a later one, at least as narrow, is about what it is about and more.
void RuleAccount::warn_of_idle(std::size_t rule, DeviationInputs& inputs) const {
  if (const auto wider = widened_.find(rule); wider != widened_.end() && !in_force_.contains(rule)) {
    inputs.warnings.push_back("The row '" + tolerances_.rules[rule].text + "' holds nowhere in this run: its rule '" +
                              tolerances_.rules[wider->second].text + "' stands in its place and is wider.");
    return;
  }
  const auto replaced = replaced_.find(rule);
  if (in_force_.contains(rule) || replaced == replaced_.end()) return;
  const std::set<std::string>& own = selected_.at(rule);
  for (const std::size_t later : replaced->second) {
    const std::set<std::string>& others = selected_.at(later);
    if (std::includes(own.begin(), own.end(), others.begin(), others.end())) continue;
    inputs.warnings.push_back("The rule '" + tolerances_.rules[rule].text + "' holds nowhere: '" +
                              tolerances_.rules[later].text +
                              "' stands after it, is no wider, and selects what it selects and more; put the rule "
                              "for fewer last, or take it out.");
    return;
  }
}

/// Empty: it is judged, or the row of a table is for what this building does not have.
std::string RuleAccount::not_judged(std::size_t i, const Request& request, const DesignT& design) const {
  const ToleranceRule& rule = tolerances_.rules[i];
  if (request.anchors + request.panels == 0) {
    const std::string why = rule.of_table ? why_unused(rule, design) : std::string();
    if (rule.of_table && why.empty()) return why;
    return "it selects no anchor and no panel" + (why.empty() ? "" : ": " + why);
  }
  for (const auto& [axis, tolerance] : rule.tolerances) {
    if ((request.anchors > 0 && judged_of_anchors(axis)) || (request.panels > 0 && judged_of_panels(axis))) continue;
    // A building without panels has no joints that the project's table could be about.
    if (rule.of_table && judged_of_panels(axis) && held_by_.empty()) continue;
    return std::string(name_of(axis)) + " is not judged of " + (request.panels > 0 ? "panels" : "anchors") +
           ", and it selects nothing else";
  }
  return why_idle(i);
}

Request RuleAccount::request_of(std::size_t i, const DesignT& design) const {
  Request request{tolerances_.rules[i].text, "rule", rules_[i].first, rules_[i].second, ""};
  request.not_judged = not_judged(i, request, design);
  return request;
}

void RuleAccount::warn_of_unused(const std::vector<std::size_t>& rows, DeviationInputs& inputs) const {
  constexpr std::size_t kNamed = 8;
  std::vector<std::string> names;
  for (const std::size_t row : rows) names.push_back("'" + tolerances_.rules[row].text + "'");
  if (!names.empty())
    inputs.warnings.push_back(
        "The project's table has rows that nothing in this building is of: " + list_of(names, kNamed) + ".");
}

void RuleAccount::add_requests(const DesignT& design, DeviationInputs& inputs) const {
  std::vector<std::size_t> unused;
  for (std::size_t i = 0; i < tolerances_.rules.size(); ++i) {
    Request request = request_of(i, design);
    if (request.not_judged.empty()) warn_of_idle(i, inputs);
    if (request.not_judged.empty() && request.anchors + request.panels == 0) unused.push_back(i);
    inputs.requests.push_back(std::move(request));
  }
  warn_of_unused(unused, inputs);
  const std::vector<std::string> mounting = ifc::texts_of(mounting_.rules), held = ifc::texts_of(held_below_.rules);
  for (std::size_t i = 0; i < mounting.size(); ++i)
    inputs.requests.push_back(
        {mounting[i], "mounting", mounting_rules_.holds(i), 0,
         mounting_rules_.not_applied(i, mounting, "anchors", "it selects no anchor of the plate table")});
  for (std::size_t i = 0; i < held.size(); ++i)
    inputs.requests.push_back({held[i], "held_below", 0, held_rules_.holds(i),
                               held_rules_.not_applied(i, held, "panels", "it selects no panel")});
  for (std::size_t i = 0; i < sill_rules_.size(); ++i)
    inputs.requests.push_back(
        {held_below_.sills[i].text(), "sills", sill_rules_[i], 0, sill_rules_[i] > 0 ? "" : "it selects no anchor"});
}

void RuleAccount::warn_of_wider(DeviationInputs& inputs) const {
  for (const std::string& property : wider_)
    inputs.warnings.push_back(property +
                              " is wider than what holds without it, and is not the own one of what it is asked of: "
                              "the narrower limit holds; a rule says where the wider one is meant.");
}

}  // namespace plumbline::judgement
