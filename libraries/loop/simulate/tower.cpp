#include "loop/simulate/tower.hpp"

#include <fmt/core.h>

namespace plumbline::loop {
namespace {

std::string bracket_name(int floor, int column, int row) {
  return fmt::format("F{:02}-C{:02}-R{}", floor + 1, column + 1, row + 1);
}

std::string panel_name(int floor, int bay) { return fmt::format("F{:02}-P{:02}", floor + 1, bay + 1); }

Panel make_panel(const TowerOptions& o, int floor, int bay, const Eigen::Matrix3d& axes) {
  Panel panel;
  panel.id = panel.name = panel_name(floor, bay), panel.floor = floor + 1, panel.axes = axes;
  const double left = bay * o.width + 0.5 * o.joint, right = (bay + 1) * o.width - 0.5 * o.joint;
  const double bottom = floor * o.height + 0.5 * o.joint, top = (floor + 1) * o.height - 0.5 * o.joint;
  constexpr double face = -0.15;  // before the slab edge
  panel.corners = {Eigen::Vector3d(left, face, bottom), {right, face, bottom}, {left, face, top}, {right, face, top}};
  panel.centre = 0.5 * (panel.corners[0] + panel.corners[3]);
  panel.limits = {o.tolerance, o.tolerance, o.tolerance};
  panel.hooks = {{tower_bracket(o, floor, 1, bay), {true, true, true}},
                 {tower_bracket(o, floor, 1, bay + 1), {false, true, true}},
                 {tower_bracket(o, floor, 0, bay), {false, false, true}},
                 {tower_bracket(o, floor, 0, bay + 1), {false, false, true}}};
  if (floor > 0) panel.depends_on.push_back(panel_name(floor - 1, bay));
  return panel;
}

Joint make_joint(const TowerOptions& o, const std::vector<Panel>& panels, std::size_t a, std::size_t b, bool upward) {
  Joint joint;
  joint.a = a, joint.b = b;
  joint.side_of_a = upward ? Side::top : Side::right, joint.side_of_b = upward ? Side::bottom : Side::left;
  joint.across = upward ? Eigen::Vector3d::UnitZ() : Eigen::Vector3d::UnitX();
  const auto& of_a = panels[a].corners;
  const auto& of_b = panels[b].corners;
  joint.on_a = {upward ? of_a[2] : of_a[1], of_a[3]};
  joint.on_b = {of_b[0], upward ? of_b[1] : of_b[2]};
  joint.nominal = o.joint, joint.least = o.joint - o.joint_tolerance, joint.most = o.joint + o.joint_tolerance;
  if (o.steps_judged) joint.step_most = o.joint_tolerance;
  return joint;
}

}  // namespace

std::size_t tower_bracket(const TowerOptions& o, int floor, int row, int column) {
  return static_cast<std::size_t>((floor * 2 + row) * (o.bays + 1) + column);
}

namespace {

/// The same facade once more, turned a quarter to face right.
void add_east_facade(Facade& facade, const TowerOptions& o) {
  const std::size_t brackets = facade.brackets.size(), panels = facade.panels.size(), joints = facade.joints.size();
  Eigen::Matrix3d turn;
  turn << 0, -1, 0, 1, 0, 0, 0, 0, 1;
  const Eigen::Vector3d corner(o.bays * o.width + 1, 1, 0);
  const auto place = [&](const Eigen::Vector3d& p) -> Eigen::Vector3d { return turn * p + corner; };
  for (std::size_t b = 0; b < brackets; ++b) {
    Bracket bracket = facade.brackets[b];
    bracket.id = "E" + bracket.id, bracket.design = place(bracket.design), bracket.axes = turn * bracket.axes;
    facade.brackets.push_back(std::move(bracket));
  }
  for (std::size_t j = 0; j < panels; ++j) {
    Panel panel = facade.panels[j];
    panel.id = panel.name = "E" + panel.id, panel.axes = turn * panel.axes, panel.centre = place(panel.centre);
    for (auto& c : panel.corners) c = place(c);
    for (Hook& hook : panel.hooks) hook.bracket += brackets;
    for (std::string& before : panel.depends_on) before = "E" + before;
    facade.panels.push_back(std::move(panel));
  }
  for (std::size_t i = 0; i < joints; ++i) {
    Joint joint = facade.joints[i];
    joint.a += panels, joint.b += panels, joint.across = turn * joint.across;
    for (auto* ends : {&joint.on_a, &joint.on_b})
      for (auto& end : *ends) end = place(end);
    facade.joints.push_back(std::move(joint));
  }
}

}  // namespace

Facade make_tower(const TowerOptions& o) {
  Facade facade;
  const Eigen::Matrix3d axes = facade_axes(-Eigen::Vector3d::UnitY());
  for (int floor = 0; floor < o.floors; ++floor)
    for (int row = 0; row < 2; ++row)
      for (int column = 0; column <= o.bays; ++column) {
        Bracket bracket;
        bracket.id = bracket_name(floor, column, row), bracket.floor = floor + 1, bracket.axes = axes;
        bracket.design = {column * o.width, 0, floor * o.height + (row == 0 ? 0.25 : 0.75) * o.height};
        facade.brackets.push_back(std::move(bracket));
      }
  for (int floor = 0; floor < o.floors; ++floor)
    for (int bay = 0; bay < o.bays; ++bay) facade.panels.push_back(make_panel(o, floor, bay, axes));
  const auto at = [&](int floor, int bay) { return static_cast<std::size_t>(floor * o.bays + bay); };
  for (int floor = 0; floor < o.floors; ++floor)
    for (int bay = 0; bay < o.bays; ++bay) {
      if (bay + 1 < o.bays)
        facade.joints.push_back(make_joint(o, facade.panels, at(floor, bay), at(floor, bay + 1), false));
      if (floor + 1 < o.floors)
        facade.joints.push_back(make_joint(o, facade.panels, at(floor, bay), at(floor + 1, bay), true));
    }
  if (o.facades > 1) add_east_facade(facade, o);
  const auto n = static_cast<Eigen::Index>(3 * facade.brackets.size());
  facade.covariance = Eigen::MatrixXd::Zero(n, n);
  return facade;
}

}  // namespace plumbline::loop
