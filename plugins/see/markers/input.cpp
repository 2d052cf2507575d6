#include "input.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <sstream>
#include <stdexcept>

#include "base/text/text.hpp"
#include "photo/cameras/camera_groups.hpp"
#include "photograph_groups.hpp"

namespace plumbline::markers {
namespace {

MarkerCamera camera_from(const CameraT& known) {
  MarkerCamera camera;
  camera.id = known.id;
  camera.camera = camera_of(known);
  camera.source = known.source;
  camera.pixel_pitch = known.pixel_pitch;
  camera.covariance = interior_covariance_of(known);
  camera.held = camera.covariance.size() == 0 || camera.covariance.diagonal().maxCoeff() == 0;
  return camera;
}

std::set<std::string> folders_of(const std::string& name) {
  std::set<std::string> folders;
  std::istringstream parts(name);
  for (std::string part; std::getline(parts, part, '/');) folders.insert(part);
  return folders;
}

/// The one calibration that shares a folder's name with the photograph which no other calibration has: "cam0" for
/// "cam0/data", "left/board" for "left/wall"; −1 if there is none or several.
int calibration_by_folder(const std::string& name, const std::vector<CameraT>& known) {
  std::map<std::string, std::set<int>> having;
  for (size_t c = 0; c < known.size(); ++c)
    for (const auto& part : folders_of(known[c].id)) having[part].insert(static_cast<int>(c));
  std::set<int> found;
  for (const auto& part : folders_of(name))
    if (const auto of = having.find(part); of != having.end() && of->second.size() == 1)
      found.insert(*of->second.begin());
  return found.size() == 1 ? *found.begin() : -1;
}

/// Index of the calibration that holds for a photograph; −1: none does.
int calibration_of(const std::string& path, const std::vector<CameraT>& known, const std::string& by) {
  if (known.size() == 1) return 0;
  const std::string name = cameras::camera_name(path, by);
  for (size_t c = 0; c < known.size(); ++c)
    if (known[c].id == name) return static_cast<int>(c);
  for (size_t c = 0; c < known.size(); ++c)  // "left" calibrated in a folder of its own, "images/left" in the campaign
    if (name.ends_with("/" + known[c].id)) return static_cast<int>(c);
  return calibration_by_folder(name, known);
}

/// Why a photograph cannot be one of its calibrated camera; empty if it can.
std::string contradiction(const ImageTagsT& image, CameraT& camera) {
  if (camera.width == 0) camera.width = image.width, camera.height = image.height;  // OpenCV's files do not say it
  if (image.width == camera.width && image.height == camera.height) return "";
  const bool turned = image.width == camera.height && image.height == camera.width;
  return "has " + size_text(image.width, image.height) + " pixels, camera '" + camera.id + "' has " +
         size_text(camera.width, camera.height) +
         (turned ? ": a program turned its pixels; use the file as the camera wrote it"
                 : "; calibrate the camera at the size of these photographs");
}

/// Tags of a photograph by family and id, in their order; empty: one of them is there twice.
std::map<std::pair<std::string, int>, const TagT*> tags_by_name(const ImageTagsT& image) {
  std::map<std::pair<std::string, int>, const TagT*> tags;
  for (const auto& tag : image.tags)
    if (!tags.emplace(std::pair(tag->family, tag->id), tag.get()).second) return {};
  return tags;
}

/// Whether one is the other at another size: all corners where a reduction has them, which no second photograph does.
bool is_reduced(const ImageTagsT& small, const ImageTagsT& large) {
  constexpr double agrees = 0.5;  // [px] of the small one; of the sides of the image, rounding
  if (small.tags.empty() || small.tags.size() != large.tags.size() || !(small.width < large.width)) return false;
  const double by = static_cast<double>(small.width) / large.width;
  if (std::abs(by * large.height - small.height) > 1) return false;
  const auto tags = tags_by_name(small), others = tags_by_name(large);
  if (tags.empty() || tags.size() != others.size()) return false;
  for (auto a = tags.begin(), b = others.begin(); a != tags.end(); ++a, ++b) {
    const auto &mine = a->second->corners, &theirs = b->second->corners;
    if (a->first != b->first || mine.size() != theirs.size()) return false;
    const Eigen::Vector2d half(0.5, 0.5);
    for (size_t k = 0; k < mine.size(); ++k)
      if (!((by * (theirs[k] + half) - half - mine[k]).norm() < agrees)) return false;
  }
  return true;
}

/// The photograph that this one is a smaller copy of; null: it is none.
const ImageTagsT* original_of(const ImageTagsT& image, const TagObservationsT& observations) {
  for (const auto& other : observations.images)
    if (other->problem.empty() && is_reduced(image, *other)) return other.get();
  return nullptr;
}

/// Which photographs can take part at all. Calibrations without a size get that of their first photograph.
std::vector<bool> usable(const TagObservationsT& observations, std::vector<CameraT>& known, const std::string& by,
                         BlockInput& input) {
  std::vector<bool> use(observations.images.size(), false);
  std::map<std::string, std::string> by_content;
  for (size_t i = 0; i < observations.images.size(); ++i) {
    const ImageTagsT& image = *observations.images[i];
    const auto leave_out = [&](const std::string& why) { input.left_out.push_back({image.path, why}); };
    if (!image.problem.empty()) {
      leave_out(image.problem);
      continue;
    }
    if (!image.sha256.empty()) {
      const auto [at, is_new] = by_content.emplace(image.sha256, image.path);
      if (!is_new) {
        leave_out("is the same file as " + at->second + "; one of them is enough");
        continue;
      }
    }
    if (image.tags.empty()) {
      leave_out("no tag of the family was found in it");
      continue;
    }
    if (const ImageTagsT* original = original_of(image, observations)) {
      leave_out("is " + original->path + " at another size; one of them is enough");
      continue;
    }
    if (!known.empty()) {
      const int c = calibration_of(image.path, known, by);
      const std::string why = c < 0 ? "is of camera '" + cameras::camera_name(image.path, by) +
                                          "', which the file of calibrations has not (it has '" + known.front().id +
                                          "' and others); cameras=by_name or by_folder tells how they are called"
                                    : contradiction(image, known[c]);
      if (!why.empty()) {
        leave_out(why);
        continue;
      }
    }
    use[i] = true;
  }
  return use;
}

Eigen::Matrix2d covariance_of(const TagT& tag, size_t corner) {
  Eigen::Matrix2d c = 0.09 * Eigen::Matrix2d::Identity();
  if (tag.corner_covariances.size() != 12) return c;
  const double* v = &tag.corner_covariances[3 * corner];
  Eigen::Matrix2d given;
  given << v[0], v[1], v[1], v[2];
  if (given.allFinite() && given(0, 0) > 0 && given.determinant() > 0) c = given;
  return c;
}

void add_views(const ImageTagsT& seen, int image, std::map<std::pair<std::string, int>, int>& marker_of, double size,
               BlockInput& input) {
  std::map<std::pair<std::string, int>, int> times;
  for (const auto& tag : seen.tags) ++times[{tag->family, tag->id}];
  for (const auto& [name, count] : times)
    if (count > 1)
      input.warnings.push_back("tag " + std::to_string(name.second) + " is " + std::to_string(count) + " times in " +
                               seen.path + ": left out there, because only one can be it. Print every id once");
  for (const auto& tag : seen.tags) {
    if (times[{tag->family, tag->id}] > 1 || tag->corners.size() != 4) continue;
    MarkerView view;
    bool inside = true;
    for (size_t k = 0; k < 4; ++k) {
      view.corners[k] = tag->corners[k];
      inside = inside && view.corners[k].allFinite() && view.corners[k].minCoeff() >= 0 &&
               view.corners[k].x() <= seen.width - 1 && view.corners[k].y() <= seen.height - 1;
      view.covariances[k] = covariance_of(*tag, k);
    }
    if (!inside) {
      input.warnings.push_back("tag " + std::to_string(tag->id) + " is cut by the border of " + seen.path +
                               ": left out there");
      continue;
    }
    const auto [at, is_new] =
        marker_of.emplace(std::make_pair(tag->family, tag->id), static_cast<int>(input.block.markers.size()));
    if (is_new) input.block.markers.push_back({tag->family, tag->id, size, std::nullopt});
    view.image = image, view.marker = at->second, view.refined = tag->refined;
    input.block.views.push_back(view);
  }
}

/// Ids that are twice in a photograph, and those that are once, over all of them.
void refuse_side_by_side(const TagObservationsT& observations) {
  size_t once = 0, twice = 0;
  std::string first;
  for (const auto& image : observations.images) {
    std::map<std::pair<std::string, int>, int> times;
    for (const auto& tag : image->tags) ++times[{tag->family, tag->id}];
    for (const auto& [name, count] : times) {
      ++(count > 1 ? twice : once);
      if (count > 1 && first.empty()) first = image->path;
    }
  }
  if (twice < 6 || twice <= once) return;
  throw std::runtime_error(
      "most tags are twice in their photographs (" + std::to_string(twice) + " of " + std::to_string(once + twice) +
      ", the first in " + first +
      "): two pictures side by side, as stereo cameras write them, or every tag was printed twice. Cut such pictures "
      "into a file for each camera (0001/left.png, 0001/right.png); print every id once");
}

/// Where a few photographs of many show one tag each, that is a square of the scene which happens to read as one: the
/// family is another. Of cameras that are calibrated one tag can be all there is.
void refuse_chance_tags(const TagObservationsT& observations) {
  constexpr size_t as_many = 3;  // photographs without a tag for each with one
  size_t with = 0, without = 0;
  const ImageTagsT* empty = nullptr;
  std::string ids;
  for (const auto& image : observations.images) {
    if (image->tags.size() > 1) return;
    if (image->tags.empty()) {
      ++without;
      if (!empty || (empty->problem.empty() && !image->problem.empty())) empty = image.get();
      continue;
    }
    ++with;
    ids += (ids.empty() ? "" : ", ") + std::to_string(image->tags.front()->id) + " in " + image->path;
  }
  if (with == 0 || without < as_many * with) return;
  throw std::runtime_error(
      std::to_string(without) + " of " + std::to_string(with + without) +
      " photographs show no tag of the family and the others one each (" + ids +
      "), which may be squares of the scene that happen to read so" +
      (empty->problem.empty() ? std::string() : "; of " + empty->path + ": " + empty->problem) +
      ". Give the family of the tags (family=); where one tag is all there is, calibrate the camera first (camera=)");
}

}  // namespace

BlockInput block_of(const std::vector<ImageT>& images, const TagObservationsT& observations, std::vector<CameraT> known,
                    const InputOptions& options) {
  refuse_side_by_side(observations);
  if (known.empty()) refuse_chance_tags(observations);
  BlockInput input;
  std::vector<std::string> paths;
  for (const auto& image : observations.images) paths.push_back(image->path);
  const std::string by = cameras::cameras_told(paths, options.cameras);
  std::vector<bool> use = usable(observations, known, by, input);
  std::vector<int> camera_of_image(observations.images.size(), -1);
  if (!known.empty()) {
    if (known.size() == 1 && by != "one")
      drop_other_bodies(groups_of(images, observations, use, "one"), known.front(), observations, use, input);
    for (const CameraT& camera : known) input.block.cameras.push_back(camera_from(camera));
    for (size_t i = 0; i < use.size(); ++i)
      if (use[i]) camera_of_image[i] = calibration_of(observations.images[i]->path, known, by);
  } else {
    std::vector<CameraGroup> groups = groups_of(images, observations, use, by);
    const std::string suspects = by == "by_folder" ? cameras::suspected_cameras(paths) : "";
    if (!suspects.empty())
      input.warnings.push_back("the photographs are called " + suspects +
                               ", each with the same numbers, and count as one camera's: cameras=by_name calibrates "
                               "each by itself, cameras=one says that it is one");
    drop_odd_groups(groups, observations, input);
    for (std::string& words : words_of_sizes(groups)) input.warnings.push_back(std::move(words));
    input.block.cameras = cameras_of_groups(groups);
    for (size_t g = 0; g < groups.size(); ++g)
      for (const size_t i : groups[g].images) camera_of_image[i] = static_cast<int>(g);
  }
  std::map<std::pair<std::string, int>, int> marker_of;
  for (size_t i = 0; i < observations.images.size(); ++i) {
    if (camera_of_image[i] < 0) continue;
    const ImageTagsT& seen = *observations.images[i];
    const size_t before = input.block.views.size();
    add_views(seen, static_cast<int>(input.block.images.size()), marker_of, options.tag_size, input);
    if (input.block.views.size() == before) {
      input.left_out.push_back({seen.path, "none of its " + std::to_string(seen.tags.size()) + " tags can be used"});
      continue;
    }
    input.block.images.push_back(
        {seen.path, camera_of_image[i], std::isnan(seen.corner_inset_sigma) ? 0 : seen.corner_inset_sigma});
  }
  return input;
}

MarkerDistance parse_distance(const std::string& text, const MarkerBlock& block) {
  std::vector<std::string> parts;
  std::istringstream stream(text);
  for (std::string part; std::getline(stream, part, ',');) parts.push_back(part);
  const auto refuse = [&](const std::string& what) {
    throw std::runtime_error("distance is '" + text + "': " + what +
                             "; expected the ids of two tags and the metres between their centres, as 3,17,1.2345");
  };
  if (parts.size() < 3 || parts.size() > 4) refuse("it has " + std::to_string(parts.size()) + " parts");
  const auto find = [&](std::string name) {
    std::string family;
    if (const size_t colon = name.find(':'); colon != std::string::npos)
      family = name.substr(0, colon), name = name.substr(colon + 1);
    int id = -1;
    const auto number = text::parse_number(name, '.');
    if (!number || *number != std::floor(*number) || std::abs(*number) > 1e9) refuse("'" + name + "' is no tag's id");
    id = static_cast<int>(*number);
    for (size_t m = 0; m < block.markers.size(); ++m)
      if (block.markers[m].id == id && (family.empty() || block.markers[m].family == family))
        return static_cast<int>(m);
    refuse("tag '" + name + "' is in no photograph");
    return -1;
  };
  MarkerDistance distance;
  distance.from = find(parts[0]), distance.to = find(parts[1]);
  if (distance.from == distance.to) refuse("both tags are the same");
  const auto metres = [&](const std::string& part) {
    const auto value = text::parse_number(part, '.');
    if (!value || !std::isfinite(*value))
      refuse("'" + part + "' is no number of metres (without a unit, with a point)");
    return *value;
  };
  distance.length = metres(parts[2]);
  distance.sigma = parts.size() == 4 ? metres(parts[3]) : 0.0005;
  if (!(distance.length > 0)) refuse("'" + parts[2] + "' is no positive length");
  if (!(distance.sigma >= 0)) refuse("'" + parts[3] + "' is no standard deviation");
  if (parts.size() == 4 && distance.sigma > 0.1 * distance.length)
    refuse("the fourth number is the standard deviation of the distance, and " + parts[3] + " m of " + parts[2] +
           " m is no measurement; a decimal comma, perhaps");
  return distance;
}

}  // namespace plumbline::markers
