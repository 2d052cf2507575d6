// evaluate.errors: ports and parameters.
#pragma once

#include <Eigen/Core>

#include "artifacts/points.hpp"
#include "plumbline/node.hpp"

namespace plumbline::judgement {

struct EvaluateErrors : Node {
  static constexpr Info info{"evaluate.errors", "", 3,
                             "Errors of a model's points against the truth as metrics: rmse, bias, largest, NEES, and "
                             "what is found and stated in heights, plan, shift, turn, tilt and scale"};
  In<Points> model{"model", frame("frame=?F"), "points of the model with their covariance"};
  In<Points> truth{"truth", frame("frame=?F"),
                   "where they really are; its roles say which count; a covariance is added to the model's"};
  Param<std::string> use{"use", "check", one_of("check", "control", "tie", "all"), "role of the points that count"};
  Param<double> max_missing{"max_missing", 0.2, "1", between(0, 1),
                            "share of them that may be missing in the model; more is an error"};
  Param<double> mounting_sigma{
      "mounting_sigma", 0.0, "m", between(0, 0.1),
      "where the truth is of anchors and the model of the plates on them: standard deviation of "
      "a plate's place, each axis, which is added to the model's"};
  Out<Points> errors{"errors", frame("frame=?F"), "model minus truth in place of the coordinates"};

  void run(Context& context) override;

 private:
  void report(Context& context, const PointsT& off, const Eigen::MatrixXd& of_heights,
              const Eigen::MatrixXd& of_all) const;
  static void report_modes(Context& context, const PointsT& built, const PointsT& off, const Eigen::MatrixXd& of_all);
};

}  // namespace plumbline::judgement
