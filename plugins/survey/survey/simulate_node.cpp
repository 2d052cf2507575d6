#include "simulate_node.hpp"

#include <cstdint>
#include <numbers>
#include <sstream>
#include <stdexcept>

#include "artifacts/survey_artifact.hpp"
#include "geometry/random.hpp"
#include "network_memory.hpp"
#include "survey/simulate/simulate_survey.hpp"

namespace plumbline::survey {

namespace {

using Kind = SurveyMistake::Kind;

int observation_of(const SurveyObservations& survey, int set_up, const std::string& to, const std::string& what) {
  const ObservationKind kind = what == "direction" ? ObservationKind::direction
                               : what == "zenith"  ? ObservationKind::zenith_angle
                                                   : ObservationKind::slope_distance;
  if (what != "direction" && what != "zenith" && what != "distance") return -1;
  for (size_t i = 0; i < survey.observations.size(); ++i) {
    const Observation& o = survey.observations[i];
    if (o.set_up == set_up && o.to == to && o.kind == kind) return static_cast<int>(i);
  }
  return -1;
}

/// Throws std::runtime_error that says what was found and expected.
SurveyMistake parse_mistake(const std::string& text, const SurveyObservations& survey) {
  constexpr double kGon = std::numbers::pi / 200;
  std::istringstream words(text);
  std::string kind, set_up, what;
  words >> kind >> set_up;
  SurveyMistake m;
  m.set_up = -1;
  for (size_t i = 0; i < survey.set_ups.size(); ++i)
    if (survey.set_ups[i].id == set_up) m.set_up = static_cast<int>(i);
  if (m.set_up < 0) throw std::runtime_error("mistakes: found '" + text + "', but there is no set-up '" + set_up + "'");
  if (kind == "reading") {
    words >> m.first >> what >> m.size;
    m.observation = observation_of(survey, m.set_up, m.first, what);
    if (m.observation < 0)
      throw std::runtime_error("mistakes: found '" + text + "', but " + set_up + " has no " + what + " to " + m.first);
    if (what != "distance") m.size *= kGon;
  } else if (kind == "swap" || kind == "name") {
    m.kind = kind == "swap" ? Kind::swapped_names : Kind::wrong_name;
    words >> m.first >> m.second;
  } else if (kind == "circle" || kind == "moved") {
    m.kind = kind == "circle" ? Kind::turned_circle : Kind::moved_instrument;
    words >> m.from_sight >> m.size;
    --m.from_sight;
    if (kind == "circle") m.size *= kGon;
  } else if (kind == "prism" || kind == "scale" || kind == "height" || kind == "unit") {
    m.kind = kind == "prism"    ? Kind::prism
             : kind == "scale"  ? Kind::scale
             : kind == "height" ? Kind::instrument_height
                                : Kind::unit;
    words >> m.size;
    if (m.kind == Kind::unit && !(m.size > 0)) words.setstate(std::ios::failbit);
  } else {
    throw std::runtime_error("mistakes: found '" + text +
                             "', expected one that begins with reading, swap, name, circle, moved, prism, scale, "
                             "height or unit");
  }
  if (words.fail()) throw std::runtime_error("mistakes: found '" + text + "', a part of it is missing or no number");
  return m;
}

}  // namespace

void SimulateSurveyNode::run(Context& context) {
  const auto planned = set_ups.unpack();
  SurveyLayout layout;
  for (const auto& p : markers.unpack().points) layout.points.push_back({p->id, p->position});
  Random random(context.seed(), "orientations");
  for (const auto& p : planned.points) {
    layout.points.push_back({p->id, p->position});
    SimulatedSetUp s;
    s.id = s.station = p->id;
    s.orientation = random.uniform(0, 2 * std::numbers::pi);
    for (const auto& o : planned.observations)
      if (o->from == p->id) s.sees.push_back(o->to);
    layout.set_ups.push_back(std::move(s));
  }
  if (layout.set_ups.empty()) throw std::runtime_error("'set_ups' holds no set-up");
  SimulationOptions options;
  std::string remark;
  options.profile = chosen_profile(planned.info ? planned.info->instrument : "", remark);
  if (!remark.empty()) context.warn(remark);
  options.sets = static_cast<int>(*sets);
  options.noise = *noise;
  options.coordinates = *coordinates;
  std::uint64_t sights = 0;
  for (const SimulatedSetUp& s : layout.set_ups) sights += s.sees.empty() ? layout.points.size() : s.sees.size();
  announce_memory(context, 2700 * sights);  // three readings each, as they are, packed and written
  SurveyObservations survey = simulate_survey(layout, options, context.seed());
  for (const std::string& text : *mistakes) plant(parse_mistake(text, survey), layout, survey);
  survey.info.format = "simulated";
  survey.info.instrument = options.profile.name;
  observations.commit(to_artifact(survey));
}

}  // namespace plumbline::survey
