// Several reports of one item, from files in any order: which of them count, and in which order.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "artifacts/actuals.hpp"

namespace plumbline::loop {

struct OrderedReport {
  const ActualT* report;
  std::string why_not;  ///< another report of its item counts in its place, or contradicts it; empty: it counts
};

/// "a.json" of "a.json:7" and "a.json items[4]"; empty: not known.
std::string report_file(const ActualT& report, const ActualsT& actuals);

/// Reports of one item in the order of their dates, items in the order in which they came. Compared are those that
/// `may_count`: one that says something else than a later one that says done is not taken; two that contradict each
/// other at one time, or of different files without a date, are both not taken. Without dates the order of a file
/// holds.
std::vector<OrderedReport> in_order_of_time(const ActualsT& actuals,
                                            const std::function<bool(const ActualT&)>& may_count);

}  // namespace plumbline::loop
