#include "photo/detect/family_guess.hpp"

#include <algorithm>
#include <cstdlib>
#include <map>
#include <opencv2/imgproc.hpp>

#include "photo/detect/likeness.hpp"
#include "photo/detect/one_thread.hpp"
#include "photo/detect/tag_pyramid.hpp"
#include "photo/images/grey_image.hpp"

namespace plumbline::detect {
namespace {

GreyImage reduced(const GreyImage& image, int longest) {
  const int factor = (std::max(image.width, image.height) + longest - 1) / longest;
  if (factor <= 1) return image;
  const cv::Mat view(image.height, image.width, CV_8UC1, const_cast<std::uint8_t*>(image.pixels.data()));
  GreyImage result{image.width / factor, image.height / factor, {}};
  result.pixels.resize(static_cast<std::size_t>(result.width) * result.height);
  cv::Mat small(result.height, result.width, CV_8UC1, result.pixels.data());
  cv::resize(view, small, small.size(), 0, 0, cv::INTER_AREA);
  return result;
}

/// Without the families of 48 bits and more, whose tables are large.
const std::vector<SquareFamily>& common_families() {
  static const std::vector<SquareFamily> families = [] {
    std::vector<SquareFamily> list;
    for (const char* name :
         {"tag36h11", "tag36h10", "tag25h9", "tag16h5", "tagStandard41h12", "tagCircle21h7", "tag36h11b2",
          "DICT_4X4_1000", "DICT_5X5_1000", "DICT_6X6_1000", "DICT_7X7_1000", "DICT_ARUCO_ORIGINAL", "ARUCO_MIP_36h12"})
      list.push_back(square_family(name));
    return list;
  }();
  return families;
}

/// OpenCV's dictionaries of one size are parts of one another: the smallest that has the number.
std::string smallest_name(const std::string& family, int largest_id) {
  if (!family.ends_with("_1000")) return family;
  for (const int count : {50, 100, 250})
    if (largest_id < count) return family.substr(0, family.size() - 4) + std::to_string(count);
  return family;
}

/// Whether `asked` has all tags of OpenCV's dictionary `name`: DICT_6X6_1000 those of DICT_6X6_50.
bool holds(const std::string& asked, const std::string& name) {
  const auto count = name.rfind('_') + 1;
  if (!name.starts_with("DICT_") || !asked.starts_with(name.substr(0, count))) return asked == name;
  return std::atoi(asked.c_str() + count) >= std::atoi(name.c_str() + count);
}

}  // namespace

std::string tags_of_another_family(const GreyImage& image, const std::vector<std::string>& asked) {
  keep_opencv_to_one_thread();
  PyramidOptions options;
  options.refinement = Refinement::apriltag;
  options.smallest_tag = 16, options.max_hamming = 0;
  std::map<std::string, std::pair<int, int>> seen;  // number of tags and largest id by family
  for (const DetectedTag& tag : TagPyramid(common_families(), options).detect(reduced(image, 2000)).tags) {
    auto& [count, largest] = seen[tag.family];
    ++count, largest = std::max(largest, tag.id);
  }
  std::string best;
  int most = 0;
  for (const SquareFamily& family : common_families()) {
    const auto found = seen.find(family.name);
    if (found == seen.end()) continue;
    const auto [count, largest] = found->second;
    const std::string name = smallest_name(family.name, largest);
    const bool weak = chance_of_code(family.codes.size(), family.cells.size(), 0) >= 1e-4;
    if (count < (weak ? 4 : 2) || count <= most ||
        std::any_of(asked.begin(), asked.end(), [&](const std::string& one) { return holds(one, name); }))
      continue;
    most = count, best = std::to_string(count) + " tags of " + name;
  }
  return best;
}

}  // namespace plumbline::detect
