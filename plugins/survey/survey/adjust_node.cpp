#include "adjust_node.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <set>

#include "artifacts/fitted_datum.hpp"
#include "artifacts/input_files_text.hpp"
#include "artifacts/survey_artifact.hpp"
#include "network_artifact.hpp"
#include "network_memory.hpp"
#include "network_trust.hpp"
#include "survey/adjust/exclusions.hpp"
#include "survey/adjust/left_out_control.hpp"
#include "survey/doctor/network_doctor.hpp"
#include "survey/epochs/check_control.hpp"
#include "survey/start/alike_names.hpp"
#include "survey/start/merge_surveys.hpp"
#include "tables.hpp"

namespace plumbline::survey {

namespace {

constexpr double kArcsecond = std::numbers::pi / 180 / 3600;

DatumMode datum_mode(const std::string& name) {
  if (name == "file") return DatumMode::file;
  if (name == "fixed") return DatumMode::fixed;
  if (name == "weighted") return DatumMode::weighted;
  if (name == "inner") return DatumMode::inner;
  return DatumMode::automatic;
}

Switch to_switch(const std::string& name) {
  return name == "on" ? Switch::on : name == "off" ? Switch::off : Switch::automatic;
}

/// Which profile stands for how many readings; several instruments have one each.
std::string stochastic_model(const plumbline::survey::SurveyObservations& survey, const AdjustOptions& options) {
  std::map<std::string, size_t> readings, centred;  // by the profile in words
  for (const auto& o : survey.observations) {
    if (!std::isnan(o.sigma) && !o.without_centring) continue;
    const auto own =
        o.instrument < 0 ? options.instruments.end() : options.instruments.find(survey.instruments[o.instrument]);
    const std::string profile = in_words(own == options.instruments.end() ? options.profile : own->second);
    ++(std::isnan(o.sigma) ? readings : centred)[profile];
  }
  std::string text;
  for (const auto& [profile, count] : readings)
    text += (text.empty() ? "" : "; ") + profile + "; used for " + std::to_string(count) + " of " +
            std::to_string(survey.observations.size()) + " readings, whose files give no standard deviation";
  for (const auto& [profile, count] : centred)
    text += (text.empty() ? "" : "; ") + profile + "; its centring is added to " + std::to_string(count) + " of " +
            std::to_string(survey.observations.size()) + " readings, whose files give standard deviations without it";
  return text;
}

std::string instruments_in_words(const plumbline::survey::SurveyObservations& survey) {
  std::string text = survey.info.instrument;
  for (const std::string& name : survey.instruments)
    if (name != survey.info.instrument) text += (text.empty() ? "" : ", ") + name;
  if (!survey.info.instrument_serial.empty()) text += ", no. " + survey.info.instrument_serial;
  return text;
}

/// Each marker with its nearest four, as the tables have them, and what else is wanted.
std::vector<std::pair<size_t, size_t>> chosen_pairs(const NetworkResult& r, const std::vector<std::string>& wanted) {
  constexpr int kNeighbours = 4;
  std::vector<std::string> ids;
  std::vector<Eigen::Vector3d> positions;
  std::set<std::string> stations;
  for (const ResultPoint& p : r.points) ids.push_back(p.id), positions.push_back(p.position);
  for (const ResultSetUp& s : r.set_ups) stations.insert(s.station);
  std::vector<std::pair<size_t, size_t>> pairs = neighbouring_markers(ids, positions, stations, kNeighbours);
  for (const std::string& text : wanted) {
    const auto [a, b] = split_pair(text);
    const auto number = [&](const std::string& id) {
      const auto at = std::find(ids.begin(), ids.end(), id);
      if (at == ids.end()) throw std::runtime_error("the pair '" + text + "': no point '" + id + "' in the network");
      return static_cast<size_t>(at - ids.begin());
    };
    pairs.emplace_back(number(a), number(b));
  }
  return pairs;
}

/// Measured values, as readers count them: what is known of coordinates is none.
int readings_of(const std::vector<SurveyObservations>& surveys) {
  size_t n = 0;
  for (const SurveyObservations& s : surveys) {
    n += s.observations.size() + s.local_coordinates.size();
    for (const VectorGroup& group : s.vectors) n += group.vectors.size();
  }
  return static_cast<int>(n);
}

std::string without_joint_covariance(const NetworkResult& r) {
  return "the covariance is that of each point and of neighbouring markers (" + std::to_string(r.unknowns) +
         " unknowns): `points` has no joint one, covariance=full makes it (" +
         std::to_string(72 * r.points.size() * r.points.size() >> 20U) + " MiB), pairs=[...] that of further pairs" +
         (r.cofactors.is_whole() ? ""
                                 : "; the effect of an undetected blunder is that on the points of its own reading");
}

}  // namespace

AdjustOptions AdjustNode::options() const {
  AdjustOptions o;
  o.datum = datum_mode(*datum);
  o.datum_points = *datum_points;
  o.alpha = *alpha;
  o.alpha0 = *alpha0;
  o.power = *power;
  o.remove_blunders = *remove_blunders;
  o.removal_alpha = *removal_alpha;
  o.largest_removed_share = *largest_removed_share;
  for (const std::string& text : *exclude) o.exclude.push_back(parse_exclusion(text));
  o.robust_start = *robust_start;
  o.estimate_variance_components = *variance_components;
  o.scale_with_sigma0 = to_switch(*scale_with_sigma0);
  o.curvature = to_switch(*curvature);
  o.refraction_coefficient = *refraction_coefficient;
  o.scale_sigma = *scale_sigma * 1e-6;
  o.additive_constant_sigma = *additive_constant_sigma;
  o.refraction_sigma = *refraction_sigma;
  o.vertical_index_sigma = *vertical_index_sigma * kArcsecond;
  o.tilt_sigma = *tilt_sigma * kArcsecond;
  o.instrument_height_sigma = *instrument_height_sigma;
  o.coordinates_are_tested = *coordinates == "tested";
  o.known_sigma = *known_sigma;
  o.map = *map;
  o.geoid = geoid();
  o.mean_height = *mean_height;
  o.centring_per_set_up = *centring == "set_up";
  if (*covariance == "full") o.largest_whole = std::numeric_limits<int>::max();
  return o;
}

namespace {

/// What was found when the files were joined may be why the network cannot be adjusted: then it is said before the
/// failure, which has no result to say it in.
NetworkResult adjust_or_say(Context& context, const MergedSurvey& merged, const AdjustOptions& options,
                            const ControlPoints& known) {
  try {
    return adjust_network(merged.survey, options, known);
  } catch (const NetworkError&) {
    for (const Finding& finding : merged.findings)
      if (finding.severity != Finding::Severity::note) context.warn(finding.text);
    throw;
  }
}

}  // namespace

void AdjustNode::run(Context& context) {
  std::vector<SurveyObservations> surveys;
  for (size_t i = 0; i < observations.size(); ++i) surveys.push_back(from_artifact(observations.unpack(i)));
  if (surveys.empty()) throw std::runtime_error("'observations' holds no survey file");
  ControlPoints known;
  if (control) known = control_from_artifact(control.unpack());
  const MergedSurvey merged = merge_surveys(surveys, {known.ids, *same_stations});
  const auto& survey = merged.survey;
  AdjustOptions o = options();
  o.measure_control = true;
  std::string remark;
  o.profile = chosen_profile(survey.info.instrument, remark);
  o.instruments = further_instruments(survey.instruments);
  if (!remark.empty()) context.warn(remark);
  for (const std::string& text : instruments_without_profile(survey.instruments, o.instruments, o.profile))
    context.warn(text);
  refuse_too_large(survey, o.largest_whole);
  announce_network(context, survey, o.largest_whole);
  NetworkResult result = adjust_or_say(context, merged, o, known);
  doubt_failed_control(survey, without_excluded(known, o.exclude), o.known_sigma, result);
  result.left_out_known = compare_with_left_out(survey, known, o, result);
  for (Finding& finding : examine_alike_points(result)) result.findings.push_back(std::move(finding));
  result.findings.insert(result.findings.begin() + result.compares_known_points(), merged.findings.begin(),
                         merged.findings.end());
  std::vector<std::string> otherwise_written = merged.known_by_other_names;
  for (Finding& finding : examine_unread_places(result, known)) {
    for (const std::string& id : finding.points)
      if (std::find(otherwise_written.begin(), otherwise_written.end(), id) == otherwise_written.end())
        otherwise_written.push_back(id);
    result.findings.push_back(std::move(finding));
  }
  doubt_known_names(otherwise_written, result);
  if (result.validity != Validity::sound) context.warn(result.verdict);
  const auto has_height = [](const ResultPoint& p) { return std::isfinite(p.position.z()); };
  if (std::isfinite(*mean_height) &&
      (o.map.empty() || o.map == kPlane || std::all_of(result.points.begin(), result.points.end(), has_height)))
    context.warn("mean_height does nothing here: it is that of points without heights on a map");
  if (o.coordinates_are_tested && !result.without_readings)
    context.warn("coordinates=tested does nothing here: the survey has readings, and these are tested");
  for (const Finding& finding : result.findings)
    if (finding.severity != Finding::Severity::note) context.warn(finding.text);
  // What was decided when the files were read (which of X and Y is east, which stations are one) was said there; it
  // belongs to the result too.
  for (const std::string& text : survey.warnings) result.findings.push_back({Finding::Severity::warning, text, {}});
  context.metric("sigma0", result.sigma0, "1");
  context.metric("degrees_of_freedom", result.degrees_of_freedom, "1");
  const bool joint = *covariance != "neighbours" && result.cofactors.is_whole();
  SurveyNetworkT tables = to_network_artifact(result, o);
  if (!joint) {
    add_covariances(result, chosen_pairs(result, *pairs), tables);
    result.findings.push_back({Finding::Severity::note, without_joint_covariance(result), {}});
    context.info(result.findings.back().text);
    auto note = std::make_unique<NetworkFindingT>();
    note->severity = "note", note->text = result.findings.back().text;
    tables.findings.push_back(std::move(note));
  }
  PointsT adjusted = to_points_artifact(result, joint);
  if (control && result.datum != DatumMode::inner) take_datum(control.unpack(), adjusted);
  points.commit(adjusted);
  measured_control.commit(to_artifact(result.measured_control));
  tables.stochastic_model = stochastic_model(survey, o);
  tables.instrument = instruments_in_words(survey);
  tables.date = survey.info.date;
  tables.files = survey.files, tables.exclusions = *exclude;
  tables.readings = readings_of(surveys);
  tables.readings_left_out = std::max(0, tables.readings - result.readings);
  if (tables.readings_left_out > 0)  // a pipeline without a summary says it, too
    context.info("took part: " + counted_readings(tables.readings, tables.readings_left_out));
  // What nothing tests by itself (a list of coordinates, sights from one station, an epoch) is no survey that failed:
  // who judges by it says that nothing tested it.
  const bool untested = result.degrees_of_freedom == 0 && result.validity != Validity::invalid;
  context.metric("invalid", !untested && proves_nothing(tables) ? 1 : 0, "1");
  network.commit(tables);
}

}  // namespace plumbline::survey
