// Small plates that are panels because of how they stand: edge to edge.
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <vector>

#include "building/ifc/facade_lines.hpp"
#include "building/ifc/what_hangs.hpp"
#include "geometry/panel_fit.hpp"

namespace plumbline::ifc {
namespace {

/// Plates up to this size [m] may be parts of a fixing: base plates and packing are, panels are larger.
constexpr double kLargestFixing = 0.6;
/// Widest joint between two panels of a field, and most that one stands before the other [m].
constexpr double kFieldJoint = 0.05;
/// Panels overlap by no more than rounding [m].
constexpr double kOverlap = 0.005;
/// Two base plates may stand side by side where two panels meet; so many edge to edge are panels.
constexpr int kField = 3;
const double kParallel = std::cos(5 * std::numbers::pi / 180);

bool is_small_plate(const Element& e) {
  return e.is_panel && !e.is_cladding && e.has_box && e.ifc_class.starts_with("IfcPlate") &&
         (e.box_high - e.box_low).maxCoeff() <= kLargestFixing;
}

/// Whether they lie in one plane, edge to edge, along half of the shorter edge or more.
bool follow_each_other(const Element& a, const Element& b) {
  const auto thin_a = thin_axis(a), thin_b = thin_axis(b);
  if (!thin_a || !thin_b) return false;
  const Eigen::Matrix3d axes = axes_of(a);
  if (std::abs(axes.col(*thin_a).dot(axes_of(b).col(*thin_b))) < kParallel) return false;
  // The box of b along the axes of a, about the middle of a.
  const Eigen::Vector3d middle = axes.transpose() * (middle_of(b) - middle_of(a));
  const Eigen::Vector3d half_a = 0.5 * (a.box_high - a.box_low);
  const Eigen::Vector3d half_b = (axes.transpose() * axes_of(b)).cwiseAbs() * (0.5 * (b.box_high - b.box_low));
  if (std::abs(middle[*thin_a]) > kFieldJoint) return false;
  const int first = (*thin_a + 1) % 3, second = (*thin_a + 2) % 3;
  const auto apart = [&](int axis) { return std::abs(middle[axis]) - half_a[axis] - half_b[axis]; };
  const auto edge_to_edge = [&](int across, int along) {
    return apart(across) >= -kOverlap && apart(across) <= kFieldJoint &&
           -apart(along) >= std::min(half_a[along], half_b[along]);
  };
  return edge_to_edge(first, second) || edge_to_edge(second, first);
}

using Cell = std::array<int, 3>;

Cell cell_of(const Element& plate) {
  Cell cell;
  for (int k = 0; k < 3; ++k)
    cell[k] = static_cast<int>(std::floor(std::clamp(middle_of(plate)[k], -1e8, 1e8) / (kLargestFixing + kFieldJoint)));
  return cell;
}

/// Groups of plates that follow one another, by index.
class Fields {
 public:
  explicit Fields(const std::vector<const Element*>& plates) : plates_(plates), group_(plates.size(), -1) {
    for (std::size_t i = 0; i < plates.size(); ++i) cells_[cell_of(*plates[i])].push_back(i);
    for (std::size_t i = 0; i < plates.size(); ++i)
      if (group_[i] < 0) grow(i);
  }
  int size_of_field(std::size_t plate) const { return sizes_[group_[plate]]; }

 private:
  void grow(std::size_t first) {
    const int group = static_cast<int>(sizes_.size());
    std::vector<std::size_t> open{first};
    group_[first] = group, sizes_.push_back(0);
    while (!open.empty()) {
      const std::size_t at = open.back();
      open.pop_back(), ++sizes_.back();
      for_near(at, [&](std::size_t other) {
        if (group_[other] >= 0 || !follow_each_other(*plates_[at], *plates_[other])) return;
        group_[other] = group, open.push_back(other);
      });
    }
  }

  template <class Visit>
  void for_near(std::size_t plate, const Visit& visit) const {
    const Cell cell = cell_of(*plates_[plate]);
    for (int x = -1; x <= 1; ++x)
      for (int y = -1; y <= 1; ++y)
        for (int z = -1; z <= 1; ++z)
          if (const auto found = cells_.find({cell[0] + x, cell[1] + y, cell[2] + z}); found != cells_.end())
            for (const std::size_t other : found->second) visit(other);
  }

  const std::vector<const Element*>& plates_;
  std::map<Cell, std::vector<std::size_t>> cells_;
  std::vector<int> group_, sizes_;
};

}  // namespace

std::set<const Element*> may_be_fixings(const Design& design) {
  std::vector<const Element*> plates;
  for (const Element& element : design.elements)
    if (is_small_plate(element)) plates.push_back(&element);
  const Fields fields(plates);
  std::set<const Element*> alone;
  for (std::size_t i = 0; i < plates.size(); ++i)
    if (fields.size_of_field(i) < kField) alone.insert(plates[i]);
  return alone;
}

}  // namespace plumbline::ifc
