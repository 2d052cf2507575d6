#include "show/bench/sentences.hpp"

#include <algorithm>
#include <cmath>
#include <set>

#include "base/text/text.hpp"
#include "base/text/words.hpp"
#include "show/bench/pairing.hpp"

namespace plumbline::bench {

using statistics::Verdict;

namespace {

std::string after_semicolons(const std::vector<std::string>& parts) {
  std::string text;
  for (const std::string& part : parts) text += (text.empty() ? "" : "; ") + part;
  return text;
}

/// Without the sign of what rounds to zero.
std::string signed_millimetres(double metres) {
  const std::string text = text::format_fixed(1e3 * metres, 2);
  return text == "-0.00" ? "0.00" : text;
}

/// Where somebody wins: "full height (by 0.62 mm)", "corridor (gives a result 40 times more)".
std::string place_with_size(const Duel& duel) {
  const auto& e = duel.errors;
  if (e.errors_differ) return duel.place + " (by " + millimetres(e.difference.value) + ")";
  const double more = std::abs(e.lost_first - e.lost_second);
  return duel.place + " (" + text::format_fixed(more, 0) + " more results" +
         (duel.untested ? ", which the other one's own test forbids)" : ")");
}

/// Every verdict and the places that have it, in an order that puts winners first.
std::string by_place(const Pairing& pair, const Bench& bench) {
  std::vector<std::string> first, second, equal, open, opposed, few, refused;
  for (const Duel* duel : pair.places) {
    if (!duel->refused.empty()) {
      refused.push_back(duel->place);
      continue;
    }
    switch (duel->errors.verdict) {
      case Verdict::first_better:
        first.push_back(place_with_size(*duel));
        break;
      case Verdict::second_better:
        second.push_back(place_with_size(*duel));
        break;
      case Verdict::equal:
        equal.push_back(duel->place);
        break;
      case Verdict::undecided:
        open.push_back(duel->place);
        break;
      case Verdict::opposed:
        opposed.push_back(duel->place);
        break;
      case Verdict::too_few:
        few.push_back(duel->place);
        break;
    }
  }
  const std::size_t all = pair.places.size();
  std::vector<std::string> parts;
  const auto add = [&](const std::vector<std::string>& places, const std::string& what) {
    if (places.empty()) return;
    const std::string where = places.size() == all && all > 3 ? "all " + std::to_string(all) + " places"
                              : places.size() > 4
                                  ? std::to_string(places.size()) + " of " + std::to_string(all) + " places"
                                  : listed(places);
    parts.push_back(what + " " + where);
  };
  const auto name_all = [&](const std::vector<std::string>& places, const std::string& what) {
    if (!places.empty()) parts.push_back(what + " on " + listed(places));
  };
  name_all(first, pair.first() + " is better");
  name_all(second, pair.second() + " is better");
  name_all(opposed, "one has the smaller errors, the other more results");
  add(equal, "they are equal within " + rope_text(bench) + " on");
  add(open, "there is no winner on");
  add(few, "there are too few trials on");
  add(refused, "they are not compared on");
  return after_semicolons(parts);
}

std::string spread_text(const Duel& duel) {
  if (!duel.errors.spread) return "";
  const auto& s = *duel.errors.spread;
  if (duel.errors.same) return "";
  return "from place to place the difference of " + duel.first + " and " + duel.second + " goes from " +
         signed_millimetres(s.lowest) + " to " + signed_millimetres(s.highest) + " mm, standard deviation " +
         text::format_fixed(1e3 * s.deviation, 2) + " mm beyond noise";
}

std::size_t pairs_of(const Pairing& pair) {
  std::size_t pairs = 0;
  for (const Duel* duel : pair.places) pairs += duel->errors.pairs;
  return pairs;
}

void append(std::string& text, const std::string& more) {
  if (!more.empty()) text += "; " + more;
}

std::string sentence_of(const Pairing& pair, const Bench& bench) {
  if (!pair.overall) {
    std::string text = pair.places.front()->words;
    append(text, pair.places.front()->time_words);
    return text + ".";
  }
  if (!pair.overall->refused.empty()) return pair.overall->words + ".";
  std::string text;
  if (all_same(pair)) {
    text = pair.first() + " and " + pair.second() + " gave the same in all " + std::to_string(pairs_of(pair)) +
           " trials: what they do differently does not reach what is measured";
  } else {
    text = pair.first() + " and " + pair.second() + ": " + by_place(pair, bench);
    append(text, spread_text(*pair.overall));
    append(text, power_text(pair, bench));
    if (pair.overall->weighted) {
      text += "; " + bench.weights_text + ", " + pair.overall->words;
      if (const std::size_t left_out = pair.overall->errors.left_out; left_out > 0)
        text += " (without " + std::to_string(left_out) + (left_out == 1 ? " place" : " places") + " of fewer than " +
                std::to_string(statistics::least_seeds) + " pairs)";
    }
  }
  append(text, pair.overall->time_words);
  return text + ".";
}

}  // namespace

std::vector<Sentence> verdicts(const Bench& bench, const Analysis& analysis) {
  std::vector<Sentence> sentences;
  std::set<std::pair<std::string, std::string>> with_result;
  for (const Cell& cell : bench.cells)
    if (cell.status == "done") with_result.insert(cell.choices.begin(), cell.choices.end());
  for (const Group& group : bench.groups)
    for (const Pairing& pair : pairings(analysis, group.name)) {
      // Who gave no result at all is told of by itself, once, and not against everybody else.
      if (with_result.count({group.name, pair.first()}) == 0 || with_result.count({group.name, pair.second()}) == 0)
        continue;
      Sentence sentence{sentence_of(pair, bench)};
      const auto any = [&](auto&& holds) { return std::any_of(pair.places.begin(), pair.places.end(), holds); };
      sentence.refused = any([](const Duel* duel) { return !duel->refused.empty(); });
      const auto decided = [](const Duel* duel) { return is_winner(duel->errors.verdict) && !duel->untested; };
      sentence.winner = any(decided) || (pair.overall && pair.overall->weighted && decided(pair.overall));
      sentence.open = !sentence.winner && !any([](const Duel* duel) { return duel->errors.verdict == Verdict::equal; });
      sentences.push_back(std::move(sentence));
    }
  return sentences;
}

std::vector<std::string> calibration_verdicts(const Analysis& analysis) {
  // Alternatives that state the same at one place stand together.
  std::map<std::pair<std::string, std::string>, std::vector<std::string>> who;
  std::vector<std::pair<std::string, std::string>> order;
  std::size_t right = 0, judged = 0;
  for (const Row& row : analysis.rows) {
    std::vector<std::string> words;
    bool known = false;
    const auto& parts = row.summary.calibration;
    for (const auto& part : parts) {
      const auto honest = statistics::honesty(part);
      known |= honest != statistics::Honesty::unknown;
      // What is measured may be there under its own name, too.
      const auto named = [&](const auto& other) {
        return !other.mode.empty() && std::abs(other.ratio.value / part.ratio.value - 1) < 1e-9;
      };
      if (part.mode.empty() && std::any_of(parts.begin(), parts.end(), named)) continue;
      if (honest == statistics::Honesty::too_much || honest == statistics::Honesty::too_little)
        words.push_back(in_words(part));
    }
    judged += known;
    right += known && words.empty();
    if (words.empty()) continue;
    const std::pair<std::string, std::string> key{row.place, text::enumerate(words)};
    if (who[key].empty()) order.push_back(key);
    who[key].push_back(row.name);
  }
  if (judged == 0) return {};
  std::vector<std::string> sentences;
  for (const auto& key : order)
    sentences.push_back((key.first.empty() ? "" : key.first + ": ") + text::enumerate(who[key], " and ", "; ") +
                        " stated " + key.second + ".");
  sentences.push_back(std::to_string(right) + " of " + std::to_string(judged) +
                      " rows state what is found, within a tenth or within what the trials can tell.");
  return sentences;
}

std::string confidence_text(const Bench& bench, const Analysis& analysis) {
  return text::format_fixed(100 * analysis.confidence, bench.looks.empty() ? 0 : 1) + " %";
}

std::string method_text(const Bench& bench, const Analysis& analysis) {
  std::string text = "Intervals: " + confidence_text(bench, analysis) +
                     ", delete-one jackknife over seeds (a seed counts once, in all places), rates by Wilson; "
                     "differences are paired by seed, tested by exchanging whole seeds, p adjusted by Holm over all "
                     "places and pairs; a trial without result is lost";
  if (!bench.looks.empty())
    text += "; the bench may stop at " + std::to_string(bench.looks.size()) +
            (bench.looks.size() == 1 ? " look" : " looks") + ", each with its share of the error probability of 5 %";
  if (bench.rope > 0) text += "; differences below " + rope_text(bench) + " count as equal";
  if (bench.places().size() > 1)
    text += bench.weights.empty() ? "; the file states no weights, so nothing is said over all places together"
                                  : "; what is said over all places is of their mean, " + bench.weights_text;
  if (std::any_of(analysis.rows.begin(), analysis.rows.end(), [](const Row& row) { return row.own_trials; }))
    text +=
        "; a row's errors are those of its own finished trials, and with * another row of its place finished "
        "others: who is better is told by the verdicts, of trials that both finished";
  return text + ".";
}

std::string own_trials_mark(const Row& row) { return row.own_trials ? "*" : ""; }

}  // namespace plumbline::bench
