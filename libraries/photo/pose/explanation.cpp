#include "photo/pose/explanation.hpp"

#include <fmt/core.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <set>

#include "geometry/exchanged_places.hpp"
#include "plumbline/stop.hpp"

namespace plumbline::pose {
namespace {

constexpr double kAgrees = 0.9;
constexpr double kNothingToExplain = 0.95;
constexpr double kLeft = 0.4;  ///< of the tags that disagree, at most so many may be left

/// One mistake: how what was given would have to be read to be right.
struct Hypothesis {
  std::string words;
  double tag_factor = 1;
  std::function<void(BrownCamera&)> camera = [](BrownCamera&) {};
  std::function<int(const TagT&)> id = [](const TagT& tag) { return tag.id; };
  std::array<int, 4> corners = {0, 1, 2, 3};
  std::function<double(double)> azimuth;  ///< where the plate really looks, from what is given [rad]; empty: as given
};

/// The view with its plate turned about the vertical through its anchor.
void turn_plate(const std::function<double(double)>& azimuth, TagView& view) {
  const Eigen::Vector3d normal = view.world_from_tag.rotation * Eigen::Vector3d::UnitZ();
  const double given = std::atan2(normal.x(), normal.y());
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(given - azimuth(given), Eigen::Vector3d::UnitZ()));
  view.world_from_tag.rotation = turn * view.world_from_tag.rotation;
  view.world_from_tag.translation =
      view.anchor_in_world + turn * (view.world_from_tag.translation - view.anchor_in_world);
}

std::string number(double value) { return fmt::format("{:.6g}", value); }

/// Share of the tags of the table that agree with a pose, over all images.
double share(const std::vector<const ImageTagsT*>& images, BrownCamera camera, const Field& field,
             const TagPoseSolver& solver, PoseSettings settings, const Hypothesis& hypothesis) {
  hypothesis.camera(camera);
  settings.robust.max_samples = std::min(settings.robust.max_samples, 60);
  std::size_t agree = 0, all = 0;
  for (const ImageTagsT* image : images) {
    std::vector<TagView> views;
    for (const auto& tag : image->tags) {
      ++all;
      TagT read;
      read.family = tag->family, read.id = hypothesis.id(*tag);
      const Field::Entry* entry = field.find(read);
      if (!entry || tag->corners.size() != 4) continue;
      for (const int k : hypothesis.corners) read.corners.push_back(tag->corners[k]);
      auto view = view_of(read, *entry, camera, settings);
      if (!view) continue;
      view->tag_size *= hypothesis.tag_factor;
      if (hypothesis.azimuth) turn_plate(hypothesis.azimuth, *view);
      views.push_back(*view);
    }
    try {
      agree += static_cast<std::size_t>(estimate_tag_pose(camera, views, solver, settings.robust).inlier_count);
    } catch (const NoTagPose&) {
    }
  }
  return all == 0 ? 0 : static_cast<double>(agree) / static_cast<double>(all);
}

void add_tag_sizes(const Field& field, std::vector<Hypothesis>& all) {
  const double size = field.entries().begin()->second.plate->tag_size;
  for (const double factor : {1e-3, 1e3, 0.1, 10.0, 0.0254, 1 / 0.0254, 0.5, 2.0}) {
    Hypothesis h;
    h.words = "the tag sizes of the plate table are wrong by a factor: tags of " + number(1e3 * size) + " mm measure " +
              number(1e3 * factor * size) + " mm in the images";
    h.tag_factor = factor;
    all.push_back(h);
  }
}

void add_cameras(const ImageCameras& cameras, std::size_t own, std::vector<Hypothesis>& all) {
  const CameraT& camera = cameras.given(own);
  const auto add = [&](const std::string& words, std::function<void(BrownCamera&)> change) {
    Hypothesis h;
    h.words = words;
    h.camera = std::move(change);
    all.push_back(h);
  };
  for (std::size_t other = 0; other < cameras.size(); ++other)
    if (other != own)
      add("its photographs look as if taken with camera '" + cameras.given(other).id + "'",
          [brown = cameras.brown(other)](BrownCamera& c) { c = brown; });
  if (camera.pixel_pitch > 0) {
    for (const double unit : {1e-3, 1.0}) {
      const double per_pixel = unit / camera.pixel_pitch;
      add(std::string("the focal length of the camera's calibration is in ") + (unit < 1 ? "millimetres" : "metres") +
              ", expected are pixels",
          [per_pixel](BrownCamera& c) { c.fx *= per_pixel, c.fy *= per_pixel; });
    }
  }
  add("cx and cy of the camera's calibration are exchanged", [](BrownCamera& c) { std::swap(c.cx, c.cy); });
  for (const double scale : {0.5, 0.25, 2.0, 4.0})
    add("the photographs are scaled: the camera's calibration is of photographs " + number(1 / scale) +
            " times their size",
        [scale](BrownCamera& c) {
          for (double* v : {&c.fx, &c.fy, &c.cx, &c.cy}) *v *= scale;
        });
  for (const double factor : {0.7, 0.8, 0.9, 1.1, 1.25, 1.4})
    add("the focal length of the camera's calibration is not that of the photographs: they look as if taken with "
        "about " +
            number(factor) + " times it",
        [factor](BrownCamera& c) { c.fx *= factor, c.fy *= factor; });
}

/// Before the corners: a plate that looks the other way and corners that run the other way round give the same images.
void add_azimuths(std::vector<Hypothesis>& all) {
  const auto add = [&](const std::string& words, std::function<double(double)> azimuth) {
    Hypothesis h;
    h.words = words;
    h.azimuth = std::move(azimuth);
    all.push_back(h);
  };
  add("facing_azimuth of the plate table is in radians, expected are degrees (or name the unit in the header)",
      [](double given) {
        constexpr double degree = M_PI / 180;
        return (given < 0 ? given + 2 * M_PI : given) / degree;
      });
  for (const int degrees : {180, 90, -90})
    add("facing_azimuth of the plate table is wrong by " + std::to_string(std::abs(degrees)) +
            " degrees: it is the direction in which the plates look, away from the wall, clockwise from north" +
            (degrees == 180
                 ? " (or the corners of the tags run the other way round than bottom left, bottom right, top "
                   "right, top left)"
                 : ""),
        [degrees](double given) { return given + degrees * M_PI / 180; });
}

void add_corners(std::vector<Hypothesis>& all) {
  for (const bool mirrored : {false, true})
    for (int first = 0; first < 4; ++first) {
      Hypothesis h;
      for (int k = 0; k < 4; ++k) h.corners[k] = (first + (mirrored ? -k : k)) & 3;
      if (h.corners == std::array<int, 4>{0, 1, 2, 3}) continue;
      h.words = mirrored
                    ? "the corners of the tags run the other way round: expected are bottom left, bottom right, top "
                      "right, top left; the detector has another order, or the photographs are mirrored"
                    : "the corners of the tags begin at another one than the bottom left, or all plates hang turned "
                      "by " +
                          std::to_string(90 * first) + " degrees";
      all.push_back(h);
    }
}

void add_ids(const Field& field, std::vector<Hypothesis>& all) {
  for (const int shift : {-1, 1, -2, 2}) {
    Hypothesis h;
    h.words =
        std::string("the ids of the plate table are moved: each tag hangs where the table has the one with the ") +
        (std::abs(shift) == 1 ? "" : "second-") + (shift > 0 ? "next higher" : "next lower") + " id";
    h.id = [shift](const TagT& tag) { return tag.id + shift; };
    all.push_back(h);
  }
  using Place = std::tuple<std::string, int, int, int>;  // family, floor, column, row
  std::map<Place, int> ids;
  std::map<std::pair<std::string, int>, Place> places;
  std::set<int> floors;
  for (const auto& [key, entry] : field.entries()) {
    const Place place{key.first, entry.plate->floor, entry.plate->column, entry.plate->row};
    ids[place] = key.second, places[key] = place;
    floors.insert(entry.plate->floor);
  }
  for (const int floor : floors) {
    std::vector<std::pair<std::string, int>> row;
    for (const auto& [key, place] : places)
      if (std::get<1>(place) == floor) row.push_back(key);
    for (const bool up : {false, true}) {
      std::map<std::pair<std::string, int>, int> moved;
      for (std::size_t i = 0; i < row.size(); ++i)
        moved[row[i]] = row[(i + (up ? 1 : row.size() - 1)) % row.size()].second;
      Hypothesis h;
      h.words = "the ids of floor " + std::to_string(floor) + " are moved by one in the plate table";
      h.id = [moved](const TagT& tag) {
        const auto found = moved.find({tag.family, tag.id});
        return found == moved.end() ? tag.id : found->second;
      };
      all.push_back(h);
    }
  }
  for (const int a : floors)
    for (const int b : floors) {
      if (a >= b) continue;
      Hypothesis h;
      h.words =
          "the tags of floors " + std::to_string(a) + " and " + std::to_string(b) + " are exchanged in the plate table";
      h.id = [=](const TagT& tag) {
        const auto found = places.find({tag.family, tag.id});
        if (found == places.end()) return tag.id;
        Place place = found->second;
        int& floor = std::get<1>(place);
        floor = floor == a ? b : floor == b ? a : floor;
        const auto other = ids.find(place);
        return other == ids.end() ? tag.id : other->second;
      };
      all.push_back(h);
    }
}

std::string another_family(const std::vector<ImageTagsT>& images, const Field& field) {
  std::set<std::string> seen, listed;
  for (const ImageTagsT& image : images)
    for (const auto& tag : image.tags) seen.insert(tag->family);
  for (const auto& [key, entry] : field.entries()) listed.insert(key.first);
  for (const std::string& family : seen)
    if (listed.count(family)) return "";
  if (listed.empty()) return "";
  if (seen.empty())
    return "none of the " + std::to_string(images.size()) +
           " photographs shows a tag of the family that the detector " + "looks for, and the plate table lists " +
           *listed.begin() + ": set that at the detector (" +
           "families, dictionary, or a family of read.tag_family), if the plates are in the photographs";
  return "the images show tags of the family " + *seen.begin() + ", the plate table lists " + *listed.begin() +
         ": correct the family in the plate table, or detect the other one";
}

}  // namespace

