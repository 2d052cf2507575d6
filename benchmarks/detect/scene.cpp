#include "scene.hpp"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <random>
#include <stdexcept>

namespace plumbline::benchmark {
namespace {

/// Reflectance as 16-bit light, drawn in place.
class Facade {
 public:
  Facade(const SceneOptions& options, std::mt19937_64& random)
      : o_(options), random_(random), light_(options.height, options.width, CV_16U) {}

  void bricks() {
    // Bricks of 24 x 7 cm with joints of 1 cm at 0.8 mm a pixel; the left third is plaster.
    const int course = 100, brick = 312, joint = 12;
    for (int y = 0; y < o_.height; ++y) {
      auto* row = light_.ptr<std::uint16_t>(y);
      const int shift = (y / course) % 2 * brick / 2;
      for (int x = 0; x < o_.width; ++x) {
        const bool plaster = x < o_.width / 3;
        const bool in_joint = y % course < joint || (x + shift) % brick < joint;
        const std::uint32_t key =
            static_cast<std::uint32_t>(y / course) * 7919u + static_cast<std::uint32_t>((x + shift) / brick) * 104729u;
        const double tone = 0.10 + 0.08 * ((key * 2654435761u >> 16) & 255) / 255.0;
        row[x] = static_cast<std::uint16_t>(65535 * (plaster ? 0.55 : in_joint ? 0.42 : tone));
      }
    }
  }
  void mesh() {
    const cv::Rect part(o_.width * 2 / 3, 0, o_.width / 3, o_.height);
    for (int x = part.x; x < part.x + part.width; x += 41)
      cv::line(light_, {x, 0}, {x + 60, o_.height}, cv::Scalar(60000), 4, cv::LINE_AA);
    for (int y = 0; y < o_.height; y += 37)
      cv::line(light_, {part.x, y}, {o_.width, y + 25}, cv::Scalar(6000), 3, cv::LINE_AA);
  }
  void text() {
    for (int k = 0; k < 400; ++k) {
      const cv::Point at(integer(o_.width), integer(o_.height));
      const double size = 0.5 + 3.5 * uniform();
      cv::putText(light_, "PORTAL 36H11 #" + std::to_string(integer(9999)), at, cv::FONT_HERSHEY_SIMPLEX, size,
                  cv::Scalar(uniform() < 0.5 ? 3000 : 60000), std::max(1, static_cast<int>(2 * size)), cv::LINE_AA);
    }
  }
  /// Every pixel is the mean of 4 x 4 samples. `from_image` leads to cells of the tag from its upper left corner.
  void tag(const detect::SquareFamily& family, std::uint64_t code, const cv::Matx33d& from_image, const cv::Rect& box) {
    const int n = family.modules;
    for (int y = box.y; y < box.br().y; ++y)
      for (int x = box.x; x < box.br().x; ++x) {
        double sum = 0, covered = 0;
        for (int k = 0; k < 16; ++k) {
          const cv::Vec3d p = from_image * cv::Vec3d(x - 0.375 + 0.25 * (k % 4), y - 0.375 + 0.25 * (k / 4), 1);
          const double column = p[0] / p[2], row = p[1] / p[2];
          if (column < -1.5 || row < -1.5 || column >= n + 1.5 || row >= n + 1.5) continue;
          covered += 1;
          bool white = column < 0 || row < 0 || column >= n || row >= n;
          const std::array<int, 2> cell = {static_cast<int>(std::floor(column)), static_cast<int>(std::floor(row))};
          const auto at = std::find(family.cells.begin(), family.cells.end(), cell);
          if (at != family.cells.end())
            white = code >> (family.cells.size() - 1 - static_cast<std::size_t>(at - family.cells.begin())) & 1;
          sum += white ? 0.75 : 0.03;
        }
        auto& light = light_.at<std::uint16_t>(y, x);
        light = static_cast<std::uint16_t>((65535 * sum + (16 - covered) * light) / 16);
      }
  }
  cv::Mat photograph() {
    cv::GaussianBlur(light_, light_, {0, 0}, o_.blur);
    cv::Mat grey(light_.size(), CV_8U);
    std::vector<std::uint8_t> curve(65536);
    for (std::size_t i = 0; i < curve.size(); ++i) {
      const double l = static_cast<double>(i) / 65535;
      curve[i] = static_cast<std::uint8_t>(
          std::lround(255 * (l <= 0.0031308 ? 12.92 * l : 1.055 * std::pow(l, 1 / 2.4) - 0.055)));
    }
    std::normal_distribution<float> normal(0, static_cast<float>(o_.noise));
    std::vector<float> noise(1 << 20);
    for (float& value : noise) value = normal(random_);
    for (int y = 0; y < grey.rows; ++y) {
      std::size_t at = random_() % (noise.size() / 2);
      for (int x = 0; x < grey.cols; ++x, ++at)
        grey.at<std::uint8_t>(y, x) = cv::saturate_cast<std::uint8_t>(
            static_cast<float>(curve[light_.at<std::uint16_t>(y, x)]) + noise[at & (noise.size() - 1)]);
    }
    return grey;
  }
  double uniform() { return std::uniform_real_distribution<double>(0, 1)(random_); }
  int integer(int below) { return static_cast<int>(uniform() * below); }

