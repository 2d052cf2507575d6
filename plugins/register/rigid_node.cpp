// register.rigid: equations (6), (7) and (8) of a free block against surveyed control.
#include <cmath>
#include <map>

#include "artifacts/points.hpp"
#include "artifacts/transform.hpp"
#include "geometry/packed_symmetric.hpp"
#include "plumbline/node.hpp"
#include "registration/robust_registration.hpp"

namespace {

using namespace plumbline;
namespace reg = plumbline::registration;

/// Index of every point by its id. Throws for an id that stands twice.
std::map<std::string, int> index_of(const PointsT& points, const char* port) {
  std::map<std::string, int> index;
  for (size_t i = 0; i < points.points.size(); ++i)
    if (!index.emplace(points.points[i]->id, static_cast<int>(i)).second)
      throw std::runtime_error(std::string("'") + port + "' has two points named " + points.points[i]->id);
  return index;
}

/// The full covariance if it is there, else that of the sigmas, else an empty matrix.
Eigen::MatrixXd covariance_of(const PointsT& points, const char* port) {
  const std::size_t n = 3 * points.points.size();
  if (!points.covariance.empty()) return unpack_symmetric(points.covariance, n, std::string("'") + port + "'");
  Eigen::MatrixXd c = Eigen::MatrixXd::Zero(n, n);
  for (size_t i = 0; i < points.points.size(); ++i) {
    const Eigen::Vector3d& sigma = points.points[i]->sigma;
    if (!sigma.allFinite()) return {};
    c.diagonal().segment<3>(static_cast<Eigen::Index>(3 * i)) = sigma.cwiseAbs2();
  }
  return c;
}

Eigen::Matrix3Xd positions_of(const PointsT& points) {
  Eigen::Matrix3Xd p(3, static_cast<Eigen::Index>(points.points.size()));
  for (size_t i = 0; i < points.points.size(); ++i) p.col(static_cast<Eigen::Index>(i)) = points.points[i]->position;
  return p;
}

Eigen::MatrixXd part(const Eigen::MatrixXd& c, const std::vector<int>& chosen) {
  if (c.size() == 0) return {};
  const auto n = static_cast<Eigen::Index>(chosen.size());
  Eigen::MatrixXd out(3 * n, 3 * n);
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = 0; j < n; ++j)
      out.block<3, 3>(3 * i, 3 * j) =
          c.block<3, 3>(3 * chosen[static_cast<size_t>(i)], 3 * chosen[static_cast<size_t>(j)]);
  return out;
}

std::vector<double> upper_of(const Eigen::Matrix3d& m) {
  return {m(0, 0), m(0, 1), m(0, 2), m(1, 1), m(1, 2), m(2, 2)};
}

struct RegisterRigid : Node {
  static constexpr Info info{"register.rigid", "registrar", 2,
                             "Weighted rigid or similarity registration of points to control, (6), (7) and (8)"};
  In<Points> source{"source", frame("frame=?S"), "points to move; those with role check never take part in the fit"};
  In<Points> target{"target", frame("frame=?T"),
                    "control, matched by id; those with role check never take part in the fit"};
  Out<Transform> transform{"transform", frame("to=?T,from=?S"), "the transform, its covariance, residuals, and (8)"};
  Out<Points> points{"points", frame("frame=?T"), "all source points in the target frame, with propagated covariance"};
  Param<std::string> weights{
      "weights", "auto", one_of("auto", "equal", "scalar", "covariance"),
      "equal; scalar: one weight a point from its variances; covariance: the full covariance of both sides; "
      "auto: covariance if either side has one, else equal"};
  Param<std::string> scale{"scale", "fixed", one_of("fixed", "estimated", "tested"),
                           "6 or 7 parameters; tested: 7 if the scale differs from 1 at 1 %, else 6"};
  Param<std::string> estimator{
      "estimator", "least_squares",
      one_of("least_squares", "huber", "cauchy", "tukey", "geman_mcclure", "truncated", "ransac"),
      "(6), or a robust cost (7); truncated: truncated least squares by graduated non-convexity"};
  Param<double> threshold{"threshold", 0.0, "sigma", at_least(0),
                          "residual in space at which the cost departs from squares or a point is rejected; 0: the "
                          "estimator's own"};
  Param<double> sigma{"sigma", 0.0, "m", at_least(0),
                      "robust with equal weights: standard deviation of a coordinate difference; 0: from the points"};
  Param<double> min_width_ratio{
      "min_width_ratio", 0.01, "1", between(0, 1),
      "a figure of control points narrower than this against its length is refused as a line"};

