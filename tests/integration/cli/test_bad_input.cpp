// Bad input through the program with its own plugins and pipelines: an error that a stranger can act on, exit code 1,
// and nothing half-written in the output folder.
#include <algorithm>

#include "program.hpp"
#include "test_paths.hpp"

namespace plumbline::test {
namespace test_bad_input {

namespace fs = std::filesystem;

const std::string pipelines = std::string(plumbline::test::source_dir()) + "/pipelines/";

/// The program with the plugins of the build; its outputs go to work/out.
class BadInput : public testing::Test {
 protected:
  Answer run(const std::string& pipeline, std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), {"run", pipeline, "--out", "out"});
    return plumbline(arguments);
  }

  /// Exit code 1 (2 where nothing was run), all the words in the error, and nothing but the record and `delivered` in
  /// the output folder.
  void expect_refused(const Answer& answer, const std::vector<std::string>& words,
                      const std::vector<std::string>& delivered = {}) const {
    EXPECT_EQ(answer.code, fs::exists(plumbline.work() / "out") ? 1 : 2) << answer.out << answer.err;
    for (const std::string& word : words)
      EXPECT_TRUE(contains(answer.err, word)) << "no '" << word << "' in:\n" << answer.err;
    std::vector<std::string> expected = delivered, found;
    if (fs::exists(plumbline.work() / "out")) {
      expected.push_back("run.jsonl");
      for (const auto& entry : fs::directory_iterator(plumbline.work() / "out"))
        found.push_back(entry.path().filename().string());
    }
    std::sort(expected.begin(), expected.end());
    std::sort(found.begin(), found.end());
    EXPECT_EQ(found, expected);
  }

  void write(const std::string& name, const std::string& text) const { plumbline.write(name, text); }

  const Program plumbline{PLUMBLINE_PLUGIN_FOLDER};
};

TEST_F(BadInput, UnknownNodesAndPortsHaveTheirNearNames) {
  Answer answer = run(pipelines + "site_campaign.yaml", {"folder=.", "block.use=adjust.cers"});
  expect_refused(answer, {"there is no node 'adjust.cers' — did you mean 'adjust.ceres'?"});
  EXPECT_FALSE(fs::exists(plumbline.work() / "out"));
  answer = run(pipelines + "site_campaign.yaml", {"folder=.", "poses.with.solver=epmp"});
  expect_refused(answer, {"'epmp'", "epnp"});
  EXPECT_FALSE(fs::exists(plumbline.work() / "out"));
}

TEST_F(BadInput, APortOfAnotherTypeIsRefusedBeforeAnythingRuns) {
  write("wrong.yaml",
        "plumbline: 1\nnodes:\n  source: {use: read.file, with: {file: wrong.yaml}}\n"
        "  network: {use: survey.adjust, in: {observations: source.file}}\noutputs: {n.json: network.network}\n");
  const Answer answer = run("wrong.yaml", {});
  expect_refused(answer, {"wrong.yaml:4:", "source.file", "plumbline.File/1", "plumbline.SurveyObservations/1"});
  EXPECT_FALSE(fs::exists(plumbline.work() / "out"));
}

TEST_F(BadInput, ACycleIsNamed) {
  write("cycle.yaml",
        "plumbline: 1\nnodes:\n  a: {use: register.rigid, in: {source: b.points, target: b.points}}\n"
        "  b: {use: register.rigid, in: {source: a.points, target: a.points}}\noutputs: {p.json: a.points}\n");
  const Answer answer = run("cycle.yaml", {});
  expect_refused(answer, {"cycle.yaml:3:3", "a", "b"});
  EXPECT_TRUE(contains(answer.err, "circle") || contains(answer.err, "cycle")) << answer.err;
  EXPECT_FALSE(fs::exists(plumbline.work() / "out"));
}

