// simulate.campaign and simulate.observations: the same simulated site, once as a folder of files, once as
// observations.
#include <tbb/task_arena.h>

#include <algorithm>

#include "artifacts/camera.hpp"
#include "artifacts/folder.hpp"
#include "artifacts/image_tags.hpp"
#include "artifacts/plates.hpp"
#include "artifacts/points.hpp"
#include "artifacts/poses.hpp"
#include "artifacts/survey_artifact.hpp"
#include "artifacts/survey_observations.hpp"
#include "campaign.hpp"
#include "observations.hpp"
#include "plumbline/node.hpp"
#include "simulated_site.hpp"

namespace {

using namespace plumbline;
namespace fs = std::filesystem;

struct SimulateCampaign : simulate::SimulatedSite {
  static constexpr Info info{
      "simulate.campaign", "", 5,
      "Simulates a site: photographs, total-station file, design IFC, and the truth beside them"};
  Param<std::string> instrument{
      "instrument", "ics50_assumed",
      one_of("ics50_assumed", "total_station_1arcsec", "total_station_2arcsec", "total_station_5arcsec"),
      "total station; its profile is named in campaign.yaml"};
  Param<double> survey_noise{"survey_noise", 1.0, "1", between(0, 100), "factor on the instrument's errors"};
  Param<int64_t> sets{"sets", 2, between(1, 20), "rounds of observations, each in two faces"};
  Param<double> control_sigma{"control_sigma", 0.0005, "m", between(1e-5, 0.1), "of the ground control points"};
  Param<double> set_up_height_sigma{
      "set_up_height_sigma", 0.0, "m", between(0, 0.1),
      "error of measured instrument heights: common to all that a set-up over a known mark "
      "sees; without known_marks the set-up's own height takes it up"};
  Param<bool> known_marks{"known_marks", false, "the set-ups stand over marks whose coordinates are in control.csv"};
  Param<double> image_noise{"image_noise", 1.0, "1", between(0, 20), "factor on the camera's noise"};
  Param<double> blur{"blur", -1.0, "px", between(-1, 10), "point spread function, 1 sigma; negative: the profile's"};
  Param<double> light_gradient{"light_gradient", 0.2, "1", between(0, 0.9), "change of the light across the facade"};
  Param<double> haze{"haze", 0.0, "1", between(0, 0.95), "share of the light that dust or mist scatters in"};
  Param<double> panels{
      "panels", 0.0, "1", between(0, 1),
      "contrast of the texture of the design's panels, which then hang at their places, the plates seen "
      "through them; 0: none hangs. truth/panels.csv has how they hang"};
  Param<double> panel_sigma{"panel_sigma", 0.002, "m", between(0, 0.02),
                            "how far panels hang from the design's face; their tilts and bows are half as large"};
  Param<std::string> ifc_unit{"ifc_unit", "millimetre", one_of("millimetre", "metre"), "length unit of the design IFC"};
  Param<std::string> photographs{"photographs", "rendered", one_of("rendered", "observed"),
                                 "observed: observations.csv with the corners and noise of pixel_sigma, in no time"};
  Param<double> pixel_sigma{"pixel_sigma", 0.1, "px", between(0.001, 10), "noise of observed corners"};
  Optional<Points> now{"now", frame("frame=building"),
                       "where anchors are by now, such as after their brackets were set; without, as they were built"};
  Param<int64_t> site_seed{
      "site_seed", -1, between(-1, 1e15),
      "of building, plates and camera; stations and noise stay those of the node's own seed, another in each "
      "round: the same site seen again. -1: all of the node's own"};
  Out<Folder> folder{"folder", "the campaign, as a site would hand it over"};
  Out<Folder> truth{"truth", "what no processing may see"};

