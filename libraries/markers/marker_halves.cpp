#include "markers/marker_halves.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <set>
#include <stdexcept>

#include "geometry/similarity.hpp"
#include "geometry/statistics.hpp"
#include "plumbline/stop.hpp"

namespace plumbline::markers {
namespace {

constexpr int kFewestPhotographs = 8;  // of a camera
constexpr std::size_t kFewestTags = 4;
constexpr double kFreeMotion = 1e6;  // variance of a motion between the halves, over the largest of a coordinate

/// Photographs of one half; empty if a camera has too few.
std::set<int> photographs_of_half(const MarkerBlock& block, const MarkerResult& result, int half) {
  std::map<int, int> taken;  // by camera
  std::set<int> chosen;
  for (const AdjustedMarkerImage& image : result.images)
    if (image.oriented && taken[block.images[static_cast<std::size_t>(image.image)].camera]++ % 2 == half)
      chosen.insert(image.image);
  for (const auto& [camera, count] : taken)
    if (count < kFewestPhotographs) return {};
  return chosen;
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
    part.images.push_back(block.images[static_cast<std::size_t>(i)]);
  }
  for (const AdjustedMarkerView& view : result.views) {
    MarkerView copy = block.views[static_cast<std::size_t>(view.view)];
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
        covariance.block<3, 3>(3 * i, 3 * j) = result.centre_covariance.block<3, 3>(
            3 * rows[static_cast<std::size_t>(i)], 3 * rows[static_cast<std::size_t>(j)]);
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
    const Eigen::Vector3d& place = one.places[static_cast<std::size_t>(i)];
    const Eigen::Vector3d arm = place - centre;
    difference.segment<3>(3 * i) = motion * two.places[static_cast<std::size_t>(i)] - place;
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
  const double square = difference.dot(sum.ldlt().solve(difference));
  halves.variance = square / halves.freedom;
  halves.contradict = square > chi_squared_quantile(0.999, halves.freedom) && std::sqrt(halves.variance) > 1.5;
  return halves;
}

}  // namespace

std::optional<MarkerHalves> compare_halves(const MarkerBlock& block, const MarkerOptions& options,
                                           const MarkerResult& result) {
  std::vector<MarkerResult> found;
  for (const int half : {0, 1}) {
    const std::set<int> photographs = photographs_of_half(block, result, half);
    if (photographs.empty()) return std::nullopt;
    try {
      found.push_back(adjust_marker_block(part_of(block, result, photographs), options));
    } catch (const Stopped&) {
      throw;
    } catch (const std::runtime_error&) {
      return std::nullopt;  // too few for a block of their own
    }
  }
  const std::vector<int> both = common_markers(found[0], found[1]);
  if (both.size() < kFewestTags) return std::nullopt;
  return compare(Centres(found[0], both), Centres(found[1], both));
}

std::string in_words(const MarkerHalves& halves) {
  char text[400];
  std::snprintf(
      text, sizeof text,
      "two halves of the photographs place the tags %.3f mm rms apart, %.1f times what their covariances allow: "
      "the stated standard deviations are too small by about that. The cameras are not what the model says: moved "
      "while "
      "their rows were read, focused or zoomed between photographs, or with a lens of another kind",
      1e3 * halves.rms, std::sqrt(halves.variance));
  return text;
}

}  // namespace plumbline::markers
