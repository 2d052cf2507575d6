// evaluate.@name@: one number that a bench can measure. A bench file names it as NODE.METRIC: measure: {error:
// own.median_z}.
#include <cmath>
#include <map>

#include "artifacts/points.hpp"
#include "geometry/median.hpp"
#include "plumbline/node.hpp"

using namespace plumbline;

namespace {

struct Metric : Node {
  static constexpr Info info{"evaluate.@name@", "", 1, "Median error of the heights against truth"};
  In<Points> model{"model", frame("frame=?F"), "points to judge, matched by id; points used as control are left out"};
  In<Points> truth{"truth", frame("frame=?F"), "where they are"};
  Out<Points> judged{"points", frame("frame=?F"), "the points that were judged"};
  Param<std::string> role{"role", "check", one_of("check", "control", "all"),
                          "which points are judged; control is no evidence"};

  void run(Context& context) override {
    std::map<std::string, double> true_height;
    for (const auto& point : truth.unpack().points) true_height[point->id] = point->position.z();
    PointsT result;
    std::vector<double> errors;
    for (auto& point : model.unpack().points) {
      const auto found = true_height.find(point->id);
      if (found == true_height.end() || !(*role == "all" || point->role == *role)) continue;
      if (std::isnan(point->position.z() - found->second)) continue;
      errors.push_back(std::abs(point->position.z() - found->second));
      result.points.push_back(std::move(point));
    }
    if (errors.empty())
      throw std::runtime_error("none of the points of 'model' has the role '" + *role +
                               "' and stands in 'truth'; choose another 'role'");
    const double middle = median(errors);
    context.metric("median_z", middle, "m");
    context.info("median error of " + std::to_string(errors.size()) + " heights: " + std::to_string(1e3 * middle) +
                 " mm");
    judged.commit(result);
  }
};

}  // namespace

PLUMBLINE_PLUGIN("@name@", "0.1.0", "MIT", Metric)
