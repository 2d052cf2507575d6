#include "build/loop/robot_models.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <stdexcept>

#include "geometry/random.hpp"
#include "loop/gate/station_error.hpp"

namespace plumbline::loop {
namespace {

/// From the first item of its floor in the job, along its own right, up, out [m].
Eigen::Vector3d from_first(const Job& todo, std::size_t index) {
  const JobItem& item = todo.items[index];
  for (const JobItem& first : todo.items)
    if (first.floor == item.floor) return item.design_rotation.conjugate() * (item.target - first.target);
  return Eigen::Vector3d::Zero();
}

/// The panel after this one in the job; null: it has no other.
const JobItem* other_panel(const Job& job, std::size_t index) {
  for (std::size_t k = 1; k < job.items.size(); ++k)
    if (const JobItem& other = job.items[(index + k) % job.items.size()]; other.kind == "panel") return &other;
  return nullptr;
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

RobotModel SimulateRobots::model() const {
  RobotModel robot;
  robot.repeatability = *repeatability, robot.calibration = *calibration, robot.wander = *bit_wander;
  robot.station = *station_sigma, robot.tilt = *tilt, robot.drift = *drift;
  robot.slip_share = *slip_share, robot.slip = *slip_sigma;
  return robot;
}

/// Where robots find their place, the plan has it from the same poses.
RobotErrors SimulateRobots::errors(const Job& todo) const {
  double base = 0;
  std::map<int, std::vector<Eigen::Vector3d>> by_floor;
  for (std::size_t i = 0; i < todo.items.size(); ++i)  // brackets come before panels
    if (todo.items[i].kind == "bracket") by_floor[todo.items[i].floor].push_back(from_first(todo, i));
  for (const auto& [floor, items] : by_floor)
    if (!believed) base = std::max(base, sigma_by_base(model(), items));
  return {std::hypot(*repeatability, *bit_wander), std::hypot(base, *calibration)};
}

Eigen::Vector3d SimulateRobots::off_by_place(const Job& todo, std::size_t index, std::uint64_t seed) const {
  const JobItem& item = todo.items[index];
  const Eigen::Vector3d place = todo.origin + item.target;
  if (believed) {
    const PoseT& pose = nearest_station(believed_, place);
    for (const auto& place_of : standing_.poses)
      if (place_of->path == pose.path)
        return item.design_rotation.conjugate() * station_error(pose.cam_from_world, place_of->cam_from_world, place);
    throw std::runtime_error("a robot believes to stand at " + pose.path + ", and 'standing' has no such place");
  }
  const auto floor = static_cast<std::uint64_t>(item.floor);
  const auto items = std::count_if(todo.items.begin(), todo.items.begin() + static_cast<std::ptrdiff_t>(index) + 1,
                                   [&](const JobItem& before) { return before.floor == item.floor; });
  return off_by_base(model(), from_first(todo, index), static_cast<int>(items), Random(seed, "station", floor),
                     Random(seed, "drift", floor), Random(seed, "tilt", floor));
}

Deed SimulateRobots::work(const Job& todo, std::size_t index, std::uint64_t seed) {
  return todo.items[index].kind == "bracket" ? set_bracket(todo, index, seed) : hang_panel(todo, index, seed);
}

Deed SimulateRobots::set_bracket(const Job& todo, std::size_t index, std::uint64_t seed) {
  const JobItem& item = todo.items[index];
  Faults faults;
  faults.did_nothing = *did_nothing, faults.off_8mm = *off_8mm, faults.wrong_side = *wrong_side;
  faults.wrong_item = *wrong_item, faults.skipped = *skipped, faults.twice = *twice;
  faults.old_revision = *old_revision, faults.other_job = *other_job;
  Random luck(seed, "fault " + item.id), own(seed, "setting " + item.id);
  Deed deed = asked(item);
  const BracketTask task = task_of(faults, item.setting, item.revision, luck);
  deed.is_fault = !task.fault.empty(), deed.revision = task.revision;
  if (task.skipped) deed.outcome = "skipped";
  if (task.other_job) deed.job = "job-of-another-tower";
  if (task.other_bracket) deed.where = todo.items[(index + 1) % todo.items.size()].id;
  if (task.asked.isZero(0)) {
    deed.where.clear();
    return deed;
  }
  const Eigen::Vector3d arm = Random(static_cast<std::uint64_t>(*robot_seed), "arm " + deed.by).normal3(*calibration);
  const Eigen::Vector3d base = off_by_place(todo, index, seed);
  deed.moved = moved_by(model(), task.asked, arm, base, own);
  if (task.twice) deed.moved += moved_by(model(), task.asked, arm, base, own);
  return deed;
}

Deed SimulateRobots::hang_panel(const Job& todo, std::size_t index, std::uint64_t seed) {
  const JobItem& item = todo.items[index];
  Random luck(seed, "fault " + item.id), own(seed, "setting " + item.id);
  Deed deed = asked(item);
  const JobItem* where = &item;
  Eigen::Vector3d aside = Eigen::Vector3d::Zero();
  deed.is_fault = true;
  if (luck.uniform() < *skipped) {
    deed.outcome = "skipped", where = nullptr;
  } else if (luck.uniform() < *old_revision) {
    deed.revision = deed.revision > 1 ? deed.revision - 1 : kOtherLoop;
  } else if (luck.uniform() < *did_nothing) {
    where = nullptr;
  } else if (luck.uniform() < *off_8mm) {
    aside.x() = 0.008;
  } else if (const JobItem* other = other_panel(todo, index); other && luck.uniform() < *wrong_item) {
    where = other;
  } else {
    deed.is_fault = false;
  }
  if (!where) return deed;
  const double face = Random(static_cast<std::uint64_t>(*robot_seed), "face " + where->id).normal(*face_sigma);
  deed.measured = centre_of(todo, *where, face) + item.design_rotation * aside + own.normal3(*seen_sigma);
  deed.sigma = *seen_sigma;
  return deed;
}

/// What is rounded to a division is off by up to half of it either way, each place as likely.
RobotErrors SimulateFitters::errors(const Job&) const {
  return {std::hypot(*hand_sigma, *division / std::sqrt(12.0)), 0};
}

Deed SimulateFitters::work(const Job& todo, std::size_t index, std::uint64_t seed) {
  const JobItem& item = todo.items[index];
  Random own(seed, "hand " + item.id);
  constexpr double kSeen = 0.001;
  Deed deed = asked(item);
  deed.by = "fitters";
  if (item.kind != "bracket") {
    deed.measured = centre_of(todo, item, 0) + own.normal3(kSeen), deed.sigma = kSeen;
    return deed;
  }
  if (*division > 0) deed.moved = *division * (deed.moved / *division).array().round().matrix();
  deed.moved += own.normal3(*hand_sigma);
  return deed;
}

}  // namespace plumbline::loop
