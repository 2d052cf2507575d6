#include "statistics/comparison.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>

#include "geometry/median.hpp"
#include "geometry/random.hpp"

namespace plumbline::statistics {

namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

using Strata = std::vector<std::vector<Pair>>;

double rmse_difference(const Strata& strata, const Weights& weights) {
  double sum = 0;
  for (std::size_t s = 0; s < strata.size(); ++s) {
    double first = 0, second = 0, total = 0;
    for (std::size_t i = 0; i < strata[s].size(); ++i) {
      first += weights[s][i] * strata[s][i].first;
      second += weights[s][i] * strata[s][i].second;
      total += weights[s][i];
    }
    sum += std::sqrt(first / total) - std::sqrt(second / total);
  }
  return sum / static_cast<double>(strata.size());
}

double exchanged_difference(const Strata& strata, const Weights& signs) {
  double sum = 0;
  for (std::size_t s = 0; s < strata.size(); ++s) {
    double first = 0, second = 0;
    for (std::size_t i = 0; i < strata[s].size(); ++i) {
      const Pair& pair = strata[s][i];
      const bool kept = signs[s][i] > 0;
      first += kept ? pair.first : pair.second;
      second += kept ? pair.second : pair.first;
    }
    const auto n = static_cast<double>(strata[s].size());
    sum += std::sqrt(first / n) - std::sqrt(second / n);
  }
  return sum / static_cast<double>(strata.size());
}

double improvement(const Strata& strata, const Weights& weights) {
  double sum = 0;
  for (std::size_t s = 0; s < strata.size(); ++s) {
    double better = 0, total = 0;
    for (std::size_t i = 0; i < strata[s].size(); ++i) {
      const Pair& pair = strata[s][i];
      better += weights[s][i] * (pair.first < pair.second ? 1.0 : pair.first == pair.second ? 0.5 : 0.0);
      total += weights[s][i];
    }
    sum += better / total;
  }
  return sum / static_cast<double>(strata.size());
}

std::string fixed(double value, int decimals) {
  char text[64];
  std::snprintf(text, sizeof text, "%.*f", decimals, value);
  const bool zero = std::string(text).find_first_of("123456789") == std::string::npos;
  return text[0] == '-' && zero && std::isfinite(value) ? text + 1 : text;
}

/// So many decimals that `size` keeps its first digit; between 1 and 6.
int decimals_for(double size) {
  if (!(size > 0) || !std::isfinite(size)) return 2;
  return std::clamp(-static_cast<int>(std::floor(std::log10(size))), 1, 6);
}

}  // namespace

const char* to_text(Verdict verdict) {
  static constexpr const char* names[] = {"first better", "second better", "equal", "undecided", "too few trials"};
  return names[static_cast<int>(verdict)];
}

PairedComparison compare_pairs(const std::vector<std::vector<Pair>>& given, const ResamplingOptions& options) {
  Strata strata;
  for (const auto& stratum : given)
    if (!stratum.empty()) strata.push_back(stratum);
  PairedComparison result;
  std::vector<std::size_t> sizes;
  for (const auto& stratum : strata) {
    double first = 0, second = 0;
    for (const Pair& pair : stratum) first += pair.first, second += pair.second;
    const auto n = static_cast<double>(stratum.size()), count = static_cast<double>(strata.size());
    result.first += std::sqrt(first / n) / count;
    result.second += std::sqrt(second / n) / count;
    result.pairs += stratum.size();
    result.fewest = sizes.empty() ? stratum.size() : std::min(result.fewest, stratum.size());
    sizes.push_back(stratum.size());
  }
  if (result.pairs == 0) result.first = result.second = kNan;
  result.difference = {result.first - result.second, {kNan, kNan}};
  result.narrow = result.improvement.interval = {kNan, kNan};
  result.improvement.value = result.p = result.adjusted_p = kNan;
  if (result.pairs < least_pairs) return result;
  const auto difference = [&](const Weights& weights) { return rmse_difference(strata, weights); };
  const double risk = 1 - options.confidence;
  const auto intervals = bca_intervals(sizes, difference, {options.confidence, 1 - 2 * risk}, options);
  result.difference.interval = intervals[0], result.narrow = intervals[1];
  result.improvement = bca(
      sizes, [&](const Weights& weights) { return improvement(strata, weights); }, options);
  ResamplingOptions test = options;
  test.resamples = std::max(options.resamples, 9999);
  result.p = result.adjusted_p = exchange_test(
      sizes, [&](const Weights& signs) { return exchanged_difference(strata, signs); }, test);
  return result;
}

