// calibrate.board over its artifacts: which photographs of a board are one camera's.
#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "artifacts/board_points.hpp"
#include "artifacts/camera.hpp"
#include "artifacts/file.hpp"
#include "artifacts/tag_observations.hpp"
#include "geometry/camera.hpp"
#include "geometry/edge_inset.hpp"
#include "node_harness.hpp"
#include "photo/cameras/camera_files.hpp"
#include "photo/markers/calibration_parts.hpp"
#include "scene.hpp"
#include "stopping.hpp"

namespace plumbline::markers {
namespace test_calibrate_nodes {

using testing::Contains;
using testing::HasSubstr;
using testing::Not;

/// A board of 9 × 7 points from another side for each `index`.
BoardPointsT photograph(int index, const std::string& taken_with, double right_by = 0) {
  BoardPointsT result;
  result.path = "photo" + std::to_string(index) + ".jpg";
  result.width = true_camera().width, result.height = true_camera().height;
  result.taken_with = taken_with;
  const RigidTransform pose =
      look({0.1 + 0.05 * (index % 3 - 1), 0.075 + 0.06 * (index % 4 - 1.5), 0.3}, {0.1, 0.075, 0}, 0.4 * index);
  const RigidTransform beside{Eigen::Quaterniond::Identity(), {-right_by, 0, 0}};
  std::mt19937_64 random(static_cast<unsigned>(index));
  std::normal_distribution<double> noise(0, 0.05);
  for (int k = 0; k < 63; ++k) {
    auto point = std::make_unique<BoardPointT>();
    point->id = k;
    point->board = Eigen::Vector3d(0.025 * (k % 9), 0.025 * (k / 9), 0);
    point->pixel =
        *project(true_camera(), beside * (pose * point->board)) + Eigen::Vector2d(noise(random), noise(random));
    point->sigma = 0.05;
    result.points.push_back(std::move(point));
  }
  return result;
}

TEST(CalibrateBoard, CanBeStopped) {
  EXPECT_EQ(test::stopping_at_fault([] {
              test::NodeHarness node("calibrate.board");
              for (int k = 0; k < 12; ++k) node.input<BoardPoints>("points", photograph(k, ""));
              return node;
            }),
            "");
}

TEST(CalibrateBoard, PhotographsOfAnotherBodyOrSizeAreNotTakenForTheCameras) {
  const auto run = [](const std::string& cameras, test::NodeHarness& node) {
    for (int k = 0; k < 12; ++k)
      node.input<BoardPoints>("points", photograph(k, k == 5  ? ""
                                                      : k < 8 ? "Acme One 111, 24 mm"
                                                              : "Acme One 222, 24 mm"));
    BoardPointsT other = photograph(12, "Acme One 111, 24 mm");
    other.width /= 2, other.height /= 2;
    node.input<BoardPoints>("points", other);
    node.set("cameras", cameras);
    node.run();
    const FileT json = node.output<File>("json");
    return std::string(json.content.begin(), json.content.end());
  };
  test::NodeHarness node("calibrate.board");
  run("by_folder", node);
  EXPECT_THAT(node.warnings(), Contains(HasSubstr("left out: photo8.jpg: was taken with another camera or focal length "
                                                  "(Acme One 222, 24 mm) than the others (Acme One 111, 24 mm)")));
  EXPECT_THAT(node.warnings(), Contains(HasSubstr("left out: photo12.jpg: has 800 x 600 pixels where the others have "
                                                  "1600 x 1200")));
  EXPECT_THAT(node.warnings(), Not(Contains(HasSubstr("left out: photo5.jpg"))));
  test::NodeHarness one("calibrate.board");
  run("one", one);
  EXPECT_THAT(one.warnings(), Not(Contains(HasSubstr("left out: photo8.jpg"))));
}

/// One photograph whose markers came out smaller than the file says, among those that agree with it, is blurred.
TEST(CalibrateBoard, OneBlurredPhotographDoesNotMakeTheBoardFileWrong) {
  const auto run = [](int blurred, test::NodeHarness& node) {
    for (int k = 0; k < 12; ++k) {
      BoardPointsT taken = photograph(k, "");
      taken.marker_ratio = taken.stated_marker_ratio = 0.75;
      if (k < blurred) {
        taken.points.clear(), taken.contradicts = true, taken.marker_ratio = 0.704;
        taken.problem =
            "the markers measure 0.704 of a square, 0.750 is in b.yaml: 'marker' or 'square' there is wrong";
      }
      node.input<BoardPoints>("points", taken);
    }
    node.run();
  };
  test::NodeHarness node("calibrate.board");
  run(1, node);
  EXPECT_THAT(
      node.warnings(),
      Contains(HasSubstr("left out: photo0.jpg: its markers measure 0.704 of their squares or spacing, those of "
                         "the 11 others 0.750, as the board file has it: this one is blurred")));
  EXPECT_THAT(node.warnings(), Not(Contains(HasSubstr("is wrong"))));
  test::NodeHarness wrong("calibrate.board");
  try {
    run(8, wrong);
    ADD_FAILURE() << "most contradict the file";
  } catch (const test::NodeFailed& error) {
    EXPECT_THAT(error.what(), HasSubstr("'marker' or 'square' there is wrong"));
  }
}

/// Several photographs whose markers all came out the same other size show another board.
TEST(CalibrateBoard, PhotographsOfAnotherBoardAreNotExcusedAsBlurred) {
  test::NodeHarness node("calibrate.board");
  for (int k = 0; k < 12; ++k) {
    BoardPointsT taken = photograph(k, "");
    taken.stated_marker_ratio = 0.75;
    taken.marker_ratio = k == 9 ? 0.66 : k < 3 ? 0.704 + 0.0005 * k : 0.75;
    if (k < 3 || k == 9) taken.points.clear(), taken.contradicts = true, taken.problem = "'marker' is wrong";
    node.input<BoardPoints>("points", taken);
  }
  node.run();
  EXPECT_THAT(node.warnings(),
              Contains(testing::AllOf(HasSubstr("left out: photo1.jpg: its markers measure 0.704"),
                                      HasSubstr("it shows another board"), Not(HasSubstr("blurred")))));
  EXPECT_THAT(node.warnings(), Contains(testing::AllOf(HasSubstr("left out: photo9.jpg"), HasSubstr("blurred"))));
}

/// A file that is wrong by less than a blurred photograph is off: each photograph may pass, all together may not.
TEST(CalibrateBoard, SaysWhatTheFileHasWhereAllMarkersAreALittleOff) {
  const auto warnings = [](double stated) {
    test::NodeHarness node("calibrate.board");
    for (int k = 0; k < 12; ++k) {
      BoardPointsT taken = photograph(k, "");
      taken.stated_marker_ratio = stated, taken.marker_ratio = k == 4 ? 0.70 : 0.74;
      if (k == 5 && stated > 0.76) taken.marker_ratio = 0.732;
      if (k == 4 || (k == 5 && stated > 0.76))
        taken.points.clear(), taken.contradicts = true, taken.problem = "'marker' is wrong";
      node.input<BoardPoints>("points", taken);
    }
    node.run();
    return node.warnings();
  };
  const auto wrong = warnings(0.781);
  EXPECT_THAT(wrong, Contains(HasSubstr("in most of the 10 photographs the markers measure 0.740 of their squares or "
                                        "spacing, the board file has 0.781")));
  EXPECT_THAT(wrong,
              Contains(HasSubstr("those of the 10 others 0.740, the board file has 0.781: this one is blurred")));
  EXPECT_THAT(wrong, Contains(testing::AllOf(HasSubstr("left out: photo5.jpg: its markers measure 0.732"),
                                             HasSubstr("it is the same board"), HasSubstr("mend the file"))));
  const auto right = warnings(0.75);
  EXPECT_THAT(right, Not(Contains(HasSubstr("in most of the"))));
  EXPECT_THAT(right, Contains(HasSubstr("as the board file has it")));
}

/// Two photographs that motion blurred in the same way measure alike: they show no other board.
TEST(CalibrateBoard, PhotographsThatMotionBlurredShowNoOtherBoard) {
  test::NodeHarness node("calibrate.board");
  for (int k = 0; k < 12; ++k) {
    BoardPointsT taken = photograph(k, "");
    taken.stated_marker_ratio = 0.75, taken.marker_ratio = k < 2 ? 0.704 : 0.75;
    if (k < 2) taken.points.clear(), taken.contradicts = true, taken.moved = "it is blurred up and down";
    if (k < 2) taken.problem = "'marker' is wrong", taken.sha256 = std::string(64, k == 0 ? 'a' : 'b');
    node.input<BoardPoints>("points", taken);
  }
  node.run();
  EXPECT_THAT(node.warnings(), Contains(testing::AllOf(HasSubstr("left out: photo1.jpg: its markers measure 0.704"),
                                                       HasSubstr(": it is blurred up and down"))));
  EXPECT_THAT(node.warnings(), Not(Contains(HasSubstr("another board"))));
}

/// One blurred photograph and a copy of it are one photograph, not two of another board.
TEST(CalibrateBoard, ACopyOfAPhotographIsNoSecondWitness) {
  for (const bool copied : {true, false}) {
    test::NodeHarness node("calibrate.board");
    for (int k = 0; k < 12; ++k) {
      BoardPointsT taken = photograph(k, "");
      taken.stated_marker_ratio = 0.75;
      taken.marker_ratio = k < 2 ? 0.704 : 0.75;
      if (k < 2) taken.points.clear(), taken.contradicts = true, taken.problem = "'marker' is wrong";
      if (k < 2) taken.sha256 = copied || k == 0 ? std::string(64, 'a') : std::string(64, 'b');
      node.input<BoardPoints>("points", taken);
    }
    node.run();
    EXPECT_THAT(node.warnings(), Contains(testing::AllOf(HasSubstr("left out: photo0.jpg: its markers measure 0.704"),
                                                         HasSubstr(copied ? "blurred" : "it shows another board"))));
  }
}

/// Two cameras that differ by less than is told: each half fits, and between them they contradict the covariance.
TEST(CalibrateBoard, StatesByHowMuchPartsContradictEachOther) {
  test::NodeHarness node("calibrate.board");
  std::vector<CalibrationView> views;
  for (int k = 0; k < 16; ++k) {
    BoardPointsT taken = photograph(k, "");
    if (k >= 8)
      for (auto& point : taken.points) point->pixel = 1.01 * point->pixel;  // zoomed
    CalibrationView& view = views.emplace_back();
    view.path = taken.path;
    for (const auto& point : taken.points) view.points.push_back({point->board, point->pixel, point->sigma});
    node.input<BoardPoints>("points", taken);
  }
  node.set("lens", "brown"), node.set("bend_sigma", "0");
  node.run();
  const Calibration alone = calibrate(views, true_camera().width, true_camera().height, {});
  const double factor = shown_too_small_by(compare_parts(views, {}, alone));
  ASSERT_GT(factor, 2) << "the case shows nothing";
  const double stated = node.output<Camera>("cameras").covariance[0];
  EXPECT_NEAR(stated, factor * factor * alone.covariance(0, 0), 1e-6 * stated);
}

/// A board of 6 × 4 tags, corners numbered as detect.board numbers them; all edges drawn in by `inset` [px].
BoardPointsT tags_photographed(int index, unsigned seed, double inset) {
  BoardPointsT result = photograph(index, "");
  const RigidTransform pose =
      look({0.1 + 0.05 * (index % 3 - 1), 0.075 + 0.06 * (index % 4 - 1.5), 0.3}, {0.1, 0.075, 0}, 0.4 * index);
  std::mt19937_64 random(1000 * seed + static_cast<unsigned>(index));
  std::normal_distribution<double> noise(0, 0.03);
  result.points.clear();
  for (int tag = 0; tag < 24; ++tag) {
    std::array<Eigen::Vector2d, 4> corners;
    std::array<Eigen::Vector3d, 4> places;
    for (int c = 0; c < 4; ++c) {
      const auto k = static_cast<std::size_t>(c);
      places[k] = {0.036 * (tag % 6) + (c == 1 || c == 2 ? 0.028 : 0), 0.04 * (tag / 6) + (c >= 2 ? 0.028 : 0), 0};
      corners[k] = *project(true_camera(), pose * places[k]);
    }
    const auto moved = moved_by_inset(corners);
    for (int c = 0; c < 4; ++c) {
      const auto k = static_cast<std::size_t>(c);
      auto point = std::make_unique<BoardPointT>();
      point->id = 4 * tag + c, point->board = places[k], point->sigma = 0.03;
      point->pixel = corners[k] + inset * moved[k] + Eigen::Vector2d(noise(random), noise(random));
      result.points.push_back(std::move(point));
    }
  }
  return result;
}

CalibrationView view_of(const BoardPointsT& taken, double inset_sigma) {
  CalibrationView view;
  view.path = taken.path;
  for (std::size_t k = 0; k < taken.points.size(); k += 4) {
    std::array<Eigen::Vector2d, 4> corners;
    for (std::size_t c = 0; c < 4; ++c) corners[c] = taken.points[k + c]->pixel;
    const auto moved = moved_by_inset(corners);
    for (std::size_t c = 0; c < 4; ++c)
      view.points.push_back({taken.points[k + c]->board, corners[c], 0.03, inset_sigma * moved[c]});
  }
  return view;
}

/// What a detector may draw all edges in by is one quantity of all tags: no scatter of the corners shows it. In the
/// combination of parameters that it moves most, the covariance holds it over many calibrations, each of photographs
/// drawn in by another inset, and the corners' covariance alone does not.
TEST(CalibrateBoard, HoldsWhatAllEdgesAreDrawnInwardsBy) {
  constexpr double inset_sigma = 0.3;
  constexpr unsigned trials = 30;
  double with = 0, without = 0;
  std::mt19937_64 random(3);
  std::normal_distribution<double> normal;
  const auto truth = true_camera().parameters();
  for (unsigned seed = 0; seed < trials; ++seed) {
    const double inset = inset_sigma * normal(random);
    std::vector<CalibrationView> views;
    for (int k = 0; k < 12; ++k) views.push_back(view_of(tags_photographed(k, seed, inset), inset_sigma));
    const Calibration c = calibrate(views, true_camera().width, true_camera().height, {});
    const Eigen::MatrixXd own = c.own_covariance();
    const Eigen::VectorXd most = own.ldlt().solve(c.by_inset);
    Eigen::VectorXd error(truth.size());
    for (std::size_t k = 0; k < truth.size(); ++k)
      error(static_cast<Eigen::Index>(k)) = c.camera.parameters()[k] - truth[k];
    const double square = std::pow(most.dot(error), 2) / trials;
    with += square / most.dot(c.covariance * most), without += square / most.dot(own * most);
  }
  RecordProperty("with", std::to_string(with)), RecordProperty("without", std::to_string(without));
  EXPECT_GT(without, 2) << "the case shows nothing";
  EXPECT_GT(with, 0.5);
  EXPECT_LT(with, 1.6);
}

/// The file has it: detect.board states it of the photographs, calibrate.board of the camera.
TEST(CalibrateBoard, TakesFromTheDetectorWhatEdgesMayBeDrawnInBy) {
  const auto stated = [](double inset_sigma) {
    test::NodeHarness node("calibrate.board");
    for (int k = 0; k < 6; ++k) {
      BoardPointsT taken = tags_photographed(k, 1, 0);
      taken.corner_inset_sigma = inset_sigma;
      node.input<BoardPoints>("points", taken);
    }
    node.set("lens", "brown"), node.set("bend_sigma", "0");
    node.run();
    return node.output<Camera>("cameras").covariance[0];
  };
  EXPECT_GT(stated(1), 1.0001 * stated(std::nan("")));
}

/// The board close before a fisheye, to 60 degrees off its axis.
BoardPointsT fisheye_photograph(int index) {
  BoardPointsT result = photograph(index, "");
  const Eigen::Vector3d centre(0.1 + 0.04 * (index % 3 - 1), 0.075 + 0.05 * (index % 4 - 1.5),
                               0.1 + 0.01 * (index % 5));
  const RigidTransform pose = look(centre, {0.1 + 0.02 * (index % 2), 0.075, 0}, 0.4 * index);
  std::mt19937_64 random(static_cast<unsigned>(index));
  std::normal_distribution<double> noise(0, 0.05);
  for (auto& point : result.points)
    point->pixel = *project(true_fisheye(), pose * point->board) + Eigen::Vector2d(noise(random), noise(random));
  return result;
}

TEST(CalibrateBoard, AFisheyeIsCalibratedAsOneAndSaysSo) {
  const auto run = [](const std::string& lens, test::NodeHarness& node) {
    for (int k = 0; k < 12; ++k) node.input<BoardPoints>("points", fisheye_photograph(k));
    if (!lens.empty()) node.set("lens", lens);
    node.run();
    return node.output<Camera>("cameras");
  };
  test::NodeHarness found("calibrate.board"), brown("calibrate.board");
  const CameraT camera = run("", found);
  EXPECT_EQ(camera.lens, "fisheye");
  ASSERT_EQ(camera.parameters.size(), 8u);
  EXPECT_EQ(camera.covariance.size(), 45u);
  EXPECT_NEAR(camera.parameters[0], 560, 4 * std::sqrt(camera.covariance[0]));
  EXPECT_NEAR(camera.parameters[7], true_fisheye().k4, 4 * std::sqrt(camera.covariance[35]));
  EXPECT_THAT(found.warnings(), Contains(testing::AllOf(HasSubstr("The lens is a fisheye"),
                                                        HasSubstr("photographs that the lens was not fitted to"))));
  const FileT yaml = found.output<File>("yaml");
  const cameras::CameraFile read =
      cameras::parse_camera_file({yaml.content.begin(), yaml.content.end()}, "camera.yaml");
  EXPECT_EQ(read.camera.lens, LensModel::fisheye);
  EXPECT_EQ(read.camera.k4, camera.parameters[7]);
  EXPECT_EQ(run("brown", brown).lens, "") << "as it was asked for";
  EXPECT_THAT(brown.warnings(), Contains(HasSubstr("wrong towards the corners by more than its standard deviations")));
}

/// What camera.yaml has of the covariance is what calibration.json and the artifact have.
TEST(CalibrateBoard, WritesOneCovarianceEverywhere) {
  test::NodeHarness node("calibrate.board");
  for (int k = 0; k < 12; ++k) node.input<BoardPoints>("points", photograph(k, ""));
  node.run();
  const FileT yaml = node.output<File>("yaml"), file = node.output<File>("json");
  const cameras::CameraFile read =
      cameras::parse_camera_file({yaml.content.begin(), yaml.content.end()}, "camera.yaml");
  const auto json = nlohmann::json::parse(file.content.begin(), file.content.end());
  ASSERT_EQ(json["covariance_lower_triangle"].size(), 45u);
  std::size_t at = 0;
  for (Eigen::Index i = 0; i < 9; ++i)
    for (Eigen::Index j = 0; j <= i; ++j, ++at) {
      const double value = json["covariance_lower_triangle"][at];
      EXPECT_NEAR(read.covariance(i, j), value, 1e-9 * std::sqrt(read.covariance(i, i) * read.covariance(j, j)));
    }
  EXPECT_GT(std::abs(read.covariance(1, 0)), 0.5 * read.covariance(0, 0)) << "fx and fy go together";
  EXPECT_TRUE(json["scatter_of_photographs"]["judged"]);
  EXPECT_THAT(std::string(yaml.content.begin(), yaml.content.end()), HasSubstr("# sigmas: "));
}

TEST(CalibrateBoard, AFolderForEachMomentIsARig) {
  test::NodeHarness node("calibrate.board");
  for (int k = 0; k < 12; ++k)
    for (int camera = 0; camera < 2; ++camera) {
      BoardPointsT taken = photograph(k, "", 0.02 * camera);
      taken.path = "000" + std::to_string(k) + "/cam" + std::to_string(camera) + ".png";
      node.input<BoardPoints>("points", taken);
    }
  node.run();
  const FileT file = node.output<File>("json");
  const auto json = nlohmann::json::parse(file.content.begin(), file.content.end());
  ASSERT_EQ(json["cameras"].size(), 2u);
  EXPECT_EQ(json["cameras"][1]["id"], "cam1");
  ASSERT_EQ(json["rig"].size(), 1u);
  EXPECT_EQ(json["rig"][0]["shared"], 12);
  EXPECT_EQ(json["rig"][0]["moments"][3], "0003");
  EXPECT_NEAR(json["rig"][0]["translation"][0], -0.02, 0.0005);
}

TEST(MarkerBoard, PicturesSideBySideAreRefused) {
  const auto failure = [](int twice) {
    test::NodeHarness node("adjust.marker_board");
    node.set("tag_size", "0.02");
    TagObservationsT seen;
    for (int k = 0; k < 4; ++k) {
      auto image = std::make_unique<ImageTagsT>();
      image->path = std::to_string(k) + ".png", image->width = 1280, image->height = 360;
      for (int id = 0; id < 4; ++id)
        for (int half = 0; half < (id < twice ? 2 : 1); ++half) {
          auto tag = std::make_unique<TagT>();
          tag->family = "tag36h11", tag->id = id;
          const double x = 100 + 640 * half + 90 * (id % 2), y = 60 + 90 * (id / 2);
          tag->corners = {{x, y + 40}, {x + 40, y + 40}, {x + 40, y}, {x, y}};
          image->tags.push_back(std::move(tag));
        }
      seen.images.push_back(std::move(image));
    }
    node.input<TagObservations>("observations", seen);
    try {
      node.run();
    } catch (const test::NodeFailed& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_THAT(failure(3), HasSubstr("most tags are twice in their photographs (12 of 16, the first in 0.png)"));
  EXPECT_THAT(failure(1), Not(HasSubstr("most tags are twice")));
}

/// A wrong family reads a square of the scene now and then: two photographs with one such tag each are no block.
TEST(MarkerBoard, ChanceTagsOfAWrongFamilyAreRefused) {
  const auto failure = [](int with, int tags) {
    test::NodeHarness node("adjust.marker_board");
    node.set("tag_size", "0.02");
    TagObservationsT seen;
    for (int k = 0; k < 12; ++k) {
      auto image = std::make_unique<ImageTagsT>();
      image->path = std::to_string(k) + ".png", image->width = 1280, image->height = 720;
      if (k >= with) image->problem = "it shows 20 tags of DICT_6X6_50: the family is wrong";
      for (int id = 0; id < (k < with ? tags : 0); ++id) {
        auto tag = std::make_unique<TagT>();
        tag->family = "DICT_5X5_1000", tag->id = 215 + id;
        const double x = 100 + 90 * id + 3 * k, y = 200 + 5 * k;
        tag->corners = {{x, y + 40}, {x + 40, y + 41}, {x + 41, y}, {x, y}};
        image->tags.push_back(std::move(tag));
      }
      seen.images.push_back(std::move(image));
    }
    node.input<TagObservations>("observations", seen);
    try {
      node.run();
    } catch (const test::NodeFailed& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_THAT(failure(2, 1),
              testing::AllOf(HasSubstr("10 of 12 photographs show no tag of the family and the others one each (215 in "
                                       "0.png, 215 in 1.png)"),
                             HasSubstr("the family is wrong"), HasSubstr("Give the family")));
  EXPECT_THAT(failure(6, 1), Not(HasSubstr("no tag of the family")));
  EXPECT_THAT(failure(2, 2), Not(HasSubstr("no tag of the family")));
}

}  // namespace test_calibrate_nodes
}  // namespace plumbline::markers
