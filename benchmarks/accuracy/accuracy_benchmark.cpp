// How accurate are the alternatives? Scenarios of Table 1 x alternatives x simulated sites, through the nodes that the
// pipelines use, from tags in images and surveyed anchors to heights of check anchors against truth. All alternatives
// see the same sites, so that they are also compared site by site.
//
//   accuracy_benchmark [SITES [FIRST_SEED [parameter=value ...]]]          parameters of simulate.observations
//   accuracy_benchmark 20 1 height_walk=0.001 network=parallel
#include <Eigen/Cholesky>
#include <cmath>
#include <cstdio>
#include <functional>
#include <map>

#include "artifacts/camera.hpp"
#include "artifacts/image_tags.hpp"
#include "artifacts/plates.hpp"
#include "artifacts/points.hpp"
#include "artifacts/poses.hpp"
#include "node_harness.hpp"

namespace {

using namespace plumbline;
using test::NodeHarness;
using Parameters = std::map<std::string, std::string>;

struct Site {
  std::vector<ImageTagsT> images;
  CameraT camera;
  PlatesT plates, local_plates;
  PointsT survey, design, local_points, truth;
};

Site make_site(int floors, uint64_t seed, const Parameters& parameters) {
  NodeHarness node("simulate.observations");
  node.seed(seed);
  node.set("floors", std::to_string(floors));
  for (const auto& [name, value] : parameters) node.set(name, value);
  node.run();
  Site site;
  for (size_t i = 0; i < node.output_count("observations"); ++i)
    site.images.push_back(node.output<ImageTags>("observations", i));
  site.camera = node.output<Camera>("camera");
  site.plates = node.output<Plates>("plates");
  site.survey = node.output<Points>("points");
  site.design = node.output<Points>("design");
  site.truth = node.output<Points>("truth");
  NodeHarness local("frame.block");
  local.input<Points>("points", site.design);
  local.input<Plates>("plates", site.plates);
  local.run();
  site.local_points = local.output<Points>("points");
  site.local_plates = local.output<Plates>("plates");
  return site;
}

void show_images(NodeHarness& node, const Site& site) {
  for (const auto& image : site.images) node.input<ImageTags>("observations", image);
  node.input<Camera>("camera", site.camera);
}

PosesT pose(const std::string& kind, const Site& site, const PlatesT& plates, const PointsT& points) {
  NodeHarness node(kind);
  show_images(node, site);
  node.input<Plates>("plates", plates);
  node.input<Points>("points", points);
  node.run();
  return node.output<Poses>("poses");
}

/// Equation (5).
PointsT constrained(const std::string& pose_kind, const Site& site, bool correlated) {
  PointsT control = site.survey;
  if (!correlated) control.covariance.clear();
  NodeHarness node("adjust.ceres");
  show_images(node, site);
  node.input<Plates>("plates", site.plates);
  node.input<Poses>("poses", pose(pose_kind, site, site.plates, site.design));
  node.input<Points>("control", control);
  node.run();
  return node.output<Points>("points");
}

/// Equation (4); registered by (6) afterwards.
PointsT free_block(const Site& site) {
  NodeHarness node("adjust.ceres");
  show_images(node, site);
  node.input<Plates>("plates", site.local_plates);
  node.input<Poses>("poses", pose("pose.opengv", site, site.local_plates, site.local_points));
  node.run();
  return node.output<Points>("points");
}

PointsT registered(const PointsT& block, const Site& site, const std::string& weights, const std::string& scale) {
  NodeHarness node("register.rigid");
  node.set("weights", weights);
  node.set("scale", scale);
  node.input<Points>("source", block);
  node.input<Points>("target", site.survey);
  node.run();
  return node.output<Points>("points");
}

/// Heights of the check anchors of one site against truth.
struct Errors {
  double mean_square = 0, predicted = 0;  ///< means over the anchors [m²]
  double nees = 0;                        ///< eᵀ Σ⁻¹ e
  int count = 0;
};

Errors errors_of(const PointsT& model, const PointsT& truth) {
  std::map<std::string, double> built;
  for (const auto& point : truth.points) built[point->id] = point->position.z();
  std::vector<size_t> rows;
  std::vector<double> differences;
  for (size_t i = 0; i < model.points.size(); ++i) {
    if (model.points[i]->role != "check") continue;
    rows.push_back(3 * i + 2);
    differences.push_back(model.points[i]->position.z() - built.at(model.points[i]->id));
  }
  const auto n = static_cast<Eigen::Index>(rows.size());
  const Eigen::Map<const Eigen::VectorXd> e(differences.data(), n);
  Eigen::MatrixXd covariance(n, n);
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = 0; j <= i; ++j) {
      const size_t r = rows[i], c = rows[j];
      covariance(i, j) = covariance(j, i) = model.covariance.at(r * (r + 1) / 2 + c);
    }
  return {e.squaredNorm() / static_cast<double>(n), covariance.trace() / static_cast<double>(n),
          e.dot(covariance.ldlt().solve(e)), static_cast<int>(n)};
}

