// register.@name@: moves a free block onto surveyed control, (6); stands in for register.rigid
// (registration.use=register.@name@).
//
// Write your way to the rotation into rotation_between(). Translation, residuals, (8) and all covariances follow from
// it.
#include <Eigen/Eigenvalues>

#include "place/register/registrar_artifacts.hpp"
#include "plumbline/node.hpp"

using namespace plumbline;
namespace reg = plumbline::registration;

namespace {

/// R of target = R source for two sets with their centroids at the origin, one point a column [m]. Here: the largest
/// eigenvector of Horn's matrix is its unit quaternion (Horn 1987).
Eigen::Matrix3d rotation_between(const Eigen::Matrix3Xd& source, const Eigen::Matrix3Xd& target) {
  const Eigen::Matrix3d s = source * target.transpose();
  Eigen::Matrix4d n;
  n << s.trace(), s(1, 2) - s(2, 1), s(2, 0) - s(0, 2), s(0, 1) - s(1, 0),                    //
      s(1, 2) - s(2, 1), s(0, 0) - s(1, 1) - s(2, 2), s(0, 1) + s(1, 0), s(2, 0) + s(0, 2),   //
      s(2, 0) - s(0, 2), s(0, 1) + s(1, 0), -s(0, 0) + s(1, 1) - s(2, 2), s(1, 2) + s(2, 1),  //
      s(0, 1) - s(1, 0), s(2, 0) + s(0, 2), s(1, 2) + s(2, 1), -s(0, 0) - s(1, 1) + s(2, 2);
  const Eigen::Vector4d q = Eigen::SelfAdjointEigenSolver<Eigen::Matrix4d>(n).eigenvectors().col(3);
  return Eigen::Quaterniond(q(0), q(1), q(2), q(3)).normalized().toRotationMatrix();
}

struct Registrar : Node {
  static constexpr Info info{"register.@name@", "registrar", 1,
                             "Rigid registration of points to control, all alike, (6) and (8)"};
  In<Points> source{"source", frame("frame=?S"), "points to move; those with role check never take part in the fit"};
  In<Points> target{"target", frame("frame=?T"),
                    "control, matched by id; those with role check never take part in the fit"};
  Out<Transform> transform{"transform", frame("to=?T,from=?S"), "the transform, its covariance, residuals, and (8)"};
  Out<Points> points{"points", frame("frame=?T"), "all source points in the target frame, with propagated covariance"};

  void run(Context& context) override {
    const PointsT from = source.unpack(), to = target.unpack();
    const reg::Matched matched = reg::match(from, to);
    reg::RobustOptions options;
    options.fit.rotation = rotation_between;
    const reg::RobustRegistration result = reg::register_robust(matched.points, options);
    context.metric("sigma0", result.fit.sigma0, "1");  // [m] where neither side has a covariance
    transform.commit(reg::transform_artifact(matched, result, "least_squares", std::nan("")));
    points.commit(reg::points_artifact(from, to, matched, result));
  }
};

}  // namespace

PLUMBLINE_PLUGIN("@name@", "0.1.0", "MIT", Registrar)
