#include "series_node.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <set>

#include "artifacts/input_files_text.hpp"
#include "artifacts/survey_artifact.hpp"
#include "network_artifact.hpp"
#include "network_memory.hpp"
#include "network_trust.hpp"
#include "series_files.hpp"
#include "survey/adjust/adjust_network.hpp"
#include "survey/epochs/check_control.hpp"
#include "survey/epochs/epoch_mistakes.hpp"
#include "survey/epochs/epoch_names.hpp"
#include "survey/epochs/epoch_scale.hpp"
#include "survey/words/network_words.hpp"

namespace plumbline::survey {

namespace {

/// Instrument stations that no sight leads to stand elsewhere every time.
std::set<std::string> stations_without_mark(const plumbline::survey::SurveyObservations& survey) {
  std::set<std::string> stations;
  for (const SetUp& s : survey.set_ups) stations.insert(s.station);
  for (const Observation& o : survey.observations) stations.erase(o.to), stations.erase(o.second_to);
  return stations;
}

/// Of the points that are told, where the first epoch that has them saw them.
std::vector<std::string> notes_of_temperature(const EpochSeries& series, const std::vector<DatedEpoch>& dated) {
  std::vector<Eigen::Vector3d> places, sigmas;
  for (const SeriesPoint& p : series.points) {
    const Epoch& first = dated.at(p.first).epoch;
    const auto at = std::find(first.ids.begin(), first.ids.end(), p.id);
    if (at != first.ids.end())
      places.push_back(first.coordinates.segment<3>(3 * static_cast<Eigen::Index>(at - first.ids.begin())));
    for (const SeriesPoint::At& seen : p.at) sigmas.push_back(seen.sigma);
  }
  return size_notes(std::nullopt, places, sigmas);
}

FileT series_file(const char* name, const char* media_type, const std::string& text) {
  FileT file;
  file.name = name;
  file.media_type = media_type;
  file.content.assign(text.begin(), text.end());
  return file;
}

std::string name_of(const SurveyObservations& survey, size_t number) {
  return survey.files.empty() ? "epoch " + std::to_string(number + 1) : survey.files.front();
}

/// Throws where two epochs are one measurement: a file under two names.
void require_own_readings(const std::vector<SurveyObservations>& surveys) {
  std::vector<std::vector<EpochReading>> readings;
  for (const SurveyObservations& survey : surveys) readings.push_back(readings_of(survey));
  if (const auto same = find_one_measurement(std::move(readings)))
    throw std::runtime_error(one_measurement_in_words(name_of(surveys[same->first], same->first),
                                                      name_of(surveys[same->second], same->second)));
}

/// Marks of an adjusted network with their joint covariance; a station that stands elsewhere every time is none.
Epoch marks_of(const SurveyObservations& survey, const NetworkResult& r) {
  Epoch all;
  std::vector<char> keep;
  const std::set<std::string> stations = stations_without_mark(survey);
  all.covariance = r.full_covariance();
  all.coordinates.resize(all.covariance.rows());
  for (size_t k = 0; k < r.points.size(); ++k) {
    all.ids.push_back(r.points[k].id);
    keep.push_back(!stations.contains(r.points[k].id));
    all.coordinates.segment<3>(static_cast<Eigen::Index>(3 * k)) = r.points[k].position;
  }
  return part_of(all, keep);
}

/// Of each epoch the day in the head of its file, where there is one.
struct Dates {
  std::vector<std::optional<double>> days;

