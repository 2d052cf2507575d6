// Blocks of tags and calibrations whose truth is known.
#include <gmock/gmock.h>

#include <Eigen/LU>
#include <random>

#include "geometry/statistics.hpp"
#include "photo/markers/calibration.hpp"
#include "photo/markers/marker_block.hpp"
#include "photo/markers/marker_datum.hpp"
#include "photo/markers/marker_halves.hpp"
#include "photo/markers/marker_words.hpp"
#include "photo/markers/planar_pose.hpp"
#include "scene.hpp"
#include "test_support.hpp"

namespace plumbline::markers {
namespace test_blocks {

using testing::HasSubstr;

TEST(PlanarPose, GivesBothPosesOfASquareTheTrueOneFirst) {
  const RigidTransform truth = look({0.2, -0.4, 1.6}, {0, 0, 0}, 0.3);
  std::array<Eigen::Vector2d, 4> corners;
  for (size_t k = 0; k < 4; ++k) corners[k] = (truth * corner(0.1, k)).hnormalized();
  const auto poses = poses_of_square(corners, 0.1);
  ASSERT_EQ(poses.size(), 2u);
  EXPECT_LT(poses[0].rms, 1e-12);
  EXPECT_LT(poses[0].cam_from_figure.rotation.angularDistance(truth.rotation), 1e-9);
  EXPECT_LT((poses[0].cam_from_figure.translation - truth.translation).norm(), 1e-9);
  // The other one is tilted the other way and fits a tag this small to a hundredth of its size.
  EXPECT_GT(poses[1].cam_from_figure.rotation.angularDistance(truth.rotation), 0.1);
  EXPECT_GT(poses[1].rms, 1e-6);
  EXPECT_LT(poses[1].rms, 1e-2);
}

TEST(MarkerBlock, RecoversTagsAndCameraWithoutNoiseAndWithoutAnyStart) {
  const Scene s = scene(0, 1);
  const MarkerResult result = adjust_marker_block(s.block, {});
  ASSERT_EQ(result.markers.size(), 12u);
  EXPECT_LT(error_of(s, result), 2e-6);
  EXPECT_NEAR(result.cameras[0].camera.fx, 1500, 0.2);
  EXPECT_NEAR(result.cameras[0].camera.k1, -0.12, 1e-3);
  for (const auto& image : result.images) EXPECT_TRUE(image.oriented);
  // Corners are those of the tag in its own frame.
  EXPECT_NEAR((result.markers[3].corners[1] - result.markers[3].corners[0]).norm(), 0.12, 1e-5);
  EXPECT_LT((0.25 * (result.markers[3].corners[0] + result.markers[3].corners[1] + result.markers[3].corners[2] +
                     result.markers[3].corners[3]) -
             result.markers[3].world_from_tag.translation)
                .norm(),
            1e-12);
  EXPECT_LT(result.markers[0].world_from_tag.translation.norm(), 1e-12) << "the frame is that of the lowest id";
}

/// A fisheye calibrates itself with its tags, and takes a calibration.
TEST(MarkerBlock, RecoversTagsThroughAFisheye) {
  Scene s = scene(0, 1, 10, true_fisheye());
  const MarkerResult result = adjust_marker_block(s.block, {});
  ASSERT_EQ(result.markers.size(), 12u);
  EXPECT_LT(error_of(s, result), 5e-6);
  EXPECT_EQ(result.cameras[0].camera.lens, LensModel::fisheye);
  EXPECT_NEAR(result.cameras[0].camera.fx, 560, 0.3);
  s.block.cameras[0].camera = true_fisheye();
  s.block.cameras[0].covariance = Eigen::MatrixXd::Zero(9, 9);
  s.block.cameras[0].covariance.diagonal().head<8>() << 1, 1, 1, 1, 1e-4, 1e-4, 1e-4, 1e-4;
  s.block.cameras[0].camera.fx += 0.5, s.block.cameras[0].camera.k4 += 1e-3;
  const MarkerResult calibrated = adjust_marker_block(s.block, {});
  EXPECT_LT(error_of(s, calibrated), 5e-6);
  EXPECT_NEAR(calibrated.cameras[0].camera.fx, 560, 0.3);
}

/// Asked for nothing, the tags say which lens it was; of a lens that is Brown's they say so, too.
TEST(MarkerBlock, TellsAFisheyeByItsTags) {
  InteriorOrientation wide = true_fisheye();
  wide.fx = wide.fy = 320;  // up to 50 degrees off the axis
  Scene fisheye = scene(0.1, 1, 10, wide, 0.7), brown = scene(0.1, 1);
  fisheye.block.cameras[0].camera.lens = LensModel::brown;
  const MarkerResult found = adjust_lens_and_block(fisheye.block, {});
  EXPECT_EQ(found.cameras[0].camera.lens, LensModel::fisheye);
  EXPECT_EQ(fisheye.block.cameras[0].camera.lens, LensModel::fisheye) << "halves of the block follow it";
  ASSERT_FALSE(found.warnings.empty());
  EXPECT_THAT(found.warnings.front(), HasSubstr("the lens is a fisheye"));
  EXPECT_LT(error_of(fisheye, found), 2e-3);
  const MarkerResult plain = adjust_lens_and_block(brown.block, {});
  EXPECT_EQ(plain.cameras[0].camera.lens, LensModel::brown);
  for (const auto& words : plain.warnings) EXPECT_THAT(words, testing::Not(HasSubstr("fisheye")));
}

/// Few photographs by a fisheye that Brown's model does not adjust at all: the fisheye's does.
TEST(MarkerBlock, TriesAFisheyeWhereBrownsModelDoesNotAdjust) {
  InteriorOrientation wide = true_fisheye();
  wide.fx = wide.fy = 150;
  int thrown = 0, taken = 0;
  for (int photographs = 3; photographs <= 5 && taken == 0; ++photographs)
    for (unsigned seed = 1; seed <= 4 && taken == 0; ++seed) {
      Scene fisheye = scene(0.1, seed, photographs, wide, 0.25);
      fisheye.block.cameras[0].camera.lens = LensModel::brown;
      try {
        adjust_marker_block(fisheye.block, {});
        continue;
      } catch (const std::runtime_error&) {
        ++thrown;
      }
      try {
        const MarkerResult found = adjust_lens_and_block(fisheye.block, {});
        EXPECT_EQ(found.cameras[0].camera.lens, LensModel::fisheye);
        ASSERT_FALSE(found.warnings.empty());
        EXPECT_THAT(found.warnings.front(), HasSubstr("Brown's model does not adjust at all"));
        ++taken;
      } catch (const std::runtime_error&) {  // too few photographs for either
      }
    }
  RecordProperty("thrown", thrown), RecordProperty("taken", taken);
  ASSERT_GT(thrown, 0) << "the case shows nothing";
  EXPECT_GT(taken, 0);
}

TEST(MarkerBlock, StatedCovarianceCoversTheErrorsItMakes) {
  double nees = 0;
  int count = 0;
  for (unsigned seed = 1; seed <= 8; ++seed) {
    const Scene s = scene(0.1, seed);
    MarkerOptions options;  // the tags have exactly their nominal size, and the detector draws no edge inwards
    options.size_sigma = 1e-6, options.inset_sigma = 0;
    const MarkerResult result = adjust_marker_block(s.block, options);
    // Distances do not hang on the datum: error over standard deviation of all pairs of neighbours.
    const Eigen::Index n = static_cast<Eigen::Index>(result.markers.size());
    for (Eigen::Index i = 0; i + 1 < n; ++i) {
      const auto &a = result.markers[i], &b = result.markers[i + 1];
      const Eigen::Vector3d d = b.world_from_tag.translation - a.world_from_tag.translation;
      Eigen::RowVectorXd slope = Eigen::RowVectorXd::Zero(3 * n);
      slope.segment<3>(3 * i) = -d.normalized(), slope.segment<3>(3 * i + 3) = d.normalized();
      const double truth = (s.tags[b.marker].translation - s.tags[a.marker].translation).norm();
      nees += std::pow(d.norm() - truth, 2) / (slope * result.centre_covariance * slope.transpose())(0, 0);
      ++count;
    }
    EXPECT_NEAR(result.groups[0].factor, 1, 0.3) << "the stated noise is the true one";
  }
  EXPECT_GT(nees / count, 0.4);
  EXPECT_LT(nees / count, 1.8);
}

TEST(MarkerBlock, InsetHasThePriorThatTheDetectorStates) {
  Scene s = scene(0.1, 1);
  MarkerOptions options;
  options.size_sigma = 1e-6, options.inset_sigma = 10;
  const double alone = adjust_marker_block(s.block, options).cameras[0].inset_sigma;
  for (size_t i = 1; i < s.block.images.size(); ++i) s.block.images[i].inset_sigma = alone;  // the first states none
  const double stated = adjust_marker_block(s.block, options).cameras[0].inset_sigma;
  EXPECT_NEAR(stated, alone / std::sqrt(2.0), 0.1 * alone) << "two witnesses of the same weight";
  options.inset_sigma = 0;
  EXPECT_EQ(adjust_marker_block(s.block, options).cameras[0].inset_sigma, 0) << "0 leaves it out";
}

/// Of detectors that state how far they may draw edges inwards, and do: errors over what is stated of them. Set to zero
/// where it is below three standard deviations, the inset would err by twice what is stated of it in the mean.
TEST(MarkerBlock, StatedInsetsErrByWhatIsStated) {
  constexpr double stated = 0.04;  // [px]
  double squares = 0;
  constexpr int trials = 12;
  std::mt19937_64 random(5);
  std::normal_distribution<double> drawn(0, stated);
  for (unsigned trial = 0; trial < trials; ++trial) {
    Scene s = scene(0.1, 40 + trial);
    const double inset = drawn(random);
    for (MarkerImage& image : s.block.images) image.inset_sigma = stated;
    for (MarkerView& view : s.block.views) {
      const auto corners = view.corners;
      for (size_t k = 0; k < 4; ++k) {
        const Eigen::Vector2d to = (corners[(k + 1) % 4] - corners[k]).normalized(),
                              back = (corners[(k + 3) % 4] - corners[k]).normalized();
        view.corners[k] += inset / std::abs(to.x() * back.y() - to.y() * back.x()) * (to + back);
      }
    }
    MarkerOptions options;
    options.size_sigma = 1e-6;
    const AdjustedMarkerCamera camera = adjust_marker_block(s.block, options).cameras[0];
    squares += std::pow((camera.inset - inset) / camera.inset_sigma, 2) / trials;
  }
  EXPECT_GT(squares, 0.3);
  EXPECT_LT(squares, 1.9);
}

TEST(MarkerBlock, DistanceReplacesThePrintedSize) {
  Scene s = scene(0, 1);
  for (auto& marker : s.block.markers) marker.size = 0.2;  // wrong by two thirds
  MarkerOptions options;
  options.distance = MarkerDistance{0, 2, 0.6, 0.0003};
  const MarkerResult result = adjust_marker_block(s.block, options);
  EXPECT_LT(error_of(s, result), 5e-6);
  EXPECT_NEAR(result.markers[0].scale * 0.2, 0.12, 1e-5);
  const auto& a = result.centre_covariance;
  EXPECT_GT(std::sqrt(a.diagonal().maxCoeff()), 1e-4) << "the distance's own uncertainty is in the coordinates";
}

TEST(MarkerBlock, NamesATagThatIsNotWhereTheOthersSayItIs) {
  Scene s = scene(0.1, 3);
  for (auto& c : s.block.views[5].corners) c += Eigen::Vector2d(6, -4);
  const MarkerResult result = adjust_marker_block(s.block, {});
  EXPECT_EQ(result.rejected, std::vector<int>{5});
  EXPECT_LT(error_of(s, result), 5e-4);
}

TEST(MarkerBlock, KeepsBothPosesOfASingleTagUntilImagesDecide) {
  // An image with one tag is oriented through it, and says which other pose there is.
  Scene s = scene(0.05, 4);
  bool first = true;
  std::erase_if(s.block.views, [&](const MarkerView& v) {
    if (v.image != 9) return false;
    const bool drop = !first;
    first = false;
    return drop;
  });
  const MarkerResult result = adjust_marker_block(s.block, {});
  ASSERT_TRUE(result.images[9].oriented);
  EXPECT_TRUE(result.images[9].other_centre.has_value());
  EXPECT_GT(result.images[9].ambiguity, 1);
}

TEST(MarkerBlock, OneTagOrARowOfThemHasADatum) {
  // Centres in one line leave the turn about it open: the rotations of the tags have to be in the datum, too.
  for (const auto& keep : {std::vector<int>{2}, std::vector<int>{0, 1}, std::vector<int>{0, 1, 2}}) {
    Scene s = only(scene(0.05, 6), keep);
    s.block.cameras[0].camera = true_camera();
    s.block.cameras[0].held = true;
    MarkerResult result;
    ASSERT_NO_THROW(result = adjust_marker_block(s.block, {})) << keep.size();
    EXPECT_EQ(result.markers.size(), keep.size());
    EXPECT_EQ(result.datum_defect, 6);
    EXPECT_THAT(result.datum, HasSubstr("centres and rotations"));
    if (keep.size() > 2) {
      EXPECT_LT(error_of(s, result), 3e-4);
    }
  }
}

TEST(MarkerBlock, SaysWhenCornersAreWorseThanStated) {
  Scene s = scene(0.3, 7);
  for (auto& view : s.block.views)
    for (auto& c : view.covariances) c = Eigen::Matrix2d::Identity() * 0.1 * 0.1;
  EXPECT_THAT(adjust_marker_block(s.block, {}).warnings, testing::Contains(HasSubstr("times as uncertain")));
  EXPECT_THAT(adjust_marker_block(scene(0.1, 7).block, {}).warnings,
              testing::Not(testing::Contains(HasSubstr("times as uncertain"))));
}

TEST(MarkerBlock, StatesHowGoodItsLengthsAre) {
  MarkerOptions options;
  options.print_sigma = 0.6e-3, options.size_sigma = 0;  // of tags of 120 mm
  Scene stated = scene(0.1, 7), unstated = stated;
  for (MarkerImage& image : stated.block.images) image.inset_sigma = 1e-9;
  const MarkerResult printed = adjust_marker_block(stated.block, options);
  EXPECT_NEAR(printed.scale_sigma, 0.005, 1e-12);
  EXPECT_THAT(printed.datum, HasSubstr("0.50 %"));
  // Whose insets nobody states knows no less of them than the prior says.
  options.inset_sigma = 0.3;
  const double of_prior = adjust_marker_block(unstated.block, options).scale_sigma;
  for (MarkerImage& image : stated.block.images) image.inset_sigma = 0.3;
  EXPECT_NEAR(of_prior, adjust_marker_block(stated.block, options).scale_sigma, 1e-12);
  EXPECT_GT(of_prior, 0.0055);
  options.distance = MarkerDistance{0, 2, 0.6, 0.0003};
  const MarkerResult measured = adjust_marker_block(scene(0.1, 7).block, options);
  EXPECT_NEAR(measured.scale_sigma, 0.0005, 1e-12);
}

/// Waves of the paper: corners off the square by 0.06 mm in the plane and 0.4 mm out of it, up to 0.4 px.
TEST(MarkerBlock, TagsThatAreNoFlatSquaresDoNotSpoilTheCovariance) {
  double squares = 0, factor = 0, rigid_factor = 0;
  for (unsigned seed = 1; seed <= 3; ++seed) {
    Scene s = scene(0.1, seed);
    std::mt19937_64 random(100 + seed);
    std::normal_distribution<double> unit(0, 1);
    std::vector<TagShape> shapes(s.tags.size());
    for (auto& shape : shapes)
      for (size_t k = 0; k < shape.size(); ++k) shape[k] = (k == 4 ? 7e-3 : 1e-3) * unit(random);
    for (MarkerView& view : s.block.views) {
      const size_t m = static_cast<size_t>(view.marker);
      const auto bent = shaped_corners(0.06, shapes[m]);
      const RigidTransform cam_from_tag = s.images[view.image] * s.tags[m];
      for (size_t q = 0; q < 4; ++q)
        view.corners[q] +=
            *project(true_camera(), cam_from_tag * bent[q]) - *project(true_camera(), cam_from_tag * corner(0.12, q));
    }
    MarkerOptions bendable;
    bendable.shape_sigma = 1e-3;
    const MarkerResult result = adjust_marker_block(s.block, bendable);
    factor += result.groups.front().factor / 3;
    squares += std::pow(result.markers[3].shape[4] - shapes[3][4], 2) / 3;
    MarkerOptions rigid;
    rigid.twist_sigma = 0;
    rigid_factor += adjust_marker_block(s.block, rigid).groups.front().factor / 3;
  }
  EXPECT_LT(factor, 1.2);
  EXPECT_GT(factor, 0.8);
  EXPECT_GT(rigid_factor, 2) << "rigid squares do not fit them";
  EXPECT_LT(std::sqrt(squares), 2e-3);
}

/// One tag says nothing of a lens whose stated uncertainty is large; the calibration is then taken as it is.
TEST(MarkerBlock, OrientsByOneTagWithACalibrationItCannotImprove) {
  Scene s = scene(0.1, 1);
  std::erase_if(s.block.views, [](const MarkerView& view) { return view.marker != 0 || view.image > 2; });
  s.block.markers[0].world_from_tag = s.tags[0];
  MarkerCamera& camera = s.block.cameras[0];
  camera.camera = true_camera();
  Eigen::VectorXd sigma(9);
  sigma << 300, 300, 200, 200, 5, 50, 500, 0.5, 0.5;
  camera.covariance = sigma.cwiseAbs2().asDiagonal();
  const MarkerResult result = adjust_marker_block(s.block, {});
  EXPECT_THAT(result.warnings, testing::Contains(HasSubstr("do not improve the calibrations")));
  EXPECT_EQ(result.cameras[0].camera.fx, 1500);
  for (size_t i = 0; i < 3; ++i) {
    ASSERT_TRUE(result.images[i].oriented);
    const double off = (result.images[i].centre - s.images[i].inverse().translation).norm();
    EXPECT_LT(off, 4 * std::sqrt(result.images[i].covariance.topLeftCorner<3, 3>().trace()));
  }
}

/// Edges that are drawn inwards by a good part of small tags: the scale hangs on how far.
TEST(MarkerBlock, OfSmallTagsSaysThatTheirLengthsHangOnTheInset) {
  Scene s = scene(0.1, 3);
  MarkerResult result = adjust_marker_block(s.block, {});
  const auto warnings = [&](double inset, const MarkerOptions& options) {
    MarkerResult stated = result;
    stated.cameras[0].inset = inset, stated.warnings.clear();
    state_scale(s.block, options, stated);
    return stated.warnings;
  };
  EXPECT_THAT(warnings(4, {}), testing::ElementsAre(HasSubstr("all lengths hang on it")));
  MarkerOptions with_distance;
  with_distance.distance = MarkerDistance{0, 2, 0.6, 1e-4};
  EXPECT_THAT(warnings(4, with_distance), testing::IsEmpty());
  EXPECT_THAT(warnings(0.3, {}), testing::IsEmpty());
}

TEST(MarkerBlock, RefusesWhatCannotBeInWords) {
  const auto message = [](const MarkerBlock& block) {
    try {
      adjust_marker_block(block, {});
    } catch (const std::runtime_error& error) {
      return std::string(error.what());
    }
    return std::string("nothing was thrown");
  };
  EXPECT_THAT(message({}), HasSubstr("no tag was found"));
  Scene one = scene(0, 1);
  one.block.images.resize(1);
  std::erase_if(one.block.views, [](const MarkerView& v) { return v.image != 0; });
  EXPECT_THAT(message(one.block), HasSubstr("one photograph"));
  Scene without_size = scene(0, 1);
  without_size.block.markers[0].size = 0;
  EXPECT_THAT(message(without_size.block), HasSubstr("has no size"));
}

TEST(MarkerBlock, NamesACalibrationThatThePhotographsContradict) {
  Scene s = scene(0.1, 4);
  MarkerCamera& given = s.block.cameras[0];
  given.id = "telephone", given.camera = true_camera();
  const std::array<double, 9> sigmas = {1, 1, 1, 1, 5e-4, 2e-3, 1e-9, 5e-5, 5e-5};
  given.covariance = Eigen::MatrixXd::Zero(9, 9);
  for (Eigen::Index k = 0; k < 9; ++k) given.covariance(k, k) = std::pow(sigmas[k], 2);
  EXPECT_THAT(adjust_marker_block(s.block, {}).warnings, testing::Not(testing::Contains(HasSubstr("contradict"))));
  given.camera.cy += 12;
  EXPECT_THAT(
      adjust_marker_block(s.block, {}).warnings,
      testing::Contains(testing::AllOf(HasSubstr("the photographs contradict the calibration of camera telephone: all "
                                                 "parameters together are off by"),
                                       HasSubstr("furthest cy is "), HasSubstr("given were 602 "))));
}

TEST(MarkerHalves, DifferByTheirCovariancesAndByMoreWhereTheCameraIsNotItsModel) {
  double square = 0, freedom = 0;
  for (unsigned seed = 1; seed <= 8; ++seed) {
    const Scene s = scene(0.1, seed);
    const auto halves = compare_halves(s.block, {}, adjust_marker_block(s.block, {}));
    ASSERT_TRUE(halves.has_value());
    EXPECT_GE(halves->tags, 8);
    EXPECT_EQ(halves->freedom, 3 * halves->tags - 7);
    EXPECT_FALSE(halves->tags_contradict) << seed;
    square += halves->variance * halves->freedom, freedom += halves->freedom;
  }
  EXPECT_GT(square, chi_squared_quantile(0.001, freedom));
  EXPECT_LT(square, chi_squared_quantile(0.999, freedom));

  Scene moved = scene(0.1, 9);  // while the rows were read, in every photograph another way
  for (MarkerView& view : moved.block.views)
    for (Eigen::Vector2d& p : view.corners) p.x() += 6e-3 * ((7 * view.image) % 5 - 2) * (p.y() - 600);
  MarkerOptions all;
  all.reject_above = 0;
  const auto halves = compare_halves(moved.block, all, adjust_marker_block(moved.block, all));
  ASSERT_TRUE(halves.has_value());
  EXPECT_TRUE(halves->tags_contradict) << halves->variance;
  EXPECT_THAT(in_words(*halves), HasSubstr("two halves of the photographs (every second one) place the tags"));
}

TEST(MarkerHalves, AreNotComparedWhereTheyAreTooFew) {
  Scene s = scene(0.1, 1);
  const MarkerResult result = adjust_marker_block(s.block, {});
  MarkerResult few = result;
  for (size_t i = 7; i < few.images.size(); ++i) few.images[i].oriented = false;
  EXPECT_TRUE(compare_halves(s.block, {}, result).has_value());
  EXPECT_FALSE(compare_halves(s.block, {}, few).has_value());
}

/// The layout's distances say how large the tags are.
TEST(MarkerBlock, ATagSizeThatTheLayoutContradictsIsRefusedWithTheRightOne) {
  const auto message = [](double factor) {
    Scene s = scene(0.1, 5);
    s.block.cameras[0].camera = true_camera(), s.block.cameras[0].held = true;
    for (size_t m = 0; m < s.tags.size(); ++m)
      s.block.markers[m].world_from_tag = s.tags[m], s.block.markers[m].size *= factor;
    MarkerOptions options;
    options.reject_above = 8;
    try {
      adjust_marker_block(s.block, options);
    } catch (const std::runtime_error& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_EQ(message(1), "");
  EXPECT_EQ(message(1.005), "") << "less than two per cent may be the print";
  for (const double factor : {0.92, 1.03, 1.09})
    EXPECT_THAT(
        message(factor),
        testing::AllOf(HasSubstr("the tags are not " + std::to_string(120 * factor).substr(0, 5)),
                       HasSubstr("by the distances in the layout their edge is 1"), HasSubstr("Correct tag_size")))
        << factor;
}

}  // namespace test_blocks
}  // namespace plumbline::markers
