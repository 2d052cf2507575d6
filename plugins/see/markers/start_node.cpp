#include "start_node.hpp"

#include <fmt/core.h>

#include <cmath>
#include <map>
#include <set>

#include "base/text/words.hpp"
#include "geometry/exchanged_places.hpp"
#include "geometry/packed_symmetric.hpp"
#include "photo/block/control_words.hpp"
#include "photo/markers/survey_frame.hpp"

namespace plumbline::markers {
namespace {

constexpr double unknown_size = 0.1;  // [m] of a tag whose size nobody said: the survey gives the scale

std::string listed(const std::set<std::string>& names) { return text::join({names.begin(), names.end()}, 8); }

/// "tag36h11:7" or "7".
std::string point_of_tag(const Marker& marker, const std::map<std::string, const PointT*>& points) {
  const std::string number = std::to_string(marker.id), full = marker.family + ":" + number;
  return points.count(full) ? full : points.count(number) ? number : "";
}

/// The plate of every tag that was seen; those of the table first, as they stand there.
PlatesT plates_of(const PlatesT& given, const MarkerBlock& block, const PointsT& surveyed, double tag_size) {
  std::map<std::string, const PointT*> points;
  for (const auto& point : surveyed.points) points[point->id] = point.get();
  PlatesT table;
  std::set<std::pair<std::string, int>> known;
  std::set<std::string> anchors;
  for (const auto& plate : given.plates) {
    known.insert({plate->tag_family, plate->tag_id}), anchors.insert(plate->anchor);
    table.plates.push_back(std::make_unique<PlateT>(*plate));
  }
  for (const Marker& marker : block.markers) {
    if (known.count({marker.family, marker.id})) continue;
    auto plate = std::make_unique<PlateT>();
    if (given.plates.empty()) plate->anchor = point_of_tag(marker, points);
    plate->role = plate->anchor.empty() ? "tie" : "control";
    if (plate->anchor.empty()) plate->anchor = "tag " + marker.family + ":" + std::to_string(marker.id);
    if (!anchors.insert(plate->anchor).second) continue;  // "7" for tags of two families: the first one's
    plate->tag_family = marker.family, plate->tag_id = marker.id;
    plate->tag_centre_in_plate = Eigen::Vector3d::Zero();
    plate->nominal_rotation = Eigen::Quaterniond::Identity();
    plate->floor = 1;
    table.plates.push_back(std::move(plate));
  }
  for (auto& plate : table.plates)
    if (!(plate->tag_size > 0)) plate->tag_size = tag_size > 0 ? tag_size : std::nan("");
  return table;
}

/// The tags of the table in the block: their sizes, and which of them are surveyed.
std::vector<SurveyedTag> surveyed_tags(const PlatesT& table, const PointsT& points, MarkerBlock& block) {
  std::map<std::string, const PointT*> point_of;
  for (const auto& point : points.points) point_of[point->id] = point.get();
  std::map<std::pair<std::string, int>, const PlateT*> plate_of;
  for (const auto& plate : table.plates) plate_of[{plate->tag_family, plate->tag_id}] = plate.get();
  std::vector<SurveyedTag> surveyed;
  for (size_t m = 0; m < block.markers.size(); ++m) {
    Marker& marker = block.markers[m];
    const auto plate = plate_of.find({marker.family, marker.id});
    if (plate == plate_of.end()) continue;
    if (plate->second->tag_size > 0) marker.size = plate->second->tag_size;
    const auto point = point_of.find(plate->second->anchor);
    if (point == point_of.end() || !point->second->position.allFinite()) continue;
    surveyed.push_back({static_cast<int>(m), point->second->id, point->second->position,
                        plate->second->tag_centre_in_plate, plate->second->role == "check"});
  }
  return surveyed;
}

/// Sizes are either all known or none: a network of which some tags have one would be bent by the guessed ones. Tags
/// that are not in the plate table can be left out.
void require_sizes(const PlatesT& given, PlatesT& table, BlockInput& input) {
  std::set<std::pair<std::string, int>> listed_tags;
  for (const auto& plate : given.plates) listed_tags.insert({plate->tag_family, plate->tag_id});
  std::set<std::pair<std::string, int>> strangers;
  std::set<std::string> without, left_out;
  bool known = false;
  for (const auto& plate : table.plates) {
    const std::string name = plate->tag_family + ":" + std::to_string(plate->tag_id);
    const bool stranger = !given.plates.empty() && !listed_tags.count({plate->tag_family, plate->tag_id});
    known = known || plate->tag_size > 0;
    if (plate->tag_size > 0) continue;
    if (stranger)
      strangers.insert({plate->tag_family, plate->tag_id}), left_out.insert(name);
    else
      without.insert(name);
  }
  if (!known) return;
  if (!without.empty())
    throw std::runtime_error("the size of some tags is known and that of others (" + listed(without) +
                             ") not: give tag_size in metres, or the column tag_size in every row of the plate table");
  if (strangers.empty()) return;
  input.warnings.push_back(
      "tags " + listed(left_out) +
      " are in no row of the plate table and their size is not known: left out; tag_size in metres "
      "lets them tie photographs together");
  const auto is_stranger = [&](const std::string& family, int id) { return strangers.count({family, id}) > 0; };
  std::erase_if(table.plates, [&](const auto& plate) { return is_stranger(plate->tag_family, plate->tag_id); });
  std::erase_if(input.block.views, [&](const MarkerView& view) {
    const Marker& marker = input.block.markers[view.marker];
    return is_stranger(marker.family, marker.id);
  });
}

SurveyFrame frame_of(const MarkerResult& network, const std::vector<SurveyedTag>& surveyed, const MarkerBlock& block,
                     const PointsT& points) {
  try {
    return fit_to_survey(network, surveyed);
  } catch (const std::runtime_error& error) {
    std::set<std::string> tags, names;
    for (const auto& marker : network.markers)
      tags.insert(block.markers[marker.marker].family + ":" + block.markers[marker.marker].name());
    for (const auto& point : points.points) names.insert(point->id);
    throw std::runtime_error("the photographs cannot be brought to the survey: of the surveyed points with a tag, " +
                             std::string(error.what()) + ". Tags in the photographs: " + listed(tags) +
                             ". Surveyed points: " + listed(names) +
                             ". A plate table (plates.csv) says which belong together where the names do not");
  }
}

/// A survey with east and north exchanged is the mirror image of the site: no motion brings photographs to it, and what
/// tries to does not converge.
void require_survey_is_no_mirror_image(const SurveyFrame& frame, const std::vector<SurveyedTag>& surveyed) {
  std::vector<Eigen::Vector3d> found, given;
  for (size_t k = 0; k < surveyed.size(); ++k)
    if (std::isfinite(frame.distance[k]) && !surveyed[k].check)
      found.push_back(frame.found[k]), given.push_back(surveyed[k].position);
  block::require_same_hand(found, given);
}

/// After the tags without a row and without a size are gone.
void require_views(const PlatesT& given, const BlockInput& input) {
  if (!input.block.views.empty()) return;
  std::set<std::string> seen, rows;
  for (const Marker& marker : input.block.markers) seen.insert(marker.family + ":" + marker.name());
  for (const auto& plate : given.plates) rows.insert(plate->tag_family + ":" + std::to_string(plate->tag_id));
  throw std::runtime_error("no tag of the plate table is in the photographs: it has " + listed(rows) + ", they show " +
                           listed(seen) +
                           ". Family and number have to be the same; which plate table belongs to these photographs?");
}

std::string metres(double value) {
  return value < 0.1 ? fmt::format("{:.2f} mm", 1e3 * value) : fmt::format("{:.3f} m", value);
}

/// Another unit shows here, before it is a block that does not converge or a site a thousand times too large.
void require_unit(const SurveyFrame& frame, double known_size, Context& context) {
  constexpr double largest = 3, smallest = 0.003;  // [m] edges of tags that somebody prints
  constexpr double tolerance = 1.25;
  const double scale = frame.motion.scale, by_survey = (known_size > 0 ? known_size : unknown_size) * scale;
  const auto near = [&](double unit) { return std::abs(std::log(scale / unit)) < std::log(1.1); };
  const std::string unit = near(1000) || near(0.001) ? "one of them is in millimetres where metres are said, or the "
                                                       "other way round"
                           : near(0.3048) || near(1 / 0.3048) ? "one of them is in feet"
                                                              : "one of them is wrong";
  if (known_size > 0 && std::abs(std::log(scale)) > std::log(tolerance))
    throw std::runtime_error("by the distances between the surveyed points the edge of a tag measures " +
                             metres(by_survey) + ", by tag_size or the plate table " + metres(known_size) + ": " +
                             unit);
  constexpr double print = 0.02;  // no printer is off by more that was looked at
  if (known_size > 0 && std::abs(std::log(scale)) > print)
    context.warn(fmt::format(
        "by the distances between the surveyed points the edge of a tag measures {}, by tag_size or the plate table "
        "{}, {:.1f} % off: the survey counts. Is the size the edge of the black square as it was printed, and are the "
        "points the centres of these tags?",
        metres(by_survey), metres(known_size), 100 * std::abs(scale - 1)));
  if (known_size > 0) return;
  if (by_survey > largest || by_survey < smallest)
    throw std::runtime_error("by the distances between the surveyed points the edge of a tag measures " +
                             metres(by_survey) +
                             ", which no tag has: are the coordinates in metres, and are the "
                             "points those of these tags? tag_size, in metres, says it if they are");
  context.info("by the survey the edge of a tag measures " + metres(by_survey));
}

/// Points that are not where the photographs have their tags. Those in the place of another end the run: no adjustment
/// finds its way from there.
void tell_misplaced(const SurveyFrame& frame, const std::vector<SurveyedTag>& surveyed, Context& context) {
  std::vector<Eigen::Vector3d> expected;
  for (const auto& tag : surveyed) expected.push_back(tag.position);
  std::string exchanged;
  for (const ExchangedPlace& pair : exchanged_places(frame.found, expected)) {
    if (frame.agrees[pair.thing] || (pair.mutual && frame.agrees[pair.place])) continue;
    // A place that has its own tag nearer is not the other's: a single point is wrong by less than plates hang apart.
    if (frame.distance[pair.place] < (frame.found[pair.thing] - expected[pair.place]).norm()) continue;
    const std::string apart = metres((expected[pair.thing] - expected[pair.place]).norm()),
                      &thing = surveyed[pair.thing].name, &place = surveyed[pair.place].name;
    exchanged +=
        (exchanged.empty() ? "" : "; ") +
        (pair.mutual ? "points " + thing + " and " + place + " are exchanged: the photographs show the tag of each " +
                           apart + " away, where the survey has the other"
                     : "the photographs show the tag of point " + thing + " where the survey has " + place + ", " +
                           apart + " away");
  }
  if (!exchanged.empty())
    throw std::runtime_error(exchanged + ". Correct the plate table (which tag is which point) or the survey's names");
  for (size_t k = 0; k < surveyed.size(); ++k)
    if (std::isfinite(frame.distance[k]) && !frame.agrees[k] && !surveyed[k].check)
      context.warn("point " + surveyed[k].name + " lies " + metres(frame.distance[k]) +
                   " from where the photographs and the other surveyed points have its tag: is it another tag's?");
}

/// What EXIF, or nothing at all, says of an interior orientation: parts of the principal distance and of the width.
Eigen::MatrixXd weak_prior(const BrownCamera& camera, double of_distance, double of_width, double distortion) {
  Eigen::VectorXd sigma(9);
  const double f = of_distance * camera.fx, c = of_width * camera.width;
  sigma << f, f, c, c, distortion, 2 * distortion, 4 * distortion, 0.03 * distortion, 0.03 * distortion;
  if (camera.lens == LensModel::fisheye) sigma.tail<2>() << 4 * distortion, 0;  // k4
  return sigma.cwiseAbs2().asDiagonal();
}

/// With priors so weak that the same observations do not count twice: once here, once in the adjustment that follows.
CameraT start_of(const MarkerCamera& given, const AdjustedMarkerCamera& adjusted) {
  CameraT camera = camera_artifact(given, adjusted);
  set_interior(adjusted.camera, weak_prior(adjusted.camera, 0.1, 0.02, 0.3), camera);
  return camera;
}

/// How many of a camera's photographs are oriented, by index of the camera.
std::vector<int> oriented_images(const MarkerBlock& block, const MarkerResult& network) {
  std::vector<int> count(block.cameras.size());
  for (const auto& image : network.images)
    if (image.oriented) ++count[block.images[image.image].camera];
  return count;
}

/// The cameras of oriented photographs: as calibrated, or as a self-calibration is to start.
std::vector<CameraT> used_cameras(const MarkerBlock& block, const MarkerResult& network,
                                  const std::vector<CameraT>& known) {
  const std::vector<int> images = oriented_images(block, network);
  std::vector<CameraT> used;
  for (size_t c = 0; c < block.cameras.size(); ++c) {
    if (images[c] == 0) continue;
    used.push_back(known.empty() ? start_of(block.cameras[c], network.cameras[c]) : known[c]);
    if (used.back().width == 0)  // OpenCV's files do not say it
      used.back().width = block.cameras[c].camera.width, used.back().height = block.cameras[c].camera.height;
  }
  return used;
}

void tell_cameras(const std::vector<CameraT>& used, const MarkerBlock& block, const MarkerResult& network,
                  Context& context) {
  const std::vector<int> images = oriented_images(block, network);
  std::string text;
  for (size_t c = 0; c < block.cameras.size(); ++c)
    if (images[c] > 0)
      text += (text.empty() ? "" : ", ") + block.cameras[c].id + " (" + std::to_string(images[c]) +
              (images[c] == 1 ? " photograph)" : " photographs)");
  context.info(std::to_string(used.size()) + " cameras, each with an interior orientation of its own: " + text);
}

}  // namespace

void AdjustMarkerStart::run(Context& context) {
  std::vector<ImageT> photographs;
  for (size_t i = 0; i < images.size(); ++i) photographs.push_back(images.unpack(i));
  const TagObservationsT seen = observations.unpack();
  const PointsT surveyed_points = points.unpack();
  std::vector<CameraT> known;
  for (size_t i = 0; i < calibration.size(); ++i) known.push_back(calibration.unpack(i));
  BlockInput input = block_of(photographs, seen, known, {*tag_size > 0 ? *tag_size : unknown_size, *cameras});
  for (const auto& image : input.left_out) context.warn("left out: " + image.path + ": " + image.reason);
  if (input.block.views.empty())
    throw std::runtime_error("no photograph shows a usable tag" +
                             (input.left_out.empty()
                                  ? std::string()
                                  : ": " + input.left_out.front().path + ": " + input.left_out.front().reason) +
                             ". Check the family of the tags");
  const PlatesT given = plates.unpack();
  PlatesT table = plates_of(given, input.block, surveyed_points, *tag_size);
  require_sizes(given, table, input);
  for (const auto& text : input.warnings) context.warn(text);
  require_views(given, input);
  const std::vector<SurveyedTag> surveyed = surveyed_tags(table, surveyed_points, input.block);
  if (known.empty())
    for (MarkerCamera& one : input.block.cameras)  // few photographs do not calibrate
      if (one.camera.fx > 0) one.covariance = weak_prior(one.camera, 0.05, 0.01, 0.1), one.any_lens = true;
  const MarkerResult network = adjust_lens_and_block(input.block, {});
  for (const auto& text : network.left_out) context.warn("left out: " + text);
  for (const auto& text : network.warnings) context.warn(text);
  const SurveyFrame frame = frame_of(network, surveyed, input.block, surveyed_points);
  require_survey_is_no_mirror_image(frame, surveyed);
  double known_size = 0;  // of any: all tags have one, or none
  for (const auto& plate : table.plates)
    if (plate->tag_size > 0) known_size = plate->tag_size;
  require_unit(frame, known_size, context);
  tell_misplaced(frame, surveyed, context);

  std::map<std::pair<std::string, int>, const AdjustedMarker*> adjusted;
  for (const auto& marker : network.markers) {
    const Marker& m = input.block.markers[marker.marker];
    adjusted[{m.family, m.id}] = &marker;
  }
  for (auto& plate : table.plates) {
    const auto marker = adjusted.find({plate->tag_family, plate->tag_id});
    if (!(plate->tag_size > 0)) plate->tag_size = unknown_size * frame.motion.scale;
    if (marker != adjusted.end())
      plate->nominal_rotation = (frame.motion.rotation * marker->second->world_from_tag.rotation).normalized();
  }
  PosesT approximate = poses_of(input.block, network);
  std::set<std::string> oriented;
  for (auto& pose : approximate.poses) {
    pose->cam_from_world = in_survey_frame(frame, pose->cam_from_world);
    pose->covariance.clear();
    oriented.insert(pose->path);
  }
  const std::vector<CameraT> used = used_cameras(input.block, network, known);
  if (used.size() > 1) tell_cameras(used, input.block, network, context);
  std::map<std::string, std::string> camera_of_image;
  for (const MarkerImage& image : input.block.images)
    camera_of_image[image.path] = input.block.cameras[image.camera].id;
  for (const auto& image : seen.images) {
    if (!oriented.count(image->path)) continue;
    ImageTagsT tags(*image);
    tags.camera = camera_of_image.at(image->path);
    usable.commit(tags);
  }
  context.metric("images_oriented", static_cast<double>(oriented.size()), "1");
  placed.commit(table);
  poses.commit(approximate);
  camera.commit(joined_cameras(used));
}

}  // namespace plumbline::markers