/// Mean over sites and half the width of its 95 % interval; sites are independent, anchors of one site are not.
struct Mean {
  double value = 0, half_width = 0;
};
Mean mean_of(const std::vector<double>& values) {
  const double n = static_cast<double>(values.size());
  double sum = 0, squares = 0;
  for (double v : values) sum += v;
  for (double v : values) squares += (v - sum / n) * (v - sum / n);
  return {sum / n, 1.96 * std::sqrt(squares / (n - 1) / n)};
}

void print_row(const std::string& scenario, const std::string& name, const std::vector<Errors>& errors,
               const std::vector<Errors>& reference) {
  std::vector<double> squares, predicted, differences;
  double nees = 0;
  int count = 0;
  for (size_t i = 0; i < errors.size(); ++i) {
    squares.push_back(1e6 * errors[i].mean_square);
    predicted.push_back(1e6 * errors[i].predicted);
    differences.push_back(squares.back() - 1e6 * reference[i].mean_square);
    nees += errors[i].nees;
    count += errors[i].count;
  }
  const Mean square = mean_of(squares), difference = mean_of(differences);
  const double expected = mean_of(predicted).value;
  std::printf("| %s | %s | %.3f (%.3f - %.3f) | %.3f | %.3f | %.2f | %+.4f +- %.4f |\n", scenario.c_str(), name.c_str(),
              std::sqrt(square.value), std::sqrt(std::max(0.0, square.value - square.half_width)),
              std::sqrt(square.value + square.half_width), std::sqrt(expected), std::sqrt(square.value / expected),
              nees / count, difference.value, difference.half_width);
  std::fflush(stdout);
}

void run_scenario(const std::string& scenario, int floors, int sites, uint64_t first_seed,
                  const Parameters& parameters) {
  const std::vector<std::string> names = {"(5), poses by OpenGV",
                                          "(5), poses by OpenCV",
                                          "(5), control taken as uncorrelated",
                                          "(4), then (6) with covariances",
                                          "(4), then (6) with equal weights",
                                          "(4), then (6) with covariances and scale"};
  std::vector<std::vector<Errors>> errors(names.size());
  for (int k = 0; k < sites; ++k) {
    const Site site = make_site(floors, first_seed + static_cast<uint64_t>(k), parameters);
    const PointsT block = free_block(site);
    const std::vector<PointsT> models = {
        constrained("pose.opengv", site, true),    constrained("pose.opencv", site, true),
        constrained("pose.opengv", site, false),   registered(block, site, "covariance", "fixed"),
        registered(block, site, "equal", "fixed"), registered(block, site, "covariance", "estimated")};
    for (size_t a = 0; a < models.size(); ++a) errors[a].push_back(errors_of(models[a], site.truth));
  }
  for (size_t a = 0; a < names.size(); ++a) print_row(scenario, names[a], errors[a], errors[0]);
}

}  // namespace

int main(int count, char** arguments) {
  const int sites = count > 1 ? std::atoi(arguments[1]) : 20;
  const uint64_t first_seed = count > 2 ? std::strtoull(arguments[2], nullptr, 10) : 1;
  Parameters parameters;
  for (int i = 3; i < count; ++i) {
    const std::string text = arguments[i];
    const size_t equals = text.find('=');
    if (equals != std::string::npos) parameters[text.substr(0, equals)] = text.substr(equals + 1);
  }
  if (sites < 2 || first_seed < 1 || static_cast<int>(parameters.size()) != std::max(0, count - 3)) {
    std::fprintf(stderr, "usage: accuracy_benchmark [SITES >= 2 [FIRST_SEED >= 1 [parameter=value ...]]]\n");
    return 1;
  }
  try {
    std::printf(
        "| scenario | alternative | RMSE_z, 95 %% interval [mm] | predicted | ratio | NEES / coordinate | MSE_z minus "
        "the first row's [mm2] |\n|---|---|---|---|---|---|---|\n");
    run_scenario("single floor", 1, sites, first_seed, parameters);
    run_scenario("cross floor", 2, sites, first_seed, parameters);
    run_scenario("full height, 5 floors", 5, sites, first_seed, parameters);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
  return 0;
}