  void run(Context& context) override {
    simulate::CampaignOptions o = site_options();
    o.survey = {*instrument,          *survey_noise, static_cast<int>(*sets), 9.0, *control_sigma,
                *set_up_height_sigma, *known_marks};
    o.noise_scale = *image_noise;
    o.blur = *blur;
    o.light_gradient = *light_gradient;
    o.haze = *haze;
    o.panels = *panels, o.panel_sigma = *panel_sigma;
    o.design_in_millimetres = *ifc_unit == "millimetre";
    if (*site_seed >= 0) o.visit = context.seed();
    if (now)
      for (const auto& point : now.unpack().points) o.moved[point->id] = point->position;
    const simulate::Campaign campaign =
        simulate::make_campaign(o, o.visit ? static_cast<uint64_t>(*site_seed) : context.seed());

    const bool observed = *photographs == "observed";
    if (*depth_distortion != 0 && !observed)
      throw std::runtime_error(
          "depth_distortion is not in rendered photographs: take photographs=observed, or leave it out");
    if (*shape != "flat" && !observed)
      throw std::runtime_error("photographs are rendered of a flat facade only: shape=" + *shape +
                               " needs photographs=observed");
    if (observed && *panels > 0)
      throw std::runtime_error("panels are in rendered photographs only: take photographs=rendered, or leave them out");
    if (observed) refuse_what_is_rendered_only();
    const auto campaign_folder = folder.make_folder(), truth_folder = truth.make_folder();
    simulate::write_campaign_files(campaign, campaign_folder.path, observed);
    if (observed)
      simulate::write_observations(campaign, campaign_folder.path, *pixel_sigma);
    else
      render(campaign, campaign_folder.path, context);
    simulate::write_truth(campaign, truth_folder.path);
    folder.commit(list_files(campaign_folder.path, campaign_folder.uri, context));
    truth.commit(list_files(truth_folder.path, truth_folder.uri, context));
  }

 private:
  static void render(const simulate::Campaign& campaign, const fs::path& folder, Context& context) {
    const auto workers = static_cast<uint64_t>(tbb::this_task_arena::max_concurrency());
    context.reserve_memory(workers * simulate::image_memory(campaign.camera.profile));
    simulate::write_images(campaign, folder, [&](std::size_t done) {
      context.progress(static_cast<double>(done) / static_cast<double>(campaign.stations.size()), "rendering");
      return !context.cancelled();
    });
  }

  static FolderT list_files(const fs::path& root, const std::string& uri, const Context& context) {
    FolderT result;
    result.uri = uri;
    for (const auto& entry : fs::recursive_directory_iterator(root)) {
      if (!entry.is_regular_file()) continue;
      auto file = std::make_unique<FolderEntryT>();
      file->path = entry.path().lexically_relative(root).generic_string();
      file->sha256 = context.digest(entry.path().string());
      file->size = entry.file_size();
      result.files.push_back(std::move(file));
    }
    std::sort(result.files.begin(), result.files.end(), [](const auto& a, const auto& b) { return a->path < b->path; });
    return result;
  }
};

struct SimulateObservations : simulate::SimulatedSite {
  static constexpr Info info{"simulate.observations", "", 5,
                             "The site of simulate.campaign as observations with noise of known size, without files"};
  Param<double> pixel_sigma{
      "pixel_sigma", 0.1, "px", between(0, 10),
      "noise of each corner coordinate; 0: none and no covariance stated, so that who uses them takes its own"};
  Param<std::string> survey{
      "survey", "coordinates", one_of("coordinates", "readings"),
      "what was surveyed: coordinates with noise of survey_sigma, or directions, zenith angles and "
      "distances of a total station from two set-ups a floor, adjusted to coordinates"};
  Param<double> survey_noise{"survey_noise", 1.0, "1", between(0, 100),
                             "readings: factor on the instrument's errors, of which nobody is told"};
  Param<double> survey_sigma{"survey_sigma", 0.001, "m", between(0, 0.1),
                             "coordinates: noise of each surveyed coordinate"};
  Param<double> height_walk{"height_walk", 0.0, "m", between(0, 0.1),
                            "height error common to a floor: a random walk with such steps from floor to floor"};
  Param<std::string> control{"control", "all", one_of("all", "two_per_floor", "ground_floor", "one_column"),
                             "which of the control markers hold the model; the others only tie the images together"};
  Param<double> control_blunders{"control_blunders", 0.0, "1", between(0, 1),
                                 "share of control points that are off by a blunder in a random direction"};
  Param<double> blunder_size{"blunder_size", 0.02, "m", between(0, 10), "how far they are off"};
  Param<double> tag_blunders{"tag_blunders", 0.0, "1", between(0, 1),
                             "share of tags whose corners are off together by 5 px and more in an image"};
  Param<double> tag_blunder_size{"tag_blunder_size", 50.0, "px", between(5, 1e4), "how far they are off at most"};
  Param<double> corner_blunders{"corner_blunders", 0.0, "1", between(0, 1),
                                "share of single corners that are off by 2 px and more, whatever their tag"};
  Param<double> corner_blunder_size{"corner_blunder_size", 20.0, "px", between(2, 1e4), "how far they are off at most"};
  OutList<ImageTags> observations{"observations", "tags of each image, with the covariance of their corners"};
  Out<Camera> calibration{"camera", "calibration with its error and uncertainty"};
  Out<Plates> plates{"plates", frame("frame=building"), "which tag stands for which anchor"};
  Out<Points> points{"points", frame("frame=building"), "surveyed anchors with their covariance"};
  Out<SurveyObservations> readings{"survey", frame("frame=building"),
                                   "what 'points' come from: readings and ground control, or the observed coordinates"};
  Out<Points> design{"design", frame("frame=building"), "anchors where the design has them"};
  Out<Points> truth{"truth", frame("frame=building"), "anchors where they really are"};
  Out<Poses> true_poses{"true_poses", frame("frame=building"), "of the images, without covariance"};

