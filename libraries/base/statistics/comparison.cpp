#include "base/statistics/comparison.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "base/statistics/not_a_number.hpp"
#include "geometry/median.hpp"
#include "geometry/random.hpp"

namespace plumbline::statistics {

namespace {

bool finished_by_both(const Encounter& e) { return std::isfinite(e.first) && std::isfinite(e.second); }

/// Trials with seeds counted from 0, so that weights by seed reach them.
class Trials {
 public:
  struct TrialOfSeed {
    std::size_t seed = 0;
    double first = 0, second = 0, only_first = 0, only_second = 0;
  };
  struct Group {
    double weight = 1;
    std::vector<TrialOfSeed> trials;
  };

  /// All trials, or only those that both finished in places that have enough of them.
  Trials(const std::vector<Place>& places, bool pairs_only) {
    std::map<std::uint64_t, std::size_t> index;
    std::map<std::string, double> sharing;
    for (const Place& place : places)
      if (counts(place, pairs_only)) ++sharing[place.stratum];
    for (const Place& place : places) {
      if (!counts(place, pairs_only)) continue;
      Group group{place.stratum.empty() ? place.weight : place.weight / sharing.at(place.stratum), {}};
      for (const Encounter& e : place.encounters)
        if (!pairs_only || finished_by_both(e))
          group.trials.push_back(
              {index.emplace(e.seed, index.size()).first->second, e.first, e.second, e.only_first, e.only_second});
      groups_.push_back(std::move(group));
    }
    double heaviest = 0;  // powers of weights are summed
    for (const Group& group : groups_) heaviest = std::max(heaviest, group.weight);
    for (Group& group : groups_) group.weight /= heaviest;
    seeds_ = index.size();
  }

  static bool counts(const Place& place, bool pairs_only) {
    return pairs_only ? pairs_of(place) >= least_seeds : !place.encounters.empty();
  }

  static std::size_t pairs_of(const Place& place) {
    return static_cast<std::size_t>(std::count_if(place.encounters.begin(), place.encounters.end(), finished_by_both));
  }

  std::size_t seeds() const { return seeds_; }
  const std::vector<Group>& groups() const { return groups_; }

  /// Weighted mean over the places of what `place` gives of one.
  template <typename OfPlace>
  double mean(const OfPlace& place) const {
    double sum = 0, total = 0;
    for (const Group& group : groups_) sum += group.weight * place(group), total += group.weight;
    return sum / total;
  }

  bool all_agree() const {
    for (const Group& group : groups_)
      for (const TrialOfSeed& t : group.trials)
        if (std::abs(t.first - t.second) > 2e-9 * std::max(t.first, t.second)) return false;
    return true;
  }

  /// Degrees of freedom of the standard deviation of a mean in which seeds do not weigh alike, because places have
  /// different ones (Satterthwaite 1946): n - 1 if all have the same.
  double freedom() const {
    std::vector<double> share(seeds_, 0.0);
    for (const Group& group : groups_)
      for (const TrialOfSeed& t : group.trials)
        share[t.seed] += group.weight / static_cast<double>(group.trials.size());
    double squares = 0, fourths = 0;
    for (const double s : share) squares += s * s, fourths += s * s * s * s;
    return squares * squares / fourths - 1;
  }

