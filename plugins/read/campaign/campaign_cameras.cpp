#include "campaign_cameras.hpp"

#include <algorithm>
#include <map>

#include "artifacts/camera_artifact.hpp"
#include "base/text/whole_file.hpp"

namespace plumbline::campaign {

CampaignCameras::CampaignCameras(const CampaignDescription& description, const std::filesystem::path& root)
    : files_(description.cameras) {
  Problems problems;
  std::map<std::string, std::string> file_of;  // by id
  for (std::size_t c = 0; c < files_.size(); ++c) {
    const std::filesystem::path path = root / files_[c].file;
    problems.attempt([&] {
      calibrations_.push_back(parse_camera(text::read_whole(path), path));
      const std::string& id = calibrations_.back().id;
      if (const auto [other, is_new] = file_of.emplace(id, files_[c].file); !is_new)
        throw CampaignError(path, 0,
                            "its id '" + id + "' is that of " + other->second +
                                " too; the report tells cameras by it, so give each body one of its own");
    });
  }
  problems.raise();
}

const CameraCalibration& CampaignCameras::of(const std::string& image) const {
  const CameraCalibration* found = nullptr;
  for (std::size_t c = 0; c < files_.size(); ++c) {
    const auto& patterns = files_[c].patterns;
    const bool its = patterns.empty() || std::any_of(patterns.begin(), patterns.end(), [&](const std::string& pattern) {
                       return matches_pattern(pattern, image);
                     });
    if (!its) continue;
    if (found)
      throw std::runtime_error("is named for two cameras of campaign.yaml, '" + found->id + "' and '" +
                               calibrations_[c].id + "'");
    found = &calibrations_[c];
  }
  if (!found) throw std::runtime_error("is named for none of the cameras of campaign.yaml");
  return *found;
}

CameraT CampaignCameras::artifact() const {
  std::vector<CameraT> cameras;
  for (std::size_t c = 0; c < files_.size(); ++c) cameras.push_back(to_artifact(calibrations_[c], files_[c].file));
  return joined_cameras(cameras);
}

}  // namespace plumbline::campaign
