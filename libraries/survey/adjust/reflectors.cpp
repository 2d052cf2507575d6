// Another reflector than the instrument was set to: one constant that some of the distances share. Which ones nobody
// knows beforehand, so each set that a day in the field can make is a hypothesis of its own: points that were known and
// points that were not (prisms that stay, and one on a pole), a length of the pole, what the file notes of the prism, a
// run of sights of one set-up, and the targets whose distances look alike. Without it a network explains the error by
// whatever bends it alike, a turned circle.
#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <set>

#include "survey/adjust/adjuster.hpp"
#include "survey/model/reading_evidence.hpp"
#include "survey/words/network_words.hpp"

namespace plumbline::survey {

namespace {

constexpr std::size_t kFewest = 3;         // sights of a set, and of the rest
constexpr std::size_t kMostTargets = 300;  // beyond, targets are not sorted one by one: each would be a solve
constexpr std::size_t kMostRuns = 150;     // sights of a set-up: beyond, runs of them are not tried
constexpr std::size_t kMostCuts = 24;      // between targets, at the widest gaps

/// A distance: row of the problem and of the model.
struct Distance {
  int r = 0, row = 0;
};
using Distances = std::vector<Distance>;

/// What the file says of the prism of a distance.
std::string note_of(const Observation& o) {
  for (const std::string& note : o.corrections)
    if (note.find("prism") != std::string::npos) return note;
  return "";
}

using ReflectorSet = std::pair<CommonError, Distances>;

/// `choices`: logarithm of the number of sets that it is the best of.
ReflectorSet reflector(Distances sights, const std::string& set, int set_up, double choices) {
  CommonError e;
  e.kind = CommonError::Kind::reflector, e.set_up = set_up, e.set = set;
  e.penalty = 2 * choices;
  std::sort(sights.begin(), sights.end(), [](const Distance& a, const Distance& b) { return a.r < b.r; });
  for (const Distance& d : sights) e.sights.push_back(d.row);
  std::sort(e.sights.begin(), e.sights.end());
  return {std::move(e), std::move(sights)};
}

class ReflectorSearch {
 public:
  using Test = std::function<std::vector<CommonError>(const std::vector<ReflectorSet>&)>;
  ReflectorSearch(const NetworkModel& model, Test test) : m_(model), known_(known_ids(model)), test_(std::move(test)) {}

  /// Points, heights and notes, each against the rest; set-up -1: all.
  void by_what_is_written(const Distances& sights, int set_up) {
    const std::string of = set_up < 0 ? "" : "of set-up " + m_.survey.set_ups[set_up].id + " ";
    classify(
        sights, set_up, [&](const Distance& d) { return known_.contains(m_.rows[d.row].to); },
        [&](bool yes) { return of + (yes ? "to points that were known" : "to points that were not known"); });
    classify(
        sights, set_up, [&](const Distance& d) { return or_zero(reading(d).target_height); },
        [&](double h) { return of + "to targets with a height of " + fixed_digits(h, 3) + " m noted"; });
    classify(
        sights, set_up, [&](const Distance& d) { return note_of(reading(d)); },
        [&](const std::string& note) {
          return of + (note.empty() ? "without a note of the prism" : "with the note '" + note + "'");
        });
    test_sets();
  }

  /// From one on, up to one, and of the best of these the part that is best.
  void by_runs(Distances list, int set_up) {
    std::sort(list.begin(), list.end(), [&](const Distance& a, const Distance& b) { return first(a) < first(b); });
    const std::size_t n = list.size();
    if (n > kMostRuns) return;  // 4 n sets, each with as many solutions as it has sights
    for (std::size_t k = 1; k < n; ++k) add_run(list, set_up, k, n), add_run(list, set_up, 0, k);
    const std::vector<CommonError> ends = test_sets();
    if (ends.empty()) return;
    const CommonError& best = *std::max_element(
        ends.begin(), ends.end(), [](const auto& a, const auto& b) { return std::abs(a.w) < std::abs(b.w); });
    const bool to_the_last = std::binary_search(best.sights.begin(), best.sights.end(), list.back().row);
    const std::size_t cut = to_the_last ? n - best.sights.size() : best.sights.size();
    for (std::size_t k = 1; k < n; ++k)
      if (to_the_last)
        add_run(list, set_up, cut, k);
      else
        add_run(list, set_up, k, cut);
    test_sets();
  }

