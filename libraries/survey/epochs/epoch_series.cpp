#include "survey/epochs/epoch_series.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <set>
#include <stdexcept>

#include "geometry/linear_algebra/decompositions.hpp"
#include "geometry/statistics.hpp"
#include "plumbline/stop.hpp"
#include "survey/epochs/epoch_axes.hpp"
#include "survey/epochs/epoch_mistakes.hpp"
#include "survey/epochs/epoch_motion.hpp"
#include "survey/epochs/epoch_names.hpp"
#include "survey/words/network_words.hpp"

namespace plumbline::survey {

namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;

Index row_of(const Epoch& e, const std::string& id) {
  const auto at = std::find(e.ids.begin(), e.ids.end(), id);
  return at == e.ids.end() ? -1 : static_cast<Index>(3 * (at - e.ids.begin()));
}

/// Bartlett (1937): are the variances of all epochs equal?
void test_variances_of(const std::vector<DatedEpoch>& epochs, double alpha, EpochSeries& series) {
  double f = 0, sum = 0, logs = 0, inverse = 0;
  int tested = 0;
  series.factors.assign(epochs.size(), 1);
  for (const DatedEpoch& e : epochs) {
    const int own = e.variance.degrees_of_freedom;
    if (own <= 0 || !(e.variance.sigma0 > 0)) continue;
    const double variance = e.variance.sigma0 * e.variance.sigma0;
    f += own, sum += own * variance, logs += own * std::log(variance), inverse += 1.0 / own, ++tested;
  }
  if (tested == 0) {
    series.variances = "no epoch has redundancy: the stated accuracies are taken as they are";
    return;
  }
  const double pooled = sum / f;
  series.sigma0 = std::sqrt(pooled);
  if (tested > 1) {
    const double correction = 1 + (inverse - 1 / f) / (3 * (tested - 1));
    series.bartlett = std::max(0.0, (f * std::log(pooled) - logs) / correction);
    series.bartlett_critical = chi_squared_quantile(1 - alpha, tested - 1);
  }
  const auto noisy = [&](double variance, double degrees) {
    return variance * degrees > chi_squared_quantile(1 - alpha, degrees);
  };
  const bool equal = series.bartlett <= series.bartlett_critical;
  int least = 0;
  for (size_t k = 0; k < epochs.size(); ++k) {
    const EpochVariance& v = epochs[k].variance;
    const double own = v.sigma0 * v.sigma0;
    if (equal && noisy(pooled, f)) series.factors[k] = v.applied ? 1 : pooled, least = static_cast<int>(f);
    if (!equal && v.degrees_of_freedom > 0 && noisy(own, v.degrees_of_freedom)) {
      series.factors[k] = v.applied ? 1 : own;
      least = least == 0 ? v.degrees_of_freedom : std::min(least, v.degrees_of_freedom);
    }
  }
  series.degrees_of_freedom = least;
  series.variances =
      (equal ? "the readings of all epochs are equally good, pooled sigma0 "
             : "the readings of the epochs are not equally good (Bartlett " + fixed_digits(series.bartlett, 1) +
                   ", critical " + fixed_digits(series.bartlett_critical, 1) + "), together sigma0 ") +
      fixed_digits(series.sigma0, 2);
  if (least > 0)
    series.variances += equal ? "; noisier than stated: all tests are with it"
                              : "; those noisier than stated count with what they show of themselves";
}

/// Points that no comparison with the first epoch takes out of the datum.
std::vector<std::string> stable_points(const std::vector<DatedEpoch>& epochs, const SeriesOptions& options,
                                       EpochSeries& series) {
  std::vector<std::string> stable;
  for (const std::string& id : epochs.front().epoch.ids)
    if (std::all_of(epochs.begin(), epochs.end(), [&](const DatedEpoch& e) { return row_of(e.epoch, id) >= 0; }))
      stable.push_back(id);
  ComparisonOptions compare;
  // Over all comparisons together a sound network loses a point with alpha (Sidak).
  compare.alpha = 1 - std::pow(1 - options.alpha, 1.0 / static_cast<double>(epochs.size() - 1));
  compare.alpha0 = options.alpha0;
  compare.free_motions = options.free_motions;
  compare.variance_degrees = series.degrees_of_freedom;
  std::set<std::string> out;
  Epoch first = epochs.front().epoch;
  first.covariance *= series.factors.front();
  for (size_t k = 1; k < epochs.size(); ++k) {
    stop_point();
    Epoch second = epochs[k].epoch;
    second.covariance *= series.factors[k];
    const Comparison c = compare_epochs(first, second, compare);
    for (const Exclusion& e : c.excluded) out.insert(e.id);
    if (!c.other_body.empty() && (c.bodies_are_rivals() || !series.bodies_are_rivals))
      series.two_bodies = two_bodies_in_words(c), series.bodies_are_rivals = c.bodies_are_rivals();
    for (const Movement& m : c.movements)
      if (m.moved) out.insert(m.id);
  }
  std::erase_if(stable, [&](const std::string& id) { return out.contains(id); });
  return stable;
}

/// Brings an epoch into the datum of the stable points: laid on them, covariance S C S'.
void align(const Epoch& reference, const std::vector<std::string>& stable, int free_motions, Epoch& epoch) {
  if (free_motions == 0) return;
  Vector3d from = Vector3d::Zero(), to = Vector3d::Zero(), count = Vector3d::Zero();
  const auto each = [&](const auto& use) {
    for (const std::string& id : stable)
      use(Vector3d(epoch.coordinates.segment<3>(row_of(epoch, id))),
          Vector3d(reference.coordinates.segment<3>(row_of(reference, id))));
  };
  each([&](const Vector3d& a, const Vector3d& b) {
    for (Index c = 0; c < 3; ++c)
      if (std::isfinite(a[c]) && std::isfinite(b[c])) from[c] += a[c], to[c] += b[c], ++count[c];
  });
  from = from.cwiseQuotient(count.cwiseMax(1)), to = to.cwiseQuotient(count.cwiseMax(1));
  double sine = 0, cosine = 0;
  if (free_motions >= 4)
    each([&](const Vector3d& a, const Vector3d& b) {
      const Eigen::Vector2d p = (a - from).head<2>(), q = (b - to).head<2>();
      if (!p.allFinite() || !q.allFinite()) return;
      cosine += p.dot(q), sine += p.x() * q.y() - p.y() * q.x();
    });
  const double angle = std::atan2(sine, cosine);
  Matrix3d turn = Matrix3d::Identity();
  turn.topLeftCorner<2, 2>() << std::cos(angle), -std::sin(angle), std::sin(angle), std::cos(angle);
  // Inner constraints on the stable points: x' = x - G (E'G)^-1 E' x, G about their centre.
  const Index n = epoch.coordinates.size() / 3;
  MatrixXd g = MatrixXd::Zero(3 * n, free_motions >= 4 ? 4 : 3), e = g;
  std::set<Index> held;
  for (const std::string& id : stable) held.insert(row_of(epoch, id));
  for (Index i = 0; i < n; ++i) {
    auto p = epoch.coordinates.segment<3>(3 * i);
    const Vector3d d = p - from;
    for (Index c = 0; c < 3; ++c) g(3 * i + c, c) = std::isfinite(p[c]) ? 1 : 0;
    if (g.cols() > 3 && d.head<2>().allFinite()) g.block<2, 1>(3 * i, 3) = Eigen::Vector2d(d.y(), -d.x());
    if (held.contains(3 * i)) e.middleRows(3 * i, 3) = g.middleRows(3 * i, 3);
    Vector3d laid(d.x() * turn(0, 0) + d.y() * turn(0, 1), d.x() * turn(1, 0) + d.y() * turn(1, 1), d.z());
    p = laid + to;
  }
  std::vector<Index> moving;
  for (Index k = 0; k < g.cols(); ++k)
    if (e.col(k).cwiseAbs().maxCoeff() > 0) moving.push_back(k);
  const MatrixXd of = g(Eigen::all, moving), on = e(Eigen::all, moving);
  const MatrixXd h = linear_algebra::solve_symmetric(on.transpose() * of, on.transpose());
  MatrixXd s = MatrixXd::Identity(3 * n, 3 * n) - of * h;
  for (Index i = 0; i < n; ++i) s.middleRows(3 * i, 3) = (turn * s.middleRows(3 * i, 3)).eval();  // and turned with it
  epoch.covariance = (s * epoch.covariance * s.transpose()).eval();
}

void require_series(const std::vector<DatedEpoch>& epochs, const SeriesOptions& options) {
  if (epochs.size() < 2) throw std::runtime_error("a series needs two epochs at least");
  for (size_t k = 1; k < epochs.size(); ++k)
    if (!(epochs[k].time > epochs[k - 1].time))
      throw std::runtime_error("epoch " + epochs[k].name + " is not later than " + epochs[k - 1].name +
                               ": give the epochs in the order of their times");
  if (options.free_motions != 0 && options.free_motions != 3 && options.free_motions != 4)
    throw std::runtime_error(
        "a series of epochs that are free in scale or tilt is not compared; hold them, or compare two");
  for (const std::string& id : options.stable)
    for (const DatedEpoch& e : epochs)
      if (row_of(e.epoch, id) < 0)
        throw std::runtime_error("point '" + id + "' is to carry the datum, and epoch " + e.name + " has not seen it");
}

/// Points that carry the datum: those that were named, else those that stayed. Named ones that moved are noted.
void choose_datum(const std::vector<DatedEpoch>& epochs, const SeriesOptions& options, EpochSeries& series) {
  series.stable = stable_points(epochs, options, series);
  if (!options.stable.empty()) {
    for (const std::string& id : options.stable)
      if (std::find(series.stable.begin(), series.stable.end(), id) == series.stable.end())
        series.contradicted.push_back(id);
    series.stable = options.stable;
  }
  const size_t needed = options.free_motions == 0 ? 0 : options.free_motions == 3 ? 1 : 2;
  if (series.stable.size() < needed)
    throw std::runtime_error("only " + std::to_string(series.stable.size()) +
                             " points have stayed in all epochs: name those that carry the datum (stable)");
}

/// All epochs in the datum of the stable points.
struct LaidEpochs {
  std::vector<double> times;
  std::vector<Epoch> epochs;
  std::vector<Eigen::VectorXd> before;  ///< variances, not yet in that datum

