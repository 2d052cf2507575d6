// What a practitioner may choose, in short sentences.
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "base/text/words.hpp"
#include "show/bench/pairing.hpp"
#include "show/bench/sentences.hpp"

namespace plumbline::bench {

using statistics::Verdict;

namespace {

constexpr std::size_t items_in_a_sentence = 3;

struct Standing {
  std::vector<std::string> beaten_on, untried;        ///< places
  double most = 0;                                    ///< largest difference by which it is beaten on one of them [m]
  bool beaten_overall = false, best_overall = false;  ///< by the verdict with the file's weights; best: and beats some
  double most_overall = 0;                            ///< [m]
  std::size_t cells = 0, failed = 0, useless = 0;
  bool compared = false;  ///< with enough trials for a verdict
  bool is_beaten() const { return beaten_overall || !beaten_on.empty(); }
};
using Standings = std::map<std::string, Standing>;

bool has_verdict(const Duel& duel) { return duel.refused.empty() && duel.errors.verdict != Verdict::too_few; }

/// What the verdicts over all places say, where the file states what a mean over them means.
void add_overall(const std::vector<Pairing>& pairs, Standings& standings) {
  for (const Pairing& pair : pairs) {
    if (!pair.overall || !pair.overall->weighted || !has_verdict(*pair.overall)) continue;
    const auto& errors = pair.overall->errors;
    standings[pair.first()].compared = standings[pair.second()].compared = true;
    if (!is_winner(errors.verdict)) continue;
    const bool first = errors.verdict == Verdict::first_better;
    Standing& loser = standings[first ? pair.second() : pair.first()];
    loser.beaten_overall = true;
    standings[first ? pair.first() : pair.second()].best_overall = true;
    if (errors.errors_differ) loser.most_overall = std::max(loser.most_overall, std::abs(errors.difference.value));
  }
  for (auto& [name, standing] : standings) standing.best_overall &= !standing.beaten_overall;
}

/// Places where nothing of an alternative has run: what is said of it says nothing of them.
void add_untried(const Bench& bench, const Group& group, Standings& standings) {
  std::map<std::string, std::set<std::string>> tried;
  for (const Cell& cell : bench.cells)
    if (const auto choice = cell.choices.find(group.name); choice != cell.choices.end() && cell.status != "missing")
      tried[choice->second].insert(cell.place);
  for (const std::string& place : bench.places())
    for (const auto& [name, places] : tried)
      if (places.count(place) == 0) standings[name].untried.push_back(place);
}

Standings standings_of(const Bench& bench, const Group& group, const std::vector<Pairing>& pairs) {
  Standings standings;
  const auto note = [](std::vector<std::string>& places, const std::string& place) {
    if (std::find(places.begin(), places.end(), place) == places.end()) places.push_back(place);
  };
  for (const Pairing& pair : pairs)
    for (const Duel* duel : pair.places) {
      if (!has_verdict(*duel)) continue;
      standings[duel->first].compared = standings[duel->second].compared = true;
      if (!is_winner(duel->errors.verdict)) continue;
      const bool first = duel->errors.verdict == Verdict::first_better;
      Standing& loser = standings[first ? duel->second : duel->first];
      note(loser.beaten_on, duel->place);
      if (duel->errors.errors_differ) loser.most = std::max(loser.most, std::abs(duel->errors.difference.value));
    }
  add_overall(pairs, standings);
  add_untried(bench, group, standings);
  const double useless_above = bench.useless_above();
  for (const Cell& cell : bench.cells) {
    const auto choice = cell.choices.find(group.name);
    if (choice == cell.choices.end() || cell.status == "missing") continue;
    Standing& standing = standings[choice->second];
    ++standing.cells;
    standing.failed += cell.status == "failed";
    standing.useless += cell.status == "done" && cell.error_size() > useless_above;
  }
  return standings;
}

std::string places_text(const std::vector<std::string>& places, std::size_t all) {
  if (all < 2) return "";
  return " on " + (places.size() == all && all > 3 ? "all " + std::to_string(all) + " places"
                   : places.size() > 2 ? std::to_string(places.size()) + " of " + std::to_string(all) + " places"
                                       : listed(places));
}

/// Names of which the same is to be said, in the order in which they came.
class SaidOf {
 public:
  void add(const std::string& name, const std::string& what) {
    for (auto& [known, names] : said_)
      if (known == what) return names.push_back(name);
    said_.push_back({what, {name}});
  }
  const std::vector<std::pair<std::string, std::vector<std::string>>>& all() const { return said_; }

