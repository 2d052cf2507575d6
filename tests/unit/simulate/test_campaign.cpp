// The folder that the simulation writes: readable by the readers of a real site, valid, and the same for the same seed.
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <map>
#include <sstream>

#include "building/ifc/design.hpp"
#include "campaign.hpp"
#include "campaign_folder.hpp"
#include "design_ifc.hpp"
#include "express_schema.hpp"
#include "observations.hpp"
#include "photo/images/photograph_header.hpp"
#include "record.hpp"
#include "survey/files/survey_format.hpp"
#include "test_support.hpp"
#include "wings.hpp"

namespace plumbline::simulate {
namespace test_campaign {

namespace fs = std::filesystem;

/// A campaign whose camera takes 600 × 400 pixels: what is tested here does not depend on how many there are.
Campaign small_campaign(int floors, std::uint64_t seed) {
  CampaignOptions options;
  options.building.floors = floors;
  options.cameras.images_per_floor = 4;
  Campaign c = make_campaign(options, seed);
  for (BrownCamera* camera : {&c.camera.truth, &c.camera.calibration}) {
    camera->width = 600, camera->height = 400;
    for (double* value : {&camera->fx, &camera->fy, &camera->cx, &camera->cy}) *value *= 0.1;
  }
  return c;
}

std::map<std::string, std::string> contents(const fs::path& folder) {
  std::map<std::string, std::string> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (entry.is_regular_file()) {
      files[entry.path().lexically_relative(folder).generic_string()] = test::read_file(entry.path());
    }
  }
  return files;
}

std::map<std::string, std::string> write(const Campaign& campaign, const fs::path& folder) {
  write_campaign_files(campaign, folder);
  write_images(campaign, folder, nullptr);
  return contents(folder);
}

TEST(SimulatedCampaign, IsTheSameForTheSameSeedOnAnyNumberOfThreads) {
  const test::TemporaryFolder a, b, c;
  const auto first = write(small_campaign(1, 7), a.path());
  const tbb::global_control one_thread(tbb::global_control::max_allowed_parallelism, 1);
  EXPECT_EQ(first, write(small_campaign(1, 7), b.path()));
  const auto other = write(small_campaign(1, 8), c.path());
  for (const char* name : {"images/F01-01.jpg", "survey/total_station.gsi", "control.csv", "camera.yaml"}) {
    EXPECT_NE(first.at(name), other.at(name)) << name;
  }
}

TEST(SimulatedCampaign, IsWhatTheReaderOfSitesReads) {
  const test::TemporaryFolder folder;
  const Campaign c = small_campaign(2, 3);
  const auto files = write(c, folder.path());
  std::vector<std::string> names;
  for (const auto& [name, ignored] : files) names.push_back(name);
  const auto description = campaign::parse_campaign(files.at("campaign.yaml"), "campaign.yaml", names);
  EXPECT_EQ(description.images.size(), 8u);
  EXPECT_EQ(description.instrument, "ics50_assumed");

  const auto camera = campaign::parse_camera(files.at("camera.yaml"), "camera.yaml");
  EXPECT_EQ(camera.camera.parameters(), c.camera.calibration.parameters());
  EXPECT_EQ(camera.sigmas, c.camera.profile.calibration_sigmas);

  const auto plates = campaign::parse_plates(files.at("plates.csv"), "plates.csv");
  ASSERT_EQ(plates.size(), c.building.anchors.size());
  for (const auto& plate : plates) {
    const auto anchor = std::find_if(c.building.anchors.begin(), c.building.anchors.end(),
                                     [&](const Anchor& a) { return a.id == plate.anchor; });
    ASSERT_NE(anchor, c.building.anchors.end());
    EXPECT_EQ(plate.tag_id, anchor->tag_id);
    EXPECT_NEAR(plate.tag_size, 0.2, 1e-15);
    EXPECT_LT((plate.tag_centre_in_plate - c.building.nominal_plate.tag_centre_in_plate).norm(), 1e-15);
    EXPECT_LT(campaign::upright_plate(plate.facing_azimuth).angularDistance(facade_from_plate()), 1e-12);
  }
  const auto control = campaign::parse_control(files.at("control.csv"), "control.csv");
  ASSERT_EQ(control.size(), 4u);
  EXPECT_LT((control[2].position - c.plan.ground_points[2].given).norm(), 1e-5);
  EXPECT_NEAR(control[2].sigma.y(), 0.5e-3, 1e-12);

  const auto header = read_photograph_header(folder.path() / "images/F02-03.jpg");
  EXPECT_EQ(header.width, 600);
  EXPECT_EQ(header.height, 400);
  EXPECT_TRUE(header.model.starts_with("Plumbline")) << header.model;
  EXPECT_EQ(header.taken_at, "2026:05:04 09:02:00");
  EXPECT_NEAR(header.focal_length, 0.024, 1e-9);
}

/// Over known marks a wrong instrument height moves all that its set-up sees: station and height are in control.csv.
TEST(SimulatedCampaign, SetUpsMayStandOverKnownMarks) {
  const test::TemporaryFolder folder;
  CampaignOptions options;
  options.building.floors = 2;
  options.survey.known_marks = true;
  options.survey.set_up_height_sigma = 0.003;
  const Campaign c = make_campaign(options, 3);
  write_campaign_files(c, folder.path());
  const auto control = campaign::parse_control(test::read_file(folder.path() / "control.csv"), "control.csv");
  ASSERT_EQ(control.size(), 4 + c.plan.set_ups.size());
  double largest = 0;
  for (std::size_t i = 0; i < c.plan.set_ups.size(); ++i) {
    EXPECT_EQ(control[4 + i].name, c.plan.set_ups[i].id);
    const double height = control[4 + i].position.z() + c.observations.set_ups[i].instrument_height;
    EXPECT_LT((control[4 + i].position - c.plan.set_ups[i].axis).head<2>().norm(), 0.003);
    EXPECT_NEAR(height, c.plan.set_ups[i].axis.z(), 0.015);
    largest = std::max(largest, std::abs(height - c.plan.set_ups[i].axis.z()));
  }
  EXPECT_GT(largest, 0.001);
}

/// Each photograph has an interior orientation of its own, and the truth of its corners is taken with it.
TEST(SimulatedCampaign, ImagesMayHaveTheirOwnPrincipalPoints) {
  CampaignOptions options;
  options.building.floors = 1;
  options.cameras.images_per_floor = 4;
  const Campaign fixed = make_campaign(options, 3);
  options.perturbations.principal_point_sigma = 2;
  const Campaign moving = make_campaign(options, 3);
  const auto steady = observe_corners(fixed, 0, 3), moved = observe_corners(moving, 0, 3);
  for (std::size_t i = 0; i < 2; ++i) {
    const Eigen::Vector2d shift = moved[i].tags[0].corners[0] - steady[i].tags[0].corners[0];
    EXPECT_NEAR(shift.x(), camera_at(moving, i).truth.cx - fixed.camera.truth.cx, 1e-9);
    EXPECT_GT(shift.norm(), 0.01);
  }
  EXPECT_NE(camera_at(moving, 0).truth.cx, camera_at(moving, 1).truth.cx);
}

TEST(SimulatedCampaign, GsiHoldsTheObservations) {
  const test::TemporaryFolder folder;
  const Campaign c = small_campaign(1, 3);
  write_campaign_files(c, folder.path());
  const auto read = survey::read_survey(test::read_file(folder.path() / "survey/total_station.gsi"), "a.gsi");
  EXPECT_TRUE(read.skipped.empty());
  ASSERT_EQ(read.set_ups.size(), 2u);
  EXPECT_NEAR(read.set_ups[1].instrument_height, c.observations.set_ups[1].instrument_height, 1e-9);
  ASSERT_EQ(read.observations.size(), c.observations.observations.size());
  for (std::size_t i = 0; i < read.observations.size(); ++i) {
    const auto &found = read.observations[i], &given = c.observations.observations[i];
    EXPECT_EQ(found.to, given.to);
    EXPECT_EQ(found.kind, given.kind);
    EXPECT_EQ(found.face, given.face);
    EXPECT_NEAR(found.value, given.value, 1e-5);
    EXPECT_NEAR(found.target_height, given.target_height, 1e-9);
  }
}

TEST(DesignIfc, IsValidAndHasAnchorsAndPanelsAtTheirPlaces) {
  PLUMBLINE_REQUIRE_DATA("ifc/express/IFC4.exp");
  const test::ExpressSchema schema(test::read_file(test::data_file("ifc/express/IFC4.exp")));
  const Building b = make_building({.floors = 3}, 1);
  for (const bool millimetres : {false, true}) {
    const step::File file(write_design_ifc(b, 1, millimetres), "design.ifc");
    for (const step::Instance& instance : file.instances()) {
      for (const std::string& problem : schema.check(file, instance)) ADD_FAILURE() << problem;
    }
    const ifc::Design design = ifc::read_design(file, {});
    ASSERT_EQ(design.storeys.size(), 3u);
    EXPECT_NEAR(design.storeys[2].elevation, 8, 1e-12);
    std::size_t anchors = 0, panels = 0;
    std::set<std::string> guids;
    for (const ifc::Element& element : design.elements) {
      EXPECT_TRUE(guids.insert(element.guid).second);
      panels += element.ifc_class == "IfcPlate";
      if (!element.is_anchor) continue;
      const auto anchor =
          std::find_if(b.anchors.begin(), b.anchors.end(), [&](const Anchor& a) { return a.id == element.name; });
      ASSERT_NE(anchor, b.anchors.end()) << element.name;
      EXPECT_LT((element.position - anchor->design).norm(), 1e-9) << element.name;
      EXPECT_EQ(element.storey, "Floor " + std::to_string(anchor->floor));
      ++anchors;
    }
    EXPECT_EQ(anchors, b.anchors.size());
    EXPECT_EQ(panels, 9u);  // between the four columns
  }
}

/// Facades that stand askew: an anchor is written relative to its facade, and read where the building has it.
TEST(DesignIfc, AnchorsOfEveryFacadeAreAtTheirPlaces) {
  for (const std::string& shape : shape_names()) {
    CampaignOptions options;
    options.shape = shape, options.building.floors = 2, options.cameras.images_per_floor = 4;
    const Building b = make_campaign(options, 3).building;
    const ifc::Design design = ifc::read_design(step::File(write_design_ifc(b, 1, false), "design.ifc"), {});
    std::size_t anchors = 0;
    for (const ifc::Element& element : design.elements) {
      if (!element.is_anchor) continue;
      const auto anchor =
          std::find_if(b.anchors.begin(), b.anchors.end(), [&](const Anchor& a) { return a.id == element.name; });
      ASSERT_NE(anchor, b.anchors.end()) << element.name;
      EXPECT_LT((element.position - anchor->design).norm(), 1e-9) << shape << ": " << element.name;
      ++anchors;
    }
    EXPECT_EQ(anchors, b.anchors.size()) << shape;
  }
}

TEST(ObservedPoints, ScatterAsTheirCovarianceSays) {
  CampaignOptions options;
  options.building.floors = 4;
  options.cameras.images_per_floor = 4;
  double within = 0, top = 0;
  const int trials = 300;
  for (std::uint64_t seed = 0; seed < trials; ++seed) {
    static const Campaign c = make_campaign(options, 1);
    const auto points = observe_points(c, 0.001, 0.002, seed);
    const double dz_first = points.front().position.z() - points.front().anchor->built.z();
    const double dz_last = points.back().position.z() - points.back().anchor->built.z();
    within += dz_first * dz_first, top += dz_last * dz_last;
    const Eigen::MatrixXd covariance = point_covariance(points, 0.001, 0.002);
    EXPECT_NEAR(covariance(2, 2), 1e-6, 1e-15);
    EXPECT_NEAR(covariance(covariance.rows() - 1, covariance.rows() - 1), 13e-6, 1e-15);
  }
  const double margin = 4 * std::sqrt(2.0 / trials);
  EXPECT_NEAR(within / trials / 1e-6, 1, margin);
  EXPECT_NEAR(top / trials / 13e-6, 1, margin);
}

/// Coordinates that were observed are the approximate ones as well: nothing has to be searched for.
TEST(ObservedPoints, AreObservedWhereTheyAreSaidToBe) {
  const Campaign campaign = small_campaign(2, 1);
  const auto points = observe_points(campaign, 0.001, 0.002, 5);
  const auto survey = as_observed_coordinates(points, point_covariance(points, 0.001, 0.002));
  ASSERT_EQ(survey.coordinates.size(), 1u);
  ASSERT_EQ(survey.points.size(), points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    EXPECT_EQ(survey.points[i].id, points[i].anchor->id);
    EXPECT_EQ(survey.points[i].coordinates, points[i].position);
    EXPECT_EQ(survey.coordinates[0].values.segment<3>(static_cast<Eigen::Index>(3 * i)), points[i].position);
  }
}

/// The first lines of every file, numbers to five digits, of a site with all that a site may have: what is drawn and
/// written is recomputed elsewhere in parts, and held here as a whole.
TEST(SimulatedCampaign, FilesAreTheRecordedOnes) {
  for (const std::string shape : {"flat", "corner"}) {
    CampaignOptions options;
    options.shape = shape;
    options.building.floors = 2, options.building.columns = 2, options.building.print_batches = 2;
    options.cameras.images_per_floor = 4, options.cameras.cut_tags = 0.25;
    options.perturbations = optics_of("real"), options.perturbations.depth_distortion = 0.001;
    options.building.flaws = options.perturbations;
    if (shape == "flat") options.obstruction = {2.5, 1.2, 0.1};  // no scaffold stands before another
    options.survey.known_marks = shape == "flat", options.survey.set_up_height_sigma = 0.002;
    options.design_in_millimetres = shape == "flat";
    const Campaign campaign = make_campaign(options, 11);
    const test::TemporaryFolder folder;
    write_campaign_files(campaign, folder.path(), true);
    write_observations(campaign, folder.path(), 0.1);
    fs::create_directories(folder.path() / "truth");
    write_truth(campaign, folder.path() / "truth");
    std::string text;
    for (const auto& [name, content] : contents(folder.path())) {
      text += "== " + name + ", " + std::to_string(std::count(content.begin(), content.end(), '\n')) + " lines\n";
      std::istringstream lines(content);
      std::string line;
      for (int i = 0; i < 260 && std::getline(lines, line); ++i) text += test::with_few_digits(line) + "\n";
    }
    test::expect_recorded("unit/simulate/recorded/campaign_" + shape + ".txt", text);
  }
}

TEST(SimulatedCampaign, StopsWhenAsked) {
  const test::TemporaryFolder folder;
  EXPECT_THROW(write_images(small_campaign(1, 1), folder.path(), [](std::size_t) { return false; }),
               std::runtime_error);
}

}  // namespace test_campaign
}  // namespace plumbline::simulate