  LaidEpochs(const std::vector<DatedEpoch>& dated, const EpochSeries& series, int free_motions) {
    for (size_t k = 0; k < dated.size(); ++k) {
      stop_point();
      times.push_back(dated[k].time);
      Epoch& laid = epochs.emplace_back(dated[k].epoch);
      laid.covariance *= series.factors[k];
      // What does not exist has no variance either.
      laid.covariance = laid.covariance.array().isFinite().select(laid.covariance, 0.0).eval();
      before.push_back(laid.covariance.diagonal());
      align(dated.front().epoch, series.stable, free_motions, laid);
    }
  }

  /// Points of all epochs, each once, in the order in which they appear.
  std::vector<std::string> ids() const {
    std::vector<std::string> all;
    std::set<std::string> known;
    for (const Epoch& e : epochs)
      for (const std::string& id : e.ids)
        if (known.insert(id).second) all.push_back(id);
    return all;
  }
};

/// A point in the epochs that have it, and which of its axes are compared.
struct FollowedPoint {
  std::vector<SeenPoint> seen;
  std::vector<std::array<Measured, 3>> measured;
  std::array<bool, 3> compared{};

  FollowedPoint(const LaidEpochs& laid, const std::string& id, NotCompared& not_compared) {
    std::vector<size_t> numbers;
    for (size_t k = 0; k < laid.epochs.size(); ++k) {
      const Index row = row_of(laid.epochs[k], id);
      if (row < 0) continue;
      const Epoch& e = laid.epochs[k];
      seen.push_back({k,
                      laid.times[k],
                      e.coordinates.segment<3>(row),
                      e.covariance.block<3, 3>(row, row),
                      laid.before[k].segment<3>(row),
                      {}});
      numbers.push_back(k);
      auto& of = measured.emplace_back();
      for (Index c = 0; c < 3; ++c)
        of[c] = !std::isfinite(seen.back().at[c]) ? Measured::missing
                : seen.back().before[c] > 0       ? Measured::yes
                                                  : Measured::held;
    }
    compared = compared_axes(measured);
    not_compared.add(id, measured, numbers, compared);
    for (size_t k = 0; k < seen.size(); ++k)
      for (size_t c = 0; c < 3; ++c) seen[k].compared[c] = compared[c] && measured[k][c] == Measured::yes;
    std::erase_if(seen, [](const SeenPoint& s) { return s.axes().empty(); });
  }

