#include "survey/start/stations_apart.hpp"

#include <algorithm>
#include <map>
#include <set>

#include "base/text/text.hpp"
#include "survey/model/station_identity.hpp"

namespace plumbline::survey {

namespace {

/// Marks: somebody knows them, or sighted them, so that their name is theirs.
std::set<std::string> marks_of(const SurveyObservations& survey, const std::vector<std::string>& known) {
  std::set<std::string> marks(known.begin(), known.end());
  for (const Observation& o : survey.observations) marks.insert({o.to, o.second_to});
  for (const LocalCoordinate& c : survey.local_coordinates) marks.insert(c.point);
  for (const CoordinateGroup& g : survey.coordinates)
    for (const auto& c : g.components) marks.insert(c.point);
  for (const VectorGroup& g : survey.vectors)
    for (const auto& v : g.vectors) marks.insert({v.from, v.to});
  for (const Point& p : survey.points)
    for (size_t k = 0; k < 3; ++k)
      if (p.known[k] || p.roles[k] > CoordinateRole::free) marks.insert(p.id);
  return marks;
}

std::string free_name(const SurveyObservations& survey, const std::string& station) {
  for (int n = 2;; ++n) {
    const std::string name = station + "/" + std::to_string(n);
    if (std::none_of(survey.points.begin(), survey.points.end(), [&](const Point& p) { return p.id == name; }))
      return name;
  }
}

/// The set-up, and those of `like` it that stand where it does, on a point of their own.
void move_to(SurveyObservations& survey, int set_up, const std::string& name) {
  survey.set_ups[set_up].station = name;
  for (Observation& o : survey.observations)
    if (o.set_up == set_up) o.from = name;
}

}  // namespace

std::vector<Finding> part_stations(SurveyObservations& survey, const std::vector<std::string>& known) {
  constexpr double kElsewhere = 0.05;  // [m]: nobody centres so badly
  std::map<std::string, std::vector<int>> set_ups;
  for (size_t i = 0; i < survey.set_ups.size(); ++i) set_ups[survey.set_ups[i].station].push_back(static_cast<int>(i));
  std::set<std::string> marks;
  std::vector<Finding> findings;
  for (const auto& [station, list] : set_ups) {
    if (list.size() < 2) continue;
    if (marks.empty()) marks = marks_of(survey, known);
    if (marks.contains(station)) continue;
    std::vector<int> places = {list.front()};  // first set-up of each
    for (size_t k = 1; k < list.size(); ++k) {
      double nearest = kNotGiven;
      int same = -1;
      bool apart = true;
      for (const int place : places) {
        const auto [metres, sigma] = how_far_apart(survey, place, list[k]);
        apart = apart && metres > std::max(kElsewhere, 5 * sigma);
        if (metres < kElsewhere) same = place;
        if (!(metres >= nearest)) nearest = metres;
      }
      if (same >= 0 && same != list.front()) move_to(survey, list[k], survey.set_ups[same].station);
      if (!apart) continue;
      const std::string name = free_name(survey, station);
      Point point;
      point.id = name, point.source = survey.set_ups[list[k]].source;
      survey.points.push_back(point);
      move_to(survey, list[k], name);
      places.push_back(list[k]);
      findings.push_back({Finding::Severity::warning,
                          "station " + station + " is occupied twice (" + place(survey.set_ups[list.front()].source) +
                              ", " + place(point.source) + "), and what both see puts them " +
                              text::format_fixed(nearest, 3) + " m" + " apart: they are points of their own, " +
                              station + " and " + name,
                          {station, name}});
    }
  }
  return findings;
}

}  // namespace plumbline::survey
