// Where a photograph has the markers of a ChArUco board: which of its two patterns it is, and a homography with the
// radial distortion of a wide lens.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <map>
#include <vector>

#include "photo/detect/board.hpp"
#include "photo/detect/tag_detector.hpp"

namespace plumbline::detect {

/// One coefficient of radial distortion about the middle of the image, by division: a pixel at d from there lies at
/// d / (1 + λ d²/h²) without it, h half the image's diagonal. −0.9 reaches as far as fisheyes do. Source: Fitzgibbon
/// (2001), Simultaneous linear estimation of multiple view geometry and lens distortion.
struct DivisionLens {
  Eigen::Vector2d middle = Eigen::Vector2d::Zero();
  double half_diagonal = 1, lambda = 0;

  /// A pixel as a lens without distortion has it.
  Eigen::Vector2d straight(const Eigen::Vector2d& pixel) const {
    const Eigen::Vector2d d = pixel - middle;
    return middle + d / (1 + lambda * d.squaredNorm() / (half_diagonal * half_diagonal));
  }
  /// The other way; nan where no pixel is.
  Eigen::Vector2d distorted(const Eigen::Vector2d& at) const {
    const Eigen::Vector2d u = at - middle;
    const double root = 1 - 4 * lambda * u.squaredNorm() / (half_diagonal * half_diagonal);
    return middle + 2 / (1 + std::sqrt(root)) * u;
  }
};

struct CharucoLayout {
  bool legacy = false;  ///< the top left square holds a marker, as OpenCV before 4.6 drew boards of even rows
  double misfit = 1e9;  ///< of the median marker [px]
  double score = 1e9;   ///< mean over all markers, each bounded: every other row alone fits the wrong layout exactly
  Eigen::Matrix3d onto_straight = Eigen::Matrix3d::Identity();  ///< from squares of the board
  DivisionLens lens;
  Eigen::Vector2d pixel(const Eigen::Vector2d& squares) const;
};

/// Centres of a ChArUco board's markers by id [m].
std::map<int, Eigen::Vector2d> charuco_markers(const Board& board, bool legacy);

/// The layout that misses the markers' centres least; of a lens without distortion if that misses by less than `bound`
/// [px], else the best of lenses of all widths.
CharucoLayout find_layout(const Board& board, const std::vector<DetectedTag>& tags, int width, int height,
                          double bound);

/// Corners of markers that are drawn turned, all alike (OpenCV draws libapriltag's families upside down), get the order
/// that they have on the board.
void turn_alike(std::vector<DetectedTag>& tags, const std::map<int, Eigen::Vector2d>& centres,
                const CharucoLayout& layout, const Board& board);

}  // namespace plumbline::detect
