#include "show/bench/breakdown.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <optional>
#include <tuple>

#include "base/text/words.hpp"
#include "show/bench/pairing.hpp"

namespace plumbline::bench {

namespace {

constexpr std::size_t fewest_values = 3;  // of a variable along which something breaks

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
  return values.size() < fewest_values ? std::vector<std::string>{} : values;
}

/// Whether the bench knows largest errors; a trial without one does not hold then.
bool measures_worst(const Bench& bench) {
  return std::any_of(bench.cells.begin(), bench.cells.end(),
                     [](const Cell& cell) { return std::isfinite(cell.measure("worst")); });
}

bool holds(const Cell& cell, double tolerance, bool worst_is_measured) {
  const double error = cell.measure(worst_is_measured ? "worst" : "error");
  return cell.status == "done" && std::abs(error) <= tolerance;  // nan does not
}

/// Of all cells with that value that have run, how many hold; nothing if none has, or the bench excludes it.
std::optional<double> share_that_holds(const Bench& bench, const std::string& variable, const std::string& value,
                                       double tolerance) {
  std::size_t all = 0, good = 0;
  const bool worst = measures_worst(bench);
  for (const Cell& cell : bench.cells)
    if (cell.has_run() && cell.values.at(variable) == value) ++all, good += holds(cell, tolerance, worst);
  if (all == 0) return std::nullopt;
  return static_cast<double>(good) / static_cast<double>(all);
}

/// Whether more sites hold at the last of the values that have run than at the first.
bool grows(const Bench& bench, const std::string& variable, const std::vector<std::string>& values, double tolerance) {
  std::vector<double> shares;
  for (const std::string& value : values)
    if (const auto share = share_that_holds(bench, variable, value, tolerance)) shares.push_back(*share);
  return !shares.empty() && shares.back() > shares.front();
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

void judge_sites(const Sites& sites, double confidence, bool worst_is_measured, Breakdown& found) {
  // A site whose next value has not run yet breaks there at the earliest and at the end at the latest. Left away, the
  // sites that broke early would be left, because those are known first.
  std::vector<std::size_t> earliest, latest;
  for (const auto& [seed, cells] : sites) {
    const auto has_run = [](const Cell* cell) { return cell && cell->status != "missing"; };
    std::size_t end = 0;
    while (end < cells.size() && cells[end] && holds(*cells[end], found.tolerance, worst_is_measured)) ++end;
    const bool known = end == cells.size() || has_run(cells[end]);
    if (!known && std::none_of(cells.begin(), cells.end(), has_run)) continue;
    found.sites += known, found.open += !known;
    earliest.push_back(end), latest.push_back(known ? end : cells.size());
  }
  std::sort(earliest.begin(), earliest.end());
  std::sort(latest.begin(), latest.end());
  found.lower = found.upper = found.values.size() + 1;
  if (found.sites == 0) return;
  const std::size_t n = earliest.size();
  found.median = earliest[(n - 1) / 2], found.at_most = latest[(n - 1) / 2];
  if (const std::size_t rank = rank_of_end(n, 1 - confidence); rank > 0) {
    found.lower = earliest[rank - 1];
    found.upper = latest[n - rank];
  }
}

/// Values of which the bench has a cell there, run or not.
std::vector<bool> planned_in(const Sites& sites, std::size_t values) {
  std::vector<bool> planned(values, false);
  for (const auto& [seed, cells] : sites)
    for (std::size_t v = 0; v < values; ++v)
      if (cells[v]) planned[v] = true;
  return planned;
}

void leave_away(const std::vector<bool>& planned, Sites& sites) {
  for (auto& [seed, cells] : sites) {
    std::vector<const Cell*> kept;
    for (std::size_t v = 0; v < planned.size(); ++v)
      if (planned[v]) kept.push_back(cells[v]);
    cells = std::move(kept);
  }
}

void add(const Bench& bench, const std::string& variable, const std::vector<std::string>& values, double tolerance,
         double confidence, std::vector<Breakdown>& all) {
  using Key = std::pair<std::string, std::map<std::string, std::string>>;
  std::vector<Key> order;
  std::map<Key, Sites> sites;
  const bool worst = measures_worst(bench);
  for (const Cell& cell : bench.cells) {
    if (!cell.planned) continue;  // nothing of it holds, and nothing of it breaks
    const Key key{place_without(cell, variable), cell.choices};
    if (sites.count(key) == 0) order.push_back(key);
    auto& cells = sites[key][cell.seed];
    cells.resize(values.size(), nullptr);
    const auto value = std::find(values.begin(), values.end(), cell.values.at(variable));
    if (value != values.end()) cells[value - values.begin()] = &cell;
  }
  for (const auto& key : order) {
    Breakdown found;
    found.variable = variable, found.place = key.first, found.name = choices_text(key.second);
    found.tolerance = tolerance, found.by_worst = worst;
    const std::vector<bool> planned = planned_in(sites.at(key), values.size());
    for (std::size_t v = 0; v < values.size(); ++v) (planned[v] ? found.values : found.excluded).push_back(values[v]);
    if (found.values.size() < fewest_values) continue;
    leave_away(planned, sites.at(key));
    judge_sites(sites.at(key), confidence, worst, found);
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
      if (grows(bench, variable.name, values, tolerance)) std::reverse(ordered.begin(), ordered.end());
      add(bench, variable.name, ordered, tolerance, confidence, all);
    }
  }
  return all;
}

std::string breakdown_text(const Breakdown& b) {
  const std::string far =
      b.median < b.at_most ? "at least " + (b.median == 0 ? "below " + b.values[0] : "up to " + b.values[b.median - 1])
      : b.median == 0      ? "not even at " + b.values[0]
      : b.median == b.values.size() ? "through " + b.values.back()
                                    : "up to " + b.values[b.median - 1];
  if (!b.has_interval() || b.lower == b.upper) return far;
  return far + " (" + values_text(b, b.lower) + " to " + values_text(b, b.upper) + ")";
}

namespace {

using Alike = std::vector<const Breakdown*>;  ///< alternatives of one variable, place and tolerance, the best first

Alike alike_of(const std::vector<Breakdown>& found, const Breakdown& first, double tolerance) {
  Alike alike;
  for (const Breakdown& b : found)
    if (b.variable == first.variable && b.place == first.place && b.tolerance == tolerance) alike.push_back(&b);
  // Those of which the same is to be said stand side by side.
  const auto how_far = [](const Breakdown* b) { return std::tuple(b->median, b->at_most, b->upper, b->lower); };
  std::stable_sort(alike.begin(), alike.end(),
                   [&](const Breakdown* a, const Breakdown* b) { return how_far(a) > how_far(b); });
  return alike;
}

/// Whether alternatives differ, or break between the first value and the last.
bool tells(const Alike& alike) {
  if (alike[0]->median > 0 && alike[0]->median < alike[0]->values.size()) return true;
  return std::any_of(alike.begin(), alike.end(), [&](const Breakdown* b) {
    return b->median != alike[0]->median || b->at_most != alike[0]->at_most;
  });
}

/// At the first tolerance at which that is so: where all hold everywhere, or nowhere, nothing can be chosen.
Alike telling(const std::vector<Breakdown>& found, const Breakdown& first) {
  for (const Breakdown& b : found)
    if (b.variable == first.variable && b.place == first.place)
      if (Alike alike = alike_of(found, first, b.tolerance); tells(alike)) return alike;
  return alike_of(found, first, first.tolerance);
}

/// "half of the sites stay within 2 mm up to 0.3 with a, b. Up to 0.1 with c"
std::string ends_text(const Alike& alike) {
  const std::string within = tolerance_text(alike[0]->tolerance) + " mm ";
  const bool none =
      std::all_of(alike.begin(), alike.end(), [](const Breakdown* b) { return b->median == 0 && b->at_most == 0; });
  if (alike.size() > 1 && none)
    return "nobody stays within " + within + "on half of the sites, even at " + alike[0]->values[0];
  std::string text = "half of the sites stay within " + within, last;
  for (const Breakdown* b : alike) {
    const std::string far = breakdown_text(*b), name = b->name.empty() ? "" : " with " + b->name;
    const std::string begun = last.empty() ? far : ". " + begin_sentence(far);
    text += far == last ? "," + name.substr(name.empty() ? 0 : 5) : begun + name;
    last = far;
  }
  return text;
}

std::string told_beside(const Alike& alike) {
  std::string text;
  std::size_t open = 0;
  for (const Breakdown* b : alike) open = std::max(open, b->open);
  if (open > 0)
    text += "; of " + (open == 1 ? "one site" : "up to " + std::to_string(open) + " sites") +
            " the next value has not run yet";
  for (const Breakdown* b : alike)
    if (!b->excluded.empty())
      text += "; " + (b->name.empty() ? "" : "with " + b->name + " ") + "the bench leaves out " +
              text::enumerate(b->excluded);
  if (!alike[0]->by_worst) text += "; by their RMSE, because no largest error is measured";
  return text;
}

/// What is said of places: those of which the same is to be said share a sentence.
struct Said {
  std::string lead, body;
  std::vector<std::string> places;
};

}  // namespace

std::vector<std::string> breakdown_sentences(const std::vector<Breakdown>& found) {
  std::vector<Said> all;
  std::vector<std::pair<std::string, std::string>> told;
  for (const Breakdown& first : found) {
    const std::pair<std::string, std::string> key{first.variable, first.place};
    if (std::find(told.begin(), told.end(), key) != told.end()) continue;
    told.push_back(key);
    const Alike alike = telling(found, first);
    const Breakdown& widest =
        **std::max_element(alike.begin(), alike.end(),
                           [](const Breakdown* a, const Breakdown* b) { return a->values.size() < b->values.size(); });
    const std::string lead =
        "as " + first.variable + " goes from " + widest.values.front() + " to " + widest.values.back();
    const std::string body = ends_text(alike) + told_beside(alike);
    const auto same =
        std::find_if(all.begin(), all.end(), [&](const Said& s) { return s.lead == lead && s.body == body; });
    (same == all.end() ? *all.insert(all.end(), {lead, body, {}}) : *same).places.push_back(first.place);
  }
  std::vector<std::string> sentences;
  for (const Said& s : all)
    sentences.push_back(s.lead + (s.places[0].empty() ? "" : " on " + listed(s.places)) + ", " + s.body + ".");
  return sentences;
}

}  // namespace plumbline::bench
