#include "photo/images/photograph_header.hpp"

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <stdexcept>

#include "photo/images/exif.hpp"
#include "photo/images/image_walk.hpp"

namespace plumbline {
namespace {

using image_decoders::Exif;
using image_decoders::ExifTag;

/// Principal distance in pixels of a width × height image; nan if EXIF tells neither the sensor's pitch nor the
/// equivalent focal length, or tells one that no lens has. Source of the tags: Exif 2.32, CIPA DC-008.
double principal_distance(const Exif& exif, int width, int height) {
  const double longest = std::max(width, height), nan = std::nan("");
  const auto plausible = [&](double value) { return value > 0.3 * longest && value < 30 * longest ? value : nan; };
  const double film = exif.positive(ExifTag::focal_length_35mm);
  // "35 mm equivalent" compares diagonals; 43.27 mm is that of the film.
  if (film > 0) return plausible(film / 43.2666 * std::hypot(width, height));
  const double focal = exif.positive(ExifTag::focal_length), per_unit = exif.positive(ExifTag::focal_plane_resolution),
               stated_width = exif.positive(ExifTag::width);
  if (focal <= 0 || per_unit <= 0) return nan;
  const auto unit = exif.numbers.find(ExifTag::focal_plane_unit);
  const double number = unit == exif.numbers.end() ? 2 : unit->second;
  const double unit_mm = number == 3 ? 10.0 : number == 4 ? 1.0 : number == 5 ? 1e-3 : 25.4;
  // The resolution counts pixels of the picture as taken, which may have been reduced since.
  const double reduced =
      stated_width > 0 ? std::max(width, height) / std::max(stated_width, exif.positive(ExifTag::height)) : 1.0;
  return plausible(focal * per_unit / unit_mm * reduced);
}

/// "Make Model" without repeating a make that the model already starts with.
std::string model_of(const Exif& exif) {
  const std::string make = exif.text(ExifTag::make), model = exif.text(ExifTag::model);
  if (make.empty() || model.rfind(make, 0) == 0) return model;
  return model.empty() ? make : make + " " + model;
}

bool ends_as(const std::filesystem::path& path, std::initializer_list<const char*> extensions) {
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return std::tolower(c); });
  return std::find(extensions.begin(), extensions.end(), extension) != extensions.end();
}

}  // namespace

bool is_photograph_name(const std::filesystem::path& path) {
  return ends_as(path, {".jpg", ".jpeg", ".png", ".tif", ".tiff"});
}

std::string unread_photographs(std::vector<std::string> names) {
  constexpr size_t kMost = 10;
  std::erase_if(names, [](const std::string& name) {
    return !ends_as(name, {".heic", ".heif", ".avif", ".webp", ".bmp", ".gif", ".jp2", ".dng", ".nef", ".cr2", ".cr3",
                           ".arw", ".raf", ".orf", ".rw2", ".raw", ".pgm", ".ppm", ".pnm"});
  });
  if (names.empty()) return {};
  std::sort(names.begin(), names.end());
  std::string text = "left out, because their format is not read (export them as JPEG, PNG or TIFF in full size): ";
  for (size_t i = 0; i < std::min(names.size(), kMost); ++i) text += (i > 0 ? ", " : "") + names[i];
  if (names.size() > kMost) text += " and " + std::to_string(names.size() - kMost) + " more";
  return text;
}

PhotographHeader read_photograph_header(const std::filesystem::path& path, ReadTo end) {
  const image_decoders::WalkedImage walked = image_decoders::walk_image(path, end == ReadTo::end_of_file);
  const image_decoders::TiffHeader header =
      walked.is_tiff ? image_decoders::read_tiff_header(path)
                     : image_decoders::TiffHeader{walked.width, walked.height, image_decoders::parse_exif(walked.exif)};
  const Exif& exif = header.exif;
  PhotographHeader result;
  result.width = header.width, result.height = header.height;
  result.jpeg_quality = walked.jpeg_quality;
  result.model = model_of(exif);
  result.serial = exif.text(ExifTag::serial);
  result.taken_at = exif.text(ExifTag::taken_at);
  const double focal = exif.positive(ExifTag::focal_length);
  if (focal > 0) result.focal_length = 1e-3 * focal;
  result.principal_distance = principal_distance(exif, result.width, result.height);
  result.orientation = static_cast<int>(exif.positive(ExifTag::orientation));
  if (result.width <= 0 || result.height <= 0) throw std::runtime_error("the image has no size");
  return result;
}

}  // namespace plumbline
