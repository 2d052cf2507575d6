// What slope distances place in a frame, without zenith angles.
#include <Eigen/Geometry>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>

#include "geometry/linear_algebra/decompositions.hpp"
#include "survey/start/approximate_frame.hpp"

namespace plumbline::survey {

namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

/// The best of two places, and the other if it fits as well within `slack`.
template <typename Place, typename Score>
std::vector<Place> as_good_as_the_best(std::vector<Place> places, const Score& score, double slack) {
  std::stable_sort(places.begin(), places.end(), [&](const Place& a, const Place& b) { return score(a) < score(b); });
  while (places.size() > 1 && score(places.back()) > score(places.front()) + slack) places.pop_back();
  return places;
}

}  // namespace

std::map<std::string, std::vector<Frame::Sphere>> Frame::collect_spheres() const {
  std::map<std::string, std::vector<Sphere>> spheres;
  const auto add = [&](const std::string& known, const std::string& unknown, double slope, double lift) {
    if (std::isnan(slope) || !has_plan(known) || !has_height(known)) return;
    if ((has_plan(unknown) && has_height(unknown)) || heightless(unknown)) return;
    const Vector2d& p = plan_.at(known);
    spheres[unknown].push_back({{p.x(), p.y(), height_.at(known) + lift}, slope});
  };
  for (const DistanceLine& d : figures_.distances) {
    add(d.from, d.to, d.slope, d.heights);
    add(d.to, d.from, d.slope, -d.heights);
  }
  for (const Figure& figure : figures_.figures)
    for (const PolarSight& s : figure.sights) {
      add(figure.station, s.to, s.slope, s.heights);
      add(s.to, figure.station, s.slope, -s.heights);
    }
  return spheres;
}

bool Frame::place_by_slope_distances(bool accept_ambiguous) {
  if (scale_open_) return false;
  constexpr double kFlat = 0.02;  // centres closer than this to one plane (or line), relative to their spread
  for (const auto& [id, list] : collect_spheres()) {
    if (has_plan(id) || list.size() < 3) continue;
    Vector3d mean = Vector3d::Zero();
    double power = 0;  // mean of |c|^2 - r^2
    const auto n = static_cast<double>(list.size());
    for (const Sphere& s : list) mean += s.centre / n;
    for (const Sphere& s : list) power += ((s.centre - mean).squaredNorm() - s.radius * s.radius) / n;
    Eigen::MatrixXd a(list.size(), 3);
    Eigen::VectorXd b(list.size());
    for (size_t k = 0; k < list.size(); ++k) {
      const Vector3d c = list[k].centre - mean;
      a.row(static_cast<Eigen::Index>(k)) = 2 * c.transpose();
      b[static_cast<Eigen::Index>(k)] = c.squaredNorm() - list[k].radius * list[k].radius - power;
    }
    linear_algebra::SingularValues svd(a, Eigen::ComputeThinU | Eigen::ComputeThinV);
    svd.setThreshold(kFlat);
    if (svd.rank() < 2) continue;
    const Vector3d foot = mean + svd.solve(b);  // in the plane of the centres, if they lie in one
    std::vector<Vector3d> places = {foot};
    if (svd.rank() == 2) {
      const double offset2 = -power - (foot - mean).squaredNorm();
      const Vector3d offset = std::sqrt(std::max(0.0, offset2)) * svd.matrixV().col(2);
      // The upper one first.
      places = {foot + (offset.z() < 0 ? -1 : 1) * offset, foot - (offset.z() < 0 ? -1 : 1) * offset};
    }
    const auto score = [&, spheres = &list](const Vector3d& p) {
      double sum = 0;
      for (const Sphere& s : *spheres) sum += std::abs((p - s.centre).norm() - s.radius);
      return has_height(id) ? sum + std::abs(p.z() - height_.at(id)) : sum;
    };
    places = as_good_as_the_best(places, score, 0.02 * list.front().radius);
    if (places.size() > 1 && !accept_ambiguous) continue;
    const Vector3d p = places[places.size() > 1 ? choices_.choose(name_ + id, 2) : 0];
    set_plan(id, p.head<2>());
    set_height(id, p.z());
    return true;
  }
  return false;
}

bool Frame::place_height_by_slope_distances() {
  if (scale_open_) return false;
  for (const auto& [id, list] : collect_spheres()) {
    if (!has_plan(id)) continue;
    const Vector2d plan = plan_.at(id);
    // The steepest sight says most about the height.
    double height = 0, steepest = -1;
    double rise = 0;
    for (const Sphere& s : list) {
      const double rise2 = s.radius * s.radius - (plan - s.centre.head<2>()).squaredNorm();
      if (rise2 / (s.radius * s.radius) <= steepest) continue;
      steepest = rise2 / (s.radius * s.radius);
      height = s.centre.z();
      rise = std::sqrt(std::max(0.0, rise2));
    }
    const auto score = [&, spheres = &list](double h) {
      double sum = 0;
      for (const Sphere& s : *spheres)
        sum += std::abs(std::hypot((plan - s.centre.head<2>()).norm(), h - s.centre.z()) - s.radius);
      return sum;
    };
    std::vector<double> places = {height + rise, height - rise};
    places = as_good_as_the_best(places, score, 0.02 * list.front().radius);
    set_height(id, places[places.size() > 1 ? choices_.choose(name_ + id + " H", 2) : 0]);
    return true;
  }
  return false;
}

std::optional<double> Frame::slope_between(const std::string& a, const std::string& b) const {
  const auto is_line = [&](const std::string& from, const std::string& to) {
    return (from == a && to == b) || (from == b && to == a);
  };
  const auto length = [](double slope, double horizontal) { return std::isnan(slope) ? horizontal : slope; };
  for (const DistanceLine& d : figures_.distances)
    if (is_line(d.from, d.to)) return length(d.slope, d.horizontal);
  for (const Figure& figure : figures_.figures)
    for (const PolarSight& s : figure.sights)
      if (is_line(figure.station, s.to) && !std::isnan(length(s.slope, s.horizontal)))
        return length(s.slope, s.horizontal);
  return std::nullopt;
}

bool Frame::seed_distance(const std::string& a, const std::string& b, const std::string& third) {
  const auto ab = slope_between(a, b);
  if (!ab) return false;
  seeded_ = true;
  set_plan(a, Vector2d::Zero());
  set_plan(b, Vector2d(*ab, 0));
  if (third.empty()) return true;
  const auto ac = slope_between(a, third), bc = slope_between(b, third);
  if (!ac || !bc) return false;
  const double along = (*ac * *ac - *bc * *bc + *ab * *ab) / (2 * *ab);
  set_plan(third, Vector2d(along, std::sqrt(std::max(0.0, *ac * *ac - along * along))));
  for (const std::string& id : {a, b, third}) set_height(id, 0);
  return true;
}

}  // namespace plumbline::survey
