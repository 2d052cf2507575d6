#include "building/judgement/accuracy.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <map>
#include <set>
#include <stdexcept>

#include "building/judgement/anchor_doubts.hpp"
#include "building/judgement/check_anchors.hpp"
#include "building/judgement/comparison.hpp"
#include "building/judgement/difference.hpp"
#include "building/judgement/drift.hpp"
#include "building/judgement/figures.hpp"
#include "building/judgement/tolerance.hpp"
#include "geometry/statistics.hpp"

namespace plumbline::judgement {

namespace {

using judgement::list_of;

using PointIndex = std::map<std::string, std::size_t>;

/// Everything the steps of an evaluation share.
struct Evaluation {
  const Inputs& inputs;
  Options options;
  PointSet model, survey;  ///< as given, without a covariance that cannot be used
  PointIndex model_index, survey_index, truth_index;
  AccuracyT result;
  bool other_checks_hold = false;  ///< some contradict the model, are named, and without them it is not contradicted

  void warn(const std::string& text) { result.warnings.push_back(text); }
};

void check_options(const Options& options) {
  const auto check = [](bool good, const std::string& what, double value) {
    if (!good) throw std::runtime_error("accuracy evaluation: " + what + ", not " + std::to_string(value));
  };
  for (const double tau : options.tolerances)
    check(tau > 0 && std::isfinite(tau), "every tolerance must be a positive length in m", tau);
  check(options.tau > 0 && std::isfinite(options.tau), "tau must be a positive length in m", options.tau);
  check(options.guard_factor >= 0 && options.guard_factor <= 10, "the guard factor must be within 0 and 10",
        options.guard_factor);
  check(options.confidence > 0.5 && options.confidence < 1, "the confidence must be between 0.5 and 1",
        options.confidence);
}

void check_table(const std::vector<AnchorEntry>& table) {
  if (table.empty())
    throw std::runtime_error(
        "accuracy evaluation: the anchor table is empty; it must say floor, column and use of every anchor");
  std::set<std::string> ids;
  for (const AnchorEntry& anchor : table)
    if (!ids.insert(anchor.id).second)
      throw std::runtime_error("accuracy evaluation: the anchor table holds '" + anchor.id + "' twice");
}

/// A point set whose covariance is either usable or gone.
PointSet usable(PointSet points, const std::string& what, Evaluation& evaluation) {
  if (points.ids.empty()) return points;
  if (points.covariance.size() == 0) {
    evaluation.warn("The " + what +
                    " comes without a covariance: no uncertainty can be given and every verdict stays undecided.");
  } else if (!points.covariance.allFinite() || points.covariance.diagonal().minCoeff() < 0) {
    evaluation.warn("The covariance of the " + what +
                    " holds values that are not finite or variances below zero; it is not used, "
                    "and every verdict stays undecided.");
    points.covariance = {};
  }
  return points;
}

/// Why the anchor cannot be compared with this reference; empty when it can.
std::string missing(const std::string& id, const PointSet& model, const PointIndex& model_index,
                    const PointSet& reference, const PointIndex& reference_index, const std::string& name) {
  const auto in_model = model_index.find(id);
  const auto in_reference = reference_index.find(id);
  if (in_model == model_index.end()) return "no model point";
  if (!model.positions[in_model->second].allFinite()) return "the model position is not finite";
  if (in_reference == reference_index.end()) return "no " + name + " point";
  if (!reference.positions[in_reference->second].allFinite()) return "the " + name + " position is not finite";
  return "";
}

std::vector<Match> matches_of(const Evaluation& evaluation, const PointSet& reference, const PointIndex& index,
                              const std::string& name) {
  std::vector<Match> matches;
  const auto& table = evaluation.inputs.anchors;
  for (std::size_t i = 0; i < table.size(); ++i)
    if (missing(table[i].id, evaluation.model, evaluation.model_index, reference, index, name).empty())
      matches.push_back({i, evaluation.model_index.at(table[i].id), index.at(table[i].id)});
  return matches;
}

/// Differences of all matches; the covariance is left out.
DifferenceSet differences_of(const PointSet& model, const PointSet& reference, const std::vector<Match>& matches) {
  DifferenceSet set;
  set.difference.resize(3 * static_cast<Eigen::Index>(matches.size()));
  for (std::size_t i = 0; i < matches.size(); ++i) {
    set.anchors.push_back(matches[i].anchor);
    set.difference.segment<3>(3 * static_cast<Eigen::Index>(i)) =
        model.positions[matches[i].model] - reference.positions[matches[i].reference];
  }
  return set;
}

/// Differences against a reference that is taken as exact, but for where plates sit on the anchors it is of.
DifferenceSet against_exact(const Evaluation& evaluation, const PointSet& reference, const PointIndex& index,
                            const std::string& name) {
  const std::vector<Match> matches = matches_of(evaluation, reference, index, name);
  DifferenceSet set = differences_of(evaluation.model, reference, matches);
  if (evaluation.model.covariance.size() == 0) return set;
  PointSet exact;
  const double mounting = evaluation.inputs.mounting_sigma;
  const std::vector<Eigen::Matrix3d> of_each(reference.ids.size(), mounting * mounting * Eigen::Matrix3d::Identity());
  exact.covariance = BlockCovariance::independent(of_each);
  set.covariance = difference_covariance(evaluation.model, exact, matches, {}).matrix;
  return set;
}

DifferenceSet against_survey(Evaluation& evaluation) {
  const std::vector<Match> matches = matches_of(evaluation, evaluation.survey, evaluation.survey_index, "survey");
  DifferenceSet set = differences_of(evaluation.model, evaluation.survey, matches);
  std::string& note = evaluation.result.correlation_note;
  if (evaluation.model.covariance.size() == 0 || evaluation.survey.covariance.size() == 0) {
    note = "Without a covariance of model and survey, uncertainties are not known.";
    return set;
  }
  std::vector<Match> control;
  if (evaluation.options.correlation == Correlation::from_control)
    for (const Match& match : matches)
      if (const AnchorEntry& anchor = evaluation.inputs.anchors[match.anchor];
          anchor.use == AnchorUse::control && !evaluation.inputs.not_adjusted_to.contains(anchor.id))
        control.push_back(match);
  DifferenceCovariance covariance = difference_covariance(evaluation.model, evaluation.survey, matches, control);
  set.covariance = std::move(covariance.matrix);
  if (control.empty()) {
    note =
        "The uncertainty of a difference is taken from the covariances of model and survey as independent of each "
        "other.";
  } else if (covariance.consistent) {
    note =
        "The uncertainty of a difference is taken from the covariances of model and survey and from the correlation "
        "between "
        "them: the model was adjusted to the survey of its control anchors. On a control anchor that leaves the "
        "uncertainty of an adjusted "
        "residual, which is smaller than that of the survey itself.";
  } else {
    note =
        "The uncertainty of a difference is taken from the covariances of model and survey as independent of each "
        "other.";
    evaluation.warn(
        "The covariance of the model is not that of an adjustment weighted with the survey's covariance, so the "
        "correlation "
        "between the two is not known: uncertainties of the differences assume none and are too large on control "
        "anchors.");
  }
  return set;
}

std::vector<std::size_t> positions_of_use(const DifferenceSet& set, const std::vector<AnchorEntry>& table,
                                          AnchorUse use) {
  std::vector<std::size_t> positions;
  for (std::size_t i = 0; i < set.size(); ++i)
    if (table[set.anchors[i]].use == use) positions.push_back(i);
  return positions;
}

std::string evidence_note(AnchorUse use, AccuracyReference reference) {
  if (use == AnchorUse::check) {
    return reference == AccuracyReference::truth
               ? "Check anchors against the simulated truth: their survey did not enter the model."
               : "Check anchors: their survey did not enter the model. The noise of the survey itself is in the "
                 "differences.";
  }
  return reference == AccuracyReference::truth ? "Control anchors carry their own survey observation and are better "
                                                 "known than an anchor without one: this says "
                                                 "nothing about unsurveyed anchors."
                                               : "The model was fitted to these anchors. Moving cameras and points "
                                                 "together changes no image residual, so the fit "
                                                 "makes the vertical residuals of control sum to zero, and the "
                                                 "cumulative drift (2) vanishes by construction, however "
                                                 "wrong the model is in between.";
}

/// Control that the model was adjusted without: photographs and other control contradict what the survey says of it.
bool is_left_out(const Evaluation& evaluation, const AnchorEntry& anchor) {
  return anchor.use == AnchorUse::control && evaluation.inputs.not_adjusted_to.contains(anchor.id);
}

/// Its height may agree by chance. How far it is off stays to be read; what of it is right nobody knows.
void take_back_verdict(AnchorAccuracyT& anchor) {
  anchor.note = "left out of the adjustment as control: the photographs contradict its survey";
  if (!anchor.survey) return;
  anchor.survey->verdict = anchor.survey->verdict_distance = ToleranceVerdict::undecided;
  anchor.survey->conformance_probability = std::nan("");
}

/// Set: one that is kept, or one that is used up.
template <typename Set>
void add_comparison(Evaluation& evaluation, Set&& all, AnchorUse use, AccuracyReference reference) {
  const auto& table = evaluation.inputs.anchors;
  const auto listed = std::count_if(table.begin(), table.end(), [use](const AnchorEntry& a) { return a.use == use; });
  if (listed == 0) return;
  const bool check = use == AnchorUse::check;
  std::vector<std::size_t> positions = positions_of_use(all, table, use);
  if (reference == AccuracyReference::survey)
    std::erase_if(positions, [&](std::size_t i) { return is_left_out(evaluation, table[all.anchors[i]]); });
  const bool evidence = check && !positions.empty();
  auto comparison =
      std::make_unique<AccuracyComparisonT>(compare(std::forward<Set>(all).subset(positions), table, evaluation.options,
                                                    check || evaluation.options.drift_on_control));
  comparison->use = use;
  comparison->reference = reference;
  comparison->anchors_listed = static_cast<int>(listed);
  comparison->evidence = evidence;
  comparison->evidence_note = evidence_note(use, reference);
  evaluation.result.comparisons.push_back(std::move(comparison));
}

/// A check anchor that was surveyed wrongly is named; the uncertainties are told to be too small only if the others
/// say so, too.
void name_contradicting_checks(Evaluation& evaluation, const DifferenceSet& survey) {
  const std::vector<std::string> words = words_of_contradicting(evaluation.result);
  if (words.empty()) return;
  for (const std::string& text : words) evaluation.warn(text);
  std::set<std::string> wrong;
  for (const AnchorAccuracyT* anchor : contradicting_checks(evaluation.result)) wrong.insert(anchor->id);
  const auto& table = evaluation.inputs.anchors;
  std::vector<std::size_t> others = positions_of_use(survey, table, AnchorUse::check);
  std::erase_if(others, [&](std::size_t i) { return wrong.contains(table[survey.anchors[i]].id); });
  const AccuracyComparisonT rest = compare(survey.subset(others), table, evaluation.options, false);
  const ErrorConsistencyT* test = rest.consistency_3d.get();
  evaluation.other_checks_hold = !test || !(test->statistic > chi_squared_quantile(0.999, test->degrees_of_freedom));
}

/// 3 x 3 block, or 0 x 0.
Eigen::MatrixXd block_of(const DifferenceSet& set, std::size_t i) {
  if (set.covariance.size() == 0) return {};
  return set.covariance.block(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(i));
}

void attach(Evaluation& evaluation, const DifferenceSet& set,
            std::unique_ptr<AnchorDifferenceT> AnchorAccuracyT::*member) {
  for (std::size_t i = 0; i < set.size(); ++i)
    (*evaluation.result.anchors[set.anchors[i]]).*member = anchor_difference(
        set.difference.segment<3>(3 * static_cast<Eigen::Index>(i)), block_of(set, i), evaluation.options);
}

void add_anchor_rows(Evaluation& evaluation) {
  for (const AnchorEntry& entry : evaluation.inputs.anchors) {
    auto row = std::make_unique<AnchorAccuracyT>();
    row->id = entry.id, row->floor = entry.floor, row->column = entry.column, row->row = entry.row,
    row->use = entry.use;
    const auto place = [&](const PointSet& points, const PointIndex& index) {
      const auto found = index.find(entry.id);
      if (found == index.end() || !points.positions[found->second].allFinite()) return;
      const Eigen::Vector3d& p = points.positions[found->second];
      row->x = p.x(), row->y = p.y(), row->z = p.z();
    };
    place(evaluation.survey, evaluation.survey_index);
    place(evaluation.model, evaluation.model_index);
    if (!evaluation.inputs.model_is_survey)
      row->note = missing(entry.id, evaluation.model, evaluation.model_index, evaluation.survey,
                          evaluation.survey_index, "survey");
    else if (!std::isfinite(row->x))
      row->note = "not surveyed";
    evaluation.result.anchors.push_back(std::move(row));
  }
}

/// Surveyed points that no anchor has the name of, but almost: " The survey has F02-C02-RI: is that F02-C02-R1?"
std::string near_misses(const std::vector<std::string>& unmeasured, const std::vector<std::string>& surveyed,
                        const std::set<std::string>& listed) {
  const auto one_letter = [](const std::string& a, const std::string& b) {
    if (a.size() == b.size()) {
      int differ = 0;
      for (std::size_t i = 0; i < a.size(); ++i) differ += std::tolower(a[i]) != std::tolower(b[i]);
      return differ <= 1;
    }
    const std::string &longer = a.size() > b.size() ? a : b, &shorter = a.size() > b.size() ? b : a;
    if (longer.size() != shorter.size() + 1) return false;
    for (std::size_t i = 0; i < longer.size(); ++i)
      if (longer.substr(0, i) + longer.substr(i + 1) == shorter) return true;
    return false;
  };
  std::string text;
  for (const std::string& anchor : unmeasured)
    for (const std::string& point : surveyed)
      if (!listed.count(point) && one_letter(anchor, point))
        text += " The survey has " + point + ": is that " + anchor + "?";
  return text;
}

void warn_of_gaps(Evaluation& evaluation) {
  std::vector<std::string> unmeasured, unlisted;
  std::set<std::string> listed;
  for (const auto& anchor : evaluation.result.anchors) {
    listed.insert(anchor->id);
    const bool surveyed = evaluation.inputs.model_is_survey ? std::isfinite(anchor->x) : anchor->survey != nullptr;
    if (!surveyed) unmeasured.push_back(anchor->id);
  }
  listed.insert(evaluation.inputs.ties.begin(), evaluation.inputs.ties.end());
  for (const std::string& id : evaluation.model.ids)
    if (!listed.count(id)) unlisted.push_back(id);
  if (!unmeasured.empty())
    evaluation.warn(std::to_string(unmeasured.size()) + " of " + std::to_string(evaluation.result.anchors.size()) +
                    " anchors were not measured and are in no mean: " + list_of(unmeasured) + "." +
                    near_misses(unmeasured,
                                evaluation.inputs.model_is_survey ? evaluation.model.ids : evaluation.survey.ids,
                                listed));
  // Marks, control and set-ups are points of a network too.
  if (!unlisted.empty() && !evaluation.inputs.model_is_survey)
    evaluation.warn("The model holds points that the anchor table does not list; they were not evaluated: " +
                    list_of(unlisted) + ".");
  const std::vector<int> floors = floors_of(evaluation.inputs.anchors);
  if (!floors.empty() && floors.front() != 1)
    evaluation.warn("The lowest floor of the anchor table is " + std::to_string(floors.front()) +
                    ": cumulative drift starts there, not at floor 1.");
}

void warn_of_evidence(Evaluation& evaluation) {
  bool evidence = false;
  for (const auto& comparison : evaluation.result.comparisons) {
    evidence = evidence || (comparison->evidence && comparison->reference == AccuracyReference::survey);
    if (comparison->use == AnchorUse::control && comparison->drift_computed &&
        comparison->reference == AccuracyReference::survey)
      evaluation.warn("D(F) was asked for on control anchors. It is not evidence: " + comparison->evidence_note);
    const ErrorConsistencyT* test = comparison->consistency_3d.get();
    // At the level of the intervals one sound campaign in twenty fails; a warning is for what is certain.
    const bool is_survey = comparison->reference == AccuracyReference::survey;
    if (is_survey && evaluation.other_checks_hold) continue;
    if (comparison->evidence && test && test->statistic > chi_squared_quantile(0.999, test->degrees_of_freedom))
      evaluation.warn(std::string("The errors of the check anchors against the ") +
                      (comparison->reference == AccuracyReference::truth ? "truth" : "survey") +
                      " are larger than their covariance allows (chi-square test): the stated uncertainties are too "
                      "small, and with "
                      "them the guard bands of the verdicts.");
  }
  if (evaluation.inputs.model_is_survey)
    evaluation.warn(
        evaluation.inputs.of_photographs
            ? "The anchors were measured in photographs alone: nothing here is evidence of their accuracy but the "
              "block's own redundancy. Measure some anchors with a total station."
            : "The anchors were measured by total station alone: nothing here is evidence of its accuracy but the "
              "network's own redundancy. Measure some anchors again from other set-ups, or in photographs.");
  else if (!evidence)
    evaluation.warn(
        "No check anchor was evaluated: nothing here is evidence of accuracy. Withhold some anchors from the "
        "adjustment, "
        "at least one on every floor.");
}

}  // namespace

std::vector<double> default_tolerances() {
  std::vector<double> tolerances;
  for (int half_mm = 4; half_mm <= 16; ++half_mm) tolerances.push_back(half_mm / 2000.0);
  return tolerances;
}

AccuracyT evaluate_accuracy(Inputs inputs, const Options& options) {
  check_options(options);
  check_table(inputs.anchors);
  Evaluation evaluation{inputs, options, {}, {}, {}, {}, {}, {}};
  if (options.tolerances.empty()) evaluation.options.tolerances = default_tolerances();
  evaluation.model_index = index_points(inputs.model, "model");
  evaluation.survey_index = index_points(inputs.survey, "survey");
  evaluation.model = usable(std::move(inputs.model), "model", evaluation);
  evaluation.survey = usable(std::move(inputs.survey), "survey", evaluation);

  AccuracyT& result = evaluation.result;
  result.tau = options.tau, result.guard_factor = options.guard_factor, result.confidence = options.confidence;
  result.anchors_needed = anchors_needed(0.95, options.confidence);
  add_anchor_rows(evaluation);
  if (inputs.model_is_survey) {
    result.correlation_note = inputs.of_photographs
                                  ? "The anchors were measured in photographs alone: there is no second measurement."
                                  : "The anchors were measured by total station alone: there is no second measurement.";
  } else {
    DifferenceSet survey = against_survey(evaluation);
    // What is joint of all points is large, and is not asked again.
    evaluation.survey.covariance = {};
    if (!inputs.truth) evaluation.model.covariance = {};
    attach(evaluation, survey, &AnchorAccuracyT::survey);
    for (std::size_t i = 0; i < inputs.anchors.size(); ++i)
      if (is_left_out(evaluation, inputs.anchors[i])) take_back_verdict(*result.anchors[i]);
    add_comparison(evaluation, survey, AnchorUse::check, AccuracyReference::survey);
    if (options.name_contradicting_checks) name_contradicting_checks(evaluation, survey);
    add_comparison(evaluation, std::move(survey), AnchorUse::control, AccuracyReference::survey);
  }
  if (inputs.truth) {
    evaluation.truth_index = index_points(*inputs.truth, "truth");
    DifferenceSet truth = against_exact(evaluation, *inputs.truth, evaluation.truth_index, "truth");
    attach(evaluation, truth, &AnchorAccuracyT::truth);
    add_comparison(evaluation, truth, AnchorUse::check, AccuracyReference::truth);
    add_comparison(evaluation, std::move(truth), AnchorUse::control, AccuracyReference::truth);
  }
  warn_of_gaps(evaluation);
  for (const auto& doubts : {floor_doubts(result), space_doubts(result)})
    for (const std::string& doubt : doubts) evaluation.warn(doubt);
  warn_of_evidence(evaluation);
  return std::move(evaluation.result);
}

}  // namespace plumbline::judgement
