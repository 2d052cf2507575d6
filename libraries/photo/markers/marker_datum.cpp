#include "photo/markers/marker_datum.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <stdexcept>
#include <tuple>

#include "base/text/text.hpp"
#include "base/text/words.hpp"
#include "geometry/median.hpp"

namespace plumbline::markers {

void scale_by_distance(const MarkerBlock& block, const MarkerDistance& distance, MarkerResult& result) {
  const auto find = [&](int marker) {
    for (size_t j = 0; j < result.markers.size(); ++j)
      if (result.markers[j].marker == marker) return j;
    throw std::runtime_error("tag " + block.markers[marker].name() +
                             " of the given distance could not be placed; measure between two tags that several "
                             "photographs show");
  };
  const size_t a = find(distance.from), b = find(distance.to);
  const Eigen::Index n = static_cast<Eigen::Index>(result.markers.size());
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  for (const auto& m : result.markers) middle += m.world_from_tag.translation / static_cast<double>(n);
  Eigen::VectorXd x(3 * n), slope = Eigen::VectorXd::Zero(3 * n);
  for (Eigen::Index j = 0; j < n; ++j) x.segment<3>(3 * j) = result.markers[j].world_from_tag.translation - middle;
  const Eigen::Vector3d between =
      result.markers[b].world_from_tag.translation - result.markers[a].world_from_tag.translation;
  const double length = between.norm(), factor = distance.length / length;
  slope.segment<3>(3 * static_cast<Eigen::Index>(b)) = between / length;
  slope.segment<3>(3 * static_cast<Eigen::Index>(a)) = -between / length;
  // x' = x L/d(x): the part of dx along the scale goes, the length's own uncertainty comes.
  const Eigen::MatrixXd project = Eigen::MatrixXd::Identity(3 * n, 3 * n) - x * slope.transpose() / length;
  result.centre_covariance = factor * factor * (project * result.centre_covariance * project.transpose()) +
                             std::pow(factor * distance.sigma / distance.length, 2) * x * x.transpose();
  for (size_t j = 0; j < result.markers.size(); ++j) {
    AdjustedMarker& marker = result.markers[j];
    const auto scaled = [&](const Eigen::Vector3d& p) -> Eigen::Vector3d { return middle + factor * (p - middle); };
    marker.world_from_tag.translation = scaled(marker.world_from_tag.translation);
    for (auto& corner : marker.corners) corner = scaled(corner);
    marker.scale *= factor;
    const Eigen::Index at = 3 * static_cast<Eigen::Index>(j);
    marker.centre_covariance = result.centre_covariance.block<3, 3>(at, at);
  }
  for (auto& image : result.images) {
    image.centre = middle + factor * (image.centre - middle);
    image.cam_from_world.translation = -(image.cam_from_world.rotation * image.centre);
    image.covariance.topRows<3>() *= factor, image.covariance.leftCols<3>() *= factor;
    image.geometry_sigma *= factor;
  }
}

void to_first_tag(const MarkerBlock& block, bool in_one_line, MarkerResult& result) {
  const auto first = std::min_element(result.markers.begin(), result.markers.end(), [&](const auto& a, const auto& b) {
    const Marker &ma = block.markers[a.marker], &mb = block.markers[b.marker];
    return std::tie(ma.family, ma.id) < std::tie(mb.family, mb.id);
  });
  const RigidTransform frame_from_world = first->world_from_tag.inverse();
  const Eigen::Matrix3d r = frame_from_world.rotation.toRotationMatrix();
  for (auto& marker : result.markers) {
    marker.world_from_tag = frame_from_world * marker.world_from_tag;
    for (auto& corner : marker.corners) corner = frame_from_world * corner;
    marker.centre_covariance = r * marker.centre_covariance * r.transpose();
    marker.rotation_covariance = r * marker.rotation_covariance * r.transpose();
  }
  for (Eigen::Index i = 0; i < result.centre_covariance.rows(); i += 3)
    for (Eigen::Index j = 0; j < result.centre_covariance.cols(); j += 3)
      result.centre_covariance.block<3, 3>(i, j) = r * result.centre_covariance.block<3, 3>(i, j) * r.transpose();
  for (auto& image : result.images) {
    if (!image.oriented) continue;
    image.cam_from_world = image.cam_from_world * frame_from_world.inverse();
    image.centre = frame_from_world * image.centre;
    image.covariance.topRows<3>() = r * image.covariance.topRows<3>();
    image.covariance.leftCols<3>() = image.covariance.leftCols<3>() * r.transpose();
  }
  result.datum = "free network: inner constraints over the centres" + std::string(in_one_line ? " and rotations" : "") +
                 " of all tags, shown in the frame of tag " + block.markers[first->marker].name() +
                 " (x right, y up, z out of it)";
}

/// What gives the lengths, and how well. The print of the tags errs alike for all of them: ink spreads, printers scale,
/// and the inset of the detector is hardly to be told from either, so that a network which fits to a hundredth of a
/// pixel can be too large by a per cent.
namespace {

/// Median side of a tag in the photographs of each camera [px]; 0: none of its views took part.
std::vector<double> sides_in_pixels(const MarkerBlock& block, const MarkerResult& result) {
  std::vector<std::vector<double>> of_camera(block.cameras.size());
  for (const auto& seen : result.views) {
    const MarkerView& view = block.views[seen.view];
    of_camera[block.images[view.image].camera].push_back(
        0.5 * ((view.corners[0] - view.corners[1]).norm() + (view.corners[1] - view.corners[2]).norm()));
  }
  std::vector<double> sides;
  for (auto& all : of_camera) sides.push_back(all.empty() ? 0 : upper_median(std::move(all)));
  return sides;
}

/// Of small tags the inset of the edges is a good part of the side, and lengths hang on the one value that is estimated
/// for all photographs of a camera.
void warn_about_inset(const std::vector<double>& sides, MarkerResult& result) {
  constexpr double much = 0.04;  // of the side
  for (size_t c = 0; c < result.cameras.size(); ++c) {
    const double inset = result.cameras[c].inset;
    if (sides[c] == 0 || !(2 * std::abs(inset) > much * sides[c])) continue;
    result.warnings.push_back(
        "the edges of the tags are " + text::format_fixed(inset, 2) + " px inside of where they are printed, " +
        text::format_fixed(200 * inset / sides[c], 0) + " % of the " + text::format_fixed(sides[c], 0) +
        " px of a side: this is allowed for, but all lengths hang on it and may be wrong by a part "
        "of that. Give distance=A,B,metres, or photograph the tags larger");
  }
}

/// Relative standard deviation of lengths by what the inset is not the same for all tags of a camera in: bloom, halos
/// and JPEG draw large and oblique tags in otherwise than small ones, and the estimate of one value takes part of that
/// for scale. How much is not derived but taken from the ten cameras of test_photograph_blocks.cpp, whose lengths are
/// known (docs/photographs.md has each): with half of what the detector states of the inset the mean of (error /
/// stated)² is 0.5, of which bloom alone makes 0.3. A third would make it 1 and leave bloom, which white walls in
/// sunlight have, at 2.5 standard deviations. Where a detector states nothing, of `unstated` [px].
double scale_sigma_of_insets(const MarkerBlock& block, const std::vector<double>& sides, double unstated) {
  constexpr double uneven = 0.5;
  double squares = 0, images = 0;
  for (const MarkerImage& image : block.images) {
    const double side = sides[image.camera];
    const double sigma = image.inset_sigma > 0 ? image.inset_sigma : unstated;
    if (side > 0) squares += std::pow(2 * uneven * sigma / side, 2), images += 1;
  }
  return images > 0 ? std::sqrt(squares / images) : 0;
}

/// Tags whose size stands apart from that of all others: prints of two scales, or two sizes under one tag_size.
struct SizeGroups {
  double gap = 0;  ///< relative; 0: there is one group
  std::vector<std::string> apart;
  bool smaller = false;  ///< those that stand apart
};

SizeGroups size_groups(const MarkerBlock& block, const MarkerOptions& options, const MarkerResult& result) {
  constexpr double beyond_chance = 5, apart = 2;
  std::vector<const AdjustedMarker*> by_size;
  for (const auto& marker : result.markers) by_size.push_back(&marker);
  std::sort(by_size.begin(), by_size.end(), [](const auto* a, const auto* b) { return a->scale < b->scale; });
  SizeGroups groups;
  if (by_size.size() < 4) return groups;
  size_t cut = 1;
  for (size_t k = 2; k < by_size.size(); ++k)
    if (by_size[k]->scale - by_size[k - 1]->scale > by_size[cut]->scale - by_size[cut - 1]->scale) cut = k;
  const AdjustedMarker &low = *by_size[cut - 1], &high = *by_size[cut];
  const double gap = high.scale - low.scale;
  const double within = std::max(low.scale - by_size.front()->scale, by_size.back()->scale - high.scale);
  if (!(gap > beyond_chance * std::hypot(options.size_sigma, low.scale_sigma, high.scale_sigma))) return groups;
  if (!(gap > apart * within)) return groups;
  const auto mean = [&](size_t from, size_t to) {
    double sum = 0;
    for (size_t k = from; k < to; ++k) sum += by_size[k]->scale;
    return sum / static_cast<double>(to - from);
  };
  groups.gap = mean(cut, by_size.size()) / mean(0, cut) - 1;
  groups.smaller = 2 * cut <= by_size.size();
  std::vector<int> apart_ones;  // in the order of the block
  for (size_t k = groups.smaller ? 0 : cut; k < (groups.smaller ? cut : by_size.size()); ++k)
    apart_ones.push_back(by_size[k]->marker);
  std::sort(apart_ones.begin(), apart_ones.end());
  for (const int marker : apart_ones) groups.apart.push_back(block.markers[marker].name());
  return groups;
}

void warn_about_sizes(const SizeGroups& groups, bool by_distance, MarkerResult& result) {
  result.warnings.push_back(
      (groups.apart.size() == 1 ? "tag " + groups.apart.front() + " is "
                                : "tags " + text::join(groups.apart, 8) + " are ") +
      text::format_fixed(100 * groups.gap, 1) + " % " + (groups.smaller ? "smaller" : "larger") + " than the other " +
      std::to_string(result.markers.size() - groups.apart.size()) +
      " beside the size that is given: printed at another scale, or of another size" +
      (by_distance ? ""
                   : ". Which of them are as tag_size says is not known, and all lengths may be wrong by that: give "
                     "each tag its own size, or distance=A,B,metres"));
}

double mean_size(const MarkerBlock& block, const MarkerResult& result) {
  double size = 0;
  for (const auto& marker : result.markers)
    size += block.markers[marker.marker].size / static_cast<double>(result.markers.size());
  return size;
}

}  // namespace

double scale_sigma_by_size(const MarkerBlock& block, const MarkerOptions& options, const MarkerResult& result) {
  const double by_insets =
      options.inset_sigma > 0 ? scale_sigma_of_insets(block, sides_in_pixels(block, result), options.inset_sigma) : 0;
  return std::hypot(options.print_sigma / mean_size(block, result), options.size_sigma, by_insets);
}

void state_scale(const MarkerBlock& block, const MarkerOptions& options, MarkerResult& result) {
  const SizeGroups groups = size_groups(block, options, result);
  if (groups.gap > 0) warn_about_sizes(groups, options.distance.has_value(), result);
  if (options.distance) {
    result.scale_sigma = options.distance->sigma / options.distance->length;
    result.datum += "; lengths by the distance of tags " + block.markers[options.distance->from].name() + " and " +
                    block.markers[options.distance->to].name() + ", good to " +
                    text::format_fixed(100 * result.scale_sigma, 2) + " %";
    return;
  }
  const std::vector<double> sides = sides_in_pixels(block, result);
  warn_about_inset(sides, result);
  const double by_insets = options.inset_sigma > 0 ? scale_sigma_of_insets(block, sides, options.inset_sigma) : 0;
  const double size = mean_size(block, result);
  result.scale_sigma = std::hypot(scale_sigma_by_size(block, options, result), 0.5 * groups.gap);
  result.datum +=
      "; lengths by the printed size of the tags, good to " + text::format_fixed(100 * result.scale_sigma, 2) + " % (" +
      text::format_fixed(1e3 * options.print_sigma, 2) + " mm of " + text::format_fixed(1e3 * size, 1) + " mm" +
      (by_insets > 0
           ? ", and " + text::format_fixed(100 * by_insets, 2) + " % for how evenly the photographs draw edges"
           : "") +
      (groups.gap > 0 ? ", and sizes of two groups" : "") +
      "), which the standard deviations do not hold: distance=A,B,metres gives them better";
}

}  // namespace plumbline::markers
