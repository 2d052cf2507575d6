// All that bench.summary writes of a small bench, line by line: numbers, words, drawings and their order
// (pages/NAME.txt). What they have to be is recomputed in the other tests; here it is held.
#include <gtest/gtest.h>

#include "geometry/random.hpp"
#include "record.hpp"
#include "show/bench/figures.hpp"
#include "show/bench/page.hpp"
#include "show/bench/sentences.hpp"
#include "show/bench/tables.hpp"

namespace plumbline::bench {
namespace test_pages {

/// Two scenarios with two shares of outliers each; two adjusters, of which one is worse with outliers and slower, and
/// two detectors. Some cells failed, one has not run, one alternative was not tried.
Bench small_bench() {
  Bench bench;
  bench.title = "Adjusters & detectors", bench.file = "bench.yaml", bench.error_metric = "errors.rmse_z";
  bench.metrics = {{"error", "errors.rmse_z"}, {"worst", "errors.max_abs_z"}, {"final_cost", "cost.final"}};
  bench.rope = 0.0001, bench.tolerances = {0.002, 0.005, 0.008}, bench.scenarios = {"single floor", "full height"};
  bench.looks = {8, 16}, bench.weights_text = "all places weighing alike";
  bench.variables = {{"outliers", {"0", "0.1", "0.2"}}};
  bench.groups = {{"adjuster", {"adjust.schur", "adjust.ceres"}, {"block"}, false},
                  {"detector", {"detect.aruco", "detect.tag_pyramid"}, {"tags"}, false}};
  bench.excluded = {{"detect.aruco with 0.2", "no tags of its family", 4}};
  bench.machine = {"2 processors, 8 GiB"};
  for (const std::string& scenario : bench.scenarios)
    for (const std::string& outliers : bench.variables[0].values) {
      const std::string place = scenario + ", outliers=" + outliers;
      bench.weights[place] = scenario == "full height" ? 2 : 1;
      for (const std::string& adjuster : bench.groups[0].alternatives)
        for (const std::string& detector : bench.groups[1].alternatives)
          for (std::uint64_t seed = 1; seed <= 16; ++seed) {
            Random random(seed, scenario + outliers);
            Cell cell;
            cell.scenario = scenario, cell.place = place, cell.values = {{"outliers", outliers}};
            cell.choices = {{"adjuster", adjuster}, {"detector", detector}}, cell.seed = seed, cell.status = "done";
            const bool worse = adjuster == "adjust.ceres" && outliers != "0";
            const double error =
                (worse ? 2.5 : 1) * (0.001 + 0.0003 * random.uniform()) * (detector == "detect.aruco" ? 1.001 : 1);
            cell.measures = {{"error", error},      {"worst", 1.3 * error}, {"bias", 0.1 * error},
                             {"predicted", 0.0011}, {"bound", 0.001},       {"nees", 8 + random.normal()},
                             {"freedom", 8},        {"start_cost", 100},    {"final_cost", worse ? 101 : 10 * error}};
            cell.modes["scale"] = {{"found", 1e-4 * random.normal()}, {"predicted", 1e-4}, {"freedom", 1}};
            cell.modes["scale"]["nees"] = std::pow(cell.modes["scale"]["found"] / (worse ? 2e-5 : 1e-4), 2);
            cell.inputs = {{"block", place}, {"tags", place}};
            cell.seconds = {{"block", adjuster == "adjust.ceres" ? 2.0 + 0.1 * random.uniform() : 0.5},
                            {"tags", 0.25},
                            {"errors", 0.01}};
            if (worse && seed % 4 == 0) cell.status = "failed", cell.error = "no agreement", cell.measures.clear();
            if (seed == 16 && outliers == "0.1" && detector == "detect.aruco") cell.status = "missing";
            bench.cells.push_back(cell);
          }
    }
  return bench;
}

void expect_file(const std::string& name, const std::string& text) {
  plumbline::test::expect_recorded("unit/bench/pages/" + name + ".txt", plumbline::test::with_few_digits(text));
}

TEST(BenchPages, AllThatIsWrittenOfASmallBench) {
  const Bench bench = small_bench();
  const Analysis analysis = analyse(bench);
  expect_file("csv", to_csv(bench).substr(0, 3000));
  expect_file("json", to_json(bench, analysis));
  expect_file("markdown", to_markdown(bench, analysis));
  expect_file("tex", to_tex(bench, analysis));
  expect_file("svg", to_svg(figure(bench, analysis), Svg::file));
  expect_file("html", plumbline::test::elements_of(to_html(bench, analysis)));
  const std::string pdf = to_pdf(figure(bench, analysis));
  EXPECT_EQ(pdf.rfind("%PDF-1.4", 0), 0u);
  expect_file("pdf", pdf);
}

/// One alternative by itself, where above two always share a sentence.
TEST(BenchPages, AnAlternativeThatAloneStatesTooLittleIsNamed) {
  Bench bench = small_bench();
  for (Cell& cell : bench.cells)
    if (cell.choices["detector"] == "detect.aruco") cell.modes.clear(), cell.measures.erase("predicted");
  const auto sentences = calibration_verdicts(analyse(bench));
  ASSERT_EQ(sentences.size(), 5u) << "of four places, and how many rows are right";
  EXPECT_EQ(sentences[0].rfind("single floor, outliers=0.1: adjust.ceres · detect.tag_pyramid stated 2.6 times too", 0),
            0u)
      << sentences[0];
}

}  // namespace test_pages
}  // namespace plumbline::bench
