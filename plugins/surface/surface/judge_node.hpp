// Surfaces against the rules of a design or a pipeline.
#pragma once

#include "artifacts/block.hpp"
#include "artifacts/design.hpp"
#include "artifacts/file.hpp"
#include "artifacts/surface_judgement.hpp"
#include "artifacts/surfaces.hpp"
#include "artifacts/survey_network.hpp"
#include "building/judgement/whose_surface.hpp"
#include "plumbline/node.hpp"

namespace plumbline::surface {

struct JudgeSurfaces : Node {
  static constexpr Info info{"surface.judge", "", 7,
                             "Flatness, bow, twist, place, steps and joint widths against rules: pass, fail or "
                             "undecided by conformance probability"};
  In<Surfaces> surfaces{"surfaces", frame("frame=?F"), "panels and joints with their covariance"};
  Optional<Design> design{"design", frame("frame=?F"),
                          "whose classes, storeys and properties rules may name; without it, names alone"};
  Optional<Block> block{
      "block", frame("frame=?B"),
      "the adjusted block behind the orientations: one that fails its global tests shows nothing; one whose "
      "camera model does not hold is less certain"};
  Optional<SurveyNetwork> network{"network", frame("frame=?N"),
                                  "the survey behind them: likewise where it contradicts itself"};
  Param<std::vector<std::string>> rules{
      "rules", std::vector<std::string>{},
      "limits: 'class=IfcPlate & storey=Level 2: flatness(1m)=3mm, bow=4mm, twist=2mm, step=2mm, joint=+4/-3mm, "
      "narrowest=8mm, widest=20mm, offset=+5/-10mm, shift=6mm'; joint is the width against the design's, offset what "
      "a panel's corners stand out of its face, shift how far a joint lies beside its place; of a joint, rules that "
      "select either panel; later rules go before earlier ones; a rule that selects nothing, or of which something is "
      "not judged, is "
      "said and ends with exit code 3"};
  Param<double> risk{"risk", 0.05, "1", between(1e-3, 0.49),
                     "a quantity passes if it keeps its limit with a probability of 1 - risk, and fails if that "
                     "probability is at most the risk"};
  Param<double> within{"within", judgement::kPlausiblePlace, "m", between(0, 10),
                       "a surface that is further from the design's face is not taken for the panel's, and not judged: "
                       "a net, a board or "
                       "the wall behind is as flat; 15 mm: three times what panels are set to"};
  Out<SurfaceJudgement> judgement{"judgement", "the verdicts"};
  Out<File> table{"table", "one line a verdict, CSV"};

  void run(Context& context) override;
};

}  // namespace plumbline::surface