namespace {

/// The same of the photographs of one camera.
std::string what_would_explain_those_of(std::size_t own, const std::vector<const ImageTagsT*>& images,
                                        const ImageCameras& cameras, const Field& field, const TagPoseSolver& solver,
                                        const PoseSettings& settings) {
  std::vector<const ImageTagsT*> most = images;
  std::stable_sort(most.begin(), most.end(),
                   [](const auto* a, const auto* b) { return a->tags.size() > b->tags.size(); });
  most.resize(std::min<std::size_t>(most.size(), 10));
  const BrownCamera& brown = cameras.brown(own);
  std::vector<Hypothesis> all;
  add_tag_sizes(field, all);
  add_cameras(cameras, own, all);
  add_azimuths(all);
  add_corners(all);
  add_ids(field, all);
  const double now = share(most, brown, field, solver, settings, {});
  if (now >= kNothingToExplain) return "";
  double best = std::max(kAgrees, 1 - kLeft * (1 - now));
  std::string words;
  for (const Hypothesis& hypothesis : all) {
    stop_point();
    const double agree = share(most, brown, field, solver, settings, hypothesis);
    if (agree < best || (agree == best && !words.empty())) continue;
    best = agree;
    const std::string figures =
        fmt::format(" (then {:.0f} % of the tags agree with their images, as it is {:.0f} %)", 100 * agree, 100 * now);
    words = hypothesis.words + figures;
  }
  return words;
}

}  // namespace

