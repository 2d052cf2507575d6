// Buildings of several facades from readings to orders: whoever is sent outward on one facade is sent outward on all,
// and the shape of a building changes nothing for the anchors that all shapes have.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <numbers>
#include <random>
#include <sstream>

#include "program.hpp"

namespace plumbline::test {
namespace test_building {

using Row = std::map<std::string, std::string>;

/// By the value in the first column.
std::map<std::string, Row> table(const std::filesystem::path& path) {
  std::istringstream lines(read_file(path));
  std::string line, cell;
  std::vector<std::string> names;
  std::map<std::string, Row> rows;
  while (std::getline(lines, line)) {
    std::istringstream cells(line);
    std::vector<std::string> values;
    while (std::getline(cells, cell, ',')) values.push_back(cell);
    if (names.empty()) {
      names = values;
      continue;
    }
    for (std::size_t i = 0; i < std::min(names.size(), values.size()); ++i) rows[values[0]][names[i]] = values[i];
  }
  return rows;
}

double number(const Row& row, const std::string& name) { return std::atof(row.at(name).c_str()); }

class Building : public testing::Test {
 protected:
  /// The judged anchors of a building of that shape, all of them compared with the truth.
  std::map<std::string, Row> built(const std::string& shape, const std::string& step = "1.0") {
    const std::string out = "out-" + shape + step;
    const Answer answer = program_({"run", std::string(source_dir()) + "/pipelines/building.yaml", "shape=" + shape,
                                    "step=" + step, "floors=2", "as_built_sigma=0.006", "--out", out});
    EXPECT_EQ(answer.code, 0) << answer.out << answer.err;
    EXPECT_FALSE(contains(answer.err, "Nobody may be sent")) << answer.err;
    const auto folder = program_.work() / out;
    const auto judged = table(folder / "metrics.csv"), truth = table(folder / "truth" / "anchors.csv"),
               plates = table(folder / "campaign" / "plates.csv");
    EXPECT_EQ(judged.size(), plates.size());
    const std::string page = read_file(folder / "report.html");
    EXPECT_EQ(contains(page, "Facade by facade"), shape == "block" || shape == "courtyard" || shape == "corner")
        << shape;
    int clear = 0;
    for (const auto& [anchor, row] : judged) {
      const double azimuth = number(plates.at(anchor), "facing_azimuth_deg") * std::numbers::pi / 180;
      const auto off = [&](const char* axis) {
        return 1e3 * (number(truth.at(anchor), std::string(axis) + "_m") -
                      number(truth.at(anchor), "design_" + std::string(axis) + "_m"));
      };
      const double outward = off("x") * std::sin(azimuth) + off("y") * std::cos(azimuth);
      const double u = number(row, "design_out_of_plane_u_mm"), told = number(row, "design_out_of_plane_mm");
      EXPECT_LT(std::abs(told - outward), 5 * u) << shape << ": " << anchor;
      clear += std::abs(outward) > 5 * u;
    }
    EXPECT_GT(clear, static_cast<int>(judged.size()) / 4)
        << shape << ": no sign is proved by what lies within its noise";
    return judged;
  }

