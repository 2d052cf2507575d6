// Verdicts of a facade with panels, for errors made at random; see record.hpp.
#include "../bim/facing.hpp"
#include "building/judgement/deviation.hpp"
#include "record.hpp"
#include "small_building.hpp"

namespace plumbline::judgement {
namespace test_record {

using judgement::test::mm;
using judgement::test::Normal;
using plumbline::test::digits;

/// Three floors of four columns of anchors; panels of 2 m by 3 m between them, each with the anchors at its corners.
DeviationInputs facade() {
  DeviationInputs inputs;
  inputs.design_file = "d.ifc";
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 4; ++column) {
      AnchorCase anchor;
      anchor.id = "A" + std::to_string(row) + "." + std::to_string(column);
      anchor.element.guid = "g" + anchor.id, anchor.instance = inputs.anchors.size() + 1;
      anchor.storey_guid = "s" + std::to_string(row), anchor.element.storey = "Level " + std::to_string(row + 1);
      anchor.floor = row + 1, anchor.use = "check";
      anchor.design = {2.0 * column, 0.02 * (column % 2), 3.0 * row};
      anchor.tolerances = tolerances_of({}, {});
      inputs.model.ids.push_back(anchor.id);
      inputs.model.positions.push_back(anchor.design);
      inputs.anchors.push_back(anchor);
    }
  for (std::size_t row = 0; row < 2; ++row)
    for (std::size_t column = 0; column < 3; ++column) {
      PanelCase panel;
      panel.guid = "p" + std::to_string(row) + std::to_string(column), panel.name = "P" + panel.guid;
      const Eigen::Vector3d low = inputs.anchors[4 * row + column].design;
      panel.low = low + Eigen::Vector3d(0.01, -0.03, 0.01), panel.high = low + Eigen::Vector3d(1.99, 0.01, 2.985);
      panel.tolerances = tolerances_of({}, {});
      for (const std::size_t corner : {0, 1, 4, 5}) panel.anchors.push_back(4 * row + column + corner);
      inputs.panels.push_back(panel);
    }
  inputs.model.covariance = judgement::test::isotropic(inputs.model.ids.size(), 0.4 * mm);
  plumbline::test::face(inputs, {0, -1, 0});
  return inputs;
}

std::string told(const char* name, const JudgedLengthT* length) {
  if (!length) return "";
  return std::string(" ") + name + " " + digits(1e3 * length->value) + "/" + digits(1e3 * length->u) + "/" +
         digits(1e3 * length->tolerance) + "/" + std::to_string(static_cast<int>(length->verdict));
}

std::string told(const PanelDeviationT& p) {
  std::string text = "  " + p.name + " " + std::to_string(static_cast<int>(p.verdict)) + " " + p.decided_by + ": " +
                     p.reason + "\n   ";
  text += told("out", p.out_of_plane.get()) + told("side", p.sideways.get()) + told("up", p.vertical.get()) +
          told("tilt", p.tilt.get()) + told("warp", p.warp.get()) + told("misfit", p.misfit.get()) +
          told("corner", p.corner.get());
  for (const double angle : {p.lean, p.u_lean, p.turn, p.u_turn, p.roll, p.u_roll}) text += " " + digits(1e3 * angle);
  text += "\n   ";
  for (const auto& f : p.fixings)
    text += " " + f->anchor + " " + digits(1e3 * f->shim) + "/" + digits(1e3 * f->u_shim) + " " +
            digits(1e3 * f->sideways) + " " + digits(1e3 * f->upward);
  for (const auto& c : p.corners)
    text += " " + c->name + " " + digits(c->design.sum()) + " " + digits(1e3 * c->movement.x()) + " " +
            digits(1e3 * c->movement.y()) + " " + digits(1e3 * c->movement.z());
  text += "\n";
  for (const auto& j : p.joints)
    text += "    " + j->side + " " + j->name + " " + digits(1e3 * j->design) + " " + digits(1e3 * j->narrowest) + " " +
            digits(1e3 * j->widest) + told("change", j->change.get()) + "\n";
  return text;
}

std::string told(const DeviationT& d) {
  std::string text = "  " + std::to_string(static_cast<int>(d.verdict)) + ": " + std::to_string(d.passed) +
                     " passed, " + std::to_string(d.undecided) + " open, " + std::to_string(d.failed) + " failed, " +
                     std::to_string(d.not_measured) + " not measured, weakest " + digits(d.weakest_pass) + "\n";
  for (const auto& f : d.floors)
    text += "  floor " + std::to_string(f->floor) + " " + std::to_string(static_cast<int>(f->verdict)) + ": " +
            std::to_string(f->passed) + " " + std::to_string(f->undecided) + " " + std::to_string(f->failed) +
            " panels " + std::to_string(f->panels_passed) + " " + std::to_string(f->panels_undecided) + " " +
            std::to_string(f->panels_failed) + "\n";
  for (const auto& a : d.anchors)
    text += "  " + a->id + " " + std::to_string(static_cast<int>(a->verdict)) + " " + a->decided_by + " " +
            digits(a->pass_probability) + "\n";
  for (const auto& p : d.panels) text += told(*p);
  if (const CommonShiftT* s = d.common_shift.get())
    text += "  shift " + digits(1e3 * s->shift.x()) + " " + digits(1e3 * s->shift.y()) + " " +
            digits(1e3 * s->shift.z()) + " turn " + digits(1e3 * s->rotation.x()) + " " +
            digits(1e3 * s->rotation.y()) + " " + digits(1e3 * s->rotation.z()) + ", " + digits(s->statistic) + " of " +
            digits(s->critical) + ", scatter " + digits(1e3 * s->scatter) + ", effect " +
            digits(1e3 * s->largest_effect) + ", " + std::to_string(s->following) + " follow, " +
            std::to_string(s->would_pass) + " would pass: " + s->words + "\n";
  for (const std::string& warning : d.warnings) text += "  " + warning + "\n";
  return text;
}

TEST(Records, VerdictsOfAFacade) {
  std::string text;
  int seed = 0;
  for (const double size : {0.1, 0.5, 1.0, 2.0, 4.0}) {
    DeviationInputs inputs = facade();
    Normal normal(static_cast<std::uint64_t>(900 + seed++));
    const Eigen::Vector3d shift = Eigen::Vector3d(7, -5, 3) * (size == 4 ? mm : 0);
    for (auto& p : inputs.model.positions)
      p += shift + Eigen::Vector3d(4e-4, 3e-4, 6e-4).cross(p) * (size == 4) +
           Eigen::Vector3d(normal(), normal(), normal()) * 0.5 * size * mm;
    if (size == 1) inputs.model.positions[5].y() -= 9 * mm;
    if (size == 2) inputs.model.positions.back().z() += 40 * mm;
    text += "errors of " + digits(size) + "\n" + told(judge_deviations(inputs, {}));
  }
  plumbline::test::expect_recorded("unit/evaluate/facade_record.txt", text);
}

TEST(Deviation, AFloorOfWhichAnAnchorIsNotMeasuredIsOpen) {
  DeviationInputs inputs = facade();
  inputs.model.ids.pop_back(), inputs.model.positions.pop_back();
  inputs.model.covariance = judgement::test::isotropic(11, 0.1 * mm);
  inputs.panels.clear();
  const DeviationT d = judge_deviations(inputs, {});
  EXPECT_EQ(d.floors[0]->verdict, ToleranceVerdict::pass);
  EXPECT_EQ(d.floors[2]->verdict, ToleranceVerdict::undecided);
  EXPECT_EQ(d.verdict, ToleranceVerdict::undecided);
}

TEST(Deviation, ACommonShiftIsMeasuredByTheSmallestTolerance) {
  DeviationInputs inputs = facade();
  inputs.model.covariance = judgement::test::isotropic(12, 0.05 * mm);
  for (auto& p : inputs.model.positions) p.x() += 1.5 * mm;
  EXPECT_FALSE(judge_deviations(inputs, {}).common_shift->significant);
  for (AnchorCase& anchor : inputs.anchors)
    for (auto& [axis, tolerance] : anchor.tolerances) tolerance.value = 1 * mm;
  EXPECT_TRUE(judge_deviations(inputs, {}).common_shift->significant);
}

TEST(Panels, AJointNeedsTheTurnOfBothPanelsAndACovarianceToBeJudged) {
  DeviationInputs inputs = facade();
  inputs.model.covariance = {};
  ASSERT_FALSE(judge_deviations(inputs, {}).panels[0]->joints.empty());
  EXPECT_TRUE(std::isnan(judge_deviations(inputs, {}).panels[0]->joints[0]->change->u));
  inputs.panels[0].anchors = {0};
  EXPECT_TRUE(judge_deviations(inputs, {}).panels[0]->joints.empty());
}

}  // namespace test_record
}  // namespace plumbline::judgement
