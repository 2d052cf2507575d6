#include "collect_nodes.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "base/text/whole_file.hpp"
#include "photo/detect/tag_dictionary.hpp"
#include "photo/detect/tag_family.hpp"

namespace plumbline::detect {
namespace {

using Json = nlohmann::ordered_json;
namespace fs = std::filesystem;

bool is_dictionary(const std::string& name) {
  try {
    builtin_dictionary(name);
    return true;
  } catch (const std::runtime_error&) {
    return false;
  }
}

}  // namespace

std::string apriltag_family_of(const std::string& name, size_t file_size) {
  if (is_apriltag_family(name)) return name;
  if (file_size > 0)
    throw std::runtime_error(name +
                             " is a dictionary file; libapriltag knows its own families only. Use "
                             "detector=aruco");
  const std::string opencv = is_dictionary(name) ? builtin_dictionary(name).name : "";
  if (is_apriltag_family(opencv)) return opencv;
  throw std::runtime_error("'" + name + "' is an OpenCV dictionary, not an AprilTag family; use detector=aruco");
}

FileT tag_family_file(const std::string& family, std::string& weakness) {
  FileT result;
  result.name = family;
  std::error_code failed;
  if (is_apriltag_family(family)) return result;
  if (!fs::is_regular_file(family, failed)) {
    const bool looks_like_path = family.find_first_of("/.") != std::string::npos;
    if (!looks_like_path) {
      weakness = weakness_of(builtin_dictionary(family));  // throws what is known
      return result;
    }
    throw std::runtime_error("there is no dictionary file " + fs::absolute(family).string() +
                             "; give the path of a file as OpenCV writes it, or a name such as tag36h11 or "
                             "DICT_6X6_1000");
  }
  const auto size = fs::file_size(family);
  if (size == 0) throw std::runtime_error(family + " is empty; expected a dictionary file as OpenCV writes it");
  if (size > (1u << 26)) throw std::runtime_error(family + " has more than 64 MB; it is no dictionary of tags");
  const std::string text = text::read_whole(family);
  result.name = fs::path(family).filename().string();
  result.content.assign(text.begin(), text.end());
  weakness = weakness_of(parse_dictionary(text, family));  // a mistake is told here, once
  return result;
}

std::string doubt_of_curve(const TagObservationsT& observations) {
  constexpr double much = 0.15;  // [px]; sRGB photographs of JPEG 70 state 0.1, with a single tag
  double squares = 0, stated = 0, doubtful = 0;
  for (const auto& image : observations.images) {
    if (!(image->corner_inset_sigma > 0)) continue;
    squares += image->corner_inset_sigma * image->corner_inset_sigma, stated += 1;
    doubtful += image->corner_inset_sigma > much;
  }
  if (!(doubtful > 0.5 * stated)) return "";
  return fmt::format(
      "the edges of all tags of a photograph may lie {:.2f} px inwards or outwards together (one standard deviation, "
      "corner_inset_sigma): {:.0f} of {:.0f} photographs do not tell whether their grey values are those of light (a "
      "linear file) or of a curve (sRGB), which JPEG, noise or sharpening hides, or their edges are none that a lens "
      "draws (bloom, overexposure, halos). Export with a quality of 90 or more, unsharpened",
      std::sqrt(squares / stated), doubtful, stated);
}

std::string observations_json(const TagObservationsT& observations) {
  Json images = Json::array();
  for (const auto& image : observations.images) {
    Json tags = Json::array();
    for (const auto& tag : image->tags) {
      Json corners = Json::array(), covariance = Json::array();
      for (const auto& c : tag->corners) corners.push_back({c.x(), c.y()});
      for (size_t i = 0; i + 2 < tag->corner_covariances.size(); i += 3)
        covariance.push_back(
            {tag->corner_covariances[i], tag->corner_covariances[i + 1], tag->corner_covariances[i + 2]});
      tags.push_back({{"family", tag->family},
                      {"id", tag->id},
                      {"corners", corners},
                      {"covariance", covariance},
                      {"refined", tag->refined}});
    }
    Json entry = {{"path", image->path}, {"width", image->width}, {"height", image->height}};
    if (!image->problem.empty()) entry["problem"] = image->problem;
    if (image->corner_inset_sigma > 0) entry["corner_inset_sigma"] = image->corner_inset_sigma;
    entry["tags"] = tags;
    images.push_back(entry);
  }
  const Json root = {{"corner_order", "bottom left, bottom right, top right, top left of the upright tag"},
                     {"pixel_origin", "the centre of the top-left pixel is (0, 0)"},
                     {"images", images}};
  return root.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace plumbline::detect
