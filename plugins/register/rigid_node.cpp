// register.rigid: equations (6) and (8) of a free block against surveyed control.
#include <cmath>
#include <map>

#include "artifacts/points.hpp"
#include "artifacts/transform.hpp"
#include "geometry/packed_symmetric.hpp"
#include "plumbline/node.hpp"
#include "register/rigid_registration.hpp"

namespace {

using namespace plumbline;
namespace reg = plumbline::registration;

/// Index of every point by its id. Throws for an id that stands twice.
std::map<std::string, int> index_of(const PointsT& points, const char* port) {
  std::map<std::string, int> index;
  for (size_t i = 0; i < points.points.size(); ++i)
    if (!index.emplace(points.points[i]->id, static_cast<int>(i)).second)
      throw std::runtime_error(std::string("'") + port + "' has two points named " + points.points[i]->id);
  return index;
}

/// The full covariance if it is there, else that of the sigmas, else an empty matrix.
Eigen::MatrixXd covariance_of(const PointsT& points, const char* port) {
  const std::size_t n = 3 * points.points.size();
  if (!points.covariance.empty()) return unpack_symmetric(points.covariance, n, std::string("'") + port + "'");
  Eigen::MatrixXd c = Eigen::MatrixXd::Zero(n, n);
  for (size_t i = 0; i < points.points.size(); ++i) {
    const Eigen::Vector3d& sigma = points.points[i]->sigma;
    if (!sigma.allFinite()) return {};
    c.diagonal().segment<3>(static_cast<Eigen::Index>(3 * i)) = sigma.cwiseAbs2();
  }
  return c;
}

Eigen::Matrix3Xd positions_of(const PointsT& points) {
  Eigen::Matrix3Xd p(3, static_cast<Eigen::Index>(points.points.size()));
  for (size_t i = 0; i < points.points.size(); ++i) p.col(static_cast<Eigen::Index>(i)) = points.points[i]->position;
  return p;
}

Eigen::MatrixXd part(const Eigen::MatrixXd& c, const std::vector<int>& chosen) {
  if (c.size() == 0) return {};
  const auto n = static_cast<Eigen::Index>(chosen.size());
  Eigen::MatrixXd out(3 * n, 3 * n);
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = 0; j < n; ++j)
      out.block<3, 3>(3 * i, 3 * j) =
          c.block<3, 3>(3 * chosen[static_cast<size_t>(i)], 3 * chosen[static_cast<size_t>(j)]);
  return out;
}

std::vector<double> upper_of(const Eigen::Matrix3d& m) {
  return {m(0, 0), m(0, 1), m(0, 2), m(1, 1), m(1, 2), m(2, 2)};
}

struct RegisterRigid : Node {
  static constexpr Info info{"register.rigid", "registrar", 1,
                             "Weighted rigid or similarity registration of points to control, equations (6) and (8)"};
  In<Points> source{"source", frame("frame=?S"), "points to move; those with role check never take part in the fit"};
  In<Points> target{"target", frame("frame=?T"),
                    "control, matched by id; those with role check never take part in the fit"};
  Out<Transform> transform{"transform", frame("to=?T,from=?S"), "the transform, its covariance, residuals, and (8)"};
  Out<Points> points{"points", frame("frame=?T"), "all source points in the target frame, with propagated covariance"};
  Param<std::string> weights{
      "weights", "auto", one_of("auto", "equal", "scalar", "covariance"),
      "equal; scalar: one weight a point from its variances; covariance: the full covariance of both sides; "
      "auto: covariance if either side has one, else equal"};
  Param<std::string> scale{"scale", "fixed", one_of("fixed", "estimated"), "6 or 7 parameters"};
  Param<double> min_width_ratio{
      "min_width_ratio", 0.01, "1", between(0, 1),
      "a figure of control points narrower than this against its length is refused as a line"};

  void run(Context& context) override {
    const PointsT from = source.unpack(), to = target.unpack();
    const Eigen::MatrixXd from_covariance = covariance_of(from, "source"), to_covariance = covariance_of(to, "target");
    std::vector<int> chosen_from, chosen_to;
    reg::Correspondences c = match(from, to, chosen_from, chosen_to);
    c.source_covariance = part(from_covariance, chosen_from);
    c.target_covariance = part(to_covariance, chosen_to);

    const reg::Registration found = reg::register_points(c, options(c));
    const reg::MovedPoints moved =
        reg::move_points(found, positions_of(from), from_covariance, chosen_from, c.target_covariance);
    context.metric("sigma0", found.sigma0, "1");
    transform.commit(transform_artifact(c, found));
    points.commit(points_artifact(from, to, moved));
  }

