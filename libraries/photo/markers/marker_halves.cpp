#include "photo/markers/marker_halves.hpp"

#include <fmt/core.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <stdexcept>

#include "base/text/name_order.hpp"
#include "geometry/linear_algebra/decompositions.hpp"
#include "geometry/median.hpp"
#include "geometry/similarity.hpp"
#include "geometry/statistics.hpp"

namespace plumbline::markers {
namespace {

constexpr int kFewestPhotographs = 8;  // of a camera
constexpr std::size_t kFewestTags = 4;
constexpr double kFreeMotion = 1e6;  // variance of a motion between the halves, over the largest of a coordinate

/// Whether each photograph is of the second half; empty if a camera has too few. By name within each camera.
std::map<int, bool> second_half(const MarkerBlock& block, const MarkerResult& result, HalvesBy by) {
  std::map<int, std::vector<const AdjustedMarkerImage*>> of_camera;
  for (const AdjustedMarkerImage& image : result.images)
    if (image.oriented) of_camera[block.images[image.image].camera].push_back(&image);
  std::map<int, bool> second;
  for (auto& [camera, images] : of_camera) {
    if (static_cast<int>(images.size()) < kFewestPhotographs) return {};
    std::stable_sort(images.begin(), images.end(), [&](const auto* a, const auto* b) {
      return text::before_by_name(block.images[a->image].path, block.images[b->image].path);
    });
    std::vector<double> along;
    if (by == HalvesBy::place) {
      Eigen::Vector3d mean = Eigen::Vector3d::Zero();
      Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
      for (const auto* image : images) mean += image->centre / static_cast<double>(images.size());
      for (const auto* image : images) spread += (image->centre - mean) * (image->centre - mean).transpose();
      const Eigen::Vector3d axis = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(spread).eigenvectors().col(2);
      for (const auto* image : images) along.push_back(axis.dot(image->centre - mean));
    }
    const double middle = along.empty() ? 0 : upper_median(along);
    for (std::size_t k = 0; k < images.size(); ++k)
      second[images[k]->image] = by == HalvesBy::turns  ? k % 2 == 1
                                 : by == HalvesBy::time ? k >= images.size() / 2
                                                        : along[k] >= middle;
  }
  return second;
}

/// The views of these photographs that took part, from the calibration that all found.
MarkerBlock part_of(const MarkerBlock& block, const MarkerResult& result, const std::set<int>& photographs) {
  MarkerBlock part;
  part.cameras = block.cameras, part.markers = block.markers;
  for (std::size_t c = 0; c < part.cameras.size(); ++c)
    if (!part.cameras[c].held) part.cameras[c].camera = result.cameras[c].camera;
  std::map<int, int> index;
  for (const int i : photographs) {
    index[i] = static_cast<int>(part.images.size());
    part.images.push_back(block.images[i]);
  }
  for (const AdjustedMarkerView& view : result.views) {
    MarkerView copy = block.views[view.view];
    const auto found = index.find(copy.image);
    if (found == index.end()) continue;
    copy.image = found->second;
    part.views.push_back(copy);
  }
  return part;
}

/// Centres of tags with the covariance of all.
struct Centres {
  Centres(const MarkerResult& result, const std::vector<int>& markers) {
    const auto n = static_cast<Eigen::Index>(markers.size());
    covariance.resize(3 * n, 3 * n);
    std::vector<Eigen::Index> rows;
    for (const int wanted : markers) {
      const auto found = std::find_if(result.markers.begin(), result.markers.end(),
                                      [wanted](const AdjustedMarker& m) { return m.marker == wanted; });
      rows.push_back(found - result.markers.begin());
      places.push_back(found->world_from_tag.translation);
    }
    for (Eigen::Index i = 0; i < n; ++i)
      for (Eigen::Index j = 0; j < n; ++j)
        covariance.block<3, 3>(3 * i, 3 * j) = result.centre_covariance.block<3, 3>(3 * rows[i], 3 * rows[j]);
  }
  std::vector<Eigen::Vector3d> places;
  Eigen::MatrixXd covariance;
};

std::vector<int> common_markers(const MarkerResult& one, const MarkerResult& two) {
  std::set<int> first;
  for (const AdjustedMarker& m : one.markers) first.insert(m.marker);
  std::vector<int> both;
  for (const AdjustedMarker& m : two.markers)
    if (first.count(m.marker)) both.push_back(m.marker);
  std::sort(both.begin(), both.end());
  return both;
}

MarkerHalves compare(const Centres& one, const Centres& two) {
  const SimilarityMotion motion = fit_similarity(two.places, one.places, true);
  const Eigen::Matrix3d turn = motion.scale * motion.rotation.toRotationMatrix();
  const auto n = static_cast<Eigen::Index>(one.places.size());
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& p : one.places) centre += p / static_cast<double>(n);
  Eigen::VectorXd difference(3 * n);
  Eigen::MatrixXd sum = one.covariance, motions(3 * n, 7);
  for (Eigen::Index i = 0; i < n; ++i) {
    const Eigen::Vector3d& place = one.places[i];
    const Eigen::Vector3d arm = place - centre;
    difference.segment<3>(3 * i) = motion * two.places[i] - place;
    motions.middleRows<3>(3 * i) << Eigen::Matrix3d::Identity(), skew(arm), arm;
    for (Eigen::Index j = 0; j < n; ++j)
      sum.block<3, 3>(3 * i, 3 * j) += turn * two.covariance.block<3, 3>(3 * i, 3 * j) * turn.transpose();
  }
  MarkerHalves halves;
  halves.tags = static_cast<int>(n);
  halves.rms = std::sqrt(difference.squaredNorm() / static_cast<double>(3 * n));
  halves.freedom = static_cast<int>(3 * n - 7);
  // Neither knows where the other's frame lies: a motion between them costs nothing.
  motions.colwise().normalize();
  sum += kFreeMotion * sum.diagonal().maxCoeff() * motions * motions.transpose();
  const double square = difference.dot(linear_algebra::solve_symmetric(sum, difference));
  halves.variance = square / halves.freedom;
  halves.tags_contradict = square > chi_squared_quantile(0.999, halves.freedom) && std::sqrt(halves.variance) > 1.5;
  return halves;
}

/// Adds what the halves' cameras differ by, in their covariances.
void compare_cameras(const MarkerBlock& block, const MarkerResult& one, const MarkerResult& two, MarkerHalves& halves) {
  double square = 0;
  for (std::size_t c = 0; c < block.cameras.size(); ++c) {
    const Eigen::MatrixXd &a = one.cameras[c].covariance, &b = two.cameras[c].covariance;
    std::vector<Eigen::Index> both;
    for (Eigen::Index k = 0; k < a.rows(); ++k)
      if (block.cameras[c].covariance.size() == 0 && a(k, k) > 0 && b(k, k) > 0) both.push_back(k);
    if (both.empty()) continue;
    const auto first = one.cameras[c].camera.parameters(), second = two.cameras[c].camera.parameters();
    Eigen::VectorXd d(static_cast<Eigen::Index>(both.size()));
    for (std::size_t i = 0; i < both.size(); ++i) d(static_cast<Eigen::Index>(i)) = second[both[i]] - first[both[i]];
    const Eigen::MatrixXd sum = a(both, both) + b(both, both);
    square += d.dot(linear_algebra::solve_symmetric(sum, d)), halves.camera_freedom += static_cast<int>(both.size());
  }
  if (halves.camera_freedom == 0) return;
  halves.camera_variance = square / halves.camera_freedom;
  halves.cameras_contradict =
      square > chi_squared_quantile(0.999, halves.camera_freedom) && std::sqrt(halves.camera_variance) > 2;
}

}  // namespace

