// Corners of tags in photographs as cameras write them: how far they lie inwards, and whether what is stated covers it.
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <string>
#include <tuple>

#include "drawn_photographs.hpp"
#include "photo/detect/corner_refinement.hpp"
#include "tag_rendering.hpp"

namespace plumbline {
namespace test_photographs {

using test::CameraChain;
using test::DrawnCorners;
using test::DrawnTag;

constexpr int kField = 200;  // the square that each tag has to itself [px]

std::vector<DrawnTag> places(int columns, int rows, std::uint64_t seed) {
  test::NormalNoise random(seed);
  std::vector<DrawnTag> tags;
  for (int k = 0; k < columns * rows; ++k) {
    const Eigen::Vector2d middle(kField * (k % columns + 0.5) + random.uniform(),
                                 kField * (k / columns + 0.5) + random.uniform());
    tags.push_back({k, test::square_corners(middle, 70 + 40 * random.uniform(), 0.1 + 6 * random.uniform(),
                                            0.7 * random.uniform())});
  }
  return tags;
}

/// Displacement of each corner if both edges at it move inwards by a pixel.
DrawnCorners inward_of(const DrawnCorners& corners) {
  DrawnCorners result;
  for (std::size_t k = 0; k < 4; ++k) {
    const Eigen::Vector2d to = (corners[(k + 1) % 4] - corners[k]).normalized(),
                          back = (corners[(k + 3) % 4] - corners[k]).normalized();
    result[k] = (to + back) / std::abs(to.x() * back.y() - to.y() * back.x());
  }
  return result;
}

struct Agreement {
  double inset = 0;        // that explains the errors best [px]
  double inset_sigma = 0;  // stated [px]
  double chi_squared = 0;  // of all corners with the inset's doubt as one common error, per freedom
  double alone = 0;        // the same without that
  double gamma = 0, model_error = 0;
  int corners = 0;
};

Agreement agreement(const GreyImage& image, const std::vector<DrawnTag>& tags) {
  constexpr double kFloor = 0.02;  // that the detectors add [px]
  detect::EdgeFitOptions options;
  options.gamma = 0;
  options.grid.reset();
  std::vector<detect::Quadrilateral> found;
  for (const DrawnTag& tag : tags) found.push_back({tag.corners, 8});
  const auto measured = detect::measure_corners(image, found, options);
  Agreement a;
  a.gamma = measured.quality.gamma, a.model_error = measured.quality.model_error;
  a.inset_sigma = measured.quality.inset_sigma;
  double squares = 0, along = 0, weight = 0;
  for (std::size_t k = 0; k < tags.size(); ++k) {
    if (!measured.corners[k]) continue;
    const DrawnCorners inward = inward_of(tags[k].corners);
    for (std::size_t i = 0; i < 4; ++i) {
      const Eigen::Vector2d e = measured.corners[k]->corners[i] - tags[k].corners[i];
      const Eigen::Matrix2d covariance =
          measured.corners[k]->covariances[i] + kFloor * kFloor * Eigen::Matrix2d::Identity();
      const Eigen::LLT<Eigen::Matrix2d> root(covariance);
      squares += e.dot(root.solve(e)), along += inward[i].dot(root.solve(e)),
          weight += inward[i].dot(root.solve(inward[i]));
      ++a.corners;
    }
  }
  a.inset = along / weight;
  const double s = a.inset_sigma * a.inset_sigma;
  a.alone = squares / (2 * a.corners);
  a.chi_squared = (squares - s * along * along / (1 + s * weight)) / (2 * a.corners);  // Sherman and Morrison
  return a;
}

struct Taken {
  std::vector<DrawnTag> tags;
  cv::Mat light;
};

Taken taken(int columns, int rows, std::uint64_t seed) {
  constexpr double kBlur = 0.7;  // [px]
  Taken result{places(columns, rows, seed), {}};
  result.light = test::light_of(result.tags, columns * kField, rows * kField, kBlur);
  return result;
}

std::string in_words(const CameraChain& camera, const Agreement& a) {
  return camera.name + ": inset " + std::to_string(a.inset) + " +- " + std::to_string(a.inset_sigma) +
         " px, chi-squared " + std::to_string(a.chi_squared) + " (" + std::to_string(a.alone) +
         " without it), exponent " + std::to_string(a.gamma);
}

/// Before, 0.02 to 0.5 px were drawn inwards with 0.02 to 0.05 px stated.
TEST(PhotographsDrawnApart, StateHowFarTheirCornersMayLieInwards) {
  double squares = 0, count = 0;
  for (const auto& [columns, rows, seed] : {std::tuple(3, 2, 1), std::tuple(1, 1, 1), std::tuple(1, 1, 2)}) {
    const Taken photograph = taken(columns, rows, static_cast<std::uint64_t>(seed));
    for (const CameraChain& camera : test::camera_chains()) {
      const Agreement a = agreement(test::photograph_of(photograph.light, camera, 1), photograph.tags);
      EXPECT_EQ(a.corners, 4 * columns * rows) << camera.name;
      EXPECT_LT(a.chi_squared, 1.5) << in_words(camera, a);
      EXPECT_LT(std::abs(a.inset), 3 * a.inset_sigma) << in_words(camera, a);
      squares += std::pow(a.inset / a.inset_sigma, 2), count += 1;
    }
  }
  EXPECT_LT(squares / count, 1.5);
  EXPECT_GT(squares / count, 0.2) << "stated far too large";
}

/// The curve that JPEG hides.
TEST(PhotographsDrawnApart, HaveCornersWhereTheyAreIfTheyAreSrgb) {
  for (const auto& [columns, rows] : {std::pair(3, 2), std::pair(1, 1)}) {
    const Taken photograph = taken(columns, rows, 3);
    for (const int quality : {0, 95, 80, 70, 60}) {
      const CameraChain camera{.name = "JPEG " + std::to_string(quality), .quality = quality};
      const Agreement a = agreement(test::photograph_of(photograph.light, camera, 2), photograph.tags);
      EXPECT_LT(std::abs(a.inset), 0.05) << in_words(camera, a);
      EXPECT_LT(a.inset_sigma, 0.15) << in_words(camera, a);
    }
  }
}

/// White on black instead: every second tag, with its square.
void negate_every_second(int columns, int rows, cv::Mat& light) {
  constexpr float kWhiteAndBlack = 0.64f;
  for (int k = 1; k < columns * rows; k += 2) {
    cv::Mat field = light(cv::Rect(kField * (k % columns), kField * (k / columns), kField, kField));
    field = kWhiteAndBlack - field;
  }
}

/// A wrong curve draws the edges of white tags outwards where it draws those of black ones inwards. The doubt about it
/// is the same for both, and since one inset cannot be both, each corner carries it.
TEST(PhotographsDrawnApart, OfBothPolaritiesHaveTheSameDoubt) {
  constexpr int kColumns = 3, kRows = 2;
  Taken photograph = taken(kColumns, kRows, 1);
  for (const CameraChain& camera : {CameraChain{.name = "JPEG 80", .quality = 80},
                                    CameraChain{.name = "linear JPEG 70", .srgb = false, .quality = 70},
                                    CameraChain{.name = "linear JPEG 50", .srgb = false, .quality = 50}}) {
    const Agreement black = agreement(test::photograph_of(photograph.light, camera, 1), photograph.tags);
    cv::Mat mixed = photograph.light.clone();
    negate_every_second(kColumns, kRows, mixed);
    const Agreement both = agreement(test::photograph_of(mixed, camera, 1), photograph.tags);
    EXPECT_EQ(both.corners, black.corners) << camera.name;
    EXPECT_GT(both.inset_sigma, 0.5 * black.inset_sigma)
        << in_words(camera, both) << "; black: " << in_words(camera, black);
    EXPECT_LT(both.alone, 4) << in_words(camera, both);  // 30 and more where the doubt is left out
  }
}

TEST(PhotographsDrawnApart, InLinearLightAreNotMistaken) {
  for (const auto& [columns, rows] : {std::pair(3, 2), std::pair(1, 1)}) {
    const Taken photograph = taken(columns, rows, 4);
    const CameraChain camera{.name = "linear", .srgb = false};
    const Agreement a = agreement(test::photograph_of(photograph.light, camera, 2), photograph.tags);
    EXPECT_EQ(a.gamma, 1);
    EXPECT_LT(std::abs(a.inset), 0.01) << in_words(camera, a);
    EXPECT_LT(a.inset_sigma, 0.05) << in_words(camera, a);
  }
}

/// JPEG hides that light is linear: the corners are then drawn out by nearly half a pixel, and what is stated holds
/// that in itself, not only in the mean over linear and sRGB files.
TEST(PhotographsDrawnApart, InLinearLightAreHeldWhereJpegHidesIt) {
  for (const auto& [columns, rows, seed] : {std::tuple(3, 2, 1), std::tuple(3, 2, 4), std::tuple(1, 1, 1)}) {
    const Taken photograph = taken(columns, rows, static_cast<std::uint64_t>(seed));
    for (const int quality : {90, 80, 70, 60, 50}) {
      const CameraChain camera{.name = "linear JPEG " + std::to_string(quality), .srgb = false, .quality = quality};
      const Agreement a = agreement(test::photograph_of(photograph.light, camera, 2), photograph.tags);
      RecordProperty("c" + std::to_string(columns) + "_" + std::to_string(seed) + "_" + std::to_string(quality),
                     in_words(camera, a));
      EXPECT_LT(std::abs(a.inset), std::sqrt(1.5) * a.inset_sigma + 0.02) << in_words(camera, a);
    }
  }
}

}  // namespace test_photographs
}  // namespace plumbline
