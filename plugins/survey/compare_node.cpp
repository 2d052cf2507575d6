#include "compare_node.hpp"

#include "compare_epochs.hpp"
#include "network_artifact.hpp"

namespace plumbline::survey {

namespace {

Epoch epoch_of(const PointsT& points, const char* which) {
  const ControlPoints all = control_from_artifact(points);
  if (points.covariance.empty())
    throw std::runtime_error(std::string("'") + which + "' has no covariance; take the points output of survey.adjust");
  return {all.ids, all.coordinates, all.covariance};
}

bool is_free(const PointsT& points) { return points.statistics && points.statistics->datum_defect > 0; }

}  // namespace

void CompareEpochsNode::run(Context& context) {
  const PointsT a = first.unpack(), b = second.unpack();
  ComparisonOptions options;
  options.alpha = *alpha;
  options.alpha0 = *alpha0;
  options.power = *power;
  options.free_datum = *datum == "free" || (*datum == "automatic" && (is_free(a) || is_free(b)));
  const Comparison c = compare_epochs(epoch_of(a, "first"), epoch_of(b, "second"), options);
  SurveyComparisonT out;
  for (const Movement& m : c.movements) {
    auto p = std::make_unique<PointMovementT>();
    p->id = m.id;
    p->movement = m.movement;
    p->sigma = m.sigma;
    p->statistic = m.statistic;
    p->moved = m.moved;
    p->stable = m.stable;
    p->detectable_height = m.detectable_height;
    if (m.moved) context.warn("point " + m.id + " has moved by " + std::to_string(m.movement.norm() * 1000) + " mm");
    out.points.push_back(std::move(p));
  }
  out.statistic = c.statistic;
  out.rank = c.rank;
  out.critical = c.critical;
  out.congruent = c.congruent;
  out.excluded = c.excluded;
  out.alpha = options.alpha;
  comparison.commit(out);
}

}  // namespace plumbline::survey
