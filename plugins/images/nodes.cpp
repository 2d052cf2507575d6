// read.images: the photographs of a folder, by reference, with what their headers and EXIF say.
#include <algorithm>
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

ImageT describe(const fs::path& file, const fs::path& folder) {
  Exiv2::LogMsg::setLevel(Exiv2::LogMsg::mute);
  ImageT image;
  image.path = file.lexically_relative(folder).generic_string();
  image.uri = file.string();
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
    if (focal != exif.end() && focal->toFloat() > 0) image.focal_length = 1e-3 * static_cast<double>(focal->toFloat());
  } catch (const Exiv2::AnyError& error) {
    throw std::runtime_error(file.string() + ": not a readable image (" + error.what() +
                             "); copy it from the camera again or take it out of the folder");
  }
  return image;
}

struct ReadImages : Node {
  static constexpr Info info{"read.images", "", 1, "Lists the photographs of a folder, by reference"};
  Param<FolderPath> folder{"folder", required, "folder with JPEG, PNG or TIFF files, also in folders below it"};
  Param<std::string> camera{"camera", "", "name of the camera that took them: Camera.id"};
  OutList<Image> images{"images", "the photographs, ordered by path"};

  void run(Context& context) override {
    const fs::path root = folder->path;
    std::vector<fs::path> files;
    for (const auto& entry : fs::recursive_directory_iterator(root))
      if (entry.is_regular_file() && is_image_name(entry.path())) files.push_back(entry.path());
    if (files.empty())
      throw std::runtime_error("no image in " + root.string() +
                               "; expected files that end in .jpg, .jpeg, .png, .tif or .tiff");
    std::sort(files.begin(), files.end());
    for (const fs::path& file : files) {
      ImageT image = describe(file, root);
      image.sha256 = context.digest(file.string());
      image.camera = *camera;
      images.commit(image);
    }
  }
};

}  // namespace

PLUMBLINE_PLUGIN("images", "0.1.0", "MIT", ReadImages)