 private:
  std::size_t seeds_ = 0;
  std::vector<Group> groups_;
};

using Group = Trials::Group;
using TrialOfSeed = Trials::TrialOfSeed;

/// First minus second; `weights` of the seeds.
double rmse_difference(const Group& group, const Weights& weights) {
  double first = 0, second = 0, total = 0;
  for (const TrialOfSeed& t : group.trials) {
    const double w = weights[t.seed];
    first += w * t.first, second += w * t.second, total += w;
  }
  return std::sqrt(first / total) - std::sqrt(second / total);
}

double exchanged_difference(const Group& group, const Weights& signs) {
  double first = 0, second = 0, count = 0;
  for (const TrialOfSeed& t : group.trials) {
    const bool kept = signs[t.seed] > 0;
    first += kept ? t.first : t.second;
    second += kept ? t.second : t.first;
    ++count;
  }
  return std::sqrt(first / count) - std::sqrt(second / count);
}

double improvement(const Group& group, const Weights& weights) {
  double better = 0, total = 0;
  for (const TrialOfSeed& t : group.trials) {
    const double both = 1 - t.only_first - t.only_second;
    const double won = t.first < t.second ? 1 : t.first > t.second ? 0 : 0.5;  // half if neither finished
    better += weights[t.seed] * (t.only_first + both * won);
    total += weights[t.seed];
  }
  return better / total;
}

double rmse(const Trials& pairs, double TrialOfSeed::*member) {
  return pairs.mean([&](const Group& group) {
    double sum = 0;
    for (const TrialOfSeed& t : group.trials) sum += t.*member;
    return std::sqrt(sum / static_cast<double>(group.trials.size()));
  });
}

void compare_errors(const Trials& pairs, const InferenceOptions& options, PairedComparison& result) {
  result.first = rmse(pairs, &TrialOfSeed::first), result.second = rmse(pairs, &TrialOfSeed::second);
  result.same = pairs.all_agree();
  Jackknife difference = jackknife(pairs.seeds(), [&](const Weights& weights) {
    return pairs.mean([&](const Group& group) { return rmse_difference(group, weights); });
  });
  difference.freedom = pairs.freedom();
  result.difference = {difference.value, difference.interval(options.confidence)};
  result.narrow = difference.interval(2 * options.confidence - 1);
  result.deviation = difference.deviation();
  result.p = result.adjusted_p = exchange_test(
      pairs.seeds(),
      [&](const Weights& signs) {
        return pairs.mean([&](const Group& group) { return exchanged_difference(group, signs); });
      },
      options);
}

Estimate improvement_of(const Trials& trials, double confidence) {
  Estimate share = estimate(
      trials.seeds(),
      [&](const Weights& weights) {
        return trials.mean([&](const Group& group) { return improvement(group, weights); });
      },
      confidence, Scale::plain);
  share.interval = {std::max(0.0, share.interval.lower), std::min(1.0, share.interval.upper)};
  return share;
}

/// Shares of trials that only one finished, over all places: those that lack pairs lack them because of it.
void compare_failures(const Trials& trials, const InferenceOptions& options, PairedComparison& result) {
  std::vector<double> by_seed(trials.seeds(), 0.0);  // first minus second, as it enters the mean
  std::vector<bool> told(trials.seeds(), false);
  double total = 0;
  for (const Group& group : trials.groups()) total += group.weight;
  for (const Group& group : trials.groups())
    for (const TrialOfSeed& t : group.trials) {
      by_seed[t.seed] +=
          group.weight / total * (t.only_second - t.only_first) / static_cast<double>(group.trials.size());
      if (t.only_second != t.only_first) told[t.seed] = true;
    }
  result.share_lost = 0;
  for (const double share : by_seed) result.share_lost += share;
  if (static_cast<std::size_t>(std::count(told.begin(), told.end(), true)) < least_seeds) return;
  std::vector<double> shares;
  for (std::size_t i = 0; i < by_seed.size(); ++i)
    if (told[i]) shares.push_back(by_seed[i]);
  result.p_lost = result.adjusted_p_lost = exchange_test(
      shares.size(),
      [&](const Weights& signs) {
        double sum = 0;
        for (std::size_t i = 0; i < signs.size(); ++i) sum += signs[i] * shares[i];
        return sum;
      },
      options);
}

/// Method of moments: the mean square of the places' differences about their mean, less what the covariance of the
/// differences (cluster jackknife over seeds, so with what the places share) would make of it alone.
Spread spread_of(const Trials& pairs) {
  Spread spread;
  std::vector<Jackknife> places;
  for (const Group& group : pairs.groups())
    places.push_back(jackknife(pairs.seeds(), [&](const Weights& weights) { return rmse_difference(group, weights); }));
  spread.places = places.size();
  const auto count = static_cast<double>(places.size()), n = static_cast<double>(pairs.seeds());
  double mean = 0, squares = 0;
  spread.lowest = std::numeric_limits<double>::infinity(), spread.highest = -spread.lowest;
  for (const Jackknife& place : places) {
    mean += place.value / count;
    spread.lowest = std::min(spread.lowest, place.value), spread.highest = std::max(spread.highest, place.value);
  }
  double noise = 0;  // trace of C S C, C = I - 1/P
  for (std::size_t i = 0; i < pairs.seeds(); ++i) {
    double sum = 0, square = 0;
    for (const Jackknife& place : places) sum += place.influence[i], square += std::pow(place.influence[i], 2);
    noise += (square - sum * sum / count) / (n * (n - 1));
  }
  for (const Jackknife& place : places) squares += std::pow(place.value - mean, 2);
  spread.deviation = std::sqrt(std::max(0.0, squares - noise) / (count - 1));
  return spread;
}

/// -1: the first is better in errors, 1: the second, 0: not shown.
int side_of_errors(const PairedComparison& c, double confidence) {
  const Interval& wide = c.difference.interval;
  if (!(c.adjusted_p < 1 - confidence)) return 0;
  return wide.upper < 0 ? -1 : wide.lower > 0 ? 1 : 0;
}

int side_of_failures(const PairedComparison& c, double confidence) {
  if (!(c.adjusted_p_lost < 1 - confidence)) return 0;
  return c.share_lost < 0 ? -1 : 1;
}

Verdict verdict_of(PairedComparison& c, double rope, double confidence) {
  const bool judged = std::isfinite(c.difference.interval.lower) && std::isfinite(c.difference.interval.upper);
  const bool equal = judged && rope > 0 && c.narrow.lower > -rope && c.narrow.upper < rope;
  const int errors = equal || !judged ? 0 : side_of_errors(c, confidence);
  const int failures = side_of_failures(c, confidence);
  c.errors_differ = errors != 0;
  if (errors * failures < 0) return Verdict::opposed;
  if (errors + failures < 0) return Verdict::first_better;
  if (errors + failures > 0) return Verdict::second_better;
  return equal ? Verdict::equal : judged ? Verdict::undecided : Verdict::too_few;
}

}  // namespace

const char* to_text(Verdict verdict) {
  static constexpr const char* names[] = {"first better", "second better", "equal",
                                          "undecided",    "opposed",       "too few trials"};
  return names[static_cast<int>(verdict)];
}

namespace {

/// Strata without a place that counts.
std::vector<std::string> silent_strata(const std::vector<Place>& places, bool pairs_only) {
  std::map<std::string, bool> heard;
  for (const Place& place : places)
    if (!place.stratum.empty()) heard[place.stratum] |= Trials::counts(place, pairs_only);
  std::vector<std::string> silent;
  for (const auto& [stratum, is_heard] : heard)
    if (!is_heard) silent.push_back(stratum);
  return silent;
}

}  // namespace

PairedComparison compare(const std::vector<Place>& places, const InferenceOptions& options) {
  PairedComparison result;
  result.first = result.second = result.deviation = kNan;
  result.difference = result.improvement = {kNan, {kNan, kNan}};
  result.narrow = {kNan, kNan};
  result.p = result.adjusted_p = result.p_lost = result.adjusted_p_lost = kNan;
  for (const Place& place : places) {
    const std::size_t paired = Trials::pairs_of(place);
    result.pairs += paired;
    (paired >= least_seeds ? result.places : result.left_out) += 1;
    for (const Encounter& e : place.encounters) result.lost_first += e.only_second, result.lost_second += e.only_first;
  }
  const Trials all(places, false), pairs(places, true);
  if (silent_strata(places, false).empty()) {
    compare_failures(all, options, result);
    if (all.seeds() > 0) result.improvement = improvement_of(all, options.confidence);
  }
  result.seeds = pairs.seeds();
  result.silent = silent_strata(places, true);
  if (result.places == 0 || !result.silent.empty()) return result;
  compare_errors(pairs, options, result);
  if (result.places > 1) result.spread = spread_of(pairs);
  return result;
}

void judge(std::vector<PairedComparison>& family, double rope, double confidence, const std::vector<double>& shares) {
  std::vector<double> p, of_test;
  double total = 0;
  for (std::size_t i = 0; i < family.size(); ++i)
    // What gave the same is not tested. Nor is it chosen by the outcome: exchanging the alternatives leaves it the
    // same.
    for (const double value : {family[i].same ? kNan : family[i].p, family[i].p_lost}) {
      p.push_back(value);
      of_test.push_back(shares.empty() ? 1.0 : shares[i]);
      if (!std::isnan(value)) total += of_test.back();
    }
  const std::vector<double> adjusted = holm(p, of_test);
  for (std::size_t i = 0; i < family.size(); ++i) {
    family[i].adjusted_p = family[i].same ? 1 : adjusted[2 * i], family[i].adjusted_p_lost = adjusted[2 * i + 1];
    family[i].risk = (1 - confidence) * of_test[2 * i] / total;
    family[i].verdict = verdict_of(family[i], rope, confidence);
  }
}

TimeComparison compare_times(const std::vector<TimePair>& seconds, const InferenceOptions& options) {
  std::map<std::uint64_t, std::vector<double>> by_seed;
  std::vector<double> all;
  for (const TimePair& pair : seconds) {
    if (!(pair.first > 0 && pair.second > 0)) continue;
    by_seed[pair.seed].push_back(pair.first / pair.second);
    all.push_back(pair.first / pair.second);
  }
  std::vector<const std::vector<double>*> every, half[2];
  for (const auto& [seed, ratios] : by_seed) {
    half[every.size() % 2].push_back(&ratios);
    every.push_back(&ratios);
  }
  const auto interval = [&](const std::vector<const std::vector<double>*>& seeds) -> Interval {
    if (seeds.size() < least_seeds) return {kNan, kNan};
    Random random(options.seed, "times");
    std::vector<double> medians, drawn;
    for (int b = 0; b < 1000; ++b) {
      drawn.clear();
      for (std::size_t k = 0; k < seeds.size(); ++k) {
        const auto& ratios = *seeds[static_cast<size_t>(random.uniform() * static_cast<double>(seeds.size()))];
        drawn.insert(drawn.end(), ratios.begin(), ratios.end());
      }
      medians.push_back(median(drawn));
    }
    std::sort(medians.begin(), medians.end());
    const double tail = 0.5 * (1 - options.confidence);
    return {quantile(medians, tail), quantile(medians, 1 - tail)};
  };
  TimeComparison result;
  result.pairs = all.size();
  result.ratio = {median(all), interval(every)};
  for (int k = 0; k < 2; ++k) result.halves[k] = interval(half[k]);
  const auto side = [](const Interval& i) { return i.upper < 1 ? -1 : i.lower > 1 ? 1 : 0; };  // nan: 0
  const int whole = side(result.ratio.interval);
  const bool matters = result.ratio.value > 1.05 || result.ratio.value < 1 / 1.05;
  result.confirmed = matters && whole != 0 && side(result.halves[0]) == whole && side(result.halves[1]) == whole;
  return result;
}

}  // namespace plumbline::statistics
