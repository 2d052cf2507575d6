#include "survey/model/station_reduction.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <set>
#include <tuple>

#include "survey/model/circle_steps.hpp"
#include "survey/model/observation_equations.hpp"

namespace plumbline::survey {

namespace {

/// In face 1: direction - pi, 2 pi - zenith angle.
double reduced_to_face_1(const Observation& o) {
  if (o.face != 2) return o.value;
  if (o.kind == ObservationKind::direction) return o.value - std::numbers::pi;
  if (o.kind == ObservationKind::zenith_angle)
    return o.value > std::numbers::pi ? 2 * std::numbers::pi - o.value : o.value;
  return o.value;
}

bool is_angular(ObservationKind kind) {
  return kind == ObservationKind::direction || kind == ObservationKind::zenith_angle ||
         kind == ObservationKind::angle || kind == ObservationKind::azimuth;
}

std::string in_words(double value, ObservationKind kind) {
  return is_angular(kind) ? fmt::format("{:.1f} mgon", value / kMgon) : fmt::format("{:.1f} mm", value * 1e3);
}

const char* kind_word(ObservationKind kind) {
  switch (kind) {
    case ObservationKind::direction:
      return "direction";
    case ObservationKind::zenith_angle:
      return "zenith angle";
    case ObservationKind::slope_distance:
      return "slope distance";
    case ObservationKind::horizontal_distance:
      return "horizontal distance";
    case ObservationKind::height_difference:
      return "height difference";
    case ObservationKind::angle:
      return "angle";
    case ObservationKind::azimuth:
      return "azimuth";
  }
  return "";
}

using Key = std::tuple<int, ObservationKind, std::string, std::string, std::string, double, double>;

Key key_of(const Observation& o) {
  return {o.set_up, o.kind, o.from, o.to, o.second_to, or_zero(o.instrument_height), or_zero(o.target_height)};
}

using CircleOffsets = std::map<std::pair<int, int>, double>;

/// The median of the differences if most of them agree with it; 0 otherwise. One target in common cannot tell a turned
/// circle from a wrong reading.
double common_turn(std::vector<double> differences) {
  constexpr double kAgree = 2e-3;  // [rad]
  if (differences.size() < 2) return 0;
  const auto middle = differences.begin() + static_cast<std::ptrdiff_t>(differences.size() / 2);
  std::nth_element(differences.begin(), middle, differences.end());
  const double turn = *middle;
  const auto agreeing =
      std::count_if(differences.begin(), differences.end(), [&](double d) { return std::abs(d - turn) < kAgree; });
  return 2 * static_cast<size_t>(agreeing) > differences.size() ? turn : 0;
}

/// Offsets of the circle between sets: median over the targets a set has in common with those before it.
/// A circle that was not touched gives offsets of a few seconds, which are noise and must stay in the means.
CircleOffsets circle_offsets(const SurveyObservations& survey, const std::vector<double>& turned) {
  constexpr double kTouched = 0.01;  // [rad]
  std::map<std::pair<int, int>, std::vector<const Observation*>> sets;
  for (const Observation& o : survey.observations)
    if (o.kind == ObservationKind::direction && o.set_number > 0) sets[{o.set_up, o.set_number}].push_back(&o);
  const auto on_one_circle = [&](const Observation* o) {
    return reduced_to_face_1(*o) - turned[o - survey.observations.data()];
  };
  CircleOffsets offsets;
  std::map<std::pair<int, std::string>, double> reference;
  for (const auto& [set, directions] : sets) {
    std::vector<double> differences;
    for (const Observation* o : directions) {
      const auto known = reference.find({o->set_up, o->to});
      if (known != reference.end()) differences.push_back(wrap_angle(on_one_circle(o) - known->second));
    }
    double offset = common_turn(differences);
    if (std::abs(offset) < kTouched) offset = 0;
    offsets[set] = offset;
    for (const Observation* o : directions) reference.try_emplace({o->set_up, o->to}, on_one_circle(o) - offset);
  }
  return offsets;
}

/// Length and steepness of each sighting, for what pointing errors do to its angles: by set-up and pointing.
struct SightLength {
  double length = 0, sin_zenith = 1;
};

std::map<std::pair<int, int>, SightLength> sights_of(const SurveyObservations& survey) {
  std::map<std::pair<int, int>, SightLength> sights;
  for (const Observation& o : survey.observations) {
    if (o.set_up < 0 || o.pointing < 0) continue;
    SightLength& sight = sights[{o.set_up, o.pointing}];
    if (o.kind == ObservationKind::zenith_angle) sight.sin_zenith = std::abs(std::sin(o.value));
    if (o.kind == ObservationKind::slope_distance || o.kind == ObservationKind::horizontal_distance)
      sight.length = o.value;
  }
  return sights;
}

/// By how much the circle had been turned when each direction was read.
std::vector<double> turned_circle(const SurveyObservations& survey, const std::vector<CircleStep>& steps) {
  std::vector<double> turned(survey.observations.size(), 0);
  for (const CircleStep& step : steps)
    for (size_t i = static_cast<size_t>(step.first); i < turned.size(); ++i)
      if (survey.observations[i].set_up == step.set_up && survey.observations[i].kind == ObservationKind::direction)
        turned[i] += step.turn;
  return turned;
}

std::vector<ReadingGroup> group_readings(const SurveyObservations& survey, const std::vector<double>& turned) {
  std::vector<char> correlated(survey.observations.size(), 0);
  for (const auto& c : survey.covariances)
    for (int i : c.indices) correlated[i] = 1;
  const auto sights = sights_of(survey);
  const CircleOffsets offsets = circle_offsets(survey, turned);
  std::map<Key, size_t> index;
  std::vector<ReadingGroup> groups;
  for (int i = 0; i < static_cast<int>(survey.observations.size()); ++i) {
    const Observation& o = survey.observations[i];
    const bool alone = correlated[i] || !std::isnan(o.sigma) || o.set_up < 0;
    double value = reduced_to_face_1(o);
    const auto offset = offsets.find({o.set_up, o.set_number});
    if (!alone) value -= turned[i];
    if (!alone && o.kind == ObservationKind::direction && offset != offsets.end()) value -= offset->second;
    size_t at = groups.size();
    if (!alone) at = index.try_emplace(key_of(o), at).first->second;
    if (at == groups.size()) {
      ReadingGroup group;
      group.kind = o.kind;
      group.set_up = o.set_up;
      group.alone = alone;
      group.origin = value;
      if (const auto sight = sights.find({o.set_up, o.pointing}); sight != sights.end()) {
        group.length = sight->second.length;
        group.sin_zenith = sight->second.sin_zenith;
      }
      groups.push_back(std::move(group));
    }
    ReadingGroup& group = groups[at];
    const double from_origin = is_angular(o.kind) ? wrap_angle(value - group.origin) : value - group.origin;
    group.readings.push_back({i, o.face, from_origin});
  }
  return groups;
}

double average(const std::vector<double>& list) {
  double sum = 0;
  for (double v : list) sum += v;
  return list.empty() ? 0.0 : sum / static_cast<double>(list.size());
}

class Reducer {
 public:
  explicit Reducer(const SurveyObservations& survey) : survey_(survey) {}
  MeanResult run();

