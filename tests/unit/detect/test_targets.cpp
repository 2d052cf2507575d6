// Centres of surveyed targets, on drawings made apart from the model that is fitted.
#include <gmock/gmock.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "photo/detect/target_fit.hpp"
#include "tag_rendering.hpp"

namespace plumbline::detect {
namespace test_targets {

using testing::HasSubstr;

constexpr int kSize = 72;

/// Reflectance of a target of radius 1 on a grey board.
double reflectance(TargetKind kind, double u, double v) {
  if (std::hypot(u, v) > 1) return 0.3;
  if (kind == TargetKind::quadrants) return (u > 0) == (v > 0) ? 0.04 : 0.8;
  return std::min(std::abs(u), std::abs(v)) < 0.08 ? 0.04 : 0.8;
}

/// Light of a target seen obliquely and in perspective: drawn, blurred and then gathered by the pixels, from cells of a
/// quarter of a pixel. `tilt` [1/px] is how the scale falls off to the right.
std::vector<double> light_of(TargetKind kind, const Eigen::Vector2d& centre, const Eigen::Matrix2d& pixel_from_target,
                             double blur = 0.8, double tilt = 0.0005) {
  constexpr int cells = 4, samples = 13, reach = 6 * cells, wide = kSize * cells + 2 * reach;
  const Eigen::Matrix2d target_from_pixel = pixel_from_target.inverse();
  std::vector<double> sharp(wide * wide), rows(wide * wide), light(kSize * kSize);
  const auto cell = [](int x, int y) { return static_cast<std::size_t>(y * wide + x); };
  for (int y = 0; y < wide; ++y)
    for (int x = 0; x < wide; ++x)
      for (int k = 0; k < samples; ++k) {
        // Fibonacci's lattice, symmetric about the middle: on a square grid upright edges would fall on its steps.
        const Eigen::Vector2d in_cell((k + 0.5) / samples, std::fmod(5 * (k + 0.5) / samples, 1));
        const Eigen::Vector2d at = (Eigen::Vector2d(x - reach, y - reach) + in_cell) / cells;
        const Eigen::Vector2d d = at - Eigen::Vector2d(0.5, 0.5) - centre;
        const Eigen::Vector2d on_target = target_from_pixel * d / (1 + tilt * d.x());
        sharp[cell(x, y)] += reflectance(kind, on_target.x(), on_target.y()) / samples;
      }
  std::vector<double> weight(2 * reach + 1);
  double sum = 0;
  for (int k = -reach; k <= reach; ++k) sum += weight[k + reach] = std::exp(-0.5 * std::pow(k / (blur * cells), 2));
  for (double& w : weight) w /= sum;
  for (int y = 0; y < wide; ++y)
    for (int x = reach; x < wide - reach; ++x)
      for (int k = -reach; k <= reach; ++k) rows[cell(x, y)] += weight[k + reach] * sharp[cell(x + k, y)];
  for (int y = 0; y < kSize * cells; ++y)
    for (int x = 0; x < kSize * cells; ++x)
      for (int k = -reach; k <= reach; ++k)
        light[y / cells * kSize + x / cells] +=
            weight[k + reach] * rows[cell(x + reach, y + reach + k)] / (cells * cells);
  return light;
}

/// sRGB's own curve (IEC 61966-2-1), noise, rounding.
GreyImage photograph(const std::vector<double>& light, double noise, std::uint64_t seed) {
  test::NormalNoise random(seed);
  GreyImage image{kSize, kSize, {}};
  for (const double l : light) {
    const double grey = 255 * (l < 0.0031308 ? 12.92 * l : 1.055 * std::pow(l, 1 / 2.4) - 0.055) + noise * random();
    image.pixels.push_back(static_cast<std::uint8_t>(std::clamp(std::lround(grey), 0l, 255l)));
  }
  return image;
}

Eigen::Matrix2d turned(double angle, double scale, double across) {
  Eigen::Matrix2d m;
  m << scale * std::cos(angle), -across * std::sin(angle), scale * std::sin(angle), across * std::cos(angle);
  return m;
}

TEST(Targets, AreMeasuredToAFewHundredthsOfAPixelUnderARealCurve) {
  for (const TargetKind kind : {TargetKind::quadrants, TargetKind::crosshair})
    for (const double angle : {0.0, 0.5, 0.785, 1.2})
      for (const double scale : {10.0, 18.0}) {
        const Eigen::Vector2d centre(35.37 + angle, 34.71 - 0.3 * angle);
        const auto light = light_of(kind, centre, turned(angle, scale, 0.7 * scale));
        const MeasuredTarget found = measure_target(photograph(light, 1.5, 1), centre + Eigen::Vector2d(5, -6), {});
        EXPECT_EQ(found.problem, "") << angle << " " << scale;
        EXPECT_EQ(found.kind, kind) << angle << " " << scale;
        EXPECT_LT((found.centre - centre).norm(), 0.05) << static_cast<int>(kind) << " " << angle << " " << scale;
        EXPECT_LT(std::sqrt(found.covariance.trace()), 0.06);
      }
}

/// Without noise nothing is left but the method's own bias.
TEST(Targets, AreNotBiasedByTheCurveTheBlurOrThePlaceWithinAPixel) {
  for (const TargetKind kind : {TargetKind::quadrants, TargetKind::crosshair})
    for (const double part : {0.0, 0.3, 0.5})
      for (const double blur : {0.5, 1.4}) {
        const Eigen::Vector2d centre(35 + part, 36.4 - part);
        const auto light = light_of(kind, centre, turned(0.2, 16, 12), blur);
        const MeasuredTarget found = measure_target(photograph(light, 0, 1), {36, 37}, {});
        EXPECT_EQ(found.problem, "");
        EXPECT_LT((found.centre - centre).norm(), 0.02) << static_cast<int>(kind) << " " << part << " " << blur;
      }
}

/// Mean of squared errors over their stated variance, in both coordinates.
double chi2(TargetKind kind, double noise, int trials) {
  double sum = 0;
  for (int place = 0; place < 4; ++place) {
    const Eigen::Vector2d centre(35.1 + 0.27 * place, 36.3 - 0.19 * place);
    const auto light = light_of(kind, centre, turned(0.1 + 0.4 * place, 15, 11));
    for (int trial = 0; trial < trials; ++trial) {
      const auto seed = static_cast<std::uint64_t>(100 * place + trial + 1);
      const MeasuredTarget found =
          measure_target(photograph(light, noise, seed), {36, 36}, {.search = 3, .max_radius = 12});
      EXPECT_EQ(found.problem, "");
      sum += (found.centre - centre).dot(found.covariance.inverse() * (found.centre - centre));
    }
  }
  return sum / (2 * 4 * trials);
}

TEST(Targets, CarryACovarianceThatIsTrue) {
  const int trials = std::getenv("PLUMBLINE_LONG") ? 50 : 8;
  for (const TargetKind kind : {TargetKind::quadrants, TargetKind::crosshair})
    for (const double noise : {1.5, 5.0}) {
      const double value = chi2(kind, noise, trials);
      RecordProperty("chi2", std::to_string(value));
      EXPECT_GT(value, 0.7) << static_cast<int>(kind) << " " << noise;
      EXPECT_LT(value, 1.5) << static_cast<int>(kind) << " " << noise;
    }
}

TEST(Targets, SayWhyThereIsNone) {
  const Eigen::Vector2d centre(35.5, 35.2);
  const auto light = light_of(TargetKind::quadrants, centre, turned(0.3, 20, 20));
  const GreyImage image = photograph(light, 1, 1);
  EXPECT_THAT(measure_target(image, {3, 31}, {}).problem, HasSubstr("border"));
  EXPECT_THAT(measure_target(image, {std::nan(""), 31}, {}).problem, HasSubstr("outside"));
  EXPECT_THAT(measure_target(image, centre, {.kind = TargetKind::crosshair}).problem, testing::Not(""));
  GreyImage flat = image;
  std::fill(flat.pixels.begin(), flat.pixels.end(), std::uint8_t{90});
  EXPECT_THAT(measure_target(flat, {31, 31}, {}).problem, HasSubstr("contrast"));
  GreyImage covered = image;  // nearly up to the centre
  for (int y = 0; y < kSize; ++y)
    for (int x = 36; x < kSize; ++x) covered.pixels[y * kSize + x] = 20;
  EXPECT_NE(measure_target(covered, centre, {}).problem, "");
  GreyImage edge = flat, bar = flat;
  for (int y = 0; y < kSize; ++y)
    for (int x = 0; x < kSize; ++x) {
      const auto i = static_cast<std::size_t>(y * kSize + x);
      if (x < 36) edge.pixels[i] = 200;
      if (std::abs(x - y) < 3) bar.pixels[i] = 200;
    }
  EXPECT_NE(measure_target(edge, {36, 36}, {}).problem, "") << "an edge has no centre";
  EXPECT_NE(measure_target(bar, {36, 36}, {}).problem, "") << "nor has a bar";
  const auto blurred = light_of(TargetKind::quadrants, centre, turned(0.3, 7, 7), 6);
  EXPECT_NE(measure_target(photograph(blurred, 1, 1), centre, {}).problem, "");
}

TEST(Targets, ThatMayBeTwoAreNotChosenBetween) {
  GreyImage board{kSize, kSize, {}};  // a chessboard with squares of 14 px
  for (int y = 0; y < kSize; ++y)
    for (int x = 0; x < kSize; ++x) board.pixels.push_back(static_cast<std::uint8_t>((x / 14 + y / 14) % 2 ? 220 : 30));
  EXPECT_THAT(measure_target(board, {34, 34}, {.search = 12}).problem, HasSubstr("two targets"));
  EXPECT_EQ(measure_target(board, {40, 43}, {.search = 4}).problem, "");
}

}  // namespace test_targets
}  // namespace plumbline::detect
