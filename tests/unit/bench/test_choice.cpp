// Which alternative a bench tells people to take.
#include <gmock/gmock.h>

#include <cmath>

#include "show/bench/analysis.hpp"
#include "show/bench/figures.hpp"
#include "show/bench/page.hpp"
#include "show/bench/sentences.hpp"
#include "show/bench/tables.hpp"

namespace plumbline::bench {
namespace test_choice {

using testing::HasSubstr;
using testing::Not;

/// Two registrations of sites without and with many outliers. `wrong`: the error of least squares where there are many
/// [m], which always answers; of 24 trials the robust one answers in `answered`, 1 mm off.
Bench bench_of(double wrong, std::size_t answered) {
  Bench bench;
  bench.tolerances = {0.002, 0.1};
  bench.rope = 0.00005;
  bench.groups = {{"method", {"least squares", "robust"}, {"registration"}, false}};
  for (const char* place : {"clean", "spoilt"})
    for (std::size_t seed = 0; seed < 24; ++seed)
      for (const std::string& name : bench.groups[0].alternatives) {
        const bool spoilt = std::string(place) == "spoilt";
        Cell cell;
        cell.scenario = cell.place = place;
        cell.choices["method"] = name;
        cell.seed = seed;
        cell.status = spoilt && name == "robust" && seed >= answered ? "failed" : "done";
        cell.error = "no agreement";
        const double noise = 1e-6 * static_cast<double>((seed * 7) % 5);
        cell.measures["error"] = cell.measures["worst"] =
            spoilt && name == "least squares" ? wrong + noise : 0.001 + noise;
        bench.cells.push_back(cell);
      }
  return bench;
}

std::string choice(const Bench& bench) { return choices_to_make(bench, analyse(bench)).at(0); }

TEST(Choice, AnAnswerThatIsOffByDecimetresDoesNotWinOverNone) {
  const std::string said = choice(bench_of(0.5, 3));
  EXPECT_THAT(said, Not(HasSubstr("take least squares"))) << said;
  EXPECT_THAT(said, Not(HasSubstr("robust is beaten"))) << said;
  EXPECT_THAT(said, HasSubstr("Off by more than 100 mm: least squares in 24 of 48 cells")) << said;
  for (const Sentence& sentence : verdicts(bench_of(0.5, 3), analyse(bench_of(0.5, 3))))
    EXPECT_FALSE(sentence.winner) << sentence.text;
}

/// A metric such as a bias has a sign, an error has a size: once what was 0.5 m too low won over no answer.
TEST(Choice, TheSignOfAnErrorDecidesNothing) {
  Bench low = bench_of(0.5, 3);
  for (Cell& cell : low.cells)
    if (cell.choices.at("method") == "least squares" && cell.measures.count("error"))
      cell.measures["error"] *= -1, cell.measures["worst"] *= -1;
  EXPECT_EQ(choice(low), choice(bench_of(0.5, 3)));
  const auto of = [](const Bench& bench) { return analyse(bench).rows; };
  const auto rows = of(low), high = of(bench_of(0.5, 3));
  for (size_t k = 0; k < rows.size(); ++k)
    for (size_t t = 0; t < rows[k].summary.failure_rates.size(); ++t)
      EXPECT_EQ(rows[k].summary.failure_rates[t].failed, high[k].summary.failure_rates[t].failed);
}

/// Whoever is best of those that are all of no use is told as that.
TEST(Choice, WhereNobodyComesWithinATolerancePeopleAreTold) {
  Bench bench = bench_of(0.001, 24);
  for (Cell& cell : bench.cells) cell.measures["error"] *= 1000;
  EXPECT_THAT(choice(bench), HasSubstr("In no trial was any of them within 100 mm"));
  EXPECT_THAT(choice(bench_of(0.001, 24)), Not(HasSubstr("In no trial")));
}

TEST(Choice, AnAnswerOfUseWinsOverNone) {
  const std::string said = choice(bench_of(0.001, 3));
  EXPECT_THAT(said, HasSubstr("take least squares, beaten nowhere. robust is beaten on spoilt, for lack of results"));
}

TEST(Choice, WhatIsOfNoUseInMostCellsIsNotTaken) {
  Bench bench = bench_of(0.5, 24);
  for (Cell& cell :
       bench.cells) {  // both wrong, one of them a little less; only one clean trial says what is asked for
    if (cell.seed == 0 && cell.place == "clean") continue;
    cell.status = "done";
    cell.measures["error"] += cell.choices["method"] == "robust" ? 0.3 : 0.6;
  }
  const std::string said = choice(bench);
  EXPECT_THAT(said, Not(HasSubstr("take robust"))) << said;
  EXPECT_THAT(said, HasSubstr("of use in fewer than half of the cells")) << said;
}

TEST(Choice, WhereNoAnswerIsWithinTheTolerancesTheyAreNoYardstick) {
  Bench bench = bench_of(0.001, 3);
  for (Cell& cell : bench.cells) cell.measures["error"] += 5;  // say, pixels
  EXPECT_THAT(choice(bench), HasSubstr("take least squares, beaten nowhere"));
}

/// Of four trials nothing is compared, also where both gave the same in each.
TEST(Choice, OfTooFewTrialsThatAgreeNobodyIsNamed) {
  Bench bench = bench_of(0.001, 24);
  std::erase_if(bench.cells, [](const Cell& cell) { return cell.seed >= 4; });
  const std::string said = choice(bench);
  EXPECT_THAT(said,
              testing::StrEq("method: of least squares and robust nothing can be said: too few trials to compare."));
}

/// Six alternatives on six places, each worse than the one before: what is to be said of many is said in many
/// sentences, and no two of them say the same of somebody else.
TEST(Choice, IsSaidInSentencesThatAPersonWouldSay) {
  Bench bench;
  bench.tolerances = {0.002, 0.1};
  bench.rope = 0.00005;
  bench.groups = {{"solver", {}, {"pose"}, false}};
  for (int a = 0; a < 6; ++a) bench.groups[0].alternatives.push_back("solver number " + std::to_string(a));
  for (int p = 0; p < 6; ++p)
    for (std::size_t seed = 0; seed < 12; ++seed)
      for (int a = 0; a < 6; ++a) {
        Cell cell;
        cell.scenario = cell.place = "a place with a name of many words, number " + std::to_string(p);
        cell.choices["solver"] = bench.groups[0].alternatives[a];
        cell.seed = seed;
        cell.status = a > 4 && seed == 0 && p < a ? "failed" : "done";
        cell.error = "no agreement";
        // Every other place is one where all do the same; the best on the others is the worst on the first.
        const double step = p == 0 ? 5 - a : p % 2 ? a / 2 : 0;
        cell.measures["error"] = cell.measures["worst"] = 0.001 + 0.001 * step + 1e-6 * static_cast<double>(seed % 5);
        bench.cells.push_back(cell);
      }
  const std::string said = choice(bench);
  std::size_t words = 0, longest = 0, sentences = 0;
  for (std::size_t k = 0; k + 1 < said.size(); ++k) {
    words += said[k] == ' ';
    if (said.compare(k, 2, ". ") == 0) ++sentences, words = 0;
    longest = std::max(longest, words);
  }
  EXPECT_LE(longest, 40u) << said;
  EXPECT_GE(sentences, 4u) << said;
  EXPECT_THAT(said, HasSubstr("none is best everywhere. solver number")) << said;
  EXPECT_THAT(said, HasSubstr("nearest, beaten on 1 of 6 places.")) << said;
}

/// One trial of each of `errors` (by alternative, in m; nan: no result) for each seed at each place.
template <typename Error>
Bench trials_of(const std::vector<std::string>& places, std::size_t seeds, const std::vector<std::string>& names,
                const Error& error) {
  Bench bench;
  bench.rope = 0.00005;
  bench.groups = {{"method", names, {}, false}};
  for (std::size_t p = 0; p < places.size(); ++p)
    for (std::size_t seed = 0; seed < seeds; ++seed)
      for (const std::string& name : names) {
        Cell cell;
        cell.scenario = cell.place = places[p];
        cell.choices["method"] = name;
        cell.seed = seed;
        const double found = error(name, p, seed);
        cell.status = std::isfinite(found) ? "done" : "failed";
        cell.measures["error"] = cell.measures["worst"] = found;
        bench.cells.push_back(cell);
      }
  return bench;
}

/// In [-1, 1), the same each time.
double noise(std::size_t a, std::size_t b) { return static_cast<double>((a * 7919 + b * 104729) % 2003) / 1001.5 - 1; }

/// Ten seeds at each of eight places show nothing at any of them, and all together they do.
Bench winner_over_all_places() {
  std::vector<std::string> places;
  for (int p = 0; p < 8; ++p) places.push_back("p" + std::to_string(p));
  Bench bench = trials_of(places, 10, {"plain", "worse"}, [](const std::string& name, std::size_t p, std::size_t seed) {
    return name == "plain" ? 0.001 : 0.0012 + 0.0006 * noise(p + 1, seed + 1);
  });
  for (const std::string& place : places) bench.weights[place] = 1;
  bench.weights_text = "all places weighing alike";
  return bench;
}

/// Once "nothing separates plain and worse", above the verdict that names the better one.
TEST(Choice, AWinnerOverAllPlacesIsOne) {
  const Bench bench = winner_over_all_places();
  const Analysis analysis = analyse(bench);
  for (const Duel& duel : analysis.duels)
    ASSERT_EQ(duel.errors.verdict, duel.overall ? statistics::Verdict::first_better : statistics::Verdict::undecided)
        << duel.place << " " << duel.words;
  EXPECT_THAT(choice(bench), testing::StartsWith("method: take plain, beaten nowhere. worse is beaten over all places, "
                                                 "all places weighing alike, by 0."));
  EXPECT_TRUE(verdicts(bench, analysis).at(0).winner);
  EXPECT_THAT(to_tex(bench, analysis), HasSubstr("take plain, beaten nowhere"));
}

TEST(Choice, WithoutWeightsNothingIsTakenFromAllPlacesTogether) {
  Bench bench = winner_over_all_places();
  bench.weights.clear();
  EXPECT_THAT(choice(bench), HasSubstr("nothing separates plain and worse: no winner at any place"));
}

/// Once "nothing separates" two of which one has a fourth of the errors and the other twice the results.
TEST(Choice, SmallerErrorsAgainstMoreResultsAreSaidInTheirOwnWords) {
  const Bench bench =
      trials_of({"one", "two"}, 40, {"sure", "frail"}, [](const std::string& name, std::size_t p, std::size_t seed) {
        if (name == "sure") return 0.002 + 0.0002 * noise(p, seed);
        return seed % 5 < 2 ? std::nan("") : 0.001 + 0.0002 * noise(p + 5, seed);
      });
  EXPECT_THAT(choice(bench), testing::StartsWith("method: frail has the smaller errors and sure more results on one / "
                                                 "two: which of that counts more is for you to say."));
  EXPECT_THAT(choice(bench), Not(HasSubstr("nothing separates")));
  Bench weighed = bench;
  weighed.weights = {{"one", 1}, {"two", 1}};
  weighed.weights_text = "all places weighing alike";
  EXPECT_THAT(choice(weighed),
              HasSubstr("more results on one / two, and over all places, all places weighing alike: "));
}

/// Once "take a or b" with b without result in most cells.
TEST(Choice, WhatGivesNoResultInMostCellsIsNotTaken) {
  const Bench bench =
      trials_of({"one", "two"}, 30, {"a", "b", "c"}, [](const std::string& name, std::size_t p, std::size_t seed) {
        if (name == "b" && seed % 5 < 3) return std::nan("");
        return (name == "a" ? 0.001 : name == "b" ? 0.0002 : 0.004) * (1 + 0.2 * noise(p, seed));
      });
  EXPECT_THAT(choice(bench), HasSubstr("take a, beaten nowhere. b is beaten nowhere, and of use in fewer than half of "
                                       "the cells. c is beaten"));
  EXPECT_THAT(choice(bench), HasSubstr("b has the smaller errors and a more results on one / two"));
  EXPECT_THAT(choice(bench), Not(HasSubstr("and c more results"))) << "c is no choice";
}

/// Once "take a or c, beaten nowhere" of one that stands at one place of four.
TEST(Choice, WhatWasNotTriedEverywhereIsSecondAndSaysWhere) {
  Bench bench = trials_of({"easy", "h1", "h2", "h3"}, 16, {"a", "b", "c"},
                          [](const std::string& name, std::size_t p, std::size_t seed) {
                            return (name == "b" ? 0.003 : 0.001) * (1 + 0.2 * noise(p + name[0], seed));
                          });
  std::erase_if(bench.cells, [](const Cell& cell) { return cell.choices.at("method") == "c" && cell.place != "easy"; });
  EXPECT_THAT(choice(bench), HasSubstr("take a, beaten nowhere. c is beaten nowhere that it was tried. b is beaten"));
  EXPECT_THAT(choice(bench), HasSubstr("c was not tried on h1 / h2 / h3."));
  std::erase_if(bench.cells, [](const Cell& cell) { return cell.choices.at("method") == "a" && cell.place == "h1"; });
  EXPECT_THAT(choice(bench), HasSubstr("take a or c, beaten nowhere that they were tried."));
}

/// One place for each value of a variable; errors [m] by value and alternative, nan: not tried there with anything that
/// the others were tried with.
Bench bench_by_tags(const std::map<std::string, std::map<std::string, double>>& errors) {
  Bench bench;
  bench.rope = 0.001;
  bench.groups = {{"solver", {}, {"poses"}, false}};
  bench.variables = {{"tags", {}}};
  for (const auto& [name, error] : errors.begin()->second) bench.groups[0].alternatives.push_back(name);
  for (const auto& [value, of] : errors) {
    bench.variables[0].values.push_back(value);
    for (std::size_t seed = 0; seed < 24; ++seed)
      for (const auto& [name, error] : of) {
        Cell cell;
        cell.place = "tags=" + value;
        cell.values["tags"] = value;
        cell.choices["solver"] = name;
        cell.seed = seed;
        cell.status = "done";
        cell.measures["error"] = error + 1e-5 * static_cast<double>((seed * 7 + name.size() * seed) % 5);
        bench.cells.push_back(cell);
      }
  }
  return bench;
}

TEST(Choice, WhereNoneIsBestEverywhereEachValueHasItsOwn) {
  const std::string said = choice(bench_by_tags({{"1", {{"ippe", 0.1}, {"sqpnp", 0.3}, {"upnp", 0.3}}},
                                                 {"2", {{"ippe", 0.3}, {"sqpnp", 0.1}, {"upnp", 0.3}}},
                                                 {"4", {{"ippe", 0.3}, {"sqpnp", 0.05}, {"upnp", 0.05}}}}));
  EXPECT_THAT(said, HasSubstr("none is best everywhere")) << said;
  EXPECT_THAT(said, HasSubstr("Where tags is 1 take ippe; where it is 2 take sqpnp; where it is 4 take sqpnp or upnp."))
      << said;
  Bench failing = bench_by_tags({{"1", {{"epnp", 0.3}, {"ippe", 0.1}}},
                                 {"2", {{"epnp", 0.3}, {"ippe", 0.1}}},
                                 {"4", {{"epnp", 0.1}, {"ippe", 0.3}}}});
  for (Cell& cell : failing.cells)
    if (cell.choices.at("solver") == "epnp" && cell.values.at("tags") != "4")
      cell.status = "failed", cell.measures.clear();
  EXPECT_THAT(choice(failing), HasSubstr("Where tags is 1 or 2 take ippe; where it is 4 take epnp."))
      << "of use where it is tried with four";
  EXPECT_THAT(choice(bench_by_tags({{"1", {{"ippe", 0.1}, {"sqpnp", 0.3}}}, {"2", {{"ippe", 0.1}, {"sqpnp", 0.3}}}})),
              Not(HasSubstr("Where tags")));
}

/// Once "where it is 8 take a or b": of three trials nothing is compared, so there nothing beats anything.
TEST(Choice, AtAValueWhereNothingWasComparedNothingIsToBeTaken) {
  Bench bench = bench_by_tags(
      {{"1", {{"a", 0.1}, {"b", 0.3}}}, {"2", {{"a", 0.3}, {"b", 0.1}}}, {"8", {{"a", 0.1}, {"b", 0.1}}}});
  std::erase_if(bench.cells, [](const Cell& cell) { return cell.values.at("tags") == "8" && cell.seed > 2; });
  EXPECT_THAT(choice(bench),
              HasSubstr("Where tags is 1 take a; where it is 2 take b; where it is 8 nothing was compared."));
}

TEST(Choice, TwoThatAreTakenAndWereNeverComparedAreSaidToBe) {
  Bench bench = bench_by_tags({{"1", {{"ceres", 0.1}, {"colmap", 0.1}, {"schur", 0.3}}}});
  bench.groups.push_back({"fusion", {"(5)", "(6)"}, {"fusion"}, false});
  std::vector<Cell> cells;  // colmap knows (6) alone, ceres (5) alone, schur both
  for (Cell cell : bench.cells)
    for (const char* fusion : {"(5)", "(6)"}) {
      const std::string& name = cell.choices.at("solver");
      if ((name == "colmap" && fusion == std::string("(5)")) || (name == "ceres" && fusion == std::string("(6)")))
        continue;
      cell.choices["fusion"] = fusion;
      cells.push_back(cell);
    }
  bench.cells = cells;
  const std::string said = choice(bench);
  EXPECT_THAT(said, HasSubstr("take ceres or colmap, beaten nowhere")) << said;
  EXPECT_THAT(said, HasSubstr("have nowhere trials enough in common to be compared with each other")) << said;
}

/// Once "of their own errors schur states too much, joint does not", of rows in which joint was not tried.
TEST(Choice, WhatWasNotTriedWithAllSpeaksAgainstNone) {
  Bench bench = bench_by_tags({{"1", {{"joint", 0.1}, {"schur", 0.1}, {"slow", 0.3}}}});
  bench.groups.push_back({"fusion", {"(5)", "(7)"}, {"fusion"}, false});
  std::vector<Cell> cells;
  for (Cell cell : bench.cells)
    for (const std::string fusion : {"(5)", "(7)"}) {
      const std::string name = cell.choices.at("solver");
      if (name == "joint" && fusion == "(7)") continue;
      cell.choices["fusion"] = fusion;
      cell.measures["predicted"] = (fusion == "(7)" ? 3 : 1) * cell.measures.at("error");
      cells.push_back(cell);
    }
  bench.cells = cells;
  bench.metrics = {{"error", "errors.rmse_z"}, {"predicted", "errors.predicted_rmse_z"}};
  EXPECT_THAT(choice(bench), Not(HasSubstr("of their own errors"))) << choice(bench);
  for (Cell& cell : bench.cells)
    if (cell.choices.at("solver") == "schur" && cell.choices.at("fusion") == "(5)")
      cell.measures["predicted"] = 3 * cell.measures.at("error");
  EXPECT_THAT(choice(bench), HasSubstr("f their own errors schur states too much or too little")) << choice(bench);
}

/// Once "take Gut or X. Gut is beaten by 6.76 mm.", of gut.
TEST(Choice, NamesStayAsTheyAreWritten) {
  const Bench bench = trials_of({""}, 12, {"Gut", "gut"}, [](const std::string& name, std::size_t, std::size_t seed) {
    return (name == "gut" ? 0.006 : 0.001) * (1 + 0.2 * noise(name[0], seed));
  });
  EXPECT_THAT(choice(bench), testing::StartsWith("method: take Gut, beaten nowhere. gut is beaten by "));
}

/// Once "no winner can rest on them" beside two winners: of two that always gave nought, and one that did not.
TEST(Choice, SeedsThatAreOneTrialForSomeAreSoForThose) {
  Bench bench =
      trials_of({""}, 10, {"zero", "null", "one"}, [](const std::string& name, std::size_t, std::size_t seed) {
        return name == "one" ? 0.001 * (1.5 + noise(3, seed)) : 0.0;
      });
  EXPECT_THAT(analyse(bench).unused,
              testing::Contains("all 10 seeds gave the same with null and with zero: they are one trial, so no "
                                "interval and no winner between these two can rest on them"));
  std::erase_if(bench.cells, [](const Cell& cell) { return cell.choices.at("method") == "one"; });
  EXPECT_THAT(analyse(bench).unused, testing::Contains(HasSubstr("no winner can rest on")));
}

/// Once in none of the files that a bench leaves.
TEST(Tables, WhatTheCommandLineSetForAllCellsIsInEveryFile) {
  Bench bench = bench_of(0.001, 24);
  bench.title = "planted";
  bench.overrides = {"private=0"};
  const Analysis analysis = analyse(bench);
  for (const std::string& text :
       {to_html(bench, analysis), to_markdown(bench, analysis), to_csv(bench), to_tex(bench, analysis),
        to_svg(figure(bench, analysis), Svg::file), to_pdf(figure(bench, analysis))})
    EXPECT_THAT(text, HasSubstr("all with private=0 of the command line"));
  EXPECT_THAT(to_json(bench, analysis), HasSubstr("\"overrides\": [\n  \"private=0\"\n ]"));
}

TEST(Tables, NoTwoColumnsHaveOneName) {
  Bench bench = bench_of(0.001, 24);
  bench.variables = {{"method", {"x"}}};
  bench.groups.push_back({"seed", {"p"}, {}, false});
  for (Cell& cell : bench.cells) cell.values["method"] = "x", cell.choices["seed"] = "p";
  EXPECT_THAT(to_csv(bench),
              testing::StartsWith("place,method,alternative of method,alternative of seed,seed,status,"));
}

/// Once \bench{a/b/x-1/rmse} was that of x_1.
TEST(Tables, ANameThatTexCanTakeKeepsItselfAndTwoThingsShareNone) {
  const Bench bench =
      trials_of({"a", "a/b"}, 8, {"x_1", "x-1", "b/x-1"}, [](const std::string& name, std::size_t, std::size_t seed) {
        return (name == "x-1" ? 0.003 : 0.001) * (1 + 0.01 * noise(1, seed));
      });
  const std::string tex = to_tex(bench, analyse(bench));
  EXPECT_THAT(tex, HasSubstr("% x_1 is written x-1-2\n"));
  EXPECT_THAT(tex, HasSubstr("csname bench@a/x-1/rmse\\endcsname{3.0"));
  EXPECT_THAT(tex, HasSubstr("csname bench@a/x-1-2/rmse\\endcsname{1.0"));
  EXPECT_THAT(tex, Not(HasSubstr("csname bench@a/b/x-1/rmse\\"))) << "of place a/b, or of b/x-1 at a?";
}

TEST(Tables, TheParagraphOfAPaperEndsItsSentences) {
  const Bench bench = bench_of(0.001, 24);
  EXPECT_THAT(to_tex(bench, analyse(bench)), HasSubstr("not run yet. method: "));
}

/// evaluate.cost counts what an alternative rejected, too: 3.78e6 to 4.23e6 in a table reads as a solver that diverged.
TEST(Choice, ACostThatGoesUpIsToldInWordsWhereverItStands) {
  Bench bench = bench_of(0.001, 24);
  for (Cell& cell : bench.cells) cell.measures["start_cost"] = 3.784e6, cell.measures["final_cost"] = 2e6;
  for (const auto& text : {to_markdown(bench, analyse(bench)), to_html(bench, analyse(bench))})
    EXPECT_THAT(text, Not(HasSubstr("Costs that go up"))) << "none does";
  for (Cell& cell : bench.cells)
    if (cell.place == "spoilt" && cell.choices["method"] == "robust") cell.measures["final_cost"] = 4.231e6;
  const Analysis analysis = analyse(bench);
  const std::string words =
      "spoilt, robust: the cost of all observations went up in 24 of 24 trials (the first from 3.784e+06 to "
      "4.231e+06): what was minimised leaves some of them out or damps them, or the solver diverged";
  EXPECT_THAT(analysis.rising, testing::ElementsAre(words));
  EXPECT_THAT(to_markdown(bench, analysis), HasSubstr("\n## Costs that go up\n\n- " + words + ".\n"));
  EXPECT_THAT(to_html(bench, analysis), HasSubstr("<summary>Costs that go up</summary>"));
  EXPECT_THAT(to_html(bench, analysis), HasSubstr("<li class=\"bad\">" + words + "</li>"));
  EXPECT_THAT(to_json(bench, analysis), HasSubstr("\"rising_costs\": [\n  \"" + words + "\"\n ]"));
}

/// Rounding is no rise, and a trial that failed has no cost.
TEST(Choice, ACostThatStaysIsNotSaidToRise) {
  Bench bench = bench_of(0.001, 20);
  for (Cell& cell : bench.cells) {
    cell.measures["start_cost"] = 100;
    cell.measures["final_cost"] = cell.status == "done" ? 100 * (1 + 1e-12) : 200;
  }
  EXPECT_THAT(analyse(bench).rising, testing::IsEmpty());
}

/// Rows are told apart by what was chosen, not by how it reads.
TEST(Rows, NamesThatReadAlikeAreRowsOfTheirOwn) {
  Bench bench;
  bench.groups = {{"first", {"a", "a · b"}, {}, false}, {"second", {"b · c", "c"}, {}, false}};
  for (const auto& [first, second] : {std::pair<std::string, std::string>{"a", "b · c"}, {"a · b", "c"}})
    for (std::size_t seed = 0; seed < 8; ++seed) {
      Cell cell;
      cell.choices = {{"first", first}, {"second", second}};
      cell.seed = seed, cell.status = "done";
      cell.measures["error"] = first == "a" ? 0.001 + 1e-6 * static_cast<double>(seed) : 0.002;
      bench.cells.push_back(cell);
    }
  const Analysis found = analyse(bench);
  ASSERT_EQ(found.rows.size(), 2u);
  EXPECT_EQ(found.rows[0].summary.trials, 8u);
}

/// A mean over the others would be one of other trials: it is not there, and that is said.
TEST(Rows, AMeasureThatSomeTrialsLackIsNamed) {
  Bench bench = bench_of(0.001, 24);
  bench.metrics = {{"error", "errors.rmse_z"}, {"predicted", "errors.predicted_rmse_z"}};
  for (Cell& cell : bench.cells)
    if (cell.choices["method"] == "robust") cell.measures["predicted"] = cell.seed % 2 == 0 ? 0.001 : std::nan("");
  const Analysis found = analyse(bench);
  EXPECT_THAT(
      found.unused,
      testing::Contains("measure predicted (errors.predicted_rmse_z) has no value in some trials of 2 rows (the "
                        "first: clean, robust), which therefore have none"));
}

}  // namespace test_choice
}  // namespace plumbline::bench
