// detect.aruco: square markers of OpenCV's dictionaries, the AprilTag families and dictionaries of one's own.
#pragma once

#include <map>
#include <memory>
#include <mutex>
#include <utility>

#include "artifacts/file.hpp"
#include "detector_node.hpp"
#include "photo/detect/aruco_detector.hpp"

namespace plumbline::detect {

struct DetectAruco : Node {
  static constexpr Info info{"detect.aruco", "detector", 4,
                             "Finds ArUco markers (also those of a ChArUco board) and measures their corners"};
  Each<Image> images{"images", "photographs: JPEG, PNG or TIFF"};
  Optional<File> family{"family", "the dictionary of read.tag_family, in place of `dictionary`"};
  Param<std::string> dictionary{"dictionary", "DICT_6X6_1000",
                                "DICT_4X4_50 ... DICT_7X7_1000, DICT_ARUCO_ORIGINAL, tag36h11, tag36h10, tag25h9 or "
                                "tag16h5"};
  Param<double> correction_rate{"correction_rate", 0.6, between(0, 1),
                                "share of the dictionary's correctable bits that are corrected"};
  Param<double> min_side{"min_side", 10.0, "px", between(6, 10000), "smallest side of a tag that is looked for"};
  Param<bool> white_on_black{"white_on_black", false, "look for tags in negative, too"};
  Param<std::string> refine{"refine", "edges", one_of("edges", "opencv"),
                            "edges: corners from a fit of the four edges, with its covariance; opencv: OpenCV's own"};
  Param<double> curvature_sigma{"curvature_sigma", 2e-5, "1/px", at_least(0),
                                "how much a lens may bow a straight edge; 0: not at all"};
  Param<double> sigma_floor{"sigma_floor", 0.02, "px", between(0, 10), "added in quadrature to the fit's sigma"};
  Param<double> opencv_sigma{"opencv_sigma", 0.3, "px", between(0.001, 10), "sigma of corners that are OpenCV's own"};
  Param<double> min_likeness{"min_likeness", 0.0, between(-1, 1),
                             "smallest correlation of a tag's grey values with its drawing; 0: by how easily chance "
                             "reads a code of the dictionary (0.85 from 1 % on, 0.7 from 0.01 % on), -1: none"};
  Param<std::string> on_bad_image{"on_bad_image", "error", one_of("error", "leave_out"),
                                  "what to do with a photograph that cannot be read: stop, or go on without it"};
  Out<ImageTags> observations{"observations", "the tags with the covariance of every corner"};

  void run(Context& context) override {
    const double pixels = static_cast<double>(images->width()) * images->height();
    context.reserve_memory(static_cast<uint64_t>(static_cast<double>(images->size()) + 12 * pixels));
    ArucoOptions options;
    options.correction_rate = *correction_rate, options.min_side = *min_side, options.white_on_black = *white_on_black;
    options.refinement = *refine == "edges" ? Refinement::edges : Refinement::apriltag;
    options.edge.curvature_sigma = *curvature_sigma;
    options.sigma_floor = *sigma_floor, options.unrefined_sigma = *opencv_sigma;
    if (*min_likeness != 0) options.limit = LikenessLimit{*min_likeness, 1e300};
    const TagDictionary dictionary_used = codes();
    const ArucoDetector detector(dictionary_used, options);
    SearchImage wide;
    if (dictionary_used.border == 1 && !(family && family->content()->size() > 0))
      wide = [&](const GreyImage& grey) {
        return ArucoDetector(builtin_dictionary(dictionary_used.name + "b2"), options).detect(grey);
      };
    ArucoSearch first;
    bool searched = false;  // the photograph as it is; later calls look at it in a mirror
    ImageTagsT result = search_image(
        context, *images, *on_bad_image == "error",
        [&](const GreyImage& grey) {
          ArucoSearch found = detector.search(grey);
          if (!std::exchange(searched, true)) first = found;
          return std::move(found.tags);
        },
        wide, {dictionary_used.name}, detector.chance() >= kWeakChance);
    if (!result.tags.empty() && first.mirrored > 2 * static_cast<int>(result.tags.size())) {
      result.problem = "the photograph or the dictionary is mirrored: " + std::to_string(first.mirrored) +
                       " tags are found only after a flip, and " + std::to_string(result.tags.size()) +
                       " without. Export it from the camera without mirroring";
      result.tags.clear();
      context.warn(result.path + ": " + result.problem);
    } else if (!result.tags.empty() && first.mirrored > 0)
      context.warn(
          result.path + ": " + std::to_string(first.mirrored) + (first.mirrored == 1 ? " tag is" : " tags are") +
          " mirrored (printed so, or seen in glass or water) and left out. Print them again as they are drawn");
    observations.commit(result);
  }

 private:
  TagDictionary codes() const {
    if (!family) return builtin_dictionary(*dictionary);
    const std::string name = family->name()->str();
    const auto* content = family->content();
    if (content->size() == 0) return builtin_dictionary(name);
    return parse_dictionary(std::string(content->begin(), content->end()), name);
  }
};

}  // namespace plumbline::detect
