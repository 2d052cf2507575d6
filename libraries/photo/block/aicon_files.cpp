#include "photo/block/aicon_files.hpp"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <map>
#include <sstream>
#include <stdexcept>

namespace plumbline::block {
namespace {

constexpr double metres_per_millimetre = 1e-3;

/// One non-empty line, split at blanks; double quotes hold a word together.
struct Line {
  const std::string* file = nullptr;
  int number = 0;
  std::vector<std::string> words;

  [[noreturn]] void fail(const std::string& what) const {
    throw std::runtime_error(*file + ":" + std::to_string(number) + ": " + what);
  }
  void require(size_t count, const char* columns) const {
    if (words.size() < count)
      fail("found " + std::to_string(words.size()) + " columns, expected at least " + std::to_string(count) + ": " +
           columns);
  }
  double real(size_t column) const {
    const std::string& word = words[column];
    size_t used = 0;
    double value = 0;
    try {
      value = std::stod(word, &used);
    } catch (const std::exception&) {
      used = 0;
    }
    if (used != word.size() || !std::isfinite(value))
      fail("column " + std::to_string(column + 1) + " is '" + word + "', expected a number");
    return value;
  }
  int integer(size_t column) const {
    const double value = real(column);
    if (value != std::floor(value) || std::abs(value) > 2e9)
      fail("column " + std::to_string(column + 1) + " is '" + words[column] + "', expected an integer");
    return static_cast<int>(value);
  }
  Eigen::Vector3d vector(size_t column) const { return {real(column), real(column + 1), real(column + 2)}; }
};

struct File {
  std::string name;
  std::vector<Line> lines;
};

std::vector<std::string> split_words(const std::string& text) {
  std::vector<std::string> words;
  std::string word;
  bool quoted = false, open = false;
  for (char c : text) {
    if (c == '"') {
      quoted = !quoted;
      open = true;
    } else if (!quoted && std::isspace(static_cast<unsigned char>(c))) {
      if (open) words.push_back(word);
      word.clear();
      open = false;
    } else {
      word += c;
      open = true;
    }
  }
  if (open) words.push_back(word);
  return words;
}

File read_lines(const std::filesystem::path& path) {
  std::ifstream stream(path);
  if (!stream) throw std::runtime_error("cannot read " + path.string());
  File file;
  file.name = path.string();
  std::string text;
  for (int number = 1; std::getline(stream, text); ++number) {
    Line line;
    line.number = number;
    line.words = split_words(text);
    if (!line.words.empty()) file.lines.push_back(std::move(line));
  }
  if (stream.bad()) throw std::runtime_error("reading " + path.string() + " failed");
  return file;
}

/// The single file of `folder` with this extension; empty if there is none and it is optional.
std::filesystem::path find_file(const std::filesystem::path& folder, const std::string& extension, bool optional) {
  std::vector<std::filesystem::path> found;
  for (const auto& entry : std::filesystem::directory_iterator(folder))
    if (entry.is_regular_file() && entry.path().extension() == extension) found.push_back(entry.path());
  std::sort(found.begin(), found.end());
  if (found.size() > 1)
    throw std::runtime_error(folder.string() + " holds " + std::to_string(found.size()) + " *" + extension +
                             " files (" + found[0].filename().string() + ", " + found[1].filename().string() +
                             "), expected one");
  if (found.empty() && !optional)
    throw std::runtime_error(folder.string() + " holds no *" + extension +
                             " file; an AICON block needs .phc, .obc, .eor and .ior");
  return found.empty() ? std::filesystem::path() : found[0];
}

using Index = std::map<int, int>;  ///< id in the files → index in the block

void add_id(Index& index, int id, int position, const Line& line, const char* what) {
  if (!index.emplace(id, position).second)
    line.fail(std::string(what) + " " + std::to_string(id) + " occurs a second time");
}

int find_id(const Index& index, int id, const Line& line, const std::string& what) {
  const auto at = index.find(id);
  if (at == index.end()) line.fail(what);
  return at->second;
}

/// Five lines a camera: id, unused, Ck, xh, yh, A1, A2, R0 / A3 / B1, B2 / C1, C2 / sensor width, height [mm], width,
/// height [px].
Index read_cameras(File file, PointBlock& block) {
  constexpr size_t lines_per_camera = 5;
  Index index;
  for (auto& line : file.lines) line.file = &file.name;
  for (size_t first = 0; first < file.lines.size(); first += lines_per_camera) {
    const Line& head = file.lines[first];
    if (first + lines_per_camera > file.lines.size())
      head.fail("the camera that begins here has " + std::to_string(file.lines.size() - first) + " lines, expected 5");
    head.require(8, "camera, -999, Ck, xh, yh, A1, A2, R0");
    file.lines[first + 1].require(1, "A3");
    file.lines[first + 2].require(2, "B1, B2");
    file.lines[first + 3].require(2, "C1, C2");
    file.lines[first + 4].require(4, "sensor width and height [mm], width and height [px]");
    SensorCamera camera;
    camera.id = head.integer(0);
    camera.values = {head.real(2),
                     head.real(3),
                     head.real(4),
                     head.real(5),
                     head.real(6),
                     file.lines[first + 1].real(0),
                     file.lines[first + 2].real(0),
                     file.lines[first + 2].real(1),
                     file.lines[first + 3].real(0),
                     file.lines[first + 3].real(1)};
    camera.balance_radius = head.real(7);
    if (!(camera.values[0] < 0)) head.fail("Ck is " + head.words[2] + ", expected a negative principal distance [mm]");
    const Line& sensor = file.lines[first + 4];
    camera.sensor_width = sensor.real(0);
    camera.sensor_height = sensor.real(1);
    camera.width = sensor.integer(2);
    camera.height = sensor.integer(3);
    add_id(index, camera.id, static_cast<int>(block.cameras.size()), head, "camera");
    block.cameras.push_back(camera);
  }
  return index;
}

Index read_images(File file, const Index& cameras, PointBlock& block) {
  Index index;
  for (auto& line : file.lines) {
    line.file = &file.name;
    line.require(8, "image, camera, X, Y, Z [mm], omega, phi, kappa [rad]");
    BlockImage image;
    image.id = line.integer(0);
    image.camera = find_id(cameras, line.integer(1), line, "camera " + line.words[1] + " is not in the .ior file");
    image.centre = metres_per_millimetre * line.vector(2);
    image.angles = line.vector(5);
    add_id(index, image.id, static_cast<int>(block.images.size()), line, "image");
    block.images.push_back(image);
  }
  return index;
}

Index read_points(File file, PointBlock& block, Index& switched_off) {
  Index index;
  for (auto& line : file.lines) {
    line.file = &file.name;
    line.require(9, "point, X, Y, Z, sigma X, Y, Z [mm], rays, 1 if it is to be used");
    BlockPoint point;
    const int id = line.integer(0);
    point.name = std::to_string(id);
    point.position = metres_per_millimetre * line.vector(1);
    if (line.integer(8) == 0) {
      add_id(switched_off, id, 0, line, "point");
      continue;
    }
    add_id(index, id, static_cast<int>(block.points.size()), line, "point");
    block.points.push_back(point);
  }
  return index;
}

void read_measurements(File file, const Index& images, const Index& points, const Index& switched_off,
                       AiconBlock& result) {
  std::map<int, int> unknown_points, off_points, unknown_images;
  int off = 0;
  std::map<std::pair<int, int>, int> first_line;
  for (auto& line : file.lines) {
    line.file = &file.name;
    line.require(10, "image, point, x, y, sigma x, y, residual x, y [mm], 1, 1 if it is to be used");
    ++result.measurements_read;
    const int image = line.integer(0), point = line.integer(1);
    const Eigen::Vector2d position(line.real(2), line.real(3));
    if (line.integer(9) == 0) {
      ++off;
    } else if (switched_off.count(point)) {
      ++off_points[point];
    } else if (!points.count(point)) {
      ++unknown_points[point];
    } else if (!images.count(image)) {
      ++unknown_images[image];
    } else {
      const auto [at, is_new] = first_line.emplace(std::make_pair(image, point), line.number);
      if (!is_new)
        line.fail("point " + line.words[1] + " is measured a second time in image " + line.words[0] +
                  ", first in line " + std::to_string(at->second));
      result.block.measurements.push_back({images.at(image), points.at(point), position});
    }
  }
  if (off > 0) result.left_out.push_back(std::to_string(off) + " measurements: switched off");
  const auto report = [&](const std::map<int, int>& counts, const std::string& what, const std::string& why) {
    for (const auto& [id, count] : counts)
      result.left_out.push_back(std::to_string(count) + " measurements " + what + " " + std::to_string(id) + ": " +
                                why);
  };
  report(off_points, "of point", "the point is switched off");
  report(unknown_points, "of point", "no approximate coordinates in the .obc file");
  report(unknown_images, "in image", "no approximate orientation in the .eor file");
}

void read_scale_bars(File file, const Index& points, AiconBlock& result) {
  for (auto& line : file.lines) {
    line.file = &file.name;
    line.require(7, "number, name, point, point, length, sigma [mm], 1 if it is to be used");
    if (line.integer(6) == 0) {
      result.left_out.push_back("scale bar '" + line.words[1] + "': switched off");
      continue;
    }
    ScaleBar bar;
    bar.name = line.words[1];
    for (size_t column : {2u, 3u}) {
      const int at = find_id(
          points, line.integer(column), line,
          "point " + line.words[column] + " of scale bar '" + bar.name + "' is not in the .obc file or switched off");
      (column == 2 ? bar.from : bar.to) = at;
    }
    bar.length = metres_per_millimetre * line.real(4);
    bar.sigma = metres_per_millimetre * line.real(5);
    if (!(bar.length > 0) || !(bar.sigma > 0)) line.fail("length and sigma of a scale bar must be positive");
    if (bar.from == bar.to) line.fail("scale bar '" + bar.name + "' runs from a point to itself");
    const auto is_same = [&](const ScaleBar& other) {
      return std::minmax(bar.from, bar.to) == std::minmax(other.from, other.to) && bar.length == other.length &&
             bar.sigma == other.sigma;
    };
    if (std::any_of(result.block.scale_bars.begin(), result.block.scale_bars.end(), is_same))
      line.fail("scale bar '" + bar.name + "' stands here a second time, with the same points, length and sigma: it " +
                "would count twice; take one of the lines out");
    result.block.scale_bars.push_back(bar);
  }
}

}  // namespace

AiconBlock read_aicon_folder(const std::filesystem::path& folder) {
  if (!std::filesystem::is_directory(folder)) throw std::runtime_error(folder.string() + " is not a folder");
  AiconBlock result;
  const Index cameras = read_cameras(read_lines(find_file(folder, ".ior", false)), result.block);
  const Index images = read_images(read_lines(find_file(folder, ".eor", false)), cameras, result.block);
  Index switched_off;
  const Index points = read_points(read_lines(find_file(folder, ".obc", false)), result.block, switched_off);
  read_measurements(read_lines(find_file(folder, ".phc", false)), images, points, switched_off, result);
  const auto scale = find_file(folder, ".scale", true);
  if (!scale.empty()) read_scale_bars(read_lines(scale), points, result);
  if (result.block.measurements.empty())
    throw std::runtime_error(folder.string() + " holds no usable image measurement");
  return result;
}

}  // namespace plumbline::block
