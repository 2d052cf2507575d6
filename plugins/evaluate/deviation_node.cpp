#include "evaluate/deviation_node.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "artifacts/frame_artifact.hpp"
#include "evaluate/design_input.hpp"
#include "evaluate/metrics.hpp"
#include "evaluate/point_input.hpp"

namespace plumbline::evaluate {

namespace {

std::string text_of(const flatbuffers::String* text) { return text ? text->str() : std::string(); }

/// "the standard deviations are multiplied by 1.3 for it"
std::string larger(double factor) {
  char text[80];
  std::snprintf(text, sizeof text, "; all standard deviations are %.3g times as large for it", std::sqrt(factor));
  return text;
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
    return ". To mend it, run again with \"block.with.free_interior=[fx, fy, cx, cy, k1, k2, k3, p1, p2, d1, d2]\".";
  return ".";
}

}  // namespace

/// One law: what fails a test that says so proves nothing (a doubt); what fits less well than it should is less
/// certain, by what its residuals say (a misfit).
void EvaluateDeviation::take_tests(judgement::DeviationInputs& inputs) {
  if (network && text_of(network->validity()) != "" && text_of(network->validity()) != "sound") {
    const auto* statistics = network->statistics();
    const bool tested =
        text_of(network->validity()) == "doubtful" && statistics && statistics->degrees_of_freedom() > 0;
    const std::string words = "the survey: " + text_of(network->verdict() ? network->verdict() : network->validity());
    const double factor =
        tested && !network->scaled_with_sigma0() ? std::max(1.0, std::pow(statistics->sigma0(), 2)) : 1;
    if (!tested)
      inputs.doubts.push_back(words);
    else
      inputs.misfit_factor = std::max(inputs.misfit_factor, factor),
      inputs.misfits.push_back(words + larger(factor) + ".");
  }
  if (!block || !block->tests()) return;
  for (const auto* test : *block->tests()) {
    if (test->passed()) continue;
    const std::string words = "the image block: " + text_of(test->words() ? test->words() : test->group());
    if (tests_observations(*block, *test)) {
      inputs.doubts.push_back(words);
      continue;
    }
    const double factor = std::max(1.0, test->variance_factor());
    inputs.misfit_factor = std::max(inputs.misfit_factor, factor);
    inputs.misfits.push_back(words + larger(factor) + mend_of(*test));
  }
}

void EvaluateDeviation::run(Context& context) {
  judgement::ToleranceTable table;
  table.tau = *tau, table.from_design = *design_tolerances;
  for (const std::string& rule : *tolerances) table.rules.push_back(judgement::parse_rule(rule));
  judgement::Mounting how;
  how.sigma = *mounting_sigma;
  for (const std::string& rule : *mounting) how.rules.push_back(judgement::parse_mounting(rule));
  judgement::DeviationInputs inputs =
      deviation_inputs(design.unpack(), matches.unpack(), plates.unpack(), table, *panel_reach, how);
  inputs.model = point_set(model.unpack(), "model");
  take_tests(inputs);
  std::string dropped;
  if (inputs.model.covariance.size() != 0 && !inputs.model.covariance.allFinite()) {
    inputs.model.covariance = {};
    dropped = "The covariance of the model holds values that are not finite; it is not used.";
  }
  inputs.model.covariance *= inputs.misfit_factor;
  DeviationT result = judgement::judge_deviations(inputs, {*tau, *risk});
  if (!dropped.empty()) result.warnings.push_back(dropped);
  for (const std::string& warning : result.warnings) context.warn(warning);
  context.metric("anchors_passed", result.passed, "1");
  context.metric("anchors_undecided", result.undecided, "1");
  context.metric("anchors_failed", result.failed, "1");
  context.metric("anchors_not_measured", result.not_measured, "1");
  context.metric("not_judged", result.not_judged, "1");
  // A measurement that proves nothing, and a question without an answer: exit code 3 (framework/cli/run.cpp).
  if (result.not_judged > 0 || !result.doubts.empty()) context.metric("invalid", 1, "1");
  deviation.commit(result);
  FileT file;
  file.name = "stake_out.csv", file.media_type = "text/csv";
  const std::string text =
      stake_out_csv(result, frames ? frame_link(frames.unpack(), "building", "survey") : FrameLink());
  file.content.assign(text.begin(), text.end());
  stake_out.commit(file);
}

}  // namespace plumbline::evaluate
