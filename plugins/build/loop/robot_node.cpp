#include "build/loop/robot_node.hpp"

#include <fmt/core.h>

#include "build/loop/file_content.hpp"
#include "loop/fit/facade.hpp"

namespace plumbline::loop {

Deed RobotNode::asked(const JobItem& item) {
  Deed deed;
  if (item.kind == "bracket") deed.where = item.id, deed.moved = item.setting;
  deed.by = "robot-" + std::to_string(1 + item.floor % 2), deed.revision = item.revision;
  deed.measured.setConstant(kUnknown);
  return deed;
}

void RobotNode::tell_of_what_the_plan_took(const Job& todo, Context& context) const {
  constexpr double kAsGood = 1.1;  // less changes p by less than what it is rounded to
  const RobotErrors own = errors();
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
  const Job todo = read_job(content_of(*job, context));
  if (todo.building_from_job)
    throw std::runtime_error(
        "the job is in the frame of the survey, and what is simulated is in that of the design; "
        "expected a job without 'frames' (write.job)");
  tell_of_what_the_plan_took(todo, context);
  PointsT site = truth.unpack();
  std::map<std::string, PointT*> point;
  for (const auto& p : site.points) point[p->id] = p.get();
  const std::uint64_t seed = context.seed();
  ActualsT reports;
  int faults = 0;
  for (std::size_t i = 0; i < todo.items.size(); ++i) {
    const Deed deed = work(todo, i, seed);
    faults += deed.is_fault;
    if (const auto hook = point.find(deed.where); hook != point.end())
      hook->second->position += todo.items[i].design_rotation * deed.moved;
    auto report = std::make_unique<ActualT>();
    report->item = todo.items[i].id, report->job = todo.id, report->revision = deed.revision;
    report->outcome = deed.outcome, report->by = deed.by, report->measured = deed.measured;
    report->sigma.setConstant(kUnknown), report->setting.setConstant(kUnknown);
    reports.items.push_back(std::move(report));
  }
  context.metric("done", static_cast<double>(todo.items.size()), "1");
  context.metric("faults", faults, "1");
  moved.commit(site);
  actuals.commit(reports);
}

}  // namespace plumbline::loop
