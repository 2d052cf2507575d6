#include <algorithm>
#include <cmath>
#include <tuple>

#include "survey/model/reduced_readings.hpp"
#include "survey/network/network_model.hpp"
#include "survey/network/reading_sigmas.hpp"
#include "survey/network/sight_covariance.hpp"

namespace plumbline::survey {

namespace {

/// Position of a parameter among those of a block; appended when new.
int slot(least_squares::ResidualBlock& block, int parameter) {
  if (parameter < 0) return -1;
  const auto at = std::find(block.parameters.begin(), block.parameters.end(), parameter);
  if (at != block.parameters.end()) return static_cast<int>(at - block.parameters.begin());
  block.parameters.push_back(parameter);
  return static_cast<int>(block.parameters.size()) - 1;
}

class Assembler {
 public:
  Assembler(const NetworkModel& model, const AdjustOptions& options, const StochasticState& state)
      : m_(model),
        options_(options),
        state_(state),
        sigmas_(model, options, state),
        shared_centring_(options.centring_per_set_up && state.weight_factors.empty()) {}

  NetworkProblem assemble() {
    add_points();
    add_set_ups();
    add_common();
    add_observations();
    add_correlated_observations();
    add_given();
    return std::move(out_);
  }

  Equation equation(ObservationBlock& block, int observation, const NetworkProblem& p) const {
    const Observation& o = m_.observations[observation].observation;
    Equation eq;
    eq.kind = o.kind;
    eq.value = o.value;
    if (!m_.corrections.empty()) {
      const MapCorrection& c = m_.corrections[observation];
      eq.map_scale = c.scale;
      eq.value += o.kind == ObservationKind::zenith_angle ? c.zenith : c.direction;
      eq.rise = c.rise, eq.second_rise = c.second_rise;
    }
    const double own = o.set_up >= 0 ? m_.survey.set_ups[o.set_up].instrument_height : 0.0;
    eq.instrument_height = or_zero(std::isnan(o.instrument_height) ? own : o.instrument_height);
    eq.target_height = or_zero(o.target_height);
    eq.second_target_height = or_zero(o.second_target_height);
    eq.from = slot(block, p.point_blocks[m_.index.at(o.from)]);
    eq.to = slot(block, p.point_blocks[m_.index.at(o.to)]);
    if (o.kind == ObservationKind::angle) eq.second_to = slot(block, p.point_blocks[m_.index.at(o.second_to)]);
    const bool angular = o.kind == ObservationKind::direction || o.kind == ObservationKind::zenith_angle;
    if (o.kind == ObservationKind::direction) eq.orientation = slot(block, p.orientation_blocks[o.set_up]);
    if (o.set_up >= 0 && angular) eq.tilt = slot(block, p.tilt_blocks[o.set_up]);
    if (has_centring_unknown(o, p)) eq.centring = slot(block, p.centring_blocks[o.set_up]);
    if (o.set_up >= 0) eq.instrument_height_correction = slot(block, p.height_correction_blocks[o.set_up]);
    const bool distance = o.kind == ObservationKind::slope_distance || o.kind == ObservationKind::horizontal_distance;
    // Said outright it holds for all; else what its file has reduced is not reduced again.
    eq.curvature = m_.curvature && (options_.curvature == Switch::on || !is_reduced(o));
    for (const auto& [name, parameter] : p.common_blocks) {
      if (name == "scale" && distance) eq.scale = slot(block, parameter);
      if (name == "additive constant" && distance) eq.additive_constant = slot(block, parameter);
      if (name == "refraction coefficient" && o.kind == ObservationKind::zenith_angle && eq.curvature)
        eq.refraction = slot(block, parameter);
      if (name == "vertical index" && o.kind == ObservationKind::zenith_angle) eq.index = slot(block, parameter);
    }
    add_extra(block, observation, p, eq);
    eq.refraction_coefficient = m_.refraction_coefficient;
    return eq;
  }

