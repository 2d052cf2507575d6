#include "survey/network/network_model.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <optional>
#include <set>

#include "survey/model/reduced_readings.hpp"
#include "survey/network/network_model_steps.hpp"
#include "survey/start/check_set_ups.hpp"
#include "survey/start/set_up_chain.hpp"

namespace plumbline::survey {

namespace {

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
  std::vector<std::string> lonely, held;
  for (const Point& p : m.survey.points) {
    if (touched.points.contains(p.id))
      add_point(m, p.id, p.coordinates, p.roles);
    else
      (p.roles[0] == CoordinateRole::fixed || p.roles[2] == CoordinateRole::fixed ? held : lonely).push_back(p.id);
  }
  if (!held.empty())
    m.findings.push_back({Finding::Severity::note, "held by the file, but nothing observes it: " + join(held), held});
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

/// Takes over approximate coordinates where the file gives none; returns the points that are still without.
std::vector<int> take_over(const Approximation& approximation, NetworkModel& m) {
  std::vector<int> lost;
  for (size_t i = 0; i < m.ids.size(); ++i) {
    const auto at = approximation.points.find(m.ids[i]);
    bool complete = true;
    for (int k = 0; k < 3; ++k) {
      double& value = m.initial[i][k];
      if (m.roles[i][k] == CoordinateRole::unused) {
        value = 0;
        continue;
      }
      if (std::isnan(value)) m.searched = true;
      if (std::isnan(value) && at != approximation.points.end()) value = at->second[k];
      complete &= !std::isnan(value);
    }
    if (!complete) lost.push_back(static_cast<int>(i));
  }
  m.orientations = approximation.orientations;
  return lost;
}

[[noreturn]] void refuse_lost(const NetworkModel& m, const std::vector<int>& lost) {
  std::vector<std::string> ids, described;
  for (int i : lost) {
    ids.push_back(m.ids[i]);
    described.push_back(sightings_of(m, m.ids[i]));
  }
  throw NetworkError("rank defect: the observations do not determine the coordinates of " + join(described, 4) +
                         "; observe them from a second set-up, or with a distance and a zenith angle, or give "
                         "approximate coordinates",
                     {{Finding::Severity::error, "not determined: " + join(ids), ids}}, ids);
}

/// The model started from the chain of its set-ups, where that gives every coordinate: most networks of total stations.
std::optional<NetworkModel> with_simple_start(const NetworkModel& m, const SetUpChain& chain,
                                              const std::map<std::string, Eigen::Vector3d>& known) {
  const auto start = start_from_chain(chain, m.survey.set_ups.size(), known);
  if (!start) return std::nullopt;
  NetworkModel started = m;
  if (!take_over({start->points, start->orientations}, started).empty()) return std::nullopt;
  find_lengths(started);
  drop_unusable(started);
  find_map_corrections(started);
  return started;
}

/// For approximate coordinates: geocentric vectors in the horizon of a known point, turned to grid north.
SurveyObservations with_vectors_on_map(const NetworkModel& m) {
  SurveyObservations plain = m.survey;
  const auto known = std::find_if(m.initial.begin(), m.initial.end(),
                                  [](const Eigen::Vector3d& p) { return p.head<2>().allFinite(); });
  if (!m.map || known == m.initial.end()) return plain;
  Eigen::Matrix3d by_map;
  m.map->geocentric({known->x(), known->y(), std::isnan(known->z()) ? 0 : known->z()}, &by_map);
  const Eigen::Matrix3d to_map = by_map.inverse();
  for (VectorGroup& g : plain.vectors)
    for (Eigen::Index k = 0; k < g.values.size(); k += 3) {
      g.values.segment<3>(k) = (to_map * g.values.segment<3>(k)).eval();
      g.covariance.block(k, 0, 3, g.covariance.cols()) =
          (to_map * g.covariance.block(k, 0, 3, g.covariance.cols())).eval();
      g.covariance.block(0, k, g.covariance.rows(), 3) =
          (g.covariance.block(0, k, g.covariance.rows(), 3) * to_map.transpose()).eval();
    }
  return plain;
}

/// The model with approximate coordinates, once for every set of them that is possible.
std::vector<NetworkModel> with_approximations(NetworkModel m, const SetUpChain& chain, bool simple_start) {
  std::map<std::string, Eigen::Vector3d> known;
  for (size_t i = 0; i < m.ids.size(); ++i)
    if (!m.initial[i].array().isNaN().all()) known[m.ids[i]] = m.initial[i];
  m.starts_from_known_points = !known.empty() || !m.survey.coordinates.empty();
  if (simple_start)
    if (auto simple = with_simple_start(m, chain, known)) return {std::move(*simple)};
  const SurveyObservations plain = with_vectors_on_map(m);
  std::vector<Approximation> approximations = approximate_coordinates(plain, m.observations, known);
  NetworkModel trial = m;
  const std::vector<int> lost = take_over(approximations.front(), trial);
  if (!lost.empty()) {
    // Something is missing between known points and the network, or between its parts. If each has a shape of its own,
    // the rank doctor can say what it is.
    approximations = approximate_coordinates(plain, m.observations, {}, true);
    approximations.resize(1);
    if (trial = m; !take_over(approximations.front(), trial).empty()) refuse_lost(m, lost);
    m.unrelated = true;
  }
  std::vector<NetworkModel> models;
  for (size_t i = 0; i + 1 < approximations.size(); ++i) models.push_back(m);
  models.push_back(std::move(m));
  for (size_t i = 0; i < models.size(); ++i) {
    take_over(approximations[i], models[i]);
    find_lengths(models[i]);
    drop_unusable(models[i]);
    if (!models[i].unrelated) find_map_corrections(models[i]);
  }
  return models;
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
    row.readings = static_cast<int>(mean.members.size());
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
      for (int axis = 0; axis < 3; ++axis) {
        m.rows.push_back(given_row("vector", g.vectors[k].from, g.vectors[k].to, axis,
                                   g.values[static_cast<Eigen::Index>(3 * k) + axis], g.source, kGiven));
        m.rows.back().readings = axis == 0;
        if (g.is_geocentric) m.rows.back().detail = std::string(1, "XYZ"[axis]);
      }
  }
  for (const LocalCoordinate& c : m.survey.local_coordinates) {
    m.first_row_of_group.push_back(static_cast<int>(m.rows.size()));
    const SetUp& set_up = m.survey.set_ups[c.set_up];
    for (int axis = 0; axis < 3; ++axis) {
      ResultRow row =
          given_row("local_coordinate", set_up.station, c.point, axis, c.position[axis], c.source, kLocalCoordinates);
      row.detail = std::string(1, "xyz"[axis]);
      row.set_up = set_up.id;
      row.readings = axis == 0;
      row.corrections = c.corrections;
      m.rows.push_back(std::move(row));
    }
  }
}

/// The set-ups beside each other. What can be mended without losing a reading is, if the user wants mending, and they
/// are looked at again; what cannot is set aside for the adjustment.
SetUpChain check_and_mend(const AdjustOptions& options, NetworkModel& m, MeanResult& means) {
  constexpr int kMost = 5;  // a set-up for each; more is not a survey
  for (int round = 0;; ++round) {
    means = mean_observations(m.survey);
    SetUpChain chain(m.survey, means.observations, options.profile);
    const std::vector<SetUpProblem> problems = check_set_ups(m.survey, means.observations, chain);
    const bool mended =
        options.remove_blunders && round < kMost && mend_set_ups(problems, means.observations, m.survey);
    for (const SetUpProblem& p : problems) {
      using Kind = SetUpProblem::Kind;
      const bool by_itself = p.kind == Kind::unit || p.kind == Kind::turned_circle || p.kind == Kind::moved_instrument;
      if (mended && !(by_itself && p.certain)) continue;  // it is met again
      const bool done = options.remove_blunders && p.certain && (mended || !by_itself);
      const char* what = p.kind == Kind::unit               ? "; they were converted"
                         : p.kind == Kind::turned_circle    ? "; these sights have an orientation of their own now"
                         : p.kind == Kind::moved_instrument ? "; these sights are a set-up of their own now"
                                                            : "; left out";
      m.findings.push_back({Finding::Severity::warning, p.text + (done ? what : ""), p.points});
      if (done && !by_itself) m.set_aside.insert(m.set_aside.end(), p.observations.begin(), p.observations.end());
      if (done && (p.kind == Kind::swapped_names || p.kind == Kind::wrong_name))
        m.misnamed.insert(m.misnamed.end(), p.observations.begin(), p.observations.end());
      if (!done && p.kind != Kind::reading && m.contradiction.empty()) m.contradiction = p.text;
    }
    if (!mended) return chain;
  }
}

}  // namespace

