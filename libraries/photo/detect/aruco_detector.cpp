#include "photo/detect/aruco_detector.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/aruco.hpp>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <tuple>

#include "photo/detect/corner_refinement.hpp"
#include "photo/detect/edge_lines.hpp"
#include "photo/detect/one_thread.hpp"
#include "photo/detect/tag_family.hpp"
#include "photo/detect/tag_pyramid.hpp"
#include "photo/images/grey_image.hpp"
#include "plumbline/stop.hpp"

namespace plumbline::detect {
namespace {

using Corners = std::array<Eigen::Vector2d, 4>;

cv::Ptr<cv::aruco::Dictionary> opencv_dictionary(const TagDictionary& dictionary) {
  auto result = cv::makePtr<cv::aruco::Dictionary>();
  result->markerSize = dictionary.size;
  result->maxCorrectionBits = dictionary.correctable_bits;
  for (const auto& code : dictionary.codes) {
    const cv::Mat bits(dictionary.size, dictionary.size, CV_8UC1, const_cast<std::uint8_t*>(code.data()));
    result->bytesList.push_back(cv::aruco::Dictionary::getByteListFromBits(bits));
  }
  return result;
}

double shortest_side(const Corners& c) {
  double shortest = (c[0] - c[3]).norm();
  for (size_t i = 0; i < 3; ++i) shortest = std::min(shortest, (c[i + 1] - c[i]).norm());
  return shortest;
}

double largest_move(const Corners& a, const Corners& b) {
  double largest = 0;
  for (size_t i = 0; i < 4; ++i) largest = std::max(largest, (a[i] - b[i]).norm());
  return largest;
}

/// Whether two tags of one number are one: its contour is found by several thresholds.
bool same_place(const DetectedTag& a, const DetectedTag& b) {
  Eigen::Vector2d between = Eigen::Vector2d::Zero();
  for (size_t i = 0; i < 4; ++i) between += 0.25 * (a.corners[i] - b.corners[i]);
  return a.id == b.id && between.norm() < 0.5 * shortest_side(a.corners);
}

std::vector<const std::uint8_t*> row_starts(const GreyImage& image) {
  std::vector<const std::uint8_t*> rows;
  for (int y = 0; y < image.height; ++y) rows.push_back(&image.pixels[static_cast<size_t>(y) * image.width]);
  return rows;
}

/// The same tags printed white on black.
SquareFamily negative_of(SquareFamily family) {
  const size_t bits = family.cells.size();
  const std::uint64_t mask = bits < 64 ? (std::uint64_t{1} << bits) - 1 : ~std::uint64_t{0};
  for (std::uint64_t& code : family.codes) code ^= mask;
  family.bright_inside = !family.bright_inside;
  return family;
}

}  // namespace

struct ArucoDetector::Impl {
  TagDictionary dictionary;
  ArucoOptions options;
  cv::Ptr<cv::aruco::Dictionary> codes;
  double chance = 0;
  LikenessLimit limit;
  // Of dictionaries up to 8 x 8 cells; larger ones need no check.
  std::optional<SquareDecoder> plain, negative;

  cv::Ptr<cv::aruco::DetectorParameters> parameters(int longest_side) const {
    auto p = cv::aruco::DetectorParameters::create();
    p->cornerRefinementMethod = cv::aruco::CORNER_REFINE_NONE;
    p->errorCorrectionRate = options.correction_rate;
    p->detectInvertedMarker = options.white_on_black;
    // OpenCV counts the pixels of the contour: along a diagonal there are fewer by the root of 2.
    p->minMarkerPerimeterRate = 4 / std::numbers::sqrt2 * options.min_side / longest_side;
    p->adaptiveThreshWinSizeMin = 3;
    p->adaptiveThreshWinSizeMax = std::clamp(longest_side / 30, 23, 83);
    p->adaptiveThreshWinSizeStep = p->adaptiveThreshWinSizeMax <= 23 ? 10 : 20;
    return p;
  }

