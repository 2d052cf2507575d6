// The page of an execution loop: what to do next by floor and robot, where everything stands, how it came so.
#pragma once

#include <map>
#include <set>
#include <string>
#include <vector>

#include "artifacts/installation_plan.hpp"
#include "artifacts/loop_state.hpp"
#include "show/report/markup.hpp"

namespace plumbline::report {

/// A change that the journal tells.
struct LoopChange {
  int round = 0;
  std::string kind, item, from, to, by, at, why;
};

/// The lines of a journal, oldest first; what is no JSON is left out.
std::vector<LoopChange> changes_of(const LoopStateT& state);

/// By round, how many of one kind stand in each state when it ends, without `left_out`; rounds in which nothing changed
/// are those before.
std::vector<std::map<std::string, int>> states_by_round(const LoopStateT& state, const std::vector<LoopChange>& changes,
                                                        const std::string& kind,
                                                        const std::set<std::string>& left_out = {});

/// "VERIFIED".
std::string state_word(ItemStatus status);

/// The chart of that, and what its colours mean.
void draw_rounds(Markup& html, const std::vector<std::map<std::string, int>>& rounds, const std::string& what);
void write_state_legend(Markup& html, const std::vector<std::map<std::string, int>>& rounds);

/// Brackets on which no panel hangs and that nobody was asked to set: they are no work, and wait for nothing.
std::set<std::string> idle_brackets(const InstallationPlanT& plan, const LoopStateT& state);

/// First screen: the next step, then for each floor what is to be set, hung, measured and looked at, and by whom.
/// `robots`: by floor; a floor that has none shows who worked there last.
void write_next(Markup& html, const InstallationPlanT& plan, const LoopStateT& state,
                const std::map<int, std::string>& robots);
/// States over rounds, what was done again and why, heights of anchors with and without what was set.
void write_rounds(Markup& html, const InstallationPlanT& plan, const LoopStateT& state);
/// Reports that changed nothing, the last ones first, with what to do.
void write_refused(Markup& html, const LoopStateT& state);
/// All panels and all brackets.
void write_items(Markup& html, const InstallationPlanT& plan, const LoopStateT& state);

}  // namespace plumbline::report
