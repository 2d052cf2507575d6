#include "planes_node.hpp"

#include <fmt/core.h>

#include <cmath>
#include <stdexcept>

#include "faces.hpp"
#include "panels_node.hpp"
#include "plumbline/stop.hpp"
#include "scan_unit.hpp"
#include "surface/dense/find_planes.hpp"

namespace plumbline::surface {
namespace {

/// The plane as a panel without thickness.
std::unique_ptr<DesignElementT> element_of(const FoundPlane& plane, const Eigen::Vector3d& out,
                                           const std::string& name) {
  const FacadePlane frame = facade_plane(plane.origin, out);
  auto element = std::make_unique<DesignElementT>();
  element->guid = element->name = name, element->class_ = "IfcPlate", element->is_panel = true;
  element->position = plane.origin;
  element->placement = {Eigen::Quaterniond(frame.axes), plane.origin};
  element->box_high = {0.5 * plane.width, 0.5 * plane.height, 0}, element->box_low = -element->box_high;
  element->facade = std::make_unique<FacadeFrameT>();
  element->facade->right = frame.axes.col(0), element->facade->up = frame.axes.col(1);
  element->facade->out = frame.axes.col(2), element->facade->confirmed = true, element->facade->source = "own_axes";
  return element;
}

std::string plane_line(const FoundPlane& plane, const Eigen::Vector3d& out, const std::string& name) {
  return fmt::format("{},{:.4f},{:.4f},{:.4f},{:.6f},{:.6f},{:.6f},{:.3f},{:.3f},{:.3f},{:.2f},{}\n", name,
                     plane.origin.x(), plane.origin.y(), plane.origin.z(), out.x(), out.y(), out.z(), plane.width,
                     plane.height, plane.area, 1e3 * plane.roughness, static_cast<unsigned long long>(plane.points));
}

}  // namespace

void FindPlanes::run(Context& context) {
  const std::vector<Eigen::Vector3d> stations = stations_of(*seen_from);
  if (stations.empty())
    throw std::runtime_error(
        "set 'seen_from' to x, y, z of the scanner's stations, one after the other: without them nobody knows which "
        "side of a plane is outside, and every sign hangs on it");
  PlaneOptions options;
  options.cell = *cell, options.roughness = *roughness, options.angle = *angle, options.least_area = *least_area;
  const auto limit = static_cast<std::uint64_t>(*memory * 1073741824.0);
  options.most_cells = limit / PlaneFinder::kBytesOfCell;
  PlaneFinder finder(options);
  const double metres = unit_of(cloud::look_at_cloud(file->path), *unit, context).metres;
  context.reserve_memory(limit);
  const cloud::CloudSummary read =
      cloud::read_cloud(file->path, [&](const std::vector<Eigen::Vector3d>& some, double done, int) {
        if (context.cancelled()) throw Stopped();
        context.progress(0.9 * done, "points");
        for (const Eigen::Vector3d& point : some) finder.add(metres * point);
      });
  DesignT result;
  result.file_name = read.format, result.length_unit = 1;
  result.facade_normal = result.site_origin = Eigen::Vector3d::Constant(std::nan(""));
  std::string csv = "plane,x_m,y_m,z_m,out_x,out_y,out_z,width_m,height_m,area_m2,roughness_mm,points\n";
  double area = 0;
  int either_side = 0;
  for (const FoundPlane& plane : finder.planes()) {
    const Lookers lookers = looked_at(plane.origin, plane.normal, stations);
    if (lookers.before == lookers.behind) {
      ++either_side;
      continue;
    }
    const Eigen::Vector3d out = lookers.before > lookers.behind ? plane.normal : Eigen::Vector3d(-plane.normal);
    const std::string name = fmt::format("S{:03}", result.elements.size() + 1);
    csv += plane_line(plane, out, name);
    area += plane.area;
    result.elements.push_back(element_of(plane, out, name));
  }
  if (either_side > 0)
    context.warn(std::to_string(either_side) +
                 " planes are left out: as many stations of 'seen_from' look at them from one side as from the other, "
                 "or none does at an angle of more than 15°");
  if (result.elements.empty())
    throw std::runtime_error("there is no plane of " + std::to_string(*least_area) + " m² in the " +
                             std::to_string(read.points) +
                             " points; are 'roughness' (rougher than noise and relief) "
                             "and 'cell' (several points in each) fit for the scan?");
  context.info(std::to_string(result.elements.size()) + " planes, " + std::to_string(std::lround(area)) +
               " m² of cells");
  context.metric("planes", static_cast<double>(result.elements.size()), "1");
  design.commit(result);
  table.commit(text_file("planes.csv", "text/csv", csv));
}

}  // namespace plumbline::surface
