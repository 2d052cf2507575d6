#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <algorithm>

#include "geometry/random.hpp"
#include "loop/gate/gate.hpp"
#include "loop/gate/station_error.hpp"
#include "random_facade.hpp"

namespace plumbline::loop {
namespace test_gate {

using test::random_facade;

TEST(Gate, AnchorsThatAreOffCanBeGo) {
  const Facade facade = random_facade({2, 3}, 3, 0.008, 0.0003, 0.0005);
  for (const PanelGate& gate : judge_plan(facade, plan_settings(facade))) {
    EXPECT_EQ(gate.verdict, GateVerdict::go) << gate.reason;
    EXPECT_GE(gate.p_in, 0.95);
  }
}

TEST(Gate, ABracketOutOfItsRangeIsNoGoWithTheRemedy) {
  Facade facade = random_facade({2, 3}, 3, 0.001, 0.0003, 0.0005);
  facade.brackets[tower_bracket({2, 3}, 0, 1, 0)].deviation.z() = -0.060;
  const std::vector<PanelGate> gates = judge_plan(facade, plan_settings(facade));
  EXPECT_EQ(gates[0].verdict, GateVerdict::no_go);
  EXPECT_NE(gates[0].reason.find("re-drill, or trim panel F01-P01"), std::string::npos) << gates[0].reason;
  EXPECT_EQ(gates[5].verdict, GateVerdict::go) << gates[5].reason;
}

TEST(Gate, HoldNamesTheMeasurementThatWouldDecide) {
  Facade facade = random_facade({1, 2}, 3, 0.001, 0.0002, 0);
  const auto bad = static_cast<Eigen::Index>(tower_bracket({1, 2}, 0, 1, 0));
  facade.covariance.block<3, 3>(3 * bad, 3 * bad) = 9e-6 * Eigen::Matrix3d::Identity();
  const std::vector<PanelGate> gates = judge_plan(facade, plan_settings(facade));
  EXPECT_EQ(gates[0].verdict, GateVerdict::hold);
  EXPECT_EQ(gates[0].measure.bracket, static_cast<int>(bad));
  EXPECT_GT(gates[0].measure.p_in, 0.95);
  EXPECT_LT(gates[0].measure.u, gates[0].measure.u_now);
  EXPECT_NE(gates[0].reason.find("measuring F01-C01-R2 once more"), std::string::npos) << gates[0].reason;
}

TEST(Gate, HoldNamesTheRobotThatWouldDo) {
  Facade facade = random_facade({1, 2}, 3, 0.001, 0.0002, 0);
  facade.errors.setting = 0.003;
  const std::vector<PanelGate> gates = judge_plan(facade, plan_settings(facade));
  EXPECT_EQ(gates[0].verdict, GateVerdict::hold) << gates[0].reason;
  EXPECT_GT(gates[0].robot_sigma, 0.0005);
  EXPECT_LT(gates[0].robot_sigma, 0.003);
  facade.errors.setting = gates[0].robot_sigma;
  EXPECT_GE(judge_plan(facade, plan_settings(facade))[0].p_in, 0.945);
}

TEST(Gate, WhatWasNotMeasuredHolds) {
  Facade facade = random_facade({1, 2}, 3, 0.001, 0.0002, 0);
  facade.brackets[tower_bracket({1, 2}, 0, 1, 2)].deviation.setConstant(kUnknown);
  const std::vector<PanelGate> gates = judge_plan(facade, plan_settings(facade));
  EXPECT_EQ(gates[0].verdict, GateVerdict::go) << gates[0].reason;
  EXPECT_EQ(gates[1].verdict, GateVerdict::hold);
  EXPECT_NE(gates[1].reason.find("not measured: F01-C03-R2"), std::string::npos) << gates[1].reason;
}

/// As the judgement of such a panel is undecided (Panels.AnchorsInOneLineShowNoPanelToBeInPlace), by the same measure.
TEST(Gate, TwoBracketsDoNotTellATurnAboutTheirLine) {
  Facade facade = random_facade({1, 1}, 3, 0.001, 0.0002, 0);
  Panel& panel = facade.panels[0];
  ASSERT_EQ(panel.hooks.size(), 4u);
  std::vector<Hook> top;
  for (const Hook& hook : panel.hooks)
    if (hook.holds[1]) top.push_back(hook);
  ASSERT_EQ(top.size(), 2u);
  panel.hooks = top;
  PanelGate gate = judge_plan(facade, plan_settings(facade))[0];
  EXPECT_EQ(gate.verdict, GateVerdict::hold);
  EXPECT_EQ(gate.obstacle, Obstacle::not_told);
  EXPECT_NE(gate.reason.find("how far its corners move out and up: a hook more"), std::string::npos) << gate.reason;
  // A strip along them, wide or narrow, as the judgement has it.
  const double height = panel.axes.col(1).dot(facade.brackets[top[0].bracket].design);
  const double depth = panel.axes.col(2).dot(facade.brackets[top[0].bracket].design);
  for (const double half : {0.04, 0.06}) {
    for (std::size_t k = 0; k < 4; ++k) {
      Eigen::Vector3d& corner = panel.corners[k];
      corner += (height + (k < 2 ? -half : half) - panel.axes.col(1).dot(corner)) * panel.axes.col(1);
      corner += (depth - panel.axes.col(2).dot(corner)) * panel.axes.col(2);
    }
    panel.centre = 0.25 * (panel.corners[0] + panel.corners[1] + panel.corners[2] + panel.corners[3]);
    gate = judge_plan(facade, plan_settings(facade))[0];
    EXPECT_EQ(gate.obstacle, half < 0.05 ? Obstacle::none : Obstacle::not_told) << half << ": " << gate.reason;
  }
}

TEST(Gate, NothingIsGoBelowWhatCanBeMeasured) {
  TowerOptions options{1, 2};
  options.tolerance = 0.0004;
  const Facade facade = random_facade(options, 3, 0.001, 0.0005, 0.001);
  const Fit fit = plan_settings(facade);
  for (const PanelGate& gate : judge_plan(facade, fit)) EXPECT_NE(gate.verdict, GateVerdict::go);
  EXPECT_NE(fit.notes.back().find("no setting can be shown to be good enough"), std::string::npos);
}

/// Few brackets slip, and far. A normal distribution of the same variance says that hardly any panel is outside.
/// The joint to a panel that cannot hang says nothing against the one below that hangs.
TEST(Gate, WhatHangsIsJudgedByWhatHangs) {
  Facade facade = random_facade({2, 1}, 3, 0.0005, 0.0002, 0);
  for (Bracket& bracket : facade.brackets) {
    bracket.fixed = bracket.floor == 1;
    if (bracket.floor == 2) bracket.deviation.z() = -0.080;
  }
  facade.panels[0].installed = true;
  const std::vector<PanelGate> gates = judge_plan(facade, plan_settings(facade));
  EXPECT_EQ(gates[0].verdict, GateVerdict::go) << gates[0].reason;
  EXPECT_EQ(gates[1].verdict, GateVerdict::no_go) << gates[1].reason;
}

TEST(Gate, SlipsAreStatedWithTheirTails) {
  TowerOptions options{1, 2};
  options.tolerance = 0.005, options.joint_tolerance = 0.005;
  Facade facade = random_facade(options, 5, 0.003, 0.0002, 0);
  facade.errors.setting = 0.0003, facade.errors.slip_share = 0.02, facade.errors.slip = 0.003;
  const Fit fit = plan_settings(facade);
  const double stated = judge_plan(facade, fit)[0].p_in;
  constexpr int kDraws = 20000;
  int inside = 0, normal = 0;
  for (int draw = 0; draw < kDraws; ++draw) {
    Random random(7, "slips", static_cast<std::uint64_t>(draw));
    std::vector<Eigen::Vector3d> slipping = fit.settings, smooth = fit.settings;
    const double same = std::sqrt(0.02) * 0.003;
    for (std::size_t b = 0; b < fit.settings.size(); ++b) {
      const Eigen::Vector3d both = random.normal3(0.0002) + random.normal3(0.0003);
      slipping[b] += both, smooth[b] += both + random.normal3(same);
      if (random.uniform() < 0.02) slipping[b] += random.normal3(0.003);
    }
    std::vector<double> made(5 * facade.panels.size());
    for (std::size_t i = 0; i < made.size(); ++i)
      made[i] = random.normal(i % 5 == 4 ? facade.errors.face : facade.errors.edge);
    const auto is_inside = [&](const std::vector<Eigen::Vector3d>& done) {
      const std::vector<double> values = values_of(facade, fit, done);
      for (std::size_t v = 0; v < values.size(); ++v) {
        const bool ours = std::any_of(fit.judged[v].rows.begin(), fit.judged[v].rows.end(),
                                      [](const auto& row) { return row.first == 0; });
        double value = values[v];
        for (const auto& [at, factor] : fit.judged[v].edges) value += factor * made[at];
        if (ours && (value < fit.judged[v].low || value > fit.judged[v].high)) return false;
      }
      return true;
    };
    inside += is_inside(slipping), normal += is_inside(smooth);
  }
  const double found = static_cast<double>(inside) / kDraws;
  EXPECT_NEAR(stated, found, 0.008);
  EXPECT_GT(static_cast<double>(normal) / kDraws - found, 0.005);
}

/// Control of a floor that was knocked, and plates that were, before anything was measured: by draws of the truth.
TEST(Gate, WhatWasKnockedBeforeTheFirstCampaignIsStated) {
  Facade facade = random_facade({1, 2}, 5, 0.003, 0.0003, 0);
  facade.errors.setting = 0.0003;
  const Fit fit = plan_settings(facade);
  const double unknocked = judge_plan(facade, fit)[0].p_in;
  facade.errors.knock_share = 0.01, facade.errors.control_share = 0.05;
  const double stated = judge_plan(facade, fit)[0].p_in;
  constexpr int kDraws = 20000;
  int inside = 0;
  for (int draw = 0; draw < kDraws; ++draw) {
    Random random(3, "knocks", static_cast<std::uint64_t>(draw));
    std::vector<Eigen::Vector3d> done = fit.settings;
    const double control = random.uniform() < 0.05 ? random.normal(0.006) : 0.0;
    for (Eigen::Vector3d& setting : done) {
      setting += random.normal3(std::hypot(0.0003, 0.0003)) + Eigen::Vector3d(0, control, 0);
      if (random.uniform() < 0.01) setting += random.normal3(0.003);
    }
    const std::vector<double> values = values_of(facade, fit, done);
    bool in = true;
    for (std::size_t v = 0; v < values.size(); ++v) {
      double value = values[v];
      for (const auto& [at, factor] : fit.judged[v].edges)
        value += factor * Random(4, "made " + std::to_string(draw), at).normal(0.0005);
      for (const auto& [panel, row] : fit.judged[v].rows)
        in = in && (panel != 0 || (value >= fit.judged[v].low && value <= fit.judged[v].high));
    }
    inside += in;
  }
  EXPECT_NEAR(stated, static_cast<double>(inside) / kDraws, 0.006);
  EXPECT_GT(unknocked - stated, 0.015);
}

/// What control is off by stays, however often is measured on it.
TEST(Gate, MoreCampaignsTellNothingOfControl) {
  Facade facade = random_facade({1, 1}, 5, 0.001, 0.0012, 0);
  facade.own = facade.covariance;
  const auto gate = [&] { return judge_plan(facade, plan_settings(facade))[0]; };
  const PanelGate own = gate();
  ASSERT_EQ(own.verdict, GateVerdict::hold) << own.reason;
  EXPECT_GT(own.p_repeated, 0.95);
  EXPECT_GT(own.measure.p_in, own.p_in + 0.01);
  facade.own.setZero();  // all of it is control's
  facade.own.diagonal().setConstant(1e-12);
  const PanelGate common = gate();
  EXPECT_NEAR(common.p_repeated, common.p_in, 0.02);
  EXPECT_EQ(common.measure.bracket, -1) << common.reason;
}

/// Errors drawn as the facade says they are: shares of panels inside against what was stated.
TEST(Gate, StatedProbabilitiesAreTrue) {
  TowerOptions options{2, 2};
  options.tolerance = 0.003, options.joint_tolerance = 0.004;
  double stated = 0, inside = 0;
  int items = 0;
  for (std::uint64_t seed = 1; seed <= 150; ++seed) {
    Facade facade = random_facade(options, seed, 0.004, 0.0006, 0.0008);
    facade.errors.station = 0.0004;
    const Fit fit = plan_settings(facade);
    const std::vector<PanelGate> gates = judge_plan(facade, fit);
    // The truth is off from what was measured by the covariance, brackets are set with their error.
    Random random(seed, "truth");
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(facade.covariance);
    Eigen::VectorXd z(facade.covariance.rows());
    for (Eigen::Index i = 0; i < z.size(); ++i) z[i] = random.normal();
    const Eigen::VectorXd error = eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(0).cwiseSqrt().cwiseProduct(z);
    std::vector<Eigen::Vector3d> done = fit.settings;
    const Eigen::Vector3d station[2] = {random.normal3(0.0004), random.normal3(0.0004)};
    for (std::size_t b = 0; b < done.size(); ++b)
      done[b] += facade.brackets[b].axes.transpose() *
                     (error.segment<3>(3 * static_cast<Eigen::Index>(b)) + station[facade.brackets[b].floor - 1]) +
                 random.normal3(facade.errors.setting);
    const std::vector<double> values = values_of(facade, fit, done);
    std::vector<double> made(5 * facade.panels.size());
    for (std::size_t i = 0; i < made.size(); ++i)
      made[i] = random.normal(i % 5 == 4 ? facade.errors.face : facade.errors.edge);
    std::vector<bool> in(facade.panels.size(), true);
    for (std::size_t v = 0; v < values.size(); ++v) {
      double value = values[v];
      for (const auto& [at, factor] : fit.judged[v].edges) value += factor * made[at];
      if (value < fit.judged[v].low || value > fit.judged[v].high)
        for (const auto& [panel, row] : fit.judged[v].rows) in[panel] = false;
    }
    for (std::size_t j = 0; j < gates.size(); ++j) stated += gates[j].p_in, inside += in[j], ++items;
  }
  EXPECT_NEAR(stated / items, inside / items, 0.05);  // 600 items in groups of four that hang together
  EXPECT_GT(stated / items, 0.4);
  EXPECT_LT(stated / items, 0.99);
}

/// What one robot is off by cancels in the joint between two panels that it sets, and not where two robots set them.
TEST(Gate, AJointBetweenPanelsOfTwoRobotsHasTheErrorsOfBoth) {
  Facade facade = random_facade({1, 2}, 3, 0.001, 0.0002, 0);
  facade.errors.setting = facade.errors.edge = facade.errors.face = 0;
  const auto n = 3 * static_cast<Eigen::Index>(facade.brackets.size());
  const auto largest = [&](int robots) {
    facade.stations = Eigen::MatrixXd::Zero(n, n);
    for (std::size_t i = 0; i < facade.brackets.size(); ++i)
      for (std::size_t j = 0; j < facade.brackets.size(); ++j) {
        const bool same = robots == 1 || (facade.brackets[i].design.x() < 1.9) == (facade.brackets[j].design.x() < 1.9);
        facade.stations.block<3, 3>(3 * static_cast<Eigen::Index>(i), 3 * static_cast<Eigen::Index>(j)) =
            (same && robots > 0 ? 1e-6 : 0.0) * Eigen::Matrix3d::Identity();
      }
    const Fit fit = plan_settings(facade);
    double most = 0;
    for (std::size_t v = 0; v < fit.judged.size(); ++v)
      if (fit.judged[v].quantity != Quantity::corner) most = std::max(most, fit.values[v].u);
    return most;
  };
  EXPECT_NEAR(largest(1), largest(0), 1e-9);
  EXPECT_GT(largest(2), largest(1) + 1e-4);
}

/// By draws: robots that believe a pose and are at another.
TEST(StationError, ItsCovarianceIsThatOfWhereThingsStand) {
  Random random(4);
  Eigen::Matrix<double, 6, 6> root = Eigen::Matrix<double, 6, 6>::Zero();
  for (Eigen::Index i = 0; i < 6; ++i)
    for (Eigen::Index j = 0; j <= i; ++j) root(i, j) = random.normal() * (i < 3 ? 1e-4 : 5e-4);
  const Eigen::Matrix<double, 6, 6> covariance = root * root.transpose();
  PoseT pose;
  pose.path = "robot.jpg";
  pose.cam_from_world = {quaternion_from_rotation_vector({1.4, 0.2, -0.1}), {3, -2, 5}};
  for (Eigen::Index i = 0; i < 6; ++i)
    for (Eigen::Index j = 0; j <= i; ++j) pose.covariance.push_back(covariance(i, j));
  const Eigen::Vector3d point(2, 7, 4);
  const int draws = 20000;
  Eigen::Matrix3d found = Eigen::Matrix3d::Zero();
  for (int i = 0; i < draws; ++i) {
    Eigen::Matrix<double, 6, 1> white;
    white << random.normal3(1), random.normal3(1);
    const Eigen::Matrix<double, 6, 1> step = root * white;
    const RigidTransform there{quaternion_from_rotation_vector(step.head<3>()) * pose.cam_from_world.rotation,
                               pose.cam_from_world.translation + step.tail<3>()};
    const Eigen::Vector3d off = station_error(pose.cam_from_world, there, point);
    found += off * off.transpose() / draws;
  }
  const Eigen::Matrix3d stated = station_covariance(pose, point);
  EXPECT_LT((found - stated).norm(), 0.04 * stated.norm()) << found << "\n" << stated;
  // Two robots far apart share nothing, unless their poses say so; one shares all with itself.
  PosesT stations;
  for (int i = 0; i < 2; ++i) {
    stations.poses.push_back(std::make_unique<PoseT>(pose));
    stations.poses.back()->cam_from_world.translation -= pose.cam_from_world.rotation * Eigen::Vector3d(100 * i, 0, 0);
  }
  const std::vector<Eigen::Vector3d> places = {point, point + Eigen::Vector3d(100, 0, 0), point};
  const Eigen::MatrixXd apart = station_covariances(stations, places);
  EXPECT_LT((apart.block<3, 3>(0, 6) - stated).norm(), 1e-12);
  EXPECT_LT((apart.block<3, 3>(3, 3) - station_covariance(*stations.poses[1], places[1])).norm(), 1e-12);
  EXPECT_EQ((apart.block<3, 3>(0, 3).norm()), 0);
  const auto jointly = [&](double correlation) {
    Eigen::MatrixXd both = Eigen::MatrixXd::Zero(16, 16);  // eight unknowns a photograph
    for (Eigen::Index i = 0; i < 2; ++i)
      for (Eigen::Index j = 0; j < 2; ++j) both.block<6, 6>(8 * i, 8 * j) = (i == j ? 1.0 : correlation) * covariance;
    stations.joint_covariance.clear();
    for (Eigen::Index i = 0; i < 16; ++i)
      for (Eigen::Index j = 0; j <= i; ++j) stations.joint_covariance.push_back(both(i, j));
    return station_covariances(stations, places);
  };
  const Eigen::MatrixXd half = jointly(0.5), full = jointly(1);
  EXPECT_LT((half - 0.5 * (apart + full)).norm(), 1e-12);
  EXPECT_GT((full.block<3, 3>(0, 3).norm()), 0.1 * stated.norm());
  // Who turn and shift alike move both places as one body does: what is left of the difference is by the turn.
  const Eigen::Matrix3d difference =
      full.block<3, 3>(0, 0) + full.block<3, 3>(3, 3) - full.block<3, 3>(0, 3) - full.block<3, 3>(3, 0);
  EXPECT_LT(difference(0, 0), 1e-6 * full(3, 3) + 1e-12);  // along the 100 m between them
  stations.joint_covariance.pop_back();
  EXPECT_THROW(station_covariances(stations, places), std::runtime_error);
  pose.covariance.clear();
  EXPECT_THROW(station_covariance(pose, point), std::runtime_error);
  EXPECT_THROW(nearest_station({}, point), std::runtime_error);
}

}  // namespace test_gate
}  // namespace plumbline::loop
