#include "control/registration/rigid_registration.hpp"

#include <fmt/core.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "geometry/linear_algebra/decompositions.hpp"
#include "geometry/similarity.hpp"

namespace plumbline::registration {
namespace {

using Eigen::Index;

/// The transform about the centroid of the source: p = scale · rotation · (x - centroid) + image.
struct Centred {
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  Eigen::Vector3d centroid, image;
  double scale = 1;

  Eigen::Matrix3Xd apply(const Eigen::Matrix3Xd& x) const {
    return ((scale * rotation) * (x.colwise() - centroid)).colwise() + image;
  }
};

void check_input(const Correspondences& points, const Options& options) {
  const Index n = points.source.cols();
  if (points.target.cols() != n || static_cast<Index>(points.ids.size()) != n)
    throw std::invalid_argument("registration: source, target and ids differ in length");
  for (const Eigen::MatrixXd* c : {&points.source_covariance, &points.target_covariance})
    if (c->size() > 0 && (c->rows() != 3 * n || c->cols() != 3 * n))
      throw std::invalid_argument("registration: a covariance is not 3n x 3n");
  if (options.weighting != Weighting::equal && points.source_covariance.size() == 0 &&
      points.target_covariance.size() == 0)
    throw std::invalid_argument(
        "registration: weights are to follow covariances, but neither side has any; use equal weights");
  if (options.point_weights.size() > 0 &&
      (options.weighting != Weighting::covariance || options.point_weights.size() != n ||
       !(options.point_weights.minCoeff() > 0)))
    throw std::invalid_argument("registration: point weights need covariances, and must be positive");
  if (options.rotation && (options.weighting != Weighting::equal || options.estimate_scale))
    throw std::invalid_argument("registration: a given rotation is of equal weights and without scale");
  if (n < 3)
    throw DegenerateRegistration(
        "a registration needs at least 3 points that both sides have and that may take part, found " +
        std::to_string(n));
  for (Index i = 0; i < n; ++i)
    for (const bool at_source : {true, false})
      if (const Eigen::Vector3d x = (at_source ? points.source : points.target).col(i); !x.allFinite())
        throw std::invalid_argument(fmt::format(
            "registration: point '{}' of the {} has the coordinates {}, {}, {}, and all three must be known; "
            "leave it out, or give what it lacks",
            points.ids[static_cast<size_t>(i)], at_source ? "source" : "target", x.x(), x.y(), x.z()));
}

/// Refuses points on a line, and names the line by the two points that are furthest apart.
void check_figure(const Eigen::Matrix3Xd& points, const std::vector<std::string>& ids, const char* side,
                  double min_ratio) {
  const Eigen::Vector3d mean = points.rowwise().mean();
  const Eigen::Matrix3Xd centred = points.colwise() - mean;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> scatter(centred * centred.transpose() /
                                                               static_cast<double>(points.cols()));
  const Eigen::Vector3d spread = scatter.eigenvalues().reverse().cwiseMax(0).cwiseSqrt();  // largest first [m]
  if (spread[1] > min_ratio * spread[0] && spread[0] > 1e-9 * (1 + mean.norm())) return;
  const Eigen::RowVectorXd along = scatter.eigenvectors().col(2).transpose() * centred;
  Index first = 0, last = 0;
  along.minCoeff(&first);
  along.maxCoeff(&last);
  const std::string figures = fmt::format(" ({} points, standard deviation {:.3g} m along it, {:.3g} m across)",
                                          static_cast<long long>(points.cols()), spread[0], spread[1]);
  throw DegenerateRegistration("the points of the " + std::string(side) + " lie on a line" + figures +
                               ": rotation about the line through " + ids[first] + " and " + ids[last] +
                               " is not determined; add a point off the line");
}

/// Weighted least squares in closed form: Umeyama (1991), IEEE PAMI 13(4), with weights.
Centred closed_form(const Correspondences& points, const Eigen::VectorXd& weights, const Options& options) {
  Centred t;
  const double total = weights.sum();
  t.centroid = points.source * weights / total;
  t.image = points.target * weights / total;
  const Eigen::Matrix3Xd x = points.source.colwise() - t.centroid, y = points.target.colwise() - t.image;
  const Eigen::Matrix3d moment = y * weights.asDiagonal() * x.transpose();
  t.rotation = options.rotation ? options.rotation(x, y) : rotation_of_moment(moment);
  if (options.estimate_scale) t.scale = t.rotation.cwiseProduct(moment).sum() / (x.cwiseAbs2() * weights).sum();
  return t;
}

/// Derivatives of moved points by (rotation vector in the target frame, image of the centroid, scale), 3m x unknowns.
Eigen::MatrixXd slopes(const Centred& t, const Eigen::Matrix3Xd& points, int unknowns) {
  Eigen::MatrixXd a(3 * points.cols(), unknowns);
  for (Index i = 0; i < points.cols(); ++i) {
    const Eigen::Vector3d turned = t.rotation * (points.col(i) - t.centroid);
    a.block<3, 3>(3 * i, 0) = -t.scale * skew(turned);
    a.block<3, 3>(3 * i, 3) = Eigen::Matrix3d::Identity();
    if (unknowns == 7) a.block<3, 1>(3 * i, 6) = turned;
  }
  return a;
}

/// (I ⊗ sR) C (I ⊗ sR)'.
Eigen::MatrixXd turned(const Eigen::MatrixXd& c, const Centred& t) {
  Eigen::MatrixXd out(c.rows(), c.cols());
  const Eigen::Matrix3d m = t.scale * t.rotation;
  for (Index i = 0; i < c.rows(); i += 3)
    for (Index j = 0; j < c.cols(); j += 3) out.block<3, 3>(i, j) = m * c.block<3, 3>(i, j) * m.transpose();
  return out;
}

/// Covariance of the residuals from both sides; empty if neither is known.
Eigen::MatrixXd residual_covariance_of(const Correspondences& points, const Centred& t) {
  Eigen::MatrixXd c = points.target_covariance;
  if (points.source_covariance.size() == 0) return c;
  const Eigen::MatrixXd moved = turned(points.source_covariance, t);
  return c.size() == 0 ? moved : Eigen::MatrixXd(c + moved);
}

bool is_regular(const Eigen::MatrixXd& c) {
  const linear_algebra::SymmetricEigen eigen(c, Eigen::EigenvaluesOnly);
  return eigen.eigenvalues()[0] > 1e-10 * eigen.eigenvalues()[c.rows() - 1];
}

/// A matrix to weight with in place of a covariance that may be singular: C + k A A' (Rao 1971). The estimate is the
/// same as with C wherever that has an inverse.
Eigen::LLT<Eigen::MatrixXd> weight_of(const Eigen::MatrixXd& c, const Eigen::MatrixXd& a) {
  if (is_regular(c)) return Eigen::LLT<Eigen::MatrixXd>(c);
  const Eigen::MatrixXd augmented = c + (c.trace() / a.squaredNorm()) * (a * a.transpose());
  if (!is_regular(augmented))
    throw DegenerateRegistration(
        "the covariances of source and target are singular in a direction that the transform does not cover (a free "
        "network without "
        "scale needs scale: estimated; points without error need equal weights)");
  return Eigen::LLT<Eigen::MatrixXd>(augmented);
}

Eigen::VectorXd flat(const Eigen::Matrix3Xd& m) { return Eigen::Map<const Eigen::VectorXd>(m.data(), m.size()); }

/// G = (A' W A)^-1 A' W.
Eigen::MatrixXd influence_of(const Eigen::MatrixXd& a, const Eigen::MatrixXd& weighted) {
  return linear_algebra::solve_symmetric(a.transpose() * weighted, weighted.transpose());
}

void apply_step(Centred& t, const Eigen::VectorXd& step) {
  t.rotation = quaternion_from_rotation_vector(step.head<3>()).toRotationMatrix() * t.rotation;
  t.image += step.segment<3>(3);
  if (step.size() == 7) t.scale += step[6];
}

/// D C D with D = 1/√weight of each point: a point of weight ¼ counts as if it were twice as uncertain.
Eigen::MatrixXd down_weighted(Eigen::MatrixXd c, const Eigen::VectorXd& weights) {
  for (Index i = 0; i < weights.size(); ++i) {
    const double d = 1 / std::sqrt(weights(i));
    c.middleRows<3>(3 * i) *= d;
    c.middleCols<3>(3 * i) *= d;
  }
  return c;
}

/// Gauss-Newton with the full covariance, whose weights follow the rotation.
Eigen::MatrixXd fit_with_covariance(const Correspondences& points, const Eigen::VectorXd& weights, int unknowns,
                                    Centred& t) {
  for (int iteration = 0; iteration < 50; ++iteration) {
    const Eigen::MatrixXd a = slopes(t, points.source, unknowns);
    const auto weight = weight_of(down_weighted(residual_covariance_of(points, t), weights), a);
    const Eigen::MatrixXd influence = influence_of(a, weight.solve(a));
    const Eigen::VectorXd step = influence * flat(points.target - t.apply(points.source));
    if (!step.allFinite()) break;
    apply_step(t, step);
    if (step.norm() < 1e-11 * (1 + t.image.norm())) return influence;
  }
  throw DegenerateRegistration("the registration does not converge; are the ids of source and target the same points?");
}

/// One weight a point, from a source covariance in its inner datum.
Eigen::VectorXd scalar_weights(const Correspondences& points, Weighting weighting) {
  const Index n = points.source.cols();
  if (weighting != Weighting::scalar) return Eigen::VectorXd::Ones(n);
  Eigen::VectorXd variance = Eigen::VectorXd::Zero(n);
  for (const Eigen::MatrixXd* c : {&points.source_covariance, &points.target_covariance})
    if (c->size() > 0)
      for (Index i = 0; i < n; ++i) variance[i] += c->diagonal().segment<3>(3 * i).sum() / 3;
  if (!(variance.minCoeff() > 0))
    throw std::invalid_argument("registration: a point has no variance; use equal weights");
  return variance.cwiseInverse();
}

/// Weighted sum of squares with the inverse covariance, or with a generalised inverse if that is singular.
double weighted_square(const Eigen::MatrixXd& covariance, const Eigen::MatrixXd& a, const Eigen::VectorXd& residuals) {
  return residuals.dot(weight_of(covariance, a).solve(residuals));
}

/// The centred covariance, and from it that of the transform about the origin.
void set_covariance(const Eigen::MatrixXd& centred_covariance, Registration& result) {
  const Eigen::Vector3d shift = result.to_from_from.rotation * result.source_centroid;
  Eigen::MatrixXd step = Eigen::MatrixXd::Identity(result.unknowns, result.unknowns);
  step.block<3, 3>(3, 0) = result.scale * skew(shift);
  if (result.unknowns == 7) step.block<3, 1>(3, 6) = -shift;
  result.centred_covariance = centred_covariance;
  result.covariance = step * centred_covariance * step.transpose();
}

Centred centred(const Registration& registration) {
  Centred t;
  t.rotation = registration.to_from_from.rotation.toRotationMatrix();
  t.scale = registration.scale;
  t.centroid = registration.source_centroid;
  t.image = t.scale * (t.rotation * t.centroid) + registration.to_from_from.translation;
  return t;
}

/// The registration of points whose target coordinates are small. `weighing`: the same points with the covariance of
/// the source in its inner datum.
Registration register_local(const Correspondences& points, const Correspondences& weighing, const Options& options) {
  Registration result;
  result.unknowns = options.estimate_scale ? 7 : 6;
  const Index n = points.source.cols();

  const Eigen::VectorXd weights = scalar_weights(weighing, options.weighting);
  Centred t = closed_form(points, weights, options);
  if (options.weighting == Weighting::covariance) {
    result.influence = fit_with_covariance(weighing, options.point_weights, result.unknowns, t);
  } else {
    const Eigen::MatrixXd a = slopes(t, points.source, result.unknowns);
    Eigen::MatrixXd weighted = a;
    for (Index i = 0; i < n; ++i) weighted.middleRows<3>(3 * i) *= weights[i];
    result.influence = influence_of(a, weighted);
  }
  result.source_centroid = t.centroid;
  result.to_from_from = {Eigen::Quaterniond(t.rotation).normalized(), t.image - t.scale * (t.rotation * t.centroid)};
  result.scale = t.scale;
  result.residuals = points.target - t.apply(points.source);
  result.degrees_of_freedom = static_cast<int>(3 * n) - result.unknowns;

  const Eigen::VectorXd v = flat(result.residuals);
  Eigen::MatrixXd known = residual_covariance_of(weighing, t);
  result.weighted_sum_of_squares = known.size() == 0 ? v.squaredNorm()
                                                     : weighted_square(down_weighted(known, options.point_weights),
                                                                       slopes(t, points.source, result.unknowns), v);
  if (result.degrees_of_freedom > 0)
    result.sigma0 = std::sqrt(result.weighted_sum_of_squares / result.degrees_of_freedom);
  if (known.size() == 0) known = result.sigma0 * result.sigma0 * Eigen::MatrixXd::Identity(3 * n, 3 * n);
  set_covariance(result.influence * known * result.influence.transpose(), result);
  if (result.unknowns == 7) result.sigma_scale_of_control = std::sqrt(result.centred_covariance(6, 6));
  state_covariance(points, result);

  const Eigen::Matrix3d squares = result.residuals * result.residuals.transpose();
  result.residual_covariance = squares / static_cast<double>(n - 1);
  result.residual_covariance_unbiased = squares * 3.0 / std::max(1, result.degrees_of_freedom);
  return result;
}

}  // namespace

Eigen::MatrixXd inner_datum(const Eigen::MatrixXd& covariance, const Eigen::Matrix3Xd& points, int unknowns) {
  if (covariance.size() == 0) return covariance;
  Centred t;
  t.centroid = points.rowwise().mean();
  const Eigen::MatrixXd a = slopes(t, points, unknowns);
  const Eigen::MatrixXd fit = linear_algebra::solve_symmetric(a.transpose() * a, a.transpose());  // (A'A)^-1 A'
  const Eigen::MatrixXd half = covariance - a * (fit * covariance);
  const Eigen::MatrixXd inner = half - (half * fit.transpose()) * a.transpose();
  return 0.5 * (inner + inner.transpose());
}

void state_covariance(const Correspondences& points, Registration& fit) {
  const Eigen::MatrixXd known = residual_covariance_of(points, centred(fit));
  if (known.size() > 0) set_covariance(fit.influence * known * fit.influence.transpose(), fit);
}

Registration register_points(const Correspondences& points, const Options& options) {
  check_input(points, options);
  check_figure(points.source, points.ids, "source", options.min_width_ratio);
  check_figure(points.target, points.ids, "target", options.min_width_ratio);
  // National coordinates have millions of metres; the fit is done where a double resolves less than a picometre.
  Correspondences local = points;
  const Eigen::Vector3d origin = points.target.col(0);
  local.target.colwise() -= origin;
  Correspondences weighing = local;
  weighing.source_covariance = inner_datum(points.source_covariance, points.source, options.estimate_scale ? 7 : 6);
  Registration result = register_local(local, weighing, options);
  result.to_from_from.translation += origin;
  return result;
}

Eigen::MatrixXd point_slopes(const Registration& registration, const Eigen::Vector3d& source) {
  return slopes(centred(registration), source, registration.unknowns);
}

MovedPoints move_points(const Registration& registration, const Eigen::Matrix3Xd& points,
                        const Eigen::MatrixXd& covariance, const std::vector<int>& fitted,
                        const Eigen::MatrixXd& target_covariance) {
  const Centred t = centred(registration);
  MovedPoints moved;
  moved.positions = t.apply(points);
  if (covariance.size() == 0) return moved;

  // dp = sR dS + J dx, dx = G (dT - sR dS of the fitted points).
  const Eigen::MatrixXd through = slopes(t, points, registration.unknowns) * registration.influence;
  Eigen::MatrixXd direct = Eigen::MatrixXd::Identity(3 * points.cols(), 3 * points.cols());
  for (std::size_t k = 0; k < fitted.size(); ++k)
    direct.middleCols<3>(3 * fitted[k]) -= through.middleCols<3>(3 * static_cast<Index>(k));
  moved.covariance = direct * turned(covariance, t) * direct.transpose();
  if (target_covariance.size() > 0) moved.covariance += through * target_covariance * through.transpose();
  moved.covariance = 0.5 * (moved.covariance + moved.covariance.transpose()).eval();
  return moved;
}

}  // namespace plumbline::registration
