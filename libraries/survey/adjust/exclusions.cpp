#include "survey/adjust/exclusions.hpp"

#include <algorithm>
#include <functional>
#include <set>
#include <stdexcept>

#include "survey/words/network_words.hpp"

namespace plumbline::survey {

namespace {

/// Observations for which `out` says yes go, and what refers to them is renumbered.
SurveyObservations without(const SurveyObservations& survey, const std::function<bool(const Observation&)>& out) {
  SurveyObservations rest = survey;
  std::vector<int> number(survey.observations.size(), -1);
  rest.observations.clear();
  for (size_t i = 0; i < survey.observations.size(); ++i) {
    if (out(survey.observations[i])) continue;
    number[i] = static_cast<int>(rest.observations.size());
    rest.observations.push_back(survey.observations[i]);
  }
  rest.covariances.clear();
  for (const ObservationCovariance& c : survey.covariances) {
    std::vector<int> kept;
    ObservationCovariance part;
    for (int k = 0; k < static_cast<int>(c.indices.size()); ++k) {
      const int i = number.at(c.indices[k]);
      if (i < 0) continue;
      kept.push_back(k);
      part.indices.push_back(i);
    }
    if (kept.empty()) continue;
    part.covariance = c.covariance(kept, kept);
    rest.covariances.push_back(std::move(part));
  }
  return rest;
}

CoordinateGroup part_of(const CoordinateGroup& group, const std::set<std::string>& points) {
  CoordinateGroup part = group;
  std::vector<int> kept;
  part.components.clear();
  for (int k = 0; k < static_cast<int>(group.components.size()); ++k) {
    const auto& c = group.components[k];
    if (points.contains(c.point)) continue;
    part.components.push_back(c);
    kept.push_back(k);
  }
  part.values = group.values(kept).eval();
  part.covariance = group.covariance(kept, kept).eval();
  return part;
}

VectorGroup part_of(const VectorGroup& group, const std::set<std::string>& points) {
  VectorGroup part = group;
  std::vector<int> kept;
  part.vectors.clear();
  for (int k = 0; k < static_cast<int>(group.vectors.size()); ++k) {
    const auto& v = group.vectors[k];
    if (points.contains(v.from) || points.contains(v.to)) continue;
    part.vectors.push_back(v);
    for (int axis = 0; axis < 3; ++axis) kept.push_back(3 * k + axis);
  }
  part.values = group.values(kept).eval();
  part.covariance = group.covariance(kept, kept).eval();
  return part;
}

/// "job.gsi:57" is line 57 of any file whose path ends in job.gsi; "57" of any file.
bool is_at(const SourcePosition& at, const std::string& what) {
  const size_t colon = what.rfind(':');
  const std::string file = colon == std::string::npos ? "" : what.substr(0, colon);
  const std::string line = colon == std::string::npos ? what : what.substr(colon + 1);
  if (at.line <= 0 || line != std::to_string(at.line)) return false;
  if (file.empty() || at.file == file) return true;
  return at.file.size() > file.size() && at.file.ends_with(file) && at.file[at.file.size() - file.size() - 1] == '/';
}

SurveyObservations without_set_up(const SurveyObservations& survey, const std::string& id) {
  SurveyObservations rest =
      without(survey, [&](const Observation& o) { return o.set_up >= 0 && survey.set_ups.at(o.set_up).id == id; });
  std::erase_if(rest.local_coordinates,
                [&](const LocalCoordinate& c) { return c.set_up >= 0 && survey.set_ups.at(c.set_up).id == id; });
  return rest;
}

size_t readings_of(const SurveyObservations& s) {
  size_t n = s.observations.size() + s.local_coordinates.size();
  for (const auto& g : s.coordinates) n += g.components.size();
  for (const auto& g : s.vectors) n += g.vectors.size();
  return n;
}

/// Known by the files of the survey themselves.
bool is_known(const SurveyObservations& survey, const std::string& id) {
  const bool keyed_in = std::any_of(survey.points.begin(), survey.points.end(), [&](const Point& p) {
    return p.id == id && (std::find(p.known.begin(), p.known.end(), true) != p.known.end() ||
                          std::find(p.roles.begin(), p.roles.end(), CoordinateRole::fixed) != p.roles.end());
  });
  return keyed_in || std::any_of(survey.coordinates.begin(), survey.coordinates.end(), [&](const CoordinateGroup& g) {
           return g.is_control && std::any_of(g.components.begin(), g.components.end(),
                                              [&](const auto& component) { return component.point == id; });
         });
}

/// What was known of a point is an approximate value now.
SurveyObservations without_known(SurveyObservations survey, const std::string& id) {
  for (Point& p : survey.points) {
    if (p.id != id) continue;
    std::fill(p.known.begin(), p.known.end(), false);
    for (CoordinateRole& role : p.roles)
      if (role == CoordinateRole::fixed || role == CoordinateRole::constrained) role = CoordinateRole::free;
  }
  for (CoordinateGroup& g : survey.coordinates)
    if (g.is_control) g = part_of(g, std::set<std::string>{id});
  std::erase_if(survey.coordinates, [](const CoordinateGroup& g) { return g.components.empty(); });
  return survey;
}

const char* kind_words(ExcludedItem::Kind kind) {
  switch (kind) {
    case ExcludedItem::Kind::point:
      return "point";
    case ExcludedItem::Kind::set_up:
      return "set-up";
    case ExcludedItem::Kind::control:
      return "control";
    default:
      return "line";
  }
}

}  // namespace

ExcludedItem parse_exclusion(const std::string& text) {
  const auto wrong = [&](const std::string& what) {
    return std::invalid_argument(
        "exclude: found '" + text + "', " + what +
        "; expected 'point A7: reason', 'set-up S3: reason', 'line job.gsi:57: reason' or 'control G1: "
        "reason'");
  };
  ExcludedItem e;
  const size_t blank = text.find(' ');
  const std::string kind = text.substr(0, blank);
  if (kind == "point")
    e.kind = ExcludedItem::Kind::point;
  else if (kind == "set-up" || kind == "set_up")
    e.kind = ExcludedItem::Kind::set_up;
  else if (kind == "line")
    e.kind = ExcludedItem::Kind::line;
  else if (kind == "control")
    e.kind = ExcludedItem::Kind::control;
  else
    throw wrong("which does not begin with point, set-up, line or control");
  const size_t colon = text.find(": ");
  if (blank == std::string::npos || colon == std::string::npos || colon <= blank + 1)
    throw wrong("which has no reason after ': '");
  e.what = text.substr(blank + 1, colon - blank - 1);
  e.reason = text.substr(colon + 2);
  if (e.reason.find_first_not_of(' ') == std::string::npos) throw wrong("whose reason is empty");
  return e;
}

SurveyObservations without_points(const SurveyObservations& survey, const std::vector<std::string>& points) {
  const std::set<std::string> out(points.begin(), points.end());
  SurveyObservations rest = without(survey, [&](const Observation& o) {
    return out.contains(o.from) || out.contains(o.to) || (!o.second_to.empty() && out.contains(o.second_to));
  });
  std::erase_if(rest.points, [&](const Point& p) { return out.contains(p.id); });
  for (CoordinateGroup& g : rest.coordinates) g = part_of(g, out);
  std::erase_if(rest.coordinates, [](const CoordinateGroup& g) { return g.components.empty(); });
  for (VectorGroup& g : rest.vectors) g = part_of(g, out);
  std::erase_if(rest.vectors, [](const VectorGroup& g) { return g.vectors.empty(); });
  std::erase_if(rest.local_coordinates, [&](const LocalCoordinate& c) {
    return out.contains(c.point) || (c.set_up >= 0 && out.contains(rest.set_ups.at(c.set_up).station));
  });
  return rest;
}

ControlPoints without_excluded(const ControlPoints& control, const std::vector<ExcludedItem>& exclude) {
  std::vector<Eigen::Index> kept;
  ControlPoints rest;
  for (size_t i = 0; i < control.ids.size(); ++i) {
    if (std::any_of(exclude.begin(), exclude.end(), [&](const ExcludedItem& e) {
          return e.kind == ExcludedItem::Kind::control && e.what == control.ids[i];
        }))
      continue;
    rest.ids.push_back(control.ids[i]);
    for (Eigen::Index k = 0; k < 3; ++k) kept.push_back(static_cast<Eigen::Index>(3 * i) + k);
  }
  if (kept.size() == 3 * control.ids.size()) return control;
  rest.coordinates = control.coordinates(kept);
  if (control.covariance.size() > 0) rest.covariance = control.covariance(kept, kept);
  return rest;
}

SurveyObservations without_excluded(const SurveyObservations& survey, const std::vector<ExcludedItem>& exclude,
                                    const ControlPoints& control, std::vector<Finding>& findings) {
  SurveyObservations rest = survey;
  for (const ExcludedItem& e : exclude) {
    const size_t before = readings_of(rest), points = rest.points.size();
    std::vector<std::string> concerned;
    if (e.kind == ExcludedItem::Kind::point) {
      rest = without_points(rest, {e.what});
      concerned = {e.what};
    } else if (e.kind == ExcludedItem::Kind::set_up) {
      rest = without_set_up(rest, e.what);
    } else {
      rest = without(rest, [&](const Observation& o) { return is_at(o.source, e.what); });
      std::erase_if(rest.local_coordinates, [&](const LocalCoordinate& c) { return is_at(c.source, e.what); });
    }
    if (e.kind == ExcludedItem::Kind::control) {
      if (!is_known(rest, e.what) && std::find(control.ids.begin(), control.ids.end(), e.what) == control.ids.end())
        throw NetworkError("exclude: control " + e.what + " is no known point of the survey");
      rest = without_known(rest, e.what);
      findings.push_back({Finding::Severity::note,
                          "excluded: control " + e.what + ", whose known coordinates hold nothing: " + e.reason,
                          {e.what},
                          Finding::Subject::exclusion});
      continue;
    }
    const size_t count = before - readings_of(rest);
    const std::string what = std::string(kind_words(e.kind)) + " " + e.what;
    if (count == 0 && points == rest.points.size())
      throw NetworkError("exclude: " + what + " is not in the survey, or all of it is excluded already");
    findings.push_back({Finding::Severity::note,
                        "excluded: " + what + " (" + std::to_string(count) + (count == 1 ? " reading" : " readings") +
                            "): " + e.reason,
                        concerned, Finding::Subject::exclusion});
  }
  return rest;
}

}  // namespace plumbline::survey
