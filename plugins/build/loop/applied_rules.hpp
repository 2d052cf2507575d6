// Rules of brackets and hooks, and which of them the anchors of a facade needed: those that hold nowhere are refused.
#pragma once

#include <set>
#include <stdexcept>
#include <string>
#include <vector>

#include "building/ifc/rule_use.hpp"

namespace plumbline::loop {

/// Rules of brackets or hooks. Of one that holds nowhere nobody could see that another was planned with.
template <typename Rule>
class AppliedRules {
 public:
  explicit AppliedRules(const std::vector<Rule>& rules) : rules_(rules), use_(rules.size()) {}

  void apply(const ifc::ElementFacts& anchor) {
    const std::vector<std::size_t> rules = ifc::selecting(rules_, anchor);
    use_.select(rules, anchor.guid.empty() ? anchor.name : anchor.guid);
    use_.apply(rules, ifc::last_of(rules));
  }

  /// A place of a sill is no bracket: nothing is set there, and a rule for it alone does no harm.
  void let(const ifc::ElementFacts& sill) {
    for (const std::size_t i : ifc::selecting(rules_, sill)) of_sills_.insert(i);
  }

  /// Throws std::runtime_error with all of them.
  void refuse_idle(const std::string& parameter) const {
    const std::vector<std::string> texts = ifc::texts_of(rules_);
    std::string idle;
    const auto refuse = [&](const std::string& text) { idle += (idle.empty() ? "" : "\n") + text; };
    const std::string nothing = "it selects no bracket";
    for (std::size_t i = 0; i < rules_.size(); ++i)
      if (const std::string why = use_.not_applied(i, texts, "anchors", nothing);
          !why.empty() && !(why == nothing && of_sills_.contains(i)))
        refuse("'" + parameter + "': rule '" + texts[i] + "': " + why);
    if (!idle.empty()) throw std::runtime_error(idle);
  }

 private:
  const std::vector<Rule>& rules_;
  ifc::RuleUse use_;
  std::set<std::size_t> of_sills_;
};

}  // namespace plumbline::loop
