#include "photo/images/visibility.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <limits>
#include <numbers>

#include "photo/images/motion_blur.hpp"

namespace plumbline {
namespace {

using Histogram = std::array<std::int64_t, 256>;

/// Smallest value with at most `share` of the counts above it.
int value_exceeded_by(const Histogram& histogram, double share) {
  std::int64_t all = 0, above = 0;
  for (const std::int64_t count : histogram) all += count;
  for (int value = 255; value > 0; --value) {
    above += histogram[value];
    if (static_cast<double>(above) > share * static_cast<double>(all)) return value;
  }
  return 0;
}

/// Between the 2nd and the 98th of a hundred grey values, in the square of 64 px that has most.
int best_contrast(const GreyImage& image) {
  constexpr int kSide = 64;
  int best = 0;
  for (int top = 0; top < image.height; top += kSide)
    for (int left = 0; left < image.width; left += kSide) {
      Histogram values{};
      for (int y = top; y < std::min(top + kSide, image.height); ++y)
        for (int x = left; x < std::min(left + kSide, image.width); ++x)
          ++values[image.pixels[static_cast<std::size_t>(y) * image.width + x]];
      best = std::max(best, value_exceeded_by(values, 0.02) - value_exceeded_by(values, 0.98));
    }
  return best;
}

std::string rounded(double value) { return std::to_string(static_cast<int>(std::lround(value))); }

}  // namespace

Visibility visibility(const GreyImage& image) {
  Histogram values{}, slopes{};
  const auto at = [&](int x, int y) {
    return static_cast<int>(image.pixels[static_cast<std::size_t>(y) * image.width + x]);
  };
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) {
      ++values[at(x, y)];
      if (x >= 2) ++slopes[std::abs(at(x, y) - at(x - 2, y))];
      if (y >= 2) ++slopes[std::abs(at(x, y) - at(x, y - 2))];
    }
  Visibility result;
  result.darkest = value_exceeded_by(values, 0.995), result.brightest = value_exceeded_by(values, 0.005);
  result.contrast = best_contrast(image);
  const double slope = 0.5 * value_exceeded_by(slopes, 1e-4);
  const double step = result.brightest - result.darkest;
  result.edge_sigma =
      slope > 0 ? step / (slope * std::sqrt(2 * std::numbers::pi)) : std::numeric_limits<double>::infinity();
  return result;
}

std::string why_nothing_is_found(const GreyImage& image) {
  // Tags are found down to 5 grey values between black and white; blurred, while a module is wider than the blur.
  constexpr int kDark = 25, kBright = 245, kContrast = 30;
  constexpr double kBlur = 4;
  const Visibility seen = visibility(image);
  const std::string range = "99 % of its grey values lie between " + std::to_string(seen.darkest) + " and " +
                            std::to_string(seen.brightest) + " of 255";
  if (seen.brightest < kDark) return "the photograph is dark (" + range + "): expose longer, or take off the cap";
  if (seen.darkest > kBright) return "the photograph is overexposed (" + range + "): expose shorter";
  if (seen.contrast < kContrast)
    return "the photograph has next to no contrast (at most " + std::to_string(seen.contrast) +
           " of 255 grey values in any square of 64 px): mist, dirt on the lens, or wrong exposure";
  if (seen.edge_sigma > kBlur)
    return "the photograph is blurred (its sharpest edges have a blur of " +
           (std::isfinite(seen.edge_sigma) ? rounded(seen.edge_sigma) : std::string("more than 100")) +
           " px, 1 sigma): out of focus, or the camera moved";
  return in_words(motion_blur(image));
}

}  // namespace plumbline
