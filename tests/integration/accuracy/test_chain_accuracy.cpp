// From tags in images and surveyed anchors to the model, by the nodes a pipeline would use, on simulated sites whose
// truth is known: the errors at anchors that were withheld must be those that the adjustment's own covariance predicts.
#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "artifacts/camera.hpp"
#include "artifacts/image_tags.hpp"
#include "artifacts/plates.hpp"
#include "artifacts/points.hpp"
#include "artifacts/poses.hpp"
#include "geometry/statistics.hpp"
#include "node_harness.hpp"

namespace plumbline::test {
namespace test_chain_accuracy {

struct Errors {
  double squares = 0;    ///< of the heights of check anchors against truth [m²]
  double predicted = 0;  ///< sum of their variances [m²]
  double nees = 0;       ///< of the heights of all check anchors of a site, normalised by their joint covariance
  int count = 0;
};

/// Covariance of the chosen coordinates out of a lower triangle.
Eigen::MatrixXd part_of(const std::vector<double>& triangle, const std::vector<std::size_t>& chosen) {
  const auto n = static_cast<Eigen::Index>(chosen.size());
  Eigen::MatrixXd part(n, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    for (Eigen::Index j = 0; j < n; ++j) {
      const std::size_t a = std::max(chosen[i], chosen[j]);
      const std::size_t b = std::min(chosen[i], chosen[j]);
      part(i, j) = triangle[a * (a + 1) / 2 + b];
    }
  }
  return part;
}

Errors errors_of(const PointsT& model, const PointsT& truth) {
  std::map<std::string, Eigen::Vector3d> built;
  for (const auto& point : truth.points) built[point->id] = point->position;
  Errors e;
  std::vector<std::size_t> heights;
  std::vector<double> differences;
  for (std::size_t i = 0; i < model.points.size(); ++i) {
    if (model.points[i]->role != "check") continue;
    heights.push_back(3 * i + 2);
    differences.push_back(model.points[i]->position.z() - built.at(model.points[i]->id).z());
  }
  const Eigen::Map<const Eigen::VectorXd> d(differences.data(), static_cast<Eigen::Index>(differences.size()));
  const Eigen::MatrixXd covariance = part_of(model.covariance, heights);
  e.squares = d.squaredNorm();
  e.predicted = covariance.trace();
  e.nees = d.dot(covariance.ldlt().solve(d));
  e.count = static_cast<int>(d.size());
  return e;
}

Errors run_site(uint64_t seed, int floors) {
  NodeHarness site("simulate.observations");
  site.seed(seed);
  site.set("floors", std::to_string(floors));
  site.run();
  NodeHarness poses("pose.opengv"), block("adjust.ceres");
  for (NodeHarness* node : {&poses, &block}) {
    for (std::size_t i = 0; i < site.output_count("observations"); ++i) {
      node->input<ImageTags>("observations", site.output<ImageTags>("observations", i));
    }
    node->input<Camera>("camera", site.output<Camera>("camera"));
    node->input<Plates>("plates", site.output<Plates>("plates"));
  }
  poses.input<Points>("points", site.output<Points>("design"));
  poses.run();
  block.input<Poses>("poses", poses.output<Poses>("poses"));
  block.input<Points>("control", site.output<Points>("points"));
  block.run();
  return errors_of(block.output<Points>("points"), site.output<Points>("truth"));
}

TEST(ChainAccuracy, WithheldAnchorsErrAsTheCovariancePredictsOverTwentySites) {
  Errors all;
  for (uint64_t seed = 1; seed <= 20; ++seed) {
    const Errors e = run_site(seed, 2);
    ASSERT_EQ(e.count, 6);
    all.squares += e.squares, all.predicted += e.predicted, all.nees += e.nees, all.count += e.count;
  }
  RecordProperty("ratio_to_predicted", std::to_string(std::sqrt(all.squares / all.predicted)));
  RecordProperty("nees_per_coordinate", std::to_string(all.nees / all.count));
  // 0.1 px and a 1 mm survey with control on every floor.
  EXPECT_LT(std::sqrt(all.squares / all.predicted), 1.15);
  EXPECT_GT(all.nees, chi_squared_quantile(0.001, all.count));
  EXPECT_LT(all.nees, chi_squared_quantile(0.999, all.count));
}

}  // namespace test_chain_accuracy
}  // namespace plumbline::test
