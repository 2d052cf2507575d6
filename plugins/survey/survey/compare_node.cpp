#include "compare_node.hpp"

#include <algorithm>
#include <cmath>
#include <set>
#include <sstream>

#include "artifacts/survey_artifact.hpp"
#include "base/text/words.hpp"
#include "ellipsoid_artifact.hpp"
#include "geometry/statistics.hpp"
#include "network_artifact.hpp"
#include "network_memory.hpp"
#include "survey/epochs/check_control.hpp"
#include "survey/epochs/compare_epochs.hpp"
#include "survey/epochs/epoch_mistakes.hpp"
#include "survey/epochs/epoch_names.hpp"
#include "survey/epochs/epoch_scale.hpp"
#include "survey/files/survey_layout.hpp"
#include "survey/start/merge_surveys.hpp"

namespace plumbline::survey {

namespace {

constexpr size_t most_named = 10;

Epoch epoch_of(const PointsT& points, const char* which) {
  const ControlPoints all = control_from_artifact(points);
  if (points.covariance.empty())
    throw std::runtime_error(std::string("'") + which +
                             "' has no covariance; take the points output of survey.adjust, with covariance=full where "
                             "it has more than 4000 unknowns");
  return {all.ids, all.coordinates, all.covariance};
}

EpochVariance variance_of(const PointsT& points, bool applied) {
  if (!points.statistics || !(points.statistics->sigma0 > 0)) return {};
  return {points.statistics->sigma0, static_cast<int>(points.statistics->degrees_of_freedom), applied};
}

int defect_of(const PointsT& points) { return points.statistics ? points.statistics->datum_defect : 0; }

/// Instrument stations that no sight leads to: free set-ups, whose names mean another place in every epoch.
std::set<std::string> unmarked_stations(const SurveyNetworkT& network) {
  std::set<std::string> stations;
  for (const auto& s : network.set_ups) stations.insert(s->station);
  for (const auto& o : network.observations)
    if (!o->from.empty()) stations.erase(o->to);
  return stations;
}

/// Of what was read; a coordinate that is known is the same in every epoch.
std::vector<EpochReading> readings_of(const SurveyNetworkT& network) {
  std::vector<EpochReading> out;
  for (const auto& o : network.observations)
    if (o->kind != "coordinate" && o->kind != "prior")
      out.push_back({o->kind + '\n' + o->from + '\n' + o->to + '\n' + o->detail, o->value});
  return out;
}

std::unique_ptr<PointMovementT> pack(const Movement& m) {
  auto p = std::make_unique<PointMovementT>();
  p->id = m.id;
  p->position = m.position;
  p->movement = m.movement;
  p->sigma = m.sigma;
  p->statistic = m.statistic;
  p->moved = m.moved;
  p->stable = m.stable;
  p->detectable_height = m.detectable_height;
  p->ellipsoid = ellipsoid_artifact(m.id, m.covariance);
  return p;
}

SurveyComparisonT to_artifact(const Comparison& c, const ComparisonOptions& options) {
  SurveyComparisonT out;
  for (const Movement& m : c.movements) out.points.push_back(pack(m));
  out.statistic = c.statistic;
  out.rank = c.rank;
  out.critical = c.critical;
  out.congruent = c.congruent;
  for (const Exclusion& e : c.excluded) {
    auto item = std::make_unique<PointExclusionT>();
    item->id = e.id;
    item->statistic = e.statistic;
    item->critical = e.critical;
    item->alternatives = e.alternatives;
    out.excluded.push_back(std::move(item));
  }
  out.alpha = options.alpha;
  out.alpha0 = options.alpha0;
  out.power = options.power;
  out.critical_point = chi_squared_quantile(1 - options.alpha0, 3);
  out.free_motions = options.free_motions;
  out.only_first = c.only_first;
  out.only_second = c.only_second;
  out.left_out = c.incomplete;
  if (c.variances.critical > 0) {
    out.variance_ratio = c.variances.ratio;
    out.variance_critical = c.variances.critical;
  }
  out.first_factor = c.variances.first_factor;
  out.second_factor = c.variances.second_factor;
  out.variances = c.variances.text;
  return out;
}

std::string tests_in_words(const Comparison& c) {
  std::ostringstream text;
  text.precision(1);
  text << std::fixed << "test statistic " << c.statistic << ", critical value " << c.critical << " at rank " << c.rank;
  return text.str();
}

std::string movement_in_words(const Movement& m) {
  std::ostringstream text;
  text.precision(2);
  std::string separator, sigmas;
  for (int k = 0; k < 3; ++k) {
    if (std::isnan(m.movement[k])) continue;  // a bench mark has a height only
    text << separator << "ENH"[k] << " " << std::showpos << std::fixed << 1000 * m.movement[k] << std::noshowpos;
    std::ostringstream sigma;
    sigma.precision(2);
    sigma << std::fixed << 1000 * m.sigma[k];
    sigmas += separator + sigma.str();
    separator = ", ";
  }
  text << " mm (sigma " << sigmas << " mm)";
  return text.str();
}

std::string alternatives_in_words(const Comparison& c, const std::string& id) {
  for (const Exclusion& e : c.excluded)
    if (e.id == id && !e.alternatives.empty())
      return "; the test cannot tell it from " + text::join(e.alternatives, most_named);
  return "";
}

/// An epoch whose own readings do not agree shows movements of what is wrong in it.
std::string epochs_in_doubt(const SurveyNetworkT& first, const SurveyNetworkT& second) {
  std::string text;
  for (const auto& [name, network] : {std::pair("the first epoch", &first), {"the second epoch", &second}})
    if (network->validity == "doubtful" || network->validity == "invalid")
      text += std::string(text.empty() ? "" : "; ") + name + " by itself is " + network->verdict;
  return text.empty() ? "" : text + ". Mend that first: what is wrong in an epoch looks like movements";
}

ComparisonOptions options_of(double alpha, double alpha0, double power) {
  ComparisonOptions options;
  options.alpha = alpha;
  options.alpha0 = alpha0;
  options.power = power;
  return options;
}

}  // namespace

void CompareEpochsNode::run(Context& context) {
  const PointsT a = first.unpack(), b = second.unpack();
  ComparisonOptions options = options_of(*alpha, *alpha0, *power);
  options.free_motions = merged_motions(defect_of(a), defect_of(b), epoch_of(a, "first"));
  if (*datum == "fixed") options.free_motions = 0;
  if (*datum == "free" && options.free_motions == 0) options.free_motions = 4;
  std::set<std::string> stations;
  if (first_network && second_network) {
    const SurveyNetworkT networks[] = {first_network.unpack(), second_network.unpack()};
    if (are_one_measurement(readings_of(networks[0]), readings_of(networks[1])))
      throw std::runtime_error(one_measurement_in_words("the first", "the second epoch"));
    for (const SurveyNetworkT& network : networks) stations.merge(unmarked_stations(network));
  }
  std::vector<std::string> skipped;
  const auto chosen = [&](const Epoch& epoch) {
    std::vector<char> keep;
    for (const std::string& id : epoch.ids) {
      const bool named =
          std::any_of(points->begin(), points->end(), [&](const auto& p) { return matches_pattern(id, p); });
      keep.push_back(named || (points->empty() && !stations.contains(id)));
      if (points->empty() && stations.contains(id) && std::find(skipped.begin(), skipped.end(), id) == skipped.end())
        skipped.push_back(id);
    }
    return part_of(epoch, keep);
  };
  const Epoch before = chosen(epoch_of(a, "first")), after = chosen(epoch_of(b, "second"));
  const auto scale = common_scale(before, after);
  if (scale && std::abs(*scale - 1) > kImpossibleScale)
    throw std::runtime_error(scale_in_words(*scale) + "; read it in its unit, these are no movements");
  options.first_variance = variance_of(a, first_network ? first_network.unpack().scaled_with_sigma0 : false);
  options.second_variance = variance_of(b, second_network ? second_network.unpack().scaled_with_sigma0 : false);
  Comparison c = compare_epochs(before, after, options);
  const auto mistake = find_epoch_mistake(before, after, options, c);
  const std::string told_mistake = mistake ? mistake->words + ". " + mistake->undone : "";
  if (mistake) {
    context.warn(told_mistake);
    if (mistake->is_undone) c = mistake->comparison, options.free_motions = mistake->free_motions;
  }
  const bool is_explained = mistake && !mistake->is_undone;
  const std::string in_doubt = epochs_in_doubt(first_network ? first_network.unpack() : SurveyNetworkT(),
                                               second_network ? second_network.unpack() : SurveyNetworkT());
  if (!in_doubt.empty()) context.warn(in_doubt);
  const std::vector<std::string> not_followed =
      names_not_followed({{"the first epoch", before.ids}, {"the second epoch", after.ids}});
  for (const std::string& words : not_followed) context.warn(words);
  if (c.variances.degrees_of_freedom > 0) context.warn(c.variances.text);  // else the remark below says it
  SurveyComparisonT out = to_artifact(c, options);
  std::vector<Eigen::Vector3d> places, sigmas;
  for (const Movement& m : c.movements) places.push_back(m.position), sigmas.push_back(m.sigma);
  const auto told_scale = mistake ? std::nullopt : scale;
  out.notes = size_notes(told_scale, places, sigmas);
  if (told_scale) context.warn(out.notes.front());  // what 10 K do is no finding: the page has it
  out.notes.insert(out.notes.begin(), not_followed.begin(), not_followed.end());
  if (mistake) out.notes.insert(out.notes.begin(), told_mistake);
  out.left_out.insert(out.left_out.end(), skipped.begin(), skipped.end());
  const std::string bodies = two_bodies_in_words(c);
  if (!bodies.empty()) out.notes.insert(out.notes.begin(), bodies);
  if (c.bodies_are_rivals()) context.warn(bodies);
  std::vector<std::string> moved;
  for (const Movement& m : c.movements) {
    if (!m.moved) continue;
    moved.push_back(m.id);
    context.warn(
        "point " + m.id +
        (in_doubt.empty() && !is_explained && !c.bodies_are_rivals() ? " has moved: " : " seems to have moved: ") +
        movement_in_words(m) + alternatives_in_words(c, m.id));
  }
  out.remark = (mistake ? told_mistake + "; " : "") + (bodies.empty() ? "" : bodies + "; ") + c.variances.text +
               (c.variances.text.empty() ? "" : "; ") +
               (c.congruent ? "the epochs are congruent: " : "the epochs are not congruent: ") + tests_in_words(c) +
               (moved.empty() ? "; no point has moved significantly" : "; moved: " + text::join(moved, most_named)) +
               (c.only_first.empty() ? "" : "; not in the second epoch: " + text::join(c.only_first, most_named));
  context.info(out.remark);
  comparison.commit(out);
}

void CheckControlNode::run(Context& context) {
  std::vector<SurveyObservations> surveys;
  for (size_t i = 0; i < observations.size(); ++i) surveys.push_back(from_artifact(observations.unpack(i)));
  ControlPoints known;
  if (control) known = control_from_artifact(control.unpack());
  const auto survey = merge_surveys(surveys, {known.ids, *same_stations}).survey;  // survey.adjust says what was united
  AdjustOptions adjustment;
  std::string remark;  // survey.adjust says it
  adjustment.profile = chosen_profile(survey.info.instrument, remark);
  adjustment.instruments = further_instruments(survey.instruments);
  adjustment.map = *map;
  adjustment.geoid = geoid();
  adjustment.mean_height = *mean_height;
  adjustment.remove_blunders = *remove_blunders;
  const ComparisonOptions options = options_of(*alpha, *alpha0, *power);
  MeasuredControl from_network;
  if (measured && !*remove_blunders) from_network = measured_control(measured.unpack());
  if (from_network.ids.empty()) announce_network(context, survey, adjustment.largest_whole);
  const ControlCheck result = check_control(survey, known, adjustment, options, from_network);
  if (!result.cause.empty()) context.warn("the control points do not fit the observations: " + result.cause);
  if (result.problem.empty()) {
    ComparisonOptions used = options;
    used.free_motions = result.free_motions;
    SurveyComparisonT out = to_artifact(result.comparison, used);
    std::vector<std::string> bad;
    for (const Movement& m : result.comparison.movements) {
      if (!m.moved) continue;
      bad.push_back(m.id);
      context.warn("control point " + m.id + " does not fit the observations: measured minus given " +
                   movement_in_words(m) + alternatives_in_words(result.comparison, m.id));
    }
    if (!result.comparison.congruent && bad.empty())
      context.warn("the control points do not fit the observations, and no single one explains it: " +
                   tests_in_words(result.comparison));
    out.remark = (result.comparison.congruent ? "the control points fit the observations: "
                                              : "the control points do not fit the observations: ") +
                 tests_in_words(result.comparison) + (bad.empty() ? "" : "; suspect: " + text::join(bad, most_named));
    context.info(out.remark);
    check.commit(out);
    return;
  }
  SurveyComparisonT out;
  out.congruent = true;
  out.remark = result.problem;
  context.info(out.remark);
  check.commit(out);
}

}  // namespace plumbline::survey
