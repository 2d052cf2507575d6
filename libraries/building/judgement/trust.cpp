#include "building/judgement/trust.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

namespace plumbline::judgement {
namespace {

std::string text_of(const flatbuffers::String* text) { return text ? text->str() : std::string(); }

/// "the standard deviations are multiplied by 1.3 for it"
std::string larger(double factor) {
  return fmt::format("; all standard deviations are {:.3g} times as large for it", std::sqrt(factor));
}

/// A group of observations that contradicts the rest proves the block wrong. A test of what the camera model leaves out
/// is of no group.
bool tests_observations(const Block& block, const BlockTest& test) {
  for (const auto* group : *block.groups())
    if (group->name()->str() == test.group()->str()) return true;
  return false;
}

/// The whole command.
std::string mend_of(const BlockTest& test) {
  const std::string group = test.group()->str();
  if (group == "one principal point")
    return ". To mend it, run again with \"block.with.image_principal_point_sigma=0.5\" (px; 0.1 to 1 for lenses that "
           "are "
           "focused or stabilised between images).";
  if (group.starts_with("distortion at all distances"))
    return ". To mend it, run again with \"block.with.free_interior=[fx, fy, cx, cy, k1, k2, k3, k4, p1, p2, d1, "
           "d2]\".";
  return ".";
}

}  // namespace

Trust trust_of(const Block* block, const SurveyNetwork* network) {
  Trust trust;
  if (network && text_of(network->validity()) != "" && text_of(network->validity()) != "sound") {
    const auto* statistics = network->statistics();
    const bool tested =
        text_of(network->validity()) == "doubtful" && statistics && statistics->degrees_of_freedom() > 0;
    const std::string words = "the survey: " + text_of(network->verdict() ? network->verdict() : network->validity());
    const double factor =
        tested && !network->scaled_with_sigma0() ? std::max(std::pow(statistics->sigma0(), 2), 1.0) : 1;
    if (!tested || !std::isfinite(factor))
      trust.doubts.push_back(words);
    else
      trust.factor = std::max(trust.factor, factor), trust.misfits.push_back(words + larger(factor) + ".");
  }
  if (!block || !block->tests()) return trust;
  for (const auto* test : *block->tests()) {
    if (test->passed()) continue;
    const std::string words = "the image block: " + text_of(test->words() ? test->words() : test->group());
    // By how much is not known: no factor makes up for it.
    if (tests_observations(*block, *test) || !std::isfinite(test->variance_factor())) {
      trust.doubts.push_back(words);
      continue;
    }
    const double factor = std::max(1.0, test->variance_factor());
    trust.factor = std::max(trust.factor, factor);
    trust.misfits.push_back(words + larger(factor) + mend_of(*test));
  }
  return trust;
}

}  // namespace plumbline::judgement
