#include "photo/block/tag_block.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <utility>

#include "base/text/words.hpp"
#include "photo/block/tag_block_fill.hpp"
#include "photo/block/tag_block_model.hpp"
#include "photo/block/tag_block_orientations.hpp"
#include "photo/block/tag_block_rejected.hpp"
#include "photo/block/tag_block_solve.hpp"
#include "plumbline/failure.hpp"

namespace plumbline::block {
namespace {

/// The block with the poses of `model` as approximate ones.
TagBlock with_poses(const TagBlock& block, const TagStart& start, const TagModel& model) {
  TagBlock result = block;
  for (size_t i = 0; i < start.images.size(); ++i) result.images[start.images[i]].cam_from_world = pose_of(model, i);
  return result;
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

  /// `carried_over`: the poses are in the frame of the control already, and what wrong control has made of them says
  /// nothing of its unit.
  void begin(bool carried_over = false) {
    result_.left_out.clear();
    result_.warnings.clear();
    start_ = start_tag_block(block_, use_, result_.left_out);
    if (!options_.free_network && !carried_over) move_to_control(block_, start_, result_.warnings);
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
    solved_ = solve_block(result_.weak_datum, options_, *layout_, model_);
  }

  TagBlockResult over_again(WrongControl wrong) {
    solved_ = {};  // its cofactors and those of the next adjustment are not there at once
    return TagAdjustment(given_, options_, judged_).run(wrong);
  }

  void begin_again() {
    block_ = with_poses(block_, start_, model_);
    begin(true);
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
        solved_ = solve_block(result_.weak_datum, options_, *layout_, model_);
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
    fill_result(block_, options_, start_, model_, *layout_, solved_, result_);
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

/// An error far above all that the approximate values are wrong by bends the block until its sound tags are blunders,
/// or nothing converges: the search begins without that point, and it stays out if the block contradicts it in the end.
/// Nothing where no point stands out so, or the rest does not hold the block.
std::optional<TagBlockResult> adjust_without(const std::optional<FarControl>& far, const TagBlock& given,
                                             const TagBlockOptions& options) {
  if (!far || !far->alone) return std::nullopt;
  JudgedControl judged;
  judged.rejected = {{far->plate, far->off}};
  judged.tested = far->of;
  try {
    TagBlockResult result = TagAdjustment(given, options, judged).run(WrongControl::left_out);
    const auto out = std::find_if(result.rejected_control.begin(), result.rejected_control.end(),
                                  [&](const RejectedControl& one) { return one.plate == far->plate; });
    if (out != result.rejected_control.end() && out->test > out->limit && result.weak_datum.empty()) return result;
  } catch (const std::runtime_error&) {  // what the whole of the control comes to is told
  }
  return std::nullopt;
}

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
  const WrongControl wrong = by_lambda || !options.test_control ? WrongControl::as_judged
                             : options.robust_control           ? WrongControl::left_out
                                                                : WrongControl::named;
  std::optional<FarControl> far;
  if (!options.free_network && !given.control.plates.empty()) far = furthest_control(given);
  if (wrong == WrongControl::left_out)
    if (auto result = adjust_without(far, given, options)) return std::move(*result);
  try {
    return TagAdjustment(given, options, {}).run(wrong);
  } catch (const NotConverged& error) {
    if (!far || !far->alone) throw;
    throw NotConverged(error.what() + ("; " + in_words(*far, given)));
  }
}

}  // namespace plumbline::block
