// Tags in images of a hundred megapixels that are never held whole.
//
// Rows arrive from the decoder; a window of them is kept. Reduced levels (1/2 and 1/8, or 1/1 and 1/4 for small images)
// are searched for quadrilaterals (level_search.hpp) as soon as a window below a figure's first row is known, and only
// where one lies are the full-resolution pixels looked at: edges, code, and a copy of the surroundings for the fit of
// the edges that all detectors share. Tags taller than the window are read in a second pass through the file.
#pragma once

#include <functional>
#include <vector>

#include "photo/detect/square_code.hpp"
#include "photo/detect/tag_detector.hpp"
#include "photo/images/grey_rows.hpp"

namespace plumbline::detect {

struct PyramidOptions {
  /// Shortest side of a tag that has to be found [px]. Below 24 every pixel is searched instead of every second; 0: 12
  /// up to 30 megapixels, 24 above.
  double smallest_tag = 0;
  int min_contrast = 24;  ///< within a tag's surroundings [grey values]
  int max_hamming = 1;    ///< bits that may be corrected, less where the family's codes lie closer
  /// See DetectorOptions, but of grey values as they are, where libapriltag sharpens first: half of min_contrast, so
  /// that a tag of the least contrast that is looked for is read [grey values].
  double min_decision_margin = 12;
  Refinement refinement = Refinement::edges;
  EdgeFitOptions edge = {.gamma = 0, .grid = std::nullopt};
  double sigma_floor = 0.02;      ///< [px]
  double unrefined_sigma = 0.25;  ///< of corners whose edges could not be fitted [px]
};

struct PyramidResult {
  std::vector<DetectedTag> tags;  ///< sorted by family, id and position
  bool mirrored = false;  ///< a tag of the families was seen in a mirror, four of one that is easily read by chance
};

class TagPyramid {
 public:
  TagPyramid(std::vector<SquareFamily> families, const PyramidOptions& options);

  /// A part of the same image again: left, top, width, height [px].
  using ReadPart = std::function<GreyImage(int, int, int, int)>;

  /// May be used by several threads at a time; the same image gives the same bits. Takes a fifth of the image's bytes
  /// or 1200 rows, a third of that for the levels, and a copy of every tag's surroundings.
  PyramidResult detect(GreyRows& rows, const ReadPart& part) const;

  /// Of an image that is held.
  PyramidResult detect(const GreyImage& image) const;

  /// Bytes that detect() takes, without the decoder and the tags.
  static double memory(int width, int height);

 private:
  std::vector<SquareDecoder> decoders_;
  PyramidOptions options_;
};

}  // namespace plumbline::detect
