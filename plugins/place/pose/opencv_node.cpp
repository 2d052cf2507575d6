// pose.opencv: exterior orientation by the solvers of OpenCV.
#include "photo/pose/pose_node.hpp"
#include "place/pose/opencv_solvers.hpp"

namespace {

using namespace plumbline;

struct PoseOpenCv : pose::PoseNode {
  static constexpr Info info{"pose.opencv", "pose_initialiser", 1,
                             "Orients images by their tags with a solver of OpenCV in a robust frame"};
  Param<std::string> solver{"solver", "sqpnp", one_of("sqpnp", "ippe_square", "p3p", "ap3p", "iterative"),
                            "what proposes poses; all are refined alike"};
  void run(Context& context) override { run_with(context, pose::make_opencv_solver(*solver)); }
};

}  // namespace

PLUMBLINE_PLUGIN("pose_opencv", PLUMBLINE_BUILD_ID, "MIT", PoseOpenCv)
