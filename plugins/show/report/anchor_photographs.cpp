#include "show/report/anchor_photographs.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "artifacts/camera_artifact.hpp"
#include "building/judgement/worst_first.hpp"
#include "photo/images/grey_rows.hpp"
#include "photo/images/jpeg_writer.hpp"

namespace plumbline::report {
namespace {

/// A page with more parts of 4 to 10 kB opens slowly; the rest is told.
constexpr std::size_t kMostAnchors = 400;
/// The worst are shown in two photographs.
constexpr std::size_t kShownTwice = 30;
/// Edge of a part on the page at most [px]; larger ones are averaged down.
constexpr int kLargestPart = 240;
constexpr int kQuality = 70;
/// A part shows so many times the marker, and at least so many pixels of the photograph.
constexpr double kAround = 2.5;
constexpr double kSmallestPart = 120;

struct View {
  const ImageTagsT* image;
  const TagT* tag;
  double size;  ///< shortest edge of the marker [px]: large and looked at from the front
};

double shortest_edge(const TagT& tag) {
  double shortest = 1e300;
  for (std::size_t k = 0; k < 4; ++k) shortest = std::min(shortest, (tag.corners[(k + 1) % 4] - tag.corners[k]).norm());
  return shortest;
}

/// Views of each anchor, the best first; of equal ones the first by name.
std::map<std::string, std::vector<View>> views_of(const PhotographSources& sources) {
  std::map<std::pair<std::string, int>, std::string> anchors;
  for (const auto& plate : sources.plates.plates) anchors[{plate->tag_family, plate->tag_id}] = plate->anchor;
  std::map<std::string, std::vector<View>> views;
  for (const ImageTagsT& image : sources.tags)
    for (const auto& tag : image.tags)
      if (const auto anchor = anchors.find({tag->family, tag->id}); anchor != anchors.end() && tag->corners.size() == 4)
        views[anchor->second].push_back({&image, tag.get(), shortest_edge(*tag)});
  for (auto& [anchor, all] : views)
    std::stable_sort(all.begin(), all.end(), [](const View& a, const View& b) {
      return a.size != b.size ? a.size > b.size : a.image->path < b.image->path;
    });
  return views;
}

class Projection {
 public:
  explicit Projection(const PhotographSources& sources) {
    if (!sources.poses || !sources.camera) return;
    for (const CameraT& camera : cameras_of(*sources.camera)) cameras_.emplace(camera.id, complete_camera_of(camera));
    for (const auto& pose : sources.poses->poses) poses_[pose->path] = pose.get();
  }

  std::optional<Eigen::Vector2d> operator()(const ImageTagsT& image, const Eigen::Vector3d& point) const {
    const auto pose = poses_.find(image.path);
    auto camera = cameras_.find(image.camera);
    if (camera == cameras_.end() && cameras_.size() == 1) camera = cameras_.begin();
    if (pose == poses_.end() || camera == cameras_.end() || !point.allFinite()) return std::nullopt;
    const Eigen::Vector3d seen = pose->second->cam_from_world * point;
    if (!(seen.z() > 0)) return std::nullopt;
    const auto pixel = project(camera->second.at(seen.z()), seen);
    if (!pixel) return std::nullopt;
    return *pixel + principal_point_of(camera->second, *pose->second);
  }

