// What all models of robots have in common: they do a job on a site whose truth only they move, and report. Theirs is
// only what they do to an item and say of it.
#pragma once

#include <map>

#include "artifacts/actuals.hpp"
#include "artifacts/file.hpp"
#include "artifacts/installation_plan.hpp"
#include "artifacts/points.hpp"
#include "loop/fit/facade.hpp"
#include "loop/job/job.hpp"
#include "plumbline/node.hpp"

namespace plumbline::loop {

/// What is done for one item of a job, and what is said of it.
struct Deed {
  std::string where;                                ///< id of the hook that is moved; empty: none
  Eigen::Vector3d moved = Eigen::Vector3d::Zero();  ///< by how much in truth, along the item's right, up, out [m]
  std::string outcome = "done";                     ///< reported: done, failed or skipped
  std::string by = "robot-1";                       ///< reported
  int revision = 0;                                 ///< reported: of the item as it was released
  std::string job = {};                             ///< reported; empty: that which it was given
  Eigen::Vector3d measured;                         ///< reported, in the root frame [m]; nan: not measured
  double sigma = kUnknown;                          ///< reported: of that place, each direction [m]; nan: not stated
  bool is_fault = false;                            ///< not what was asked for, and not told
};

/// Standard deviations of what is set against what was asked for, along the direction where they are largest [m],
/// without faults. Brackets that slip (slip_share, slip_sigma) and panels' manufacture (edge_sigma, face_sigma) the
/// plan takes beside them; a job does not say what it took, and they are not compared.
struct RobotErrors {
  double setting = 0;  ///< of each bracket by itself
  double station = 0;  ///< common to what is set from one place
};

struct RobotNode : Node {
  In<File> job{"job", "job.json"};
  In<Points> truth{"truth", frame("frame=?F"), "hooks as they really are"};
  Optional<InstallationPlan> plan{"plan", frame("frame=?F"),
                                  "how panels hang on their brackets: one is seen where its hooks really put it; "
                                  "without, where it is to hang"};
  Out<Points> moved{"truth", frame("frame=?F"), "hooks as they are afterwards"};
  Out<Actuals> actuals{"actuals", frame("frame=?F"), "what the robots report"};
  void run(Context& context) override;

 protected:
  /// Where the centre of a panel's face really is, in the root frame [m]; `face`: how far it is out of its plane by
  /// manufacture. By the plan and the truth as it is now; without a plan, or where it does not have the panel with all
  /// its hooks, its target.
  Eigen::Vector3d centre_of(const Job& todo, const JobItem& panel, double face) const;
  /// A deed that does what the item asks for, without errors and without having measured anything.
  static Deed asked(const JobItem& item);
  /// `seed`: of the node, for Random(seed, stream).
  virtual Deed work(const Job& todo, std::size_t item, std::uint64_t seed) = 0;
  /// What a plan has to take of them for its probabilities to be true, with this job; where it took less, that is told.
  virtual RobotErrors errors(const Job& todo) const = 0;

 private:
  void tell_of_what_the_plan_took(const Job& todo, Context& context) const;
  InstallationPlanT planned_;
  std::map<std::string, Eigen::Vector3d> hooks_;  ///< by id, as they really are now
};

}  // namespace plumbline::loop
