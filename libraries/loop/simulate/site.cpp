#include "loop/simulate/site.hpp"

#include <algorithm>
#include <cmath>

namespace plumbline::loop {

SimulatedSite::SimulatedSite(const SiteOptions& options, std::uint64_t seed)
    : options_(options), design_(make_tower(options.tower)), seed_(seed) {
  Random built(seed, "as built"), made(seed, "manufacture"), control(seed, "control"), arm(seed, "arm");
  for (std::size_t b = 0; b < design_.brackets.size(); ++b) {
    truth_.push_back(built.normal3(options.as_built));
    bracket_at_[design_.brackets[b].id] = b;
  }
  seen_.assign(truth_.size(), Eigen::Vector3d::Constant(kUnknown));
  plate_off_.assign(truth_.size(), Eigen::Vector3d::Zero()), set_ = plate_off_;
  for (std::size_t i = 0; i < 5 * design_.panels.size(); ++i)
    made_.push_back(made.normal(i % 5 == 4 ? options.face : options.edge));
  for (int floor = 0; floor < options.tower.floors; ++floor)
    walk_.push_back((floor == 0 ? 0.0 : walk_.back()) + control.normal(options.survey.control_walk));
  arm_ = arm.normal3(options.robot.calibration);
  design_.errors = stated_errors();
}

ErrorModel SimulatedSite::stated_errors() const {
  const RobotModel& r = options_.robot;
  ErrorModel errors;
  errors.slip_share = r.slip_share, errors.slip = r.slip;
  // As if all brackets of the lowest floor were set in one round, from their first one on.
  std::vector<Eigen::Vector3d> from_first;
  for (const Bracket& bracket : design_.brackets)
    if (bracket.floor == design_.brackets.front().floor)
      from_first.push_back(bracket.axes.transpose() * (bracket.design - design_.brackets.front().design));
  errors.setting = std::hypot(r.repeatability, r.wander);
  errors.station = std::hypot(sigma_by_base(r, from_first), r.calibration);
  errors.edge = options_.edge, errors.face = options_.face;
  errors.knock_share = options_.faults.tag_bumped, errors.control_share = options_.faults.control_knocked;
  return errors;
}

void SimulatedSite::plant(const std::string& kind, std::size_t bracket, int round,
                          const Eigen::Vector3d& displacement) {
  planted_.push_back({kind, design_.brackets[bracket].id, round, displacement.norm()});
}

Facade SimulatedSite::measure(int round) {
  const SurveyErrors& s = options_.survey;
  Facade facade = design_;
  Random noise(seed_, "campaign", static_cast<std::uint64_t>(round));
  Random faults(seed_, "campaign faults", static_cast<std::uint64_t>(round));
  std::vector<Eigen::Vector3d> set_up;
  for (int floor = 0; floor < options_.tower.floors; ++floor) {
    set_up.push_back(noise.normal3(s.set_up) + walk_[floor] * Eigen::Vector3d::UnitZ());
    if (faults.uniform() < options_.faults.control_knocked) {
      planted_.push_back({"control knocked", "floor " + std::to_string(floor + 1), round, kControlKnock});
      set_up.back() += Eigen::Vector3d(0, 0, kControlKnock);
    }
  }
  Random gaps(seed_, "campaign gaps", static_cast<std::uint64_t>(round));
  std::vector<bool> left_out;
  for (int floor = 1; floor <= options_.tower.floors; ++floor) {
    left_out.push_back(gaps.uniform() < options_.faults.partial);
    if (left_out.back()) planted_.push_back({"partial campaign", "floor " + std::to_string(floor), round, 0});
  }
  for (std::size_t b = 0; b < facade.brackets.size(); ++b) {
    Bracket& bracket = facade.brackets[b];
    if (faults.uniform() < options_.faults.tag_bumped) {
      plate_off_[b] = kPlateBump;
      plant("tag bumped", b, round, plate_off_[b]);
    }
    bracket.deviation = truth_[b] + plate_off_[b] + set_up[bracket.floor - 1] + noise.normal3(s.single);
    if (left_out[bracket.floor - 1] && seen_[b].allFinite()) bracket.deviation = seen_[b];
    if (gaps.uniform() < options_.faults.hidden) {
      plant("hidden", b, round, Eigen::Vector3d::Zero());
      bracket.deviation.setConstant(kUnknown);
    } else {
      seen_[b] = bracket.deviation;
    }
  }
  facade.own = facade.covariance;  // zero
  for (std::size_t i = 0; i < facade.brackets.size(); ++i)
    for (std::size_t j = 0; j < facade.brackets.size(); ++j) {
      const int a = facade.brackets[i].floor, b = facade.brackets[j].floor;
      auto block = facade.covariance.block<3, 3>(3 * static_cast<Eigen::Index>(i), 3 * static_cast<Eigen::Index>(j));
      if (i == j) block.diagonal().array() += s.single * s.single;
      if (a == b) block.diagonal().array() += s.set_up * s.set_up;
      facade.own.block<3, 3>(3 * static_cast<Eigen::Index>(i), 3 * static_cast<Eigen::Index>(j)) = block;
      block(2, 2) += std::min(a, b) * s.control_walk * s.control_walk;
    }
  return facade;
}

Eigen::Vector3d SimulatedSite::off_by_base_at(std::size_t b, int round) {
  const Bracket& bracket = design_.brackets[b];
  const std::uint64_t place = static_cast<std::uint64_t>(round) * 1000u + static_cast<unsigned>(bracket.floor);
  auto& [first, items] = worked_on_.try_emplace(place, b, 0).first->second;
  ++items;
  const Eigen::Vector3d from_first = bracket.axes.transpose() * (bracket.design - design_.brackets[first].design);
  return off_by_base(options_.robot, from_first, items, Random(seed_, "station", place), Random(seed_, "drift", place),
                     Random(seed_, "tilt", place));
}

void SimulatedSite::set(std::size_t b, const Eigen::Vector3d& setting, int round) {
  const Bracket& bracket = design_.brackets[b];
  const auto key = static_cast<std::uint64_t>(round) * 100000u + b;
  Random own(seed_, "setting", key);
  const Eigen::Vector3d base = off_by_base_at(b, round);
  Eigen::Vector3d done = moved_by(options_.robot, setting, arm_, base, own);
  done = (set_[b] + done).cwiseMax(bracket.type.low).cwiseMin(bracket.type.high) - set_[b];
  set_[b] += done, truth_[b] += bracket.axes * done;
}

void SimulatedSite::execute_bracket(const LoopItemT& item, int round, ActualsT& actuals) {
  const std::size_t b = bracket(item.id);
  Random luck(seed_, "faults", static_cast<std::uint64_t>(round) * 100000u + b);
  auto actual = std::make_unique<ActualT>();
  actual->item = item.id, actual->revision = item.revision, actual->by = "robot-" + std::to_string(1 + item.floor % 2);
  actual->outcome = "done", actual->job = item.jobs.empty() ? "" : item.jobs.front();
  actual->measured.setConstant(kUnknown), actual->sigma.setConstant(kUnknown), actual->setting.setConstant(kUnknown);
  const BracketTask task = task_of(options_.faults, item.pending, item.revision, luck);
  const std::size_t where = task.other_bracket ? (b + 1) % truth_.size() : b;
  if (!task.fault.empty()) plant(task.fault, b, round, task.left);
  if (task.other_bracket) plant(task.fault, where, round, task.left);
  actual->revision = task.revision;
  if (task.skipped) actual->outcome = "skipped";
  if (task.other_job) actual->job = "job-of-another-tower";
  if (task.asked.squaredNorm() > 0) set(where, task.asked, round);
  if (task.twice) set(where, task.asked, round + 50000);
  actuals.items.push_back(std::move(actual));
}

/// Its face, in the frame of the control that its floor has.
void SimulatedSite::see_panel(const std::string& id, Random& luck, ActualT& actual) const {
  for (std::size_t j = 0; j < design_.panels.size(); ++j) {
    const Panel& panel = design_.panels[j];
    if (panel.id != id) continue;
    actual.measured = centre_on(panel, design_.brackets, truth_, made_[5 * j + 4]) +
                      walk_[panel.floor - 1] * Eigen::Vector3d::UnitZ() + luck.normal3(options_.seen);
  }
  actual.sigma.setConstant(options_.seen);
}

/// By a crew, who do what they are told.
void SimulatedSite::take_down(const LoopItemT& panel, ActualsT& actuals) {
  auto actual = std::make_unique<ActualT>();
  actual->item = panel.id, actual->revision = panel.revision, actual->by = "crew", actual->outcome = "removed";
  actual->measured.setConstant(kUnknown), actual->sigma.setConstant(kUnknown), actual->setting.setConstant(kUnknown);
  actuals.items.push_back(std::move(actual));
}

ActualsT SimulatedSite::execute(const LoopStateT& state, int round) {
  ActualsT actuals;
  std::vector<int> hung(static_cast<std::size_t>(options_.tower.floors) + 1, 0);
  const int on_a_floor = static_cast<int>(design_.panels.size()) / options_.tower.floors;
  for (const auto& item : state.items) {
    if (item->status == ItemStatus::rework) take_down(*item, actuals);
    if (item->status != ItemStatus::released) continue;
    if (item->kind == "bracket") {
      execute_bracket(*item, round, actuals);
      continue;
    }
    auto actual = std::make_unique<ActualT>();
    actual->item = item->id, actual->revision = item->revision,
    actual->by = "robot-" + std::to_string(1 + item->floor % 2);
    actual->outcome = "done";
    actual->measured.setConstant(kUnknown), actual->sigma.setConstant(kUnknown), actual->setting.setConstant(kUnknown);
    Random luck(seed_, "panel " + item->id, static_cast<std::uint64_t>(round));
    if (luck.uniform() < options_.faults.did_nothing)
      planted_.push_back({"panel not hung", item->id, round, 0}), not_hung_.insert(item->id);
    else
      see_panel(item->id, luck, *actual), not_hung_.erase(item->id);
    actuals.items.push_back(std::move(actual));
    hung[item->floor] += loads_.insert(item->id).second;
  }
  for (int floor = 1; floor <= options_.tower.floors; ++floor)
    hang(floor, static_cast<double>(hung[floor]) / on_a_floor);
  return actuals;
}

void SimulatedSite::mend_plate(const std::string& id) { plate_off_[bracket(id)].setZero(); }

void SimulatedSite::hang(int floor, double share) {
  for (std::size_t b = 0; b < truth_.size(); ++b)
    truth_[b].z() -= share * options_.shortening * std::min(floor, design_.brackets[b].floor);
}

void SimulatedSite::set_to_design() {
  Random carried(seed_, "carried");
  double height = 0;
  for (int floor = 1; floor <= options_.tower.floors; ++floor) {
    // What a layout tool carries from floor to floor: two of its own sights each time.
    height += carried.normal(std::sqrt(2.0) * (options_.survey.set_up + options_.survey.single));
    for (std::size_t b = 0; b < truth_.size(); ++b) {
      if (design_.brackets[b].floor != floor) continue;
      Eigen::Vector3d seen = truth_[b] - height * Eigen::Vector3d::UnitZ();
      set(b, -(design_.brackets[b].axes.transpose() * seen), 70000 + floor);
    }
    hang(floor);
  }
}

std::vector<double> SimulatedSite::true_values(const std::vector<JudgedValue>& judged,
                                               const std::vector<PanelPose>& poses) const {
  std::vector<Eigen::Matrix<double, 6, 1>> twists;
  for (const PanelPose& pose : poses) {
    Eigen::VectorXd moved(pose.solve.cols());
    for (Eigen::Index i = 0; i < moved.size(); ++i) {
      const PanelPose::Held& held = pose.held[i];
      moved[i] = held.direction.dot(truth_[held.bracket]);
    }
    twists.push_back(pose.solve * moved);
  }
  std::vector<double> values;
  for (const JudgedValue& value : judged) {
    double sum = value.constant;
    for (const auto& [panel, row] : value.rows) sum += row.dot(twists[panel]);
    for (const auto& [edge, factor] : value.edges) sum += factor * made_[edge];
    values.push_back(sum);
  }
  return values;
}

}  // namespace plumbline::loop
