#include "control/points/control_files.hpp"

#include <cmath>
#include <set>
#include <stdexcept>

#include "control/points/gcp_list.hpp"
#include "control/points/openmvs_gcp.hpp"

namespace plumbline::control {
namespace {

void refuse_x_north(const ControlOptions& options, const std::string& file) {
  if (options.axes == Axes::x_north)
    throw std::runtime_error(file +
                             ": axes is x_north, but the file says itself which coordinate is east; leave axes out");
}

}  // namespace

ControlTable parse_control(const std::string& text, const std::string& file, const ControlOptions& options) {
  ControlTable table;
  std::set<std::string> seen;
  if (const auto lines = gcp_lines(text, file)) {
    refuse_x_north(options, file);
    for (const GcpLine& g : *lines)
      if (seen.insert(g.name).second)
        table.points.push_back({g.name, g.position, Eigen::Vector3d::Constant(std::nan("")), false});
    return table;
  }
  if (looks_like_openmvs_gcp(text)) {
    refuse_x_north(options, file);
    for (const GcpRow& row : parse_openmvs_gcp(text, file)) {
      if (!seen.insert(row.point).second) continue;
      table.points.push_back({row.point, row.position, row.sigma, false});
      table.has_sigmas = table.has_sigmas || row.sigma.allFinite();
    }
    return table;
  }
  return parse_control_table(text, file, options);
}

void require_whole(const ControlTable& table, const std::string& file, const std::string& reader) {
  for (const ControlPoint& p : table.points)
    if (!p.is_whole())
      throw std::runtime_error(file + ": point '" + p.name + "' has no " +
                               (std::isnan(p.position.z()) ? "height" : "place in the plan") + ", and " + reader +
                               " takes whole points only; take it out of the list, or give all of E, N and H");
}

}  // namespace plumbline::control
