#include "sfm_node.hpp"

#include "exchange_nodes.hpp"
#include "photo/colmap/reconstruction.hpp"

namespace plumbline::markers {

void ColmapSfm::run(Context& context) {
  colmap::ReconstructionOptions options;
  options.camera_model = *camera_model, options.one_camera = *one_camera;
  options.max_image_size = static_cast<int>(*max_image_size), options.max_features = static_cast<int>(*max_features);
  options.threads = static_cast<int>(*threads), options.time_limit = *time_limit;
  options.program = program->path;
  context.info("program: " + colmap::version_of(program->path) + ", " + program->path);
  const colmap::Reconstruction found = colmap::reconstruct(photographs->path, options);
  for (const std::string& warning : found.warnings) context.warn(warning);
  for (const std::string& name : found.unregistered)
    context.warn(name + " is not in the model: COLMAP found no place for it");
  double error = 0, observations = 0;
  for (const auto& [id, point] : found.model.points) {
    error += point.error * static_cast<double>(point.track.size());
    observations += static_cast<double>(point.track.size());
  }
  context.metric("images", static_cast<double>(found.model.images.size()), "1");
  context.metric("unregistered", static_cast<double>(found.unregistered.size()), "1");
  context.metric("points", static_cast<double>(found.model.points.size()), "1");
  context.metric("mean_reprojection_error", error / observations, "px");
  const auto folder = model.make_folder();
  model.commit(write_model(found.model, folder.uri, folder.path, context));
}

}  // namespace plumbline::markers