  void run(Context& context) override {
    const uint64_t seed = context.seed();
    refuse_what_is_rendered_only();
    simulate::CampaignOptions options = site_options();
    options.survey.noise_scale = *survey_noise;
    options.readings = *survey == "readings";
    const simulate::Campaign campaign = simulate::make_campaign(options, seed);
    for (auto& image : simulate::observe_corners(campaign, *pixel_sigma, seed)) {
      simulate::displace_tags(image, *tag_blunders, *tag_blunder_size, seed);
      simulate::displace_corners(image, *corner_blunders, *corner_blunder_size, seed);
      commit_image(image, campaign);
    }
    commit_camera(campaign.camera);
    commit_plates(campaign.building);
    commit_points(campaign, seed);
    commit_poses(campaign);
  }

 private:
  /// "check" for a control marker that the layout does not use: it must not hold the model.
  std::string role_of(const simulate::Anchor& anchor) const {
    return simulate::holds_model(anchor, static_cast<int>(*columns), *control) ? "control" : "check";
  }

  void commit_image(const simulate::ObservedImage& image, const simulate::Campaign& campaign) {
    ImageTagsT out;
    out.path = "images/" + image.station->image;
    out.camera = campaign.camera.profile.name;
    out.width = campaign.camera.truth.width;
    out.height = campaign.camera.truth.height;
    for (const simulate::VisibleTag& seen : image.tags) {
      auto tag = std::make_unique<TagT>();
      tag->family = "tag36h11";
      tag->id = seen.anchor->tag_id;
      tag->corners.assign(seen.corners.begin(), seen.corners.end());
      const double variance = *pixel_sigma * *pixel_sigma;
      if (variance > 0) {
        for (int corner = 0; corner < 4; ++corner) {
          for (const double value : {variance, 0.0, variance}) tag->corner_covariances.push_back(value);
        }
      }
      out.tags.push_back(std::move(tag));
    }
    observations.commit(out);
  }

  void commit_poses(const simulate::Campaign& campaign) {
    PosesT out;
    for (const simulate::CameraStation& station : campaign.stations) {
      auto pose = std::make_unique<PoseT>();
      pose->path = "images/" + station.image;
      pose->cam_from_world = station.camera_from_building;
      out.poses.push_back(std::move(pose));
    }
    true_poses.commit(out);
  }

