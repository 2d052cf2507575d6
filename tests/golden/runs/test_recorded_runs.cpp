// Shipped pipelines on small simulated sites: every field of every artifact that a node gives, and every part of every
// file that is delivered, as it was when it was looked at (recorded/NAME.txt). Whether it is right other tests say; a
// line that is wrong shows here, also where it only writes a field that no other test reads.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "node_harness.hpp"
#include "program.hpp"
#include "runtime/record/deliver.hpp"
#include "runtime/store/store.hpp"
#include "signature.hpp"

namespace plumbline::test {
namespace test_recorded_runs {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

/// Without AVX2 it is another by 1.3 % on the real board: halves of cameras that hardly determine themselves.
const char* const kOfLastDigits = ".camera_variance_factor";

// Results must not depend on it.
const char* const kThreads = "1";

/// What is written for others and read again, and what stands in for what the shipped pipelines take.
const char* const kExchange = R"(plumbline: 1
nodes:
  site: {use: simulate.observations, with: {floors: 2, images_per_floor: 6, survey: readings}}
  gama: {use: write.gama, in: {observations: site.survey}}
  gsi: {use: write.gsi, in: {observations: site.survey}}
  landxml: {use: write.landxml, in: {observations: site.survey}}
  starnet: {use: write.starnet, in: {observations: site.survey, points: site.design}}
  from_gama: {use: read.gama, in: {file: gama.file}}
  from_gsi: {use: read.gsi, in: {file: gsi.file}}
  from_landxml: {use: read.landxml, in: {file: landxml.file}}
  from_starnet: {use: read.starnet, in: {file: starnet.file}}
  ply: {use: write.ply, in: {points: site.truth}}
  colmap: {use: write.colmap, in: {poses: site.true_poses, cameras: site.camera, points: site.truth}}
  dlt: {use: triangulate.dlt, in: {observations: site.observations, camera: site.camera, plates: site.plates, poses: site.true_poses}}
  midpoint: {use: triangulate.midpoint, in: {observations: site.observations, camera: site.camera, plates: site.plates, poses: site.true_poses}}
  angular: {use: triangulate.angular, in: {observations: site.observations, camera: site.camera, plates: site.plates, poses: site.true_poses}}
  arun: {use: register.opengv_arun, in: {source: dlt.points, target: site.points}}
  poses: {use: pose.opencv, in: {observations: site.observations, camera: site.camera, plates: site.plates, points: site.design}}
  ceres: {use: adjust.ceres, in: {observations: site.observations, poses: poses.poses, camera: site.camera, plates: site.plates, control: site.points}}
outputs: {gama.xml: gama.file, job.gsi: gsi.file, job.xml: landxml.file, job.dat: starnet.file, points.ply: ply.file, colmap: colmap.model}
)";

class RecordedRuns : public testing::Test {
 protected:
  void run(const std::string& pipeline, const std::vector<std::string>& settings, const std::string& out) {
    std::vector<std::string> words{"run", std::string(source_dir()) + "/pipelines/" + pipeline + ".yaml"};
    if (pipeline.ends_with(".yaml")) words[1] = pipeline;
    words.insert(words.end(), settings.begin(), settings.end());
    words.insert(words.end(), {"--threads", kThreads, "--out", out});
    const Answer answer = program_(words);
    EXPECT_TRUE(answer.code == 0 || answer.code == 3) << out << ": " << answer.code << answer.out << answer.err;
  }

  /// Runs it and compares all of it with recorded/OUT.txt. What a kind of node gives, and a file of numbers by its
  /// name, is signed once in a test; words and pages always.
  void expect(const std::string& pipeline, const std::vector<std::string>& settings, const std::string& out) {
    run(pipeline, settings, out);
    RunSignatures found;
    sign_nodes(out, found);
    for (const auto& entry : fs::recursive_directory_iterator(program_.work() / out)) {
      const fs::path file = fs::relative(entry.path(), program_.work() / out);
      if (!entry.is_regular_file() || file == "run.jsonl" || is_packed(file)) continue;
      const std::string text = told(read_file(entry.path()));
      if (file.extension() == ".json" && artifacts_.count(Json::parse(text).dump())) continue;
      sign_file(file.string(), text, found[file.string()]);
    }
    for (auto& [name, fields] : found)
      std::erase_if(fields, [](const auto& field) { return field.first.ends_with(kOfLastDigits); });
    expect_signatures(out + ".txt", found);
  }

  /// What a command answers on both channels, as the run of its name.
  void ask(const std::vector<std::string>& words, int code, RunSignatures& found) const {
    const Answer answer = program_(words);
    std::string name, text = told(answer.out + answer.err);
    for (const std::string& word : words) name += (name.empty() ? "" : " ") + fs::path(word).filename().string();
    std::erase(name, ':');
    // A plugin that was built again is another one.
    std::string kept;
    std::istringstream lines(text);
    for (std::string line; std::getline(lines, line);)
      if (line.find("plugin binary") == std::string::npos) kept += line + "\n";
    EXPECT_EQ(answer.code, code) << name << answer.err;
    found[name]["answer"].text(kept);
  }

