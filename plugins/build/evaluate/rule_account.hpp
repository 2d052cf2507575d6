// Which rules of a site selected what and held where, and what is said of those that did not.
#pragma once

#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "artifacts/design.hpp"
#include "building/ifc/rule_use.hpp"
#include "building/judgement/deviation.hpp"
#include "building/judgement/mounting.hpp"

namespace plumbline::judgement {

/// Refers to the rules of tolerances, of where plates sit and of what holds bottom edges.
class RuleAccount {
 public:
  RuleAccount(const ToleranceTable& tolerances, const Mounting& mounting, const HeldBelow& held_below);

  /// An anchor with what its tolerances were found by.
  void count_anchor(const ifc::ElementFacts& anchor, const ToleranceFindings& findings, const std::string& guid);

  /// The next panel of the design, whether anchors hold it or not.
  void see_panel(const ifc::ElementFacts& panel, const std::string& guid);

  /// The panel that was seen as number `seen`, which anchors hold.
  void count_panel(std::size_t seen, const ToleranceFindings& findings, const std::string& guid);

  /// Every rule with what it is about; one that selects nothing, or asks for an axis that what it selects does not
  /// have, is not judged; nor is one that a later, wider one replaces wherever it would hold. One that decides nothing
  /// because a later one decides is a warning. So are rows of the project's table that this building has nothing of
  /// (unused_row.hpp), or that a rule of the run replaces.
  void add_requests(const DesignT& design, DeviationInputs& inputs) const;

  /// Properties of the design that are wider than what holds without them are warnings.
  void warn_of_wider(DeviationInputs& inputs) const;

 private:
  void note(const ToleranceFindings& findings, const std::string& guid);
  std::string why_idle(std::size_t rule) const;
  void warn_of_idle(std::size_t rule, DeviationInputs& inputs) const;
  Request request_of(std::size_t rule, const DesignT& design) const;
  std::string not_judged(std::size_t rule, const Request& request, const DesignT& design) const;
  void warn_of_unused(const std::vector<std::size_t>& rows, DeviationInputs& inputs) const;

  const ToleranceTable& tolerances_;
  const Mounting& mounting_;
  const HeldBelow& held_below_;
  std::vector<std::pair<int, int>> rules_;                 // anchors and panels that each rule selects
  std::set<std::size_t> in_force_;                         // rules that hold somewhere
  std::set<std::string> wider_;                            // properties of the design that only tell (findings.wider)
  std::map<std::size_t, std::size_t> widened_;             // rules that a later, wider one replaces somewhere
  std::map<std::size_t, std::set<std::string>> selected_;  // by rule: GlobalIds of anchors and panels
  std::map<std::size_t, std::set<std::size_t>> replaced_;  // by rule: later ones that stand in its place somewhere
  ifc::RuleUse mounting_rules_, held_rules_;
  std::vector<int> sill_rules_;                    // anchors that each selects
  std::vector<std::vector<std::size_t>> held_by_;  // by panel, rules that select it
};

}  // namespace plumbline::judgement
