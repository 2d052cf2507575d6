// What all planners have in common: a facade from what was judged, campaigns as one estimate, the gate, words and
// tables. Theirs is only the way to the settings.
#pragma once

#include "artifacts/design.hpp"
#include "artifacts/deviation.hpp"
#include "artifacts/file.hpp"
#include "artifacts/installation_plan.hpp"
#include "artifacts/loop_state.hpp"
#include "artifacts/points.hpp"
#include "artifacts/poses.hpp"
#include "artifacts/survey_observations.hpp"
#include "build/loop/facade_input.hpp"
#include "loop/fit/plan_settings.hpp"
#include "loop/state/rounds_estimate.hpp"
#include "plumbline/node.hpp"

namespace plumbline::loop {

struct PlannerNode : Node {
  In<Deviation> deviation{"deviation", frame("frame=?F"), "anchors and panels as judged, with their tolerances"};
  In<Points> model{"model", frame("frame=?F"), "the points that were judged, with their joint covariance"};
  In<Design> design{"design", frame("frame=?F"), "the design"};
  Optional<LoopState> state{"state", frame("frame=?F"),
                            "the round before: what hangs already is data, and what was set is range no more"};
  Optional<Points> control{"control", frame("frame=?S"),
                           "points of the model that all campaigns rest on: with them, anchors that did not move since "
                           "the state's campaigns are one estimate; without, this campaign counts alone"};
  Optional<SurveyObservations> readings{
      "readings", frame("frame=?S"),
      "readings of this campaign: one that holds some of a campaign before is found by them; without, only by places "
      "that are the same"};
  Optional<Poses> stations{"stations", frame("frame=?F"),
                           "where robots stand by the tags that their cameras see, with covariance, that of the "
                           "calibration in it: how well the nearest one knows the place of a bracket is added to "
                           "station_sigma; without, station_sigma alone"};
  Param<std::vector<std::string>> brackets{
      "brackets", std::vector<std::string>{},
      "what brackets can be set by: 'class=IfcMechanicalFastener: right=20mm, up=15mm, out=25mm, step_out=1mm'; later "
      "rules go before earlier ones, both before the design's Pset_BracketRange; none: 20, 15 and 25 mm are assumed"};
  Param<std::vector<std::string>> hooks{
      "hooks", std::vector<std::string>{},
      "what a hook takes up: 'name~-R2$: slides_sideways' (fixed, slides_sideways, slides_up, slides); without: the "
      "upper "
      "left one is fixed, the others of the upper row slide sideways, the lower ones hold out of plane only"};
  Param<std::vector<std::string>> after{
      "after", std::vector<std::string>{},
      "order: 'F02-P01 after F01-P01, F01-P02'; a panel always waits for the one below"};
  Param<std::vector<std::string>> standing{
      "standing", std::vector<std::string>{},
      "panels that hang though neither this campaign nor a round before has them, by name; '*': all such. Without, the "
      "panels above them wait"};
  Param<std::vector<double>> facade_normal{"facade_normal", std::vector<double>{}, "1", between(-1, 1),
                                           "direction out of the facade, x, y, z, for all anchors; without: each as it "
                                           "was judged, on as many facades as there are"};
  Param<double> setting_sigma{"setting_sigma", 0.0005, "m", between(0, 0.1),
                              "of a bracket as it is set against what was asked, each direction"};
  Param<double> station_sigma{"station_sigma", 0.0, "m", between(0, 0.1),
                              "common to all brackets that one robot sets on one floor, each direction"};
  Param<double> slip_share{
      "slip_share", 0.0, "1", between(0, 1),
      "of brackets that slip on tightening, besides setting_sigma: few and large, which no standard "
      "deviation says"};
  Param<double> slip_sigma{"slip_sigma", 0.002, "m", between(0, 0.1), "how far these slip, each direction"};
  Param<double> knock_share{"knock_share", 0.0, "1", between(0, 1),
                            "of plates that were knocked before they were measured first, which no campaign tells"};
  Param<double> knock_sigma{"knock_sigma", 0.003, "m", between(0, 0.1), "how far, each direction"};
  Param<double> control_share{"control_share", 0.0, "1", between(0, 1),
                              "of storeys whose control was knocked before anything was measured from it"};
  Param<double> control_sigma{"control_sigma", 0.006, "m", between(0, 0.1), "how far, in height"};
  Param<double> drift_per_storey{
      "drift_per_storey", 0.00002, "m", between(0, 0.01),
      "how far a storey may sink or rise against the one below from campaign to campaign: loads, temperature"};
  Param<double> edge_sigma{"edge_sigma", 0.0005, "m", between(0, 0.1), "of a panel's edges, by manufacture"};
  Param<double> face_sigma{"face_sigma", 0.0005, "m", between(0, 0.1),
                           "of a panel's face out of plane, by manufacture"};
  Param<double> step_tolerance{"step_tolerance", 0.0, "m", between(0, 1),
                               "of the step from panel to panel out of plane; 0: that of the joint's width"};
  Param<double> guard_factor{"guard_factor", 1.645, "1", between(0, 10),
                             "k of the guard band that the settings keep from every limit"};
  Param<double> go_probability{"go_probability", 0.95, "1", between(0.5, 0.9999),
                               "least probability of GO, and of a length outside for NO_GO"};
  Param<double> measurement_sigma{"measurement_sigma", 0.0005, "m", between(1e-6, 0.1),
                                  "of the one more measurement that HOLD is held against, each direction"};
  Out<InstallationPlan> plan{"plan", frame("frame=?F"), "settings, poses, gates"};
  Out<File> table{"table",
                  "settings.csv: bracket;floor;right;up;out in mm, with what it can be set by, for who sets by hand"};
  Out<File> words{"words",
                  "installation.txt: what may be hung, what waits for what, what has to be drilled or trimmed"};

  void run(Context& context) override;

 protected:
  /// What is to be set on a facade without faults (faults_of() is empty), and what that does to its panels: by
  /// plan_settings(), fit_of_settings() or a way of your own.
  virtual Fit settings(const Facade& facade) = 0;

 private:
  FacadeRules rules();
  /// What robots know of their places, into the facade and, in words, to the reader.
  void add_stations(FacadeInput& input, Context& context);
  RoundsEstimate with_campaigns_before(FacadeInput& input, LoopStateT* before, InstallationPlanT& result);
};

}  // namespace plumbline::loop