void judge(std::vector<PairedComparison>& family, double rope, double confidence) {
  std::vector<double> p;
  for (const PairedComparison& comparison : family) p.push_back(comparison.p);
  const std::vector<double> adjusted = holm(p);
  for (std::size_t i = 0; i < family.size(); ++i) {
    PairedComparison& c = family[i];
    c.adjusted_p = adjusted[i];
    const Interval& wide = c.difference.interval;
    const bool significant = c.adjusted_p < 1 - confidence;
    if (!std::isfinite(wide.lower) || !std::isfinite(wide.upper))
      c.verdict = Verdict::too_few;
    else if (rope > 0 && c.narrow.lower > -rope && c.narrow.upper < rope)
      c.verdict = Verdict::equal;
    else if (significant && wide.upper < 0)
      c.verdict = Verdict::first_better;
    else if (significant && wide.lower > 0)
      c.verdict = Verdict::second_better;
    else
      c.verdict = Verdict::undecided;
  }
}

std::string in_words(const PairedComparison& c, const std::string& first, const std::string& second, double rope,
                     double scale, const std::string& unit) {
  const Interval wide{scale * c.difference.interval.lower, scale * c.difference.interval.upper};
  const int digits =
      decimals_for(std::max(0.5 * (wide.upper - wide.lower), 1e-3 * scale * std::max(c.first, c.second)));
  const auto range = [&](double a, double b) { return "(" + fixed(a, digits) + " to " + fixed(b, digits) + ")"; };
  const double value = scale * c.difference.value;
  switch (c.verdict) {
    case Verdict::first_better:
      return first + " beats " + second + " by " + fixed(-value, digits) + " " + unit + " " +
             range(-wide.upper, -wide.lower);
    case Verdict::second_better:
      return second + " beats " + first + " by " + fixed(value, digits) + " " + unit + " " +
             range(wide.lower, wide.upper);
    case Verdict::equal:
      return first + " and " + second + " are equal within " + fixed(scale * rope, decimals_for(scale * rope)) + " " +
             unit + " (difference " + fixed(value, digits) + " " + unit + ", " + fixed(wide.lower, digits) + " to " +
             fixed(wide.upper, digits) + ")";
    case Verdict::undecided: {
      const bool covers = wide.lower <= 0 && wide.upper >= 0;
      return "no winner between " + first + " and " + second + ": the difference is " + fixed(value, digits) + " " +
             unit + " " + range(wide.lower, wide.upper) +
             (covers ? ", an interval that covers zero" : ", but not significant after Holm's correction") +
             (rope > 0 ? "" : "; no rope is given, so nothing can be called equal");
    }
    case Verdict::too_few:
      return "nothing can be said of " + first + " and " + second + ": " +
             (c.pairs < least_pairs
                  ? std::to_string(c.pairs) + (c.pairs == 1 ? " trial" : " trials") +
                        " that both finished, needed are " + std::to_string(least_pairs)
                  : "of " + std::to_string(c.pairs) + " trials that both finished, one place has only " +
                        std::to_string(c.fewest) + ", and an interval needs two in each");
  }
  return "";
}

TimeComparison compare_times(const std::vector<Pair>& seconds, const ResamplingOptions& options) {
  std::vector<double> all, half[2];
  for (const Pair& pair : seconds) {
    if (!(pair.first > 0 && pair.second > 0)) continue;
    half[all.size() % 2].push_back(pair.first / pair.second);
    all.push_back(pair.first / pair.second);
  }
  const auto interval = [&](const std::vector<double>& ratios) -> Interval {
    if (ratios.size() < least_pairs) return {kNan, kNan};
    Random random(options.seed, "times");
    std::vector<double> medians, drawn(ratios.size());
    for (int b = 0; b < options.resamples; ++b) {
      for (double& value : drawn)
        value = ratios[static_cast<std::size_t>(random.uniform() * static_cast<double>(ratios.size()))];
      medians.push_back(median(drawn));
    }
    std::sort(medians.begin(), medians.end());
    const double tail = 0.5 * (1 - options.confidence);
    return {quantile(medians, tail), quantile(medians, 1 - tail)};
  };
  TimeComparison result;
  result.pairs = all.size();
  result.ratio = {median(all), interval(all)};
  for (int k = 0; k < 2; ++k) result.halves[k] = interval(half[k]);
  const auto side = [](const Interval& i) { return i.upper < 1 ? -1 : i.lower > 1 ? 1 : 0; };  // nan: 0
  const int whole = side(result.ratio.interval);
  const bool matters = result.ratio.value > 1.05 || result.ratio.value < 1 / 1.05;
  result.confirmed = matters && whole != 0 && side(result.halves[0]) == whole && side(result.halves[1]) == whole;
  return result;
}

}  // namespace plumbline::statistics
