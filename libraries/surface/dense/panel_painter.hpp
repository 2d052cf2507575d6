// One panel of an orthophoto, from several photographs that are held against each other: what stands before the panel
// is seen beside it from elsewhere, and is not painted onto it.
#pragma once

#include <vector>

#include "surface/dense/orthophoto.hpp"
#include "surface/dense/screens.hpp"

namespace plumbline::surface {

/// One photograph of a panel with what may stand before the panel in it.
struct PaintView {
  FacetView view;
  Screens screens;
};

/// Pixels of a panel by how they came about.
struct PaintCounts {
  std::int64_t unseen = 0, contradicted = 0, unchecked = 0, agreed = 0;
  std::int64_t all() const { return unseen + contradicted + unchecked + agreed; }
  PaintCounts& operator+=(const PaintCounts& other);
};

/// Brightness is made alike first (gain and offset of each photograph against the median of all). A pixel is then taken
/// from the first photograph with which most of those that show the place agree, their surroundings compared with the
/// shift that the photographs' ground pixels leave. Where no most agrees it stays black. Two photographs that differ
/// contradict each other: nobody knows which one shows the panel. Beyond the panel's edge, where a joint shows each
/// photograph another part of itself, and where its surface was not measured (glass shows each photograph something
/// else), the first photograph that is not hidden is taken then; that stays unchecked.
class PanelPainter {
 public:
  /// `views`: the best first, with their pixels. `beyond`: how far outside of its edge the panel is painted where
  /// nothing is yet [m]. What is given is kept by reference.
  PanelPainter(const PanelFace& face, const PanelSurface& surface, const std::vector<PaintView>& views, double beyond,
               Orthophoto& picture);
  int first_row() const { return top_; }
  int rows() const { return bottom_ - top_ + 1; }
  /// Paints rows of the picture, [from, to). Rows may be painted in any order, several at a time. Counts are of the
  /// panel itself.
  PaintCounts paint(int from, int to) const;

 private:
  struct Strip;
  int sample(size_t view, const Eigen::Vector3d& place, int level) const;
  Eigen::Vector3d place_of(int x, int y) const;
  bool on_panel(const Eigen::Vector3d& place) const;
  void make_brightness_alike();
  Strip strip(int from, int to) const;
  Shown decide(const Strip& strip, size_t at, bool own, std::uint8_t& grey) const;

  const PanelFace& face_;
  const PanelSurface& surface_;
  const std::vector<PaintView>& views_;
  double beyond_;
  Orthophoto& picture_;
  int left_ = 0, right_ = -1, top_ = 0, bottom_ = -1;
  int blur_ = 3, shift_ = 1;  ///< half widths of what is compared, and of how far it may lie beside [px of the picture]
  bool measured_;
  std::vector<int> level_;            ///< of each photograph's pyramid
  std::vector<float> gain_, offset_;  ///< of each photograph
  float alike_ = 12;                  ///< grey values that differ by less show the same
};

}  // namespace plumbline::surface
