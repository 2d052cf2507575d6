// Corners of rendered tags whose true corners are known: bias, spread, and whether the stated covariance is honest.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "photo/detect/aruco_detector.hpp"
#include "photo/detect/corner_refinement.hpp"
#include "photo/detect/square_code.hpp"
#include "photo/detect/tag_detector.hpp"
#include "photo/detect/tag_family.hpp"
#include "tag_rendering.hpp"

namespace plumbline {
namespace test_corners {

using detect::ArucoDetector;
using detect::DetectorOptions;
using detect::TagDetector;
using detect::TagDictionary;
using test::TagScene;

constexpr double kTurn = 2 * M_PI;

TagScene scene_of(double size, double angle, double tilt, int k) {
  TagScene scene;
  scene.width = scene.height = static_cast<int>(2 * size) + 20;
  test::NormalNoise random(static_cast<std::uint64_t>(1000 + k));
  const double middle = 0.5 * scene.width;
  scene.corners = test::square_corners({middle + random.uniform(), middle + random.uniform()}, size, angle, tilt);
  scene.noise = 2;
  scene.seed = static_cast<std::uint64_t>(k) + 1;
  return scene;
}

struct Figures {
  double rms = 0;          // [px], per axis
  double outward = 0;      // mean error away from the tag's centre [px]
  double mahalanobis = 0;  // mean of eᵀ Σ⁻¹ e / 2: 1 if the covariance is honest
  double inset_sigma = 0;  // mean of what is stated [px]
  int corners = 0;
};

Figures measure(TagDetector& detector, const std::vector<TagScene>& scenes) {
  Figures f;
  for (const TagScene& scene : scenes) {
    const auto tags = detector.detect(render(scene));
    if (tags.size() != 1 || !tags[0].refined) continue;
    const auto truth = test::true_corners(scene);
    const Eigen::Vector2d centre = 0.25 * (truth[0] + truth[1] + truth[2] + truth[3]);
    for (int i = 0; i < 4; ++i) {
      const Eigen::Vector2d e = tags[0].corners[i] - truth[i];
      f.rms += e.squaredNorm() / 2;
      f.outward += e.dot((truth[i] - centre).normalized());
      f.mahalanobis += e.dot(tags[0].covariances[i].inverse() * e) / 2;
      f.inset_sigma += tags[0].inset_sigma;
      ++f.corners;
    }
  }
  f.rms = std::sqrt(f.rms / f.corners);
  f.outward /= f.corners;
  f.mahalanobis /= f.corners;
  f.inset_sigma /= f.corners;
  return f;
}

TEST(Corners, AreMeasuredToFiveHundredthsOfAPixelWithoutBias) {
  TagDetector detector{DetectorOptions{}};
  std::vector<TagScene> scenes;
  for (int k = 0; k < 10; ++k) scenes.push_back(scene_of(80, kTurn * k / 10 + 0.1, k % 2 ? 0.8 : 0.0, k));
  const Figures f = measure(detector, scenes);
  EXPECT_EQ(f.corners, 40);
  EXPECT_LT(f.rms, 0.05);
  EXPECT_LT(std::abs(f.outward), 0.01);
}

TEST(Corners, CarryACovarianceThatCoversTheirErrors) {
  DetectorOptions options;
  options.sigma_floor = 0;
  options.edge.gamma = 1;  // drawn in linear light, which this noise hides
  TagDetector detector{options};
  std::vector<TagScene> scenes;
  for (int k = 0; k < 12; ++k) {
    scenes.push_back(scene_of(70, 0.3 + 0.5 * k, 0.3, k));
    scenes.back().noise = 5;
  }
  const Figures f = measure(detector, scenes);
  EXPECT_EQ(f.corners, 48);
  // 96 components: a chi-squared over its degrees of freedom lies in [0.74, 1.29] at 95 %, and neighbours are
  // correlated.
  EXPECT_GT(f.mahalanobis, 0.6);
  EXPECT_LT(f.mahalanobis, 1.6);
}

/// One tag under noise does not tell linear light from sRGB, which is taken; the doubt is stated apart.
TEST(Corners, OfASingleTagUnderNoiseStateHowFarTheyMayBeOffTogether) {
  TagDetector detector{DetectorOptions{}};
  std::vector<TagScene> scenes;
  for (int k = 0; k < 12; ++k) {
    scenes.push_back(scene_of(70, 0.3 + 0.5 * k, 0.3, k));
    scenes.back().noise = 5;
  }
  const Figures f = measure(detector, scenes);
  EXPECT_LT(std::abs(f.outward), 2 * std::sqrt(2.0) * f.inset_sigma) << f.inset_sigma;
  EXPECT_LT(f.inset_sigma, 0.3);
}

/// sRGB (IEC 61966-2-1) of linear grey values, then sharpened by `amount` with a halo of a pixel.
GreyImage photographed(GreyImage image, double amount) {
  std::vector<double> grey;
  for (const std::uint8_t value : image.pixels) {
    const double light = value / 255.0;
    grey.push_back(255 * (light <= 0.0031308 ? 12.92 * light : 1.055 * std::pow(light, 1 / 2.4) - 0.055));
  }
  for (int y = 1; y + 1 < image.height; ++y)
    for (int x = 1; x + 1 < image.width; ++x) {
      const auto at = [&](int dx, int dy) { return grey[(y + dy) * image.width + x + dx]; };
      double mean = 0;
      for (int dy = -1; dy <= 1; ++dy)
        for (int dx = -1; dx <= 1; ++dx) mean += at(dx, dy) / 9;
      image.pixels[y * image.width + x] =
          static_cast<std::uint8_t>(std::lround(std::clamp(at(0, 0) + amount * (at(0, 0) - mean), 0.0, 255.0)));
    }
  return image;
}

/// Images of one height side by side.
GreyImage beside(const std::vector<GreyImage>& images) {
  GreyImage row{0, images.front().height, {}};
  for (const GreyImage& image : images) row.width += image.width;
  for (int y = 0; y < row.height; ++y)
    for (const GreyImage& image : images)
      row.pixels.insert(row.pixels.end(), image.pixels.begin() + y * image.width,
                        image.pixels.begin() + (y + 1) * image.width);
  return row;
}

TEST(Corners, OfAPhotographWithATransferCurveAreNotMovedInwards) {
  std::vector<GreyImage> images;
  std::vector<detect::Quadrilateral> truth;
  for (int k = 0; k < 5; ++k) {
    TagScene scene = scene_of(120, 0.3 + 0.7 * k, 0.2, k);
    scene.blur = 1.2;
    detect::Quadrilateral q{test::true_corners(scene), 8};
    for (auto& corner : q.corners) corner.x() += static_cast<double>(k) * scene.width;
    images.push_back(render(scene));
    truth.push_back(q);
  }
  const GreyImage image = photographed(beside(images), 0);
  double outward_of[2] = {0, 0};
  for (const int estimated : {0, 1}) {
    detect::EdgeFitOptions options;
    options.gamma = estimated ? 0 : 1;
    const auto measured = detect::measure_corners(image, truth, options);
    EXPECT_NEAR(measured.quality.gamma, estimated ? 2.4 : 1.0, 0.3);
    for (std::size_t k = 0; k < truth.size(); ++k) {
      ASSERT_TRUE(measured.corners[k]);
      const auto& corners = truth[k].corners;
      const Eigen::Vector2d centre = 0.25 * (corners[0] + corners[1] + corners[2] + corners[3]);
      for (int i = 0; i < 4; ++i)
        outward_of[estimated] +=
            (measured.corners[k]->corners[i] - corners[i]).dot((corners[i] - centre).normalized()) / 20;
    }
  }
  EXPECT_LT(outward_of[0], -0.3) << "without the curve the tag looks smaller";
  EXPECT_NEAR(outward_of[1], 0, 0.06);
}

TEST(Corners, OfASharpenedPhotographAreStatedToBeWorse) {
  const TagScene scene = scene_of(90, 0.4, 0.2, 1);
  const auto truth = test::true_corners(scene);
  detect::EdgeFitOptions options;
  options.gamma = 0;
  const auto plain = detect::measure_corners(render(scene), {{truth, 8}}, options);
  const auto sharpened = detect::measure_corners(photographed(render(scene), 1.0), {{truth, 8}}, options);
  ASSERT_TRUE(plain.corners[0] && sharpened.corners[0]);
  EXPECT_LT(plain.quality.model_error, 0.004);
  EXPECT_GT(sharpened.quality.model_error, 0.01);
  EXPECT_GT(sharpened.corners[0]->covariances[0].trace(), 9 * plain.corners[0]->covariances[0].trace());
}

/// Three pixels of every five by taking the nearest, as cameras make small pictures of their sensor's.
GreyImage three_of_five(const GreyImage& image) {
  GreyImage small{(image.width - 1) * 3 / 5, (image.height - 1) * 3 / 5, {}};
  for (int y = 0; y < small.height; ++y)
    for (int x = 0; x < small.width; ++x) small.pixels.push_back(image.pixels[5 * y / 3 * image.width + 5 * x / 3]);
  return small;
}

TEST(Corners, OfAPictureOfNearestPixelsAreWhereTheyWereOnTheSensor) {
  std::vector<GreyImage> images;
  std::vector<detect::Quadrilateral> on_sensor, truth;
  for (int k = 0; k < 12; ++k) {
    TagScene scene = scene_of(90, 0.01 + 0.01 * k, 0.15, k);
    detect::Quadrilateral q{test::true_corners(scene), 8};
    for (auto& corner : q.corners) corner.x() += static_cast<double>(k) * scene.width;
    on_sensor.push_back(q);
    for (auto& corner : q.corners)
      corner = (3 * corner + Eigen::Vector2d::Ones()) / 5;  // of the columns 0, 5/3 and 10/3, 0, 1 and 3 are taken
    images.push_back(render(scene));
    truth.push_back(q);
  }
  const GreyImage image = three_of_five(beside(images));
  double rms_of[2] = {0, 0};
  for (const int estimated : {0, 1}) {
    detect::EdgeFitOptions options;
    if (estimated) options.grid.reset();
    const auto measured = detect::measure_corners(image, truth, options);
    EXPECT_EQ(measured.quality.grid.period, estimated ? 3 : 1);
    const std::array<double, 3> offsets = {0.2, -0.2, 0};
    for (int i = 0; i < 3 && estimated; ++i) {
      EXPECT_NEAR(measured.quality.grid.column(i), offsets[i], 1e-12);
      EXPECT_NEAR(measured.quality.grid.row(i), offsets[i], 1e-12);
    }
    for (std::size_t k = 0; k < truth.size(); ++k) {
      if (!measured.corners[k]) continue;
      for (std::size_t i = 0; i < 4; ++i)
        rms_of[estimated] += (measured.corners[k]->corners[i] - truth[k].corners[i]).squaredNorm() / 96;
    }
  }
  EXPECT_GT(std::sqrt(rms_of[0]), 0.1) << "as if on an even grid";
  EXPECT_LT(std::sqrt(rms_of[1]), 0.04);

  detect::EdgeFitOptions options;
  options.grid.reset();
  EXPECT_EQ(detect::measure_corners(beside(images), on_sensor, options).quality.grid.period, 1);
}

TEST(Corners, OfEdgesSharperThanPixelsAreFound) {
  // Gauss-Newton alone goes to and fro on such edges.
  for (int k = 0; k < 12; ++k) {
    TagScene scene = scene_of(60, 0.02 + 0.5 * k, 0.2, k);
    scene.blur = 0;
    const auto refined = detect::refine_corners(photographed(render(scene), 2), test::true_corners(scene), 8, {});
    ASSERT_TRUE(refined) << k;
    for (int i = 0; i < 4; ++i) EXPECT_LT((refined->corners[i] - test::true_corners(scene)[i]).norm(), 0.5) << k;
  }
}

TEST(Corners, WhoseEdgesRunIntoTheNextCellsAreLeftUnmeasured) {
  TagScene scene = scene_of(80, 0.2, 0, 2);
  scene.blur = 3.5;  // a cell has 10 px
  EXPECT_FALSE(detect::refine_corners(render(scene), test::true_corners(scene), 8, {}));
  TagScene large = scene_of(240, 0.2, 0, 2);
  large.blur = 3;
  const auto refined = detect::refine_corners(render(large), test::true_corners(large), 8, {});
  ASSERT_TRUE(refined) << "cells of 30 px leave room for a blur of 3 px";
  for (int i = 0; i < 4; ++i) EXPECT_LT((refined->corners[i] - test::true_corners(large)[i]).norm(), 0.1);
}

TEST(Corners, OfAnUnblurredTagOnThePixelGridAreExact) {
  TagScene scene = scene_of(80, 0, 0, 0);
  scene.noise = scene.blur = 0;
  scene.corners = test::square_corners({89.5, 89.5}, 80, 0);  // edges at 49.5 and 129.5: between two columns
  TagDetector detector{DetectorOptions{}};
  const auto tags = detector.detect(render(scene));
  ASSERT_EQ(tags.size(), 1u);
  for (int i = 0; i < 4; ++i) EXPECT_LT((tags[0].corners[i] - scene.corners[i]).norm(), 1e-3) << i;
}

TEST(Corners, AreNotBiasedByEdgesThatALensBows) {
  // 3e-5 / px: k1 = -0.1, 3000 px from the principal point, f = 4500 px; a straight line would be 0.09 px off at the
  // corners.
  TagScene scene = scene_of(180, 0.2, 0, 3);
  scene.bow = 3e-5;
  scene.noise = 1;
  DetectorOptions options;
  const double with_bow = measure(*std::make_unique<TagDetector>(options), {scene}).rms;
  options.edge.curvature_sigma = 0;
  const double straight = measure(*std::make_unique<TagDetector>(options), {scene}).rms;
  EXPECT_LT(with_bow, 0.03);
  EXPECT_GT(straight, 0.04);
}

TEST(Corners, IgnoreAnObstacleAcrossAnEdge) {
  TagScene scene = scene_of(120, 0.05, 0, 5);
  GreyImage image = render(scene);
  const Eigen::Vector2d middle = 0.5 * (scene.corners[0] + scene.corners[1]);  // a rod of 12 px over the bottom edge
  for (int y = static_cast<int>(middle.y()) - 5; y < scene.height; ++y)
    for (int x = static_cast<int>(middle.x()) - 6; x < static_cast<int>(middle.x()) + 6; ++x)
      image.pixels[static_cast<std::size_t>(y) * image.width + x] = 120;
  const auto refined = detect::refine_corners(image, scene.corners, 8, {});
  ASSERT_TRUE(refined);
  for (int i = 0; i < 4; ++i) EXPECT_LT((refined->corners[i] - scene.corners[i]).norm(), 0.06) << i;
}

TEST(Corners, OfAFlatOrCutOffPatchAreNotInvented) {
  GreyImage flat{100, 100, std::vector<std::uint8_t>(10000, 128)};
  EXPECT_FALSE(detect::refine_corners(flat, test::square_corners({50, 50}, 40, 0), 8, {}));
  const TagScene scene = scene_of(80, 0, 0, 1);
  auto outside = scene.corners;
  for (auto& c : outside) c.x() += 60;
  EXPECT_FALSE(detect::refine_corners(render(scene), outside, 8, {}));
}

TEST(Corners, ComeInTheOrderBottomLeftBottomRightTopRightTopLeftForEveryFamily) {
  for (const std::string& family : detect::tag_family_names()) {
    TagScene scene = scene_of(80, 0.1, 0, 2);
    scene.family = family;
    scene.id = 3;
    scene.width = scene.height = 220;
    scene.corners = test::square_corners({110.2, 109.6}, 80, 0.1);
    DetectorOptions options;
    options.families = {family};
    options.bits_corrected = 1;
    const auto tags = TagDetector{options}.detect(render(scene));
    ASSERT_EQ(tags.size(), 1u) << family;
    EXPECT_EQ(tags[0].family, family);
    EXPECT_EQ(tags[0].id, 3);
    EXPECT_TRUE(tags[0].refined) << family;
    for (int i = 0; i < 4; ++i)
      EXPECT_LT((tags[0].corners[i] - scene.corners[i]).norm(), 0.06) << family << " corner " << i;
  }
}

TEST(Detector, GivesTheSameBitsTwiceAndFromTwoDetectors) {
  const GreyImage image = render(scene_of(60, 1, 0.5, 9));
  TagDetector first{DetectorOptions{}}, second{DetectorOptions{}};
  const auto a = first.detect(image), b = first.detect(image), c = second.detect(image);
  ASSERT_EQ(a.size(), 1u);
  ASSERT_EQ(b.size(), 1u);
  ASSERT_EQ(c.size(), 1u);
  for (int i = 0; i < 4; ++i) {
    EXPECT_EQ(a[0].corners[i], b[0].corners[i]);
    EXPECT_EQ(a[0].corners[i], c[0].corners[i]);
  }
}

TEST(Detector, FindsNothingInAnEmptyOrTinyImage) {
  TagDetector detector{DetectorOptions{}};
  EXPECT_TRUE(detector.detect(GreyImage{3, 3, std::vector<std::uint8_t>(9, 10)}).empty());
  EXPECT_TRUE(detector.detect(GreyImage{300, 200, std::vector<std::uint8_t>(60000, 90)}).empty());
}

TEST(Detector, SaysWhichOptionCannotBe) {
  const auto message_of = [](const DetectorOptions& options) -> std::string {
    try {
      TagDetector detector(options);
    } catch (const std::runtime_error& error) {
      return error.what();
    }
    return "";
  };
  DetectorOptions options;
  options.families = {"tag36h12"};
  EXPECT_THAT(message_of(options), testing::AllOf(testing::HasSubstr("'tag36h12'"), testing::HasSubstr("tag36h11, ")));
  options = {};
  options.decimate = 2.5;
  EXPECT_THAT(message_of(options), testing::HasSubstr("decimate is 2.5"));
  options = {};
  options.bits_corrected = 3;
  EXPECT_THAT(message_of(options), testing::HasSubstr("bits_corrected is 3"));
}

TEST(Detector, KeepsTheDecodingTableSmall) {
  const auto circle = detect::make_tag_family("tagCircle49h12");
  EXPECT_EQ(detect::affordable_bits_corrected(*circle, 2), 1);
  EXPECT_GT(detect::decoding_table_bytes(*circle, 2), 3e9);
  EXPECT_EQ(detect::affordable_bits_corrected(*detect::make_tag_family("tag36h11"), 2), 2);
}

TEST(Detector, FindsTagsOfSixteenReducedPixelsAndMeasuresThemAllTheSame) {
  for (const double factor : {2.0, 3.0, 4.0}) {
    DetectorOptions options;
    options.decimate = factor;
    options.edge.gamma = 1;  // drawn in linear light
    TagDetector detector{options};
    std::vector<TagScene> scenes;
    for (int k = 0; k < 3; ++k) scenes.push_back(scene_of(16 * factor, 0.4 + 2 * k, 0.6, k));
    const Figures f = measure(detector, scenes);
    EXPECT_EQ(f.corners, 12) << "reduced by " << factor;
    EXPECT_LT(f.rms, 0.06) << "reduced by " << factor;
  }
}

TEST(Detector, DecimatesByTheSizeOfTheImage) {
  EXPECT_EQ(detect::decimation_for(800, 533), 1);
  EXPECT_EQ(detect::decimation_for(3500, 2300), 1.5);
  EXPECT_EQ(detect::decimation_for(4000, 3000), 2);
  EXPECT_EQ(detect::decimation_for(6000, 4000), 3);
  EXPECT_EQ(detect::decimation_for(11656, 8742), 5);
}

/// The drawing of a code in whole pixels, 200 on 40, in the middle of a light image.
GreyImage drawn(const TagDictionary& dictionary, std::size_t index, int cell, bool mirrored = false) {
  const int n = dictionary.size, side = (n + 6) * cell;
  GreyImage image{side, side, std::vector<std::uint8_t>(static_cast<std::size_t>(side * side), 200)};
  for (int y = 2 * cell; y < (n + 4) * cell; ++y)
    for (int x = 2 * cell; x < (n + 4) * cell; ++x) {
      const int row = y / cell - 3, column = mirrored ? n - 1 - (x / cell - 3) : x / cell - 3;
      const bool code = row >= 0 && row < n && column >= 0 && column < n;
      const bool white = code && dictionary.codes[index][row * n + column] != 0;
      image.pixels[y * side + x] = white ? 200 : 40;
    }
  return image;
}

/// Nearly every tag of another dictionary can be read as some code of 3 x 3 cells; it does not look like it.
/// One square in thirty is read as one of tag16h5. Cells of two colours are none of a tag's.
TEST(Detector, LeavesOutWhatDoesNotLookLikeATagOfAWeakFamily) {
  const detect::SquareFamily family = detect::apriltag_square_family("tag16h5");
  DetectorOptions options;
  options.families = {"tag16h5"};
  for (const bool sound : {true, false}) {
    GreyImage image{200, 200, std::vector<std::uint8_t>(200 * 200, 220)};
    const auto fill = [&](int x0, int y0, int width, int height, std::uint8_t value) {
      for (int y = y0; y < y0 + height; ++y)
        for (int x = x0; x < x0 + width; ++x) image.pixels[200 * y + x] = value;
    };
    fill(40, 40, 120, 120, 30);
    for (size_t bit = 0; bit < family.cells.size(); ++bit) {
      const auto [column, row] = family.cells[bit];
      const bool white = (family.codes[7] >> (family.cells.size() - 1 - bit)) & 1;
      fill(40 + 20 * column, 40 + 20 * row, 20, 20, white ? 220 : 30);
      if (!sound) fill(40 + 20 * column, 40 + 20 * row, 20, 6, white ? 30 : 220);
    }
    EXPECT_EQ(TagDetector(options).detect(image).size(), sound ? 1u : 0u);
  }
}

TEST(ArucoDetector, LeavesOutWhatDoesNotLookLikeItsTag) {
  const TagDictionary weak = detect::builtin_dictionary("DICT_3X3_32"),
                      other = detect::builtin_dictionary("DICT_4X4_50");
  const ArucoDetector detector(weak, {});
  detect::ArucoOptions credulous;
  credulous.limit = detect::LikenessLimit{};
  const ArucoDetector unchecked(weak, credulous);
  int unlike = 0;
  for (std::size_t k = 0; k < other.codes.size(); k += 2) {
    const GreyImage image = drawn(other, k, 8);
    const detect::ArucoSearch found = detector.search(image);
    EXPECT_THAT(found.tags, testing::IsEmpty()) << other.ids[k];
    EXPECT_EQ(unchecked.detect(image).size(), static_cast<std::size_t>(found.unlike));
    unlike += found.unlike;
  }
  EXPECT_GT(unlike, 2);
  for (std::size_t k = 0; k < weak.codes.size(); k += 5) {
    const auto tags = detector.detect(drawn(weak, k, 6));
    ASSERT_THAT(tags, testing::SizeIs(1)) << weak.ids[k];
    EXPECT_EQ(tags[0].id, weak.ids[k]);
    EXPECT_LT((tags[0].corners[0] - Eigen::Vector2d(11.5, 41.5)).norm(), 0.1);
  }
}

/// Nine pixels a cell: the fit of the edges leaves these tags, and OpenCV's own corners were 0.7 to 4 px off.
TEST(ArucoDetector, MeasuresBlurredTagsByTheirEdges) {
  double sum = 0, largest = 0, count = 0;
  for (int k = 0; k < 12; ++k) {
    TagScene scene = scene_of(72, 0.1 + 0.5 * k, 0.3, k);
    scene.id = k;
    scene.blur = 2.5;
    const auto tags = ArucoDetector(detect::builtin_dictionary("tag36h11"), {}).detect(render(scene));
    ASSERT_EQ(tags.size(), 1u) << k;
    EXPECT_EQ(tags[0].id, k);
    const auto truth = test::true_corners(scene);
    for (size_t i = 0; i < 4; ++i) {
      const double off = (tags[0].corners[i] - truth[i]).norm();
      sum += off * off, largest = std::max(largest, off), count += 1;
    }
  }
  EXPECT_LT(std::sqrt(sum / count), 0.3);
  EXPECT_LT(largest, 0.8);
}

TEST(ArucoDetector, TellsMirroredTags) {
  const TagDictionary dictionary = detect::builtin_dictionary("DICT_5X5_50");
  const ArucoDetector detector(dictionary, {});
  const detect::ArucoSearch mirrored = detector.search(drawn(dictionary, 3, 8, true));
  EXPECT_THAT(mirrored.tags, testing::IsEmpty());
  EXPECT_EQ(mirrored.mirrored, 1);
}

}  // namespace test_corners
}  // namespace plumbline
