// What every detector of tags has in common: from a photograph by reference to its tags as an artifact.
#pragma once

#include <algorithm>
#include <functional>
#include <memory>
#include <vector>

#include "artifacts/image.hpp"
#include "artifacts/image_tags.hpp"
#include "photo/detect/family_guess.hpp"
#include "photo/detect/tag_detector.hpp"
#include "photo/images/grey_image.hpp"
#include "photo/images/visibility.hpp"
#include "plumbline/node.hpp"

namespace plumbline::detect {

using SearchImage = std::function<std::vector<DetectedTag>(const GreyImage&)>;

inline std::unique_ptr<TagT> tag_artifact(const DetectedTag& found) {
  auto tag = std::make_unique<TagT>();
  tag->family = found.family;
  tag->id = found.id;
  tag->hamming = found.hamming;
  tag->decision_margin = static_cast<float>(found.decision_margin);
  tag->refined = found.refined;
  for (size_t i = 0; i < 4; ++i) {
    tag->corners.push_back(found.corners[i]);
    const Eigen::Matrix2d& c = found.covariances[i];
    for (const double value : {c(0, 0), c(0, 1), c(1, 1)}) tag->corner_covariances.push_back(value);
  }
  return tag;
}

/// Appends the tags to the photograph's.
inline void add_tags(const std::vector<DetectedTag>& found, ImageTagsT& image) {
  for (const DetectedTag& tag : found) {
    image.tags.push_back(tag_artifact(tag));
    if (tag.inset_sigma > 0) image.corner_inset_sigma = tag.inset_sigma;  // common to the image
  }
}

inline GreyImage mirrored(const GreyImage& image) {
  GreyImage result = image;
  for (int y = 0; y < image.height; ++y) {
    const auto row = result.pixels.begin() + static_cast<std::ptrdiff_t>(y) * image.width;
    std::reverse(row, row + image.width);
  }
  return result;
}

inline GreyImage negative(const GreyImage& image) {
  GreyImage result = image;
  for (auto& pixel : result.pixels) pixel = static_cast<std::uint8_t>(255 - pixel);
  return result;
}

/// Why a photograph shows `count` tags where there are more: they are found only in a mirror, as negatives, or with a
/// border of two cells (`wide`, where there is such a family); or, of one in a mirror, that tags of none of the
/// `families` are there.
inline std::string found_only_otherwise(const GreyImage& grey, size_t count, bool by_chance, const SearchImage& search,
                                        const SearchImage& wide, const std::vector<std::string>& families) {
  const auto some = [](size_t n) { return std::to_string(n) + (n == 1 ? " tag is" : " tags are"); };
  const size_t in_mirror = search(mirrored(grey)).size();
  // A single one may be chance among tags of another family.
  const std::string others = in_mirror == 1 && count == 0 ? tags_of_another_family(grey, families) : "";
  if (!others.empty()) return "it shows " + others + ": the family is wrong";
  if (in_mirror > 2 * count + (by_chance ? 1 : 0))
    return "the photograph is mirrored: " + some(in_mirror) +
           " found only after a flip. Export it from the camera without mirroring (selfie and web-camera programs "
           "mirror)";
  if (const auto tags = count == 0 && wide ? wide(grey) : std::vector<DetectedTag>{};
      tags.size() > 1)  // one may be chance
    return some(tags.size()) +
           " there with a border of two black cells, as on Kalibr's grids: family=" + tags.front().family +
           " takes them";
  const size_t as_negative = count == 0 ? search(negative(grey)).size() : 0;
  if (as_negative > 0)
    return some(as_negative) +
           " printed white on black. detector=aruco tags.with.white_on_black=true takes them, or print them as they "
           "are drawn";
  return {};
}

/// Why no tag of `families` was found: others are there, or the photograph is bad.
inline std::string why_not_these(const GreyImage& grey, const std::vector<std::string>& families) {
  const std::string others = tags_of_another_family(grey, families);
  return others.empty() ? why_nothing_is_found(grey) : "it shows " + others + ": the family is wrong";
}

/// The result for a photograph, without tags yet.
inline ImageTagsT registered(const Image& photograph) {
  ImageTagsT result;
  result.path = photograph.path()->str();
  result.sha256 = photograph.sha256()->str();
  if (photograph.camera()) result.camera = photograph.camera()->str();
  result.width = photograph.width(), result.height = photograph.height();
  return result;
}

/// Takes over the size of the file at `path`; an ImageFileError if it was registered with another.
inline void check_size(const std::string& path, int width, int height, ImageTagsT& result) {
  if (result.width > 0 && (width != result.width || height != result.height))
    throw ImageFileError(path + " has " + std::to_string(width) + " x " + std::to_string(height) +
                         " pixels, but was registered with " + std::to_string(result.width) + " x " +
                         std::to_string(result.height) + "; it was changed since");
  result.width = width, result.height = height;
}

/// Reads the photograph and searches it. A file that cannot be read is an error, or with `stop_at_bad` false a result
/// that says so in `problem`. `by_chance`: squares of the scene may be read as tags, so some are found in a mirrored
/// photograph, too. `wide` as in found_only_otherwise(), `families` are those searched for.
inline ImageTagsT search_image(const Context& context, const Image& photograph, bool stop_at_bad,
                               const SearchImage& search, const SearchImage& wide,
                               const std::vector<std::string>& families, bool by_chance = false) {
  ImageTagsT result = registered(photograph);
  GreyImage grey;
  const std::string path = context.resolve(photograph.uri()->str());
  try {
    grey = read_grey_image(path);
    check_size(path, grey.width, grey.height, result);
  } catch (const ImageFileError& error) {
    if (stop_at_bad) throw;
    result.problem = error.what();
    context.warn("left out: " + result.problem);
    return result;
  }
  const auto tags = search(grey);
  if (tags.empty() || by_chance) {
    const std::string otherwise = found_only_otherwise(grey, tags.size(), by_chance, search, wide, families);
    if (!otherwise.empty()) {
      result.problem = otherwise;
      context.warn(result.path + ": " + otherwise);
      return result;
    }
  }
  if (tags.empty()) {
    result.problem = why_not_these(grey, families);
    context.warn(result.path + ": no tag found" + (result.problem.empty() ? "" : "; ") + result.problem);
  }
  add_tags(tags, result);
  return result;
}

}  // namespace plumbline::detect
