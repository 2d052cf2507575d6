#include "build/evaluate/image_plan_node.hpp"

#include <fmt/core.h>

#include <cmath>
#include <set>

namespace plumbline::judgement {

namespace {

const char* words_of(block::Addition::Kind kind) {
  switch (kind) {
    case block::Addition::Kind::again:
      return "photograph again";
    case block::Addition::Kind::rolled:
      return "photograph rolled by 90 degrees";
    case block::Addition::Kind::survey:
      break;
  }
  return "survey";
}

template <typename... Values>
std::string line(fmt::format_string<const Values&...> format, const Values&... values) {
  return fmt::format(format, values...) + "\n";
}

std::string verdict_text(const ImagePlanT& plan, std::size_t images, std::size_t anchors) {
  std::string text = line("Planned: {} photographs, heights of {} anchors count", images, anchors);
  text += line("  expected RMSE in height {:.2f} mm, in space {:.2f} mm", 1e3 * plan.rmse_z, 1e3 * plan.rmse_3d);
  text += line("  sigma of D(F) {:.2f} mm, of the top floor against the lowest {:.2f} mm", 1e3 * plan.drift_sigma,
               1e3 * plan.relative_drift_sigma);
  text += line("  expected within {:.1f} mm in height: {:.1f} %; weakest {} with {:.2f} mm", 1e3 * plan.tolerance,
               100 * plan.pass_rate, plan.worst, 1e3 * plan.worst_sigma);
  if (!plan.unseen.empty())
    text += line("  in no photograph: {} anchors, such as {}", plan.unseen.size(), plan.unseen.front());
  if (!plan.weak_images.empty())
    text += line("  {} photographs say little, such as {} ({} plates, {:.0f} % of its area)", plan.weak_images.size(),
                 plan.weak_images.front()->path, plan.weak_images.front()->plates,
                 100 * plan.weak_images.front()->coverage);
  std::set<std::string> told;  // the best of each kind
  for (const auto& addition : plan.additions) {
    if (!told.insert(addition->what).second) continue;
    if (told.size() == 1) text += "Cheapest to add\n";
    text += line("  {}: {}, RMSE in height {:.3f} mm", addition->what, addition->of, 1e3 * addition->rmse_z);
  }
  return text;
}

}  // namespace

ImagePlanT PlanImages::pack(const block::BoundProblem& given, const block::ImagePlan& found,
                            const Eigen::MatrixXd& covariance) const {
  ImagePlanT out;
  out.rmse_z = found.rmse_z;
  out.rmse_3d = found.rmse_3d;
  out.worst = given.plates[found.worst].anchor;
  out.worst_sigma = found.worst_sigma;
  for (const block::WeakImage& weak : found.weak) {
    auto item = std::make_unique<PlannedImageT>();
    item->path = given.images[weak.image];
    item->plates = weak.plates;
    item->coverage = weak.coverage;
    out.weak_images.push_back(std::move(item));
  }
  for (std::size_t j = 0; j < given.plates.size(); ++j)
    if (!std::isfinite(covariance(static_cast<Eigen::Index>(3 * j), static_cast<Eigen::Index>(3 * j))))
      out.unseen.push_back(given.plates[j].anchor);
  std::map<block::Addition::Kind, int64_t> listed;
  for (const block::Addition& addition : found.additions) {
    if (++listed[addition.kind] > *additions) continue;
    auto item = std::make_unique<PlannedAdditionT>();
    item->what = words_of(addition.kind);
    item->of =
        addition.kind == block::Addition::Kind::survey ? given.plates[addition.of].anchor : given.images[addition.of];
    item->rmse_z = addition.rmse_z;
    item->gain = addition.per_cost;
    out.additions.push_back(std::move(item));
  }
  return out;
}

void PlanImages::run(Context& context) {
  const block::BoundProblem given = problem(context);
  const block::TagBound bound(given);
  const Eigen::MatrixXd covariance = bound.anchors();
  const std::vector<std::size_t> wanted = check_anchors(given, covariance);
  if (wanted.empty())
    throw std::runtime_error(
        "no anchor with role check is in a photograph: nothing would be proved by these photographs; give some "
        "anchors that role in the plate table");
  block::ImagePlanOptions options;
  options.fewest_plates = static_cast<int>(*fewest_plates);
  options.least_coverage = *least_coverage;
  options.survey_sigma = *survey_sigma;
  options.survey_cost = *survey_cost;
  ImagePlanT out = pack(given, block::plan_images(given, bound, wanted, options), covariance);
  const Prospects expected = prospects(given, covariance, wanted);
  out.drift_sigma = expected.drift;
  out.relative_drift_sigma = expected.relative_drift;
  out.tolerance = *tolerance;
  out.pass_rate = expected.within(*tolerance);
  for (const auto& image : out.weak_images)
    context.warn("photograph " + image->path + " says little: " + std::to_string(image->plates) + " plates on " +
                 std::to_string(std::lround(100 * image->coverage)) + " % of its area");
  constexpr double lopsided = 20;  // positions that much worse than heights hang on a lever, not on the images
  if (out.rmse_3d > lopsided * out.rmse_z && out.rmse_3d > *tolerance)
    context.warn("the control hardly holds the positions (" + std::to_string(std::lround(1e3 * out.rmse_3d)) +
                 " mm expected in space): it lies nearly on one line; survey a marker beside it");
  const std::string text = verdict_text(out, given.images.size(), wanted.size());
  FileT file;
  file.name = "verdict.txt";
  file.media_type = "text/plain";
  file.content.assign(text.begin(), text.end());
  verdict.commit(file);
  plan.commit(out);
}

}  // namespace plumbline::judgement
