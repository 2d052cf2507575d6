#include "show/bench/breakdown.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <optional>

#include "show/bench/pairing.hpp"

namespace plumbline::bench {

namespace {

std::optional<double> number_in(const std::string& text) {
  char* end = nullptr;
  const double value = std::strtod(text.c_str(), &end);
  if (text.empty() || *end != '\0' || !std::isfinite(value)) return std::nullopt;
  return value;
}

/// The values in the order of their numbers; empty if they are no numbers or fewer than three.
std::vector<std::string> in_order(const Variable& variable) {
  std::vector<std::string> values = variable.values;
  for (const std::string& value : values)
    if (!number_in(value)) return {};
  std::sort(values.begin(), values.end(),
            [](const std::string& a, const std::string& b) { return *number_in(a) < *number_in(b); });
  values.erase(std::unique(values.begin(), values.end()), values.end());
  return values.size() < 3 ? std::vector<std::string>{} : values;
}

bool holds(const Cell& cell, double tolerance) {
  const double worst = cell.measure("worst"), error = std::isfinite(worst) ? worst : cell.measure("error");
  return cell.status == "done" && std::abs(error) <= tolerance;  // nan does not
}

/// Of all cells with that value, how many hold.
double share_that_holds(const Bench& bench, const std::string& variable, const std::string& value, double tolerance) {
  std::size_t all = 0, good = 0;
  for (const Cell& cell : bench.cells)
    if (cell.status != "missing" && cell.values.at(variable) == value) ++all, good += holds(cell, tolerance);
  return all ? static_cast<double>(good) / static_cast<double>(all) : 0;
}

std::string place_without(const Cell& cell, const std::string& variable) {
  std::string text = cell.scenario;
  for (const auto& [name, value] : cell.values)
    if (name != variable) text += (text.empty() ? "" : ", ") + name + "=" + value;
  return text;
}

/// The rank of the order statistic that ends the interval of a median: P(B(n, 1/2) < rank) ≤ risk / 2. 0: there is
/// none.
std::size_t rank_of_end(std::size_t n, double risk) {
  double term = std::pow(0.5, static_cast<double>(n)), sum = term;  // P(B = 0)
  std::size_t rank = 0;
  while (rank < n && sum <= risk / 2) {
    ++rank;
    term *= static_cast<double>(n - rank + 1) / static_cast<double>(rank);
    sum += term;
  }
  return rank;
}

/// One alternative in one place: by site the cells in the order of the values.
using Sites = std::map<std::uint64_t, std::vector<const Cell*>>;

void judge_sites(const Sites& sites, double confidence, Breakdown& found) {
  std::vector<std::size_t> ends;
  for (const auto& [seed, cells] : sites) {
    std::size_t end = 0;
    while (end < cells.size() && cells[end] && holds(*cells[end], found.tolerance)) ++end;
    const bool known = end == cells.size() || (cells[end] && cells[end]->status != "missing");
    if (known) ends.push_back(end);
  }
  std::sort(ends.begin(), ends.end());
  found.sites = ends.size();
  found.lower = found.upper = found.values.size() + 1;
  if (ends.empty()) return;
  found.median = ends[(ends.size() - 1) / 2];
  if (const std::size_t rank = rank_of_end(ends.size(), 1 - confidence); rank > 0) {
    found.lower = ends[rank - 1];
    found.upper = ends[ends.size() - rank];
  }
}

void add(const Bench& bench, const std::string& variable, const std::vector<std::string>& values, double tolerance,
         double confidence, std::vector<Breakdown>& all) {
  std::vector<std::pair<std::string, std::string>> order;
  std::map<std::pair<std::string, std::string>, Sites> sites;
  for (const Cell& cell : bench.cells) {
    const std::pair<std::string, std::string> key{place_without(cell, variable), choices_text(cell.choices)};
    if (sites.count(key) == 0) order.push_back(key);
    auto& cells = sites[key][cell.seed];
    cells.resize(values.size(), nullptr);
    const auto value = std::find(values.begin(), values.end(), cell.values.at(variable));
    if (value != values.end()) cells[value - values.begin()] = &cell;
  }
  for (const auto& key : order) {
    Breakdown found{variable, key.first, key.second, tolerance, values, 0, 0, 0, 0};
    judge_sites(sites.at(key), confidence, found);
    if (found.sites > 0) all.push_back(std::move(found));
  }
}

std::string tolerance_text(double metres) { return fmt::format("{:g}", 1e3 * metres); }

std::string values_text(const Breakdown& b, std::size_t count) {
  return count == 0 ? "below " + b.values[0] : b.values[count - 1];
}

}  // namespace

std::vector<Breakdown> breakdowns(const Bench& bench, double confidence) {
  std::vector<Breakdown> all;
  for (const Variable& variable : bench.variables) {
    std::vector<std::string> values = in_order(variable);
    if (values.empty()) continue;
    for (const double tolerance : bench.tolerances) {
      // Of tags, control and images there may be too few, of noise too much.
      std::vector<std::string> ordered = values;
      if (share_that_holds(bench, variable.name, values.back(), tolerance) >
          share_that_holds(bench, variable.name, values.front(), tolerance))
        std::reverse(ordered.begin(), ordered.end());
      add(bench, variable.name, ordered, tolerance, confidence, all);
    }
  }
  return all;
}

std::string breakdown_text(const Breakdown& b) {
  const std::string far = b.median == 0                 ? "not even at " + b.values[0]
                          : b.median == b.values.size() ? "through " + b.values.back()
                                                        : "up to " + b.values[b.median - 1];
  if (!b.has_interval() || b.lower == b.upper) return far;
  return far + " (" + values_text(b, b.lower) + " to " + values_text(b, b.upper) + ")";
}

std::vector<std::string> breakdown_sentences(const std::vector<Breakdown>& found) {
  std::vector<std::string> sentences;
  std::vector<std::pair<std::string, std::string>> told;
  for (const Breakdown& first : found) {
    const std::pair<std::string, std::string> key{first.variable, first.place};
    if (std::find(told.begin(), told.end(), key) != told.end()) continue;
    told.push_back(key);
    std::vector<const Breakdown*> alike;
    for (const Breakdown& b : found)
      if (b.variable == first.variable && b.place == first.place && b.tolerance == first.tolerance) alike.push_back(&b);
    std::stable_sort(alike.begin(), alike.end(),
                     [](const Breakdown* a, const Breakdown* b) { return a->median > b->median; });
    std::string text = "as " + first.variable + " goes from " + first.values.front() + " to " + first.values.back() +
                       (first.place.empty() ? "" : " on " + first.place) + ", half of the sites stay within " +
                       tolerance_text(first.tolerance) + " mm ";
    std::string last;
    for (const Breakdown* b : alike) {
      const std::string far = breakdown_text(*b), name = b->name.empty() ? "" : " with " + b->name;
      const std::string begun = last.empty() ? far : ". " + begin_sentence(far);
      text += far == last ? "," + name.substr(name.empty() ? 0 : 5) : begun + name;
      last = far;
    }
    sentences.push_back(text + ".");
  }
  return sentences;
}

}  // namespace plumbline::bench
