// evaluate.crossval: how well control points are predicted by adjustments that they had no part in.
#pragma once

#include <map>

#include "artifacts/file.hpp"
#include "tag_adjuster_node.hpp"

namespace plumbline::block {

struct EvaluateCrossval : TagAdjusterNode {
  static constexpr Info info{"evaluate.crossval", "", 3,
                             "Cross-validation: each control point against the adjustment without it, by folds or "
                             "floors; or two halves of photographs and control against each other"};
  List<ImageTags> observations{"observations", "tags of every image"};
  In<Poses> poses{"poses", frame("frame=?F"), "approximate poses"};
  In<Camera> camera{"camera", "interior orientation; its covariance is the prior of a self-calibration"};
  In<Plates> plates{"plates", frame("frame=?F"), "which tag stands for which anchor, control and check anchors"};
  In<Points> control{"control", frame("frame=?F"), "surveyed anchors with their covariance"};
  Param<std::string> by{"by", "fold", one_of("fold", "floor", "halves"),
                        "fold: k folds by a hash of the names; floor: one floor after the other; halves: every second "
                        "photograph and every second control point make a model of their own"};
  Param<int64_t> folds{"folds", 5, between(2, 1000), "number of folds"};
  Out<Points> differences{"differences", frame("frame=?F"),
                          "survey minus model of each point withheld, or one half minus the other of each anchor, with "
                          "the standard deviation of the difference; without control that contradicts"};
  Out<File> table{"table",
                  "the differences as CSV: fold, anchor, floor, dx, dy, dz, their sigmas, normalised dz; "
                  "control that contradicts as fold 'left out'"};

  void run(Context& context) override;

 private:
  struct Difference {
    std::string fold, anchor;
    int floor = 0;
    Eigen::Vector3d off = Eigen::Vector3d::Zero(), sigma = Eigen::Vector3d::Zero();
  };
  struct Sums {
    std::vector<Difference> all;
    double nees_z = 0, nees_3d = 0;
    std::vector<Difference> left_out;  ///< control that contradicts: in the table alone
  };
  TagBlockBuilder builder_of(bool every, size_t first) const;
  std::map<std::string, int> floors() const;
  Sums withheld(Context& context);
  Sums halves(Context& context);
  void tell(Context& context, const Sums& sums);
};

}  // namespace plumbline::block
