// write.job, read.actuals, simulate.site: to robots and back.
#pragma once

#include "artifacts/actuals.hpp"
#include "artifacts/file.hpp"
#include "artifacts/installation_plan.hpp"
#include "artifacts/loop_state.hpp"
#include "artifacts/points.hpp"
#include "artifacts/survey_observations.hpp"
#include "artifacts/transform.hpp"
#include "plumbline/node.hpp"

namespace plumbline::loop {

struct WriteJob : Node {
  static constexpr Info info{"write.job", "", 4, "What is released, for robots (JSON, signed) and for layout tools"};
  In<InstallationPlan> plan{"plan", frame("frame=?F"), "the plan that released it"};
  In<LoopState> state{"state", frame("frame=?F"), "the state after the release"};
  Optional<Points> control{"control", frame("frame=?F"),
                           "control points, for a file of their own: a tool is set up on them"};
  Optional<Transform> frames{"frames", frame("to=?F,from=?S"),
                             "what survey and control were moved by into the frame of the plan (frames.to_building): "
                             "jobs and layouts go back by it; without: nothing"};
  Param<int64_t> floor{"floor", 0, between(0, 1000), "items of this floor only; 0: all"};
  Param<std::string> created_at{"created_at", "", "when, ISO 8601 with zone; empty: not said"};
  Param<std::string> valid_until{"valid_until", "",
                                 "until when robots may take it, ISO 8601 with zone; empty: not said"};
  Param<std::string> signing_key{"signing_key", "", "file with an Ed25519 private key in PEM; empty: not signed"};
  Out<File> job{"job", "job.json (schemas/robot_job.schema.json)"};
  Out<File> signature{"signature",
                      "job.json.sig: 64 bytes, 'openssl pkeyutl -verify -rawin' checks it; empty without key"};
  Out<File> settings{"settings", "settings.csv: what is asked of the brackets of the job, for who sets by hand"};
  Out<File> hilti{"hilti", "layout_hilti.csv: PtID;E;N;H of the brackets that the job sets"};
  Out<File> trimble{"trimble", "layout_trimble.csv: name, N, E, elevation, code"};
  Out<File> leica{"leica", "layout_leica.csv: PtID, E, N, H, code"};
  Out<File> control_points{"control_points", "control.csv: PtID;E;N;H of the control"};
  Out<File> drawing{"drawing",
                    "layout.dxf: R12, the job's brackets, the panels on them on layers by gate, control on its own"};
  void run(Context& context) override;
};

struct ReadActuals : Node {
  static constexpr Info info{"read.actuals", "", 4,
                             "What robots and people report: actuals.json, or staked points of a layout tool"};
  In<File> file{"file", "the file"};
  Optional<Transform> frames{"frames", frame("to=building,from=?S"),
                             "what the survey was moved by into the building's frame: staked points are in the "
                             "survey's; without: they share one"};
  Param<std::string> format{"format", "json", one_of("json", "hilti", "trimble", "leica"), "who wrote it"};
  Param<std::string> frame_name{"frame", "building", one_of("building"), "frame of its places"};
  Out<Actuals> actuals{"actuals", frame("frame=building"), "the reports"};
  void run(Context& context) override;
};

/// What a surveyor needs who measures a simulated site once more.
struct SimulateSite : Node {
  static constexpr Info info{
      "simulate.site", "", 3,
      "Set-ups and control marks before a simulated facade, for simulate.survey: the site is measured again"};
  In<Points> truth{"truth", frame("frame=?F"), "hooks as they really are; their y axis points into the building"};
  Param<double> distance{"distance", 14.0, "m", between(3, 60), "of the set-ups from the facade"};
  Param<double> range{"range", 60.0, "m", between(5, 500), "longest sight"};
  Param<double> control_sigma{"control_sigma", 0.0003, "m", between(1e-5, 0.1), "of a control mark's coordinates"};
  Param<std::vector<std::string>> knocked{
      "knocked", std::vector<std::string>{},
      "control marks that were knocked by 6 mm upward, of K1 to K6: a fault to be found"};
  Optional<LoopState> state{"state", frame("frame=?F"),
                            "the round before: which round this is; without, the first (number 0)"};
  Param<int64_t> knocked_from{"knocked_from", 0, between(0, 1000),
                              "the round from which on these are knocked, counted from 0: while the loop runs"};
  Param<double> knock_share{"knock_share", 0.0, "1", between(0, 1),
                            "of control marks that are knocked in each round, and stay so"};
  Param<double> bump_share{"bump_share", 0.0, "1", between(0, 1),
                           "of plates that are knocked by 5 mm in each round, and stay so: their hooks do not move"};
  Param<int64_t> fault_seed{"fault_seed", 1, between(0, 1000000), "which ones: drawn by it, the same in all rounds"};
  Out<Points> markers{"markers", frame("frame=?F"), "hooks and marks as they really are"};
  Out<SurveyObservations> set_ups{"set_ups", frame("frame=?F"), "what each set-up is to sight"};
  Out<Points> control{"control", frame("frame=?F"), "the marks as they are known"};
  void run(Context& context) override;

 private:
  void bump_plates(PointsT& site, std::int64_t round, Context& context);
};

}  // namespace plumbline::loop
