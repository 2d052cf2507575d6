// pose.opengv_rig: exterior orientation of the cameras of a rig by the solvers of OpenGV for several projection
// centres.

#include "base/text/whole_file.hpp"
#include "photo/pose/pose_node.hpp"
#include "photo/pose/rig_poses.hpp"
#include "place/pose/opengv_solvers.hpp"

namespace {

using namespace plumbline;

/// Has the ports of the role, but not the role: it cannot do without the file of the rig.
struct PoseOpenGvRig : pose::PoseNode {
  static constexpr Info info{"pose.opengv_rig", "", 1,
                             "Orients the images of a rig of cameras, those of one moment together, with a solver of "
                             "OpenGV for several projection centres in a robust frame"};
  Param<FilePath> rig{"rig", required,
                      "calibration.json of calibrate_camera: how the cameras stand to each other, taken as exact. "
                      "Images are of its cameras by the camera they name, their folder or their names; those of one "
                      "moment have the same last number in their names"};
  Param<std::string> solver{"solver", "gp3p", one_of("gp3p", "gpnp", "upnp"),
                            "what proposes poses; all are refined alike"};

  void run(Context& context) override {
    if (*raw_tags > 0)
      throw std::runtime_error("raw_tags is of single cameras: a rig has no pose of one solver alone; leave it at 0");
    const PosesT result = pose::initial_rig_poses(
        images(), camera.unpack(), pose::parse_rig(text::read_whole(rig->path), rig->path), plates.unpack(),
        points.unpack(), pose::make_opengv_rig_solver(*solver), pose::make_opengv_solver("p3p_kneip"),
        settings_of(context), [&context](const std::string& warning) { context.warn(warning); });
    context.metric("images_oriented", static_cast<double>(result.poses.size()), "1");
    poses.commit(result);
  }
};

}  // namespace

PLUMBLINE_PLUGIN("pose_opengv_rig", PLUMBLINE_BUILD_ID, "MIT", PoseOpenGvRig)
