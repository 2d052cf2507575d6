// read.images: the photographs of a folder, by reference, with what their headers and EXIF say.
#include <algorithm>
#include <filesystem>

#include "artifacts/image.hpp"
#include "artifacts/input_files_text.hpp"
#include "photo/images/photograph_header.hpp"
#include "plumbline/folder_files.hpp"
#include "plumbline/node.hpp"

namespace {

using namespace plumbline;
namespace fs = std::filesystem;

/// Somebody who names the folder of a run means a folder that it delivered.
std::string words_of_outputs(const FolderFiles& found) {
  const auto photographs = std::count_if(found.outputs.begin(), found.outputs.end(),
                                         [](const std::string& file) { return is_photograph_name(file); });
  if (photographs == 0) return "";
  return ". " + std::to_string(photographs) + " images there are outputs of a run: name the folder they lie in";
}

/// Photographs that lost their fine detail to the compression. Measured: corners of tags move by 0.06 px at a quality
/// of 95, by 0.3 px at 70.
class Compressed {
 public:
  void look_at(const std::string& path, int quality) {
    constexpr int low = 60;
    if (quality == 0 || quality >= low) return;
    if (count_ == 0) first_ = path;
    ++count_, worst_ = std::min(worst_, quality);
  }
  std::string in_words() const {
    if (count_ == 0) return "";
    return first_ + (count_ > 1 ? " and " + std::to_string(count_ - 1) + " more" : "") +
           ": compressed to a JPEG quality of " + std::to_string(worst_) + (count_ > 1 ? " at worst" : "") +
           " (of 100): edges and corners lie tenths of a pixel off in it. "
           "Export with 90 or more, or use the files as the camera wrote them";
  }

 private:
  std::size_t count_ = 0;
  int worst_ = 100;
  std::string first_;
};

ImageT describe(const fs::path& file, const fs::path& folder, bool stop_at_bad, Compressed& compressed) {
  ImageT image;
  image.path = file.lexically_relative(folder).generic_string();
  image.size = fs::file_size(file);
  try {
    const PhotographHeader header = read_photograph_header(file);
    image.width = header.width, image.height = header.height;
    image.model = header.model, image.serial = header.serial, image.taken_at = header.taken_at;
    image.focal_length = header.focal_length, image.principal_distance = header.principal_distance;
    image.orientation = header.orientation;
    compressed.look_at(image.path, header.jpeg_quality);
  } catch (const std::runtime_error& error) {
    // Whoever reads the pixels tells what is wrong with them.
    if (!stop_at_bad) return image;
    throw std::runtime_error(file.string() + ": not a readable image (" + error.what() +
                             "); copy it from the camera again or take it out of the folder");
  }
  return image;
}

struct ReadImages : Node {
  static constexpr Info info{"read.images", "", 4, "Lists the photographs of a folder, by reference"};
  Param<FolderPath> folder{"folder", required, "folder with JPEG, PNG or TIFF files, also in folders below it"};
  Param<std::string> camera{"camera", "", "name of the camera that took them: Camera.id"};
  Param<std::string> on_bad_image{
      "on_bad_image", "error", one_of("error", "leave_out"),
      "what to do with a file that is no image: stop, or leave it to the node that reads its pixels to say so"};
  OutList<Image> images{"images", "the photographs, ordered by path"};

  void run(Context& context) override {
    const fs::path root = folder->path;
    FolderFiles found = list_files(root);
    std::vector<fs::path> files;
    std::vector<std::string> others, of_systems;
    for (const std::string& file : found.files)
      if (is_system_file(file) && is_photograph_name(file))
        of_systems.push_back(file);
      else if (is_photograph_name(file))
        files.push_back(root / file);
      else
        others.push_back(file);
    std::erase_if(found.dangling, [](const std::string& link) { return !is_photograph_name(link); });
    if (!found.dangling.empty()) say_dangling(context, found.dangling);
    if (!of_systems.empty())
      context.info(of_systems.front() +
                   (of_systems.size() > 1 ? " and " + std::to_string(of_systems.size() - 1) + " more" : "") +
                   ": written by a computer's system beside the photographs, and no photograph");
    const std::string unread = unread_photographs(others);
    if (files.empty())
      throw std::runtime_error("no image in " + root.string() +
                               "; expected files that end in .jpg, .jpeg, .png, .tif or .tiff" +
                               (unread.empty() ? "" : ". Photographs are " + unread) + words_of_outputs(found));
    if (!unread.empty()) context.warn("photographs of " + root.string() + " are " + unread);
    std::erase_if(others, [](const std::string& file) { return is_system_file(file); });
    context.info(std::to_string(files.size()) + (files.size() == 1 ? " photograph of " : " photographs of ") +
                 root.string() + (others.empty() ? "" : "; in the folder and not read: " + few_names(others)));
    std::sort(files.begin(), files.end());
    Compressed compressed;
    for (const fs::path& file : files) {
      ImageT image = describe(file, root, *on_bad_image == "error", compressed);
      image.sha256 = context.digest(file.string());
      image.uri = "sha256:" + image.sha256 + "/" + file.filename().string();
      image.camera = *camera;
      images.commit(image);
    }
    if (const std::string words = compressed.in_words(); !words.empty()) context.warn(words);
  }

 private:
  void say_dangling(Context& context, const std::vector<std::string>& links) const {
    const std::string text = links.front() +
                             (links.size() > 1 ? " and " + std::to_string(links.size() - 1) + " others" : "") + " of " +
                             folder->path + ": a link to a file that is not there; take it away, or put the file back";
    if (*on_bad_image == "error") throw std::runtime_error(text);
    context.warn(text);
  }
};

}  // namespace

PLUMBLINE_PLUGIN("images", PLUMBLINE_BUILD_ID, "MIT", ReadImages)
