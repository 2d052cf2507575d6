// Corners of tags in photographs as cameras write them: light that a lens has blurred, the curve of sRGB, and JPEG.
// Drawn by OpenCV, apart from our renderer and its simulator.
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "detect/corner_refinement.hpp"
#include "tag_cells.hpp"
#include "tag_rendering.hpp"

namespace plumbline {
namespace {

constexpr int kColumns = 4, kRows = 3, kField = 200;  // tags, and the square that each has to itself [px]
constexpr int kFine = 8;                              // samples a pixel, each way

/// Where the corners of the tags are: bottom left, bottom right, top right, top left [px].
std::vector<detect::Quadrilateral> places(std::uint64_t seed) {
  test::NormalNoise random(seed);
  std::vector<detect::Quadrilateral> tags;
  for (int k = 0; k < kColumns * kRows; ++k) {
    const Eigen::Vector2d middle(kField * (k % kColumns + 0.5) + random.uniform(),
                                 kField * (k / kColumns + 0.5) + random.uniform());
    tags.push_back(
        {test::square_corners(middle, 70 + 40 * random.uniform(), 0.1 + 6 * random.uniform(), 0.7 * random.uniform()),
         8});
  }
  return tags;
}

/// Light, 0 to 1, of the tags before a wall; blurred by a lens with the standard deviation `blur` [px].
cv::Mat light_of(const std::vector<detect::Quadrilateral>& tags, double blur) {
  constexpr int kCell = 60;  // of the drawing that is projected [samples]
  cv::Mat light(kRows * kField, kColumns * kField, CV_32F);
  for (std::size_t k = 0; k < tags.size(); ++k) {
    const test::TagCells cells = test::cells_of("tag36h11", static_cast<int>(k));
    cv::Mat drawing(cells.total * kCell, cells.total * kCell, CV_32F);
    for (int y = 0; y < drawing.rows; ++y)
      for (int x = 0; x < drawing.cols; ++x)
        drawing.at<float>(y, x) =
            cells.white[static_cast<std::size_t>(y / kCell * cells.total + x / kCell)] > 127 ? 0.6f : 0.04f;
    const float near = static_cast<float>((cells.total - cells.border) / 2 * kCell) - 0.5f;
    const float far = near + static_cast<float>(cells.border * kCell);
    const std::vector<cv::Point2f> from = {{near, far}, {far, far}, {far, near}, {near, near}};
    const cv::Rect field(kField * (static_cast<int>(k) % kColumns), kField * (static_cast<int>(k) / kColumns), kField,
                         kField);
    const auto fine = [](double pixel) { return static_cast<float>((pixel + 0.5) * kFine - 0.5); };
    std::vector<cv::Point2f> to;
    for (const auto& corner : tags[k].corners) to.emplace_back(fine(corner.x() - field.x), fine(corner.y() - field.y));
    cv::Mat samples(kField * kFine, kField * kFine, CV_32F, cv::Scalar(0.6));
    cv::warpPerspective(drawing, samples, cv::getPerspectiveTransform(from, to), samples.size(), cv::INTER_NEAREST,
                        cv::BORDER_TRANSPARENT);
    cv::GaussianBlur(samples, samples, {}, blur * kFine);
    cv::resize(samples, light(field), field.size(), 0, 0, cv::INTER_AREA);
  }
  return light;
}

/// Grey values after the curve of sRGB (IEC 61966-2-1) if `srgb`, and JPEG; quality 0: not compressed.
GreyImage photograph_of(const cv::Mat& light, bool srgb, int quality, double noise) {
  test::NormalNoise random(5);
  cv::Mat grey(light.size(), CV_8U);
  for (int y = 0; y < light.rows; ++y)
    for (int x = 0; x < light.cols; ++x) {
      const double l = light.at<float>(y, x);
      const double value = srgb ? (l <= 0.0031308 ? 12.92 * l : 1.055 * std::pow(l, 1 / 2.4) - 0.055) : l;
      grey.at<std::uint8_t>(y, x) = cv::saturate_cast<std::uint8_t>(255 * value + noise * random());
    }
  if (quality > 0) {
    std::vector<std::uint8_t> file;
    cv::imencode(".jpg", grey, file, {cv::IMWRITE_JPEG_QUALITY, quality});
    grey = cv::imdecode(file, cv::IMREAD_GRAYSCALE);
  }
  return {grey.cols, grey.rows, std::vector<std::uint8_t>(grey.begin<std::uint8_t>(), grey.end<std::uint8_t>())};
}

struct Agreement {
  double inward = 0, chi_squared = 0;  // mean displacement across the edges towards the tag [px]; per freedom
  double gamma = 0;
  int corners = 0;
};

/// With the floor of 0.02 px that the detectors add.
Agreement agreement(const GreyImage& image, const std::vector<detect::Quadrilateral>& tags) {
  detect::EdgeFitOptions options;
  options.gamma = 0;
  options.grid.reset();
  const auto measured = detect::measure_corners(image, tags, options);
  Agreement a;
  a.gamma = measured.quality.gamma;
  for (std::size_t k = 0; k < tags.size(); ++k) {
    if (!measured.corners[k]) continue;
    const auto& truth = tags[k].corners;
    const Eigen::Vector2d centre = 0.25 * (truth[0] + truth[1] + truth[2] + truth[3]);
    for (std::size_t i = 0; i < 4; ++i) {
      const Eigen::Vector2d e = measured.corners[k]->corners[i] - truth[i];
      const Eigen::Matrix2d covariance = measured.corners[k]->covariances[i] + 0.0004 * Eigen::Matrix2d::Identity();
      a.inward -= e.dot((truth[i] - centre).normalized()) / std::sqrt(2.0);
      a.chi_squared += e.dot(covariance.inverse() * e) / 2;
      ++a.corners;
    }
  }
  a.inward /= a.corners, a.chi_squared /= a.corners;
  return a;
}

class PhotographsDrawnApart : public testing::Test {
 protected:
  static constexpr double kBlur = 0.7;  // [px]
  std::vector<detect::Quadrilateral> tags = places(1);
  cv::Mat light = light_of(tags, kBlur);
};

/// The curve that JPEG hides drew corners inwards by 0.02 to 0.5 px, with 0.02 px stated.
TEST_F(PhotographsDrawnApart, HaveCornersWhereTheyAre) {
  for (const int quality : {0, 95, 80, 60}) {
    const Agreement a = agreement(photograph_of(light, true, quality, 1), tags);
    EXPECT_EQ(a.corners, 48) << quality;
    EXPECT_LT(std::abs(a.inward), 0.05) << quality;
    EXPECT_LT(a.chi_squared, 1.5) << quality;
  }
}

TEST_F(PhotographsDrawnApart, InLinearLightAreNotMistaken) {
  for (const int quality : {0, 90}) {
    const Agreement a = agreement(photograph_of(light, false, quality, 1), tags);
    EXPECT_EQ(a.gamma, 1) << quality;
    EXPECT_LT(std::abs(a.inward), 0.01) << quality;
    EXPECT_LT(a.chi_squared, 1.5) << quality;
  }
}

}  // namespace
}  // namespace plumbline
