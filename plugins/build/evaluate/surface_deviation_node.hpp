// evaluate.surface_deviation: ports.
#pragma once

#include "artifacts/accuracy.hpp"
#include "artifacts/design.hpp"
#include "artifacts/deviation.hpp"
#include "artifacts/surface_judgement.hpp"
#include "plumbline/node.hpp"

namespace plumbline::judgement {

struct SurfaceDeviation : Node {
  static constexpr Info info{
      "evaluate.surface_deviation", "", 1,
      "Surfaces and joints alone as the judgement of the building, where nobody measured anchors, "
      "as a scan does"};
  In<Design> design{"design", frame("frame=?F"), "the design"};
  In<SurfaceJudgement> surface_judgement{"surface_judgement", "surfaces and joints against their rules"};
  Out<Deviation> deviation{"deviation", frame("frame=?F"), "the judgement, without anchors"};
  Out<Accuracy> accuracy{"accuracy", frame("frame=?F"), "without comparisons, as there is nothing to compare with"};

  void run(Context& context) override;
};

}  // namespace plumbline::judgement
