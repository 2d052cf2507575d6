#include "photo/block/tag_block.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <utility>

#include "base/text/words.hpp"
#include "geometry/median.hpp"
#include "photo/block/tag_block_model.hpp"
#include "photo/block/tag_block_orientations.hpp"
#include "photo/block/tag_block_rejected.hpp"
#include "plumbline/failure.hpp"

namespace plumbline::block {
namespace {

using bundle::Kind;

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

/// Finds blunders: a robust adjustment, then every tag whose residuals stand out. The yardstick is the median tag, not
/// the a priori standard deviation: detectors' covariances may be wrong by a factor.
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

/// The block with the poses of `model` as approximate ones.
TagBlock with_poses(const TagBlock& block, const TagStart& start, const TagModel& model) {
  TagBlock result = block;
  for (size_t i = 0; i < start.images.size(); ++i) result.images[start.images[i]].cam_from_world = pose_of(model, i);
  return result;
}

struct Solved {
  bundle::Adjusted adjusted;
  bundle::Reliability reliability;
  double variance = 1;  ///< what cofactors are multiplied by to give covariances
};

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

void fill_statistics(const TagBlockOptions& options, const TagModel& model, Solved& solved, TagBlockResult& result) {
  result.observations = solved.adjusted.rows;
  result.unknowns = solved.adjusted.unknowns;
  result.datum_defect = solved.adjusted.defect;
  result.degrees_of_freedom = solved.adjusted.redundancy();
  result.iterations = solved.adjusted.iterations;
  result.groups = solved.reliability.groups;
  for (const auto& group : result.groups) result.weighted_sum_of_squares += group.sum_of_squares;
  if (result.degrees_of_freedom < 1)
    throw std::runtime_error("the block has no redundancy: nothing checks its observations");
  const double factor = result.weighted_sum_of_squares / result.degrees_of_freedom;
  result.sigma0 = std::sqrt(factor);
  std::erase_if(result.groups, [](const least_squares::VarianceComponent& group) { return group.rows == 0; });
  const double sigma = model.problem.groups[group_images].sigma_factor;
  result.image_variance_factor = sigma * sigma;
  if (options.weighting == TagBlockOptions::Weighting::lambda && options.estimate_image_variance) {
    solved.variance = factor;  // λ fixes the ratio of the two groups: only their common variance can be estimated
    result.image_variance_factor = factor;
  }
}

void fill_poses(const TagBlock& block, const TagStart& start, const TagModel& model, const bundle::Layout& layout,
                const Solved& solved, TagBlockResult& result) {
  result.cam_from_world.resize(block.images.size());
  result.pose_covariance.assign(block.images.size(), Matrix6::Zero());
  if (!model.state.shifts.empty()) result.principal_points.resize(block.images.size());
  for (size_t i = 0; i < start.images.size(); ++i) {
    const size_t image = static_cast<size_t>(start.images[i]);
    const RigidTransform pose = pose_of(model, i);
    result.cam_from_world[image] = pose;
    if (!model.state.shifts.empty()) result.principal_points[image].shift = model.state.shifts[i];
    if (model.problem.images[i].shift_free)
      result.principal_points[image].covariance =
          solved.variance * solved.adjusted.cofactors->own(layout.block({Kind::shift, static_cast<int>(i)}));
    const Matrix6 jacobian = pose_by_unknowns(model, i);
    result.pose_covariance[image] = solved.variance * jacobian *
                                    solved.adjusted.cofactors->own(layout.block({Kind::image, static_cast<int>(i)})) *
                                    jacobian.transpose();
  }
}

std::vector<int> plate_blocks(const TagModel& model, const bundle::Layout& layout) {
  std::vector<int> blocks;
  for (size_t j = 0; j < model.problem.plates.size(); ++j)
    blocks.push_back(layout.block({Kind::plate, static_cast<int>(j)}));
  return blocks;
}

void fill_cameras(const TagBlock& block, const TagModel& model, const bundle::Layout& layout, const Solved& solved,
                  TagBlockResult& result) {
  constexpr int nine = BrownCamera::parameter_count, all = nine + 2;
  std::vector<int> blocks, rows;
  for (int c = 0; c < static_cast<int>(block.cameras.size()); ++c) {
    for (int value : layout.free_values(c)) rows.push_back(all * c + value);
    if (!layout.free_values(c).empty()) blocks.push_back(layout.block({Kind::camera, c}));
  }
  const Eigen::Index size = all * static_cast<Eigen::Index>(block.cameras.size());
  result.interior_covariance = Eigen::MatrixXd::Zero(size, size);
  if (!blocks.empty())
    result.interior_covariance(rows, rows) = solved.variance * solved.adjusted.cofactors->joint(blocks);
  for (size_t c = 0; c < block.cameras.size(); ++c) {
    AdjustedTagCamera camera;
    const auto& values = model.state.interiors[c];
    const bundle::Camera& adjusted = model.problem.cameras[c];
    std::array<double, nine> interior;
    std::copy_n(values.begin(), interior.size(), interior.begin());
    camera.interior = block.cameras[c].interior;
    camera.interior.set_parameters(interior);
    const Eigen::Index at = all * static_cast<Eigen::Index>(c);
    camera.covariance = result.interior_covariance.block<nine, nine>(at, at);
    if ((adjusted.lens == bundle::Lens::brown && (adjusted.free[nine] || adjusted.free[nine + 1])) ||
        !block.cameras[c].distance_terms.isZero(0)) {
      camera.distance_terms = Eigen::Map<const Eigen::Vector2d>(values.data() + nine);
      camera.reference_distance = 1 / adjusted.inverse_reference;
    }
    result.cameras.push_back(camera);
  }
}

void fill_unknowns(const TagStart& start, const TagModel& model, const bundle::Layout& layout, const Solved& solved,
                   TagBlockResult& result) {
  const bundle::Cofactors& cofactors = *solved.adjusted.cofactors;
  result.plates = start.plates;
  std::vector<Eigen::Index> rows;
  result.anchors.resize(3 * static_cast<Eigen::Index>(start.plates.size()));
  for (size_t j = 0; j < start.plates.size(); ++j) {
    result.world_from_plate.push_back(model.state.plates[j].rotation);
    for (Eigen::Index c = 0; c < 3; ++c) rows.push_back(6 * static_cast<Eigen::Index>(j) + c);
    result.anchors.segment<3>(3 * static_cast<Eigen::Index>(j)) = model.state.plates[j].position + model.origin;
  }
  result.anchor_covariance = solved.variance * cofactors.joint(plate_blocks(model, layout))(rows, rows);
  // Batches as they were printed, then the same of each further camera that has insets of its own.
  int last = 0;
  for (const auto& plate : model.problem.plates) last = std::max(last, plate.batch);
  const auto printed = static_cast<size_t>(last) + 1;
  for (size_t b = 0; b < model.problem.batches.size(); ++b) {
    const auto sigma = [&](Kind kind) {
      const int id = layout.block({kind, static_cast<int>(b)});
      return layout.size(id) > 0 ? std::sqrt(solved.variance * cofactors.own(id)(0, 0)) : 0.0;
    };
    result.batches.push_back({model.problem.batches[b].name, model.state.scales[b], sigma(Kind::scale),
                              model.state.insets[b], sigma(Kind::inset), model.problem.batches[b % printed].name,
                              static_cast<int>(b / printed)});
  }
  result.images_per_plate.assign(start.plates.size(), 0);
  for (const auto& term : model.problem.image_tags) ++result.images_per_plate[term.plate];
}

void fill_tags(const TagStart& start, const TagModel& model, const Solved& solved, TagBlockResult& result) {
  const double root = std::sqrt(solved.variance);
  std::vector<std::vector<double>> w_of_plate(start.plates.size());
  for (size_t i = 0; i < model.problem.image_tags.size(); ++i) {
    AdjustedTag tag;
    tag.observation = start.observations[i];
    tag.smallest_redundancy = 1;
    double sum = 0;
    for (const auto& row : solved.reliability.tags[i]) {
      sum += row.residual * row.residual;
      tag.largest_normalised = std::max(tag.largest_normalised, std::abs(row.w) / root);
      tag.smallest_redundancy = std::min(tag.smallest_redundancy, row.redundancy_number);
      tag.largest_detectable_error = std::max(tag.largest_detectable_error, row.mdb * root);
    }
    tag.rms = std::sqrt(sum / 8);
    w_of_plate[model.problem.image_tags[i].plate].push_back(tag.largest_normalised);
    result.tags.push_back(tag);
  }
  for (const auto& w : w_of_plate) result.plate_w.push_back(w.empty() ? 0 : upper_median(w));
}

void fill_control(const TagStart& start, const TagModel& model, const bundle::Layout& layout, const Solved& solved,
                  TagBlockResult& result) {
  if (model.control_term < 0) return;
  const size_t term = static_cast<size_t>(model.control_term);
  const auto& known = model.problem.known[term];
  const bundle::KnownRows rows = bundle::evaluate(model.problem, layout, solved.adjusted.state, known);
  // Change of all heights per unit of error in one control coordinate: Q Aᵀ P e, with whitened rows A' = W A.
  std::vector<Eigen::Index> heights, coordinates;
  for (size_t j = 0; j < start.plates.size(); ++j) heights.push_back(3 * static_cast<Eigen::Index>(j) + 2);
  for (int plate : model.control_plates)
    for (Eigen::Index c = 0; c < 3; ++c) coordinates.push_back(3 * static_cast<Eigen::Index>(plate) + c);
  const Eigen::MatrixXd of_heights = result.anchor_covariance(heights, coordinates) / solved.variance;
  const Eigen::MatrixXd influence = of_heights * rows.jacobian.transpose() * known.whitening;
  const double root = std::sqrt(solved.variance);
  for (size_t k = 0; k < model.control_plates.size(); ++k) {
    AdjustedControl control;
    const size_t plate = static_cast<size_t>(model.control_plates[k]);
    control.plate = start.plates[plate];
    for (size_t c = 0; c < 3; ++c) {
      control.coordinates[c] = solved.reliability.known[term][3 * k + c];
      control.coordinates[c].w /= root;
      control.coordinates[c].mdb *= root;
      control.effect_on_height[c] =
          influence.col(static_cast<Eigen::Index>(3 * k + c)).cwiseAbs().maxCoeff() * control.coordinates[c].mdb;
      result.plate_w[plate] = std::max(result.plate_w[plate], std::abs(control.coordinates[c].w));
    }
    result.control.push_back(control);
  }
}

/// Control nearly on a line lets the block swing by degrees; the iteration that follows has this cause and no other.
Solved solve_under(const std::vector<std::string>& weak_datum, const TagBlockOptions& options,
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

/// Of groups that fail the priors, which may be what makes the control fail, too.
std::vector<least_squares::VarianceComponent> not_to_believe(std::vector<least_squares::VarianceComponent> failing) {
  if (std::any_of(failing.begin(), failing.end(), [](const auto& group) { return group.name != "control"; }))
    std::erase_if(failing, [](const auto& group) { return group.name == "control"; });
  return failing;
}

/// Priors as if they said nothing, control at the standard deviations that its residuals ask for.
void do_not_believe(const std::vector<least_squares::VarianceComponent>& groups, TagModel& model) {
  constexpr double nothing = 1e3;
  for (const auto& group : groups)
    for (auto& of_model : model.problem.groups)
      if (of_model.name == group.name)
        of_model.sigma_factor = group.name == "control" ? std::sqrt(group.factor) : nothing;
}

/// What is done with control that its tests find wrong.
enum class WrongControl { as_judged, named, left_out };

/// One adjustment at work.
class TagAdjustment {
 public:
  TagAdjustment(const TagBlock& given, const TagBlockOptions& options, JudgedControl judged,
                std::vector<least_squares::VarianceComponent> disproved = {})
      : given_(given),
        options_(options),
        block_(given),
        use_(given.observations.size(), true),
        judged_(std::move(judged)),
        disproved_(std::move(disproved)) {
    for (const RejectedControl& rejected : judged_.rejected) leave_out(rejected.plate, block_.control);
  }

  TagBlockResult run(WrongControl wrong) {
    adjust();
    if (wrong == WrongControl::left_out) {
      if (leave_wrong_control_out() == Search::begins_anew) return over_again(WrongControl::left_out);
      const auto failing = failing_by_itself();
      if (judged_.too_many || (!judged_.rejected.empty() && !failing.empty())) {
        keep_what_is_clear(failing);
        return over_again(WrongControl::as_judged);
      }
    }
    if (!judged_.disproved.empty()) doubt_what_is_disproved();
    fill();
    // Weights by λ are no claims about variances.
    if (options_.weighting == TagBlockOptions::Weighting::lambda) return std::move(result_);
    if (wrong == WrongControl::named) {
      const ControlTests tests = test_control(model_, start_, solved_.adjusted);
      if (tests.worst || !tests.rivals.empty()) name_wrong_control(given_, options_, result_);
    }
    test_groups(block_, result_);
    test_models(options_, model_, solved_.adjusted, result_);
    return std::move(result_);
  }

  /// What the tests of the control come to, and nothing else. What fails then as well is not believed, either.
  JudgedControl judge() {
    adjust();
    const Search search = leave_wrong_control_out();
    auto failing = failing_by_itself();
    solved_ = {};
    if (search == Search::begins_anew)
      return TagAdjustment(given_, options_, std::move(judged_), std::move(disproved_)).judge();
    for (const auto& group : disproved_) {
      judged_.disproved.push_back(group.name);
      std::erase_if(failing, [&](const auto& other) { return other.name == group.name; });
    }
    if (judged_.too_many || judged_.rejected.empty() || failing.empty()) return std::move(judged_);
    for (auto& group : not_to_believe(std::move(failing))) disproved_.push_back(std::move(group));
    return TagAdjustment(given_, options_, {}, std::move(disproved_)).judge();
  }

 private:
  enum class Search { ended, begins_anew };

  void begin() {
    result_.left_out.clear();
    result_.warnings.clear();
    start_ = start_tag_block(block_, use_, result_.left_out);
    if (!options_.free_network) move_to_control(block_, start_, result_.warnings);
    model_ = build_tag_model(block_, options_, start_);
    do_not_believe(disproved_, model_);
    require_datum(options_, model_, result_);
  }

  void adjust() {
    begin();
    warnings_ = result_.warnings;
    result_.rejected = find_blunders(options_, start_, model_);
    if (!result_.rejected.empty()) {
      for (int o : result_.rejected) use_[o] = false;
      begin_again();
    }
    layout_.emplace(model_.problem);
    solved_ = solve_under(result_.weak_datum, options_, *layout_, model_);
  }

  TagBlockResult over_again(WrongControl wrong) {
    solved_ = {};  // its cofactors and those of the next adjustment are not there at once
    return TagAdjustment(given_, options_, judged_).run(wrong);
  }

  void begin_again() {
    block_ = with_poses(block_, start_, model_);
    begin();
    result_.warnings = warnings_;
  }

  /// Leaves out what is clear, until nothing is. The adjustment at hand is then the one without it, unless too many
  /// went.
  Search leave_wrong_control_out() {
    for (;;) {
      const ControlTests tests = test_control(model_, start_, solved_.adjusted, plates_of(judged_.needed));
      if (judged_.tested == 0) judged_.tested = model_.control_plates.size();
      judged_.hidden = tests.hidden;
      doubt_rivals(tests.rivals);
      if (!tests.worst) {
        test_needed_again();
        return Search::ended;
      }
      judged_.rejected.push_back(*tests.worst);
      judged_.too_many = are_too_many(judged_.tested, judged_.rejected);
      if (judged_.too_many) return Search::ended;
      leave_out(tests.worst->plate, block_.control);
      try {
        const double sigma = model_.problem.groups[group_images].sigma_factor;
        const bool was_weak = !result_.weak_datum.empty();
        begin_again();
        if (!was_weak && !result_.weak_datum.empty())
          throw std::runtime_error("the control holds " + text::enumerate(result_.weak_datum) + " only weakly");
        model_.problem.groups[group_images].sigma_factor = sigma;
        solved_ = solve_under(result_.weak_datum, options_, *layout_, model_);
      } catch (const std::runtime_error& without) {
        judged_.rejected.pop_back();
        judged_.needed.push_back({*tests.worst, without.what()});
        return Search::begins_anew;
      }
    }
  }

  /// Control that stays in doubt fails its test, and that says nothing of what is out.
  std::vector<least_squares::VarianceComponent> failing_by_itself() const {
    auto failing = failing_but_images(solved_.reliability.groups);
    if (!judged_.doubts.empty() || !judged_.needed.empty())
      std::erase_if(failing, [](const auto& group) { return group.name == "control"; });
    return failing;
  }

  void doubt_rivals(const std::vector<ControlRivals>& groups) {
    judged_.doubts.clear();
    judged_.unclear.clear();
    for (const ControlRivals& group : groups) {
      judged_.doubts.push_back(rivals(given_, group.worst, group.others));
      judged_.unclear.push_back(group.worst.plate);
      judged_.unclear.insert(judged_.unclear.end(), group.others.begin(), group.others.end());
    }
  }

  /// A point that the block needs may have contradicted what is out by now.
  void test_needed_again() {
    if (judged_.needed.empty()) return;
    const ControlTests tests = test_control(model_, start_, solved_.adjusted);
    std::erase_if(judged_.needed, [&](NeededControl& point) {
      const int plate = point.worst.plate;
      if (tests.worst && tests.worst->plate == plate) return point.worst = *tests.worst, false;
      for (const ControlRivals& group : tests.rivals) {
        if (group.worst.plate == plate) return point.worst = group.worst, false;
        if (std::find(group.others.begin(), group.others.end(), plate) != group.others.end()) return false;
      }
      return judged_.needed.size() == 1 || (!tests.worst && tests.rivals.empty());
    });
  }

  /// Where control or priors fail by themselves, that may be what the points contradict: wrong are those that do
  /// whatever the priors say or, if these hold, at the standard deviations of the survey that the rest asks for.
  void keep_what_is_clear(std::vector<least_squares::VarianceComponent> failing) {
    if (judged_.too_many) std::erase_if(failing, [](const auto& group) { return group.name == "control"; });
    JudgedControl clear;
    clear.too_many = failing.empty();
    solved_ = {};
    try {
      if (!failing.empty()) clear = TagAdjustment(given_, options_, {}, not_to_believe(std::move(failing))).judge();
    } catch (const std::runtime_error&) {  // without the priors the photographs do not determine the block
      clear.too_many = true;
    }
    if (clear.too_many) {
      clear = {};
      clear.doubts = {judged_.too_many ? too_many(given_, judged_.tested, judged_.rejected)
                                       : not_mended(given_, judged_.tested, judged_.rejected)};
    }
    clear.tested = judged_.tested;
    judged_ = std::move(clear);
  }

  /// What contradicts once more where everything is believed again.
  void doubt_what_is_disproved() {
    std::vector<int> known = plates_of(judged_.needed);
    known.insert(known.end(), judged_.unclear.begin(), judged_.unclear.end());
    const ControlTests tests = test_control(model_, start_, solved_.adjusted, known);
    judged_.hidden = tests.hidden;
    if (tests.worst || !tests.rivals.empty())
      judged_.doubts.push_back(as_far_as_believed(
          given_, tests.rivals.empty() ? *tests.worst : tests.rivals.front().worst, judged_.disproved));
  }

  void fill() {
    fill_statistics(options_, model_, solved_, result_);
    fill_poses(block_, start_, model_, *layout_, solved_, result_);
    if (options_.joint_orientations)
      result_.orientation_covariance =
          solved_.variance * joint_orientations(start_.images, static_cast<int>(block_.cameras.size()), model_,
                                                *layout_, *solved_.adjusted.cofactors);
    fill_unknowns(start_, model_, *layout_, solved_, result_);
    fill_cameras(block_, model_, *layout_, solved_, result_);
    fill_tags(start_, model_, solved_, result_);
    fill_control(start_, model_, *layout_, solved_, result_);
    fill_judged_control(given_, judged_, result_);
    for (const auto& plates : options_.withhold)
      result_.withheld.push_back(withheld_control(model_, start_, solved_.adjusted, plates));
  }

  const TagBlock& given_;
  const TagBlockOptions& options_;
  TagBlock block_;
  std::vector<bool> use_;
  JudgedControl judged_;
  std::vector<least_squares::VarianceComponent> disproved_;  ///< groups that this search does not believe
  std::vector<std::string> warnings_;                        ///< of the first start, which is the one that people gave
  TagBlockResult result_;
  TagStart start_;
  TagModel model_;
  std::optional<bundle::Layout> layout_;
  Solved solved_;
};

}  // namespace

void require_usable(const TagBlock& block) {
  if (block.images.size() < 2)
    throw std::runtime_error("a block needs at least 2 images, this one has " + std::to_string(block.images.size()));
  if (block.observations.empty()) throw std::runtime_error("no image shows a tag of a known plate");
  for (const auto& image : block.images)
    if (image.camera < 0 || image.camera >= static_cast<int>(block.cameras.size()))
      throw std::runtime_error("image " + image.name + " is of no camera of the block");
  for (const auto& plate : block.plates)
    if (!(plate.plate.tag_size > 0)) throw std::runtime_error("the plate of " + plate.anchor + " has no tag size");
}

TagBlockResult adjust_tag_block(const TagBlock& given, const TagBlockOptions& options) {
  require_usable(given);
  const bool by_lambda = options.weighting == TagBlockOptions::Weighting::lambda;
  if (by_lambda && !(options.lambda > 0 && options.corner_sigma > 0))
    throw std::runtime_error("lambda weighting needs lambda > 0 [px^2/m^2] and corner_sigma > 0 [px]");
  return TagAdjustment(given, options, {})
      .run(by_lambda || !options.test_control ? WrongControl::as_judged
           : options.robust_control           ? WrongControl::left_out
                                              : WrongControl::named);
}

}  // namespace plumbline::block
