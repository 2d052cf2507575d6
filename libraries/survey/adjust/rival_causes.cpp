// Two errors that explain the same misfit: the pole of one set-up noted too short, or that of the other too long.
// Mended either way the network agrees with itself, and its points lie elsewhere. So before anything is mended the
// others that explain nearly as much are tried, each with an adjustment of its own; in a large network, where that
// takes seconds each, by what the equations of the last one say of them.
#include <algorithm>
#include <cmath>
#include <optional>
#include <set>
#include <string>

#include "survey/adjust/adjuster.hpp"
#include "survey/words/network_words.hpp"

namespace plumbline::survey {

namespace {

constexpr double kAlike = 10.8;          // of v'Pv: 0.1 %
constexpr double kNearlyAlike = 0.9;     // of |w|: tests are of the linearised network
constexpr std::size_t kMostRivals = 8;   // each is an adjustment
constexpr double kElsewhere = 1;         // standard deviations of a coordinate
constexpr double kNoticeable = 0.00005;  // [m]

}  // namespace

std::optional<Adjuster::MendedPlaces> Adjuster::mended_places(const Pass& pass, const CommonError& error) {
  if (!pass.cofactors.is_whole() && error.rows) return places_by_equations(pass, error);
  const NetworkModel before = m_;
  const StochasticState state = state_;
  apply(error);
  std::optional<MendedPlaces> found;
  try {
    const Pass other = adjust(false);
    found.emplace();
    found->sum_of_squares = other.solution.sum_of_squares();
    for (const int block : other.problem.point_blocks)
      found->places.push_back(Eigen::Map<const Eigen::Vector3d>(other.problem.problem.parameters[block].value.data()));
  } catch (const NetworkError&) {
    found.reset();
  }
  m_ = before;
  state_ = state;
  find_set_ups_of_rows();
  return found;
}

std::optional<Adjuster::Elsewhere> Adjuster::lies_elsewhere(const Pass& pass,
                                                            const std::vector<Eigen::Vector3d>& differences) const {
  std::vector<least_squares::Functional> components;
  std::vector<Elsewhere> moved;
  std::set<std::string> stood;  // free instruments: where they stood nobody wants to know
  for (const SetUp& s : m_.survey.set_ups) stood.insert(s.station);
  for (const ResultRow& row : m_.rows) stood.erase(row.to);
  for (std::size_t i = 0; i < m_.ids.size(); ++i)
    for (int k = 0; k < 3; ++k) {
      const int unknown = pass.solution.unknowns(pass.problem.point_blocks[i], k);
      const double difference = std::abs(differences[i][k]);
      if (unknown < 0 || !(difference > kNoticeable) || stood.contains(m_.ids[i])) continue;
      components.push_back({{unknown, 1.0}});
      moved.push_back({static_cast<int>(i), difference});
    }
  if (components.empty()) return std::nullopt;
  const Eigen::VectorXd variances = pass.cofactors.variances(components);
  std::optional<Elsewhere> most;
  double clearest = kElsewhere;
  for (std::size_t k = 0; k < moved.size(); ++k) {
    const double sigmas = moved[k].by / std::sqrt(variances[static_cast<Eigen::Index>(k)]);
    if (sigmas > clearest) clearest = sigmas, most = moved[k];
  }
  return most;
}

namespace {

std::vector<Eigen::Vector3d> differences(std::vector<Eigen::Vector3d> a, const std::vector<Eigen::Vector3d>& b) {
  for (std::size_t i = 0; i < a.size(); ++i) a[i] -= b[i];
  return a;
}

}  // namespace

CommonError Adjuster::rival_of(const Pass& pass, const CommonError& worst, std::vector<CommonError> errors) {
  const auto explained = [](const CommonError& e) { return e.w * e.w - e.penalty; };
  std::erase_if(errors, [&](const CommonError& e) {
    return e.key() == worst.key() || !(explained(e) > kNearlyAlike * kNearlyAlike * explained(worst));
  });
  std::stable_sort(errors.begin(), errors.end(),
                   [&](const CommonError& a, const CommonError& b) { return explained(a) > explained(b); });
  if (errors.size() > kMostRivals) errors.resize(kMostRivals);
  if (errors.empty()) return {};
  const std::optional<MendedPlaces> mended = mended_places(pass, worst);
  if (!mended) return {};
  for (const CommonError& e : errors) {
    if (!can_be_mended(e.kind)) {
      if (explained(e) > explained(worst) - kAlike) return e;
      continue;
    }
    const std::optional<MendedPlaces> other = mended_places(pass, e);
    if (other && other->sum_of_squares < mended->sum_of_squares + kAlike &&
        lies_elsewhere(pass, differences(mended->places, other->places)))
      return e;
  }
  return {};
}

std::set<int> Adjuster::rows_of(int set_up, const std::vector<int>& sights) const {
  if (!sights.empty()) return {sights.begin(), sights.end()};
  std::set<int> rows;
  for (int row = 0; row < static_cast<int>(set_up_of_row_.size()); ++row)
    if (set_up_of_row_[row] >= 0 && (set_up < 0 || set_up_of_row_[row] == set_up)) rows.insert(row);
  return rows;
}

std::set<int> Adjuster::rows_beside(const Pass& pass, const CommonError& error) const {
  constexpr double kShadow = 0.3;  // of the largest |w| there
  std::set<int> own = rows_of(error.set_up, error.sights);
  if (!error.equal.empty()) own.merge(rows_of(error.equal_set_up, error.equal_sights));
  std::set<std::string> points;
  std::set<int> set_ups;
  for (const int row : own) {
    points.insert(m_.rows[row].to);
    set_ups.insert(set_up_of_row_[row]);
  }
  if (error.sights.empty())
    for (const int row : own) points.insert(m_.rows[row].from);
  points.erase("");
  std::set<int> rows;
  for (int row = 0; row < static_cast<int>(m_.rows.size()); ++row)
    if (points.contains(m_.rows[row].from) || points.contains(m_.rows[row].to)) rows.insert(row);
  double largest = 0;
  for (std::size_t r = 0; r < pass.problem.rows.size(); ++r)
    if (rows.contains(pass.problem.rows[r])) largest = std::max(largest, std::abs(pass.reliability.rows[r].w));
  for (std::size_t r = 0; r < pass.problem.rows.size(); ++r) {
    const int row = pass.problem.rows[r];
    if (row >= 0 && set_ups.contains(set_up_of_row_[row]) && std::abs(pass.reliability.rows[r].w) < kShadow * largest)
      rows.insert(row);
  }
  return rows;
}

}  // namespace plumbline::survey
