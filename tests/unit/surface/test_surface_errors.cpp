// Measured panels and joints against the true ones: on whichever face they are described, with the joint covariance.
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/QR>
#include <cmath>
#include <random>

#include "building/judgement/surface_errors.hpp"
#include "geometry/packed_symmetric.hpp"

namespace plumbline::judgement {
namespace test_surface_errors {

using Vector6 = Eigen::Matrix<double, 6, 1>;

Vector6 row_at(double x, double y) { return (Vector6() << 1, x, y, 1 - x * x, 1 - y * y, x * y).finished(); }

std::unique_ptr<PanelSurfaceFiguresT> panel(const std::string& id, const Eigen::Vector3d& origin, double width,
                                            double height, const Vector6& form) {
  auto made = std::make_unique<PanelSurfaceFiguresT>();
  made->face = std::make_unique<SurfaceFaceT>();
  made->face->id = id, made->face->origin = origin;
  made->face->right = {0.8, 0.6, 0}, made->face->up = {0, 0, 1}, made->face->out = {0.6, -0.8, 0};
  made->face->width = width, made->face->height = height;
  made->coefficients.assign(form.data(), form.data() + 6);
  made->coverage = 0.9;
  return made;
}

std::unique_ptr<JointFiguresT> joint(const std::string& first, const std::string& second, double moved,
                                     double (*width)(double), double sigma) {
  auto made = std::make_unique<JointFiguresT>();
  made->first = first, made->second = second, made->upright = true;
  made->along = {0, 0, 1}, made->origin = {0, 0, moved};
  for (int i = -10; i <= 10; ++i) {
    auto place = std::make_unique<JointPlaceT>();
    place->along = 0.02 * i, place->width = width(moved + place->along), place->width_sigma = sigma;
    place->step = 0.001, place->step_sigma = sigma;
    made->places.push_back(std::move(place));
  }
  return made;
}

const SurfaceErrorsOf& of(const SurfaceErrors& errors, const std::string& quantity) {
  for (const SurfaceErrorsOf& one : errors.of)
    if (one.quantity == quantity) return one;
  throw std::runtime_error("no errors of " + quantity);
}

/// The same surface in space, fitted by least squares to points of the truth on the other face.
TEST(SurfaceErrors, AFormOnAnotherFaceIsTheSameSurface) {
  const Vector6 form = (Vector6() << 2e-3, 1e-3, -7e-4, 1.5e-3, -9e-4, 4e-4).finished();
  const auto truth = panel("A", {3, 2, 1}, 1.2, 0.8, form);
  const Eigen::Vector3d moved = 0.03 * truth->face->right - 0.02 * truth->face->up + 0.004 * truth->face->out;
  const auto measured = panel("A", truth->face->origin + moved, 1.1, 0.9, Vector6::Zero());
  Eigen::MatrixXd rows(49, 6);
  Eigen::VectorXd heights(49);
  for (int i = 0; i < 49; ++i) {
    const double x = (i % 7 - 3) / 3.0, y = (i / 7 - 3) / 3.0;
    rows.row(i) = row_at(x, y);
    const double u = 0.55 * x + 0.03, v = 0.45 * y - 0.02;  // from the middle of the true face
    heights(i) = row_at(2 * u / 1.2, 2 * v / 0.8).dot(form) - 0.004;
  }
  const Vector6 fitted = rows.colPivHouseholderQr().solve(heights);
  EXPECT_LT((coefficients_on(*measured->face, *truth) - fitted).norm(), 1e-15);
  measured->face->right = {0.6, 0.8, 0};
  EXPECT_THROW(coefficients_on(*measured->face, *truth), std::runtime_error);
}

/// Errors drawn from a covariance of which half is common to all panels: squared errors over it average one.
TEST(SurfaceErrors, SquaredErrorsOverTheJointCovarianceAverageOne) {
  std::mt19937_64 engine(4);
  std::normal_distribution<double> normal(0, 1);
  const Vector6 form = (Vector6() << 1e-3, 5e-4, 0, 1e-3, 0, 0).finished();
  constexpr int trials = 300;
  std::map<std::string, double> nees;
  double beyond = 0;
  for (int trial = 0; trial < trials; ++trial) {
    SurfacesT truth, measured;
    measured.rank = 2;
    const double common[2] = {normal(engine), normal(engine)};
    for (int p = 0; p < 3; ++p) {
      const Eigen::Vector3d origin(0.8 * p, 0.6 * p, 0);
      truth.panels.push_back(panel("P" + std::to_string(p), origin, 0.9, 0.9, form));
      Vector6 found = form;
      std::vector<double> factor(12);
      Eigen::Matrix<double, 6, 6> random = Eigen::Matrix<double, 6, 6>::Zero();
      for (int i = 0; i < 6; ++i) {
        random(i, i) = std::pow(1e-5 * (i + 1), 2);
        found(i) += 1e-5 * (i + 1) * normal(engine);
        for (int k = 0; k < 2; ++k)
          factor[2 * i + k] = 4e-5 * (k == 0 ? 1 : p - i), found(i) += factor[2 * i + k] * common[k];
      }
      measured.panels.push_back(panel("P" + std::to_string(p), origin, 0.9, 0.9, found));
      measured.panels.back()->coefficients_random = pack_symmetric(random);
      measured.panels.back()->coefficients_factor = factor;
    }
    const SurfaceErrors errors = surface_errors(measured, truth);
    for (const char* quantity : {"offset", "tilt", "bow", "twist"})
      nees[quantity] += of(errors, quantity).nees / of(errors, quantity).freedom / trials;
    beyond += errors.beyond_3_sigma / trials;
  }
  for (const auto& [quantity, mean] : nees) {  // of 900 and 1800 degrees of freedom, within four standard deviations
    EXPECT_GT(mean, 0.81) << quantity;
    EXPECT_LT(mean, 1.19) << quantity;
  }
  EXPECT_LT(beyond, 0.01);
}

TEST(SurfaceErrors, SayWhatIsMissingAndWhatIsInvented) {
  const Vector6 flat = Vector6::Zero();
  SurfacesT truth, measured;
  for (const char* id : {"A", "B", "C"}) truth.panels.push_back(panel(id, {0, 0, 0}, 1, 1, flat));
  truth.panels.push_back(panel("D", {0, 0, 0}, 1, 1, flat)), truth.panels.back()->not_measured = "glass";
  for (const char* id : {"A", "B", "D"}) measured.panels.push_back(panel(id, {0, 0, 0}, 1, 1, flat));
  for (auto& one : measured.panels)
    one->coefficients_random =
        pack_symmetric(Eigen::Matrix<double, 6, 6>(1e-8 * Eigen::Matrix<double, 6, 6>::Identity()));
  measured.panels[1]->not_measured = "no point was measured on it";
  const SurfaceErrors errors = surface_errors(measured, truth);
  EXPECT_EQ(errors.wanted, 3);
  EXPECT_EQ(errors.measured, 1);
  EXPECT_EQ(errors.invented, 1) << "glass has no surface that anybody could know";
  EXPECT_NEAR(errors.coverage, 0.3, 1e-12) << "what is missing covers nothing";
  SurfacesT none;
  EXPECT_THROW(surface_errors(measured, none), std::runtime_error);
}

/// Errors drawn from what joints state: what all places share, what those of one joint do, and what each is off by
/// itself. A metric that took each place by itself would say 1 whatever they share.
TEST(SurfaceErrors, WidthsAndStepsCountWithWhatTheyHaveInCommon) {
  std::mt19937_64 engine(9);
  std::normal_distribution<double> normal(0, 1);
  const Vector6 flat = Vector6::Zero();
  constexpr int trials = 100;
  double width = 0, step = 0, beside = 0;
  SurfacesT truth, measured;
  for (int trial = 0; trial < trials; ++trial) {
    truth = SurfacesT(), measured = SurfacesT();
    measured.rank = 1, measured.joint_rank = 2;
    const double common[3] = {normal(engine), normal(engine), normal(engine)};
    std::vector<Vector6> forms;
    for (int p = 0; p < 4; ++p) {
      truth.panels.push_back(panel("P" + std::to_string(p), p * Eigen::Vector3d(0.8, 0.6, 0), 0.9, 0.9, flat));
      Vector6 form;
      std::vector<double> factor(6);
      for (int i = 0; i < 6; ++i)
        factor[i] = 1e-4 * (p + 1) * (i < 3), form(i) = 3e-5 * normal(engine) + factor[i] * common[2];
      measured.panels.push_back(panel("P" + std::to_string(p), p * Eigen::Vector3d(0.8, 0.6, 0), 0.9, 0.9, form));
      measured.panels.back()->coefficients_random =
          pack_symmetric(Eigen::Matrix<double, 6, 6>(9e-10 * Eigen::Matrix<double, 6, 6>::Identity()));
      measured.panels.back()->coefficients_factor = factor;
      forms.push_back(form);
    }
    truth.panels[3]->not_measured = "glass", measured.panels[3]->not_measured = "nothing on it to measure";
    for (int j = 0; j < 3; ++j) {
      const auto nominal = [](double) { return 0.1; };
      for (SurfacesT* of : {&truth, &measured}) {
        of->joints.push_back(joint("P" + std::to_string(j), "P" + std::to_string(j + 1), 0, nominal, 0));
        of->joints.back()->origin = (j + 0.5) * Eigen::Vector3d(0.8, 0.6, 0);
      }
      for (auto& place : truth.joints.back()->places) place->step = 0;
      const double edges[2] = {normal(engine), normal(engine)};
      for (auto& place : measured.joints.back()->places) {
        place->width_random = 2e-5, place->width_by_edge = {-3e-5, j == 2 ? 2e-4 : 3e-5};
        place->width_factor = {1e-4, 5e-5 * place->along};
        place->width += 2e-5 * normal(engine);
        for (int k = 0; k < 2; ++k)
          place->width += place->width_by_edge[k] * edges[k] + place->width_factor[k] * common[k];
        place->width_sigma = 2e-4;  // no matter: the parts count
        const double y = 2 * place->along / 0.9;
        place->step = row_at(-1, y).dot(forms[j + 1]) - row_at(1, y).dot(forms[j]), place->step_sigma = 1e-4;
      }
    }
    const SurfaceErrors errors = surface_errors(measured, truth);
    ASSERT_EQ(of(errors, "width").freedom, 42);
    ASSERT_EQ(of(errors, "step").freedom, 6) << "three of each of two joints";
    EXPECT_FALSE(of(errors, "width").one_by_one);
    width += of(errors, "width").nees / 42 / trials, step += of(errors, "step").nees / 6 / trials;
    beside += of(errors, "width_beside_unmeasured").nees / 21 / trials;
    EXPECT_EQ(errors.joints_wanted, 2);
    EXPECT_EQ(errors.joints_beside, 1);
  }
  EXPECT_NEAR(width, 1, 4 * std::sqrt(2.0 / (42 * trials)));
  EXPECT_NEAR(step, 1, 4 * std::sqrt(2.0 / (6 * trials)));
  EXPECT_NEAR(beside, 1, 4 * std::sqrt(2.0 / (21 * trials)));
  for (auto& place : measured.joints[0]->places) place->width_factor.clear();
  EXPECT_TRUE(of(surface_errors(measured, truth), "width").one_by_one) << "nobody says what they have in common";
  EXPECT_EQ(of(surface_errors(measured, truth), "width").freedom, 2);
}

/// Two facades that count their panels alike.
TEST(SurfaceErrors, PanelsOfOneNameAreNotCompared) {
  SurfacesT truth, measured;
  for (double x : {0.0, 5.0}) {
    truth.panels.push_back(panel("A", {x, 0, 0}, 1, 1, Vector6::Zero()));
    measured.panels.push_back(panel("A", {x, 0, 0}, 1, 1, Vector6::Zero()));
  }
  EXPECT_THROW(surface_errors(measured, truth), std::runtime_error);
}

/// Places of a joint are compared where they lie, also where its middle is described elsewhere or it runs the other
/// way.
TEST(SurfaceErrors, JointsArePlacesInSpace) {
  const Vector6 flat = Vector6::Zero();
  SurfacesT truth, measured;
  for (const char* id : {"A", "B", "C"}) truth.panels.push_back(panel(id, {0, 0, 0}, 1, 1, flat));
  const auto width = [](double along) { return 0.012 + 0.003 * along; };
  truth.joints.push_back(joint("A", "B", 0, width, 0)), truth.joints.push_back(joint("B", "C", 0, width, 0));
  measured.joints.push_back(joint("A", "B", 0.013, width, 1e-4));
  for (auto& place : measured.joints[0]->places) place->width += 2e-4;
  const SurfaceErrors errors = surface_errors(measured, truth);
  EXPECT_EQ(errors.joints_wanted, 2);
  EXPECT_EQ(errors.joints_measured, 1);
  EXPECT_NEAR(of(errors, "width").bias, 2e-4, 1e-12);
  EXPECT_NEAR(of(errors, "width").rms, 2e-4, 1e-12);
  EXPECT_NEAR(of(errors, "width").nees, 4, 1e-9) << "of one joint: twice its standard deviation off";
  EXPECT_NEAR(of(errors, "step").rms, 0, 1e-12);
  size_t places = 0;
  for (const SurfaceError& one : errors.all) places += one.quantity == "width";
  EXPECT_EQ(places, 20U) << "the last one lies beyond the true joint";
  measured.joints[0]->along *= -1;
  for (auto& place : measured.joints[0]->places) place->along *= -1;
  EXPECT_NEAR(of(surface_errors(measured, truth), "width").bias, 2e-4, 1e-12);
}

}  // namespace test_surface_errors
}  // namespace plumbline::judgement
