// What a practitioner may choose, in short sentences.
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "base/text/words.hpp"
#include "show/bench/pairing.hpp"
#include "show/bench/sentences.hpp"
#include "show/bench/standings.hpp"

namespace plumbline::bench {

using statistics::Verdict;

namespace {

constexpr std::size_t items_in_a_sentence = 3;

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
  std::vector<std::string> ran, unbeaten, beaten, silent, unknown;
  SaidOf failing, useless, untried;
  bool any_winner = false;
};

Field field_of(const Group& group, Standings& standings) {
  Field field;
  for (const std::string& name : group.alternatives) {
    const Standing& s = standings[name];
    if (s.cells == 0 && s.unplanned > 0) field.silent.push_back(name + " did not run");
    if (s.cells == 0) continue;
    field.ran.push_back(name);
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
  bool all_equal = true, any_equal = false;
  std::string power;
  for (const Pairing& pair : pairs) {
    for (const Duel* duel : pair.places) {
      const bool equal = duel->untested ? errors_equal(*duel, bench.rope)
                                        : duel->refused.empty() && duel->errors.verdict == Verdict::equal;
      const bool silent =
          duel->untested ? duel->errors.places == 0 : duel->refused.empty() && duel->errors.verdict == Verdict::too_few;
      all_equal &= duel->never_ran || equal || silent, any_equal |= equal;
    }
    if (power.empty()) power = power_text(pair, bench);
  }
  const std::string lead = "nothing separates " + text::enumerate(field.unbeaten) + ": ";
  if (all_equal && any_equal) {
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

/// "where tags is 1 take a or b, where it is 2 or 4 take c": what the reader has is a value, not a mean over all of
/// them. Nothing where the same is to be taken at each value.
void add_by_value(const Bench& bench, const Field& field, const Standings& standings,
                  std::vector<std::string>& sentences) {
  for (const Variable& variable : bench.variables) {
    std::map<std::string, std::set<std::string>>
        values_at;  // by place; it has one value, but if the bench says otherwise
    for (const Cell& cell : bench.cells) values_at[cell.place].insert(cell.values.at(variable.name));
    SaidOf said;
    for (const std::string& value : variable.values) {
      const auto is_of_value = [&](const std::string& place) { return values_at[place].count(value) > 0; };
      std::vector<std::string> taken;
      bool all_beaten = true, any_compared = false;
      for (const std::string& name : field.ran) {
        const Standing& s = standings.at(name);
        const bool compared = std::any_of(s.compared_on.begin(), s.compared_on.end(), is_of_value);
        any_compared |= compared;
        const bool beaten = std::any_of(s.beaten_on.begin(), s.beaten_on.end(), is_of_value);
        all_beaten &= beaten;
        std::size_t cells = 0, lost = 0;
        for (const auto& [place, count] : s.at)
          if (is_of_value(place)) cells += count.cells, lost += count.lost;
        if (compared && !beaten && 2 * lost <= cells && std::none_of(s.untried.begin(), s.untried.end(), is_of_value))
          taken.push_back(name);
      }
      said.add(value, !any_compared    ? "nothing was compared"
                      : !taken.empty() ? "take " + text::enumerate(taken, " or ")
                      : all_beaten     ? "each is beaten by another"
                                       : "none that is not beaten was tried everywhere and of use");
    }
    if (said.all().size() < 2) continue;
    std::vector<std::string> parts;
    for (const auto& [what, values] : said.all())
      parts.push_back((parts.empty() ? "where " + variable.name + " is " : "where it is ") +
                      text::enumerate(values, " or ") + " " + what);
    sentences.push_back(text::enumerate(parts, "; ", "; "));
  }
}

/// Two that are both to be taken and were never set against each other: "take a or b" does not say that they are alike.
void add_never_compared(const Field& field, const std::vector<Pairing>& pairs, std::vector<std::string>& sentences) {
  SaidOf said;
  for (const Pairing& pair : pairs) {
    const auto is_taken = [&](const std::string& name) {
      return std::find(field.unbeaten.begin(), field.unbeaten.end(), name) != field.unbeaten.end();
    };
    if (is_taken(pair.first()) && is_taken(pair.second()) &&
        std::all_of(pair.places.begin(), pair.places.end(),
                    [](const Duel* duel) { return duel->refused.empty() && duel->errors.verdict == Verdict::too_few; }))
      said.add(pair.second(), pair.first());
  }
  for (const auto& [first, others] : said.all())
    sentences.push_back(first + " and " + text::enumerate(others, " or ") +
                        " have nowhere trials enough in common to be compared with each other");
}

void add_choice(const Bench& bench, const Field& field, const std::vector<Pairing>& pairs, const Standings& standings,
                std::vector<std::string>& sentences) {
  const std::size_t places = bench.places().size();
  if (!field.unbeaten.empty()) {
    add_unbeaten(field, standings, sentences);
    add_never_compared(field, pairs, sentences);
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
    add_by_value(bench, field, standings, sentences);
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
      if (duel->refused.empty() || duel->never_ran) continue;
      sentences.push_back(duel->words + (duel->place.empty() ? "" : " (" + duel->place + ")"));
      break;
    }
  }
  return sentences;
}

/// "x forbids by its own test 16 results on noisy that y gives with no NEES to judge them by: more results are no merit
/// there"
void add_untested(const Bench& bench, const Group& group, const Standings& standings,
                  std::vector<std::string>& sentences) {
  SaidOf said;
  for (const std::string& name : group.alternatives) {
    const auto standing = standings.find(name);
    if (standing == standings.end() || standing->second.untested.empty()) continue;
    const Standing& s = standing->second;
    const std::size_t forbidden = s.forbidden.size();
    std::vector<std::string> how;
    for (const auto& [stated, winners] : s.untested)
      how.push_back(
          text::enumerate(winners) + (winners.size() > 1 ? " give" : " gives") +
          (stated == Stated::wrong ? " with covariances that state too little" : " with no NEES to judge them by"));
    const std::vector<std::string> places(s.untested_on.begin(), s.untested_on.end());
    said.add(name, std::to_string(forbidden) + (forbidden == 1 ? " result" : " results") +
                       (bench.places().size() > 1 ? " on " + listed(places) : "") + " that " + text::enumerate(how) +
                       ": more results are no merit there");
  }
  for (const auto& [what, names] : said.all())
    sentences.push_back(text::enumerate(names) + (names.size() > 1 ? " forbid by their" : " forbids by its") +
                        " own test " + (names.size() > 1 ? "each " : "") + what);
}

/// A row without its choice of the group: what else was chosen, and where.
using Elsewhere = std::pair<std::string, std::map<std::string, std::string>>;

Elsewhere elsewhere_of(const Row& row, const std::string& group) {
  Elsewhere rest{row.place, {row.choices.begin(), row.choices.end()}};
  rest.second.erase(group);
  return rest;
}

/// Of those that are not beaten, who states its own errors right and who does not, where all of them were tried alike:
/// a registration that states too much speaks against no adjuster that was not tried with it.
void add_honesty(const Group& group, const Field& field, const Analysis& analysis,
                 std::vector<std::string>& sentences) {
  const std::set<std::string> unbeaten(field.unbeaten.begin(), field.unbeaten.end());
  std::map<Elsewhere, std::set<std::string>> judged;
  const auto chosen = [&](const Row& row) {
    const auto choice = row.choices.find(group.name);
    return choice != row.choices.end() && unbeaten.count(choice->second) > 0 ? choice->second : std::string();
  };
  const auto is_judged = [](const auto& part) { return statistics::honesty(part) != statistics::Honesty::unknown; };
  for (const Row& row : analysis.rows)
    if (const auto& parts = row.summary.calibration; std::any_of(parts.begin(), parts.end(), is_judged))
      judged[elsewhere_of(row, group.name)].insert(chosen(row));
  std::set<std::string> stating;  // who states nothing anywhere is no measure of the others
  for (const auto& [rest, who] : judged) stating.insert(who.begin(), who.end());
  stating.erase("");
  std::vector<std::string> right, wrong;
  for (const std::string& name : field.unbeaten) {
    bool known = false, lies = false;
    for (const Row& row : analysis.rows) {
      if (chosen(row) != name) continue;
      const std::set<std::string>& who = judged[elsewhere_of(row, group.name)];
      if (!std::includes(who.begin(), who.end(), stating.begin(), stating.end())) continue;
      for (const auto& part : row.summary.calibration) {
        const auto honest = statistics::honesty(part);
        known |= honest != statistics::Honesty::unknown;
        lies |= honest == statistics::Honesty::too_much || honest == statistics::Honesty::too_little;
      }
    }
    if (known) (lies ? wrong : right).push_back(name);
  }
  if (right.empty() || wrong.empty()) return;
  sentences.push_back("of their own errors " + text::enumerate(wrong) + (wrong.size() > 1 ? " state" : " states") +
                      " too much or too little (what covariances state says where), " + text::enumerate(right) +
                      (right.size() > 1 ? " do" : " does") + " not");
}

std::string said_of(const Group& group, const std::vector<std::string>& sentences) {
  std::string text = group.name + ":";
  for (std::size_t k = 0; k < sentences.size(); ++k)
    text += " " + (k == 0 ? sentences[k] : begin_sentence(sentences[k], group.alternatives)) + ".";
  return text;
}

std::string choice_of(const Bench& bench, const Group& group, const Analysis& analysis) {
  std::vector<Pairing> pairs = pairings(analysis, group.name);
  std::erase_if(pairs, [](const Pairing& pair) {
    return std::all_of(pair.places.begin(), pair.places.end(), [](const Duel* duel) { return duel->never_ran; });
  });
  Standings standings = standings_of(bench, group, analysis, pairs);
  const Field field = field_of(group, standings);
  std::vector<std::string> sentences;
  if (field.ran.size() < 2 && !field.silent.empty()) {
    sentences.push_back(field.ran.empty() ? "nothing to choose: nothing ran"
                                          : "nothing to choose: only " + field.ran[0] + " ran");
  } else if (!pairs.empty() && std::all_of(pairs.begin(), pairs.end(), all_same)) {
    sentences.push_back("nothing separates " + text::enumerate(field.unbeaten) + ": they gave the same in every trial");
    sentences.push_back("what they do differently does not reach what is measured here");
  } else if (const auto opposed = opposed_in_words(bench, field, pairs); field.any_winner || !opposed.empty()) {
    if (field.any_winner) add_choice(bench, field, pairs, standings, sentences);
    sentences.insert(sentences.end(), opposed.begin(), opposed.end());
    if (!field.any_winner && field.unbeaten.size() > 2)
      sentences.push_back("nothing else separates " + text::enumerate(field.unbeaten));
  } else if (field.unbeaten.size() > 1) {
    add_nothing_separates(bench, field, pairs, sentences);
  }
  const auto refused = refused_in_words(field, pairs);
  sentences.insert(sentences.end(), refused.begin(), refused.end());
  if (!field.unknown.empty() && refused.empty() && field.ran.size() > 1)
    sentences.push_back("of " + text::enumerate(field.unknown) + " nothing can be said: too few trials to compare");
  add_untested(bench, group, standings, sentences);
  add_honesty(group, field, analysis, sentences);
  for (const auto& [places, names] : field.untried.all())
    sentences.push_back(text::enumerate(names) + (names.size() > 1 ? " were" : " was") + " not tried on " + places);
  add_counts("without result: ", field.failing, sentences);
  add_counts(fmt::format("off by more than {:g} mm: ", 1e3 * bench.useless_above()), field.useless, sentences);
  sentences.insert(sentences.end(), field.silent.begin(), field.silent.end());
  if (const double most = bench.none_within(); std::isfinite(most))
    sentences.push_back(fmt::format("in no trial was any of them within {:g} mm", 1e3 * most));
  return said_of(group, sentences);
}

}  // namespace

std::vector<std::string> choices_to_make(const Bench& bench, const Analysis& analysis) {
  std::vector<std::string> sentences;
  for (const Group& group : bench.groups) sentences.push_back(choice_of(bench, group, analysis));
  return sentences;
}

}  // namespace plumbline::bench
