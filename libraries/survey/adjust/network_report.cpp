// From the last adjustment to the tables of the result.
#include <algorithm>
#include <cmath>

#include "geometry/statistics.hpp"
#include "survey/adjust/adjuster.hpp"
#include "survey/doctor/network_doctor.hpp"

namespace plumbline::survey {

using least_squares::Solution;

void Adjuster::report_points(const Pass& pass, NetworkResult& result) const {
  for (size_t i = 0; i < m_.ids.size(); ++i) {
    ResultPoint point;
    point.id = m_.ids[i];
    point.roles = m_.roles[i];
    const int block = pass.problem.point_blocks[i];
    for (int k = 0; k < 3; ++k) {
      const bool exists = m_.roles[i][k] != CoordinateRole::unused;
      point.position[k] = exists ? pass.problem.problem.parameters[block].value[k] : kNotGiven;
      point.unknowns[k] = pass.solution.unknowns(block, k);
    }
    // Named by readings alone, in a file that says of each point what it is (gama-local): none of them is used.
    if (!point.position.array().isNaN().all()) result.points.push_back(std::move(point));
  }
}

void Adjuster::report_set_ups(const Pass& pass, NetworkResult& result) const {
  const auto sigma = [&](int block) {
    const int u = pass.solution.unknowns(block, 0);
    return std::sqrt(result.cofactors(u, u));
  };
  // An unknown whose standard deviation is still that of its prior was not estimated, and is not shown as if it were.
  const auto is_told = [&](int block, double prior) {
    return sigma(block) < 0.98 * prior * std::sqrt(result.variance_factor);
  };
  const auto prior_of = [&](const std::string& name) {
    return name == "scale"               ? options_.scale_sigma
           : name == "additive constant" ? options_.additive_constant_sigma
           : name == "vertical index"    ? options_.vertical_index_sigma
                                         : options_.refraction_sigma;
  };
  for (size_t i = 0; i < m_.survey.set_ups.size(); ++i) {
    ResultSetUp set_up;
    set_up.id = m_.survey.set_ups[i].id, set_up.station = m_.survey.set_ups[i].station;
    if (const int block = pass.problem.orientation_blocks[i]; block >= 0) {
      set_up.orientation = wrap_angle(pass.problem.problem.parameters[block].value[0]);
      set_up.orientation_sigma = sigma(block);
    }
    set_up.instrument_height = m_.survey.set_ups[i].instrument_height;
    if (i < m_.collimations.size()) set_up.collimation = m_.collimations[i];
    if (const int block = pass.problem.height_correction_blocks[i];
        block >= 0 && is_told(block, options_.instrument_height_sigma))
      set_up.instrument_height_correction = pass.problem.problem.parameters[block].value[0];
    if (const int block = pass.problem.tilt_blocks[i]; block >= 0 && is_told(block, options_.tilt_sigma))
      for (Eigen::Index k = 0; k < 2; ++k) set_up.tilt[k] = pass.problem.problem.parameters[block].value[k];
    result.set_ups.push_back(std::move(set_up));
  }
  for (const auto& [name, block] : pass.problem.common_blocks) {
    if (is_told(block, prior_of(name)))
      result.parameters.push_back({name, pass.problem.problem.parameters[block].value[0], sigma(block)});
    else
      m_.findings.push_back({Finding::Severity::note,
                             name + " cannot be told from these observations: it stays what was assumed before",
                             {}});
  }
  for (const int block : pass.problem.extra_blocks)
    result.parameters.push_back(
        {pass.problem.problem.parameters[block].name, pass.problem.problem.parameters[block].value[0], sigma(block)});
}

void Adjuster::report_rows(const Pass& pass, NetworkResult& result) const {
  result.rows = m_.rows;
  const auto finish = [&](ResultRow& row, const least_squares::RowStatistics& statistics) {
    row.statistics = statistics;
    row.flagged = std::abs(statistics.w) > result.critical_w;
    if (statistics.external_group >= 0) row.external_point = m_.ids[statistics.external_group];
  };
  for (size_t r = 0; r < pass.problem.rows.size(); ++r)
    if (pass.problem.rows[r] >= 0) finish(result.rows[pass.problem.rows[r]], pass.reliability.rows[r]);
  for (size_t row = 0; row < result.rows.size(); ++row) {
    if (!state_.removed[row]) continue;
    result.rows[row].removed = true;
    finish(result.rows[row], removed_statistics(pass, static_cast<int>(row)));
  }
  // Observations that cannot be used at all are told of in the findings and have no figures here.
  std::vector<ResultRow> rows;
  std::vector<int> position(result.rows.size(), -1);
  for (size_t row = 0; row < result.rows.size(); ++row) {
    if (row < m_.dropped.size() && m_.dropped[row]) continue;
    if (!result.rows[row].removed) result.readings += result.rows[row].readings;
    position[row] = static_cast<int>(rows.size());
    rows.push_back(std::move(result.rows[row]));
  }
  result.rows = std::move(rows);
  result.snooping = actions_;
  for (SnoopingAction& action : result.snooping) action.row = position[action.row];
}

void Adjuster::report_pointings(const Pass& pass, NetworkResult& result) const {
  for (size_t b = 0; b < pass.problem.problem.residuals.size(); ++b) {
    const auto& block = pass.solution.linearisation.blocks[b];
    const int row = pass.problem.rows[block.row];
    if (block.rows < 2 || row < 0 || pass.problem.block_names[b].empty()) continue;
    ResultPointing pointing;
    pointing.set_up = pass.problem.block_names[b];
    pointing.to = m_.rows[row].to;
    pointing.test = pass.reliability.blocks[b];
    if (pointing.test.rank > 0) {
      pointing.critical = chi_squared_quantile(1 - options_.alpha0, pointing.test.rank);
      pointing.flagged = pointing.test.statistic > pointing.critical;
    }
    result.pointings.push_back(std::move(pointing));
  }
}

void Adjuster::report_common_error(const Pass& pass, const std::vector<CommonError>& common, NetworkResult& result) {
  const CommonError error = largest_common_error(pass, common);
  if (error.observations == 0) return;
  result.common_error = describe(error) + (error.rival.empty() ? "" : ", or " + error.rival) +
                        (error.equal.empty() ? "" : ", or " + error.equal + ": the readings do not tell which");
  result.findings.push_back({Finding::Severity::warning,
                             result.common_error +
                                 ". This explains the misfit better than any single observation; mend it "
                                 "first, others may follow from it",
                             {}});
}

void Adjuster::report_common_estimates(const Pass& pass, const std::vector<CommonError>& common,
                                       NetworkResult& result) const {
  using Kind = CommonError::Kind;
  result.errors_taken_off = static_cast<int>(state_.extra.size());
  const double factor = std::sqrt(result.variance_factor);
  const auto put = [](ResultSetUp& s, Kind kind, const CommonEstimate& estimate) {
    if (kind == Kind::index) s.index = estimate;
    if (kind == Kind::constant) s.constant = estimate;
    if (kind == Kind::scale) s.scale = estimate;
    if (kind == Kind::height) s.instrument_height_correction = estimate.value;
  };
  for (const CommonError& e : common)
    if (e.set_up >= 0 && e.sigma > 0 && e.kind < Kind::height)
      put(result.set_ups[e.set_up], e.kind, {e.size, factor * e.sigma});
  for (size_t k = 0; k < state_.extra.size(); ++k) {
    const auto& [kind, set_up, target_height, sights] = state_.extra[k];
    const int block = pass.problem.extra_blocks[k], unknown = pass.solution.unknowns(block, 0);
    const CommonEstimate estimate{pass.problem.problem.parameters[block].value[0],
                                  std::sqrt(result.cofactors(unknown, unknown))};
    static constexpr Kind kinds[] = {Kind::constant, Kind::scale,      Kind::index,       Kind::height,
                                     Kind::target,   Kind::face_index, Kind::collimation, Kind::reflector};
    for (size_t s = 0; s < result.set_ups.size(); ++s)
      if (set_up < 0 || set_up == static_cast<int>(s)) put(result.set_ups[s], kinds[static_cast<int>(kind)], estimate);
  }
}

static CommonEstimate scale_of_all(const std::vector<CommonError>& common) {
  for (const CommonError& e : common)
    if (e.kind == CommonError::Kind::scale && e.set_up < 0 && e.sigma > 0) return {e.size, e.sigma};
  return {};
}

NetworkResult Adjuster::report(Pass& pass) {
  NetworkResult result;
  const Solution& s = pass.solution;
  result.datum = m_.datum;
  result.datum_points = m_.datum_points;
  // Constrained points of a gama-local file carry the datum only where the observations leave one open.
  if (m_.datum == DatumMode::file && s.datum.defect() == 0)
    std::erase_if(result.datum_points, [&](const std::string& id) {
      const auto& roles = m_.roles[m_.index.at(id)];
      return std::find(roles.begin(), roles.end(), CoordinateRole::fixed) == roles.end();
    });
  result.observations = s.linearisation.rows;
  result.unknowns = s.unknowns.count();
  result.defect = s.datum.defect();
  result.degrees_of_freedom = s.degrees_of_freedom();
  result.iterations = s.iterations();
  result.sum_of_squares = s.sum_of_squares();
  if (result.degrees_of_freedom > 0) result.sigma0 = std::sqrt(result.sum_of_squares / result.degrees_of_freedom);
  result.sum_of_redundancy_numbers = pass.reliability.sum_of_redundancy_numbers;
  result.global_test = least_squares::global_test(result.sum_of_squares, result.degrees_of_freedom, options_.alpha);
  result.critical_w = critical_w();
  result.critical_tau = least_squares::tau_critical(options_.alpha0, result.degrees_of_freedom);
  result.null_space = s.datum.null_space();
  const bool scale = options_.scale_with_sigma0 == Switch::on ||
                     (options_.scale_with_sigma0 == Switch::automatic && m_.survey.info.use_a_posteriori_sigma0);
  if (scale && result.degrees_of_freedom > 0) result.variance_factor = result.sigma0 * result.sigma0;
  const auto components = least_squares::variance_components(pass.problem.problem, s, pass.reliability);
  for (size_t g = 0; g < components.size() && g < kGroups; ++g)
    if (components[g].rows > 0) result.groups.push_back({kGroupNames[g], state_.sigma_factors[g], components[g]});
  report_rows(pass, result);
  const std::vector<CommonError> common = common_errors(pass);
  report_common_error(pass, common, result);
  result.undecided = undecided_, result.either = either_;
  result.known_points = compare_with_known(m_, pass.problem, s, pass.cofactors, scale);
  result.cofactors = std::move(pass.cofactors);
  if (result.variance_factor != 1) result.cofactors.multiply(result.variance_factor);
  report_points(pass, result);
  result.without_readings =
      m_.survey.observations.empty() && m_.survey.vectors.empty() && m_.survey.local_coordinates.empty();
  if (m_.map) {
    std::vector<Eigen::Vector3d> places;
    for (const ResultPoint& p : result.points)
      if (p.position.head<2>().allFinite())
        places.emplace_back(p.position.x(), p.position.y(), or_else(p.position.z(), m_.mean_height));
    result.frame = m_.map->in_words(places);
  }
  const std::string apart = tell_faces_apart(result);
  report_set_ups(pass, result);
  report_common_estimates(pass, common, result);
  report_pointings(pass, result);
  result.findings.insert(result.findings.begin(), m_.findings.begin(), m_.findings.end());
  if (result.compares_known_points()) result.findings.insert(result.findings.begin(), in_words(result.known_points));
  const std::vector<Finding> examined = examine(m_, options_, result);
  result.findings.insert(result.findings.end(), examined.begin(), examined.end());
  judge(m_, options_, critical_removal(), result);
  if (!apart.empty() && result.validity == Validity::sound)
    result.verdict += "; index and collimation of the instrument stay in what was read in one face at " + apart;
  if (tell_missing_map(m_, options_, scale_of_all(common), result) && result.validity == Validity::sound)
    result.verdict += "; lengths are those of a plane, though the coordinates look like a map's";
  return result;
}

}  // namespace plumbline::survey