/// A free station takes up millimetres in place of metres: its own height is wrong by a kilometre, and nothing else is.
static void refuse_height(const char* of, double height, const std::string& where) {
  constexpr double kHighest = 100;  // [m]
  if (std::abs(height) > kHighest)
    throw NetworkError(where + ": the " + of + " height is " + fixed_digits(height, 3) +
                       " m; heights of targets and instruments are metres: mend the unit of the file or the number");
}

void check_indices(const SurveyObservations& s) {
  for (const SetUp& set_up : s.set_ups) refuse_height("instrument", set_up.instrument_height, "set-up " + set_up.id);
  const int set_ups = static_cast<int>(s.set_ups.size()), observations = static_cast<int>(s.observations.size());
  for (const Observation& o : s.observations) {
    if (o.set_up < -1 || o.set_up >= set_ups || (o.kind == ObservationKind::direction && o.set_up < 0))
      throw NetworkError("observation " + o.from + " -> " + o.to + " refers to set-up " + std::to_string(o.set_up) +
                         ", there are " + std::to_string(set_ups));
    if (!std::isfinite(o.value)) throw NetworkError(name_of(o) + " has no value");
    refuse_height("target", o.target_height, name_of(o));
    refuse_height("target", o.second_target_height, name_of(o));
    refuse_height("instrument", o.instrument_height, name_of(o));
    if (o.face < 0 || o.face > 2)
      throw NetworkError(name_of(o) + " has the face " + std::to_string(o.face) + ", expected 0, 1 or 2");
  }
  for (const CoordinateGroup& g : s.coordinates)
    for (const auto& c : g.components)
      if (c.axis < 0 || c.axis > 2)
        throw NetworkError("coordinates of " + c.point + " refer to axis " + std::to_string(c.axis));
  for (const auto& c : s.covariances)
    for (int i : c.indices)
      if (i < 0 || i >= observations) throw NetworkError("a covariance refers to observation " + std::to_string(i));
  for (const auto& c : s.local_coordinates)
    if (c.set_up < 0 || c.set_up >= set_ups)
      throw NetworkError("local coordinates of " + c.point + " refer to set-up " + std::to_string(c.set_up));
}

