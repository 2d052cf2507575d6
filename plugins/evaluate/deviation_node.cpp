#include "evaluate/deviation_node.hpp"

#include "artifacts/frame_artifact.hpp"
#include "evaluate/design_input.hpp"
#include "evaluate/metrics.hpp"
#include "evaluate/point_input.hpp"
#include "judgement/deviation.hpp"

namespace plumbline::evaluate {

std::vector<std::string> EvaluateDeviation::doubts() {
  std::vector<std::string> found;
  if (network && network->validity() && network->validity()->str() != "sound")
    found.push_back("the survey: " + (network->verdict() ? network->verdict()->str() : network->validity()->str()));
  if (block && block->tests())
    for (const auto* test : *block->tests())
      if (!test->passed())
        found.push_back("the image block: " + (test->words() ? test->words()->str() : test->group()->str()));
  return found;
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
  inputs.doubts = doubts();
  std::string dropped;
  if (inputs.model.covariance.size() != 0 && !inputs.model.covariance.allFinite()) {
    inputs.model.covariance.resize(0, 0);
    dropped = "The covariance of the model holds values that are not finite; it is not used.";
  }
  DeviationT result = judgement::judge_deviations(inputs, {*tau, *guard_factor});
  if (!dropped.empty()) result.warnings.push_back(dropped);
  for (const std::string& warning : result.warnings) context.warn(warning);
  context.metric("anchors_passed", result.passed, "1");
  context.metric("anchors_undecided", result.undecided, "1");
  context.metric("anchors_failed", result.failed, "1");
  context.metric("anchors_not_measured", result.not_measured, "1");
  deviation.commit(result);
  FileT file;
  file.name = "stake_out.csv", file.media_type = "text/csv";
  const std::string text =
      stake_out_csv(result, frames ? frame_link(frames.unpack(), "building", "survey") : FrameLink());
  file.content.assign(text.begin(), text.end());
  stake_out.commit(file);
}

}  // namespace plumbline::evaluate
