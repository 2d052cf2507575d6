// What a comparison says, as a person would say it.
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "base/statistics/comparison.hpp"
#include "base/text/text.hpp"
#include "base/text/words.hpp"

namespace plumbline::statistics {

namespace {

constexpr double kPower = 0.8;

/// So many decimals that `size` keeps its first digit; between 1 and 6.
int decimals_for(double size) {
  if (!(size > 0) || !std::isfinite(size)) return 2;
  return std::clamp(-static_cast<int>(std::floor(std::log10(size))), 1, 6);
}

std::string length(double value, const std::string& unit) {
  return text::format_fixed(value, decimals_for(value)) + " " + unit;
}

/// Counts of cells are whole where each seed has one cell.
std::string count(double value) {
  return std::abs(value - std::round(value)) < 1e-9 ? text::format_fixed(value, 0) : text::format_fixed(value, 1);
}

/// The sentence about errors alone, as if nothing had failed.
class ErrorWords {
 public:
  ErrorWords(const PairedComparison& c, const std::string& first, const std::string& second, double scale,
             const std::string& unit)
      : c_(c),
        first_(first),
        second_(second),
        unit_(unit),
        wide_{scale * c.difference.interval.lower, scale * c.difference.interval.upper},
        value_(scale * c.difference.value),
        digits_(decimals_for(std::max(0.5 * (wide_.upper - wide_.lower), 1e-3 * scale * std::max(c.first, c.second)))) {
  }

  std::string winner() const {
    const bool of_first = value_ < 0;
    return (of_first ? first_ : second_) + " beats " + (of_first ? second_ : first_) + " by " +
           text::format_fixed(std::abs(value_), digits_) + " " + unit_ + " " +
           (of_first ? range(-wide_.upper, -wide_.lower) : range(wide_.lower, wide_.upper));
  }
  std::string equal(double rope) const {
    if (c_.same)
      return first_ + " and " + second_ + " gave the same in all " + std::to_string(c_.pairs) +
             " trials: what they do differently does not reach what is measured";
    return first_ + " and " + second_ + " are equal within " + length(rope, unit_) + " (difference " +
           text::format_fixed(value_, digits_) + " " + unit_ + ", " + text::format_fixed(wide_.lower, digits_) +
           " to " + text::format_fixed(wide_.upper, digits_) + ")";
  }
  std::string undecided(double rope) const {
    if (c_.same) return equal(rope);
    const bool covers = wide_.lower <= 0 && wide_.upper >= 0;
    return "no winner between " + first_ + " and " + second_ + ": the difference is " + difference() +
           (covers ? ", an interval that covers zero" : ", but not significant after Holm's correction") +
           (rope > 0 ? "" : "; no rope is given, so nothing can be called equal");
  }
  std::string too_few() const {
    if (!c_.silent.empty()) return "nothing can be said of " + first_ + " and " + second_ + ": " + silent();
    return "nothing can be said of " + first_ + " and " + second_ + ": " + std::to_string(c_.pairs) +
           (c_.pairs == 1 ? " trial" : " trials") + " that both finished, needed are " + std::to_string(least_seeds) +
           (c_.left_out > 1 ? " at one place" : "");
  }
  /// Which weights would go to others.
  std::string silent() const {
    return text::enumerate(c_.silent) + (c_.silent.size() > 1 ? " have" : " has") + " no place with " +
           std::to_string(least_seeds) + " trials that both finished";
  }
  std::string difference() const {
    return text::format_fixed(value_, digits_) + " " + unit_ + " " + range(wide_.lower, wide_.upper);
  }

 private:
  std::string range(double a, double b) const {
    return "(" + text::format_fixed(a, digits_) + " to " + text::format_fixed(b, digits_) + ")";
  }

  const PairedComparison& c_;
  const std::string &first_, &second_, &unit_;
  const Interval wide_;
  const double value_;
  const int digits_;
};

std::string more_results(const PairedComparison& c, const std::string& first, const std::string& second) {
  const bool of_first = c.share_lost < 0;
  const double more = of_first ? c.lost_second : c.lost_first, fewer = of_first ? c.lost_first : c.lost_second;
  return "gives a result in " + count(more) + (more == 1 ? " trial" : " trials") + " in which " +
         (of_first ? second : first) + " gives none" + (fewer > 0 ? ", against " + count(fewer) : "");
}

}  // namespace

double seeds_wanted(const PairedComparison& c, double rope) {
  if (c.verdict != Verdict::undecided || c.same) return std::nan("");
  const double risk = c.risk > 0 ? c.risk : 0.05;
  const double wanted = seeds_to_show(std::max(rope, std::abs(c.difference.value)), c.deviation, risk, kPower);
  return std::max(wanted, static_cast<double>(seeds_for_risk(risk)));
}

std::string power_in_words(const PairedComparison& c, double rope, double scale, const std::string& unit) {
  const double wanted = seeds_wanted(c, rope), shown = std::max(rope, std::abs(c.difference.value));
  if (!std::isfinite(wanted) || wanted <= static_cast<double>(c.seeds)) return "";
  return (wanted > 1e6 ? "more than a million" : text::format_fixed(wanted, 0)) + " seeds would show " +
         length(scale * shown, unit);
}

std::string in_words(const PairedComparison& c, const std::string& first, const std::string& second, double rope,
                     double scale, const std::string& unit) {
  const ErrorWords errors(c, first, second, scale, unit);
  const bool first_wins = c.verdict == Verdict::first_better;
  std::string text;
  switch (c.verdict) {
    case Verdict::first_better:
    case Verdict::second_better: {
      const std::string &winner = first_wins ? first : second, &loser = first_wins ? second : first;
      if (c.errors_differ) {
        text = errors.winner();
        break;
      }
      text = winner + " beats " + loser + ": it " + more_results(c, first, second);
      if (!c.silent.empty()) return text + "; of the errors nothing can be said, " + errors.silent();
      if (c.places == 0)
        return text + "; of the errors nothing can be said, " + std::to_string(c.pairs) +
               (c.pairs == 1 ? " trial" : " trials") + " that both finished";
      return text + "; where both finish, the difference is " + errors.difference();
    }
    case Verdict::opposed: {
      const bool first_smaller = c.difference.value < 0;
      return errors.winner() + " where both finish, but " + (first_smaller ? second : first) + " " +
             more_results(c, first, second) + ": no winner";
    }
    case Verdict::equal:
      text = errors.equal(scale * rope);
      break;
    case Verdict::undecided:
      text = errors.undecided(rope);
      break;
    case Verdict::too_few:
      text = errors.too_few();
      break;
  }
  if (c.lost_first + c.lost_second > 0)
    text += "; on the trials that both finished, besides them " + count(c.lost_second) + " only by " + first + ", " +
            count(c.lost_first) + " only by " + second;
  const std::string power = power_in_words(c, rope, scale, unit);
  return text + (power.empty() ? "" : "; " + power);
}

}  // namespace plumbline::statistics