  void run(Context& context) override {
    const PointsT from = source.unpack(), to = target.unpack();
    const Eigen::MatrixXd from_covariance = covariance_of(from, "source"), to_covariance = covariance_of(to, "target");
    std::vector<int> chosen_from, chosen_to;
    reg::Correspondences c = match(from, to, chosen_from, chosen_to);
    c.source_covariance = part(from_covariance, chosen_from);
    c.target_covariance = part(to_covariance, chosen_to);

    reg::RobustOptions how = options(c);
    reg::RobustRegistration result = reg::register_robust(c, how);
    double scale_w = std::nan("");
    if (how.fit.estimate_scale) {
      const double variance = result.fit.centred_covariance(6, 6);
      scale_w = variance > 0 ? (result.fit.scale - 1) / std::sqrt(variance) : std::nan("");
      constexpr double significant = 2.5758;  // two-sided, 1 %
      if (*scale == "tested" && std::abs(scale_w) < significant) {
        how.fit.estimate_scale = false;
        result = reg::register_robust(c, how);
      }
    }
    for (size_t i = 0; i < c.ids.size(); ++i)
      if (result.weights(static_cast<Eigen::Index>(i)) <= 0)
        context.warn("rejected: " + c.ids[i] + " is " +
                     std::to_string(1e3 * result.residuals.col(static_cast<Eigen::Index>(i)).norm()) +
                     " mm from where the other points have it");
    context.metric("sigma0", result.fit.sigma0, "1");
    transform.commit(transform_artifact(c, result, scale_w));
    points.commit(points_artifact(from, to, move(c, result, positions_of(from), from_covariance, chosen_from)));
  }

 private:
  reg::RobustOptions options(const reg::Correspondences& c) const {
    static const std::map<std::string, reg::Estimator> estimators = {{"least_squares", reg::Estimator::least_squares},
                                                                     {"huber", reg::Estimator::huber},
                                                                     {"cauchy", reg::Estimator::cauchy},
                                                                     {"tukey", reg::Estimator::tukey},
                                                                     {"geman_mcclure", reg::Estimator::geman_mcclure},
                                                                     {"truncated", reg::Estimator::truncated},
                                                                     {"ransac", reg::Estimator::ransac}};
    reg::RobustOptions o;
    const bool known = c.source_covariance.size() > 0 || c.target_covariance.size() > 0;
    if (*weights == "scalar") o.fit.weighting = reg::Weighting::scalar;
    if (*weights == "covariance" || (*weights == "auto" && known)) o.fit.weighting = reg::Weighting::covariance;
    o.fit.estimate_scale = *scale != "fixed";
    o.fit.min_width_ratio = *min_width_ratio;
    o.estimator = estimators.at(*estimator);
    o.threshold = *threshold;
    o.sigma = *sigma;
    return o;
  }

  /// All source points, with the errors of those that took part acting twice.
  static reg::MovedPoints move(const reg::Correspondences& c, const reg::RobustRegistration& result,
                               const Eigen::Matrix3Xd& positions, const Eigen::MatrixXd& covariance,
                               const std::vector<int>& chosen) {
    std::vector<int> fitted;
    for (int i : result.used) fitted.push_back(chosen[static_cast<size_t>(i)]);
    return reg::move_points(result.fit, positions, covariance, fitted, part(c.target_covariance, result.used));
  }