 private:
  void add_extra(ObservationBlock& block, int observation, const NetworkProblem& p, Equation& eq) const {
    using Kind = ExtraUnknown::Kind;
    const Observation& o = m_.observations[observation].observation;
    const bool distance = o.kind == ObservationKind::slope_distance || o.kind == ObservationKind::horizontal_distance;
    bool of_reflector = false;
    for (size_t k = 0; k < state_.extra.size(); ++k) {
      const auto& [kind, set_up, target_height, sights] = state_.extra[k];
      const bool reflector = kind == Kind::reflector && std::binary_search(sights.begin(), sights.end(), observation);
      if (!reflector && set_up >= 0 && o.set_up != set_up)
        continue;  // sights stay what they are where a set-up is split
      const int parameter = p.extra_blocks[k];
      if (kind == Kind::constant && distance && !of_reflector) eq.additive_constant = slot(block, parameter);
      // Of sights that have a constant already it is another one in its place.
      if (reflector) eq.additive_constant = slot(block, parameter), of_reflector = true;
      if (kind == Kind::scale && distance) eq.scale = slot(block, parameter);
      if (kind == Kind::index && o.kind == ObservationKind::zenith_angle) eq.index = slot(block, parameter);
      // What is a mean of both faces is free of it.
      const double face = o.face == 1 ? 1 : o.face == 2 ? -1 : 0;
      if (kind == Kind::face_index && o.kind == ObservationKind::zenith_angle && face != 0 && eq.index < 0)
        eq.index = slot(block, parameter), eq.index_factor = face;
      if (kind == Kind::collimation && o.kind == ObservationKind::direction && face != 0)
        eq.collimation = slot(block, parameter), eq.face = face;
      if (kind == Kind::height && o.set_up >= 0) eq.instrument_height_correction = slot(block, parameter);
      // A target noted too high is an axis noted too high.
      if (kind == Kind::target && eq.instrument_height_correction < 0 && or_zero(o.target_height) == target_height)
        eq.instrument_height_correction = slot(block, parameter);
    }
  }

  int add_block(const std::string& name, std::vector<double> value, std::vector<bool> constant = {}) {
    out_.problem.parameters.push_back({name, std::move(value), std::move(constant)});
    return static_cast<int>(out_.problem.parameters.size()) - 1;
  }

  void add_prior(int parameter, const Eigen::VectorXd& prior, double sigma) {
    auto block = std::make_unique<PriorBlock>();
    block->prior = prior;
    block->set_sigmas(Eigen::VectorXd::Constant(prior.size(), sigma));
    block->parameters = {parameter};
    block->groups.assign(prior.size(), kGiven);
    finish(std::move(block), std::vector<int>(prior.size(), -1), "");
  }

  void finish(std::unique_ptr<least_squares::ResidualBlock> block, const std::vector<int>& rows,
              const std::string& name) {
    out_.rows.insert(out_.rows.end(), rows.begin(), rows.end());
    out_.block_names.push_back(name);
    out_.problem.residuals.push_back(std::move(block));
  }

  void add_points() {
    for (size_t i = 0; i < m_.ids.size(); ++i) {
      std::vector<bool> constant;
      for (CoordinateRole role : m_.roles[i])
        constant.push_back(role == CoordinateRole::unused || role == CoordinateRole::fixed);
      const Eigen::Vector3d& p = m_.initial[i];
      out_.point_blocks.push_back(add_block(m_.ids[i], {p.x(), p.y(), p.z()}, constant));
    }
  }

  /// Orientation from the first direction, where the approximation gave none.
  double initial_orientation(int set_up) const {
    if (!std::isnan(m_.orientations[set_up])) return m_.orientations[set_up];
    for (const MeanObservation& mean : m_.observations) {
      const Observation& o = mean.observation;
      if (o.set_up != set_up || o.kind != ObservationKind::direction) continue;
      const Eigen::Vector3d d = m_.initial[m_.index.at(o.to)] - m_.initial[m_.index.at(o.from)];
      return wrap_angle(std::atan2(d.x(), d.y()) - o.value);
    }
    return 0;
  }

