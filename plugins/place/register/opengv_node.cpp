// register.opengv_arun: equation (6) with equal weights by OpenGV's implementation of Arun, Huang & Blostein (1987).
#include <cmath>
#include <opengv/point_cloud/PointCloudAdapter.hpp>
#include <opengv/point_cloud/methods.hpp>

#include "plumbline/node.hpp"
#include "registrar_artifacts.hpp"

namespace {

using namespace plumbline;
namespace reg = plumbline::registration;

/// R of target = R source. OpenGV gives the transform from its second frame to its first.
Eigen::Matrix3d rotation_by_arun(const Eigen::Matrix3Xd& source, const Eigen::Matrix3Xd& target) {
  opengv::points_t to, from;
  for (Eigen::Index i = 0; i < source.cols(); ++i) to.push_back(target.col(i)), from.push_back(source.col(i));
  const opengv::point_cloud::PointCloudAdapter adapter(to, from);
  const Eigen::Matrix3d rotation = opengv::point_cloud::threept_arun(adapter).leftCols<3>();
  if (!rotation.allFinite() || std::abs(rotation.determinant() - 1) > 1e-6)
    throw reg::DegenerateRegistration("OpenGV's threept_arun gives no rotation for these points");
  return rotation;
}

struct RegisterOpengvArun : Node {
  static constexpr Info info{"register.opengv_arun", "registrar", 2,
                             "Rigid registration of points to control with equal weights (6) by OpenGV's threept_arun"};
  In<Points> source{"source", frame("frame=?S"), "points to move; those with role check never take part in the fit"};
  In<Points> target{"target", frame("frame=?T"),
                    "control, matched by id; those with role check never take part in the fit"};
  Out<Transform> transform{"transform", frame("to=?T,from=?S"), "the transform, its covariance, residuals, and (8)"};
  Out<Points> points{"points", frame("frame=?T"), "all source points in the target frame, with propagated covariance"};
  Param<double> min_width_ratio{
      "min_width_ratio", 0.01, "1", between(0, 1),
      "a figure of control points narrower than this against its length is refused as a line"};

  void run(Context& context) override {
    const PointsT from = source.unpack(), to = target.unpack();
    const reg::Matched matched = reg::match(from, to);
    reg::RobustOptions how;
    how.fit.min_width_ratio = *min_width_ratio;
    how.fit.rotation = rotation_by_arun;
    const reg::RobustRegistration result = reg::register_robust(matched.points, how);
    context.metric("sigma0", result.fit.sigma0, "1");
    transform.commit(reg::transform_artifact(matched, result, "least_squares", std::nan("")));
    points.commit(reg::points_artifact(from, to, matched, result));
  }
};

}  // namespace

PLUMBLINE_PLUGIN("register_opengv", PLUMBLINE_BUILD_ID, "MIT", RegisterOpengvArun)
