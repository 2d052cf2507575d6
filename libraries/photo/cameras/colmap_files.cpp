#include "photo/cameras/colmap_files.hpp"

#include <bit>
#include <charconv>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <stdexcept>

#include "base/text/whole_file.hpp"

namespace plumbline::cameras {
namespace {

namespace fs = std::filesystem;
static_assert(std::endian::native == std::endian::little, "COLMAP's binary files are little endian");

struct Model {
  int number;
  const char* name;
  size_t parameters;
};

constexpr std::array<Model, 11> models = {{{0, "SIMPLE_PINHOLE", 3},
                                           {1, "PINHOLE", 4},
                                           {2, "SIMPLE_RADIAL", 4},
                                           {3, "RADIAL", 5},
                                           {4, "OPENCV", 8},
                                           {5, "OPENCV_FISHEYE", 8},
                                           {6, "FULL_OPENCV", 12},
                                           {7, "FOV", 5},
                                           {8, "SIMPLE_RADIAL_FISHEYE", 4},
                                           {9, "RADIAL_FISHEYE", 5},
                                           {10, "THIN_PRISM_FISHEYE", 12}}};

constexpr const char* representable =
    "run COLMAP with --ImageReader.camera_model OPENCV, or give the model that colmap image_undistorter writes, with "
    "points measured in its photographs";

ColmapCamera camera_of(std::uint32_t id, const std::string& model, int width, int height, const std::vector<double>& p,
                       const std::string& where) {
  ColmapCamera c;
  c.id = id, c.model = model;
  BrownCamera& b = c.camera;
  b.width = width, b.height = height;
  const auto need = [&](size_t n) {
    if (p.size() != n)
      throw std::runtime_error(where + ": camera " + std::to_string(id) + " is " + model + " with " +
                               std::to_string(p.size()) + " parameters, expected " + std::to_string(n));
  };
  const auto single = [&](size_t n) { need(n), b.fx = b.fy = p[0], b.cx = p[1], b.cy = p[2]; };
  const auto two = [&](size_t n) { need(n), b.fx = p[0], b.fy = p[1], b.cx = p[2], b.cy = p[3]; };
  if (model == "SIMPLE_PINHOLE") {
    single(3);
  } else if (model == "SIMPLE_RADIAL") {
    single(4), b.k1 = p[3];
  } else if (model == "RADIAL") {
    single(5), b.k1 = p[3], b.k2 = p[4];
  } else if (model == "PINHOLE") {
    two(4);
  } else if (model == "OPENCV") {
    two(8), b.k1 = p[4], b.k2 = p[5], b.p1 = p[6], b.p2 = p[7];
  } else if (model == "FULL_OPENCV") {
    two(12), b.k1 = p[4], b.k2 = p[5], b.p1 = p[6], b.p2 = p[7], b.k3 = p[8];
    if (std::abs(p[9]) + std::abs(p[10]) + std::abs(p[11]) > 1e-12)
      throw std::runtime_error(where + ": camera " + std::to_string(id) +
                               " has the rational terms k4 to k6, which Brown's model has "
                               "not; " +
                               representable);
  } else if (model == "SIMPLE_RADIAL_FISHEYE") {
    single(4), b.lens = LensModel::fisheye, b.k1 = p[3];
  } else if (model == "RADIAL_FISHEYE") {
    single(5), b.lens = LensModel::fisheye, b.k1 = p[3], b.k2 = p[4];
  } else if (model == "OPENCV_FISHEYE") {
    two(8), b.lens = LensModel::fisheye, b.k1 = p[4], b.k2 = p[5], b.k3 = p[6], b.k4 = p[7];
  } else {
    throw std::runtime_error(where + ": camera " + std::to_string(id) + " is " + model +
                             "; known are SIMPLE_PINHOLE, PINHOLE, SIMPLE_RADIAL, RADIAL, OPENCV, FULL_OPENCV, "
                             "SIMPLE_RADIAL_FISHEYE, RADIAL_FISHEYE and OPENCV_FISHEYE; " +
                             representable);
  }
  b.cx -= 0.5, b.cy -= 0.5;
  if (!(b.fx > 0 && b.fy > 0))
    throw std::runtime_error(where + ": camera " + std::to_string(id) + " has no positive focal length");
  return c;
}

/// Values of a binary file, checked against its end.
class Binary {
 public:
  explicit Binary(const fs::path& path) : name_(path.string()), bytes_(text::read_whole(path)) {}
  template <typename T>
  T next() {
    T value;
    if (bytes_.size() - at_ < sizeof(T)) fail("ends");
    std::memcpy(&value, bytes_.data() + at_, sizeof(T));
    at_ += sizeof(T);
    return value;
  }
  std::string text() {
    const size_t end = bytes_.find('\0', at_);
    if (end == std::string::npos) fail("has a name without an end");
    std::string result = bytes_.substr(at_, end - at_);
    at_ = end + 1;
    return result;
  }
  /// A number of items that take at least `bytes` each: a wrong one must not ask for memory.
  std::uint64_t items(size_t bytes) {
    const auto count = next<std::uint64_t>();
    if (count > (bytes_.size() - at_) / bytes)
      fail("names " + std::to_string(count) + " items, more than it can hold,");
    return count;
  }
  [[noreturn]] void fail(const std::string& what) const {
    throw std::runtime_error(name_ + " " + what + " at byte " + std::to_string(at_) + " of " +
                             std::to_string(bytes_.size()) + "; it is damaged or no COLMAP model: export it again");
  }
  const std::string& name() const { return name_; }

