// Settings of brackets: optimal, within their limits, and least relaxed where that cannot be.
#include <gtest/gtest.h>

#include <ClpSimplex.hpp>
#include <Eigen/Geometry>
#include <cmath>

#include "loop/fit/bracket_rules.hpp"
#include "loop/fit/limit_dual.hpp"
#include "plumbline/stop.hpp"
#include "random_facade.hpp"

namespace plumbline::loop {
namespace test_fit {

using test::random_facade;

std::vector<Limit> all_limits(const Facade& facade, const SettingsProgram& program, const Fit& fit) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  std::vector<Limit> limits;
  const auto add = [&](Limit limit) {
    limits.push_back(limit), limits.back().low = -infinity;
    limits.push_back(limit), limits.back().high = infinity;
  };
  for (std::size_t b = 0; b < facade.brackets.size(); ++b)
    for (int k = 0; program.is_set(b) && k < 3; ++k)
      add({static_cast<int>(b), k, -1, 1e3 * facade.brackets[b].type.low[k], 1e3 * facade.brackets[b].type.high[k]});
  for (std::size_t v = 0; v < fit.judged.size(); ++v) {
    const double half = 0.5 * (fit.judged[v].high - fit.judged[v].low);
    const double guard = std::min(facade.errors.guard_factor * fit.values[v].u, 0.9 * half);
    add({-1, -1, static_cast<int>(v), 1e3 * (fit.judged[v].low + guard), 1e3 * (fit.judged[v].high - guard)});
  }
  return limits;
}

/// The whole program at once, all limits known from the start.
ConvexProgram whole_program(const Facade& facade, const FitWeights& weights = {}) {
  const Fit fit =
      fit_of_settings(facade, std::vector<Eigen::Vector3d>(facade.brackets.size(), Eigen::Vector3d::Zero()));
  const SettingsProgram program(facade, fit.poses, fit.judged, weights);
  return program.with(all_limits(facade, program, fit));
}

/// Its optimum with the multipliers of all limits as the unknowns.
ConvexOptimum optimum_by_limits(const Facade& facade, const FitWeights& weights = {}) {
  const Fit fit =
      fit_of_settings(facade, std::vector<Eigen::Vector3d>(facade.brackets.size(), Eigen::Vector3d::Zero()));
  const SettingsProgram program(facade, fit.poses, fit.judged, weights);
  LimitDual dual(program);
  EXPECT_TRUE(dual.is_regular());
  const std::vector<Limit> limits = all_limits(facade, program, fit);
  dual.optimum({limits.begin() + limits.size() / 2, limits.begin() + limits.size() / 2 + 7});  // known to what follows
  return dual.optimum(limits);
}

/// The same derived anew from docs/loop_explained.md, with the twists of the panels and all settings as unknowns and an
/// equation for each hook, all in millimetres: hooks * twist - direction * axes * setting = direction * deviation. For
/// facades of which nothing hangs and all is measured and may be set.
ConvexProgram program_of_twists(const Facade& facade, const FitWeights& weights = {}) {
  const Fit fit =
      fit_of_settings(facade, std::vector<Eigen::Vector3d>(facade.brackets.size(), Eigen::Vector3d::Zero()));
  const std::vector<Limit> limits = all_limits(facade, SettingsProgram(facade, fit.poses, fit.judged, weights), fit);
  const int panels = static_cast<int>(facade.panels.size());
  const int settings = 6 * panels, excesses = settings + 3 * static_cast<int>(facade.brackets.size());
  const int n = excesses + static_cast<int>(limits.size());
  using Row = std::vector<std::pair<int, double>>;
  std::vector<Eigen::Triplet<double>> squares, rows;
  ConvexProgram program;
  program.linear = Eigen::VectorXd::Zero(n);
  const auto of_twist = [](std::size_t panel, const Eigen::Matrix<double, 1, 6>& movement) {
    Row row;
    for (int k = 0; k < 6; ++k) row.emplace_back(6 * static_cast<int>(panel) + k, movement[k]);
    return row;
  };
  const auto add_square = [&](const Row& row, double weight) {
    for (const auto& [i, a] : row)
      for (const auto& [j, b] : row) squares.emplace_back(i, j, 2 * weight * a * b);
  };
  std::vector<double> low, high;
  const auto add_row = [&](const Row& row, double least, double most) {
    for (const auto& [i, a] : row) rows.emplace_back(static_cast<int>(low.size()), i, a);
    low.push_back(least), high.push_back(most);
  };
  std::vector<Row> values;
  for (const JudgedValue& value : fit.judged) {
    Row& row = values.emplace_back();
    for (const auto& [panel, movement] : value.rows)
      for (const auto& entry : of_twist(panel, movement)) row.push_back(entry);
    if (value.quantity != Quantity::corner)
      add_square(row, (value.quantity == Quantity::gap ? weights.gap : weights.step) / 2);
  }
  for (std::size_t j = 0; j < facade.panels.size(); ++j) {
    const Panel& panel = facade.panels[j];
    const PanelPose& pose = fit.poses[j];
    for (const Eigen::Vector3d& corner : panel.corners)
      for (int k = 0; k < 3; ++k)
        add_square(of_twist(j, pose.movement(panel, corner, panel.axes.col(k))), weights.pose / 4);
    for (std::size_t h = 0; h < pose.held.size(); ++h) {
      const Bracket& bracket = facade.brackets[pose.held[h].bracket];
      Row row = of_twist(j, pose.movement(panel, bracket.design, pose.held[h].direction));
      const Eigen::Vector3d along = bracket.axes.transpose() * pose.held[h].direction;
      for (int k = 0; k < 3; ++k)
        row.emplace_back(settings + 3 * static_cast<int>(pose.held[h].bracket) + k, -along[k]);
      const double off = 1e3 * pose.held[h].direction.dot(bracket.deviation);
      add_row(row, off, off);
    }
  }
  for (int s = settings; s < excesses; ++s) add_square({{s, 1.0}}, weights.setting);
  for (std::size_t i = 0; i < limits.size(); ++i) {
    const Limit& limit = limits[i];
    Row row = limit.value >= 0 ? values[limit.value] : Row{{settings + 3 * limit.bracket + limit.direction, 1.0}};
    const double constant = limit.value >= 0 ? 1e3 * fit.judged[limit.value].constant : 0;
    row.emplace_back(excesses + static_cast<int>(i), std::isfinite(limit.high) ? -1.0 : 1.0);
    program.linear[excesses + static_cast<int>(i)] = limit.value >= 0 ? kTolerancePrice : kRangePrice;
    add_row(row, limit.low - constant, limit.high - constant);
  }
  program.quadratic.resize(n, n), program.quadratic.setFromTriplets(squares.begin(), squares.end());
  program.rows.resize(static_cast<Eigen::Index>(low.size()), n), program.rows.setFromTriplets(rows.begin(), rows.end());
  program.low = Eigen::Map<const Eigen::VectorXd>(low.data(), program.rows.rows());
  program.high = Eigen::Map<const Eigen::VectorXd>(high.data(), program.rows.rows());
  constexpr double infinity = std::numeric_limits<double>::infinity();
  program.x_low = Eigen::VectorXd::Constant(n, -infinity), program.x_high = Eigen::VectorXd::Constant(n, infinity);
  program.x_low.tail(n - excesses).setZero();
  return program;
}

/// Another program's answer: Clp's barrier method. It takes one triangle of the quadratic part.
double clp_value(const ConvexProgram& p) {
  Eigen::SparseMatrix<double> columns = p.rows;
  columns.makeCompressed();
  Eigen::SparseMatrix<double> lower = p.quadratic.triangularView<Eigen::Lower>();
  lower.makeCompressed();
  const auto finite = [](Eigen::VectorXd v) {
    return Eigen::VectorXd(v.unaryExpr([](double x) { return std::clamp(x, -COIN_DBL_MAX, COIN_DBL_MAX); }));
  };
  const Eigen::VectorXd x_low = finite(p.x_low), x_high = finite(p.x_high), low = finite(p.low), high = finite(p.high);
  ClpSimplex clp;
  clp.setLogLevel(0);
  std::vector<CoinBigIndex> starts(columns.outerIndexPtr(), columns.outerIndexPtr() + columns.cols() + 1);
  clp.loadProblem(static_cast<int>(columns.cols()), static_cast<int>(columns.rows()), starts.data(),
                  columns.innerIndexPtr(), columns.valuePtr(), x_low.data(), x_high.data(), p.linear.data(), low.data(),
                  high.data());
  std::vector<CoinBigIndex> of_quadratic(lower.outerIndexPtr(), lower.outerIndexPtr() + lower.cols() + 1);
  clp.loadQuadraticObjective(static_cast<int>(lower.cols()), of_quadratic.data(), lower.innerIndexPtr(),
                             lower.valuePtr());
  clp.setPrimalTolerance(1e-9), clp.setDualTolerance(1e-9);
  ClpSolve how;
  how.setSolveType(ClpSolve::useBarrier);
  clp.initialSolve(how);
  EXPECT_TRUE(clp.isProvenOptimal());
  const Eigen::Map<const Eigen::VectorXd> x(clp.primalColumnSolution(), columns.cols());
  return x.dot(0.5 * (p.quadratic * x) + p.linear) + p.constant;
}

/// Without a rule the topmost brackets carry, the leftmost of them holds sideways; those below only hold to the wall.
TEST(UsualHook, CarriesInTheTopRowAndHoldsSidewaysAtItsLeft) {
  const std::vector<Eigen::Vector3d> brackets = {{0, 0, 0}, {2, 0, 0}, {0, 3, 0}, {2, 3.1, 0}};
  using Hook = std::array<bool, 3>;
  const Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();
  for (const std::size_t below : {0, 1}) EXPECT_EQ(usual_hook(brackets, below, axes), (Hook{false, false, true}));
  EXPECT_EQ(usual_hook(brackets, 2, axes), (Hook{true, true, true}));
  EXPECT_EQ(usual_hook(brackets, 3, axes), (Hook{false, true, true}));
  // One row is what lies within 0.3 m of the topmost; the leftmost of it counts, not that of a lower row.
  const std::vector<Eigen::Vector3d> rows = {{-1, 2.69, 0}, {0, 2.71, 0}, {2, 3, 0}};
  EXPECT_EQ(usual_hook(rows, 0, axes), (Hook{false, false, true}));
  EXPECT_EQ(usual_hook(rows, 1, axes), (Hook{true, true, true}));
  EXPECT_EQ(usual_hook(rows, 2, axes), (Hook{false, true, true}));
}

TEST(HookRule, SaysInWhichDirectionsABracketHolds) {
  using Hook = std::array<bool, 3>;
  const std::pair<const char*, Hook> words[] = {{"fixed", {true, true, true}},
                                                {"slides_sideways", {false, true, true}},
                                                {"slides_up", {true, false, true}},
                                                {"slides", {false, false, true}}};
  for (const auto& [word, holds] : words)
    EXPECT_EQ(parse_hook_rule("name~-R2$: " + std::string(word)).holds, holds) << word;
  try {
    parse_hook_rule("name~-R2$: hangs");
    FAIL();
  } catch (const std::runtime_error& error) {
    EXPECT_EQ(std::string(error.what()),
              "hook rule 'name~-R2$: hangs': found 'hangs', expected fixed, slides_sideways, slides_up or slides");
  }
}

TEST(BracketRule, AStepThatIsLongerThanTheRangeIsRefused) {
  EXPECT_NO_THROW(parse_bracket_rule("*: right=20mm, up=15mm, out=25mm, step_out=25mm"));
  EXPECT_THROW(parse_bracket_rule("*: right=20mm, up=15mm, out=10mm, step_out=50mm"), std::runtime_error);
}

/// A number or a name that is not understood would leave what is assumed: 20 mm for a bracket that has 8.
TEST(BracketRule, TheDesignsRangeIsReadOrNamed) {
  const auto type = [](const std::vector<ifc::Property>& properties, const std::vector<BracketRule>& rules = {}) {
    ifc::ElementFacts anchor;
    anchor.name = "F01-C01-R1", anchor.ifc_class = "IfcMechanicalFastener", anchor.properties = &properties;
    return bracket_type_of(rules, anchor);
  };
  const auto words = [&](const std::vector<ifc::Property>& properties) {
    try {
      type(properties);
    } catch (const std::runtime_error& error) {
      return std::string(error.what());
    }
    return std::string("read");
  };
  const BracketType read = *type({{"Pset_BracketRange", "Up", "", 0.008},
                                  {"Pset_BracketRange", "StepUp", "", 0.002},
                                  {"Pset_Other", "Rigth", "", 8}});
  EXPECT_EQ(read.high, Eigen::Vector3d(0.020, 0.008, 0.025));
  EXPECT_EQ(read.low, Eigen::Vector3d(-0.020, -0.008, -0.025));
  EXPECT_EQ(read.step, Eigen::Vector3d(0, 0.002, 0));
  EXPECT_EQ(read.name, "design: Pset_BracketRange");
  EXPECT_EQ(type({})->name, "assumed");
  EXPECT_FALSE(type({}, {parse_bracket_rule("class=IfcWall: up=5mm")})) << "rules, and none for it";
  EXPECT_EQ(type({{"Pset_BracketRange", "Up", "", 0.008}}, {parse_bracket_rule("*: up=5mm")})->high.y(), 0.005);
  EXPECT_NE(words({{"Pset_BracketRange", "Rigth", "", 0.008}}).find("has 'Rigth'; expected Right, Up"),
            std::string::npos);
  EXPECT_NE(words({{"Pset_BracketRange", "Up", "8", 8}}).find("Up is 8, expected a length from 0 to 0.5 m"),
            std::string::npos)
      << "millimetres in a design in metres";
  EXPECT_NE(words({{"Pset_BracketRange", "Up", "8 mm", ifc::Property::nan}}).find("Up is 8 mm, expected"),
            std::string::npos);
  EXPECT_NE(words({{"Pset_BracketRange", "Up", "", 0.001}, {"Pset_BracketRange", "StepUp", "", 0.002}})
                .find("its step up is longer than its range"),
            std::string::npos);
  EXPECT_THROW(parse_bracket_rule("*: up=5mm, up=8mm"), std::runtime_error);
}

/// Not "no optimum", wherever Ipopt was.
TEST(Fit, StopsWhenNobodyWaitsForIt) {
  const ConvexProgram program = whole_program(random_facade({2, 2}, 1, 0.010));
  struct Asked {
    int limit, count;
  };
  for (const int limit : {0, 1, 3}) {
    Asked asked{limit, 0};
    const StopScope scope(
        [](const void* of) {
          auto& all = *static_cast<Asked*>(const_cast<void*>(of));
          return ++all.count > all.limit;
        },
        &asked);
    EXPECT_THROW(minimise(program), Stopped) << limit;
  }
}

/// The conditions of Karush, Kuhn and Tucker, and another program, of another derivation.
TEST(Fit, IsOptimalByItsConditionsAndByAnotherSolverOnAHundredRandomFacades) {
  int infeasible = 0;
  for (std::uint64_t seed = 1; seed <= 100; ++seed) {
    // From easy ones to such that no setting suffices.
    const Facade facade = random_facade({2, 2}, seed, 0.002 + 0.0002 * static_cast<double>(seed));
    const ConvexProgram program = whole_program(facade);
    const double theirs = clp_value(program_of_twists(facade));
    for (const ConvexOptimum& optimum : {minimise(program), optimum_by_limits(facade)}) {
      const OptimalityGap gap = optimality_gap(program, optimum);
      EXPECT_LT(gap.stationarity, 1e-4) << seed;  // of prices of 1e4 and more
      EXPECT_LT(gap.feasibility, 1e-7) << seed;
      EXPECT_LT(gap.complementarity, 1e-3) << seed;
      EXPECT_LT(gap.sign, 1e-6) << seed;
      EXPECT_NEAR(optimum.value, theirs, 1e-4 * std::abs(theirs) + 1e-5) << "seed " << seed;
    }
    infeasible += theirs > kRangePrice * 0.01;
  }
  EXPECT_GT(infeasible, 20);
  EXPECT_LT(infeasible, 80);
}

/// Forces that a millimetre takes differ by orders of magnitude from limit to limit, and with the weights. On some of
/// these programs Mehrotra's steps go round and round.
TEST(Fit, LimitsThatTakeLargeForcesHaveTheirOptimum) {
  int broken = 0;
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    const Facade facade = random_facade({2, 2}, seed, 0.012);
    const Fit fit =
        fit_of_settings(facade, std::vector<Eigen::Vector3d>(facade.brackets.size(), Eigen::Vector3d::Zero()));
    const double w = seed % 2 ? 3e3 : 3e4;
    const SettingsProgram program(facade, fit.poses, fit.judged, {w, w, w, 0.01 * w});
    LimitDual dual(program);
    ASSERT_TRUE(dual.is_regular());
    const Eigen::VectorXd free = dual.optimum({}).x;
    for (const Limit& limit : all_limits(facade, program, fit)) {
      const double at = program.at(limit, free);
      if (at >= limit.low && at <= limit.high) continue;
      ++broken;
      const OptimalityGap gap = optimality_gap(program.with({limit}), dual.optimum({limit}));
      EXPECT_LT(gap.stationarity, 1e-4);
      EXPECT_LT(gap.feasibility, 1e-6);
      EXPECT_LT(gap.complementarity, 1e-2);
    }
  }
  EXPECT_GE(broken, 10);
}