  static reg::Correspondences match(const PointsT& from, const PointsT& to, std::vector<int>& chosen_from,
                                    std::vector<int>& chosen_to) {
    const auto index = index_of(from, "source");
    index_of(to, "target");
    reg::Correspondences c;
    for (size_t k = 0; k < to.points.size(); ++k) {
      const PointT& point = *to.points[k];
      const auto other = index.find(point.id);
      if (other == index.end() || point.role == "check" ||
          from.points[static_cast<size_t>(other->second)]->role == "check")
        continue;
      c.ids.push_back(point.id);
      chosen_from.push_back(other->second);
      chosen_to.push_back(static_cast<int>(k));
    }
    const auto n = static_cast<Eigen::Index>(c.ids.size());
    c.source.resize(3, n);
    c.target.resize(3, n);
    for (Eigen::Index i = 0; i < n; ++i) {
      c.source.col(i) = from.points[static_cast<size_t>(chosen_from[static_cast<size_t>(i)])]->position;
      c.target.col(i) = to.points[static_cast<size_t>(chosen_to[static_cast<size_t>(i)])]->position;
    }
    if (n < 3)
      throw reg::DegenerateRegistration("a registration needs at least 3 points that both 'source' (" +
                                        std::to_string(from.points.size()) + " points) and 'target' (" +
                                        std::to_string(to.points.size()) +
                                        " points) have and that are not check points; found " + std::to_string(n));
    return c;
  }

  TransformT transform_artifact(const reg::Correspondences& c, const reg::RobustRegistration& result,
                                double scale_w) const {
    const reg::Registration& found = result.fit;
    TransformT t;
    t.estimator = *estimator;
    t.scale_w = scale_w;
    t.to_from_from = found.to_from_from;
    t.scale = found.scale;
    t.covariance = pack_symmetric(found.covariance);
    for (size_t i = 0; i < c.ids.size(); ++i) {
      auto residual = std::make_unique<RegistrationResidualT>();
      residual->id = c.ids[i];
      residual->residual = result.residuals.col(static_cast<Eigen::Index>(i));
      residual->weight = result.weights(static_cast<Eigen::Index>(i));
      residual->w = result.w.col(static_cast<Eigen::Index>(i));
      t.residuals.push_back(std::move(residual));
    }
    t.residual_covariance = upper_of(found.residual_covariance);
    t.residual_covariance_unbiased = upper_of(found.residual_covariance_unbiased);
    t.statistics = std::make_unique<StatisticsT>();
    t.statistics->sigma0 = found.sigma0;
    t.statistics->degrees_of_freedom = found.degrees_of_freedom;
    t.statistics->weighted_sum_of_squares = found.weighted_sum_of_squares;
    t.statistics->observations = static_cast<int64_t>(3 * result.used.size());
    t.statistics->unknowns = found.unknowns;
    return t;
  }

  static PointsT points_artifact(const PointsT& from, const PointsT& to, const reg::MovedPoints& moved) {
    std::map<std::string, std::string> roles;
    for (const auto& point : to.points) roles[point->id] = point->role;
    PointsT result;
    for (size_t i = 0; i < from.points.size(); ++i) {
      auto point = std::make_unique<PointT>(*from.points[i]);
      const auto k = static_cast<Eigen::Index>(i);
      point->position = moved.positions.col(k);
      point->sigma.setConstant(std::nan(""));
      if (moved.covariance.size() > 0)
        point->sigma = moved.covariance.diagonal().segment<3>(3 * k).cwiseMax(0).cwiseSqrt();
      if (point->role.empty() && roles.count(point->id)) point->role = roles[point->id];
      result.points.push_back(std::move(point));
    }
    result.covariance = pack_symmetric(moved.covariance);
    return result;
  }
};

}  // namespace

PLUMBLINE_PLUGIN("register", "0.1.0", "MIT", RegisterRigid)