TEST_F(BadInput, MissingFilesAreNamed) {
  for (const auto& [pipeline, argument] :
       {std::pair("survey_network.yaml", "file=nowhere.gsi"), std::pair("read_design.yaml", "file=nowhere.ifc"),
        std::pair("detect_images.yaml", "folder=nowhere"), std::pair("site_campaign.yaml", "folder=nowhere")})
    expect_refused(run(pipelines + pipeline, {argument}), {"nowhere", "there is no"});
  fs::create_directory(plumbline.work() / "empty");
  expect_refused(run(pipelines + "site_campaign.yaml", {"folder=empty"}), {"campaign.yaml"});
  expect_refused(run(pipelines + "detect_images.yaml", {"folder=empty"}), {"no image in", ".jpg"});
}

TEST_F(BadInput, AGsiLineCutInHalf) {
  write("cut.gsi",
        "*410001+0000000000000021 42....+00000000000000S1 43....+0000000000001500\n"
        "*110002+000000000000000A 21.322+0000000012345670 22.322+0000000009876540 31..00+0000000000012345\n"
        "*110003+000000000000000B 21.322+00000000123\n");
  expect_refused(run(pipelines + "survey_network.yaml", {"file=cut.gsi"}), {"cut.gsi:3", "21.322+00000000123"});
}

TEST_F(BadInput, AnIfcWithoutStoreys) {
  write("flat.ifc",
        "ISO-10303-21;\nHEADER;\nFILE_DESCRIPTION((''),'2;1');\nFILE_NAME('flat.ifc','',(''),(''),'','','');\n"
        "FILE_SCHEMA(('IFC4'));\nENDSEC;\nDATA;\n#1=IFCPROJECT('0YvctVUKr0kugbFTf53O9L',$,'P',$,$,$,$,$,#2);\n"
        "#2=IFCUNITASSIGNMENT((#3));\n#3=IFCSIUNIT(*,.LENGTHUNIT.,$,.METRE.);\nENDSEC;\nEND-ISO-10303-21;\n");
  const Answer flat = run(pipelines + "read_design.yaml", {"file=flat.ifc"});
  EXPECT_EQ(flat.code, 0) << flat.err;  // it costs the statistics by floor only
  EXPECT_TRUE(contains(flat.err, "warning: the file has no IfcBuildingStorey: statistics by floor")) << flat.err;
  fs::remove_all(plumbline.work() / "out");
  write("cut.ifc", "ISO-10303-21;\nHEADER;\nFILE_SCHEMA(('IFC4'));\nENDSEC;\nDATA;\n#1=IFCPROJECT('0Yvct");
  expect_refused(run(pipelines + "read_design.yaml", {"file=cut.ifc"}), {"cut.ifc:6"});
}

/// A campaign on disk that is whole; each test spoils it in its own way.
class BadCampaign : public BadInput {
 protected:
  void SetUp() override {
    write(
        "make.yaml",
        "plumbline: 1\nvars: {seed: 2}\nnodes:\n  site: {use: simulate.campaign, with: {floors: 1, columns: 3, camera: "
        "quick_6mp, images_per_floor: 4}}\noutputs: {site: site.folder}\n");
    const Answer made = plumbline({"run", "make.yaml", "--out", "made"});
    ASSERT_EQ(made.code, 0) << made.err;
    fs::copy(plumbline.work() / "made/site", site(), fs::copy_options::recursive);
    for (const auto& entry : fs::recursive_directory_iterator(site()))
      fs::permissions(entry, fs::perms::owner_write, fs::perm_options::add);
  }
  fs::path site() const { return plumbline.work() / "site"; }
  std::string text(const std::string& name) const { return read_file(site() / name); }
  void rewrite(const std::string& name, const std::string& content) const {
    std::ofstream(site() / name, std::ios::binary) << content;
  }
  Answer process(std::vector<std::string> more = {}) const {
    more.insert(more.begin(), "folder=site");
    return run(pipelines + "site_campaign.yaml", more);
  }
  /// The lines of a table for which `keep` holds, and its head.
  template <typename Keep>
  std::string table(const std::string& name, Keep keep) const {
    std::istringstream lines(text(name));
    std::string line, result;
    std::getline(lines, result);
    result += "\n";
    while (std::getline(lines, line))
      if (keep(line)) result += line + "\n";
    return result;
  }
};

