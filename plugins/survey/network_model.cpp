#include "network_model.hpp"

#include <algorithm>
#include <cmath>
#include <set>
#include <tuple>

namespace plumbline::survey {

namespace {

bool is_free(CoordinateRole role) { return role == CoordinateRole::free || role == CoordinateRole::constrained; }

std::string join(const std::vector<std::string>& ids, size_t most = 12) {
  std::string text;
  for (size_t i = 0; i < ids.size() && i < most; ++i) text += (i ? ", " : "") + ids[i];
  if (ids.size() > most) text += " and " + std::to_string(ids.size() - most) + " more";
  return text;
}

/// Which components of which points the observations touch.
struct Touched {
  std::map<std::string, std::array<bool, 2>> points;  // plan, height
  void plan(const std::string& id) { points[id][0] = true; }
  void height(const std::string& id) { points[id][1] = true; }
  void both(const std::string& id) { points[id] = {true, true}; }
};

Touched touched_points(const NetworkModel& m) {
  Touched t;
  for (const MeanObservation& mean : m.observations) {
    const Observation& o = mean.observation;
    for (const std::string& id : {o.from, o.to, o.second_to}) {
      if (id.empty()) continue;
      if (o.kind == ObservationKind::height_difference)
        t.height(id);
      else if (o.kind == ObservationKind::zenith_angle || o.kind == ObservationKind::slope_distance)
        t.both(id);
      else
        t.plan(id);
    }
  }
  for (const CoordinateGroup& g : m.survey.coordinates)
    for (const auto& c : g.components) c.axis == 2 ? t.height(c.point) : t.plan(c.point);
  for (const VectorGroup& g : m.survey.vectors)
    for (const auto& v : g.vectors) {
      t.both(v.from);
      t.both(v.to);
    }
  for (const LocalCoordinate& c : m.survey.local_coordinates) {
    t.both(m.survey.set_ups.at(c.set_up).station);
    t.both(c.point);
  }
  return t;
}

void add_point(NetworkModel& m, const std::string& id, const Eigen::Vector3d& coordinates,
               const std::array<CoordinateRole, 3>& roles) {
  if (!m.index.try_emplace(id, static_cast<int>(m.ids.size())).second) return;
  m.ids.push_back(id);
  m.initial.push_back(coordinates);
  m.roles.push_back(roles);
}

/// Points that take part, in the order of the file; those nobody observed are left out.
void collect_points(NetworkModel& m) {
  const Touched touched = touched_points(m);
  std::vector<std::string> lonely;
  for (const Point& p : m.survey.points) {
    if (touched.points.contains(p.id))
      add_point(m, p.id, p.coordinates, p.roles);
    else if (p.roles[0] != CoordinateRole::fixed && p.roles[2] != CoordinateRole::fixed)
      lonely.push_back(p.id);
  }
  if (!lonely.empty())
    m.findings.push_back({Finding::Severity::note, "no observation, left out: " + join(lonely), lonely});
  using R = CoordinateRole;
  for (const auto& [id, parts] : touched.points)
    add_point(m, id, Eigen::Vector3d::Constant(kNotGiven), {R::free, R::free, R::free});
  std::vector<std::string> no_height, no_plan;
  for (size_t i = 0; i < m.ids.size(); ++i) {
    const auto& parts = touched.points.at(m.ids[i]);
    if (!parts[1] && is_free(m.roles[i][2])) {
      m.roles[i][2] = R::unused;
      no_height.push_back(m.ids[i]);
    }
    if (!parts[0] && is_free(m.roles[i][0])) {
      m.roles[i][0] = m.roles[i][1] = R::unused;
      no_plan.push_back(m.ids[i]);
    }
  }
  if (!no_height.empty())
    m.findings.push_back({Finding::Severity::note, "no observation of the height of " + join(no_height), no_height});
  if (!no_plan.empty())
    m.findings.push_back({Finding::Severity::note, "no observation of the plan position of " + join(no_plan), no_plan});
}

/// Free stations that were all keyed in with the same coordinates have none.
void distrust_equal_coordinates(NetworkModel& m) {
  for (size_t i = 0; i < m.ids.size(); ++i)
    for (size_t j = i + 1; j < m.ids.size(); ++j) {
      if (!is_free(m.roles[i][0]) || !is_free(m.roles[j][0]) || m.roles[i][2] == CoordinateRole::unused) continue;
      if (!((m.initial[i] - m.initial[j]).norm() < 1e-3)) continue;
      m.findings.push_back(
          {Finding::Severity::warning,
           "points " + m.ids[i] + " and " + m.ids[j] +
               " have the same coordinates in the file; they are computed from the observations instead",
           {m.ids[i], m.ids[j]}});
      m.initial[j].setConstant(kNotGiven);
      m.initial[i].setConstant(kNotGiven);
    }
}

DatumMode choose_datum(const NetworkModel& m, const AdjustOptions& options, const ControlPoints& control) {
  if (options.datum != DatumMode::automatic) return options.datum;
  if (!control.ids.empty()) return control.covariance.size() > 0 ? DatumMode::weighted : DatumMode::fixed;
  for (const auto& roles : m.roles)
    for (CoordinateRole role : roles)
      if (role == CoordinateRole::fixed || role == CoordinateRole::constrained) return DatumMode::file;
  for (const CoordinateGroup& g : m.survey.coordinates)
    if (g.is_control) return DatumMode::file;
  if (!options.datum_points.empty()) return DatumMode::inner;
  // Adjustment programs' own files say what the datum is; if they say nothing that is for the user to decide.
  return m.survey.info.format == "gama-xml" || m.survey.info.format == "krumm" ? DatumMode::file : DatumMode::inner;
}

int require_point(const NetworkModel& m, const std::string& id, const std::string& what) {
  const auto at = m.index.find(id);
  if (at != m.index.end()) return at->second;
  throw NetworkError(what + " '" + id + "' is not observed in this network; observed are " + join(m.ids));
}

void hold(NetworkModel& m, int point) {
  for (int k = 0; k < 3; ++k)
    if (m.roles[point][k] != CoordinateRole::unused) m.roles[point][k] = CoordinateRole::fixed;
  m.datum_points.push_back(m.ids[point]);
}

/// Control points that take part, with their part of the covariance, as observed coordinates.
void add_weighted_control(NetworkModel& m, const ControlPoints& control) {
  if (control.covariance.size() == 0)
    throw NetworkError("datum 'weighted' needs control points with a covariance; without one use datum 'fixed'");
  CoordinateGroup group;
  group.is_control = true;
  std::vector<int> kept;
  for (size_t c = 0; c < control.ids.size(); ++c) {
    const auto at = m.index.find(control.ids[c]);
    if (at == m.index.end()) continue;
    m.datum_points.push_back(control.ids[c]);
    for (int k = 0; k < 3; ++k) {
      const int position = static_cast<int>(3 * c) + k;
      if (m.roles[at->second][k] == CoordinateRole::unused || std::isnan(control.coordinates[position])) continue;
      group.components.push_back({control.ids[c], k});
      kept.push_back(position);
    }
  }
  if (kept.empty()) throw NetworkError("none of the control points (" + join(control.ids) + ") is observed");
  group.values = control.coordinates(kept);
  group.covariance = control.covariance(kept, kept);
  // A free network's covariance is singular in its datum; a micrometre makes it usable and changes nothing else.
  group.covariance.diagonal().array() += 1e-12;
  m.survey.coordinates.push_back(std::move(group));
}

void apply_datum(NetworkModel& m, const AdjustOptions& options, const ControlPoints& control) {
  for (size_t c = 0; c < control.ids.size(); ++c) {
    const auto at = m.index.find(control.ids[c]);
    if (at != m.index.end()) m.initial[at->second] = control.coordinates.segment<3>(static_cast<Eigen::Index>(3 * c));
  }
  m.datum = choose_datum(m, options, control);
  using R = CoordinateRole;
  if (m.datum == DatumMode::inner || m.datum == DatumMode::weighted)
    for (auto& roles : m.roles)
      for (R& role : roles)
        if (role != R::unused) role = R::free;
  if (m.datum == DatumMode::inner) {
    std::vector<std::string> members = options.datum_points.empty() ? m.ids : options.datum_points;
    for (const std::string& id : members)
      for (R& role : m.roles[require_point(m, id, "datum point")])
        if (role == R::free) role = R::constrained;
    m.datum_points = members;
  } else if (m.datum == DatumMode::weighted) {
    add_weighted_control(m, control);
  } else if (m.datum == DatumMode::fixed) {
    const auto& held = options.datum_points.empty() ? control.ids : options.datum_points;
    for (const std::string& id : held)
      if (options.datum_points.empty() ? m.index.contains(id) : true) hold(m, require_point(m, id, "datum point"));
    if (held.empty())
      for (size_t i = 0; i < m.ids.size(); ++i)
        if (m.roles[i][0] == R::fixed || m.roles[i][2] == R::fixed) m.datum_points.push_back(m.ids[i]);
  } else {
    for (size_t i = 0; i < m.ids.size(); ++i)
      if (!is_free(m.roles[i][0]) || !is_free(m.roles[i][2]) || m.roles[i][0] == R::constrained ||
          m.roles[i][2] == R::constrained)
        if (m.roles[i] != std::array<R, 3>{R::unused, R::unused, R::free} &&
            m.roles[i] != std::array<R, 3>{R::free, R::free, R::unused})
          m.datum_points.push_back(m.ids[i]);
  }
}

/// What an observer would say of a point whose coordinates could not be found.
std::string sightings_of(const NetworkModel& m, const std::string& id) {
  std::map<std::string, int> kinds;
  std::set<std::string> others;
  for (const MeanObservation& mean : m.observations) {
    const Observation& o = mean.observation;
    if (o.from != id && o.to != id && o.second_to != id) continue;
    ++kinds[kind_name(o.kind)];
    others.insert(o.from == id ? o.to : o.from);
  }
  std::string text;
  for (const auto& [kind, count] : kinds)
    text += (text.empty() ? "" : ", ") + std::to_string(count) + " " + kind + (count > 1 ? "s" : "");
  return id + " (" + (text.empty() ? "no observation" : text + " with " + join({others.begin(), others.end()}, 4)) +
         ")";
}

void find_approximations(NetworkModel& m) {
  std::map<std::string, Eigen::Vector3d> known;
  for (size_t i = 0; i < m.ids.size(); ++i)
    if (!m.initial[i].array().isNaN().all()) known[m.ids[i]] = m.initial[i];
  const Approximation approximation = approximate_coordinates(m.survey, m.observations, known);
  std::vector<std::string> lost, described;
  for (size_t i = 0; i < m.ids.size(); ++i) {
    const auto at = approximation.points.find(m.ids[i]);
    bool complete = true;
    for (int k = 0; k < 3; ++k) {
      double& value = m.initial[i][k];
      if (m.roles[i][k] == CoordinateRole::unused) {
        value = 0;
        continue;
      }
      if (std::isnan(value) && at != approximation.points.end()) value = at->second[k];
      complete &= !std::isnan(value);
    }
    if (complete) continue;
    lost.push_back(m.ids[i]);
    described.push_back(sightings_of(m, m.ids[i]));
  }
  m.orientations = approximation.orientations;
  if (!lost.empty())
    throw NetworkError("rank defect: the observations do not determine the coordinates of " + join(described) +
                           "; observe them from a second set-up, or with a distance and a zenith angle",
                       {{Finding::Severity::error, "not determined: " + join(lost), lost}});
}

/// Lengths that standard deviations depend on: as measured where the sight has a distance, else from approximate
/// coordinates.
void find_lengths(NetworkModel& m) {
  std::map<std::tuple<int, std::string, double>, Eigen::Vector2d> measured;  // slope, zenith angle
  const auto key = [](const Observation& o) {
    return std::tuple(o.set_up, o.to, std::isnan(o.target_height) ? 0.0 : o.target_height);
  };
  for (const MeanObservation& mean : m.observations) {
    const Observation& o = mean.observation;
    if (o.set_up < 0) continue;
    Eigen::Vector2d& sight = measured.try_emplace(key(o), kNotGiven, kNotGiven).first->second;
    if (o.kind == ObservationKind::slope_distance) sight[0] = o.value;
    if (o.kind == ObservationKind::zenith_angle) sight[1] = o.value;
  }
  for (const MeanObservation& mean : m.observations) {
    const Observation& o = mean.observation;
    const Eigen::Vector3d d = m.initial[m.index.at(o.to)] - m.initial[m.index.at(o.from)];
    Eigen::Vector2d lengths(d.head<2>().norm(), d.norm());
    if (const auto at = measured.find(key(o)); o.set_up >= 0 && at != measured.end() && !at->second.hasNaN())
      lengths = {at->second[0] * std::abs(std::sin(at->second[1])), at->second[0]};
    m.lengths.push_back(lengths.cwiseMax(kShortestHorizontal));
  }
}

/// Observations that cannot be used with the points as they are.
void drop_unusable(NetworkModel& m) {
  m.dropped.assign(m.observations.size(), 0);
  for (size_t i = 0; i < m.observations.size(); ++i) {
    const Observation& o = m.observations[i].observation;
    const int from = m.index.at(o.from), to = m.index.at(o.to);
    const Eigen::Vector3d d = m.initial[to] - m.initial[from];
    const bool needs_plan = o.kind != ObservationKind::height_difference;
    const bool needs_height = o.kind == ObservationKind::height_difference || o.kind == ObservationKind::zenith_angle ||
                              o.kind == ObservationKind::slope_distance;
    std::string reason;
    const auto lacks = [&](int p, int axis) { return m.roles[p][axis] == CoordinateRole::unused; };
    if (from == to) reason = "it sights its own station";
    if (needs_plan && (lacks(from, 0) || lacks(to, 0))) reason = "one end has no plan position";
    if (needs_height && (lacks(from, 2) || lacks(to, 2))) reason = "one end has no height";
    const double h = d.head<2>().norm();
    if (reason.empty() && (o.kind == ObservationKind::direction || o.kind == ObservationKind::azimuth) &&
        h < kShortestHorizontal)
      reason = "the sight is vertical, a direction means nothing there";
    if (reason.empty() && o.kind == ObservationKind::zenith_angle && h < 1e-3) reason = "the sight is exactly vertical";
    if (reason.empty()) continue;
    m.dropped[i] = 1;
    m.findings.push_back({Finding::Severity::warning,
                          kind_name(o.kind) + " " + o.from + " -> " + o.to + " (" + o.source.file + ":" +
                              std::to_string(o.source.line) + ") is not used: " + reason,
                          {o.from, o.to}});
  }
}

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// What the approximate coordinates disagree with an observation, as a length at the target [m].
double misclosure(const NetworkModel& m, const Observation& o, double orientation) {
  const auto or_zero = [](double v) { return std::isnan(v) ? 0.0 : v; };
  const double own = o.set_up >= 0 ? m.survey.set_ups[o.set_up].instrument_height : 0.0;
  const double instrument = or_zero(std::isnan(o.instrument_height) ? own : o.instrument_height);
  const auto sight = [&](const std::string& to, double height) {
    Eigen::Vector3d d = m.initial[m.index.at(to)] - m.initial[m.index.at(o.from)];
    d.z() += or_zero(height) - instrument;
    return d;
  };
  const Eigen::Vector3d d = sight(o.to, o.target_height);
  const double h = d.head<2>().norm(), azimuth = std::atan2(d.x(), d.y());
  switch (o.kind) {
    case ObservationKind::direction:
      return h * wrap_angle(azimuth - orientation - o.value);
    case ObservationKind::azimuth:
      return h * wrap_angle(azimuth - o.value);
    case ObservationKind::angle:
      return 0;
    case ObservationKind::zenith_angle:
      return d.norm() * wrap_angle(std::atan2(h, d.z()) - o.value);
    case ObservationKind::slope_distance:
      return d.norm() - o.value;
    case ObservationKind::horizontal_distance:
      return h - o.value;
    case ObservationKind::height_difference:
      return d.z() - o.value;
  }
  return 0;
}

/// Files of gama-local rely on its tolerance for absolute terms: what contradicts the approximate coordinates by a
/// metre (its default) is left out, because linearised it would spoil everything.
void drop_outlying(NetworkModel& m) {
  constexpr double kTolerance = 1.0;
  if (m.survey.info.format != "gama-xml") return;
  std::map<int, std::vector<double>> turns;
  for (size_t i = 0; i < m.observations.size(); ++i) {
    const Observation& o = m.observations[i].observation;
    if (m.dropped[i] || o.kind != ObservationKind::direction) continue;
    const Eigen::Vector3d d = m.initial[m.index.at(o.to)] - m.initial[m.index.at(o.from)];
    auto& list = turns[o.set_up];
    const double turn = std::atan2(d.x(), d.y()) - o.value;
    list.push_back(list.empty() ? turn : list.front() + wrap_angle(turn - list.front()));
  }
  for (size_t i = 0; i < m.observations.size(); ++i) {
    const Observation& o = m.observations[i].observation;
    if (m.dropped[i] || o.kind == ObservationKind::angle) continue;  // its arms have no one length
    const bool direction = o.kind == ObservationKind::direction;
    const double size = misclosure(m, o, direction ? median(turns.at(o.set_up)) : 0.0);
    if (!(std::abs(size) > kTolerance)) continue;
    m.dropped[i] = 1;
    m.findings.push_back({Finding::Severity::warning,
                          kind_name(o.kind) + " " + o.from + " -> " + o.to + " (" + o.source.file + ":" +
                              std::to_string(o.source.line) + ") is not used: it contradicts the approximate " +
                              "coordinates by " + std::to_string(std::abs(size)) + " m",
                          {o.from, o.to}});
  }
}

ResultRow given_row(const std::string& kind, const std::string& from, const std::string& to, int axis, double value,
                    const SourcePosition& source, int group) {
  ResultRow row;
  row.kind = kind;
  row.from = from;
  row.to = to;
  row.detail = std::string(1, "ENH"[axis]);
  row.value = value;
  row.source = source;
  row.group = group;
  return row;
}

void make_rows(NetworkModel& m) {
  std::vector<char> correlated(m.survey.observations.size(), 0);
  for (const auto& c : m.survey.covariances)
    for (int i : c.indices) correlated[i] = 1;
  for (size_t i = 0; i < m.observations.size(); ++i) {
    const MeanObservation& mean = m.observations[i];
    const Observation& o = mean.observation;
    ResultRow row;
    row.kind = kind_name(o.kind);
    if (o.set_up >= 0) row.set_up = m.survey.set_ups[o.set_up].id;
    row.from = o.from;
    row.to = o.to;
    row.detail = o.second_to;
    row.value = o.value;
    row.sets = mean.sets;
    row.source = o.source;
    row.corrections = o.corrections;
    row.group = group_of(o.kind);
    row.removable = !correlated[mean.members.front()];
    m.rows.push_back(std::move(row));
  }
  for (const CoordinateGroup& g : m.survey.coordinates) {
    m.first_row_of_group.push_back(static_cast<int>(m.rows.size()));
    for (size_t k = 0; k < g.components.size(); ++k)
      m.rows.push_back(given_row("coordinate", "", g.components[k].point, g.components[k].axis,
                                 g.values[static_cast<Eigen::Index>(k)], g.source, kGiven));
  }
  for (const VectorGroup& g : m.survey.vectors) {
    m.first_row_of_group.push_back(static_cast<int>(m.rows.size()));
    for (size_t k = 0; k < g.vectors.size(); ++k)
      for (int axis = 0; axis < 3; ++axis)
        m.rows.push_back(given_row("vector", g.vectors[k].from, g.vectors[k].to, axis,
                                   g.values[static_cast<Eigen::Index>(3 * k) + axis], g.source, kGiven));
  }
  for (const LocalCoordinate& c : m.survey.local_coordinates) {
    m.first_row_of_group.push_back(static_cast<int>(m.rows.size()));
    const SetUp& set_up = m.survey.set_ups[c.set_up];
    for (int axis = 0; axis < 3; ++axis) {
      ResultRow row =
          given_row("local_coordinate", set_up.station, c.point, axis, c.position[axis], c.source, kLocalCoordinates);
      row.detail = std::string(1, "xyz"[axis]);
      row.set_up = set_up.id;
      row.corrections = c.corrections;
      m.rows.push_back(std::move(row));
    }
  }
}

/// Indices are as good as the file or artifact they come from.
void check_indices(const SurveyObservations& s) {
  const int set_ups = static_cast<int>(s.set_ups.size()), observations = static_cast<int>(s.observations.size());
  for (const Observation& o : s.observations) {
    if (o.set_up < -1 || o.set_up >= set_ups || (o.kind == ObservationKind::direction && o.set_up < 0))
      throw NetworkError("observation " + o.from + " -> " + o.to + " refers to set-up " + std::to_string(o.set_up) +
                         ", there are " + std::to_string(set_ups));
    if (!std::isfinite(o.value))
      throw NetworkError(kind_name(o.kind) + " " + o.from + " -> " + o.to + " (" + o.source.file + ":" +
                         std::to_string(o.source.line) + ") has no value");
  }
  for (const auto& c : s.covariances)
    for (int i : c.indices)
      if (i < 0 || i >= observations) throw NetworkError("a covariance refers to observation " + std::to_string(i));
  for (const auto& c : s.local_coordinates)
    if (c.set_up < 0 || c.set_up >= set_ups)
      throw NetworkError("local coordinates of " + c.point + " refer to set-up " + std::to_string(c.set_up));
}

}  // namespace

NetworkModel make_model(const SurveyObservations& survey, const AdjustOptions& options, const ControlPoints& control) {
  check_indices(survey);
  NetworkModel m;
  m.survey = survey;
  MeanResult means = mean_observations(survey);
  m.observations = std::move(means.observations);
  for (const std::string& note : means.notes) m.findings.push_back({Finding::Severity::warning, note, {}});
  if (m.observations.empty() && survey.coordinates.empty() && survey.vectors.empty() &&
      survey.local_coordinates.empty())
    throw NetworkError("there are no observations to adjust");
  collect_points(m);
  distrust_equal_coordinates(m);
  apply_datum(m, options, control);
  find_approximations(m);
  find_lengths(m);
  drop_unusable(m);
  drop_outlying(m);
  const bool reduced_file = survey.info.format == "gama-xml" || survey.info.format == "krumm";
  m.curvature = options.curvature == Switch::on || (options.curvature == Switch::automatic && !reduced_file);
  m.refraction_coefficient = std::isnan(survey.info.refraction_coefficient) ? options.refraction_coefficient
                                                                            : survey.info.refraction_coefficient;
  make_rows(m);
  return m;
}

std::string kind_name(ObservationKind kind) {
  switch (kind) {
    case ObservationKind::direction:
      return "direction";
    case ObservationKind::zenith_angle:
      return "zenith_angle";
    case ObservationKind::slope_distance:
      return "slope_distance";
    case ObservationKind::horizontal_distance:
      return "horizontal_distance";
    case ObservationKind::height_difference:
      return "height_difference";
    case ObservationKind::angle:
      return "angle";
    case ObservationKind::azimuth:
      return "azimuth";
  }
  return "?";
}

Group group_of(ObservationKind kind) {
  switch (kind) {
    case ObservationKind::zenith_angle:
      return kZenithAngles;
    case ObservationKind::slope_distance:
    case ObservationKind::horizontal_distance:
      return kDistances;
    case ObservationKind::height_difference:
      return kHeightDifferences;
    default:
      return kDirections;
  }
}

const char* datum_name(DatumMode mode) {
  switch (mode) {
    case DatumMode::file:
      return "file";
    case DatumMode::fixed:
      return "fixed";
    case DatumMode::weighted:
      return "weighted";
    case DatumMode::inner:
      return "inner";
    default:
      return "automatic";
  }
}

SurveyObservations merge_surveys(const std::vector<SurveyObservations>& surveys) {
  if (surveys.size() == 1) return surveys.front();
  SurveyObservations all;
  std::map<std::string, size_t> index;
  int pointings = 0;
  for (const SurveyObservations& s : surveys) {
    if (all.files.empty()) all.info = s.info;
    if (all.info.format != s.info.format) all.info.format = "several";
    const int set_up_offset = static_cast<int>(all.set_ups.size());
    const int observation_offset = static_cast<int>(all.observations.size());
    int next_pointing = pointings;
    all.files.insert(all.files.end(), s.files.begin(), s.files.end());
    for (const Point& p : s.points) {
      const auto [at, is_new] = index.try_emplace(p.id, all.points.size());
      if (is_new) {
        all.points.push_back(p);
        continue;
      }
      Point& known = all.points[at->second];
      for (int k = 0; k < 3; ++k) {
        if (std::isnan(known.coordinates[k])) known.coordinates[k] = p.coordinates[k];
        known.roles[k] = std::max(known.roles[k], p.roles[k]);
      }
    }
    all.set_ups.insert(all.set_ups.end(), s.set_ups.begin(), s.set_ups.end());
    for (Observation o : s.observations) {
      if (o.set_up >= 0) o.set_up += set_up_offset;
      if (o.pointing >= 0) o.pointing += pointings;
      next_pointing = std::max(next_pointing, o.pointing + 1);
      all.observations.push_back(std::move(o));
    }
    pointings = next_pointing;
    for (ObservationCovariance c : s.covariances) {
      for (int& i : c.indices) i += observation_offset;
      all.covariances.push_back(std::move(c));
    }
    all.coordinates.insert(all.coordinates.end(), s.coordinates.begin(), s.coordinates.end());
    all.vectors.insert(all.vectors.end(), s.vectors.begin(), s.vectors.end());
    for (LocalCoordinate c : s.local_coordinates) {
      if (c.set_up >= 0) c.set_up += set_up_offset;
      all.local_coordinates.push_back(std::move(c));
    }
    all.skipped.insert(all.skipped.end(), s.skipped.begin(), s.skipped.end());
    all.warnings.insert(all.warnings.end(), s.warnings.begin(), s.warnings.end());
  }
  return all;
}

}  // namespace plumbline::survey
