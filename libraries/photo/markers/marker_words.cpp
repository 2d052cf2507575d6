#include "photo/markers/marker_words.hpp"

#include <fmt/core.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <stdexcept>
#include <tuple>

#include "base/text/text.hpp"
#include "base/text/words.hpp"
#include "geometry/linear_algebra/decompositions.hpp"
#include "geometry/median.hpp"
#include "geometry/statistics.hpp"
#include "photo/markers/marker_model.hpp"

namespace plumbline::markers {
namespace {

/// A tag as the photographs have it.
struct Sighting {
  std::vector<Eigen::Vector3d> places;
  std::vector<Eigen::Quaterniond> turns;  ///< from the layout's frame of the tag to that of the photographs
  double angle_sigma = 0;                 ///< of `turns` [rad]
};

Eigen::Quaterniond turn_of(const Marker& marker, const Eigen::Quaterniond& world_from_tag) {
  if (!marker.world_from_tag) return Eigen::Quaterniond::Identity();
  return (marker.world_from_tag->rotation.conjugate() * world_from_tag).normalized();
}

double angle_of(const Eigen::Quaterniond& turn) { return 2 * std::atan2(turn.vec().norm(), std::abs(turn.w())); }

/// Where the photographs have each tag: by the adjustment, or if it was left out as a blunder, by the poses that the
/// other tags give. Of the two poses of a square the rotation is the one nearer to the layout's.
std::map<int, Sighting> sightings_of(const MarkerBlock& block, const MarkerResult& result) {
  constexpr double of_one_square = 0.07;  // [rad], a pose from four corners is tilted by some degrees
  std::map<int, Sighting> sightings;
  for (const int v : result.rejected) {
    const MarkerView& view = block.views[v];
    const AdjustedMarkerImage& image = result.images[view.image];
    if (!image.oriented) continue;
    const BrownCamera& camera = result.cameras[block.images[view.image].camera].camera;
    std::vector<Eigen::Quaterniond> turns;
    for (const FittedPose& pose : poses_of_view(block, view, camera)) {
      const RigidTransform world_from_tag = image.cam_from_world.inverse() * pose.cam_from_figure;
      if (turns.empty()) sightings[view.marker].places.push_back(world_from_tag.translation);
      turns.push_back(turn_of(block.markers[view.marker], world_from_tag.rotation));
    }
    if (turns.empty()) continue;
    sightings[view.marker].turns.push_back(*std::min_element(
        turns.begin(), turns.end(), [](const auto& a, const auto& b) { return angle_of(a) < angle_of(b); }));
    sightings[view.marker].angle_sigma = of_one_square;
  }
  for (const auto& marker : result.markers) {
    Sighting& seen = sightings[marker.marker];
    if (seen.places.empty()) seen.places.push_back(marker.world_from_tag.translation);
    if (static_cast<int>(seen.turns.size()) > marker.images) continue;
    seen.turns = {turn_of(block.markers[marker.marker], marker.world_from_tag.rotation)};
    seen.angle_sigma = std::sqrt(marker.rotation_covariance.diagonal().maxCoeff());
  }
  return sightings;
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

/// Normalised residual of the layout's rotation of a tag: what the adjustment turns it by, over the standard deviation
/// that this has if the layout is right. Where a neighbour alone speaks against a tag both are turned by a part of what
/// one of them is off, so the angle itself says little. 0 where the rotation took no part.
double contradiction(const Marker& marker, const MarkerOptions& options, const MarkerResult& result, int m) {
  for (const auto& adjusted : result.markers) {
    if (adjusted.marker != m) continue;
    const Eigen::AngleAxisd turn(adjusted.world_from_tag.rotation * marker.world_from_tag->rotation.conjugate());
    const double variance = options.layout_rotation_sigma * options.layout_rotation_sigma;
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> cofactor(variance * Eigen::Matrix3d::Identity() -
                                                                  adjusted.rotation_covariance);
    const Eigen::Vector3d along = cofactor.eigenvectors().transpose() * (turn.angle() * turn.axis());
    const Eigen::Vector3d of = cofactor.eigenvalues().cwiseMax(0.01 * variance);
    return std::sqrt(along.cwiseAbs2().cwiseQuotient(of).sum());
  }
  return 0;
}

}  // namespace

std::map<int, TagOffLayout> tags_off_layout(const MarkerBlock& block, const MarkerOptions& options,
                                            const MarkerResult& result) {
  constexpr double limit = 5;  // standard deviations
  std::map<int, TagOffLayout> off;
  for (auto& [m, seen] : sightings_of(block, result)) {
    const Marker& marker = block.markers[m];
    if (!marker.world_from_tag || seen.turns.empty()) continue;
    TagOffLayout tag;
    tag.place = median_of(seen.places);
    tag.distance = (tag.place - marker.world_from_tag->translation).norm();
    const auto middle = seen.turns.begin() + static_cast<std::ptrdiff_t>(seen.turns.size() / 2);
    std::nth_element(seen.turns.begin(), middle, seen.turns.end(),
                     [](const auto& a, const auto& b) { return angle_of(a) < angle_of(b); });
    tag.angle = angle_of(*middle);
    tag.about_normal = std::abs(middle->z()) > 0.95 * middle->vec().norm();
    const double by_distance = tag.distance / std::max(limit * options.layout_position_sigma, 0.5 * marker.size),
                 by_angle = tag.angle / (limit * std::max(options.layout_rotation_sigma, seen.angle_sigma));
    tag.excess = std::max(by_distance, by_angle);
    tag.moved = by_distance > 1, tag.turned = by_angle > 1;
    tag.contradiction = contradiction(marker, options, result, m) / limit;
    if (std::max(tag.excess, tag.contradiction) > 1) off[m] = tag;
  }
  return off;
}

namespace {

/// "tag 4 is turned by 180 degrees about its normal, against the layout".
std::string words_of_turn(const TagOffLayout& tag) {
  return (tag.about_normal ? "turned by " : "tilted by ") + text::format_fixed(tag.angle * 180 / M_PI, 0) +
         (tag.about_normal ? " degrees about its normal" : " degrees");
}

/// A few wrong rotations are named one by one. Where most are wrong, so are the places of the photographs.
void require_common_convention(const MarkerBlock& block, const std::map<int, TagOffLayout>& off) {
  std::set<int> seen;
  for (const MarkerView& view : block.views)
    if (block.markers[view.marker].world_from_tag) seen.insert(view.marker);
  size_t turned = 0;
  for (const auto& [m, tag] : off) turned += tag.turned;
  if (turned < 3 || 2 * turned <= seen.size()) return;
  throw std::runtime_error("the layout turns " + std::to_string(turned) + " of " + std::to_string(seen.size()) +
                           " tags otherwise than the photographs show them: expected are rotations world from tag, "
                           "with x to the right, y up and z out of "
                           "the tag as one looks at it. Correct the layout's rotations");
}

}  // namespace

void warn_about_layout(const MarkerBlock& block, const MarkerOptions& options, const std::set<int>& left_out,
                       MarkerResult& result) {
  const std::map<int, TagOffLayout> off = tags_off_layout(block, options, result);
  std::map<int, int> at;  // the tag that the layout has there
  require_common_convention(block, off);
  for (const auto& [m, tag] : off) {
    if (!tag.moved) continue;
    double nearest = 0.25 * tag.distance;  // a pose by one tag is good to a few per cent of the distance
    for (size_t other = 0; other < block.markers.size(); ++other) {
      const auto& layout = block.markers[other].world_from_tag;
      if (!layout || static_cast<int>(other) == m || (layout->translation - tag.place).norm() > nearest) continue;
      nearest = (layout->translation - tag.place).norm(), at[m] = static_cast<int>(other);
    }
  }
  for (const auto& [m, tag] : off) {
    const std::string name = block.markers[m].name();
    const auto there = at.find(m);
    const std::string other = there == at.end() ? "" : block.markers[there->second].name();
    const std::string effect = left_out.count(m) ? ". Its place in the layout takes no part" : "";
    if (there != at.end() && at.count(there->second) && at[there->second] == m) {
      if (m < there->second)
        result.warnings.push_back("tags " + name + " and " + other +
                                  " are exchanged: the photographs show each where the layout has the other, " +
                                  text::format_fixed(tag.distance, 2) + " m away. Correct the layout");
      continue;
    }
    if (!tag.moved) {
      result.warnings.push_back("tag " + name + " is " + words_of_turn(tag) + " against the layout" +
                                ": it was hung otherwise, or its rotation in the layout is wrong" + effect);
      continue;
    }
    result.warnings.push_back(
        "tag " + name + " is " + text::format_fixed(tag.distance, 2) + " m from its place in the layout" +
        (other.empty() ? "" : ", where the layout has tag " + other) +
        (tag.turned ? ", and " + words_of_turn(tag) : "") + ": it was moved, or the layout is wrong" + effect);
  }
}

void warn_about_variance(MarkerResult& result) {
  constexpr double limit = 4;  // twice the stated standard deviation
  for (const auto& group : result.groups) {
    const bool corners = group.name.rfind("corners", 0) == 0;
    if (!corners || !(group.redundancy > 10) || !(group.factor > limit)) continue;
    result.warnings.push_back(group.name + ": " + text::format_fixed(std::sqrt(group.factor), 1) +
                              " times as uncertain as the detector states (variance factor " +
                              text::format_fixed(group.factor, 1) +
                              "): motion, sharpening, or a lens or tags that are no plane squares. All standard "
                              "deviations are scaled by it");
  }
}

void explain_images(const MarkerBlock& block, MarkerResult& result) {
  std::vector<int> views(block.images.size(), 0), rejected(block.images.size(), 0);
  for (const auto& view : block.views) ++views[view.image];
  for (const int v : result.rejected) ++rejected[block.views[v].image];
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
  for (const auto& marker : result.markers) placed[marker.marker] = true;
  std::vector<std::string> missing;
  for (size_t m = 0; m < placed.size(); ++m) {
    const bool seen = std::any_of(block.views.begin(), block.views.end(),
                                  [&](const MarkerView& v) { return v.marker == static_cast<int>(m); });
    if (placed[m] || !seen) continue;
    missing.push_back(block.markers[m].name());
  }
  if (!missing.empty())
    result.left_out.push_back((missing.size() == 1 ? "tag " : "tags ") + text::join(missing, 12) +
                              ": could not be placed from the photographs that show " +
                              (missing.size() == 1 ? "it" : "them"));
}

void explain_single_tags(const MarkerBlock& block, MarkerResult& result) {
  for (const auto& seen : result.views) {
    const MarkerView& view = block.views[seen.view];
    AdjustedMarkerImage& image = result.images[view.image];
    if (image.tags != 1) continue;
    const BrownCamera& camera = result.cameras[block.images[view.image].camera].camera;
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

namespace {

/// Five digits: coefficients of distortion are small, principal distances are not.
std::string digits(double value) { return fmt::format("{:.5g}", value); }

}  // namespace

namespace {

/// "fx is 1130 ± 2, given were 1124 ± 1 (w = 4.2)", of the parameter whose own normalised residual is largest.
std::string furthest_parameter(const BrownCamera& given, const BrownCamera& found, const Eigen::MatrixXd& prior,
                               const Eigen::MatrixXd& adjusted) {
  constexpr double controlled = 0.05;  // redundancy number from which a normalised residual means something
  const auto before = given.parameters(), after = found.parameters();
  double largest = 0;
  std::string worst;
  for (Eigen::Index k = 0; k < BrownCamera::parameter_count; ++k) {
    const auto i = static_cast<std::size_t>(k);
    if (!(prior(k, k) - adjusted(k, k) > controlled * prior(k, k))) continue;
    const double w = std::abs(after[i] - before[i]) / std::sqrt(prior(k, k) - adjusted(k, k));
    if (!(w > largest)) continue;
    largest = w;
    worst = std::string(given.names()[i]) + " is " + digits(after[i]) + " \u00b1 " + digits(std::sqrt(adjusted(k, k))) +
            ", given were " + digits(before[i]) + " \u00b1 " + digits(std::sqrt(prior(k, k))) +
            " (w = " + text::format_fixed(w, 1) + ")";
  }
  return worst;
}

}  // namespace

CalibrationTest test_calibration(const Eigen::VectorXd& change, const Eigen::MatrixXd& prior,
                                 const Eigen::MatrixXd& adjusted) {
  constexpr double controlled = 0.2;  // redundancy number from which the photographs can contradict
  std::vector<Eigen::Index> free;
  for (Eigen::Index k = 0; k < prior.rows(); ++k)
    if (prior(k, k) > 0) free.push_back(k);
  CalibrationTest test;
  if (free.empty()) return test;
  const Eigen::MatrixXd before = prior(free, free), shown = before - adjusted(free, free);
  const linear_algebra::GeneralizedSymmetricEigen directions(shown, before);
  const Eigen::VectorXd along = directions.eigenvectors().transpose() * change(free);
  for (Eigen::Index k = 0; k < along.size(); ++k) {
    const double redundancy = directions.eigenvalues()(k);
    if (!(redundancy > controlled)) continue;
    test.statistic += along(k) * along(k) / redundancy;
    ++test.freedom;
  }
  return test;
}

void warn_about_calibrations(const MarkerBlock& block, MarkerResult& result) {
  constexpr double level = 0.9995;
  for (std::size_t c = 0; c < block.cameras.size(); ++c) {
    const MarkerCamera& given = block.cameras[c];
    const Eigen::MatrixXd& adjusted = result.cameras[c].formal_covariance;
    // What EXIF says is no calibration to contradict.
    if (given.held || given.any_lens || given.covariance.size() == 0 || adjusted.size() == 0) continue;
    const auto before = given.camera.parameters(), after = result.cameras[c].camera.parameters();
    Eigen::VectorXd change(BrownCamera::parameter_count);
    for (Eigen::Index k = 0; k < change.size(); ++k) change(k) = after[k] - before[k];
    const CalibrationTest test = test_calibration(change, given.covariance, adjusted);
    if (test.freedom == 0) continue;
    const double limit = chi_squared_quantile(level, test.freedom);
    if (!(test.statistic > limit)) continue;
    result.warnings.push_back(
        "the photographs contradict the calibration of camera " + given.id + ": all parameters together are off by " +
        text::format_fixed(std::sqrt(test.statistic), 1) + " standard deviations (" + std::to_string(test.freedom) +
        " degrees of freedom, at most " + text::format_fixed(std::sqrt(limit), 1) + "), furthest " +
        furthest_parameter(given.camera, result.cameras[c].camera, given.covariance, adjusted) +
        ". Check that it is of this camera, focus and size of photographs; without it the camera calibrates itself");
  }
}

void warn_about_weak(const MarkerBlock& block, MarkerResult& result) {
  constexpr double weak_part = 0.05;  // of the distance to the nearest tag
  for (auto& image : result.images) {
    if (!image.oriented) continue;
    // Of its own geometry: what all photographs scatter by makes none of them weaker than the others.
    const double sigma = image.geometry_sigma;
    double nearest = std::numeric_limits<double>::infinity();
    for (const auto& seen : result.views) {
      const MarkerView& view = block.views[seen.view];
      for (const auto& m : result.markers)
        if (view.image == image.image && m.marker == view.marker)
          nearest = std::min(nearest, (m.world_from_tag.translation - image.centre).norm());
    }
    std::vector<std::string> why;
    if (image.other_centre && image.ambiguity < 2 && (*image.other_centre - image.centre).norm() > 3 * sigma)
      why.push_back("one tag, and a second pose fits nearly as well (residuals " +
                    text::format_fixed(image.ambiguity, 2) + " times as large) with the camera " +
                    text::format_fixed((*image.other_centre - image.centre).norm(), 2) + " m away");
    if (sigma > weak_part * nearest)
      why.push_back("its corners leave its centre uncertain by " + text::format_fixed(sigma, 3) + " m (1 sigma) at " +
                    text::format_fixed(nearest, 2) + " m from the nearest tag in it: " + std::to_string(image.tags) +
                    (image.tags == 1 ? " tag" : " tags"));
    for (const auto& text : why) image.reason += (image.reason.empty() ? "weak: " : "; ") + text;
  }
  for (size_t c = 0; c < result.cameras.size(); ++c) {
    const AdjustedMarkerCamera& camera = result.cameras[c];
    const double inset_limit = 3 * 0.3;
    if (camera.inset_sigma > 0 && std::abs(camera.inset) > inset_limit)
      result.warnings.push_back(
          "the tags' edges are drawn " + text::format_fixed(camera.inset, 2) +
          " px inwards, far beyond what a detector does: the photographs are blurred or sharpened "
          "strongly, or the printed size is not that of the black square");
    const double sigma_f = camera.covariance.size() ? std::sqrt(camera.covariance(0, 0)) : 0;
    if (sigma_f > 0.02 * camera.camera.fx)
      result.warnings.push_back("the principal distance of camera " + block.cameras[c].id + " is uncertain by " +
                                text::format_fixed(100 * sigma_f / camera.camera.fx, 1) +
                                " %: photograph the tags from several directions, tilted, and some with the camera "
                                "turned by 90 degrees");
  }
  for (const auto& marker : result.markers) {
    const Marker& m = block.markers[marker.marker];
    if (marker.images != 1) continue;
    const auto seen = std::count_if(block.views.begin(), block.views.end(),
                                    [&](const MarkerView& view) { return view.marker == marker.marker; });
    result.warnings.push_back("tag " + m.name() +
                              (seen == 1 ? " is seen in one photograph only: nothing checks it"
                                         : " stands where one of its " + std::to_string(seen) +
                                               " photographs has it, the others contradict each other: do not use it"));
  }
}

}  // namespace plumbline::markers
