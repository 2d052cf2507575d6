// The nodes around the detector, on files.
#include <gmock/gmock.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>

#include "artifacts/board_points.hpp"
#include "artifacts/camera.hpp"
#include "artifacts/file.hpp"
#include "artifacts/image.hpp"
#include "artifacts/image_block.hpp"
#include "artifacts/image_tags.hpp"
#include "artifacts/points.hpp"
#include "artifacts/poses.hpp"
#include "artifacts/tag_observations.hpp"
#include "geometry/camera.hpp"
#include "node_harness.hpp"
#include "parameter_effects.hpp"
#include "photo/detect/board.hpp"
#include "stopping.hpp"
#include "tag_rendering.hpp"

namespace plumbline {
namespace test_nodes {

namespace fs = std::filesystem;
using test::write_png;
using testing::HasSubstr;

test::TagScene scene() {
  test::TagScene scene;
  scene.corners = test::square_corners({100.3, 99.1}, 80, 0.4);
  scene.noise = 1;
  return scene;
}

std::string failure_of(test::NodeHarness& node) {
  try {
    node.run();
  } catch (const test::NodeFailed& error) {
    return error.what();
  }
  return "";
}

TEST(DetectNodes, GoFromAFolderOfImagesToCollectedObservations) {
  const test::TemporaryFolder folder;
  fs::create_directories(folder.path() / "floor 1");
  write_png(folder.path() / "floor 1" / "b.png", render(scene()));
  write_png(folder.path() / "a.PNG", render(scene()));
  std::ofstream(folder.path() / "notes.txt") << "not an image";

  test::NodeHarness read("read.images");
  read.set("folder", folder.path().string());
  read.set("camera", "left");
  read.run();
  ASSERT_EQ(read.output_count("images"), 2u);

  test::NodeHarness collect("detect.collect");
  for (size_t i = 0; i < 2; ++i) {
    const ImageT image = read.output<Image>("images", i);
    EXPECT_EQ(image.width, 200);
    EXPECT_EQ(image.sha256.size(), 64u);
    test::NodeHarness detect("detect.apriltag");
    detect.input<Image>("images", image);
    detect.run();
    collect.input<ImageTags>("observations", detect.output<ImageTags>("observations"));
  }
  collect.run();
  const auto all = collect.output<TagObservations>("observations");
  ASSERT_EQ(all.images.size(), 2u);
  EXPECT_EQ(all.images[0]->path, "a.PNG");
  EXPECT_EQ(all.images[1]->path, "floor 1/b.png");
  EXPECT_EQ(all.images[1]->camera, "left");
  ASSERT_EQ(all.images[1]->tags.size(), 1u);
  const TagT& tag = *all.images[1]->tags[0];
  EXPECT_EQ(tag.id, 7);
  ASSERT_EQ(tag.corners.size(), 4u);
  for (size_t i = 0; i < 4; ++i) EXPECT_LT((tag.corners[i] - scene().corners[i]).norm(), 0.05);
  ASSERT_EQ(tag.corner_covariances.size(), 12u);
  for (size_t i = 0; i < 4; ++i) EXPECT_LT(tag.corner_covariances[3 * i], 0.05 * 0.05);
}

/// Four tags in a square, each by its edges: what their detector states of the inset goes with the board's points.
TEST(DetectNodes, StateOfABoardOfTagsHowFarEdgesMayBeDrawnIn) {
  GreyImage image{260, 260, std::vector<std::uint8_t>(260 * 260, 190)};
  for (int id = 0; id < 4; ++id) {
    test::TagScene one;
    one.id = id, one.width = one.height = 110;
    one.corners = test::square_corners({54.5, 54.5}, 80, 0);
    one.noise = 1, one.seed = static_cast<std::uint64_t>(id + 1);
    const GreyImage part = render(one);
    for (int y = 0; y < 110; ++y)
      for (int x = 0; x < 110; ++x)
        image.pixels[(y + 20 + 110 * (id / 2)) * 260 + x + 20 + 110 * (id % 2)] = part.pixels[y * 110 + x];
  }
  const test::TemporaryFolder folder;
  write_png(folder.path() / "board.png", image);
  std::ofstream(folder.path() / "board.yaml")
      << "type: tags\ncolumns: 2\nrows: 2\nmarker: 0.08\ngap: 0.03\ndictionary: tag36h11\n";
  const test::Situation situation = [&] {
    test::NodeHarness before("detect.board");
    before.set("board", (folder.path() / "board.yaml").string());
    ImageT photograph;
    photograph.path = "board.png", photograph.uri = (folder.path() / "board.png").string();
    photograph.width = photograph.height = 260;
    before.input<Image>("images", photograph);
    return before;
  };
  EXPECT_EQ(test::stopping_at_fault(situation), "");
  test::NodeHarness node = situation();
  node.run();
  const BoardPointsT found = node.output<BoardPoints>("points");
  ASSERT_EQ(found.points.size(), 16u) << found.problem;
  const auto board = detect::parse_board(test::read_file(folder.path() / "board.yaml"), "board.yaml");
  const double stated = detect::find_board(image, board).inset_sigma;
  EXPECT_GT(stated, 0.001);
  EXPECT_EQ(found.corner_inset_sigma, stated);
}

TEST(DetectNodes, NameADamagedImage) {
  const test::TemporaryFolder folder;
  write_png(folder.path() / "whole.png", render(scene()));
  const std::string bytes = test::read_file(folder.path() / "whole.png");
  std::ofstream(folder.path() / "cut.png", std::ios::binary) << bytes.substr(0, bytes.size() / 2);
  test::NodeHarness detect("detect.apriltag");
  ImageT image;
  image.path = "cut.png";
  image.uri = (folder.path() / "cut.png").string();
  detect.input<Image>("images", image);
  EXPECT_THAT(failure_of(detect), testing::AllOf(HasSubstr("cut.png"), HasSubstr("truncated PNG")));
}

TEST(DetectNodes, SayThatAFolderHoldsNoImage) {
  const test::TemporaryFolder folder;
  test::NodeHarness read("read.images");
  read.set("folder", folder.path().string());
  EXPECT_THAT(failure_of(read), HasSubstr("no image in " + folder.path().string()));
}

TEST(DetectNodes, WarnOfAnImageWithoutTags) {
  const test::TemporaryFolder folder;
  write_png(folder.path() / "grey.png", GreyImage{64, 64, std::vector<std::uint8_t>(4096, 77)});
  for (const std::string detector : {"detect.apriltag", "detect.tag_pyramid"}) {
    test::NodeHarness detect(detector);
    ImageT image;
    image.path = "grey.png";
    image.uri = (folder.path() / "grey.png").string();
    detect.input<Image>("images", image);
    detect.run();
    EXPECT_TRUE(detect.output<ImageTags>("observations").tags.empty());
    ASSERT_EQ(detect.warnings().size(), 1u);
    EXPECT_THAT(detect.warnings()[0], HasSubstr("grey.png"));
  }
}

TEST(DetectNodes, SayThatAllTagsAreNegativeOrMirrored) {
  const test::TemporaryFolder folder;
  GreyImage inverse = render(scene()), mirror = inverse;
  for (auto& pixel : inverse.pixels) pixel = static_cast<std::uint8_t>(255 - pixel);
  for (int y = 0; y < mirror.height; ++y)
    std::reverse(mirror.pixels.begin() + y * mirror.width, mirror.pixels.begin() + (y + 1) * mirror.width);
  write_png(folder.path() / "negative.png", inverse);
  write_png(folder.path() / "mirror.png", mirror);
  for (const std::string name : {"negative", "mirror"}) {
    test::NodeHarness detect("detect.aruco");
    detect.set("dictionary", "tag36h11");
    ImageT image;
    image.path = name + ".png";
    image.uri = (folder.path() / image.path).string();
    detect.input<Image>("images", image);
    detect.run();
    const ImageTagsT result = detect.output<ImageTags>("observations");
    EXPECT_TRUE(result.tags.empty());
    EXPECT_THAT(result.problem, HasSubstr(name == "mirror" ? "is mirrored" : "white on black"));
  }
}

/// One code in a mirror may be chance where the photograph is full of tags of another family.
TEST(DetectNodes, OneTagInAMirrorAmongThoseOfAnotherFamilyIsNoMirroredPhotograph) {
  const test::TemporaryFolder folder;
  GreyImage all{800, 200, std::vector<std::uint8_t>(800 * 200, 190)};
  for (int part = 0; part < 4; ++part) {
    test::TagScene one = scene();
    one.id = part, one.family = part < 3 ? "tag36h11" : "tag25h9";
    const GreyImage image = render(one);
    for (int y = 0; y < 200; ++y) {
      const auto to = all.pixels.begin() + y * 800 + 200 * part;
      std::copy_n(image.pixels.begin() + y * 200, 200, to);
      if (part == 3) std::reverse(to, to + 200);
    }
  }
  write_png(folder.path() / "all.png", all);
  test::NodeHarness detect("detect.apriltag");
  detect.set("families", "tag25h9");
  ImageT image;
  image.path = "all.png", image.uri = (folder.path() / image.path).string();
  detect.input<Image>("images", image);
  detect.run();
  const ImageTagsT result = detect.output<ImageTags>("observations");
  EXPECT_TRUE(result.tags.empty());
  EXPECT_THAT(result.problem, HasSubstr("3 tags of"));
  EXPECT_THAT(result.problem, HasSubstr("the family is wrong"));
}

/// In a mirror a few codes look like others of a small dictionary: what is found among many mirrored tags is chance.
TEST(DetectNodes, AFewTagsAmongManyMirroredOnesAreNone) {
  const test::TemporaryFolder folder;
  const GreyImage one = render(scene());
  for (const int mirrored : {1, 3}) {
    GreyImage all{one.width * (mirrored + 1), one.height, {}};
    for (int y = 0; y < one.height; ++y)
      for (int part = 0; part <= mirrored; ++part) {
        const auto row = one.pixels.begin() + y * one.width;
        all.pixels.insert(all.pixels.end(), row, row + one.width);
        if (part > 0) std::reverse(all.pixels.end() - one.width, all.pixels.end());
      }
    write_png(folder.path() / "all.png", all);
    test::NodeHarness detect("detect.aruco");
    detect.set("dictionary", "tag36h11");
    ImageT image;
    image.path = "all.png";
    image.uri = (folder.path() / image.path).string();
    detect.input<Image>("images", image);
    detect.run();
    const ImageTagsT result = detect.output<ImageTags>("observations");
    EXPECT_EQ(result.tags.size(), mirrored == 1 ? 1u : 0u);
    EXPECT_THAT(result.problem, mirrored == 1 ? HasSubstr("") : HasSubstr("3 tags are found only after a flip, and 1"));
    EXPECT_EQ(detect.warnings().size(), 1u);
  }
}

TEST(DetectNodes, SearchStripByStripLeavesOutWhatCannotBeRead) {
  const test::TemporaryFolder folder;
  write_png(folder.path() / "whole.png", render(scene()));
  const std::string bytes = test::read_file(folder.path() / "whole.png");
  std::ofstream(folder.path() / "cut.png", std::ios::binary) << bytes.substr(0, bytes.size() / 2);
  const auto run = [&](const std::string& name, int width) {
    test::NodeHarness detect("detect.tag_pyramid");
    detect.set("on_bad_image", "leave_out");
    ImageT image;
    image.path = name;
    image.uri = (folder.path() / name).string();
    image.width = width, image.height = 200;
    detect.input<Image>("images", image);
    detect.run();
    return detect.output<ImageTags>("observations");
  };
  const ImageTagsT found = run("whole.png", 200);
  ASSERT_EQ(found.tags.size(), 1u);
  EXPECT_EQ(found.tags[0]->id, 7);
  for (size_t i = 0; i < 4; ++i) EXPECT_LT((found.tags[0]->corners[i] - scene().corners[i]).norm(), 0.05);
  EXPECT_THAT(run("cut.png", 200).problem, testing::AllOf(HasSubstr("cut.png"), HasSubstr("truncated PNG")));
  EXPECT_THAT(run("whole.png", 300).problem, HasSubstr("was registered with 300 x 200"));
}

FileT table_of(const std::string& name, const std::string& text) {
  FileT file;
  file.name = name;
  file.content.assign(text.begin(), text.end());
  return file;
}

/// Quarters in black and white about `centre`, hardly blurred.
GreyImage quadrants(const Eigen::Vector2d& centre) {
  GreyImage image{200, 200, {}};
  const auto edge = [](double d) { return std::erf(d / 1.1); };
  for (int y = 0; y < 200; ++y)
    for (int x = 0; x < 200; ++x) {
      const Eigen::Vector2d d = Eigen::Vector2d(x, y) - centre;
      const double share = edge(0.9 * d.x() + 0.436 * d.y()) * edge(0.9 * d.y() - 0.436 * d.x());
      const double grey = d.norm() < 25 ? 120 + 80 * share : 120;
      image.pixels.push_back(static_cast<std::uint8_t>(std::lround(grey)));
    }
  return image;
}

std::string text_of(const FileT& file) { return {file.content.begin(), file.content.end()}; }

TEST(DetectNodes, MeasureTargetsWhereTheyArePredictedAndSayWhichTheyDoNot) {
  const test::TemporaryFolder folder;
  write_png(folder.path() / "a.png", quadrants({101.3, 98.6}));
  ImageT image;
  image.path = "site/a.png", image.uri = (folder.path() / "a.png").string(), image.width = image.height = 200;
  const test::Situation situation = [&] {
    test::NodeHarness detect("detect.target");
    detect.input<Image>("images", image);
    detect.input<File>("places", table_of("clicked.csv",
                                          "image,point,x,y\na.png,P1,104,96\na.png,P2,30,40\n"
                                          "b.png,P1,5,5\n"));
    return detect;
  };
  test::NodeHarness detect = situation();
  detect.run();
  const std::string table = text_of(detect.output<File>("table"));
  double x = 0, y = 0, sigma = 0;
  ASSERT_EQ(std::sscanf(table.c_str(), "image,point,x,y,sigma site/a.png,P1,%lf,%lf,%lf", &x, &y, &sigma), 3) << table;
  EXPECT_NEAR(x, 101.3, 0.02);
  EXPECT_NEAR(y, 98.6, 0.02);
  EXPECT_LT(sigma, 0.05);
  EXPECT_EQ(table.find("P2"), std::string::npos);
  EXPECT_THAT(detect.warnings(),
              testing::Contains(HasSubstr("target P2 is not measured: nothing there has a contrast")));
  EXPECT_THAT(detect.warnings(), testing::Contains(HasSubstr("b.png")));
  EXPECT_THAT(text_of(detect.output<File>("report")), HasSubstr("\"kind\": \"quadrants\""));
  test::NodeHarness elsewhere("detect.target");
  elsewhere.input<Image>("images", image);
  elsewhere.input<File>("places", table_of("clicked.csv", "image,point,x,y\nb.png,P1,104,96\n"));
  EXPECT_THAT(failure_of(elsewhere), HasSubstr("'clicked.csv' names other photographs"));
  EXPECT_EQ(test::parameters_at_fault({situation}), "");
  EXPECT_EQ(test::stopping_at_fault(situation), "");
}

/// Points on two planes, three cameras about them; the places are exact projections.
TEST(DetectNodes, TargetsArePredictedAndBecomeABlockThatAdjusts) {
  BrownCamera camera;
  camera.width = camera.height = 2000, camera.fx = 2100, camera.fy = 2090, camera.cx = 990, camera.cy = 1013;
  camera.k1 = -0.08, camera.p1 = 3e-4;
  CameraT given;
  given.id = "c", given.width = given.height = 2000;
  const auto values = camera.parameters();
  given.parameters.assign(values.begin(), values.end());
  PointsT points;
  for (int i = 0; i < 12; ++i) {
    auto point = std::make_unique<PointT>();
    point->id = "P" + std::to_string(i);
    point->position = {0.5 * (i % 4), 0.6 * (i / 4), i % 3 == 0 ? 0.4 : 0.0};
    point->sigma = Eigen::Vector3d::Constant(0.001);
    point->role = i < 4 || i == 11 ? "control" : "";
    points.points.push_back(std::move(point));
  }
  PosesT poses;
  std::vector<ImageT> images;
  for (int k = 0; k < 3; ++k) {
    auto pose = std::make_unique<PoseT>();
    pose->path = std::to_string(k) + ".png";
    const Eigen::Quaterniond rotation(Eigen::AngleAxisd(0.3 * (k - 1), Eigen::Vector3d::UnitY()) *
                                      Eigen::AngleAxisd(M_PI, Eigen::Vector3d::UnitX()));
    pose->cam_from_world = {rotation, -(rotation * Eigen::Vector3d(0.75 + 0.9 * (k - 1), 0.6, 3))};
    ImageT image;
    image.path = image.uri = pose->path, image.width = image.height = 2000;
    images.push_back(image);
    poses.poses.push_back(std::move(pose));
  }
  test::NodeHarness predict("predict.targets");
  for (const ImageT& image : images) predict.input<Image>("images", image);
  predict.input<Points>("points", points);
  predict.input<Poses>("poses", poses);
  predict.input<Camera>("cameras", given);
  predict.run();
  ASSERT_GT(predict.metric("predicted"), 30);

  PointsT approximate = points;
  for (auto& point : approximate.points)
    if (point->role.empty()) point->position += Eigen::Vector3d(0.01, -0.02, 0.03);
  test::NodeHarness block("block.of_targets");
  block.input<File>("table", predict.output<File>("places"));
  block.input<Points>("points", approximate);
  block.input<Poses>("poses", poses);
  block.input<Camera>("cameras", given);
  block.run();
  test::NodeHarness adjust("adjust.schur");
  adjust.input<ImageBlock>("block", block.output<ImageBlock>("block"));
  adjust.run();
  const PointsT adjusted = adjust.output<Points>("points");
  ASSERT_EQ(adjusted.points.size(), points.points.size());
  for (size_t i = 0; i < points.points.size(); ++i)
    EXPECT_LT((adjusted.points[i]->position - points.points[i]->position).norm(), 2e-6) << points.points[i]->id;
}

}  // namespace test_nodes
}  // namespace plumbline
