// evaluate.deviation: as-built minus design, judged once for everybody.
#pragma once

#include "artifacts/block.hpp"
#include "artifacts/design.hpp"
#include "artifacts/deviation.hpp"
#include "artifacts/element_matches.hpp"
#include "artifacts/file.hpp"
#include "artifacts/plates.hpp"
#include "artifacts/points.hpp"
#include "artifacts/surface_judgement.hpp"
#include "artifacts/survey_network.hpp"
#include "artifacts/transform.hpp"
#include "building/judgement/deviation.hpp"
#include "geometry/panel_fit.hpp"
#include "plumbline/node.hpp"

namespace plumbline::judgement {

struct EvaluateDeviation : Node {
  static constexpr Info info{
      "evaluate.deviation", "", 19,
      "As-built minus design (14): verdicts of anchors, panels, floors and surfaces, joints, shims, common shift"};
  In<Points> model{"model", frame("frame=?F"), "as-built points with their covariance"};
  In<Design> design{"design", frame("frame=?F"), "the design"};
  In<ElementMatches> matches{"matches", frame("frame=?F"), "which anchor is which element"};
  In<Plates> plates{"plates", frame("frame=?P"),
                    "anchor table: floor, column and role of every anchor, how its plate faces and is mounted"};
  Optional<Block> block{
      "block", frame("frame=?B"),
      "the adjusted block: one that fails its global tests proves nothing; one whose camera model does not "
      "hold is less certain"};
  Optional<SurveyNetwork> network{
      "network", frame("frame=?N"),
      "the survey: one that contradicts itself or that nothing controls proves nothing; one "
      "whose readings agree less well than they should is less certain"};
  Optional<Transform> frames{"frames", frame("to=?F,from=?S"),
                             "the way from the survey's frame: the stake-out list is in that one, because instruments "
                             "are; without it, in the design's"};
  Optional<SurfaceJudgement> surface_judgement{"surface_judgement",
                                               "surfaces of panels and joints against their rules: nothing is ready to "
                                               "install where one fails or is not judged"};
  Optional<File> tolerance_table{
      "tolerance_table",
      "tolerance classes of the project, CSV: class, select, vertical_mm, horizontal_mm, "
      "in_plane_mm, out_of_plane_mm, space_mm, joint_mm; the rules of `tolerances` go before "
      "it, later rows before earlier ones; an empty file is none"};
  Param<double> tau{"tau", 0.005, "m", between(1e-6, 1),
                    "tolerance of the horizontal and of the vertical deviation; joints: twice that"};
  Param<std::vector<std::string>> tolerances{
      "tolerances", std::vector<std::string>{},
      "tolerances of their own: 'class=IfcPlate & storey=Level 2: out_of_plane=3mm, vertical=5mm' (horizontal, "
      "vertical, "
      "in_plane, out_of_plane, space, joint; 0mm: not judged; vertical, out_of_plane and joint may have two sides, "
      "+5/-2mm); later rules go before earlier ones; a rule that selects nothing is not judged"};
  Param<bool> design_tolerances{"design_tolerances", true, "Pset_Tolerance of an element goes before tau"};
  Param<double> risk{"risk", 0.05, "1", between(1e-3, 0.49),
                     "an anchor passes if it is within all its tolerances with a probability of 1 - risk, and fails if "
                     "that probability is at most the risk"};
  Param<double> mounting_sigma{
      "mounting_sigma", 0.0005, "m", between(0, 0.1),
      "of a plate's place on its anchor, on each axis of the plate: part of the anchor's uncertainty, because survey "
      "and photographs see the plate; columns mounting_x, mounting_y, mounting_z of plates.csv go before it"};
  Param<std::vector<std::string>> mounting{
      "mounting", std::vector<std::string>{},
      "the same for some anchors: 'class=IfcMechanicalFastener & batch=march: right=0.3mm, up=0.3mm, out=1mm'; goes "
      "before plates.csv, later rules before earlier ones"};
  Param<std::vector<std::string>> held_below{
      "held_below", std::vector<std::string>{},
      "panels whose bottom edge is held out of plane by the panel below (stack joint) or by a sill: 'class=IfcPlate: "
      "sigma=0.5mm, sill_sigma=2mm' (sigma or play: of the joint; sill_sigma: of a sill that nobody measured, else "
      "such "
      "panels stay undecided); later rules go before earlier ones, both before the design's Pset_StackJoint"};
  Param<std::vector<std::string>> sills{
      "sills", std::vector<std::string>{},
      "anchors that are measured places of such a sill: 'name~^SILL-'; no panel hangs on them"};
  Param<double> panel_reach{"panel_reach", kPanelReach, "m", between(0, 10),
                            "anchors so near to a panel hold it, where the design does not say"};
  Param<std::string> unmeasured_panels{
      "unmeasured_panels", "asked", one_of("asked", "not_built"),
      "panels of which no anchor was measured: asked for, and exit code 3; or not built yet, as while a tower is "
      "measured floor by floor: then those that were measured in part are noted, and release.state, which knows what "
      "hangs, ends with exit code 3 for those that do not"};
  Out<Deviation> deviation{"deviation", frame("frame=?F"), "the judgement"};
  Out<File> stake_out{"stake_out",
                      "stake_out.csv: PtID;E;N;H and corrections in the survey's frame, as site instruments import it"};

  void run(Context& context) override;

 private:
  bool hangs_on_the_design(DeviationInputs& inputs) const;
  /// Panels by name, each with the anchors of its that were not measured while others were; of a tower that is built.
  std::vector<std::string> measured_in_part(const DeviationT& judged) const;
};

}  // namespace plumbline::judgement
