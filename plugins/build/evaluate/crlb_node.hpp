// evaluate.crlb: ports and parameters.
#pragma once

#include "build/evaluate/bound_inputs.hpp"

namespace plumbline::judgement {

struct EvaluateCrlb : BoundInputs {
  static constexpr Info info{"evaluate.crlb", "", 1,
                             "Cramér-Rao bound of anchors in images of marker plates under control: the best that any "
                             "unbiased adjustment of these observations can do"};
  Out<Points> bound{"bound", frame("frame=?F"), "the anchors with the bound as their covariance"};

  void run(Context& context) override;
};

}  // namespace plumbline::judgement
