#include "photo/block/bal_files.hpp"

#include <fmt/core.h>

#include <Eigen/LU>
#include <charconv>
#include <cmath>
#include <fstream>
#include <set>
#include <stdexcept>

#include "base/text/whole_file.hpp"
#include "plumbline/rigid_transform.hpp"
#include "plumbline/stop.hpp"

namespace plumbline::block {
namespace {

namespace fs = std::filesystem;

constexpr uintmax_t largest_file = 2048u << 20;

std::string content_of(const fs::path& file) {
  std::error_code error;
  if (const auto size = fs::file_size(file, error); error || size > largest_file)
    throw std::runtime_error(file.string() + (error ? ": cannot be read" : ": larger than 2 GB"));
  return text::read_whole(file);
}

/// Numbers separated by blanks and line ends.
class Numbers {
 public:
  Numbers(std::string name, const std::string& text)
      : name_(std::move(name)), next_(text.data()), end_(text.data() + text.size()) {
    if (text.starts_with("\xEF\xBB\xBF")) next_ += 3;  // an editor's mark
  }
  [[noreturn]] void fail(const std::string& what) const {
    throw std::runtime_error(name_ + ":" + std::to_string(line_) + ": " + what);
  }
  template <typename Number>
  Number read(const char* expected) {
    if (at_end()) fail(std::string("the file ends, expected ") + expected);
    if (*next_ == '+') ++next_;
    Number value{};
    const auto [after, error] = std::from_chars(next_, end_, value);
    if (error != std::errc() || (after<end_&& * after> ' ') || !std::isfinite(static_cast<double>(value))) {
      const char* word_end = next_;
      while (word_end<end_&& * word_end> ' ' && word_end < next_ + 40) ++word_end;
      fail("found '" + std::string(next_, word_end) + "', expected " + expected);
    }
    next_ = after;
    return value;
  }
  int index(size_t count, const char* expected) {
    const auto value = read<int64_t>(expected);
    if (value < 0 || static_cast<size_t>(value) >= count)
      fail(std::to_string(value) + " is no " + expected + ": the file has " + std::to_string(count));
    return static_cast<int>(value);
  }
  /// Whether only blanks and line ends are left, which it steps over.
  bool at_end() {
    while (next_ < end_ && (*next_ == ' ' || *next_ == '\t' || *next_ == '\r' || *next_ == '\n'))
      line_ += *next_++ == '\n';
    return next_ == end_;
  }
  size_t bytes_left() const { return static_cast<size_t>(end_ - next_); }

