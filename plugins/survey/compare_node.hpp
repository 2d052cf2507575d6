// survey.compare_epochs: two adjusted epochs to movements.
#pragma once

#include "artifacts/points.hpp"
#include "artifacts/survey_comparison.hpp"
#include "plumbline/node.hpp"

namespace plumbline::survey {

struct CompareEpochsNode : Node {
  static constexpr Info info{"survey.compare_epochs", "", 1,
                             "Tests whether two epochs of a network are congruent and which points have moved"};
  In<Points> first{"first", frame("frame=?S"), "adjusted points of the first epoch, with full covariance"};
  In<Points> second{"second", frame("frame=?S"), "adjusted points of the second epoch, with full covariance"};
  Param<std::string> datum{
      "datum", "automatic", one_of("automatic", "free", "fixed"),
      "free: epochs may be shifted and turned against each other; automatic: if one is a free network"};
  Param<double> alpha{"alpha", 0.05, "1", between(1e-6, 0.5), "error of the first kind of the global test"};
  Param<double> alpha0{"alpha0", 0.001, "1", between(1e-9, 0.5), "error of the first kind of the test of a point"};
  Param<double> power{"power", 0.80, "1", between(0.5, 0.999), "power that the detectable movement refers to"};
  Out<SurveyComparison> comparison{"comparison", frame("frame=?S"), "movements and tests"};
  void run(Context& context) override;
};

}  // namespace plumbline::survey