  bool lacks_velocity(const SeriesPoint& point) const {
    for (size_t c = 0; c < 3; ++c)
      if (compared[c] && !std::isfinite(point.velocity[static_cast<Index>(c)])) return true;
    return false;
  }
};

}  // namespace

std::vector<const SeriesPoint::At*> SeriesPoint::latest() const {
  std::vector<const At*> found;
  for (Index c = 0; c < 3; ++c) {
    const auto last = std::find_if(at.rbegin(), at.rend(), [&](const At& a) { return std::isfinite(a.movement[c]); });
    if (last != at.rend() && std::find(found.begin(), found.end(), &*last) == found.end()) found.push_back(&*last);
  }
  std::sort(found.begin(), found.end(), [](const At* a, const At* b) { return a->epoch > b->epoch; });
  return found;
}

Level SeriesPoint::latest_alarm() const {
  Level highest = Level::below;
  for (const At* a : latest()) highest = std::max(highest, a->alarm);
  return highest;
}

Level SeriesPoint::latest_warning() const {
  Level highest = Level::below;
  for (const At* a : latest()) highest = std::max(highest, a->warning);
  return highest;
}

std::optional<double> day_of_date(const std::string& date) {
  int part[3] = {0, 0, 0};
  const char* at = date.data();
  const char* const end = at + std::min<size_t>(date.size(), 10);
  for (int k = 0; k < 3; ++k) {
    const auto read = std::from_chars(at, end, part[k]);
    if (read.ec != std::errc()) return std::nullopt;
    at = read.ptr;
    if (k < 2 && (at == end || (*at != '-' && *at != '.'))) return std::nullopt;
    if (k < 2) ++at;
  }
  if (part[0] <= 31 && part[2] > 1900) {
    if (date.find('-') < 4) std::swap(part[0], part[1]);
    std::swap(part[0], part[2]);
  }
  int y = part[0];
  const int m = part[1], d = part[2];
  if (y < 1900 || y > 2200 || m < 1 || m > 12 || d < 1 || d > 31) return std::nullopt;
  y -= m <= 2;  // Hinnant, days from civil
  const int era = y / 400, of_era = y - era * 400, of_year = (153 * (m + (m > 2 ? -3 : 9)) + 2) / 5 + d - 1;
  return era * 146097 + of_era * 365 + of_era / 4 - of_era / 100 + of_year - 719468;
}

