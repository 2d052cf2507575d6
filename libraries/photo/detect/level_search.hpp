// Quadrilaterals in one reduced level of an image that arrives row by row.
//
// Each row of 4 × 4 tiles gets its threshold from the darkest and the brightest pixel of the 3 × 3 tiles around (as in
// Wang and Olson, AprilTag 2, IROS 2016); tiles without contrast hold no figure at all, so most of an image costs its
// minima and maxima only. Outlines are followed along the cracks between pixels. The outline of a convex figure has
// exactly the length of its bounding box; one that has become longer than that is left at once, which is where brick,
// mesh and text end. What remains is split at its four extreme points and fitted with four lines.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

namespace plumbline::detect {

struct LevelSearchOptions {
  bool bright = false;  ///< figures brighter than what is around them, in place of darker ones
  /// Of the way from the darkest to the brightest pixel around an edge. Below a half, figures that touch at their
  /// corners come apart: a blurred crossing of black and white is half way.
  double threshold = 0.5;
  int min_contrast = 24;  ///< between the darkest and the brightest pixel around an edge [grey values]
  double min_side = 8;    ///< shortest side of a quadrilateral [px of this level]
  bool keep_all = false;  ///< no row is forgotten, so that unfinished figures can be followed again
};

struct LevelQuad {
  std::array<Eigen::Vector2d, 4>
      corners;  ///< clockwise as seen; corner of the top-left pixel at (0, 0) [px of this level]
};

struct Outlines {
  std::vector<LevelQuad> quads;
  std::vector<std::array<int, 2>> unfinished;  ///< first pixel (x, y) of figures that reach below the rows known so far
};

class LevelSearch {
 public:
  /// `kept_rows`: rows that are usually known, but not followed yet; only memory is reserved by it.
  LevelSearch(int width, int height, int kept_rows, const LevelSearchOptions& options);

  /// The next row, `width` grey values.
  void add_row(const std::uint8_t* grey);
  /// Rows in which figures can be followed by now.
  int known_rows() const { return known_; }
  /// Follows the figures whose first pixel is above row `end`, at most known_rows(), and was not yet.
  void follow(int end, Outlines& out);
  /// One figure by its first pixel, for those that were unfinished.
  void follow_again(std::array<int, 2> first, Outlines& out);

 private:
  static constexpr int tile = 4;
  void finish_tile_row();
  void binarise(int tile_row, const std::uint8_t* threshold);
  std::uint8_t* pixel(int x, int y) {
    return &binary_[static_cast<std::size_t>(y - first_ + 1) * stride_ + static_cast<std::size_t>(x + 1)];
  }
  void make_room();
  enum class End { closed, wiggly, unfinished };
  End trace(int x, int y, bool only_new);
  bool fit(LevelQuad& quad) const;

  int width_, height_;
  LevelSearchOptions options_;
  std::size_t stride_;
  int tiles_;                            // a row of tiles
  int rows_ = 0, known_ = 0, next_ = 0;  // rows added, rows binarised, next row to look for first pixels in
  std::vector<std::uint8_t> grey_;       // rows of three rows of tiles, a ring
  std::vector<std::uint8_t> low_, high_, limit_, scratch_;
  std::array<std::vector<std::uint8_t>, 3> tile_low_, tile_high_;  // a ring, by row of tiles
  int first_ = 0;                     // row that binary_ begins with, after one empty row; rows above are forgotten
  std::vector<std::uint8_t> binary_;  // 0: none, 1: of a figure, 3: a followed figure's convex upper left corner
  std::vector<std::array<std::int16_t, 2>> path_;  // of the last outline, room for more
  std::size_t path_length_ = 0;
  int left_ = 0, right_ = 0, top_ = 0, bottom_ = 0;  // of path_
};

}  // namespace plumbline::detect
