// What is reported on orders that were recalled: it is no work that anybody asked for any more, and yet tells that the
// robot is through with it.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "artifacts/actuals.hpp"
#include "loop/state/machine.hpp"
#include "loop/state/transitions.hpp"

namespace plumbline::loop {

/// Takes down in the journal, once for each, reports that are refused and end an order that was recalled. Nothing else
/// of the item changes.
class RecalledOrders {
 public:
  explicit RecalledOrders(LoopStateT& state) : state_(state) {}

  /// `because`: by and at of the report, and the hash of its file. Of what was not touched (skipped; a panel that
  /// failed) the line answers at once. That a panel was hung no measurement of plates tells: nothing answers.
  void take(const LoopItemT& item, const ActualT& actual, Because because);

 private:
  bool was_recalled(const LoopItemT& item, int revision);
  bool is_known(const LoopItemT& item, const ActualT& actual, const Because& because);
  void read_journal();

  LoopStateT& state_;
  /// By kind and item: from, to, by, at and hashes of its lines, as they were when the first report was refused.
  struct Line {
    std::string from, to, by, at;
    std::vector<std::string> rests_on;
  };
  std::optional<std::map<std::pair<std::string, std::string>, std::vector<Line>>> lines_;
};

/// Brackets that were reported on an order that was recalled, and that this plan's campaign, which began after that
/// (`options.measured_at`), measured anew: where they are is known, and the journal says so. One that was released
/// again before it was measured is recalled once more: its setting was planned on where it stood before. Without dates
/// nothing is known.
void answer_recalled_orders(LoopStateT& state, const InstallationPlanT& plan, const MachineOptions& options);

}  // namespace plumbline::loop
