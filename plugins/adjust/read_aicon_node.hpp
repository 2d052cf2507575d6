// read.aicon: an AICON block from a folder of its exchange files.
#pragma once

#include "artifacts/folder.hpp"
#include "artifacts/image_block.hpp"
#include "block/aicon_files.hpp"
#include "plumbline/node.hpp"

namespace plumbline::adjust {

inline ImageBlockT to_artifact(const AiconBlock& read) {
  ImageBlockT artifact;
  for (const auto& camera : read.block.cameras) {
    auto entry = std::make_unique<SensorCameraT>();
    entry->id = camera.id;
    entry->parameters.assign(camera.values.begin(), camera.values.end());
    entry->balance_radius = camera.balance_radius;
    entry->sensor_width = camera.sensor_width;
    entry->sensor_height = camera.sensor_height;
    entry->width = camera.width;
    entry->height = camera.height;
    artifact.cameras.push_back(std::move(entry));
  }
  for (const auto& image : read.block.images) {
    auto entry = std::make_unique<SensorImageT>();
    entry->id = image.id;
    entry->camera = image.camera;
    entry->centre = image.centre;
    entry->angles = image.angles;
    artifact.images.push_back(std::move(entry));
  }
  for (const auto& point : read.block.points) {
    auto entry = std::make_unique<PointT>();
    entry->id = point.name;
    entry->position = point.position;
    entry->sigma.setConstant(std::nan(""));
    artifact.points.push_back(std::move(entry));
  }
  for (const auto& m : read.block.measurements)
    artifact.measurements.emplace_back(m.image, m.point, m.position.x(), m.position.y(), m.sigma);
  for (const auto& bar : read.block.scale_bars) {
    auto entry = std::make_unique<ScaleBarT>();
    entry->name = bar.name;
    entry->from = bar.from;
    entry->to = bar.to;
    entry->length = bar.length;
    entry->sigma = bar.sigma;
    artifact.scale_bars.push_back(std::move(entry));
  }
  artifact.measurements_read = read.measurements_read;
  artifact.left_out = read.left_out;
  return artifact;
}

struct ReadAicon : Node {
  static constexpr Info info{"read.aicon", "", 1,
                             "Reads an AICON block: image and object coordinates, orientations, distances"};
  Param<FolderPath> folder{"folder", required,
                           "folder with one .phc, .obc, .eor and .ior file, and a .scale file if there is one"};
  Out<ImageBlock> block{"block", frame("frame=block"), "measurements with approximate values"};

  void run(Context& context) override {
    const AiconBlock read = read_aicon_folder(folder->path);
    for (const auto& what : read.left_out) context.info("left out: " + what);
    block.commit(to_artifact(read));
  }
};

}  // namespace plumbline::adjust