  const Program program_{PLUMBLINE_PLUGIN_FOLDER};

 private:
  /// Tables and issues in containers: what is in them stands in other files too.
  static bool is_packed(const fs::path& file) {
    static const std::set<std::string> endings{".xlsx", ".bcf", ".png", ".jpg"};
    return endings.count(file.extension()) > 0;
  }
  /// Without what another version, folder or place of the checkout would change.
  std::string told(std::string text) const {
    for (const std::string& own : {version_, program_.folder.path().string(), std::string(source_dir())})
      for (std::size_t at = 0; (at = text.find(own, at)) != std::string::npos;) text.replace(at, own.size(), "-");
    return text;
  }

  void sign_nodes(const std::string& out, RunSignatures& found) {
    runtime::Store store(program_.folder.path() / "store");
    std::istringstream record(read_file(program_.work() / out / "run.jsonl"));
    for (std::string line; std::getline(record, line);) {
      const Json event = Json::parse(line);
      if (event["event"] != "node") continue;
      const auto name = event["name"].get<std::string>();
      for (const char* const member : {"metrics", "messages", "warnings"})
        if (event.contains(member)) sign(Json::parse(told(event[member].dump())), member, found[name]);
      for (const auto& [port, hashes] : event["outputs"].items()) {
        const runtime::Registry& registry = built_registry();
        const plumbline_type& type = *registry.type(event["types"][port].get<std::string>());
        const std::string type_name = type.name;
        if (type_name.find(".File/") != std::string::npos || type_name.find(".Folder/") != std::string::npos) continue;
        for (const auto& hash : hashes) {
          const Json artifact = Json::parse(told(runtime::blob_to_json(store, type, hash)));
          artifacts_.insert(artifact.dump());
          sign(artifact, "", found[name + " " + port]);
        }
      }
    }
  }