 private:
  reg::Options options(const reg::Correspondences& c) const {
    reg::Options o;
    const bool known = c.source_covariance.size() > 0 || c.target_covariance.size() > 0;
    if (*weights == "scalar") o.weighting = reg::Weighting::scalar;
    if (*weights == "covariance" || (*weights == "auto" && known)) o.weighting = reg::Weighting::covariance;
    o.estimate_scale = *scale == "estimated";
    o.min_width_ratio = *min_width_ratio;
    return o;
  }

  static reg::Correspondences match(const PointsT& from, const PointsT& to, std::vector<int>& chosen_from,
                                    std::vector<int>& chosen_to) {
    const auto index = index_of(from, "source");
    index_of(to, "target");
    reg::Correspondences c;
    for (size_t k = 0; k < to.points.size(); ++k) {
      const PointT& point = *to.points[k];
      const auto other = index.find(point.id);
      if (other == index.end() || point.role == "check" ||
          from.points[static_cast<size_t>(other->second)]->role == "check")
        continue;
      c.ids.push_back(point.id);
      chosen_from.push_back(other->second);
      chosen_to.push_back(static_cast<int>(k));
    }
    const auto n = static_cast<Eigen::Index>(c.ids.size());
    c.source.resize(3, n);
    c.target.resize(3, n);
    for (Eigen::Index i = 0; i < n; ++i) {
      c.source.col(i) = from.points[static_cast<size_t>(chosen_from[static_cast<size_t>(i)])]->position;
      c.target.col(i) = to.points[static_cast<size_t>(chosen_to[static_cast<size_t>(i)])]->position;
    }
    if (n < 3)
      throw reg::DegenerateRegistration("a registration needs at least 3 points that both 'source' (" +
                                        std::to_string(from.points.size()) + " points) and 'target' (" +
                                        std::to_string(to.points.size()) +
                                        " points) have and that are not check points; found " + std::to_string(n));
    return c;
  }

  static TransformT transform_artifact(const reg::Correspondences& c, const reg::Registration& found) {
    TransformT t;
    t.to_from_from = found.to_from_from;
    t.scale = found.scale;
    t.covariance = pack_symmetric(found.covariance);
    for (size_t i = 0; i < c.ids.size(); ++i) {
      auto residual = std::make_unique<RegistrationResidualT>();
      residual->id = c.ids[i];
      residual->residual = found.residuals.col(static_cast<Eigen::Index>(i));
      residual->weight = 1;
      t.residuals.push_back(std::move(residual));
    }
    t.residual_covariance = upper_of(found.residual_covariance);
    t.residual_covariance_unbiased = upper_of(found.residual_covariance_unbiased);
    t.statistics = std::make_unique<StatisticsT>();
    t.statistics->sigma0 = found.sigma0;
    t.statistics->degrees_of_freedom = found.degrees_of_freedom;
    t.statistics->weighted_sum_of_squares = found.weighted_sum_of_squares;
    t.statistics->observations = static_cast<int64_t>(3 * c.ids.size());
    t.statistics->unknowns = found.unknowns;
    return t;
  }

  static PointsT points_artifact(const PointsT& from, const PointsT& to, const reg::MovedPoints& moved) {
    std::map<std::string, std::string> roles;
    for (const auto& point : to.points) roles[point->id] = point->role;
    PointsT result;
    for (size_t i = 0; i < from.points.size(); ++i) {
      auto point = std::make_unique<PointT>(*from.points[i]);
      const auto k = static_cast<Eigen::Index>(i);
      point->position = moved.positions.col(k);
      point->sigma.setConstant(std::nan(""));
      if (moved.covariance.size() > 0)
        point->sigma = moved.covariance.diagonal().segment<3>(3 * k).cwiseMax(0).cwiseSqrt();
      if (point->role.empty() && roles.count(point->id)) point->role = roles[point->id];
      result.points.push_back(std::move(point));
    }
    result.covariance = pack_symmetric(moved.covariance);
    return result;
  }
};

}  // namespace

PLUMBLINE_PLUGIN("register", "0.1.0", "MIT", RegisterRigid)