/// Two panels on the same four brackets (a panel and its sunshade) must both lie flat on them: their equations depend
/// on each other.
TEST(Fit, PanelsOnTheSameBracketsHaveTheOptimumOfAllLimits) {
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    Facade facade = random_facade({2, 2}, seed, 0.008);
    facade.panels.push_back(facade.panels[0]);
    facade.panels.back().id = facade.panels.back().name = "sunshade";
    const double planned = 1e6 * plan_settings(facade).objective;
    EXPECT_NEAR(planned, minimise(whole_program(facade)).value, 1e-6 * std::abs(planned) + 1e-6) << seed;
  }
}

/// Both ways of the solver: many limits are more than the multipliers are taken as unknowns for.
TEST(Fit, AFacadeOfWhichHundredsOfLimitsHoldHasTheOptimumOfAllOfThem) {
  const Facade facade = random_facade({9, 8}, 3, 0.013);
  const Fit fit = plan_settings(facade);
  EXPECT_GT(fit.relaxations.size(), 10u);
  const double whole = minimise(whole_program(facade)).value;
  EXPECT_NEAR(1e6 * fit.objective, whole, 1e-6 * std::abs(whole));
}

TEST(Fit, LimitsAddedOnDemandGiveTheOptimumOfAllOfThem) {
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    const Facade facade = random_facade({3, 2}, seed, 0.012);
    for (const FitWeights& weights : {FitWeights{}, FitWeights{1, 1, 1, 1e-6}}) {  // settings may cost next to nothing
      const double on_demand = 1e6 * plan_settings(facade, weights).objective;
      EXPECT_NEAR(on_demand, minimise(whole_program(facade, weights)).value, 1e-6 * std::abs(on_demand) + 1e-6) << seed;
    }
  }
}