  bool ascend() const {
    for (size_t i = 0; i < days.size(); ++i)
      if (!days[i] || (i > 0 && !(*days[i] > *days[i - 1]))) return false;
    return true;
  }
  /// Throws where an epoch is dated before the one that stands in front of it.
  void require_oldest_first(const std::vector<DatedEpoch>& dated, const std::vector<std::string>& labels) const {
    for (size_t i = 1; i < days.size(); ++i)
      if (days[i] && days[i - 1] && *days[i] < *days[i - 1])
        throw std::runtime_error(
            "by the dates in their heads " + dated[i].name + " (" + labels[i] + ") is older than " + dated[i - 1].name +
            " (" + labels[i - 1] +
            "): name the files oldest first, or give days=[0, 30, ...] if the dates are not those of "
            "the measurement");
  }
};

/// Times of the epochs: the days that were given, else those of the files, else their numbers.
void set_times(Context& context, const std::vector<double>& given, const Dates& dates, std::vector<DatedEpoch>& dated,
               SeriesText& text) {
  if (given.empty()) dates.require_oldest_first(dated, text.labels);
  const bool by_dates = given.empty() && dates.ascend();
  text.unit = !given.empty() || by_dates ? "day" : "epoch";
  for (size_t i = 0; i < dated.size(); ++i)
    text.times.push_back(dated[i].time = !given.empty() ? given[i]
                                         : by_dates     ? *dates.days[i] - *dates.days[0]
                                                        : static_cast<double>(i + 1));
  if (text.unit == "epoch")
    context.warn(
        "the files do not say when they were measured, or not apart from each other: velocities are per epoch; give "
        "days=[0, 30, ...]");
  if (!by_dates) return;
  std::string taken;
  for (const double time : text.times) taken += (taken.empty() ? "" : ", ") + fixed_digits(time, 0);
  context.warn("velocities are by the dates in the heads of the files (days " + taken +
               "), which of exports (JobXML, LandXML) are those of the export: give days=[0, 30, ...] if it was "
               "measured on others");
}

/// What a mistake in one epoch explains of its difference from the first, told before any point moves.
void note_mistakes(const std::vector<DatedEpoch>& dated, SeriesText& text) {
  ComparisonOptions options;
  options.alpha = text.options.alpha, options.alpha0 = text.options.alpha0;
  options.free_motions = text.options.free_motions;
  for (size_t k = 1; k < dated.size(); ++k) {
    if (common_scale(dated[0].epoch, dated[k].epoch)) continue;
    options.first_variance = dated[0].variance, options.second_variance = dated[k].variance;
    const Comparison compared = compare_epochs(dated[0].epoch, dated[k].epoch, options);
    const auto mistake = find_epoch_mistake(dated[0].epoch, dated[k].epoch, options, compared);
    if (!mistake) continue;
    text.is_explained = true;
    text.notes.push_back(text.labels[k] + " (second) beside " + text.labels[0] + " (first): " + mistake->words +
                         "; the movements and velocities of this series hold it");
  }
}

/// Scales that epochs do not share with the first one; throws where one is of another unit.
void note_scales(const std::vector<DatedEpoch>& dated, SeriesText& text) {
  for (size_t k = 1; k < dated.size(); ++k) {
    const auto scale = common_scale(dated[0].epoch, dated[k].epoch);
    if (!scale) continue;
    if (std::abs(*scale - 1) > kImpossibleScale)
      throw std::runtime_error(dated[k].name + " beside " + dated[0].name + ": " + scale_in_words(*scale) +
                               "; read it in its unit, these are no movements");
    for (const std::string& note : size_notes(scale, {}, {}))
      text.notes.push_back(text.labels[k] + " beside " + text.labels[0] + ": " + note);
  }
}

/// What was found, on the terminal and as metrics.
void tell(Context& context, const EpochSeries& result, const SeriesText& text) {
  if (result.degrees_of_freedom > 0)
    context.warn(result.variances);
  else
    context.info(result.variances);
  for (const std::string& words : result.not_followed) context.warn(words);
  for (const std::string& words : result.not_compared) context.warn(words);
  for (const std::string& id : result.contradicted)
    context.warn("point '" + id +
                 "' was named to carry the datum (stable), and has itself moved against most of the others beyond "
                 "chance: all movements here are against it as if it had not");
  int told = 0, alarms = 0;
  for (const SeriesPoint& p : result.points) {
    alarms += p.latest_alarm() != Level::below;
    if (const std::string words = in_words(p, text); !words.empty()) ++told, context.warn(words);
  }
  context.metric("points_told", told, "1");
  context.metric("alarms", alarms, "1");
}

}  // namespace

NetworkResult EpochSeriesNode::adjusted(Context& context, const SurveyObservations& survey,
                                        const std::string& name) const {
  AdjustOptions options;
  std::string remark;
  options.profile = chosen_profile(survey.info.instrument, remark);
  options.instruments = further_instruments(survey.instruments);
  options.datum = *datum == "free" ? DatumMode::inner : DatumMode::automatic;
  options.map = *map, options.geoid = geoid(), options.mean_height = *mean_height;
  options.largest_whole = std::numeric_limits<int>::max();  // epochs are compared with their joint covariance
  if (!remark.empty()) context.warn(name + ": " + remark);
  NetworkResult r = adjust_network(survey, options);
  if (r.validity == Validity::invalid) throw std::runtime_error(name + " is no epoch to compare: " + r.verdict);
  if (r.validity != Validity::sound) context.warn(name + ": " + r.verdict);
  if (r.defect > 4)
    throw std::runtime_error(name + " is free in " + std::to_string(r.defect) +
                             " motions: epochs without a vertical or a scale are not compared");
  return r;
}

std::string EpochSeriesNode::words_of_evidence() const {
  std::optional<InputFilesT> read, left;
  if (inputs) read = inputs.unpack();
  if (unread) left = unread.unpack();
  return words_of_inputs(read ? &*read : nullptr, left ? &*left : nullptr);
}

void EpochSeriesNode::run(Context& context) {
  if (epochs.size() < 2)
    throw std::runtime_error("a series needs two epochs at least, 'epochs' has " + std::to_string(epochs.size()));
  if (!days->empty() && days->size() != epochs.size())
    throw std::runtime_error("'days' has " + std::to_string(days->size()) + " values, and there are " +
                             std::to_string(epochs.size()) + " epochs");
  std::vector<SurveyObservations> surveys;
  for (size_t i = 0; i < epochs.size(); ++i) surveys.push_back(from_artifact(epochs.unpack(i)));
  announce_memory(context, series_memory(surveys));
  require_own_readings(surveys);
  SeriesText text;
  text.options.alpha = *alpha, text.options.alpha0 = *alpha0, text.options.stable = *stable;
  text.options.warning_level = *warning_level, text.options.alarm_level = *alarm_level;
  std::vector<DatedEpoch> dated;
  Dates dates;
  bool untrusted = false;
  int largest = 0, smallest = std::numeric_limits<int>::max();  // rank defects
  for (const SurveyObservations& survey : surveys) {
    const std::string name = name_of(survey, dated.size());
    const NetworkResult r = adjusted(context, survey, name);
    SurveyNetworkT network = to_network_artifact(r, {});
    // Epochs that nothing controls by themselves (one station, lists of coordinates) are tested against each other.
    untrusted = untrusted || (r.degrees_of_freedom > 0 && proves_nothing(network));
    largest = std::max(largest, r.defect), smallest = std::min(smallest, r.defect);
    DatedEpoch& epoch = dated.emplace_back();
    epoch.name = name;
    epoch.variance = {r.sigma0, r.degrees_of_freedom, r.variance_factor != 1};
    epoch.epoch = marks_of(survey, r);
    dates.days.push_back(day_of_date(survey.info.date));
    text.labels.push_back(survey.info.date.empty() ? name : survey.info.date);
  }
  // Three of a network of plan positions are two shifts and a turn, of one in space three shifts.
  text.options.free_motions = merged_motions(largest, smallest, dated.front().epoch);
  set_times(context, *days, dates, dated, text);
  note_scales(dated, text);
  note_mistakes(dated, text);
  const EpochSeries result = epoch_series(dated, text.options);
  if (result.bodies_are_rivals) text.notes.insert(text.notes.begin(), result.two_bodies);
  for (const std::string& note : text.notes) context.warn(note);
  // Of a settling corner it is said, and nothing is asked.
  if (!result.two_bodies.empty() && !result.bodies_are_rivals) text.notes.push_back(result.two_bodies);
  // What 10 K do is no finding: page and verdict have it.
  for (const std::string& note : notes_of_temperature(result, dated)) text.notes.push_back(note);
  tell(context, result, text);
  context.metric("invalid", untrusted ? 1 : 0, "1");
  series.commit(series_file("series.json", "application/json", series_as_json(result, text)));
  table.commit(series_file("series.csv", "text/csv", series_as_csv(result, text)));
  page.commit(series_file("series.html", "text/html", series_as_html(result, text)));
  verdict.commit(series_file("verdict.txt", "text/plain", series_verdict(result, text) + words_of_evidence()));
}

}  // namespace plumbline::survey
