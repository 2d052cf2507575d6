// evaluate.crlb: from artifacts to block/tag_bound.hpp and back.
#include "build/evaluate/crlb_node.hpp"

#include <cmath>
#include <cstdint>

#include "artifacts/joint_memory.hpp"
#include "geometry/packed_symmetric.hpp"

namespace plumbline::judgement {

void EvaluateCrlb::run(Context& context) {
  const block::BoundProblem given = problem(context);
  const std::uint64_t coordinates = 3 * given.plates.size();
  announce_joint(context, coordinates * (coordinates + 1) / 2, 36);  // of six unknowns a plate, reordered, inverted
  const Eigen::MatrixXd covariance = block::tag_bound(given);
  const PointsT anchors = points.unpack();
  const auto place = by_id(anchors);
  PointsT out;
  for (std::size_t j = 0; j < given.plates.size(); ++j) {
    auto point = std::make_unique<PointT>(*place.at(given.plates[j].anchor));
    point->sigma = covariance.diagonal().segment<3>(static_cast<Eigen::Index>(3 * j)).cwiseSqrt();
    out.points.push_back(std::move(point));
  }
  if (covariance.allFinite()) out.covariance = pack_symmetric(covariance);
  const std::vector<std::size_t> checked = check_anchors(given, covariance);
  if (!checked.empty()) {
    double heights = 0, distances = 0;
    for (const std::size_t j : checked) {
      const Eigen::Vector3d variance = covariance.diagonal().segment<3>(static_cast<Eigen::Index>(3 * j));
      heights += variance.z(), distances += variance.sum();
    }
    const double count = static_cast<double>(checked.size());
    context.metric("rmse_z", std::sqrt(heights / count), "m");
    context.metric("rmse_3d", std::sqrt(distances / count), "m");
    const Prospects expected = prospects(given, covariance, checked);
    context.metric("drift", expected.drift, "m");
    context.metric("relative_drift", expected.relative_drift, "m");
    context.metric("within_2mm", expected.within(2e-3), "1");
    context.metric("within_5mm", expected.within(5e-3), "1");
    context.metric("within_8mm", expected.within(8e-3), "1");
  }
  bound.commit(out);
}

}  // namespace plumbline::judgement
