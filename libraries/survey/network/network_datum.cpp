// What holds the network: fixed points, control with covariance, or inner constraints.
#include <algorithm>
#include <cmath>
#include <map>
#include <string_view>

#include "survey/model/reduced_readings.hpp"
#include "survey/network/network_model_steps.hpp"

namespace plumbline::survey {

namespace {

/// A coordinate that was keyed in, takes part, and was not found to be a placeholder (two stations at one place).
bool is_known(const NetworkModel& m, const Point& p, int axis) {
  const auto at = m.index.find(p.id);
  const auto k = static_cast<size_t>(axis);
  return at != m.index.end() && p.known[k] && m.roles[at->second][k] != CoordinateRole::unused &&
         std::isfinite(m.initial[at->second][axis]) && std::isfinite(p.coordinates[axis]);
}

bool knows_any(const NetworkModel& m) {
  return std::any_of(m.survey.points.begin(), m.survey.points.end(),
                     [&](const Point& p) { return is_known(m, p, 0) || is_known(m, p, 1) || is_known(m, p, 2); });
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
  if (knows_any(m)) return DatumMode::weighted;
  // Adjustment programs' own files say what the datum is; if they say nothing that is for the user to decide.
  return is_of_adjustment_programs(m.survey) ? DatumMode::file : DatumMode::inner;
}

int require_point(const NetworkModel& m, const std::string& id, const std::string& what) {
  const auto at = m.index.find(id);
  if (at != m.index.end()) return at->second;
  throw NetworkError(what + " '" + id + "' is not observed in this network; observed are " + join(m.ids));
}

/// Holds the given components; a bench mark may have a height only.
void hold(NetworkModel& m, int point, const Eigen::Vector3d& known) {
  if (known.array().isNaN().all())
    throw NetworkError("datum point '" + m.ids[point] +
                       "' has no coordinates that could be held; give it some, or use datum: inner");
  for (int k = 0; k < 3; ++k)
    if (m.roles[point][k] != CoordinateRole::unused && !std::isnan(known[k])) {
      m.roles[point][k] = CoordinateRole::fixed;
      m.initial[point][k] = known[k];
    }
  m.datum_points.push_back(m.ids[point]);
}

/// Points that were keyed in as known are control. What they leave open (the turn about a single one, the heights of
/// known plan positions) is carried by the approximate coordinates of the others.
void add_keyed_in(NetworkModel& m, double sigma) {
  using R = CoordinateRole;
  for (auto& roles : m.roles)
    for (R& role : roles)
      if (role == R::free) role = R::constrained;
  for (const Point& p : m.survey.points) {
    CoordinateGroup group;
    std::vector<double> values;
    for (int k = 0; k < 3; ++k) {
      if (!is_known(m, p, k)) continue;
      m.roles[m.index.at(p.id)][k] = R::free;
      group.components.push_back({p.id, k});
      values.push_back(p.coordinates[k]);
    }
    if (values.empty()) continue;
    group.is_control = true;
    group.values = Eigen::Map<const Eigen::VectorXd>(values.data(), static_cast<Eigen::Index>(values.size()));
    group.covariance = sigma * sigma * Eigen::MatrixXd::Identity(group.values.size(), group.values.size());
    group.source = p.source;
    m.survey.coordinates.push_back(std::move(group));
    m.datum_points.push_back(p.id);
    m.keyed_in.insert(p.id);
  }
  m.findings.push_back({Finding::Severity::note,
                        "the file has " + join(m.datum_points) +
                            " as known: " + (m.datum_points.size() == 1 ? "it is" : "they are") +
                            " control, with an assumed standard "
                            "deviation of " +
                            fixed_digits(1e3 * sigma, 1) +
                            " mm (known_sigma); coordinates that the "
                            "instrument computed are approximate values",
                        m.datum_points});
}

/// A table of known points that is handed over as a survey file, too, states the same once more: an error of it would
/// weigh twice, and the network look better than it is.
void drop_repeated_control(NetworkModel& m, const ControlPoints& control) {
  constexpr double kSame = 1e-6;  // [m]
  std::vector<std::string> repeated;
  std::erase_if(m.survey.coordinates, [&](const CoordinateGroup& g) {
    const auto is_same = [&](size_t k) {
      const auto at = std::find(control.ids.begin(), control.ids.end(), g.components[k].point);
      const auto position = 3 * (at - control.ids.begin()) + g.components[k].axis;
      return at != control.ids.end() &&
             std::abs(control.coordinates[position] - g.values[static_cast<Eigen::Index>(k)]) < kSame;
    };
    bool same = g.is_control;
    for (size_t k = 0; same && k < g.components.size(); ++k) same = is_same(k);
    if (same) repeated.push_back(g.components.front().point);
    return same;
  });
  if (!repeated.empty())
    m.findings.push_back({Finding::Severity::note,
                          "known points of the survey files have the values of the control (" + join(repeated) +
                              "): they count once, as the control",
                          repeated});
}

/// What survey files have as known beside the control does not hold: where it contradicts the control somebody is to
/// know, and where the control does not have it, too.
void tell_keyed_in_beside(NetworkModel& m, const ControlPoints& control) {
  constexpr double kSame = 0.001;  // [m]
  std::map<std::string_view, Eigen::Index> rows;
  for (std::size_t c = 0; c < control.ids.size(); ++c) rows.try_emplace(control.ids[c], static_cast<Eigen::Index>(c));
  std::vector<std::string> others, other_ids, unused;
  for (const Point& p : m.survey.points) {
    if (!is_known(m, p, 0) && !is_known(m, p, 1) && !is_known(m, p, 2)) continue;
    const auto found = rows.find(p.id);
    const bool is_control = found != rows.end();
    const Eigen::Index at = is_control ? found->second : 0;
    bool held = true;
    for (int k = 0; k < 3; ++k) {
      if (!is_known(m, p, k)) continue;
      const Eigen::Index row = 3 * at + k;
      const double value = is_control ? control.coordinates[row] : kNotGiven;
      const double sigma = is_control && control.covariance.size() > 0 ? std::sqrt(control.covariance(row, row)) : 0;
      held &= std::isfinite(value);
      if (!(std::abs(p.coordinates[k] - value) > std::max(kSame, 3 * sigma))) continue;
      others.push_back(p.id + " (" + "ENH"[k] + " " + fixed_digits(p.coordinates[k], 3) + " m, in the control " +
                       fixed_digits(value, 3) + " m)");
      if (other_ids.empty() || other_ids.back() != p.id) other_ids.push_back(p.id);
    }
    if (!held) unused.push_back(p.id);
  }
  if (!others.empty())
    m.findings.push_back({Finding::Severity::warning,
                          "known points are keyed into the survey files with other coordinates than the control has: " +
                              join(others) + "; those of the control count. Mend the one that is wrong",
                          other_ids});
  if (unused.empty()) return;
  m.known_beside_control = "the survey files have " + join(unused) +
                           " as known, wholly or in part, and the control does not: they are approximate values "
                           "beside a control. Give them as control if they are to hold";
  m.findings.push_back({Finding::Severity::note, m.known_beside_control, unused});
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
  drop_repeated_control(m, control);
  m.survey.coordinates.push_back(std::move(group));
}

}  // namespace

void apply_datum(NetworkModel& m, const AdjustOptions& options, const ControlPoints& control) {
  for (size_t c = 0; c < control.ids.size(); ++c) {
    const auto at = m.index.find(control.ids[c]);
    if (at == m.index.end()) continue;
    for (int k = 0; k < 3; ++k)
      if (const double value = control.coordinates[static_cast<Eigen::Index>(3 * c) + k]; !std::isnan(value))
        m.initial[at->second][k] = value;
  }
  m.datum = choose_datum(m, options, control);
  if (!control.ids.empty()) tell_keyed_in_beside(m, control);
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
  } else if (m.datum == DatumMode::weighted && control.ids.empty() && knows_any(m)) {
    add_keyed_in(m, options.known_sigma);
  } else if (m.datum == DatumMode::weighted) {
    add_weighted_control(m, control);
  } else if (m.datum == DatumMode::fixed) {
    for (const std::string& id : options.datum_points) {
      const int point = require_point(m, id, "datum point");
      hold(m, point, m.initial[point]);
    }
    if (options.datum_points.empty())
      for (size_t c = 0; c < control.ids.size(); ++c)
        if (const auto at = m.index.find(control.ids[c]); at != m.index.end())
          hold(m, at->second, control.coordinates.segment<3>(static_cast<Eigen::Index>(3 * c)));
    if (options.datum_points.empty() && control.ids.empty())
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

}  // namespace plumbline::survey
