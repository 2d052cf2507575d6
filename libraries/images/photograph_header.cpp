#include "images/photograph_header.hpp"

#include <algorithm>
#include <cmath>
#include <exiv2/exiv2.hpp>
#include <initializer_list>
#include <stdexcept>

namespace plumbline {
namespace {

double number_of(const Exiv2::ExifData& exif, const char* key) {
  const auto found = exif.findKey(Exiv2::ExifKey(key));
  const double value = found == exif.end() || found->count() == 0 ? 0.0 : static_cast<double>(found->toFloat());
  return std::isfinite(value) && value > 0 ? value : 0.0;
}

/// Principal distance in pixels of a width × height image; nan if EXIF tells neither the sensor's pitch nor the
/// equivalent focal length, or tells one that no lens has. Source of the tags: Exif 2.32, CIPA DC-008.
double principal_distance(const Exiv2::ExifData& exif, int width, int height) {
  const double longest = std::max(width, height), nan = std::nan("");
  const auto plausible = [&](double value) { return value > 0.3 * longest && value < 30 * longest ? value : nan; };
  const double film = number_of(exif, "Exif.Photo.FocalLengthIn35mmFilm");
  // "35 mm equivalent" compares diagonals; 43.27 mm is that of the film.
  if (film > 0) return plausible(film / 43.2666 * std::hypot(width, height));
  const double focal = number_of(exif, "Exif.Photo.FocalLength"),
               per_unit = number_of(exif, "Exif.Photo.FocalPlaneXResolution"),
               stated_width = number_of(exif, "Exif.Photo.PixelXDimension");
  if (focal <= 0 || per_unit <= 0) return nan;
  const auto unit = exif.findKey(Exiv2::ExifKey("Exif.Photo.FocalPlaneResolutionUnit"));
  const long number = unit == exif.end() || unit->count() == 0 ? 2 : unit->toLong();
  const double unit_mm = number == 3 ? 10.0 : number == 4 ? 1.0 : number == 5 ? 1e-3 : 25.4;
  // The resolution counts pixels of the picture as taken, which may have been reduced since.
  const double reduced =
      stated_width > 0 ? std::max(width, height) / std::max(stated_width, number_of(exif, "Exif.Photo.PixelYDimension"))
                       : 1.0;
  return plausible(focal * per_unit / unit_mm * reduced);
}

std::string text_of(const Exiv2::ExifData& exif, const char* key) {
  const auto found = exif.findKey(Exiv2::ExifKey(key));
  return found == exif.end() ? "" : found->toString();
}

/// "Make Model" without repeating a make that the model already starts with.
std::string model_of(const Exiv2::ExifData& exif) {
  const std::string make = text_of(exif, "Exif.Image.Make"), model = text_of(exif, "Exif.Image.Model");
  if (make.empty() || model.rfind(make, 0) == 0) return model;
  return model.empty() ? make : make + " " + model;
}

}  // namespace

namespace {

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

PhotographHeader read_photograph_header(const std::filesystem::path& path) {
  Exiv2::LogMsg::setLevel(Exiv2::LogMsg::mute);
  PhotographHeader result;
  try {
    const auto header = Exiv2::ImageFactory::open(path.string());
    header->readMetadata();
    result.width = static_cast<int>(header->pixelWidth());
    result.height = static_cast<int>(header->pixelHeight());
    const Exiv2::ExifData& exif = header->exifData();
    result.model = model_of(exif);
    result.serial = text_of(exif, "Exif.Photo.BodySerialNumber");
    result.taken_at = text_of(exif, "Exif.Photo.DateTimeOriginal");
    const double focal = number_of(exif, "Exif.Photo.FocalLength");
    if (focal > 0) result.focal_length = 1e-3 * focal;
    result.principal_distance = principal_distance(exif, result.width, result.height);
    result.orientation = static_cast<int>(number_of(exif, "Exif.Image.Orientation"));
  } catch (const Exiv2::AnyError& error) {
    throw std::runtime_error(error.what());
  }
  return result;
}

}  // namespace plumbline
