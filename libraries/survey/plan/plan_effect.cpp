#include "survey/plan/plan_effect.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <Eigen/QR>
#include <algorithm>
#include <array>
#include <cmath>

#include "plumbline/stop.hpp"

namespace plumbline::survey {

namespace {

using Eigen::Index;
using Eigen::Vector3d;

/// Zenith angle and slope distance of a sight as rows over the unknowns, whitened. The direction is left out: its
/// orientation unknown is not at hand and heights hardly depend on it, so the effect is slightly understated.
struct SightRows {
  std::array<int, 6> unknowns;
  Eigen::Matrix<double, 2, 6> rows;
};

SightRows rows_of(const PlanLayout& layout, const NetworkResult& network, const PlanOptions& options, Sight sight) {
  const PlannedSetUp& from = layout.set_ups()[sight.first];
  const PlannedMarker& to = layout.markers()[sight.second];
  const Vector3d d = to.position - from.position;
  const double h = d.head<2>().norm(), s = d.norm();
  const Vector3d zenith = Vector3d(d.z() * d.x() / h, d.z() * d.y() / h, -h) / (s * s);
  SightRows r;
  const auto& a = network.point(from.id).unknowns;
  const auto& b = network.point(to.id).unknowns;
  std::copy(a.begin(), a.end(), r.unknowns.begin());
  std::copy(b.begin(), b.end(), r.unknowns.begin() + 3);
  r.rows.row(0) << -zenith.transpose(), zenith.transpose();
  r.rows.row(1) << -d.transpose() / s, d.transpose() / s;
  const InstrumentProfile p = options.profile.without_instrument_centring();  // free stations
  r.rows.row(0) /= p.zenith_angle(s, options.sets, false);
  r.rows.row(1) /= p.distance(s, options.sets);
  return r;
}

bool known(const NetworkResult& network, const std::string& id) {
  return std::any_of(network.points.begin(), network.points.end(), [&](const auto& p) {
    return p.id == id && std::all_of(p.unknowns.begin(), p.unknowns.end(), [](int u) { return u >= 0; });
  });
}

/// Sights that bring the transfer to the wanted sigma, each the one that helps most after those before it.
class SightSearch {
 public:
  SightSearch(const PlanLayout& layout, const PlanPrediction& prediction, const PlanOptions& options, int lower,
              int upper)
      : layout_(layout), network_(prediction.network), options_(options), q_(prediction.network.cofactors.whole()) {
    weights_ = Eigen::VectorXd::Zero(q_.rows());
    for (const auto& [m, w] : transfer_weights(layout.seen_on_floor(lower), layout.seen_on_floor(upper)))
      weights_[network_.point(layout.markers()[m].id).unknowns[2]] += w;
    for (const Sight& sight : spare_sights(layout, [](size_t) { return true; }))
      if (known(network_, layout.set_ups()[sight.first].id) && known(network_, layout.markers()[sight.second].id))
        spare_.push_back(sight);
  }

  /// Empty if `most` sights do not suffice.
  std::vector<Sight> find(double wanted, size_t most) {
    std::vector<Sight> found;
    while (std::sqrt(std::max(0.0, weights_.dot(q_ * weights_))) > wanted) {
      if (found.size() == most || spare_.empty()) return {};
      found.push_back(take_best());
    }
    return found;
  }

 private:
  Sight take_best() {
    const Eigen::VectorXd effect = q_ * weights_;
    double most = -1;
    size_t best = 0;
    for (size_t i = 0; i < spare_.size(); ++i) {
      stop_point();
      const SightRows r = rows_of(layout_, network_, options_, spare_[i]);
      const std::vector<int> at(r.unknowns.begin(), r.unknowns.end());
      const Eigen::Vector2d g = r.rows * effect(at);
      const Eigen::Matrix2d s = r.rows * q_(at, at) * r.rows.transpose() + Eigen::Matrix2d::Identity();
      const double gain = g.dot(s.inverse() * g);
      if (gain <= most) continue;
      most = gain;
      best = i;
    }
    const Sight sight = spare_[best];
    const SightRows r = rows_of(layout_, network_, options_, sight);
    const std::vector<int> at(r.unknowns.begin(), r.unknowns.end());
    const Eigen::MatrixXd qa = q_(Eigen::all, at) * r.rows.transpose();
    const Eigen::Matrix2d s = r.rows * q_(at, at) * r.rows.transpose() + Eigen::Matrix2d::Identity();
    q_ -= qa * s.inverse() * qa.transpose();
    spare_.erase(spare_.begin() + static_cast<std::ptrdiff_t>(best));
    return sight;
  }

