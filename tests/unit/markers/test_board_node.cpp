// adjust.marker_board, write.ply and read.images over their artifacts: what they refuse.
#include <gmock/gmock.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "artifacts/file.hpp"
#include "artifacts/image.hpp"
#include "artifacts/plates.hpp"
#include "artifacts/points.hpp"
#include "artifacts/tag_observations.hpp"
#include "node_harness.hpp"
#include "scene.hpp"
#include "stopping.hpp"

namespace plumbline::markers {
namespace test_board_node {

using testing::HasSubstr;
using testing::Not;

/// The photographs of a block and the tags in them; `principal_distance`: of EXIF, 0: none.
/// `half`: the photograph that has half of the size.
void give(const Scene& s, double principal_distance, test::NodeHarness& node, const std::string& half = "") {
  TagObservationsT seen;
  for (std::size_t i = 0; i < s.block.images.size(); ++i) {
    ImageT photograph;
    photograph.path = s.block.images[i].path;
    photograph.width = true_camera().width, photograph.height = true_camera().height;
    if (photograph.path == half) photograph.width /= 2, photograph.height /= 2;
    if (principal_distance > 0) photograph.principal_distance = principal_distance;
    node.input<Image>("images", photograph);
    auto image = std::make_unique<ImageTagsT>();
    image->path = photograph.path, image->width = photograph.width, image->height = photograph.height;
    for (const MarkerView& view : s.block.views) {
      if (view.image != static_cast<int>(i)) continue;
      auto tag = std::make_unique<TagT>();
      tag->family = "tag36h11", tag->id = s.block.markers[view.marker].id, tag->refined = true;
      tag->corners.assign(view.corners.begin(), view.corners.end());
      for (const Eigen::Matrix2d& c : view.covariances)
        for (const double value : {c(0, 0), c(0, 1), c(1, 1)}) tag->corner_covariances.push_back(value);
      image->tags.push_back(std::move(tag));
    }
    seen.images.push_back(std::move(image));
  }
  node.input<TagObservations>("observations", seen);
}

/// All warnings, or what the node refuses.
std::string said_by(test::NodeHarness& node) {
  try {
    node.run();
  } catch (const test::NodeFailed& error) {
    return error.what();
  }
  std::string said;
  for (const std::string& warning : node.warnings()) said += warning + "\n";
  return said;
}

/// What the node says of the block of scene.hpp, whose tags 0 and 1 are 0.3 m apart, with this distance.
std::string said_of(const std::string& distance, const std::string& tag_size = "0.12") {
  test::NodeHarness node("adjust.marker_board");
  give(scene(0.05, 3), 0, node);
  node.set("tag_size", tag_size);
  node.set("distance", distance);
  node.set("compare_halves", "false");
  return said_by(node);
}

/// The start of photo_campaign with 24 photographs and all tags surveyed, the second half zoomed.
test::NodeHarness campaign_node(double zoom, double exif, const std::string& tag_size = "0.12") {
  Scene s = scene(0.1, 3, 24);
  const Eigen::Vector2d middle(800, 600);
  for (MarkerView& view : s.block.views)
    for (Eigen::Vector2d& corner : view.corners)
      if (view.image >= 12) corner = middle + zoom * (corner - middle);
  test::NodeHarness node("adjust.marker_start");
  give(s, exif, node);
  PointsT points;
  for (std::size_t m = 0; m < s.tags.size(); ++m) {
    points.points.push_back(std::make_unique<PointT>());
    points.points.back()->id = std::to_string(m), points.points.back()->position = s.tags[m].translation;
    points.points.back()->sigma = Eigen::Vector3d::Constant(1e-3);
  }
  node.input<Points>("points", points);
  node.input<Plates>("plates", PlatesT());
  node.set("tag_size", tag_size);
  return node;
}

std::string said_of_campaign(double zoom, double exif, const std::string& tag_size = "0.12") {
  test::NodeHarness node = campaign_node(zoom, exif, tag_size);
  return said_by(node);
}

/// Tags in known places and turned as they are, as a field of tags has them.
test::NodeHarness field_node() {
  const Scene s = scene(0.1, 3, 12);
  test::NodeHarness node("adjust.marker_field");
  give(s, 1480, node);
  PointsT points;
  PlatesT plates;
  for (std::size_t m = 0; m < s.tags.size(); ++m) {
    points.points.push_back(std::make_unique<PointT>()), plates.plates.push_back(std::make_unique<PlateT>());
    points.points.back()->id = plates.plates.back()->anchor = std::to_string(m);
    points.points.back()->position = s.tags[m].translation;
    PlateT& plate = *plates.plates.back();
    plate.tag_family = "tag36h11", plate.tag_id = s.block.markers[m].id, plate.tag_size = s.block.markers[m].size;
    plate.nominal_rotation = s.tags[m].rotation, plate.tag_centre_in_plate.setZero();
  }
  node.input<Points>("points", points), node.input<Plates>("plates", plates);
  return node;
}

TEST(MarkerStart, CanBeStopped) {
  EXPECT_EQ(test::stopping_at_fault([] { return campaign_node(1, 1480); }), "");
}

TEST(MarkerField, CanBeStopped) { EXPECT_EQ(test::stopping_at_fault(field_node), ""); }

TEST(MarkerStart, SaysThatTheCameraChanged) {
  for (const double exif : {1480.0, 0.0})
    EXPECT_THAT(said_of_campaign(1.03, exif), testing::ContainsRegex("from image12.jpg on .* (longer|shorter): focus"));
  EXPECT_THAT(said_of_campaign(1, 1480), Not(HasSubstr("principal distance")));
}

/// What EXIF has is no calibration: photographs that contradict it mend it.
TEST(MarkerStart, SaysOfNoGuessThatItIsContradicted) {
  const std::string said = said_of_campaign(1, 1150);
  EXPECT_THAT(said, Not(HasSubstr("contradict the calibration")));
  EXPECT_THAT(said, Not(HasSubstr("principal distance")));
}

/// A list that was cut with "..." did not say whether one tag was left out of it or ninety.
TEST(MarkerStart, SaysHowManyNamesAListLeavesOut) {
  test::NodeHarness node("adjust.marker_start");
  give(scene(0.1, 3, 6), 1480, node);
  PlatesT plates;
  for (int k = 0; k < 30; ++k) {
    auto plate = std::make_unique<PlateT>();
    plate->anchor = "A" + std::to_string(k), plate->role = "control", plate->tag_family = "tag36h11";
    plate->tag_id = 500 + k, plate->tag_size = 0.12, plate->floor = 1;
    plate->tag_centre_in_plate.setZero(), plate->nominal_rotation.setIdentity();
    plates.plates.push_back(std::move(plate));
  }
  node.input<Points>("points", PointsT());
  node.input<Plates>("plates", plates);
  EXPECT_THAT(said_by(node), HasSubstr("it has tag36h11:500, tag36h11:501, tag36h11:502, tag36h11:503, tag36h11:504, "
                                       "tag36h11:505, tag36h11:506, tag36h11:507 and 22 more, they show"));
}

/// In block.json, of which other programs take them.
TEST(MarkerBoard, CornersOfATagLieAroundItsPlaceAndAreItsSizeApart) {
  test::NodeHarness node("adjust.marker_board");
  give(scene(0.05, 3), 0, node);
  node.set("tag_size", "0.12"), node.set("distance", "0,1,0.3"), node.set("compare_halves", "false");
  node.run();
  const FileT file = node.output<File>("block");
  const auto block = nlohmann::json::parse(file.content.begin(), file.content.end());
  const auto vector = [](const nlohmann::json& v) { return Eigen::Vector3d(v.at(0), v.at(1), v.at(2)); };
  ASSERT_FALSE(block["points"].empty());
  for (const auto& point : block["points"]) {
    ASSERT_EQ(point["corners"].size(), 4u) << point["id"];
    Eigen::Vector3d middle = Eigen::Vector3d::Zero();
    for (size_t k = 0; k < 4; ++k) {
      const Eigen::Vector3d corner = vector(point["corners"][k]), next = vector(point["corners"][(k + 1) % 4]);
      middle += corner / 4;
      EXPECT_NEAR((next - corner).norm(), 0.12 * point["size_ratio"].get<double>(), 1e-5) << point["id"];
    }
    EXPECT_LT((middle - vector(point["position"])).norm(), 1e-6) << point["id"];
  }
}

TEST(MarkerBoardDistance, IsThreePlainNumbersOrFour) {
  EXPECT_THAT(said_of("0,1,0.3"), Not(HasSubstr("distance")));
  EXPECT_THAT(said_of("0,1,0.3,0.0002"), Not(HasSubstr("distance")));
  EXPECT_THAT(said_of("0,1,0.3m"), HasSubstr("'0.3m' is no number of metres"));
  EXPECT_THAT(said_of("0,1,1,3"), HasSubstr("3 m of 1 m is no measurement; a decimal comma, perhaps"));
  EXPECT_THAT(said_of("0,one,0.3"), HasSubstr("'one' is no tag's id"));
  EXPECT_THAT(said_of("0,1.5,0.3"), HasSubstr("'1.5' is no tag's id"));
}

TEST(MarkerBoardDistance, InAnotherUnitThanMetresIsTold) {
  EXPECT_THAT(said_of("0,1,300"), HasSubstr("with distance=0,1,300 the tags measure 1200"));
}

/// Up to five per cent of contradiction were silent, with a scale that was stated to 0.05 %.
TEST(MarkerBoardDistance, IsHeldAgainstTheSizeOfTheTags) {
  EXPECT_THAT(said_of("0,1,0.309"),
              testing::AllOf(HasSubstr("the tags measure 123."), HasSubstr("all lengths are wrong")));
  EXPECT_THAT(said_of("0,1,0.3006"), Not(HasSubstr("distance")));
  EXPECT_THAT(said_of("0,1,300", "0"), HasSubstr("which no tag that is printed does: is it in metres"));
  EXPECT_THAT(said_of("0,1,0.3", "0"), Not(HasSubstr("distance")));
}

TEST(MarkerStart, ASizeThatTheSurveyContradictsIsTold) {
  EXPECT_THAT(said_of_campaign(1, 1480, "0.1164"),
              testing::AllOf(HasSubstr("the edge of a tag measures 0.120 m"), HasSubstr("% off: the survey counts")));
  EXPECT_THAT(said_of_campaign(1, 1480, "0.1212"), Not(HasSubstr("the survey counts"))) << "a print is off by that";
}

TEST(MarkerStart, ASurveyThatIsTheMirrorImageIsRefused) {
  const Scene s = scene(0.1, 3, 24);
  test::NodeHarness node("adjust.marker_start");
  give(s, 1480, node);
  PointsT points;
  for (std::size_t m = 0; m < s.tags.size(); ++m) {
    const Eigen::Vector3d& place = s.tags[m].translation;
    points.points.push_back(std::make_unique<PointT>());
    points.points.back()->id = std::to_string(m), points.points.back()->position = {place.y(), place.x(), place.z()};
    points.points.back()->sigma = Eigen::Vector3d::Constant(1e-3);
  }
  node.input<Points>("points", points);
  node.input<Plates>("plates", PlatesT());
  EXPECT_THAT(said_by(node), testing::AllOf(HasSubstr("mirror image"), HasSubstr("exchanged (east and north)")));
}

/// Copies for the office beside the photographs: every one counted twice, and sigma was smaller for it.
TEST(MarkerBoard, ACopyAtAnotherSizeIsLeftOut) {
  Scene s = scene(0.05, 3);
  const auto seen = s.block.views;
  s.block.images.push_back({"small.jpg", 0});
  for (MarkerView view : seen) {
    if (view.image != 2) continue;
    view.image = static_cast<int>(s.block.images.size()) - 1;
    for (Eigen::Vector2d& corner : view.corners)
      corner = 0.5 * (corner + Eigen::Vector2d(0.5, 0.5)) - Eigen::Vector2d(0.4, 0.55);
    s.block.views.push_back(view);
  }
  test::NodeHarness node("adjust.marker_board");
  give(s, 1480, node, "small.jpg");
  node.set("tag_size", "0.12"), node.set("compare_halves", "false");
  EXPECT_THAT(said_by(node), HasSubstr("left out: small.jpg: is image2.jpg at another size"));
}

/// It was a rolling shutter.
TEST(MarkerBoard, APrintThatIsWiderThanHighIsNamed) {
  const auto said_with = [](double wider, bool halves = false) {
    Scene s = scene(0.05, 3, 20);
    for (MarkerView& view : s.block.views)
      for (std::size_t q = 0; q < 4; ++q) {
        const RigidTransform &image = s.images[view.image], &tag = s.tags[view.marker];
        const Eigen::Vector3d square = corner(0.12, q), print(square.x() * (1 + wider), square.y(), 0);
        view.corners[q] +=
            *project(true_camera(), image * (tag * print)) - *project(true_camera(), image * (tag * square));
      }
    test::NodeHarness node("adjust.marker_board");
    give(s, 1480, node);
    node.set("tag_size", "0.12"), node.set("compare_halves", halves ? "true" : "false");
    return said_by(node);
  };
  EXPECT_THAT(said_with(0.006), testing::ContainsRegex("the tags are 0\\.[56].* % wider than they are high"));
  for (const bool halves : {false, true})  // one cause, one sentence
    for (const char* const other : {"rows", "scatter", "two halves", "as two cameras", "either side"})
      EXPECT_THAT(said_with(0.006, halves), Not(HasSubstr(other))) << halves;
  EXPECT_THAT(said_with(0), Not(HasSubstr("than they are high")));
}

/// Some were printed at 97 %: lengths were wrong by 0.7 % where 0.2 % was stated, without a word.
TEST(MarkerBoard, SizesOfTwoGroupsAreTold) {
  const auto said_with = [](double scale) {
    Scene s = scene(0.05, 3, 12);
    for (MarkerView& view : s.block.views)
      for (std::size_t q = 0; view.marker >= 8 && q < 4; ++q) {
        const RigidTransform &image = s.images[view.image], &tag = s.tags[view.marker];
        view.corners[q] += *project(true_camera(), image * (tag * corner(0.12 * scale, q))) -
                           *project(true_camera(), image * (tag * corner(0.12, q)));
      }
    test::NodeHarness node("adjust.marker_board");
    give(s, 1480, node);
    node.set("tag_size", "0.12"), node.set("compare_halves", "false");
    return said_by(node);
  };
  EXPECT_THAT(said_with(0.97),
              testing::ContainsRegex("tags 8, 9, 10, 11 are (2.9|3.0|3.1) % smaller than the other 8"));
  EXPECT_THAT(said_with(0.999), Not(HasSubstr("smaller than the other")));
}

TEST(WritePly, RefusesWhatIsNoCoordinate) {
  for (const double height : {300.0, 1e308}) {
    PointsT points;
    points.points.push_back(std::make_unique<PointT>());
    points.points.back()->id = "far", points.points.back()->position = {4.5e5, 5.4e6, height};
    test::NodeHarness node("write.ply");
    node.input<Points>("points", points);
    try {
      node.run();
      EXPECT_EQ(height, 300.0);
    } catch (const test::NodeFailed& error) {
      EXPECT_THAT(error.what(), HasSubstr("point 'far' has a coordinate beyond 1e9 m"));
      EXPECT_EQ(height, 1e308);
    }
  }
}

TEST(ReadImages, NamesALinkToNothing) {
  const test::TemporaryFolder folder;
  std::filesystem::create_symlink("gone.jpg", folder.path() / "a.jpg");
  test::NodeHarness node("read.images");
  node.set("folder", folder.path().string());
  try {
    node.run();
    FAIL();
  } catch (const test::NodeFailed& error) {
    EXPECT_THAT(error.what(), HasSubstr("a.jpg of "));
    EXPECT_THAT(error.what(), HasSubstr("a link to a file that is not there"));
  }
}

}  // namespace test_board_node
}  // namespace plumbline::markers