  std::set<std::string> artifacts_;
  std::string version_ = [&] {
    std::istringstream words(program_({"--version"}).out);
    std::string word, version;
    while (words >> word)
      if (word.find('.') != std::string::npos) version = word;
    return version;
  }();
};

TEST_F(RecordedRuns, OfObservationsByEveryEngine) {
  expect("observations", {"floors=2", "optics=real", "height_walk=0.001"}, "observations");
  expect("observations_free",
         {"floors=2", "images_per_floor=6", "control_blunders=0.2", "lost_plates=0.1", "scaffold_spacing=2"},
         "observations_free");
  expect("observations_joint", {"floors=2", "images_per_floor=6", "survey=readings"}, "observations_joint");
  expect("plan_images", {"floors=1"}, "plan_images");
  expect("pose_breakdown", {"outliers=0.2"}, "pose_breakdown");
  expect("registration_breakdown", {"floors=2", "outliers=0.2"}, "registration_breakdown");
}

TEST_F(RecordedRuns, OfWhatOthersReadAndWrite) {
  program_.write("exchange.yaml", kExchange);
  expect("exchange.yaml", {}, "exchange");
  std::string layout = "kind,id,east_m,north_m,height_m,floor,column,facing_azimuth_deg,sees\n";
  for (const char* const row : {"marker,A1,0,0,1,1,1,180,", "marker,B1,2,0.1,1,1,2,180,", "marker,C1,4,0,1,1,3,180,",
                                "marker,A2,0,0,3,1,1,180,", "marker,B2,2,0.1,3,1,2,180,", "marker,C2,4,0,3,1,3,180,",
                                "marker,A3,0,0,5,2,1,180,", "marker,B3,2,0.1,5,2,2,180,", "set_up,S1,-2,-12,1.6,,,,",
                                "set_up,S2,6,-13,1.6,,,,A* B* C1"})
    layout += std::string(row) + "\n";
  program_.write("layout.csv", layout);
  expect("plan_survey", {"file=layout.csv", "sets=2"}, "plan_survey");
}

/// A building with its campaign, what a site does with that folder, and once more later; in another language and unit.
TEST_F(RecordedRuns, OfABuildingAndOfItsFolder) {
  const std::vector<std::string> site{"floors=2", "shape=corner", "site.with.images_per_floor=6",
                                      "site.with.site_seed=2"};
  expect("building", site, "building");
  const std::string folder = "folder=building/campaign", file = "building/campaign/survey/total_station.gsi",
                    profile = "profile=total_station_1arcsec";
  expect("survey_network", {"file=" + file, profile, "language=de", "units=in"}, "survey_network");
  expect("survey_campaign", {folder}, "survey_campaign");
  expect("site_observations", {folder, "language=de", "units=in", "epoch=2026-05"}, "site_observations");
  expect("plan_installation", {folder}, "plan_installation");
  expect("site_survey", {folder, "before=site_observations/as_built.json", "epoch=2026-06"}, "site_survey");
  for (const auto& [name, seed] : {std::pair("later", "2"), {"last", "3"}}) {  // visits of the same building
    auto visit = site;
    visit.push_back(std::string("seed=") + seed);
    run("building", visit, name);
  }
  const std::string later = "later/campaign/survey/total_station.gsi", last = "last/campaign/survey/total_station.gsi";
  expect("compare_epochs", {"before=" + file, "after=" + later, profile}, "compare_epochs");
  fs::create_directory(program_.work() / "series");
  for (const auto& [from, to] : {std::pair(file, "1.gsi"), {later, "2.gsi"}, {last, "3.gsi"}})
    fs::copy_file(program_.work() / from, program_.work() / "series" / to);
  program_.write("series/campaign.yaml", "plumbline_campaign: 1\nsurvey: [1.gsi, 2.gsi, 3.gsi]\n");
  expect("epoch_series", {"folder=series", profile, "movements.with.days=[0, 30, 61]"}, "epoch_series");
  expect("read_survey", {"file=" + file}, "read_survey");
  expect("read_design", {"file=building/campaign/design.ifc"}, "read_design");
  expect("check_campaign", {folder}, "check_campaign");
}

TEST_F(RecordedRuns, OfFacadesOfEveryShape) {
  for (const std::string shape : {"set_back", "curved", "courtyard", "flat"})
    expect("building",
           {"floors=" + std::string(shape == "flat" ? "2" : "1"), "shape=" + shape, "site.with.images_per_floor=4",
            "optics=" + std::string(shape == "flat" ? "real" : "ideal")},
           shape);
}

TEST_F(RecordedRuns, OfTheExecutionLoop) { expect("execution_loop", {"floors=2", "columns=3"}, "execution_loop"); }

TEST_F(RecordedRuns, OfPhotographs) {
  expect("rendered", {"floors=1", "images_per_floor=4", "camera=quick_6mp"}, "rendered");
  expect("robot_localisation", {"stations=4", "floors=1"}, "robot_localisation");
}

TEST_F(RecordedRuns, OfARealBoard) {
  ASSERT_EQ(program_({"example", "tutorial"}).code, 0);
  const std::string folder = "folder=tutorial", detector = "detector=aruco", family = "family=DICT_6X6_1000";
  expect("photo_campaign", {folder, detector, family}, "photo_campaign");
  expect("marker_board", {folder, detector, family, "tag_size=0.0375"}, "marker_board");
}

TEST_F(RecordedRuns, OfSurfaces) {
  std::vector<std::string> settings;
  for (const char* const one : {"columns=2", "rows=2", "photographs=6", "width=760", "height=620", "panel_width=0.5",
                                "panel_height=0.4", "distance=3"})
    settings.push_back(std::string("site.with.") + one);
  expect("facade_surfaces", settings, "facade_surfaces");
}

TEST_F(RecordedRuns, OfWhatCommandsSayOfThem) {
  const std::string folder = std::string(source_dir()) + "/pipelines/", free = folder + "observations_free.yaml";
  const std::string floors = "floors=2", images = "images_per_floor=6";
  run("observations_free", {floors, images}, "a");
  run("observations_free", {floors, images, "seed=2"}, "b");
  run("observations_free", {floors, images, "seed=2"}, "b");
  run("execution_loop", {floors, "columns=3"}, "loop");
  RunSignatures found;
  const std::string of_free = "a/run.jsonl:registration.points", of_block = "a/run.jsonl:block.points";
  for (const auto& [code, words] : std::vector<std::pair<int, std::vector<std::string>>>{
           {0, {"plan", free, floors, images}},
           {0, {"plan", free, floors, images, "seed=2"}},
           {0, {"plan", free, floors, images, "registration.with.scale=estimated", "--json"}},
           {0, {"plan", free, "floors=3"}},
           {0, {"graph", free}},
           {0, {"graph", folder + "execution_loop.yaml", "--format", "mermaid"}},
           {0, {"why", "block", "a"}},
           {0, {"why", "block", "b", "--json"}},
           {0, {"diff", "a", "a"}},
           {0, {"journal", "loop"}},
           {0, {"journal", "loop", "--json"}},
           {0, {"journal", "loop", "--check"}},
           {0, {"journal", "loop", "--item", "F01-P01"}},
           {0, {"show", "a/run.jsonl:site.points"}},
           {0, {"show", of_free, "--relative", "F01-C01-R1", "F02-C02-R1"}},
           {0, {"show", of_block, "--relative", "F01-C01-R1", "F02-C02-R1", "--json"}},
           {1, {"validate", free, "floors=x"}},
           {0, {"validate", free, "--json"}}})
    ask(words, code, found);
  expect_signatures("commands.txt", found);
}

}  // namespace test_recorded_runs
}  // namespace plumbline::test
