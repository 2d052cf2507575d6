#include "geometry/similarity.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/SVD>
#include <stdexcept>

namespace plumbline {

SimilarityMotion fit_similarity(const std::vector<Eigen::Vector3d>& from, const std::vector<Eigen::Vector3d>& to,
                                bool with_scale) {
  if (from.size() != to.size() || from.size() < 3)
    throw std::logic_error("fit_similarity needs three pairs of points or more");
  Eigen::Vector3d from_centre = Eigen::Vector3d::Zero(), to_centre = Eigen::Vector3d::Zero();
  for (size_t i = 0; i < from.size(); ++i) {
    from_centre += from[i] / static_cast<double>(from.size());
    to_centre += to[i] / static_cast<double>(to.size());
  }
  Eigen::Matrix3d s = Eigen::Matrix3d::Zero();
  double from_size = 0, to_size = 0;
  for (size_t i = 0; i < from.size(); ++i) {
    const Eigen::Vector3d a = from[i] - from_centre, b = to[i] - to_centre;
    s += a * b.transpose();
    from_size += a.squaredNorm();
    to_size += b.squaredNorm();
  }
  Eigen::Matrix4d n;
  n << s(0, 0) + s(1, 1) + s(2, 2), s(1, 2) - s(2, 1), s(2, 0) - s(0, 2), s(0, 1) - s(1, 0),  //
      s(1, 2) - s(2, 1), s(0, 0) - s(1, 1) - s(2, 2), s(0, 1) + s(1, 0), s(2, 0) + s(0, 2),   //
      s(2, 0) - s(0, 2), s(0, 1) + s(1, 0), s(1, 1) - s(0, 0) - s(2, 2), s(1, 2) + s(2, 1),   //
      s(0, 1) - s(1, 0), s(2, 0) + s(0, 2), s(1, 2) + s(2, 1), s(2, 2) - s(0, 0) - s(1, 1);
  const Eigen::Vector4d q = Eigen::SelfAdjointEigenSolver<Eigen::Matrix4d>(n).eigenvectors().col(3);
  SimilarityMotion motion;
  motion.rotation = Eigen::Quaterniond(q(0), q(1), q(2), q(3)).normalized();
  if (with_scale && from_size > 0) motion.scale = std::sqrt(to_size / from_size);
  motion.translation = to_centre - motion.scale * (motion.rotation * from_centre);
  return motion;
}

Eigen::Matrix3d rotation_of_moment(const Eigen::Matrix3d& moment) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(moment, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const double sign = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0 ? -1 : 1;
  return svd.matrixU() * Eigen::Vector3d(1, 1, sign).asDiagonal() * svd.matrixV().transpose();
}

Eigen::Quaterniond shortest_rotation(const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
  constexpr double kOpposite = 1e-12;  // 1 + cosine below which the cross product has no direction
  const Eigen::Vector3d a = from.normalized(), b = to.normalized();
  const double cosine = a.dot(b);
  Eigen::Quaterniond q;
  if (1 + cosine < kOpposite) {
    q.w() = 0, q.vec() = a.unitOrthogonal();
    return q;
  }
  const double s = std::sqrt(2 * (1 + cosine));  // twice the cosine of half the angle
  q.w() = 0.5 * s, q.vec() = a.cross(b) / s;
  return q;
}

}  // namespace plumbline
