// Rules over elements of which later ones go before earlier ones: which of them hold somewhere, and which were replaced
// everywhere by a wider one, which nobody means who wrote the narrower one.
#pragma once

#include <algorithm>
#include <set>
#include <string>
#include <vector>

namespace plumbline::ifc {

class RuleUse {
 public:
  explicit RuleUse(std::size_t rules = 0) : rules_(rules) {}

  void select(const std::vector<std::size_t>& rules, const std::string& element) {
    for (const std::size_t rule : rules) rules_[rule].selects.insert(element);
  }

  /// Of one element: the rules that select it, in their order, and those of them of which something holds there.
  void apply(const std::vector<std::size_t>& rules, const std::set<std::size_t>& hold) {
    for (const std::size_t rule : rules) {
      ++rules_[rule].counted;
      rules_[rule].holds += hold.contains(rule);
      for (const std::size_t later : hold)
        if (later > rule) rules_[rule].replaced_by.insert(later);
    }
  }

  int counted(std::size_t rule) const { return rules_[rule].counted; }
  int holds(std::size_t rule) const { return rules_[rule].holds; }

  /// Why a rule is not applied: it selects nothing, or holds nowhere because of a later one that selects what it does
  /// and more. Empty: it is applied. `texts` are those of all rules, `elements` what they select: "anchors".
  std::string not_applied(std::size_t rule, const std::vector<std::string>& texts, const std::string& elements,
                          const std::string& selects_nothing) const {
    const Use& use = rules_[rule];
    if (use.counted == 0) return selects_nothing;
    if (use.holds > 0) return {};
    for (const std::size_t later : use.replaced_by)
      if (std::any_of(rules_[later].selects.begin(), rules_[later].selects.end(),
                      [&](const std::string& element) { return !use.selects.contains(element); }))
        return "it holds nowhere: '" + texts[later] + "' stands after it and selects its " + elements +
               " and others; put the narrower rule last, or take it out";
    return {};
  }

 private:
  struct Use {
    std::set<std::string> selects;
    int counted = 0, holds = 0;
    std::set<std::size_t> replaced_by;
  };
  std::vector<Use> rules_;
};

/// Indices of those of `rules` that select an element, in their order.
template <typename Rule, typename Facts>
std::vector<std::size_t> selecting(const std::vector<Rule>& rules, const Facts& facts) {
  std::vector<std::size_t> found;
  for (std::size_t i = 0; i < rules.size(); ++i)
    if (rules[i].selection.matches(facts)) found.push_back(i);
  return found;
}

/// Of rules that replace each other as a whole: the last one holds.
inline std::set<std::size_t> last_of(const std::vector<std::size_t>& rules) {
  return rules.empty() ? std::set<std::size_t>() : std::set<std::size_t>{rules.back()};
}

/// As they were written.
template <typename Rule>
std::vector<std::string> texts_of(const std::vector<Rule>& rules) {
  std::vector<std::string> texts;
  for (const Rule& rule : rules) texts.push_back(rule.text);
  return texts;
}

}  // namespace plumbline::ifc