  const PlanLayout& layout_;
  const NetworkResult& network_;
  const PlanOptions& options_;
  Eigen::MatrixXd q_;
  Eigen::VectorXd weights_;
  std::vector<Sight> spare_;
};

}  // namespace

std::vector<Sight> spare_sights(const PlanLayout& layout, const std::function<bool(size_t)>& wanted) {
  std::vector<Sight> spare;
  for (size_t s = 0; s < layout.set_ups().size(); ++s)
    for (size_t m = 0; m < layout.markers().size(); ++m)
      if (layout.possible(s, m) && !layout.planned(s, m) && wanted(m)) spare.emplace_back(s, m);
  return spare;
}

std::vector<Sight> sights_for_transfer(const PlanLayout& layout, const PlanPrediction& prediction,
                                       const PlanOptions& options, int lower, int upper, double wanted, size_t most) {
  return SightSearch(layout, prediction, options, lower, upper).find(wanted, most);
}

double height_sigma_with(const PlanLayout& layout, const PlanPrediction& prediction, const PlanOptions& options,
                         const PlanLayout& trial, const HeightWeights& weights) {
  stop_point();
  const NetworkResult& network = prediction.network;
  Eigen::VectorXd w = Eigen::VectorXd::Zero(network.cofactors.size());
  for (const auto& [m, weight] : weights) w[network.point(layout.markers()[m].id).unknowns[2]] += weight;
  const size_t s = trial.set_ups().size() - 1;
  std::vector<size_t> seen;
  for (size_t m = 0; m < trial.markers().size(); ++m)
    if (trial.planned(s, m) && known(network, trial.markers()[m].id)) seen.push_back(m);
  const auto k = static_cast<Index>(seen.size());
  const Eigen::VectorXd effect = network.cofactors.times(w);
  if (k < 2) return std::sqrt(std::max(0.0, w.dot(effect)));
  Eigen::MatrixXd markers = Eigen::MatrixXd::Zero(3 * k, 3 * k), set_up = Eigen::MatrixXd::Zero(3 * k, 4);
  std::vector<int> at;
  for (Index i = 0; i < k; ++i) {
    const PlannedMarker& marker = trial.markers()[seen[i]];
    const Vector3d d = marker.position - trial.set_ups()[s].position;
    const double h = d.head<2>().norm(), length = d.norm();
    Eigen::Matrix3d rows;
    rows << d.y() / (h * h), -d.x() / (h * h), 0,  //
        d.z() * d.x() / (h * length * length), d.z() * d.y() / (h * length * length), -h / (length * length),
        d.x() / length, d.y() / length, d.z() / length;
    const InstrumentProfile p = options.profile.without_instrument_centring();
    const Vector3d sigmas(p.direction(h, length, options.sets, false), p.zenith_angle(length, options.sets, false),
                          p.distance(length, options.sets));
    rows = sigmas.cwiseInverse().asDiagonal() * rows;
    markers.block<3, 3>(3 * i, 3 * i) = rows;
    set_up.block<3, 3>(3 * i, 0) = -rows;
    set_up(3 * i, 3) = -1 / sigmas[0];
    const auto& unknowns = network.point(marker.id).unknowns;
    at.insert(at.end(), unknowns.begin(), unknowns.end());
  }
  const Eigen::HouseholderQR<Eigen::MatrixXd> qr(set_up);
  const Eigen::MatrixXd a = (qr.householderQ().transpose() * markers).bottomRows(3 * k - 4);
  const Eigen::VectorXd g = a * effect(at);
  const Eigen::MatrixXd sum =
      a * network.cofactors.joint(at) * a.transpose() + Eigen::MatrixXd::Identity(3 * k - 4, 3 * k - 4);
  return std::sqrt(std::max(0.0, w.dot(effect) - g.dot(sum.llt().solve(g))));
}

}  // namespace plumbline::survey
