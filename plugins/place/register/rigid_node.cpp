// register.rigid: equations (6), (7) and (8) of a free block against surveyed control.
#include <cmath>
#include <map>

#include "plumbline/node.hpp"
#include "registrar_artifacts.hpp"
#include "without_worst_node.hpp"

namespace {

using namespace plumbline;
namespace reg = plumbline::registration;

struct RegisterRigid : Node {
  static constexpr Info info{"register.rigid", "registrar", 3,
                             "Weighted rigid or similarity registration of points to control, (6), (7) and (8)"};
  In<Points> source{"source", frame("frame=?S"), "points to move; those with role check never take part in the fit"};
  In<Points> target{"target", frame("frame=?T"),
                    "control, matched by id; those with role check never take part in the fit"};
  Out<Transform> transform{"transform", frame("to=?T,from=?S"), "the transform, its covariance, residuals, and (8)"};
  Out<Points> points{"points", frame("frame=?T"), "all source points in the target frame, with propagated covariance"};
  Param<std::string> weights{
      "weights", "auto", one_of("auto", "equal", "scalar", "covariance"),
      "equal; scalar: one weight a point from its variances, (6) as printed; covariance: the full covariance of both "
      "sides; auto: covariance if either side has one, else equal. What the transform takes out of the source "
      "counts in no weight"};
  Param<std::string> scale{"scale", "fixed", one_of("fixed", "estimated", "tested"),
                           "6 or 7 parameters; tested: 7 if the control contradicts the source's scale at 1 %, else 6"};
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
    const reg::Matched matched = reg::match(from, to);
    const reg::Correspondences& c = matched.points;
    reg::RobustOptions how = options(c);
    reg::RobustRegistration result = reg::register_robust(c, how);
    double scale_w = std::nan("");
    if (how.fit.estimate_scale) {
      // Six parameters take the source's scale for exact: the test is of that, however well the source knows its scale.
      const double of_control = result.fit.sigma_scale_of_control;
      scale_w = of_control > 0 ? (result.fit.scale - 1) / of_control : std::nan("");
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
    if (*weights != "equal" && matched.points.source_covariance.size() > 0 && from.covariance.empty())
      context.warn(
          "'source' has standard deviations, but not the correlations between its points: they are taken for "
          "independent, so that uncertainty of the datum they are stated in counts as if it were the points' own, in "
          "the weights and in the standard deviations that leave here; give the full covariance, or weights: equal");
    context.metric("sigma0", result.fit.sigma0, "1");
    transform.commit(reg::transform_artifact(matched, result, *estimator, scale_w));
    points.commit(reg::points_artifact(from, to, matched, result));
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
};

}  // namespace

PLUMBLINE_PLUGIN("register", PLUMBLINE_BUILD_ID, "MIT", RegisterRigid, reg::WithoutWorst)
