// Measurements of surveyed points that contradict the model of the photographs, before the survey is looked at.
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/text/words.hpp"
#include "photo/markers/control_targets.hpp"

namespace plumbline::markers {
namespace {

constexpr double nowhere = std::numeric_limits<double>::infinity();

/// [px] from where the model has the point in that photograph; infinite: behind it, or no point.
double distance(const cameras::ColmapModel& model, const std::optional<Eigen::Vector3d>& point, const Measured& ray) {
  if (!point) return nowhere;
  const cameras::ColmapImage& image = model.images.at(ray.image);
  const auto pixel = project(model.cameras.at(image.camera).camera, image.cam_from_world * *point);
  return pixel ? (*pixel - ray.pixel).norm() : nowhere;
}

double largest_distance(const cameras::ColmapModel& model, const std::vector<Measured>& rays) {
  const auto point = intersect(model, rays);
  double largest = 0;
  for (const Measured& ray : rays) largest = std::max(largest, distance(model, point, ray));
  return largest;
}

std::string pixels(double value) { return value < nowhere ? fmt::format("{:.0f} px", value) : "far"; }

/// ". In that photograph P4 was measured 1 px from there": two names at one place.
std::string same_place(const std::vector<Target>& targets, const Target& of, const Measured& ray, double limit) {
  for (const Target& other : targets) {
    if (&other == &of) continue;
    for (const Measured& m : other.rays)
      if (m.image == ray.image && (m.pixel - ray.pixel).norm() < limit)
        return ". " + other.name + " is measured " + pixels((m.pixel - ray.pixel).norm()) +
               " from there: one of the two names is wrong";
  }
  return ". Is it another point's?";
}

std::string names_of(const cameras::ColmapModel& model, const std::vector<Measured>& rays) {
  std::vector<std::string> names;
  for (const Measured& ray : rays) names.push_back(model.images.at(ray.image).name);
  return text::join(names, 5);
}

}  // namespace

void set_wrong_measurements_aside(const cameras::ColmapModel& model, std::vector<Target>& targets,
                                  ControlResult& result) {
  constexpr double of_sigma = 20, least = 25;  // [px]: a model that is bent fits its own photographs better than that
  for (Target& target : targets)
    while (target.rays.size() >= 2) {
      double limit = least;
      for (const Measured& ray : target.rays) limit = std::max(limit, of_sigma * ray.sigma);
      const double off = largest_distance(model, target.rays);
      if (off <= limit || !intersect(model, target.rays)) break;  // nearly parallel rays say nothing
      std::vector<size_t> suspects;
      for (size_t k = 0; k < target.rays.size() && target.rays.size() > 2; ++k) {
        std::vector<Measured> others = target.rays;
        others.erase(others.begin() + static_cast<std::ptrdiff_t>(k));
        if (largest_distance(model, others) <= limit) suspects.push_back(k);
      }
      if (suspects.size() != 1) {
        result.warnings.push_back("the measurements of point " + target.name + " in " + names_of(model, target.rays) +
                                  " contradict each other by " + pixels(off) +
                                  ", and nothing says which of them is wrong: the point is left out");
        target.rays.clear();
        break;
      }
      const Measured wrong = target.rays[suspects[0]];
      target.rays.erase(target.rays.begin() + static_cast<std::ptrdiff_t>(suspects[0]));
      result.warnings.push_back("point " + target.name + " is measured in " + model.images.at(wrong.image).name + " " +
                                pixels(distance(model, intersect(model, target.rays), wrong)) +
                                " from where its other photographs have it: that measurement is left out" +
                                same_place(targets, target, wrong, limit));
    }
}

}  // namespace plumbline::markers