  void commit_camera(const simulate::SimulatedCamera& simulated) {
    CameraT out;
    out.id = simulated.profile.name;
    out.width = simulated.calibration.width;
    out.height = simulated.calibration.height;
    out.pixel_pitch = simulated.profile.pixel_pitch;
    const auto values = simulated.calibration.parameters();
    out.parameters.assign(values.begin(), values.end());
    const auto& sigmas = simulated.profile.calibration_sigmas;
    for (std::size_t i = 0; i < sigmas.size(); ++i) {
      for (std::size_t j = 0; j <= i; ++j) out.covariance.push_back(i == j ? sigmas[i] * sigmas[i] : 0.0);
    }
    out.source = "simulated calibration";
    calibration.commit(out);
  }

  void commit_plates(const simulate::Building& building) {
    PlatesT out;
    for (const simulate::Anchor& anchor : building.anchors) {
      auto plate = std::make_unique<PlateT>();
      plate->anchor = anchor.id;
      plate->tag_family = "tag36h11";
      plate->tag_id = anchor.tag_id;
      plate->tag_size = building.nominal_plate.tag_size;
      plate->tag_centre_in_plate = building.nominal_plate.tag_centre_in_plate;
      plate->nominal_rotation = building.wings[anchor.wing].rotation * simulate::facade_from_plate();
      plate->batch = "batch-" + std::to_string(anchor.batch + 1);
      plate->role = role_of(anchor);
      plate->floor = anchor.floor;
      plate->column = anchor.column;
      plate->row = anchor.row;
      out.plates.push_back(std::move(plate));
    }
    std::sort(out.plates.begin(), out.plates.end(), [](const auto& a, const auto& b) { return a->anchor < b->anchor; });
    plates.commit(out);
  }

  std::unique_ptr<PointT> point(const simulate::Anchor& anchor, const Eigen::Vector3d& position, double sigma) const {
    auto out = std::make_unique<PointT>();
    out->id = anchor.id;
    out->position = position;
    out->sigma.setConstant(sigma);
    out->role = role_of(anchor);
    return out;
  }

  simulate::SurveyedSite surveyed_site(const simulate::Campaign& campaign, uint64_t seed) const {
    if (*survey == "readings") {
      if (*height_walk > 0 || *control_blunders > 0)
        throw std::runtime_error(
            "height_walk and control_blunders are errors of surveyed coordinates; with survey=readings the errors are "
            "those of the instrument (survey_noise)");
      return simulate::survey_by_readings(campaign);
    }
    simulate::SurveyedSite site;
    site.points = simulate::observe_points(campaign, *survey_sigma, *height_walk, seed);
    simulate::displace_points(site.points, *control_blunders, *blunder_size, seed);
    site.covariance = simulate::point_covariance(site.points, *survey_sigma, *height_walk);
    site.readings = simulate::as_observed_coordinates(site.points, site.covariance);
    return site;
  }

  void commit_points(const simulate::Campaign& campaign, uint64_t seed) {
    PointsT surveyed, designed, built;
    const simulate::SurveyedSite site = surveyed_site(campaign, seed);
    const Eigen::MatrixXd& covariance = site.covariance;
    for (std::size_t i = 0; i < site.points.size(); ++i) {
      const simulate::Anchor& anchor = *site.points[i].anchor;
      surveyed.points.push_back(point(anchor, site.points[i].position, 0));
      surveyed.points.back()->sigma = covariance.diagonal().segment<3>(static_cast<Eigen::Index>(3 * i)).cwiseSqrt();
      designed.points.push_back(point(anchor, anchor.design, std::nan("")));
      built.points.push_back(point(anchor, anchor.built, 0));
      // Errors are compared on the same anchors whatever the layout: those that never are control.
      if (anchor.role == simulate::AnchorRole::control && built.points.back()->role == "check")
        built.points.back()->role = "tie";
    }
    for (Eigen::Index i = 0; i < covariance.rows(); ++i) {
      for (Eigen::Index j = 0; j <= i; ++j) surveyed.covariance.push_back(covariance(i, j));
    }
    points.commit(surveyed);
    readings.commit(survey::to_artifact(site.readings));
    design.commit(designed);
    truth.commit(built);
  }
};

}  // namespace

PLUMBLINE_PLUGIN("simulate", PLUMBLINE_BUILD_ID, "MIT", SimulateCampaign, SimulateObservations)