  /// OpenCV's own measurement, for tags whose edges cannot be fitted: within a third of a cell.
  Corners subpixel_corners(const cv::Mat& view, const Corners& initial, double cell) const {
    std::vector<cv::Point2f> points;
    for (const auto& c : initial) points.emplace_back(static_cast<float>(c.x()), static_cast<float>(c.y()));
    const int window = std::clamp(static_cast<int>(std::floor(0.4 * cell)), 1, 5);
    cv::cornerSubPix(view, points, {window, window}, {-1, -1},
                     cv::TermCriteria(cv::TermCriteria::EPS + cv::TermCriteria::COUNT, 30, 0.01));
    Corners result;
    for (size_t i = 0; i < 4; ++i) {
      result[i] = {static_cast<double>(points[i].x), static_cast<double>(points[i].y)};
      if ((result[i] - initial[i]).norm() > std::max(2.0, 0.5 * cell)) result[i] = initial[i];
    }
    return result;
  }

  /// Corners for tags whose edges cannot be fitted: those of straight lines along the steepest grey values, else
  /// OpenCV's. A blurred corner is rounded, and OpenCV's measurement of it is off by a good part of the blur.
  Corners unfitted_corners(const cv::Mat& view, const PixelRows& image, const Corners& initial, double cell) const {
    const std::array<Eigen::Vector2d, 4> clockwise = {initial[3], initial[2], initial[1], initial[0]};
    const double reach = std::clamp(0.4 * cell, 1.5, 4.0);
    for (const bool bright_inside : {false, true}) {
      auto lines = on_edges(image, clockwise, reach, bright_inside);
      if (lines) lines = on_edges(image, *lines, reach, bright_inside);  // OpenCV's contours are good to a pixel or two
      if (!lines) continue;
      const Corners corners = {(*lines)[3], (*lines)[2], (*lines)[1], (*lines)[0]};
      if (largest_move(corners, initial) <= std::max(2.0, 0.5 * cell)) return corners;
    }
    return subpixel_corners(view, initial, cell);
  }

  /// OpenCV's own corners for every tag, and in their place those of the edge fit where it holds.
  void measure(const GreyImage& image, const cv::Mat& view, std::vector<DetectedTag>& tags) const {
    const auto rows = row_starts(image);
    const PixelRows pixels{0, image.width, 0, image.height, rows.data()};
    const int modules = dictionary.size + 2 * dictionary.border;
    std::vector<Corners> initial;
    std::vector<Quadrilateral> found;
    for (DetectedTag& tag : tags) {
      stop_point();
      initial.push_back(tag.corners);
      const double cell = shortest_side(tag.corners) / modules;
      tag.corners = options.refinement == Refinement::edges ? unfitted_corners(view, pixels, tag.corners, cell)
                                                            : subpixel_corners(view, tag.corners, cell);
      for (auto& c : tag.covariances)
        c = Eigen::Matrix2d::Identity() * options.unrefined_sigma * options.unrefined_sigma;
      found.push_back({tag.corners, modules});
    }
    if (options.refinement != Refinement::edges) return;
    // OpenCV's contours are good to a pixel or two; the second pass has its strips in the right place.
    const Measurement first = measure_corners(image, found, options.edge);
    for (size_t k = 0; k < tags.size(); ++k)
      if (first.corners[k]) found[k].corners = first.corners[k]->corners;
    EdgeFitOptions again = options.edge;
    again.gamma = first.quality.gamma;  // the image's, and most of the work
    again.grid = first.quality.grid;
    stop_point();
    const Measurement second = measure_corners(image, found, again);
    for (size_t k = 0; k < tags.size(); ++k) {
      if (!first.corners[k] || !second.corners[k]) continue;
      const double cell = shortest_side(initial[k]) / modules;
      if (largest_move(first.corners[k]->corners, initial[k]) > std::max(3.0, 0.7 * cell)) continue;
      if (largest_move(second.corners[k]->corners, first.corners[k]->corners) > std::max(0.5, 0.1 * cell)) continue;
      tags[k].corners = second.corners[k]->corners;
      for (size_t i = 0; i < 4; ++i)
        tags[k].covariances[i] =
            second.corners[k]->covariances[i] + Eigen::Matrix2d::Identity() * options.sigma_floor * options.sigma_floor;
      tags[k].refined = true, tags[k].inset_sigma = first.quality.inset_sigma;
    }
  }

