// pose.opengv: exterior orientation by the solvers of OpenGV.
#include "pose/opengv_solvers.hpp"
#include "pose/pose_node.hpp"

namespace {

using namespace plumbline;

struct PoseOpenGv : pose::PoseNode {
  static constexpr Info info{"pose.opengv", "pose_initialiser", 1,
                             "Orients images by their tags with a solver of OpenGV in a robust frame"};
  Param<std::string> solver{"solver", "p3p_kneip", one_of("p3p_kneip", "p3p_gao", "epnp", "upnp"),
                            "what proposes poses; all are refined alike"};
  void run(Context& context) override { run_with(context, pose::make_opengv_solver(*solver)); }
};

}  // namespace

PLUMBLINE_PLUGIN("pose_opengv", "0.1.0", "MIT", PoseOpenGv)
