// Global tests of a tag block: the variance of each group of observations against what was assumed of it.
#include <cmath>
#include <cstdio>

#include "block/control_words.hpp"
#include "block/tag_block_model.hpp"
#include "geometry/statistics.hpp"

namespace plumbline::adjust {
namespace {

/// Detectors know their standard deviations to a factor of some five: residuals larger than that are no noise.
constexpr double largest_image_factor = 25;
constexpr double test_level = 1e-4;

}  // namespace

void test_groups(const TagBlock& block, TagBlockResult& result) {
  for (const auto& group : result.groups) {
    if (!(group.redundancy > 0.1)) continue;
    GroupTest test;
    test.group = group.name;
    test.factor = group.factor;
    char figure[160];
    if (group.name == "images") {
      test.factor *= result.image_variance_factor;
      test.limit = largest_image_factor;
      std::snprintf(figure, sizeof figure, "the tags fit %.1f times worse than the detector says of its corners",
                    std::sqrt(test.factor));
      test.words = std::string(figure) + ": camera model or calibration, tag size or plate table are wrong";
    } else {
      test.limit = chi_squared_quantile(1 - test_level, group.redundancy) / group.redundancy;
      std::snprintf(figure, sizeof figure, " (variance factor %.3g, expected 1, at most %.2f)", test.factor,
                    test.limit);
      test.words =
          (group.name == "control"
               ? "images and survey contradict each other far beyond the survey's standard deviations"
           : group.name == "interior prior" ? "the images contradict the camera's calibration far beyond its sigmas: "
                                              "wrong calibration, lens or focus"
           : group.name == "tag scale prior"
               ? "the tags are not of the size given: printed at another scale, or measured wrong"
               : "the images contradict the " + group.name) +
          std::string(figure);
    }
    test.passed = test.factor <= test.limit;
    if (group.name == "control" && !test.passed) test.words += control_in_words(block, result);
    if (test.passed) test.words.clear();
    result.tests.push_back(test);
  }
}

}  // namespace plumbline::adjust
