// Places of reports that are the numbers that were asked for, and no measurement.
#pragma once

#include <map>
#include <string>

#include "artifacts/actuals.hpp"
#include "artifacts/loop_state.hpp"

namespace plumbline::loop {

/// Which reports copy the target of their item. To a tenth of a millimetre or finer a place decides it alone: nothing
/// is set and measured that well. In whole millimetres, along the axes they were written along, what was measured is
/// often the target's own number too; there the report as a whole decides it: its places that are the target's are
/// copies where they are more than half of all places of panels that it has in whole millimetres. Brackets do not
/// count: their places prove nothing, another campaign does.
class CopiedPlaces {
 public:
  CopiedPlaces(const LoopStateT& state, const ActualsT& actuals);
  bool contains(const ActualT& report) const { return words_.contains(&report); }
  /// "is the number that was asked for ...": of one that is contained.
  const std::string& words(const ActualT& report) const { return words_.at(&report); }

 private:
  std::map<const ActualT*, std::string> words_;
};

}  // namespace plumbline::loop
