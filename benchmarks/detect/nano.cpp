// A detector built the way that ArUco Nano is described to be: the image is compared with its mean over 15 x 15 pixels,
// outlines of dark figures are followed and left as soon as they meet one followed before, polygons of four corners are
// read with bilinear samples of the cells at up to five slightly different sets of corners, and codes are looked up in
// a hash table without correction. Written for this comparison from that description; not the program itself.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <unordered_map>

#include "peers.hpp"

#define PLUMBLINE_CLONES __attribute__((target_clones("avx2", "default")))

namespace plumbline::benchmark {
namespace {

constexpr int kBox = 15, kBelowMean = 7, kShortestOutline = 40;

PLUMBLINE_CLONES void mark(const std::uint8_t* grey, const std::uint8_t* mean, std::size_t count, std::uint8_t* out) {
  for (std::size_t i = 0; i < count; ++i) out[i] = grey[i] + kBelowMean < mean[i] ? 1 : 0;
}

/// Outline of the figure whose leftmost pixel of a row is (x, y), by its pixels (8 neighbours). Empty if it meets one
/// that was followed before.
void follow(cv::Mat& marks, int x, int y, std::vector<cv::Point>& outline) {
  static constexpr std::array<int, 8> dx = {1, 1, 0, -1, -1, -1, 0, 1}, dy = {0, 1, 1, 1, 0, -1, -1, -1};
  outline.clear();
  int px = x, py = y, back = 4;
  do {
    std::uint8_t& here = marks.at<std::uint8_t>(py, px);
    if (here == 2 && !outline.empty() && (px != x || py != y)) {
      outline.clear();
      return;
    }
    here = 2;
    outline.emplace_back(px, py);
    int direction = back, k = 0;
    for (; k < 8; ++k) {
      direction = (back + 1 + k) & 7;
      if (marks.at<std::uint8_t>(py + dy[direction], px + dx[direction]) != 0) break;
    }
    if (k == 8) return;
    px += dx[direction], py += dy[direction];
    back = (direction + 4) & 7;
  } while (px != x || py != y);
}

struct Nano {
  detect::SquareFamily family;
  std::unordered_map<std::uint64_t, int> ids;  // with all turns

  explicit Nano(const detect::SquareFamily& source) : family(source) {
    const int last = source.modules - 1;
    const std::size_t n = source.cells.size();
    for (std::size_t c = 0; c < source.codes.size(); ++c)
      for (int turn = 0; turn < 4; ++turn) {
        std::uint64_t code = 0;
        for (std::size_t i = 0; i < n; ++i) {
          std::array<int, 2> cell = source.cells[i];
          for (int t = 0; t < turn; ++t) cell = {last - cell[1], cell[0]};
          const auto at = std::find(source.cells.begin(), source.cells.end(), cell) - source.cells.begin();
          code = code << 1 | (source.codes[c] >> (n - 1 - static_cast<std::size_t>(at)) & 1);
        }
        ids.emplace(code, source.ids[c]);
      }
  }

