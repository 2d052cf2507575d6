// evaluate.withhold and evaluate.lengths: ports and parameters.
#pragma once

#include "artifacts/plates.hpp"
#include "artifacts/points.hpp"
#include "plumbline/node.hpp"

namespace plumbline::judgement {

/// Cross-validation is a bench over `fold`: each control point is a check point in one of the folds.
struct EvaluateWithhold : Node {
  static constexpr Info info{"evaluate.withhold", "", 1,
                             "Makes some of the control points check points: k folds, one floor, or one of two halves"};
  In<Plates> plates{"plates", frame("frame=?F"), "anchor table"};
  In<Points> control{"control", frame("frame=?F"), "surveyed anchors"};
  Param<std::string> by{"by", "fold", one_of("fold", "floor"),
                        "fold: by the order of a hash of their names; floor: all of the floor with the number `fold`"};
  Param<int64_t> folds{"folds", 5, between(2, 1000), "number of folds; 2 for halves"};
  Param<int64_t> fold{"fold", 1, between(1, 1000), "which of them is withheld, from 1"};
  Out<Plates> plates_out{"plates", frame("frame=?F"), "with the role check for what is withheld"};
  Out<Points> control_out{"control", frame("frame=?F"), "likewise"};
  Out<Points> withheld{"withheld", frame("frame=?F"),
                       "the withheld points alone, to compare with; with their covariance"};

  void run(Context& context) override;
};

/// Distances in the sense of VDI/VDE 2634 part 1: largest length measurement error against A + L / K.
struct EvaluateLengths : Node {
  static constexpr Info info{"evaluate.lengths", "", 1,
                             "Length measurement errors of a model between reference points (VDI/VDE 2634): E_max"};
  In<Points> model{"model", frame("frame=?M"), "points of the model; any frame, lengths do not change with it"};
  In<Points> reference{"reference", frame("frame=?F"), "points whose distances are known"};
  Param<std::string> use{"use", "check", one_of("check", "control", "tie", "all"),
                         "role of the reference points that count"};
  Param<double> shortest{"shortest", 0.0, "m", at_least(0), "distances below are left out"};
  Param<double> a{"a", 0.001, "m", at_least(0), "A of the specification E = A + L / K"};
  Param<double> k{"k", 0.0, "1", at_least(0), "1 / K of the specification: allowed error per length"};
  Out<Points> errors{"errors", frame("frame=?F"), "each reference point with its largest length error as sigma x"};

  void run(Context& context) override;
};

}  // namespace plumbline::judgement