  /// Where an instrument stood and how high is one amount for all that it saw from there.
  void add_set_ups() {
    std::vector<char> directions(m_.survey.set_ups.size(), 0);
    for (size_t i = 0; i < m_.observations.size(); ++i) {
      const Observation& o = m_.observations[i].observation;
      if (o.kind == ObservationKind::direction && !m_.dropped[i] && !state_.removed[i]) directions[o.set_up] = 1;
    }
    for (const LocalCoordinate& c : m_.survey.local_coordinates) directions[c.set_up] = 1;
    const std::vector<Eigen::Vector2d> centring = sigmas_.centrings();
    const auto with_prior = [&](const std::string& name, int size, double sigma) {
      if (!(sigma > 0)) return -1;
      const int block = add_block(name, std::vector<double>(static_cast<size_t>(size), 0.0));
      add_prior(block, Eigen::VectorXd::Zero(size), sigma);
      return block;
    };
    for (size_t i = 0; i < m_.survey.set_ups.size(); ++i) {
      const std::string& id = m_.survey.set_ups[i].id;
      out_.orientation_blocks.push_back(
          directions[i] ? add_block("orientation " + id, {initial_orientation(static_cast<int>(i))}) : -1);
      const bool all_heights = options_.instrument_height_sigma > 0;
      out_.height_correction_blocks.push_back(
          with_prior("instrument height " + id, 1, all_heights ? options_.instrument_height_sigma : centring[i][1]));
      out_.centring_blocks.push_back(with_prior("centring " + id, 2, centring[i][0]));
      out_.tilt_blocks.push_back(with_prior("tilt " + id, 2, options_.tilt_sigma));
    }
  }

  void add_common(const std::string& name, double value, double prior_sigma) {
    if (!(prior_sigma > 0)) return;
    const int block = add_block(name, {value});
    out_.common_blocks.emplace_back(name, block);
    add_prior(block, Eigen::VectorXd::Constant(1, value), prior_sigma);
  }

  void add_common() {
    add_common("scale", 0, options_.scale_sigma);
    add_common("additive constant", 0, options_.additive_constant_sigma);
    add_common("refraction coefficient", m_.refraction_coefficient, m_.curvature ? options_.refraction_sigma : 0);
    add_common("vertical index", 0, options_.vertical_index_sigma);
    const bool geocentric = std::any_of(m_.survey.vectors.begin(), m_.survey.vectors.end(),
                                        [](const VectorGroup& g) { return g.is_geocentric; });
    if (m_.map && geocentric && options_.geoid.is_open()) {
      geoid_slope_ = add_block("slope of the geoid", {0.0, 0.0});
      add_prior(geoid_slope_, Eigen::VectorXd::Zero(2), options_.geoid.slope_sigma);
    }
    static const char* const names[] = {"additive constant",
                                        "scale",
                                        "vertical index",
                                        "instrument height correction",
                                        "target height correction",
                                        "vertical index by face",
                                        "collimation",
                                        "additive constant of some reflectors"};
    for (const auto& [kind, set_up, target_height, sights] : state_.extra)
      out_.extra_blocks.push_back(add_block(
          std::string(names[static_cast<int>(kind)]) + (set_up >= 0 ? " of " + m_.survey.set_ups[set_up].id : ""),
          {0.0}));
  }

  bool takes_part(int observation) const { return !m_.dropped[observation] && !state_.removed[observation]; }

  /// The observations of one sighting make one block, so that they are tested together; and with them whatever else
  /// saw the target where it stood then (sight_covariance.hpp).
  void add_observations() {
    using Key = std::tuple<int, std::string, std::string, double, int>;
    std::map<std::tuple<int, std::string, std::string, double, ObservationKind>, int> seen;
    std::vector<std::vector<int>> blocks;
    std::map<Key, size_t> block_of;
    int station = -1;  // last reading without a set-up that may share a station with the next
    for (int i = 0; i < static_cast<int>(m_.observations.size()); ++i) {
      const Observation& o = m_.observations[i].observation;
      if (!takes_part(i) || !m_.rows[i].removable) continue;
      const bool shares = shared_centring_ && is_centred_by_profile(o);
      if (o.set_up < 0) {
        constexpr size_t kMost = 60;  // readings of one station
        const bool goes_on = shares && station >= 0 && stands_where(station, o) && blocks.back().size() < kMost &&
                             !holds(blocks.back(), o);
        if (!goes_on) blocks.emplace_back();
        blocks.back().push_back(i);
        station = shares && o.kind != ObservationKind::height_difference ? i : -1;
        continue;
      }
      station = -1;
      const double heights = std::round(1e4 * (or_zero(o.target_height) - or_zero(o.instrument_height)));
      const int occurrence = shares ? 0 : seen[{o.set_up, o.from, o.to, heights, o.kind}]++;
      const auto [at, is_new] = block_of.try_emplace(Key{o.set_up, o.from, o.to, heights, occurrence}, blocks.size());
      if (is_new) blocks.emplace_back();
      blocks[at->second].push_back(i);
    }
    for (const auto& members : blocks) add_observation_block(members);
  }

