// evaluate.accuracy: the evaluation of accuracy.hpp as a node.
#include <map>

#include "artifacts/block.hpp"
#include "artifacts/deviation.hpp"
#include "artifacts/file.hpp"
#include "artifacts/joint_memory.hpp"
#include "artifacts/plates.hpp"
#include "artifacts/points.hpp"
#include "artifacts/transform.hpp"
#include "build/evaluate/deviation_node.hpp"
#include "build/evaluate/epochs_node.hpp"
#include "build/evaluate/metrics.hpp"
#include "build/evaluate/point_input.hpp"
#include "build/evaluate/surface_deviation_node.hpp"
#include "building/judgement/accuracy.hpp"
#include "building/judgement/check_anchors.hpp"
#include "plumbline/node.hpp"

namespace plumbline::judgement {

namespace {

AnchorUse use_of(const PlateT& plate) {
  if (plate.role == "control") return AnchorUse::control;
  if (plate.role == "check") return AnchorUse::check;
  throw std::runtime_error("input 'plates': anchor '" + plate.anchor + "' has the role '" + plate.role +
                           "', expected \"control\" or \"check\"; say it in the anchor table of campaign.yaml");
}

/// One row an anchor: an anchor may carry several plates, and a tag that stands for no point is none ("tie").
std::vector<AnchorEntry> anchor_table(const PlatesT& plates) {
  std::vector<AnchorEntry> table;
  std::map<std::string, std::size_t> index;
  for (const auto& plate : plates.plates) {
    if (plate->role == "tie") continue;
    const AnchorEntry entry{plate->anchor, plate->floor, plate->column, plate->row, use_of(*plate)};
    const auto [found, added] = index.emplace(entry.id, table.size());
    if (added) {
      table.push_back(entry);
      continue;
    }
    const AnchorEntry& first = table[found->second];
    if (first.floor != entry.floor || first.use != entry.use)
      throw std::runtime_error("input 'plates': two plates of anchor '" + entry.id + "' differ in floor or role");
  }
  return table;
}

std::unique_ptr<AdjustmentSummaryT> summary_of(const BlockT& block) {
  auto summary = std::make_unique<AdjustmentSummaryT>();
  summary->datum = block.datum, summary->weighting = block.weighting, summary->lambda = block.lambda;
  summary->statistics = std::make_unique<StatisticsT>(*block.statistics);
  return summary;
}

std::unique_ptr<RegistrationSummaryT> summary_of(const TransformT& transform) {
  auto summary = std::make_unique<RegistrationSummaryT>();
  summary->statistics =
      transform.statistics ? std::make_unique<StatisticsT>(*transform.statistics) : std::make_unique<StatisticsT>();
  for (const auto& residual : transform.residuals) summary->down_weighted += residual->weight < 1;
  summary->residual_covariance = transform.residual_covariance;
  summary->residual_covariance_unbiased = transform.residual_covariance_unbiased;
  return summary;
}

FileT file_of(const std::string& name, const std::string& media_type, const std::string& text) {
  FileT file;
  file.name = name, file.media_type = media_type;
  file.content.assign(text.begin(), text.end());
  return file;
}

}  // namespace

struct EvaluateAccuracy : Node {
  static constexpr Info info{"evaluate.accuracy", "metric", 6,
                             "Anchor, floor and column accuracy of a model: (1)-(3) and (9)-(13); the metrics files"};
  In<Points> model{"model", frame("frame=?F"), "points of the model with their covariance"};
  In<Points> survey{"survey", frame("frame=?F"), "surveyed points with their covariance"};
  In<Plates> plates{"plates", frame("frame=?F"), "anchor table: floor, column, row and role of every anchor"};
  Optional<Points> truth{"truth", frame("frame=?F"), "true points, in simulation"};
  Optional<Deviation> deviation{"deviation", frame("frame=?F"), "as-built minus design (14), for the metrics"};
  Optional<Block> block{"block", frame("frame=?B"), "the adjustment behind the model, (4) or (5), for the metrics"};
  Optional<Transform> registration{"registration", frame("to=?F,from=?B"),
                                   "the registration behind it, (6) to (8), for the metrics"};
  Param<std::vector<double>> tolerances{"tolerances", default_tolerances(), "m", between(1e-6, 1),
                                        "sweep of (3) and (10)"};
  Param<double> tau{"tau", 0.005, "m", between(1e-6, 1), "headline tolerance of the verdicts"};
  Param<double> guard_factor{"guard_factor", 1.645, "1", between(0, 10),
                             "k of the guard band: pass if |dz| + k u <= tau"};
  Param<double> confidence{"confidence", 0.95, "1", between(0.5, 0.9999), "level of all intervals and tests"};
  Param<bool> drift_on_control{"drift_on_control", false, "D(F) on control anchors too, marked as no evidence"};
  Param<std::string> correlation{
      "correlation", "from_control", one_of("from_control", "independent", "same"),
      "from_control: the model was adjusted to this survey's control anchors with their covariance, "
      "(5); also right for (6) where the image block is much more precise than the survey. same: the model is this "
      "survey, of anchors that were measured by total station alone (or, with a block, in photographs alone), and "
      "nothing is compared"};
  Param<double> mounting_sigma{
      "mounting_sigma", 0.0, "m", between(0, 0.1),
      "of a plate's place on its anchor, each axis: part of what is expected against the truth, "
      "which is of anchors"};
  Param<std::string> contradicting_checks{"contradicting_checks", "warn", one_of("warn", "invalid"),
                                          "what a model is that its own check anchors contradict, one of them or all "
                                          "together, at 0.1 %: told, or not to be "
                                          "used as it is (exit code 3)"};
  Out<Accuracy> accuracy{"accuracy", frame("frame=?F"), "the evaluation"};
  Out<File> metrics{"metrics", "metrics.json"};
  Out<File> table{"table", "metrics.csv"};
  Out<File> junit{"junit", "metrics.xml in the format of JUnit: what fails can fail a CI job"};