  /// By what each target would say alone, cut where the gaps are widest.
  void by_targets(const Distances& all) {
    std::map<std::string, Distances> of_target;
    for (const Distance& d : all) of_target[m_.rows[d.row].to].push_back(d);
    if (of_target.size() < 2 * kFewest || of_target.size() > kMostTargets) return;
    std::vector<ReflectorSet> single;
    for (const auto& [id, sights] : of_target) single.push_back(reflector(sights, id, -1, 0));
    const std::vector<CommonError> alone = test_(single);
    std::vector<std::size_t> order;
    for (std::size_t t = 0; t < alone.size(); ++t)
      if (alone[t].sigma > 0) order.push_back(t);
    std::stable_sort(order.begin(), order.end(), [&](auto a, auto b) { return alone[a].size < alone[b].size; });
    std::vector<std::size_t> cuts;
    for (std::size_t k = kFewest; k + kFewest <= order.size(); ++k) cuts.push_back(k);
    const auto gap = [&](std::size_t k) { return alone[order[k]].size - alone[order[k - 1]].size; };
    std::stable_sort(cuts.begin(), cuts.end(), [&](auto a, auto b) { return gap(a) > gap(b); });
    if (cuts.size() > kMostCuts) cuts.resize(kMostCuts);
    const auto add = [&](std::size_t begin, std::size_t end) {
      Distances sights;
      std::vector<std::string> names;
      for (std::size_t i = begin; i < end; ++i) {
        const ReflectorSet& own = single[order[i]];
        sights.insert(sights.end(), own.second.begin(), own.second.end());
        names.push_back(own.first.set);
      }
      std::sort(names.begin(), names.end());
      sets_.push_back(reflector(std::move(sights), "to the points " + join(names, 8), -1,
                                log_choices(static_cast<int>(order.size()), static_cast<int>(end - begin))));
    };
    for (const std::size_t k : cuts) add(0, k), add(k, order.size());
    test_sets();
  }

  std::vector<CommonError> result() { return std::move(tested_); }

 private:
  const Observation& reading(const Distance& d) const { return m_.observations[d.row].observation; }
  int first(const Distance& d) const { return m_.observations[d.row].members.front(); }
  std::string name(const Distance& d) const {
    const ResultRow& row = m_.rows[d.row];
    return row.to + (row.source.line > 0 ? " (" + place(row.source) + ")" : "");
  }

  std::vector<CommonError> test_sets() {
    std::vector<CommonError> now = test_(sets_);
    sets_.clear();
    tested_.insert(tested_.end(), now.begin(), now.end());
    return now;
  }

  template <class Key, class Words>
  void classify(const Distances& all, int set_up, Key key, Words words) {
    constexpr std::size_t kMostClasses = 8;
    std::map<decltype(key(Distance{})), Distances> classes;
    for (const Distance& d : all) classes[key(d)].push_back(d);
    if (classes.size() < 2 || classes.size() > kMostClasses) return;
    for (auto& [value, sights] : classes)
      if (sights.size() >= kFewest) sets_.push_back(reflector(std::move(sights), words(value), set_up, 0));
  }

  void add_run(const Distances& list, int set_up, std::size_t begin, std::size_t end) {
    const std::size_t n = list.size();
    if (end < begin + kFewest || n < end - begin + kFewest) return;
    sets_.push_back(reflector(
        {list.begin() + static_cast<long>(begin), list.begin() + static_cast<long>(end)},
        "of set-up " + m_.survey.set_ups[set_up].id + " from " + name(list[begin]) + " to " + name(list[end - 1]),
        set_up, std::log(2.0 * static_cast<double>(n))));
  }

  const NetworkModel& m_;
  std::set<std::string> known_;
  Test test_;
  std::vector<ReflectorSet> sets_;
  std::vector<CommonError> tested_;
};

}  // namespace

std::vector<CommonError> Adjuster::reflectors(const Pass& pass) const {
  if (clean(pass)) return {};
  std::map<int, Distances> of_set_up;
  Distances all;
  std::set<int> failing;
  for (int r = 0; r < static_cast<int>(pass.problem.rows.size()); ++r) {
    const int row = pass.problem.rows[r];
    if (row < 0 || static_cast<std::size_t>(row) >= m_.observations.size() || !m_.rows[row].removable) continue;
    const int own = set_up_of_row_[row];
    if (own < 0) continue;
    if (std::abs(pass.reliability.rows[r].w) > critical_w()) failing.insert(own);
    if (group_of(m_.observations[row].observation.kind) != kDistances) continue;
    all.push_back({r, row});
    of_set_up[own].push_back({r, row});
  }
  ReflectorSearch search(m_, [&](const std::vector<ReflectorSet>& sets) {
    std::vector<Hypothesis> hypotheses;
    for (const auto& [error, sights] : sets) {
      hypotheses.push_back({error, {}});
      for (const Distance& d : sights) hypotheses.back().rows.emplace_back(d.r, 1.0);
    }
    return test(pass, hypotheses);
  });
  search.by_what_is_written(all, -1);
  for (const auto& [set_up, sights] : of_set_up) {
    if (of_set_up.size() > 1) search.by_what_is_written(sights, set_up);
    if (failing.contains(set_up)) search.by_runs(sights, set_up);
  }
  search.by_targets(all);
  // Where the readings are noisier than stated, so is what the best of many explains by chance.
  const int degrees = pass.solution.degrees_of_freedom();
  std::vector<CommonError> result = search.result();
  const auto classes = std::count_if(result.begin(), result.end(), [](const CommonError& e) { return e.penalty == 0; });
  for (CommonError& e : result)
    if (e.penalty == 0) e.penalty = 2 * std::log(static_cast<double>(classes));  // the best of all that is written
  for (CommonError& e : result)
    e.penalty *= std::max(1.0, (pass.solution.sum_of_squares() - e.w * e.w) / std::max(1, degrees - 1));
  return result;
}

}  // namespace plumbline::survey
