// A whole simulated campaign: made in memory from options and a seed, then written as the folder that a site would hand
// over, with the truth in another folder beside it.
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <optional>

#include "camera.hpp"
#include "renderer.hpp"
#include "survey_plan.hpp"

namespace plumbline::simulate {

struct CampaignOptions {
  BuildingOptions building;
  std::string shape = "flat";  ///< of shape_names(); the building's columns are those of each facade
  double step = 1.0;           ///< by which the middle of "set_back" lies behind the others [m]
  SurveyOptions survey;
  CameraNetworkOptions cameras;
  std::string camera = "demo_24mp";
  double noise_scale = 1.0;     ///< of the image noise
  double blur = -1;             ///< [px]; negative: the camera profile's
  double light_gradient = 0.2;  ///< relative change of the light across the facade
  double haze = 0;              ///< share of the light that dust or mist scatters in; contrast falls by it
  ObstructionOptions obstruction;
  double panels = 0;           ///< contrast of the texture of the design's panels; 0: none hangs
  double panel_sigma = 0.002;  ///< how far they hang from their place, each [m]
  bool design_in_millimetres = false;
  bool readings = true;              ///< take those of the total station; without them `observations` stays empty
  Perturbations perturbations = {};  ///< those of plates are in building.flaws, too
  /// Of camera stations, noise and readings; without: of the campaign. The same site is then seen and measured again.
  std::optional<std::uint64_t> visit;
  std::map<std::string, Eigen::Vector3d> moved;  ///< where anchors are by now [m]; of the others: as built
};

struct Campaign {
  CampaignOptions options;
  std::uint64_t seed = 0;
  Building building;
  SimulatedCamera camera;
  std::vector<CameraStation> stations;
  Obstruction obstruction;
  std::vector<HungPanel> panels;
  StationPlan plan;
  survey::SurveyObservations observations;
};

/// Throws std::invalid_argument for options out of bounds and for a plan that breaks the rules of the station plan.
Campaign make_campaign(const CampaignOptions& options, std::uint64_t seed);

/// The camera as it was for one photograph: with that image's own principal point and distortion.
SimulatedCamera camera_at(const Campaign& campaign, std::size_t station);

/// What of that camera changes with the distance.
DepthDistortion depth_distortion_of(const Campaign& campaign);

/// campaign.yaml, camera.yaml, plates.csv, control.csv, survey/total_station.gsi, design.ifc. The folder must exist.
/// With `observed` the campaign names observations.csv in place of photographs.
void write_campaign_files(const Campaign& campaign, const std::filesystem::path& folder, bool observed = false);

/// observations.csv: what a detector with normal noise of `sigma` [px] would find in the photographs.
void write_observations(const Campaign& campaign, const std::filesystem::path& folder, double sigma);

/// images/*.jpg, rendered in parallel. `progress` is called from any thread after each image with how many are done,
/// and may return false to stop: then std::runtime_error is thrown.
void write_images(const Campaign& campaign, const std::filesystem::path& folder,
                  const std::function<bool(std::size_t done)>& progress);

/// Bytes that one image takes while it is rendered and encoded, generously.
std::uint64_t image_memory(const CameraProfile& profile);

/// truth/: anchors.csv, cameras.csv, camera.yaml, tags.csv, set_ups.csv, corners.csv, and panels.csv where panels
/// hang. The folder must exist.
void write_truth(const Campaign& campaign, const std::filesystem::path& folder);

}  // namespace plumbline::simulate
