// evaluate.poses: how far estimated poses are from the true ones.
#pragma once

#include "artifacts/poses.hpp"
#include "plumbline/node.hpp"

namespace plumbline::judgement {

struct EvaluatePoses : Node {
  static constexpr Info info{"evaluate.poses", "", 2,
                             "Errors of poses against the truth as metrics: position, rotation, squared errors over "
                             "their covariance, missing ones"};
  In<Poses> poses{"poses", frame("frame=?F"), "estimated exterior orientations"};
  In<Poses> truth{"truth", frame("frame=?F"), "the true ones; every image of it counts"};
  Param<double> wrong_above{"wrong_above", 0.1, "m", at_least(0),
                            "a projection centre that is farther off counts as wrong"};
  Param<double> max_missing{"max_missing", 0.2, "1", between(0, 1),
                            "share of the images that may have no pose; more is an error"};
  Out<Poses> kept{"poses", frame("frame=?F"), "the poses that are not wrong"};

  void run(Context& context) override;
};

}  // namespace plumbline::judgement