EpochSeries epoch_series(const std::vector<DatedEpoch>& epochs, const SeriesOptions& options) {
  require_series(epochs, options);
  EpochSeries series;
  test_variances_of(epochs, options.alpha, series);
  choose_datum(epochs, options, series);
  const LaidEpochs laid(epochs, series, options.free_motions);
  NotCompared not_compared;
  std::vector<std::string> without_velocity;
  for (const std::string& id : laid.ids()) {
    stop_point();
    const FollowedPoint followed(laid, id, not_compared);
    if (followed.seen.empty()) {
      series.seen_once.push_back(id);
      continue;
    }
    SeriesPoint point;
    point.id = id;
    point.stable = std::find(series.stable.begin(), series.stable.end(), id) != series.stable.end();
    add_movements(followed.seen, options, series.degrees_of_freedom, point);
    add_velocity(followed.seen, options, series.degrees_of_freedom, point);
    if (followed.lacks_velocity(point)) without_velocity.push_back(id);
    series.points.push_back(std::move(point));
  }
  std::vector<std::string> names;
  std::vector<NamedEpoch> named;
  for (const DatedEpoch& e : epochs) names.push_back(e.name), named.push_back({e.name, e.epoch.ids});
  series.not_followed = names_not_followed(named);
  series.not_compared = not_compared.words(names);
  if (!without_velocity.empty())
    series.not_compared.push_back(
        "no velocity in every direction of " + join(without_velocity) +
        ": one epoch only leaves some direction there free, the others have it from the datum");
  return series;
}

}  // namespace plumbline::survey