  Program program_{PLUMBLINE_PLUGIN_FOLDER};
};

TEST_F(Building, OfEveryShapeAllAreSentTheRightWay) {
  const auto flat = built("flat");
  for (const auto& [shape, step, facades] :
       std::vector<std::tuple<std::string, std::string, std::size_t>>{{"block", "1.0", 4},
                                                                      {"courtyard", "1.0", 4},
                                                                      {"curved", "1.0", 4},
                                                                      {"corner", "1.0", 2},
                                                                      {"set_back", "0.3", 3},
                                                                      {"set_back", "1.2", 3}}) {
    const auto judged = built(shape, step);
    EXPECT_EQ(judged.size(), facades * flat.size()) << shape;
    for (const auto& [anchor, row] : flat) {
      if (anchor.find("-C") == std::string::npos) continue;  // check anchors are in columns after all others
      for (const char* length : {"design_out_of_plane", "design_vertical"}) {
        const double u = number(row, std::string(length) + "_u_mm");
        EXPECT_LT(
            std::abs(number(judged.at(anchor), std::string(length) + "_mm") - number(row, std::string(length) + "_mm")),
            6 * u)
            << shape << ": " << anchor << " " << length;
      }
    }
  }
}

/// Lines of campaign.yaml without those keys (and what hangs under them).
std::string without(const std::string& yaml, const std::vector<std::string>& keys) {
  std::istringstream lines(yaml);
  std::string line, kept;
  bool leave = false;
  while (std::getline(lines, line)) {
    if (!line.empty() && line[0] != ' ')
      leave = std::any_of(keys.begin(), keys.end(), [&](const auto& key) { return line.starts_with(key + ":"); });
    if (!leave) kept += line + "\n";
  }
  return kept;
}

/// The same folder without its photographs, and without a word of tags: the anchors are judged by the total station.
TEST_F(Building, MeasuredByTotalStationAloneIsJudgedLikeEveryOther) {
  built("block");
  const auto truth = table(program_.work() / "out-block1.0" / "truth" / "anchors.csv");
  for (const bool azimuths : {true, false}) {
    const auto folder = program_.work() / (azimuths ? "told" : "untold");
    std::filesystem::copy(program_.work() / "out-block1.0" / "campaign", folder,
                          std::filesystem::copy_options::recursive);
    std::filesystem::remove(folder / "observations.csv"), std::filesystem::remove(folder / "camera.yaml");
    const std::string yaml = read_file(folder / "campaign.yaml");
    std::ofstream(folder / "campaign.yaml") << without(yaml, {"images", "observations", "camera"});
    std::string plates = azimuths ? "anchor,floor,facing_azimuth_deg\n" : "anchor,floor\n";
    for (const auto& [anchor, row] : table(folder / "plates.csv"))
      plates += anchor + "," + row.at("floor") + (azimuths ? "," + row.at("facing_azimuth_deg") : "") + "\n";
    const auto of_site = table(folder / "plates.csv");
    std::ofstream(folder / "plates.csv") << plates;
    const std::string out = azimuths ? "out-told" : "out-untold";
    const Answer answer = program_({"run", std::string(source_dir()) + "/pipelines/site_survey.yaml",
                                    "folder=" + folder.string(), "mounting_sigma=0", "epoch=2026-05", "--out", out});
    EXPECT_EQ(answer.code, 0) << answer.out << answer.err;
    EXPECT_TRUE(contains(answer.err, "measured by total station alone")) << answer.err;
    const auto result = program_.work() / out;
    const auto judged = table(result / "metrics.csv");
    EXPECT_EQ(judged.size(), of_site.size());
    int clear = 0, decided = 0;
    for (const auto& [anchor, row] : judged) {
      const double azimuth = number(of_site.at(anchor), "facing_azimuth_deg") * std::numbers::pi / 180;
      const auto off = [&](const char* axis) {
        return 1e3 * (number(truth.at(anchor), std::string(axis) + "_m") -
                      number(truth.at(anchor), "design_" + std::string(axis) + "_m"));
      };
      const double outward = off("x") * std::sin(azimuth) + off("y") * std::cos(azimuth);
      const double u = number(row, "design_out_of_plane_u_mm"), told = number(row, "design_out_of_plane_mm");
      EXPECT_GT(u, 0) << anchor;
      EXPECT_LT(std::abs(told - outward), 5 * u) << anchor;
      clear += std::abs(outward) > 5 * u;
      decided += row.at("design_verdict") == "pass" || row.at("design_verdict") == "fail";
    }
    EXPECT_GT(clear, static_cast<int>(judged.size()) / 4);
    EXPECT_GT(decided, static_cast<int>(judged.size()) / 4);
    EXPECT_TRUE(contains(read_file(result / "summary.txt"), "Installation: "));
    EXPECT_TRUE(contains(read_file(result / "as_built.ifc"), "ASB_"));
    EXPECT_TRUE(contains(read_file(result / "report.html"), "measured by total station alone"));
    EXPECT_EQ(contains(read_file(result / "metrics.json"), "\"overall\": \"no_evidence\""), true);
  }
}

/// Commands of a page that stand there to be pasted, without the program's name.
std::vector<std::vector<std::string>> commands_in(const std::string& page) {
  std::vector<std::vector<std::string>> commands;
  const std::string mark = "<pre class=\"command\">plumbline ";
  for (std::size_t at = page.find(mark); at != std::string::npos; at = page.find(mark, at + 1)) {
    std::string text = page.substr(at + mark.size(), page.find("</pre>", at) - at - mark.size());
    for (const auto& [entity, c] : {std::pair{"&#39;", "'"}, std::pair{"&quot;", "\""}, std::pair{"&amp;", "&"}})
      for (std::size_t found = text.find(entity); found != std::string::npos; found = text.find(entity))
        text.replace(found, std::string(entity).size(), c);
    std::vector<std::string> words(1);
    bool quoted = false;
    for (const char c : text)
      if (c == '\'')
        quoted = !quoted;
      else if (c == ' ' && !quoted)
        words.emplace_back();
      else
        words.back() += c;
    commands.push_back(words);
  }
  return commands;
}

/// What the page offers is the whole command: pasted it runs, and what it is offered for is mended.
TEST_F(Building, EachCommandThatThePageOffersRunsAndMends) {
  const auto run = [&](std::vector<std::string> words, const std::string& out) {
    words.insert(words.end(), {"--out", out});
    const Answer answer = program_(words);
    EXPECT_EQ(answer.code, 0) << answer.out << answer.err;
    return read_file(program_.work() / out / "report.html");
  };
  const std::string page = run({"run", std::string(source_dir()) + "/pipelines/building.yaml", "shape=flat", "floors=5",
                                "optics=real", "mounting_sigma=0.0005", "seed=1"},
                               "out");
  const auto commands = commands_in(page);
  ASSERT_EQ(commands.size(), 1u) << "why all is less certain";
  EXPECT_EQ(commands[0].back().find("block.with.image_principal_point_sigma="), 0u) << commands[0].back();
  const std::string mended = run(commands[0], "mended");
  EXPECT_TRUE(contains(page, "standard deviations of anchors ")) << "less certain, and by how much";
  EXPECT_TRUE(commands_in(mended).empty());
}

/// The same folder without its survey: how anchors stand to each other is told as by the survey, where all stand is not
/// decided. Once a fit to the anchors that are judged was "Ready to install", whatever the whole was off.
TEST_F(Building, PhotographsAloneJudgeHowAnchorsStandToEachOther) {
  const auto with_survey = built("corner");
  const auto folder = program_.work() / "alone";
  std::filesystem::copy(program_.work() / "out-corner1.0" / "campaign", folder,
                        std::filesystem::copy_options::recursive);
  const std::string yaml = read_file(folder / "campaign.yaml");
  std::ofstream(folder / "campaign.yaml") << without(yaml, {"survey", "control"});
  std::filesystem::remove_all(folder / "survey"), std::filesystem::remove(folder / "control.csv");
  std::ofstream(program_.work() / "alone.yaml")
      << "plumbline: 1\ninclude: " << source_dir() << "/pipelines/site_photographs.yaml\n"
      << "nodes:\n  campaign: {with: {takes: observations}}\n"
         "  poses: {in: {observations: campaign.observations}}\n  block: {in: {observations: campaign.observations}}\n"
         "  photographs: {in: {tags: campaign.observations}}\n";
  const auto run = [&](const std::string& out, std::vector<std::string> more) {
    more.insert(more.begin(), {"run", "alone.yaml", "folder=" + folder.string(), "epoch=2026-05"});
    more.insert(more.end(), {"--out", out});
    return program_(more);
  };
  const Answer unsaid = run("unsaid", {}), said = run("said", {"frames.with.datum_sigma=0"});
  EXPECT_EQ(unsaid.code, 3) << unsaid.out << unsaid.err;
  const auto work = program_.work();
  EXPECT_TRUE(contains(read_file(work / "unsaid/summary.txt"), "NOT TO BE TRUSTED, where the whole stands: "));
  EXPECT_TRUE(contains(read_file(work / "unsaid/report.html"), "Not decided: nothing shows where the whole stands."));
  EXPECT_TRUE(contains(read_file(work / "unsaid/report.html"), "frames.with.datum_sigma=0.005 where they do to 5 mm"));
  EXPECT_FALSE(contains(read_file(work / "unsaid/report.html"), "SIGMA")) << "no command that cannot be pasted";
  EXPECT_TRUE(contains(unsaid.err, "measured in photographs alone")) << unsaid.err;
  EXPECT_FALSE(contains(unsaid.err, "total station alone")) << unsaid.err;
  for (const auto& [anchor, row] : table(work / "unsaid/metrics.csv"))
    EXPECT_EQ(row.at("design_verdict"), "undecided") << anchor;
  EXPECT_TRUE(said.code == 0 || said.code == 3) << said.err;
  for (const char* file : {"report.html", "summary.txt", "as_built.ifc", "metrics.json"})
    EXPECT_TRUE(contains(read_file(work / "said" / file), "Judged about the best fit of the anchors")) << file;
  const auto judged = table(work / "said/metrics.csv");
  ASSERT_EQ(judged.size(), with_survey.size());
  int decided = 0;
  for (const auto& [anchor, row] : judged) {
    decided += row.at("design_verdict") == "pass" || row.at("design_verdict") == "fail";
    for (const char* length : {"design_out_of_plane", "design_vertical"}) {
      const double u = number(row, std::string(length) + "_u_mm"), told = number(row, std::string(length) + "_mm");
      EXPECT_GT(u, 0.1) << anchor;
      EXPECT_LT(std::abs(told - number(with_survey.at(anchor), std::string(length) + "_mm")), 4 * u + 2)
          << anchor << " " << length;
    }
  }
  EXPECT_GT(decided, static_cast<int>(judged.size()) / 4);
}

/// What a scanner sees of the panels of this design artifact, 3 mm before their outer faces: points every 40 mm, so
/// that no cell of `surface.panels` (50 mm) goes without one.
std::string scanned(const nlohmann::json& design) {
  std::mt19937_64 random(4);
  std::normal_distribution<double> noise(0.003, 0.001);
  std::ostringstream cloud;
  cloud.precision(9);
  for (const auto& element : design.at("elements")) {
    if (!element.value("is_panel", false) || element.at("class") != "IfcPlate") continue;
    const std::vector<double> q = element["placement"][0], t = element["placement"][1], low = element["box_low"],
                              high = element["box_high"];
    // x to the right as one looks at it and z up: the turn about z alone, and -y is outward.
    const double turn = 2 * std::atan2(q[3], q[0]), c = std::cos(turn), s = std::sin(turn);
    for (double u = low[0] + 0.02; u < high[0]; u += 0.04)
      for (double v = low[2] + 0.02; v < high[2]; v += 0.04) {
        const double out = low[1] - noise(random);
        cloud << t[0] + c * u - s * out << ' ' << t[1] + s * u + c * out << ' ' << t[2] + v << '\n';
      }
  }
  return cloud.str();
}

/// Anchors by total station, panels by a scan that comes later: one judgement, which changes nothing for the anchors,
/// and of which summary, JUnit, issues and as-built model say the same.
TEST_F(Building, PanelsScannedLaterAreJudgedWithAnchorsMeasuredByTotalStation) {
  built("corner");
  const auto folder = program_.work() / "out-corner1.0" / "campaign";
  std::filesystem::remove(folder / "observations.csv"), std::filesystem::remove(folder / "camera.yaml");
  const std::string yaml = read_file(folder / "campaign.yaml");
  std::ofstream(folder / "campaign.yaml") << without(yaml, {"images", "observations", "camera"});
  const auto run = [&](const std::string& pipeline, std::vector<std::string> more) {
    more.insert(more.begin(), {"run", std::string(source_dir()) + "/pipelines/" + pipeline + ".yaml",
                               "folder=" + folder.string(), "mounting_sigma=0", "epoch=2026-05"});
    more.insert(more.end(), {"--out", pipeline});
    return program_(more);
  };
  EXPECT_EQ(run("site_survey", {}).code, 0);
  const Answer shown = program_({"show", "site_survey/run.jsonl:design.design"});
  ASSERT_EQ(shown.code, 0) << shown.err;
  const auto design = nlohmann::json::parse(shown.out);
  program_.write("scan.xyz", scanned(design.contains("value") ? design["value"] : design));
  const std::vector<std::string> scan = {"scan=scan.xyz", "unit=m", "noise=0.001", "place_sigma=0.0005"};
  auto judged = scan, too_much = scan;
  judged.push_back("rule=*: bow=5mm"), too_much.push_back("rule=*: flatness(9m)=5mm");
  const Answer answer = run("site_survey_scan", judged);
  EXPECT_EQ(answer.code, 0) << answer.err;
  const auto result = program_.work() / "site_survey_scan";
  EXPECT_EQ(table(result / "metrics.csv"), table(program_.work() / "site_survey" / "metrics.csv"));
  const std::string summary = read_file(result / "summary.txt"), tests = read_file(result / "metrics.xml"),
                    model = read_file(result / "as_built.ifc");
  EXPECT_TRUE(contains(summary, "surfaces and joints: ")) << summary;
  EXPECT_TRUE(contains(model, "ASB_PanelSurface"));
  EXPECT_TRUE(contains(model, "total station and laser scan"));
  EXPECT_TRUE(contains(tests, "<testsuite name=\"surfaces\"")) << tests;
  EXPECT_TRUE(contains(read_file(result / "report.html"), "total station and laser scan"));
  // What nobody can judge is said everywhere, and in the exit code.
  EXPECT_EQ(run("site_survey_scan", too_much).code, 3);
  EXPECT_TRUE(contains(read_file(result / "summary.txt"), "NOT JUDGED"));
  EXPECT_TRUE(contains(read_file(result / "metrics.xml"), "<testsuite name=\"asked_for\""));
}

}  // namespace test_building
}  // namespace plumbline::test
