#include "campaign.hpp"

#include <fmt/core.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "design_ifc.hpp"
#include "geometry/random.hpp"
#include "jpeg.hpp"
#include "observations.hpp"
#include "survey/files/gsi.hpp"
#include "text_output.hpp"
#include "wings.hpp"

namespace plumbline::simulate {
namespace {

std::string campaign_yaml(const Campaign& c, bool observed) {
  return "# What a site hands over; docs/campaign_folder.md explains every line.\n"
         "plumbline_campaign: 1\n"
         "name: simulated facade, " +
         std::to_string(c.building.options.floors) + (c.building.options.floors == 1 ? " floor, " : " floors, ") +
         std::to_string(c.building.options.columns) + " columns" +
         (c.options.shape == "flat" ? "" : ", shape " + c.options.shape) + "\n" +
         (observed ? "observations: observations.csv\n" : "images: images/*.jpg\n") +
         "camera: camera.yaml\n"
         "plates: plates.csv\n"
         "survey: survey/*.gsi\n"
         "instrument: " +
         c.options.survey.instrument +
         "\n"
         "date: 2026-05-04\n"
         "control: control.csv\n"
         "design: design.ifc\n";
}

std::string camera_yaml(const SimulatedCamera& camera, const BrownCamera& values, bool with_sigmas) {
  std::string text =
      "plumbline_camera: 1\nid: " + camera.profile.name + "\nmake: " + camera.profile.make +
      "\nmodel: " + camera.profile.model + "\nwidth: " + std::to_string(values.width) +
      "\nheight: " + std::to_string(values.height) + "\npixel_pitch_um: " + number(1e6 * camera.profile.pixel_pitch) +
      "\npixel_origin: centre  # the centre of the top-left pixel is (0, 0); 'corner': it is (0.5, 0.5)\n"
      "# px for f and c; Brown's distortion in OpenCV's order and signs\n";
  const auto list = [&](const char* name, const std::array<double, BrownCamera::parameter_count>& numbers) {
    text += std::string(name) + ":\n";
    for (std::size_t i = 0; i < values.names().size(); ++i)
      text += std::string("  ") + values.names()[i] + ": " + number(numbers[i]) + "\n";
  };
  list("parameters", values.parameters());
  if (with_sigmas) list("sigmas", camera.profile.calibration_sigmas);
  return text;
}

std::string plates_csv(const Building& c) {
  std::string text =
      "anchor,role,floor,column,row,tag_family,tag_id,tag_size_mm,tag_x_mm,tag_y_mm,tag_z_mm,facing_azimuth_deg,"
      "batch\n";
  const MarkerPlate& plate = c.nominal_plate;
  for (const Anchor& a : c.anchors) {
    text += a.id + "," + to_string(a.role) + "," + std::to_string(a.floor) + "," + std::to_string(a.column) + "," +
            std::to_string(a.row) + ",tag36h11," + std::to_string(a.tag_id) + "," + number(1e3 * plate.tag_size);
    for (const double offset : plate.tag_centre_in_plate) text += "," + number(1e3 * offset);
    const Eigen::Vector3d out = c.wings[a.wing].rotation * -Eigen::Vector3d::UnitY();
    const double azimuth = std::atan2(out.x(), out.y()) * 180 / std::numbers::pi;
    text += "," + number(std::round(1e6 * (azimuth < 0 ? azimuth + 360 : azimuth)) / 1e6) + ",batch-" +
            std::to_string(a.batch + 1) + "\n";
  }
  return text;
}

std::string control_csv(const StationPlan& plan, const SurveyOptions& survey) {
  std::string text = "id,east_m,north_m,height_m,sigma_east_mm,sigma_north_mm,sigma_height_mm\n";
  for (const GroundPoint& p : plan.ground_points) {
    text += p.id;
    for (const double coordinate : p.given) text += "," + fixed(coordinate, 5);
    for (int axis = 0; axis < 3; ++axis) text += "," + number(1e3 * p.sigma);
    text += "\n";
  }
  for (const PlannedSetUp& s : plan.set_ups) {
    if (!survey.known_marks) break;
    text += s.id;
    for (const double coordinate : s.given_mark) text += "," + fixed(coordinate, 5);
    for (int axis = 0; axis < 3; ++axis) text += "," + number(1e3 * survey.control_sigma);
    text += "\n";
  }
  return text;
}

std::string taken_at(std::size_t index) {  // a photograph every 20 s from nine in the morning
  const int seconds = static_cast<int>(20 * index);
  return fmt::format("2026:05:04 {:02}:{:02}:{:02}", (9 + seconds / 3600) % 24, seconds / 60 % 60, seconds % 60);
}

RenderOptions render_options(const Campaign& c, std::size_t index) {
  RenderOptions options;
  options.noise_scale = c.options.noise_scale;
  options.blur = c.options.blur;
  options.light_gradient = c.options.light_gradient;
  options.haze = c.options.haze;
  Random random(c.seed, "light", index);
  options.exposure = 1 + 0.05 * (2 * random.uniform() - 1);
  options.seed = derive_seed(c.seed, "image", index);
  options.perturbations = c.options.perturbations;
  options.panels = c.panels, options.panel_contrast = c.options.panels;
  return options;
}

}  // namespace

namespace {

/// The first facade is that of the flat building of the same seed.
std::uint64_t derived(std::uint64_t seed, std::size_t wing) {
  return wing == 0 ? seed : derive_seed(seed, "wing", wing);
}

WingPlan plan_wing(const CampaignOptions& options, const SimulatedCamera& camera, std::uint64_t seed,
                   std::uint64_t visit) {
  WingPlan wing;
  wing.building = make_building(options.building, seed);
  wing.stations = plan_camera_stations(wing.building, camera, options.cameras, visit);
  wing.plan = plan_set_ups(wing.building, options.survey, seed);
  const std::vector<std::string> broken = broken_station_rules(wing.building, wing.plan);
  if (!broken.empty())
    throw std::invalid_argument("the station plan breaks " + std::to_string(broken.size()) +
                                " rules of the survey, the first: " + broken.front());
  return wing;
}

}  // namespace

Campaign make_campaign(const CampaignOptions& options, std::uint64_t seed) {
  Campaign c;
  c.options = options;
  c.seed = options.visit.value_or(seed);
  c.camera = make_camera(camera_profile(options.camera), seed);
  const double width = options.building.columns * options.building.spacing;
  const double distance = options.cameras.distance > 0 ? options.cameras.distance : c.camera.profile.distance;
  const auto places = wings_of(options.shape, width, options.step, 2 + std::max(distance, options.survey.distance));
  if (places.size() > 1 && options.obstruction.scaffold_spacing > 0)
    throw std::invalid_argument("a scaffold stands before a flat facade only; the shape is " + options.shape);
  std::vector<WingPlan> wings;
  for (std::size_t w = 0; w < places.size(); ++w)
    wings.push_back(plan_wing(options, c.camera, derived(seed, w), derived(c.seed, w)));
  WingPlan all = join_wings(std::move(wings), places, c.camera.truth, options.cameras.required_tags);
  c.building = std::move(all.building), c.stations = std::move(all.stations), c.plan = std::move(all.plan);
  for (Anchor& anchor : c.building.anchors)
    if (const auto now = options.moved.find(anchor.id); now != options.moved.end()) {
      anchor.building_from_plate.translation += now->second - anchor.built;
      anchor.built = now->second;
    }
  c.obstruction = make_obstruction(c.building, options.obstruction, seed);
  if (options.panels > 0) {
    if (places.size() > 1)
      throw std::invalid_argument("panels hang before a flat facade only; the shape is " + options.shape);
    c.panels = hang_panels(c.building, options.panel_sigma, seed);
  }
  if (options.readings) c.observations = observe(c.building, c.plan, options.survey, c.seed);
  return c;
}

SimulatedCamera camera_at(const Campaign& c, std::size_t station) {
  SimulatedCamera camera = c.camera;
  Random random(c.seed, "interior of " + c.stations[station].image);
  const Perturbations& p = c.options.perturbations;
  camera.truth.cx += random.normal(p.principal_point_sigma);
  camera.truth.cy += random.normal(p.principal_point_sigma);
  const double change = 1 + random.normal(p.distance_distortion);
  camera.truth.k1 *= change, camera.truth.k2 *= change;
  return camera;
}

DepthDistortion depth_distortion_of(const Campaign& c) {
  const double distance = c.options.cameras.distance;
  return {c.options.perturbations.depth_distortion, distance > 0 ? distance : c.camera.profile.distance};
}

void write_observations(const Campaign& c, const std::filesystem::path& folder, double sigma) {
  std::string text = "image,family,tag_id,x0_px,y0_px,x1_px,y1_px,x2_px,y2_px,x3_px,y3_px,sigma_px\n";
  for (const ObservedImage& image : observe_corners(c, sigma, c.seed))
    for (const VisibleTag& tag : image.tags) {
      text += "images/" + image.station->image + ",tag36h11," + std::to_string(tag.anchor->tag_id);
      for (const Eigen::Vector2d& corner : tag.corners) text += "," + fixed(corner.x(), 4) + "," + fixed(corner.y(), 4);
      text += "," + number(sigma) + "\n";
    }
  write_file(folder / "observations.csv", text);
}

void write_campaign_files(const Campaign& c, const std::filesystem::path& folder, bool observed) {
  std::filesystem::create_directories(folder / "survey");
  write_file(folder / "campaign.yaml", campaign_yaml(c, observed));
  write_file(folder / "camera.yaml", camera_yaml(c.camera, c.camera.calibration, true));
  write_file(folder / "plates.csv", plates_csv(c.building));
  write_file(folder / "control.csv", control_csv(c.plan, c.options.survey));
  write_file(folder / "survey/total_station.gsi", survey::write_gsi(c.observations));
  write_file(folder / "design.ifc", write_design_ifc(c.building, c.seed, c.options.design_in_millimetres));
}

std::uint64_t image_memory(const CameraProfile& profile) {
  const auto pixels =
      static_cast<std::uint64_t>(profile.nominal.width) * static_cast<std::uint64_t>(profile.nominal.height);
  return pixels + (std::uint64_t{32} << 20);  // the JPEG while it grows, the plates, the grid of rays
}

void write_images(const Campaign& c, const std::filesystem::path& folder,
                  const std::function<bool(std::size_t)>& progress) {
  std::filesystem::create_directories(folder / "images");
  std::atomic<std::size_t> done{0};
  std::atomic<bool> stopped{false};
  tbb::parallel_for(std::size_t{0}, c.stations.size(), [&](std::size_t i) {
    if (stopped) return;
    const CameraStation& station = c.stations[i];
    const Renderer renderer(c.building, camera_at(c, i), station.camera_from_building, render_options(c, i),
                            c.obstruction);
    const CameraProfile& profile = c.camera.profile;
    const int quality = c.options.perturbations.jpeg_quality;
    const ExifFields exif{profile.make, profile.model, taken_at(i), profile.focal_length};
    write_file(folder / "images" / station.image,
               encode_jpeg(renderer, quality > 0 ? quality : profile.jpeg_quality, exif));
    if (progress && !progress(++done)) stopped = true;
  });
  if (stopped) throw std::runtime_error("stopped while rendering images");
}

void write_truth(const Campaign& c, const std::filesystem::path& folder) {
  std::string anchors =
      "anchor,role,floor,column,row,design_x_m,design_y_m,design_z_m,x_m,y_m,z_m,rotation_w,rotation_x,rotation_y,"
      "rotation_z\n";
  std::string tags = "tag_id,anchor,batch,size_mm\n";
  for (const Anchor& a : c.building.anchors) {
    anchors += a.id + "," + to_string(a.role) + "," + std::to_string(a.floor) + "," + std::to_string(a.column) + "," +
               std::to_string(a.row);
    for (const double v : a.design) anchors += "," + number(v);
    for (const double v : a.built) anchors += "," + number(v);
    const Eigen::Quaterniond& q = a.building_from_plate.rotation;
    for (const double v : {q.w(), q.x(), q.y(), q.z()}) anchors += "," + number(v);
    anchors += "\n";
    tags += std::to_string(a.tag_id) + "," + a.id + ",batch-" + std::to_string(a.batch + 1) + "," +
            number(1e3 * a.true_plate.tag_size) + "\n";
  }
  std::string cameras = "image,w,x,y,z,tx_m,ty_m,tz_m\n";  // camera_from_building
  std::string corners = "image,tag_id,corner,x_px,y_px\n";
  for (std::size_t station = 0; station < c.stations.size(); ++station) {
    const CameraStation& s = c.stations[station];
    const RigidTransform& pose = s.camera_from_building;
    cameras += s.image;
    for (const double v : {pose.rotation.w(), pose.rotation.x(), pose.rotation.y(), pose.rotation.z()}) {
      cameras += "," + number(v);
    }
    for (const double v : pose.translation) cameras += "," + number(v);
    cameras += "\n";
    for (const VisibleTag& tag :
         visible_tags(c.building, camera_at(c, station).truth, pose, 12, c.obstruction, depth_distortion_of(c))) {
      for (std::size_t i = 0; i < 4; ++i) {
        corners += s.image + "," + std::to_string(tag.anchor->tag_id) + "," + std::to_string(i) + "," +
                   number(tag.corners[i].x()) + "," + number(tag.corners[i].y()) + "\n";
      }
    }
  }
  std::string set_ups = "set_up,x_m,y_m,z_m,instrument_height_m,orientation_rad\n";
  for (const PlannedSetUp& s : c.plan.set_ups) {
    set_ups += s.id;
    for (const double v : s.axis) set_ups += "," + number(v);
    set_ups += "," + number(s.instrument_height) + "," + number(s.orientation) + "\n";
  }
  if (!c.panels.empty()) write_file(folder / "panels.csv", panels_truth(c.panels));
  std::string ground = "id,x_m,y_m,z_m\n";
  for (const GroundPoint& p : c.plan.ground_points) {
    ground += p.id;
    for (const double v : p.truth) ground += "," + number(v);
    ground += "\n";
  }
  write_file(folder / "anchors.csv", anchors);
  write_file(folder / "tags.csv", tags);
  write_file(folder / "cameras.csv", cameras);
  write_file(folder / "corners.csv", corners);
  write_file(folder / "set_ups.csv", set_ups);
  write_file(folder / "control.csv", ground);
  write_file(folder / "camera.yaml", camera_yaml(c.camera, c.camera.truth, false));
}

}  // namespace plumbline::simulate