  /// Whether the tag of code number `index` looks like its drawing; white on black too if that is looked for.
  bool alike(const PixelRows& image, const DetectedTag& tag, size_t index) const {
    if (!limit.checks() || !plain) return true;
    Corners upright = tag.corners;  // as OpenCV draws it
    if (dictionary.turned) std::rotate(upright.begin(), upright.begin() + 2, upright.end());
    return limit.holds(likeness(image, upright, plain->family(), index)) ||
           (options.white_on_black && limit.holds(likeness(image, upright, negative->family(), index)));
  }

  /// Tags among the squares that OpenCV found and could not read: blur that hides single cells from it leaves them to
  /// our decoder, which knows the light over the square.
  void read_again(const PixelRows& image, const std::vector<std::vector<cv::Point2f>>& rejected,
                  std::vector<DetectedTag>& tags, std::vector<size_t>& kept) const {
    if (!plain) return;
    const LikenessLimit sure = likeness_limit(1);
    for (const auto& square : rejected) {
      Corners clockwise;
      for (size_t i = 0; i < 4; ++i)
        clockwise[i] = {static_cast<double>(square[i].x), static_cast<double>(square[i].y)};
      const double cell = shortest_side(clockwise) / plain->family().modules;
      if (shortest_side(clockwise) < options.min_side - 1) continue;
      const auto lines = on_edges(image, clockwise, std::clamp(0.4 * cell, 1.5, 4.0), false);
      const auto code = plain->read(image, lines ? *lines : clockwise).code;
      if (!code) continue;
      const auto& ids = plain->family().ids;
      const auto index = static_cast<size_t>(std::find(ids.begin(), ids.end(), code->id) - ids.begin());
      if (!sure.holds(likeness(image, code->corners, plain->family(), index))) continue;
      DetectedTag tag;
      tag.family = dictionary.name, tag.id = code->id, tag.decision_margin = std::nan("");
      tag.corners = code->corners;
      if (dictionary.turned) std::rotate(tag.corners.begin(), tag.corners.begin() + 2, tag.corners.end());
      if (std::any_of(tags.begin(), tags.end(), [&](const DetectedTag& other) { return same_place(other, tag); }))
        continue;
      tags.push_back(std::move(tag)), kept.push_back(index);
    }
  }