 private:
  const SceneOptions& o_;
  std::mt19937_64& random_;
  cv::Mat light_;
};

}  // namespace

void write_scene(const SceneOptions& o, const detect::SquareFamily& family, const std::string& path) {
  std::mt19937_64 random(o.seed);
  Facade facade(o, random);
  facade.bricks();
  facade.text();
  facade.mesh();
  std::ofstream truth(path + ".csv");
  truth << "id,x0,y0,x1,y1,x2,y2,x3,y3\n";
  std::vector<cv::Rect> taken;
  for (int k = 0, attempts = 0; k < o.tags; ++attempts) {
    if (attempts > 200 * o.tags)
      throw std::runtime_error("no room for " + std::to_string(o.tags) + " tags of this size");
    const double share = o.tags > 1 ? k / static_cast<double>(o.tags - 1) : 0;
    const double side = o.smallest * std::pow(o.largest / o.smallest, share), turn = 2 * M_PI * facade.uniform();
    const double tilt = 0.8 * facade.uniform(), cx = facade.integer(o.width), cy = facade.integer(o.height);
    const auto n = static_cast<float>(family.modules);
    const std::array<cv::Point2f, 4> square = {{{0, 0}, {n, 0}, {n, n}, {0, n}}};
    std::array<cv::Point2f, 4> corners;
    float left = 1e9f, right = -1e9f, top = 1e9f, bottom = -1e9f;
    for (std::size_t i = 0; i < 4; ++i) {
      const double x = side * (static_cast<double>(square[i].x / n) - 0.5),
                   y = side * (static_cast<double>(square[i].y / n) - 0.5);
      const double u = (x * std::cos(turn) - y * std::sin(turn)), v = x * std::sin(turn) + y * std::cos(turn);
      const double scale = 6 * side / (6 * side + u * std::sin(tilt));
      corners[i] = {static_cast<float>(cx + u * std::cos(tilt) * scale), static_cast<float>(cy + v * scale)};
      left = std::min(left, corners[i].x), right = std::max(right, corners[i].x);
      top = std::min(top, corners[i].y), bottom = std::max(bottom, corners[i].y);
    }
    const float border = static_cast<float>(0.4 * side) + 4;
    const cv::Rect box(static_cast<int>(left - border), static_cast<int>(top - border),
                       static_cast<int>(right - left + 2 * border), static_cast<int>(bottom - top + 2 * border));
    if ((box & cv::Rect(0, 0, o.width, o.height)) != box) continue;
    if (std::any_of(taken.begin(), taken.end(), [&](const cv::Rect& t) { return (t & box).area() > 0; })) continue;
    taken.push_back(box);
    const std::size_t id = static_cast<std::size_t>(k) % family.codes.size();
    facade.tag(family, family.codes[id], cv::getPerspectiveTransform(corners.data(), square.data()), box);
    truth << family.ids[id];
    for (const auto& c : corners) truth << ',' << c.x << ',' << c.y;
    truth << '\n';
    ++k;
  }
  if (!cv::imwrite(path, facade.photograph(), {cv::IMWRITE_JPEG_QUALITY, 93}))
    throw std::runtime_error("cannot write " + path);
}

}  // namespace plumbline::benchmark