 private:
  std::vector<std::pair<std::string, std::vector<std::string>>> said_;
};

/// "without result: a and b in 3 of 40 cells each, c in 1 of 40 cells", three such to a sentence.
void add_counts(const std::string& what, const SaidOf& counts, std::vector<std::string>& sentences) {
  std::vector<std::string> items;
  for (std::size_t k = 0; k < counts.all().size(); ++k) {
    const auto& [count, names] = counts.all()[k];
    items.push_back(text::enumerate(names) + " in " + count + (names.size() > 1 ? " each" : ""));
    if (items.size() < items_in_a_sentence && k + 1 < counts.all().size()) continue;
    sentences.push_back(what + text::enumerate(items, "; ", "; "));
    items.clear();
  }
}

/// "beaten on corridor by 0.30 mm, and over all places, all places weighing alike, by 0.21 mm"
std::string beaten_text(const Bench& bench, const Standing& s) {
  std::string text = "beaten";
  if (!s.beaten_on.empty())
    text += places_text(s.beaten_on, bench.places().size()) +
            (s.most > 0 ? (s.beaten_on.size() > 1 ? ", by up to " : " by ") + millimetres(s.most)
                        : ", for lack of results");
  if (s.beaten_overall)
    text += (s.beaten_on.empty() ? " over all places, " : ", and over all places, ") + bench.weights_text + ", " +
            (s.most_overall > 0 ? "by " + millimetres(s.most_overall) : "for lack of results");
  return text;
}

void add_beaten(const Bench& bench, const std::vector<std::string>& beaten, const Standings& standings,
                std::vector<std::string>& sentences) {
  SaidOf said;
  for (const std::string& name : beaten) said.add(name, beaten_text(bench, standings.at(name)));
  for (const auto& [what, names] : said.all())
    sentences.push_back(text::enumerate(names) + (names.size() > 1 ? " are " : " is ") + what);
}

/// What stands in a group: who was compared and who not, by name and in its order.
struct Field {
  std::vector<std::string> unbeaten, beaten, silent, unknown;
  SaidOf failing, useless, untried;
  bool any_winner = false;
};

Field field_of(const Group& group, Standings& standings) {
  Field field;
  for (const std::string& name : group.alternatives) {
    const Standing& s = standings[name];
    if (s.cells == 0) continue;
    const std::string of_cells = " of " + std::to_string(s.cells) + " cells";
    if (s.failed == s.cells)
      field.silent.push_back(name + " gave no result in any" + of_cells);
    else if (!s.compared)
      field.unknown.push_back(name);
    else
      (s.is_beaten() ? field.beaten : field.unbeaten).push_back(name);
    field.any_winner |= s.is_beaten();
    if (!s.untried.empty()) field.untried.add(name, listed(s.untried));
    if (s.failed > 0 && s.failed < s.cells) field.failing.add(name, std::to_string(s.failed) + of_cells);
    if (s.useless > 0) field.useless.add(name, std::to_string(s.useless) + of_cells);
  }
  // The one that is beaten on fewest places comes first.
  std::stable_sort(field.beaten.begin(), field.beaten.end(), [&](const std::string& x, const std::string& y) {
    return standings[x].beaten_on.size() < standings[y].beaten_on.size();
  });
  return field;
}

/// Who has the smaller errors where the other gives more results: no number says which of that counts more. Who is
/// beaten by somebody else is no choice where others are not.
std::vector<std::string> opposed_in_words(const Bench& bench, const Field& field, const std::vector<Pairing>& pairs) {
  const auto is_choice = [&](const std::string& name) {
    return field.unbeaten.empty() ||
           std::find(field.unbeaten.begin(), field.unbeaten.end(), name) != field.unbeaten.end();
  };
  SaidOf where;  // by place, who is opposed to whom there
  const auto add = [&](const Duel& duel, const std::string& place) {
    if (!duel.refused.empty() || duel.errors.verdict != Verdict::opposed) return;
    const bool first = duel.errors.difference.value < 0;
    where.add(place, (first ? duel.first : duel.second) + " has the smaller errors and " +
                         (first ? duel.second : duel.first) + " more results");
  };
  const std::string overall = "over all places, " + bench.weights_text;
  for (const Pairing& pair : pairs) {
    if (!is_choice(pair.first()) || !is_choice(pair.second())) continue;
    for (const Duel* duel : pair.places) add(*duel, duel->place);
    if (pair.overall && pair.overall->weighted) add(*pair.overall, overall);
  }
  std::vector<std::string> sentences;
  for (auto [what, places] : where.all()) {
    const bool also_overall = std::erase(places, overall) > 0;
    const bool named = !places.empty() && !places.front().empty();
    sentences.push_back(what + (named ? " on " + listed(places) : "") +
                        (also_overall ? (named ? ", and " : " ") + overall : "") +
                        ": which of that counts more is for you to say");
  }
  return sentences;
}

void add_nothing_separates(const Bench& bench, const Field& field, const std::vector<Pairing>& pairs,
                           std::vector<std::string>& sentences) {
  const std::size_t places = bench.places().size();
  bool all_equal = true;
  std::string power;
  for (const Pairing& pair : pairs) {
    for (const Duel* duel : pair.places)
      all_equal &=
          duel->refused.empty() && (duel->errors.verdict == Verdict::equal || duel->errors.verdict == Verdict::too_few);
    if (power.empty()) power = power_text(pair, bench);
  }
  const std::string lead = "nothing separates " + text::enumerate(field.unbeaten) + ": ";
  if (all_equal) {
    sentences.push_back(lead + "they are equal within " + rope_text(bench) +
                        (places > 1 ? " wherever there are trials enough" : ""));
    return;
  }
  sentences.push_back(lead + "no winner" + (places > 1 ? " at any place" : ""));
  if (!power.empty()) sentences.push_back(power);
}

void add_unbeaten(const Field& field, const Standings& standings, std::vector<std::string>& sentences) {
  // Nobody takes what is of no use in most trials, though nothing that gave an answer was better; and what was tried on
  // some places only is second to what was tried on all.
  std::vector<std::string> taken, partly, useless;
  for (const std::string& name : field.unbeaten) {
    const Standing& s = standings.at(name);
    (2 * (s.useless + s.failed) > s.cells ? useless : s.untried.empty() ? taken : partly).push_back(name);
  }
  if (!taken.empty()) sentences.push_back("take " + text::enumerate(taken, " or ") + ", beaten nowhere");
  if (!partly.empty())
    sentences.push_back((taken.empty() ? "take " + text::enumerate(partly, " or ") + ","
                                       : text::enumerate(partly) + (partly.size() > 1 ? " are" : " is")) +
                        " beaten nowhere that " + (partly.size() > 1 ? "they were" : "it was") + " tried");
  if (!useless.empty())
    sentences.push_back(text::enumerate(useless) + (useless.size() > 1 ? " are" : " is") +
                        " beaten nowhere, and of use in fewer than half of the cells");
}

void add_choice(const Bench& bench, const Field& field, const Standings& standings,
                std::vector<std::string>& sentences) {
  const std::size_t places = bench.places().size();
  if (!field.unbeaten.empty()) {
    add_unbeaten(field, standings, sentences);
  } else if (places < 2) {
    sentences.push_back("each of " + text::enumerate(field.beaten) + " is beaten by another");
    return;
  } else {
    std::vector<std::string> rest, nearest;  // who is beaten over all places comes nearest to nothing
    for (const std::string& name : field.beaten)
      if (!standings.at(name).beaten_overall) rest.push_back(name);
    if (rest.empty()) rest = field.beaten;
    std::size_t fewest = standings.at(rest.front()).beaten_on.size();
    for (const std::string& name : rest) fewest = std::min(fewest, standings.at(name).beaten_on.size());
    for (const std::string& name : rest)
      if (standings.at(name).beaten_on.size() == fewest) nearest.push_back(name);
    sentences.push_back("none is best everywhere");
    sentences.push_back(text::enumerate(nearest) + (nearest.size() > 1 ? " come" : " comes") + " nearest, beaten on " +
                        std::to_string(fewest) + " of " + std::to_string(places) + " places");
    std::vector<std::string> best;
    for (const std::string& name : field.beaten)
      if (standings.at(name).best_overall) best.push_back(name);
    if (!best.empty())
      sentences.push_back("over all places, " + bench.weights_text + ", nothing beats " +
                          text::enumerate(best, " or "));
  }
  add_beaten(bench, field.beaten, standings, sentences);
}

/// Why those that nothing can be said of are not compared, where that is another reason than too few trials.
std::vector<std::string> refused_in_words(const Field& field, const std::vector<Pairing>& pairs) {
  const auto is_unknown = [&](const std::string& name) {
    return std::find(field.unknown.begin(), field.unknown.end(), name) != field.unknown.end();
  };
  std::vector<std::string> sentences;
  for (const Pairing& pair : pairs) {
    if (!is_unknown(pair.first()) && !is_unknown(pair.second())) continue;
    for (const Duel* duel : pair.places) {
      if (duel->refused.empty()) continue;
      sentences.push_back(duel->words + (duel->place.empty() ? "" : " (" + duel->place + ")"));
      break;
    }
  }
  return sentences;
}

std::string choice_of(const Bench& bench, const Group& group, const std::vector<Pairing>& pairs) {
  Standings standings = standings_of(bench, group, pairs);
  const Field field = field_of(group, standings);
  std::vector<std::string> sentences;
  if (!pairs.empty() && std::all_of(pairs.begin(), pairs.end(), all_same)) {
    sentences.push_back("nothing separates " + text::enumerate(field.unbeaten) + ": they gave the same in every trial");
    sentences.push_back("what they do differently does not reach what is measured here");
  } else if (const auto opposed = opposed_in_words(bench, field, pairs); field.any_winner || !opposed.empty()) {
    if (field.any_winner) add_choice(bench, field, standings, sentences);
    sentences.insert(sentences.end(), opposed.begin(), opposed.end());
    if (!field.any_winner && field.unbeaten.size() > 2)
      sentences.push_back("nothing else separates " + text::enumerate(field.unbeaten));
  } else if (field.unbeaten.size() > 1) {
    add_nothing_separates(bench, field, pairs, sentences);
  }
  const auto refused = refused_in_words(field, pairs);
  sentences.insert(sentences.end(), refused.begin(), refused.end());
  if (!field.unknown.empty() && refused.empty())
    sentences.push_back("of " + text::enumerate(field.unknown) + " nothing can be said: too few trials to compare");
  for (const auto& [places, names] : field.untried.all())
    sentences.push_back(text::enumerate(names) + (names.size() > 1 ? " were" : " was") + " not tried on " + places);
  add_counts("without result: ", field.failing, sentences);
  add_counts(fmt::format("off by more than {:g} mm: ", 1e3 * bench.useless_above()), field.useless, sentences);
  sentences.insert(sentences.end(), field.silent.begin(), field.silent.end());
  if (const double most = bench.none_within(); std::isfinite(most))
    sentences.push_back(fmt::format("in no trial was any of them within {:g} mm", 1e3 * most));
  std::string text = group.name + ":";
  for (std::size_t k = 0; k < sentences.size(); ++k)
    text += " " + (k == 0 ? sentences[k] : begin_sentence(sentences[k], group.alternatives)) + ".";
  return text;
}

}  // namespace

std::vector<std::string> choices_to_make(const Bench& bench, const Analysis& analysis) {
  std::vector<std::string> sentences;
  for (const Group& group : bench.groups) sentences.push_back(choice_of(bench, group, pairings(analysis, group.name)));
  return sentences;
}

}  // namespace plumbline::bench