  /// What was read already is read again in another set, of which nobody says that nothing was moved before.
  bool holds(const std::vector<int>& block, const Observation& o) const {
    return std::any_of(block.begin(), block.end(), [&](int i) {
      const Observation& b = m_.observations[i].observation;
      return b.kind == o.kind && b.to == o.to && b.second_to == o.second_to;
    });
  }

  /// Angles and single sights that follow each other on one station are of one occupation.
  bool stands_where(int before, const Observation& o) const {
    const Observation& b = m_.observations[before].observation;
    return o.kind != ObservationKind::height_difference && b.from == o.from && b.source.file == o.source.file &&
           b.source.line <= o.source.line && or_zero(b.instrument_height) == or_zero(o.instrument_height);
  }

  void add_observation_block(const std::vector<int>& members) {
    auto block = std::make_unique<ObservationBlock>();
    for (const int i : members) {
      block->equations.push_back(equation(*block, i, out_));
      block->groups.push_back(group_of(m_.observations[i].observation.kind));
      if (!state_.weight_factors.empty()) block->weight_factors.push_back(state_.weight_factors[i]);
    }
    const Observation& first = m_.observations[members.front()].observation;
    set_uncertainty(*block, members, first);
    finish(std::move(block), members, first.set_up >= 0 ? m_.survey.set_ups[first.set_up].id : "");
  }

  void set_uncertainty(ObservationBlock& block, const std::vector<int>& members, const Observation& first) const {
    Eigen::VectorXd variances(members.size());
    for (size_t k = 0; k < members.size(); ++k)
      variances[static_cast<Eigen::Index>(k)] = std::pow(sigmas_(members[k]), 2);
    if (shared_centring_) {
      const Eigen::MatrixXd covariance = sight_covariance(m_, sigmas_, members);
      if (!covariance.isDiagonal(1e-12)) return set_covariance(block, covariance, name_of(first));
      variances = covariance.diagonal();
    }
    set_sigmas(block, variances.cwiseSqrt(), first);
  }

  static void set_sigmas(ObservationBlock& block, const Eigen::VectorXd& sigmas, const Observation& o) {
    try {
      block.set_sigmas(sigmas);
    } catch (const std::invalid_argument& error) {
      throw NetworkError(name_of(o) + ": " + error.what());
    }
  }

  static void set_covariance(least_squares::ResidualBlock& block, const Eigen::MatrixXd& covariance,
                             const std::string& what) {
    try {
      block.set_covariance(covariance);
    } catch (const std::invalid_argument& error) {
      throw NetworkError(what + ": " + error.what());
    }
  }

  void add_correlated_observations() {
    std::map<int, int> mean_of;  // reading -> mean observation
    for (int i = 0; i < static_cast<int>(m_.observations.size()); ++i) mean_of[m_.observations[i].members.front()] = i;
    for (const ObservationCovariance& c : m_.survey.covariances) {
      std::vector<int> members, kept;
      for (int k = 0; k < static_cast<int>(c.indices.size()); ++k) {
        const int i = mean_of.at(c.indices[k]);
        if (!takes_part(i)) continue;
        members.push_back(i);
        kept.push_back(k);
      }
      if (members.empty()) continue;
      auto block = std::make_unique<ObservationBlock>();
      for (int i : members) {
        block->equations.push_back(equation(*block, i, out_));
        block->groups.push_back(group_of(m_.observations[i].observation.kind));
      }
      Eigen::MatrixXd covariance = c.covariance(kept, kept);
      for (size_t a = 0; a < kept.size(); ++a)
        for (size_t b = 0; b < kept.size(); ++b)
          covariance(static_cast<Eigen::Index>(a), static_cast<Eigen::Index>(b)) *=
              state_.sigma_factors[block->groups[a]] * state_.sigma_factors[block->groups[b]];
      const Observation& first = m_.observations[members.front()].observation;
      set_covariance(*block, covariance,
                     "correlated observations from " + first.from + " (" + place(first.source) + ")");
      finish(std::move(block), members, "");
    }
  }

