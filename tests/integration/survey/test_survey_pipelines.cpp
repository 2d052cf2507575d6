// The survey pipelines from outside: damaged files, encodings, a plan, two epochs.
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>
#include <sstream>

#include "geometry/random.hpp"
#include "program.hpp"
#include "simulated_network.hpp"
#include "survey/files/gsi.hpp"
#include "survey/files/survey_csv.hpp"
#include "test_paths.hpp"

namespace plumbline::test {
namespace test_survey_pipelines {

namespace fs = std::filesystem;
using Json = nlohmann::json;

std::string pipeline(const std::string& name) {
  return (fs::path(plumbline::test::source_dir()) / "pipelines" / (name + ".yaml")).string();
}

/// A job as the instrument writes it, with readings rounded to its last digit.
std::string job(std::uint64_t seed = 3) {
  survey::test::SimulationSettings settings;
  settings.coordinates = settings.sigmas = false;
  return survey::write_gsi(survey::test::simulate(settings, seed).survey, {});
}

/// The line with the n-th sighting cut off within a word, somewhat behind its middle.
std::string cut(std::string text, int sighting, int& line) {
  size_t at = 0;
  line = 0;
  for (int seen = 0;; ++line) {
    const size_t end = text.find('\n', at);
    if (text.substr(at, end - at).find(" 31") != std::string::npos && ++seen == sighting) {
      const size_t kept = (end - at) * 5 / 8;
      text.erase(at + kept, end - at - kept);
      ++line;
      return text;
    }
    at = end + 1;
  }
}

TEST(SurveyPipelines, AGsiLineCutInHalfStopsTheAdjustment) {
  const Program plumbline;
  int line = 0;
  plumbline.write("job.gsi", cut(job(), 5, line));
  Answer answer = plumbline({"run", pipeline("survey_network"), "file=job.gsi", "--out", "out"});
  EXPECT_EQ(answer.code, 1);
  EXPECT_TRUE(contains(answer.err, "job.gsi:" + std::to_string(line) + ":")) << answer.err;
  EXPECT_TRUE(contains(answer.err, "expected")) << answer.err;
  EXPECT_TRUE(contains(answer.err, "strict=false")) << answer.err;
  EXPECT_FALSE(fs::exists(plumbline.work() / "out/network.json"));
  EXPECT_FALSE(fs::exists(plumbline.work() / "out/network.html"));
  answer = plumbline({"run", pipeline("survey_network"), "file=job.gsi", "strict=false", "--out", "out"});
  EXPECT_EQ(answer.code, 0) << answer.err;
  EXPECT_TRUE(contains(answer.err, "job.gsi:" + std::to_string(line) + ":")) << answer.err;
  EXPECT_TRUE(fs::exists(plumbline.work() / "out/network.json"));
}

TEST(SurveyPipelines, ReadSurveyListsWhatItSkipped) {
  const Program plumbline;
  int line = 0;
  plumbline.write("whole.gsi", job());
  plumbline.write("job.gsi", cut(job(), 5, line));
  ASSERT_EQ(plumbline({"run", pipeline("read_survey"), "file=whole.gsi", "--out", "whole"}).code, 0);
  Answer answer = plumbline({"run", pipeline("read_survey"), "file=job.gsi", "--out", "out"});
  EXPECT_EQ(answer.code, 0) << answer.err;
  const Json whole = Json::parse(read_file(plumbline.work() / "whole/observations.json"));
  const Json read = Json::parse(read_file(plumbline.work() / "out/observations.json"));
  EXPECT_FALSE(whole.contains("skipped") && !whole["skipped"].empty());
  ASSERT_EQ(read["skipped"].size(), 1u);
  const Json skipped = read["skipped"][0];
  EXPECT_EQ(skipped["file"], "job.gsi");
  EXPECT_EQ(skipped["line"], line);
  EXPECT_GT(skipped["column"], 0);
  EXPECT_NE(skipped["found"], "");
  EXPECT_NE(skipped["expected"], "");
  EXPECT_LT(read["observations"].size(), whole["observations"].size());
  EXPECT_GE(read["observations"].size(), whole["observations"].size() - 3) << "only the damaged sighting is lost";
  answer = plumbline({"run", pipeline("read_survey"), "file=job.gsi", "strict=true", "--out", "strict"});
  EXPECT_EQ(answer.code, 1);
  EXPECT_FALSE(fs::exists(plumbline.work() / "strict/observations.json"));
}

std::string utf16(const std::string& ascii) {
  std::string bytes = "\xFF\xFE";
  for (char c : ascii) (bytes += c) += '\0';
  return bytes;
}

std::string replaced(std::string text, char from, char to) {
  std::replace(text.begin(), text.end(), from, to);
  return text;
}

TEST(SurveyPipelines, EncodingsAndDecimalCommasReadTheSame) {
  const Program plumbline;
  const std::string table =
      "station,target,hz [gon],v [gon],sd [m]\n"
      "S1,T\xC3\xBCr 1,0.0000,98.1234,12.3456\nS1,P2,33.1200,95.5000,14.2000\nS1,P3,66.0400,91.2500,15.0010\n";
  const std::string windows = std::string(table).replace(table.find("\xC3\xBC"), 2, "\xFC");
  plumbline.write("utf8.csv", table);
  plumbline.write("windows.csv", windows);
  plumbline.write("excel.csv", replaced(replaced(windows, ',', ';'), '.', ','));
  std::string wide;
  wide = utf16(windows);  // U+00FC is FC 00
  plumbline.write("utf16.csv", wide);
  Json first;
  for (const std::string name : {"utf8", "windows", "excel", "utf16"}) {
    const Answer answer =
        plumbline({"run", pipeline("read_survey"), "file=" + name + ".csv", "strict=true", "--out", name});
    ASSERT_EQ(answer.code, 0) << name << ": " << answer.err;
    Json read = Json::parse(read_file(plumbline.work() / name / "observations.json"))["observations"];
    for (Json& o : read) o.erase("file");
    EXPECT_EQ(read.size(), 9u) << name;
    EXPECT_EQ(read[0]["to"], "T\xC3\xBCr 1") << name;
    if (first.is_null()) first = read;
    EXPECT_EQ(read, first) << name;
  }
}

TEST(SurveyPipelines, APlanGivesRulesRemediesAndAPage) {
  const Program plumbline;
  std::string layout = "kind,id,east_m,north_m,height_m,floor,column,facing_azimuth_deg,sees\n";
  for (int floor = 1; floor <= 2; ++floor)
    for (int row = 1; row <= 2; ++row)
      for (int column = 1; column <= 3; ++column)
        layout += "marker,F" + std::to_string(floor) + "C" + std::to_string(column) + "R" + std::to_string(row) + "," +
                  std::to_string(2 * column) + ",0," + std::to_string(4 * floor - 4 + 2 * row) + "," +
                  std::to_string(floor) + "," + std::to_string(column) + ",180,\n";
  layout += "set_up,S1,0,-12,1.6,,,,\nset_up,S2,8,-13,1.6,,,,F1* F2C1* F2C2*\n";
  plumbline.write("layout.csv", layout);
  const Answer answer = plumbline({"run", pipeline("plan_survey"), "file=layout.csv", "--out", "out"});
  ASSERT_EQ(answer.code, 0) << answer.err;
  EXPECT_TRUE(contains(answer.out, "determined, 1 of ")) << answer.out;
  const Json plan = Json::parse(read_file(plumbline.work() / "out/plan.json"));
  bool told = false;
  for (const Json& rule : plan["rules"]) told |= rule["name"] == "set-ups per marker" && !rule["holds"];
  EXPECT_TRUE(told) << plan["rules"].dump(1);
  ASSERT_FALSE(plan["remedies"].empty());
  EXPECT_EQ(plan["remedies"][0]["text"], "sight F2C3R1, F2C3R2 also from S2");
  const std::string page = read_file(plumbline.work() / "out/plan.html");
  for (const char* part : {"1\xC2\xA0rule is broken.", "✗ violated", "sight F2C3R1, F2C3R2 also from S2", "<ellipse"})
    EXPECT_TRUE(contains(page, part)) << part;
}

/// It ended with 0, and only a warning above the list of files said that nothing is predicted.
TEST(SurveyPipelines, APlanThatIsNotDeterminedIsNotToBeUsed) {
  const Program plumbline;
  const Answer answer = plumbline({"run", pipeline("plan_survey"), "--out", "out",
                                   "file=" + std::string(source_dir()) + "/docs/examples/survey_plan.csv"});
  EXPECT_EQ(answer.code, 3) << answer.err;
  EXPECT_TRUE(contains(answer.out, "NOT DETERMINED: rank defect")) << answer.out;
  EXPECT_TRUE(contains(answer.err, "NOT TO BE USED")) << answer.err;
  EXPECT_TRUE(std::filesystem::exists(plumbline.work() / "out/plan.html"));
}

TEST(SurveyPipelines, TwoFilesAreComparedAsEpochs) {
  const Program plumbline;
  plumbline.write("before.gsi", job(11));
  plumbline.write("after.gsi", job(12));
  const Answer answer = plumbline({"run", pipeline("compare_epochs"), "before=before.gsi", "after=after.gsi",
                                   "profile=total_station_5arcsec", "--out", "out"});
  ASSERT_EQ(answer.code, 0) << answer.err;
  const Json json = Json::parse(read_file(plumbline.work() / "out/movements.json"));
  EXPECT_EQ(json["points"].size(), 12u);
  EXPECT_EQ(json["rank"], 3 * 12 - 4);
  EXPECT_EQ(json["congruent"], true);
  EXPECT_TRUE(contains(read_file(plumbline.work() / "out/movements.html"), "No point has moved significantly."));
}

TEST(SurveyPipelines, ThreeFilesAreASeries) {
  const Program plumbline;
  for (const int seed : {11, 12, 13}) plumbline.write("e" + std::to_string(seed) + ".gsi", job(seed));
  plumbline.write("campaign.yaml", "plumbline_campaign: 1\nsurvey: [e11.gsi, e12.gsi, e13.gsi]\n");
  const Answer answer = plumbline({"run", pipeline("epoch_series"), "folder=.", "profile=total_station_5arcsec",
                                   "movements.with.days=[0, 30, 60]", "alarm_level=0.05", "--out", "out"});
  ASSERT_EQ(answer.code, 0) << answer.err;
  const Json json = Json::parse(read_file(plumbline.work() / "out/series.json"));
  EXPECT_EQ(json["points"].size(), 12u) << "free stations stand elsewhere every time";
  EXPECT_EQ(json["epochs"].size(), 3u);
  EXPECT_EQ(json["epochs"][2]["time"], 60);
  EXPECT_EQ(json["points"][0]["movements"].size(), 2u);
  const std::string page = read_file(plumbline.work() / "out/series.html");
  EXPECT_TRUE(contains(page, "No point moves, and none has moved, beyond chance.")) << page.substr(0, 2000);
  EXPECT_TRUE(contains(page, "<svg"));
  EXPECT_TRUE(contains(page, "<section id=\"point-")) << "a place of its own for each, and a sheet where it is printed";
  EXPECT_FALSE(contains(page, ">alarm level</text>")) << "50 mm would flatten charts of a millimetre";
  const Answer near = plumbline({"run", pipeline("epoch_series"), "folder=.", "profile=total_station_5arcsec",
                                 "movements.with.days=[0, 30, 60]", "alarm_level=0.002", "--out", "near"});
  ASSERT_EQ(near.code, 0) << near.err;
  EXPECT_TRUE(contains(read_file(plumbline.work() / "near/series.html"), ">alarm level</text>"));
}

/// A forgotten epoch was "No point moves", with exit code 0.
TEST(SurveyPipelines, AnEpochThatNothingNamesEndsTheSeries) {
  const Program plumbline;
  for (const int seed : {11, 12, 13}) plumbline.write("e" + std::to_string(seed) + ".gsi", job(seed));
  plumbline.write("campaign.yaml", "plumbline_campaign: 1\nsurvey: [e11.gsi, e12.gsi]\nunsued: [e13.gsi]\n");
  const Answer answer = plumbline({"run", pipeline("epoch_series"), "folder=.", "profile=total_station_5arcsec",
                                   "movements.with.days=[0, 30]", "--out", "out"});
  EXPECT_EQ(answer.code, 1);
  EXPECT_TRUE(contains(answer.err, "1 survey file (e13.gsi)")) << answer.err;
  EXPECT_TRUE(contains(answer.err, "unknown key 'unsued'")) << answer.err;
}

/// They were taken by their names: april, march, may, and the days given were those of other files, without a word.
TEST(SurveyPipelines, EpochsAreInTheOrderInWhichTheyAreNamed) {
  const Program plumbline;
  for (const auto& [name, seed] : {std::pair("march", 11), {"april", 12}, {"may", 13}})
    plumbline.write(std::string(name) + ".gsi", job(seed));
  plumbline.write("campaign.yaml", "plumbline_campaign: 1\nsurvey: [march.gsi, april.gsi, may.gsi]\n");
  const Answer answer = plumbline({"run", pipeline("epoch_series"), "folder=.", "profile=total_station_5arcsec",
                                   "movements.with.days=[0, 31, 61]", "--out", "out"});
  ASSERT_EQ(answer.code, 0) << answer.err;
  const Json json = Json::parse(read_file(plumbline.work() / "out/series.json"));
  EXPECT_EQ(json["epochs"][0]["name"], "march.gsi");
  EXPECT_EQ(json["epochs"][1]["name"], "april.gsi");
  EXPECT_TRUE(contains(answer.out, "In their order, with their days: march.gsi 0, april.gsi 31, may.gsi 61."))
      << answer.out;
}

/// docs/examples/before.csv as directions and horizontal distances, with circles that were set up `turn` gon on and
/// errors of their own.
std::string in_plan(double turn, std::uint64_t seed) {
  Random random(seed, "plan");
  std::istringstream stream(read_file(fs::path(source_dir()) / "docs/examples/before.csv"));
  std::string text = "station,target,hz [gon],hd [m]\n", line;
  std::getline(stream, line);
  while (std::getline(stream, line)) {
    std::istringstream cells(line);
    std::vector<std::string> cell;
    for (std::string c; std::getline(cells, c, ',');) cell.push_back(c);
    const double v = std::stod(cell.at(3)) * std::numbers::pi / 200;
    text += cell[0] + "," + cell[1] + "," +
            std::to_string(std::fmod(std::stod(cell[2]) + turn + random.normal(0.0005), 400)) + "," +
            std::to_string(std::stod(cell.at(4)) * std::sin(v) + random.normal(0.0005)) + "\n";
  }
  return text;
}

/// A network in plan is free to turn, though its rank defect is three as that of three shifts.
TEST(SurveyPipelines, ASeriesInPlanDoesNotMoveByTurning) {
  const Program plumbline;
  for (int k = 1; k <= 3; ++k)
    plumbline.write("e" + std::to_string(k) + ".csv", in_plan(70 * k, static_cast<std::uint64_t>(k)));
  plumbline.write("campaign.yaml", "plumbline_campaign: 1\nsurvey: [e1.csv, e2.csv, e3.csv]\n");
  for (const char* stable : {"[]", "[F01-C01-R1, F03-C04-R2, F01-C04-R1]"}) {
    const Answer answer = plumbline({"run", pipeline("epoch_series"), "folder=.", "profile=total_station_2arcsec",
                                     std::string("movements.with.stable=") + stable, "--out", "out"});
    ASSERT_EQ(answer.code, 0) << stable << "\n" << answer.err;
    const Json json = Json::parse(read_file(plumbline.work() / "out/series.json"));
    EXPECT_EQ(json["points"].size(), 24u);
    for (const Json& p : json["points"]) EXPECT_FALSE(p["moves"].get<bool>()) << stable << " " << p["id"];
  }
}

/// docs/examples/before.csv with the distances of one set-up in feet.
std::string with_feet(const std::string& set_up) {
  std::istringstream stream(read_file(fs::path(source_dir()) / "docs/examples/before.csv"));
  std::string text;
  for (std::string line; std::getline(stream, line);) {
    if (line.rfind(set_up + ",", 0) == 0) {
      const size_t comma = line.rfind(',');
      line = line.substr(0, comma + 1) + std::to_string(std::stod(line.substr(comma + 1)) / 0.3048);
    }
    text += line + "\n";
  }
  return text;
}

TEST(SurveyPipelines, ASetUpInFeetIsNoResultUntilItIsMended) {
  const Program plumbline;
  plumbline.write("job.csv", with_feet("S2"));
  Answer answer = plumbline({"run", pipeline("survey_network"), "file=job.csv", "--out", "out"});
  EXPECT_NE(answer.code, 0);
  EXPECT_TRUE(contains(answer.err, "set-up S2 are 3.2808 times")) << answer.err;
  if (answer.code == 3) {
    EXPECT_TRUE(contains(answer.out, "NOT A RESULT")) << answer.out;
    EXPECT_TRUE(contains(read_file(plumbline.work() / "out/network.html"), "NOT A RESULT"));
  }
  answer = plumbline(
      {"run", pipeline("survey_network"), "file=job.csv", "network.with.remove_blunders=true", "--out", "mended"});
  EXPECT_EQ(answer.code, 0) << answer.err;
  EXPECT_TRUE(contains(answer.out, "Sound: ")) << answer.out;
  EXPECT_TRUE(contains(answer.out, "they were converted")) << answer.out;
  EXPECT_FALSE(contains(read_file(plumbline.work() / "mended/network.html"), "NOT A RESULT"));
}

/// relative.csv has its figures from the same covariance by another way.
TEST(SurveyPipelines, ShowTellsAnyPairRelativeToEachOther) {
  const Program plumbline;
  plumbline.write("job.csv", read_file(fs::path(source_dir()) / "docs/examples/before.csv"));
  ASSERT_EQ(plumbline({"run", pipeline("survey_network"), "file=job.csv", "profile=total_station_1arcsec",
                       "tables.with.pairs=[F01-C01-R1 F03-C04-R2]", "--out", "out"})
                .code,
            0);
  EXPECT_TRUE(contains(read_file(plumbline.work() / "out/network.html"), "Node network")) << "which run made the page";
  std::istringstream table(read_file(plumbline.work() / "out/relative.csv"));
  std::vector<double> row;
  for (std::string line; std::getline(table, line) && row.empty();)
    if (line.rfind("F01-C01-R1,F03-C04-R2,", 0) == 0) {
      std::istringstream cells(line.substr(22));
      for (std::string cell; std::getline(cells, cell, ',');) row.push_back(std::stod(cell));
    }
  ASSERT_GT(row.size(), 8u);
  const Json pair = Json::parse(plumbline({"show", "out", "--relative", "F01-C01-R1", "F03-C04-R2", "--json"}).out);
  const char* names[] = {"dE", "dN", "dH", "slope_distance"};
  for (size_t i = 0; i < 4; ++i) {
    EXPECT_NEAR(pair[names[i]]["value"], row[i], 6e-6) << names[i];
    EXPECT_NEAR(1e3 * pair[names[i]]["sigma"].get<double>(), row[4 + i], 6e-4) << names[i];
  }
  const double de = pair["dE"]["value"], dn = pair["dN"]["value"];
  const Json& c = pair["covariance"];
  const double ee = c[0][0], en = c[0][1], nn = c[1][1];
  EXPECT_NEAR(pair["horizontal_distance"]["value"], std::hypot(de, dn), 1e-12);
  EXPECT_NEAR(pair["horizontal_distance"]["sigma"],
              std::sqrt(de * de * ee + 2 * de * dn * en + dn * dn * nn) / std::hypot(de, dn), 1e-12);
  const Answer words = plumbline({"show", "out/run.jsonl", "--relative", "F03-C04-R2", "F01-C01-R1"});
  EXPECT_TRUE(contains(words.out, "horizontal distance")) << words.out;
  const auto message = [&](const char* run, const char* a, const char* b) {
    const Answer answer = plumbline({"show", run, "--relative", a, b});
    EXPECT_NE(answer.code, 0) << answer.out;
    EXPECT_EQ(answer.out, "");
    return answer.err;
  };
  EXPECT_TRUE(contains(message("out", "F01-C01-R1", "F01-C01-R7"), "did you mean 'F01-C01-R1'"));
  EXPECT_TRUE(contains(message("out", "S1", "S1"), "expected two different points"));
  EXPECT_TRUE(contains(message("out/run.jsonl:network.network", "S1", "S2"), "network.points"));
  fs::remove_all(plumbline.work() / "out" / "run.jsonl");
  EXPECT_TRUE(contains(message("out", "S1", "S2"), "run.jsonl"));
}

/// A survey that proves nothing ended with 0, and a judgement that rested on it with 3.
/// Coordinates that nobody controlled are no wrong ones; who judges by them says so.
TEST(SurveyPipelines, WhatNothingControlsIsSaidAndNoFailure) {
  const Program plumbline;
  plumbline.write(
      "polar.csv",
      "station,target,hz [gon],v [gon],sd [m]\nS1,P1,10.0000,100.0000,20.000\nS1,P2,60.0000,98.0000,25.000\n");
  const Answer answer = plumbline({"run", pipeline("survey_network"), "file=polar.csv", "--out", "out"});
  EXPECT_EQ(answer.code, 0) << answer.out << answer.err;
  EXPECT_TRUE(contains(answer.out, "Cannot be tested")) << answer.out;
  EXPECT_TRUE(std::filesystem::exists(plumbline.work() / "out/coordinates.csv"));
}

TEST(SurveyPipelines, APairOfANetworkThatIsNoResultSaysSo) {
  const Program plumbline;
  plumbline.write("job.csv", with_feet("S2"));
  ASSERT_EQ(plumbline({"run", pipeline("survey_network"), "file=job.csv", "--out", "out"}).code, 3);
  const Answer answer = plumbline({"show", "out", "--relative", "S1", "S2"});
  EXPECT_EQ(answer.code, 0) << answer.err;
  EXPECT_TRUE(contains(answer.out, "! the network is not a result")) << answer.out;
}

}  // namespace test_survey_pipelines
}  // namespace plumbline::test
