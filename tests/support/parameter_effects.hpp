// Whether every declared parameter of a node does something: each is given other values, one at a time, and what the
// node then gives is compared with what it gives by default. A parameter that is read from the wrong member, or not at
// all, changes nothing.
#pragma once

#include <cmath>
#include <functional>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "node_harness.hpp"

namespace plumbline::test {

/// A node with its inputs, ready to run; some of its parameters may be set, where another depends on them.
using Situation = std::function<NodeHarness()>;

namespace detail {

inline std::string number_text(double value, bool whole) {
  std::ostringstream text;
  text.precision(17);
  text << (whole ? std::round(value) : value);
  return text.str();
}

/// Values to try beside `now`: all choices; for numbers a tenth, ten times, the bounds that exist, and about zero.
inline std::vector<std::string> other_values(const plumbline_param& param, const std::string& now) {
  std::vector<std::string> values;
  for (uint32_t i = 0; i < param.choice_count; ++i) values.emplace_back(param.choices[i]);
  if (param.kind == PLUMBLINE_BOOLEAN) values = {"true", "false"};
  if (param.kind == PLUMBLINE_TEXT && param.choice_count == 0) values = {"2026-05", "another"};
  if (param.kind == PLUMBLINE_NUMBER || param.kind == PLUMBLINE_INTEGER) {
    const double n = now.empty() ? 0 : std::stod(now);
    const bool whole = param.kind == PLUMBLINE_INTEGER;
    for (const double v : {0.1 * n, 0.5 * n, 2 * n, 10 * n, n + 1, n - 1, 1e-4, 0.01})
      if (v >= param.minimum && v <= param.maximum) values.push_back(number_text(v, whole));
    if (std::isfinite(param.minimum)) values.push_back(number_text(param.minimum, whole));
    if (!whole && std::isfinite(param.maximum)) values.push_back(number_text(param.maximum, false));
  }
  if (param.is_list) values.emplace_back();
  const std::set<std::string> once(values.begin(), values.end());
  values.assign(once.begin(), once.end());
  std::erase(values, now);
  return values;
}

}  // namespace detail

/// A line for each parameter that changes nothing in any of the situations, whatever its value, or whose refusal is
/// without words. In the first situation the node must succeed with its defaults. `without_effect`: parameters that
/// must change nothing (such as a number of threads), which is tested the same way. Files and folders are left to the
/// kit.
inline std::string parameters_at_fault(const std::vector<Situation>& situations,
                                       const std::set<std::string>& without_effect = {}) {
  std::string faults;
  std::map<std::string, bool> changed;
  for (const Situation& situation : situations) {
    NodeHarness by_default = situation();
    const std::string expected = by_default.outcome();
    if (&situation == &situations.front() && expected.rfind("failed: ", 0) == 0)
      faults += "nothing can be seen of a node that fails by default: " + expected + "\n";
    for (const plumbline_param* param : by_default.declared_parameters()) {
      if (param->kind == PLUMBLINE_FILE || param->kind == PLUMBLINE_FOLDER || changed[param->name]) continue;
      for (const std::string& value : detail::other_values(*param, by_default.parameter(param->name))) {
        NodeHarness other = situation();
        other.set(param->name, value);
        const std::string outcome = other.outcome();
        if (outcome == "failed: (no message)")
          faults += "'" + std::string(param->name) + ": " + value + "' fails without a word" + "\n";
        if (outcome != expected) {
          changed[param->name] = true;
          if (without_effect.count(param->name))
            faults += "'" + std::string(param->name) + ": " + value + "' changes the result, and should not" + "\n";
          break;
        }
      }
    }
  }
  for (const auto& [name, does] : changed)
    if (!does && !without_effect.count(name))
      faults += "'" + name + "' changes nothing in any of " + std::to_string(situations.size()) + " situations" + "\n";
  return faults;
}

}  // namespace plumbline::test