  void add_given() {
    size_t group = 0;
    for (const CoordinateGroup& g : m_.survey.coordinates) {
      auto block = std::make_unique<CoordinateBlock>();
      std::vector<int> rows;
      for (size_t k = 0; k < g.components.size(); ++k) {
        const int point = m_.index.at(g.components[k].point);
        block->equations.push_back(
            {slot(*block, out_.point_blocks[point]), g.components[k].axis, g.values[static_cast<Eigen::Index>(k)]});
        rows.push_back(m_.first_row_of_group[group] + static_cast<int>(k));
      }
      finish_given(std::move(block), g.covariance, rows, kGiven, "observed coordinates (" + place(g.source) + ")");
      ++group;
    }
    for (const VectorGroup& g : m_.survey.vectors) {
      auto block = std::make_unique<VectorBlock>();
      block->observed = g.values;
      std::vector<int> rows;
      for (const auto& v : g.vectors) {
        const int from = slot(*block, out_.point_blocks[m_.index.at(v.from)]);
        const int to = slot(*block, out_.point_blocks[m_.index.at(v.to)]);
        block->vectors.push_back({from, to, v.from_height, v.to_height});
      }
      for (int k = 0; k < g.values.size(); ++k) rows.push_back(m_.first_row_of_group[group] + k);
      if (g.is_geocentric) block->map = m_.map;
      if (g.is_geocentric && geoid_slope_ >= 0) block->slope = slot(*block, geoid_slope_);
      finish_given(std::move(block), covariance_of(g, m_), rows, kGiven, "observed vectors (" + place(g.source) + ")");
      ++group;
    }
    for (const LocalCoordinate& c : m_.survey.local_coordinates) add_local(c, m_.first_row_of_group[group++]);
  }

  void add_local(const LocalCoordinate& c, int first_row) {
    const SetUp& set_up = m_.survey.set_ups[c.set_up];
    auto block = std::make_unique<LocalCoordinateBlock>();
    block->observed = c.position;
    block->instrument_height = or_zero(set_up.instrument_height);
    block->target_height = or_zero(c.target_height);
    block->parameters = {out_.point_blocks[m_.index.at(set_up.station)], out_.point_blocks[m_.index.at(c.point)],
                         out_.orientation_blocks[c.set_up]};
    if (out_.height_correction_blocks[c.set_up] >= 0)
      block->parameters.push_back(out_.height_correction_blocks[c.set_up]);
    if (m_.map)
      block->map_scale = m_.map->scale(m_.initial[m_.index.at(set_up.station)], m_.initial[m_.index.at(c.point)]);
    const double factor = state_.sigma_factors[kLocalCoordinates];
    const Eigen::Matrix3d covariance =
        c.covariance.allFinite() ? c.covariance : polar_covariance(c.position, options_.profile);
    finish_given(std::move(block), factor * factor * covariance, {first_row, first_row + 1, first_row + 2},
                 kLocalCoordinates, "local coordinates of " + c.point + " (" + place(c.source) + ")");
  }

  void finish_given(std::unique_ptr<least_squares::ResidualBlock> block, const Eigen::MatrixXd& covariance,
                    const std::vector<int>& rows, int group, const std::string& what) {
    set_covariance(*block, covariance, what);
    block->groups.assign(rows.size(), group);
    finish(std::move(block), rows, "");
  }

  const NetworkModel& m_;
  const AdjustOptions& options_;
  const StochasticState& state_;
  ReadingSigmas sigmas_;
  bool shared_centring_;
  int geoid_slope_ = -1;  // parameter
  NetworkProblem out_;
};

}  // namespace

NetworkProblem make_problem(const NetworkModel& model, const AdjustOptions& options, const StochasticState& state) {
  return Assembler(model, options, state).assemble();
}

std::unique_ptr<ObservationBlock> single_block(const NetworkModel& model, const AdjustOptions& options,
                                               const StochasticState& state, const NetworkProblem& problem,
                                               int observation) {
  const Assembler assembler(model, options, state);
  auto block = std::make_unique<ObservationBlock>();
  block->equations.push_back(assembler.equation(*block, observation, problem));
  block->set_sigmas(Eigen::VectorXd::Constant(1, ReadingSigmas(model, options, state)(observation)));
  return block;
}

std::vector<int> datum_unknowns(const NetworkModel& model, const NetworkProblem& problem) {
  const least_squares::UnknownIndex unknowns(problem.problem);
  std::vector<int> result;
  for (size_t i = 0; i < model.ids.size(); ++i)
    for (int k = 0; k < 3; ++k)
      if (model.roles[i][k] == CoordinateRole::constrained) result.push_back(unknowns(problem.point_blocks[i], k));
  return result;
}

}  // namespace plumbline::survey