std::string what_would_explain(const std::vector<ImageTagsT>& images, const ImageCameras& cameras, const Field& field,
                               const TagPoseSolver& solver, const PoseSettings& settings) {
  if (field.size() == 0) return "";
  if (const std::string family = another_family(images, field); !family.empty()) return family;
  std::vector<std::vector<const ImageTagsT*>> taken(cameras.size());
  for (const ImageTagsT& image : images)
    if (const auto camera = cameras.find(image)) taken[*camera].push_back(&image);
  std::string sentences;
  for (std::size_t c = 0; c < cameras.size(); ++c) {
    const std::string words = what_would_explain_those_of(c, taken[c], cameras, field, solver, settings);
    if (words.empty()) continue;
    if (!sentences.empty()) sentences += "; ";
    sentences += (cameras.size() > 1 ? "camera '" + cameras.given(c).id + "': " : "") + words;
  }
  return sentences;
}

namespace {

/// Rays to the centre of one tag.
struct Rays {
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  std::vector<std::pair<Eigen::Vector3d, Eigen::Vector3d>> rays;  ///< origin, direction

  void add(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) {
    const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - direction * direction.transpose();
    normal += across, right += across * origin;
    rays.emplace_back(origin, direction);
  }
  /// The point nearest to all rays, if they meet within `tolerance` [m].
  std::optional<Eigen::Vector3d> meet(double tolerance) const {
    if (rays.size() < 2) return std::nullopt;
    const Eigen::FullPivLU<Eigen::Matrix3d> lu(normal);
    if (lu.rank() < 3) return std::nullopt;
    const Eigen::Vector3d point = lu.solve(right);
    for (const auto& [origin, direction] : rays)
      if (!((point - origin).cross(direction).norm() < tolerance)) return std::nullopt;
    return point;
  }
};

Eigen::Vector3d centre_of(const Field::Entry& entry) {
  return entry.point->position + entry.plate->nominal_rotation.normalized() * entry.plate->tag_centre_in_plate;
}

}  // namespace

