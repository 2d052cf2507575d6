#include "photo/block/tag_block_solve.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "base/text/words.hpp"
#include "geometry/median.hpp"
#include "plumbline/failure.hpp"

namespace plumbline::block {
namespace {

bool scale_is_unknown(const TagModel& model) {
  return std::any_of(model.problem.batches.begin(), model.problem.batches.end(),
                     [](const auto& batch) { return batch.scale_free; });
}

/// What control and priors say about the similarity motions of the block; images say nothing about them.
least_squares::DatumAnalysis analyse_control(const TagBlockOptions& options, const TagModel& model) {
  // Where the survey has them: approximate values off by a centimetre would turn a straight line of control into a
  // plane.
  bundle::State surveyed = model.state;
  for (size_t k = 0; k < model.control_plates.size(); ++k)
    surveyed.plates[model.control_plates[k]].position =
        model.problem.known[model.control_term].target.segment<3>(3 * static_cast<Eigen::Index>(k));
  const bundle::Layout layout(model.problem);
  std::vector<least_squares::NamedPoint> anchors = bundle::bodies_of(model.problem, surveyed), fixed;
  const Eigen::MatrixXd motions =
      bundle::motions_of(model.problem, layout, surveyed, least_squares::centre_of(anchors));
  Eigen::MatrixXd information = Eigen::MatrixXd::Zero(least_squares::motion_count, least_squares::motion_count);
  for (const auto& term : model.problem.known) {
    const bundle::KnownRows rows = bundle::evaluate(model.problem, layout, surveyed, term);
    const Eigen::MatrixXd moved = rows.jacobian * motions(rows.columns, Eigen::all);
    information += moved.transpose() * moved;
  }
  for (auto& anchor : anchors) anchor.position += model.origin;
  for (int j : model.control_plates) fixed.push_back(anchors[j]);
  return least_squares::analyse_datum(information, anchors, fixed, scale_is_unknown(model), options.weak_ratio);
}

/// Root mean square of the 8 whitened residuals of each tag.
std::vector<double> tag_misfits(const TagModel& model) {
  const bundle::Layout layout(model.problem);
  std::vector<double> rms;
  bundle::Rows rows;
  for (const auto& term : model.problem.image_tags)
    rms.push_back(bundle::evaluate(model.problem, layout, model.state, term, false, rows)
                      ? rows.values().norm() / std::sqrt(8.0)
                      : std::numeric_limits<double>::infinity());
  return rms;
}

bundle::Loss loss_of(RobustLoss loss, double scale) {
  using Loss = bundle::Loss::Kind;
  return {loss == RobustLoss::huber    ? Loss::huber
          : loss == RobustLoss::cauchy ? Loss::cauchy
          : loss == RobustLoss::tukey  ? Loss::tukey
                                       : Loss::none,
          scale};
}

Solved solve(const TagBlockOptions& options, const bundle::Layout& layout, TagModel& model) {
  constexpr int max_variance_steps = 5;
  const bool by_lambda = options.weighting == TagBlockOptions::Weighting::lambda;
  bundle::AdjustOptions how;
  how.announce = options.announce;
  how.minimise.max_iterations = options.max_iterations;
  how.minimise.threads = options.threads;
  how.minimiser = options.minimiser;
  if (options.free_network) how.datum = bundle::inner_datum(model.problem, layout, bundle::free_motions(model.problem));
  how.nearby = 1e-4;
  how.with_cofactors = false;                                                     // of the last step only
  how.start_is_near = options.refine_robust && options.loss != RobustLoss::none;  // find_blunders() has been there
  Solved solved;
  const bundle::State start = model.state;
  for (int step = 0; step < max_variance_steps; ++step) {
    solved.adjusted = bundle::adjust(model.problem, layout, step == 0 ? start : model.state, how);
    model.state = solved.adjusted.state;
    how.start_is_near = how.is_determined = true;
    if (!options.estimate_image_variance || by_lambda) break;
    const double factor = bundle::observed_variance(model.problem, layout, solved.adjusted, how.datum);
    if (!(factor > 0) || std::abs(factor - 1) < 0.01) break;
    // No detector is 20 times better or 1000 times worse than it says; without this, a block without noise would run
    // away.
    double& sigma = model.problem.groups[group_images].sigma_factor;
    const double next = std::clamp(sigma * std::sqrt(factor), 0.05, 1000.0);
    if (next == sigma || step + 1 == max_variance_steps) break;
    const double change = std::exchange(sigma, next) / next;
    if (std::abs(change - 1) < 0.1) {
      bundle::follow(model.problem, layout, how, solved.adjusted);
      model.state = solved.adjusted.state;
    }
  }
  solved.adjusted.cofactors = std::make_unique<bundle::Cofactors>(model.problem, layout, solved.adjusted.state,
                                                                  *solved.adjusted.elimination, how.datum);
  solved.reliability = bundle::reliability_of(model.problem, solved.adjusted);
  return solved;
}

}  // namespace

void require_datum(const TagBlockOptions& options, const TagModel& model, TagBlockResult& result) {
  if (options.free_network) return;
  const least_squares::DatumAnalysis datum = analyse_control(options, model);
  if (!datum.undetermined.empty())
    throw std::runtime_error(
        "the control leaves " + text::enumerate(datum.undetermined) + " of the block undetermined: " +
        std::to_string(model.control_plates.size()) + " of " + std::to_string(model.problem.plates.size()) +
        " anchors in the images are control; add control that is not on one line, or adjust a free network");
  result.weak_datum = datum.weak;
  result.weakest_datum_sigma = datum.weakest_sigma;
}

std::vector<int> find_blunders(const TagBlockOptions& options, const TagStart& start, TagModel& model) {
  std::vector<int> blunders;
  if (options.loss == RobustLoss::none) return blunders;
  double unit = 1;
  for (int pass = 0; pass < 2; ++pass) {
    bundle::MinimiseOptions how;
    how.max_iterations = options.max_iterations;
    how.threads = options.threads;
    how.loss = loss_of(options.loss, options.loss_scale * std::sqrt(8.0) * unit);
    // What is left is far below the noise of one tag, or nothing: then the next linearisation is at the minimum.
    how.function_tolerance = options.refine_robust ? 1e-12 : 1e-7;
    options.minimiser(model.problem, model.state, how);
    const double before = std::exchange(unit, std::max(1.0, upper_median(tag_misfits(model))));
    if (unit == before) break;  // the loss would be the same again
  }
  const std::vector<double> misfits = tag_misfits(model);
  for (size_t i = 0; i < misfits.size(); ++i)
    if (options.reject_above > 0 && misfits[i] > options.reject_above * unit) blunders.push_back(start.observations[i]);
  return blunders;
}

Solved solve_block(const std::vector<std::string>& weak_datum, const TagBlockOptions& options,
                   const bundle::Layout& layout, TagModel& model) {
  try {
    return solve(options, layout, model);
  } catch (const std::runtime_error& error) {
    if (weak_datum.empty()) throw;
    throw BadInput("the control hardly determines " + text::enumerate(weak_datum) +
                   " of the block; add control that is not on one line, or adjust a free network (" + error.what() +
                   ")");
  }
}

}  // namespace plumbline::block
