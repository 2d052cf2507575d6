// Square markers of any dictionary: OpenCV finds and decodes them, we measure their corners in the full-resolution
// image with the same fit of the edges as for AprilTags.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "photo/detect/likeness.hpp"
#include "photo/detect/tag_detector.hpp"
#include "photo/detect/tag_dictionary.hpp"

namespace plumbline::detect {

struct ArucoOptions {
  double correction_rate = 0.6;  ///< share of the dictionary's correctable bits that may be corrected, 0 … 1
  double min_side = 10;          ///< smallest side of a tag that is looked for [px]
  bool white_on_black = false;   ///< tags printed in negative, too
  Refinement refinement = Refinement::edges;                 ///< `apriltag` stands for the detector's own corners
  EdgeFitOptions edge = {.gamma = 0, .grid = std::nullopt};  ///< the transfer curve is estimated from the image
  double sigma_floor = 0.02;                                 ///< added in quadrature to the fit's sigma [px]
  double unrefined_sigma = 0.3;                              ///< of corners that are OpenCV's own [px]
  /// What a tag must look like; unset: by how likely chance reads a code of the dictionary.
  std::optional<LikenessLimit> limit;
};

struct ArucoSearch {
  std::vector<DetectedTag> tags;
  int unlike = 0;    ///< read as a tag, but do not look like its drawing, and are left out
  int mirrored = 0;  ///< tags seen in a mirror or printed mirrored
};

/// May be used by several threads at a time.
class ArucoDetector {
 public:
  ArucoDetector(const TagDictionary& dictionary, const ArucoOptions& options);
  ~ArucoDetector();
  ArucoDetector(const ArucoDetector&) = delete;
  ArucoDetector& operator=(const ArucoDetector&) = delete;

  /// Tags of the image, sorted by id and position, corners in the order of DetectedTag; the same image gives the same
  /// bits.
  std::vector<DetectedTag> detect(const GreyImage& image) const { return search(image).tags; }
  ArucoSearch search(const GreyImage& image) const;

  /// Probability that a square of the scene with cells of chance is read as a tag.
  double chance() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace plumbline::detect
