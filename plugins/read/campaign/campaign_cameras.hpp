// The calibrations of a campaign, and which photograph is of which.
#pragma once

#include "campaign_artifacts.hpp"

namespace plumbline::campaign {

class CampaignCameras {
 public:
  /// Reads the calibrations. Throws CampaignError, also where two have one id. `description` names one at least.
  CampaignCameras(const CampaignDescription& description, const std::filesystem::path& root);

  /// The camera of a photograph. Throws std::runtime_error, without its name, if it is of none or of two.
  const CameraCalibration& of(const std::string& image) const;

  /// All of them: the first with the others.
  CameraT artifact() const;

 private:
  std::vector<CameraOfImages> files_;
  std::vector<CameraCalibration> calibrations_;
};

}  // namespace plumbline::campaign
