// Panels of the design that are to be hung and that no plan has, because nothing of them was measured: work all the
// same.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "artifacts/design.hpp"
#include "loop/fit/facade.hpp"

namespace plumbline::loop {

struct UnplannedPanel {
  std::string id, guid;
  int floor = 0;                                                ///< storey, counted from 1 at the bottom; 0: not known
  Eigen::Vector3d place = Eigen::Vector3d::Constant(kUnknown);  ///< its reference point by design [m]
  std::string why;                                              ///< with what to do
};

/// What the design says of panels that were not measured.
class UnmeasuredDesign {
 public:
  /// `brackets`: anchors that the judgement has, measured or not; `guids` of theirs.
  UnmeasuredDesign(const DesignT& design, const std::vector<Bracket>& brackets, const std::vector<std::string>& guids);

  /// As the anchors count storeys; where none of its own storey is known, as the design orders them. 0: in none.
  int floor_of(const DesignElementT& panel) const;
  /// Why it is not planned, of one whose anchors nobody measured, or that has none.
  std::string why_not_planned(const DesignElementT& panel) const;

 private:
  bool has_anchor(const DesignElementT& panel) const;

  std::vector<Eigen::Vector3d> anchors_;
  std::map<std::string, int> floor_;  ///< by GlobalId of the storey
};

}  // namespace plumbline::loop
