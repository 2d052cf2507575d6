#include "block/photomodeler_files.hpp"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <map>
#include <set>
#include <sstream>
#include <stdexcept>

#include "block/aicon_files.hpp"
#include "block/bal_files.hpp"
#include "block/defects.hpp"
#include "text/text.hpp"

namespace plumbline::adjust {
namespace {

namespace fs = std::filesystem;

constexpr uintmax_t largest_file = 512u << 20;

std::vector<std::string> lines_of(const fs::path& file) {
  std::error_code error;
  if (const auto size = fs::file_size(file, error); error || size > largest_file)
    throw std::runtime_error(file.string() + (error ? ": cannot be read" : ": larger than 512 MB"));
  std::ifstream stream(file, std::ios::binary);
  if (!stream) throw std::runtime_error("cannot open " + file.string());
  std::ostringstream bytes;
  bytes << stream.rdbuf();
  std::vector<std::string> lines;
  std::string line;
  for (char c : bytes.str()) {
    if (c == '\n') {
      lines.push_back(std::move(line));
      line.clear();
    } else if (c != '\r') {
      line += c;
    }
  }
  if (!line.empty()) lines.push_back(std::move(line));
  return lines;
}

std::vector<std::string> words_of(const std::string& line, bool commas) {
  std::vector<std::string> words;
  std::string word;
  for (char c : line + " ")
    if (c == ' ' || c == '\t' || c == ';' || (commas && c == ',')) {
      if (!word.empty()) words.push_back(std::move(word));
      word.clear();
    } else {
      word += c;
    }
  return words;
}

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
      const auto value = formats::parse_number(word, '.');
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

/// Whether `words` are `values` as somebody prints them with fewer digits.
bool is_rounded(const std::vector<std::string>& words, const std::vector<double>& values) {
  if (words.size() < values.size()) return false;
  for (size_t i = 0; i < values.size(); ++i) {
    const auto value = formats::parse_number(words[i], '.');
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
    const auto number = formats::parse_number(first, '.');
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

int count_erased(std::vector<BlockMeasurement>& measurements, const std::vector<bool>& drop_point,
                 const std::vector<bool>& drop_image) {
  return static_cast<int>(std::erase_if(measurements, [&](const BlockMeasurement& m) {
    return drop_point[static_cast<size_t>(m.point)] || drop_image[static_cast<size_t>(m.image)];
  }));
}

std::string few_of(const std::vector<std::string>& names) {
  if (names.size() <= 5) return enumerate(names);
  return enumerate({names[0], names[1], names[2], std::to_string(names.size() - 3) + " more"});
}

/// Removes points and images without a measurement and numbers the others anew.
void compact(PointBlock& block, const std::vector<bool>& drop_point, const std::vector<bool>& drop_image) {
  std::vector<int> point(block.points.size(), -1), image(block.images.size(), -1);
  std::vector<BlockPoint> points;
  std::vector<BlockImage> images;
  for (size_t i = 0; i < point.size(); ++i)
    if (!drop_point[i]) {
      point[i] = static_cast<int>(points.size());
      points.push_back(block.points[i]);
    }
  for (size_t i = 0; i < image.size(); ++i)
    if (!drop_image[i]) {
      image[i] = static_cast<int>(images.size());
      images.push_back(block.images[i]);
    }
  block.points = std::move(points);
  block.images = std::move(images);
  for (auto& m : block.measurements) {
    m.point = point[static_cast<size_t>(m.point)];
    m.image = image[static_cast<size_t>(m.image)];
  }
  std::erase_if(block.scale_bars, [&](ScaleBar& bar) {
    bar.from = point[static_cast<size_t>(bar.from)];
    bar.to = point[static_cast<size_t>(bar.to)];
    return bar.from < 0 || bar.to < 0;
  });
  BlockControl& control = block.control;
  std::vector<Eigen::Index> rows;
  std::vector<int> kept;
  std::vector<bool> is_check;
  for (size_t k = 0; k < control.points.size(); ++k) {
    const int now = point[static_cast<size_t>(control.points[k])];
    if (now < 0) continue;
    kept.push_back(now);
    is_check.push_back(control.is_check[k]);
    for (Eigen::Index c = 0; c < 3; ++c) rows.push_back(3 * static_cast<Eigen::Index>(k) + c);
  }
  if (!control.points.empty()) {
    control.position = Eigen::VectorXd(control.position(rows));
    control.covariance = Eigen::MatrixXd(control.covariance(rows, rows));
  }
  control.points = kept;
  control.is_check = is_check;
}

}  // namespace

ReadBlock read_photomodeler_export(const fs::path& file, const std::array<int, 2>& image_size) {
  Reader reader(file);
  ReadBlock result;
  PointBlock& block = result.block;
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
  auto project_camera = reader.numbers(10, "the project's camera");
  project_camera.resize(10);
  reader.numbers(1, "its standard deviations");
  read_photos(reader, project_camera, head[2], head[3], block);
  if (block.images.empty()) reader.fail("the export has no photo");
  if (!reader.at_end()) reader.skip();
  const auto control = read_points(reader, "control point, X, Y, Z");
  const auto points = read_points(reader, "object point, X, Y, Z");
  // Points found by matching ("smart points") are numbered from 1 again after the others, and their marks have no
  // standard deviation.
  std::map<int, int> point_of, smart_of, image_of;
  size_t split = points.size();
  std::set<int> seen;
  for (size_t i = 0; i < points.size() && split == points.size(); ++i)
    if (!seen.insert(points[i].id).second) split = i;
  if (split < points.size()) {  // the second list begins where numbers last fell before the first repetition
    while (split > 1 && points[split - 1].id < points[split].id) --split;
  }
  for (size_t i = 0; i < points.size(); ++i) {
    auto& index = i < split ? point_of : smart_of;
    if (!index.emplace(points[i].id, static_cast<int>(block.points.size())).second) {
      result.left_out.push_back("object point " + std::to_string(points[i].id) + ": listed a second time");
      continue;
    }
    block.points.push_back({(i < split ? "" : "s") + std::to_string(points[i].id), points[i].position});
  }
  for (const auto& point : control)
    if (point_of.emplace(point.id, static_cast<int>(block.points.size())).second)
      block.points.push_back({std::to_string(point.id), point.position});
  for (size_t i = 0; i < block.images.size(); ++i) image_of.emplace(block.images[i].id, static_cast<int>(i));
  std::map<int, int> unknown;
  std::set<std::pair<int, int>> pairs;
  while (!reader.at_end() && !reader.blank()) {
    const auto v = reader.numbers(4, "photo, point, x, y [px], standard deviations");
    ++result.measurements_read;
    const double sx = v.size() > 4 ? v[4] : 0, sy = v.size() > 5 ? v[5] : sx;
    const auto image = image_of.find(reader.integer(v[0], "the photo number"));
    const auto& index = sx == 0 && sy == 0 && !smart_of.empty() ? smart_of : point_of;
    const auto point = index.find(reader.integer(v[1], "the point number"));
    if (image == image_of.end()) reader.fail("photo " + std::to_string(static_cast<int>(v[0])) + " is not in the file");
    if (point == index.end()) {
      ++unknown[static_cast<int>(v[1])];
      continue;
    }
    if (!pairs.emplace(image->second, point->second).second)
      reader.fail("point " + std::to_string(static_cast<int>(v[1])) + " is marked a second time in this photo");
    const SensorCamera& camera =
        block.cameras[static_cast<size_t>(block.images[static_cast<size_t>(image->second)].camera)];
    const double px = camera.sensor_width / camera.width, py = camera.sensor_height / camera.height;
    BlockMeasurement m;
    m.image = image->second;
    m.point = point->second;
    m.position = {v[2] * px, v[3] * py};
    m.sigma = 0.5 * (sx + sy) * std::sqrt(px * py);
    block.measurements.push_back(m);
  }
  for (const auto& [id, count] : unknown)
    result.left_out.push_back(std::to_string(count) + " marks of point " + std::to_string(id) +
                              ": it has no coordinates in the export");
  if (block.measurements.empty()) reader.fail("the export has no usable mark");
  return result;
}

void add_control(const fs::path& file, const std::vector<std::string>& check, ReadBlock& read) {
  PointBlock& block = read.block;
  std::map<std::string, int> index;
  for (size_t j = 0; j < block.points.size(); ++j) index.emplace(block.points[j].name, static_cast<int>(j));
  std::vector<Eigen::Vector3d> positions, sigmas;
  std::vector<std::string> unseen, checks = check;
  std::set<int> taken;
  const auto lines = lines_of(file);
  for (size_t i = 0; i < lines.size(); ++i) {
    const std::string text = lines[i].substr(0, lines[i].find('#'));
    const auto words = words_of(text, true);
    if (words.empty()) continue;
    const auto fail = [&](const std::string& what) {
      throw std::runtime_error(file.string() + ":" + std::to_string(i + 1) + ": " + what);
    };
    std::vector<double> numbers;  // from the right: coordinates and standard deviations
    for (auto w = words.rbegin(); w != words.rend() && numbers.size() < 7; ++w) {
      const auto value = formats::parse_number(*w, '.');
      if (!value) break;
      numbers.insert(numbers.begin(), *value);
    }
    // id [name] X Y Z [sx sy sz]: what is left of three or six numbers is id and name.
    size_t labels = 0;
    for (size_t l : {size_t{1}, size_t{2}})
      if (words.size() >= l + 3 && (words.size() - l == 3 || words.size() - l == 6 || words.size() - l == 4) &&
          numbers.size() >= words.size() - l)
        labels = labels == 0 || !formats::parse_number(words[1], '.') ? l : labels;
    if (labels == 0) fail("found '" + text + "', expected id, name, X, Y, Z and perhaps three standard deviations [m]");
    numbers.erase(numbers.begin(), numbers.end() - static_cast<long>(words.size() - labels));
    auto point = index.find(words[0]);
    if (point == index.end() && labels == 2) point = index.find(words[1]);
    const std::string shown = labels == 2 ? words[1] : words[0];
    const auto is_check =
        std::find_if(checks.begin(), checks.end(), [&](const std::string& c) { return c == words[0] || c == shown; });
    const bool to_check = is_check != checks.end();
    if (to_check) checks.erase(is_check);
    if (point == index.end()) {
      unseen.push_back(shown);
      continue;
    }
    if (!taken.insert(point->second).second) fail("point " + words[0] + " is listed a second time");
    Eigen::Vector3d sigma = Eigen::Vector3d::Zero();
    if (numbers.size() == 6) sigma = {numbers[3], numbers[4], numbers[5]};
    if (numbers.size() == 4) sigma.setConstant(numbers[3]);
    if (!(sigma.minCoeff() >= 0)) fail("a standard deviation is negative");
    block.control.points.push_back(point->second);
    block.control.is_check.push_back(to_check);
    positions.push_back({numbers[0], numbers[1], numbers[2]});
    sigmas.push_back(sigma);
  }
  if (positions.empty())
    throw std::runtime_error(file.string() + ": none of its points (" + few_of(unseen) +
                             ") is measured in the block, by number or by name");
  if (!checks.empty()) throw std::runtime_error(file.string() + ": holds no check point " + few_of(checks));
  if (!unseen.empty()) read.left_out.push_back("control " + few_of(unseen) + ": measured in no image");
  const Eigen::Index size = 3 * static_cast<Eigen::Index>(positions.size());
  block.control.position.resize(size);
  block.control.covariance = Eigen::MatrixXd::Zero(size, size);
  for (size_t k = 0; k < positions.size(); ++k) {
    block.control.position.segment<3>(3 * static_cast<Eigen::Index>(k)) = positions[k];
    block.control.covariance.diagonal().segment<3>(3 * static_cast<Eigen::Index>(k)) = sigmas[k].cwiseAbs2();
  }
}

void drop_unusable(ReadBlock& read) {
  PointBlock& block = read.block;
  std::vector<bool> known(block.points.size()), drop_point(block.points.size()), drop_image(block.images.size());
  for (size_t k = 0; k < block.control.points.size(); ++k)
    known[static_cast<size_t>(block.control.points[k])] = !block.control.is_check[k];
  std::vector<std::string> single, unmarked, poor;
  for (bool changed = true; changed;) {
    changed = false;
    std::vector<int> rays(block.points.size()), ties(block.images.size());
    for (const auto& m : block.measurements) ++rays[static_cast<size_t>(m.point)];
    for (const auto& m : block.measurements) {
      const size_t j = static_cast<size_t>(m.point);
      if (rays[j] >= 2 || known[j]) ties[static_cast<size_t>(m.image)] += known[j] || rays[j] > 2 ? 2 : 1;
    }
    for (size_t j = 0; j < rays.size(); ++j)
      if (!drop_point[j] && rays[j] < (known[j] ? 1 : 2)) {
        drop_point[j] = changed = true;
        (rays[j] == 0 ? unmarked : single).push_back(block.points[j].name);
      }
    // A point that two other images place fixes both coordinates of its mark; one that a single other image sees has
    // its distance still open and fixes one. A pose takes six.
    for (size_t i = 0; i < ties.size(); ++i)
      if (!drop_image[i] && ties[i] < 6) {
        drop_image[i] = changed = true;
        poor.push_back(std::to_string(block.images[i].id));
      }
    count_erased(block.measurements, drop_point, drop_image);
  }
  if (!single.empty())
    read.left_out.push_back(std::to_string(single.size()) + " points measured in one image only: " + few_of(single));
  if (!unmarked.empty())
    read.left_out.push_back(std::to_string(unmarked.size()) + " points measured in no image: " + few_of(unmarked));
  if (!poor.empty())
    read.left_out.push_back(std::to_string(poor.size()) +
                            " images that too few points tie to the others: " + few_of(poor));
  compact(block, drop_point, drop_image);
}

namespace {

/// Whether a text begins as an export does, whatever it is called: a title, then lines of numbers.
bool looks_like_export(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  std::string line;
  if (!std::getline(stream, line)) return false;
  for (size_t count : {2, 9, 10, 10}) {
    line.clear();
    for (char c; line.size() < 400 && stream.get(c) && c != '\n';) line += c;
    const auto words = words_of(line.substr(0, line.find('\r')), false);
    if (words.size() < count || words.size() > count + 2) return false;
    for (const auto& word : words)
      if (!formats::parse_number(word, '.')) return false;
  }
  return true;
}

enum class Format { aicon, photomodeler, bal };
struct Found {
  fs::path path;  ///< file, or the folder of an AICON block
  Format format;
};

/// All blocks in a folder and below, by path.
std::vector<Found> blocks_in(const fs::path& folder) {
  std::vector<Found> found;
  for (const auto& entry : fs::recursive_directory_iterator(folder, fs::directory_options::skip_permission_denied)) {
    if (!entry.is_regular_file()) continue;
    const fs::path& path = entry.path();
    const std::string name = path.filename().string();
    if (path.extension() == ".phc")
      found.push_back({path.parent_path(), Format::aicon});
    else if (path.extension() == ".txt" && name.find("pmexport") != std::string::npos)
      found.push_back({path, Format::photomodeler});
    else if (path.extension() == ".txt" && looks_like_export(path))
      found.push_back({path, Format::photomodeler});
    else if ((path.extension() == ".txt" || path.extension() == ".bal") && looks_like_bal(path))
      found.push_back({path, Format::bal});
  }
  std::sort(found.begin(), found.end(), [](const Found& a, const Found& b) { return a.path < b.path; });
  return found;
}

}  // namespace

ReadBlock read_image_block(const fs::path& folder, const std::string& project, const std::string& control,
                           const std::vector<std::string>& check, const std::array<int, 2>& image_size) {
  if (!fs::is_directory(folder)) throw std::runtime_error(folder.string() + " is not a folder");
  std::vector<Found> found = blocks_in(folder);
  std::vector<std::string> names;
  for (const auto& block : found) names.push_back(fs::relative(block.path, folder).string());
  if (!project.empty())
    std::erase_if(found, [&](const Found& block) {
      return block.path.filename().string().rfind(project, 0) != 0 &&
             fs::relative(block.path, folder).string().rfind(project, 0) != 0;
    });
  if (found.size() != 1)
    throw std::runtime_error(
        folder.string() + (names.empty()
                               ? " holds no AICON block (.phc, .obc, .eor, .ior), no PhotoModeler text export "
                                 "(*pmexport*.txt) and no bundle adjustment problem (BAL)"
                               : " holds " + std::to_string(names.size()) + " blocks (" + few_of(names) + ")" +
                                     (project.empty() ? ": choose one with project=BEGINNING_OF_ITS_NAME"
                                                      : ", and project=" + project + " does not choose one of them")));
  ReadBlock read;
  const fs::path& path = found[0].path;
  if (found[0].format == Format::aicon) {
    AiconBlock block = read_aicon_folder(path);
    read = {std::move(block.block), block.measurements_read, std::move(block.left_out)};
  } else {
    read = found[0].format == Format::bal ? read_bal_file(path, bal_pixel_pitch)
                                          : read_photomodeler_export(path, image_size);
  }
  if (!control.empty()) {
    const fs::path inside = folder / control, beside = path.parent_path() / control;
    const fs::path file = fs::is_regular_file(inside)   ? inside
                          : fs::is_regular_file(beside) ? beside
                                                        : fs::path(control);
    add_control(file, check, read);
  } else if (!check.empty()) {
    throw std::runtime_error("check points need a list of coordinates: control=FILE");
  }
  drop_unusable(read);
  return read;
}

}  // namespace plumbline::adjust
