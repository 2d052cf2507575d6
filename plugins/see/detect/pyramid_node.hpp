// detect.tag_pyramid: AprilTags and ArUco markers in images of any size, which are never held whole.
#pragma once

#include "artifacts/file.hpp"
#include "detector_node.hpp"
#include "photo/detect/tag_family.hpp"
#include "photo/detect/tag_pyramid.hpp"

namespace plumbline::detect {

struct DetectTagPyramid : Node {
  static constexpr Info info{"detect.tag_pyramid", "detector", 4,
                             "Finds square tags in large images strip by strip and measures their corners"};
  Each<Image> images{"images", "photographs: JPEG, PNG or TIFF; baseline JPEG is decoded strip by strip"};
  Optional<File> family{"family", "the family or dictionary of read.tag_family, in place of `families`"};
  Out<ImageTags> observations{"observations", "the tags with the covariance of every corner"};
  Param<std::vector<std::string>> families{
      "families", {"tag36h11"}, "libapriltag's families (tag36h11, tagStandard41h12, ...) and OpenCV's dictionaries"};
  Param<double> smallest_tag{"smallest_tag", 0.0, "px", between(0, 10000),
                             "shortest side that has to be found; below 24 every pixel is searched, else every second "
                             "each way. 0: 12 up to 30 megapixels, 24 above"};
  Param<int64_t> min_contrast{"min_contrast", 24, "grey levels", between(5, 200),
                              "between the darkest and the brightest pixel of a tag's surroundings"};
  Param<int64_t> max_hamming{"max_hamming", 1, between(0, 5),
                             "bits that may be corrected, at most what the smallest distance of the codes allows"};
  Param<double> min_decision_margin{"min_decision_margin", 12.0, "grey levels", at_least(0),
                                    "tags that were decoded with less contrast are dropped"};
  Param<double> curvature_sigma{"curvature_sigma", 2e-5, "1/px", at_least(0),
                                "how much a lens may bow a straight edge; 0: not at all"};
  Param<double> sigma_floor{"sigma_floor", 0.02, "px", between(0, 10), "added in quadrature to the fit's sigma"};
  Param<double> unrefined_sigma{"unrefined_sigma", 0.25, "px", between(0.001, 10),
                                "sigma of corners whose edges cannot be fitted"};
  Param<std::string> on_bad_image{"on_bad_image", "error", one_of("error", "leave_out"),
                                  "what to do with a photograph that cannot be read: stop, or go on without it"};

  void run(Context& context) override {
    context.reserve_memory(static_cast<uint64_t>(TagPyramid::memory(images->width(), images->height())));
    PyramidOptions options;
    options.smallest_tag = *smallest_tag;
    options.min_contrast = static_cast<int>(*min_contrast);
    options.max_hamming = static_cast<int>(*max_hamming);
    options.min_decision_margin = *min_decision_margin;
    options.edge.curvature_sigma = *curvature_sigma;
    options.sigma_floor = *sigma_floor, options.unrefined_sigma = *unrefined_sigma;
    const TagPyramid detector(wanted(), options);
    ImageTagsT result = registered(*images);
    try {
      search(context, detector, result);
    } catch (const ImageFileError& error) {
      if (*on_bad_image == "error") throw;
      result.problem = error.what();
      context.warn("left out: " + result.problem);
    }
    observations.commit(result);
  }

 private:
  void search(const Context& context, const TagPyramid& detector, ImageTagsT& result) {
    const std::string path = context.resolve(images->uri()->str());
    const auto rows = open_grey_rows(path);
    check_size(path, rows->width(), rows->height(), result);
    const PyramidResult found = detector.detect(*rows, [&](int left, int top, int width, int height) {
      return read_grey_part(path, left, top, width, height);
    });
    add_tags(found.tags, result);
    if (!found.tags.empty()) return;
    if (found.mirrored) {
      result.problem =
          "the photograph is mirrored: tags are found only after a flip. Export it from the camera without mirroring "
          "(selfie and web-camera programs mirror)";
    } else {
      constexpr int kSide = 2048;  // the middle tells what is wrong without holding the image
      const GreyImage middle =
          read_grey_part(path, (rows->width() - kSide) / 2, (rows->height() - kSide) / 2, kSide, kSide);
      std::vector<std::string> names;
      for (const SquareFamily& one : wanted()) names.push_back(one.name);
      result.problem = found_only_otherwise(
          middle, 0, false, [](const GreyImage&) { return std::vector<DetectedTag>{}; },
          [&](const GreyImage& grey) { return with_wide_borders(grey); }, names);
      if (result.problem.empty()) result.problem = why_not_these(middle, names);
    }
    context.warn(result.path + ": " + (found.mirrored ? "" : "no tag found") +
                 (!found.mirrored && !result.problem.empty() ? "; " : "") + result.problem);
  }

  /// Tags of the same families, but with a border of two cells.
  std::vector<DetectedTag> with_wide_borders(const GreyImage& grey) const {
    std::vector<SquareFamily> wide;
    if (family && family->content()->size() > 0) return {};
    for (const SquareFamily& plain : wanted())
      if (plain.border == 1 && !plain.bright_inside) wide.push_back(square_family(plain.name + "b2"));
    return wide.empty() ? std::vector<DetectedTag>{} : TagPyramid(std::move(wide), {}).detect(grey).tags;
  }

  std::vector<SquareFamily> wanted() const {
    if (family && family->content()->size() > 0)
      return {dictionary_square_family(
          parse_dictionary(std::string(family->content()->begin(), family->content()->end()), family->name()->str()))};
    std::vector<SquareFamily> result;
    for (const std::string& name : family ? std::vector<std::string>{family->name()->str()} : *families)
      result.push_back(square_family(name));
    return result;
  }
};

}  // namespace plumbline::detect
