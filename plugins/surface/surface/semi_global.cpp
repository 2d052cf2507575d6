#include "semi_global.hpp"

#include <cmath>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

#include "plumbline/stop.hpp"

namespace plumbline::surface {
namespace {

constexpr int kStrip = 384, kOverlap = 32, kNode = 8;  // rows, rows at each border, pixels between the nodes of a map

/// A part of a rectified photograph: columns from x0, rows from y0 on [px]. The way to the photograph is computed at
/// every eighth pixel and linear between, which is within a thousandth of a pixel of it.
cv::Mat rectified_part(const RectifiedPair& pair, const FacetView& view, double x0, double y0, int width, int height) {
  const int across = (width + kNode - 1) / kNode + 1, down = (height + kNode - 1) / kNode + 1;
  cv::Mat nodes(down, across, CV_32FC2);
  for (int r = 0; r < down; ++r)
    for (int c = 0; c < across; ++c) {
      const auto at = pair.source(*view.view, {x0 + c * kNode, y0 + r * kNode});
      nodes.at<cv::Vec2f>(r, c) =
          at ? cv::Vec2f(static_cast<float>(at->x()), static_cast<float>(at->y())) : cv::Vec2f(-1e6f, -1e6f);
    }
  cv::Mat map(height, width, CV_32FC2);
  for (int r = 0; r < height; ++r) {
    const float b = static_cast<float>(r % kNode) / kNode;
    for (int c = 0; c < width; ++c) {
      const float a = static_cast<float>(c % kNode) / kNode;
      const int nr = r / kNode, nc = c / kNode;
      map.at<cv::Vec2f>(r, c) =
          (1 - b) * ((1 - a) * nodes.at<cv::Vec2f>(nr, nc) + a * nodes.at<cv::Vec2f>(nr, nc + 1)) +
          b * ((1 - a) * nodes.at<cv::Vec2f>(nr + 1, nc) + a * nodes.at<cv::Vec2f>(nr + 1, nc + 1));
    }
  }
  const GreyImage& grey = view.image->level[0];
  const cv::Mat from(grey.height, grey.width, CV_8UC1, const_cast<std::uint8_t*>(grey.pixels.data()));
  cv::Mat part;
  cv::remap(from, part, map, cv::noArray(), cv::INTER_CUBIC, cv::BORDER_CONSTANT, 0);
  return part;
}

}  // namespace

std::optional<DisparityRange> disparity_range(const RectifiedPair& pair, const CellGrid& grid, double search) {
  Eigen::Vector3d low = Eigen::Vector3d::Constant(1e300), high = -low;
  for (const double u : {grid.area.low.x(), grid.area.high.x()})
    for (const double v : {grid.area.low.y(), grid.area.high.y()})
      for (const double h : {-search, search}) {
        const Eigen::Vector3d at = pair.rectified(grid.plane.world({u, v, h}));
        if (!(at.z() > 0)) return std::nullopt;  // behind the cameras
        low = low.cwiseMin(at), high = high.cwiseMax(at);
      }
  DisparityRange range;
  range.low = low.head<2>(), range.high = high.head<2>();
  if (!(high.z() - low.z() < 1000) || !(range.high - range.low).allFinite() ||
      (range.high - range.low).maxCoeff() > 1e5)
    return std::nullopt;
  range.least = static_cast<int>(std::floor(low.z())) - 2;
  range.count = (static_cast<int>(std::ceil(high.z())) + 2 - range.least + 15) / 16 * 16;
  return range;
}

std::vector<PairHeight> semi_global_heights(const RectifiedPair& pair, const CellGrid& grid,
                                            const std::vector<FacetView>& views, const SemiGlobalOptions& options) {
  std::vector<PairHeight> result(grid.size());
  const auto range = disparity_range(pair, grid, options.pair.search);
  if (!range) return result;
  const int squared = options.block * options.block;
  const auto matcher = cv::StereoSGBM::create(0, range->count, options.block, 8 * squared, 32 * squared, 1, 31, 5, 60,
                                              2, cv::StereoSGBM::MODE_SGBM);
  std::vector<std::vector<float>> heights(grid.size());
  // The first columns have no partner at the largest disparity: as many are taken more.
  const double x0 = std::floor(range->low.x()) - range->count - 8, top = std::floor(range->low.y()) - 1;
  const int width = static_cast<int>(std::ceil(range->high.x()) - x0) + 8;
  const int rows = static_cast<int>(std::ceil(range->high.y()) - top) + 1;
  for (int first = 0; first < rows; first += kStrip) {
    stop_point();
    const double y0 = top + first - kOverlap;
    const int height = std::min(kStrip, rows - first) + 2 * kOverlap;
    const cv::Mat left = rectified_part(pair, views[pair.left], x0, y0, width, height),
                  right = rectified_part(pair, views[pair.right], x0 - range->least, y0, width, height);
    cv::Mat disparity;
    matcher->compute(left, right, disparity);
    for (int r = kOverlap; r < height - kOverlap; ++r)
      for (int c = range->count; c < width; ++c) {
        const std::int16_t sixteenths = disparity.at<std::int16_t>(r, c);
        if (sixteenths < 0) continue;
        const Eigen::Vector3d local = grid.plane.local(pair.world({x0 + c, y0 + r, range->least + sixteenths / 16.0}));
        if (const auto cell = grid.at(local.x(), local.y())) heights[*cell].push_back(static_cast<float>(local.z()));
      }
  }
  const double ground = pair.depth / pair.focal, expected = grid.step().prod() / (ground * ground);
  for (size_t cell = 0; cell < grid.size(); ++cell)
    result[cell] = cell_height(grid, cell, heights[cell], expected, pair, views, options.pair);
  return result;
}

}  // namespace plumbline::surface
