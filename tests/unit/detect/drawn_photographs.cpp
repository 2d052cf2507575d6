#include "drawn_photographs.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "tag_cells.hpp"
#include "tag_rendering.hpp"

namespace plumbline::test {
namespace {

constexpr int kFine = 6;   // samples a pixel, each way
constexpr int kCell = 48;  // of the drawing that is projected, linear between samples: edges keep their place
constexpr float kWhite = 0.6f, kBlack = 0.04f;

cv::Mat drawing_of(const TagCells& cells) {
  cv::Mat drawing(cells.total * kCell, cells.total * kCell, CV_32F);
  for (int y = 0; y < drawing.rows; ++y)
    for (int x = 0; x < drawing.cols; ++x)
      drawing.at<float>(y, x) = cells.white[y / kCell * cells.total + x / kCell] > 127 ? kWhite : kBlack;
  return drawing;
}

/// The part of the image that a tag's surroundings take.
cv::Rect field_of(const DrawnCorners& corners, double blur, const cv::Size& image) {
  Eigen::Vector2d low = corners[0], high = corners[0];
  for (const auto& corner : corners) low = low.cwiseMin(corner), high = high.cwiseMax(corner);
  const double margin = 0.2 * (high - low).maxCoeff() + 5 * blur + 2;
  const cv::Point first(static_cast<int>(std::floor(low.x() - margin)), static_cast<int>(std::floor(low.y() - margin)));
  const cv::Point last(static_cast<int>(std::ceil(high.x() + margin)), static_cast<int>(std::ceil(high.y() + margin)));
  return cv::Rect(first, last) & cv::Rect({0, 0}, image);
}

float grey_of(double light, const CameraChain& camera) {
  double grey = std::clamp(camera.exposure * light, 0.0, 1.0);
  if (camera.srgb) grey = grey <= 0.0031308 ? 12.92 * grey : 1.055 * std::pow(grey, 1 / 2.4) - 0.055;
  grey += camera.s_curve * (grey * grey * (3 - 2 * grey) - grey);
  return static_cast<float>(255 * grey);
}

}  // namespace

cv::Mat light_of(const std::vector<DrawnTag>& tags, int width, int height, double blur) {
  cv::Mat light(height, width, CV_32F, cv::Scalar(kWhite));
  for (const DrawnTag& tag : tags) {
    const TagCells cells = cells_of("tag36h11", tag.id);
    const float near = static_cast<float>((cells.total - cells.border) / 2 * kCell) - 0.5f;
    const float far = near + static_cast<float>(cells.border * kCell);
    const std::vector<cv::Point2f> from = {{near, far}, {far, far}, {far, near}, {near, near}};
    const cv::Rect field = field_of(tag.corners, blur, light.size());
    const auto fine = [](double pixel) { return static_cast<float>((pixel + 0.5) * kFine - 0.5); };
    std::vector<cv::Point2f> to;
    for (const auto& corner : tag.corners) to.emplace_back(fine(corner.x() - field.x), fine(corner.y() - field.y));
    cv::Mat samples(field.size() * kFine, CV_32F, cv::Scalar(kWhite));
    cv::warpPerspective(drawing_of(cells), samples, cv::getPerspectiveTransform(from, to), samples.size(),
                        cv::INTER_LINEAR, cv::BORDER_TRANSPARENT);
    cv::GaussianBlur(samples, samples, {}, blur * kFine);
    cv::Mat part;
    cv::resize(samples, part, field.size(), 0, 0, cv::INTER_AREA);
    cv::Mat behind = light(field);
    cv::min(behind, part, behind);
  }
  return light;
}

GreyImage photograph_of(const cv::Mat& light, const CameraChain& camera, std::uint64_t seed) {
  cv::Mat seen = light.clone();
  if (camera.bloom > 0) {
    cv::GaussianBlur(light, seen, {}, 3);
    seen = (1 - camera.bloom) * light + camera.bloom * seen;
  }
  NormalNoise random(seed);
  cv::Mat grey(light.size(), CV_32F);
  const double cx = 0.5 * light.cols, cy = 0.5 * light.rows;
  for (int y = 0; y < light.rows; ++y)
    for (int x = 0; x < light.cols; ++x) {
      const double r = (std::pow(x - cx, 2) + std::pow(y - cy, 2)) / (cx * cx + cy * cy);
      const double shade = camera.vignette ? 1 - 0.5 * r : 1;
      grey.at<float>(y, x) = grey_of(shade * static_cast<double>(seen.at<float>(y, x)), camera) +
                             static_cast<float>(camera.noise * random());
    }
  if (camera.smoothed) {
    cv::Mat smooth;
    cv::bilateralFilter(grey, smooth, 5, 25, 1.5);
    grey = smooth;
  }
  if (camera.sharpened > 0) {
    cv::Mat soft;
    cv::GaussianBlur(grey, soft, {}, 1.5);
    grey += camera.sharpened * (grey - soft);
  }
  cv::Mat bytes;
  grey.convertTo(bytes, CV_8U);
  if (camera.quality > 0) {
    std::vector<std::uint8_t> file;
    cv::imencode(".jpg", bytes, file, {cv::IMWRITE_JPEG_QUALITY, camera.quality});
    bytes = cv::imdecode(file, cv::IMREAD_GRAYSCALE);
  }
  return {bytes.cols, bytes.rows, std::vector<std::uint8_t>(bytes.begin<std::uint8_t>(), bytes.end<std::uint8_t>())};
}

std::vector<CameraChain> camera_chains() {
  return {
      {.name = "sRGB"},
      {.name = "JPEG 95", .quality = 95},
      {.name = "JPEG 90", .quality = 90},
      {.name = "JPEG 80", .quality = 80},
      {.name = "JPEG 70", .quality = 70},
      {.name = "JPEG 50", .quality = 50},
      {.name = "bloom", .exposure = 1.5, .bloom = 0.25, .quality = 95},
      {.name = "smoothed", .noise = 3, .smoothed = true, .quality = 90},
      {.name = "sharpened", .sharpened = 0.8, .quality = 92},
      {.name = "telephone",
       .vignette = true,
       .noise = 3,
       .s_curve = 0.5,
       .smoothed = true,
       .sharpened = 0.8,
       .quality = 70},
      {.name = "linear", .srgb = false},
      {.name = "linear JPEG 90", .srgb = false, .quality = 90},
      {.name = "linear JPEG 70", .srgb = false, .quality = 70},
  };
}

}  // namespace plumbline::test