NetworkModel make_model(const SurveyObservations& survey, const AdjustOptions& options, const ControlPoints& control,
                        bool simple_start) {
  check_indices(survey);
  NetworkModel m;
  m.survey = survey;
  MeanResult means;
  const SetUpChain chain = check_and_mend(options, m, means);
  m.observations = std::move(means.observations);
  for (const InstrumentErrors& e : means.instrument)
    m.collimations.push_back(e.has_collimation() ? CommonEstimate{e.collimation, e.collimation_sigma}
                                                 : CommonEstimate{});
  m.knocked = means.knocked;
  for (const std::string& text : means.warnings) m.findings.push_back({Finding::Severity::warning, text, {}});
  for (const std::string& text : means.notes) m.findings.push_back({Finding::Severity::note, text, {}});
  if (m.observations.empty() && survey.coordinates.empty() && survey.vectors.empty() &&
      survey.local_coordinates.empty())
    throw NetworkError("there are no observations to adjust: " +
                       (survey.points.empty() ? std::string("nothing was read")
                                              : "the file gives " + std::to_string(survey.points.size()) +
                                                    (survey.points.size() == 1 ? " point" : " points") +
                                                    " and no reading of a total station or level") +
                       "; `plumbline run read_survey` writes what it gives");
  collect_points(m);
  distrust_equal_coordinates(m);
  apply_datum(m, options, control);
  const bool is_raw = !is_of_adjustment_programs(survey);
  m.curvature = options.curvature == Switch::on || (options.curvature == Switch::automatic && is_raw);
  m.refraction_coefficient = std::isnan(survey.info.refraction_coefficient) ? options.refraction_coefficient
                                                                            : survey.info.refraction_coefficient;
  take_map(m, options);
  tell_orientation(m);
  hold_stated_orientation(m);
  make_rows(m);
  m = choose_alternative(with_approximations(std::move(m), chain, simple_start), options);
  if (!m.unrelated) drop_outlying(m);
  return m;
}

}  // namespace plumbline::survey
