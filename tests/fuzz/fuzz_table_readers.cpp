// libFuzzer's entry for the readers of tables and camera files: a value that is whole, or a std::runtime_error with
// words. One program with a name for each target, as in fuzz_survey_readers.cpp: fuzz_plates runs the target "plates".
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>

#include "campaign_folder.hpp"
#include "control/points/control_files.hpp"
#include "control/points/image_points.hpp"
#include "photo/cameras/camera_files.hpp"
#include "photo/cameras/colmap_files.hpp"
#include "photo/markers/layout_files.hpp"

namespace {

using namespace plumbline;

void promise(bool kept, const char* what) {
  if (kept) return;
  std::fprintf(stderr, "broken promise: %s\n", what);
  std::abort();
}

void check(const BrownCamera& camera) {
  for (const double parameter : camera.parameters())
    promise(std::isfinite(parameter), "a camera has finite parameters");
  promise(camera.fx > 0 && camera.fy > 0, "a camera has a positive principal distance");
}

void run_plates(const std::string& text) {
  for (const auto use : {campaign::CampaignUse::site, campaign::CampaignUse::photographs})
    for (const campaign::PlateEntry& p : campaign::parse_plates(text, "plates.csv", use)) {
      promise(!p.anchor.empty() && p.tag_id >= 0, "a plate has an anchor and a tag");
      promise(p.tag_centre_in_plate.allFinite() && std::isfinite(p.facing_azimuth), "a plate's numbers are finite");
      promise(!(p.tag_size <= 0) && !std::isinf(p.tag_size), "a tag's size is positive or not given");
    }
}

void run_campaign_control(const std::string& text) {
  for (const campaign::ControlPoint& p : campaign::parse_control(text, "control.csv"))
    for (int k = 0; k < 3; ++k)
      promise(std::isnan(p.position(k)) || (std::isfinite(p.position(k)) && p.sigma(k) > 0),
              "control has standard deviations where it has a place");
}

void run_control_points(const std::string& text) {
  for (const control::ControlPoint& p : control::parse_control(text, "gcp_list.txt").points) {
    promise(!p.name.empty() && !p.position.array().isInf().any(), "a control point has a name and a place");
    promise(!p.sigma.array().isInf().any(), "standard deviations are finite or not given");
  }
}

void run_image_points(const std::string& text) {
  for (const control::ImagePoint& p : control::parse_image_points(text, "points.csv", true))
    promise(p.pixel.allFinite() && std::isfinite(p.sigma) && p.sigma >= 0, "a measured point is whole");
}

void run_camera(const std::string& text) {
  for (const cameras::CameraFile& file : cameras::parse_camera_files(text, "camera.yaml")) check(file.camera);
}

void run_campaign_camera(const std::string& text) { check(campaign::parse_camera(text, "camera.yaml").camera); }

void run_campaign(const std::string& text) {
  campaign::parse_campaign(text, "campaign.yaml",
                           {"a.jpg", "camera.yaml", "plates.csv", "control.csv", "s.gsi", "d.ifc"});
}

void run_observations(const std::string& text) {
  BrownCamera camera;
  camera.width = 4000, camera.height = 3000;
  for (const campaign::ObservedTag& t : campaign::parse_observations(
           text, "observations.csv", [&](const std::string&) -> const BrownCamera& { return camera; }))
    for (const Eigen::Vector2d& corner : t.corners) promise(corner.allFinite(), "corners are finite");
}

void run_layout(const std::string& text) {
  for (const markers::LayoutTag& t : markers::parse_layout(text, "tags.json"))
    promise(t.world_from_tag.translation.allFinite() && std::isfinite(t.size) && t.size >= 0, "a tag is whole");
}

/// A model as text: cameras, images and points, with a line "---" between them.
void run_colmap(const std::string& text) {
  static const std::filesystem::path folder =
      std::filesystem::temp_directory_path() / ("fuzz_colmap_" + std::to_string(getpid()));
  std::filesystem::create_directories(folder);
  std::size_t at = 0;
  for (const char* name : {"cameras.txt", "images.txt", "points3D.txt"}) {
    const std::size_t end = std::min(text.find("---\n", at), text.size());
    std::ofstream(folder / name, std::ios::binary) << text.substr(at, end - at);
    at = std::min(end + 4, text.size());
  }
  for (const auto& [id, camera] : cameras::read_colmap(folder.string()).cameras) check(camera.camera);
}

struct Target {
  const char* name;
  void (*run)(const std::string& text);
};
constexpr Target kTargets[] = {{"plates", run_plates},
                               {"campaign_control", run_campaign_control},
                               {"control_points", run_control_points},
                               {"image_points", run_image_points},
                               {"camera", run_camera},
                               {"campaign_camera", run_campaign_camera},
                               {"campaign", run_campaign},
                               {"observations", run_observations},
                               {"layout", run_layout},
                               {"colmap", run_colmap}};
const Target* chosen = nullptr;

}  // namespace

extern "C" int LLVMFuzzerInitialize(int*, char*** arguments) {
  const std::string_view program((*arguments)[0]);
  for (const Target& target : kTargets)
    if (program.ends_with(std::string("fuzz_") + target.name)) chosen = &target;
  if (!chosen) std::fprintf(stderr, "no target has the name of this program\n"), std::abort();
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  try {
    chosen->run({reinterpret_cast<const char*>(data), size});
  } catch (const std::runtime_error& error) {
    promise(error.what()[0] != '\0', "an error has words");
  }
  return 0;
}
