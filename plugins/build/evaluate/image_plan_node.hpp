// plan.images: ports and parameters.
#pragma once

#include "artifacts/file.hpp"
#include "artifacts/image_plan.hpp"
#include "build/evaluate/bound_inputs.hpp"
#include "photo/block/image_plan.hpp"

namespace plumbline::judgement {

struct PlanImages : BoundInputs {
  static constexpr Info info{"plan.images", "", 1,
                             "What planned photographs of marker plates will reach at best, which of them say little, "
                             "and the cheapest photograph or surveyed marker to add"};
  Param<double> tolerance{"tolerance", 0.005, "m", between(1e-4, 1), "of the heights, for the expected pass rate"};
  Param<int64_t> fewest_plates{"fewest_plates", 3, between(1, 100), "a photograph that shows fewer says little"};
  Param<double> least_coverage{"least_coverage", 0.05, "1", between(0, 1),
                               "so does one whose tags cover a smaller share of it"};
  Param<double> survey_sigma{"survey_sigma", 0.001, "m", between(1e-6, 1), "of a marker that is surveyed as well"};
  Param<double> survey_cost{"survey_cost", 3.0, "1", between(1e-3, 1e3),
                            "photographs that surveying one more marker is worth"};
  Param<int64_t> additions{"additions", 20, between(0, 10000), "how many additions of a kind are listed"};
  Out<ImagePlan> plan{"plan", "the plan, judged"};
  Out<File> verdict{"verdict", "the plan in a few lines of text"};

  void run(Context& context) override;

 private:
  ImagePlanT pack(const block::BoundProblem& given, const block::ImagePlan& found,
                  const Eigen::MatrixXd& covariance) const;
};

}  // namespace plumbline::judgement