std::vector<std::string> exchanged_plates(const std::vector<ImageTagsT>& images, const PosesT& poses,
                                          const ImageCameras& cameras, const Field& field) {
  std::map<std::string, const ImageTagsT*> by_path;
  for (const ImageTagsT& image : images) by_path[image.path] = &image;
  std::map<std::pair<std::string, int>, Rays> rays;
  for (const auto& pose : poses.poses) {
    const RigidTransform world_from_cam = pose->cam_from_world.inverse();
    const ImageTagsT& image = *by_path.at(pose->path);
    const BrownCamera& camera = cameras.brown(cameras.of(image));
    for (const auto& tag : image.tags) {
      if (!field.find(*tag) || tag->corners.size() != 4) continue;
      const Eigen::Vector2d middle = 0.25 * (tag->corners[0] + tag->corners[1] + tag->corners[2] + tag->corners[3]);
      if (const auto normalised = unproject(camera, middle))
        rays[{tag->family, tag->id}].add(world_from_cam.translation,
                                         (world_from_cam.rotation * normalised->homogeneous()).normalized());
    }
  }
  std::vector<std::string> anchors;
  std::vector<Eigen::Vector3d> places, expected;
  for (const auto& [key, entry] : field.entries()) {
    const auto found = rays.find(key);
    const auto place = found == rays.end() ? std::nullopt : found->second.meet(0.15);
    anchors.push_back(entry.plate->anchor), expected.push_back(centre_of(entry));
    places.push_back(place.value_or(Eigen::Vector3d::Constant(std::nan(""))));
  }
  std::vector<std::string> sentences;
  for (const ExchangedPlace& pair : exchanged_places(places, expected)) {
    const std::string &anchor = anchors[pair.thing], &place = anchors[pair.place];
    sentences.push_back(pair.mutual ? "the plates of " + anchor + " and " + place +
                                          " hang in each other's place: their tags are exchanged in the plate table, "
                                          "or on the facade"
                                    : "the plate of " + anchor + " hangs where " + place +
                                          " should: check its tag in the plate table, and which plate is which");
  }
  return sentences;
}

}  // namespace plumbline::pose
