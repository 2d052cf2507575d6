// read.images: the photographs of a folder, by reference, with what their headers and EXIF say.
#include <algorithm>
#include <cmath>
#include <exiv2/exiv2.hpp>
#include <filesystem>

#include "artifacts/image.hpp"
#include "plumbline/node.hpp"

namespace {

using namespace plumbline;
namespace fs = std::filesystem;

bool is_image_name(const fs::path& path) {
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return std::tolower(c); });
  return extension == ".jpg" || extension == ".jpeg" || extension == ".png" || extension == ".tif" ||
         extension == ".tiff";
}

/// Photographs in formats that are not read: told of, because their owner expects them to take part.
bool is_foreign_image_name(const fs::path& path) {
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return std::tolower(c); });
  for (const char* known : {".heic", ".heif", ".avif", ".webp", ".bmp", ".gif", ".jp2", ".dng", ".nef", ".cr2", ".cr3",
                            ".arw", ".raf", ".orf", ".rw2", ".raw", ".pgm", ".ppm", ".pnm"})
    if (extension == known) return true;
  return false;
}

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

ImageT describe(const fs::path& file, const fs::path& folder, bool stop_at_bad) {
  Exiv2::LogMsg::setLevel(Exiv2::LogMsg::mute);
  ImageT image;
  image.path = file.lexically_relative(folder).generic_string();
  image.size = fs::file_size(file);
  try {
    const auto header = Exiv2::ImageFactory::open(file.string());
    header->readMetadata();
    image.width = static_cast<int>(header->pixelWidth());
    image.height = static_cast<int>(header->pixelHeight());
    const Exiv2::ExifData& exif = header->exifData();
    image.model = model_of(exif);
    image.taken_at = text_of(exif, "Exif.Photo.DateTimeOriginal");
    const auto focal = exif.findKey(Exiv2::ExifKey("Exif.Photo.FocalLength"));
    if (focal != exif.end() && focal->count() > 0 && focal->toFloat() > 0)
      image.focal_length = 1e-3 * static_cast<double>(focal->toFloat());
    image.principal_distance = principal_distance(exif, image.width, image.height);
    image.orientation = static_cast<int>(number_of(exif, "Exif.Image.Orientation"));
  } catch (const Exiv2::AnyError& error) {
    // Whoever reads the pixels tells what is wrong with them.
    if (!stop_at_bad) return image;
    throw std::runtime_error(file.string() + ": not a readable image (" + error.what() +
                             "); copy it from the camera again or take it out of the folder");
  }
  return image;
}

struct ReadImages : Node {
  static constexpr Info info{"read.images", "", 3, "Lists the photographs of a folder, by reference"};
  Param<FolderPath> folder{"folder", required, "folder with JPEG, PNG or TIFF files, also in folders below it"};
  Param<std::string> camera{"camera", "", "name of the camera that took them: Camera.id"};
  Param<std::string> on_bad_image{
      "on_bad_image", "error", one_of("error", "leave_out"),
      "what to do with a file that is no image: stop, or leave it to the node that reads its pixels to say so"};
  OutList<Image> images{"images", "the photographs, ordered by path"};

  void run(Context& context) override {
    const fs::path root = folder->path;
    std::vector<fs::path> files;
    std::vector<std::string> foreign;
    for (const auto& entry : fs::recursive_directory_iterator(root))
      if (entry.is_regular_file() && is_image_name(entry.path()))
        files.push_back(entry.path());
      else if (entry.is_regular_file() && is_foreign_image_name(entry.path()))
        foreign.push_back(entry.path().lexically_relative(root).generic_string());
    std::sort(foreign.begin(), foreign.end());
    const std::string mend = "export them as JPEG, PNG or TIFF in full size";
    if (files.empty())
      throw std::runtime_error("no image in " + root.string() +
                               "; expected files that end in .jpg, .jpeg, .png, .tif or .tiff" +
                               (foreign.empty() ? "" : ". " + foreign.front() + " and the like are not read: " + mend));
    if (!foreign.empty())
      context.warn(std::to_string(foreign.size()) + " photographs of " + root.string() + " are left out, " +
                   foreign.front() + " is the first: their format is not read; " + mend);
    std::sort(files.begin(), files.end());
    for (const fs::path& file : files) {
      ImageT image = describe(file, root, *on_bad_image == "error");
      image.sha256 = context.digest(file.string());
      image.uri = "sha256:" + image.sha256 + "/" + file.filename().string();
      image.camera = *camera;
      images.commit(image);
    }
  }
};

}  // namespace

PLUMBLINE_PLUGIN("images", "0.1.0", "MIT", ReadImages)