TEST(Fit, WithoutNoiseEveryPanelComesToItsDesignWithinRange) {
  const Facade facade = random_facade({3, 4}, 7, 0.003, 1e-6, 0);
  const Fit fit = plan_settings(facade, {1, 1, 1, 1e-9});
  EXPECT_TRUE(fit.relaxations.empty());
  for (const auto& twist : fit.twists) EXPECT_LT(twist.norm(), 1e-6);
  // What a hook holds is set back by what the anchor is off; what slides is left alone.
  EXPECT_NEAR(fit.settings[tower_bracket({3, 4}, 0, 1, 0)].z(),
              -facade.brackets[tower_bracket({3, 4}, 0, 1, 0)].axes.col(2).dot(
                  facade.brackets[tower_bracket({3, 4}, 0, 1, 0)].deviation),
              1e-6);
  EXPECT_NEAR(fit.settings[tower_bracket({3, 4}, 0, 0, 0)].y(), 0, 1e-9);
}

TEST(Fit, TheSameInTurnedFrames) {
  const Facade facade = random_facade({2, 3}, 3, 0.012);
  Facade turned = facade;
  const Eigen::Matrix3d r = Eigen::AngleAxisd(0.7, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  const Eigen::Vector3d t(350000, 5800000, 100);
  for (Bracket& b : turned.brackets) b.design = r * b.design + t, b.axes = r * b.axes, b.deviation = r * b.deviation;
  for (Panel& p : turned.panels) {
    p.axes = r * p.axes, p.centre = r * p.centre + t;
    for (auto& c : p.corners) c = r * c + t;
  }
  for (Joint& j : turned.joints) {
    j.across = r * j.across;
    for (auto& p : j.on_a) p = r * p + t;
    for (auto& p : j.on_b) p = r * p + t;
  }
  const Fit a = plan_settings(facade), b = plan_settings(turned);
  for (std::size_t i = 0; i < a.settings.size(); ++i) EXPECT_LT((a.settings[i] - b.settings[i]).norm(), 2e-7);
}

TEST(Fit, WhatNeighboursShareCancelsInTheirJoint) {
  const TowerOptions options{1, 2};
  Facade facade = random_facade(options, 1, 0.003, 0.0002, 0.003);  // 3 mm that all brackets have in common
  facade.errors.setting = facade.errors.edge = facade.errors.face = 0;
  const Fit joint = plan_settings(facade);
  const Eigen::MatrixXd variances = facade.covariance.diagonal().asDiagonal();
  facade.covariance = variances;
  const Fit apart = plan_settings(facade);
  for (std::size_t v = 0; v < joint.judged.size(); ++v) {
    if (joint.judged[v].quantity == Quantity::corner) {
      EXPECT_GT(joint.values[v].u, 0.0029);  // for one panel nothing cancels
    } else {
      EXPECT_LT(joint.values[v].u, 0.2 * apart.values[v].u) << joint.judged[v].words(facade);
    }
  }
}

TEST(Fit, ABracketOutOfRangeIsNamedWithWhatToDo) {
  Facade facade = random_facade({2, 3}, 5, 0.001, 0.0002, 0.0002);
  const std::size_t bad = tower_bracket({2, 3}, 1, 1, 0);
  facade.brackets[bad].deviation = {0, 0, -0.026};  // 26 mm low; 15 of range and 5 of tolerance
  const Fit fit = plan_settings(facade);
  ASSERT_EQ(fit.relaxations.size(), 1u);
  EXPECT_EQ(fit.relaxations[0].bracket, static_cast<int>(bad));
  EXPECT_NE(fit.relaxations[0].words.find("bracket F02-C01-R2 would have to move"), std::string::npos);
  EXPECT_NE(fit.relaxations[0].words.find("mm up, it has 15.0: re-drill, or trim panel F02-P01 by"), std::string::npos)
      << fit.relaxations[0].words;
  for (std::size_t b = 0; b < facade.brackets.size(); ++b) {
    EXPECT_TRUE((fit.settings[b].array() <= facade.brackets[b].type.high.array() + 1e-12).all());
    EXPECT_TRUE((fit.settings[b].array() >= facade.brackets[b].type.low.array() - 1e-12).all());
  }
}

TEST(Fit, AToleranceBelowWhatIsMeasuredIsNamedWithThePrecisionThatWouldDo) {
  Facade facade = random_facade({1, 2}, 5, 0.001, 0.0005, 0.0005);
  const auto words_of = [](const Fit& fit) {
    for (const std::string& note : fit.notes)
      if (note.find("nine tenths") != std::string::npos) return note;
    return std::string();
  };
  EXPECT_EQ(words_of(plan_settings(facade)), "");
  for (Panel& panel : facade.panels) panel.limits = {0.0002, 0.0002, 0.0002};
  const std::string words = words_of(plan_settings(facade));
  // 0.9 of 0.2 mm over k = 1.645.
  EXPECT_NE(words.find("mm, and 0.11 mm or less would do"), std::string::npos) << words;
  EXPECT_NE(words.find("; worst is the corner "), std::string::npos) << words;
}

/// Who drills one of a panel's brackets again must know which others have nothing left.
TEST(Fit, AllRangesThatBindAreNamed) {
  Facade facade = random_facade({1, 1}, 5, 0.0, 0.0002, 0.0002);
  const std::size_t high = tower_bracket({1, 1}, 0, 1, 0);
  facade.brackets[high].deviation.z() = -0.026;                             // 15 of range, 5 of tolerance
  facade.brackets[tower_bracket({1, 1}, 0, 1, 1)].deviation.z() = -0.0192;  // within its range, and all of it is used
  const Fit fit = plan_settings(facade);
  ASSERT_FALSE(fit.relaxations.empty());
  bool named = false;
  for (const Relaxation& relaxed : fit.relaxations) {
    if (relaxed.bracket != static_cast<int>(high)) continue;
    named =
        relaxed.words.find("; at the end of their ranges beside it: F01-C02-R2 with 15.0 mm up") != std::string::npos;
    EXPECT_TRUE(named) << relaxed.words;
    EXPECT_EQ(relaxed.words.find("beside it: F01-C01-R2"), std::string::npos) << "it has a line of its own";
  }
  EXPECT_TRUE(named);
}

TEST(Fit, ShimsComeInSteps) {
  Facade facade = random_facade({2, 2}, 5, 0.003);
  for (Bracket& bracket : facade.brackets) bracket.type.step = {0, 0, 0.001};
  const Fit fit = plan_settings(facade);
  for (const Eigen::Vector3d& setting : fit.settings)
    EXPECT_NEAR(setting.z(), 1e-3 * std::round(1e3 * setting.z()), 1e-12);
}

TEST(Fit, PanelsOfTwoPlanesShareABracket) {
  // The second panel turned to the right-hand side of a corner: what is "out" for one is "right" for the other.
  Facade facade = make_tower({1, 2});
  Panel& around = facade.panels[1];
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(M_PI / 2, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  const Eigen::Vector3d corner(2.0, 0, 0);
  const auto turned = [&](const Eigen::Vector3d& p) { return Eigen::Vector3d(corner + turn * (p - corner)); };
  around.axes = turn * around.axes, around.centre = turned(around.centre);
  for (auto& c : around.corners) c = turned(c);
  for (const int row : {0, 1}) {
    Bracket& bracket = facade.brackets[tower_bracket({1, 2}, 0, row, 2)];
    bracket.design = turned(bracket.design), bracket.axes = turn * bracket.axes;
  }
  facade.joints.clear();
  Random random(4, "corner");
  for (Bracket& bracket : facade.brackets) bracket.deviation = random.normal3(0.004);
  ASSERT_TRUE(faults_of(facade).empty());
  const Fit fit = plan_settings(facade, {1, 1, 1, 1e-9});
  EXPECT_TRUE(fit.relaxations.empty());
  for (const auto& twist : fit.twists) EXPECT_LT(twist.norm(), 1e-6);
}

TEST(Fit, WhatCannotBePlannedIsSaid) {
  Facade facade = random_facade({1, 3}, 2, 0.002);
  facade.panels[0].hooks.clear();
  facade.panels[1].hooks.resize(1);
  facade.brackets[tower_bracket({1, 3}, 0, 1, 3)].deviation.setConstant(kUnknown);
  const Fit fit = plan_settings(facade);
  std::string notes;
  for (const std::string& note : fit.notes) notes += note + "\n";
  EXPECT_NE(notes.find("panel F01-P01 hangs on no bracket"), std::string::npos) << notes;
  EXPECT_NE(notes.find("panel F01-P02 hangs on one bracket, F01-C02-R2: how it turns is open"), std::string::npos);
  EXPECT_NE(notes.find("panel F01-P03: bracket F01-C04-R2 was not measured"), std::string::npos);
  EXPECT_NE(notes.find("bracket F01-C01-R1 holds no panel"), std::string::npos);
  EXPECT_TRUE(std::isnan(fit.asked[tower_bracket({1, 3}, 0, 1, 3)].x()));
}

TEST(Fit, ARowThatHangsIsDataForTheNext) {
  Facade facade = random_facade({2, 2}, 9, 0.002, 0.0002, 0);
  for (Panel& panel : facade.panels) panel.installed = panel.floor == 1;
  for (Bracket& bracket : facade.brackets) {
    bracket.fixed = bracket.floor == 1;
    if (bracket.fixed) bracket.deviation = {0, 0, 0.004};  // all of the lower floor came out 4 mm high
  }
  const Fit fit = plan_settings(facade);
  for (std::size_t j = 0; j < 4; ++j) {
    if (facade.panels[j].installed) {
      EXPECT_NEAR(fit.twists[j].z(), 0.004, 1e-9);
    } else {
      EXPECT_GT(fit.twists[j].z(), 0.0005);  // shares the gap rather than halving it alone
    }
  }
  for (std::size_t b = 0; b < facade.brackets.size(); ++b)
    if (facade.brackets[b].fixed) {
      EXPECT_EQ(fit.settings[b].norm(), 0);
    }
}

TEST(Fit, FaultsAreNamedWithTheirPlace) {
  Facade facade = random_facade({2, 2}, 1);
  facade.panels[0].depends_on = {"F02-P01"};
  facade.brackets[3].type.low = facade.brackets[3].type.high + Eigen::Vector3d::Ones();
  facade.brackets[1].id = facade.brackets[0].id;
  facade.panels[1].limits.out = 0;
  facade.covariance.resize(3, 3);
  std::string words;
  for (const std::string& fault : faults_of(facade)) words += fault + "\n";
  EXPECT_NE(words.find("dependsOn goes in a circle: F01-P01 needs F02-P01 needs F01-P01"), std::string::npos) << words;
  EXPECT_NE(words.find("bracket F01-C01-R2 (type assumed): its range right is"), std::string::npos);
  EXPECT_NE(words.find("bracket F01-C01-R1 occurs twice"), std::string::npos);
  EXPECT_NE(words.find("panel F01-P02: the tolerance out is 0"), std::string::npos);
  EXPECT_NE(words.find("expected 36 x 36 for 12 brackets"), std::string::npos);
}

TEST(Fit, TheSameBitsEachTime) {
  const Facade facade = random_facade({3, 3}, 11, 0.012);
  const Fit a = plan_settings(facade), b = plan_settings(facade);
  for (std::size_t i = 0; i < a.settings.size(); ++i) EXPECT_EQ(a.settings[i], b.settings[i]);
}

}  // namespace test_fit
}  // namespace plumbline::loop
