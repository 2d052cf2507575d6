// Anchors and panels by place: a topic shows those around it, and there may be thousands of topics.
#pragma once

#include <array>
#include <map>
#include <vector>

#include "artifacts/deviation.hpp"

namespace plumbline::ifc {

class BcfSurroundings {
 public:
  /// Keeps references into `deviation`.
  explicit BcfSurroundings(const DeviationT& deviation);

  struct Around {
    std::vector<const AnchorDeviationT*> anchors;
    std::vector<const PanelDeviationT*> panels;
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
};

}  // namespace plumbline::ifc
