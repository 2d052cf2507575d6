#include "markers/marker_words.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <map>
#include <set>
#include <stdexcept>
#include <tuple>

#include "geometry/median.hpp"
#include "markers/marker_model.hpp"

namespace plumbline::markers {
namespace {

std::string number(double value, int decimals) {
  char text[64];
  std::snprintf(text, sizeof text, "%.*f", decimals, value);
  return text;
}

/// Where the photographs have each tag: by the adjustment, or if it was left out as a blunder, by the poses that the
/// other tags give.
std::map<int, std::vector<Eigen::Vector3d>> places_of(const MarkerBlock& block, const MarkerResult& result) {
  std::map<int, std::vector<Eigen::Vector3d>> places;
  for (const int v : result.rejected) {
    const MarkerView& view = block.views[static_cast<size_t>(v)];
    const AdjustedMarkerImage& image = result.images[static_cast<size_t>(view.image)];
    if (!image.oriented) continue;
    const BrownCamera& camera =
        result.cameras[static_cast<size_t>(block.images[static_cast<size_t>(view.image)].camera)].camera;
    for (const FittedPose& pose : poses_of_view(block, view, camera)) {
      places[view.marker].push_back((image.cam_from_world.inverse() * pose.cam_from_figure).translation);
      break;
    }
  }
  for (const auto& marker : result.markers)
    if (!places.count(marker.marker)) places[marker.marker].push_back(marker.world_from_tag.translation);
  return places;
}

/// Coordinate by coordinate.
Eigen::Vector3d median_of(const std::vector<Eigen::Vector3d>& places) {
  Eigen::Vector3d result;
  for (Eigen::Index k = 0; k < 3; ++k) {
    std::vector<double> values;
    for (const auto& p : places) values.push_back(p(k));
    result(k) = median(values);
  }
  return result;
}

}  // namespace

std::map<int, TagOffLayout> tags_off_layout(const MarkerBlock& block, const MarkerOptions& options,
                                            const MarkerResult& result) {
  std::map<int, TagOffLayout> off;
  for (const auto& [m, places] : places_of(block, result)) {
    const Marker& marker = block.markers[static_cast<size_t>(m)];
    if (!marker.world_from_tag) continue;
    const Eigen::Vector3d place = median_of(places);
    const double distance = (place - marker.world_from_tag->translation).norm();
    if (distance > std::max(5 * options.layout_position_sigma, 0.5 * marker.size)) off[m] = {place, distance};
  }
  return off;
}

void warn_about_layout(const MarkerBlock& block, const MarkerOptions& options, const std::set<int>& left_out,
                       MarkerResult& result) {
  const std::map<int, TagOffLayout> off = tags_off_layout(block, options, result);
  std::map<int, int> at;  // the tag that the layout has there
  for (const auto& [m, tag] : off) {
    double nearest = 0.25 * tag.distance;  // a pose by one tag is good to a few per cent of the distance
    for (size_t other = 0; other < block.markers.size(); ++other) {
      const auto& layout = block.markers[other].world_from_tag;
      if (!layout || static_cast<int>(other) == m || (layout->translation - tag.place).norm() > nearest) continue;
      nearest = (layout->translation - tag.place).norm(), at[m] = static_cast<int>(other);
    }
  }
  for (const auto& [m, tag] : off) {
    const std::string name = block.markers[static_cast<size_t>(m)].name();
    const auto there = at.find(m);
    const std::string other = there == at.end() ? "" : block.markers[static_cast<size_t>(there->second)].name();
    const std::string effect = left_out.count(m) ? ". Its place in the layout takes no part" : "";
    if (there != at.end() && at.count(there->second) && at[there->second] == m) {
      if (m < there->second)
        result.warnings.push_back("tags " + name + " and " + other +
                                  " are exchanged: the photographs show each where the layout has the other, " +
                                  number(tag.distance, 2) + " m away. Correct the layout");
      continue;
    }
    result.warnings.push_back("tag " + name + " is " + number(tag.distance, 2) + " m from its place in the layout" +
                              (other.empty() ? "" : ", where the layout has tag " + other) +
                              ": it was moved, or the layout is wrong" + effect);
  }
}

void warn_about_variance(MarkerResult& result) {
  constexpr double limit = 4;  // twice the stated standard deviation
  for (const auto& group : result.groups) {
    const bool corners = group.name.rfind("corners", 0) == 0;
    if (!corners || !(group.redundancy > 10) || !(group.factor > limit)) continue;
    result.warnings.push_back(group.name + ": " + number(std::sqrt(group.factor), 1) +
                              " times as uncertain as the detector states (variance factor " + number(group.factor, 1) +
                              "): motion, sharpening, or a lens or tags that are no plane squares. All standard "
                              "deviations are scaled by it");
  }
}

void explain_images(const MarkerBlock& block, MarkerResult& result) {
  std::vector<int> views(block.images.size(), 0), rejected(block.images.size(), 0);
  for (const auto& view : block.views) ++views[static_cast<size_t>(view.image)];
  for (const int v : result.rejected) ++rejected[static_cast<size_t>(block.views[static_cast<size_t>(v)].image)];
  const bool layout = has_layout(block);
  for (auto& image : result.images) {
    const size_t i = static_cast<size_t>(image.image);
    if (image.oriented) continue;
    if (rejected[i] == views[i] && rejected[i] > 0)
      image.reason = "its " + std::to_string(rejected[i]) + (rejected[i] == 1 ? " tag disagrees" : " tags disagree") +
                     " with the other photographs";
    else
      image.reason = layout ? "none of its tags is in the layout or seen with one that is"
                            : "it shares no tag with the photographs of the largest group that hang together";
    result.left_out.push_back(block.images[i].path + ": " + image.reason);
  }
  std::vector<bool> placed(block.markers.size(), false);
  for (const auto& marker : result.markers) placed[static_cast<size_t>(marker.marker)] = true;
  std::string names;
  int missing = 0;
  for (size_t m = 0; m < placed.size(); ++m) {
    const bool seen = std::any_of(block.views.begin(), block.views.end(),
                                  [&](const MarkerView& v) { return v.marker == static_cast<int>(m); });
    if (placed[m] || !seen) continue;
    if (++missing <= 12) names += (names.empty() ? "" : ", ") + block.markers[m].name();
  }
  if (missing)
    result.left_out.push_back((missing == 1 ? "tag " : "tags ") + names + (missing > 12 ? ", ..." : "") +
                              ": could not be placed from the photographs that show " + (missing == 1 ? "it" : "them"));
}

void explain_single_tags(const MarkerBlock& block, MarkerResult& result) {
  for (const auto& seen : result.views) {
    const MarkerView& view = block.views[static_cast<size_t>(seen.view)];
    AdjustedMarkerImage& image = result.images[static_cast<size_t>(view.image)];
    if (image.tags != 1) continue;
    const BrownCamera& camera =
        result.cameras[static_cast<size_t>(block.images[static_cast<size_t>(view.image)].camera)].camera;
    const auto poses = poses_of_view(block, view, camera);
    if (poses.size() < 2) continue;
    const auto marker = std::find_if(result.markers.begin(), result.markers.end(),
                                     [&](const auto& m) { return m.marker == view.marker; });
    const auto centre_of = [&](const FittedPose& pose) -> Eigen::Vector3d {
      return (pose.cam_from_figure * marker->world_from_tag.inverse()).inverse().translation;
    };
    const Eigen::Vector3d first = centre_of(poses[0]), second = centre_of(poses[1]);
    const bool took_first = (first - image.centre).norm() <= (second - image.centre).norm();
    image.other_centre = took_first ? second : first;
    image.ambiguity = poses[took_first ? 1 : 0].rms / std::max(1e-12, poses[took_first ? 0 : 1].rms);
  }
}

void warn_about_weak(const MarkerBlock& block, MarkerResult& result) {
  constexpr double weak_part = 0.05;  // of the distance to the nearest tag
  for (auto& image : result.images) {
    if (!image.oriented) continue;
    const double sigma = std::sqrt(image.covariance.topLeftCorner<3, 3>().trace());
    double nearest = std::numeric_limits<double>::infinity();
    for (const auto& seen : result.views) {
      const MarkerView& view = block.views[static_cast<size_t>(seen.view)];
      for (const auto& m : result.markers)
        if (view.image == image.image && m.marker == view.marker)
          nearest = std::min(nearest, (m.world_from_tag.translation - image.centre).norm());
    }
    std::vector<std::string> why;
    if (image.other_centre && image.ambiguity < 2 && (*image.other_centre - image.centre).norm() > 3 * sigma)
      why.push_back("one tag, and a second pose fits nearly as well (residuals " + number(image.ambiguity, 2) +
                    " times as large) with the camera " + number((*image.other_centre - image.centre).norm(), 2) +
                    " m away");
    if (sigma > weak_part * nearest)
      why.push_back("its centre is uncertain by " + number(sigma, 3) + " m (1 sigma) at " + number(nearest, 2) +
                    " m from the nearest tag in it: " + std::to_string(image.tags) +
                    (image.tags == 1 ? " tag" : " tags"));
    for (const auto& text : why) image.reason += (image.reason.empty() ? "weak: " : "; ") + text;
  }
  for (size_t c = 0; c < result.cameras.size(); ++c) {
    const AdjustedMarkerCamera& camera = result.cameras[c];
    const double inset_limit = 3 * 0.3;
    if (camera.inset_sigma > 0 && std::abs(camera.inset) > inset_limit)
      result.warnings.push_back(
          "the tags' edges are drawn " + number(camera.inset, 2) +
          " px inwards, far beyond what a detector does: the photographs are blurred or sharpened "
          "strongly, or the printed size is not that of the black square");
    const double sigma_f = camera.covariance.size() ? std::sqrt(camera.covariance(0, 0)) : 0;
    if (sigma_f > 0.02 * camera.camera.fx)
      result.warnings.push_back("the principal distance of camera " + block.cameras[c].id + " is uncertain by " +
                                number(100 * sigma_f / camera.camera.fx, 1) +
                                " %: photograph the tags from several directions, tilted, and some with the camera "
                                "turned by 90 degrees");
  }
  for (const auto& marker : result.markers) {
    const Marker& m = block.markers[static_cast<size_t>(marker.marker)];
    if (marker.images == 1)
      result.warnings.push_back("tag " + m.name() + " is seen in one photograph only: nothing checks it");
  }
}

}  // namespace plumbline::markers
