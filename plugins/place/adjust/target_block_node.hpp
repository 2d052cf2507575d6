// block.of_targets: measured targets, poses and points as the block that adjusters take.
#pragma once

#include "artifacts/camera.hpp"
#include "artifacts/file.hpp"
#include "artifacts/image_block.hpp"
#include "artifacts/points.hpp"
#include "artifacts/poses.hpp"
#include "plumbline/node.hpp"

namespace plumbline::block {

struct BlockOfTargets : Node {
  static constexpr Info info{"block.of_targets", "", 1,
                             "Makes a block of measured targets, for adjust.schur and adjust.ceres"};
  In<File> table{"table", "targets.csv of detect.target, or another table image, point, x, y, sigma"};
  In<Points> points{"points", frame("frame=?F"),
                    "the targets: approximate places; those of role control or check with standard deviations are "
                    "known points"};
  In<Poses> poses{"poses", frame("frame=?F"), "approximate exterior orientations"};
  List<Camera> cameras{"cameras", "the camera of all images, or several that are called as the images' folders"};
  Param<double> sigma{"sigma", 0.1, "px", between(1e-4, 100), "of a measurement whose table says none"};
  Out<ImageBlock> block{"block", frame("frame=?F"),
                        "measurements freed of the cameras' distortion, in the sensor plane with the pixel's pitch, or "
                        "1 µm where it is not known; images are numbered in the order of their paths"};

  void run(Context& context) override;
};

}  // namespace plumbline::block