  Options options() const {
    Options chosen;
    chosen.tolerances = *tolerances;
    chosen.tau = *tau, chosen.guard_factor = *guard_factor, chosen.confidence = *confidence;
    chosen.drift_on_control = *drift_on_control;
    chosen.name_contradicting_checks = *contradicting_checks == "invalid";
    chosen.correlation = *correlation == "independent" ? Correlation::independent : Correlation::from_control;
    return chosen;
  }

  void run(Context& context) override {
    announce_joint(context, joint_size(model) + joint_size(survey) + joint_size(truth), 6);
    Inputs inputs;
    const PlatesT listed = plates.unpack();
    inputs.anchors = anchor_table(listed);
    for (const auto& plate : listed.plates)
      if (plate->role == "tie") inputs.ties.push_back(plate->anchor);
    inputs.model = point_set(*model, "model");
    inputs.model_is_survey = *correlation == "same", inputs.of_photographs = static_cast<bool>(block);
    if (!inputs.model_is_survey) inputs.survey = point_set(*survey, "survey");
    inputs.mounting_sigma = *mounting_sigma;
    if (block && block->control())
      for (const auto* control : *block->control())
        if (control->left_out()) inputs.not_adjusted_to.insert(control->anchor()->str());
    if (truth) inputs.truth = point_set(*truth, "truth");
    AccuracyT result = evaluate_accuracy(std::move(inputs), options());
    if (block) result.adjustment = summary_of(block.unpack());
    if (registration) result.registration = summary_of(registration.unpack());
    for (const std::string& warning : result.warnings) context.warn(warning);
    for (const auto& c : result.comparisons) {
      const std::string name = std::string(EnumNameAnchorUse(c->use)) + "_" + EnumNameAccuracyReference(c->reference);
      context.metric("rmse_z_" + name, c->rmse_z, "m");
      context.metric("max_abs_dz_" + name, c->max_abs_dz, "m");
      context.metric("rmse_3d_" + name, c->rmse_3d, "m");
    }
    if (*contradicting_checks == "invalid") context.metric("invalid", check_anchors_hold(result) ? 0 : 1, "1");
    accuracy.commit(result);
    DeviationT built;
    if (deviation) built = deviation.unpack();
    const DeviationT* told = deviation ? &built : nullptr;
    metrics.commit(file_of("metrics.json", "application/json", metrics_json(result, told)));
    table.commit(file_of("metrics.csv", "text/csv", metrics_csv(result, told)));
    junit.commit(file_of("metrics.xml", "application/xml", junit_xml(result, told)));
  }
};

}  // namespace plumbline::judgement

PLUMBLINE_PLUGIN("evaluate", PLUMBLINE_BUILD_ID, "MIT", plumbline::judgement::EvaluateAccuracy,
                 plumbline::judgement::EvaluateDeviation, plumbline::judgement::EvaluateEpochs,
                 plumbline::judgement::SurfaceDeviation)
