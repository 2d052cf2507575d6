#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <functional>
#include <numbers>
#include <set>
#include <string>

#include "campaign_folder.hpp"
#include "whole_design.hpp"

namespace plumbline::campaign {
namespace test_campaign_folder {

std::string message_of(const std::function<void()>& call) {
  try {
    call();
  } catch (const CampaignError& error) {
    return error.what();
  }
  return "nothing was thrown";
}

const std::vector<std::string> kFiles = {"campaign.yaml", "c.yaml",    "p.csv",         "k.csv",    "d.ifc",
                                         "img/b.jpg",     "img/a.jpg", "img/raw/x.jpg", "ts/1.gsi", "ts/2.gsi"};
const std::string kCampaign =
    "plumbline_campaign: 1\nimages: img/*.jpg\ncamera: c.yaml\nplates: p.csv\nsurvey: [ts/2.gsi, ts/*.gsi]\n"
    "control: k.csv\ndesign: d.ifc\n";

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  if (at == std::string::npos) throw std::logic_error("the test's text has no " + from);
  return text.replace(at, from.size(), to);
}
std::string campaign_message(const std::string& yaml) {
  return message_of([&] { parse_campaign(yaml, "site/campaign.yaml", kFiles); });
}

/// A quaternion of zeros is no rotation; normalised it was one of nan, and nobody was told.
TEST(TrueCameras, OfNoRotationAreRefusedWithTheirLine) {
  const std::string header = "image,w,x,y,z,tx_m,ty_m,tz_m\n", sound = "a.jpg,0.6,0,0.8,0,1,2,3\n";
  const auto cameras = parse_true_cameras(header + sound, "cameras.csv");
  ASSERT_EQ(cameras.size(), 1u);
  EXPECT_NEAR(cameras[0].camera_from_building.rotation.y(), 0.8, 1e-15);
  for (const char* wrong : {"b.jpg,0,0,0,0,1,2,3\n", "b.jpg,1,1,0,0,1,2,3\n", "b.jpg,0.9,0,0,0,1,2,3\n"}) {
    std::string told;
    try {
      parse_true_cameras(header + sound + wrong, "cameras.csv");
    } catch (const std::runtime_error& error) {
      told = error.what();
    }
    for (const char* part : {"cameras.csv:3", "'b.jpg'", "expected 1"})
      EXPECT_NE(told.find(part), std::string::npos) << wrong << ": " << told;
  }
}

TEST(CampaignYaml, ResolvesPatternsInOrder) {
  const CampaignDescription c = parse_campaign(kCampaign, "campaign.yaml", kFiles);
  EXPECT_EQ(c.images, (std::vector<std::string>{"img/a.jpg", "img/b.jpg"}));  // '*' does not enter folders
  EXPECT_EQ(c.survey, (std::vector<std::string>{"ts/1.gsi", "ts/2.gsi"}));
  EXPECT_EQ(c.control, "k.csv");
}

TEST(CampaignYaml, TheTableOfToleranceClassesIsAFileOfTheFolder) {
  std::vector<std::string> files = kFiles;
  files.push_back("tolerances.csv");
  const std::string yaml = kCampaign + "tolerances: tolerances.csv\n";
  for (const CampaignUse use : {CampaignUse::site, CampaignUse::measured}) {
    EXPECT_EQ(parse_campaign(yaml, "campaign.yaml", files, use).tolerances, "tolerances.csv");
    EXPECT_EQ(parse_campaign(kCampaign, "campaign.yaml", files, use).tolerances, "");
  }
  EXPECT_NE(campaign_message(yaml).find("'tolerances' names 'tolerances.csv', and the folder has no such file"),
            std::string::npos)
      << campaign_message(yaml);
}

/// Epochs m1, m10, m2: a movement went to and fro, and an alarm was missed.
TEST(CampaignYaml, APatternOfEpochsIsInTheOrderInWhichPeopleCount) {
  const std::vector<std::string> files = {"m1.csv", "m10.csv", "m2.csv", "m010b.csv", "M3.csv", "m9/x.csv"};
  const auto epochs = [&](const std::string& survey) {
    const std::string yaml = "plumbline_campaign: 1\nsurvey: " + survey + "\n";
    return parse_campaign(yaml, "campaign.yaml", files, CampaignUse::survey).survey_in_order;
  };
  EXPECT_EQ(epochs("\"?*.csv\""), (std::vector<std::string>{"m1.csv", "m2.csv", "M3.csv", "m10.csv", "m010b.csv"}));
  EXPECT_EQ(epochs("[m10.csv, \"m?.csv\"]"), (std::vector<std::string>{"m10.csv", "m1.csv", "m2.csv"}));
}

TEST(CampaignYaml, PhotographsNeedASurveyButNeitherDesignNorCalibration) {
  const auto use = CampaignUse::photographs;
  const std::string yaml = "plumbline_campaign: 1\nimages: img/*.jpg\ncontrol: k.csv\n";
  const CampaignDescription c = parse_campaign(yaml, "campaign.yaml", kFiles, use);
  EXPECT_EQ(c.control, "k.csv");
  EXPECT_TRUE(c.cameras.empty() && c.plates.empty() && c.design.empty() && c.survey.empty());
  EXPECT_EQ(parse_campaign(kCampaign, "campaign.yaml", kFiles, use).plates, "p.csv") << "what is there is taken";
  EXPECT_EQ(message_of([&] { parse_campaign(replaced(yaml, "control: k.csv\n", ""), "c.yaml", kFiles, use); }),
            "c.yaml: found neither 'survey' nor 'control': where the points are, nothing says");
  EXPECT_NE(message_of([&] {
              parse_campaign(yaml, "c.yaml", kFiles);
            }).find("a list of coordinates that somebody measured is a survey, too"),
            std::string::npos);
  const CampaignDescription found =
      find_campaign("site", {"survey/b.gsi", "camera.yaml", "x/2.JPG", "1.png", "notes.txt", "control.csv"});
  EXPECT_EQ(found.images, (std::vector<std::string>{"1.png", "x/2.JPG"}));
  EXPECT_EQ(found.survey, std::vector<std::string>{"survey/b.gsi"});
  ASSERT_EQ(found.cameras.size(), 1u);
  EXPECT_EQ(found.cameras[0].file + found.control + found.plates, "camera.yamlcontrol.csv");
  EXPECT_NE(message_of([&] { find_campaign("site", {"1.png"}); }).find("no survey files in survey/ and no control.csv"),
            std::string::npos);
}

const std::vector<std::string> kTwoCameras = {"l.yaml",     "r.yaml",     "p.csv",       "k.csv", "d.ifc",
                                              "left/b.jpg", "left/a.jpg", "right/a.jpg", "t.gsi", "obs.csv"};
const std::string kOfTwoCameras =
    "plumbline_campaign: 1\ncamera:\n  r.yaml: [right/*.jpg]\n  l.yaml: left/*.jpg\nplates: p.csv\nsurvey: t.gsi\n"
    "design: d.ifc\n";

TEST(CampaignYaml, SeveralCamerasSayWhosePhotographsAreWhose) {
  const CampaignDescription c = parse_campaign(kOfTwoCameras, "campaign.yaml", kTwoCameras);
  EXPECT_EQ(c.images, (std::vector<std::string>{"left/a.jpg", "left/b.jpg", "right/a.jpg"}));
  ASSERT_EQ(c.cameras.size(), 2u);
  EXPECT_EQ(c.cameras[0].file, "r.yaml");
  EXPECT_EQ(c.cameras[1].patterns, std::vector<std::string>{"left/*.jpg"});
  const auto message = [&](const std::string& from, const std::string& to) {
    return message_of([&] { parse_campaign(replaced(kOfTwoCameras, from, to), "c.yaml", kTwoCameras); });
  };
  EXPECT_NE(message("plates", "images: left/*.jpg\nplates").find("c.yaml:3: 'camera' says which photographs"),
            std::string::npos);
  EXPECT_NE(message("[right/*.jpg]", "[right/*.jpg, left/a.jpg]").find("'left/a.jpg' is named for two cameras"),
            std::string::npos);
  EXPECT_NE(message("r.yaml: [", "q.yaml: [").find("c.yaml:3: 'camera' names 'q.yaml', and the folder has no such"),
            std::string::npos);
  EXPECT_NE(message("r.yaml: [", "?.yaml: [").find("c.yaml:3: '?.yaml' matches 2 files, expected one"),
            std::string::npos);
  EXPECT_NE(message("r.yaml: [", "l.yaml: [").find("c.yaml:4: "), std::string::npos);
  EXPECT_NE(message("[right/*.jpg]", "[]").find("no photographs are named for r.yaml"), std::string::npos);
  EXPECT_NE(message("[right/*.jpg]", "right/*.png").find("'camera' names 'right/*.png'"), std::string::npos);
  EXPECT_NE(message("[right/*.jpg]", "{a: b}").find("expected photographs of r.yaml"), std::string::npos);
}

TEST(CampaignYaml, PhotographsAndTheirSurveyTakeSeveralCamerasFromOneFile) {
  const std::string said =
      message_of([] { parse_campaign(kOfTwoCameras, "c.yaml", kTwoCameras, CampaignUse::photographs); });
  EXPECT_NE(said.find("several cameras are one camera.yaml here"), std::string::npos) << said;
}

TEST(CampaignYaml, TagsOfSeveralCamerasAreMatchedByTheNamesOfTheirImages) {
  const CampaignDescription c =
      parse_campaign(replaced(kOfTwoCameras, "plates", "observations: obs.csv\nplates"), "campaign.yaml", kTwoCameras);
  EXPECT_TRUE(c.images.empty()) << "photographs need not be there";
  EXPECT_EQ(c.cameras.size(), 2u);
}

TEST(CampaignYaml, ErrorsNameFileLineAndMend) {
  EXPECT_EQ(campaign_message(replaced(kCampaign, "plates", "plate")),
            "site/campaign.yaml:4: unknown key 'plate', did you mean 'plates'?");
  EXPECT_NE(
      campaign_message(kCampaign + "weather: fine\n").find("site/campaign.yaml:8: unknown key 'weather'; known are"),
      std::string::npos);
  EXPECT_NE(
      campaign_message(replaced(kCampaign, "d.ifc", "e.ifc")).find(":7: 'design' names 'e.ifc', and the folder has no"),
      std::string::npos);
  EXPECT_NE(campaign_message(replaced(kCampaign, "*.jpg", "*.tif")).find(":2: 'images' names 'img/*.tif'"),
            std::string::npos);
  EXPECT_NE(campaign_message(replaced(kCampaign, "camera: c.yaml\n", "")).find("the key 'camera' is missing"),
            std::string::npos);
  EXPECT_NE(campaign_message(kCampaign + "design: d.ifc\n").find(":8: 'design' stands here a second time"),
            std::string::npos);
  EXPECT_NE(campaign_message(replaced(kCampaign, "camera: c.yaml", "camera: img/*.jpg")).find("matches 2 files"),
            std::string::npos);
  EXPECT_NE(
      campaign_message(replaced(kCampaign, "campaign: 1", "campaign: 9")).find(":1: this program reads version 1"),
      std::string::npos);
  EXPECT_NE(campaign_message("a: [1\n").find("this is no YAML"), std::string::npos);
  EXPECT_NE(campaign_message(kCampaign + "[a, b]: c\n").find(":8: a key must be a single word"), std::string::npos);
  EXPECT_NE(campaign_message("just text").find("found no mapping"), std::string::npos);
}

TEST(CampaignYaml, AllThatIsWrongIsToldAtOnce) {
  std::string yaml = replaced(kCampaign, "plates", "plate");
  yaml = replaced(replaced(yaml, "d.ifc", "e.ifc"), "[ts/2.gsi, ts/*.gsi]", "[ts/3.gsi, ts/4.gsi]");
  EXPECT_EQ(campaign_message(yaml),
            "site/campaign.yaml:4: unknown key 'plate', did you mean 'plates'?\n"
            "site/campaign.yaml:5: 'survey' names 'ts/3.gsi', and the folder has no such file; paths are relative to "
            "campaign.yaml\n"
            "site/campaign.yaml:5: 'survey' names 'ts/4.gsi', and the folder has no such file; paths are relative to "
            "campaign.yaml\n"
            "site/campaign.yaml:7: 'design' names 'e.ifc', and the folder has no such file; paths are relative to "
            "campaign.yaml");
}

TEST(CampaignYaml, PatternsMayEnterFoldersAndPassOverWhatIsUnused) {
  const std::string yaml = replaced(kCampaign, "img/*.jpg", "\"img/**/*.jpg\"") + "unused: [img/b.jpg, \"no/**\"]\n";
  const CampaignDescription c = parse_campaign(yaml, "campaign.yaml", kFiles);
  EXPECT_EQ(c.images, (std::vector<std::string>{"img/a.jpg", "img/raw/x.jpg"}));
  EXPECT_EQ(c.unused, std::vector<std::string>{"img/b.jpg"});
  ASSERT_EQ(c.remarks.size(), 1u);
  EXPECT_NE(c.remarks[0].find(":8: 'unused' names 'no/**', which fits nothing here"), std::string::npos)
      << c.remarks[0];
  EXPECT_NE(
      campaign_message(kCampaign + "unused: gone.jpg\n").find(":8: 'unused' names 'gone.jpg', and the folder has"),
      std::string::npos);
  EXPECT_NE(campaign_message(kCampaign + "unused: k.csv\n").find("'control' names 'k.csv', and 'unused' names it too"),
            std::string::npos);
  EXPECT_TRUE(matches_pattern("a/**", "a/b/c.jpg"));
  EXPECT_TRUE(matches_pattern("**.JPG", "a/b/c.JPG"));
  EXPECT_FALSE(matches_pattern("a/**/c", "a/b/cc"));
  EXPECT_TRUE(matches_pattern("S?d.csv",
                              "Su\xCC\x88"
                              "d.csv"))
      << "u and a mark are one character";
}

/// "4.5.2026" went into the provenance as it stood, "gestern" too.
TEST(CampaignYaml, ADateIsADay) {
  const auto date_of = [](const std::string& date) {
    return parse_campaign(kCampaign + "date: " + date + "\n", "campaign.yaml", kFiles);
  };
  EXPECT_EQ(date_of("2026-05-04").date, "2026-05-04");
  EXPECT_EQ(date_of("2026-5-4").date, "2026-05-04");
  EXPECT_EQ(date_of("2026-05-04T10:30:00+02:00").date, "2026-05-04T10:30:00+02:00");
  EXPECT_EQ(date_of("2026:05:04 10:30:15").date, "2026-05-04T10:30:15");
  EXPECT_EQ(date_of("2026-05-04").date_remark, "");
  EXPECT_EQ(date_of("13.5.2026").date, "2026-05-13");
  EXPECT_EQ(date_of("13.5.2026").date_remark, "");  // no month has the number 13
  EXPECT_EQ(date_of("4.5.2026").date, "2026-05-04");
  EXPECT_NE(date_of("04.05.2026").date_remark.find("day.month.year: 2026-05-04"), std::string::npos);
  for (const char* wrong : {"05/04/2026", "4.5.26", "31.4.2026", "2026-02-29", "gestern", "2026", "2026-05-04x",
                            "2026-05-04T25:00", "2026-05/04", "-4.5.2026", "4. Mai 2026"}) {
    const std::string told = campaign_message(kCampaign + "date: \"" + wrong + "\"\n");
    for (const char* part : {"site/campaign.yaml:8", wrong, "2026-05-12 (year-month-day) or 12.05.2026"})
      EXPECT_NE(told.find(part), std::string::npos) << wrong << ": " << told;
  }
}

TEST(CampaignYaml, PhotographsAloneNeedNoSurveyAndTakeNone) {
  const std::string alone = "plumbline_campaign: 1\nimages: img/*.jpg\ncamera: c.yaml\nplates: p.csv\ndesign: d.ifc\n";
  const CampaignDescription c = parse_campaign(alone, "campaign.yaml", kFiles, CampaignUse::alone);
  EXPECT_EQ(c.images.size(), 2u);
  EXPECT_EQ(c.design, "d.ifc");
  EXPECT_NE(message_of([&] {
              parse_campaign(kCampaign, "campaign.yaml", kFiles, CampaignUse::alone);
            }).find("plumbline run site_campaign"),
            std::string::npos)
      << "evidence is not left out in silence";
  EXPECT_NE(message_of([&] { parse_campaign(alone, "campaign.yaml", kFiles); }).find("survey"), std::string::npos);
}

TEST(CampaignYaml, WhatIsWholeForSomethingElseIsToldSo) {
  EXPECT_NE(campaign_message("plumbline_campaign: 1\nsurvey: ts/*.gsi\n").find("run survey_campaign"),
            std::string::npos);
  EXPECT_NE(campaign_message("plumbline_campaign: 1\nsurvey: ts/*.gsi\nplates: p.csv\ndesign: d.ifc\n")
                .find("run site_survey"),
            std::string::npos);
  EXPECT_NE(campaign_message("plumbline_campaign: 1\nsurvey: ts/*.gsi\nimages: img/*.jpg\n").find("run photo_campaign"),
            std::string::npos);
  EXPECT_NE(campaign_message("plumbline_campaign: 1\nimages: img/*.jpg\ncamera: c.yaml\nplates: p.csv\ndesign: d.ifc\n")
                .find("run site_photographs"),
            std::string::npos);
  EXPECT_EQ(campaign_message(replaced(kCampaign, "images", "imaegs")).find("as it is"), std::string::npos);
}

TEST(CampaignYaml, ANameInOtherCaseIsShown) {
  EXPECT_NE(campaign_message(replaced(kCampaign, "p.csv", "P.CSV")).find("upper and lower case differ: there is p.csv"),
            std::string::npos);
}

const std::string kCamera =
    "plumbline_camera: 1\nid: c\nwidth: 600\nheight: 400\npixel_origin: centre\nparameters: {fx: 500, fy: 501, cx: "
    "300, cy: "
    "200, k1: -0.1}\nsigmas: {fx: 1, cx: 0.5}\n";
std::string camera_message(const std::string& yaml) {
  return message_of([&] { parse_camera(yaml, "c.yaml"); });
}

TEST(CameraYaml, ReadsParametersAndSigmas) {
  const CameraCalibration c = parse_camera(kCamera, "c.yaml");
  EXPECT_EQ(c.camera.fy, 501);
  EXPECT_EQ(c.camera.k1, -0.1);
  EXPECT_EQ(c.camera.p2, 0);
  EXPECT_EQ(c.sigmas[2], 0.5);
  EXPECT_EQ(c.sigmas[4], 0);
  EXPECT_TRUE(std::isnan(c.pixel_pitch));
}

TEST(CameraYaml, CorrelationsBelongToTheCovariance) {
  const std::string text = kCamera + "correlations: {cx: [0.8, 0]}\n";
  const CameraCalibration c = parse_camera(text, "c.yaml");
  ASSERT_EQ(c.covariance.rows(), 9);
  EXPECT_DOUBLE_EQ(c.covariance(0, 0), 1);
  EXPECT_DOUBLE_EQ(c.covariance(2, 0), 0.4);
  EXPECT_DOUBLE_EQ(c.covariance(0, 2), 0.4);
  EXPECT_EQ(c.covariance(1, 1), 0) << "exact";
  EXPECT_NE(camera_message(kCamera + "correlations: {cx: [0.8]}\n").find("the correlations of cx are 1 numbers"),
            std::string::npos);
  EXPECT_NE(camera_message(kCamera + "correlations: {cx: [much, 0]}\n").find("a list of numbers"), std::string::npos);
  EXPECT_EQ(parse_camera(replaced(kCamera, "sigmas: {fx: 1, cx: 0.5}", ""), "c.yaml").covariance.size(), 0);
}

TEST(CameraYaml, CornerOriginIsShiftedByHalfAPixel) {
  const CameraCalibration c = parse_camera(replaced(kCamera, "centre", "corner"), "c.yaml");
  EXPECT_EQ(c.camera.cx, 299.5);
  EXPECT_EQ(c.camera.cy, 199.5);
}

TEST(CameraYaml, ErrorsNameFileLineAndMend) {
  EXPECT_EQ(camera_message(replaced(kCamera, "width: 600", "width: wide")),
            "c.yaml:3: 'width' is 'wide', expected a whole number of pixels");
  EXPECT_NE(
      camera_message(replaced(kCamera, "centre", "middle")).find(":5: 'pixel_origin' is 'middle', expected 'centre'"),
      std::string::npos);
  EXPECT_NE(camera_message(replaced(kCamera, "k1", "k9")).find("unknown key 'k9'"), std::string::npos);
  EXPECT_NE(camera_message(replaced(kCamera, "fx: 500", "fx: -500")).find("fx and fy must be positive"),
            std::string::npos);
  EXPECT_NE(camera_message(replaced(kCamera, "cx: 0.5", "cx: -1")).find("negative"), std::string::npos);
}

const std::string kPlates =
    "anchor,role,floor,column,row,tag_family,tag_id,tag_size_mm,tag_x_mm,tag_y_mm,tag_z_mm,facing_azimuth_deg,batch\n"
    "B,check,1,0,0,tag36h11,2,200,0,200,0,180,x\n"
    "A,control,1,1,1,tag36h11,1,200,0,200,0,180,x\n";
std::string plates_message(const std::string& csv) {
  return message_of([&] { parse_plates(csv, "p.csv"); });
}

TEST(PlatesCsv, ReadsUnitsFromTheHeader) {
  const auto plates = parse_plates(kPlates, "p.csv");
  ASSERT_EQ(plates.size(), 2u);
  EXPECT_EQ(plates[0].anchor, "A");
  EXPECT_EQ(plates[0].tag_id, 1);
  EXPECT_DOUBLE_EQ(plates[0].tag_size, 0.2);
  EXPECT_DOUBLE_EQ(plates[1].tag_centre_in_plate.y(), 0.2);
  EXPECT_DOUBLE_EQ(plates[1].facing_azimuth, std::numbers::pi);
  EXPECT_TRUE(plates[0].mounting_sigma.array().isNaN().all());
}

TEST(PlatesCsv, TakesHowPlatesAreMountedOnAllThreeAxesOrNone) {
  std::string csv =
      "anchor,role,floor,tag_family,tag_id,tag_size_mm,tag_x_mm,tag_y_mm,tag_z_mm,facing_azimuth_deg,"
      "mounting_x_mm,mounting_y_mm,mounting_z_mm\nA,control,1,tag36h11,1,200,0,200,0,180,0.2,0.3,1\n";
  EXPECT_LT((parse_plates(csv, "p.csv")[0].mounting_sigma - Eigen::Vector3d(0.0002, 0.0003, 0.001)).norm(), 1e-15);
  EXPECT_NE(plates_message(replaced(csv, "0.2,0.3,1", "0.2,-0.3,1")).find("p.csv:2"), std::string::npos);
  EXPECT_NE(plates_message(replaced(replaced(csv, ",mounting_z_mm", ""), "0.3,1", "0.3")).find("all three or none"),
            std::string::npos);
}

TEST(PlatesCsv, OfPhotographsNeedOnlyNamesAndTags) {
  const std::string csv = "anchor,tag_family,tag_id\nP1,tag36h11,7\n";
  const auto plates = parse_plates(csv, "p.csv", CampaignUse::photographs);
  ASSERT_EQ(plates.size(), 1u);
  EXPECT_EQ(plates[0].role, "control");
  EXPECT_EQ(plates[0].floor, 1);
  EXPECT_TRUE(std::isnan(plates[0].tag_size));
  EXPECT_NE(plates_message(csv).find("the column 'role' is missing"), std::string::npos);
}

TEST(PlatesCsv, TakesSemicolonsAndDecimalCommas) {
  const auto plates = parse_plates(
      "anchor;role;floor;tag_family;tag_id;tag_size_m;tag_x_m;tag_y_m;tag_z_m;facing_azimuth_gon\n"
      "A;control;1;tag36h11;1;0,2;0,0;0,25;0,0;200,0\n",
      "p.csv");
  EXPECT_DOUBLE_EQ(plates.at(0).tag_centre_in_plate.y(), 0.25);
  EXPECT_DOUBLE_EQ(plates.at(0).facing_azimuth, std::numbers::pi);
}

TEST(PlatesCsv, ErrorsNameFileLineAndMend) {
  EXPECT_EQ(plates_message(replaced(kPlates, "tag_size_mm", "tag_size_ft")),
            "p.csv:1: column 'tag_size' is in 'ft', expected its name to end in _m or _mm");
  EXPECT_NE(plates_message(replaced(kPlates, "facing_azimuth_deg", "facing_azimuth")).find("has no unit"),
            std::string::npos);
  EXPECT_NE(plates_message(replaced(kPlates, "check", "chek"))
                .find("p.csv:2: column 'role' holds 'chek', expected control or"),
            std::string::npos);
  EXPECT_NE(plates_message(replaced(kPlates, "A,control", "B,control")).find("p.csv:3: anchor 'B' has a plate already"),
            std::string::npos);
  EXPECT_NE(plates_message(replaced(kPlates, "tag36h11,1,", "tag36h11,2,")).find("p.csv:3: tag 2 of tag36h11 hangs at"),
            std::string::npos);
  EXPECT_NE(
      plates_message(replaced(kPlates, ",200,0,200", ",big,0,200")).find("p.csv:2: column 'tag_size' holds 'big'"),
      std::string::npos);
  EXPECT_NE(plates_message(replaced(kPlates, "0,180,x\nA", "0\nA")).find("p.csv:2: found 11 cells, expected 13"),
            std::string::npos);
  EXPECT_NE(plates_message(replaced(kPlates, "batch", "bach")).find("unknown column 'bach'"), std::string::npos);
  EXPECT_NE(plates_message(replaced(kPlates, "tag_z_mm,", "")).find("the column 'tag_z' is missing"),
            std::string::npos);
  EXPECT_NE(plates_message("").find("no header line"), std::string::npos);
}

TEST(UprightPlate, FacesItsAzimuth) {
  for (const double azimuth : {0.0, 0.5, 3.0, 5.5}) {
    const Eigen::Quaterniond q = upright_plate(azimuth);
    EXPECT_LT((q * Eigen::Vector3d::UnitZ() - Eigen::Vector3d(std::sin(azimuth), std::cos(azimuth), 0)).norm(), 1e-12);
    EXPECT_LT((q * Eigen::Vector3d::UnitY() - Eigen::Vector3d::UnitZ()).norm(), 1e-12);
    EXPECT_NEAR(q.toRotationMatrix().determinant(), 1, 1e-12);
  }
}

TEST(ControlCsv, ReadsAndRefuses) {
  const std::string csv =
      "id,east_m,north_m,height_m,sigma_east_mm,sigma_north_mm,sigma_height_mm\nG1,1,2,3,0.5,0.5,1\nG2,4,5,6,1,1,1\n";
  const auto points = parse_control(csv, "k.csv");
  EXPECT_EQ(points[0].position, Eigen::Vector3d(1, 2, 3));
  EXPECT_DOUBLE_EQ(points[0].sigma.z(), 1e-3);
  const auto message = [&](const std::string& text) { return message_of([&] { parse_control(text, "k.csv"); }); };
  EXPECT_NE(message(replaced(csv, "G2", "G1")).find("k.csv:3: point 'G1' stands in it twice"), std::string::npos);
  EXPECT_NE(message(replaced(csv, "0.5,0.5,1", "0.5,0,1")).find("k.csv: 'G1' lacks a standard deviation above zero"),
            std::string::npos);
  for (const char* sigma : {"nan", "inf", "x"})
    EXPECT_NE(message(replaced(csv, "0.5,0.5,1", std::string(sigma) + ",0.5,1"))
                  .find("k.csv:2: 'sigma_east' is '" + std::string(sigma)),
              std::string::npos)
        << sigma;
  EXPECT_NE(message(replaced(csv, "0.5,0.5,1", "-1,0.5,1")).find("k.csv:2: point 'G1' has a negative"),
            std::string::npos);
  EXPECT_NE(message("id,e,n,h,sigma_n_mm\nG1,1,2,3,1\n").find("standard deviations are given for some"),
            std::string::npos)
      << "one that is given is not put aside for 1 mm";
  EXPECT_NE(message("id,E,N,H,Role\nG1,1,2,3,control\nG2,4,5,6,check\n").find("'G2' has the role 'check'"),
            std::string::npos)
      << "points that are to be withheld are no control";
  EXPECT_EQ(message("id,E,N,H,role\nG1,1,2,3,control\nG2,4,5,6,\n"), "nothing was thrown");
  EXPECT_NE(message(replaced(csv, "east_m", "east_km")).find("the column 'east' is in 'km'"), std::string::npos);
  EXPECT_NE(message(replaced(csv, "G2", "#G2")).find("k.csv:3: found a row that begins with '#G2'"), std::string::npos);
  EXPECT_NE(message(replaced(csv, ",1,1,1\n", ",,1,1\n")).find("k.csv:3: point 'G2' lacks a standard deviation"),
            std::string::npos);
}

TEST(ControlCsv, SpeaksTheDialectsOfSurveyCsv) {
  std::vector<std::string> warnings;
  const auto german =
      parse_control("Punktnummer;Rechtswert;Hochwert;H\xC3\xB6he\nG1;1,5;2,5;3,5\n", "k.csv", &warnings);
  EXPECT_EQ(german.at(0).position, Eigen::Vector3d(1.5, 2.5, 3.5));
  EXPECT_DOUBLE_EQ(german.at(0).sigma.x(), 1e-3);
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_NE(warnings[0].find("1 mm in E, N and H is assumed"), std::string::npos);
  warnings.clear();
  const auto penzd = parse_control("G1,1,2,3,bolt\nG2,4,5,6,\n", "k.csv", &warnings);
  EXPECT_EQ(penzd.at(1).position, Eigen::Vector3d(4, 5, 6));
  EXPECT_EQ(parse_control("id,E,N,H\n\"#7\",1,2,3\n# out of use: G9,1,2,3\n", "k.csv").at(0).name, "#7");
}

/// Anchors measured by total station have no tags; and who gives no azimuth says nothing of where they face.
TEST(Plates, OfAMeasuredCampaignNeedNoTagsAndMayKeepTheAzimuthToThemselves) {
  const auto plates = parse_plates("anchor,floor\nA1,1\nA2,2\n", "p.csv", CampaignUse::measured);
  ASSERT_EQ(plates.size(), 2u);
  EXPECT_EQ(plates[1].floor, 2);
  EXPECT_EQ(plates[0].role, "control");
  EXPECT_TRUE(std::isnan(plates[0].facing_azimuth)) << "north would be a lie";
  const auto told = parse_plates("anchor,floor,facing_azimuth_deg\nA1,1,90\n", "p.csv", CampaignUse::measured);
  EXPECT_NEAR(told[0].facing_azimuth, M_PI / 2, 1e-12);
  EXPECT_THROW(parse_plates("anchor,floor\nA1,1\n", "p.csv"), CampaignError) << "a site's table has tags";
  try {
    parse_plates("anchor,floor\nA1,-1\n", "p.csv", CampaignUse::measured);
    FAIL() << "a basement";
  } catch (const CampaignError& error) {
    EXPECT_NE(std::string(error.what()).find("floors are counted from the lowest, basements too"), std::string::npos)
        << error.what();
  }
}

/// "John's" in a comment turned what is a text inside out for the rest of the file.
TEST(WholeDesign, AnApostropheInACommentBeginsNoText) {
  const std::filesystem::path file = std::filesystem::temp_directory_path() / "plumbline_comment_of_a_design.ifc";
  std::ofstream(file)
      << "ISO-10303-21;\n/* John's plugin, 'A2' */\nDATA;\n#1=IFCPLATE('A1','/* no comment',$,'A4');/*'A5*/"
         "#2=IFCPLATE('A6');\n/* an end that is missing 'A3'";
  const std::set<std::string> found = names_that_may_be_in(file, {"A1", "A2", "A3", "A4", "A5", "A6"});
  std::filesystem::remove(file);
  EXPECT_EQ(found, (std::set<std::string>{"A1", "A4", "A6"}));
}

}  // namespace test_campaign_folder
}  // namespace plumbline::campaign
