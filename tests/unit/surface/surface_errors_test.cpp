// Measured panels and joints against the true ones: on whichever face they are described, with the joint covariance.
#include "building/judgement/surface_errors.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/QR>
#include <cmath>
#include <random>

#include "geometry/packed_symmetric.hpp"

namespace plumbline::judgement {
namespace {

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

}  // namespace
}  // namespace plumbline::judgement