  int read(const cv::Mat& image, const std::array<cv::Point2f, 4>& corners) const {
    const int n = family.modules;
    const std::array<cv::Point2f, 4> square = {{{0, 0},
                                                {static_cast<float>(n), 0},
                                                {static_cast<float>(n), static_cast<float>(n)},
                                                {0, static_cast<float>(n)}}};
    const cv::Matx33d h = cv::getPerspectiveTransform(square.data(), corners.data());
    std::vector<float> value(static_cast<std::size_t>(n * n));
    float low = 255, high = 0;
    for (int row = 0; row < n; ++row)
      for (int column = 0; column < n; ++column) {
        const cv::Vec3d p = h * cv::Vec3d(column + 0.5, row + 0.5, 1);
        const double x = p[0] / p[2], y = p[1] / p[2];
        const int i = static_cast<int>(x), j = static_cast<int>(y);
        if (i < 0 || j < 0 || i + 1 >= image.cols || j + 1 >= image.rows) return -1;
        const double u = x - i, v = y - j;
        const std::uint8_t *a = image.ptr(j) + i, *b = image.ptr(j + 1) + i;
        const double grey = (1 - v) * ((1 - u) * a[0] + u * a[1]) + v * ((1 - u) * b[0] + u * b[1]);
        value[row * n + column] = static_cast<float>(grey);
        low = std::min(low, static_cast<float>(grey)), high = std::max(high, static_cast<float>(grey));
      }
    const float threshold = 0.5f * (low + high);
    for (int k = 0; k < n; ++k)
      for (const int cell : {k, (n - 1) * n + k, k * n, k * n + n - 1})
        if (value[cell] > threshold) return -1;
    std::uint64_t code = 0;
    for (const auto& [column, row] : family.cells)
      code = code << 1 | static_cast<std::uint64_t>(value[row * n + column] > threshold);
    const auto found = ids.find(code);
    return found == ids.end() ? -1 : found->second;
  }

  std::vector<Found> detect(const GreyImage& grey) const {
    const cv::Mat image(grey.height, grey.width, CV_8UC1, const_cast<std::uint8_t*>(grey.pixels.data()));
    cv::Mat mean, marks = cv::Mat::zeros(image.size(), CV_8UC1);
    cv::boxFilter(image, mean, CV_8U, {kBox, kBox});
    for (int y = 1; y + 1 < image.rows; ++y)
      mark(image.ptr(y) + 1, mean.ptr(y) + 1, static_cast<std::size_t>(image.cols - 2), marks.ptr(y) + 1);
    std::vector<Found> result;
    std::vector<cv::Point> outline, polygon;
    for (int y = 1; y + 1 < image.rows; ++y) {
      const std::uint8_t* row = marks.ptr(y);
      for (int x = 1; x + 1 < image.cols; ++x) {
        if (row[x] != 1 || row[x - 1] != 0) continue;
        follow(marks, x, y, outline);
        if (outline.size() < kShortestOutline) continue;
        cv::approxPolyDP(outline, polygon, 0.05 * static_cast<double>(outline.size()), true);
        if (polygon.size() != 4 || !cv::isContourConvex(polygon)) continue;
        look(image, polygon, result);
      }
    }
    return result;
  }

  void look(const cv::Mat& image, const std::vector<cv::Point>& polygon, std::vector<Found>& result) const {
    static constexpr std::array<std::array<float, 2>, 5> shift = {
        {{0, 0}, {0.7f, 0}, {-0.7f, 0}, {0, 0.7f}, {0, -0.7f}}};
    for (const auto& [dx, dy] : shift) {
      std::array<cv::Point2f, 4> corners;
      for (std::size_t i = 0; i < 4; ++i)
        corners[i] = {static_cast<float>(polygon[i].x) + dx, static_cast<float>(polygon[i].y) + dy};
      const cv::Point2f first = corners[1] - corners[0], second = corners[2] - corners[1];
      if (first.x * second.y - first.y * second.x < 0) std::swap(corners[1], corners[3]);
      const int id = read(image, corners);
      if (id < 0) continue;
      std::vector<cv::Point2f> exact(corners.begin(), corners.end());
      cv::cornerSubPix(image, exact, {4, 4}, {-1, -1},
                       cv::TermCriteria(cv::TermCriteria::EPS + cv::TermCriteria::COUNT, 12, 0.005));
      Found found{id, {}};
      for (std::size_t i = 0; i < 4; ++i)
        found.corners[i] = {static_cast<double>(exact[i].x), static_cast<double>(exact[i].y)};
      result.push_back(found);
      return;
    }
  }
};

}  // namespace

Peer nano_peer(const detect::SquareFamily& family) {
  auto nano = std::make_shared<Nano>(family);
  return {"ArUco-Nano-like", [nano](const GreyImage& image) { return nano->detect(image); }};
}

}  // namespace plumbline::benchmark
