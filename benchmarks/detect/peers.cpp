#include "peers.hpp"

#include <apriltag/apriltag.h>
#include <apriltag/common/zarray.h>

#include <algorithm>
#include <map>
#include <memory>
#include <opencv2/aruco.hpp>
#include <opencv2/core.hpp>

#include "photo/detect/tag_pyramid.hpp"

namespace plumbline::benchmark {
namespace {

using detect::SquareFamily;

/// The family in libapriltag's form. A turn by 90 degrees is a turn of its code by a quarter of the bits, so the cells
/// of one quarter come first, then where each of them goes at the next turn; a cell in the middle is last.
struct OwnFamily {
  apriltag_family_t family{};
  std::vector<std::uint64_t> codes;
  std::vector<std::uint32_t> x, y;
  std::string name;

  explicit OwnFamily(const SquareFamily& source) : name(source.name) {
    const int last = source.modules - 1;
    std::map<std::array<int, 2>, std::size_t> index;
    for (std::size_t i = 0; i < source.cells.size(); ++i) index[source.cells[i]] = i;
    std::map<std::array<int, 2>, bool> placed;
    std::vector<std::array<int, 2>> quarter, middle;
    for (const auto& cell : source.cells) {
      if (placed[cell]) continue;
      std::array<int, 2> at = cell;
      for (int turn = 0; turn < 4; ++turn) placed[at] = true, at = {last - at[1], at[0]};
      (2 * cell[0] == last && 2 * cell[1] == last ? middle : quarter).push_back(cell);
    }
    std::vector<std::array<int, 2>> order;
    for (int turn = 0; turn < 4; ++turn)
      for (auto& cell : quarter) order.push_back(cell), cell = {last - cell[1], cell[0]};
    order.insert(order.end(), middle.begin(), middle.end());
    for (const auto& [column, row] : order)
      x.push_back(static_cast<std::uint32_t>(column)), y.push_back(static_cast<std::uint32_t>(row));
    for (const std::uint64_t code : source.codes) {
      std::uint64_t turned = 0;
      for (const auto& cell : order) turned = turned << 1 | (code >> (source.cells.size() - 1 - index[cell]) & 1);
      codes.push_back(turned);
    }
    family.ncodes = static_cast<std::uint32_t>(codes.size());
    family.codes = codes.data();
    family.width_at_border = source.modules;
    int outermost = 0;
    for (const auto& [column, row] : source.cells) outermost = std::max({outermost, column, row});
    family.total_width = std::max(source.modules + 2, 2 * outermost + 3 - source.modules);
    family.reversed_border = source.bright_inside;
    family.nbits = static_cast<std::uint32_t>(x.size());
    family.bit_x = x.data(), family.bit_y = y.data();
    family.h = static_cast<std::uint32_t>(2 * source.correctable_bits + 1);
    family.name = name.data();
  }
};

struct OwnDetector {
  std::unique_ptr<OwnFamily> family;
  apriltag_detector_t* detector = apriltag_detector_create();
  ~OwnDetector() { apriltag_detector_destroy(detector); }
};

}  // namespace

double Found::shortest_side() const {
  double shortest = (corners[3] - corners[0]).norm();
  for (std::size_t i = 0; i < 3; ++i) shortest = std::min(shortest, (corners[i + 1] - corners[i]).norm());
  return shortest;
}

Peer libapriltag_peer(const SquareFamily& source, float decimate) {
  auto own = std::make_shared<OwnDetector>();
  own->family = std::make_unique<OwnFamily>(source);
  apriltag_detector_add_family_bits(own->detector, &own->family->family, std::min(1, source.correctable_bits));
  own->detector->nthreads = 1;
  own->detector->quad_decimate = decimate;
  const auto detect = [own](const GreyImage& image) {
    image_u8_t view{image.width, image.height, image.width, const_cast<std::uint8_t*>(image.pixels.data())};
    zarray_t* detections = apriltag_detector_detect(own->detector, &view);
    std::vector<Found> result;
    for (int k = 0; k < zarray_size(detections); ++k) {
      apriltag_detection_t* d = nullptr;
      zarray_get(detections, k, &d);
      if (d->decision_margin < 25) continue;
      Found found{d->id, {}};
      for (std::size_t i = 0; i < 4; ++i) found.corners[i] = {d->p[i][0] - 0.5, d->p[i][1] - 0.5};
      result.push_back(found);
    }
    apriltag_detections_destroy(detections);
    return result;
  };
  return {"libapriltag 3.3.0 decimate " + std::to_string(static_cast<int>(decimate)), detect};
}

Peer opencv_peer(const std::string& name) {
  const detect::TagDictionary codes = detect::builtin_dictionary(name);
  auto dictionary = cv::makePtr<cv::aruco::Dictionary>();
  dictionary->markerSize = codes.size;
  dictionary->maxCorrectionBits = codes.correctable_bits;
  for (const auto& code : codes.codes)
    dictionary->bytesList.push_back(cv::aruco::Dictionary::getByteListFromBits(
        cv::Mat(codes.size, codes.size, CV_8UC1, const_cast<std::uint8_t*>(code.data()))));
  const auto detect = [dictionary](const GreyImage& image) {
    const cv::Mat view(image.height, image.width, CV_8UC1, const_cast<std::uint8_t*>(image.pixels.data()));
    std::vector<std::vector<cv::Point2f>> corners;
    std::vector<int> ids;
    cv::aruco::detectMarkers(view, dictionary, corners, ids);
    std::vector<Found> result;
    for (std::size_t k = 0; k < ids.size(); ++k) {
      Found found{ids[k], {}};
      for (std::size_t i = 0; i < 4; ++i)
        found.corners[i] = {static_cast<double>(corners[k][i].x), static_cast<double>(corners[k][i].y)};
      result.push_back(found);
    }
    return result;
  };
  return {std::string("OpenCV ") + CV_VERSION + " aruco", detect};
}

Peer pyramid_peer(const SquareFamily& family, double smallest_tag, bool edges) {
  detect::PyramidOptions options;
  options.smallest_tag = smallest_tag;
  if (!edges) options.refinement = detect::Refinement::apriltag;
  auto detector = std::make_shared<detect::TagPyramid>(std::vector<SquareFamily>{family}, options);
  const auto detect = [detector](const GreyImage& image) {
    const auto rows = rows_of(image);
    const auto part = [&](int left, int top, int width, int height) {
      return part_of(image, left, top, width, height);
    };
    std::vector<Found> result;
    for (const auto& tag : detector->detect(*rows, part).tags) result.push_back({tag.id, tag.corners});
    return result;
  };
  return {edges ? "tag_pyramid, edges fitted" : "tag_pyramid", detect};
}

}  // namespace plumbline::benchmark
