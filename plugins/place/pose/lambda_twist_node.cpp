// pose.lambda_twist: exterior orientation by our own solver for three points.
#include "photo/pose/lambda_twist.hpp"
#include "photo/pose/pose_node.hpp"

namespace {

using namespace plumbline;

struct PoseLambdaTwist : pose::PoseNode {
  static constexpr Info info{"pose.lambda_twist", "pose_initialiser", 1,
                             "Orients images by their tags with the solver of Persson and Nordberg in a robust frame"};
  void run(Context& context) override { run_with(context, pose::lambda_twist_of_tags); }
};

}  // namespace

PLUMBLINE_PLUGIN("pose_lambda_twist", PLUMBLINE_BUILD_ID, "MIT", PoseLambdaTwist)
