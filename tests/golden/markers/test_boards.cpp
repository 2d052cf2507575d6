// Boards that other people printed and photographed.
#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <cmath>
#include <map>

#include "geometry/similarity.hpp"
#include "geometry/statistics.hpp"
#include "photo/detect/aruco_detector.hpp"
#include "photo/detect/board.hpp"
#include "photo/images/grey_image.hpp"
#include "photo/markers/calibration.hpp"
#include "photo/markers/marker_block.hpp"
#include "test_support.hpp"

namespace plumbline {
namespace test_boards {

/// Every `step`th photograph of the folder, from `first` on, as a block of tags of one size.
markers::MarkerBlock block_of(const std::filesystem::path& folder, const std::string& family, double size, int images,
                              int step, int first = 0) {
  markers::MarkerBlock block;
  std::map<int, int> marker_of;
  const detect::ArucoDetector detector(detect::builtin_dictionary(family), {});
  for (int k = first; k < images; k += step) {
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
  const auto block = block_of(test::data_file(folder), "DICT_6X6_1000", 0.0375, 42, 1);
  const auto result = markers::adjust_marker_block(block, {});
  ASSERT_EQ(result.markers.size(), 20u);
  std::vector<Eigen::Vector3d> from, to;
  for (const auto& m : result.markers) {
    const int id = block.markers[m.marker].id;
    from.push_back(m.world_from_tag.translation);
    to.emplace_back(0.0425 * (id % 4), -0.0425 * (id / 4), 0);
  }
  const SimilarityMotion motion = fit_similarity(from, to, true);
  Eigen::Array3d squares = Eigen::Array3d::Zero();
  for (size_t i = 0; i < from.size(); ++i) squares += (motion * from[i] - to[i]).array().square();
  EXPECT_LT(std::sqrt(squares.x() / 20), 0.03e-3);
  EXPECT_LT(std::sqrt(squares.y() / 20), 0.03e-3);
  EXPECT_NEAR(motion.scale, 1, 1.5e-3);
  EXPECT_NEAR(result.cameras[0].camera.fx, 811.3, 4) << "OpenCV on all photographs: 811.3 +- 1.2";
}

/// Tags' centres in the order of their ids, with the covariance of all.
struct Centres {
  explicit Centres(const markers::MarkerBlock& block) {
    const auto result = markers::adjust_marker_block(block, {});
    std::map<int, Eigen::Index> by_id;
    for (size_t m = 0; m < result.markers.size(); ++m)
      by_id[block.markers[result.markers[m].marker].id] = static_cast<Eigen::Index>(m);
    covariance.resize(3 * std::ssize(by_id), 3 * std::ssize(by_id));
    for (const auto& [id, m] : by_id) {
      Eigen::Index column = 0;
      for (const auto& [other_id, other] : by_id)
        covariance.block<3, 3>(3 * std::ssize(places), 3 * column++) =
            result.centre_covariance.block<3, 3>(3 * m, 3 * other);
      ids.push_back(id);
      places.push_back(result.markers[m].world_from_tag.translation);
    }
  }
  std::vector<int> ids;
  std::vector<Eigen::Vector3d> places;
  Eigen::MatrixXd covariance;
};

/// No print is as true as the network, and paper is wavy; but what one half of the photographs finds, with its own
/// calibration, the other half has to find within both covariances. Every second photograph is from the places of the
/// other half's, so the halves agree better than covariances say that hold how photographs from all sides differ.
TEST(Boards, HalvesOfThePhotographsAgreeWithinTheirCovariances) {
  const std::string folder = "images/aruco_grid/aruco_data";
  PLUMBLINE_REQUIRE_DATA(folder + "/0.jpg");
  const Centres one(block_of(test::data_file(folder), "DICT_6X6_1000", 0.0375, 42, 2, 0));
  const Centres two(block_of(test::data_file(folder), "DICT_6X6_1000", 0.0375, 42, 2, 1));
  ASSERT_EQ(one.ids, two.ids);
  const SimilarityMotion motion = fit_similarity(two.places, one.places, false);
  const auto n = std::ssize(one.places);
  Eigen::VectorXd difference(3 * n);
  Eigen::MatrixXd turned = two.covariance, motions(3 * n, 6);
  const Eigen::Matrix3d rotation = motion.rotation.toRotationMatrix();
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  for (const auto& p : one.places) centre += p / static_cast<double>(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const auto k = static_cast<size_t>(i);
    difference.segment<3>(3 * i) = motion * two.places[k] - one.places[k];
    motions.middleRows<3>(3 * i) << Eigen::Matrix3d::Identity(), -skew(one.places[k] - centre);
    for (Eigen::Index j = 0; j < n; ++j)
      turned.block<3, 3>(3 * i, 3 * j) = rotation * two.covariance.block<3, 3>(3 * i, 3 * j) * rotation.transpose();
  }
  // A motion of one against the other is free: so uncertain that what the fit above left of it counts for nothing.
  const Eigen::MatrixXd both = one.covariance + turned + 1e-2 * motions * motions.transpose();
  const double nees = difference.dot(both.ldlt().solve(difference)), freedom = static_cast<double>(3 * n - 6);
  EXPECT_GT(nees, 0.5 * chi_squared_quantile(0.005, freedom));
  EXPECT_LT(nees, chi_squared_quantile(0.995, freedom));
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

}  // namespace test_boards
}  // namespace plumbline
