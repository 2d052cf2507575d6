// Global tests of a tag block: the variance of each group of observations against what was assumed of it.
#include <fmt/core.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/SparseCore>
#include <algorithm>
#include <cmath>

#include "geometry/linear_algebra/decompositions.hpp"
#include "geometry/statistics.hpp"
#include "photo/block/control_suspects.hpp"
#include "photo/block/control_words.hpp"
#include "photo/block/tag_block_model.hpp"
#include "photo/bundle/score.hpp"

namespace plumbline::block {
namespace {

/// Detectors know their standard deviations to a factor of some five: residuals larger than that are no noise.
constexpr double largest_image_factor = 25;
constexpr double test_level = 1e-4;

constexpr size_t most_images = 300;      ///< with a principal point each: the cube of their number is work
constexpr double least_redundancy = 30;  ///< left by the larger model, so that its variance is known

/// The score test of what `explained` has beyond the model, against the variance that would be left.
GroupTest model_test(GroupTest::Kind kind, const std::string& name, double explained, double freedom,
                     const TagBlockResult& result) {
  GroupTest test;
  test.group = name, test.kind = kind;
  test.factor =
      explained / freedom / ((result.weighted_sum_of_squares - explained) / (result.degrees_of_freedom - freedom));
  test.limit = chi_squared_quantile(1 - test_level, freedom) / freedom;
  test.passed = test.factor <= test.limit;
  return test;
}

/// Adds to the anchors' covariance what unknowns that nobody estimates move them by: K S Sᵀ Kᵀ, where `moved` is K S, K
/// the change of the adjustment for a unit of each and S Sᵀ their covariance (Tapley, Schutz & Born 2004, Statistical
/// Orbit Determination, 6.4: consider covariance). So it is the heights that grow where these feel it, or the scale,
/// and nothing else.
void widen(const TagBlockOptions& options, const TagModel& model, Eigen::MatrixXd moved, GroupTest& test,
           TagBlockResult& result) {
  if (result.anchor_covariance.size() == 0) return;
  const bundle::Layout layout(model.problem);
  const bundle::Datum datum = options.free_network
                                  ? bundle::inner_datum(model.problem, layout, bundle::free_motions(model.problem))
                                  : bundle::Datum();
  if (datum.count > 0) {  // I − G (CᵀG)⁻¹ Cᵀ, as cofactors are brought to it
    const Eigen::MatrixXd g =
        bundle::motions_of(model.problem, layout, model.state,
                           least_squares::centre_of(bundle::bodies_of(model.problem, model.state)))
            .leftCols(datum.count);
    const Eigen::MatrixXd c = g(datum.held, Eigen::all), seen = c.transpose() * moved(datum.held, Eigen::all);
    moved -= g * (c.transpose() * c).ldlt().solve(seen);
  }
  std::vector<int> positions;
  for (int j = 0; j < static_cast<int>(model.problem.plates.size()); ++j)
    for (int k = 0; k < 3; ++k) positions.push_back(layout.offset(layout.block({bundle::Kind::plate, j})) + k);
  const Eigen::MatrixXd of_anchors = moved(positions, Eigen::all);
  const Eigen::VectorXd before = result.anchor_covariance.diagonal();
  result.anchor_covariance.noalias() += of_anchors * of_anchors.transpose();
  test.points_factor = std::sqrt(result.anchor_covariance.diagonal().cwiseQuotient(before).maxCoeff());
  test.words +=
      test.points_factor < 1.05
          ? "; standard deviations of anchors grow by less than 5 % for it"
          : fmt::format("; standard deviations of anchors are up to {:.1f} times as large for it", test.points_factor);
}

/// What of the decrease is no noise, by the variance that the larger model leaves.
double beyond_noise(const bundle::ScoreTest::Explained& explained, const TagBlockResult& result) {
  const auto freedom = static_cast<double>(explained.step.size());
  const double left = (result.weighted_sum_of_squares - explained.decrease) / (result.degrees_of_freedom - freedom);
  return std::max(0.0, explained.decrease - freedom * left);
}

/// `camera`: its name, if there are several.
void add_distance_terms(const bundle::ScoreTest& score, int index, const std::string& camera,
                        const TagBlockOptions& options, const TagModel& model, TagBlockResult& result) {
  const auto explained = score.by(bundle::Kind::camera, index);
  if (!std::isfinite(explained.decrease)) return;  // one distance: nothing to tell
  const std::string of = camera.empty() ? "" : " of " + camera;
  GroupTest test =
      model_test(GroupTest::Kind::distances, "distortion at all distances" + of, explained.decrease, 2, result);
  if (!test.passed)
    test.words = "the lens' distortion" + of + " changes with the distance" +
                 fmt::format(" (test value {:.1f}, at most {:.1f})", test.factor, test.limit) +
                 ": add d1 and d2 to free_interior";
  if (!test.passed)
    widen(options, model,
          std::sqrt(beyond_noise(explained, result) / explained.decrease) *
              (score.influence(bundle::Kind::camera, index) * explained.step),
          test, result);
  result.models.push_back(test);
}

/// Principal points that scatter by σ raise the decrease by σ² times the information about them: so σ² is told from it.
void add_principal_points(const bundle::ScoreTest& score, const TagBlockOptions& options, const TagModel& model,
                          TagBlockResult& result) {
  const auto explained = score.by(bundle::Kind::shift);
  if (!std::isfinite(explained.decrease)) return;
  const auto freedom = static_cast<double>(explained.step.size());
  GroupTest test =
      model_test(GroupTest::Kind::principal_points, "one principal point", explained.decrease, freedom, result);
  test.shift = std::sqrt(explained.step.squaredNorm() / freedom);
  const std::string figure =
      fmt::format(" (test value {:.1f}, at most {:.1f}), rms {:.2g} px: set image_principal_point_sigma to that",
                  test.factor, test.limit, test.shift);
  if (!test.passed) {
    test.words = "the images have principal points of their own" + std::string(figure);
    const double sigma = std::sqrt(beyond_noise(explained, result) / explained.information);
    widen(options, model, sigma * score.influence(bundle::Kind::shift), test, result);
  }
  result.models.push_back(test);
}

}  // namespace

std::vector<least_squares::VarianceComponent> failing_but_images(
    const std::vector<least_squares::VarianceComponent>& groups) {
  std::vector<least_squares::VarianceComponent> failing;
  for (const auto& group : groups)
    if (group.name != "images" && group.redundancy > 0.1 &&
        group.factor > chi_squared_quantile(1 - test_level, group.redundancy) / group.redundancy)
      failing.push_back(group);
  return failing;
}

namespace {

/// W' A W. W is of independent points mostly: the three coordinates of one hang together, and a thousand points are no
/// products of full matrices.
Eigen::MatrixXd between(const Eigen::MatrixXd& w, const Eigen::MatrixXd& a) {
  constexpr double kSparse = 0.1;
  const Eigen::SparseMatrix<double> sparse = w.sparseView();
  if (static_cast<double>(sparse.nonZeros()) > kSparse * static_cast<double>(w.size())) return w.transpose() * a * w;
  return sparse.transpose() * (a * sparse);
}

}  // namespace

ControlTests test_control(const TagModel& model, const TagStart& start, const bundle::Adjusted& adjusted,
                          const std::vector<int>& kept) {
  ControlTests result;
  if (model.control_term < 0) return result;
  const auto term = static_cast<size_t>(model.control_term);
  const auto& known = model.problem.known[term];
  const Eigen::MatrixXd whitening = known.whitening / model.problem.groups[known.group].sigma_factor;
  const auto quality = adjusted.cofactors->known(adjusted.state, term);
  const auto rows = whitening.rows();
  const auto plate = [&](size_t k) { return start.plates[model.control_plates[k]]; };
  std::vector<size_t> unknown;
  for (size_t k = 0; k < model.control_plates.size(); ++k)
    if (std::find(kept.begin(), kept.end(), plate(k)) != kept.end()) unknown.push_back(k);
  const ControlSuspects suspects = suspects_of(between(whitening, quality.residual_cofactor),
                                               between(whitening, Eigen::MatrixXd::Identity(rows, rows)),
                                               whitening.transpose() * quality.rows.residual, 1, std::move(unknown));
  const auto of = [&](const SuspectedControl& found) {
    return RejectedControl{plate(found.point), found.off,   Eigen::Vector3d::Zero(),
                           found.test,         found.limit, found.freedom};
  };
  for (const RivalControl& group : suspects.rivals) {
    result.rivals.push_back({of(group.worst), {}});
    for (const size_t k : group.others) result.rivals.back().others.push_back(plate(k));
  }
  for (const size_t k : suspects.hidden) result.hidden.push_back(plate(k));
  if (suspects.worst) result.worst = of(*suspects.worst);
  return result;
}

WithheldControl withheld_control(const TagModel& model, const TagStart& start, const bundle::Adjusted& adjusted,
                                 const std::vector<int>& plates) {
  constexpr double determined = 1e-6;  // part of an error that shows in the residuals; rounding leaves 1e-12
  WithheldControl result;
  std::vector<int> columns;
  for (size_t k = 0; k < model.control_plates.size(); ++k) {
    const int plate = start.plates[model.control_plates[k]];
    if (std::find(plates.begin(), plates.end(), plate) == plates.end()) continue;
    result.plates.push_back(plate);
    for (int c = 0; c < 3; ++c) columns.push_back(3 * static_cast<int>(k) + c);
  }
  if (result.plates.empty()) {
    result.undetermined = "none of its points is control that the images show";
    return result;
  }
  const size_t term = static_cast<size_t>(model.control_term);
  const auto quality = adjusted.cofactors->known(adjusted.state, term);
  const Eigen::MatrixXd b = model.problem.known[term].whitening(Eigen::all, columns);
  const Eigen::MatrixXd seen = b.transpose() * quality.residual_cofactor * b, weight = b.transpose() * b;
  const linear_algebra::GeneralizedSymmetricEigen shown(seen, weight, Eigen::EigenvaluesOnly);
  if (!(shown.eigenvalues()(0) > determined)) {
    result.undetermined = "without its points the control does not hold the block";
    return result;
  }
  const Eigen::LLT<Eigen::MatrixXd> factor(seen);
  result.off = -factor.solve(b.transpose() * quality.rows.residual);
  result.covariance = factor.solve(Eigen::MatrixXd::Identity(seen.rows(), seen.cols()));
  return result;
}

void test_models(const TagBlockOptions& options, const TagModel& model, const bundle::Adjusted& adjusted,
                 TagBlockResult& result) {
  constexpr int d1 = BrownCamera::parameter_count;
  constexpr double anywhere = 100;  // [px] so far the prior says next to nothing, and cx, cy keep the mean
  if (!options.self_calibration) return;
  bundle::Problem larger = model.problem;
  bundle::State state = model.state;
  const size_t images = larger.images.size();
  std::vector<int> distances;
  for (size_t c = 0; c < larger.cameras.size() && result.degrees_of_freedom - 2 >= least_redundancy; ++c) {
    auto& free = larger.cameras[c].free;
    if (larger.cameras[c].lens != bundle::Lens::brown) continue;
    if (free[d1] || free[d1 + 1]) continue;
    free[d1] = free[d1 + 1] = true;
    distances.push_back(static_cast<int>(c));
  }
  const bool points = !(options.image_principal_point_sigma > 0) && images <= most_images &&
                      result.degrees_of_freedom - 2.0 * static_cast<double>(images) >= least_redundancy;
  if (distances.empty() && !points) return;
  if (points) free_principal_points(anywhere, larger, state);
  const bundle::ScoreTest score(model.problem, larger, state, *adjusted.elimination);
  for (int c : distances)
    add_distance_terms(score, c, larger.cameras.size() > 1 ? larger.cameras[c].name : "", options, model, result);
  if (points) add_principal_points(score, options, model, result);
}

namespace {

/// Baarda's rule: what decides is the point that contradicts most, at its level; the sum over all of them may hide it.
GroupTest test_of_points(const std::vector<ControlDoubt>& doubts) {
  constexpr size_t told = 5;
  GroupTest test;
  test.group = "control points", test.passed = false;
  const ControlDoubt& worst = *std::max_element(
      doubts.begin(), doubts.end(), [](const auto& a, const auto& b) { return a.test - a.limit < b.test - b.limit; });
  test.factor = worst.test / worst.freedom, test.limit = worst.limit / worst.freedom;
  for (size_t k = 0; k < std::min(doubts.size(), told); ++k) test.words += (k > 0 ? "; " : "") + doubts[k].words;
  if (doubts.size() > told) test.words += "; and so are " + std::to_string(doubts.size() - told) + " more";
  return test;
}

}  // namespace

void test_groups(const TagBlock& block, TagBlockResult& result) {
  const std::string interior = "interior prior";
  for (const auto& group : result.groups) {
    if (!(group.redundancy > 0.1)) continue;
    GroupTest test;
    test.group = group.name;
    test.factor = group.factor;
    std::string figure;
    if (group.name == "images") {
      test.factor *= result.image_variance_factor;
      test.limit = largest_image_factor;
      figure =
          fmt::format("the tags fit {:.1f} times worse than the detector says of its corners", std::sqrt(test.factor));
      test.words = std::string(figure) + ": camera model or calibration, tag size or plate table are wrong";
    } else {
      test.limit = chi_squared_quantile(1 - test_level, group.redundancy) / group.redundancy;
      figure = fmt::format(" (variance factor {:.3g}, expected 1, at most {:.2f})", test.factor, test.limit);
      test.words =
          (group.name == "control"
               ? "images and survey contradict each other far beyond the survey's standard deviations"
           : group.name.starts_with(interior)
               ? "the images contradict the " +
                     (group.name == interior ? "camera's calibration"
                                             : "calibration of camera " + group.name.substr(interior.size() + 4)) +
                     " far beyond its sigmas: wrong calibration, lens or focus"
           : group.name == "tag scale prior" ? "the tags are not of the size given, or not all of one where none is: "
                                               "printed at another scale, or measured wrong"
                                             : "the images contradict the " + group.name) +
          std::string(figure);
    }
    test.passed = test.factor <= test.limit;
    if (group.name == "control" && !test.passed) test.words += control_in_words(block, result);
    if (test.passed) test.words.clear();
    result.tests.push_back(test);
  }
  if (!result.control_doubts.empty()) result.tests.push_back(test_of_points(result.control_doubts));
}

}  // namespace plumbline::block
