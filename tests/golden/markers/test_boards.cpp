// Boards that other people printed and photographed.
#include <Eigen/Geometry>
#include <cmath>
#include <map>

#include "detect/aruco_detector.hpp"
#include "detect/board.hpp"
#include "geometry/similarity.hpp"
#include "images/grey_image.hpp"
#include "markers/calibration.hpp"
#include "markers/marker_block.hpp"
#include "test_support.hpp"

namespace plumbline {
namespace {

/// Every `step`th photograph of the folder as a block of tags of one size.
markers::MarkerBlock block_of(const std::filesystem::path& folder, const std::string& family, double size, int images,
                              int step) {
  markers::MarkerBlock block;
  std::map<int, int> marker_of;
  const detect::ArucoDetector detector(detect::builtin_dictionary(family), {});
  for (int k = 0; k < images; k += step) {
    const std::string name = std::to_string(k) + ".jpg";
    const GreyImage image = read_grey_image(folder / name);
    if (block.cameras.empty()) {
      block.cameras.emplace_back();
      block.cameras[0].camera.width = image.width, block.cameras[0].camera.height = image.height;
    }
    block.images.push_back({name, 0});
    for (const auto& tag : detector.detect(image)) {
      const auto [at, is_new] = marker_of.emplace(tag.id, static_cast<int>(block.markers.size()));
      if (is_new) block.markers.push_back({family, tag.id, size, std::nullopt});
      block.views.push_back(
          {static_cast<int>(block.images.size()) - 1, at->second, tag.corners, tag.covariances, tag.refined});
    }
  }
  return block;
}

TEST(Boards, TagsOfThePrintedGridAreWhereTheyWerePrinted) {
  const std::string folder = "images/aruco_grid/aruco_data";
  PLUMBLINE_REQUIRE_DATA(folder + "/0.jpg");
  const auto block = block_of(test::data_file(folder), "DICT_6X6_1000", 0.0375, 42, 3);
  const auto result = markers::adjust_marker_block(block, {});
  ASSERT_EQ(result.markers.size(), 20u);
  std::vector<Eigen::Vector3d> from, to;
  for (const auto& m : result.markers) {
    const int id = block.markers[static_cast<size_t>(m.marker)].id;
    from.push_back(m.world_from_tag.translation);
    to.emplace_back(0.0425 * (id % 4), -0.0425 * (id / 4), 0);
  }
  const SimilarityMotion motion = fit_similarity(from, to, true);
  double in_plane = 0;
  for (size_t i = 0; i < from.size(); ++i) in_plane += (motion * from[i] - to[i]).head<2>().squaredNorm();
  EXPECT_LT(std::sqrt(in_plane / 40), 0.04e-3);
  EXPECT_NEAR(motion.scale, 1, 1.5e-3);
  EXPECT_NEAR(result.cameras[0].camera.fx, 811.3, 4) << "OpenCV on all photographs: 811.3 +- 1.2";
}

TEST(Boards, ArucoAndAprilTagAgreeOnCornersAndTheirOrder) {
  const std::string file = "images/apriltag/33369213973_9d9bb4cc96_c.jpg";
  PLUMBLINE_REQUIRE_DATA(file);
  const GreyImage image = read_grey_image(test::data_file(file));
  const auto april = detect::TagDetector({}).detect(image);
  const auto aruco = detect::ArucoDetector(detect::builtin_dictionary("tag36h11"), {}).detect(image);
  int compared = 0;
  for (const auto& a : april)
    for (const auto& b : aruco) {
      if (a.id != b.id || (a.corners[0] - b.corners[0]).norm() > 4) continue;
      ++compared;
      for (size_t k = 0; k < 4; ++k)
        EXPECT_LT((a.corners[k] - b.corners[k]).norm(), a.refined && b.refined ? 0.3 : 2.0) << a.id;
    }
  EXPECT_GE(compared, 6);
}

TEST(Boards, CharucoCalibrationIsAsGoodAsOpenCVs) {
  const std::string folder = "images/charuco_lifecam_1280";
  PLUMBLINE_REQUIRE_DATA(folder + "/Microsoft_LifeCam_HD-3000-1280_output_2024-05-07T080500613.jpg");
  const auto board = detect::parse_board(
      "type: charuco\ncolumns: 8\nrows: 8\nsquare: 0.0254\nmarker: 0.01905\ndictionary: DICT_4X4_50\n", "board.yaml");
  std::vector<markers::CalibrationView> views;
  for (const auto& entry : std::filesystem::directory_iterator(test::data_file(folder))) {
    const auto seen = detect::find_board(read_grey_image(entry.path()), board);
    EXPECT_EQ(seen.problem, "") << entry.path();
    EXPECT_NEAR(seen.marker_ratio, 0.75, 0.03);
    markers::CalibrationView view;
    view.path = entry.path().filename().string();
    for (const auto& p : seen.points) view.points.push_back({p.board, p.pixel, p.sigma});
    views.push_back(view);
  }
  const auto c = markers::calibrate(views, 1280, 720, {});
  EXPECT_GT(c.observations, 2 * 730);
  EXPECT_LT(c.rms, 0.24) << "OpenCV: 0.2325 px on 749 corners";
  EXPECT_NEAR(c.camera.fx, 1127.3, 8) << "OpenCV: 1127.3 +- 2.5";
}

}  // namespace
}  // namespace plumbline
