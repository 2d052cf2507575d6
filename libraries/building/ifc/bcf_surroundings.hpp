// Anchors, panels and what else has a shape by place: a topic shows those around it, and there may be thousands.
#pragma once

#include <array>
#include <map>
#include <vector>

#include "artifacts/deviation.hpp"
#include "building/ifc/design.hpp"

namespace plumbline::ifc {

class BcfSurroundings {
 public:
  /// Keeps references into both. `elements`: of the design; null: what stands before something is not known.
  explicit BcfSurroundings(const DeviationT& deviation, const std::vector<Element>* elements = nullptr);

  struct Around {
    std::vector<const AnchorDeviationT*> anchors;
    std::vector<const PanelDeviationT*> panels;
    std::vector<const Element*>
        shapes;  ///< with a box of their own: no openings, and no wholes of which parts are here
  };
  /// All that may reach into the sphere, in the order of the deviation, and some beside it [m].
  Around around(const Eigen::Vector3d& centre, double radius) const;

 private:
  using Cell = std::array<int, 3>;
  template <class T>
  struct Index {
    std::vector<const T*> all;
    std::map<Cell, std::vector<std::size_t>> cells;
    std::vector<std::size_t> large;  ///< those that reach farther than a cell
    void add(const T& item, const Eigen::Vector3d& centre, double reach);
    std::vector<const T*> near(const Eigen::Vector3d& centre, double radius) const;
  };
  Index<AnchorDeviationT> anchors_;
  Index<PanelDeviationT> panels_;
  Index<Element> shapes_;
};

}  // namespace plumbline::ifc
