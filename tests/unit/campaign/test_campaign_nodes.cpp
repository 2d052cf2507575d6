// read.campaign and simulate.observations as the host runs them.
#include <gtest/gtest.h>

#include <fstream>
#include <functional>

#include "artifacts/camera.hpp"
#include "artifacts/element_matches.hpp"
#include "artifacts/file.hpp"
#include "artifacts/folder.hpp"
#include "artifacts/image.hpp"
#include "artifacts/image_tags.hpp"
#include "artifacts/input_files.hpp"
#include "artifacts/plates.hpp"
#include "artifacts/points.hpp"
#include "artifacts/survey_observations.hpp"
#include "campaign.hpp"
#include "node_harness.hpp"

namespace plumbline::test {
namespace test_campaign_nodes {

namespace fs = std::filesystem;

FolderT list(const fs::path& root) {
  FolderT folder;
  folder.uri = root.string();
  for (const auto& entry : fs::recursive_directory_iterator(root)) {
    if (!entry.is_regular_file()) continue;
    auto file = std::make_unique<FolderEntryT>();
    file->path = entry.path().lexically_relative(root).generic_string();
    file->sha256 = runtime::sha256_of_file(entry.path());
    file->size = entry.file_size();
    folder.files.push_back(std::move(file));
  }
  std::sort(folder.files.begin(), folder.files.end(), [](const auto& a, const auto& b) { return a->path < b->path; });
  return folder;
}

class ReadCampaignTest : public testing::Test {
 protected:
  void SetUp() override {
    simulate::CampaignOptions options;
    options.building.floors = 1;
    options.cameras.images_per_floor = 4;
    campaign_ = simulate::make_campaign(options, 1);
    for (BrownCamera* camera : {&campaign_.camera.truth, &campaign_.camera.calibration}) {
      camera->width = 600, camera->height = 400;
      for (double* value : {&camera->fx, &camera->fy, &camera->cx, &camera->cy}) *value *= 0.1;
    }
    simulate::write_campaign_files(campaign_, folder_.path());
    simulate::write_images(campaign_, folder_.path(), nullptr);
  }
  std::string message() {
    NodeHarness node("read.campaign");
    node.input<Folder>("folder", list(folder_.path()));
    try {
      node.run();
    } catch (const NodeFailed& error) {
      return error.what();
    }
    return "nothing was thrown";
  }
  simulate::Campaign campaign_;
  TemporaryFolder folder_;
};

TEST_F(ReadCampaignTest, GivesEveryPartOfTheFolder) {
  NodeHarness node("read.campaign");
  node.input<Folder>("folder", list(folder_.path()));
  node.run();
  EXPECT_EQ(node.warnings(), std::vector<std::string>());
  ASSERT_EQ(node.output_count("images"), 4u);
  const ImageT image = node.output<Image>("images", 1);
  EXPECT_EQ(image.path, "images/F01-02.jpg");
  EXPECT_EQ(image.width, 600);
  EXPECT_EQ(image.camera, node.output<Camera>("camera").id);
  EXPECT_EQ(image.sha256, runtime::sha256_of_file(folder_.path() / "images/F01-02.jpg"));
  EXPECT_EQ(node.output<Plates>("plates").plates.size(), 11u);
  EXPECT_EQ(node.output<Points>("control").points.size(), 4u);
  const SurveyObservationsT survey = node.output<SurveyObservations>("survey");
  EXPECT_EQ(survey.observations.size(), campaign_.observations.observations.size());
  EXPECT_EQ(survey.info->instrument, "ics50_assumed");
  EXPECT_EQ(survey.info->date, "2026-05-04");
  const FileT design = node.output<File>("design_file");
  EXPECT_EQ(design.name, "design.ifc");
  EXPECT_EQ(design.sha256, runtime::sha256_of_file(folder_.path() / "design.ifc"));
  EXPECT_EQ(design.uri, "sha256:" + design.sha256 + "/design.ifc");
}

TEST_F(ReadCampaignTest, GivesTheTableOfToleranceClassesAndTellsWhatIsWrongWithIt) {
  std::ofstream(folder_.path() / "campaign.yaml", std::ios::app) << "tolerances: limits.csv\n";
  std::ofstream(folder_.path() / "limits.csv") << "class,select,vertical_mm,joint_mm\nA,*,3,\n";
  for (const char* kind : {"read.campaign", "read.measured_campaign"}) {
    NodeHarness node(kind);
    node.input<Folder>("folder", list(folder_.path()));
    node.run();
    const FileT table = node.output<File>("tolerances");
    EXPECT_EQ(table.name, "limits.csv");
    EXPECT_EQ(std::string(table.content.begin(), table.content.end()), "class,select,vertical_mm,joint_mm\nA,*,3,\n");
    bool read = false;
    for (const auto& file : node.output<InputFiles>("inputs").files)
      read = read || (file->path == "limits.csv" && file->use == "tolerances");
    EXPECT_TRUE(read) << "it counts as read, with its hash";
  }
  std::ofstream(folder_.path() / "limits.csv") << "class,select,vertical_mm,joint_mm\nA,*,3 or 4,\n";
  EXPECT_NE(message().find("limits.csv:2: column 'vertical_mm' is '3 or 4'"), std::string::npos) << message();
}

TEST_F(ReadCampaignTest, SurveyCampaignNeedsNothingButSurveyFiles) {
  for (const char* gone : {"plates.csv", "camera.yaml", "design.ifc"}) fs::remove(folder_.path() / gone);
  fs::remove_all(folder_.path() / "images");
  std::ofstream(folder_.path() / "campaign.yaml") << "plumbline_campaign: 1\nname: Tower\nsurvey: survey/*\ncontrol: "
                                                     "control.csv\ninstrument: total_station_1arcsec\n";
  NodeHarness node("read.survey_campaign");
  node.input<Folder>("folder", list(folder_.path()));
  node.run();
  EXPECT_EQ(node.output<Points>("control").points.size(), 4u);
  const SurveyObservationsT survey = node.output<SurveyObservations>("survey");
  EXPECT_EQ(survey.observations.size(), campaign_.observations.observations.size());
  EXPECT_EQ(survey.info->instrument, "total_station_1arcsec");
  EXPECT_EQ(survey.info->title, "Tower");
  EXPECT_NE(message().find("the key 'images' is missing"), std::string::npos) << message();
}

/// `campaign check` said nothing of an instrument without a profile, and the run warned.
TEST_F(ReadCampaignTest, AnInstrumentWithoutAProfileIsToldBeforeTheRun) {
  SurveyObservationsT survey;
  survey.info = std::make_unique<SurveyInfoT>();
  survey.info->instrument = "Leica TS60", survey.instruments = {"S9", "total_station_1arcsec"};
  const auto told_of = [](const SurveyObservationsT& read) {
    NodeHarness node("campaign.account");
    node.input<InputFiles>("inputs", InputFilesT());
    node.input<InputFiles>("unread", InputFilesT());
    node.input<SurveyObservations>("survey", read);
    node.run();
    return node.warnings();
  };
  const std::vector<std::string> told = told_of(survey);
  ASSERT_EQ(told.size(), 2u);
  EXPECT_NE(told[0].find("'Leica TS60', of which there is no profile; ics50_assumed is used"), std::string::npos);
  EXPECT_NE(told[1].find("the instrument S9"), std::string::npos);
  survey.info->instrument = "ics50_assumed", survey.instruments.clear();
  EXPECT_EQ(told_of(survey), std::vector<std::string>());
}

TEST_F(ReadCampaignTest, APhotographThatIsThereTwiceIsToldBeforeTheRun) {
  const auto told_of = [](const std::vector<std::string>& hashes) {
    InputFilesT files;
    for (const std::string& hash : hashes) {
      files.files.push_back(std::make_unique<InputFileT>());
      files.files.back()->path = std::to_string(files.files.size()) + ".jpg", files.files.back()->sha256 = hash;
      files.files.back()->use = "photograph", files.files.back()->read = true;
    }
    NodeHarness node("campaign.account");
    node.input<InputFiles>("inputs", files);
    node.input<InputFiles>("unread", InputFilesT());
    node.run();
    return node.warnings();
  };
  EXPECT_EQ(told_of({"a", "b"}), std::vector<std::string>());
  EXPECT_EQ(told_of({"a", "b", "a"}),
            std::vector<std::string>{"1.jpg and 3.jpg are the same photograph, which counts twice; take one away"});
  EXPECT_EQ(told_of({"a", "b", "a", "b"}).at(0).substr(0, 37), "2 photographs are there a second time");
}

/// Of a folder as simulated, `change`d: the first line, all warnings or the error.
std::string account_of(const FolderT& folder, const std::function<void(PointsT&, PlatesT&)>& change,
                       const std::vector<std::string>& designed = {}, const std::string& families = "") {
  NodeHarness read("read.campaign"), node("campaign.account");
  read.input<Folder>("folder", folder);
  read.run();
  PointsT control = read.output<Points>("control");
  PlatesT plates = read.output<Plates>("plates");
  change(control, plates);
  node.input<InputFiles>("inputs", read.output<InputFiles>("inputs"));
  node.input<InputFiles>("unread", read.output<InputFiles>("unread"));
  node.input<SurveyObservations>("survey", read.output<SurveyObservations>("survey"));
  node.input<Points>("control", control);
  node.input<Plates>("plates", plates);
  if (!families.empty()) node.set("families", families);
  ElementMatchesT matches;
  for (const std::string& anchor : designed) {
    matches.matches.push_back(std::make_unique<ElementMatchT>());
    matches.matches.back()->anchor = anchor, matches.matches.back()->guid = "0aBcDeFgHiJkLmNoPqRsTu";
    matches.matches.back()->position.setZero(), matches.matches.back()->target_offset.setZero();
  }
  node.input<ElementMatches>("matches", matches);
  try {
    node.run();
  } catch (const NodeFailed& error) {
    return error.what();
  }
  const FileT file = node.output<File>("summary");
  std::string said(file.content.begin(), file.content.end());
  said = said.substr(0, said.find('\n'));
  for (const std::string& warning : node.warnings()) said += "\n" + warning;
  return said;
}

/// "The folder is whole" where the run had to fail, or went on without an anchor.
TEST_F(ReadCampaignTest, NamesAreHeldAgainstEachOther) {
  const FolderT folder = list(folder_.path());
  const auto told = [&](const auto& change) { return account_of(folder, change); };
  EXPECT_EQ(told([](PointsT&, PlatesT&) {}), "The folder is whole.");
  const std::string control = told([](PointsT& points, PlatesT&) {
    for (auto& point : points.points) point->id[0] = 'H';
  });
  EXPECT_NE(control.find("none of the control points (H1, H2"), std::string::npos) << control;
  const std::string alike = told([](PointsT& points, PlatesT&) { points.points[0]->id = "G-01"; });
  EXPECT_EQ(alike.find("The folder is whole."), 0u)
      << "two names that are alike may be two marks, and other control is measured: " << alike;
  const std::string all_alike = told([](PointsT& points, PlatesT&) {
    for (auto& point : points.points) point->id.insert(1, "-0");
  });
  EXPECT_NE(all_alike.find("none of the control points (G-01"), std::string::npos) << all_alike;
  const auto rename = [](PointsT&, PlatesT& plates) { plates.plates[1]->anchor = "F01-K9"; };
  const std::string anchor = told(rename);
  EXPECT_NE(anchor.find("nor the design have these anchors of the plate table: F01-K9;"), std::string::npos) << anchor;
  const std::string designed = account_of(folder, rename, {"F01-K9"});
  EXPECT_EQ(designed.find("The folder is whole.\nneither the readings nor the control have these anchors of the plate "
                          "table: F01-K9; photographs alone measure them"),
            0u)
      << designed;
  const auto other_family = [](PointsT&, PlatesT& plates) {
    for (auto& plate : plates.plates) plate->tag_family = "tag36h10";
  };
  const std::string family = told(other_family);
  EXPECT_NE(family.find("tags of tag36h10, and a run looks for tag36h11 alone"), std::string::npos) << family;
  const std::string both = told([&](PointsT& points, PlatesT& plates) {
    for (auto& point : points.points) point->id[0] = 'H';
    other_family(points, plates);
  });
  EXPECT_NE(both.find("none of the control points"), std::string::npos) << both;
  EXPECT_NE(both.find("tags of tag36h10"), std::string::npos) << "all that is wrong at once: " << both;
  EXPECT_EQ(account_of(folder, other_family, {}, "tag36h10"), "The folder is whole.");
}

TEST_F(ReadCampaignTest, WhatIsAssumedOfControlGoesWithTheReadings) {
  std::ofstream(folder_.path() / "control.csv") << "id,X,Y,Z\nG1,4500000.5,5300000.25,3\nG2,4500010.5,5300010.25,3\n";
  NodeHarness node("read.campaign");
  node.input<Folder>("folder", list(folder_.path()));
  node.run();
  const SurveyObservationsT survey = node.output<SurveyObservations>("survey");
  std::string all;
  for (const std::string& warning : survey.warnings) all += warning + "\n";
  EXPECT_NE(all.find("control.csv: no standard deviations: 1 mm in E, N and H is assumed"), std::string::npos) << all;
  EXPECT_NE(all.find("X = east and Y = north"), std::string::npos) << all;
}

TEST_F(ReadCampaignTest, TruncatedPhotographIsNamed) {
  const fs::path image = folder_.path() / "images/F01-03.jpg";
  fs::resize_file(image, fs::file_size(image) / 2);
  EXPECT_NE(message().find("F01-03.jpg: the JPEG is truncated"), std::string::npos) << message();
  EXPECT_NE(message().find("leave it out by 'unused'"), std::string::npos) << message();
}

TEST_F(ReadCampaignTest, MissingFilesAreNamed) {
  fs::remove(folder_.path() / "plates.csv");
  EXPECT_NE(message().find("'plates' names 'plates.csv'"), std::string::npos);
  fs::remove(folder_.path() / "campaign.yaml");
  EXPECT_NE(message().find("campaign.yaml: this file is missing"), std::string::npos);
}

TEST_F(ReadCampaignTest, PhotographOfAnotherSizeIsRefused) {
  std::string yaml = read_file(folder_.path() / "camera.yaml");
  yaml.replace(yaml.find("width: 600"), 10, "width: 640");
  std::ofstream(folder_.path() / "camera.yaml") << yaml;
  EXPECT_NE(message().find("was calibrated with 640 x 400"), std::string::npos);
}

TEST_F(ReadCampaignTest, SeveralCamerasTakeTheirOwnPhotographs) {
  const fs::path& root = folder_.path();
  std::string yaml = read_file(root / "camera.yaml");
  const std::size_t at = yaml.find("id: ") + 4;
  const std::string id = yaml.substr(at, yaml.find('\n', at) - at);
  std::ofstream(root / "second.yaml") << yaml.replace(at, id.size(), "second");
  std::string campaign = read_file(root / "campaign.yaml");
  const std::size_t images = campaign.find("images:");
  campaign.erase(images, campaign.find('\n', images) + 1 - images);
  const std::size_t camera = campaign.find("camera: camera.yaml");
  ASSERT_NE(camera, std::string::npos) << campaign;
  campaign.replace(camera, 19,
                   "camera:\n  camera.yaml: images/F01-0[12].jpg\n"
                   "  second.yaml: [images/F01-03.jpg, images/F01-04.jpg]");
  std::ofstream(root / "campaign.yaml") << campaign;
  EXPECT_NE(message().find("names 'images/F01-0[12].jpg'"), std::string::npos) << message();
  campaign.replace(campaign.find("images/F01-0[12].jpg"), 20, "[images/F01-01.jpg, images/F01-02.jpg]");
  std::ofstream(root / "campaign.yaml") << campaign;
  NodeHarness node("read.campaign");
  node.input<Folder>("folder", list(root));
  node.run();
  const CameraT both = node.output<Camera>("camera");
  EXPECT_EQ(both.id, id);
  ASSERT_EQ(both.others.size(), 1u);
  EXPECT_EQ(both.others[0]->id, "second");
  ASSERT_EQ(node.output_count("images"), 4u);
  EXPECT_EQ(node.output<Image>("images", 1).camera, id);
  EXPECT_EQ(node.output<Image>("images", 2).camera, "second");
  std::ofstream(root / "second.yaml") << read_file(root / "camera.yaml");
  EXPECT_NE(message().find("second.yaml: its id '" + id + "' is that of camera.yaml too"), std::string::npos)
      << message();
}

TEST(SimulateObservations, DeliversCornersPointsAndTruthOfOneSite) {
  NodeHarness node("simulate.observations");
  node.set("floors", "2");
  node.set("pixel_sigma", "0");
  node.set("survey_sigma", "0.002");
  node.run();
  EXPECT_EQ(node.output_count("observations"), 20u);
  EXPECT_TRUE(node.output<ImageTags>("observations", 0).tags.at(0)->corner_covariances.empty());
  const PointsT points = node.output<Points>("points"), truth = node.output<Points>("truth");
  ASSERT_EQ(points.points.size(), 22u);
  EXPECT_EQ(points.covariance.size(), 66u * 67u / 2);
  double sum = 0;
  for (std::size_t i = 0; i < 22; ++i) {
    EXPECT_EQ(points.points[i]->id, truth.points[i]->id);
    sum += (points.points[i]->position - truth.points[i]->position).squaredNorm();
  }
  EXPECT_NEAR(std::sqrt(sum / 66), 0.002, 0.002 * 4 / std::sqrt(132.0));
}

TEST(SimulateObservations, ADifferentSeedIsADifferentSite) {
  NodeHarness a("simulate.observations"), b("simulate.observations"), c("simulate.observations");
  b.seed(2);
  a.run(), b.run(), c.run();
  EXPECT_NE(a.output_bytes("observations"), b.output_bytes("observations"));
  EXPECT_EQ(a.output_bytes("observations"), c.output_bytes("observations"));
}

}  // namespace test_campaign_nodes
}  // namespace plumbline::test
