#include "photo/block/photomodeler_files.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <map>
#include <set>
#include <stdexcept>

#include "base/text/text.hpp"
#include "photo/block/block_text.hpp"

namespace plumbline::block {
namespace {

namespace fs = std::filesystem;

/// The export line by line.
class Reader {
 public:
  explicit Reader(const fs::path& file) : name_(file.string()), lines_(lines_of(file)) {}
  bool at_end() const { return next_ >= lines_.size(); }
  bool blank() const { return words_of(lines_[next_], false).empty(); }
  const std::string& peek() const { return lines_[next_]; }
  void skip() { ++next_; }
  [[noreturn]] void fail(const std::string& what) const {
    throw std::runtime_error(name_ + ":" + std::to_string(std::min(next_ + 1, lines_.size())) + ": " + what);
  }
  std::string line(const char* expected) {
    if (at_end()) fail(std::string("the file ends, expected ") + expected);
    return lines_[next_++];
  }
  std::vector<double> numbers(size_t least, const char* expected) {
    if (at_end()) fail(std::string("the file ends, expected ") + expected);
    std::vector<double> values;
    for (const auto& word : words_of(lines_[next_], false)) {
      const auto value = text::parse_number(word, '.');
      if (!value) fail("'" + word + "' is not a number, expected " + expected);
      values.push_back(*value);
    }
    if (values.size() < least) fail("found " + std::to_string(values.size()) + " numbers, expected " + expected);
    ++next_;
    return values;
  }
  int integer(double value, const char* what) const {
    if (!(std::abs(value) < 2e9) || value != std::round(value)) fail(std::string(what) + " is not a whole number");
    return static_cast<int>(value);
  }