 private:
  std::string name_, bytes_;
  size_t at_ = 0;
};

void read_binary(const fs::path& folder, ColmapModel& model) {
  Binary cameras(folder / "cameras.bin");
  for (std::uint64_t n = cameras.items(24); n > 0; --n) {
    const auto id = cameras.next<std::uint32_t>();
    const int number = cameras.next<std::int32_t>();
    const auto width = cameras.next<std::uint64_t>(), height = cameras.next<std::uint64_t>();
    if (number < 0 || static_cast<size_t>(number) >= models.size())
      cameras.fail("has camera model " + std::to_string(number) + ", which is not known,");
    std::vector<double> parameters(models[number].parameters);
    for (double& p : parameters) p = cameras.next<double>();
    model.cameras[id] = camera_of(id, models[number].name, static_cast<int>(width), static_cast<int>(height),
                                  parameters, cameras.name());
  }
  Binary images(folder / "images.bin");
  for (std::uint64_t n = images.items(64); n > 0; --n) {
    ColmapImage image;
    image.id = images.next<std::uint32_t>();
    double q[4], t[3];
    for (double& v : q) v = images.next<double>();
    for (double& v : t) v = images.next<double>();
    image.cam_from_world = {Eigen::Quaterniond(q[0], q[1], q[2], q[3]), {t[0], t[1], t[2]}};
    image.camera = images.next<std::uint32_t>();
    image.name = images.text();
    image.features.resize(images.items(24));
    for (auto& f : image.features) {
      f.pixel.x() = images.next<double>() - 0.5, f.pixel.y() = images.next<double>() - 0.5;
      f.point = images.next<std::int64_t>();
    }
    model.images[image.id] = std::move(image);
  }
  Binary points(folder / "points3D.bin");
  for (std::uint64_t n = points.items(43); n > 0; --n) {
    const auto id = static_cast<std::int64_t>(points.next<std::uint64_t>());
    ColmapPoint point;
    for (int k = 0; k < 3; ++k) point.position(k) = points.next<double>();
    for (auto& c : point.colour) c = points.next<std::uint8_t>();
    point.error = points.next<double>();
    for (std::uint64_t m = points.items(8); m > 0; --m) {
      const auto image = points.next<std::uint32_t>(), feature = points.next<std::uint32_t>();
      point.track.emplace_back(image, feature);
    }
    model.points[id] = std::move(point);
  }
}

class Lines {
 public:
  explicit Lines(const fs::path& path) : name_(path.string()), stream_(path) {
    if (!stream_) throw std::runtime_error("cannot read " + name_);
  }
  /// The next line that is no comment; with `empty` an empty one counts.
  bool next(std::istringstream& line, bool empty = false) {
    for (std::string text; std::getline(stream_, text);) {
      ++number_;
      if (!text.empty() && text.back() == '\r') text.pop_back();
      if (!text.empty() && text[0] == '#') continue;
      if (text.empty() && !empty) continue;
      line = std::istringstream(text);
      return true;
    }
    return false;
  }
  [[noreturn]] void fail(const std::string& what) const { throw std::runtime_error(where() + ": " + what); }
  std::string where() const { return name_ + ":" + std::to_string(number_); }