TEST_F(BadCampaign, ATruncatedPhotographIsNamed) {
  const std::string photograph = text("images/F01-02.jpg");
  rewrite("images/F01-02.jpg", photograph.substr(0, photograph.size() / 2));
  expect_refused(process(), {"images/F01-02.jpg", "truncated"});
  // Photographs without a campaign: the others are searched, and it is said which one is left out.
  const Answer answer = run(pipelines + "detect_images.yaml", {"folder=site/images"});
  EXPECT_EQ(answer.code, 0) << answer.err;
  for (const char* word : {"left out", "F01-02.jpg", "truncated"})
    EXPECT_TRUE(contains(answer.err, word)) << answer.err;
}

TEST_F(BadCampaign, AnImageThatShowsTooFewMarkers) {
  // Plates that only some images show: where fewer than three remain in the table, a pose cannot be trusted.
  const std::string few = table("plates.csv", [](const std::string& line) {
    return line.find("-C01-") != std::string::npos || line.find("-C02-") != std::string::npos;
  });
  rewrite("plates.csv", few);
  rewrite("plates.csv", table("plates.csv", [](const std::string& line) { return line.rfind("F01-C02-R2", 0) != 0; }));
  rewrite("plates.csv", table("plates.csv", [](const std::string& line) { return line.rfind("F01-C02-R1", 0) != 0; }));
  expect_refused(process(),
                 {"image images/F01-0", "markers that are in the plate table", "needed are 3", "on_too_few: skip"});
  // Going on without such images does not help where all are such.
  expect_refused(process({"poses.with.on_too_few=skip"}), {"it is left out", "none of the 4 images could be oriented"});
}

TEST_F(BadCampaign, ASurveyFileCutInHalfIsRefusedAndMayBeGoneOnWith) {
  const std::string survey = text("survey/total_station.gsi");
  const size_t line = survey.rfind("\n", survey.size() * 2 / 3);
  rewrite("survey/total_station.gsi", survey.substr(0, line + 60));  // in the middle of a line's second word
  expect_refused(process(), {"survey/total_station.gsi:", "found", "strict=false"});
  const Answer answer = process({"strict=false"});
  EXPECT_TRUE(contains(answer.err, "warning: survey/total_station.gsi:")) << answer.err;
}

TEST_F(BadCampaign, ControlThatLeavesTheNetworkFreeIsNamed) {
  rewrite("control.csv", table("control.csv", [](const std::string& line) { return line.rfind("G1", 0) == 0; }));
  expect_refused(process(), {"node 'network'", "rank defect", "determined"});
}

TEST_F(BadCampaign, ControlInOneLineLeavesTheBlockFreeAndIsNamed) {
  std::string plates = text("plates.csv");
  for (size_t at = 0; (at = plates.find(",control,", at)) != std::string::npos;) {
    const size_t line = plates.rfind('\n', at) + 1;
    if (plates.compare(line, 8, "F01-C02-") != 0) plates.replace(at, 9, ",check,");
    ++at;
  }
  rewrite("plates.csv", plates);
  const Answer answer = process();
  expect_refused(answer, {"rotation about the line through", "undetermined"});
}

TEST_F(BadCampaign, AFailureInOneBranchLeavesTheOthersTheirOutputs) {
  // The design is damaged or cut off: what needs it fails with its cause named, the survey network is adjusted and
  // delivered.
  const std::string begun = text("design.ifc").substr(0, 400);
  write("with_network.yaml",
        "plumbline: 1\ninclude: " + pipelines + "site_campaign.yaml\noutputs: {network.json: network.network}\n");
  for (const std::string end : {"\nENDSEC;\nEND-ISO-10303-21;\n", ""}) {
    SCOPED_TRACE(end.empty() ? "cut off" : "damaged");
    rewrite("design.ifc", begun + end);
    const Answer answer = run("with_network.yaml", {"folder=site"});
    expect_refused(
        answer, {"node 'design' (bim.read_ifc) failed: design.ifc:", "nodes that need it did not run", "report.html"},
        {"network.json"});
    fs::remove_all(plumbline.work() / "out");
  }
}

}  // namespace test_bad_input
}  // namespace plumbline::test