std::optional<MarkerHalves> compare_halves(const MarkerBlock& block, const MarkerOptions& options,
                                           const MarkerResult& result, HalvesBy by) {
  const std::map<int, bool> second = second_half(block, result, by);
  if (second.empty()) return std::nullopt;
  std::vector<MarkerResult> found;
  for (const bool half : {false, true}) {
    std::set<int> photographs;
    for (const auto& [image, in_second] : second)
      if (in_second == half) photographs.insert(image);
    try {
      found.push_back(adjust_marker_block(part_of(block, result, photographs), options));
    } catch (const std::runtime_error&) {
      return std::nullopt;  // too few for a block of their own
    }
  }
  const std::vector<int> both = common_markers(found[0], found[1]);
  if (both.size() < kFewestTags) return std::nullopt;
  MarkerHalves halves = compare(Centres(found[0], both), Centres(found[1], both));
  halves.by = by;
  compare_cameras(block, found[0], found[1], halves);
  return halves;
}

std::string in_words(const MarkerHalves& halves, bool only_by_place) {
  const std::string which = halves.by == HalvesBy::turns  ? "two halves of the photographs (every second one)"
                            : halves.by == HalvesBy::time ? "the first and the second half of the photographs"
                                                          : "the photographs from either side";
  std::string words = which;
  if (halves.tags_contradict) {
    words += fmt::format(" place the tags {:.3f} mm rms apart, {:.1f} times what their covariances allow",
                         1e3 * halves.rms, std::sqrt(halves.variance));
  }
  if (halves.cameras_contradict) {
    words += fmt::format("{} give cameras that differ by {:.1f} times what their covariances allow",
                         halves.tags_contradict ? ", and" : "", std::sqrt(halves.camera_variance));
  }
  words += ": the stated standard deviations are too small by about that. ";
  if (only_by_place)
    return words +
           "Other halves agree, so it is not the cameras: the tags or their paper are not as the model has them";
  return words + "The cameras, the lens or the tags are not as the model has them";
}

}  // namespace plumbline::markers
