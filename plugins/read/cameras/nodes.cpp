// join.cameras: a reader gives a list of cameras, and who orients or adjusts takes one artifact that holds all of them.
#include <stdexcept>
#include <vector>

#include "artifacts/camera.hpp"
#include "artifacts/camera_artifact.hpp"
#include "plumbline/node.hpp"

namespace {

using namespace plumbline;

struct JoinCameras : Node {
  static constexpr Info info{
      "join.cameras", "", 1,
      "Several interior orientations, such as those of read.camera or calibrate.board, as the one "
      "that pose initialisers, triangulators and adjusters take"};
  List<Camera> cameras{"cameras", "the cameras; of several, each image says by its own camera's name which took it"};
  Out<Camera> camera{"camera", "the first of them, with all others"};

  void run(Context&) override {
    std::vector<CameraT> list;
    for (std::size_t i = 0; i < cameras.size(); ++i)
      for (CameraT& one : cameras_of(cameras.unpack(i))) list.push_back(std::move(one));
    if (list.empty())
      throw std::runtime_error(
          "no camera was given: read.camera has no file, or it holds none; calibrate the camera (calibrate_camera)");
    for (std::size_t i = 0; i < list.size(); ++i)
      for (std::size_t j = 0; j < i; ++j)
        if (list[i].id == list[j].id)
          throw std::runtime_error("two cameras are called '" + list[i].id + "'; expected names that tell them apart");
    camera.commit(joined_cameras(list));
  }
};

}  // namespace

PLUMBLINE_PLUGIN("cameras", PLUMBLINE_BUILD_ID, "MIT", JoinCameras)
