#include "photo/colmap/reconstruction.hpp"

#include <algorithm>
#include <fstream>
#include <set>
#include <stdexcept>

#include "photo/colmap/program.hpp"
#include "photo/images/photograph_header.hpp"
#include "plumbline/folder_files.hpp"

namespace plumbline::colmap {
namespace {

namespace fs = std::filesystem;

/// Names below the folder, in their order.
std::vector<std::string> photographs_in(const fs::path& folder, std::vector<std::string>& warnings) {
  std::vector<std::string> names, others;
  for (const std::string& name : list_files(folder).files)
    if (!is_system_file(name)) (is_photograph_name(name) ? names : others).push_back(name);
  if (const std::string unread = unread_photographs(others); !unread.empty()) warnings.push_back(unread);
  if (names.size() < 2)
    throw std::runtime_error(
        folder.string() + " has " + std::to_string(names.size()) +
        " photographs (JPEG, PNG, TIFF); a reconstruction needs two and is worth something with ten");
  return names;
}

/// The model with most photographs; COLMAP leaves several where it could not join them.
cameras::ColmapModel largest_model(const fs::path& folder, std::vector<std::string>& warnings) {
  std::vector<fs::path> found;
  for (const auto& entry : fs::directory_iterator(folder))
    if (entry.is_directory()) found.push_back(entry.path());
  std::sort(found.begin(), found.end());
  cameras::ColmapModel best;
  std::string sizes;
  for (const fs::path& path : found) {
    cameras::ColmapModel model = cameras::read_colmap(path.string());
    sizes += (sizes.empty() ? "" : ", ") + std::to_string(model.images.size());
    if (model.images.size() > best.images.size()) best = std::move(model);
  }
  if (best.images.empty())
    throw std::runtime_error(
        "COLMAP found no two photographs to begin with: they overlap too little, show too little texture, or are not "
        "of one camera (one_camera=false)");
  if (found.size() > 1)
    warnings.push_back("the photographs fall into " + std::to_string(found.size()) + " models of " + sizes +
                       " photographs that COLMAP could not join; the largest is taken");
  return best;
}

}  // namespace

Reconstruction reconstruct(const fs::path& photographs, const ReconstructionOptions& options) {
  if (!is_installed(options.program))
    throw std::runtime_error("the program '" + options.program +
                             "' is not installed: install it (Debian: apt install colmap); photographs of markers need "
                             "no other program");
  Reconstruction result;
  const std::vector<std::string> names = photographs_in(photographs, result.warnings);
  const ScratchFolder scratch;
  const fs::path models = scratch.make("models"), list = scratch.path() / "list.txt", log = scratch.path() / "log",
                 database = scratch.path() / "database.db";
  {
    std::ofstream stream(list);
    for (const std::string& name : names) stream << name << "\n";
    if (!stream.flush()) throw std::runtime_error("cannot write " + list.string() + " for COLMAP; is the disk full?");
  }
  const std::string threads = std::to_string(options.threads), folder = fs::absolute(photographs).string();
  run_program(
      options.program,
      {"feature_extractor", "--database_path", database.string(), "--image_path", folder, "--image_list_path",
       list.string(), "--ImageReader.single_camera", options.one_camera ? "1" : "0", "--ImageReader.camera_model",
       options.camera_model, "--SiftExtraction.use_gpu", "0", "--SiftExtraction.num_threads", threads,
       "--SiftExtraction.max_image_size", std::to_string(options.max_image_size), "--SiftExtraction.max_num_features",
       std::to_string(options.max_features)},
      options.time_limit, log);
  run_program(options.program,
              {"exhaustive_matcher", "--database_path", database.string(), "--SiftMatching.use_gpu", "0",
               "--SiftMatching.num_threads", threads},
              options.time_limit, log);
  run_program(options.program,
              {"mapper", "--database_path", database.string(), "--image_path", folder, "--output_path", models.string(),
               "--Mapper.num_threads", threads},
              options.time_limit, log);
  result.model = largest_model(models, result.warnings);
  std::set<std::string> registered;
  for (const auto& [id, image] : result.model.images) registered.insert(image.name);
  for (const std::string& name : names)
    if (!registered.count(name)) result.unregistered.push_back(name);
  return result;
}

}  // namespace plumbline::colmap
