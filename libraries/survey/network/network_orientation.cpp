// What turns a network about the vertical where its observations do not: a stated orientation, or nothing.
#include <algorithm>
#include <cmath>
#include <set>

#include "survey/model/observation_equations.hpp"
#include "survey/network/network_model_steps.hpp"

namespace plumbline::survey {

void tell_orientation(NetworkModel& m) {
  std::vector<size_t> known;
  for (size_t i = 0; i < m.ids.size(); ++i)
    if (m.roles[i][0] != CoordinateRole::unused && !m.initial[i].head<2>().array().isNaN().any()) known.push_back(i);
  const auto elsewhere = [&](size_t i) { return (m.initial[i] - m.initial[known.front()]).head<2>().norm() > 0.01; };
  if (known.empty() || std::any_of(known.begin(), known.end(), elsewhere)) return;
  const bool north = std::any_of(m.observations.begin(), m.observations.end(), [](const MeanObservation& mean) {
    return mean.observation.kind == ObservationKind::azimuth;
  });
  const bool others = m.survey.coordinates.size() > m.keyed_in.size();  // observed, beside the one known point
  if (north || !m.survey.vectors.empty() || others || m.survey.set_ups.empty()) return;
  const SetUp* oriented = nullptr;
  for (const SetUp& s : m.survey.set_ups)
    if (!oriented && !std::isnan(s.stated_orientation)) oriented = &s;
  std::string text;
  if (oriented) {
    text = "the network is oriented by what the file states of set-up " + oriented->id + " (" +
           place(oriented->source) + "), and by nothing measured: only " + m.ids[known.front()] + " is known";
  } else {
    text = "the orientation is free: only " + m.ids[known.front()] +
           " is known and no backsight, azimuth or orientation is given; the zero of the circle of set-up " +
           m.survey.set_ups.front().id + " was taken as north. Give a second known point, or a backsight";
  }
  m.findings.insert(m.findings.begin(), {oriented ? Finding::Severity::note : Finding::Severity::warning, text, {}});
}

void hold_stated_orientation(NetworkModel& m) {
  constexpr double kHeld = 1e-7;  // [rad]
  if (m.datum == DatumMode::inner || !m.survey.vectors.empty()) return;
  std::set<std::string> held;
  for (size_t i = 0; i < m.ids.size(); ++i)
    if (m.roles[i][0] == CoordinateRole::fixed) held.insert(m.ids[i]);
  for (const CoordinateGroup& g : m.survey.coordinates)
    for (const auto& c : g.components)
      if (c.axis < 2) held.insert(c.point);
  const MeanObservation* first = nullptr;
  for (const MeanObservation& mean : m.observations) {
    const Observation& o = mean.observation;
    if (o.kind == ObservationKind::azimuth) return;
    if (!first && o.kind == ObservationKind::direction && !std::isnan(m.survey.set_ups[o.set_up].stated_orientation))
      first = &mean;
  }
  if (held.size() != 1 || !first) return;
  Observation azimuth = first->observation;
  const SetUp& set_up = m.survey.set_ups[azimuth.set_up];
  azimuth.kind = ObservationKind::azimuth;
  azimuth.value = wrap_angle(azimuth.value + set_up.stated_orientation);
  azimuth.sigma = kHeld;
  azimuth.set_up = azimuth.pointing = -1;
  azimuth.corrections.push_back("stated orientation of set-up " + set_up.id + ", held");
  MeanObservation mean;
  mean.members = {static_cast<int>(m.survey.observations.size())};
  mean.observation = azimuth;
  m.survey.observations.push_back(azimuth);
  m.observations.push_back(std::move(mean));
}

}  // namespace plumbline::survey
