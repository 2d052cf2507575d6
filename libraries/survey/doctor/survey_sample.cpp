#include "survey/doctor/survey_sample.hpp"

#include <algorithm>
#include <map>
#include <set>
#include <vector>

namespace plumbline::survey {

std::string SurveySample::in_words() const {
  return is_whole() ? "" : " (tried on " + std::to_string(taken) + " of " + std::to_string(of) + " set-ups)";
}

SurveySample sample_of(const SurveyObservations& survey, int set_up, std::size_t most) {
  SurveySample sample;
  sample.set_up = set_up;
  std::vector<std::set<std::string>> points(survey.set_ups.size());
  std::vector<std::size_t> readings(survey.set_ups.size());
  std::map<std::string, std::vector<int>> views;
  std::size_t all = 0;
  for (const Observation& o : survey.observations) {
    if (o.set_up < 0) continue;
    const auto s = static_cast<std::size_t>(o.set_up);
    ++readings[s], ++all;
    if (points[s].insert(o.to).second) views[o.to].push_back(o.set_up);
  }
  sample.of = static_cast<std::size_t>(std::count_if(readings.begin(), readings.end(), [](auto n) { return n > 0; }));
  sample.taken = sample.of;
  if (all <= most) {
    sample.survey = survey;
    return sample;
  }
  std::vector<std::size_t> shared(survey.set_ups.size());  // points in common with those taken
  if (set_up < 0) {
    for (std::size_t s = 0; s < points.size(); ++s)
      for (const std::string& id : points[s]) shared[s] += views.at(id).size() - 1;
    set_up = static_cast<int>(std::max_element(shared.begin(), shared.end()) - shared.begin());
    std::fill(shared.begin(), shared.end(), 0);
  }
  constexpr std::size_t fewest = 3;  // one alone agrees with itself, whatever is undone
  std::vector<char> taken(survey.set_ups.size(), 0);
  std::set<std::string> known;
  sample.taken = 0;
  for (std::size_t count = 0, next = static_cast<std::size_t>(set_up);;) {
    taken[next] = 1, ++sample.taken, count += readings[next];
    for (const std::string& id : points[next])
      if (known.insert(id).second)
        for (const int s : views.at(id)) ++shared[s];
    std::size_t best = taken.size();
    for (std::size_t s = 0; s < taken.size(); ++s)
      if (!taken[s] && shared[s] > 0 && (best == taken.size() || shared[s] > shared[best])) best = s;
    if (best == taken.size() || (count >= most && sample.taken >= fewest)) break;
    next = best;
  }
  sample.survey.info = survey.info;
  sample.survey.points = survey.points;
  sample.survey.set_ups = survey.set_ups;
  sample.survey.instruments = survey.instruments;
  for (const Observation& o : survey.observations)
    if (o.set_up >= 0 && taken[o.set_up]) sample.survey.observations.push_back(o);
  return sample;
}

}  // namespace plumbline::survey
