#include "build/evaluate/deviation_node.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <set>

#include "artifacts/frame_artifact.hpp"
#include "base/text/words.hpp"
#include "build/evaluate/design_input.hpp"
#include "build/evaluate/metrics.hpp"
#include "build/evaluate/point_input.hpp"
#include "building/ifc/doubt_words.hpp"
#include "building/judgement/designed_control.hpp"
#include "building/judgement/surfaces.hpp"
#include "building/judgement/tolerance_classes.hpp"
#include "building/judgement/trust.hpp"

namespace plumbline::judgement {

/// Whether control that was taken from the design holds the survey; then a doubt, unless somebody said how well the
/// place of the whole is known by other means.
bool EvaluateDeviation::hangs_on_the_design(DeviationInputs& inputs) const {
  if (!network || fitted_datum(*model, frames ? &*frames : nullptr)) return false;
  FrameLink link;
  if (frames) link = frame_link(frames.unpack(), "building", "survey");
  // Without a joint covariance nothing says how far known points take others along: then they count by number.
  PointSet places{inputs.model.ids, inputs.model.positions, {}};
  const DesignedControl control =
      designed_control(*network, link, inputs.anchors, inputs.common_unknown ? places : inputs.model);
  if (!control.holds_the_datum()) return false;
  if (!frames || std::isnan(frames->datum_sigma())) inputs.doubts.push_back(doubt_of(control));
  return true;
}

namespace {

std::string about_common_errors(std::size_t points) {
  return "What the errors of the anchors have in common is not known by itself (the survey is too large for a joint "
         "covariance): panels and common shifts count as no better known than single anchors; "
         "network.with.covariance=full makes it joint, in some " +
         std::to_string(1 + 3 * (72 * points * points >> 30U)) + " GB of memory.";
}

}  // namespace

std::vector<std::string> EvaluateDeviation::measured_in_part(const DeviationT& judged) const {
  // A bracket at a mullion, or the upper one of a panel below, carries two: one that a panel which misses nothing has,
  // too, does not say that its other panel is begun.
  std::set<std::string> of_whole;
  for (const auto& panel : judged.panels)
    for (const auto& fixing : panel->fixings)
      if (panel->missing.empty()) of_whole.insert(fixing->anchor);
  std::vector<std::string> panels;
  for (const auto& panel : judged.panels)
    if (!panel->missing.empty() && std::any_of(panel->fixings.begin(), panel->fixings.end(),
                                               [&](const auto& f) { return !of_whole.contains(f->anchor); }))
      panels.push_back((panel->name.empty() ? panel->guid : panel->name) + " without " + text::join(panel->missing, 8));
  return panels;
}

void EvaluateDeviation::run(Context& context) {
  judgement::ToleranceTable table;
  table.tau = *tau, table.from_design = *design_tolerances;
  // A table is for the whole project, rules are for this run: they stand after it and go before it.
  if (tolerance_table) {
    const FileT given = tolerance_table.unpack();
    table.rules =
        judgement::parse_tolerance_classes(std::string(given.content.begin(), given.content.end()), given.name);
  }
  for (const std::string& rule : *tolerances) table.rules.push_back(judgement::parse_rule(rule));
  judgement::Mounting how;
  how.sigma = *mounting_sigma;
  for (const std::string& rule : *mounting) how.rules.push_back(judgement::parse_mounting(rule));
  judgement::HeldBelow stack;
  for (const std::string& rule : *held_below) stack.rules.push_back(judgement::parse_held_below(rule));
  for (const std::string& sill : *sills) stack.sills.emplace_back(sill);
  judgement::DeviationInputs inputs =
      deviation_inputs(design.unpack(), matches.unpack(), plates.unpack(), table, *panel_reach, how, stack);
  inputs.model = point_set(*model, "model");
  inputs.common_unknown = network && network->covariances() && network->covariances()->size() > 0 &&
                          !(model->covariance() && model->covariance()->size() > 0);
  const bool common_unknown = inputs.common_unknown;
  const bool grows = *unmeasured_panels == "not_built";
  const judgement::Trust trust = judgement::trust_of(block ? &*block : nullptr, network ? &*network : nullptr);
  inputs.doubts = trust.doubts, inputs.misfits = trust.misfits, inputs.misfit_factor = trust.factor;
  const auto fitted = judgement::fitted_datum(*model, frames ? &*frames : nullptr);
  if (fitted)
    if (auto doubt = judgement::doubt_of_datum(*fitted)) inputs.doubts.push_back(*std::move(doubt));
  const bool designed = hangs_on_the_design(inputs);
  std::string dropped;
  if (inputs.model.covariance.size() != 0 && !inputs.model.covariance.allFinite()) {
    inputs.model.covariance = {};
    dropped = "The covariance of the model holds values that are not finite; it is not used.";
  }
  inputs.model.covariance *= inputs.misfit_factor;
  DeviationT result = judgement::judge_deviations(std::move(inputs), {*tau, *risk, grows});
  if (!dropped.empty()) result.warnings.push_back(dropped);
  if (common_unknown) result.warnings.push_back(about_common_errors(model->points()->size()));
  if (fitted) result.datum = judgement::about_best_fit(*fitted);
  if (designed && frames && std::isfinite(frames->datum_sigma()))
    result.datum = judgement::about_designed_control(frames->datum_sigma());
  if (!result.datum.empty()) context.warn(result.datum);
  if (surface_judgement)
    judgement::take_surfaces(surface_judgement.unpack(), result, judgement::panel_storeys(design.unpack()));
  for (const auto& doubt : result.doubts) context.warn("Nothing is decided: " + ifc::in_words(*doubt));
  for (const auto& misfit : result.misfits) context.warn(ifc::in_words(*misfit));
  const std::vector<std::string> in_part = grows ? measured_in_part(result) : std::vector<std::string>();
  // Whether it matters who knows what hangs says: a panel that hangs hides plates of its own (release.state).
  for (const std::string& panel : in_part)
    context.info("measured in part: " + panel + "; nothing is decided of that panel");
  for (const auto& request : result.requests)
    if (!request->not_judged.empty()) context.warn("Not judged: " + request->asked + ": " + request->not_judged + ".");
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
  // What leans in space, a block of photographs alone, is no frame that an instrument sets out in.
  const bool has_frame = frames && !(frames->fitted_to_design() && !frames->plan_only());
  const std::string text =
      stake_out_csv(result, has_frame ? frame_link(frames.unpack(), "building", "survey") : FrameLink());
  file.content.assign(text.begin(), text.end());
  stake_out.commit(file);
}

}  // namespace plumbline::judgement
