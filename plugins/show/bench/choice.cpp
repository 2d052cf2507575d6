// What a practitioner may choose, in short sentences.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>

#include "base/text/words.hpp"
#include "show/bench/pairing.hpp"
#include "show/bench/sentences.hpp"

namespace plumbline::bench {

using statistics::Verdict;

namespace {

constexpr std::size_t items_in_a_sentence = 3;

struct Standing {
  std::vector<std::string> beaten_on;
  double most = 0;  ///< largest difference by which it is beaten [m]
  std::size_t cells = 0, failed = 0, useless = 0;
  bool compared = false;  ///< with enough trials for a verdict
};
using Standings = std::map<std::string, Standing>;

Standings standings_of(const Bench& bench, const Group& group, const std::vector<Pairing>& pairs) {
  Standings standings;
  const auto note = [](std::vector<std::string>& places, const std::string& place) {
    if (std::find(places.begin(), places.end(), place) == places.end()) places.push_back(place);
  };
  for (const Pairing& pair : pairs)
    for (const Duel* duel : pair.places) {
      if (!duel->refused.empty() || duel->errors.verdict == Verdict::too_few) continue;
      standings[duel->first].compared = standings[duel->second].compared = true;
      if (!is_winner(duel->errors.verdict)) continue;
      const bool first = duel->errors.verdict == Verdict::first_better;
      Standing& loser = standings[first ? duel->second : duel->first];
      note(loser.beaten_on, duel->place);
      if (duel->errors.errors_differ) loser.most = std::max(loser.most, std::abs(duel->errors.difference.value));
    }
  const double useless_above = bench.useless_above();
  for (const Cell& cell : bench.cells) {
    const auto choice = cell.choices.find(group.name);
    if (choice == cell.choices.end() || cell.status == "missing") continue;
    Standing& standing = standings[choice->second];
    ++standing.cells;
    standing.failed += cell.status == "failed";
    standing.useless += cell.status == "done" && cell.measure("error") > useless_above;
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

void add_beaten(const std::vector<std::string>& beaten, const Standings& standings, std::size_t places,
                std::vector<std::string>& sentences) {
  SaidOf said;
  for (const std::string& name : beaten) {
    const Standing& s = standings.at(name);
    said.add(name, "beaten" + places_text(s.beaten_on, places) +
                       (s.most > 0 ? (s.beaten_on.size() > 1 ? ", by up to " : " by ") + millimetres(s.most)
                                   : ", for lack of results"));
  }
  for (const auto& [what, names] : said.all())
    sentences.push_back(text::enumerate(names) + (names.size() > 1 ? " are " : " is ") + what);
}

/// What stands in a group: who was compared and who not, by name and in its order.
struct Field {
  std::vector<std::string> unbeaten, beaten, silent, unknown;
  SaidOf failing, useless;
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
      (s.beaten_on.empty() ? field.unbeaten : field.beaten).push_back(name);
    field.any_winner |= !s.beaten_on.empty();
    if (s.failed > 0 && s.failed < s.cells) field.failing.add(name, std::to_string(s.failed) + of_cells);
    if (s.useless > 0) field.useless.add(name, std::to_string(s.useless) + of_cells);
  }
  // The one that is beaten on fewest places comes first.
  std::stable_sort(field.beaten.begin(), field.beaten.end(), [&](const std::string& x, const std::string& y) {
    return standings[x].beaten_on.size() < standings[y].beaten_on.size();
  });
  return field;
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

void add_choice(const Bench& bench, const Field& field, const Standings& standings,
                std::vector<std::string>& sentences) {
  const std::size_t places = bench.places().size();
  if (!field.unbeaten.empty()) {
    // Nobody takes what is of no use in most trials, though nothing that gave an answer was better.
    std::vector<std::string> taken;
    for (const std::string& name : field.unbeaten) {
      const Standing& s = standings.at(name);
      if (2 * (s.useless + s.failed) <= s.cells || s.useless == 0) taken.push_back(name);
    }
    sentences.push_back(taken.empty() ? text::enumerate(field.unbeaten) +
                                            " are beaten nowhere, and of use in fewer than half of the cells"
                                      : "take " + text::enumerate(taken, " or ") + ", beaten nowhere");
  } else if (places < 2) {
    sentences.push_back("each of " + text::enumerate(field.beaten) + " is beaten by another");
    return;
  } else {
    const std::size_t fewest = standings.at(field.beaten.front()).beaten_on.size();
    std::vector<std::string> nearest;
    for (const std::string& name : field.beaten)
      if (standings.at(name).beaten_on.size() == fewest) nearest.push_back(name);
    sentences.push_back("none is best everywhere");
    sentences.push_back(text::enumerate(nearest) + (nearest.size() > 1 ? " come" : " comes") + " nearest, beaten on " +
                        std::to_string(fewest) + " of " + std::to_string(places) + " places");
  }
  add_beaten(field.beaten, standings, places, sentences);
}

std::string choice_of(const Bench& bench, const Group& group, const std::vector<Pairing>& pairs) {
  Standings standings = standings_of(bench, group, pairs);
  const Field field = field_of(group, standings);
  std::vector<std::string> sentences;
  if (!pairs.empty() && std::all_of(pairs.begin(), pairs.end(), all_same)) {
    sentences.push_back("nothing separates " + text::enumerate(field.unbeaten) + ": they gave the same in every trial");
    sentences.push_back("what they do differently does not reach what is measured here");
  } else if (!field.any_winner && field.unbeaten.size() > 1) {
    add_nothing_separates(bench, field, pairs, sentences);
  } else if (field.any_winner) {
    add_choice(bench, field, standings, sentences);
  }
  if (!field.unknown.empty())
    sentences.push_back("of " + text::enumerate(field.unknown) + " nothing can be said: too few trials to compare");
  add_counts("without result: ", field.failing, sentences);
  char limit[48];
  std::snprintf(limit, sizeof limit, "off by more than %g mm: ", 1e3 * bench.useless_above());
  add_counts(limit, field.useless, sentences);
  sentences.insert(sentences.end(), field.silent.begin(), field.silent.end());
  std::string text = group.name + ":";
  for (std::size_t k = 0; k < sentences.size(); ++k)
    text += " " + (k == 0 ? sentences[k] : begin_sentence(sentences[k])) + ".";
  return text;
}

}  // namespace

std::vector<std::string> choices_to_make(const Bench& bench, const Analysis& analysis) {
  std::vector<std::string> sentences;
  for (const Group& group : bench.groups) sentences.push_back(choice_of(bench, group, pairings(analysis, group.name)));
  return sentences;
}

}  // namespace plumbline::bench
