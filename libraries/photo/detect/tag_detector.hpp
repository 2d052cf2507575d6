// AprilTag detection: libapriltag finds and decodes the tags, we measure their corners in the full-resolution image.
#pragma once

#include <Eigen/Core>
#include <array>
#include <memory>
#include <string>
#include <vector>

#include "photo/detect/edge_fit.hpp"

namespace plumbline {
struct GreyImage;
}

namespace plumbline::detect {

enum class Refinement {
  edges,     ///< our fit of the four edges to the grey values; its covariance per corner
  apriltag,  ///< libapriltag's corners as they are, with one fixed covariance
};

struct DetectorOptions {
  std::vector<std::string> families = {"tag36h11"};
  /// Linear factor by which the image is reduced for the search (corners are measured at full resolution all the same):
  /// 1, 1.5, 2, 3, 4, ...; 0 chooses by decimation_for(). Tags smaller than about 16 px · factor a side are lost to
  /// libapriltag; with 0 the search of tag_pyramid.hpp finds those of 24 px and more.
  double decimate = 0;
  int bits_corrected = 2;           ///< at most; families of 48 bits and more get 1, see affordable_bits_corrected()
  int max_hamming = 1;              ///< detections that needed more corrected bits are dropped as doubtful
  double min_decision_margin = 25;  ///< mean contrast of the bits against the threshold [grey values]
  Refinement refinement = Refinement::edges;
  EdgeFitOptions edge = {.gamma = 0, .grid = std::nullopt};  ///< the transfer curve is estimated from the image
  /// Added in quadrature to the fit's sigma [px]: lens blur that is not symmetric, print edges, JPEG blocks. Not
  /// derived, and little hangs on it where an adjustment estimates the corners' variance factor: on printed tags before
  /// real lenses that is 1.53, 1.43, 1.09 with 0, 0.02, 0.05 px (aruco_grid) and 1.15, 1.13, 1.04
  /// (charuco_lifecam_1280). 0.05 would make it 1 there and be seven times the errors of drawn photographs (0.007 px).
  double sigma_floor = 0.02;
  /// Standard deviation that libapriltag's own corners get [px], with `apriltag` and where the edge fit fails.
  double apriltag_sigma = 0.25;
};

/// One tag in one image. Pixel coordinates have the centre of the top-left pixel at (0, 0).
struct DetectedTag {
  std::string family;
  int id = 0;
  int hamming = 0;                         ///< bits corrected
  double decision_margin = 0;              ///< [grey values]
  std::array<Eigen::Vector2d, 4> corners;  ///< bottom left, bottom right, top right, top left of the upright tag [px]
  std::array<Eigen::Matrix2d, 4> covariances;  ///< [px²]
  bool refined = false;                        ///< corners are from the edge fit
  /// Of fitted corners: how far all edges of the image may be drawn inwards together, which `covariances` leave out
  /// [px]; 0: not known.
  double inset_sigma = 0;
};

/// Smallest factor that leaves libapriltag at most 4.5 megapixels to search: 3 for 24 megapixels, 5 for 100.
double decimation_for(int width, int height);

/// A detector and its decoding tables. Not for two threads at a time: make one per worker (tag36h11 takes 20 MB and 15
/// ms).
class TagDetector {
 public:
  /// Throws std::runtime_error that names the option that cannot be.
  explicit TagDetector(const DetectorOptions& options);
  ~TagDetector();
  TagDetector(TagDetector&&) noexcept;
  TagDetector& operator=(TagDetector&&) noexcept;

  /// Tags of the image, sorted by family, id and position; the same image gives the same bits.
  /// Needs about 30 bytes a pixel of the reduced image.
  std::vector<DetectedTag> detect(const GreyImage& image);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace plumbline::detect
