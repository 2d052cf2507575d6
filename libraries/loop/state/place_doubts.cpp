#include "loop/state/place_doubts.hpp"

#include <fmt/core.h>

#include <functional>
#include <vector>

namespace plumbline::loop {

std::string place_doubt(const Eigen::Vector3d& reported, const Eigen::Vector3d& expected, double reach) {
  const double off = (reported - expected).norm();
  if (off <= reach) return {};
  const std::string words = fmt::format("lies {:.3f} m from where it should be", off);
  struct Reading {
    const char* name;
    std::function<Eigen::Vector3d(const Eigen::Vector3d&)> read;
  };
  static const std::vector<Reading> readings = {
      {"it is in feet", [](const Eigen::Vector3d& p) { return Eigen::Vector3d(0.3048 * p); }},
      {"it is in US survey feet", [](const Eigen::Vector3d& p) { return Eigen::Vector3d(1200.0 / 3937.0 * p); }},
      {"it is in millimetres", [](const Eigen::Vector3d& p) { return Eigen::Vector3d(1e-3 * p); }},
      {"it is in centimetres", [](const Eigen::Vector3d& p) { return Eigen::Vector3d(1e-2 * p); }},
      {"its first two axes are exchanged",
       [](const Eigen::Vector3d& p) { return Eigen::Vector3d(p.y(), p.x(), p.z()); }},
      {"its height stands second", [](const Eigen::Vector3d& p) { return Eigen::Vector3d(p.x(), p.z(), p.y()); }},
      {"its second axis has the other sign",
       [](const Eigen::Vector3d& p) { return Eigen::Vector3d(p.x(), -p.y(), p.z()); }},
      {"its first axis has the other sign",
       [](const Eigen::Vector3d& p) { return Eigen::Vector3d(-p.x(), p.y(), p.z()); }},
  };
  const std::string what_to_do = "; export metres in the survey's frame, that of control and job";
  for (const Reading& reading : readings)
    if ((reading.read(reported) - expected).norm() <= reach)
      return words + "; that would fit if " + reading.name + what_to_do;
  return words + "; it is in another frame, or of another item" + what_to_do + ", or measure the item";
}

}  // namespace plumbline::loop
