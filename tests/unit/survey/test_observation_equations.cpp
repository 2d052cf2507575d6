// Partials against numeric differences, and values against geometry done by hand.
#include <cmath>

#include "survey/model/observation_equations.hpp"
#include "test_support.hpp"

namespace plumbline::survey {
namespace test_observation_equations {

/// Largest deviation of the analytic partials from central differences.
double worst_partial(const least_squares::ResidualBlock& block, std::vector<std::vector<double>> values, int rows) {
  const auto pointers = [&] {
    std::vector<const double*> p;
    for (const auto& v : values) p.push_back(v.data());
    return p;
  };
  std::vector<std::vector<double>> storage;
  std::vector<double*> jacobians;
  for (const auto& v : values) storage.emplace_back(v.size() * static_cast<size_t>(rows), 0.0);
  for (auto& s : storage) jacobians.push_back(s.data());
  const std::vector<double*> none(values.size(), nullptr);
  Eigen::VectorXd r(rows), plus(rows), minus(rows);
  EXPECT_TRUE(block.evaluate(pointers().data(), r.data(), jacobians.data()));
  double worst = 0;
  for (size_t p = 0; p < values.size(); ++p)
    for (size_t c = 0; c < values[p].size(); ++c) {
      const double kept = values[p][c], step = 1e-4;
      values[p][c] = kept + step;
      EXPECT_TRUE(block.evaluate(pointers().data(), plus.data(), none.data()));
      values[p][c] = kept - step;
      EXPECT_TRUE(block.evaluate(pointers().data(), minus.data(), none.data()));
      values[p][c] = kept;
      for (int row = 0; row < rows; ++row) {
        const double numeric = (plus[row] - minus[row]) / (2 * step);
        worst = std::max(worst, std::abs(numeric - storage[p][static_cast<size_t>(row) * values[p].size() + c]));
      }
    }
  return worst;
}

TEST(ObservationEquations, PartialsOfAllKindsWithAllUnknowns) {
  ObservationBlock block;
  // 0 from, 1 to, 2 second target, 3 orientation, 4 tilt, 5 height correction, 6 scale, 7 constant, 8 index, 9
  // refraction
  for (ObservationKind kind : {ObservationKind::direction, ObservationKind::zenith_angle,
                               ObservationKind::slope_distance, ObservationKind::horizontal_distance,
                               ObservationKind::height_difference, ObservationKind::angle, ObservationKind::azimuth}) {
    Equation eq;
    eq.kind = kind;
    eq.value = 0.3;
    eq.instrument_height = 1.6;
    eq.target_height = 0.1;
    eq.second_target_height = 0.2;
    eq.from = 0;
    eq.to = 1;
    eq.second_to = kind == ObservationKind::angle ? 2 : -1;
    eq.orientation = kind == ObservationKind::direction ? 3 : -1;
    eq.tilt = 4;
    eq.instrument_height_correction = 5;
    eq.scale = 6;
    eq.additive_constant = 7;
    eq.index = 8;
    eq.refraction = 9;
    eq.curvature = true;
    block.equations.push_back(eq);
  }
  const double worst = worst_partial(
      block, {{10, 20, 5}, {22, 31, 12}, {-4, 45, 9}, {0.4}, {1e-3, -2e-3}, {0.01}, {1e-4}, {0.002}, {1e-5}, {0.2}}, 7);
  EXPECT_LT(worst, 1e-6);
}

TEST(ObservationEquations, PartialsOfLocalCoordinates) {
  LocalCoordinateBlock block;
  block.observed = {1, 2, 3};
  block.instrument_height = 1.5;
  block.target_height = 0.2;
  block.parameters = {0, 1, 2, 3};
  EXPECT_LT(worst_partial(block, {{10, 20, 5}, {22, 31, 12}, {0.4}, {0.01}}, 3), 1e-6);
}

TEST(ObservationEquations, DirectionIsClockwiseFromNorthMinusOrientation) {
  ObservationBlock block;
  Equation eq;
  eq.from = 0;
  eq.to = 1;
  eq.orientation = 2;
  block.equations.push_back(eq);
  const double from[] = {0, 0, 0}, east[] = {10, 0, 0}, orientation[] = {0.25};
  const double* values[] = {from, east, orientation};
  double* jacobians[] = {nullptr, nullptr, nullptr};
  double residual = 0;
  ASSERT_TRUE(block.evaluate(values, &residual, jacobians));
  EXPECT_NEAR(residual, std::acos(-1.0) / 2 - 0.25, 1e-15);
}

TEST(ObservationEquations, CurvatureAndRefractionLowerFarTargets) {
  ObservationBlock block;
  Equation eq;
  eq.kind = ObservationKind::zenith_angle;
  eq.from = 0;
  eq.to = 1;
  eq.curvature = true;
  eq.value = std::acos(-1.0) / 2;
  block.equations.push_back(eq);
  const double from[] = {0, 0, 0}, to[] = {0, 100, 0};
  const double* values[] = {from, to};
  double* jacobians[] = {nullptr, nullptr};
  double residual = 0;
  ASSERT_TRUE(block.evaluate(values, &residual, jacobians));
  EXPECT_NEAR(residual * 100, 0.68e-3, 0.01e-3);  // 0.68 mm at 100 m with k = 0.13
}

/// At 20 km a metre farther is 3 mm deeper: the partial by the distance has the curvature's part in it.
TEST(ObservationEquations, PartialsOfFarSightsKnowTheCurvature) {
  ObservationBlock block;
  Equation eq;
  eq.kind = ObservationKind::zenith_angle;
  eq.from = 0;
  eq.to = 1;
  eq.curvature = true;
  block.equations.push_back(eq);
  const double from[] = {0, 0, 0};
  const auto residual_at = [&](double north, double* partials) {
    const double to[] = {0, north, 0};
    const double* values[] = {from, to};
    double* jacobians[] = {nullptr, partials};
    double residual = 0;
    EXPECT_TRUE(block.evaluate(values, &residual, jacobians));
    return residual;
  };
  double partials[3] = {0, 0, 0};
  residual_at(20000, partials);
  const double numeric = (residual_at(20010, nullptr) - residual_at(19990, nullptr)) / 20;
  EXPECT_NEAR(numeric / 6.8e-8, 1, 0.01) << "(1 - k) / 2R";
  EXPECT_NEAR(partials[1] / numeric, 1, 1e-4);
}

TEST(ObservationEquations, ResidualsWrapAtTheCircle) {
  EXPECT_NEAR(wrap_angle(2 * std::acos(-1.0) + 0.1), 0.1, 1e-15);
  EXPECT_NEAR(wrap_angle(std::acos(-1.0) + 0.1), 0.1 - std::acos(-1.0), 1e-15);
  EXPECT_GT(wrap_angle(-std::acos(-1.0)), 0);
}

TEST(ObservationEquations, CoincidingPointsAreUndefined) {
  ObservationBlock block;
  Equation eq;
  eq.kind = ObservationKind::slope_distance;
  eq.from = 0;
  eq.to = 1;
  block.equations.push_back(eq);
  const double p[] = {1, 2, 3};
  const double* values[] = {p, p};
  double* jacobians[] = {nullptr, nullptr};
  double residual = 0;
  EXPECT_FALSE(block.evaluate(values, &residual, jacobians));
}

}  // namespace test_observation_equations
}  // namespace plumbline::survey
