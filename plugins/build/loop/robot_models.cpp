#include "build/loop/robot_models.hpp"

#include <cmath>
#include <stdexcept>

#include "geometry/random.hpp"
#include "loop/gate/station_error.hpp"

namespace plumbline::loop {
namespace {

/// Revision of a job that was left from another loop: there is none before the first.
constexpr int kOtherLoop = 1000;

/// Who hangs a panel sees it to a millimetre.
Eigen::Vector3d seen_panel(const Job& job, const JobItem& item, Random& own) {
  return job.origin + item.target + own.normal3(0.001);
}

}  // namespace

void SimulateRobots::run(Context& context) {
  if (static_cast<bool>(believed) != static_cast<bool>(standing))
    throw std::runtime_error("'believed' and 'standing' go together: where robots believe to stand, and where they do");
  if (believed) believed_ = believed.unpack(), standing_ = standing.unpack();
  if (!believed)
    context.info("where robots stand is drawn, station_sigma for each floor and round: none has found its place");
  RobotNode::run(context);
}

/// Where robots find their place, the plan has it from the same poses.
RobotErrors SimulateRobots::errors() const { return {*repeatability, believed ? 0.0 : *station_sigma}; }

Eigen::Vector3d SimulateRobots::off_by_base(const Job& todo, const JobItem& item, std::uint64_t seed) const {
  if (!believed) return Random(seed, "station", static_cast<std::uint64_t>(item.floor)).normal3(*station_sigma);
  const Eigen::Vector3d place = todo.origin + item.target;
  const PoseT& pose = nearest_station(believed_, place);
  for (const auto& place_of : standing_.poses)
    if (place_of->path == pose.path)
      return item.design_rotation.conjugate() * station_error(pose.cam_from_world, place_of->cam_from_world, place);
  throw std::runtime_error("a robot believes to stand at " + pose.path + ", and 'standing' has no such place");
}

Deed SimulateRobots::work(const Job& todo, std::size_t index, std::uint64_t seed) {
  const JobItem& item = todo.items[index];
  Random luck(seed, "fault " + item.id);
  Random own(seed, "setting " + item.id);
  Deed deed = asked(item);
  const bool is_bracket = item.kind == "bracket";
  bool untouched = false;
  deed.is_fault = true;
  if (luck.uniform() < *skipped) {
    deed.outcome = "skipped", untouched = true;
  } else if (luck.uniform() < *old_revision) {
    deed.revision = deed.revision > 1 ? deed.revision - 1 : kOtherLoop;
  } else if (luck.uniform() < *did_nothing) {
    untouched = true;
  } else if (is_bracket && luck.uniform() < *off_8mm) {
    deed.moved.x() += 0.008;
  } else if (is_bracket && luck.uniform() < *wrong_side) {
    deed.moved = -deed.moved;
  } else if (is_bracket && luck.uniform() < *wrong_item) {
    deed.where = todo.items[(index + 1) % todo.items.size()].id;
  } else {
    deed.is_fault = false;
  }
  if (untouched) {
    deed.where.clear();
    return deed;
  }
  if (is_bracket) {
    deed.moved += off_by_base(todo, item, seed) + own.normal3(*repeatability);
    if (own.uniform() < *slip_share) deed.moved += own.normal3(*slip_sigma);
  } else {
    deed.measured = seen_panel(todo, item, own);
  }
  return deed;
}

/// What is rounded to a division is off by up to half of it either way, each place as likely.
RobotErrors SimulateFitters::errors() const { return {std::hypot(*hand_sigma, *division / std::sqrt(12.0)), 0}; }

Deed SimulateFitters::work(const Job& todo, std::size_t index, std::uint64_t seed) {
  const JobItem& item = todo.items[index];
  Random own(seed, "hand " + item.id);
  Deed deed = asked(item);
  deed.by = "fitters";
  if (item.kind != "bracket") {
    deed.measured = seen_panel(todo, item, own);
    return deed;
  }
  if (*division > 0) deed.moved = *division * (deed.moved / *division).array().round().matrix();
  deed.moved += own.normal3(*hand_sigma);
  return deed;
}

}  // namespace plumbline::loop