 private:
  std::string name_;
  std::vector<std::string> lines_;
  size_t next_ = 0;
};

SensorCamera camera_of(const Reader& reader, const std::vector<double>& v, size_t first, double width, double height) {
  SensorCamera camera;
  camera.lens = bundle::Lens::correcting;
  camera.values = {
      v[first], v[first + 1], v[first + 2], v[first + 5], v[first + 6], v[first + 7], v[first + 8], v[first + 9], 0, 0};
  camera.sensor_width = v[first + 3];
  camera.sensor_height = v[first + 4];
  camera.width = static_cast<int>(width);
  camera.height = static_cast<int>(height);
  if (!(camera.values[0] > 0)) reader.fail("the principal distance is not positive");
  if (!(camera.sensor_width > 0 && camera.sensor_height > 0)) reader.fail("the sensor's format is not positive");
  return camera;
}

/// An image size that is not the photographs': pixels that are not square, or marks outside.
void require_image_size(const PointBlock& block, const fs::path& file) {
  const auto size_of = [](const SensorCamera& camera) {
    return std::to_string(camera.width) + " x " + std::to_string(camera.height) + " pixels";
  };
  for (const SensorCamera& camera : block.cameras) {
    const double ratio = camera.sensor_width / camera.width / (camera.sensor_height / camera.height);
    if (ratio > 0.9 && ratio < 1.1) continue;
    const std::string text = fmt::format(
        " on a sensor of {:.4g} x {:.4g} mm have sides of {:.3g} and {:.3g} um", camera.sensor_width,
        camera.sensor_height, 1e3 * camera.sensor_width / camera.width, 1e3 * camera.sensor_height / camera.height);
    throw std::runtime_error(file.string() + ": " + size_of(camera) + text +
                             ": are width and height of the image exchanged?");
  }
  for (const BlockMeasurement& m : block.measurements) {
    const BlockImage& image = block.images[m.image];
    const SensorCamera& camera = block.cameras[image.camera];
    const Eigen::Array2d share = m.position.array() / Eigen::Array2d(camera.sensor_width, camera.sensor_height);
    if (share.minCoeff() > -0.05 && share.maxCoeff() < 1.05) continue;
    const std::string text = fmt::format(" is marked at ({:.1f}, {:.1f}) in photo {}, outside of ",
                                         share.x() * camera.width, share.y() * camera.height, image.id);
    throw std::runtime_error(file.string() + ": point " + block.points[m.point].name + text + size_of(camera) +
                             ": that is not the size of the photographs");
  }
}

/// Whether `words` are `values` as somebody prints them with fewer digits.
bool is_rounded(const std::vector<std::string>& words, const std::vector<double>& values) {
  if (words.size() < values.size()) return false;
  for (size_t i = 0; i < values.size(); ++i) {
    const auto value = text::parse_number(words[i], '.');
    const size_t point = words[i].find('.');
    if (!value || words[i].find_first_of("eE") != std::string::npos) return false;
    const double decimals = point == std::string::npos ? 0 : static_cast<double>(words[i].size() - point - 1);
    if (std::abs(*value - values[i]) > 0.501 * std::pow(10.0, -decimals)) return false;
  }
  return true;
}

/// Photos; those whose camera has the same values share one. The project's camera in the head of the file has more
/// digits than the photos' own lines: it stands for all that are it.
void read_photos(Reader& reader, const std::vector<double>& head, double width, double height, PointBlock& block) {
  constexpr double degree = M_PI / 180;
  std::vector<std::vector<double>> cameras;
  while (!reader.at_end() && !reader.blank()) {
    const std::string name = reader.line("a photo");
    const std::string first = words_of(name, false)[0];
    const auto number = text::parse_number(first, '.');
    if (!number) reader.fail("'" + first + "' is not a photo number");
    BlockImage image;
    image.id = static_cast<int>(*number);
    const auto outer = reader.numbers(7, "photo, X, Y, Z, kappa, phi, omega");
    if (reader.integer(outer[0], "the photo number") != image.id) reader.fail("this line is of another photo");
    image.centre = {outer[1], outer[2], outer[3]};
    image.angles = Eigen::Vector3d(outer[6], outer[5], outer[4]) * degree;
    reader.numbers(1, "the standard deviations of the orientation");
    if (reader.at_end()) reader.fail("the file ends within a photo");
    if (reader.blank())
      reader.skip();
    else if (words_of(reader.peek(), false).size() <= 7)
      reader.skip();  // covariances of the position
    auto words = words_of(reader.at_end() ? "" : reader.peek(), false);
    auto inner = reader.numbers(11, "photo, c, xp, yp, format width, height, K1, K2, K3, P1, P2");
    reader.numbers(1, "the standard deviations of the camera");
    inner.erase(inner.begin());
    words.erase(words.begin());
    if (is_rounded(words, head)) inner = head;
    const auto at = std::find(cameras.begin(), cameras.end(), inner);
    image.camera = static_cast<int>(at - cameras.begin());
    if (at == cameras.end()) {
      cameras.push_back(inner);
      block.cameras.push_back(camera_of(reader, inner, 0, width, height));
      block.cameras.back().id = static_cast<int>(block.cameras.size());
    }
    block.images.push_back(image);
  }
}

struct Listed {
  int id = 0;
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
};

std::vector<Listed> read_points(Reader& reader, const char* what) {
  std::vector<Listed> points;
  while (!reader.at_end() && !reader.blank()) {
    const auto v = reader.numbers(4, what);
    points.push_back({reader.integer(v[0], "the point number"), {v[1], v[2], v[3]}});
  }
  if (!reader.at_end()) reader.skip();
  return points;
}

/// Title, image size [px] and the project's camera.
struct Head {
  double width = 0, height = 0;
  std::vector<double> camera;
};

Head read_head(Reader& reader, const std::array<int, 2>& image_size) {
  reader.line("a title");
  auto head = reader.numbers(2, "tolerance, iterations, image width and height [px]");
  if (head.size() < 4 || !(head[2] > 0 && head[3] > 0)) {
    if (image_size[0] <= 0 || image_size[1] <= 0)
      reader.fail(
          "the second line has no image size, and marks are in pixels where the camera is in millimetres: say "
          "image_size=[WIDTH, HEIGHT] (in image_block: files.with.image_size=[WIDTH,HEIGHT])");
    head.resize(4);
    head[2] = image_size[0];
    head[3] = image_size[1];
  }
  reader.numbers(1, "default standard deviations");
  auto camera = reader.numbers(10, "the project's camera");
  camera.resize(10);
  reader.numbers(1, "its standard deviations");
  return {head[2], head[3], std::move(camera)};
}

/// Points of the block by their numbers in the file. Points found by matching ("smart points") are numbered from 1
/// again after the others, and their marks have no standard deviation.
struct PointNumbers {
  std::map<int, int> marked, smart;
};

/// Index of the first smart point: the second list begins where numbers last fell before the first repetition.
size_t first_smart(const std::vector<Listed>& points) {
  std::set<int> seen;
  size_t split = 0;
  while (split < points.size() && seen.insert(points[split].id).second) ++split;
  if (split < points.size())
    while (split > 1 && points[split - 1].id < points[split].id) --split;
  return split;
}

PointNumbers add_points(const std::vector<Listed>& control, const std::vector<Listed>& points, ReadBlock& result) {
  PointNumbers numbers;
  PointBlock& block = result.block;
  const size_t split = first_smart(points);
  for (size_t i = 0; i < points.size(); ++i) {
    auto& index = i < split ? numbers.marked : numbers.smart;
    if (!index.emplace(points[i].id, static_cast<int>(block.points.size())).second) {
      result.left_out.push_back("object point " + std::to_string(points[i].id) + ": listed a second time");
      continue;
    }
    block.points.push_back({(i < split ? "" : "s") + std::to_string(points[i].id), points[i].position});
  }
  for (const auto& point : control)
    if (numbers.marked.emplace(point.id, static_cast<int>(block.points.size())).second)
      block.points.push_back({std::to_string(point.id), point.position});
  return numbers;
}

/// Reads the marks. Gives how many there are of each point that the file does not list.
std::map<int, int> read_marks(Reader& reader, const PointNumbers& points, ReadBlock& result) {
  PointBlock& block = result.block;
  std::map<int, int> image_of, unknown;
  for (size_t i = 0; i < block.images.size(); ++i) image_of.emplace(block.images[i].id, static_cast<int>(i));
  std::set<std::pair<int, int>> pairs;
  while (!reader.at_end() && !reader.blank()) {
    const auto v = reader.numbers(4, "photo, point, x, y [px], standard deviations");
    ++result.measurements_read;
    const double sx = v.size() > 4 ? v[4] : 0, sy = v.size() > 5 ? v[5] : sx;
    const auto image = image_of.find(reader.integer(v[0], "the photo number"));
    const auto& index = sx == 0 && sy == 0 && !points.smart.empty() ? points.smart : points.marked;
    const auto point = index.find(reader.integer(v[1], "the point number"));
    if (image == image_of.end()) reader.fail("photo " + std::to_string(static_cast<int>(v[0])) + " is not in the file");
    if (point == index.end()) {
      ++unknown[static_cast<int>(v[1])];
      continue;
    }
    if (!pairs.emplace(image->second, point->second).second)
      reader.fail("point " + std::to_string(static_cast<int>(v[1])) + " is marked a second time in this photo");
    const SensorCamera& camera = block.cameras[block.images[image->second].camera];
    const double px = camera.sensor_width / camera.width, py = camera.sensor_height / camera.height;
    BlockMeasurement m;
    m.image = image->second;
    m.point = point->second;
    m.position = {v[2] * px, v[3] * py};
    m.sigma = 0.5 * (sx + sy) * std::sqrt(px * py);
    block.measurements.push_back(m);
  }
  return unknown;
}

void tell_unlisted(const std::map<int, int>& unknown, ReadBlock& result) {
  int lost = 0;
  std::vector<std::string> without_coordinates;
  for (const auto& [id, count] : unknown) lost += count, without_coordinates.push_back(std::to_string(id));
  if (lost == 0) return;
  result.left_out.push_back(number_of(lost, "mark") + " of " + number_of(unknown.size(), "point") +
                            " without coordinates in the export: " + few_of(without_coordinates));
  if (2 * lost > result.measurements_read) result.contradictions.push_back(result.left_out.back());
}

}  // namespace

ReadBlock read_photomodeler_export(const fs::path& file, const std::array<int, 2>& image_size) {
  Reader reader(file);
  ReadBlock result;
  PointBlock& block = result.block;
  const Head head = read_head(reader, image_size);
  read_photos(reader, head.camera, head.width, head.height, block);
  if (block.images.empty()) reader.fail("the export has no photo");
  if (!reader.at_end()) reader.skip();
  const auto control = read_points(reader, "control point, X, Y, Z");
  const auto points = read_points(reader, "object point, X, Y, Z");
  tell_unlisted(read_marks(reader, add_points(control, points, result), result), result);
  if (block.measurements.empty()) reader.fail("the export has no usable mark");
  require_image_size(block, file);
  return result;
}

bool looks_like_photomodeler(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  std::string line;
  if (!std::getline(stream, line)) return false;
  for (size_t count : {2, 9, 10, 10}) {
    line.clear();
    for (char c; line.size() < 400 && stream.get(c) && c != '\n';) line += c;
    const auto words = words_of(line.substr(0, line.find('\r')), false);
    if (words.size() < count || words.size() > count + 2) return false;
    for (const auto& word : words)
      if (!text::parse_number(word, '.')) return false;
  }
  return true;
}

}  // namespace plumbline::block
