// pose.opengv: exterior orientation by the solvers of OpenGV.

#include "photo/pose/pose_node.hpp"
#include "place/pose/opengv_solvers.hpp"

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

PLUMBLINE_PLUGIN("pose_opengv", PLUMBLINE_BUILD_ID, "MIT", PoseOpenGv)