 private:
  std::map<std::string, CompleteCamera> cameras_;
  std::map<std::string, const PoseT*> poses_;
};

/// Every block of factor × factor pixels as their mean.
GreyImage averaged(const GreyImage& image, int factor) {
  if (factor <= 1) return image;
  GreyImage small{image.width / factor, image.height / factor, {}};
  for (int y = 0; y < small.height; ++y)
    for (int x = 0; x < small.width; ++x) {
      int sum = 0;
      for (int dy = 0; dy < factor; ++dy)
        for (int dx = 0; dx < factor; ++dx) sum += image.pixels[(y * factor + dy) * image.width + x * factor + dx];
      small.pixels.push_back(static_cast<std::uint8_t>(sum / (factor * factor)));
    }
  return small;
}

/// One that is to be shown, and what of the photograph.
struct Wanted {
  std::size_t place;  ///< in the order of the page
  View view;
  const AnchorDeviationT* anchor;
};

/// Cuts the part out of the photograph; nothing where the marker lies outside of it.
std::optional<AnchorPhotograph> cut(const GreyImage& photograph, const Wanted& wanted, const Projection& project) {
  const TagT& tag = *wanted.view.tag;
  AnchorPhotograph part;
  part.anchor = wanted.anchor->id, part.verdict = wanted.anchor->verdict;
  part.photograph = wanted.view.image->path, part.tag = tag.family + " " + std::to_string(tag.id);
  part.design = project(*wanted.view.image, wanted.anchor->design);
  part.as_built = project(*wanted.view.image, wanted.anchor->as_built);
  Eigen::Vector2d low = Eigen::Vector2d::Constant(1e300), high = -low;
  const auto include = [&](const Eigen::Vector2d& at) { low = low.cwiseMin(at), high = high.cwiseMax(at); };
  for (const Eigen::Vector2d& corner : tag.corners) include(corner);
  const double marker = (high - low).maxCoeff();
  // A design position far away would make the marker a speck: then only the marker is shown.
  for (const auto* place : {&part.design, &part.as_built})
    if (*place && (**place - 0.5 * (low + high)).norm() < 4 * marker) include(**place);
  const double side = std::max({kAround * marker, 1.3 * (high - low).maxCoeff(), kSmallestPart});
  const Eigen::Vector2d corner = 0.5 * (low + high) - Eigen::Vector2d::Constant(0.5 * side);
  const int left = std::max(0, static_cast<int>(std::floor(corner.x()))),
            top = std::max(0, static_cast<int>(std::floor(corner.y())));
  const int right = std::min(photograph.width, static_cast<int>(std::ceil(corner.x() + side))),
            bottom = std::min(photograph.height, static_cast<int>(std::ceil(corner.y() + side)));
  if (right <= left || bottom <= top) return std::nullopt;
  const int factor = (std::max(right - left, bottom - top) + kLargestPart - 1) / kLargestPart;
  const GreyImage small = averaged(part_of(photograph, left, top, right - left, bottom - top), factor);
  if (small.pixels.empty()) return std::nullopt;
  part.width = small.width * factor, part.height = small.height * factor;
  part.jpeg = grey_jpeg(small, kQuality);
  // The first pixel's centre is (0, 0), its corner half a pixel before.
  const Eigen::Vector2d origin(left - 0.5, top - 0.5);
  for (const Eigen::Vector2d& at : tag.corners) part.outline.push_back(at - origin);
  for (auto* place : {&part.design, &part.as_built})
    if (*place) **place -= origin;
  return part;
}

}  // namespace

AnchorPhotographs photographs_of(const DeviationT& deviation, const PhotographSources& sources) {
  AnchorPhotographs result;
  const auto views = views_of(sources);
  const Projection project(sources);
  std::map<std::string, std::vector<Wanted>> by_photograph;
  std::size_t anchors = 0, place = 0;
  for (const AnchorDeviationT* anchor : judgement::worst_first(deviation)) {
    if (anchor->verdict != ToleranceVerdict::fail && anchor->verdict != ToleranceVerdict::undecided) continue;
    const auto seen = views.find(anchor->id);
    std::size_t shown = 0;
    for (const View& view : seen == views.end() ? std::vector<View>() : seen->second) {
      if (!sources.files.contains(view.image->path)) continue;
      if (anchors >= kMostAnchors || shown == (anchors < kShownTwice ? 2u : 1u)) break;
      by_photograph[view.image->path].push_back({place++, view, anchor}), ++shown;
    }
    if (anchors >= kMostAnchors)
      ++result.left_out;
    else if (shown == 0)
      result.not_shown.push_back(anchor->id);
    else
      ++anchors;
  }
  std::map<std::size_t, AnchorPhotograph> parts;  // by place
  const auto not_cut = [&](const Wanted& one, const std::string& reason) {
    result.not_cut.try_emplace(one.anchor->id, one.view.image->path + reason);
  };
  for (const auto& [path, wanted] : by_photograph) try {
      const GreyImage photograph = read_grey_image(sources.files.at(path));
      for (const Wanted& one : wanted)
        if (auto part = cut(photograph, one, project))
          parts.emplace(one.place, std::move(*part));
        else
          not_cut(one, fmt::format(" has {} × {} pixels, and its marker was detected outside of them", photograph.width,
                                   photograph.height));
    } catch (const ImageFileError& error) {
      result.not_read[path] = error.what();
      for (const Wanted& one : wanted) not_cut(one, " cannot be read");
    }
  for (auto& [at, part] : parts) {
    result.not_cut.erase(part.anchor);  // another photograph shows it
    result.parts.push_back(std::move(part));
  }
  return result;
}

}  // namespace plumbline::report
