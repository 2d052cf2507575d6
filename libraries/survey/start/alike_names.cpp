#include "survey/start/alike_names.hpp"

#include <cmath>
#include <map>
#include <set>

#include "base/text/bare_name.hpp"
#include "base/text/composed.hpp"
#include "base/text/words.hpp"
#include "survey/start/measured_names.hpp"

namespace plumbline::survey {

namespace {

constexpr size_t kMostNamed = 8;

/// Points that a file holds, or knows: fixed, part of the datum, keyed in, or with a control's covariance.
std::set<std::string> held_by_file(const SurveyObservations& survey) {
  std::set<std::string> names;
  for (const Point& p : survey.points)
    for (size_t k = 0; k < 3; ++k)
      if (p.known[k] || p.roles[k] > CoordinateRole::free) names.insert(p.id);
  for (const CoordinateGroup& g : survey.coordinates)
    for (const auto& c : g.components)
      if (g.is_control) names.insert(c.point);
  return names;
}

bool is_digit(char c) { return c >= '0' && c <= '9'; }

/// Between two points along the axes that both have [m]; NaN with none.
double distance(const ResultPoint& a, const ResultPoint& b) {
  double sum = kNotGiven;
  for (int k = 0; k < 3; ++k)
    if (const double d = a.position[k] - b.position[k]; !std::isnan(d)) sum = or_zero(sum) + d * d;
  return std::sqrt(sum);
}

}  // namespace

std::set<std::string> measured_names(const SurveyObservations& survey) {
  std::set<std::string> names;
  for (const SetUp& s : survey.set_ups) names.insert(s.station);
  for (const Observation& o : survey.observations)
    for (const std::string* id : {&o.from, &o.to, &o.second_to}) names.insert(*id);
  for (const CoordinateGroup& g : survey.coordinates)
    for (const auto& c : g.components)
      if (!g.is_control) names.insert(c.point);
  for (const VectorGroup& g : survey.vectors)
    for (const auto& v : g.vectors) names.insert({v.from, v.to});
  for (const LocalCoordinate& c : survey.local_coordinates) names.insert(c.point);
  names.erase("");
  return names;
}

std::string folded_name(const std::string& name) {
  static const std::map<std::string, std::string> umlauts = {
      {"Ä", "AE"}, {"ä", "AE"}, {"Ö", "OE"}, {"ö", "OE"}, {"Ü", "UE"}, {"ü", "UE"}, {"ß", "SS"}, {"А", "A"},
      {"В", "B"},  {"Е", "E"},  {"К", "K"},  {"М", "M"},  {"Н", "H"},  {"О", "O"},  {"Р", "P"},  {"С", "C"},
      {"Т", "T"},  {"Х", "X"},  {"Α", "A"},  {"Β", "B"},  {"Ε", "E"},  {"Ζ", "Z"},  {"Η", "H"},  {"Ι", "I"},
      {"Κ", "K"},  {"Μ", "M"},  {"Ν", "N"},  {"Ο", "O"},  {"Ρ", "P"},  {"Τ", "T"},  {"Υ", "Y"},  {"Χ", "X"}};
  const std::string composed = text::composed(name);
  std::string out;
  for (std::size_t i = 0; i < composed.size(); ++i) {
    if (const auto umlaut = umlauts.find(composed.substr(i, 2)); umlaut != umlauts.end()) {
      out += umlaut->second, ++i;
      continue;
    }
    const char c = composed[i];
    const bool beside_digit =
        (!out.empty() && is_digit(out.back())) || (i + 1 < composed.size() && is_digit(composed[i + 1]));
    const bool nought = c == 'O' || c == 'o', one = c == 'I' || c == 'l';
    out += beside_digit && nought ? '0' : beside_digit && one ? '1' : c;
  }
  return text::bare_name(out);
}

std::vector<Finding> examine_known_names(const SurveyObservations& survey, const std::vector<std::string>& known) {
  const std::set<std::string> measured = measured_names(survey);
  const std::set<std::string> given(known.begin(), known.end());
  std::set<std::string> held = held_by_file(survey);
  held.insert(given.begin(), given.end());
  std::map<std::string, std::vector<std::string>> by_fold;
  for (const std::string& id : measured)
    if (!held.contains(id)) by_fold[folded_name(id)].push_back(id);
  std::vector<std::string> alike, points, unread;
  for (const std::string& id : held) {
    if (measured.contains(id)) continue;
    const auto at = by_fold.find(folded_name(id));
    if (at == by_fold.end()) {
      if (given.contains(id)) unread.push_back(id);
      continue;
    }
    alike.push_back(id + " (read is " + text::join(at->second, 2) + ")");
    points.insert(points.end(), at->second.begin(), at->second.end());
  }
  std::vector<Finding> findings;
  if (!alike.empty())
    findings.push_back({Finding::Severity::warning,
                        "known points hold nothing because no reading has their names, only names like them: " +
                            text::join(alike, kMostNamed) + "; where it is one mark, write its name the same way",
                        points});
  if (!unread.empty())
    findings.push_back({Finding::Severity::note,
                        "known points that no reading touches: " + text::join(unread, kMostNamed),
                        {},
                        Finding::Subject::unread});
  return findings;
}

std::vector<Finding> examine_unread_places(const NetworkResult& result, const ControlPoints& known) {
  constexpr double kOneMark = 0.02;  // [m]
  const std::set<std::string> given(known.ids.begin(), known.ids.end());
  std::set<std::string> measured;
  for (const ResultPoint& p : result.points) measured.insert(p.id);
  std::vector<std::string> alike, points;
  for (size_t c = 0; c < known.ids.size(); ++c) {
    if (measured.contains(known.ids[c])) continue;
    ResultPoint mark;
    mark.position = known.coordinates.segment<3>(static_cast<Eigen::Index>(3 * c));
    if (!mark.position.head<2>().allFinite()) continue;
    for (const ResultPoint& p : result.points) {
      const double apart = p.position.head<2>().allFinite() ? distance(mark, p) : kNotGiven;
      if (given.contains(p.id) || !(apart < kOneMark)) continue;
      alike.push_back(known.ids[c] + " (" + text::millimetres(apart) + " from " + p.id + ")");
      points.push_back(p.id);
    }
  }
  if (alike.empty()) return {};
  return {{Finding::Severity::warning,
           "known points that no reading touches lie where a point of another name was read: " +
               text::join(alike, kMostNamed) + "; where it is one mark, write its name the same way",
           points}};
}

std::vector<Finding> examine_alike_points(const NetworkResult& result) {
  constexpr double kOneMark = 0.1;  // [m]
  std::map<std::string, std::vector<const ResultPoint*>> by_fold;
  for (const ResultPoint& p : result.points) by_fold[folded_name(p.id)].push_back(&p);
  std::vector<Finding> findings;
  for (const auto& [fold, points] : by_fold)
    for (size_t i = 0; i < points.size(); ++i)
      for (size_t j = i + 1; j < points.size(); ++j) {
        const double apart = distance(*points[i], *points[j]);
        if (!(apart < kOneMark)) continue;
        findings.push_back({Finding::Severity::warning,
                            points[i]->id + " and " + points[j]->id + " are two points here, and come out " +
                                text::millimetres(apart) +
                                " apart: if they are one mark, write its name the same way everywhere",
                            {points[i]->id, points[j]->id}});
      }
  return findings;
}

}  // namespace plumbline::survey