 private:
  std::string name_;
  std::ifstream stream_;
  int number_ = 0;
};

void read_text(const fs::path& folder, ColmapModel& model) {
  std::istringstream line;
  Lines cameras(folder / "cameras.txt");
  while (cameras.next(line)) {
    std::uint32_t id;
    std::string name;
    int width, height;
    if (!(line >> id >> name >> width >> height)) cameras.fail("expected CAMERA_ID MODEL WIDTH HEIGHT PARAMS");
    std::vector<double> parameters;
    for (double p; line >> p;) parameters.push_back(p);
    model.cameras[id] = camera_of(id, name, width, height, parameters, cameras.where());
  }
  Lines images(folder / "images.txt");
  while (images.next(line)) {
    ColmapImage image;
    double q[4], t[3];
    if (!(line >> image.id >> q[0] >> q[1] >> q[2] >> q[3] >> t[0] >> t[1] >> t[2] >> image.camera))
      images.fail("expected IMAGE_ID QW QX QY QZ TX TY TZ CAMERA_ID NAME");
    std::getline(line >> std::ws, image.name);
    image.cam_from_world = {Eigen::Quaterniond(q[0], q[1], q[2], q[3]), {t[0], t[1], t[2]}};
    if (images.next(line, true)) {
      ColmapFeature f;
      while (line >> f.pixel.x() >> f.pixel.y() >> f.point) {
        f.pixel -= Eigen::Vector2d(0.5, 0.5);
        image.features.push_back(f);
      }
      if (!line.eof()) images.fail("expected triples X Y POINT3D_ID");
    }
    model.images[image.id] = std::move(image);
  }
  Lines points(folder / "points3D.txt");
  while (points.next(line)) {
    std::int64_t id;
    ColmapPoint p;
    int c[3];
    if (!(line >> id >> p.position.x() >> p.position.y() >> p.position.z() >> c[0] >> c[1] >> c[2] >> p.error))
      points.fail("expected POINT3D_ID X Y Z R G B ERROR TRACK");
    for (size_t k = 0; k < 3; ++k) p.colour[k] = static_cast<std::uint8_t>(c[k]);
    std::uint32_t image, feature;
    while (line >> image >> feature) p.track.emplace_back(image, feature);
    model.points[id] = std::move(p);
  }
}

void check(ColmapModel& model, const std::string& folder) {
  if (model.images.empty()) throw std::runtime_error(folder + ": the model has no image");
  for (auto& [id, image] : model.images) {
    if (!model.cameras.count(image.camera))
      throw std::runtime_error(folder + ": image " + image.name + " is of camera " + std::to_string(image.camera) +
                               ", which is not in cameras");
    if (!(image.cam_from_world.rotation.norm() > 0.5) || !image.cam_from_world.translation.allFinite())
      throw std::runtime_error(folder + ": image " + image.name + " has no rotation or translation");
    image.cam_from_world.rotation.normalize();
  }
  for (const auto& [id, point] : model.points)
    for (const auto& [image, feature] : point.track) {
      const auto found = model.images.find(image);
      if (found == model.images.end() || feature >= found->second.features.size())
        throw std::runtime_error(folder + ": the track of point " + std::to_string(id) + " names feature " +
                                 std::to_string(feature) + " of image " + std::to_string(image) +
                                 ", which is not there; the files are not of one model");
    }
}

/// A blank and the shortest digits that read back as the same number.
template <typename Number>
void append(std::string& text, Number value) {
  char digits[32];
  digits[0] = ' ';
  text.append(digits, std::to_chars(digits + 1, std::end(digits), value).ptr);
}

}  // namespace

ColmapModel read_colmap(const std::string& folder) {
  ColmapModel model;
  const fs::path root = folder;
  if (fs::exists(root / "images.bin") && fs::exists(root / "cameras.bin") && fs::exists(root / "points3D.bin"))
    read_binary(root, model);
  else if (fs::exists(root / "images.txt") && fs::exists(root / "cameras.txt") && fs::exists(root / "points3D.txt"))
    read_text(root, model);
  else
    throw std::runtime_error(folder +
                             " is no COLMAP model: expected cameras, images and points3D as .bin or .txt. A sparse "
                             "reconstruction lies in a folder such as sparse/0");
  check(model, folder);
  return model;
}

std::map<std::string, std::string> colmap_text(const ColmapModel& model) {
  std::string cameras = "# CAMERA_ID, MODEL, WIDTH, HEIGHT, PARAMS[]\n",
              images = "# IMAGE_ID, QW, QX, QY, QZ, TX, TY, TZ, CAMERA_ID, NAME\n# POINTS2D[] as (X, Y, POINT3D_ID)\n",
              points = "# POINT3D_ID, X, Y, Z, R, G, B, ERROR, TRACK[] as (IMAGE_ID, POINT2D_IDX)\n";
  for (const auto& [id, c] : model.cameras) {
    const InteriorOrientation& b = c.camera;
    const bool is_fisheye = b.lens == LensModel::fisheye, has_third = !is_fisheye && b.k3 != 0;
    cameras += std::to_string(id) + (is_fisheye ? " OPENCV_FISHEYE" : has_third ? " FULL_OPENCV" : " OPENCV");
    append(cameras, b.width);
    append(cameras, b.height);
    std::vector<double> p = {
        b.fx, b.fy, b.cx + 0.5, b.cy + 0.5, b.k1, b.k2, is_fisheye ? b.k3 : b.p1, is_fisheye ? b.k4 : b.p2};
    if (has_third) p.insert(p.end(), {b.k3, 0, 0, 0});
    for (const double v : p) append(cameras, v);
    cameras += "\n";
  }
  for (const auto& [id, image] : model.images) {
    const RigidTransform& t = image.cam_from_world;
    images += std::to_string(id);
    for (const double v : {t.rotation.w(), t.rotation.x(), t.rotation.y(), t.rotation.z(), t.translation.x(),
                           t.translation.y(), t.translation.z()})
      append(images, v);
    append(images, image.camera);
    images += " " + image.name + "\n";
    const std::size_t line = images.size();
    for (const ColmapFeature& f : image.features) {
      append(images, f.pixel.x() + 0.5);
      append(images, f.pixel.y() + 0.5);
      append(images, f.point);
    }
    if (!image.features.empty()) images.erase(line, 1);
    images += "\n";
  }
  for (const auto& [id, p] : model.points) {
    points += std::to_string(id);
    for (int k = 0; k < 3; ++k) append(points, p.position(k));
    for (const int c : p.colour) append(points, c);
    append(points, p.error);
    for (const auto& [image, feature] : p.track) {
      append(points, image);
      append(points, feature);
    }
    points += "\n";
  }
  return {{"cameras.txt", cameras}, {"images.txt", images}, {"points3D.txt", points}};
}

}  // namespace plumbline::cameras