 private:
  std::string name_;
  const char* next_;
  const char* end_;
  int line_ = 1;
};

/// What a problem of this kind knows of a camera.
struct BalCamera {
  double f = 0, k1 = 0, k2 = 0;  ///< f [mm]
  bool exact = true;             ///< else coordinates are to be reduced
};

BalCamera bal_camera(const SensorCamera& camera) {
  const auto& v = camera.values;
  BalCamera result;
  if (camera.lens == bundle::Lens::correcting) {
    result.f = v[0];
    result.exact = false;
    return result;
  }
  const double b2 = camera.balance_radius * camera.balance_radius, scale = 1 - v[3] * b2 - v[4] * b2 * b2;
  for (size_t k = 5; k < v.size(); ++k) result.exact = result.exact && v[k] == 0;
  result.f = -v[0];
  if (!result.exact) return result;
  result.f *= scale;
  result.k1 = v[3] * v[0] * v[0] / scale;
  result.k2 = v[4] * std::pow(v[0], 4) / scale;
  return result;
}

/// Where an ideal camera of the same principal distance would have measured, from its principal point, y up [mm].
Eigen::Vector2d ideal_coordinates(const SensorCamera& camera, const Eigen::Vector2d& measured) {
  bundle::LensRows rows;
  const double* values = camera.values.data();
  if (camera.lens == bundle::Lens::correcting) {  // its misclosure on the axis is the corrected coordinate, negative
    bundle::evaluate_lens(camera.lens, values, 0, 0, -Eigen::Vector3d::UnitZ(), measured, false, rows);
    return -rows.misclosure;
  }
  Eigen::Vector3d ray((measured.x() - values[1]) / values[0], (measured.y() - values[2]) / values[0], 1);
  ray *= -1;  // the scene is at negative z
  for (int step = 0; step < 50; ++step) {
    if (!bundle::evaluate_lens(camera.lens, values, camera.balance_radius, 0, ray, measured, true, rows)) break;
    if (rows.misclosure.norm() < 1e-13 * std::abs(values[0])) return values[0] * ray.head<2>() / ray.z();
    ray.head<2>() -= rows.by_direction.leftCols<2>().inverse() * rows.misclosure;
    if (!ray.allFinite()) break;
  }
  throw std::runtime_error("the lens of camera " + std::to_string(camera.id) + " cannot have produced (" +
                           std::to_string(measured.x()) + ", " + std::to_string(measured.y()) +
                           ") mm: its distortion cannot be inverted there");
}

double pitch_of(const SensorCamera& camera) {
  return camera.width > 0 && camera.sensor_width > 0 ? camera.sensor_width / camera.width : bal_pixel_pitch;
}

/// What the first line of a problem announces.
struct BalCounts {
  int64_t images = 0, points = 0, observations = 0;
  std::string words() const {
    return std::to_string(images) + " cameras, " + std::to_string(points) + " points and " +
           std::to_string(observations) + " observations";
  }
};

BalCounts read_counts(Numbers& numbers) {
  BalCounts counts;
  counts.images = numbers.read<int64_t>("the number of cameras");
  counts.points = numbers.read<int64_t>("the number of points");
  counts.observations = numbers.read<int64_t>("the number of observations");
  // The shortest number with its separator has two bytes.
  const double least = 2.0 * (9.0 * static_cast<double>(counts.images) + 3.0 * static_cast<double>(counts.points) +
                              4.0 * static_cast<double>(counts.observations)) -
                       1;
  if (counts.images < 1 || counts.points < 1 || counts.observations < 1 ||
      least > static_cast<double>(numbers.bytes_left()))
    numbers.fail("the file begins with " + counts.words() + ", and is too short for them");
  return counts;
}

/// Of a point that was measured before in the same image the first one counts. Gives the largest coordinates [mm].
Eigen::Vector2d read_measurements(Numbers& numbers, const BalCounts& counts, double pixel_pitch, ReadBlock& result) {
  int twice = 0;
  Eigen::Vector2d extent = Eigen::Vector2d::Zero();
  std::set<std::pair<int, int>> seen;
  for (int64_t k = 0; k < counts.observations; ++k) {
    stop_point();
    BlockMeasurement m;
    m.image = numbers.index(static_cast<size_t>(counts.images), "number of a camera");
    m.point = numbers.index(static_cast<size_t>(counts.points), "number of a point");
    m.position.x() = pixel_pitch * numbers.read<double>("x [px]");
    m.position.y() = pixel_pitch * numbers.read<double>("y [px]");
    m.sigma = pixel_pitch;
    extent = extent.cwiseMax(m.position.cwiseAbs());
    if (seen.emplace(m.image, m.point).second)
      result.block.measurements.push_back(m);
    else
      ++twice;
  }
  result.measurements_read = static_cast<int>(counts.observations);
  if (twice > 0)
    result.left_out.push_back(std::to_string(twice) + " measurements: of a point measured before in the same image");
  return extent;
}

/// Adds camera and image `i`, whose sensor holds `extent` [mm] around its middle. Gives the turn into the camera.
Eigen::Matrix3d read_image(Numbers& numbers, int i, double pixel_pitch, const Eigen::Vector2d& extent,
                           PointBlock& block) {
  double v[9];
  for (double& value : v) value = numbers.read<double>("rotation, translation, f, k1, k2 of a camera");
  if (!(v[6] > 0))
    numbers.fail("the principal distance of camera " + std::to_string(i) +
                 " is not positive: are the counts of the first line those of the file?");
  SensorCamera camera;
  camera.id = i;
  const double f = v[6] * pixel_pitch;
  camera.values = {-f, 0, 0, v[7] / (f * f), v[8] / (f * f * f * f)};
  camera.estimated = {"Ck", "A1", "A2"};
  camera.width = 2 * static_cast<int>(std::ceil(extent.x() / pixel_pitch));
  camera.height = 2 * static_cast<int>(std::ceil(extent.y() / pixel_pitch));
  camera.sensor_width = camera.width * pixel_pitch;
  camera.sensor_height = camera.height * pixel_pitch;
  block.cameras.push_back(camera);
  const Eigen::Matrix3d turn = quaternion_from_rotation_vector({v[0], v[1], v[2]}).toRotationMatrix();
  block.images.push_back(
      {i, i, -(turn.transpose() * Eigen::Vector3d(v[3], v[4], v[5])), angles_from_rotation(turn.transpose())});
  return turn;
}

void leave_out_behind(const std::vector<Eigen::Matrix3d>& turns, ReadBlock& result) {
  PointBlock& block = result.block;
  const auto behind = std::erase_if(block.measurements, [&](const BlockMeasurement& m) {
    stop_point();
    const size_t i = static_cast<size_t>(m.image);
    const Eigen::Vector3d v = turns[i] * (block.points[m.point].position - block.images[i].centre);
    return !(v.z() < -1e-6 * v.norm());
  });
  if (behind > 0)
    result.left_out.push_back(std::to_string(behind) +
                              " measurements: their points lie behind the camera by the approximate values");
}

}  // namespace

bool looks_like_bal(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  std::string start(4096, '\0');
  stream.read(start.data(), static_cast<std::streamsize>(start.size()));
  start.resize(stream.gcount());
  start = start.substr(0, start.find_last_of(" \t\r\n") + 1);
  try {
    Numbers numbers("", start);
    const auto cameras = numbers.read<int64_t>(""), points = numbers.read<int64_t>(""),
               observations = numbers.read<int64_t>("");
    numbers.index(static_cast<size_t>(cameras), "");
    numbers.index(static_cast<size_t>(points), "");
    numbers.read<double>(""), numbers.read<double>("");
    return cameras > 0 && points > 0 && observations > 0;
  } catch (const std::runtime_error&) {
    return false;
  }
}

ReadBlock read_bal_file(const fs::path& file, double pixel_pitch) {
  const std::string text = content_of(file);
  Numbers numbers(file.string(), text);
  const BalCounts counts = read_counts(numbers);
  ReadBlock result;
  const Eigen::Vector2d extent = read_measurements(numbers, counts, pixel_pitch, result);
  std::vector<Eigen::Matrix3d> turns;
  for (int64_t i = 0; i < counts.images; ++i)
    turns.push_back(read_image(numbers, static_cast<int>(i), pixel_pitch, extent, result.block));
  for (int64_t j = 0; j < counts.points; ++j) {
    stop_point();
    Eigen::Vector3d p;
    for (int c = 0; c < 3; ++c) p(c) = numbers.read<double>("coordinates of a point");
    result.block.points.push_back({std::to_string(j), p});
  }
  if (!numbers.at_end())
    numbers.fail("the file goes on behind its last point: the counts of its first line (" + counts.words() +
                 ") are too small, and what was read is not what was meant");
  leave_out_behind(turns, result);
  return result;
}

std::string bal_text(const PointBlock& block, std::vector<std::string>& notes) {
  std::string text;
  std::vector<BalCamera> cameras;
  int reduced = 0;
  for (const auto& camera : block.cameras) {
    cameras.push_back(bal_camera(camera));
    reduced += !cameras.back().exact;
    if (!(cameras.back().f > 0))
      throw std::runtime_error("camera " + std::to_string(camera.id) + " has no positive principal distance");
  }
  if (reduced > 0)
    notes.push_back(std::to_string(reduced) + " of " + std::to_string(cameras.size()) +
                    " cameras have a lens that the format does not know: their measurements are reduced to ideal "
                    "images, and k1 and k2 are 0");
  if (!block.control.points.empty() || !block.scale_bars.empty())
    notes.push_back("control points and scale bars have no place in the format");
  text += fmt::format("{} {} {}\n", block.images.size(), block.points.size(), block.measurements.size());
  for (const auto& m : block.measurements) {
    const size_t c = static_cast<size_t>(block.images[m.image].camera);
    const SensorCamera& camera = block.cameras[c];
    const Eigen::Vector2d at = cameras[c].exact
                                   ? Eigen::Vector2d(m.position - Eigen::Vector2d(camera.values[1], camera.values[2]))
                                   : ideal_coordinates(camera, m.position);
    text +=
        fmt::format("{} {} {:.17g} {:.17g}\n", m.image, m.point, at.x() / pitch_of(camera), at.y() / pitch_of(camera));
  }
  for (const auto& image : block.images) {
    const BalCamera& camera = cameras[image.camera];
    const Eigen::Matrix3d turn = rotation_from_angles(image.angles).transpose();
    const Eigen::AngleAxisd axis(turn);
    const Eigen::Vector3d r = axis.angle() * axis.axis(), t = -(turn * image.centre);
    for (double value : {r.x(), r.y(), r.z(), t.x(), t.y(), t.z(), camera.f / pitch_of(block.cameras[image.camera]),
                         camera.k1, camera.k2})
      text += fmt::format("{:.17g}\n", value);
  }
  for (const auto& point : block.points)
    for (int c = 0; c < 3; ++c) text += fmt::format("{:.17g}\n", point.position(c));
  return text;
}

}  // namespace plumbline::block
