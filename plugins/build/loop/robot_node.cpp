#include "build/loop/robot_node.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>

#include "build/loop/file_content.hpp"
#include "loop/fit/facade.hpp"
#include "loop/fit/panel_pose.hpp"
#include "loop/simulate/robot.hpp"
#include "loop/state/hash.hpp"

namespace plumbline::loop {

Deed RobotNode::asked(const JobItem& item) {
  Deed deed;
  if (item.kind == "bracket") deed.where = item.id, deed.moved = item.setting;
  deed.by = "robot-" + std::to_string(1 + item.floor % 2), deed.revision = item.revision;
  deed.measured.setConstant(kUnknown);
  return deed;
}

Eigen::Vector3d RobotNode::centre_of(const Job& todo, const JobItem& item, double face) const {
  const Eigen::Vector3d out = item.design_rotation * Eigen::Vector3d::UnitZ();
  const Eigen::Vector3d target = todo.origin + item.target + face * out;
  const auto planned =
      std::find_if(planned_.panels.begin(), planned_.panels.end(), [&](const auto& one) { return one->id == item.id; });
  if (planned == planned_.panels.end()) return target;
  Panel panel;
  panel.centre = (*planned)->centre, panel.axes = item.design_rotation.toRotationMatrix();
  std::copy_n((*planned)->corners.begin(), std::min<std::size_t>(4, (*planned)->corners.size()), panel.corners.begin());
  std::vector<Bracket> brackets;
  std::vector<Eigen::Vector3d> off;
  for (std::size_t h = 0; h < (*planned)->brackets.size(); ++h) {
    const std::string& id = (*planned)->brackets[h];
    const auto there = hooks_.find(id);
    const auto setting = std::find_if(planned_.brackets.begin(), planned_.brackets.end(),
                                      [&](const auto& one) { return one->id == id; });
    if (there == hooks_.end() || setting == planned_.brackets.end()) return target;
    Bracket bracket;
    bracket.id = id, bracket.design = (*setting)->design;
    for (int k = 0; k < 3 && (*setting)->axes.size() == 3; ++k) bracket.axes.col(k) = (*setting)->axes[k];
    const std::string& holds = (*planned)->holds[h];
    Hook hook{h, {}};
    for (int k = 0; k < 3; ++k) hook.holds[k] = holds.find(std::array{"right", "up", "out"}[k]) != std::string::npos;
    panel.hooks.push_back(hook), brackets.push_back(std::move(bracket));
    off.push_back(there->second - (*setting)->design);
  }
  // What its hooks alone do not hold, as on two brackets, another panel or a sill does.
  Panel there = panel;
  for (Bracket& bracket : brackets) bracket.deviation.setZero();
  if (pose_of(there, brackets).open.cols() > 0) return target;
  return centre_on(panel, brackets, off, face);
}

void RobotNode::tell_of_what_the_plan_took(const Job& todo, Context& context) const {
  constexpr double kAsGood = 1.1;  // less changes p by less than what it is rounded to
  const RobotErrors own = errors(todo);
  const auto tell = [&](const char* parameter, const char* what, double is, double taken) {
    if (!todo.items.empty() && is > kAsGood * taken)
      context.warn(
          fmt::format("{} is {:.2f} mm here (standard deviation, each direction), and the plan of this job "
                      "took {:.2f} mm: its probabilities are too high; give the planner {}={:.5f}",
                      what, 1e3 * is, 1e3 * taken, parameter, is));
  };
  tell("setting_sigma", "what a bracket is set off by", own.setting, todo.setting_sigma);
  tell("station_sigma", "what all brackets of a floor are set off by", own.station, todo.station_sigma);
}

void RobotNode::run(Context& context) {
  const std::string text = content_of(*job, context);
  const Job todo = read_job(text);
  if (todo.building_from_job)
    throw std::runtime_error(
        "the job is in the frame of the survey, and what is simulated is in that of the design; "
        "expected a job without 'frames' (write.job)");
  tell_of_what_the_plan_took(todo, context);
  PointsT site = truth.unpack();
  std::map<std::string, PointT*> point;
  for (const auto& p : site.points) point[p->id] = p.get(), hooks_[p->id] = p->position;
  if (plan) planned_ = plan.unpack();
  const std::uint64_t seed = context.seed();
  ActualsT reports;
  const std::string digest = sha256_hex(text);
  int faults = 0;
  for (std::size_t i = 0; i < todo.items.size(); ++i) {
    const Deed deed = work(todo, i, seed);
    faults += deed.is_fault;
    if (const auto hook = point.find(deed.where); hook != point.end())
      hooks_[deed.where] = hook->second->position += todo.items[i].design_rotation * deed.moved;
    auto report = std::make_unique<ActualT>();
    report->item = todo.items[i].id, report->job = deed.job.empty() ? todo.id : deed.job,
    report->revision = deed.revision;
    report->digest = digest, report->outcome = deed.outcome, report->by = deed.by, report->measured = deed.measured;
    report->sigma.setConstant(deed.sigma), report->setting.setConstant(kUnknown);
    reports.items.push_back(std::move(report));
  }
  context.metric("done", static_cast<double>(todo.items.size()), "1");
  context.metric("faults", faults, "1");
  moved.commit(site);
  actuals.commit(reports);
}

}  // namespace plumbline::loop
