#include "build/evaluate/surface_deviation_node.hpp"

#include "building/judgement/surfaces.hpp"

namespace plumbline::judgement {

void SurfaceDeviation::run(Context& context) {
  SurfaceJudgementT judged = surface_judgement.unpack();
  DeviationT result;
  if (design->file_name()) result.design_file = design->file_name()->str();
  result.risk = judged.risk;
  // What surfaces fail or leave open lowers it.
  result.verdict = judged.passed + judged.undecided > 0 ? ToleranceVerdict::pass : ToleranceVerdict::not_measured;
  take_surfaces(std::move(judged), result);
  // That a verdict counts in no floor is no news where there are no floors.
  result.warnings.clear();
  if (result.not_judged > 0) context.metric("invalid", 1, "1");
  deviation.commit(result);
  accuracy.commit(AccuracyT());
}

}  // namespace plumbline::judgement