  /// Squares that are no tags of the dictionary, but would be in a mirror.
  int mirrored_in(const PixelRows& image, const std::vector<std::vector<cv::Point2f>>& rejected) const {
    if (!plain) return 0;
    const LikenessLimit sure = likeness_limit(1);
    int count = 0;
    for (const auto& square : rejected) {
      Corners c;
      for (size_t i = 0; i < 4; ++i) c[i] = {static_cast<double>(square[i].x), static_cast<double>(square[i].y)};
      const auto code = plain->read(image, {c[0], c[3], c[2], c[1]}).code;
      if (!code) continue;
      const auto& ids = plain->family().ids;
      const auto index = static_cast<size_t>(std::find(ids.begin(), ids.end(), code->id) - ids.begin());
      count += sure.holds(likeness(image, code->corners, plain->family(), index));
    }
    return count;
  }
};

/// Tags with a border of two cells are those of Kalibr's grids, whose corners touch black squares: OpenCV's contours
/// run from one into the other.
TagPyramid pyramid_for(const TagDictionary& dictionary, const ArucoOptions& options) {
  PyramidOptions search;
  search.smallest_tag = options.min_side;
  // More than one wrong bit makes a tag with a border of one cell one of these.
  search.max_hamming = std::min(1, static_cast<int>(options.correction_rate * dictionary.correctable_bits));
  search.min_decision_margin = 10;
  search.refinement = options.refinement, search.edge = options.edge;
  search.sigma_floor = options.sigma_floor, search.unrefined_sigma = options.unrefined_sigma;
  const bool apriltag = is_apriltag_family(dictionary.name);
  return {{apriltag ? apriltag_square_family(dictionary.name) : dictionary_square_family(dictionary)}, search};
}

ArucoDetector::ArucoDetector(const TagDictionary& dictionary, const ArucoOptions& options)
    : impl_(std::make_unique<Impl>()) {
  keep_opencv_to_one_thread();
  impl_->dictionary = dictionary;
  impl_->options = options;
  impl_->codes = opencv_dictionary(dictionary);
  const auto bits = static_cast<size_t>(dictionary.size) * dictionary.size;
  impl_->chance = chance_of_code(dictionary.codes.size(), bits,
                                 static_cast<int>(options.correction_rate * dictionary.correctable_bits));
  impl_->limit = options.limit ? *options.limit : likeness_limit(impl_->chance);
  if (dictionary.size > 8) return;
  const SquareFamily family = dictionary_square_family(dictionary);
  impl_->plain.emplace(family, 0);
  impl_->negative.emplace(negative_of(family), 0);
}
ArucoDetector::~ArucoDetector() = default;

double ArucoDetector::chance() const { return impl_->chance; }

ArucoSearch ArucoDetector::search(const GreyImage& image) const {
  ArucoSearch result;
  if (image.width < 16 || image.height < 16) return result;
  if (impl_->dictionary.border > 1) {
    result.tags = pyramid_for(impl_->dictionary, impl_->options).detect(image).tags;
    return result;
  }
  const cv::Mat view(image.height, image.width, CV_8UC1, const_cast<std::uint8_t*>(image.pixels.data()));
  std::vector<std::vector<cv::Point2f>> corners, rejected;
  std::vector<int> numbers;
  cv::aruco::detectMarkers(view, impl_->codes, corners, numbers, impl_->parameters(std::max(image.width, image.height)),
                           rejected);
  // OpenCV goes clockwise from the top left of its own drawing of the marker.
  const std::array<size_t, 4> order =
      impl_->dictionary.turned ? std::array<size_t, 4>{1, 0, 3, 2} : std::array<size_t, 4>{3, 2, 1, 0};
  std::vector<DetectedTag> tags;
  std::vector<size_t> kept;  // their numbers in the dictionary
  for (size_t k = 0; k < numbers.size(); ++k) {
    DetectedTag tag;
    tag.family = impl_->dictionary.name;
    tag.id = impl_->dictionary.ids[numbers[k]];
    tag.decision_margin = std::nan("");
    for (size_t i = 0; i < 4; ++i)
      tag.corners[i] = {static_cast<double>(corners[k][order[i]].x), static_cast<double>(corners[k][order[i]].y)};
    if (shortest_side(tag.corners) < impl_->options.min_side - 1) continue;  // contours are good to a pixel
    tags.push_back(std::move(tag));
    kept.push_back(static_cast<size_t>(numbers[k]));
  }
  const auto rows = row_starts(image);
  const PixelRows pixels{0, image.width, 0, image.height, rows.data()};
  impl_->read_again(pixels, rejected, tags, kept);
  impl_->measure(image, view, tags);
  for (size_t k = 0; k < tags.size(); ++k) {
    if (impl_->alike(pixels, tags[k], kept[k]))
      result.tags.push_back(std::move(tags[k]));
    else
      ++result.unlike;
  }
  result.mirrored = impl_->mirrored_in(pixels, rejected);
  std::sort(result.tags.begin(), result.tags.end(), [](const DetectedTag& a, const DetectedTag& b) {
    return std::make_tuple(a.id, a.corners[0].x(), a.corners[0].y()) <
           std::make_tuple(b.id, b.corners[0].x(), b.corners[0].y());
  });
  return result;
}

}  // namespace plumbline::detect
