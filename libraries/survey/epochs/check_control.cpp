#include "survey/epochs/check_control.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numeric>
#include <set>
#include <utility>

#include "geometry/statistics.hpp"
#include "survey/network/held_points.hpp"
#include "survey/words/network_words.hpp"

namespace plumbline::survey {

namespace {

/// Points as one epoch; `survey` adds those that its files hold fixed, or have as known, each coordinate then with
/// `known_sigma` [m].
Epoch given_points(const SurveyObservations& survey, const ControlPoints& control, double known_sigma) {
  Epoch e{control.ids, control.coordinates, control.covariance};
  std::vector<Eigen::Index> keyed_in;
  const auto n = static_cast<Eigen::Index>(3 * control.ids.size());
  if (e.covariance.rows() != n) e.covariance = Eigen::MatrixXd::Zero(n, n);
  if (n == 0) e.coordinates.resize(0);
  for (const Point& p : survey.points) {
    const bool known = std::all_of(p.known.begin(), p.known.end(), [](bool k) { return k; });
    const bool fixed = known || std::all_of(p.roles.begin(), p.roles.end(),
                                            [](CoordinateRole r) { return r == CoordinateRole::fixed; });
    if (!fixed || !p.coordinates.allFinite() || std::find(e.ids.begin(), e.ids.end(), p.id) != e.ids.end()) continue;
    const Eigen::Index old = e.coordinates.size();
    e.ids.push_back(p.id);
    e.coordinates.conservativeResize(old + 3);
    e.coordinates.tail<3>() = p.coordinates;
    const Eigen::MatrixXd covariance = e.covariance;
    e.covariance = Eigen::MatrixXd::Zero(old + 3, old + 3);
    e.covariance.topLeftCorner(old, old) = covariance;
    for (Eigen::Index i = old; known && i < old + 3; ++i) keyed_in.push_back(i);
  }
  std::vector<double> written;  // without a standard deviation
  for (Eigen::Index i = 0; i < e.covariance.rows(); ++i)
    if (e.covariance(i, i) == 0 && std::isfinite(e.coordinates[i])) written.push_back(e.coordinates[i]);
  const double rounding = rounding_variance(written);
  for (Eigen::Index i = 0; i < e.covariance.rows(); ++i)
    if (e.covariance(i, i) == 0) e.covariance(i, i) = rounding;
  for (const Eigen::Index i : keyed_in) e.covariance(i, i) = std::max(rounding, known_sigma * known_sigma);
  return e;
}

/// Coordinate groups given as control would hold the free network; they are what is tested.
SurveyObservations without_control(const SurveyObservations& survey) {
  SurveyObservations free = survey;
  std::erase_if(free.coordinates, [](const CoordinateGroup& g) { return g.is_control; });
  return free;
}

/// On a map a free network still has to know where it lies, or its lengths have no scale: there the given coordinates
/// are approximate ones.
void place_on_map(const Epoch& given, SurveyObservations& free) {
  for (size_t i = 0; i < given.ids.size(); ++i) {
    const Eigen::Vector3d at = given.coordinates.segment<3>(static_cast<Eigen::Index>(3 * i));
    const auto known =
        std::find_if(free.points.begin(), free.points.end(), [&](const Point& p) { return p.id == given.ids[i]; });
    if (known == free.points.end()) {
      Point& added = free.points.emplace_back();
      added.id = given.ids[i];
      added.coordinates = at;
    } else if (known->coordinates.array().isNaN().any()) {
      known->coordinates = at;
    }
  }
}

/// Points that both epochs have, in plan: east + i·north. In space a figure that lies flat could be turned over.
struct Pairs {
  std::vector<std::complex<double>> given, measured;
};

Pairs common_points(const Epoch& given, const Epoch& measured) {
  Pairs pairs;
  for (size_t i = 0; i < given.ids.size(); ++i) {
    const auto at = std::find(measured.ids.begin(), measured.ids.end(), given.ids[i]);
    if (at == measured.ids.end()) continue;
    const Eigen::Vector2d a = given.coordinates.segment<2>(static_cast<Eigen::Index>(3 * i));
    const Eigen::Vector2d b = measured.coordinates.segment<2>(3 * (at - measured.ids.begin()));
    if (!a.allFinite() || !b.allFinite()) continue;
    pairs.given.emplace_back(a.x(), a.y());
    pairs.measured.emplace_back(b.x(), b.y());
  }
  return pairs;
}

/// Rms of given − (a·measured + b), least squares, over the extent of the given points, and the scale |a|.
std::pair<double, double> misfit(const Pairs& pairs) {
  const auto n = static_cast<double>(pairs.given.size());
  const std::complex<double> g = std::accumulate(pairs.given.begin(), pairs.given.end(), std::complex<double>{}) / n;
  const std::complex<double> m =
      std::accumulate(pairs.measured.begin(), pairs.measured.end(), std::complex<double>{}) / n;
  std::complex<double> product;
  double given = 0, measured = 0;
  for (size_t i = 0; i < pairs.given.size(); ++i) {
    product += std::conj(pairs.measured[i] - m) * (pairs.given[i] - g);
    given += std::norm(pairs.given[i] - g), measured += std::norm(pairs.measured[i] - m);
  }
  if (!(given > 0 && measured > 0)) return {1, 1};
  return {std::sqrt(std::max(0.0, given - std::norm(product) / measured) / given), std::abs(product) / measured};
}

/// A misfit that all points share.
std::string cause_of(Pairs pairs) {
  constexpr double kFits = 0.002;  // of the extent: 20 mm in 10 m
  if (pairs.given.size() < 3) return "";
  const auto [rest, scale] = misfit(pairs);
  static const std::pair<double, const char*> units[] = {
      {3.28084, "the given coordinates are in feet, the distances in metres"},
      {0.3048, "the given coordinates are in metres, the distances in feet"},
      {1000, "the given coordinates are in millimetres, the distances in metres"},
      {0.001, "the given coordinates are in metres, the distances in millimetres"},
      {100, "the given coordinates are in centimetres, the distances in metres"}};
  for (const auto& [factor, words] : units)
    if (rest < kFits && std::abs(scale / factor - 1) < 0.005) return words;
  if (rest < kFits) return "";
  for (auto& p : pairs.given) p = {p.imag(), p.real()};
  const auto [exchanged, exchanged_scale] = misfit(pairs);
  if (exchanged < kFits && std::abs(exchanged_scale - 1) < 0.005)
    return "east and north of the given coordinates are exchanged, or one of them has the wrong sign";
  return "";
}

}  // namespace

Epoch epoch_of(const NetworkResult& network, const std::vector<std::string>& only) {
  const std::set<std::string> wanted(only.begin(), only.end());
  Epoch e;
  std::vector<size_t> numbers;
  for (size_t i = 0; i < network.points.size(); ++i) {
    if (!wanted.empty() && !wanted.contains(network.points[i].id)) continue;
    e.ids.push_back(network.points[i].id);
    numbers.push_back(i);
  }
  e.coordinates.resize(static_cast<Eigen::Index>(3 * e.ids.size()));
  for (size_t i = 0; i < e.ids.size(); ++i)
    e.coordinates.segment<3>(static_cast<Eigen::Index>(3 * i)) = network.points[numbers[i]].position;
  e.covariance = wanted.empty() ? network.full_covariance() : network.covariance_of(numbers);
  return e;
}

int merged_motions(int first_defect, int second_defect, const Epoch& epoch) {
  const int larger = std::max(first_defect, second_defect), smaller = std::min(first_defect, second_defect);
  bool plan = false, height = false;
  for (Eigen::Index i = 0; i + 2 < epoch.coordinates.size(); i += 3) {
    plan |= std::isfinite(epoch.coordinates[i]) && std::isfinite(epoch.coordinates[i + 1]);
    height |= std::isfinite(epoch.coordinates[i + 2]);
  }
  if (!plan) return larger > 0 ? 3 : 0;                          // levelling: a lift
  if (!height) return larger < 2 ? 0 : std::min(5, larger + 1);  // plane: the lift is not among its defects
  if (larger == 6 && smaller == 5) return 7;                     // tilts of one, scale of the other
  return larger < 3 ? 0 : std::min(7, larger);
}

namespace {

/// The given points in a free network of the readings, and by what it may lie elsewhere.
Epoch measured_freely(const SurveyObservations& survey, const Epoch& given, AdjustOptions adjustment, int& motions) {
  adjustment.datum = DatumMode::inner;
  adjustment.datum_points.clear();
  SurveyObservations free = without_control(survey);
  if (!adjustment.map.empty()) place_on_map(given, free);
  const NetworkResult r = adjust_network(free, adjustment);
  Epoch everywhere;  // its coordinates only
  everywhere.coordinates.resize(static_cast<Eigen::Index>(3 * r.points.size()));
  for (size_t i = 0; i < r.points.size(); ++i)
    everywhere.coordinates.segment<3>(static_cast<Eigen::Index>(3 * i)) = r.points[i].position;
  motions = merged_motions(r.defect, 0, everywhere);
  return epoch_of(r, given.ids);
}

Epoch measured_with_the_network(const MeasuredControl& measured, const Epoch& given, int& motions) {
  const Epoch all{measured.ids, measured.coordinates, measured.covariance};
  motions = merged_motions(measured.defect, 0, all);
  std::vector<char> keep;
  for (const std::string& id : all.ids)
    keep.push_back(std::find(given.ids.begin(), given.ids.end(), id) != given.ids.end());
  return part_of(all, keep);
}

}  // namespace

ControlCheck check_control(const SurveyObservations& survey, const ControlPoints& control, AdjustOptions adjustment,
                           ComparisonOptions options, const MeasuredControl& known) {
  ControlCheck check;
  const Epoch given = given_points(survey, control, adjustment.known_sigma);
  if (given.ids.empty()) {
    check.problem = "there are no control points to check";
    return check;
  }
  try {
    const Epoch measured = known.ids.empty() ? measured_freely(survey, given, std::move(adjustment), check.free_motions)
                                             : measured_with_the_network(known, given, check.free_motions);
    options.free_motions = check.free_motions;
    const size_t common = measured.ids.size();
    if (common < 3) {
      check.problem = "the control points cannot be checked: " + std::to_string(common) +
                      " of them are observed, a check needs at least three";
      return check;
    }
    check.cause = cause_of(common_points(given, measured));
    check.comparison = compare_epochs(given, measured, options);
  } catch (const NetworkError& error) {
    check.problem =
        std::string("the control points cannot be checked, the free network is not determined: ") + error.what();
  } catch (const std::runtime_error& error) {
    check.problem = std::string("the control points cannot be checked: ") + error.what();
  }
  return check;
}

bool doubt_failed_control(const SurveyObservations& survey, const ControlPoints& control, double known_sigma,
                          NetworkResult& r) {
  constexpr double kAlpha = 0.001;    // as the global test: each point by itself is tested beside
  constexpr double kClearly = 0.001;  // readings worse than stated by more than chance: measured by their own agreement
  MeasuredControl measured = r.measured_control;
  const bool single =
      std::any_of(r.known_points.begin(), r.known_points.end(), [](const KnownPoint& k) { return !k.stands(); });
  if (measured.ids.empty() || r.datum == DatumMode::inner || single) return false;
  const int degrees = measured.degrees_of_freedom;
  bool estimated = r.variance_factor != 1;
  if (!estimated && degrees > 0 && measured.sum_of_squares > chi_squared_quantile(1 - kClearly, degrees))
    measured.covariance *= measured.sum_of_squares / degrees, estimated = true;
  ComparisonOptions options;
  options.alpha = kAlpha;
  if (estimated) options.variance_degrees = degrees;
  AdjustOptions adjustment;
  adjustment.known_sigma = known_sigma;
  const ControlCheck check = check_control(survey, control, adjustment, options, measured);
  if (!check.problem.empty() || check.comparison.congruent) return false;
  r.findings.push_back({Finding::Severity::warning,
                        "the control as a whole does not fit the readings: test statistic " +
                            fixed_digits(check.comparison.statistic, 1) + ", critical value " +
                            fixed_digits(check.comparison.critical, 1) + " at rank " +
                            std::to_string(check.comparison.rank),
                        {},
                        Finding::Subject::control});
  if (r.validity == Validity::sound) {
    r.validity = Validity::doubtful;
    r.verdict = "doubtful: the control does not fit the readings; of the readings: " + r.verdict;
  }
  return true;
}

}  // namespace plumbline::survey