 private:
  MeanObservation mean_of(const ReadingGroup& group, const std::vector<Reading>& readings) const;
  void take_out_instrument_error(const ReadingGroup& group, const std::vector<Reading>& readings,
                                 std::vector<double> (&values)[3], std::vector<std::string>& corrections) const;
  void reduce(const ReadingGroup& group, const GroupVerdict& verdict);
  void tell_removed(const ReadingGroup& group, const Reading& reading, double difference, size_t others);
  void tell_separate(const ReadingGroup& group);
  void tell_knocked(const std::vector<ReadingGroup>& groups, const std::vector<GroupVerdict>& verdicts);
  void tell_instrument();
  std::string name(const Reading& reading) const {
    const Observation& o = survey_.observations[reading.observation];
    return std::string(kind_word(o.kind)) + " " + o.from + " -> " + o.to;
  }
  std::string at(const Reading& reading) const { return place(survey_.observations[reading.observation].source); }

  const SurveyObservations& survey_;
  MeanResult result_;
};

/// Readings in one face have the instrument's error in them, which the set-up's pairs may know.
void Reducer::take_out_instrument_error(const ReadingGroup& group, const std::vector<Reading>& readings,
                                        std::vector<double> (&values)[3], std::vector<std::string>& corrections) const {
  const bool direction = group.kind == ObservationKind::direction;
  if (group.set_up < 0 || readings.front().face == 0) return;
  if (!direction && group.kind != ObservationKind::zenith_angle) return;
  const InstrumentErrors& errors = result_.instrument[group.set_up];
  if (!(direction ? errors.has_collimation() : errors.has_index())) return;
  for (auto& list : values) list.clear();
  for (const Reading& r : readings) values[r.face].push_back(without_instrument_error(group, r, errors));
  corrections.push_back(std::string(direction ? "collimation " : "index ") +
                        in_words(direction ? errors.collimation : errors.index, group.kind) +
                        " of the set-up taken out");
}

MeanObservation Reducer::mean_of(const ReadingGroup& group, const std::vector<Reading>& readings) const {
  MeanObservation mean;
  mean.observation = survey_.observations[readings.front().observation];
  Observation& first = mean.observation;
  std::vector<double> values[3];  // by face
  for (const Reading& r : readings) {
    mean.members.push_back(r.observation);
    values[r.face].push_back(r.value);
  }
  const bool both = !values[1].empty() && !values[2].empty();
  if (first.face == 2 || both) first.corrections.push_back(both ? "mean of both faces" : "face 2 reduced");
  if (!both && !group.alone) take_out_instrument_error(group, readings, values, first.corrections);
  // The mean of the two face means: with unequal counts the errors of the instrument still cancel.
  std::vector<double> sets;
  if (both) {
    const size_t pairs = std::max(values[1].size(), values[2].size());
    for (size_t k = 0; k < pairs; ++k)
      sets.push_back(0.5 * ((k < values[1].size() ? values[1][k] : average(values[1])) +
                            (k < values[2].size() ? values[2][k] : average(values[2]))));
    first.value = group.origin + 0.5 * (average(values[1]) + average(values[2]));
  } else {
    for (const auto& list : values) sets.insert(sets.end(), list.begin(), list.end());
    first.value = group.origin + average(sets);
    mean.single_face = is_angular(first.kind) && !values[1].empty() + !values[2].empty() == 1;
  }
  mean.sets = static_cast<int>(sets.size());
  double squares = 0;
  for (double v : sets) squares += (v - average(sets)) * (v - average(sets));
  if (sets.size() > 1) mean.spread = std::sqrt(squares / static_cast<double>(sets.size() - 1));
  if (mean.sets > 1) first.corrections.push_back("mean of " + std::to_string(mean.sets) + " sets");
  first.face = both ? 0 : first.face;
  return mean;
}

void Reducer::tell_removed(const ReadingGroup& group, const Reading& reading, double difference, size_t others) {
  result_.removed.push_back({reading.observation, difference});
  result_.warnings.push_back(name(reading) + " (" + at(reading) + ") differs by " + in_words(difference, group.kind) +
                             " from the " + std::to_string(others) +
                             " other readings of that target and is left out; look at that line");
}

void Reducer::tell_separate(const ReadingGroup& group) {
  double least = group.readings.front().value, most = least;
  std::string lines;
  bool faces = false;
  for (const Reading& r : group.readings) {
    least = std::min(least, r.value);
    most = std::max(most, r.value);
    lines += (lines.empty() ? "" : ", ") + at(r);
    faces = faces || r.face != group.readings.front().face;
  }
  // Where the instrument's error is taken for something that half of the targets do not show, equal faces stand out.
  std::string than = ", far more than noise, and";
  if (faces && group.set_up >= 0 && group.readings.size() == 2) {
    const InstrumentErrors& e = result_.instrument[group.set_up];
    const auto free = [&](size_t i) { return without_instrument_error(group, group.readings[i], e); };
    if (std::abs(free(1) - free(0)) > 2 * (most - least))
      than = ", those of most others of the set-up by about " +
             in_words(std::abs(free(1) - free(0)) - (most - least), group.kind) + ", and";
  }
  result_.warnings.push_back(std::string(faces ? "the faces of " : "the readings of ") + name(group.readings.front()) +
                             " differ by " + in_words(most - least, group.kind) + " (" + lines + ")" + than +
                             " no third reading says which is wrong: they are not averaged, "
                             "the network tests each; "
                             "check the point number and these lines");
}

void Reducer::reduce(const ReadingGroup& group, const GroupVerdict& verdict) {
  if (verdict.separate) {
    tell_separate(group);
    for (const Reading& r : group.readings) result_.observations.push_back(mean_of(group, {r}));
    return;
  }
  std::vector<Reading> kept;
  for (size_t i = 0; i < group.readings.size(); ++i)
    if (!verdict.removed[i]) kept.push_back(group.readings[i]);
  for (size_t i = 0; i < group.readings.size(); ++i)
    if (verdict.removed[i]) tell_removed(group, group.readings[i], verdict.differences[i], kept.size());
  result_.observations.push_back(mean_of(group, kept));
}

void Reducer::tell_instrument() {
  constexpr double kAdjustIt = 20 * kMgon;
  for (const InstrumentErrors& e : result_.instrument) {
    if (!e.has_collimation() && !e.has_index()) continue;
    const auto one = [](const char* what, double value, double sigma, int pairs) {
      return fmt::format("{} {:.2f} mgon (sigma {:.2f}, {} pairs)", what, value / kMgon, sigma / kMgon, pairs);
    };
    std::string text = "instrument in set-up " + survey_.set_ups[e.set_up].id + ": ";
    if (e.has_collimation()) text += one("collimation", e.collimation, e.collimation_sigma, e.direction_pairs);
    if (e.has_index())
      text += (e.has_collimation() ? ", " : "") + one("vertical index", e.index, e.index_sigma, e.zenith_pairs);
    result_.notes.push_back(text);
    if (std::abs(e.collimation) > kAdjustIt || std::abs(e.index) > kAdjustIt)
      result_.warnings.push_back(text +
                                 ": large; means of both faces are free of it, determine it anew in the instrument");
  }
}

/// One reading in a set-up may be wrong; where a third of what was read twice does not repeat, the set-up moved.
void Reducer::tell_knocked(const std::vector<ReadingGroup>& groups, const std::vector<GroupVerdict>& verdicts) {
  constexpr size_t kFewest = 3, kOneIn = 3;
  struct Targets {
    std::set<std::string> twice, apart;
  };
  std::map<int, Targets> of_set_up;
  for (size_t g = 0; g < groups.size(); ++g) {
    if (groups[g].set_up < 0 || groups[g].alone || groups[g].readings.size() < 2) continue;
    const std::string& to = survey_.observations[groups[g].readings.front().observation].to;
    of_set_up[groups[g].set_up].twice.insert(to);
    if (verdicts[g].separate) of_set_up[groups[g].set_up].apart.insert(to);
  }
  for (const auto& [set_up, targets] : of_set_up)
    if (targets.apart.size() >= kFewest && kOneIn * targets.apart.size() >= targets.twice.size())
      result_.knocked.push_back("set-up " + survey_.set_ups[set_up].id + ": of " +
                                std::to_string(targets.twice.size()) + " targets that were read twice " +
                                std::to_string(targets.apart.size()) +
                                " do not repeat: it was knocked between its rounds, or readings of two places of the "
                                "instrument have one name");
  result_.warnings.insert(result_.warnings.begin(), result_.knocked.begin(), result_.knocked.end());
}

MeanResult Reducer::run() {
  const std::vector<CircleStep> steps = circle_steps(survey_);
  for (const CircleStep& step : steps) result_.warnings.push_back(in_words(step, survey_));
  const std::vector<ReadingGroup> groups = group_readings(survey_, turned_circle(survey_, steps));
  result_.instrument = estimate_instrument_errors(groups, static_cast<int>(survey_.set_ups.size()));
  const std::vector<GroupVerdict> verdicts = test_readings(groups, result_.instrument);
  for (size_t g = 0; g < groups.size(); ++g) reduce(groups[g], verdicts[g]);
  tell_knocked(groups, verdicts);
  tell_instrument();
  return std::move(result_);
}

}  // namespace

MeanResult mean_observations(const SurveyObservations& survey) { return Reducer(survey).run(); }

}  // namespace plumbline::survey
